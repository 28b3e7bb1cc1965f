"""TIFF pictures: what the tags say, and the raster that they make of strips or tiles.

TIFF 6.0 (Adobe 1992), its technical notes 1 to 3, the Photoshop technical notes (2002), and
BigTIFF: gray, RGB, palette, CMYK, YCbCr within JPEG, CIELAB and ICCLAB, of 1 to 16 bits, 32 bits
and floats. The first picture of a file is taken.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from gamutcore.characterisation.pictures.bounds import malformed
from gamutcore.characterisation.pictures.raster import Raster
from gamutcore.characterisation.pictures.tiff_data import Layout, decoded_samples, refused
from gamutcore.characterisation.pictures.tiff_tags import Directory, tiff_directory

__all__ = ["TIFF_SIGNATURES", "tiff_raster"]

TIFF_SIGNATURES = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")

_MODELS = {0: "gray", 1: "gray", 2: "RGB", 3: "RGB", 5: "CMYK", 6: "RGB", 8: "Lab", 9: "Lab"}
"""Colour models by the tag PhotometricInterpretation (262)."""

_WHITE_IS_ZERO, _PALETTE, _YCBCR, _CIELAB = 0, 3, 6, 8
_JPEG = 7

_CHANNELS = {"gray": 1, "RGB": 3, "CMYK": 4, "Lab": 3}
_INTEGER, _SIGNED, _FLOAT = 1, 2, 3


def tiff_raster(data: bytes) -> Raster:
    """Return the pixels of a TIFF file.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    Raster

    Raises
    ------
    MalformedFileError
        A tag, strip or tile is broken, missing or not within the file.
    PictureSizeError
        It has more pixels than are decoded.
    UnsupportedPictureError
        It is of a kind that is not read.
    """
    tags, following = tiff_directory(data, 0)
    photometric = tags.whole(262, 1)
    if photometric not in _MODELS:
        raise refused(
            f"The picture's photometric interpretation is {photometric}.",
            262,
            "Gray, RGB, palette, CMYK, CIELAB and ICCLAB are read.",
        )
    model = _MODELS[photometric]
    layout = _layout(tags, photometric, model)
    samples = decoded_samples(data, tags, layout)
    said = []
    if following:
        said.append("The file holds several pictures; the first is used.")
    colours = 1 if photometric == _PALETTE else _CHANNELS[model]
    raster = Raster(
        "tiff",
        model,
        layout.width,
        layout.height,
        samples.blocks,
        samples.dtype,
        samples.packed,
        full=2 ** min(layout.bits, 16) - 1,
        bits=layout.bits,
        colours=lambda block: block[:, :, :colours],
        profile=tags.content(34675),
        said=said,
    )
    _take_alpha(raster, tags, layout.samples, colours)
    if photometric == _PALETTE:
        _look_up(raster, tags)
    elif photometric == _WHITE_IS_ZERO:
        white = samples.dtype.type(1 if samples.dtype.kind == "f" else raster.full)
        raster.colours = lambda block: white - block[:, :, :colours]
    elif model == "Lab":
        signed = photometric == _CIELAB
        raster.colours = lambda block: _offset_lab(block[:, :, :colours], signed=signed)
    return raster


def _layout(tags: Directory, photometric: int, model: str) -> Layout:
    width, height = tags.whole(256, 0), tags.whole(257, 0)
    count = tags.whole(277, 1)
    bits = tags.numbers(258) or (1,)
    formats = tags.numbers(339) or (_INTEGER,)
    compression = tags.whole(259, 1)
    if len(set(bits)) > 1 or len(set(formats)) > 1:
        raise refused("The picture's channels are of different types.", 258, "One type for all.")
    depth, kind = int(bits[0]), int(formats[0])
    floats = kind == _FLOAT
    if kind == _SIGNED and photometric == _CIELAB:
        kind = _INTEGER  # some writers say so of all channels for the sake of a* and b*
    wrong = (
        depth not in {16, 32, 64} if floats else kind not in {_INTEGER, 4} or not _whole_bits(depth)
    )
    if wrong or (model == "Lab" and depth not in {8, 16, 32}):
        raise refused(
            f"The picture has {depth} bits per channel of the sample format {kind}.",
            258,
            "Whole numbers of 1 to 16 and 32 bits without a sign are read, and floats of 16, 32 "
            "and 64 bits; of Lab those of 8 and 16 bits, and floats.",
        )
    if model == "Lab" and not floats and depth == 32:
        raise refused("Lab of 32-bit whole numbers is not read.", 258, "8 or 16 bits, or floats.")
    needed = 1 if photometric == _PALETTE else _CHANNELS[model]
    if not needed <= count <= 64:
        raise malformed(
            f"The picture has {count} samples per pixel; {model} needs {needed}.", {"tag": "277"}
        )
    if photometric == _PALETTE and (floats or depth > 16):
        raise malformed("A palette needs whole numbers of 16 bits at most.", {"tag": "258"})
    if photometric == _YCBCR and compression != _JPEG:
        raise refused("YCbCr is read in JPEG compression only.", 262, "Save the picture as RGB.")
    if model == "CMYK" and tags.whole(332, 1) != 1:
        raise refused("The inks of the picture are not CMYK.", 332, "CMYK is read of inks.")
    return Layout(
        width,
        height,
        count,
        depth,
        floats=floats,
        planar=tags.whole(284, 1) == 2 and count > 1,
        compression=compression,
        predictor=tags.whole(317, 1),
        reversed_bits=tags.whole(266, 1) == 2,
        photometric=photometric,
    )


def _whole_bits(depth: int) -> bool:
    return 1 <= depth <= 16 or depth == 32


def _take_alpha(raster: Raster, tags: Directory, samples: int, colours: int) -> None:
    """Take the first extra sample that is alpha (TIFF 6.0, section 18)."""
    extra = tags.numbers(338)[: samples - colours]
    for index, meaning in enumerate(extra):
        if meaning in {1, 2}:
            raster.alpha = partial(_channel, colours + index)
            raster.premultiplied = meaning == 1
            raster.alpha_full = 1.0 if raster.dtype.kind == "f" else float(raster.full)
            break
    unused = samples - colours - (raster.alpha is not None)
    if unused:
        raster.said.append(f"{unused} further channels of the picture are not used.")
    if raster.premultiplied and raster.model == "Lab":
        raise refused("Lab that was multiplied by alpha is not read.", 338, "Unassociated alpha.")


def _channel(place: int, block: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return block[:, :, place]


def _look_up(raster: Raster, tags: Directory) -> None:
    """Put the colours of the palette in the place of their numbers."""
    table = np.array(tags.numbers(320))
    size = 2**raster.bits
    if table.shape != (3 * size,) or (table < 0).any() or (table > 65535).any():
        raise malformed(
            f"The palette has {len(table)} values in place of {3 * size}.", {"tag": "320"}
        )
    palette = table.reshape(3, size).T.astype(np.uint16)
    raster.palette = palette
    raster.full = 65535
    raster.notes["indexed"] = True


def _offset_lab(pixels: npt.NDArray[Any], *, signed: bool) -> npt.NDArray[Any]:
    """Return Lab in the one encoding of rasters."""
    if pixels.dtype.kind == "f":
        return pixels
    pixels = pixels.copy()
    if signed:  # CIELAB: a* and b* have a sign; ICCLAB has them offset
        pixels[:, :, 1:] ^= 0x80 if pixels.dtype == np.uint8 else 0x8000
        if pixels.dtype == np.uint16:
            # L* 100 is 65535 here, and 65280 in rasters.
            pixels[:, :, 0] = np.round(pixels[:, :, 0] * (65280 / 65535)).astype(np.uint16)
    return pixels
