"""Gamut mapping of picture files: decoded, mapped and written some rows at a time.

The result has the encoding, depth, alpha and profile of the picture. Pixels whose colours stay keep
their values exactly. The others get the values of the mapped colour in the same encoding. Another
depth can be asked for; integers of a picture in linear light are sRGB.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.characterisation.icc import IccProfile
from gamutcore.characterisation.pictures import (
    LARGEST_LIGHT,
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
    closed_form_values,
    find_values,
    lab_to_xyz,
    luminance_of_black,
    picture_colours,
)
from gamutcore.errors import MalformedFileError, UnsupportedPictureError
from gamutcore.export.picture_file import picture_writer, with_depth
from gamutcore.kernels import kernel
from gamutcore.queries import delta_e_2000
from gamutcore.results import Shown

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from gamutcore.arrays import ByteArray, FloatArray, IndexArray, LongArray
    from gamutcore.characterisation.pictures import Raster
    from gamutcore.export.picture_file import Depth
    from gamutcore.results import Conditions

    Moves = Callable[[FloatArray], tuple[LongArray, FloatArray]]

__all__ = ["BLUE_TURNS", "PICTURE_SPACE", "MappedPicture", "map_picture", "turns_blue"]

PICTURE_SPACE = "IPT"
"""Space in which gamuts for pictures are best built; docs/decisions/picture-space.md has why."""

BLUE_TURNS = (
    f"CIELAB turns blue pixels to purple. Build the gamut with space {PICTURE_SPACE} for pictures."
)
"""Warning about a gamut in CIELAB."""

_BLUE = 270.0, 310.0
"""Hues of CIELAB in degrees where the loci of constant hue of the Munsell renotation turn by 1.1°
or more for a difference of 10 in chroma, all to purple."""

_LOSS = 10.0
"""Loss of chroma in CIELAB from which a colour counts as turned."""

VISIBLE = 1.0
"""Distance in CIELAB from which a mapped colour counts as missed by the encoding."""

_AT_A_TIME = 2**16
"""Colours that a thread maps at once; each takes up to 700 bytes."""

THREADS = 4
"""Most threads that map. Kernels and NumPy release the interpreter's lock for most of the time."""


@dataclass(frozen=True, kw_only=True, repr=False)
class MappedPicture(Shown):
    """What became of the pixels of a picture.

    Attributes
    ----------
    pixels : int
        Opaque pixels.
    moved : int
        Those whose colours have another place.
    missed : int
        Those whose mapped colour is not in the encoding of the picture: they have its nearest
        colour, which is more than `VISIBLE` away.
    delta_e : float
        Mean colour difference CIE 2000 of the opaque pixels and their mapped colours.
    encoding : str
        Of the result.
    warnings : tuple of str
        Assumptions about the picture, and blue that became purple.
    gamut : Conditions, optional
        What the colours of the gamut are relative to.
    """

    pixels: int
    moved: int
    missed: int
    delta_e: float
    encoding: str
    warnings: tuple[str, ...]
    gamut: Conditions | None = None


def map_picture(
    data: bytes,
    output: Path,
    moves_from: Callable[[float], Moves],
    depth: Depth | None = None,
) -> MappedPicture:
    """Map the colours of a picture, and write the result.

    Parameters
    ----------
    data : bytes
        A file of gray or RGB.
    output : Path
        A .png, .tif, .exr or .jpg file.
    moves_from : callable
        From the luminance of the black of the encoding to a function, which several threads call.
        It takes colours (n, 3) in CIELAB, and returns the rows that move and their new colours.
    depth : {"8", "16", "half", "float"}, optional
        As for `gamutcore.export.picture_file.with_depth`.

    Raises
    ------
    MalformedFileError, PictureSizeError, MalformedProfileError, UnsupportedProfileError
        As for the gamut of a picture.
    InvalidPointsError
        A value is not finite, or linear light is too bright.
    UnsupportedPictureError
        The picture is CMYK, CIELAB or has a profile of one channel; or the output cannot store the
        depth, alpha or encoding.
    OptionError
        There is no such depth.
    OSError
        The file cannot be written.
    """
    file_format = picture_format(data)
    if file_format is None:
        raise MalformedFileError(
            "The file is not a picture.",
            where={"field": "header"},
            remedy="Give PNG, TIFF, JPEG, OpenEXR or another format of pictures.",
        )
    with open_raster(data, file_format) as raster:
        meaning, said = picture_meaning(raster)
        if raster.model not in {"RGB", "gray"} or (
            isinstance(meaning, IccProfile) and len(meaning.channels) != 3
        ):
            raise UnsupportedPictureError(
                f"The picture is {raster.model}"
                f"{' with a profile of one channel' if raster.model == 'gray' else ''}.",
                where={"field": "channels"},
                remedy="Convert it to RGB.",
            )
        assert meaning is not None  # noqa: S101  # only CIELAB has none
        result = with_depth(raster, depth, output)
        pixels = _Pixels(raster, meaning, result, moves_from)
        with (
            picture_writer(output, result) as write,
            ThreadPoolExecutor(1) as writing,
            ThreadPoolExecutor(min(THREADS, os.cpu_count() or 1)) as workers,
        ):
            written: Future[None] | None = None
            for first, band, alpha in raster.bands:
                rows = pixels.mapped(first, band, alpha, workers)
                if written is not None:
                    written.result()
                written = writing.submit(write, first, first + len(band) // raster.width, rows)
            if written is not None:
                written.result()
        pixels.finish()
    return MappedPicture(
        pixels=pixels.count,
        moved=pixels.moved,
        missed=pixels.missed,
        delta_e=pixels.delta_e / max(pixels.count, 1),
        encoding=pixels.encoding,
        warnings=tuple(dict.fromkeys([*raster.warnings, *said])),
    )


def turns_blue(before: FloatArray, after: FloatArray) -> bool:
    """Return whether a mapping along hues of CIELAB, (n, 3), makes any blue visibly purple."""
    hue = np.degrees(np.arctan2(before[:, 2], before[:, 1])) % 360.0
    loss = np.hypot(before[:, 1], before[:, 2]) - np.hypot(after[:, 1], after[:, 2])
    blue = (hue >= _BLUE[0]) & (hue <= _BLUE[1])
    return bool((blue & (loss > _LOSS)).any())


class _Pixels:
    """The way of some rows from samples to mapped samples, with the counts."""

    def __init__(
        self,
        raster: Raster,
        meaning: IccProfile | Encoding,
        result: Raster,
        moves_from: Callable[[float], Moves],
    ) -> None:
        self._raster, self._meaning = raster, meaning
        self._result, self._encoded = result, result.encoding or meaning
        self._full, self._full_result = _full_scale(raster.dtype), _full_scale(result.dtype)
        linear = isinstance(self._encoded, Encoding) and self._encoded.transfer == "linear"
        self._wide = linear and result.dtype.kind == "f"
        self._light = (
            raster.dtype.kind == "f"
            and isinstance(meaning, Encoding)
            and meaning.transfer == "linear"
        )
        self._recoded = self._encoded != meaning
        black = luminance_of_black(lab_to_xyz(self._colours(np.zeros((1, 3)), meaning))[0])
        self._moves = moves_from(black)
        self._known = _KnownColours() if raster.dtype == np.uint8 else None
        self._results = np.empty((self._known.room if self._known else 0, 3), result.dtype)
        self._changes = np.empty(len(self._results), _CHANGE)
        self.count = self.moved = self.missed = 0
        self.delta_e = 0.0

    @property
    def encoding(self) -> str:
        """The name of the encoding of the result."""
        encoded = self._encoded
        return "the embedded profile" if isinstance(encoded, IccProfile) else encoded.name

    def mapped(
        self,
        row: int,
        band: NDArray[Any],
        alpha: NDArray[Any] | None,
        workers: ThreadPoolExecutor,
    ) -> NDArray[Any]:
        """Return the samples of the result, alpha included."""
        given = np.empty((len(band), 3), band.dtype)
        given[:] = band  # gray is equal R, G and B
        if alpha is None:
            return self._opaque(given, row, workers)
        samples = np.empty((len(band), 4), self._result.dtype)
        samples[:, :3], samples[:, 3] = self._stored(given), self._stored(alpha)
        opaque = alpha > 0
        colours = given[opaque]
        if not self._raster.premultiplied:
            samples[opaque, :3] = self._opaque(colours, row, workers)
            return samples
        straight = divided_by_alpha(colours, alpha[opaque])
        found = self._opaque(straight, row, workers)
        if not self._result.premultiplied:
            samples[opaque, :3] = found
            return samples
        colours = self._stored(colours)
        changed = (found != self._stored(straight)).any(axis=1)
        share = alpha[opaque][changed, np.newaxis] / self._full
        product = found[changed] * share
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
        if self._full_result == 1.0:
            floats: NDArray[Any] = values.astype(self._result.dtype)
            return floats
        # transparent pixels may have any values
        limited = np.nan_to_num(np.clip(values, 0.0, 1.0))
        integers: NDArray[Any] = np.round(limited * self._full_result).astype(self._result.dtype)
        return integers

    def _opaque(self, samples: NDArray[Any], row: int, workers: ThreadPoolExecutor) -> NDArray[Any]:
        if len(samples) == 0:
            return samples
        refuse_not_finite(samples, row)
        if self._light:
            refuse_too_bright(samples, row)
        if self._known is None:
            distinct, place, times = _distinct(samples)
            result, changes = self._evaluated(distinct, workers)
            self._count(changes, times)
            return result[place] if len(place) else result
        first = self._known.count
        numbers = self._known.places(samples)
        new = slice(first, self._known.count)
        self._results[new], self._changes[new] = self._evaluated(self._known.colours[new], workers)
        return np.take(self._results, numbers, axis=0)

    def finish(self) -> None:
        """Count the pixels of colours that many bands share."""
        if self._known is not None:
            count = self._known.count
            self._count(self._changes[:count], self._known.times[:count].astype(np.int64))

    def _count(self, changes: NDArray[Any], times: LongArray) -> None:
        self.count += int(times.sum())
        self.moved += int(times[changes["moved"]].sum())
        self.missed += int(times[changes["missed"]].sum())
        self.delta_e += float(times @ changes["delta_e"])

    def _evaluated(
        self, samples: NDArray[Any], workers: ThreadPoolExecutor
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return samples of the mapped colours, and what became of each."""
        parts = [
            samples[start : start + _AT_A_TIME] for start in range(0, len(samples), _AT_A_TIME)
        ]
        result = np.empty(samples.shape, self._result.dtype)
        changes = np.empty(len(samples), _CHANGE)
        start = 0
        for values, change in workers.map(lambda part: self._exact(part / self._full), parts):
            end = start + len(values)
            result[start:end], changes[start:end] = self._scaled(values), change
            start = end
        return result, changes

    def _exact(self, values: FloatArray) -> tuple[FloatArray, NDArray[Any]]:
        """Return the values of the mapped colours in the encoding of the result."""
        lab = self._colours(values, self._meaning)
        rows, target = self._moves(lab)
        changes = np.zeros(len(values), _CHANGE)
        changes["moved"][rows] = True
        changes["delta_e"][rows] = delta_e_2000(lab[rows], target)
        if self._recoded:
            lab[rows] = target
            rows, target = np.arange(len(lab)), lab
        most = LARGEST_LIGHT if self._wide else 1.0
        begin = closed_form_values(target, self._encoded)
        found, distance = find_values(
            target,
            values[rows] if begin is None else begin,
            lambda some: self._colours(some, self._encoded),
            -most if self._wide else 0.0,
            most,
        )
        result = values.copy()
        result[rows] = found
        changes["missed"][rows] = distance > VISIBLE
        return result, changes

    def _colours(self, values: FloatArray, meaning: IccProfile | Encoding) -> FloatArray:
        raster, once = self._raster, np.ones(len(values), np.int64)
        picture = Picture(raster.format, "RGB", values, once, meaning)
        colours: FloatArray = picture_colours(picture, "relative").points
        return colours


def _full_scale(dtype: np.dtype[Any]) -> float:
    return 1.0 if dtype.kind == "f" else float(np.iinfo(dtype).max)


_CHANGE = np.dtype([("delta_e", np.float32), ("moved", np.bool_), ("missed", np.bool_)])
"""What became of a colour."""


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
    """Return distinct samples (m, 3), the place of each of the n samples, and numbers of pixels.

    Floats are hardly equal: all are returned, and no places.
    """
    if samples.dtype.kind == "f":
        return samples, np.empty(0, np.int64), np.ones(len(samples), np.int64)
    key = samples[:, 0].astype(np.uint64)
    for channel in (1, 2):
        key = (key << np.uint64(16)) | samples[:, channel]
    _, first, place, times = np.unique(
        key, return_index=True, return_inverse=True, return_counts=True
    )
    return samples[first], place, times
