"""Pictures as characterisation data: the distinct colours of all pixels, and their encoding.

`read_picture` decodes a file, drops transparent pixels, and counts the pixels of each distinct
value. An embedded profile or an `Encoding` gives the values their meaning.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gamutcore.arrays import FloatArray
from gamutcore.characterisation.icc import IccProfile, icc_profile
from gamutcore.characterisation.pictures.distinct_values import MAX_VALUES, distinct_values
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

__all__ = [
    "LARGEST_LIGHT",
    "Picture",
    "divided_by_alpha",
    "picture_meaning",
    "read_picture",
    "refuse_not_finite",
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
        ``"gray"``, ``"RGB"``, ``"CMYK"`` or ``"Lab"``.
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


def read_picture(data: bytes, file_format: str) -> Picture:
    """Return the colours of a picture file.

    Parameters
    ----------
    data : bytes
    file_format : str
        Name of its format, as `picture_format` returns it.

    Raises
    ------
    MalformedFileError
        The file breaks its format or ends early, or its profile fits another colour model.
    PictureSizeError
        The picture has too many pixels or bytes.
    PictureWorkError
        The picture is a JPEG with too many scans.
    UnsupportedPictureError
        The kind of picture is not supported, or it is CMYK without a profile.
    MalformedProfileError, UnsupportedProfileError
        The embedded profile is broken or not supported.
    InvalidPointsError
        A value is not finite, linear light is beyond `LARGEST_LIGHT`, or every pixel is
        transparent.
    """
    with open_raster(data, file_format) as raster:
        return _picture(raster, len(data))


def _picture(raster: Raster, size: int) -> Picture:
    meaning, said = picture_meaning(raster)
    floats = raster.dtype.kind == "f"
    linear = floats and isinstance(meaning, Encoding) and meaning.transfer == "linear"
    clipped = [0]
    found = distinct_values(
        _opaque_values(raster, linear=linear, clipped=clipped),
        raster.width * raster.height,
        len(MODELS[raster.model]),
        LIGHT_BITS if linear else 8 if raster.dtype == np.uint8 else 16,
        most=min(MAX_VALUES, max(FREE_VALUES, size // BYTES_PER_VALUE)),
    )
    values = found.values.astype(np.float64)
    if linear:
        values = ((values - _ROOT_OFFSET) / ROOT_STEPS) ** 3
    elif raster.model == "Lab":
        full, offset, step = (255, 128, 1) if raster.dtype == np.uint8 else (65280, 32768, 256)
        values = np.column_stack([values[:, 0] / full * 100, (values[:, 1:] - offset) / step])
    else:
        values /= 255.0 if raster.dtype == np.uint8 else 65535.0
    if clipped[0]:
        said.append(f"{clipped[0]} channel values beyond the encoding's range were clipped.")
    pixels, used = raster.width * raster.height, int(found.counts.sum())
    provenance: dict[str, JSON] = {
        "format": raster.format,
        "channels": list[JSON](MODELS[raster.model]),
        "size": [raster.width, raster.height],
        "bit_depth": raster.bits,
        "sample_format": "float" if floats else "integer",
        "colour_model": raster.model,
        "pixels": {"read": pixels, "transparent": pixels - used, "used": used},
        "distinct_values": found.distinct,
    }
    if floats:
        provenance["rounding"] = f"cube roots to 1/{ROOT_STEPS}" if linear else "16 bits"
    if found.levels is not None:
        provenance["lattice"] = {"levels": found.levels, "values": len(values)}
        said.append(
            f"Of {found.distinct} distinct values, {len(values)} are used: the outermost one in "
            f"each cell of {found.levels} levels per channel."
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
        found.counts,
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
            f"{float(np.abs(values[beyond]).max()):.3g} × white, more than {LARGEST_LIGHT:.0f}.",
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
    kept = np.clip(whole, 0, 65535)
    clipped[0] += int(np.count_nonzero(whole != kept))
    return kept.astype(np.uint16)
