"""Reports of a gamut by published standards: displays, printing processes, comparisons.

`STANDARDS` declares each standard once, with its edition, what it asks to be stated, and what could
not be checked because its text is not public. `report` arranges the figures.

The gamut rings of displays follow the public tools of the standard's authors: triangles in CIELAB
between 602 signals, crossed by rays from the L* axis at the middles of 100 steps of L* and 360 of
hue. The crossings are signed, so that folds of displays with a white sub-pixel count once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.characterisation.icc import icc_profile
from gamutcore.colours import lab_to_xyz, xyz_to_lab
from gamutcore.colours.device_model import Fit, Interpolation
from gamutcore.colours.profile import ProfileTransform, printed_values, profile_colours
from gamutcore.content import gamut_source, is_saved_gamut
from gamutcore.errors import OptionError, UnsupportedProfileError
from gamutcore.gamut import Gamut
from gamutcore.names import folded
from gamutcore.number_text import fixed_text
from gamutcore.questions import compared_conditions, draw_rings
from gamutcore.reports.document import Chart, Report, ReportColumn, ReportTable
from gamutcore.reports.signals import SIGNAL_COUNTS, cube_faces, signal_levels
from gamutcore.results import GamutRings

if TYPE_CHECKING:
    import os

    from matplotlib.figure import Figure

    from gamutcore.arrays import FloatArray, IndexArray, LongArray
    from gamutcore.colours import DeviceModel

__all__ = ["STANDARDS", "Standard", "find_standard", "report", "standard_intent"]

HUES = 360
LIGHTNESSES = np.arange(100) + 0.5
"""Middles of the steps of L*, in the standard 100."""

RING_NUMBERS = range(9, 100, 10)
"""Steps of L* that end at 10, 20, …, 100: the rings that are drawn."""

SAME_SIGNAL = 0.006
"""Largest difference of a measured device value from a test signal: 1.5 codes of 8 bits."""

EMISSIVE_SCALE, REFLECTIVE_SCALES = 1250.0, (150.0, 300.0, 600.0)
"""Ends of the axes of charts of rings (IEC 62906-6-1:2025)."""

_UNCHECKED = "The text of the standard is not public; {} not checked against it."


@dataclass(frozen=True)
class Standard:
    """A standard that a gamut is reported by.

    Attributes
    ----------
    slug, title, edition : str
        Name in commands, what the report is about, and the edition with the clause.
    method : str
        How the figures are found.
    not_checked : str
        What could not be checked.
    body : callable
        The gamut and the reference, or None, to the parts of a report.
    needs_reference : bool
    """

    slug: str
    title: str
    edition: str
    method: str
    not_checked: str
    body: Callable[[Gamut, Gamut | None], _Parts]
    needs_reference: bool = False


class _Parts(NamedTuple):
    """The parts of a report that depend on the standard."""

    sentences: Sequence[str]
    conditions: Mapping[str, str]
    tables: Sequence[ReportTable]
    warnings: Sequence[str] = ()
    charts: Sequence[Chart] = ()
    data: Mapping[str, Any] = MappingProxyType({})


def report(
    gamut: Gamut,
    standard: str,
    reference: Gamut | str | os.PathLike[str] | None = None,
) -> Report:
    """Return the report of a gamut by a standard.

    Parameters
    ----------
    gamut : Gamut
        In CIELAB relative to D50. `gamutcore.reports.standard_intent` names the intent that the
        standard needs; a warning says if the gamut has another one.
    standard : str
        ``"idms"``, ``"iec-62977"``, ``"iso-18621-11"`` or ``"cie-246"``.
    reference : Gamut, str or path, optional
        Gamut to compare with, which ``"cie-246"`` needs.

    Returns
    -------
    Report
        Names the edition, method, white, intent, medium, number of patches, and what of the
        standard could not be checked. `Report.save` writes it.

    Raises
    ------
    OptionError
        There is no such standard, it needs a reference, or the gamut is in another space.

    Examples
    --------
    >>> import gamutcore
    >>> srgb = gamutcore.reference("srgb", surface_samples=1000)
    >>> round(gamutcore.report(srgb, "idms").data["volume"], -3)
    831000.0
    """
    chosen = find_standard(standard, has_reference=reference is not None)
    if not gamut.colour_space.is_icc_cielab:
        raise OptionError(
            f"The gamut is in {gamut.colour_space.name}, and {chosen.edition} is for CIELAB.",
            where={"field": "space"},
            remedy="Build it with the default space, CIELAB relative to D50.",
        )
    other = None if reference is None else _opened(reference)
    parts = chosen.body(gamut, other)
    name = gamut.name or "The gamut"
    conditions = {
        "Standard": chosen.edition,
        "Method": chosen.method,
        "Gamut": f"{name}: {gamut.conditions}",
        "Medium": _medium(gamut),
        "White": _white(gamut),
        "Intent": gamut.conditions.intent,
        "Patches": _patches(gamut),
        **parts.conditions,
    }
    if other is not None:
        conditions["Reference"] = f"{other.name or 'reference'}: {other.conditions}"
        conditions["Reference white"] = _white(other)
    conditions["Not checked"] = chosen.not_checked
    warnings = [*parts.warnings, *_intent_warnings(gamut, chosen)]
    if other is None:
        warnings += gamut.conditions.build_warnings
    else:
        other_name = other.name or "The reference"
        names = ("A", "B") if name == other_name else (name, other_name)
        both = gamut.conditions, other.conditions
        for side, each in zip(names, both, strict=True):
            warnings += [f"{side}: {warning}" for warning in each.build_warnings]
        warnings += compared_conditions(*both, names)
    return Report(
        f"{chosen.title}: {name}",
        parts.sentences,
        conditions,
        parts.tables,
        parts.charts,
        tuple(dict.fromkeys(warnings)),
        {"standard": chosen.slug, **parts.data},
    )


def find_standard(name: str, *, has_reference: bool) -> Standard:
    """Return the standard of a name; refuse others, and a comparison without a reference."""
    slugs = {folded(slug): slug for slug in STANDARDS}
    if folded(str(name)) not in slugs:
        *others, last = STANDARDS
        raise OptionError.refusal("standard", name, f"{', '.join(others)} or {last}")
    chosen = STANDARDS[slugs[folded(str(name))]]
    if chosen.needs_reference and not has_reference:
        raise OptionError(
            f"{chosen.edition} compares two gamuts, and there is no reference.",
            where={"field": "reference"},
            remedy="Give a reference, such as srgb.",
        )
    return chosen


def _opened(reference: Gamut | str | os.PathLike[str]) -> Gamut:
    """Return the gamut of a name or a file, in CIELAB."""
    if isinstance(reference, Gamut):
        return reference
    source = gamut_source(reference)
    if not isinstance(source, bytes):
        return Gamut(source.data)
    return Gamut.load(reference) if is_saved_gamut(source) else Gamut(reference)


# --- what the gamut is ---------------------------------------------------------------------------


def _facts(gamut: Gamut) -> Mapping[str, Any]:
    facts: Mapping[str, Any] = gamut.description.get("provenance", {})
    return facts


def _is_display(gamut: Gamut) -> bool:
    """Whether the colours are lights: a display, or an RGB space."""
    facts = _facts(gamut)
    return str(facts.get("medium", "")).startswith("display") or (
        facts.get("device_class") in {"display", "colour space"}
        or (facts.get("format") == "reference" and "R" in gamut.channels)
    )


def standard_intent(gamut: Gamut, standard: str) -> str:
    """Return the intent that a standard needs for the medium of a gamut; empty if any is right.

    The white of an emissive display is that of the display, of a reflective one the perfect
    diffuser: an e-paper measured against its own white looks four times as large as it is.
    """
    if folded(standard) == folded("cie-246") or not (
        _is_display(gamut) or gamut.conditions.is_print
    ):
        return ""
    return "absolute" if gamut.conditions.is_print else "relative"


def _intent_warnings(gamut: Gamut, standard: Standard) -> list[str]:
    wanted = standard_intent(gamut, standard.slug)
    if wanted in {"", gamut.conditions.intent}:
        return []
    white = (
        "the perfect diffuser is the white of a reflective medium"
        if wanted == "absolute"
        else "the white of the display is adapted to D50"
    )
    has = f"The gamut has the intent {gamut.conditions.intent}. By the standard, {white}"
    return [f"{has}: build it with the intent {wanted}."]


def _per_cent(share: float, decimals: int = 1, *, signed: bool = False) -> str:
    return f"{fixed_text(100.0 * share, decimals, signed=signed)} %"


def _medium(gamut: Gamut) -> str:
    facts = _facts(gamut)
    if "medium" in facts:
        return str(facts["medium"])
    if "device_class" in facts:
        return f"profile of the class {facts['device_class']}"
    if facts.get("format") == "reference":
        return "RGB space, emissive" if "R" in gamut.channels else "reference gamut"
    return "not stated"


def _white(gamut: Gamut) -> str:
    white, facts = gamut.conditions.medium_white, _facts(gamut)
    parts = []
    xyz = facts.get("white")
    if isinstance(xyz, Sequence) and len(xyz) == 3:
        parts.append("X Y Z " + " ".join(f"{value:.5g}" for value in xyz))
    if white is not None:
        parts.append("absolute L*a*b* " + " ".join(fixed_text(value, 2) for value in white))
    return ", ".join(parts) or "not stated"


def _patches(gamut: Gamut) -> str:
    facts = _facts(gamut)
    model = facts.get("model", {})
    counts = facts.get("patches")
    if counts:
        residual = model.get("residual", {}).get("mean")
        error = "" if residual is None else f", which its model misses by {residual:.2f} ΔE*ab"
        return f"{counts['used']:,} measured{error}"
    tag = model.get("tag")
    return "none: " + (f"the transform {tag} of the profile" if tag else str(model.get("name", "")))


# --- gamut rings ---------------------------------------------------------------------------------


class _RayCrossings(NamedTuple):
    """Crossings of a surface with the rays: cell, distance from the axis, and 1 where it leaves."""

    cells: LongArray
    distance: FloatArray
    signs: FloatArray

    def volumes(self) -> FloatArray:
        """Return the volume in each cell, (100, 360)."""
        return _cell_volumes(self.cells, self.signs * self.distance**2)


def _cell_volumes(cells: LongArray, squares: FloatArray) -> FloatArray:
    count = len(LIGHTNESSES) * HUES
    sums = np.bincount(cells, squares, count).reshape(len(LIGHTNESSES), HUES)
    return np.asarray(sums * np.pi / HUES, np.float64)  # ΔL Δh/2, ΔL = 1


def _ray_crossings(points: FloatArray, faces: IndexArray) -> _RayCrossings:
    """Return the crossings of outward triangles (m, 3) with all rays."""
    corners = points[faces]
    angles = (np.arange(HUES) + 0.5) * 2.0 * np.pi / HUES
    ray = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    lists: list[tuple[LongArray, FloatArray, FloatArray]] = []
    for plane, height in enumerate(LIGHTNESSES):
        above = corners[:, :, 0] > height
        following = np.roll(above, -1, axis=1)
        rows = np.flatnonzero((above & ~following).any(axis=1))
        # the solid is at the left of the way from the edge that goes down to the one that goes up
        start, end = (
            _edge_points(corners[rows], (one[rows] & ~two[rows]).argmax(axis=1), height)
            for one, two in ((above, following), (following, above))
        )
        before, after = (
            ray[:, 0] * ends[:, np.newaxis, 1] - ray[:, 1] * ends[:, np.newaxis, 0]
            for ends in (start, end)
        )
        segment, hue = np.nonzero((before < 0.0) != (after < 0.0))
        before, after = before[segment, hue], after[segment, hue]
        share = (before / (before - after))[:, np.newaxis]
        crossing = start[segment] + share * (end - start)[segment]
        distance = (crossing * ray[hue]).sum(axis=1)
        ahead = distance > 0.0
        signs = np.where(before < 0.0, 1.0, -1.0)
        lists.append((plane * HUES + hue[ahead], distance[ahead], signs[ahead]))
    cells, distances, signs = (np.concatenate(part) for part in zip(*lists, strict=True))
    return _RayCrossings(cells.astype(np.int64), distances, signs)


def _edge_points(corners: FloatArray, edge: LongArray, height: float) -> FloatArray:
    """Return a*, b* (m, 2) where an edge of each triangle has a lightness."""
    rows = np.arange(len(corners))
    one, two = corners[rows, edge], corners[rows, (edge + 1) % 3]
    share = (height - one[:, 0]) / (two[:, 0] - one[:, 0])
    return np.asarray(one[:, 1:] + share[:, np.newaxis] * (two - one)[:, 1:], np.float64)


def _common_volumes(one: _RayCrossings, two: _RayCrossings) -> FloatArray:
    """Return the volume that two solids have in common in each cell, (100, 360)."""
    cells = np.concatenate([one.cells, two.cells])
    distance = np.concatenate([one.distance, two.distance])
    order = np.lexsort((-distance, cells))
    cells, squares = cells[order], distance[order] ** 2
    first = np.searchsorted(cells, cells)
    inside = np.ones(len(cells), bool)
    for part, before, behind in ((one, 0, len(two.cells)), (two, len(one.cells), 0)):
        windings = np.cumsum(np.pad(part.signs, (before, behind))[order])
        inside &= windings - np.concatenate([[0.0], windings])[first] > 0.5
    inner = np.append(squares[1:], 0.0)
    inner[np.append(cells[1:] != cells[:-1], True)] = 0.0
    return _cell_volumes(cells, np.where(inside, squares - inner, 0.0))


class _Solid(NamedTuple):
    """Triangles in CIELAB, what their vertices are, and why the volume is an estimate, if it is."""

    points: FloatArray
    faces: IndexArray
    vertices: str
    estimate: str = ""


def _display_solid(gamut: Gamut) -> _Solid:
    """Return the solid of the test signals of a display, else that of the gamut's boundary."""
    if gamut.channels != ("R", "G", "B") or not gamut.has_device_model:
        level = gamut.mesh(max_error=gamut.default_error)
        points = np.asarray(level.vertices, np.float64)
        return _Solid(points, level.faces, f"{len(points):,} of the boundary")
    model = gamut.device_model
    levels = signal_levels() / 255.0
    signals, faces = cube_faces(levels)
    ends = model.limited.cube.lowest, model.limited.cube.highest
    low, high = (model.limited.device(end[np.newaxis])[0] for end in ends)
    device = low + signals * (high - low)
    readings = _readings(model)
    if readings is None:
        return _Solid(model.lab(device), faces, "602 signals, whose colours are computed")
    at_end = ((readings <= low + SAME_SIGNAL) | (readings >= high - SAME_SIGNAL)).any(axis=1)
    count = next((n for n in sorted(SIGNAL_COUNTS, reverse=True) if _has_signals(readings, n)), 0)
    if count == len(signals):
        return _Solid(model.lab(device), faces, f"{count} measured signals")
    if not count:
        text = f"{int(at_end.sum())} readings on the surface of the cube are not a set of signals"
        return _Solid(model.lab(device), faces, "602 signals, by the device model", text)
    return _Solid(
        _between_signals(model, signals, count),
        faces,
        f"{count} measured signals, and 602 interpolated linearly in XYZ",
        f"{count} signals were measured, and the standard asks for 602",
    )


def _readings(model: DeviceModel) -> FloatArray | None:
    """Return the device values that were measured, (n, 3); None for other models."""
    function = model.function
    if isinstance(function, Fit) and function.varied.all():
        return function.model.centres
    if isinstance(function, Interpolation):
        grids = np.meshgrid(*function.model.levels, indexing="ij")
        return np.stack([grid.ravel() for grid in grids], axis=1)
    return None


def _has_signals(readings: FloatArray, count: int) -> bool:
    """Whether a set of test signals is among the readings."""
    from scipy.spatial import cKDTree  # noqa: PLC0415  # takes a tenth of a second

    signals = cube_faces(signal_levels(count) / 255.0)[0]
    distance, _ = cKDTree(readings).query(signals, p=np.inf)
    return bool(np.max(distance) < SAME_SIGNAL)


def _between_signals(model: DeviceModel, signals: FloatArray, count: int) -> FloatArray:
    """Return CIELAB of signals by interpolation in XYZ between a smaller set of signals."""
    from scipy.interpolate import RegularGridInterpolator  # noqa: PLC0415

    levels = signal_levels(count) / 255.0
    grid = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1)
    xyz = lab_to_xyz(model.lab(grid.reshape(-1, 3))).reshape(grid.shape)
    return xyz_to_lab(RegularGridInterpolator((levels,) * 3, xyz)(signals))


def _display_parts(gamut: Gamut, reference: Gamut | None) -> _Parts:
    solid = _display_solid(gamut)
    crossings = _ray_crossings(solid.points, solid.faces)
    maps = {"gamut": crossings.volumes()}
    if reference is not None:
        other = _ray_crossings(*_display_solid(reference)[:2])
        maps |= {"reference": other.volumes(), "intersection": _common_volumes(crossings, other)}
    squares = {
        name: 2.0 * cells.cumsum(axis=0) * HUES / (2.0 * np.pi) for name, cells in maps.items()
    }
    radii = {name: np.sqrt(np.maximum(square, 0.0)) for name, square in squares.items()}
    volumes = {name: float(cells.sum()) for name, cells in maps.items()}
    volume = volumes["gamut"]
    name = gamut.name or "the gamut"
    kind = "an estimate of the gamut volume" if solid.estimate else "the gamut volume"
    sentences = [f"{name}: {kind} is {volume:,.0f} in CIELAB (ΔE*ab³)."]
    if solid.estimate:
        sentences.append(f"It is an estimate: {solid.estimate}.")
    exact = float(gamut.description.get("device_surface_volume", gamut.volume))
    sentences.append(
        f"The volume within the whole surface, without steps, is {exact:,.0f} "
        f"({_per_cent(exact / volume - 1.0, 2, signed=True)})."
    )
    data: dict[str, Any] = {"volume": volume, "exact_volume": exact}
    if reference is not None:
        coverage = volumes["intersection"] / volumes["reference"]
        data |= {
            "reference_volume": volumes["reference"],
            "intersection_volume": volumes["intersection"],
            "coverage": coverage,
        }
        sentences.append(
            f"It covers {_per_cent(coverage)} of {reference.name or 'the reference'}, whose volume "
            f"by the same method is {volumes['reference']:,.0f}; the ratio of the volumes is "
            f"{_per_cent(volume / volumes['reference'])}."
        )
    data |= {
        "signals": solid.vertices,
        "lightness": LIGHTNESSES + 0.5,
        "hue": np.arange(HUES) + 0.5,
        "rings": {key: radius.round(3) for key, radius in radii.items()},
    }
    warnings = []
    if not (_is_display(gamut) or (gamut.conditions.is_print and "R" in gamut.channels)):
        warnings.append("The standard is for displays, and the data is not of a display.")
    if "peak_luminance" in _facts(gamut):
        warnings.append(
            "The method is not for high dynamic range: colours above L* 100 are left out."
        )
    return _Parts(
        sentences,
        {"Vertices": solid.vertices, "Hue": "from +a*; charts have a* to the right, b* upwards"},
        [_ring_table(maps, radii)],
        warnings,
        [
            Chart(
                "The area within a ring is the volume up to its lightness",
                lambda page: _draw(page, gamut, reference, radii, volume),
            )
        ],
        data,
    )


def _ring_table(maps: Mapping[str, FloatArray], radii: Mapping[str, FloatArray]) -> ReportTable:
    ends = [number + 1.0 for number in RING_NUMBERS]
    columns = [ReportColumn("L*", ends, decimals=0)]
    for name, cells in maps.items():
        sums = cells.sum(axis=1).cumsum()[list(RING_NUMBERS)]
        # a shorter heading, so that all columns fit 80 characters
        heading = "common volume" if name == "intersection" else ""
        title = f"{name} volume"
        columns.append(ReportColumn(title, sums.tolist(), decimals=0, heading=heading))
    for key, reduce in (("least", np.min), ("largest", np.max)):
        values = reduce(radii["gamut"][list(RING_NUMBERS)], axis=1)
        columns.append(ReportColumn(f"{key} C*RSS", values.tolist(), decimals=1))
    return ReportTable("Rings: volume up to a lightness, and C*RSS of the gamut", columns)


def _draw(
    page: Figure,
    gamut: Gamut,
    reference: Gamut | None,
    radii: Mapping[str, FloatArray],
    volume: float,
) -> None:
    rows = list(RING_NUMBERS)
    rings = {name: radius[rows] for name, radius in radii.items()}
    common = None
    if reference is not None:
        # in each band, the intersection begins at the ring of the gamut below
        below = np.concatenate([np.zeros((1, HUES)), rings["gamut"][:-1]])
        both = rings["intersection"] ** 2
        band = both - np.concatenate([np.zeros((1, HUES)), both[:-1]])
        common = np.sqrt(below**2 + band)
    drawn = GamutRings(
        np.asarray(rows, np.float64) + 1.0,
        np.asarray(np.arange(HUES) + 0.5, np.float64),
        rings["gamut"],
        volume,
        rings.get("reference"),
        common,
        gamut.conditions,
        None if reference is None else reference.conditions,
    )
    ax = page.add_subplot()
    draw_rings(
        ax,
        drawn,
        gamut.colour_space,
        gamut.name,
        "reference" if reference is None else reference.name or "reference",
    )
    largest = max(float(radius[-1].max()) for radius in radii.values())
    scales = REFLECTIVE_SCALES if gamut.conditions.is_print else (EMISSIVE_SCALE,)
    scale = next((each for each in scales if largest <= each), largest * 1.05)
    ax.set(xlim=(-scale, scale), ylim=(-scale, scale), aspect="equal")


# --- printing processes --------------------------------------------------------------------------

_CMY_LEVELS = np.array([0.0, 0.2, 0.4, 0.7, 1.0])
_K_LEVELS = np.array([0.0, 0.2, 0.4, 0.6, 1.0])
"""Levels of the surface chart: those that IT8.7/4 has in its solids of little and of much black."""


def _press_chart(channels: tuple[str, ...], *, inks: bool) -> tuple[FloatArray, IndexArray] | None:
    """Return device values and outward triangles of the surface of a chart; None for other devices.

    For CMYK: the light sides of the cube of CMY without black, its edges from primary to secondary
    with black, and the light sides with full black: 384 triangles.
    """
    if len(channels) == 3:
        return cube_faces(_CMY_LEVELS)
    if not inks or channels != ("C", "M", "Y", "K"):
        return None
    values, faces = cube_faces(_CMY_LEVELS)
    light = faces[(values[faces] == 0.0).all(axis=1).any(axis=1)]
    edge = _dark_edge(values, light)
    used = np.unique(light)
    layers = [np.column_stack([values[used], np.full(len(used), k)]) for k in _K_LEVELS]
    row = np.full(len(values), -1)
    row[used] = np.arange(len(used))
    light, edge = row[light], row[edge]
    sides = []
    for layer in range(len(_K_LEVELS) - 1):
        here, there = edge + layer * len(used), edge + (layer + 1) * len(used)
        one, two = (here[:, 0], here[:, 1]), (there[:, 0], there[:, 1])
        sides.append(np.stack([one[1], one[0], two[0]], axis=1))
        sides.append(np.stack([one[1], two[0], two[1]], axis=1))
    bottom = light[:, ::-1] + (len(_K_LEVELS) - 1) * len(used)
    return np.concatenate(layers), np.concatenate([light, *sides, bottom]).astype(np.int32)


def _dark_edge(values: FloatArray, light: IndexArray) -> LongArray:
    """Return the directed edges of the light sides that only one triangle has."""
    edges = np.concatenate([light[:, [0, 1]], light[:, [1, 2]], light[:, [2, 0]]]).astype(np.int64)
    keys = edges[:, 0] * len(values) + edges[:, 1]
    back = edges[:, 1] * len(values) + edges[:, 0]
    return edges[~np.isin(keys, back)]


def tetrahedra_volume(points: FloatArray, faces: IndexArray) -> float:
    """Return the sum of signed tetrahedra about the mean of the lightest and the darkest vertex."""
    middle = (points[points[:, 0].argmax()] + points[points[:, 0].argmin()]) / 2.0
    one, two, three = np.moveaxis(points[faces] - middle, 1, 0)
    return abs(float(np.einsum("ij,ij->", one, np.cross(two, three))) / 6.0)


class _Volume(NamedTuple):
    """A row of the table: which gamut, by which tables, the intent, and the volume."""

    kind: str
    tables: str
    intent: str
    volume: float


def _press_volumes(gamut: Gamut) -> tuple[list[_Volume], str, list[str]]:
    """Return the volumes of a printing process, what their vertices are, and remarks."""
    model = gamut.device_model if gamut.has_device_model else None
    chart = None if model is None else _press_chart(gamut.channels, inks=model.inks)
    intent = gamut.conditions.intent
    if model is None or chart is None:
        mesh = gamut.level(gamut.history.triangles)
        volume = tetrahedra_volume(np.asarray(mesh.vertices, np.float64), mesh.faces)
        return (
            [_Volume("device", "boundary", intent, volume)],
            f"{len(mesh.vertices):,} of the boundary",
            ["The device has no surface chart of the standard; its boundary is used."],
        )
    device, faces = chart
    vertices = f"{len(np.unique(faces)):,} colours of a surface chart, {len(faces):,} triangles"
    if not isinstance(model.function, ProfileTransform) or gamut.profile is None:
        volumes = [_Volume("device", "", intent, tetrahedra_volume(model.lab(device), faces))]
        if _facts(gamut).get("format") != "icc":
            return volumes, vertices, ["Usable volume: none, as there are no tables B2A."]
        remark = "Usable volume: not known, as the saved gamut has no tables B2A; give the profile."
        return volumes, vertices, [remark]
    profile = icc_profile(gamut.profile)

    def volume_of(values: FloatArray, chosen: str) -> float:
        return tetrahedra_volume(profile_colours(profile, values, chosen).lab, faces)

    volumes, remarks = [], []
    tag = profile.transform("relative")[0].tag
    for chosen in ("absolute", "relative"):
        volumes.append(_Volume("device", tag, chosen, volume_of(device, chosen)))
    for printed_by in ("relative", "perceptual", "saturation"):
        try:
            separation = profile.separation(printed_by)
            values = printed_values(profile, device, printed_by)
        except UnsupportedProfileError as error:
            remarks.append(f"Usable volume, {printed_by}: {error.message}")
            continue
        name = "none" if separation is None else separation.tag
        if any(name in row.tables.split(" ") for row in volumes):
            continue  # a table that stands for that of another intent
        for chosen in ("absolute", "relative"):
            row = _Volume("usable", f"{name} {tag}", chosen, volume_of(values, chosen))
            volumes.append(row)
    return volumes, vertices, remarks


def _press_parts(gamut: Gamut, reference: Gamut | None) -> _Parts:
    volumes, vertices, remarks = _press_volumes(gamut)
    device = volumes[0]
    usable = next((row for row in volumes if row.kind == "usable"), None)
    name = gamut.name or "the gamut"
    sentences = [
        f"{name}: the device volume is {device.volume:,.0f} in CIELAB (ΔE*ab³), {device.intent}."
    ]
    if usable is not None:
        sentences.append(
            f"The usable volume through {usable.tables.split(' ')[0]} is {usable.volume:,.0f}, "
            f"{_per_cent(usable.volume / device.volume - 1.0, signed=True)}."
        )
    sentences.append(
        f"The volume of the whole boundary, {gamut.conditions.intent}, is {gamut.volume:,.0f}."
    )
    first = {row.intent: row.volume for row in reversed(volumes) if row.kind == "device"}
    table = ReportTable(
        "Volumes",
        [
            ReportColumn("gamut", [row.kind for row in volumes]),
            ReportColumn("tables", [row.tables for row in volumes]),
            ReportColumn("intent", [row.intent for row in volumes]),
            ReportColumn("volume", [row.volume for row in volumes], decimals=1),
            ReportColumn(
                "share of device",
                [row.volume / first[row.intent] for row in volumes],
                kind="share",
                decimals=3,
            ),
        ],
        ["Usable: device values to colours, to device values by B2A, to colours by A2B1."],
    )
    data: dict[str, Any] = {
        "device_volume": device.volume,
        "usable_volume": None if usable is None else usable.volume,
    }
    warnings = []
    if device.intent != "absolute":
        warnings.append("The standard asks for absolute colours, which this gamut does not have.")
    limit = gamut.conditions.ink_limit
    if limit is not None and "K" in gamut.channels:
        remarks.append(f"The chart has up to 300 % of ink; the limit is {limit:g} %.")
    if reference is not None:
        others, _, _ = _press_volumes(reference)
        data["reference_volume"] = others[0].volume
        sentences.append(
            f"It is {_per_cent(device.volume / others[0].volume)} of the device volume of "
            f"{reference.name or 'the reference'}, {others[0].volume:,.0f}, {others[0].intent}."
        )
    conditions = {"Vertices": vertices}
    if remarks:
        conditions["Remarks"] = " ".join(remarks)
    return _Parts(sentences, conditions, [table], warnings, (), data)


# --- comparison ----------------------------------------------------------------------------------


def _comparison_parts(gamut: Gamut, reference: Gamut | None) -> _Parts:
    assert reference is not None  # noqa: S101  # checked by `report`
    found = gamut.compare(reference, sectors=1)
    one, two, both = found.volume_a, found.volume_b, found.intersection
    name, other = gamut.name or "the gamut", reference.name or "the reference"
    rows = {
        "Vi/Vx": both / one,
        "Vi/Vy": both / two,
        "(Vx - Vi)/Vx": (one - both) / one,
        "Vx/Vy": one / two,
        "GCI": float(np.sqrt(both / one * both / two)),
    }
    meanings = (
        "share of the gamut that the reference has",
        "share of the reference that the gamut covers",
        "share of the gamut outside of the reference",
        "ratio of the volumes",
        "gamut comparison index, √(Vi/Vx · Vi/Vy)",
    )
    volumes = {"Vx": one, "Vy": two, "Vi": both}
    return _Parts(
        [
            f"The gamut comparison index of {name} (x) and {other} (y) is {rows['GCI']:.3f}.",
            f"{name} covers {_per_cent(both / two)} of {other}.",
            f"{_per_cent(1.0 - both / one)} of {name} is outside of it.",
        ],
        {"Triangles": " and ".join(f"{count:,}" for count in found.triangles)},
        [
            ReportTable(
                "Figures",
                [
                    ReportColumn("figure", list(rows)),
                    ReportColumn("value", list(rows.values()), decimals=4),
                    ReportColumn("meaning", meanings),
                ],
            ),
            ReportTable(
                "Volumes",
                [
                    ReportColumn("volume", list(volumes)),
                    ReportColumn("ΔE*ab³", list(volumes.values()), decimals=0),
                    ReportColumn("of", [name, other, "intersection"]),
                ],
            ),
        ],
        (),  # those about two gamuts are added with their names
        (),
        {**rows, **volumes},
    )


_RING_METHOD = (
    "Gamut rings: triangles in CIELAB between 602 signals (11 levels a channel), signed crossings "
    "of rays at the middles of 100 steps of L* and 360 of hue; C*RSS = √(2ΣV/Δh). Emissive "
    "displays are adapted to D50 by linear Bradford."
)
_RING_UNCHECKED = _UNCHECKED.format(
    "the method follows the public tools of its authors. Tolerances of the measurement, and the "
    "state of the display, are"
)

STANDARDS: Mapping[str, Standard] = MappingProxyType(
    {
        each.slug: each
        for each in (
            Standard(
                "idms",
                "Gamut rings and volume",
                "IDMS 1.3, section 5.32 (ICDM, SID)",
                _RING_METHOD,
                "The state of the display and the conditions of the measurement.",
                _display_parts,
            ),
            Standard(
                "iec-62977",
                "Gamut volume and rings",
                "IEC 62977-3-5:2023",
                _RING_METHOD,
                _RING_UNCHECKED,
                _display_parts,
            ),
            Standard(
                "iso-18621-11",
                "Volume of a printing process",
                "ISO/TS 18621-11:2022",
                "Signed tetrahedra about the mean of the lightest and the darkest vertex. Device "
                "volume: A2B at the colours of a surface chart. Usable volume: the same through "
                "B2A.",
                _UNCHECKED.format("the list of its 382 faces, and its tolerances, are"),
                _press_parts,
            ),
            Standard(
                "cie-246",
                "Comparison of two gamuts",
                "CIE 246:2021",
                "Volumes of two surfaces and of their exact intersection in CIELAB, D50.",
                _UNCHECKED.format(
                    "the formulas are those of slides of its author. The square root in GCI, and "
                    "the gamut boundary descriptor, are"
                ),
                _comparison_parts,
                needs_reference=True,
            ),
        )
    }
)
"""The standards by slug."""
