"""The device model of measured samples: its kind, its estimated error, and what it cannot know.

Complete grids are interpolated linearly between their nodes, and scattered samples are fitted. A
fit can be more accurate for coarse grids of smooth devices. The provenance then says so, and the
option ``device_model`` chooses. Measurements: ``docs/decisions/device-model.md``.

A device model also answers far from its samples, and a profile may contain any number. Unusual
gamuts are never refused, but warnings say what is unusual: device values far from all samples,
colours outside the optimal colour solid, and lightness outside 0 to 100.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from gamutcore.characterisation.icc.transforms import checked_positions, multilinear
from gamutcore.characterisation.samples import JSON
from gamutcore.colours.colorimetry import ICC_D50, lab_to_xyz
from gamutcore.colours.models import Arrays, DeviceFunction, check_shapes, device_function
from gamutcore.errors import FlatPointsError, OptionError, UnsupportedProfileError
from gamutcore.kernels import kernel
from gamutcore.number_text import number_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation import Samples
    from gamutcore.colours.ink_limits import LimitedCube

DEVICE_MODELS = ("interpolation", "fit")
"""Kinds of models: multilinear interpolation of complete grids, or a fit to the samples."""

_COMPARED = 1000
"""Largest grid whose fit is estimated as well; the fit of so many nodes takes 0.1 s."""

_STEPS_DOUBLED = 4.0
"""Ratio of the errors of linear interpolation when the step is doubled, for colours of constant
curvature. The estimate of a grid's error is too large by at most this factor."""

_NOTICEABLE = 1.0
"""Mean ΔE*ab of a grid's estimate below which the choice of the model does not matter. The errors
themselves are a half to a quarter of the estimate."""


_THIN = 1e-3
"""Thickness of device values as a share of their extent below which they lie in a plane: rounding
to 0.1 %."""

_SINGULAR = 1e-6
"""Square of that share: what is left of a sample's freedom if the others lie in a plane."""


def check_dimensions(samples: Samples) -> None:
    """Refuse device values on a line or plane of the device space: their colours are a sheet."""
    if samples.device is None or len(samples.channels) < 3:
        return
    distinct = np.unique(samples.device, axis=0)
    spread = np.linalg.eigvalsh(np.atleast_2d(np.cov(distinct.T, bias=True)))
    dimensions = int((spread > _THIN**2 * spread[-1]).sum()) if spread[-1] > _APART**2 else 0
    if dimensions >= 3:
        return
    shape = ("are all equal", "lie on a line", "lie in a plane")[dimensions]
    varied = np.ptp(distinct, axis=0) > _APART
    names = ", ".join(
        channel for channel, varies in zip(samples.channels, varied, strict=True) if varies
    )
    which = f" Channels that vary: {names}." if names else ""
    raise FlatPointsError(
        f"The device values of the {len(samples)} patches {shape}, so their colours enclose no "
        f"volume.{which}",
        where={"field": "samples", "dimensions": dimensions},
        remedy="Give patches that vary in three channels or more, independently of each other.",
    )


@dataclass(frozen=True, eq=False)
class SampleModel:
    """Device value to colour, from measured samples.

    `device` (n, k) and `lab` (n, 3) are the samples used. `function` is None if no model can be
    fitted, and `degenerate` tells why. `mean_error`
    is the mean ΔE*ab of left-out samples, if some can be left out. `nodes` (k, l) are levels of
    each channel between which the model is smooth, if all channels have equally many.
    """

    device: FloatArray
    lab: FloatArray
    function: Fit | Interpolation | None
    provenance: dict[str, JSON]
    mean_error: float | None = None
    nodes: FloatArray | None = None
    degenerate: str = ""
    warnings: tuple[str, ...] = ()


def device_model(device: FloatArray, lab: FloatArray, kind: str | None = None) -> SampleModel:
    """Return the device model of samples with distinct device values (n, k), 0 to 1.

    Without a `kind` of `DEVICE_MODELS`, complete grids are interpolated and other samples are
    fitted. A fit uses at most `MAX_MODEL_SAMPLES` samples.
    """
    grid = None if kind == "fit" else grid_model(device, lab)
    if grid is not None:
        return _interpolation(grid, device, lab)
    if kind == "interpolation":
        raise _incomplete_grid(device)
    device, lab = _sample_subset(device, lab)
    fitted = _fit(device, lab)
    if isinstance(fitted, DegenerateSamplesError):
        none: dict[str, JSON] = {"name": "none: the samples' own colours"}
        why = str(fitted) if len(device) > 1 else "there is only one distinct device value"
        return SampleModel(device, lab, None, none, degenerate=why)
    provenance: dict[str, JSON] = {
        "name": "radial basis functions",
        "kernel": "cubic",
        "smoothing": SMOOTHING,
        "samples": len(device),
        "leave_out_error": None,
    }
    mean: float | None = None
    warnings: tuple[str, ...] = ()
    errors = fitted.leave_out_errors
    if len(errors):
        mean, high = _figures(errors)
        provenance["leave_out_error"] = {"unit": "ΔE*ab", "mean": mean, "percentile_95": high}
    if len(errors) < len(device):
        single = len(device) - len(errors)
        warning = (
            f"The device model rests on {single} single patch{'es' if single > 1 else ''}: without "
            "one, the others lie in a plane of the device space. The error there is unknown."
        )
        warnings = (warning,)
    varied = np.ptp(device, axis=0) > _APART
    return SampleModel(device, lab, Fit(fitted, varied), provenance, mean, warnings=warnings)


def _incomplete_grid(device: FloatArray) -> OptionError:
    levels = [len(np.unique(values)) for values in device.T]
    if len(device) > 1:
        why = (
            f"the {len(device)} distinct device values are not a complete grid; a grid of "
            f"{' · '.join(map(str, levels))} levels has {number_text(math.prod(levels))}"
        )
        remedy = "Give 'fit', or send exactly all combinations of some levels of each channel."
    else:
        why = "there is only one distinct device value"
        remedy = "Send all combinations of two or more levels of each channel."
    return OptionError.not_applicable("device_model", "interpolation", why, remedy)


def _fit(device: FloatArray, lab: FloatArray) -> ScatteredModel | DegenerateSamplesError:
    """Fit over the channels that vary, or the reason why there is none."""
    try:
        return scattered_model(device[:, np.ptp(device, axis=0) > _APART], lab)
    except DegenerateSamplesError as error:
        return error


def _interpolation(grid: GridModel, device: FloatArray, lab: FloatArray) -> SampleModel:
    errors = grid.leave_out_errors()
    provenance: dict[str, JSON] = {
        "name": "n-linear interpolation of a complete grid",
        "levels": list[JSON](grid.shape),
        "samples": len(device),
        "leave_out_error": None,
    }
    warnings: list[str] = []
    mean = None
    if len(errors):
        mean, high = _figures(errors)
        provenance["leave_out_error"] = {
            "unit": "ΔE*ab",
            "mean": mean,
            "percentile_95": high,
            "of": "every second level, interpolated between the others; the whole grid's errors "
            "are about two to four times smaller",
        }
        fitted = _fit(device, lab) if len(device) <= _COMPARED else None
        if isinstance(fitted, ScatteredModel) and len(fitted.leave_out_errors):
            other, other_high = _figures(fitted.leave_out_errors)
            provenance["fit"] = {
                "leave_out_error": {"unit": "ΔE*ab", "mean": other, "percentile_95": other_high}
            }
            if mean > _NOTICEABLE and other * _STEPS_DOUBLED < mean:
                warnings.append(
                    f"The grid of {len(device)} patches is coarse for this device: a fit is likely "
                    f"to be more accurate (patches left out are missed by {other:.2f} ΔE*ab on "
                    f"average, by interpolation over every second level by {mean:.2f}). The option "
                    "device_model 'fit' asks for it."
                )
    else:
        warnings.append(
            "The error of the device model is unknown: a grid of two levels per channel has no "
            "level that could be left out."
        )
    nodes = np.stack(grid.levels) if len(set(grid.shape)) == 1 else None
    function = Interpolation(grid)
    return SampleModel(device, lab, function, provenance, mean, nodes, warnings=tuple(warnings))


def _figures(errors: FloatArray) -> tuple[float, float]:
    """Mean and 95th percentile of errors."""
    return round(float(errors.mean()), 4), round(float(np.percentile(errors, 95)), 4)


def _sample_subset(device: FloatArray, lab: FloatArray) -> tuple[FloatArray, FloatArray]:
    """At most `MAX_MODEL_SAMPLES` samples: the cube's corners and a fixed random choice."""
    if len(device) <= MAX_MODEL_SAMPLES:
        return device, lab
    corners = ((device == 0) | (device == 1)).all(axis=1)
    # a fixed seed: the same file must give the same gamut
    rank = np.random.default_rng(0).permutation(len(device)) + len(device) * ~corners
    chosen = np.sort(np.argsort(rank, kind="stable")[:MAX_MODEL_SAMPLES])
    return device[chosen], lab[chosen]


_APART = 1e-6
"""Distance of two levels of a channel as a fraction of its range; closer values are one level."""


@dataclass(frozen=True, eq=False)
class GridModel:
    """Device value to colour, interpolated as in the lookup tables of profiles.

    `levels` are the ascending levels of each channel, and `table` (product of levels, 3) has the
    colours at the nodes, the last channel fastest. Single precision is 10⁻⁵ ΔE.
    """

    levels: tuple[FloatArray, ...]
    table: npt.NDArray[np.float32] = field(repr=False)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of levels of each channel."""
        return tuple(len(levels) for levels in self.levels)

    def colours(self, device: FloatArray) -> FloatArray:
        """Return the colours (m, 3) of device values (m, k), clipped to the outermost levels."""
        positions = np.empty(device.shape)
        for channel, levels in enumerate(self.levels):
            fractions = np.linspace(0.0, 1.0, len(levels))
            positions[:, channel] = np.interp(device[:, channel], levels, fractions)
        try:
            positions, steps, strides = checked_positions(positions, self.shape)
        except UnsupportedProfileError as error:
            raise OptionError(error.message, where=error.where, remedy=error.remedy) from None
        colours = np.empty((len(device), 3))
        multilinear(positions, steps, strides, self.table, colours)
        return colours

    def leave_out_errors(self) -> FloatArray:
        """Return the errors (m,) at left-out nodes: every second level of each channel at once.

        The errors of the whole grid are two to four times smaller: halving the steps quarters the
        errors of smooth colours. The last levels stay, so two levels per channel give no errors.
        """
        shape = self.shape
        chosen = [np.unique([*range(0, count, 2), count - 1]) for count in shape]
        stays = np.zeros(shape, dtype=bool)
        stays[np.ix_(*chosen)] = True
        left_out = ~stays.reshape(-1)
        coarse = GridModel(
            tuple(levels[some] for levels, some in zip(self.levels, chosen, strict=True)),
            np.ascontiguousarray(self.table[~left_out]),
        )
        indices = np.unravel_index(np.flatnonzero(left_out), shape)
        device = np.column_stack(
            [levels[index] for levels, index in zip(self.levels, indices, strict=True)]
        )
        errors: FloatArray = np.linalg.norm(coarse.colours(device) - self.table[left_out], axis=1)
        return errors


def grid_model(device: FloatArray, colours: FloatArray) -> GridModel | None:
    """Return the model of distinct samples that form a complete grid; None for other samples."""
    count = len(device)
    if count < 2:
        return None
    levels, indices = [], []
    nodes = 1
    for values in device.T:
        order = np.argsort(values, kind="stable")
        ranked = values[order]
        first = np.concatenate([[True], np.diff(ranked) > _APART])
        levels.append(ranked[first])
        nodes *= len(levels[-1])
        # scattered samples have far more combinations of levels than samples
        if nodes > count:
            return None
        index = np.empty(count, dtype=np.int64)
        index[order] = np.cumsum(first) - 1
        indices.append(index)
    if nodes < count:
        return None
    row = np.ravel_multi_index(tuple(indices), tuple(len(some) for some in levels))
    if len(np.unique(row)) < count:
        return None
    table = np.empty((count, 3), dtype=np.float32)
    table[row] = colours
    return GridModel(tuple(levels), table)


SMOOTHING = 1e-3
"""Added to the diagonal for the noise of measurements. Held-out errors of presses and displays
were 2 to 4 times lower than with polynomials or linear interpolation
(``docs/decisions/device-model.md``)."""

MAX_MODEL_SAMPLES = 5000
"""Largest number N of samples of a fit: the matrix takes N² · 8 bytes and N³ operations."""


_ROWS = 512
"""Number of points whose distances from all centres are in memory together."""

_BLOCK = 64
"""Number of points that are evaluated together: all of them stay in the first-level cache."""


class DegenerateSamplesError(ValueError):
    """The device values do not spread in all directions, so no model can be fitted."""


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
    """Cubic radial basis functions with a linear part, fitted to scattered samples.

    `centres` (n, k) are the device values of the samples, `weights` (n, 3) those of the functions,
    and `linear` (k + 1, 3) the constant and the linear part. `leave_out_errors` are the distances
    of the samples from their predictions by the others, without samples that the others cannot
    predict because they lie in a plane. A model of other columns than colours has `weights` (n, c).
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

    def columns(self, device: FloatArray) -> FloatArray:
        """Return the values (m, c) of a model of any number of columns, by matrix products."""
        from scipy.spatial.distance import cdist  # noqa: PLC0415  # see scattered_model
        from threadpoolctl import threadpool_limits  # noqa: PLC0415

        values: FloatArray = self.linear[0] + device @ self.linear[1:]
        with threadpool_limits(limits=1, user_api="blas"):
            for start in range(0, len(device), _ROWS):
                rows = slice(start, start + _ROWS)
                values[rows] += cdist(device[rows], self.centres) ** 3 @ self.weights
        return values


def scattered_model(device: FloatArray, colours: FloatArray) -> ScatteredModel:
    """Return the model that fits scattered samples (n, k), 0 to 1, with its leave-one-out errors.

    The model is that of SciPy's ``RBFInterpolator(kernel="cubic", degree=1)``. P has the columns
    (1, device) of the linear part, and Q is its null space. Qᵀ(Φ + λ)Q = LLᵀ is positive definite
    (Wendland, Scattered Data Approximation, 2005, 8.5), so one Cholesky factorisation gives the
    weights M·colours with M = Q(LLᵀ)⁻¹Qᵀ and the errors weights_i / M_ii (Rippa, Advances in
    Computational Mathematics 11, 1999, equation 3).
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
    from scipy.spatial.distance import cdist  # noqa: PLC0415

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
    for start in range(0, count, _BLOCK):
        rows = matrix[start : start + _BLOCK]
        cdist(device[start : start + _BLOCK], device, "sqeuclidean", out=rows)
        rows *= np.sqrt(rows)
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
    with np.errstate(divide="ignore", invalid="ignore"):  # some have no error, see below
        errors = weights / np.einsum("ij,ij->j", spread, spread)[:, np.newaxis]
    # The first rows of Qᵀ(Φ + λ)·weights + Qᵀ·basis·linear = Qᵀ·colours; Qᵀ·basis is a triangle.
    rotated = _reflection(
        np.column_stack([weights, colours]), reflectors, scales, "L", transposed=True
    )
    columns = weights.shape[1]
    remainder = rotated[:order, columns:] - head @ rotated[:, :columns]
    linear = linalg.solve_triangular(triangle[:order], remainder, check_finite=False)
    # a sample that alone decides a coefficient of the linear part has no prediction by the others
    row_factors = linalg.solve_triangular(triangle[:order], basis.T, trans="T", check_finite=False)
    predicted = 1.0 - np.einsum("ij,ij->j", row_factors, row_factors) > _SINGULAR
    return ScatteredModel(
        centres=np.ascontiguousarray(device),
        weights=weights,
        linear=linear,
        leave_out_errors=np.linalg.norm(errors[predicted], axis=1),
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


@device_function
@dataclass(frozen=True, eq=False)
class Fit(DeviceFunction):
    """Radial basis functions of the channels that vary, `varied` (n,)."""

    kind: ClassVar[str] = "fit"
    model: ScatteredModel
    varied: np.ndarray

    def fitted(self, device: FloatArray) -> FloatArray:
        """Return the values of the functions, which may be below L* 0."""
        return self.model.colours(device[:, self.varied])

    def lab(self, device: FloatArray) -> FloatArray:
        """Return colours; those below L* 0 are raised to it."""
        return _raised(self.fitted(device))

    def parts(self) -> tuple[Arrays, dict[str, Any]]:
        """Return the centres, the weights and the linear part."""
        model = self.model
        arrays = {"centres": model.centres, "weights": model.weights, "linear": model.linear}
        return arrays, {"varied": self.varied.tolist()}

    @classmethod
    def of(cls, arrays: Arrays, facts: Mapping[str, Any]) -> Self:
        """Return the function of its parts."""
        varied = np.array(facts["varied"], bool)
        parts = (arrays["centres"], arrays["weights"], arrays["linear"])
        count, channels = len(parts[0]), int(varied.sum())
        # kernels do not check indices
        check_shapes(parts, ((count, channels), (count, 3), (channels + 1, 3)), np.float64)
        return cls(ScatteredModel(*parts, np.empty(0)), varied)


@device_function
@dataclass(frozen=True, eq=False)
class Interpolation(DeviceFunction):
    """Multilinear interpolation of a complete grid of samples."""

    kind: ClassVar[str] = "grid"
    model: GridModel

    def fitted(self, device: FloatArray) -> FloatArray:
        """Return the interpolated values, which may be below L* 0."""
        return self.model.colours(device)

    def lab(self, device: FloatArray) -> FloatArray:
        """Return colours; those below L* 0 are raised to it."""
        return _raised(self.fitted(device))

    def parts(self) -> tuple[Arrays, dict[str, Any]]:
        """Return the levels of all channels, one after the other, and the table."""
        model = self.model
        arrays = {"levels": np.concatenate(model.levels), "table": model.table}
        return arrays, {"shape": list(model.shape)}

    @classmethod
    def of(cls, arrays: Arrays, facts: Mapping[str, Any]) -> Self:
        """Return the function of its parts."""
        shape = [int(count) for count in facts["shape"]]
        check_shapes((arrays["levels"],), ((sum(shape),),), np.float64)
        check_shapes((arrays["table"],), ((math.prod(shape), 3),), np.float32)
        ends = np.cumsum(shape)[:-1]
        levels = tuple(np.ascontiguousarray(part) for part in np.split(arrays["levels"], ends))
        return cls(GridModel(levels, arrays["table"]))


def _raised(lab: FloatArray) -> FloatArray:
    lab[:, 0] = np.maximum(lab[:, 0], 0.0)
    return lab


_FAR = 0.5
"""Distance of a corner from the nearest sample at which the corner is far: half of an edge of the
device cube. Charts of displays and presses measure the corners themselves."""

_EXCESS = 1.1
"""Ratio of volumes above which a gamut is called larger than its samples. Presses and displays that
were measured at their corners have 0.99 to 1.04."""

_HULL_POINTS = 10_000
"""Largest number of points whose convex hull is computed, which takes 0.02 s."""

_TESTED = 2000
"""Largest number of colours that are compared with the optimal colour solid, which takes 0.01 s."""

_OUTSIDE = 0.005
"""Distance from the solid in X, Y, Z (white: Y = 1) above which a colour counts as outside: 1 to 3
ΔE*ab at L* 50. It allows for rounding, and for colours that were measured for another illuminant or
observer and adapted to D50."""

_BANDS = 1e-5 * np.array([
    [76, 233, 775, 1619, 2451, 2772, 2498, 1718, 860, 283, 40, 88, 594, 1589, 2800, 4204, 5657,
     7135, 8533, 9269, 9833, 9464, 8006, 5932, 4168, 2611, 1541, 854, 433, 194, 191],
    [2, 6, 23, 66, 162, 313, 514, 798, 1238, 1841, 2947, 4632, 6591, 8302, 9199, 9645, 9472,
     8905, 8105, 6839, 5837, 4751, 3572, 2446, 1628, 985, 570, 312, 157, 70, 69],
    [359, 1110, 3722, 7901, 12301, 14618, 14338, 11304, 7302, 4132, 2466, 1447, 737, 401, 196,
     85, 37, 20, 15, 10, 7, 4, 2, 1, 0, 0, 0, 0, 0, 0, 0],
])  # fmt: skip
"""Tristimulus values of 31 bands from 400 to 700 nm, for D50 and 2°: weights of ASTM E308-18 for
steps of 10 nm, with 1 as the sum of Y. The bands at both ends include those beyond. This table
spares most builds the import of colour-science, which takes a second."""

_LIGHTNESS = 0.5
"""Excess of L* over 0 to 100 that is not a warning: fits to measured whites overshoot by less."""


def range_warnings(samples: Samples, device: FloatArray, limited: LimitedCube) -> list[str]:
    """Return warnings about parts of the range of channels that were not measured.

    `device` has the samples' distinct device values, (n, k), 0 to 1.
    """
    warnings = [
        f"{channel} was measured only from {100 * low:.3g} to {100 * high:.3g} %; the gamut covers "
        "that range."
        for channel, low, high in zip(
            samples.channels, device.min(axis=0), device.max(axis=0), strict=True
        )
        if low > 0.005 or high < 0.995
    ]
    full = float(limited.base[~limited.free].sum() + limited.cube.largest_sum)
    most = float(device.sum(axis=1).max())
    if not samples.additive and most < 0.99 * full:
        warnings.append(
            f"The largest measured sum of inks is {100 * most:.0f} %; colours up to "
            f"{100 * full:.0f} % are extrapolated."
        )
    return warnings


def extrapolation_warnings(
    corners: FloatArray,
    device: FloatArray,
    points: FloatArray,
    measured: FloatArray,
) -> list[str]:
    """Return warnings about the part of a gamut that no sample supports.

    Warnings arise if a corner (c, k) of the cube is farther than half a channel's range from all
    samples `device` (n, k), or if the convex hull of `points` is clearly larger than that of
    `measured`.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415  # slow; only device models need it

    distances, _ = cKDTree(device).query(corners, distance_upper_bound=_FAR)
    far = int(np.isinf(distances).sum())
    hull_volume = _hull_volume(measured)
    ratio = _hull_volume(_thinned(points, _HULL_POINTS)) / hull_volume if hull_volume > 0 else 1.0
    warnings = []
    if far:
        warnings.append(
            f"{far} of the {len(corners)} corners of the device cube are farther from all samples "
            "than half the range of a channel; the gamut is extrapolated there."
        )
    if far or ratio > _EXCESS:
        warnings.append(
            f"The convex hull of the gamut has {ratio:.2f} times the volume of the convex hull of "
            "the measured colours."
        )
    return warnings


def _hull_volume(colours: FloatArray) -> float:
    """Volume of the convex hull of colours; 0 if they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  # as above

    try:
        return float(ConvexHull(colours).volume)
    except (QhullError, ValueError):
        return 0.0


def _thinned(colours: FloatArray, most: int) -> FloatArray:
    """Return evenly chosen rows, at most `most`."""
    return colours[:: -(-len(colours) // most)]


def impossible_colour_warnings(lab: FloatArray, *, lights: bool) -> list[str]:
    """Return warnings about colours (m, 3) in CIELAB that no surface, or no light, can have."""
    warnings = []
    beyond = (lab[:, 0] < -_LIGHTNESS) | (lab[:, 0] > 100.0 + _LIGHTNESS)
    if beyond.any():
        low, high = float(lab[:, 0].min()), float(lab[:, 0].max())
        warnings.append(
            f"{int(beyond.sum())} of {len(lab)} colours have an L* outside 0 to 100: from "
            f"{low:.1f} to {high:.1f}."
        )
    if lights:
        return warnings
    middle, normals, supports = _optimal_colour_solid()
    away = lab_to_xyz(_thinned(lab, _TESTED)) - middle
    outside = (np.abs(away @ normals.T) - supports).max(axis=1) > _OUTSIDE
    if outside.any():
        warnings.append(
            f"{100 * outside.mean():.3g} % of the colours are outside the optimal colour solid "
            "(D50, 2°). No reflecting surface can have them."
        )
    return warnings


@lru_cache(maxsize=1)
def _optimal_colour_solid() -> tuple[FloatArray, FloatArray, FloatArray]:
    """The middle (3,) of the optimal colour solid in XYZ, normals of its faces and their distances.

    Reflectances of 0 to 1 in bands of 10 nm have the colours of a zonotope: the sum of one segment
    for each band. Two bands span each pair of opposite faces, of which one is returned.
    """
    bands = _BANDS.T * (ICC_D50 / _BANDS.sum(axis=1))
    first, second = np.triu_indices(len(bands), 1)
    normals = np.cross(bands[first], bands[second])
    lengths = np.linalg.norm(normals, axis=1)
    # Bands at the ends of the spectrum have nearly the same chromaticity and span no face.
    normals = normals[lengths > 1e-12] / lengths[lengths > 1e-12, np.newaxis]
    return bands.sum(axis=0) / 2, normals, np.abs(normals @ bands.T).sum(axis=1) / 2
