"""The gamut: characterisation, options, history, and a description of everything that went in.

`build_gamut` is the whole path from the bytes of a file to a history; the other modules are its
stations. A gamut is stored as its history file, with the description in the file's metadata.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gamutcore.boundary import wrapped
from gamutcore.characterisation import Characterisation, characterisation, measurements_of
from gamutcore.colours import InkLimits, surface_colours
from gamutcore.decimation import decimated
from gamutcore.decimation.costs import cost_module
from gamutcore.errors import HistoryFileError, OptionError
from gamutcore.history import (
    MINIMUM_TRIANGLES,
    History,
    history_bytes,
    history_from_bytes,
    history_metadata,
    history_of,
)
from gamutcore.metric.error_curve import curve_counts, error_curve
from gamutcore.options import Options
from gamutcore.version import ALGORITHM_VERSION, __version__

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = ["STAGES", "Gamut", "Options", "build_gamut", "gamut_id", "read_description"]

STAGES = ("characterisation", "colours", "boundary", "decimation", "metric")
"""Stations of a build, as they are reported to `progress`."""

VOLUME_TOLERANCE = 1e-5
"""Part of the volume by which levels may differ that are said to preserve it. Very thin gamuts, and
those far from the origin, lie on grids that do not allow it."""

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
    def nbytes(self) -> int:
        """Memory held by the history, in bytes."""
        return self.history.nbytes

    def to_bytes(self) -> bytes:
        """Return the gamut as a history file with the description in its metadata."""
        text = json.dumps(self.description, separators=(",", ":"), allow_nan=False)
        return history_bytes(self.history, {DESCRIPTION: text})

    @classmethod
    def from_bytes(cls, data: bytes) -> Gamut:
        """Read a gamut from its file.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        Gamut

        Raises
        ------
        HistoryFileError
            If the file is damaged, or a history without a gamut's description.
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
    data: bytes, options: Options, *, progress: Callable[[str, float], None] | None = None
) -> Gamut:
    """Build a gamut from the bytes of a characterisation file.

    Parameters
    ----------
    data : bytes
        Any format that `gamutcore.characterisation` recognises.
    options : Options
    progress : callable, optional
        Called with a stage of `STAGES` and the part of it that is done, 0 when it begins.

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
    if options.source == "measurements":
        device: Characterisation = measurements_of(
            characterisation(data), condition=options.condition
        )
    else:
        device = characterisation(data, condition=options.condition)
    report("colours", 0.0)
    colours = surface_colours(
        device,
        intent=options.intent,
        surface_samples=options.surface_samples,
        limits=InkLimits(options.ink_limit, options.black_limit),
        observer=options.observer,
        illuminant=options.illuminant,
        popularity=options.popularity,
    )
    report("boundary", 0.0)
    boundary = wrapped(
        colours.points, options.boundary, options.centre, **options.boundary_parameters
    )
    report("decimation", 0.0)
    history = history_of(decimated(boundary.mesh, boundary.centre, options.cost))
    report("metric", 0.0)
    curve = error_curve(history, curve_counts(history.triangles))
    digest = hashlib.sha256(data).hexdigest()
    description: dict[str, Any] = {
        "id": gamut_id(options, digest),
        "options": options.to_mapping(),
        "provenance": {
            **colours.provenance,
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
        "volume_preserved": cost_module(options.cost).PRESERVES_VOLUME
        and all(
            abs(level.volume / boundary.mesh.volume - 1) <= VOLUME_TOLERANCE for level in curve
        ),
        "grid_step": history.step,
        "area": boundary.mesh.area,
        "centre": boundary.centre.tolist(),
        "bounds": boundary.mesh.bounds.tolist(),
        "levels": [level.to_mapping() for level in curve],
    }
    return Gamut(description, history)


def _description(metadata: dict[str, str]) -> dict[str, Any]:
    try:
        description = dict(json.loads(metadata[DESCRIPTION]))
        bytes.fromhex(description["id"])
        Options.from_mapping(description["options"])
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError, OptionError) as cause:
        raise HistoryFileError(
            "the history does not describe a gamut",
            where={"field": DESCRIPTION},
            remedy="a file written by Gamut.to_bytes",
        ) from cause
    return description
