"""Intervals of volume and of comparisons: how far the data lets them be known.

The method is explained in ``docs/uncertainty.md``. Errors are drawn and propagated through the
device model and the surface of the device: the Monte Carlo method of JCGM 101:2008 (GUM
Supplement 1). Nothing is decimated. Three parts are kept apart:

- *noise* of readings: each patch gets a random error, and the white is measured with the others;
- *patches*: models of random halves of the patches, whose difference from the whole is scaled by
  the measured order of convergence;
- *instrument*: an error that all readings have in common, which does not average out.

A fit and an interpolation are linear in the colours of the patches. All draws therefore share one
factorisation.
"""

from __future__ import annotations

from math import ceil, hypot, inf, sqrt
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from gamutcore.arguments import Number, check_option
from gamutcore.boundary import radial_map, wrap_colours
from gamutcore.colours import lab_to_xyz, xyz_to_lab
from gamutcore.colours.device_model import (
    SMOOTHING,
    Fit,
    GridModel,
    Interpolation,
    scattered_model,
)
from gamutcore.colours.sampling import surface_values
from gamutcore.errors import DeviceModelError, InvalidPointsError, OptionError
from gamutcore.number_text import number_text, volume_text
from gamutcore.options import Options
from gamutcore.questions.comparison import compared_conditions
from gamutcore.questions.conditions import build_warnings
from gamutcore.questions.declarations import (
    NULLABLE_NUMBER,
    NUMBER,
    Answer,
    Parameter,
    Question,
    described,
    list_of,
)
from gamutcore.questions.levels import check_space, is_as_measured
from gamutcore.results import ComparisonUncertainty, Interval, VolumeUncertainty

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.colours import DeviceModel
    from gamutcore.geometry import TriangleMesh
    from gamutcore.questions.levels import GamutLike

__all__ = ["UNCERTAINTY", "compare_with_interval", "uncertainty"]

SURFACE_SAMPLES = 3000
"""Points of the surface. The volume of FOGRA39L differs by 0.01 % from that of 100,000 points, and
the figures are of differences between surfaces with the same device values."""

PIXELS = 128
"""Pixels along an edge of the cube of rays. All surfaces are met by the same rays."""

DRAWS = 100
"""Draws of errors. The standard deviation of so many is within 14 % of the true one (95 %)."""

HALVES = 16
"""Random halves of the patches."""

BIAS_ORDER = 1.2
"""Order of convergence of the volume in the number of patches (``docs/uncertainty.md``)."""

SPREAD_ORDER = 1.0
"""Order of convergence of the standard deviation by the choice of patches."""

TARGET = 0.01
"""Half-width for which the number of patches is stated."""

NORMAL = 1.96
"""Coverage factor of 95 % of a normal distribution."""

HALVES_FACTOR = 2.57
"""Coverage factor of what the halves tell: Student's t of five degrees of freedom. Halves of one
set of patches overlap, so they are worth fewer than `HALVES` independent ones."""

FEWEST_PATCHES = 8
"""Patches that can be left out, below which halves say nothing."""

INSTRUMENT_RADIUS = 50.0
"""Distance from mid grey, L*a*b* 50 0 0, at which a common error has its stated mean square."""

NOISE = Annotated[float, Number(0.0, 20.0)]
"""Noise and instrument, in ΔE*ab."""


class _Surface:
    """The surface of a gamut in directions from a centre, as a function of its patches' colours.

    `patches` (n, k) are device values, and `lab` (n, 3) their colours in CIELAB of the gamut.
    """

    def __init__(self, gamut: GamutLike) -> None:
        model = _measured_model(gamut)
        function = model.function
        assert isinstance(function, Fit | Interpolation)  # noqa: S101  # by _measured_model
        self._gamut, self._inks = gamut, model.inks
        self.is_grid = isinstance(function, Interpolation)
        self.patches, self.lab = _patches_of(function)
        nodes, varied = None, np.ones(self.patches.shape[1], bool)
        if isinstance(function, Fit):
            varied = function.varied
        elif len(set(function.model.shape)) == 1:
            nodes = np.stack(function.model.levels)
        surface = surface_values(model.limited, function.fitted, SURFACE_SAMPLES, nodes)
        self._values = np.ascontiguousarray(surface.device[:, varied])
        self._faces = surface.faces
        self._points = self.points(self.lab, None)
        target = 0.0 if model.inks else 1.0
        white = (np.abs(self.patches - target) < 1e-6).all(axis=1)
        self.white = np.flatnonzero(white)
        low, high = self.patches.min(axis=0), self.patches.max(axis=0)
        corner = ((self.patches == low) | (self.patches == high)).all(axis=1)
        self._corners, self._others = np.flatnonzero(corner), np.flatnonzero(~corner)

    @property
    def centre(self) -> FloatArray:
        """The centre of the gamut."""
        return np.asarray(self._gamut.history.centre, np.float64)

    @property
    def lightness_scale(self) -> float:
        """Change of CIELAB from as measured to relative to the medium, for the noise of readings.

        Coordinates grow with the cube root of the luminance.
        """
        white = self._gamut.conditions.medium_white
        if self._gamut.conditions.intent != "relative" or white is None:
            return 1.0
        return 116.0 / (white[0] + 16.0)

    def points(self, lab: FloatArray, rows: LongArray | None) -> FloatArray:
        """Return the surface (s, 3) by the model of some patches, or of all."""
        patches = self.patches if rows is None else self.patches[rows]
        lab = lab if rows is None else lab[rows]
        if not self.is_grid:
            return scattered_model(patches, lab).colours(self._values)
        levels = tuple(map(np.unique, patches.T))
        return GridModel(levels, np.ascontiguousarray(lab, np.float32)).colours(self._values)

    def has_chart_of(self, other: _Surface) -> bool:
        """Whether the patches are those of another surface, so that their choice is the same."""
        return self.is_grid == other.is_grid and np.array_equal(self.patches, other.patches)

    def moved(self, errors: FloatArray) -> list[FloatArray]:
        """Return the surface for each of the errors (t, n, 3) of the readings of the patches."""
        errors = np.stack([self._normalised(self.lab + error) - self.lab for error in errors])
        if self.is_grid:
            return [self.points(self.lab + error, None) for error in errors]
        columns = np.ascontiguousarray(np.moveaxis(errors, 0, 1)).reshape(len(self.patches), -1)
        moves = scattered_model(self.patches, columns).columns(self._values)
        return [self._points + part for part in np.split(moves, len(errors), axis=1)]

    def radii(self, points: FloatArray | None, centre: FloatArray) -> FloatArray:
        """Return the radii of the surface as `radial_map`, in the space of the gamut."""
        lab = (self._points if points is None else points).copy()
        lab[:, 0] = np.maximum(lab[:, 0], 0.0)
        gamut = self._gamut
        coordinates = lab
        if not gamut.colour_space.is_icc_cielab:
            coordinates, _ = gamut.colour_space.from_tristimulus(
                lab_to_xyz(lab), as_measured=is_as_measured(gamut)
            )
        method = gamut.description["provenance"].get("boundary", {}).get("method")
        if method == "device-surface" and self._faces is not None:
            return radial_map(coordinates, self._faces.corners, centre, PIXELS)
        options = Options.from_mapping(gamut.description["options"])
        wrapped = wrap_colours(
            coordinates, self._faces, str(method), self.centre, options.boundary_parameters
        )
        return _mesh_radii(wrapped.boundary.mesh, centre)

    def _normalised(self, lab: FloatArray) -> FloatArray:
        """Return colours relative to the white among them, as those of the data are."""
        conditions = self._gamut.conditions
        relative = conditions.intent == "relative"
        if not len(self.white) or not (relative or not (self._inks or conditions.is_print)):
            return lab
        xyz = lab_to_xyz(lab)
        white = xyz[self.white].mean(axis=0)
        if relative:
            return xyz_to_lab(xyz * (lab_to_xyz(self.lab[self.white]).mean(axis=0) / white))
        before = lab_to_xyz(self.lab[self.white])[:, 1].mean()
        return xyz_to_lab(xyz * (before / white[1]))  # luminances relative to the white

    def halves(self, random: np.random.Generator) -> list[LongArray]:
        """Return rows of halves of the patches. Solids and their overprints are in all of them.

        Of a grid, every second level is the only half. No halves: there are too few patches.
        """
        if not self.is_grid:
            if len(self._others) < FEWEST_PATCHES:
                return []
            half = len(self._others) // 2
            return [
                np.sort(np.append(self._corners, random.permutation(self._others)[:half]))
                for _ in range(HALVES)
            ]
        inside = np.ones(len(self.patches), bool)
        for values in self.patches.T:
            levels = np.unique(values)
            inside &= np.isin(values, [*levels[::2], levels[-1]])
        return [] if inside.all() else [np.flatnonzero(inside)]

    def scales(self, half: LongArray) -> tuple[float, float]:
        """Return by what the difference of a half is multiplied: for the bias, and the spread.

        The errors of linear interpolation fall with the square of the step between levels.
        """
        if self.is_grid:
            return 1.0 / 3.0, 0.0
        ratio = len(self.patches) / len(half)
        return 1.0 / (ratio**BIAS_ORDER - 1.0), 1.0 / sqrt(ratio ** (2.0 * SPREAD_ORDER) - 1.0)


class _FixedSurface:
    """The surface of a gamut that counts as exact: of a reference, a profile or a mesh."""

    def __init__(self, gamut: GamutLike) -> None:
        self.centre = np.asarray(gamut.history.centre, np.float64)
        self._mesh = gamut.history.full()
        self._radii: FloatArray | None = None

    def radii(self, points: FloatArray | None, centre: FloatArray) -> FloatArray:  # noqa: ARG002
        """Return the radii as `radial_map`."""
        if self._radii is None:
            self._radii = _mesh_radii(self._mesh, centre)
        return self._radii


def _mesh_radii(mesh: TriangleMesh, centre: FloatArray) -> FloatArray:
    vertices = np.ascontiguousarray(mesh.vertices, np.float64)
    radii: FloatArray = radial_map(vertices, mesh.faces, centre, PIXELS)
    return radii


def _is_measured(gamut: GamutLike) -> bool:
    """Whether the gamut is that of a device model of measured patches."""
    facts = gamut.description["provenance"]
    return "patches" in facts and str(facts["model"]["name"]).startswith(
        ("radial basis", "n-linear")
    )


def _measured_model(gamut: GamutLike) -> DeviceModel:
    """Return the model of measured samples; refuse gamuts of any other kind."""
    if not _is_measured(gamut):
        kind = gamut.description["provenance"].get("format", "")
        raise DeviceModelError(
            f"The gamut has no interval: its data, of the format {kind}, has no measured patches.",
            where={"field": "gamut"},
            remedy="Give the measurements themselves: patches with their device values and colours "
            "as CGATS, CxF or CSV. A profile may embed them (source=measurements).",
        )
    model = gamut.device_model
    if not isinstance(model.function, Fit | Interpolation):
        raise DeviceModelError(
            "The gamut has no interval: its device model is not of measured patches.",
            where={"field": "gamut"},
            remedy="Give the measurements themselves, as CGATS, CxF or CSV.",
        )
    return model


class _Reading(NamedTuple):
    """The noise of readings in ΔE*ab, root mean square, as measured; None if it is not known.

    `white` is the number of readings of the white.
    """

    noise: float | None
    source: str
    white: int = 1


def _reading(
    gamut: GamutLike, surface: _Surface, noise: float | None, repeats: DeviceModel | None
) -> _Reading:
    stated = gamut.description["provenance"].get("repeats", {})
    white = max(int(stated.get("white", 1)), 1)
    if noise is not None:
        check_option("noise", noise, NOISE)
        return _Reading(float(noise), "given", white)
    if repeats is not None:
        return _Reading(_second_reading(surface, repeats), "a second reading", white)
    if stated:
        scale = surface.lightness_scale
        return _Reading(float(stated["noise"]) / scale, "repeated patches of the data", white)
    return _Reading(None, "not known")


def _second_reading(surface: _Surface, repeats: DeviceModel) -> float:
    """Return the noise of one reading, from the differences of two."""
    function = repeats.function
    if not isinstance(function, Fit | Interpolation):
        raise OptionError.not_applicable("repeats", "data", "it has no measured patches")
    patches, lab = _patches_of(function)
    rows = {tuple(row): number for number, row in enumerate(np.round(patches, 3).tolist())}
    pairs = [
        (number, rows[key])
        for number, key in enumerate(map(tuple, np.round(surface.patches, 3).tolist()))
        if key in rows
    ]
    if len(pairs) < FEWEST_PATCHES:
        raise OptionError(
            f"The second reading has {len(pairs)} patches in common with the first.",
            where={"field": "repeats"},
            remedy=f"Give a reading of the same chart: {FEWEST_PATCHES} or more of its patches.",
        )
    first, second = np.array(pairs).T
    squares = ((surface.lab[first] - lab[second]) ** 2).sum(axis=1)
    return sqrt(float(squares.mean()) / 2.0) / surface.lightness_scale


def _patches_of(function: Fit | Interpolation) -> tuple[FloatArray, FloatArray]:
    """Return the device values of the patches that vary, and their colours.

    A fit misses the colours by its smoothing, so that they follow from it.
    """
    if isinstance(function, Fit):
        fit = function.model
        return fit.centres, fit.colours(fit.centres) + SMOOTHING * fit.weights
    grid = function.model
    axes = np.meshgrid(*grid.levels, indexing="ij")
    return np.stack([axis.ravel() for axis in axes], axis=1), grid.table.astype(np.float64)


class _Parts(NamedTuple):
    """Figures (q,), corrections of their bias, and half-widths of the parts (95 %)."""

    value: FloatArray
    bias: FloatArray
    noise: FloatArray
    patches: FloatArray
    instrument: FloatArray

    @property
    def half_width(self) -> FloatArray:
        """Half-width of the whole interval."""
        return np.sqrt(self.noise**2 + self.patches**2 + self.instrument**2)

    def scaled(self, factor: float) -> _Parts:
        """Return the parts in another unit."""
        return _Parts(*(factor * part for part in self))

    def interval(self, figure: int, least: float, most: float) -> Interval:
        """Return the interval of a figure, which lies between two limits."""
        value = float(self.value[figure] + self.bias[figure])
        half = float(self.half_width[figure])
        return Interval(
            min(max(value, least), most),
            max(value - half, least),
            min(value + half, most),
            noise=float(self.noise[figure]),
            patches=float(self.patches[figure]),
            instrument=float(self.instrument[figure]),
            bias=float(self.bias[figure]),
        )


class _Study:
    """Figures of one or two surfaces, and how they vary with the errors of the patches.

    `figures` makes them of the radii of the surfaces.
    """

    def __init__(
        self,
        surfaces: Sequence[_Surface | _FixedSurface],
        figures: Callable[[Sequence[FloatArray]], FloatArray],
    ) -> None:
        self._surfaces, self._figures = surfaces, figures
        self._random = np.random.default_rng(0)  # the same data must give the same interval
        centres = [surface.centre for surface in surfaces]
        for centre in (np.mean(centres, axis=0), *centres):
            self._centre = centre
            whole = [surface.radii(None, centre) for surface in surfaces]
            if all((radii > 0.0).all() for radii in whole):
                break
        else:
            raise OptionError(
                "The gamuts have no common centre.",
                where={"field": "other"},
                remedy="Give two gamuts that overlap.",
            )
        self._whole, self._value = whole, figures(whole)

    def parts(
        self, readings: Sequence[_Reading], instrument: float, *, same_instrument: bool
    ) -> _Parts:
        """Return the figures with their corrections and the parts of their intervals."""
        zero = np.zeros_like(self._value)
        bias, noise, common = zero, zero, zero
        if any(reading.noise for reading in readings):
            moved = self._deviations(
                [
                    self._noise(surface, reading) if isinstance(surface, _Surface) else None
                    for surface, reading in zip(self._surfaces, readings, strict=True)
                ]
            )
            bias = bias - moved.mean(axis=0)
            noise = NORMAL * moved.std(axis=0, ddof=1)
        if instrument:
            draws = self._random.normal(size=(2, DRAWS, 4, 3)) * instrument / sqrt(6.0)
            moved = self._deviations(
                [
                    _common_errors(surface, draws[0 if same_instrument else number])
                    if isinstance(surface, _Surface)
                    else None
                    for number, surface in enumerate(self._surfaces)
                ]
            )
            common = NORMAL * moved.std(axis=0, ddof=1)
        squares = zero
        for group in self._groups():
            group_bias, spread = self._halves(group)
            bias = bias + group_bias
            squares = squares + group_bias**2 + spread**2
        return _Parts(self._value, bias, noise, HALVES_FACTOR * np.sqrt(squares), common)

    def _groups(self) -> list[list[int]]:
        """Return the numbers of surfaces whose patches are halved together: those of one chart."""
        measured = [
            (number, surface)
            for number, surface in enumerate(self._surfaces)
            if isinstance(surface, _Surface)
        ]
        if len(measured) == 2 and measured[0][1].has_chart_of(measured[1][1]):
            return [[number for number, _ in measured]]
        return [[number] for number, _ in measured]

    def _halves(self, group: list[int]) -> tuple[FloatArray, FloatArray]:
        """Return the bias by the number of patches, and the spread by their choice."""
        surfaces = [self._surfaces[number] for number in group]
        first = surfaces[0]
        assert isinstance(first, _Surface)  # noqa: S101  # by _groups
        halves = first.halves(self._random)
        if not halves:
            raise InvalidPointsError(
                f"{len(first.patches)} patches are too few for an interval: without the solids and "
                f"their overprints, {FEWEST_PATCHES} are needed, or three levels of a grid.",
                where={"field": "samples"},
                remedy="Measure a chart of more patches.",
            )
        differences = []
        for rows in halves:
            radii = list(self._whole)
            for number in group:
                surface = self._surfaces[number]
                assert isinstance(surface, _Surface)  # noqa: S101  # by _groups
                radii[number] = surface.radii(surface.points(surface.lab, rows), self._centre)
            differences.append(self._value - self._figures(radii))
        for_bias, for_spread = first.scales(halves[0])
        changes = np.array(differences)
        spread = changes.std(axis=0, ddof=1) if len(changes) > 1 else np.zeros_like(self._value)
        return for_bias * changes.mean(axis=0), for_spread * spread

    def _noise(self, surface: _Surface, reading: _Reading) -> list[FloatArray]:
        """Return surfaces with the noise of readings."""
        axis = (reading.noise or 0.0) * surface.lightness_scale / sqrt(3.0)
        errors = self._random.normal(0.0, axis, (DRAWS, *surface.lab.shape))
        errors[:, surface.white] /= sqrt(reading.white)
        return surface.moved(errors)

    def _deviations(self, moved: Sequence[list[FloatArray] | None]) -> FloatArray:
        """Return the deviations (draws, q) of the figures of moved surfaces."""
        rows = []
        for draw in range(DRAWS):
            radii = [
                whole if points is None else surface.radii(points[draw], self._centre)
                for surface, points, whole in zip(self._surfaces, moved, self._whole, strict=True)
            ]
            rows.append(self._figures(radii) - self._value)
        return np.array(rows)


def _common_errors(surface: _Surface, draws: FloatArray) -> list[FloatArray]:
    """Return surfaces with errors that readings have in common: a shift and a linear change."""
    away = (surface.lab - (50.0, 0.0, 0.0)) / INSTRUMENT_RADIUS
    terms = np.column_stack([np.ones(len(away)), away])
    return surface.moved(surface.lightness_scale * (terms @ draws))


def _volume_of(radii: FloatArray) -> float:
    """Return the volume within radii: ∫ t³ ÷ 3 du dv over the sides of the cube."""
    volume: float = float((radii**3).sum()) / 3.0 * (2.0 / radii.shape[1]) ** 2
    return volume


def _volume_figures(radii: Sequence[FloatArray]) -> FloatArray:
    return np.array([_volume_of(radii[0])])


def _pair_figures(radii: Sequence[FloatArray]) -> FloatArray:
    """Return A ÷ B − 1, the share of B that A covers, and the share of A that B covers."""
    a, b, both = map(_volume_of, (*radii, np.minimum(*radii)))
    return np.array([a / b - 1.0, both / b, both / a])


def uncertainty(
    gamut: GamutLike,
    noise: float | None = None,
    repeats: DeviceModel | None = None,
    instrument: float = 0.0,
) -> VolumeUncertainty:
    """Return the 95 % interval of the volume of a measured device, with its parts.

    Parameters
    ----------
    noise : float, optional
        Noise of readings: root mean square ΔE*ab of one reading. By default that of the repeated
        patches of the data.
    repeats : DeviceModel, optional
        The device model of a second reading, from which the noise is found.
    instrument : float, optional
        Error that all readings have in common, in ΔE*ab.
    """
    check_option("instrument", instrument, NOISE)
    surface = _Surface(gamut)
    reading = _reading(gamut, surface, noise, repeats)
    study = _Study([surface], _volume_figures)
    parts = study.parts([reading], instrument, same_instrument=False)
    exact = float(gamut.description["volume"])
    relative = parts.scaled(1.0 / parts.value[0]).interval(0, 0.0, inf)
    needed = _patches_needed(relative, len(surface.patches))
    volume = parts.scaled(exact / parts.value[0]).interval(0, 0.0, inf)
    return VolumeUncertainty(
        volume=volume,
        relative=relative,
        noise=reading.noise,
        noise_from=reading.source,
        patches=len(surface.patches),
        patches_needed=needed,
        summary=_volume_words(volume, relative, len(surface.patches), needed),
        gamut=gamut.conditions,
        warnings=(*build_warnings(gamut.conditions), *_noise_warnings([reading])),
    )


def compare_with_interval(
    gamut: GamutLike,
    other: GamutLike,
    *,
    noise: float | None = None,
    instrument: float = 0.0,
    same_instrument: bool = False,
) -> ComparisonUncertainty:
    """Return the 95 % intervals of a comparison of a gamut, A, with another one, B.

    Errors of readings, and of the choice of patches of different charts, are independent. Those of
    the choice of patches cancel in part if both have the same patches, and those of the instrument
    only if it is the `same_instrument`.
    """
    check_option("instrument", instrument, NOISE)
    check_space(gamut, other)
    both = gamut, other
    surfaces = [_Surface(each) if _is_measured(each) else _FixedSurface(each) for each in both]
    measured = [surface for surface in surfaces if isinstance(surface, _Surface)]
    if not measured:
        _measured_model(gamut)  # raises the error
    readings = [
        _reading(each, surface, noise, None)
        if isinstance(surface, _Surface)
        else _Reading(None, "exact")
        for each, surface in zip(both, surfaces, strict=True)
    ]
    study = _Study(surfaces, _pair_figures)
    parts = study.parts(readings, instrument, same_instrument=same_instrument)
    larger = parts.interval(0, -1.0, inf)
    counts = [
        len(surface.patches) if isinstance(surface, _Surface) else None for surface in surfaces
    ]
    fewest = min(count for count in counts if count is not None)
    needed = _patches_needed(larger, fewest)
    exact = tuple(
        f"{name} counts as exact: it has no measured patches."
        for name, count in zip("AB", counts, strict=True)
        if count is None
    )
    return ComparisonUncertainty(
        larger=larger,
        a_covers_b=parts.interval(1, 0.0, 1.0),
        b_covers_a=parts.interval(2, 0.0, 1.0),
        smallest_difference=2.0 * larger.half_width,
        noise=(readings[0].noise, readings[1].noise),
        patches=(counts[0], counts[1]),
        patches_needed=needed,
        summary=_pair_words(parts, needed),
        gamuts=(gamut.conditions, other.conditions),
        warnings=(
            *build_warnings(gamut.conditions, other.conditions),
            *compared_conditions(gamut.conditions, other.conditions),
            *_noise_warnings(
                [
                    reading
                    for reading, count in zip(readings, counts, strict=True)
                    if count is not None
                ]
            ),
            *exact,
        ),
    )


def _noise_warnings(readings: Sequence[_Reading]) -> tuple[str, ...]:
    if all(reading.noise is not None for reading in readings):
        return ()
    warning = (
        "The noise of readings is not known, and is not in the interval: the data has no repeated "
        "patches. Give it in ΔE*ab (noise, --noise), or a second reading (repeats)."
    )
    return (warning,)


def _patches_needed(interval: Interval, patches: int) -> int | None:
    """Return the number of patches for ± 1 %, to two digits; None if other parts exceed it."""
    others = hypot(interval.noise, interval.instrument)
    if others >= TARGET:
        return None
    needed = patches * (interval.patches / sqrt(TARGET**2 - others**2)) ** (1.0 / SPREAD_ORDER)
    unit = 10 ** max(len(str(ceil(needed))) - 2, 0)
    rounded: int = ceil(needed / unit) * unit
    return rounded


def _percent(share: float) -> str:
    """Return a share in per cent, with two digits for small ones."""
    percent = abs(100.0 * share)
    return f"{percent:.1f} %" if percent >= 0.095 else f"{percent:.1g} %"


def _needed_words(needed: int | None, interval: Interval, patches: str) -> str:
    if needed is None:
        others = _percent(hypot(interval.noise, interval.instrument))
        return (
            f"No number of patches gives ± 1 %: noise and instrument alone are ± {others}. Read "
            "the chart, and above all its white, several times."
        )
    return f"For ± 1 %, {patches} would need about {needed} patches."


def _volume_words(
    volume: Interval, relative: Interval, patches: int, needed: int | None
) -> tuple[str, ...]:
    parts = [
        f"± {_percent(part)} by {name}"
        for part, name in (
            (relative.noise, "noise of readings"),
            (relative.patches, f"number and choice of the {patches} patches"),
            (relative.instrument, "instrument and paper"),
        )
        if part
    ]
    sign = "+" if relative.bias > 0 else "−"
    value, low, high = (
        volume_text(float(number_text(figure, 4)))
        for figure in (volume.value, volume.low, volume.high)
    )
    whole = f"The volume is {value} ± {_percent(relative.half_width)}, from {low} to {high} (95 %)."
    correction = (
        f"It is corrected by {sign}{_percent(relative.bias)}: few patches make a gamut smaller, "
        "and noise makes it larger."
    )
    needed_words = _needed_words(needed, relative, "the chart")
    return (whole, f"Parts: {', '.join(parts)}.", correction, needed_words)


def _pair_words(parts: _Parts, needed: int | None) -> tuple[str, ...]:
    larger = parts.interval(0, -inf, inf)
    half, difference = larger.half_width, larger.value
    most, least = ("A", "B") if difference >= 0.0 else ("B", "A")
    if difference < 0.0:  # of the smaller one
        share = 1.0 / (1.0 + difference) - 1.0
        half /= (1.0 + difference) ** 2
    else:
        share = difference
    amount = f"{_percent(share)} ± {_percent(half)}"
    limit = f"with these numbers of patches, differences below {_percent(2.0 * half)} mean nothing."
    if share < half:
        head = f"A and B cannot be told apart by volume: {most} is larger by {amount}; {limit}"
    else:
        probably = "" if share >= 2.0 * half else "probably "
        head = f"{most} is {probably}larger than {least} by {amount}; {limit}"
    covers = [
        f"{name} covers {_percent(cover.value)} of {other} ({_percent(cover.low)} to "
        f"{_percent(cover.high)})"
        for name, other, cover in (
            ("A", "B", parts.interval(1, 0.0, 1.0)),
            ("B", "A", parts.interval(2, 0.0, 1.0)),
        )
    ]
    return (head, f"{', and '.join(covers)}.", _needed_words(needed, larger, "each chart"))


_INTERVAL = {
    "type": "object",
    "properties": {
        "value": described(NUMBER, "The figure, corrected for its bias."),
        "low": described(NUMBER, "Lower end of the interval of 95 %."),
        "high": described(NUMBER, "Upper end."),
        "noise": described(NUMBER, "Half-width by the noise of readings."),
        "patches": described(NUMBER, "Half-width by the number and choice of patches."),
        "instrument": described(NUMBER, "Half-width by what all readings have in common."),
        "bias": described(NUMBER, "Correction that is in the value."),
    },
}


def _answer(result: VolumeUncertainty) -> Answer:
    document = {
        "summary": list(result.summary),
        "volume": result.volume.to_mapping(),
        "relative": result.relative.to_mapping(),
        "noise": result.noise,
        "noise_from": result.noise_from,
        "patches": result.patches,
        "patches_needed": result.patches_needed,
    }
    table = {name: np.array([value]) for name, value in result.volume.to_mapping().items()}
    return Answer(table, document=document)


UNCERTAINTY = Question(
    "uncertainty",
    "estimateUncertainty",
    "Estimate how well the volume is known",
    "The interval of 95 % of the volume of a measured device, with its parts: noise of readings, "
    "number and choice of patches, and what all readings have in common. Only for gamuts of "
    "measured patches. It takes seconds.",
    (
        Parameter(
            "noise",
            NOISE,
            "Noise of readings: root mean square ΔE*ab of one reading. Default: that of the "
            "repeated patches of the data.",
            example=0.3,
        ),
        Parameter(
            "instrument",
            NOISE,
            "Error that all readings have in common, in ΔE*ab.",
            default=0.0,
            example=0.5,
        ),
    ),
    uncertainty,
    answer_schema={
        "summary": described(list_of({"type": "string"}), "The interval in words."),
        "volume": described(_INTERVAL, "In cubic units of the space."),
        "relative": described(_INTERVAL, "The same as shares of the volume."),
        "noise": described(NULLABLE_NUMBER, "Noise of readings in ΔE*ab; null if it is not known."),
        "noise_from": described({"type": "string"}, "Where the noise is from."),
        "patches": described({"type": "integer"}, "Number of patches of the device model."),
        "patches_needed": described(
            {"type": ["integer", "null"]},
            "Number of patches for ± 1 %; null if the other parts alone exceed it.",
        ),
    },
    tabulate_result=_answer,
    example_answer={
        "summary": ["The volume is 401700 ± 0.8 %, from 398500 to 404900 (95 %)."],
        "noise": 0.3,
        "noise_from": "given",
        "patches": 1588,
        "patches_needed": 240,
    },
    level=(),
    needs_model=True,
)
