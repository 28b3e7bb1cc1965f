"""The class `Gamut`: everything that is known about a gamut, and everything that can be asked.

A gamut is its history, and a description of the input, the options and the result. It is stored as
its history file, with the description in the file's metadata. `gamutcore.building` has the stages
of a build.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, cast

from gamutcore.answers.base import INDEX_BYTES, IndexedLevels
from gamutcore.answers.comparisons import ComparisonAnswers
from gamutcore.answers.drawing import DrawingAnswers
from gamutcore.answers.mapping import MappingAnswers
from gamutcore.answers.points import PointAnswers
from gamutcore.building import build, report_progress
from gamutcore.colours import SPACE_PARAMETERS
from gamutcore.colours.spaces import ColourSpace
from gamutcore.content import content_of, gamut_source, is_saved_gamut
from gamutcore.errors import HistoryFileError, OptionError
from gamutcore.export import mesh_file
from gamutcore.export.provenance import mesh_provenance
from gamutcore.export.viewer_page import HTML_SUFFIXES, viewer_page
from gamutcore.history import History, history_bytes, history_from_bytes, history_metadata
from gamutcore.level_mesh import LevelMesh
from gamutcore.levels import LevelRequest, LevelSearch, Side, sided_level
from gamutcore.limits import Limits
from gamutcore.options import Options

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.geometry import TriangleMesh
    from gamutcore.references import Reference

__all__ = ["Gamut", "read_description"]

DESCRIPTION = "gamut"
"""Key of the description in a history file's metadata."""

COLOURED_TRIANGLES = 4000
"""Triangles of the level from which the viewer takes colours, in spaces that it cannot convert."""


class Gamut(PointAnswers, MappingAnswers, DrawingAnswers, ComparisonAnswers):
    """The gamut of a device, a picture or a set of colours.

    Parameters
    ----------
    data : path, bytes, array, table, mesh or profile
        The path or the content of a file in any format that `gamutcore.characterisation`
        recognises; an (n, 3) array of L*, a*, b*; a table of named columns, such as a pandas
        DataFrame; a mesh with `vertices` and `faces`, such as a `trimesh.Trimesh`, in the space of
        the options; or an ICC profile that Pillow has opened.
    options : Options or mapping, optional
        How the gamut is built; the defaults unless given.
    progress : bool or callable, optional
        True shows a bar if tqdm is installed. A callable gets a stage of
        `gamutcore.building.STAGES` and the completed fraction of it, 0 when it begins. During
        the decimation, it is called from another thread.
    limits : Limits, optional
        Largest accepted amount of data.
    **choices
        Options by name, such as ``ink_limit=300``.

    Attributes
    ----------
    description : dict
        JSON-able: id, options, provenance, counts, volume, area, centre, bounds, levels.
    history : History
        All levels.
    search : LevelSearch
        The search for levels within limits, which keeps what it has found.
    levels : IndexedLevels
        The levels that queries have used, with the bound of their memory.

    Raises
    ------
    GamutError
        The data cannot be read, an option is not accepted, or no valid boundary can be wrapped
        around the colours.
    TypeError
        `data` has none of these forms, or `options` are no options.
    OSError
        The file cannot be read.

    Notes
    -----
    Colours in arguments are arrays (..., 3) in the space of the gamut, unless `space` names another
    one: any value of the option `space`, ``LCHab`` or ``sRGB`` (0 to 1). See
    `gamutcore.colours.spaces`. Queries are answered on a level: that of `triangles`, the
    smallest within `max_error`, or by default the smallest within 0.1 % of the lightness of white,
    0.1 in CIELAB. ``max_error=0`` is the full boundary.

    Examples
    --------
    >>> press = Gamut("examples/FOGRA39L.ti3", surface_samples=1000, ink_limit=300)
    >>> press.contains([(50, 0, 0), (50, 100, 0)]).tolist()
    [True, False]
    """

    def __init__(
        self,
        data: object,
        options: Options | Mapping[str, object] | None = None,
        *,
        progress: bool | Callable[[str, float], None] = False,
        limits: Limits = Limits(),  # noqa: B008 - frozen
        **choices: Any,  # noqa: ANN401  # checked by Options
    ) -> None:
        chosen, content = _chosen_options(options, choices), content_of(data)
        with report_progress(progress) as report:
            description, history = build(content, chosen, report, limits)
        self._hold(description, history)

    def _hold(
        self,
        description: dict[str, Any],
        history: History,
        search: LevelSearch | None = None,
        index_bytes: int = INDEX_BYTES,
    ) -> None:
        self.description, self.history = description, history
        self.search = LevelSearch(description["levels"]) if search is None else search
        self.levels = IndexedLevels(history, index_bytes)

    @property
    def id(self) -> str:
        """The gamut's id, 64 hexadecimal digits."""
        return str(self.description["id"])

    @property
    def options(self) -> Options:
        """The options of the build."""
        return Options.from_mapping(self.description["options"])

    @cached_property
    def colour_space(self) -> ColourSpace:
        """The colour space of the coordinates."""
        return _colour_space(self.description)

    @property
    def volume(self) -> float:
        """Volume of the full boundary, in cubic units of the space."""
        return float(self.description["volume"])

    @property
    def nbytes(self) -> int:
        """Memory of the history and of the levels that queries have used, in bytes."""
        return self.history.nbytes + self.levels.nbytes

    def _same_space(self, other: Self | str | os.PathLike[str]) -> Self:
        if not isinstance(other, type(self)):
            other = self._opened(cast("str | os.PathLike[str]", other))
        self._check_space(other)
        return other

    def _opened(self, given: str | os.PathLike[str]) -> Self:
        """Return the gamut of a name or a file; unless it is saved, built in this one's space."""
        found = gamut_source(given)
        if isinstance(found, bytes) and is_saved_gamut(found):
            return self.from_bytes(found)
        chosen = self.options.to_mapping()
        names = {"space", *SPACE_PARAMETERS} & chosen.keys()
        if not isinstance(found, bytes) and found.peak is not None:
            names -= {"luminance"}  # its luminances are known
        options = Options.from_mapping({name: chosen[name] for name in names})
        if isinstance(found, bytes):
            return type(self)(found, options)
        return cast("Self", _reference(type(self), found, options))

    def __repr__(self) -> str:
        space, volume = self.colour_space.name, self.volume
        device = self.description.get("provenance", {}).get("channels")
        of = f" of {' '.join(map(str, device))}" if device else ""
        return (
            f"<Gamut {self.id[:12]}{of} in {space}: volume {volume:.4g}, "
            f"{self.history.triangles} triangles>"
        )

    def level(self, triangles: int, *, side: Side = "both") -> TriangleMesh:
        """Return the level of a triangle count, with the device values of its vertices if known.

        Parameters
        ----------
        triangles : int
            Largest number of triangles, as for `History.level`.
        side : {'both', 'inside', 'outside'}, optional
            `inside`: the level is contained in the full boundary. `outside`: it contains the full
            boundary. See `gamutcore.levels`.

        Returns
        -------
        TriangleMesh
            Its `device` is None if the gamut was built from bare colours. Device values on one side
            are those of the vertices of the level, before they were moved.

        Raises
        ------
        TriangleCountError
            There is no such level.
        HistoryFileError
            The part of the file that the level needs is damaged.

        Notes
        -----
        The time is proportional to the size of the level. For one side, it is proportional to the
        size of the full boundary: about 0.15 s for 1,000 of 130,000 triangles.
        """
        mesh = sided_level(self.history, triangles, side)
        return replace(mesh, device=self.history.device_values(mesh.triangles))

    def mesh(
        self,
        triangles: int | None = None,
        *,
        max_error: float | None = None,
        max_mismatch: float | None = None,
        side: Side = "both",
    ) -> LevelMesh:
        """Return a level as a mesh that can be saved.

        Parameters
        ----------
        triangles : int, optional
            Largest number of triangles; 1000 unless a limit is given.
        max_error : float, optional
            Largest distance from the full boundary, in both directions, in units of the space. 0
            gives the full boundary.
        max_mismatch : float, optional
            Largest volume of the symmetric difference ÷ volume of the full boundary.
        side : {'both', 'inside', 'outside'}, optional
            As for `level`.

        Returns
        -------
        LevelMesh

        Raises
        ------
        TriangleCountError
            There is no such level.
        OptionError
            A count and a limit are given, or a limit is not a number of at least 0.

        Examples
        --------
        >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
        >>> Gamut(colours).mesh(4).triangles
        4
        """
        request = LevelRequest(triangles, max_error, max_mismatch, side)
        count, bounds = self.search.find(self.history, request)
        mesh = self.level(count, side=side)
        return LevelMesh(
            mesh.vertices,
            mesh.faces,
            mesh.device,
            space=self.colour_space,
            max_error=None if bounds.distance == inf else bounds.distance,
            provenance=mesh_provenance(self.description),
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the gamut to a file, which `load` reads, or to a page for browsers.

        Parameters
        ----------
        path : path
            Usually with the suffix ``.gamut``. With ``.html``, the file is that of `to_html` under
            the name of the file, which `load` does not read.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        path = Path(path)
        is_page = path.suffix.lower() in HTML_SUFFIXES
        path.write_bytes(self.to_html(path.stem) if is_page else self.to_bytes())

    def to_html(self, name: str) -> bytes:
        """Return the gamut as an HTML file that shows every level in a browser, without a network.

        Parameters
        ----------
        name : str
            By which the page calls the gamut.

        Returns
        -------
        bytes
            UTF-8: the viewer and the history. 1.6 MB for a press.
        """
        coloured = None
        if self.colour_space.name != "CIELAB":
            level = self.history.level(min(COLOURED_TRIANGLES, self.history.triangles))
            coloured = mesh_file(level, "ply", space=self.colour_space)
        return viewer_page(self.description, self.to_bytes(), name, coloured)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Return the gamut that `save` wrote to a file.

        Parameters
        ----------
        path : path

        Returns
        -------
        Gamut

        Raises
        ------
        HistoryFileError
            As for `from_bytes`.
        OSError
            The file cannot be read.
        """
        return cls.from_bytes(Path(path).read_bytes())

    def to_bytes(self) -> bytes:
        """Return the gamut as a history file with the description in its metadata."""
        text = json.dumps(self.description, separators=(",", ":"), allow_nan=False)
        return history_bytes(self.history, {DESCRIPTION: text})

    @classmethod
    def from_bytes(
        cls, data: bytes, *, search: LevelSearch | None = None, index_bytes: int = INDEX_BYTES
    ) -> Self:
        """Return the gamut of a file. Its levels are unpacked when they are first asked for.

        Parameters
        ----------
        data : bytes
        search : LevelSearch, optional
            That of an earlier object of the same gamut, with what it has found.
        index_bytes : int, optional
            Bytes for the levels that queries have used.

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
        gamut = cls.__new__(cls)
        gamut._hold(_description(metadata), history, search, index_bytes)  # noqa: SLF001  # a constructor
        return gamut


@lru_cache(maxsize=8)  # many gamuts are compared with a few references, of 2 MB each
def _reference(kind: type[Gamut], found: Reference, options: Options) -> Gamut:
    return kind(found.data, options)


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


def _chosen_options(given: object, choices: Mapping[str, object]) -> Options:
    """Return options from both ways of giving them; the choices by name come second."""
    if given is None:
        given = {}
    if isinstance(given, Options):
        if not choices:
            return given
        given = given.to_mapping()
    if isinstance(given, Mapping):
        return Options.from_mapping({**given, **choices})
    raise TypeError(
        f"The options are of the type {type(given).__name__}. Give gamutcore.Options(...), a "
        "mapping of option names to values, or nothing for the defaults."
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
            "The history file has no description of a gamut.",
            where={"field": DESCRIPTION},
            remedy="Give a file that Gamut.to_bytes wrote.",
        ) from cause
    return description
