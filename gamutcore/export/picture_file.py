"""Picture files: PNG of arrays, and rows of pixels in the encoding of another picture."""

from __future__ import annotations

import os
import shutil
import struct
import tempfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from gamutcore.characterisation.pictures import (
    EXTENSIONS,
    SRGB,
    Encoding,
    open_raster,
    openimageio,
    picture_meaning,
)
from gamutcore.errors import OptionError, UnsupportedPictureError

if TYPE_CHECKING:
    from gamutcore.characterisation.pictures import Raster

__all__ = [
    "DEPTHS",
    "WRITTEN",
    "Depth",
    "atomic_write",
    "check_written",
    "device_writer",
    "in_encoding",
    "picture_writer",
    "png",
    "with_depth",
]

COLOUR_TYPES = {1: 0, 3: 2, 4: 6}
"""PNG's colour types by the number of channels (11.2.2): gray, truecolour, and with alpha."""

PERCEPTUAL = b"\0"
"""Content of PNG's chunk sRGB: the perceptual intent (11.3.2.5)."""


def png(pixels: NDArray[np.uint8], level: int = 9, texts: Mapping[str, str] | None = None) -> bytes:
    """Return sRGB pixels (rows, columns, 1, 3 or 4) from the top as PNG (ISO/IEC 15948).

    A fourth channel is alpha. `level` is that of the compression, 0 to 9. `texts` are textual data
    by keywords of at most 79 Latin characters (11.3.3).
    """
    rows, columns, channels = pixels.shape
    lines = np.zeros((rows, channels * columns + 1), np.uint8)  # each with the filter type 0
    lines[:, 1:] = pixels.reshape(rows, -1)
    header = struct.pack(">2I5B", columns, rows, 8, COLOUR_TYPES[channels], 0, 0, 0)
    content = zlib.compress(lines.tobytes(), level)
    # iTXt without compression and language (11.3.3.4)
    entries = [
        (b"iTXt", keyword.encode("latin-1") + bytes(5) + text.encode())
        for keyword, text in (texts or {}).items()
    ]
    chunks = (
        (b"IHDR", header),
        (b"sRGB", PERCEPTUAL),
        *entries,
        (b"IDAT", content),
        (b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )


Depth = Literal["8", "16", "half", "float"]

WRITTEN = {".png": "png", ".tif": "tiff", ".tiff": "tiff", ".exr": "exr", ".jpg": "jpeg"}
"""Formats that are written, by the suffix of the file."""

DEPTHS: dict[str, tuple[str, type[np.generic]]] = {
    "8": ("uint8", np.uint8),
    "16": ("uint16", np.uint16),
    "half": ("half", np.float32),
    "float": ("float", np.float32),
}
"""Depths by name: OpenImageIO's type of the samples in the file, and the type in memory."""

_COLOUR = ("CICP", "chromaticities", "oiio:ColorSpace", "colorInteropID", "Exif:ColorSpace")
_KEPT = (
    *_COLOUR,
    *("Orientation", "XResolution", "YResolution", "ResolutionUnit", "PixelAspectRatio"),
)
"""Attributes of the header that are written as they were read."""

_LOSSLESS = ("none", "lzw", "packbits", "zip")
"""Compressions of TIFF that are kept."""

LARGEST_DENSITY = 4e6
"""Maximum pixels per inch or centimetre in TIFF, whose numbers are ratios of 32 bits."""

PNG_LEVEL = 1
"""Compression of PNG: a quarter of the time of the usual level 6, and files 9 % larger (measured on
3 megapixels of smooth noise: 0.5 s instead of 2.0)."""


def with_depth(like: Raster, depth: Depth | None, path: Path) -> Raster:
    """Return how a picture is written: a raster with another type of samples, without its bands.

    Without a depth, that of the picture is kept; half floats become floats in TIFF, which has no
    half floats. Integers have straight alpha. Integers of a picture in linear light are sRGB.
    """
    if depth is None and like.stored == "half" and WRITTEN.get(path.suffix.lower()) == "tiff":
        depth = "float"
    if depth is None:
        return like
    if depth not in DEPTHS:
        raise OptionError(
            f"There is no depth {depth!r}.",
            where={"field": "depth"},
            remedy=f"Give one of {', '.join(DEPTHS)}.",
        )
    stored, dtype = DEPTHS[depth]
    made = replace(like, stored=stored, dtype=np.dtype(dtype), bands=iter(()))
    if made.dtype.kind == "f":
        return made
    made.premultiplied = False
    meaning, _ = picture_meaning(like)
    if isinstance(meaning, Encoding) and meaning.transfer == "linear":
        made.encoding = SRGB
        made.header = openimageio().ImageSpec(like.header)
        for name in _COLOUR:
            made.header.erase_attribute(name)
        made.header.attribute("oiio:ColorSpace", "srgb_rec709_scene")
    return made


def in_encoding(like: Raster, meaning: Encoding | bytes) -> Raster:
    """Return how a picture is written in another encoding of RGB, or with another profile.

    Linear light is stated by its chromaticities, as OpenEXR files do.
    """
    made = replace(like, model="RGB", bands=iter(()), profile=b"", encoding=None)
    made.header = openimageio().ImageSpec(like.header)
    for name in _COLOUR:
        made.header.erase_attribute(name)
    if isinstance(meaning, bytes):
        made.profile = meaning
        return made
    made.encoding = meaning
    corners = np.ravel((*meaning.primaries, meaning.white)).tolist()
    made.header.attribute("chromaticities", "float[8]", corners)
    return made


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield a file that takes the place of `path` at the end, and not after an exception."""
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".picture-") as folder:
        draft = Path(folder) / path.name
        yield draft
        os.replace(draft, path)  # noqa: PTH105  # Path.replace resolves nothing more


@contextmanager
def picture_writer(path: Path, like: Raster) -> Iterator[Callable[[int, int, NDArray[Any]], None]]:
    """Open a picture of red, green and blue for writing, and put it in its place at the end.

    The suffix chooses the format. `like` gives size, type of the samples, alpha and encoding; see
    `with_depth`. The yielded function writes rows: the first row, the row after the last, and
    samples (pixels, channels). A format that cannot store them raises UnsupportedPictureError.
    """
    suffix = path.suffix.lower()
    check_written(path)
    oiio = openimageio()
    names = ["R", "G", "B", *("A" if like.has_alpha else "")]
    spec = oiio.ImageSpec(like.width, like.height, len(names), like.stored)
    spec.channelnames = names
    spec.alpha_channel = 3 if like.has_alpha else -1
    for each in like.header.extra_attribs:
        if each.name in _KEPT:
            spec.attribute(each.name, each.type, each.value)
    if like.profile:
        profile: Any = np.frombuffer(like.profile, np.uint8)
        spec.attribute("ICCProfile", f"uint8[{len(profile)}]", profile)
    if like.has_alpha and not like.premultiplied:
        spec.attribute("oiio:UnassociatedAlpha", 1)
    if WRITTEN[suffix] == "jpeg":
        spec.attribute("Compression", "jpeg:95")
    if WRITTEN[suffix] == "png":
        spec.attribute("png:compressionLevel", PNG_LEVEL)
    compression = like.header.get_string_attribute("compression")
    if WRITTEN[suffix] == like.format == "tiff" and compression in _LOSSLESS:
        spec.attribute("compression", compression)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".picture-") as folder:
        # the reader knows a format by its usual extension
        draft = Path(folder) / f"picture{EXTENSIONS[WRITTEN[suffix]]}"
        output = oiio.ImageOutput.create(str(draft))
        if output is None or not output.open(str(draft), spec):
            raise _refusal(f"The picture cannot be written: {(output or oiio).geterror()}")
        stored = output.spec()
        if str(stored.format) != like.stored or stored.nchannels != len(names):
            output.close()
            raise _refusal(
                f"A {WRITTEN[suffix]} file cannot store {like.stored} samples"
                f"{' with alpha' if like.has_alpha else ''}.",
                "Give the depth 8 or 16, or write OpenEXR or TIFF."
                if like.dtype.kind == "f"
                else _REMEDY,
            )

        def write(first: int, end: int, samples: NDArray[Any]) -> None:
            rows = samples.reshape(end - first, like.width, len(names))
            if not output.write_scanlines(first, end, 0, rows):
                raise OSError(f"The picture cannot be written: {output.geterror()}")

        try:
            yield write
        finally:
            closed = output.close()
        if not closed:
            raise OSError(f"The picture cannot be written: {output.geterror()}")
        _check(draft, WRITTEN[suffix], like)
        os.replace(draft, path)  # noqa: PTH105  # Path.replace resolves nothing more


_SEPARATED, _RGB, _DEFLATE, _CMYK_INKS, _OTHER_INKS = 5, 2, 8, 1, 2
"""Values of PhotometricInterpretation, Compression and InkSet (TIFF 6.0, section 16; TIFF
Specification Supplement 2, 2002)."""


@contextmanager
def device_writer(
    path: Path, like: Raster, channels: Sequence[str], *, inks: bool
) -> Iterator[Callable[[int, int, NDArray[Any]], None]]:
    """Open a TIFF of device values for writing, as `picture_writer`.

    Inks are separated colours, 0 for no ink (TIFF 6.0, section 16). OpenImageIO writes these with 8
    bits alone, and without the names of further inks. Pillow writes the fields. All calls but the
    last have equally many rows, which are a strip.
    """
    from PIL.ExifTags import Base as Tag  # noqa: PLC0415  # few pictures become device values
    from PIL.TiffImagePlugin import ImageFileDirectory_v2  # noqa: PLC0415

    check_written(path, device=True)
    header = like.header
    fields = ImageFileDirectory_v2()
    fields[Tag.ImageWidth], fields[Tag.ImageLength] = like.width, like.height
    fields[Tag.SamplesPerPixel] = len(channels)
    fields[Tag.BitsPerSample] = (8 * like.dtype.itemsize,) * len(channels)
    fields[Tag.Compression] = _DEFLATE
    fields[Tag.PhotometricInterpretation] = _SEPARATED if inks else _RGB
    fields[Tag.Orientation] = header.get_int_attribute("Orientation", 1)
    for tag in (Tag.XResolution, Tag.YResolution):
        density = header.get_float_attribute(tag.name, 0.0)
        if density > 0:
            fields[tag] = min(density, LARGEST_DENSITY)
            is_metric = header.get_string_attribute("ResolutionUnit") == "cm"
            fields[Tag.ResolutionUnit] = 3 if is_metric else 2
    if inks:
        is_cmyk = [name.upper()[:1] for name in channels] == list("CMYK")
        fields[Tag.InkSet] = _CMYK_INKS if is_cmyk else _OTHER_INKS
        fields[Tag.NumberOfInks] = len(channels)
        if not is_cmyk:
            fields[Tag.InkNames] = "\0".join(channels)
    if like.profile:
        fields[Tag.InterColorProfile] = like.profile
    with atomic_write(path) as draft, tempfile.TemporaryFile(dir=draft.parent) as strips:
        sizes: list[int] = []

        def write(first: int, end: int, samples: NDArray[Any]) -> None:
            if first == 0:
                fields[Tag.RowsPerStrip] = end
            stored = samples.astype(samples.dtype.newbyteorder("<"), copy=False)
            sizes.append(strips.write(zlib.compress(stored.tobytes(), PNG_LEVEL)))

        yield write
        # offsets are counted from the end of the fields
        fields[Tag.StripOffsets] = tuple(accumulate(sizes[:-1], initial=0))
        fields[Tag.StripByteCounts] = tuple(sizes)
        with draft.open("wb") as file:
            fields.save(file)
            strips.seek(0)
            shutil.copyfileobj(strips, file)


def _check(draft: Path, file_format: str, like: Raster) -> None:
    """Refuse a file whose values mean something else than those of the picture."""
    with open_raster(draft.read_bytes(), file_format) as raster:
        meanings = [picture_meaning(each)[0] for each in (raster, like)]
        if raster.profile != like.profile or (not like.profile and meanings[0] != meanings[1]):
            raise _refusal(f"A {file_format} file cannot state the encoding of the picture.")
        if raster.has_alpha != like.has_alpha or raster.premultiplied != like.premultiplied:
            raise _refusal(f"A {file_format} file cannot store the alpha of the picture.")


_REMEDY = "Write the format of the picture itself, or PNG or TIFF."


def check_written(path: Path, *, device: bool = False) -> None:
    """Refuse a file whose suffix is of no format of pictures, or of device values."""
    suffix = path.suffix.lower()
    if device and WRITTEN.get(suffix) != "tiff":
        raise _refusal("Device values are written as TIFF.", "Give a .tif file.")
    if suffix not in WRITTEN:
        raise _refusal(f"Pictures are not written as {suffix or 'files without a suffix'}.")


def _refusal(message: str, remedy: str = _REMEDY) -> UnsupportedPictureError:
    return UnsupportedPictureError(message, where={"field": "output"}, remedy=remedy)
