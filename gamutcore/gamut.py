"""The gamut: characterisation, options, history, and a description of everything that went in.

`build_gamut` is the whole path from the bytes of a file to a history; the other modules are its
stations. A gamut is stored as its history file, with the description in the file's metadata.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from gamutcore.boundary import given_boundary, vertex_device_values, wrapped
from gamutcore.characterisation import (
    Characterisation,
    GamutMesh,
    IccProfile,
    Picture,
    Samples,
    characterisation,
    described_boundary,
    measurements_of,
)
from gamutcore.colours import InkLimits, surface_colours
from gamutcore.colours.spaces import ColourSpace, colours_in_space
from gamutcore.colours.stated_space import (
    assumption_warnings,
    refuse_far_vertices,
    refuse_other_space,
    stated_space,
)
from gamutcore.decimation import decimate
from gamutcore.errors import FlatPointsError, HistoryFileError, OptionError
from gamutcore.history import (
    MINIMUM_TRIANGLES,
    History,
    history_bytes,
    history_from_bytes,
    history_metadata,
    history_of,
)
from gamutcore.limits import Limits, limited_to
from gamutcore.metric.error_curve import curve_counts, error_curve, rounded_up
from gamutcore.options import Options
from gamutcore.version import ALGORITHM_VERSION, __version__

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from gamutcore.boundary import Boundary
    from gamutcore.decimation import Decimation
    from gamutcore.device_values import DeviceValues
    from gamutcore.mesh import TriangleMesh

__all__ = ["STAGES", "Gamut", "Options", "build_gamut", "gamut_id", "read_description"]

STAGES = ("characterisation", "colours", "boundary", "decimation", "metric")
"""Stations of a build, as they are reported to `progress`."""

VOLUME_TOLERANCE = 1e-5
"""Part of the volume by which levels may differ that are said to preserve it. Very thin gamuts, and
those far from the origin, lie on grids that do not allow it."""

NOT_OF_MESHES = (
    "boundary",
    "gamma",
    "segments",
    "basis",
    "subdivisions",
    "surface_samples",
    "intent",
    "device_model",
    "ink_limit",
    "black_limit",
    "observer",
    "illuminant",
    "popularity",
)
"""Options that say how colours are found and wrapped. A mesh has its boundary already, so all but
their defaults are refused with it."""

DESCRIPTION = "gamut"
"""Key of the description in a history file's metadata."""


def gamut_id(options: Options, input_sha256: str) -> str:
    """Identity of a gamut: the same question has the same id everywhere.

    Parameters
    ----------
    options : Options
    input_sha256 : str
        SHA-256 of the input's bytes, 64 hexadecimal digits.

    Returns
    -------
    str
        SHA-256 over the algorithm's version, the canonical options and the input's digest, 64
        hexadecimal digits.
    """
    question = f"gamut {ALGORITHM_VERSION}\n{options.canonical}\n{input_sha256}\n"
    return hashlib.sha256(question.encode()).hexdigest()


@dataclass(frozen=True, eq=False)
class Gamut:
    """A built gamut.

    Attributes
    ----------
    description : dict
        JSON-able: id, options, provenance, counts, volume, area, centre, bounds, levels.
    history : History
    """

    description: dict[str, Any]
    history: History

    @property
    def id(self) -> str:
        """The gamut's id, 64 hexadecimal digits."""
        return str(self.description["id"])

    @property
    def options(self) -> Options:
        """The options that it was built with."""
        return Options.from_mapping(self.description["options"])

    @property
    def colour_space(self) -> ColourSpace:
        """The space that its coordinates are in."""
        return _colour_space(self.description)

    @property
    def nbytes(self) -> int:
        """Memory held by the history, in bytes."""
        return self.history.nbytes

    def level(self, triangles: int) -> TriangleMesh:
        """Return a level with the device values at its vertices, where the gamut has them.

        Parameters
        ----------
        triangles : int
            As for `History.level`.

        Returns
        -------
        TriangleMesh
            In time proportional to its size. Without `device` if the gamut is of bare colours.

        Raises
        ------
        TriangleCountError
            If there is no such level.
        HistoryFileError
            If what a file holds of it turns out to be damaged.
        """
        mesh = self.history.level(triangles)
        return replace(mesh, device=self.history.device_values(triangles))

    def to_bytes(self) -> bytes:
        """Return the gamut as a history file with the description in its metadata."""
        text = json.dumps(self.description, separators=(",", ":"), allow_nan=False)
        return history_bytes(self.history, {DESCRIPTION: text})

    @classmethod
    def from_bytes(cls, data: bytes) -> Gamut:
        """Read a gamut from its file, whose levels are unpacked as far as they are asked for.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        Gamut

        Raises
        ------
        HistoryFileError
            If the file is damaged, or a history without a gamut's description. Damage within a
            stream is noticed when a level that needs it is asked for.
        """
        history, metadata = history_from_bytes(data)
        return cls(_description(metadata), history)


def read_description(path: Path) -> dict[str, Any]:
    """Read the description of a gamut file without its history.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict

    Raises
    ------
    HistoryFileError
        If the file is not a gamut.
    OSError
        If it cannot be read.
    """
    return _description(history_metadata(path))


def build_gamut(
    data: bytes,
    options: Options,
    *,
    progress: Callable[[str, float], None] | None = None,
    limits: Limits = Limits(),  # noqa: B008 - frozen
) -> Gamut:
    """Build a gamut from the bytes of a characterisation file.

    Parameters
    ----------
    data : bytes
        Any format that `gamutcore.characterisation` recognises.
    options : Options
    progress : callable, optional
        Called with a stage of `STAGES` and the part of it that is done, 0 when it begins; during
        the decimation from another thread.
    limits : Limits, optional
        How much data is accepted.

    Returns
    -------
    Gamut

    Raises
    ------
    GamutError
        The data cannot be read, or no valid boundary can be wrapped around its colours.
    """
    report = progress or (lambda _stage, _fraction: None)
    report("characterisation", 0.0)
    with limited_to(limits):
        device = _characterised(data, options)
    report("colours", 0.0)
    boundary, values, provenance = (
        _given(device, options)
        if isinstance(device, GamutMesh)
        else _wrapped(device, options, report)
    )
    report("decimation", 0.0)
    decimation = decimate(
        boundary.mesh, boundary.centre, options.cost, progress=partial(report, "decimation")
    )
    history = history_of(decimation, values)
    report("metric", 0.0)
    curve = error_curve(
        history, curve_counts(history.triangles), progress=partial(report, "metric")
    )
    digest = hashlib.sha256(data).hexdigest()
    description: dict[str, Any] = {
        "id": gamut_id(options, digest),
        "options": {
            name: value
            for name, value in options.to_mapping().items()
            if not (isinstance(device, GamutMesh) and _is_of_colours(name, options))
        },
        "provenance": {
            **provenance,
            "space": options.space,
            "input": {"sha256": digest, "bytes": len(data)},
            "algorithm": {"version": ALGORITHM_VERSION, "gamutcore": __version__},
        },
        "counts": {
            "triangles": history.triangles,
            "vertices": history.vertices,
            "minimum": MINIMUM_TRIANGLES,
            "constructed": int((boundary.sources < 0).sum()),
        },
        "volume": boundary.mesh.volume,
        **_kept_volume(decimation, boundary.mesh),
        "grid_step": history.step,
        "area": boundary.mesh.area,
        "centre": boundary.centre.tolist(),
        "bounds": boundary.mesh.bounds.tolist(),
        "levels": [level.to_mapping() for level in curve],
    }
    return Gamut(description, history)


def _kept_volume(decimation: Decimation, full: TriangleMesh) -> dict[str, Any]:
    """Say which part of its volume any level differs by at most, where the cost keeps it."""
    if decimation.volume_error is None:
        return {"volume_preserved": False}
    error = decimation.volume_error / full.volume
    return {
        "volume_preserved": error <= VOLUME_TOLERANCE,
        "volume_error": rounded_up(error),
    }


class _Wrapping(NamedTuple):
    """A boundary, the device values of its vertices, if known, and all that went in."""

    boundary: Boundary
    values: DeviceValues | None
    provenance: dict[str, Any]


def _characterised(data: bytes, options: Options) -> Characterisation:
    """Return what a file says of the device, or what it carries of that."""
    if options.source == "measurements":
        return measurements_of(characterisation(data), condition=options.condition)
    if options.source == "boundary":
        return described_boundary(
            characterisation(data, condition=options.condition), options.intent
        )
    return characterisation(data, condition=options.condition)


def _wrapped(
    device: Samples | IccProfile | Picture, options: Options, report: Callable[[str, float], None]
) -> _Wrapping:
    _refuse_surface_samples(device, options)
    colours = surface_colours(
        device,
        intent=options.intent,
        surface_samples=options.surface_samples,
        limits=InkLimits(options.ink_limit, options.black_limit),
        observer=options.observer,
        illuminant=options.illuminant,
        adaptation=options.adaptation or "Bradford",
        popularity=options.popularity,
        model=options.device_model,
    )
    space = options.colour_space(colours.provenance.get("white_luminance"))
    colours = colours_in_space(colours, space)
    report("boundary", 0.0)
    try:
        boundary = wrapped(
            colours.points, options.boundary, options.centre, **options.boundary_parameters
        )
    except FlatPointsError as error:
        raise _explained(error, device) from error
    values = None
    if colours.device is not None:
        values = vertex_device_values(boundary, colours.points, colours.device, colours.channels)
    return _Wrapping(boundary, values, colours.provenance)


def _explained(error: FlatPointsError, device: Samples | IccProfile | Picture) -> FlatPointsError:
    """Return the error of flat points, with its reason where the device has one channel only."""
    channels = device.provenance.get("channels")
    if not isinstance(channels, list) or len(channels) != 1:
        return error
    return FlatPointsError(
        f"The device has one channel, {str(channels[0])[:40]}: its colours lie on a line, which "
        "encloses no volume.",
        where={"field": "channels"},
        remedy="Send a device or a picture of three or more channels, such as RGB or CMYK.",
    )


def _refuse_surface_samples(device: Samples | IccProfile | Picture, options: Options) -> None:
    """Refuse a number of samples where there is no model that could be sampled."""
    if isinstance(device, Picture):
        what = "a picture's colours"
    elif isinstance(device, Samples) and device.device is None:
        what = "colours without device values"
    else:
        return
    if options.surface_samples != Options().surface_samples:
        raise OptionError.not_applying(
            "surface_samples", options.surface_samples, f"{what} are all used"
        )


def _given(mesh: GamutMesh, options: Options) -> _Wrapping:
    _refuse_options_of_colours(options)
    stated = stated_space(mesh.space_notes)
    space = options.colour_space(mesh.provenance.get("white_luminance"))
    if stated is not None:
        refuse_other_space(stated, space)
    refuse_far_vertices(mesh.vertices, space)
    boundary, provenance = given_boundary(mesh, options.centre)
    provenance["colour_space"] = {
        **space.description(),
        "from": "the option space (assumed, not stated)" if stated is None else "the file",
    }
    provenance["axes"] = " ".join(space.axes)
    told = provenance["warnings"]
    if stated is None and isinstance(told, list):
        told.extend(assumption_warnings(mesh.vertices, space))
    values = None
    if mesh.device is not None:
        values = replace(mesh.device, values=mesh.device.values[boundary.sources])
    return _Wrapping(boundary, values, provenance)


def _is_of_colours(name: str, options: Options) -> bool:
    """Whether an option has no meaning for a mesh; the intent has one where it chose the tag."""
    return name in NOT_OF_MESHES and not (name == "intent" and options.source == "boundary")


def _refuse_options_of_colours(options: Options) -> None:
    """Refuse what only has a meaning where colours are sampled and wrapped."""
    default = Options()
    for name in NOT_OF_MESHES:
        value = getattr(options, name)
        if _is_of_colours(name, options) and value != getattr(default, name):
            raise OptionError.not_applying(
                name, value, "the data is a boundary already, and nothing is wrapped"
            )


def _colour_space(description: dict[str, Any]) -> ColourSpace:
    options = Options.from_mapping(description["options"])
    return options.colour_space(description.get("provenance", {}).get("white_luminance"))


def _description(metadata: dict[str, str]) -> dict[str, Any]:
    try:
        description = dict(json.loads(metadata[DESCRIPTION]))
        bytes.fromhex(description["id"])
        _colour_space(description)
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError, OptionError) as cause:
        raise HistoryFileError(
            "the history does not describe a gamut",
            where={"field": DESCRIPTION},
            remedy="a file written by Gamut.to_bytes",
        ) from cause
    return description
