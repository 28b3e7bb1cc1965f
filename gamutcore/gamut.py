"""The class `Gamut`: everything that is known about a gamut, and everything that can be asked.

A gamut is its history, and a description of the input, the options and the result. It is stored as
its history file, with the description in the file's metadata. `gamutcore.building` has the stages
of a build.
"""

from __future__ import annotations

import os
import threading
import warnings
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

from gamutcore import questions
from gamutcore.building import build, device_model, report_progress
from gamutcore.characterisation.icc import looks_like_icc
from gamutcore.colours import DeviceModel
from gamutcore.colours.spaces import ColourSpace
from gamutcore.content import content_of
from gamutcore.errors import DeviceModelError, HistoryFileError, OptionError, errors_in
from gamutcore.export.provenance import mesh_provenance
from gamutcore.export.viewer_page import HTML_SUFFIXES, PageGamut, viewer_page
from gamutcore.history import (
    MINIMUM_TRIANGLES,
    History,
    history_bytes,
    history_description,
    history_from_bytes,
    history_prefix,
    history_section,
)
from gamutcore.level_mesh import LevelMesh
from gamutcore.levels import LevelRequest, LevelSearch, Side, sided_level
from gamutcore.limits import Limits
from gamutcore.number_text import number_text
from gamutcore.options import Options
from gamutcore.pictures import map_picture_file
from gamutcore.questions import (
    DEFAULT_EDGE_WIDTH,
    DEFAULT_ERROR,
    INDEX_BYTES,
    IndexedLevels,
    build_warnings,
    check_space,
    colours_in,
    compared_conditions,
    comparison_warnings,
    conditions_of,
    other_gamut,
    tolerance_of,
)
from gamutcore.recipes import InverseModel
from gamutcore.references import stated_name
from gamutcore.results import VIEWER_HEIGHT, Intersection, ViewerPage

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from gamutcore.arrays import FloatArray
    from gamutcore.colour_rows import Colours
    from gamutcore.export.picture_file import Depth
    from gamutcore.geometry import TriangleMesh
    from gamutcore.pictures import MappedPicture
    from gamutcore.results import (
        ComparisonUncertainty,
        Conditions,
        VolumeUncertainty,
    )

__all__ = ["Gamut", "load_level", "read_description", "stored_level"]

DESCRIPTION = "gamut"
"""Key of the description in a history file's metadata."""

DEVICE_MODEL = "device_model"
"""Name of the array with the device model in a history file."""


class Gamut:
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
    name : str
        For titles and legends: that of the reference, of the characterisation data, of the profile,
        or of the file, else empty. May be set.

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
    **Questions.** Methods that ask the gamut have these parameters in common, and name only their
    own ones. They are declared in `gamutcore.questions`, as the service and the command line have
    them.

    `colours`
        Arrays (..., 3), or tables of named columns. Results have the same shape.
    `space`
        Space of the colours, and of those in the result; that of the gamut by default. Any value of
        the option `space`, ``LCHab`` or ``sRGB`` (0 to 1). See `gamutcore.colours.spaces`.
    `triangles`, `max_error`
        The level that answers: that of a count, or the smallest within an error; by default the
        smallest within 0.1 % of the lightness of white, 0.1 in CIELAB. ``max_error=0`` is the full
        boundary.
    `other`, `reference`, `source`
        Another gamut in the same colour space. The name of a reference or a file is built in it,
        with the default options otherwise, unless the file is a saved gamut.

    They raise `InvalidPointsError` if a row is not three finite numbers; ``where["row"]`` names it.
    `OptionError`: a parameter is not accepted, a count and a limit are given, the gamuts are in
    different spaces, or the space has no hue, as CIEXYZ. `TriangleCountError`: there is no such
    level.

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
        with report_progress(progress) as report, errors_in(data):
            description, history, model = build(content, chosen, report, limits)
        profile = content if model is not None and looks_like_icc(content) else None
        self._hold(description, history, model, profile=profile)
        if isinstance(data, str | os.PathLike):
            self.name = stated_name(description) or Path(data).stem

    def _hold(
        self,
        description: dict[str, Any],
        history: History,
        model: DeviceModel | bytes | None,
        search: LevelSearch | None = None,
        index_bytes: int = INDEX_BYTES,
        profile: bytes | None = None,
    ) -> None:
        self.description, self.history = description, history
        self.search = LevelSearch(description["levels"]) if search is None else search
        self.levels = IndexedLevels(history, index_bytes)
        self.name = stated_name(description)
        self._model = model
        self._profile = profile
        self._inverse: InverseModel | None = None
        self._lock = threading.Lock()

    @property
    def id(self) -> str:
        """The gamut's id, 64 hexadecimal digits."""
        return str(self.description["id"])

    @cached_property
    def options(self) -> Options:
        """The options of the build."""
        return Options.from_mapping(self.description["options"])

    @cached_property
    def colour_space(self) -> ColourSpace:
        """The colour space of the coordinates."""
        return _colour_space(self.description, self.options)

    @property
    def volume(self) -> float:
        """Volume of the full boundary, in cubic units of the space."""
        return float(self.description["volume"])

    @property
    def nbytes(self) -> int:
        """Memory of the history, the levels that queries have used, and recipes, in bytes."""
        tables = 0 if self._inverse is None else self._inverse.nbytes
        return self.history.nbytes + self.levels.nbytes + tables

    @cached_property
    def conditions(self) -> Conditions:
        """What the colours are relative to: intent, ink limits, white and space."""
        return conditions_of(self.description)

    @cached_property
    def default_error(self) -> float:
        """Error limit of the level that answers unless another one is asked for."""
        return DEFAULT_ERROR / 100.0 * self.colour_space.white_lightness

    @cached_property
    def default_edge_width(self) -> float:
        """Largest distance from the surface of a colour at the edge, unless another is given."""
        return DEFAULT_EDGE_WIDTH / 100.0 * self.colour_space.white_lightness

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the device's channels; empty if the gamut is of colours only."""
        return tuple(map(str, self.description.get("provenance", {}).get("channels") or ()))

    @property
    def is_of_device(self) -> bool:
        """Whether the gamut was built with a device model."""
        facts = self.description.get("provenance", {})
        model = facts.get("model", {}).get("name", "none")
        return "channels" in facts and not str(model).startswith("none")

    def no_device_model(self) -> DeviceModelError:
        """Return the error of a gamut without a device model."""
        if not self.is_of_device:
            kind = self.description.get("provenance", {}).get("format", "")
            return DeviceModelError(
                f"The gamut has no device model: its data, of the format {kind}, is colours only.",
                where={"field": "gamut"},
                remedy="Give measured samples with device values, an ICC profile or an RGB space.",
            )
        return DeviceModelError(
            "The file of the gamut does not have the device model.",
            where={"field": "gamut"},
            remedy="Build the gamut again from its data; Gamut.save keeps the model.",
        )

    @property
    def has_device_model(self) -> bool:
        """Whether there is a `device_model`."""
        return self._model is not None

    @property
    def device_model(self) -> DeviceModel:
        """The device model: device values to colours.

        Raises
        ------
        DeviceModelError
            The gamut is of colours, a picture or a mesh, or its file was saved without the model.
        """
        with self._lock:
            if isinstance(self._model, bytes):
                self._model = DeviceModel.from_bytes(self._model)
            if self._model is None:
                raise self.no_device_model()
            return self._model

    @property
    def inverse_model(self) -> InverseModel:
        """The inverse device model, whose tables are made when it is first asked for."""
        model = self.device_model
        with self._lock:
            if self._inverse is None:
                self._inverse = InverseModel(model)
            return self._inverse

    @property
    def has_inverse(self) -> bool:
        """Whether the tables of `inverse_model` are made."""
        return self._inverse is not None

    @property
    def profile(self) -> bytes | None:
        """The ICC profile that the gamut was built from; None for others, and from a file."""
        return self._profile

    def use_device_model(self, data: bytes, profile: bytes | None = None) -> None:
        """Take the device model of `DeviceModel.to_bytes`, for a gamut that was saved without.

        `profile` is the profile that the gamut was built from.
        """
        with self._lock:
            self._model, self._profile = data, profile

    def __repr__(self) -> str:
        space, volume = self.colour_space.name, self.volume
        of = f" of {' '.join(self.channels)}" if self.channels else ""
        return (
            f"<Gamut {self.id[:12]}{of} in {space}: volume {number_text(volume, 4)}, "
            f"{self.history.triangles} triangles>"
        )

    # --- questions about colours ------------------------------------------------------------------

    contains = questions.contains

    def tolerance(self, *, triangles: int | None = None, max_error: float | None = None) -> float:
        """Return the distance up to which a colour outside of a level counts as in gamut.

        Returns
        -------
        float
            In units of the gamut's space: the error bound of the level, the rounding of
            coordinates to the grid, and the largest distance by which the full boundary misses the
            device's own colours, ``description["boundary_error"]``. A colour that the device can
            make is not farther outside.

        Examples
        --------
        >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
        >>> 0 < Gamut(colours).tolerance() < 0.1
        True
        """
        return tolerance_of(self, triangles, max_error)

    def convert(self, colours: Colours, space: str) -> FloatArray:
        """Return colours of another space in the space of the gamut.

        Returns
        -------
        (..., 3) float64

        Examples
        --------
        >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
        >>> Gamut(colours).convert((50, 20, 90), "LCHab").round(3).tolist()
        [50.0, 0.0, 20.0]
        """
        rows, _ = colours_in(self, colours, space)
        return rows.in_shape(rows.points)

    distance = questions.distance

    classify = questions.classify

    nearest = questions.nearest

    map = questions.map_colours

    def map_picture(
        self,
        picture: str | os.PathLike[str] | bytes,
        output: str | os.PathLike[str],
        method: str = "clip-hue",
        *,
        focus: Colours | Literal["cusp"] | None = None,
        source: Self | str | os.PathLike[str] | None = None,
        black_point_compensation: bool | None = None,
        decode: str | None = None,
        iterations: int | None = None,
        depth: Depth | None = None,
        table: int | None = None,
        heat_map: str | os.PathLike[str] | None = None,
        to: str = "picture",
        black: str | float | ArrayLike | None = None,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> MappedPicture:
        """Map the colours of a picture file into the gamut, and write the result.

        Parameters
        ----------
        picture : path or bytes
            A file of gray or RGB. An embedded profile, or the encoding that the file declares,
            gives the colours, relative to its white; sRGB is assumed without one. Or a file of
            CMYK with an embedded profile, for a soft proof.
        output : path
            A .png, .tif, .exr or .jpg file. It has the encoding, the depth, the profile and the
            alpha of the picture, unless `to` or `depth` names others.
        depth : {"8", "16", "half", "float"}, optional
            Another depth: 8 or 16 bits, or floats of 16 or 32 bits. PNG has no floats, and TIFF no
            half floats, which become floats there by default. Integers of a picture in linear light
            are sRGB, with straight alpha.
        method, focus, source : optional
            As for `map`; a focal point is in CIELAB. In addition, ``"spatial"`` keeps the
            differences between neighbouring pixels, and their hues (Alsam & Farup 2012). Pixels in
            gamut may move towards the neutral axis. It needs the whole picture in memory.
        black_point_compensation : bool, optional
            As for `map`, from the black of the picture's profile or encoding. By default, it is
            applied if the colours of the gamut are relative to a white, and not by ``"sgck"``.
        decode : {"bt1886", "oetf", "pq", "hlg", "srgb"}, optional
            How values of a picture without a profile become light. By default, as displays do:
            pictures that declare BT.709, BT.601 or BT.2020 are decoded by ITU-R BT.1886, an
            exponent of 2.4, and not by the inverse of the curve of cameras (``"oetf"``).
        iterations : int, optional
            Of ``"spatial"``, 25 by default, at most 10,000. Without one, it is clipping. Details
            that are larger than some ten pixels need more.
        table : int, optional
            Map through a table of as many nodes along each channel, 5 to 129; 0 maps every colour
            exactly. By default 65 for pictures of more than 8 megapixels, else 0. The result states
            the error at 20,000 pixels.
        heat_map : path, optional
            A .png file with the colour difference of each pixel and its mapped colour: ΔE00 in
            steps of 0.05, rounded up, black where nothing changed.
        to : str, optional
            The encoding of the output: ``"picture"``, that of the picture, which is sRGB
            for CMYK; the slug of an RGB space such as ``"display-p3"``, with its profile, or in
            OpenEXR in linear light; or
            ``"device"``, values of the device of the gamut as TIFF with 8 or 16 bits, such as CMYK,
            with the profile that the gamut was built from. Ink limits are kept.
        black : str, float or (n, 2) array, optional
            As for `to_device`, of device values. Those of up to four channels with the rule medium
            go through a table of 33 nodes from 250,000 pixels on.
        triangles, max_error : optional
            The level; by default the full boundary.

        Returns
        -------
        MappedPicture
            Numbers of pixels and distinct colours, in all and out of gamut; differences; the error
            of the table; and pixels whose mapped colour the encoding cannot store.

        Raises
        ------
        GamutError
            The picture cannot be read, or is not gray, RGB or CMYK with a profile; the output
            cannot store it; or as for `map`.
        OSError
            A file cannot be read or written.

        Notes
        -----
        Rows are read, mapped and written in parts, by up to four threads. Beside the file, 24
        megapixels of 8 bits take 250 MB. Transparent pixels stay. Pixels in gamut keep their values
        exactly, except by ``"spatial"`` and ``"sgck"``, and where the black of the gamut is not
        that of the picture. Through a table, those next to the surface may move within
        the stated error, where the surface bulges into a cell whose corners are all outside.
        """
        other = None if source is None else other_gamut(self, source)
        with errors_in(picture):
            return map_picture_file(
                self,
                content_of(picture),
                output,
                method,
                focus=focus,
                source=other,
                black_point_compensation=black_point_compensation,
                decode=decode,
                iterations=iterations,
                depth=depth,
                table=table,
                heat_map=heat_map,
                to=to,
                black=black,
                triangles=triangles,
                max_error=max_error,
            )

    to_device = questions.recipes

    to_colour = questions.device_colours

    crossings = questions.crossings

    # --- questions about the shape ----------------------------------------------------------------

    cusps = questions.cusps

    max_chroma = questions.max_chroma

    slice = questions.section

    leaf = questions.leaf

    leaves = questions.leaves

    rings = questions.rings

    # --- questions about two gamuts ---------------------------------------------------------------

    compare = questions.compare

    chromaticity = questions.chromaticity

    # --- how sure -----------------------------------------------------------------------------

    def uncertainty(
        self,
        noise: float | None = None,
        repeats: Self | str | os.PathLike[str] | bytes | None = None,
        *,
        instrument: float = 0.0,
    ) -> VolumeUncertainty:
        """Return the 95 % interval of the volume of a measured device, with its parts.

        Parameters
        ----------
        noise : float, optional
            Noise of readings: root mean square ΔE*ab between one reading and the mean of many. By
            default, that of `repeats`, else that of the repeated patches of the data.
        repeats : Gamut, path or bytes, optional
            A second reading of the same chart.
        instrument : float, optional
            Error in ΔE*ab that all readings have in common, at 50 units from mid grey. It never
            averages out.

        Returns
        -------
        VolumeUncertainty
            With `volume`, `relative`, `patches_needed` and a `summary` in words.

        Raises
        ------
        DeviceModelError
            The gamut is not of measured patches.
        InvalidPointsError
            There are too few patches.

        Notes
        -----
        Monte Carlo through the device model, JCGM 101:2008, and models of halves of the patches. It
        takes seconds. ``docs/uncertainty.md`` explains the method.

        Examples
        --------
        >>> press = Gamut("examples/FOGRA39L.ti3", surface_samples=1000)
        >>> press.uncertainty(noise=0.3).noise_from  # doctest: +SKIP
        'given'
        """
        second: DeviceModel | None = None
        if isinstance(repeats, Gamut):
            second = repeats.device_model
        elif repeats is not None:
            with errors_in(repeats):
                made = device_model(content_of(repeats), self.options, Limits())
            if made is None:
                raise OptionError.not_applicable("repeats", "data", "it has no measured patches")
            second = made[0]
        return questions.uncertainty(self, noise, second, instrument)

    def compare_with_interval(
        self,
        other: Self | str | os.PathLike[str],
        *,
        noise: float | None = None,
        instrument: float = 0.0,
        same_instrument: bool = False,
    ) -> ComparisonUncertainty:
        """Return the 95 % intervals of a comparison of this gamut, A, with another one, B.

        Parameters
        ----------
        other : Gamut, str or path
            A gamut without measured patches, such as a reference, counts as exact.
        noise, instrument : float, optional
            As for `uncertainty`, of the data of both.
        same_instrument : bool, optional
            Whether one instrument has read both, so that its error is the same. It then cancels
            where the colours are alike.

        Returns
        -------
        ComparisonUncertainty
            With `larger`, `a_covers_b`, `b_covers_a`, `smallest_difference`, `patches_needed` and a
            `summary` in words.

        Raises
        ------
        DeviceModelError
            Neither gamut is of measured patches.
        InvalidPointsError
            There are too few patches.
        """
        return questions.compare_with_interval(
            self,
            other_gamut(self, other),
            noise=noise,
            instrument=instrument,
            same_instrument=same_instrument,
        )

    def coverage_of(self, other: Self | str | os.PathLike[str]) -> float:
        """Return the share of another gamut's volume that this gamut covers.

        Parameters
        ----------
        other : Gamut, str or path

        Returns
        -------
        float
            Volume of the intersection ÷ volume of the other gamut, from 0 to 1.

        Warns
        -----
        UserWarning
            The gamuts have different intents, whites or conditions of measurement.

        Examples
        --------
        >>> import numpy as np
        >>> cube = np.array([(l, a, b) for l in (-1, 1) for a in (-1, 1) for b in (-1, 1)])
        >>> Gamut(20 * cube + (50, 0, 0)).coverage_of(Gamut(10 * cube + (50, 0, 0)))
        1.0
        """
        other = other_gamut(self, other)
        for warning in comparison_warnings(self.conditions, other.conditions):
            warnings.warn(warning, stacklevel=2)
        return self.compare(other, sectors=1).a_covers_b

    def warnings_about(self, other: Gamut) -> tuple[str, ...]:
        """Return reasons why a comparison with another gamut may mislead, as `compare` does."""
        both = self.conditions, other.conditions
        return (*build_warnings(*both), *compared_conditions(*both))

    def __and__(self, other: object) -> Intersection:
        """Return the intersection with another gamut: its volume, and its shares of both.

        Examples
        --------
        >>> import numpy as np
        >>> cube = np.array([(l, a, b) for l in (-1, 1) for a in (-1, 1) for b in (-1, 1)])
        >>> common = Gamut(20 * cube + (50, 0, 0)) & Gamut(10 * cube + (50, 0, 0))
        >>> round(common.volume), round(common.of_first, 3)
        (8000, 0.125)
        """
        if not isinstance(other, type(self) | str | os.PathLike):
            return NotImplemented
        found = self.compare(other, sectors=1)
        return Intersection(
            found.intersection,
            found.b_covers_a,
            found.a_covers_b,
            found.jaccard,
            found.gamuts,
            found.warnings,
        )

    # --- pictures ---------------------------------------------------------------------------------

    _repr_html_ = questions.notebook_html

    picture = questions.picture

    plot = questions.plot

    plot_slice = questions.plot_slice

    plot_rings = questions.plot_rings

    # --- levels and files -------------------------------------------------------------------------

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
        content = self.to_html(path.stem) if is_page else self.to_bytes(device_model=True)
        path.write_bytes(content)

    def to_html(self, name: str | Sequence[str] = (), *others: Gamut) -> bytes:
        """Return an HTML file that shows every level in a browser, without a network.

        Parameters
        ----------
        name : str or sequence of str, optional
            By which the page calls the gamut, or this one and the others. By default, the names are
            those in the data.
        *others : Gamut
            Up to five gamuts to compare with.

        Returns
        -------
        bytes
            UTF-8: the viewer and the histories. 1.6 MB for a press.

        Raises
        ------
        OptionError
            There are more than five other gamuts, or they are in other spaces.
        """
        for other in others:
            check_space(self, other)
        gamuts, names = [self, *others], [name] if isinstance(name, str) else list(name)
        names += [each.name or f"Gamut {each.id[:12]}" for each in gamuts[len(names) :]]
        pages = [
            PageGamut(text, each.description, each.to_bytes())
            for text, each in zip(names, gamuts, strict=False)
        ]
        if not others:
            return viewer_page(pages)
        comparison = self.compare(others[0])
        stated = ("a_covers_b", "b_covers_a", "summary")
        return viewer_page(pages, {name: getattr(comparison, name) for name in stated})

    def show(
        self, *others: Self | str | os.PathLike[str], state: str = "", height: int = VIEWER_HEIGHT
    ) -> ViewerPage:
        """Show the gamut and others with the viewer in a notebook, without a network.

        Parameters
        ----------
        *others : Gamut, path or str
            Up to five gamuts to compare with, files, or names of references. What is no saved gamut
            is built in the space of this one.
        state : str, optional
            How the page begins: what stands behind the number sign of its address in the viewer of
            the service, such as ``"lightness=50&outside=on"``.
        height : int, optional
            Height of the frame in pixels of CSS.

        Returns
        -------
        ViewerPage
            Notebooks show it. `save` writes it to a file for browsers, and `html` has its bytes.

        Raises
        ------
        OptionError
            There are more than five other gamuts, or one is in another space.
        ReferenceNameError
            There is no reference of that name.

        Examples
        --------
        >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
        >>> Gamut(colours).show(state="lightness=50")
        <ViewerPage: height 520>
        """
        gamuts = [other_gamut(self, other) for other in others]
        return ViewerPage.restoring(self.to_html((), *gamuts), state, height)

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
        with errors_in(path):
            gamut = cls.from_bytes(Path(path).read_bytes())
        gamut.name = gamut.name or Path(path).stem
        return gamut

    def to_bytes(self, *, device_model: bool = False) -> bytes:
        """Return the gamut as a history file with the description in its header.

        Parameters
        ----------
        device_model : bool, optional
            Whether the file has the device model as well, if the gamut has one.
        """
        sections = {}
        if device_model and self.has_device_model:
            sections[DEVICE_MODEL] = self.device_model.to_bytes()
        return history_bytes(self.history, self.description, sections)

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
            group of splits is noticed when a level needs the group.
        """
        history, description = history_from_bytes(data)
        gamut = cls.__new__(cls)
        model = history_section(data, DEVICE_MODEL)
        gamut._hold(_description(description), history, model, search, index_bytes)  # noqa: SLF001  # a constructor
        return gamut


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
    return _description(history_description(path))


STORED_ERROR = 2.0
"""Error of a level of the stored curve ÷ `Gamut.default_error`. The curve has few levels: those of
a press have errors of about 0.4, 0.1 to 0.2 and 0 in CIELAB."""


def stored_level(
    description: dict[str, Any], triangles: int | None = None, max_error: float | None = None
) -> int:
    """Return the triangle count of the level that answers for many gamuts.

    It is the largest one up to `triangles`, or the smallest level of the stored error curve within
    `max_error`, by default `STORED_ERROR`. No levels are compared, so the beginning of a file will
    do.
    """
    curve = description["levels"]
    if triangles is None and max_error is None:
        options = Options.from_mapping(description["options"])
        white: float = _colour_space(description, options).white_lightness
        max_error = STORED_ERROR * DEFAULT_ERROR / 100.0 * white
    count = LevelSearch(curve).largest_count(LevelRequest(triangles, max_error))
    return max(min(count, int(curve[-1]["triangles"])), MINIMUM_TRIANGLES) // 2 * 2


def load_level(
    path: Path, triangles: int | None = None, max_error: float | None = None
) -> tuple[Gamut, int]:
    """Return a saved gamut for questions to its `stored_level`, and the count of this level.

    Only the beginning of the file is read, so there are neither finer levels nor the device model.
    """
    counts: list[int] = []

    def count_of(stored: dict[str, Any] | None) -> int:
        counts.append(stored_level(_description(stored), triangles, max_error))
        return counts[0]

    with errors_in(path):
        data = history_prefix(path, count_of)
        history, description = history_from_bytes(data, partial=True)
        gamut = Gamut.__new__(Gamut)
        gamut._hold(_description(description), history, None)  # noqa: SLF001  # a constructor
    return gamut, counts[0]


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


def _colour_space(description: dict[str, Any], options: Options) -> ColourSpace:
    return options.colour_space(description.get("provenance", {}).get("white_luminance"))


def _description(stored: dict[str, Any] | None) -> dict[str, Any]:
    try:
        description = dict(stored or {})
        bytes.fromhex(description["id"])
        _colour_space(description, Options.from_mapping(description["options"]))
        LevelSearch(description["levels"])
    except (
        LookupError,
        ValueError,
        TypeError,
        AttributeError,
        RecursionError,
        OptionError,
    ) as cause:
        raise HistoryFileError(
            "The history file has no description of a gamut.",
            where={"field": DESCRIPTION},
            remedy="Give a file that Gamut.to_bytes wrote.",
        ) from cause
    return description
