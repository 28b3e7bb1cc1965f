"""A device model from scattered samples: cubic radial basis functions with a linear part.

The interpolant is scipy's ``RBFInterpolator(kernel="cubic", smoothing=1e-3)`` on device values
from 0 to 1. It is solved here, because its system, once the linear part is projected out, is
positive definite: one Cholesky factorisation gives the coefficients and, in closed form, the error
that every sample would have if it were left out. Evaluation is a kernel over plain arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import linalg

from gamutcore.kernels import kernel

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = [
    "MAX_MODEL_SAMPLES",
    "SMOOTHING",
    "DegenerateSamplesError",
    "ScatteredModel",
    "cubed_distances",
    "scattered_model",
]

SMOOTHING = 1e-3
"""Added to the diagonal: takes up measurement noise. Held-out errors of presses and displays were
2-4 times lower than with polynomials or linear interpolation (docs/decisions/device-model.md)."""

MAX_MODEL_SAMPLES = 5000
"""Samples that a model is fitted to at most: its matrix takes N² · 8 bytes and N³ operations."""


_BLOCK = 32
"""Points evaluated at once: their distances from 1,600 samples fit a second level cache."""


class DegenerateSamplesError(ValueError):
    """The device values do not spread in all directions, so that no model can be fitted."""


@kernel
def cubed_distances(points: FloatArray, centres: FloatArray, out: FloatArray) -> None:
    """Cubed distances of points from centres.

    Parameters
    ----------
    points : (m, k) float
        Points.
    centres : (k, n) float
        Centres, one row per dimension.
    out : (m, n) float
        Receives |point - centre|³.
    """
    dimensions, count = centres.shape
    for i in range(points.shape[0]):
        # One pass per dimension over a row that stays in the nearest cache: loops this simple
        # become vector instructions, unlike a loop over dimensions within one over centres.
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


@dataclass(frozen=True, eq=False)
class ScatteredModel:
    """Device value to colour, fitted to scattered samples.

    Parameters
    ----------
    centres : (k, n) float
        Device values of the samples, one row per channel.
    weights : (n, 3) float
        Weights of the cubic basis functions.
    linear : (k + 1, 3) float
        The constant and the linear part.
    leave_out_errors : (n,) float
        Distance (ΔE*ab where colours are CIELAB) of each sample from what the other samples
        predict for it.
    """

    centres: FloatArray
    weights: FloatArray
    linear: FloatArray
    leave_out_errors: FloatArray

    def colours(self, device: FloatArray) -> FloatArray:
        """Return the colours of device values.

        Parameters
        ----------
        device : (m, k) float
            Device values, 0 to 1.

        Returns
        -------
        (m, 3) float
            In the space of the samples that the model was fitted to.
        """
        points = np.ascontiguousarray(device, dtype=np.float64)
        out: FloatArray = self.linear[0] + points @ self.linear[1:]
        cubes = np.empty((_BLOCK, self.centres.shape[1]))
        for start in range(0, len(points), _BLOCK):
            block = points[start : start + _BLOCK]
            cubed_distances(block, self.centres, cubes)
            out[start : start + _BLOCK] += cubes[: len(block)] @ self.weights
        return out


def scattered_model(device: FloatArray, colours: FloatArray) -> ScatteredModel:
    """Return the model that fits scattered samples, with its leave-one-out errors.

    Parameters
    ----------
    device : (n, k) float
        Distinct device values, 0 to 1.
    colours : (n, 3) float
        Their colours.

    Returns
    -------
    ScatteredModel

    Raises
    ------
    DegenerateSamplesError
        There are no more than k + 1 samples, or their device values lie in a plane.

    Notes
    -----
    With P the linear part's columns (1, device) and Q its null space (from a QR decomposition),
    Qᵀ(Φ + λ)Q = LLᵀ is positive definite for the cubic kernel (Wendland, Scattered Data
    Approximation, 2005, section 8.5). The weights are M·colours with M = Q(LLᵀ)⁻¹Qᵀ, and sample i,
    left out, is missed by weights_i / M_ii (Rippa, Advances in Computational Mathematics 11,
    1999, 193-210, equation 3).
    """
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

    # Everything of size n by n is done in place, with two such matrices at most at any time.
    # Householder reflections from both sides take two passes over the matrix, where products with
    # an explicit Q would take two multiplications of n by n matrices.
    matrix = np.empty((count, count))
    cubed_distances(np.ascontiguousarray(device), np.ascontiguousarray(device.T), matrix)
    matrix.flat[:: count + 1] += SMOOTHING
    matrix = _reflected(matrix.T, reflectors, scales, "L", transposed=True)
    matrix = _reflected(matrix, reflectors, scales, "R", transposed=False)
    head = matrix[:order].copy()
    matrix = np.asfortranarray(matrix[order:, order:])
    try:
        matrix = linalg.cholesky(matrix, lower=True, overwrite_a=True, check_finite=False)
    except linalg.LinAlgError:
        raise DegenerateSamplesError("the samples' system is singular") from None
    matrix, _ = linalg.lapack.dtrtri(matrix, lower=1, overwrite_c=1)
    spread = np.zeros((count, count), order="F")
    spread[order:, order:] = matrix
    del matrix
    # L⁻¹ Qᵀ, of which M is the square.
    spread = _reflected(spread, reflectors, scales, "R", transposed=True)
    weights = spread.T @ (spread @ colours)
    errors = weights / np.einsum("ij,ij->j", spread, spread)[:, np.newaxis]
    # The first rows of Qᵀ(Φ + λ)·weights + Qᵀ·basis·linear = Qᵀ·colours; of Qᵀ·basis only the
    # triangle is left there.
    turned = _reflected(
        np.column_stack([weights, colours]), reflectors, scales, "L", transposed=True
    )
    remainder = turned[:order, 3:] - head @ turned[:, :3]
    linear = linalg.solve_triangular(triangle[:order], remainder, check_finite=False)
    return ScatteredModel(
        centres=np.ascontiguousarray(device.T),
        weights=weights,
        linear=linear,
        leave_out_errors=np.linalg.norm(errors, axis=1),
    )


def _reflected(
    matrix: FloatArray, reflectors: FloatArray, scales: FloatArray, side: str, *, transposed: bool
) -> FloatArray:
    matrix = np.asfortranarray(matrix)
    product: FloatArray
    trans = "T" if transposed else "N"
    _, work, _ = linalg.lapack.dormqr(side, trans, reflectors, scales, matrix, lwork=-1)
    product, _, _ = linalg.lapack.dormqr(
        side, trans, reflectors, scales, matrix, lwork=int(work[0]), overwrite_c=1
    )
    return product
