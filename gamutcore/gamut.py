"""The gamut: its history, and a description of the input, the options and the result.

`build_gamut` takes characterisation data through all stages: colours, boundary, decimation, history
and error curve. A gamut is stored as its history file, with the description in the file's metadata.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.boundary import compute_boundary, mesh_boundary, vertex_device_values
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
from gamutcore.colours import InkLimits, colours_in_space, surface_colours
from gamutcore.colours.spaces import ColourSpace
from gamutcore.colours.spaces.declared import (
    assumption_warnings,
    declared_space,
    refuse_far_vertices,
    refuse_other_space,
)
from gamutcore.decimation import decimate
from gamutcore.errors import FlatPointsError, HistoryFileError, OptionError
from gamutcore.history import (
    MINIMUM_TRIANGLES,
    History,
    build_history,
    history_bytes,
    history_from_bytes,
    history_metadata,
)
from gamutcore.limits import Limits, apply_limits
from gamutcore.metric.error_curve import curve_counts, error_curve, round_up
from gamutcore.options import Options
from gamutcore.version import ALGORITHM_VERSION, __version__

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.boundary import Boundary
    from gamutcore.decimation import Decimation
    from gamutcore.mesh import DeviceValues, TriangleMesh

__all__ = ["STAGES", "Gamut", "Options", "build_gamut", "gamut_id", "read_description"]

STAGES = ("characterisation", "colours", "boundary", "decimation", "metric")
"""Stages of a build, as they are reported to `progress`."""

VOLUME_TOLERANCE = 1e-5
"""Largest relative volume error at which levels count as preserving the volume. The grids of very
thin gamuts, and of gamuts far from the origin, are too coarse for it."""

DESCRIPTION = "gamut"
"""Key of the description in a history file's metadata."""


def gamut_id(options: Options, input_sha256: str) -> str:
    """Return the id of a gamut. The same options and input give the same id everywhere.

    Parameters
    ----------
    options : Options
    input_sha256 : str
        SHA-256 of the input's bytes, 64 hexadecimal digits.

    Returns
    -------
    str
        SHA-256 of the algorithm's version, the canonical options and the input's digest, as 64
        hexadecimal digits.

    Examples
    --------
    >>> gamut_id(Options(), "0" * 64) == gamut_id(Options(gamma=0.2), "0" * 64)
    True
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
        """The options of the build."""
        return Options.from_mapping(self.description["options"])

    @property
    def colour_space(self) -> ColourSpace:
        """The colour space of the coordinates."""
        return _colour_space(self.description)

    @property
    def nbytes(self) -> int:
        """Memory of the history, in bytes."""
        return self.history.nbytes

    def level(self, triangles: int) -> TriangleMesh:
        """Return the level of a triangle count, with the device values of its vertices if known.

        Parameters
        ----------
        triangles : int
            Largest number of triangles, as for `History.level`.

        Returns
        -------
        TriangleMesh
            Its `device` is None if the gamut was built from bare colours.

        Raises
        ------
        TriangleCountError
            There is no such level.
        HistoryFileError
            The part of the file that the level needs is damaged.

        Notes
        -----
        The time is proportional to the size of the level.
        """
        mesh = self.history.level(triangles)
        return replace(mesh, device=self.history.device_values(triangles))

    def to_bytes(self) -> bytes:
        """Return the gamut as a history file with the description in its metadata."""
        text = json.dumps(self.description, separators=(",", ":"), allow_nan=False)
        return history_bytes(self.history, {DESCRIPTION: text})

    @classmethod
    def from_bytes(cls, data: bytes) -> Gamut:
        """Return the gamut of a file. Its levels are unpacked when they are first asked for.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        Gamut

        Raises
        ------
        HistoryFileError
            The file is damaged, or its history has no description of a gamut. Damage within a
            stream is noticed when a level needs the stream.
        """
        history, metadata = history_from_bytes(data)
        return cls(_description(metadata), history)


def read_description(path: Path) -> dict[str, Any]:
    """Return the description of a gamut file without reading the history.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict

    Raises
    ------
    HistoryFileError
        The file is not a gamut.
    OSError
        The file cannot be read.
    """
    return _description(history_metadata(path))


def build_gamut(
    data: bytes | str | os.PathLike[str],
    options: Options | Mapping[str, object] | None = None,
    *,
    progress: Callable[[str, float], None] | None = None,
    limits: Limits = Limits(),  # noqa: B008 - frozen
) -> Gamut:
    """Build a gamut from characterisation data.

    Parameters
    ----------
    data : bytes, str or path
        The content of a file in any format that `gamutcore.characterisation` recognises, or the
        path of such a file.
    options : Options or mapping, optional
        How the gamut is built; the defaults unless given.
    progress : callable, optional
        Called with a stage of `STAGES` and the completed fraction of it, 0 when it begins. During
        the decimation, it is called from another thread.
    limits : Limits, optional
        Largest accepted amount of data.

    Returns
    -------
    Gamut

    Raises
    ------
    GamutError
        The data cannot be read, or no valid boundary can be wrapped around its colours.
    TypeError
        `data` is neither bytes nor a path, or `options` are no options.
    OSError
        The file cannot be read.

    Examples
    --------
    >>> gamut = build_gamut("examples/FOGRA39L.ti3", {"surface_samples": 1000})
    >>> gamut.level(100).triangles
    100
    """
    content, settings = _content(data), _settings(options)
    report = progress or (lambda _stage, _fraction: None)
    report("characterisation", 0.0)
    with apply_limits(limits):
        device = _device(content, settings)
    settings.check_data(_data_kind(device))
    report("colours", 0.0)
    source = (
        _mesh_surface(device, settings)
        if isinstance(device, GamutMesh)
        else _device_surface(device, settings, report)
    )
    boundary = source.boundary
    report("decimation", 0.0)
    decimation = decimate(
        boundary.mesh, boundary.centre, settings.cost, progress=partial(report, "decimation")
    )
    history = build_history(decimation, source.values)
    report("metric", 0.0)
    curve = error_curve(
        history, curve_counts(history.triangles), progress=partial(report, "metric")
    )
    digest = hashlib.sha256(content).hexdigest()
    description: dict[str, Any] = {
        "id": gamut_id(settings, digest),
        "options": {
            name: value
            for name, value in settings.to_mapping().items()
            if not isinstance(device, GamutMesh) or settings.applies(name, "mesh")
        },
        "provenance": {
            **source.provenance,
            "space": settings.space,
            "input": {"sha256": digest, "bytes": len(content)},
            "algorithm": {"version": ALGORITHM_VERSION, "gamutcore": __version__},
        },
        "counts": {
            "triangles": history.triangles,
            "vertices": history.vertices,
            "minimum": MINIMUM_TRIANGLES,
            "constructed": int((boundary.sources < 0).sum()),
        },
        "volume": boundary.mesh.volume,
        **_volume_error(decimation, boundary.mesh),
        "grid_step": history.step,
        "area": boundary.mesh.area,
        "centre": boundary.centre.tolist(),
        "bounds": boundary.mesh.bounds.tolist(),
        "levels": [level.to_mapping() for level in curve],
    }
    return Gamut(description, history)


def _content(data: object) -> bytes:
    """Return the bytes of the input, from a file if a path is given."""
    if isinstance(data, bytes | bytearray | memoryview):
        return bytes(data)
    if isinstance(data, os.PathLike) or (isinstance(data, str) and "\n" not in data):
        return Path(data).read_bytes()
    if isinstance(data, str):
        raise TypeError(
            "The data is text of several lines. Give the bytes of a file, such as text.encode(), "
            "or the path of a file."
        )
    what = "an array" if isinstance(data, np.ndarray) else f"of the type {type(data).__name__}"
    raise TypeError(
        f"The data is {what}. Give the bytes or the path of a file. Save an (n, 3) array of "
        "colours with numpy.save, and give the path of the .npy file."
    )


def _settings(options: object) -> Options:
    if options is None:
        return Options()
    if isinstance(options, Options):
        return options
    if isinstance(options, Mapping):
        return Options.from_mapping(options)
    raise TypeError(
        f"The options are of the type {type(options).__name__}. Give gamutcore.gamut.Options(...), "
        "a mapping of option names to values, or nothing for the defaults."
    )


def _volume_error(decimation: Decimation, full: TriangleMesh) -> dict[str, Any]:
    """Return the largest relative volume error of any level, for costs that preserve volume."""
    if decimation.volume_error is None:
        return {"volume_preserved": False}
    error = decimation.volume_error / full.volume
    return {
        "volume_preserved": error <= VOLUME_TOLERANCE,
        "volume_error": round_up(error),
    }


class _Surface(NamedTuple):
    """A boundary, the device values of its vertices if known, and its provenance."""

    boundary: Boundary
    values: DeviceValues | None
    provenance: dict[str, Any]


def _device(data: bytes, options: Options) -> Characterisation:
    """Read characterisation data, or the part of an ICC profile that `options.source` names."""
    if options.source == "measurements":
        return measurements_of(characterisation(data), condition=options.condition)
    device = characterisation(data, condition=options.condition)
    return described_boundary(device, options.intent) if options.source == "boundary" else device


def _data_kind(device: Characterisation) -> str:
    """Return the key of `DATA_KINDS` for some data."""
    if isinstance(device, Samples):
        return "colours" if device.device is None else "measurements"
    kinds = {IccProfile: "profile", Picture: "picture", GamutMesh: "mesh"}
    return kinds[type(device)]


def _device_surface(
    device: Samples | IccProfile | Picture, options: Options, report: Callable[[str, float], None]
) -> _Surface:
    """Wrap a boundary around the colours of a device."""
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
        boundary = compute_boundary(
            colours.points, options.boundary, options.centre, **options.boundary_parameters
        )
    except FlatPointsError as error:
        raise _flat_colours(error, device) from error
    values = None
    if colours.device is not None:
        values = vertex_device_values(boundary, colours.points, colours.device, colours.channels)
    return _Surface(boundary, values, colours.provenance)


def _flat_colours(
    error: FlatPointsError, device: Samples | IccProfile | Picture
) -> FlatPointsError:
    """Return the error of flat points, with the reason if the device has a single channel."""
    channels = device.provenance.get("channels")
    if not isinstance(channels, list) or len(channels) != 1:
        return error
    return FlatPointsError(
        f"The device has one channel, {str(channels[0])[:40]}: its colours lie on a line, which "
        "encloses no volume.",
        where={"field": "channels"},
        remedy="Send a device or a picture of three or more channels, such as RGB or CMYK.",
    )


def _mesh_surface(mesh: GamutMesh, options: Options) -> _Surface:
    """Take a mesh as the boundary."""
    declared = declared_space(mesh.space_notes)
    space = options.colour_space(mesh.provenance.get("white_luminance"))
    if declared is not None:
        refuse_other_space(declared, space)
    refuse_far_vertices(mesh.vertices, space)
    boundary, provenance = mesh_boundary(mesh, options.centre)
    provenance["colour_space"] = {
        **space.description(),
        "from": "the option space (assumed, not stated)" if declared is None else "the file",
    }
    provenance["axes"] = " ".join(space.axes)
    warnings = provenance["warnings"]
    if declared is None and isinstance(warnings, list):
        warnings.extend(assumption_warnings(mesh.vertices, space))
    values = None
    if mesh.device is not None:
        values = replace(mesh.device, values=mesh.device.values[boundary.sources])
    return _Surface(boundary, values, provenance)


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
            "The history file has no description of a gamut.",
            where={"field": DESCRIPTION},
            remedy="Give a file that Gamut.to_bytes wrote.",
        ) from cause
    return description
