"""A picture as data: what all formats are read into, with the checks that they share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gamutcore.arrays import FloatArray
from gamutcore.characterisation.icc import IccProfile, icc_profile
from gamutcore.characterisation.pictures.bounds import (
    BYTES_PER_VALUE,
    FREELY_DISTINCT,
    FREELY_EVALUATED,
    FREELY_SORTED,
    SORTED_RATIO,
    malformed,
)
from gamutcore.characterisation.pictures.encoding import LINEAR, SRGB, Encoding
from gamutcore.characterisation.pictures.values import (
    MAX_VALUES,
    TooManyValuesError,
    distinct_values,
)
from gamutcore.characterisation.samples import JSON, IntArray
from gamutcore.errors import (
    InvalidPointsError,
    MalformedProfileError,
    PictureSizeError,
    UnsupportedPictureError,
    UnsupportedProfileError,
)

__all__ = [
    "CHANNELS",
    "MAX_PROFILE_BYTES",
    "Picture",
    "Raster",
    "picture_of_raster",
]

MAX_PROFILE_BYTES = 2**25
"""Bytes of an unpacked profile at most; the largest press profiles have some 10 MB."""

CHANNELS: dict[str, tuple[str, ...]] = {
    "gray": ("gray",),
    "RGB": ("R", "G", "B"),
    "CMYK": ("C", "M", "Y", "K"),
    "Lab": ("L*", "a*", "b*"),
}
"""Colour models that are read, and their channels."""

ROOT_STEPS = 16384
"""Steps per unit of cube roots, which linear light is rounded in: 0.007 L* at most."""

_BAND_PIXELS = 2**20


@dataclass(frozen=True, eq=False)
class Picture:
    """The colours of a picture.

    Parameters
    ----------
    format : str
        ``"png"``, ``"tiff"`` or ``"jpeg"``.
    model : str
        One of `CHANNELS`.
    values : (m, k) float
        Distinct channel values: 0 to 1, −8 to 8 for linear light, or L*, a*, b* for Lab.
    counts : (m,) int64
        Pixels of each.
    meaning : IccProfile, Encoding or None
        What the values mean; None for Lab.
    provenance : dict
        Size, depth, pixels, distinct values and so on; JSON-able.
    warnings : tuple of str
        What was assumed or tolerated in reading.
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


def _as_they_are(samples: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return samples


@dataclass(eq=False)
class Raster:
    """A picture that is being decoded, before its colours are sorted out.

    Parameters
    ----------
    format : str
    model : str
        One of `CHANNELS`.
    width, height : int
    parts : iterator of (int, (rows, columns, samples) array)
        The samples of the pixels, of every pixel once, with their first row in the picture. They
        are decoded on the way, so that memory need not hold all of them.
    dtype : dtype
        uint8, uint16 or float, of what `colours` returns.
    packed : int
        Bytes that the pixels have in the file.
    full : int
        The largest value of integers: 255 or 65535, or less for fewer bits.
    bits : int
        Bits of a channel value in the file.
    colours : callable
        From samples, as of `parts`, to (rows, columns, k) channel values. Lab in whole numbers has
        a* and b* offset by 128, and 100 L* at 255 or 65280 (ICC.1:2001-04, annex A); floats are as
        they are.
    palette : (n, 3) uint8 or uint16, or None
        The colours that `colours`, of one channel, are numbers of; `full` is of these.
    palette_alpha : (n,) array or None
        Of each of them; 0 is transparent.
    alpha : callable or None
        From samples to (rows, columns) alpha; 0 is transparent.
    alpha_full : float
        The alpha of what is opaque.
    premultiplied : bool
        Whether the pixels were multiplied by alpha.
    profile : bytes
        The embedded profile; empty without one.
    encoding : Encoding or None
        What the file says in place of a profile.
    said : list of str
        Warnings.
    notes : dict
        What else belongs to the provenance.
    """

    format: str
    model: str
    width: int
    height: int
    parts: Iterator[tuple[int, npt.NDArray[Any]]]
    dtype: np.dtype[Any]
    packed: int
    full: int
    bits: int
    colours: Callable[[npt.NDArray[Any]], npt.NDArray[Any]] = _as_they_are
    palette: npt.NDArray[Any] | None = None
    palette_alpha: npt.NDArray[Any] | None = None
    alpha: Callable[[npt.NDArray[Any]], npt.NDArray[Any]] | None = None
    alpha_full: float = 1.0
    premultiplied: bool = False
    profile: bytes = b""
    encoding: Encoding | None = None
    said: list[str] = field(default_factory=list)
    notes: dict[str, JSON] = field(default_factory=dict)


def picture_of_raster(raster: Raster) -> Picture:
    """Return the distinct colours of a decoded picture, with their meaning.

    Parameters
    ----------
    raster : Raster

    Returns
    -------
    Picture

    Raises
    ------
    InvalidPointsError
        A value is not a finite number, or every pixel is transparent.
    MalformedFileError
        The profile is for another colour model.
    MalformedProfileError, UnsupportedProfileError
        The embedded profile is broken, or not evaluated.
    UnsupportedPictureError
        The picture is CMYK, and no profile says what its inks look like.
    """
    meaning, said = _meaning(raster)
    width, height = raster.width, raster.height
    channels = 1 if raster.palette is not None else len(CHANNELS[raster.model])
    floats = raster.dtype.kind == "f"
    linear = floats and isinstance(meaning, Encoding)
    clipped = [0]
    bands = _bands(raster, linear=linear, clipped=clipped)
    depth = 8 if raster.dtype == np.uint8 else 16
    fewer = max(FREELY_DISTINCT, raster.packed)
    try:
        found = distinct_values(
            bands,
            width * height,
            channels,
            depth,
            most=min(MAX_VALUES, max(FREELY_EVALUATED, raster.packed // BYTES_PER_VALUE)),
            sorted_bytes=max(FREELY_SORTED, raster.packed * SORTED_RATIO),
            fewer=fewer,
        )
    except TooManyValuesError as error:
        raise PictureSizeError(
            f"The {raster.packed} bytes of the picture unpack to more than {fewer} distinct "
            "values.",
            where={"field": "size"},
            remedy=f"Beyond {FREELY_DISTINCT}, large pictures need a byte for each; send a smaller "
            "copy, or one of 8 bits.",
        ) from error
    whole, counts, distinct = found.values, found.counts, found.distinct
    if raster.palette is not None:
        whole, counts = _looked_up(whole[:, 0], counts, raster)
        distinct = len(whole)
    used = int(counts.sum())
    values = whole.astype(np.float64)
    rounding: JSON = None
    if linear:
        values = ((values - 2 * ROOT_STEPS) / ROOT_STEPS) ** 3
        rounding = f"cube roots to 1/{ROOT_STEPS}"
    elif raster.model == "Lab":
        full = 255.0 if depth == 8 else 65280.0
        offset, step = (128, 1.0) if depth == 8 else (32768, 256.0)
        values = np.column_stack([values[:, 0] / full * 100, (values[:, 1:] - offset) / step])
        rounding = "16 bits" if floats else None
    else:
        values /= 65535.0 if floats else raster.full
        rounding = "16 bits" if floats else None
    if clipped[0]:
        said.append(f"{clipped[0]} channel values beyond the encoding's range were cut off.")
    provenance: dict[str, JSON] = {
        "format": raster.format,
        "channels": list[JSON](CHANNELS[raster.model]),
        "size": [width, height],
        "bit_depth": raster.bits,
        "sample_format": "float" if floats else "integer",
        "colour_model": raster.model,
        "pixels": {"read": width * height, "transparent": width * height - used, "used": used},
        "distinct_values": distinct,
        **raster.notes,
    }
    if rounding is not None:
        provenance["rounding"] = rounding
    if found.levels is not None:
        provenance["lattice"] = {"levels": found.levels, "values": len(values)}
        said.append(
            f"Of {distinct} distinct values, {len(values)} were used: the outermost in each "
            f"cell of {found.levels} levels per channel."
        )
    if isinstance(meaning, IccProfile):
        provenance["profile"] = meaning.provenance
    elif isinstance(meaning, Encoding):
        provenance["encoding"] = {
            "name": meaning.name,
            "from": "assumed" if raster.encoding is None else "the file",
        }
    return Picture(
        raster.format,
        raster.model,
        values,
        counts,
        meaning,
        provenance,
        (*raster.said, *said),
    )


def _meaning(raster: Raster) -> tuple[IccProfile | Encoding | None, list[str]]:
    if raster.model == "Lab":
        said = ["CIELAB is taken to be relative to D50, which the file does not state."]
        if raster.profile:
            said.append("The embedded profile is not needed for CIELAB, and was not used.")
        return None, said
    if raster.profile:
        profile = _embedded_profile(raster.profile)
        fitting = {"gray": {"gray", "RGB"}, "RGB": {"RGB"}, "CMYK": {"CMYK"}}[raster.model]
        space = "".join(profile.channels)
        if space not in fitting:
            raise malformed(
                f"The picture is {raster.model}, and its embedded profile is for {space}.",
                {"field": "profile"},
                "Embed the profile that the values were made for.",
            )
        return profile, [f"The embedded profile: {warning}" for warning in profile.warnings]
    if raster.encoding is not None:
        return raster.encoding, []
    if raster.model == "CMYK":
        raise UnsupportedPictureError(
            "The picture is CMYK and has no embedded profile, so its colours are not known.",
            where={"field": "profile"},
            remedy="Embed the profile of the printing condition.",
        )
    if raster.dtype.kind == "f":
        return LINEAR, ["No profile is embedded: linear light of sRGB's primaries is assumed."]
    return SRGB, ["No profile is embedded: sRGB is assumed."]


def _embedded_profile(data: bytes) -> IccProfile:
    if len(data) > MAX_PROFILE_BYTES:
        raise MalformedProfileError(
            f"The embedded profile has {len(data)} bytes.",
            where={"field": "profile"},
            remedy=f"At most {MAX_PROFILE_BYTES} bytes are read.",
        )
    if data[36:40] != b"acsp":
        raise MalformedProfileError(
            "The embedded profile is no ICC profile: acsp is not at byte 36.",
            where={"field": "profile"},
            remedy="Embed the profile anew.",
        )
    try:
        return icc_profile(data)
    except (MalformedProfileError, UnsupportedProfileError) as error:
        raise type(error)(
            f"The embedded profile: {error.message}", where=error.where, remedy=error.remedy
        ) from error


def _bands(raster: Raster, *, linear: bool, clipped: list[int]) -> Iterator[npt.NDArray[Any]]:
    """Yield the opaque pixels as whole numbers, some rows at a time."""
    seen = 0
    for row, band, alpha in _pieces(raster):
        if alpha is not None:
            opaque = alpha > 0
            band, alpha = band[opaque], alpha[opaque]  # noqa: PLW2901
            if raster.premultiplied:
                band = _divided(band, alpha, raster)  # noqa: PLW2901
        if band.dtype.kind == "f":
            _refuse_not_finite(band, row)
            band = _whole(band, raster.model, clipped, linear=linear)  # noqa: PLW2901
        seen += len(band)
        yield band
    if not seen:
        raise _invisible()


def _pieces(
    raster: Raster,
) -> Iterator[tuple[int, npt.NDArray[Any], npt.NDArray[Any] | None]]:
    """Yield the first row, the colours (n, k) and the alpha (n,) of few pixels at a time."""
    for top, part in raster.parts:
        rows = max(1, _BAND_PIXELS // part.shape[1])
        for start in range(0, len(part), rows):
            samples = part[start : start + rows]
            colours = raster.colours(samples)
            alpha = None if raster.alpha is None else raster.alpha(samples).reshape(-1)
            yield top + start, colours.reshape(-1, colours.shape[2]), alpha


def _invisible() -> InvalidPointsError:
    return InvalidPointsError(
        "Every pixel of the picture is transparent.",
        where={"field": "alpha"},
        remedy="Send a picture with pixels that can be seen.",
    )


def _looked_up(
    numbers: npt.NDArray[np.uint16], counts: IntArray, raster: Raster
) -> tuple[npt.NDArray[Any], IntArray]:
    """Return the distinct colours of a palette that pixels have, and their numbers of pixels."""
    assert raster.palette is not None  # noqa: S101 (this is called for indexed pictures)
    largest = int(numbers.max())
    if largest >= len(raster.palette):
        raise malformed(
            f"A pixel has the colour number {largest}; there are {len(raster.palette)} colours.",
            {"field": "palette"},
        )
    if raster.palette_alpha is not None:
        opaque = raster.palette_alpha[numbers] > 0
        numbers, counts = numbers[opaque], counts[opaque]
    if not len(numbers):
        raise _invisible()
    colours, places = np.unique(raster.palette[numbers], axis=0, return_inverse=True)
    return colours, np.bincount(places.reshape(-1), counts).astype(np.int64)


def _divided(band: npt.NDArray[Any], alpha: npt.NDArray[Any], raster: Raster) -> npt.NDArray[Any]:
    """Return colours that were multiplied by alpha as they were before."""
    colours = band * (raster.alpha_full / alpha.astype(np.float64))[:, np.newaxis]
    if band.dtype.kind == "f":
        return colours
    return np.minimum(np.round(colours), raster.full).astype(band.dtype)


def _refuse_not_finite(band: npt.NDArray[Any], row: int) -> None:
    finite = np.isfinite(band).all(axis=1)
    if not finite.all():
        value = float(band[~finite][0].sum())
        raise InvalidPointsError(
            f"{int((~finite).sum())} pixels from row {row + 1} on hold values that are not finite "
            f"numbers, such as {value}.",
            where={"row": row + 1},
            remedy="Every value must be a finite number; make what is no picture transparent.",
        )


def _whole(
    band: npt.NDArray[Any], model: str, clipped: list[int], *, linear: bool
) -> npt.NDArray[np.uint16]:
    values = band.astype(np.float64)
    if linear:
        values = np.cbrt(values) * ROOT_STEPS + 2 * ROOT_STEPS
    elif model == "Lab":
        values = values * np.array([652.8, 256.0, 256.0]) + np.array([0.0, 32768.0, 32768.0])
    else:
        values = values * 65535.0
    whole = np.round(values)
    kept = np.clip(whole, 0, 65535)
    clipped[0] += int(np.count_nonzero(whole != kept))
    return kept.astype(np.uint16)
