"""Pictures as characterisation data: the distinct colours of all pixels, and their encoding.

`read_picture` decodes a file, drops transparent pixels, and counts the pixels of each distinct
value. An embedded profile or an `Encoding` gives the values their meaning.

For the counting, each pixel becomes one integer in Morton order: the bits of its channels
interleaved (Morton 1966). After sorting, equal values are neighbours, and so are all values in one
cell of a lattice that divides every channel into 2ⁿ levels. If there are too many distinct values,
the finest lattice with few enough cells is chosen, and each cell is represented by its outermost
value.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gamutcore.arrays import FloatArray
from gamutcore.characterisation.icc import IccProfile, icc_profile
from gamutcore.characterisation.pictures.encoding import LINEAR, SRGB, Encoding
from gamutcore.characterisation.pictures.raster import (
    MODELS,
    Raster,
    malformed_picture,
    open_raster,
)
from gamutcore.characterisation.samples import JSON, IntArray
from gamutcore.errors import (
    InvalidPointsError,
    MalformedProfileError,
    UnsupportedPictureError,
    UnsupportedProfileError,
)
from gamutcore.number_text import number_text

__all__ = [
    "LARGEST_LIGHT",
    "Picture",
    "distinct_values",
    "divided_by_alpha",
    "picture_meaning",
    "read_picture",
    "refuse_not_finite",
    "refuse_too_bright",
]

FREE_VALUES = 2**19
"""Distinct values of any file that are evaluated. Each takes 240 bytes in memory."""

BYTES_PER_VALUE = 2
"""Size of a file in bytes for each value beyond `FREE_VALUES`. Photographs have 4 to 14."""

ROOT_STEPS = 16384
"""Steps per unit of the cube roots to which linear light is rounded: at most 0.007 L*."""

LIGHT_BITS = 21
"""Bits of these steps: three channels are one key of 63 bits."""

_ROOT_OFFSET = 2 ** (LIGHT_BITS - 1)

LARGEST_LIGHT = ((_ROOT_OFFSET - 1) / ROOT_STEPS) ** 3
"""Largest value of linear light, 1 is white: 262,143. Half floats end at 65,504."""


@dataclass(frozen=True, eq=False)
class Picture:
    """The colours of a picture.

    Parameters
    ----------
    format : str
        Name of the file format, such as ``"png"`` or ``"exr"``.
    model : str
        A key of `MODELS`.
    values : (m, k) float
        Distinct channel values: 0 to 1; for linear light up to ±`LARGEST_LIGHT`; for
        Lab L*, a*, b*.
    counts : (m,) int64
        Number of pixels of each value.
    meaning : IccProfile, Encoding or None
        What the values mean; None for Lab.
    provenance : dict
        Size, depth, pixels, distinct values and so on; JSON-able.
    warnings : tuple of str
        Assumptions, and faults that were tolerated.
    """

    format: str
    model: str
    values: FloatArray
    counts: IntArray
    meaning: IccProfile | Encoding | None
    provenance: dict[str, JSON] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.values)


def read_picture(data: bytes, file_format: str, layer: str | None = None) -> Picture:
    """Return the colours of a picture file, whose format is one that `picture_format` returns.

    `layer` names a layer of OpenEXR.
    """
    with open_raster(data, file_format, layer) as raster:
        return _picture(raster, len(data))


def _picture(raster: Raster, size: int) -> Picture:
    meaning, said = picture_meaning(raster)
    floats = raster.dtype.kind == "f"
    linear = floats and isinstance(meaning, Encoding) and meaning.transfer == "linear"
    clipped = [0]
    pixel_values = distinct_values(
        _opaque_values(raster, linear=linear, clipped=clipped),
        raster.width * raster.height,
        len(MODELS[raster.model]),
        LIGHT_BITS if linear else 8 if raster.dtype == np.uint8 else 16,
        most=min(MAX_VALUES, max(FREE_VALUES, size // BYTES_PER_VALUE)),
    )
    values = pixel_values.values.astype(np.float64)
    if linear:
        values = ((values - _ROOT_OFFSET) / ROOT_STEPS) ** 3
    elif raster.model == "Lab":
        full, offset, step = (255, 128, 1) if raster.dtype == np.uint8 else (65280, 32768, 256)
        values = np.column_stack([values[:, 0] / full * 100, (values[:, 1:] - offset) / step])
    else:
        values /= 255.0 if raster.dtype == np.uint8 else 65535.0
    if clipped[0]:
        said.append(f"{clipped[0]} channel values beyond the encoding's range were clipped.")
    pixels, used = raster.width * raster.height, int(pixel_values.counts.sum())
    provenance: dict[str, JSON] = {
        "format": raster.format,
        "channels": list[JSON](MODELS[raster.model]),
        "size": [raster.width, raster.height],
        "bit_depth": raster.bits,
        "sample_format": "float" if floats else "integer",
        "colour_model": raster.model,
        "pixels": {"read": pixels, "transparent": pixels - used, "used": used},
        "distinct_values": pixel_values.distinct,
    }
    if floats:
        provenance["rounding"] = f"cube roots to 1/{ROOT_STEPS}" if linear else "16 bits"
    if pixel_values.levels is not None:
        provenance["lattice"] = {"levels": pixel_values.levels, "values": len(values)}
        said.append(
            f"Of {pixel_values.distinct} distinct values, {len(values)} are used: the outermost "
            f"one in each cell of {pixel_values.levels} levels per channel."
        )
    if isinstance(meaning, IccProfile):
        provenance["profile"] = meaning.provenance
    elif meaning is not None:
        source = "assumed" if raster.encoding is None else "the file"
        provenance["encoding"] = {"name": meaning.name, "from": source}
    return Picture(
        raster.format,
        raster.model,
        values,
        pixel_values.counts,
        meaning,
        provenance,
        (*raster.warnings, *said),
    )


def picture_meaning(raster: Raster) -> tuple[IccProfile | Encoding | None, list[str]]:
    """Return the profile or encoding of a raster, None for CIELAB, and warnings."""
    if raster.model == "Lab":
        said = ["CIELAB is taken to be relative to D50, which the file does not state."]
        if raster.profile:
            said.append("The embedded profile is not needed for CIELAB, and is not used.")
        return None, said
    if raster.profile and raster.encoding is None:
        profile = _embedded_profile(raster.profile)
        fitting = {"gray": {"gray", "RGB"}}.get(raster.model, {raster.model})
        space = "".join(profile.channels)
        if space not in fitting:
            raise malformed_picture(
                f"The picture is {raster.model}, but its embedded profile is for {space}.",
                {"field": "profile"},
                "Embed the profile that belongs to the values.",
            )
        return profile, [f"The embedded profile: {warning}" for warning in profile.warnings]
    if raster.encoding is not None:
        return raster.encoding, []
    if raster.model == "CMYK":
        raise UnsupportedPictureError(
            "The picture is CMYK and has no embedded profile, so its colours are unknown.",
            where={"field": "profile"},
            remedy="Embed the profile of the printing condition.",
        )
    if raster.dtype.kind == "f":
        return LINEAR, ["No profile is embedded: linear light of sRGB's primaries is assumed."]
    return SRGB, ["No profile is embedded: sRGB is assumed."]


def _embedded_profile(data: bytes) -> IccProfile:
    if data[36:40] != b"acsp":
        raise MalformedProfileError(
            "The embedded profile is not an ICC profile: acsp is missing at byte 36.",
            where={"field": "profile"},
            remedy="Embed the profile again.",
        )
    try:
        return icc_profile(data)
    except (MalformedProfileError, UnsupportedProfileError) as error:
        raise type(error)(
            f"The embedded profile: {error.message}", where=error.where, remedy=error.remedy
        ) from error


def _opaque_values(
    raster: Raster, *, linear: bool, clipped: list[int]
) -> Iterator[npt.NDArray[Any]]:
    """Yield the opaque pixels as integers, some rows at a time."""
    seen = 0
    for row, band, alpha in raster.bands:
        values = band
        if alpha is not None:
            opaque = alpha > 0
            values = values[opaque]
            if raster.premultiplied:
                values = divided_by_alpha(values, alpha[opaque])
        if values.dtype.kind == "f":
            refuse_not_finite(values, row)
            if linear:
                refuse_too_bright(values, row)
            values = _rounded(values, raster.model, clipped, linear=linear)
        seen += len(values)
        yield values
    if not seen:
        raise InvalidPointsError(
            "Every pixel of the picture is transparent.",
            where={"field": "alpha"},
            remedy="Send a picture with opaque pixels.",
        )


def divided_by_alpha(values: npt.NDArray[Any], alpha: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return colours that were multiplied by alpha as they were before."""
    if values.dtype.kind == "f":
        divided: npt.NDArray[Any] = values / alpha[:, np.newaxis]
        return divided
    full = float(np.iinfo(values.dtype).max)
    colours = values * (full / alpha.astype(np.float64))[:, np.newaxis]
    return np.minimum(np.round(colours), full).astype(values.dtype)


def refuse_not_finite(values: npt.NDArray[Any], row: int) -> None:
    """Raise InvalidPointsError if a pixel from a row on has a value that is not finite."""
    if values.dtype.kind != "f":
        return
    finite = np.isfinite(values).all(axis=1)
    if not finite.all():
        raise InvalidPointsError(
            f"Pixel values must be finite. {int((~finite).sum())} pixels from row {row + 1} on "
            f"contain {float(values[~finite][0].sum())}.",
            where={"row": row + 1},
            remedy="Mask invalid pixels with an alpha of 0.",
        )


def refuse_too_bright(values: npt.NDArray[Any], row: int) -> None:
    """Raise InvalidPointsError if linear light from a row on is beyond `LARGEST_LIGHT`."""
    beyond = (np.abs(values.astype(np.float64)) > LARGEST_LIGHT).any(axis=1)
    if beyond.any():
        raise InvalidPointsError(
            f"{int(beyond.sum())} pixels from row {row + 1} on have linear light of "
            f"{number_text(float(np.abs(values[beyond]).max()), 3)} × white, more than "
            f"{LARGEST_LIGHT:.0f}.",
            where={"row": row + 1},
            remedy="Clip or scale the picture, or mask these pixels with an alpha of 0.",
        )


def _rounded(
    values: npt.NDArray[Any], model: str, clipped: list[int], *, linear: bool
) -> npt.NDArray[Any]:
    """Return floats as integers of 16 bits, or `LIGHT_BITS`, and count the clipped ones."""
    scaled = values.astype(np.float64)
    if linear:
        roots: npt.NDArray[np.uint32] = np.round(
            np.cbrt(scaled) * ROOT_STEPS + _ROOT_OFFSET
        ).astype(np.uint32)
        return roots
    if model == "Lab":
        scaled = scaled * np.array([652.8, 256.0, 256.0]) + np.array([0.0, 32768.0, 32768.0])
    else:
        scaled = scaled * 65535.0
    whole = np.round(scaled)
    values = np.clip(whole, 0, 65535)
    clipped[0] += int(np.count_nonzero(whole != values))
    return values.astype(np.uint16)


MAX_VALUES = 2**21
"""Maximum number of values to evaluate: 2 s with a CMYK profile, or 7 bits of R, G and B each."""

_BLOCK = 2**22
"""Keys that are compared at a time, to avoid copies of all of them."""

_Key = type[np.unsignedinteger[Any]]


@dataclass(frozen=True, eq=False)
class DistinctValues:
    """Distinct values of pixels (m, k), and the number of pixels of each, or of its cell.

    `distinct` is the number of distinct values in the picture. `levels` are the lattice levels per
    channel; None if `values` has all distinct values.
    """

    values: npt.NDArray[np.uint32]
    counts: IntArray
    distinct: int
    levels: int | None


def distinct_values(
    bands: Iterable[npt.NDArray[Any]],
    pixels: int,
    channels: int,
    bits: int,
    *,
    most: int = MAX_VALUES,
) -> DistinctValues:
    """Return at most `most` distinct values of pixels, in Morton order.

    `bands` are the pixels in parts (n, channels), with at most `pixels` pixels in all. There are 1
    to 4 channels of 8 or 16 bits, or three of up to 21 bits.
    """
    if channels == 1:
        return _distinct_of_one_channel(bands, bits)
    kind: Any = np.uint32 if channels * bits <= 32 else np.uint64
    keys = _sorted_keys(bands, pixels, channels, bits, kind)
    level_bits, distinct = bits, _count_runs(keys, 0)
    runs = distinct
    while level_bits > 1 and runs > most:
        level_bits -= 1
        runs = _count_runs(keys, channels * (bits - level_bits))
    starts = _run_starts(keys, channels * (bits - level_bits))
    counts = np.diff(np.append(starts, len(keys)))
    chosen = keys[starts]
    if level_bits < bits:
        chosen = _outermost_keys(keys, starts, counts, channels, bits, level_bits)
    values = _gather_bits(chosen, channels, bits)
    return DistinctValues(values, counts, distinct, None if level_bits == bits else 2**level_bits)


def _sorted_keys(
    bands: Iterable[npt.NDArray[Any]], pixels: int, channels: int, bits: int, kind: _Key
) -> npt.NDArray[Any]:
    spread = _spread_bits(channels, bits, kind)
    keys = np.zeros(pixels, kind)
    filled = 0
    for band in bands:
        part = keys[filled : filled + len(band)]
        for channel in range(channels):
            part |= spread[band[:, channel]] << kind(channels - 1 - channel)
        filled += len(band)
    keys = keys[:filled]
    keys.sort()
    return keys


def _distinct_of_one_channel(bands: Iterable[npt.NDArray[Any]], bits: int) -> DistinctValues:
    numbers = np.zeros(2**bits, np.int64)
    for band in bands:
        numbers += np.bincount(band[:, 0], minlength=2**bits)
    values = np.flatnonzero(numbers)
    return DistinctValues(
        values.astype(np.uint32)[:, np.newaxis], numbers[values], len(values), None
    )


def _spread_bits(channels: int, bits: int, kind: _Key) -> npt.NDArray[Any]:
    """Return every channel value with its bits `channels` places apart."""
    spread = np.zeros(1, kind)
    for bit in range(bits):
        spread = np.concatenate([spread, spread | kind(1) << kind(bit * channels)])
    return spread


def _gather_bits(keys: npt.NDArray[Any], channels: int, bits: int) -> npt.NDArray[np.uint32]:
    """Return the channel values of keys: the inverse of `_spread_bits`."""
    values = np.zeros((len(keys), channels), np.uint32)
    kind = keys.dtype.type
    for channel in range(channels):
        for bit in range(bits):
            place = kind(bit * channels + channels - 1 - channel)
            values[:, channel] |= (((keys >> place) & kind(1)) << kind(bit)).astype(np.uint32)
    return values


def _changes(keys: npt.NDArray[Any], shift: int) -> Iterator[tuple[int, npt.NDArray[np.bool_]]]:
    """Yield where sorted keys, less their lowest bits, differ from their predecessors."""
    places = keys.dtype.type(shift)
    for start in range(0, len(keys) - 1, _BLOCK):
        cells = keys[start : start + _BLOCK + 1] >> places
        yield start + 1, cells[1:] != cells[:-1]


def _count_runs(keys: npt.NDArray[Any], shift: int) -> int:
    return 1 + sum(int(np.count_nonzero(changed)) for _, changed in _changes(keys, shift))


def _run_starts(keys: npt.NDArray[Any], shift: int) -> IntArray:
    starts = [np.flatnonzero(changed) + first for first, changed in _changes(keys, shift)]
    return np.concatenate([np.zeros(1, np.int64), *starts])


def _outermost_keys(
    keys: npt.NDArray[Any],
    starts: IntArray,
    counts: IntArray,
    channels: int,
    bits: int,
    kept: int,
) -> npt.NDArray[Any]:
    """Return the outermost key of each cell: the last in Morton order, with axes turned outwards.

    An axis is turned in cells below the middle of the picture's values.
    """
    kind = keys.dtype.type
    cells = _gather_bits(keys[starts], channels, bits) >> (bits - kept)
    middle = (cells.min(axis=0).astype(np.float64) + cells.max(axis=0)) / 2
    ones = _spread_bits(channels, bits, kind)[2 ** (bits - kept) - 1]
    turned = np.zeros(len(cells), kind)
    for channel in range(channels):
        below = cells[:, channel] < middle[channel]
        turned[below] |= ones << kind(channels - 1 - channel)
    # Blocks of whole cells avoid a second array of all keys.
    chosen = np.empty(len(cells), kind)
    first = 0
    while first < len(cells):
        last = int(np.searchsorted(starts, starts[first] + _BLOCK, side="left"))
        last = min(max(last, first + 1), len(cells))
        end = starts[last] if last < len(cells) else len(keys)
        members = keys[starts[first] : end] ^ np.repeat(turned[first:last], counts[first:last])
        chosen[first:last] = np.maximum.reduceat(members, starts[first:last] - starts[first])
        first = last
    return chosen ^ turned
