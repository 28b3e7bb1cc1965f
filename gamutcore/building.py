"""The stages of a build: from the bytes of characterisation data to a history and a description.

`build` takes the data through all stages: colours, boundary, decimation, history and errors. The
class `gamutcore.Gamut` calls it.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from gamutcore.boundary import (
    mesh_boundary,
    mesh_vertices,
    raise_wrapping,
    vertex_device_values,
    wrap_colours,
)
from gamutcore.characterisation import (
    Characterisation,
    GamutMesh,
    IccProfile,
    Picture,
    Samples,
    embedded_boundary,
    embedded_measurements,
    read_characterisation,
    stated_ink_limit,
)
from gamutcore.colours import (
    DEFAULT_LUMINANCE,
    MEASURED,
    InkLimits,
    SurfaceFaces,
    check_dimensions,
    check_mesh_space,
    colours_in_space,
    declared_space,
    display_primaries,
    fold_sheets,
    lacks_black,
    medium_white_lab,
    naming_remedy,
    own_tristimulus,
    spread_values,
    surface_colours,
    values_beside,
    volume_description,
)
from gamutcore.colours.device_model import Fit
from gamutcore.colours.spaces import ColourSpace
from gamutcore.decimation import decimate
from gamutcore.errors import BoundaryError, FlatPointsError, OptionError, errors_in
from gamutcore.history import MINIMUM_TRIANGLES, build_history
from gamutcore.levels import curve_counts, error_curve, round_up
from gamutcore.limits import Limits, apply_limits
from gamutcore.number_text import number_text
from gamutcore.options import DATA_KINDS, OPTIONS, Options, option_name
from gamutcore.references import Reference
from gamutcore.search import (
    build_index,
    chromaticity_description,
    chromaticity_gamut,
    contains,
    nearest,
)
from gamutcore.version import ALGORITHM_VERSION, __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from gamutcore.arrays import FloatArray
    from gamutcore.boundary import Boundary, Wrapping
    from gamutcore.characterisation.samples import JSON
    from gamutcore.colours import AbsoluteColours, DeviceColours, DeviceModel, SurfaceColours
    from gamutcore.decimation import Decimation
    from gamutcore.geometry import DeviceValues, TriangleMesh
    from gamutcore.history import History
    from gamutcore.results import ChromaticityGamut

__all__ = [
    "STAGES",
    "build",
    "device_model",
    "fitting_options",
    "gamut_id",
    "parsed_input",
    "report_progress",
]

STAGES = ("characterisation", "colours", "boundary", "decimation", "metric")
"""Stages of a build, as they are reported to `progress`. The history belongs to `decimation`, and
``metric`` is the error curve."""

VOLUME_TOLERANCE = 1e-5
"""Largest relative volume error at which levels count as preserving the volume. The grids of very
thin gamuts, and of gamuts far from the origin, are too coarse for it."""


def gamut_id(options: Options, input_sha256: str) -> str:
    """Return the id of a gamut, the same everywhere for the same options and input.

    It is the SHA-256 of the algorithm's version, the canonical options and the input's digest, in
    64 hexadecimal digits.
    """
    question = f"gamut {ALGORITHM_VERSION}\n{options.canonical}\n{input_sha256}\n"
    return hashlib.sha256(question.encode()).hexdigest()


@contextlib.contextmanager
def report_progress(
    progress: bool | Callable[[str, float], None],
) -> Iterator[Callable[[str, float], None]]:
    """Provide the function that a build reports to, with `progress` as for `gamutcore.Gamut`.

    It takes a stage of `STAGES` and the completed fraction. Without tqdm, True shows nothing.
    """
    if callable(progress):
        yield progress
        return
    try:
        from tqdm.auto import tqdm  # noqa: PLC0415  # optional
    except ImportError:
        progress = False
    if not progress:
        yield lambda _stage, _fraction: None
        return
    form = "{desc:16} {percentage:3.0f} %|{bar}| {elapsed}"
    with tqdm(total=len(STAGES), bar_format=form, leave=False) as bar:

        def report(stage: str, fraction: float) -> None:
            bar.set_description_str(stage, refresh=False)
            bar.update(STAGES.index(stage) + fraction - bar.n)

        yield report


def build(
    content: bytes,
    options: Options,
    report: Callable[[str, float], None],
    limits: Limits,
) -> tuple[dict[str, Any], History, DeviceModel | None]:
    """Build the history of a gamut, describe it, and return the model of its device if it has one.

    The description is JSON-able: id, options, provenance, counts, volume, area, centre, bounds,
    levels and limits. The content is a file in any format of `gamutcore.characterisation`. `report`
    gets a stage of `STAGES` and its completed fraction, 0 when it begins; decimation reports from
    another thread. Data that cannot be read or wrapped raises GamutError.
    """
    report("characterisation", 0.0)
    parsed = parsed_input(content, options, limits)
    report("colours", 0.0)
    full = (
        _boundary_of_mesh(parsed, options)
        if isinstance(parsed, GamutMesh)
        else _boundary_of_colours(parsed, options, report)
    )
    boundary = full.boundary
    report("decimation", 0.0)
    decimation = decimate(
        boundary.mesh, boundary.centre, options.cost, progress=partial(report, "decimation")
    )
    history = build_history(decimation, full.values)
    report("metric", 0.0)
    counts = curve_counts(history.triangles)
    curve = error_curve(history, counts, progress=partial(report, "metric"))
    digest = hashlib.sha256(content).hexdigest()
    description: dict[str, Any] = {
        "id": gamut_id(options, digest),
        "options": {
            name: value
            for name, value in options.to_mapping().items()
            if not isinstance(parsed, GamutMesh) or options.applies(name, "mesh")
        },
        "provenance": {
            **full.provenance,
            "space": options.space,
            "input": {"sha256": digest, "bytes": len(content)},
            "algorithm": {"version": ALGORITHM_VERSION, "gamutcore": __version__},
        },
        "counts": {
            "triangles": history.triangles,
            "vertices": history.vertices,
            "minimum": MINIMUM_TRIANGLES,
            "constructed": int((boundary.sources < 0).sum()),
        },
        **volume_description(
            boundary.mesh,
            full.space,
            full.provenance.get("intent"),
            full.absolute,
            full.device_volume,
        ),
        **_volume_error(decimation, boundary.mesh),
        "grid_step": history.step,
        "boundary_error": full.boundary_error,
        "area": boundary.mesh.area,
        "centre": boundary.centre.tolist(),
        "bounds": boundary.mesh.bounds.tolist(),
        **(
            {}
            if full.chromaticity is None
            else {"chromaticity": chromaticity_description(full.chromaticity)}
        ),
        "levels": [level.to_mapping() for level in curve],
    }
    return description, history, full.model


def _volume_error(decimation: Decimation, full: TriangleMesh) -> dict[str, Any]:
    """Return the largest relative volume error of any level, for costs that preserve volume."""
    if decimation.volume_error is None:
        return {"volume_preserved": False}
    error = decimation.volume_error / full.volume
    return {
        "volume_preserved": error <= VOLUME_TOLERANCE,
        "volume_error": round_up(error),
    }


class _FullBoundary(NamedTuple):
    """A boundary in its space, with device values of its vertices and what describes it.

    `absolute` maps media-relative colours to absolute ones.
    """

    boundary: Boundary
    values: DeviceValues | None
    provenance: dict[str, Any]
    space: ColourSpace
    chromaticity: ChromaticityGamut | None
    device_volume: float | None = None
    boundary_error: float = 0.0
    absolute: AbsoluteColours | None = None
    model: DeviceModel | None = None


def parsed_input(content: bytes, options: Options, limits: Limits) -> Characterisation:
    """Return the characterisation data of a file, and check that the options apply to it."""
    with apply_limits(limits):
        parsed = _read_input(content, options)
    options.check_data(_data_kind(parsed))
    return parsed if options.inks is None else _rename_inks(parsed, options.inks)


def fitting_options(
    inputs: Iterable[tuple[object, bytes | None]], settings: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """Return the options of each of several inputs: those that apply to its data.

    An input has a name for errors, a path for example, and no content if it is built already. An
    option that applies to none of the inputs is refused.
    """
    Options.from_mapping(settings)  # refuses values
    settings = {option_name(name): value for name, value in settings.items()}
    unused, refusals = set(settings), dict[str, OptionError]()
    choices: list[dict[str, Any]] = []
    built: object = None
    for name, content in inputs:
        if content is None:
            built = name
            choices.append({})
            continue
        fitting = dict(settings)
        while any(len(OPTIONS[option].data) < len(DATA_KINDS) for option in fitting):
            try:
                with errors_in(name):
                    parsed_input(content, Options.from_mapping(fitting), Limits())
                break
            except OptionError as error:
                option = str(error.where.get("field"))
                if option not in fitting:
                    raise
                refusals.setdefault(option, error)
                del fitting[option]
        unused -= fitting.keys()
        choices.append(fitting)
    for option in settings:
        if option in refusals.keys() & unused:
            raise refusals[option]
        if option in unused and choices:
            why = f"{built} is a gamut that is built already"
            raise OptionError.not_applicable(option, settings[option], why)
    return choices


def _rename_inks(parsed: Characterisation, inks: str) -> Characterisation:
    """Return data with other names of its inks."""
    assert isinstance(parsed, Samples | IccProfile)  # noqa: S101  # of the option's kinds of data
    names, channels = tuple(inks.split(",")), parsed.channels
    if not parsed.inks:
        why = f"the channels {', '.join(channels)} are not inks"
        raise OptionError.not_applicable("inks", inks, why)
    if len(names) != len(channels) or len(set(map(str.lower, names))) < len(names) or "" in names:
        raise OptionError(
            f"The inks are named {inks[:80]}, and the device has {len(channels)} inks.",
            where={"field": "inks"},
            remedy=f"Give {len(channels)} different names. For one of two devices, name its inks "
            "in a gamut that is saved first (gamut build --inks).",
        )
    provenance: dict[str, JSON] = {**parsed.provenance, "channels": list(names)}
    named = replace(parsed, channels=names, provenance=provenance)
    if not named.inks:
        raise OptionError.not_applicable("inks", inks, "these are names of lights")
    return named


FEWEST_SAMPLES = 8
"""Points at the surface of a device whose model alone is wanted: the corners of RGB's cube."""


def device_model(
    content: bytes, options: Options, limits: Limits
) -> tuple[DeviceModel, tuple[str, ...]] | None:
    """Return the device model of the gamut that `build` makes of some content; None without one.

    Also return the warnings about the data.
    """
    parsed = parsed_input(content, options, limits)
    if isinstance(parsed, GamutMesh):
        return None
    colours = _input_colours(parsed, options, samples=FEWEST_SAMPLES)
    space = options.colour_space(colours.provenance.get("white_luminance"))
    device = colours_in_space(colours, space).device_colours
    if device is None:
        return None
    # the surface is sampled for the model only, so how coarsely does not matter
    warnings = [str(warning) for warning in _warnings(colours.provenance)]
    return device.model, tuple(warning for warning in warnings if "surface_samples" not in warning)


def _input_colours(
    parsed: Samples | IccProfile | Picture | Reference, options: Options, samples: int | None = None
) -> SurfaceColours:
    """Return the colours at the surface of a device, with its model, in CIELAB.

    `samples` replaces the option ``surface_samples``.
    """
    if isinstance(parsed, Samples):
        check_dimensions(parsed)
    limits, limit_warnings = ink_limits(parsed, options)
    colours = surface_colours(
        parsed,
        intent=options.intent,
        surface_samples=samples or options.surface_samples,
        limits=limits,
        observer=options.observer,
        illuminant=options.illuminant,
        adaptation=options.adaptation or "Bradford",
        popularity=options.popularity,
        model=options.device_model,
        usable=options.source == "usable",
    )
    warnings = [*_warnings(colours.provenance), *limit_warnings]
    if colours.device_colours is not None:
        device = colours.device_colours.model
        if lacks_black(device.channels, device.inks) and all(map(str.isdigit, device.channels)):
            warnings.append(
                "The inks have no names. Black is not known, and greys are made of all inks. "
                f"{naming_remedy(device)}"
            )
    return replace(colours, provenance={**colours.provenance, "warnings": warnings})


def _warnings(provenance: dict[str, JSON]) -> list[JSON]:
    return cast("list[JSON]", provenance["warnings"])


IN_PER_CENT = 50.0
"""Limits of the option below this get a warning: the user probably means a number of full inks."""

ONE_INK = 100.0
"""Limits that data states below this are not used: no press has them, so the unit is another."""


def ink_limits(data: Characterisation, options: Options) -> tuple[InkLimits, list[str]]:
    """Return the ink limits of a gamut and of all its device values, and warnings about them.

    The total is that of the options, else the one that the data states.
    """
    total = options.ink_limit
    if isinstance(total, str):
        return InkLimits(black=options.black_limit), []
    if total is not None:
        warning = (
            f"The ink limit is {total:g} % of one full ink. ink_limit is in per cent: 300 stands "
            "for three full inks."
        )
        return InkLimits(total, options.black_limit), [warning] * (total < IN_PER_CENT)
    stated = stated_ink_limit(data)
    if stated is None:
        return InkLimits(black=options.black_limit), []
    states = f"The data states an ink limit of {stated.total:g} % ({stated.source})"
    if stated.total < ONE_INK:
        warning = f"{states}, less than one full ink. It is not used; ink_limit gives another."
        return InkLimits(black=options.black_limit), [warning]
    warning = (
        f"{states}, which the gamut and all device values keep. ink_limit (--ink-limit) gives "
        "another one, or none."
    )
    return InkLimits(stated.total, options.black_limit, stated.source), [warning]


def _read_input(data: bytes, options: Options) -> Characterisation:
    """Read characterisation data, or the part of an ICC profile that `options.source` names."""
    if options.source == "measurements":
        return embedded_measurements(read_characterisation(data), condition=options.condition)
    parsed = read_characterisation(data, condition=options.condition, layer=options.layer)
    if options.source == "usable":
        _check_usable(parsed, options)
    return embedded_boundary(parsed, options.intent) if options.source == "boundary" else parsed


def _check_usable(parsed: Characterisation, options: Options) -> None:
    """Refuse data without B2A tables, and limits that these tables do not keep."""
    if not isinstance(parsed, IccProfile):
        raise OptionError(
            "source is 'usable', but the data is not an ICC profile.",
            where={"field": "source"},
            remedy="Leave it out: only profiles convert colours to device values.",
        )
    for name in ("ink_limit", "black_limit"):
        if getattr(options, name) is not None:
            reason = "the tables B2A of the usable gamut have their own limit"
            raise OptionError.not_applicable(name, getattr(options, name), reason)
    parsed.separation(options.intent)


def _data_kind(parsed: Characterisation) -> str:
    """Return the key of `DATA_KINDS` for parsed data."""
    if isinstance(parsed, Samples):
        return "colours" if parsed.device is None else "measurements"
    kinds = {IccProfile: "profile", Picture: "picture", GamutMesh: "mesh", Reference: "reference"}
    return kinds[type(parsed)]


LARGE_ERROR = 0.25
"""Boundary error from which a warning is given, where the white has a lightness of 100."""


def _boundary_of_colours(
    parsed: Samples | IccProfile | Picture | Reference,
    options: Options,
    report: Callable[[str, float], None],
) -> _FullBoundary:
    """Return the boundary around the colours of a device, a picture or a reference gamut."""
    colours = _input_colours(parsed, options)
    states_luminance = isinstance(parsed, Reference) and parsed.peak is not None
    if states_luminance and options.luminance not in {None, MEASURED, DEFAULT_LUMINANCE}:
        raise OptionError.not_applicable(
            "luminance", options.luminance, "the reference states its luminances in cd/m²"
        )
    space = options.colour_space(colours.provenance.get("white_luminance"))
    xyz, luminance = own_tristimulus(colours)
    chromaticity = chromaticity_gamut(xyz, luminance, display_primaries(colours))
    colours = colours_in_space(colours, space)
    report("boundary", 0.0)
    try:
        wrapping = wrap_colours(
            colours.points,
            colours.faces,
            options.boundary,
            options.centre,
            options.boundary_parameters,
        )
    except FlatPointsError as error:
        channels = colours.provenance.get("channels")
        if not isinstance(channels, list) or len(channels) != 1:
            raise
        raise FlatPointsError(
            f"The device has one channel, {str(channels[0])[:40]}: its colours lie on a line, "
            "which encloses no volume.",
            where={"field": "channels"},
            remedy="Send a device or a picture of three or more channels, such as RGB or CMYK.",
        ) from error
    colours, wrapping, missed = _add_folds(colours, wrapping, space.white_lightness)
    boundary, values = wrapping.boundary, None
    if colours.device is not None:
        own = colours.device_colours
        if own is not None and own.printed is not None:
            colours = replace(colours, device=own.printed(colours.device))
        assert colours.device is not None  # noqa: S101
        values = vertex_device_values(boundary, colours.points, colours.device, colours.channels)
    provenance = {**colours.provenance, "boundary": wrapping.choices}
    warnings = [*_warnings(colours.provenance), *wrapping.warnings]
    if colours.device_colours is not None and missed > LARGE_ERROR / 100.0 * space.white_lightness:
        warnings.append(
            f"Colours of the device, by its model or as measured, are up to "
            f"{number_text(missed, 3)} outside of the full boundary. The default tolerance counts "
            "them, and others as near, as in gamut."
        )
    provenance["warnings"] = warnings
    if colours.absolute is not None:
        provenance["white_lab"] = medium_white_lab(colours.absolute)
    return _FullBoundary(
        boundary,
        values,
        provenance,
        space,
        chromaticity,
        wrapping.device_volume,
        missed,
        colours.absolute,
        None if colours.device_colours is None else colours.device_colours.model,
    )


SPREAD_VALUES = 2**15
"""Number of device values inside the cube and on its faces at which `_farthest_values` begins."""

SEARCH_STARTS = 512
"""Number of device values around which the farthest colours are searched."""

SEARCH_TRIES = 4
"""Number of device values that are tried around each of them in a step of the search."""

SEARCH_STEPS = tuple(0.1 * 0.6**step for step in range(8))
"""Largest changes of the search, as shares of a channel's range."""

FOLDED = 0.05
"""Distance outside of the boundary from which a fold becomes part of it, where the white has a
lightness of 100. Surfaces without folds have errors of 0.001 to 0.03."""

FLAT_PIECES = 2.0
"""Multiple of the error of the flat pieces of the surface from which an error is that of a fold."""

FOLD = -1
"""Label of the triangles of folds, which belong to no patch of the surface."""

FOLD_ROUNDS = 2
"""Largest number of rounds in which folds are added. The first round leaves small ones."""


def _distance_outside(boundary: Boundary) -> Callable[[FloatArray], FloatArray]:
    """Return the function from points to their distance outside of a boundary, 0 inside."""
    index = build_index(boundary.mesh.vertices, boundary.mesh.faces, boundary.centre)

    def outside(points: FloatArray) -> FloatArray:
        distance, beyond = np.zeros(len(points)), ~contains(points, index)
        distance[beyond] = nearest(points[beyond], index).distance
        return distance

    return outside


def _add_folds(
    colours: SurfaceColours, wrapping: Wrapping, white_lightness: float
) -> tuple[SurfaceColours, Wrapping, float]:
    """Add the device's folds to its colours and boundary; return both, and the boundary error.

    A fold is a piece of the gamut's surface whose device values are inside the cube
    (`gamutcore.colours.folds`). The error counts the colours of the device model and the measured
    ones.
    """
    error, values = _farthest_values(colours, wrapping.boundary)
    device, threshold, triangles = colours.device_colours, FOLDED * white_lightness / 100.0, 0
    if device is not None and wrapping.choices["method"] == "device-surface":
        folds = _has_inner_samples(device) and error > max(
            threshold, FLAT_PIECES * _surface_error(device, wrapping.boundary)
        )
        for number in range(FOLD_ROUNDS if folds else 0):
            outside = _distance_outside(wrapping.boundary)
            known = values[outside(device.points(values)) > threshold]
            everywhere = None if number else threshold
            sheets = fold_sheets(device.cube, device.points, outside, everywhere, known)
            if sheets is None or colours.faces is None or colours.device is None:
                break
            faces, first = colours.faces, len(colours.points)
            faces = SurfaceFaces(
                np.concatenate([faces.corners, sheets.corners + np.int32(first)]),
                np.append(faces.labels, np.full(len(sheets.corners), FOLD, np.int32)),
                closed=False,
            )
            with_folds = replace(
                colours,
                points=np.concatenate([colours.points, sheets.points]),
                device=np.concatenate([colours.device, device.model.limited.device(sheets.values)]),
                faces=faces,
            )
            try:
                wrapping = raise_wrapping(wrapping, with_folds.points, faces)
            except BoundaryError:  # crumpled: spaces turn imaginary colours inside out
                break
            colours, triangles = with_folds, triangles + len(sheets.corners)
            error, values = _farthest_values(colours, wrapping.boundary)
            if error <= threshold:
                break
    if triangles:
        wrapping.choices["fold_triangles"] = triangles
    if device is not None:
        measured = _distance_outside(wrapping.boundary)(device.measured)
        error = max(error, round_up(float(measured.max(initial=0.0))))
    return colours, wrapping, error


def _has_inner_samples(device: DeviceColours) -> bool:
    """Whether samples inside the cube support the model. A fit to the faces alone extrapolates."""
    function = device.model.function
    if not isinstance(function, Fit):
        return True
    places = function.model.centres
    return bool(((places > places.min(axis=0)) & (places < places.max(axis=0))).all(axis=1).any())


def _surface_error(device: DeviceColours, boundary: Boundary) -> float:
    """Return how far colours between the points of the device's surface are outside of it."""
    values, cube = device.tried, device.cube
    at_end = np.isclose(values, cube.lowest) | np.isclose(values, cube.highest)
    free = values.shape[1] - at_end.sum(axis=1) - np.isclose(values.sum(axis=1), cube.limit)
    distance = _distance_outside(boundary)(device.points(values[free <= 2]))
    return float(distance.max(initial=0.0))


def _farthest_values(colours: SurfaceColours, boundary: Boundary) -> tuple[float, FloatArray]:
    """Return the largest distance by which colours of a device model are outside of its boundary.

    Colours are tried at the surface of the device's cube and inside of it. Around the farthest, a
    random search finds the local maxima; their device values (s, k) are returned as well.
    """
    outside = _distance_outside(boundary)
    error = float(outside(colours.points).max(initial=0.0))
    device = colours.device_colours
    if device is None:
        return round_up(error), np.empty((0, 0))
    values = device.tried
    if colours.faces is not None:
        values = np.concatenate([values, spread_values(device.cube, SPREAD_VALUES)])
    distance = outside(device.points(values))
    farthest = np.argsort(-distance, kind="stable")[:SEARCH_STARTS]
    values, distance = values[farthest], distance[farthest]
    random, rows = np.random.default_rng(0), np.arange(len(values))
    for step in SEARCH_STEPS:
        tried = values_beside(device.cube, np.repeat(values, SEARCH_TRIES, axis=0), step, random)
        trial_distances = outside(device.points(tried)).reshape(-1, SEARCH_TRIES)
        best = trial_distances.argmax(axis=1)
        better = trial_distances[rows, best] > distance
        values[better] = tried.reshape(len(rows), SEARCH_TRIES, -1)[rows, best][better]
        distance[better] = trial_distances[rows, best][better]
    return round_up(max(error, float(distance.max(initial=0.0)))), values


def _boundary_of_mesh(mesh: GamutMesh, options: Options) -> _FullBoundary:
    """Return a mesh as the boundary, after the checks of its colour space and its surface."""
    declared = declared_space(mesh.space_notes)
    space = options.colour_space(mesh.provenance.get("white_luminance"))
    vertices = mesh_vertices(mesh)
    assumption_warnings = check_mesh_space(vertices, declared, space)
    xyz = space.tristimulus(vertices)
    chromaticity = chromaticity_gamut(xyz, xyz[:, 1])
    boundary, provenance = mesh_boundary(mesh, options.centre)
    provenance["colour_space"] = {
        **space.description(),
        "from": "the option space (assumed, not stated)" if declared is None else "the file",
    }
    provenance["axes"] = " ".join(space.axes)
    warnings = provenance["warnings"]
    if isinstance(warnings, list):
        warnings.extend(assumption_warnings)
    values = None
    if mesh.device is not None:
        values = replace(mesh.device, values=mesh.device.values[boundary.sources])
    return _FullBoundary(boundary, values, provenance, space, chromaticity)
