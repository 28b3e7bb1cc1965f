"""From device values of a source to device values of a destination, as a table.

The way is: device values → colours by the source's device model → gamut mapping → device values by
the destination's inverse device model. The table holds this way at its nodes.

Two errors are measured for each link. One is against the wanted colours, which do not depend on the
way: the colour of the source, with its black scaled to that of the destination, wherever the
destination has it. The other is of the table alone, against the way.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from errno import ENOENT
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import numpy as np

from gamutcore.arguments import Choice, WholeNumber, check_option
from gamutcore.building import device_model
from gamutcore.colours import (
    LookupTable,
    RgbSpace,
    compensate_black,
    lab_to_xyz,
    luminance_of_black,
    xyz_to_lab,
)
from gamutcore.content import gamut_source, is_saved_gamut
from gamutcore.errors import OptionError, ReferenceNameError, errors_in
from gamutcore.export.picture_file import atomic_write
from gamutcore.gamut import Gamut
from gamutcore.limits import Limits
from gamutcore.links.cube import DECIMALS, cube_file
from gamutcore.links.device_link import device_link_file
from gamutcore.links.pure_inks import PRESERVE, PureInks
from gamutcore.options import OPTIONS, Options
from gamutcore.pictures import DECODE
from gamutcore.questions import (
    COMPENSATION,
    MAP,
    METHOD,
    PICTURE_SPACE,
    RECIPES,
    Parameter,
    black_luminance,
    black_rule,
    check_space,
    comparison_warnings,
    compensates_black,
    is_as_measured,
    map_points,
    no_limit_warnings,
)
from gamutcore.recipes import InverseModel
from gamutcore.references import REFERENCES, Reference
from gamutcore.results import TabularRepr
from gamutcore.search import delta_e_2000
from gamutcore.version import __version__

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.arrays import FloatArray
    from gamutcore.colour_rows import Colours
    from gamutcore.colours import DeviceModel

__all__ = ["PARAMETERS", "Link", "LinkErrors", "check_path", "link", "table_size"]

SIZE = Annotated[int, WholeNumber(2, 129)]
"""Nodes of a table along each channel. 129 take 300 MB; a ``.cube`` file may have 256."""

SIZES = {3: 33, 4: 17, 5: 11, 6: 8, 7: 6}
"""Nodes by the number of the source's channels, if no size is given: at most 280,000 in all."""

FEWEST_NODES = 4
"""Nodes along each of still more channels."""

MOST_NODES = 129**3
"""Largest number of nodes of a table."""

FORMAT = Annotated[str, Choice(("cube", "icc"))]
"""Formats of links."""

PARAMETERS = (
    Parameter(
        "method",
        METHOD,
        "How colours are mapped into the gamut of the destination, as for `map`. `sgck` maps from "
        "the gamut of the source.",
        default="clip-hue",
    ),
    Parameter(
        "size",
        SIZE,
        "Nodes along each channel of the source. Programs usually read 17, 33 and 65. Default: 33 "
        "for three channels, 17 for four, and fewer for more.",
        example=33,
    ),
    *(parameter for parameter in MAP.parameters if parameter.name == "focus"),
    COMPENSATION,
    DECODE,
    *(parameter for parameter in RECIPES.parameters if parameter.name == "black"),
    Parameter(
        "preserve",
        PRESERVE,
        "From press to press, inks that stay pure. `black`: black alone stays black alone. "
        "`primaries`: so does every single ink. The share of the way from paper to the solid "
        "colour stays. By default, all inks are those of the colours.",
        example="black",
    ),
    Parameter(
        "format",
        FORMAT,
        "`cube`: a `.cube` file, from RGB to RGB. `icc`: an ICC device link of version 2. Default: "
        "`cube` from RGB to RGB, else `icc`.",
        example="cube",
    ),
)
"""Parameters of a link besides the devices."""

SUFFIXES = {".cube": "cube", ".icc": "icc", ".icm": "icc"}
"""Formats by the suffix of a file."""

INPUTS = 20_000
"""Random inputs at which the error is measured: the 99th percentile then lies between the 98.85th
and the 99.15th in 95 of 100 cases."""

EDGE_INPUTS = 3072
"""Inputs on the edges of the source's cube, where the error is measured as well: 256 on each edge
of three channels. No usual number of nodes has the same places."""

_AT_A_TIME = 2**14
"""Inputs that are mapped at once by a thread; each takes up to 1 kB."""

_THREADS = 4
"""Largest number of threads, which bounds the memory."""

_HDR = frozenset({"PQ", "HLG"})
"""Transfer curves of high dynamic range. A source may have them: its steps are nearly even."""


@dataclass(frozen=True, kw_only=True)
class LinkErrors:
    """Colour differences CIEDE2000 between the colours of a table and others, on the destination.

    Attributes
    ----------
    mean, percentile_95, percentile_99 : float
        Of random inputs, uniform in the cube of the source.
    worst : float
        Of these and of the edges of the cube.
    worst_at : tuple of float
        Device value of the source with the worst error.
    inputs : int
        Number of random inputs.
    """

    mean: float
    percentile_95: float
    percentile_99: float
    worst: float
    worst_at: tuple[float, ...]
    inputs: int = INPUTS

    @classmethod
    def of(cls, inputs: FloatArray, one: FloatArray, two: FloatArray) -> LinkErrors:
        """Return those between colours in CIELAB of inputs, of which the first are random."""
        difference = delta_e_2000(one, two)
        random, worst = difference[:INPUTS], int(np.argmax(difference))
        percentiles = np.percentile(random, (95.0, 99.0)).tolist()
        return cls(
            mean=float(random.mean()),
            percentile_95=percentiles[0],
            percentile_99=percentiles[1],
            worst=float(difference[worst]),
            worst_at=tuple(inputs[worst].tolist()),
        )

    def __str__(self) -> str:
        return (
            f"mean {self.mean:.3f}, 95 % {self.percentile_95:.3f}, 99 % {self.percentile_99:.3f}, "
            f"worst {self.worst:.2f} dE00"
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Link(TabularRepr):
    """A table from device values of a source to those of a destination.

    Attributes
    ----------
    source, destination : str
        Names of the devices.
    channels, destination_channels : tuple of str
        Names of the inputs and of the outputs.
    method : str
        Method of gamut mapping.
    intent : str
        Rendering intent of both devices.
    space : str
        Colour space of the mapping.
    table : LookupTable
        Device values of the destination, 0 to 1, by those of the source.
    errors : LinkErrors
        Differences from the wanted colours: those of the source, with its black scaled to that of
        the destination, where the destination has them, and mapped ones elsewhere.
    table_errors : LinkErrors
        Differences of the table from the exact mapping, between the nodes.
    black_point_compensation : bool
        Whether the black of the source becomes that of the destination.
    preserve : str, optional
        Inks that stay pure.
    decodings : pair of str, optional
        By what code values of the source and of the destination become light; None for devices of
        profiles and measurements, which state it themselves.
    warnings : tuple of str
    """

    source: str
    destination: str
    channels: tuple[str, ...]
    destination_channels: tuple[str, ...]
    method: str
    intent: str
    space: str
    table: LookupTable
    errors: LinkErrors
    table_errors: LinkErrors
    black_point_compensation: bool = False
    preserve: str | None = None
    decodings: tuple[str | None, str | None] = (None, None)
    warnings: tuple[str, ...] = ()

    @property
    def format(self) -> str:
        """The format that a file has unless another is asked for."""
        return "cube" if (self.channels, self.destination_channels) == (_RGB, _RGB) else "icc"

    def to_bytes(self, format: str | None = None) -> bytes:  # noqa: A002  # as in other methods
        """Return the link as a file.

        Parameters
        ----------
        format : {"cube", "icc"}, optional
            A ``.cube`` file (Adobe, Cube LUT Specification 1.0) from RGB to RGB, which is the
            default for them, or an ICC device link of version 2, whose values have 16 bits.

        Raises
        ------
        OptionError
            There is no such format, or it cannot hold these channels.
        """
        names = self.source, self.destination
        source, destination = map(_named, names, self.decodings)
        title = f"{source} to {destination}, {self.method}: {self.errors}"
        if check_option("format", format or self.format, FORMAT) == "icc":
            devices = (source, self.channels), (destination, self.destination_channels)
            return device_link_file(title, devices, self.intent, self.table.nodes)
        if self.format != "cube":
            raise OptionError.not_applicable(
                "format",
                "cube",
                f"a .cube file leads from R G B to R G B, and this link from "
                f"{' '.join(self.channels)} to {' '.join(self.destination_channels)}",
                "Give icc, a device link.",
            )
        scaled = "is" if self.black_point_compensation else "is not"
        comments = [
            f"Source: {self.source}. Destination: {self.destination}.",
            *(
                f"Code values of the {side} are light by: {_DETAILS.get(decoding, decoding)}."
                for side, decoding in zip(("source", "destination"), self.decodings, strict=True)
                if decoding is not None
            ),
            f"Gamut mapping: {self.method} in {self.space}, intent {self.intent}.",
            f"The black of the source {scaled} compensated.",
            f"Error against the wanted colours: {self.errors}.",
            "Wanted: the colour of the source if the destination has it, else the mapped one.",
            f"Of {self.errors.inputs} random inputs; the worst is also of the cube's edges.",
            f"Worst at {' '.join(f'{value:.4f}' for value in self.errors.worst_at)}.",
            f"Error of tetrahedral interpolation against the exact mapping: {self.table_errors}.",
            f"Written by gamutcore {__version__}.",
        ]
        return cube_file(title, comments, self.table.nodes)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the link to a ``.cube``, ``.icc`` or ``.icm`` file, complete or not at all.

        Raises
        ------
        OptionError
            The name has another suffix, or the format cannot hold these channels.
        OSError
            The file cannot be written.
        """
        target = Path(path)
        check_path(target)
        data = self.to_bytes(SUFFIXES[target.suffix.lower()])
        with atomic_write(target) as draft:
            draft.write_bytes(data)


_RGB = ("R", "G", "B")

_DETAILS = {
    "BT.1886": "ITU-R BT.1886, exponent 2.4, black 0",
    "inverse OETF": "the inverse of the curve of cameras, ITU-R BT.709-6, 1.2",
    "PQ": "ITU-R BT.2100 PQ",
    "HLG": "ITU-R BT.2100 HLG",
    "sRGB": "IEC 61966-2-1 (sRGB)",
}
"""Decodings as the file states them, by their short names."""


def _named(name: str, decoding: str | None) -> str:
    """Return the name of a device, with the decoding if it is not the only one of the space."""
    reference = REFERENCES.get(name)
    if decoding is None or reference is None:
        return name
    is_plain = reference.display is None and reference.decoding == decoding
    return name if is_plain else f"{name} ({decoding})"


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
    method: str = "clip-hue",
    size: int | None = None,
    focus: Colours | Literal["cusp"] | None = None,
    black_point_compensation: bool | None = None,
    decode: str | None = None,
    black: str | float | ArrayLike | None = None,
    preserve: str | None = None,
    cache: Callable[[Reference, Options, Callable[[], Gamut]], Gamut] | None = None,
    **options: Any,  # noqa: ANN401  # checked by Options
) -> Link:
    """Compute a table from the device values of one device to those of another.

    Parameters
    ----------
    source, destination : str, path, bytes or Gamut
        An RGB space by its name, such as ``"rec2020"``; an ICC profile or measurements of a display
        or a press, as a file or its bytes; or the gamut of a device.
    method : str, optional
        Of gamut mapping, as for `Gamut.map`. By clipping, as by default, colours that both devices
        have stay. ``sgck`` maps from the gamut of the source.
    size : int, optional
        Nodes along each channel of the source, 2 to 129. Programs usually read 17, 33 and 65.
        Default: 33 for three channels, 17 for four, and fewer for more.
    focus : (3,) array_like or "cusp", optional
        Focal point of ``clip-focal``: L*, a*, b*.
    black_point_compensation : bool, optional
        Whether the black of the source becomes that of the destination, by scaling in CIEXYZ
        (ISO 18619). By default, it does if colours are relative to white. Not for ``sgck``, which
        maps black itself.
    decode : {"bt1886", "oetf", "pq", "hlg", "srgb"}, optional
        How code values of an RGB space as the source become light. By default, spaces are decoded
        and encoded as their displays do: BT.709 and BT.2020 by ITU-R BT.1886, an exponent of 2.4
        and a black of 0, and not by the inverse of the curve of cameras (``"oetf"``).
    black : str, float or (n, 2) array_like, optional
        How much black a destination with black ink gets, as for `Gamut.to_device`.
    preserve : {"black", "primaries"}, optional
        From press to press, the inks that stay pure: black alone, or every single ink. The share of
        the way from paper to the solid colour stays.
    cache : callable, optional
        Returns the gamut of an RGB space and options, which its third argument builds.
    **options
        How the gamuts are built, as for `Gamut`, such as ``intent``, ``ink_limit`` and ``space``.
        The space is CAM16-UCS unless given. Options that do not apply to RGB spaces are meant for
        the other device. A `Gamut` has its own options.

    Returns
    -------
    Link

    Raises
    ------
    OptionError
        A device has fewer than three channels, no model or linear values, the gamuts do not fit
        together, or an option is not accepted; ``where["field"]`` names it.
    GamutError
        The data cannot be read, or no gamut can be built.
    OSError
        A file cannot be read.

    Notes
    -----
    Colours are mapped by the full boundary, as those of pictures. A table is exact at its nodes
    only. Clipping has edges inside of the cells, which no table holds. `Link.errors` has the
    differences from the wanted colours, and the file states them. Limits of inks are kept between
    the nodes as well, because interpolated values are means of values at nodes.

    Examples
    --------
    >>> same = link("srgb", "srgb", size=5, surface_samples=1000)
    >>> bool(same.errors.mean < 0.01)
    True
    """
    method = str(check_option("method", method, METHOD))
    options = {"space": PICTURE_SPACE, **options}
    one, two = (
        _side(data, field, options, cache)
        for data, field in ((source, "source"), (destination, "destination"))
    )
    if decode is not None:
        decode = str(check_option("decode", decode, DECODE.kind))
        one = one.with_decoding(decode)
    _check_device(one.model, "source")
    _check_device(two.model, "destination")
    if decode in {"pq", "hlg"} and method == "sgck":
        raise OptionError.not_applicable(
            "decode",
            decode,
            "sgck maps from the gamut of the source, which ends at its white",
            "Give a source such as bt2100-pq-1000, or another method.",
        )
    size = table_size(size, len(one.model.channels))
    rule = black_rule(black, two.model)
    if one.options.intent != two.options.intent:
        raise OptionError(
            f"The source has the intent {one.options.intent}, and the destination "
            f"{two.options.intent}.",
            where={"field": "intent"},
            remedy="Build both gamuts with the same intent.",
        )
    into, origin = two.gamut(), one.gamut() if method == "sgck" else None
    if origin is not None:
        check_space(into, origin)
        if is_as_measured(into) != is_as_measured(origin):
            raise OptionError.not_applicable(
                "intent",
                two.options.intent,
                "the colours of one of the devices are adapted to D50, and those of the other are "
                "not",
                "Give relative, or another method than sgck.",
            )
    if black_point_compensation is None:
        black_point_compensation = compensates_black(into, method)
    blacks = _blacks(one, into) if black_point_compensation else (0.0, 0.0)
    pure = None if preserve is None else PureInks.of(preserve, one.model, two.model)
    inverse = two.inverse()

    def mapped(lab: FloatArray) -> FloatArray:
        return map_points(
            into,
            lab,
            method,
            focus=focus,
            source=origin,
            black_point_compensation=black_point_compensation,
            black=blacks[0],
            max_error=0.0,  # edges of a coarser level are visible as arcs
        )

    def exact(values: FloatArray) -> _Colours:
        device = np.empty((len(values), len(two.model.channels)))
        lab = np.empty((len(values), 3))

        def write(start: int) -> None:
            part = slice(start, start + _AT_A_TIME)
            lab[part] = mapped(one.model.lab(values[part]))
            device[part] = inverse.recipes(lab[part], rule).device
            if pure is not None:
                pure.write(values[part], device[part])

        with ThreadPoolExecutor(min(_THREADS, os.cpu_count() or 1)) as workers:
            for _ in workers.map(write, range(0, len(values), _AT_A_TIME)):
                pass
        return _Colours(device, lab)

    sampled = LookupTable.sample(lambda nodes: exact(nodes).device, size, len(one.model.channels))
    table = LookupTable(np.round(sampled.nodes, DECIMALS))
    inputs = _inputs(table.inputs)
    table_lab, (device, wanted) = two.model.lab(table.values(inputs)), exact(inputs)
    # colours that both devices have stay, whatever the mapping does
    source_lab = one.model.lab(inputs)
    xyz = lab_to_xyz(source_lab)
    if black_point_compensation:
        xyz = compensate_black(xyz, *blacks)
        source_lab = xyz_to_lab(xyz)
    # some inks are darker than the neutral black: scaled, they are no colours
    stays = into.contains(source_lab, space="CIELAB", max_error=0.0) & (xyz >= 0.0).all(axis=1)
    wanted[stays] = source_lab[stays]
    # the gamut of the source is built for some methods only
    warnings = [f"The source: {warning}" for warning in one.warnings]
    warnings += [f"The destination: {warning}" for warning in into.conditions.build_warnings]
    warnings += no_limit_warnings(into.options, two.model)
    if origin is not None:
        names = "the destination", "the source"
        warnings += comparison_warnings(into.conditions, origin.conditions, names)
    return Link(
        source=one.name,
        destination=two.name,
        channels=one.model.channels,
        destination_channels=two.model.channels,
        method=method,
        intent=two.options.intent,
        space=into.colour_space.name,
        table=table,
        errors=LinkErrors.of(inputs, table_lab, wanted),
        table_errors=LinkErrors.of(inputs, table_lab, two.model.lab(device)),
        black_point_compensation=black_point_compensation,
        preserve=preserve,
        decodings=(one.decoding, two.decoding),
        warnings=tuple(warnings),
    )


def table_size(size: int | None, channels: int, most: int = MOST_NODES) -> int:
    """Return the number of nodes along each channel; the default for None.

    Raise OptionError if all channels together have more than `most` nodes.
    """
    largest = int(most ** (1.0 / channels) + 1e-9)
    if size is None:
        return min(SIZES.get(channels, FEWEST_NODES), largest)
    checked = int(check_option("size", size, SIZE))
    if checked > largest:
        raise OptionError.refusal("size", size, f"at most {largest} for {channels} channels")
    return checked


class _Side(NamedTuple):
    """One of the two devices, and how to get its gamut and the inverse of its model."""

    name: str
    model: DeviceModel
    options: Options
    gamut: Callable[[], Gamut]
    inverse: Callable[[], InverseModel]
    warnings: tuple[str, ...]

    @property
    def decoding(self) -> str | None:
        """By what code values of an RGB space become light; None for other devices."""
        function = self.model.function
        return function.reference.decoding if isinstance(function, RgbSpace) else None

    def with_decoding(self, decode: str) -> _Side:
        """Return the source with values that are decoded by one of `DECODE`."""
        function = self.model.function
        if not isinstance(function, RgbSpace):
            why = "the source is no RGB space, and its data states how values become light"
            raise OptionError.not_applicable("decode", decode, why)
        model = replace(self.model, function=function.with_decoding(decode))
        return self._replace(model=model, inverse=partial(InverseModel, model))


def _side(
    data: str | os.PathLike[str] | bytes | Gamut,
    field: str,
    choices: dict[str, Any],
    cache: Callable[[Reference, Options, Callable[[], Gamut]], Gamut] | None,
) -> _Side:
    if isinstance(data, Gamut):
        return _side_of_gamut(data, field)
    try:
        input_data = data if isinstance(data, bytes) else gamut_source(data)
    except ReferenceNameError as error:
        error.where["field"] = field
        raise
    if isinstance(input_data, Reference):
        reference, content = input_data, input_data.data
        unfit = {name for name in OPTIONS if "reference" not in OPTIONS[name].data}
        choices = {name: choices[name] for name in choices if name not in unfit}
    elif is_saved_gamut(input_data):
        with errors_in(data):
            return _side_of_gamut(Gamut.from_bytes(input_data), field)
    else:
        reference, content = None, input_data
    options = Options.from_mapping(choices)

    def build() -> Gamut:
        with errors_in(data):
            return Gamut(content, options)

    with errors_in(data):
        model_and_warnings = device_model(content, options, Limits())
    if model_and_warnings is None:
        raise _unfit(field, "has no model of a device")
    model, warnings = model_and_warnings
    inverse = partial(InverseModel, model)
    if reference is None:
        name = f"the {field}" if isinstance(data, bytes) else Path(data).name
        return _Side(name, model, options, build, inverse, warnings)
    cached = build if cache is None else partial(cache, reference, options, build)
    return _Side(reference.slug, model, options, cached, inverse, warnings)


def _side_of_gamut(gamut: Gamut, field: str) -> _Side:
    if not gamut.has_device_model:
        error = gamut.no_device_model()
        error.where["field"] = field
        raise error
    model = gamut.device_model
    name = gamut.description["provenance"].get("reference") or f"the {field}"
    warnings = gamut.conditions.build_warnings
    return _Side(
        str(name), model, gamut.options, lambda: gamut, lambda: gamut.inverse_model, warnings
    )


def _check_device(model: DeviceModel, field: str) -> None:
    """Refuse devices of fewer than three channels, and those of linear or HDR values."""
    if int(model.limited.free.sum()) < 3:
        raise _unfit(field, f"has the channels {' '.join(model.channels)}")
    if isinstance(model.function, RgbSpace):
        space = model.function.reference
        curve = space.definition["curve"]
        if curve == 1.0 or (curve in _HDR and field != "source"):
            kind = "linear light or a camera's curve" if curve == 1.0 else "high dynamic range"
            raise OptionError(
                f"The {field} {space.slug} has values in {kind}, which a table with equal steps "
                "from 0 to 1 cannot hold.",
                where={"field": field},
                remedy="Give a space with a transfer curve for displays, such as bt2020.",
            )


def _unfit(field: str, why: str) -> OptionError:
    return OptionError(
        f"The {field} {why}; a table needs a device of three or more.",
        where={"field": field},
        remedy="Give an RGB space such as display-p3, an ICC profile, or measurements of a display "
        "or a press.",
    )


class _Colours(NamedTuple):
    """Device values of the destination, and the mapped colours in CIELAB that they are for."""

    device: FloatArray
    lab: FloatArray


def _blacks(one: _Side, into: Gamut) -> tuple[float, float]:
    """Return the luminances of the blacks of the source and of the gamut of the destination.

    Both are those of the darkest neutral colours. That of an RGB space is 0.
    """
    darkest = luminance_of_black(lab_to_xyz(one.model.lab(one.model.limited.base[None]))[0])
    if darkest > 0.0 or one.model.inks:
        darkest = black_luminance(one.gamut())
    return darkest, black_luminance(into)


def _inputs(channels: int) -> FloatArray:
    """Return values at which tables are measured: `INPUTS` random ones, and those of the edges."""
    random = np.random.default_rng(0).random((INPUTS, channels))
    return np.concatenate([random, _edges(channels)])


def _edges(inputs: int) -> FloatArray:
    """Return values on the edges of the cube, about `EDGE_INPUTS` of them in equal steps."""
    corners = list(product((0.0, 1.0), repeat=inputs - 1))
    along = np.linspace(0.0, 1.0, max(EDGE_INPUTS // (inputs * len(corners)), 3))
    edges = np.empty((inputs, len(corners), len(along), inputs))
    for axis in range(inputs):
        edges[axis] = np.insert(np.array(corners), axis, 0.0, axis=1)[:, np.newaxis]
        edges[axis, :, :, axis] = along
    places = edges.reshape(-1, inputs)
    return places[:: 1 + len(places) // INPUTS]  # 12 channels have 25,000 edges
