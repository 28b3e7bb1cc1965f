"""From device values of a source to device values of a destination, as a table.

The way is the same as for pictures: encoded values → colours → gamut mapping → encoded values. The
table holds this way at its nodes. Its error against the way itself is measured for each link.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from errno import ENOENT
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import numpy as np

from gamutcore.arguments import Choice, WholeNumber, check_option
from gamutcore.building import input_colours, parsed_input
from gamutcore.characterisation import GamutMesh
from gamutcore.colours import (
    LookupTable,
    RgbDevice,
    lab_to_xyz,
    luminance_of_black,
    rgb_device,
)
from gamutcore.content import gamut_source, is_saved_gamut
from gamutcore.errors import OptionError, ReferenceNameError
from gamutcore.export.picture_file import draft_of
from gamutcore.gamut import Gamut
from gamutcore.limits import Limits
from gamutcore.links.cube import DECIMALS, cube_file
from gamutcore.links.device_link import device_link_file
from gamutcore.options import OPTIONS, Options
from gamutcore.queries import delta_e_2000
from gamutcore.questions import METHOD, PICTURE_SPACE, comparison_warnings, map_points
from gamutcore.references import Reference, find_reference
from gamutcore.results import Shown
from gamutcore.version import __version__

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.colour_rows import Colours

__all__ = ["SIZE", "Link", "LinkErrors", "link"]

SIZE = Annotated[int, WholeNumber(2, 129)]
"""Nodes of a table along each channel. 129 take 300 MB; a ``.cube`` file may have 256."""

FORMAT = Annotated[str, Choice(("cube", "icc"))]
"""Formats of links."""

SUFFIXES = {".cube": "cube", ".icc": "icc", ".icm": "icc"}
"""Formats by the suffix of a file."""

INPUTS = 20_000
"""Random inputs at which the error is measured: the 99th percentile then lies between the 98.85th
and the 99.15th in 95 of 100 cases."""

EDGE_STEPS = 255
"""Parts of an edge of the source's cube where the error is measured as well; no usual number of
nodes has the same places."""

FEWEST_SAMPLES = 8
"""Samples of the surface of a device of which only the model is needed."""

_AT_A_TIME = 2**16
"""Inputs that are mapped at once; each takes up to 700 bytes."""


@dataclass(frozen=True, kw_only=True)
class LinkErrors:
    """Colour differences CIEDE2000 between a table and the exact way, on the destination.

    Attributes
    ----------
    mean, percentile_95, percentile_99 : float
        Of random inputs, uniform in the cube of the source.
    worst : float
        Of these and of the edges of the cube.
    worst_at : tuple of three float
        Device value of the source with the worst error.
    inputs : int
        Number of random inputs.
    """

    mean: float
    percentile_95: float
    percentile_99: float
    worst: float
    worst_at: tuple[float, float, float]
    inputs: int = INPUTS

    def __str__(self) -> str:
        return (
            f"mean {self.mean:.3f}, 95 % {self.percentile_95:.3f}, 99 % {self.percentile_99:.3f}, "
            f"worst {self.worst:.2f} dE00"
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Link(Shown):
    """A table from device values of a source to those of a destination.

    Attributes
    ----------
    source, destination : str
        Names of the devices.
    method : str
        Method of gamut mapping.
    intent : str
        Rendering intent of both devices.
    space : str
        Colour space of the mapping.
    table : LookupTable
        Red, green and blue of the destination, encoded, 0 to 1, by those of the source.
    errors : LinkErrors
        Differences between the table and the exact way.
    warnings : tuple of str
    """

    source: str
    destination: str
    method: str
    intent: str
    space: str
    table: LookupTable
    errors: LinkErrors
    warnings: tuple[str, ...] = ()

    def to_bytes(self, format: str = "cube") -> bytes:  # noqa: A002  # as in other methods
        """Return the link as a file.

        Parameters
        ----------
        format : {"cube", "icc"}, optional
            A ``.cube`` file (Adobe, Cube LUT Specification 1.0), or an ICC device link of version
            2, whose values have 16 bits.

        Raises
        ------
        OptionError
            There is no such format.
        """
        title = f"{self.source} to {self.destination}, {self.method}: {self.errors}"
        if check_option("format", format, FORMAT) == "icc":
            names = self.source, self.destination
            return device_link_file(title, names, self.intent, self.table.nodes)
        red, green, blue = self.errors.worst_at
        comments = [
            f"Source: {self.source}. Destination: {self.destination}.",
            f"Gamut mapping: {self.method} in {self.space}, intent {self.intent}.",
            f"Error of tetrahedral interpolation against the exact mapping: {self.errors}.",
            f"Of {self.errors.inputs} random inputs; the worst is also of the cube's edges.",
            f"Worst at {red:.4f} {green:.4f} {blue:.4f}.",
            f"Written by gamutcore {__version__}.",
        ]
        return cube_file(title, comments, self.table.nodes)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the link to a ``.cube``, ``.icc`` or ``.icm`` file, complete or not at all.

        Raises
        ------
        OptionError
            The name has another suffix.
        OSError
            The file cannot be written.
        """
        target = Path(path)
        check_path(target)
        data = self.to_bytes(SUFFIXES[target.suffix.lower()])
        with draft_of(target) as draft:
            draft.write_bytes(data)


def check_path(path: Path, suffixes: Sequence[str] = tuple(SUFFIXES)) -> None:
    """Refuse a name with another suffix, or in a folder that does not exist."""
    if path.suffix.lower() not in suffixes:
        names = f"{', '.join(suffixes[:-1])} or {suffixes[-1]}"
        raise OptionError.refusal("output", path.name, f"a name that ends in {names}")
    if not path.parent.is_dir():
        raise FileNotFoundError(ENOENT, "There is no such folder", str(path.parent))


def link(
    source: str | os.PathLike[str] | bytes | Gamut,
    destination: str | os.PathLike[str] | bytes | Gamut,
    *,
    method: str = "sgck",
    size: int = 33,
    focus: Colours | Literal["cusp"] | None = None,
    black_point_compensation: bool = False,
    cache: Callable[[Reference, Options, Callable[[], Gamut]], Gamut] | None = None,
    **options: Any,  # noqa: ANN401  # checked by Options
) -> Link:
    """Compute a table from the values of one RGB device to those of another, with gamut mapping.

    Parameters
    ----------
    source, destination : str, path, bytes or Gamut
        An RGB space by its name, such as ``"rec2020"``; an RGB profile or measurements of a
        display, as a file or its bytes; or the gamut of an RGB space.
    method : str, optional
        Of gamut mapping, as for `Gamut.map`. ``sgck`` maps from the gamut of the source.
    size : int, optional
        Nodes along each channel, 2 to 129. Programs usually read 17, 33 and 65.
    focus : (3,) array_like or "cusp", optional
        Focal point of ``clip-focal``: L*, a*, b*.
    black_point_compensation : bool, optional
        Whether the black of the source becomes that of the destination. Not for ``sgck``.
    cache : callable, optional
        Returns the gamut of an RGB space and options, which its third argument builds.
    **options
        How the gamuts are built, as for `Gamut`, such as ``intent`` and ``space``. The space is IPT
        unless given. Options that do not apply to RGB spaces are meant for the other device. A
        `Gamut` has its own options.

    Returns
    -------
    Link

    Raises
    ------
    OptionError
        A device is not RGB or has linear values, the gamuts do not fit together, or an option is
        not accepted; ``where["field"]`` names it.
    GamutError
        The data cannot be read, or no gamut can be built.
    OSError
        A file cannot be read.

    Notes
    -----
    Colours are mapped by the full boundary, as those of pictures. A table is exact at its nodes
    only. Clipping has edges inside of the cells, which no table holds. `Link.errors` has the
    differences, and the file states them.

    Examples
    --------
    >>> same = link("srgb", "srgb", method="clip-hue", size=5, surface_samples=1000)
    >>> bool(same.errors.mean < 0.01)
    True
    """
    method = str(check_option("method", method, METHOD))
    size = int(check_option("size", size, SIZE))
    options = {"space": PICTURE_SPACE, **options}
    one, two = (
        _side(given, field, options, cache)
        for given, field in ((source, "source"), (destination, "destination"))
    )
    if one.options.intent != two.options.intent:
        raise OptionError(
            f"The source has the intent {one.options.intent}, and the destination "
            f"{two.options.intent}.",
            where={"field": "intent"},
            remedy="Build both gamuts with the same intent.",
        )
    if one.device.as_measured != two.device.as_measured:
        raise OptionError.not_applicable(
            "intent",
            one.options.intent,
            "the colours of one of the devices are adapted to D50, and those of the other are not",
            "Give relative.",
        )
    into, origin = two.gamut(), one.gamut() if method == "sgck" else None
    black = luminance_of_black(lab_to_xyz(one.device.colours(np.zeros((1, 3))))[0])

    def exact(values: FloatArray) -> FloatArray:
        found = np.empty_like(values)
        for start in range(0, len(values), _AT_A_TIME):
            part = slice(start, start + _AT_A_TIME)
            mapped = map_points(
                into,
                one.device.colours(values[part]),
                method,
                focus=focus,
                source=origin,
                black_point_compensation=black_point_compensation,
                black=black,
                max_error=0.0,  # edges of a coarser level are visible as arcs
            )
            found[part] = two.device.values(mapped)
        return found

    table = LookupTable(np.round(LookupTable.sample(exact, size).nodes, DECIMALS))
    warnings: tuple[str, ...] = ()
    if origin is not None:
        names = "the destination", "the source"
        warnings = comparison_warnings(into.conditions, origin.conditions, names)
    return Link(
        source=one.name,
        destination=two.name,
        method=method,
        intent=two.options.intent,
        space=into.colour_space.name,
        table=table,
        errors=_errors(table, exact, two.device),
        warnings=warnings,
    )


class _Side(NamedTuple):
    """One of the two devices, and how to get its gamut."""

    name: str
    device: RgbDevice
    options: Options
    gamut: Callable[[], Gamut]


def _side(
    given: str | os.PathLike[str] | bytes | Gamut,
    field: str,
    choices: dict[str, Any],
    cache: Callable[[Reference, Options, Callable[[], Gamut]], Gamut] | None,
) -> _Side:
    if isinstance(given, Gamut):
        return _side_of_gamut(given, field)
    try:
        found = given if isinstance(given, bytes) else gamut_source(given)
    except ReferenceNameError as error:
        error.where["field"] = field
        raise
    if isinstance(found, Reference):
        reference, content = found, found.data
        unfit = {each for each in OPTIONS if "reference" not in OPTIONS[each].data}
        choices = {each: choices[each] for each in choices if each not in unfit}
    elif is_saved_gamut(found):
        return _side_of_gamut(Gamut.from_bytes(found), field)
    else:
        reference, content = None, found
    options = Options.from_mapping(choices)

    def build() -> Gamut:
        return Gamut(content, options)

    device = _device(content, options, field)
    if reference is None:
        name = f"the {field}" if isinstance(given, bytes) else Path(given).name
        return _Side(name, device, options, build)
    cached = build if cache is None else partial(cache, reference, options, build)
    return _Side(reference.slug, device, options, cached)


def _side_of_gamut(gamut: Gamut, field: str) -> _Side:
    """Return the device of a reference gamut; other gamuts have no model of their device."""
    slug = gamut.description["provenance"].get("reference")
    if slug is None:
        raise OptionError.not_applicable(
            field,
            "of a built gamut",
            "a gamut does not keep the model of its device",
            "Give the file that it was built from.",
        )
    found = find_reference(str(slug))
    device = _device(found.data, gamut.options, field)
    return _Side(found.slug, device, gamut.options, lambda: gamut)


def _device(content: bytes, options: Options, field: str) -> RgbDevice:
    parsed = parsed_input(content, options, Limits())
    if isinstance(parsed, GamutMesh):
        raise OptionError.not_applicable(
            field, "of a mesh", "it has no device values", "Give an RGB profile or space."
        )
    found = input_colours(parsed, options, samples=FEWEST_SAMPLES)
    return rgb_device(parsed, found, field, options.adaptation or "Bradford")


def _errors(
    table: LookupTable, exact: Callable[[FloatArray], FloatArray], device: RgbDevice
) -> LinkErrors:
    """Measure a table at random inputs and on the edges of the source's cube."""
    inputs = np.random.default_rng(0).random((INPUTS, 3))
    inputs = np.concatenate([inputs, _edges()])
    difference = delta_e_2000(device.colours(table.values(inputs)), device.colours(exact(inputs)))
    random, worst = difference[:INPUTS], int(np.argmax(difference))
    percentiles = np.percentile(random, (95.0, 99.0)).tolist()
    red, green, blue = inputs[worst].tolist()
    return LinkErrors(
        mean=float(random.mean()),
        percentile_95=percentiles[0],
        percentile_99=percentiles[1],
        worst=float(difference[worst]),
        worst_at=(red, green, blue),
    )


def _edges() -> FloatArray:
    """Return values on the twelve edges of the cube, (12 · (`EDGE_STEPS` + 1), 3)."""
    along = np.linspace(0.0, 1.0, EDGE_STEPS + 1)
    edges = np.empty((3, 2, 2, len(along), 3))
    for axis in range(3):
        edges[axis, ..., axis] = along
        edges[axis, 1, :, :, axis - 1], edges[axis, 0, :, :, axis - 1] = 1.0, 0.0
        edges[axis, :, 1, :, axis - 2], edges[axis, :, 0, :, axis - 2] = 1.0, 0.0
    return edges.reshape(-1, 3)
