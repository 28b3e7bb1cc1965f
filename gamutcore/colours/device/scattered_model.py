"""A device model from scattered samples: cubic radial basis functions with a linear part.

The model is that of SciPy's ``RBFInterpolator(kernel="cubic", degree=1, smoothing=1e-3)`` on device
values from 0 to 1. The system is solved here, because it is positive definite once the linear part
is projected out. One Cholesky factorisation gives the coefficients and, in closed form, the
leave-one-out error of every sample. Evaluation is a kernel over plain arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.kernels import kernel

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = [
    "MAX_MODEL_SAMPLES",
    "SMOOTHING",
    "DegenerateSamplesError",
    "ScatteredModel",
    "add_cubic_sums",
    "fill_cubed_distances",
    "scattered_model",
]

SMOOTHING = 1e-3
"""Added to the diagonal for the noise of measurements. Held-out errors of presses and displays
were 2 to 4 times lower than with polynomials or linear interpolation
(``docs/decisions/device-model.md``)."""

MAX_MODEL_SAMPLES = 5000
"""Largest number N of samples of a fit: the matrix takes N² · 8 bytes and N³ operations."""


_BLOCK = 64
"""Number of points that are evaluated together: all of them stay in the first-level cache."""


class DegenerateSamplesError(ValueError):
    """The device values do not spread in all directions, so no model can be fitted."""


@kernel
def fill_cubed_distances(points: FloatArray, centres: FloatArray, out: FloatArray) -> None:
    """Write |point - centre|³ to `out` (m, n), for points (m, k) and centres (k, n)."""
    dimensions, count = centres.shape
    for i in range(points.shape[0]):
        row = out[i]
        for j in range(count):
            step = points[i, 0] - centres[0, j]
            row[j] = step * step
        for d in range(1, dimensions):
            for j in range(count):
                step = points[i, d] - centres[d, j]
                row[j] += step * step
        for j in range(count):
            row[j] *= np.sqrt(row[j])


@kernel
def add_cubic_sums(
    points: FloatArray, centres: FloatArray, weights: FloatArray, out: FloatArray
) -> None:
    """Add the sums Σ weights·|point - centre|³ to `out` (3, m).

    Points of evaluation are (k, m), centres of the basis functions (n, k), and weights (n, 3).
    """
    dimensions, count = points.shape
    squares = np.empty(_BLOCK)
    for start in range(0, count, _BLOCK):
        # The inner loops run over points, not centres: they become vector instructions without
        # changing the order of any sum.
        stop = min(start + _BLOCK, count)
        size = stop - start
        first, second, third = out[0, start:stop], out[1, start:stop], out[2, start:stop]
        for j in range(centres.shape[0]):
            x = points[0, start:stop]
            for i in range(size):
                step = x[i] - centres[j, 0]
                squares[i] = step * step
            for d in range(1, dimensions):
                x = points[d, start:stop]
                for i in range(size):
                    step = x[i] - centres[j, d]
                    squares[i] += step * step
            for i in range(size):
                squares[i] *= np.sqrt(squares[i])
            for i in range(size):
                first[i] += weights[j, 0] * squares[i]
            for i in range(size):
                second[i] += weights[j, 1] * squares[i]
            for i in range(size):
                third[i] += weights[j, 2] * squares[i]


@dataclass(frozen=True, eq=False)
class ScatteredModel:
    """Device value to colour, fitted to scattered samples.

    Attributes
    ----------
    centres, weights : (n, k) and (n, 3) float
        Device values of the samples; weights of the cubic basis functions.
    linear : (k + 1, 3) float
        The constant and the linear part.
    leave_out_errors : (n,) float
        Distance of each sample from its prediction by the other samples (ΔE*ab in CIELAB).
    """

    centres: FloatArray
    weights: FloatArray
    linear: FloatArray
    leave_out_errors: FloatArray

    def colours(self, device: FloatArray) -> FloatArray:
        """Return the colours (m, 3) of device values (m, k), 0 to 1."""
        sums = np.zeros((3, len(device)))
        add_cubic_sums(np.ascontiguousarray(device.T), self.centres, self.weights, sums)
        colours: FloatArray = self.linear[0] + device @ self.linear[1:] + sums.T
        return colours


def scattered_model(device: FloatArray, colours: FloatArray) -> ScatteredModel:
    """Return the model that fits scattered samples (n, k), 0 to 1, with its leave-one-out errors.

    P has the columns (1, device) of the linear part, and Q is its null space (from a QR
    decomposition). Qᵀ(Φ + λ)Q = LLᵀ is positive definite for the cubic kernel (Wendland, Scattered
    Data Approximation, 2005, section 8.5). The weights are M·colours with M = Q(LLᵀ)⁻¹Qᵀ. The
    leave-one-out error of sample i is weights_i / M_ii (Rippa, Advances in Computational
    Mathematics 11, 1999, 193-210, equation 3).

    At most k + 1 samples, or device values in a plane, raise `DegenerateSamplesError`.
    """
    # scipy.linalg takes 0.2 s and 15 MB to import, and only fits need it. Import it here first:
    # threadpool_limits affects only the BLAS libraries that are loaded already.
    from scipy import linalg  # noqa: F401, PLC0415
    from threadpoolctl import threadpool_limits  # noqa: PLC0415

    # One BLAS thread: the division of a sum among threads changes its last bits, and a rerun must
    # give the same gamut. Concurrent builds also share the cores better.
    with threadpool_limits(limits=1, user_api="blas"):
        return _solution(device, colours)


def _solution(device: FloatArray, colours: FloatArray) -> ScatteredModel:
    from scipy import linalg  # noqa: PLC0415  # see scattered_model

    count, channels = device.shape
    order = channels + 1
    if count <= order:
        raise DegenerateSamplesError(f"{count} samples for {channels} channels")
    basis = np.column_stack([np.ones(count), device])
    (packed, factors), triangle = linalg.qr(basis, mode="raw")
    reflectors: FloatArray = np.array(packed, dtype=np.float64, order="F")
    scales: FloatArray = np.array(factors, dtype=np.float64)
    diagonal = np.abs(np.diag(triangle))
    if diagonal.min() < 1e-6 * diagonal.max():
        raise DegenerateSamplesError("the device values lie in a plane")

    # All steps work in place, in one n by n matrix. Householder reflections from both sides take
    # two passes over it; an explicit Q would take two matrix products.
    matrix = np.empty((count, count))
    fill_cubed_distances(np.ascontiguousarray(device), np.ascontiguousarray(device.T), matrix)
    matrix.flat[:: count + 1] += SMOOTHING
    matrix = _reflection(matrix.T, reflectors, scales, "L", transposed=True)
    matrix = _reflection(matrix, reflectors, scales, "R", transposed=False)
    head = matrix[:order].copy()
    # rows of the linear part become rows of an identity, which the factor and its inverse keep
    matrix[:order] = matrix[:, :order] = 0.0
    matrix.flat[: order * count : count + 1] = 1.0
    try:
        matrix = linalg.cholesky(matrix, lower=True, overwrite_a=True, check_finite=False)
    except linalg.LinAlgError:
        raise DegenerateSamplesError("the samples' system is singular") from None
    matrix, _ = linalg.lapack.dtrtri(matrix, lower=1, overwrite_c=1)
    matrix[:order, :order] = 0.0
    # spread = L⁻¹ Qᵀ, and M = spreadᵀ spread
    spread = _reflection(matrix, reflectors, scales, "R", transposed=True)
    weights = spread.T @ (spread @ colours)
    errors = weights / np.einsum("ij,ij->j", spread, spread)[:, np.newaxis]
    # The first rows of Qᵀ(Φ + λ)·weights + Qᵀ·basis·linear = Qᵀ·colours; Qᵀ·basis is a triangle.
    rotated = _reflection(
        np.column_stack([weights, colours]), reflectors, scales, "L", transposed=True
    )
    remainder = rotated[:order, 3:] - head @ rotated[:, :3]
    linear = linalg.solve_triangular(triangle[:order], remainder, check_finite=False)
    return ScatteredModel(
        centres=np.ascontiguousarray(device),
        weights=weights,
        linear=linear,
        leave_out_errors=np.linalg.norm(errors, axis=1),
    )


def _reflection(
    matrix: FloatArray, reflectors: FloatArray, scales: FloatArray, side: str, *, transposed: bool
) -> FloatArray:
    from scipy.linalg import lapack  # noqa: PLC0415  # see scattered_model

    matrix = np.asfortranarray(matrix)
    product: FloatArray
    trans = "T" if transposed else "N"
    # without overwrite_c, even the query of the workspace size would copy the matrix
    _, work, _ = lapack.dormqr(side, trans, reflectors, scales, matrix, lwork=-1, overwrite_c=1)
    product, _, _ = lapack.dormqr(
        side, trans, reflectors, scales, matrix, lwork=int(work[0]), overwrite_c=1
    )
    return product
