"""Gamut mapping of picture files: decoded, mapped and written some rows at a time.

The result has the encoding, depth, alpha and profile of the picture. Pixels whose colours stay keep
their values exactly. The others get the values of the mapped colour in the same encoding. Another
depth can be asked for; integers of a picture in linear light are sRGB. So can another encoding: an
RGB space, or device values (`gamutcore.pictures.picture_targets`).

Large pictures are mapped through a table of nodes in the encoding of the picture. A cell whose
corners all stay keeps its colours. A cell whose corners all move is interpolated. Colours of the
other cells, at the boundary of the gamut, are mapped exactly: there the mapping has an edge.

Pictures of CMYK become light first, and the result has an RGB space (a soft proof).

Spatial mapping reads the picture twice: for the lines on which its pixels move, and to move them.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.characterisation.icc import IccProfile
from gamutcore.characterisation.pictures import (
    LARGEST_LIGHT,
    LINEAR,
    Encoding,
    Picture,
    divided_by_alpha,
    open_raster,
    picture_format,
    picture_meaning,
    refuse_not_finite,
    refuse_too_bright,
)
from gamutcore.colours import (
    LookupTable,
    closed_form_values,
    cube_nodes,
    decode_srgb,
    encode_srgb,
    find_values,
    lab_to_xyz,
    luminance_of_black,
    picture_colours,
    profile_warnings,
)
from gamutcore.errors import MalformedFileError, OptionError, UnsupportedPictureError
from gamutcore.export.picture_file import (
    PNG_LEVEL,
    atomic_write,
    device_writer,
    picture_writer,
    png,
    with_depth,
)
from gamutcore.kernels import kernel
from gamutcore.pictures.picture_targets import (
    OWN,
    DeviceValues,
    blank_samples,
    decoded_meaning,
    device_raster,
    full_scale,
    space_raster,
)
from gamutcore.pictures.soft_proof import (
    PROOF_SPACE,
    PROOF_SPACE_CHOSEN,
    black_of_press,
    light_raster,
)
from gamutcore.questions import PICTURE_SPACE
from gamutcore.results import TabularRepr
from gamutcore.search import Lines, delta_e_2000

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from gamutcore.arrays import (
        BooleanArray,
        ByteArray,
        Float32Array,
        FloatArray,
        IndexArray,
        LongArray,
    )
    from gamutcore.characterisation.pictures import Raster
    from gamutcore.export.picture_file import Depth
    from gamutcore.results import Conditions

    Moves = Callable[[FloatArray], tuple[BooleanArray, LongArray, FloatArray]]

__all__ = [
    "BLACK_MOVES",
    "BLUE_TURNS",
    "HEAT_STEP",
    "TABLE_NODES",
    "TABLE_PIXELS",
    "MappedPicture",
    "SpatialMoves",
    "TableError",
    "map_picture",
    "no_picture",
    "turns_blue",
]

BLUE_TURNS = (
    f"CIELAB turns blue pixels to purple. Build the gamut with space {PICTURE_SPACE} for pictures."
)
"""Warning about a gamut in CIELAB."""

BLACK_MOVES = (
    "Black-point compensation moves colours in gamut as well: black becomes that of the gamut. "
    "Without it (--no-bpc, or black_point_compensation=false), they keep their values."
)
"""Warning if pixels in gamut move, and nobody asked for it."""

_BLUE = 270.0, 310.0
"""Hues of CIELAB in degrees where the loci of constant hue of the Munsell renotation turn by 1.1°
or more for a difference of 10 in chroma, all to purple."""

_LOSS = 10.0
"""Loss of chroma in CIELAB from which a colour counts as turned."""

VISIBLE = 1.0
"""Distance in CIELAB from which a mapped colour counts as missed by the encoding."""

_AT_A_TIME = 2**14
"""Colours that a thread maps at once; each takes up to 700 bytes. OpenBLAS multiplies up to 2¹⁸ ÷ 9
rows by a matrix in the calling thread; above, its own threads wait for ours, which takes four times
the processor time."""

THREADS = 4
"""Most threads that map. Kernels and NumPy release the interpreter's lock for most of the time."""


TABLE_NODES = 65
"""Nodes of the default table along each channel."""

DEVICE_NODES, DEVICE_PIXELS = 33, 250_000
"""The same for device values, which take ten times as long as values of an encoding."""

TABLE_PIXELS = 8_000_000
"""Pixels from which a table is the default. The exact mapping of as many takes about 3 s on two
cores, and the table alone 1 s."""

MOST_NODES = 129
"""Nodes along a channel of the largest table: 2.1 million nodes, 100 MB."""

CHECKED = 20_000
"""Pixels at which the error of a table is measured."""

HEAT_STEP = 0.05
"""ΔE00 of a step of gray in a heat map. White is 12.75, which is a large error in any picture."""

HEAT_MAP = (
    f"CIEDE2000 between each pixel and its mapped colour, rounded up: gray value × {HEAT_STEP:g}. "
    f"0 is an unchanged pixel, and 255 stands for {255 * HEAT_STEP:g} and more."
)
"""Text in the heat map."""

RESOLUTION = 0.01
"""Steps of percentiles of ΔE00."""


@dataclass(frozen=True, kw_only=True, repr=False)
class TableError(TabularRepr):
    """Difference CIE 2000 of pixels of the result from the exact calculation.

    Attributes
    ----------
    nodes : int
        Nodes of the table along each channel.
    pixels : int
        Pixels of the picture, chosen at random with a fixed seed, that were calculated exactly.
    mean, percentile_95, largest : float
        ΔE00 between the two results, both in the depth of the result.
    """

    nodes: int
    pixels: int
    mean: float
    percentile_95: float
    largest: float


@dataclass(frozen=True, kw_only=True, repr=False)
class MappedPicture(TabularRepr):
    """What became of the pixels of a picture.

    Through a table, the numbers beside `pixels` and `colours` are estimates.

    Attributes
    ----------
    pixels : int
        Opaque pixels.
    outside : int
        Those whose colours are out of gamut.
    moved : int
        Those that the mapping moves, and whose values are others after rounding, if the result has
        the encoding and depth of the picture. More than `outside` if colours in gamut move too.
    missed : int
        Those whose mapped colour is not in the encoding of the picture: they have its nearest
        colour, which is more than `VISIBLE` away.
    colours, colours_outside : int
        Distinct colours of the opaque pixels, and those with a pixel out of gamut. Pictures with
        more than 8 bits are rounded to 8 bits a channel for this, linear light after the curve of
        sRGB.
    delta_e, delta_e_95 : float
        Mean and 95th percentile, in steps of `RESOLUTION`, of the colour difference CIE 2000 of all
        opaque pixels and their mapped colours.
    moved_delta_e, moved_delta_e_95 : float
        The same of the moved pixels. 0 without any.
    encoding : str
        Of the result.
    warnings : tuple of str
        Assumptions about the picture, colours in gamut that move, and blue that became purple.
    table_error : TableError, optional
        Error of the table; None if every colour was mapped exactly.
    heat_map : str, optional
        What the values of the heat map mean, if one was written.
    gamut : Conditions, optional
        What the colours of the gamut are relative to.
    """

    pixels: int
    outside: int
    moved: int
    missed: int
    colours: int
    colours_outside: int
    delta_e: float
    delta_e_95: float
    moved_delta_e: float
    moved_delta_e_95: float
    encoding: str
    warnings: tuple[str, ...]
    table_error: TableError | None = None
    heat_map: str | None = None
    gamut: Conditions | None = None


@dataclass(frozen=True)
class SpatialMoves:
    """The functions of a mapping that depends on the neighbours of a pixel.

    Attributes
    ----------
    lines : callable
        From colours (n, 3) in CIELAB to which are out of gamut, and their lines.
    relaxed : callable
        From the lines of all pixels of a picture, as planes of float32, to the shares of the
        shifts (rows, columns).
    shifted : callable
        From colours (n, 3) in CIELAB and shifts in the space of the gamut to the rows that move,
        and the new colours of these rows.
    """

    lines: Callable[[FloatArray], tuple[BooleanArray, Lines]]
    relaxed: Callable[[Float32Array, Float32Array, Float32Array], Float32Array]
    shifted: Callable[[FloatArray, FloatArray], tuple[LongArray, FloatArray]]


def map_picture(
    data: bytes,
    output: Path,
    moves_from: Callable[[float], Moves | SpatialMoves],
    depth: Depth | None = None,
    *,
    table: int | None = None,
    heat_map: Path | None = None,
    to: str | DeviceValues = OWN,
    decode: str | None = None,
) -> MappedPicture:
    """Map the colours of a picture, and write the result.

    Parameters
    ----------
    data : bytes
        A file of gray or RGB, or of CMYK with an embedded profile.
    output : Path
        A .png, .tif, .exr or .jpg file.
    moves_from : callable
        From the luminance of the black of the encoding to a function, which several threads call.
        It takes colours (n, 3) in CIELAB, and returns which are out of gamut, the rows that move,
        and the new colours of these rows. Or to the functions of a spatial mapping.
    depth : {"8", "16", "half", "float"}, optional
        As for `gamutcore.export.picture_file.with_depth`.
    table : int, optional
        Nodes of a table along each channel, 5 to `MOST_NODES`; 0 maps every colour exactly. By
        default `TABLE_NODES` for pictures of more than `TABLE_PIXELS` pixels, else 0.
    heat_map : Path, optional
        A .png file for the colour difference of each pixel; see `HEAT_MAP`.
    to : str or DeviceValues, optional
        The encoding of the result: ``"picture"``, the slug of an RGB space, or a device.
        ``"picture"`` is sRGB for CMYK.
    decode : str, optional
        How values become light, by a name of `gamutcore.references.DECODINGS`.

    Raises
    ------
    MalformedFileError, PictureSizeError, MalformedProfileError, UnsupportedProfileError
        As for the gamut of a picture.
    InvalidPointsError
        A value is not finite, or linear light is too bright.
    UnsupportedPictureError
        The picture is CMYK without a profile, CIELAB or has a profile of one channel; or
        the output cannot store the depth, alpha or encoding.
    OptionError
        There is no such depth or table, or the heat map is no PNG file beside the output.
    OSError
        A file cannot be written.
    """
    if not (table is None or table == 0 or 5 <= table <= MOST_NODES):
        raise OptionError.refusal("table", table, f"0, or 5 to {MOST_NODES}")
    if heat_map is not None and (heat_map.suffix.lower() != ".png" or heat_map == output):
        raise OptionError.refusal("heat_map", str(heat_map), "a .png file beside the output")
    file_format = picture_format(data)
    if file_format is None:
        raise no_picture()
    with open_raster(data, file_format) as opened:
        meaning, said = _meaning_of(opened, decode)
        device = to if isinstance(to, DeviceValues) else None
        result, encoded, lost = _result_of(opened, meaning, to, depth, output)
        raster, black = opened, None
        press = meaning if opened.model == "CMYK" and isinstance(meaning, IccProfile) else None
        if press is not None:
            raster, meaning, black = light_raster(opened, press), LINEAR, black_of_press(press)
        if decode is not None and to == OWN:
            encoded = meaning
        if table is None:
            table = _default_nodes(raster.width * raster.height, device)
        with ExitStack() as stack:
            heat_file = stack.enter_context(atomic_write(heat_map)) if heat_map else None
            write = stack.enter_context(_writer(output, result, device))
            writing = stack.enter_context(ThreadPoolExecutor(1))
            threads = min(THREADS, os.cpu_count() or 1)
            workers = stack.enter_context(ThreadPoolExecutor(threads))
            pixels = _Pixels(
                raster, meaning, result, encoded, device, moves_from, workers, table, black
            )
            if pixels.spatial is not None:
                again = stack.enter_context(open_raster(data, file_format))
                pixels.find_shifts(again if press is None else light_raster(again, press))
            if heat_file is not None:
                pixels.heat = np.zeros(raster.height * raster.width, np.uint8)
            # a band is read, and another one written, while a third is mapped
            reading = stack.enter_context(ThreadPoolExecutor(1))
            read = reading.submit(pixels.next_band)
            written: Future[None] | None = None
            while (band := read.result()) is not None:
                read = reading.submit(pixels.next_band)
                rows = pixels.mapped(band)
                if written is not None:
                    written.result()
                end = band.row + len(rows) // raster.width
                written = writing.submit(write, band.row, end, rows)
            if written is not None:
                written.result()
            figures = pixels.figures()
            if heat_file is not None:
                gray = pixels.heat.reshape(raster.height, raster.width, 1)
                heat_file.write_bytes(png(gray, PNG_LEVEL, {"Description": HEAT_MAP}))
    return MappedPicture(
        **figures,
        encoding=pixels.encoding,
        warnings=tuple(dict.fromkeys([*raster.warnings, *said, *lost])),
        heat_map=HEAT_MAP if heat_map else None,
    )


def _meaning_of(raster: Raster, decode: str | None) -> tuple[IccProfile | Encoding, list[str]]:
    """Return what `picture_meaning` does, of a picture that can be mapped, or a decoding."""
    meaning, said = picture_meaning(raster)
    is_gray_profile = isinstance(meaning, IccProfile) and len(meaning.channels) == 1
    if meaning is None or raster.model not in {"RGB", "gray", "CMYK"} or is_gray_profile:
        raise UnsupportedPictureError(
            f"The picture is {raster.model}"
            f"{' with a profile of one channel' if raster.model == 'gray' else ''}.",
            where={"field": "channels"},
            remedy="Convert it to RGB.",
        )
    meaning, more = decoded_meaning(meaning, decode)
    said += more
    if isinstance(meaning, IccProfile):
        said += profile_warnings(meaning, "relative")
    return meaning, said


def no_picture() -> MalformedFileError:
    """Return the error of a file that is not a picture."""
    return MalformedFileError(
        "The file is not a picture.",
        where={"field": "header"},
        remedy="Give PNG, TIFF, JPEG, OpenEXR or another format of pictures.",
    )


def _result_of(
    like: Raster,
    meaning: IccProfile | Encoding,
    to: str | DeviceValues,
    depth: Depth | None,
    output: Path,
) -> tuple[Raster, IccProfile | Encoding | None, list[str]]:
    """Return how a picture is written, its encoding unless it is its own, and what it loses."""
    lost = []
    if like.model == "CMYK":
        like = replace(like, premultiplied=False)  # as its light
        if to == OWN:
            to, lost = PROOF_SPACE, [PROOF_SPACE_CHOSEN]
    if isinstance(to, DeviceValues):
        result = device_raster(like, depth, to)
        return result, None, result.warnings
    result = with_depth(like, depth, output)
    return (result, None, lost) if to == OWN else (*space_raster(result, meaning, to, output), lost)


def _writer(
    output: Path, result: Raster, device: DeviceValues | None
) -> AbstractContextManager[Callable[[int, int, NDArray[Any]], None]]:
    if device is None:
        return picture_writer(output, result)
    return device_writer(output, result, device.model.channels, inks=device.model.inks)


def _default_nodes(pixels: int, device: DeviceValues | None) -> int:
    """Return the nodes of the default table along each channel, 0 for none."""
    if device is None:
        return TABLE_NODES if pixels > TABLE_PIXELS else 0
    return DEVICE_NODES if device.tabulated and pixels > DEVICE_PIXELS else 0


def turns_blue(before: FloatArray, after: FloatArray) -> bool:
    """Return whether a mapping along hues of CIELAB, (n, 3), makes any blue visibly purple."""
    hue = np.degrees(np.arctan2(before[:, 2], before[:, 1])) % 360.0
    loss = np.hypot(before[:, 1], before[:, 2]) - np.hypot(after[:, 1], after[:, 2])
    blue = (hue >= _BLUE[0]) & (hue <= _BLUE[1])
    return bool((blue & (loss > _LOSS)).any())


_CHANGE = np.dtype([("delta_e", "f4"), ("outside", "?"), ("moved", "?"), ("missed", "?")])
"""What became of a colour."""


class _Band(NamedTuple):
    """Some rows: samples (n, 3), alpha (n,), which are opaque, and the colours of these.

    Colours of 8 bits have numbers, of which those in `new` are met here for the first time.
    """

    row: int
    given: NDArray[Any]
    alpha: NDArray[Any] | None
    opaque: BooleanArray | None
    straight: NDArray[Any]
    numbers: IndexArray | None
    new: slice


class _Pixels:
    """The way of some rows from samples to mapped samples, with the counts.

    `heat` (pixels,) receives the heat map if it has room.
    """

    def __init__(
        self,
        raster: Raster,
        meaning: IccProfile | Encoding,
        result: Raster,
        encoded: IccProfile | Encoding | None,
        device: DeviceValues | None,
        moves_from: Callable[[float], Moves | SpatialMoves],
        workers: ThreadPoolExecutor,
        table: int,
        black: float | None,
    ) -> None:
        self._raster, self._meaning, self._workers = raster, meaning, workers
        self._result, self._encoded = result, encoded or result.encoding or meaning
        self._device = device
        self._full, self._full_result = full_scale(raster.dtype), full_scale(result.dtype)
        self._is_linear = isinstance(meaning, Encoding) and meaning.transfer == "linear"
        self._recoded = device is not None or self._encoded != meaning
        self._same_codes = not self._recoded and raster.dtype == result.dtype
        self._channels = 3 if device is None else len(device.model.channels)
        linear = isinstance(self._encoded, Encoding) and self._encoded.transfer == "linear"
        self._wide = linear and result.dtype.kind == "f"
        if black is None:
            black = luminance_of_black(lab_to_xyz(self._colours(np.zeros((1, 3)), meaning))[0])
        moves = moves_from(black)
        self.spatial = moves if isinstance(moves, SpatialMoves) else None
        self._moves = None if isinstance(moves, SpatialMoves) else moves
        self._shifts: _Shifts | None = None
        self._known = _KnownColours() if raster.dtype == np.uint8 else None
        room = self._known.room if self._known else 0
        self._results = np.empty((room, self._channels), result.dtype)
        self._changes = np.empty(room, _CHANGE)
        self._seen = np.zeros(0 if self._known else 2**24, np.uint8)
        self.heat = np.empty(0, np.uint8)
        self._counts = dict.fromkeys(("pixels", "outside", "moved", "missed"), 0)
        self._sum = 0.0
        self._histogram = np.zeros(1, np.int64)
        self._table, self._cells = None, np.empty(0, np.uint8)
        size = raster.width * raster.height
        chosen = np.random.default_rng(0).choice(size, min(size, CHECKED), replace=False)
        self._chosen = np.sort(chosen) if table else np.empty(0, np.int64)
        self._checked: list[tuple[NDArray[Any], NDArray[Any]]] = []
        if table:
            self._table, self._cells = self._tabulated(table)

    @property
    def encoding(self) -> str:
        """The name of the encoding of the result."""
        if self._device is not None:
            return self._device.name
        encoded = self._encoded
        return "the embedded profile" if isinstance(encoded, IccProfile) else encoded.name

    def next_band(self) -> _Band | None:
        """Read some rows, and number their colours; None at the end."""
        for row, samples, alpha in self._raster.bands:
            given = np.empty((len(samples), 3), samples.dtype)
            given[:] = samples  # gray is equal R, G and B
            straight, opaque = given, None
            if alpha is not None:
                opaque = alpha > 0
                straight = given[opaque]
                if self._raster.premultiplied:
                    straight = divided_by_alpha(straight, alpha[opaque])
            refuse_not_finite(straight, row)
            if self._is_linear and straight.dtype.kind == "f":
                refuse_too_bright(straight, row)
            numbers, new = None, slice(0)
            if self._known is not None:
                first = self._known.count
                numbers = self._known.places(straight)
                new = slice(first, self._known.count)
            return _Band(row, given, alpha, opaque, straight, numbers, new)
        return None

    def find_shifts(self, again: Raster) -> None:
        """Read the picture to the end for the shifts of all pixels. `again` is read next."""
        assert self.spatial is not None  # noqa: S101  # else there are none
        width, height = self._raster.width, self._raster.height
        shifts = _Shifts.of_room(width * height)
        room = 0 if self._known is None else self._known.room
        of_colours = _Shifts.of_room(room)
        read = self._workers.submit(self.next_band)
        while (band := read.result()) is not None:
            read = self._workers.submit(self.next_band)
            at = self._opaque_places(band)
            if band.numbers is None or self._known is None:
                self._write_lines(band.straight, shifts, at)
                continue
            new = np.arange(band.new.start, band.new.stop)
            self._write_lines(self._known.colours[band.new], of_colours, new)
            for each, known in zip(shifts, of_colours, strict=True):
                each[at] = np.take(known, band.numbers, axis=0)
        directions, least, most, _ = shifts
        del of_colours
        self._known, self._seen = None, np.zeros(2**24, np.uint8)
        self._results, self._changes = np.empty((0, self._channels)), np.empty(0, _CHANGE)
        shares = self.spatial.relaxed(
            directions.reshape(height, width, 3),
            least.reshape(height, width),
            most.reshape(height, width),
        )
        self._shifts = shifts._replace(least=shares.ravel())
        self._raster = again

    def _opaque_places(self, band: _Band) -> LongArray:
        """Return the numbers in the picture of the opaque pixels of a band."""
        first = band.row * self._raster.width
        if band.opaque is None:
            return np.arange(first, first + len(band.given))
        return first + np.flatnonzero(band.opaque)

    def _write_lines(self, samples: NDArray[Any], shifts: _Shifts, at: LongArray) -> None:
        def write(start: int) -> None:
            part = slice(start, start + _AT_A_TIME)
            assert self.spatial is not None  # noqa: S101  # checked by the caller
            lab = self._colours(samples[part] / self._full, self._meaning)
            outside, lines = self.spatial.lines(lab)
            for shift, values in zip(shifts, (*lines, outside), strict=True):
                shift[at[part]] = values

        for _ in self._workers.map(write, range(0, len(samples), _AT_A_TIME)):
            pass

    def mapped(self, band: _Band) -> NDArray[Any]:
        """Return the samples of the result, alpha included."""
        given, opaque, straight = band.given, band.opaque, band.straight
        first = band.row * self._raster.width
        heat = self.heat[first : first + len(given)]
        begin, end = np.searchsorted(self._chosen, (first, first + len(given)))
        chosen = self._chosen[begin:end] - first
        results, gray = self._opaque(band)
        if opaque is None or band.alpha is None:
            heat[:] = gray
            self._checked.append((given[chosen], results[chosen]))
            return results
        if len(heat):
            heat[opaque] = gray
        chosen = np.cumsum(opaque)[chosen[opaque[chosen]]] - 1
        self._checked.append((straight[chosen], results[chosen]))
        if self._device is not None:
            samples = blank_samples(self._device, len(given), self._result.dtype)
            samples[opaque] = results
            return samples
        samples = np.empty((len(given), 4), self._result.dtype)
        samples[:, :3], samples[:, 3] = self._stored(given), self._stored(band.alpha)
        if not self._result.premultiplied:
            samples[opaque, :3] = results
            return samples
        colours = self._stored(given[opaque])
        changed = (results != self._stored(straight)).any(axis=1)
        share = band.alpha[opaque][changed, np.newaxis] / self._full
        product = results[changed] * share
        colours[changed] = product if self._full_result == 1.0 else np.round(product)
        samples[opaque, :3] = colours
        return samples

    def _stored(self, samples: NDArray[Any]) -> NDArray[Any]:
        """Return samples of the picture in the type of the result."""
        if samples.dtype == self._result.dtype:
            return samples
        return self._scaled(samples / self._full)

    def _scaled(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values, 1 is full scale, in the type of the result."""
        if self._device is not None:
            codes: NDArray[Any] = self._device.codes(values, self._full_result)
            return codes.astype(self._result.dtype)
        if self._full_result == 1.0:
            floats: NDArray[Any] = values.astype(self._result.dtype)
            return floats
        # transparent pixels may have any values
        limited = np.nan_to_num(np.clip(values, 0.0, 1.0))
        integers: NDArray[Any] = np.round(limited * self._full_result).astype(self._result.dtype)
        return integers

    def _opaque(self, band: _Band) -> tuple[NDArray[Any], ByteArray]:
        """Return the mapped samples, and their values in the heat map if there is one."""
        samples, numbers = band.straight, band.numbers
        if self._known is not None and numbers is not None:
            new = self._known.colours[band.new]
            self._results[band.new], self._changes[band.new] = self._evaluated(new)
            return np.take(self._results, numbers, axis=0), self._gray(self._changes, numbers)
        at = None if self._shifts is None else self._opaque_places(band)
        if self._table is None and self._shifts is None and samples.dtype.kind != "f":
            distinct, place, times = _distinct(samples)
        else:  # as fast as sorting
            distinct, place = samples, np.arange(len(samples))
            times = np.ones(len(samples), np.int64)
        result, changes = self._evaluated(distinct, at)
        self._count(changes, times)
        light = np.clip(self._shaped(distinct / self._full), 0.0, 1.0)
        red, green, blue = np.rint(255.0 * light).astype(np.int32).T
        key = red << 16 | green << 8 | blue
        self._seen[key] |= 1
        self._seen[key[changes["outside"]]] |= 2
        return np.take(result, place, axis=0), self._gray(changes, place)

    def _gray(self, changes: NDArray[Any], numbers: NDArray[np.integer[Any]]) -> ByteArray:
        if len(self.heat) == 0:
            return self.heat
        differences = np.take(changes["delta_e"], numbers)
        return np.minimum(np.ceil(differences / HEAT_STEP), 255.0).astype(np.uint8)

    def figures(self) -> dict[str, Any]:
        """Return the counts and the differences."""
        if self._known is not None:
            count = self._known.count
            self._count(self._changes[:count], self._known.times[:count].astype(np.int64))
            colours, outside = count, int(self._changes["outside"][:count].sum())
        else:
            colours, outside = (int(np.count_nonzero(self._seen & bit)) for bit in (1, 2))
        pixels, moved = self._counts["pixels"], self._counts["moved"]
        every = self._histogram.copy()
        every[0] += pixels - moved
        return {
            **self._counts,
            "colours": colours,
            "colours_outside": outside,
            "delta_e": self._sum / max(pixels, 1),
            "delta_e_95": _percentile_95(every),
            "moved_delta_e": self._sum / max(moved, 1),
            "moved_delta_e_95": _percentile_95(self._histogram),
            "table_error": self._table_error(),
        }

    def _count(self, changes: NDArray[Any], times: LongArray) -> None:
        self._counts["pixels"] += int(times.sum())
        for name in ("outside", "moved", "missed"):
            self._counts[name] += int(times[changes[name]].sum())
        moved = changes["moved"]
        differences = changes["delta_e"][moved].astype(np.float64)
        self._sum += float(times[moved] @ differences)
        steps = np.rint(differences / RESOLUTION).astype(np.int64)
        size = max(len(self._histogram), int(steps.max(initial=0)) + 1)
        histogram = np.bincount(steps, times[moved], size).astype(np.int64)
        histogram[: len(self._histogram)] += self._histogram
        self._histogram = histogram

    def _evaluated(
        self, samples: NDArray[Any], at: LongArray | None = None
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return samples of the mapped colours, and what became of each.

        `at` has the numbers of the pixels in the picture for a spatial mapping.
        """
        evaluate = self._exact if self._table is None else self._by_table
        result = np.empty((len(samples), self._channels), self._result.dtype)
        changes = np.empty(len(samples), _CHANGE)

        def write(start: int) -> None:
            part = slice(start, start + _AT_A_TIME)
            given = samples[part] / self._full
            if at is None:
                values, changes[part], _ = evaluate(given)
            else:
                values, changes[part], _ = self._exact(given, at[part])
            result[part] = self._scaled(values)
            if self._same_codes:
                rounded = (result[part] == samples[part]).all(axis=1)
                changes["moved"][part][rounded], changes["delta_e"][part][rounded] = False, 0.0

        for _ in self._workers.map(write, range(0, len(samples), _AT_A_TIME)):
            pass
        return result, changes

    def _exact(
        self, values: FloatArray, at: LongArray | None = None
    ) -> tuple[FloatArray, NDArray[Any], FloatArray]:
        """Return values of the mapped colours, what became of each, and what the encoding misses.

        The values are in the encoding of the result. The last array has the distances in CIELAB.
        """
        lab = self._colours(values, self._meaning)
        outside, rows, target = self._moved(lab, at)
        changes = np.zeros(len(values), _CHANGE)
        changes["outside"], changes["moved"][rows] = outside, True
        changes["delta_e"][rows] = delta_e_2000(lab[rows], target)
        if self._recoded:
            lab[rows] = target
            rows, target = np.arange(len(lab)), lab
        if self._device is not None:
            recipes, made = self._device.recipes(lab)
            missed = np.linalg.norm(made - lab, axis=1)
            changes["missed"] = missed > VISIBLE
            return recipes, changes, missed
        most = LARGEST_LIGHT if self._wide else 1.0
        begin = closed_form_values(target, self._encoded)
        encodings, distance = find_values(
            target,
            values[rows] if begin is None else begin,
            self._encoded_colours,
            -most if self._wide else 0.0,
            most,
        )
        result, missed = values.copy(), np.zeros(len(values))
        result[rows], missed[rows] = encodings, distance
        changes["missed"] = missed > VISIBLE
        return result, changes, missed

    def _moved(
        self, lab: FloatArray, at: LongArray | None
    ) -> tuple[BooleanArray, LongArray, FloatArray]:
        """Return what `Moves` does; with a spatial mapping, for the pixels of these numbers."""
        if self.spatial is None or self._shifts is None or at is None:
            assert self._moves is not None  # noqa: S101  # else there are shifts
            return self._moves(lab)
        directions, shares, _, outside = self._shifts
        shifts: NDArray[Any] = shares[at, np.newaxis] * directions[at]
        return outside[at], *self.spatial.shifted(lab, shifts)

    def _tabulated(self, size: int) -> tuple[LookupTable, ByteArray]:
        """Return a table of what `_exact` returns, and the kind of each cell."""
        nodes = cube_nodes(size)
        columns = np.empty((len(nodes), 3 + self._channels))
        moved = np.empty(len(nodes), np.bool_)

        def write(start: int) -> None:
            part = slice(start, start + _AT_A_TIME)
            values, changes, missed = self._exact(self._shaped(nodes[part], back=True))
            columns[part, 3:] = values if self._recoded else self._shaped(values)
            columns[part, 0], columns[part, 1] = changes["delta_e"], missed
            columns[part, 2], moved[part] = changes["outside"], changes["moved"]

        for _ in self._workers.map(write, range(0, len(nodes), _AT_A_TIME)):
            pass
        corners = moved.reshape(size, size, size).astype(np.uint8)
        for _ in range(3):  # along each axis in turn
            corners = np.moveaxis(corners[1:] + corners[:-1], 0, -1)
        cells = np.full(corners.shape, _MIXED, np.uint8)
        if self._device is not None or not self._recoded:  # formulas need no table
            cells[corners == 0] = _KEPT
        cells[corners == 8] = _MOVED
        return LookupTable(columns.reshape(size, size, size, -1)), cells.ravel()

    def _by_table(self, values: FloatArray) -> tuple[FloatArray, NDArray[Any], FloatArray]:
        """Return what `_exact` returns, from the table where it is interpolated."""
        assert self._table is not None  # noqa: S101  # chosen by `_evaluated`
        places, last = self._shaped(values), self._table.size - 1
        x, y, z = np.clip(places * last, 0, last - 1).astype(np.int64).T
        kind = self._cells[(x * last + y) * last + z]
        if values.dtype.kind == "f" and self._raster.dtype.kind == "f":
            kind[((places < 0.0) | (places > 1.0)).any(axis=1)] = _MIXED
        missed, changes = np.zeros(len(values)), np.zeros(len(values), _CHANGE)
        rows = np.flatnonzero(kind == _MOVED)
        if self._device is None:
            result = values.copy()
        else:
            result = np.empty((len(values), self._channels))
            kept = np.flatnonzero(kind == _KEPT)
            result[kept] = self._table.values(places[kept])[:, 3:]
        columns = self._table.values(places[rows])
        colours = columns[:, 3:]
        result[rows] = colours if self._recoded else self._shaped(colours, back=True)
        missed[rows] = columns[:, 1]
        changes["delta_e"][rows], changes["moved"][rows] = columns[:, 0], True
        changes["missed"][rows], changes["outside"][rows] = (
            missed[rows] > VISIBLE,
            columns[:, 2] > 0.5,
        )
        rows = np.flatnonzero(kind == _MIXED)
        result[rows], changes[rows], missed[rows] = self._exact(values[rows])
        return result, changes, missed

    def _table_error(self) -> TableError | None:
        """Compare the chosen pixels with the exact calculation."""
        if self._table is None:
            return None
        given, results = (np.concatenate(each) for each in zip(*self._checked, strict=True))
        exact = self._scaled(self._exact(given / self._full)[0])
        colours = self._encoded_colours if self._device is None else self._device.model.lab
        one, two = (colours(each / self._full_result) for each in (results, exact))
        errors = delta_e_2000(one, two) if len(one) else np.zeros(1)
        return TableError(
            nodes=self._table.size,
            pixels=len(one),
            mean=float(errors.mean()),
            percentile_95=float(np.percentile(errors, 95)),
            largest=float(errors.max()),
        )

    def _shaped(self, values: FloatArray, *, back: bool = False) -> FloatArray:
        """Return linear light by the curve of sRGB, whose steps are visually more equal, or back.

        Values of other encodings are returned unchanged.
        """
        if not self._is_linear:
            return values
        curve = decode_srgb if back else encode_srgb
        return np.copysign(curve(np.abs(values)), values)

    def _encoded_colours(self, values: FloatArray) -> FloatArray:
        return self._colours(values, self._encoded)

    def _colours(self, values: FloatArray, meaning: IccProfile | Encoding) -> FloatArray:
        if len(values) == 0:
            return np.empty((0, 3))
        raster, once = self._raster, np.ones(len(values), np.int64)
        picture = Picture(raster.format, "RGB", values, once, meaning)
        colours: FloatArray = picture_colours(picture, "relative").points
        return colours


class _Shifts(NamedTuple):
    """`Lines` of pixels or colours in float32, and which are out of gamut.

    `least` becomes the share of the shift. Transparent pixels have zeros.
    """

    directions: Float32Array
    least: Float32Array
    most: Float32Array
    outside: BooleanArray

    @classmethod
    def of_room(cls, size: int) -> _Shifts:
        """Return zeros, which occupy no memory until they are written."""
        directions, planes = np.zeros((size, 3), np.float32), np.zeros((2, size), np.float32)
        return cls(directions, planes[0], planes[1], np.zeros(size, np.bool_))


_KEPT, _MOVED, _MIXED = 0, 1, 2
"""Kinds of cells of a table: no corner moves, all do, and others, which are mapped exactly."""


def _percentile_95(histogram: LongArray) -> float:
    """Return the 95th percentile of differences that are counted in steps of `RESOLUTION`."""
    total = np.cumsum(histogram)
    return float(np.searchsorted(total, 0.95 * total[-1])) * RESOLUTION


class _KnownColours:
    """The distinct colours of 8 bits, numbered as they are met.

    `colours` has the samples of each, and `times` the number of its pixels. Arrays have room for
    all colours; the system provides the memory of the parts in use.
    """

    room = 2**24

    def __init__(self) -> None:
        self.count = 0
        self.colours = np.empty((self.room, 3), np.uint8)
        self.times = np.zeros(self.room, np.int32)
        self._numbers = np.zeros(self.room, np.int32)

    def places(self, samples: NDArray[np.uint8]) -> IndexArray:
        """Return the number of the colour of each pixel."""
        places = np.empty(len(samples), np.int32)
        self.count = _number_colours(
            samples, _SPREAD, self._numbers, self.colours, self.times, self.count, places
        )
        return places


_SPREAD = np.array(
    [sum((v >> bit & 1) << 3 * bit for bit in range(8)) for v in range(256)], np.int32
)
"""The bits of a sample, three places apart."""


@kernel
def _number_colours(
    samples: ByteArray,
    spread: IndexArray,
    numbers: IndexArray,
    colours: ByteArray,
    times: IndexArray,
    count: int,
    places: IndexArray,
) -> int:
    """Write the number of each pixel's colour to `places`; return the count of colours.

    `numbers` has the number of each colour plus 1. Its order is that of Morton (1966), in which the
    colours of adjacent pixels share cache lines.
    """
    for pixel in range(len(samples)):
        r, g, b = samples[pixel, 0], samples[pixel, 1], samples[pixel, 2]
        key = spread[r] << 2 | spread[g] << 1 | spread[b]
        number = numbers[key] - 1
        if number < 0:
            number = count
            colours[count, 0], colours[count, 1], colours[count, 2] = r, g, b
            count += 1
            numbers[key] = count
        times[number] += 1
        places[pixel] = number
    return count


def _distinct(samples: NDArray[Any]) -> tuple[NDArray[Any], LongArray, LongArray]:
    """Return distinct samples (m, 3), the place of each of the n samples, and numbers of pixels."""
    key = samples[:, 0].astype(np.uint64)
    for channel in (1, 2):
        key = (key << np.uint64(16)) | samples[:, channel]
    _, first, place, times = np.unique(
        key, return_index=True, return_inverse=True, return_counts=True
    )
    return samples[first], place, times
