"""Rasters: the pixels and metadata of a picture file, read by OpenImageIO or Pillow.

The first bytes give the format. The header is read first, and its size is checked before any pixel
is decoded. Pixels are then decoded some rows at a time. Pillow decodes CMYK JPEG, because
OpenImageIO converts it to RGB, and WebP, GIF and BMP: OpenImageIO 3.2 reports damage in every WebP
still, fails on GIF, and takes the unused byte of BMP for alpha. Both decode in native code: a
hostile file may exhaust memory, crash the process or take long, so callers decode in a worker
process with limits.
"""

from __future__ import annotations

import contextlib
import io
import re
import struct
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from gamutcore.characterisation.pictures.encoding import (
    Encoding,
    bmp_profile,
    declared_encoding,
    embedded_profile,
    exif_colour_space,
    is_narrow_range,
    refuse_film_densities,
    text_attribute,
)
from gamutcore.errors import (
    GamutError,
    MalformedFileError,
    PictureSizeError,
    PictureWorkError,
    UnsupportedPictureError,
    Where,
)
from gamutcore.limits import current_limits
from gamutcore.number_text import number_text

__all__ = [
    "EXTENSIONS",
    "MODELS",
    "Raster",
    "malformed_picture",
    "open_raster",
    "openimageio",
    "picture_format",
]

_SIGNATURES = {
    "png": (b"\x89PNG\r\n\x1a\n",),
    "jpeg": (b"\xff\xd8\xff",),
    "tiff": (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    "exr": (b"v/1\x01",),
    "hdr": (b"#?RADIANCE\n", b"#?RGBE\n"),
    "jpeg-xl": (b"\xff\x0a", b"\0\0\0\x0cJXL \r\n\x87\n"),
    "jpeg-2000": (b"\0\0\0\x0cjP  \r\n\x87\n", b"\xff\x4f\xff\x51"),
    "gif": (b"GIF87a", b"GIF89a"),
    "dpx": (b"SDPX", b"XPDS"),
}

_BMP_HEADER_SIZES = frozenset({12, 40, 52, 56, 64, 108, 124})
"""Sizes of the header that follows the 14 bytes of BMP's file header."""


def picture_format(data: bytes) -> str | None:
    """Return the name of a picture's format, such as ``"jpeg"``; None for other data."""
    if data.startswith(b"RIFF") and data[8:12] == b"WEBP":
        return "webp"
    if data.startswith(b"BM") and int.from_bytes(data[14:18], "little") in _BMP_HEADER_SIZES:
        return "bmp"  # two letters alone may be the start of a text
    return next((name for name, starts in _SIGNATURES.items() if data.startswith(starts)), None)


MAX_DECODED_BYTES = 2**29
"""Maximum size of the decoded pixels in bytes. A picture of 24 megapixels in CMYK or RGBA has
192 MB in 16 bits and 384 MB in 32-bit floats."""

BAND_BYTES = 2**22
"""Bytes of pixels that are decoded at a time."""

MAX_CHANNELS = 64

MAX_SCANS = 100
"""Maximum number of scans of a JPEG. Each takes the time of a pass over the picture, and may have
ten bytes. libjpeg's cjpeg writes at most 100 and by default up to 18, and libtiff reads 100."""

OPENING_SECONDS = 60.0
"""Processor time for opening a picture. Some decoders then decode it, up to 120 megapixels."""

DECODING_SECONDS = 20.0
SECONDS_PER_MEGAPIXEL = 1.0
"""Processor time for reading a picture, with the opening. For each megapixel of 16-bit noise, PNG
takes 0.25 s, JPEG XL 0.5 s and lossless JPEG 2000, the slowest, 0.9 s."""

_TICK = 0.1
"""Seconds between two checks of the time."""

MODELS: dict[str, tuple[str, ...]] = {
    "gray": ("gray",),
    "RGB": ("R", "G", "B"),
    "CMYK": ("C", "M", "Y", "K"),
    "Lab": ("L*", "a*", "b*"),
}
"""Colour models and their channels."""

_TIFF_WHITE_IS_ZERO, _TIFF_BLACK_IS_ZERO = 0, 1
_TIFF_CMYK, _TIFF_CIELAB, _TIFF_ICCLAB = 5, 8, 9
_TIFF_RAW = {_TIFF_CMYK: "CMYK", _TIFF_CIELAB: "Lab", _TIFF_ICCLAB: "Lab"}
"""Values of the TIFF tag PhotometricInterpretation that OpenImageIO must not convert to RGB."""

EXTENSIONS = {
    "png": ".png",
    "jpeg": ".jpg",
    "tiff": ".tif",
    "exr": ".exr",
    "hdr": ".hdr",
    "jpeg-xl": ".jxl",
    "jpeg-2000": ".jp2",
    "dpx": ".dpx",
}
"""Extensions by which OpenImageIO chooses its decoder."""

_BY_PILLOW = frozenset({"webp", "gif", "bmp"})
"""Formats that Pillow decodes. WebP is decoded in one call, after which alone `_TimeLimit` can act:
a megapixel of noise takes 0.06 s, so the largest picture takes 7 s."""

_PILLOW_FAULTS = (
    *(OSError, EOFError, SyntaxError, ValueError, TypeError, LookupError),
    *(struct.error, AssertionError, OverflowError),
)
"""What Pillow raises for damaged files."""

_SEVERAL = "The file holds several pictures; the first is used."

_NO_MEMORY = re.compile(
    r"insufficient memory"  # libjpeg
    r"|memory error|exceeds system limits",  # OpenJPEG, without memory for a tile
    re.IGNORECASE,
)
"""Messages of decoders that were refused memory. Others raise std::bad_alloc."""

_UNSUPPORTED = re.compile(r"unsupported|not supported|no support|not configured", re.IGNORECASE)
"""Words in the messages of decoders about files that are intact, but of an unsupported kind."""

_REMEDY = "Send the whole picture, or save it again."

Band = tuple[int, npt.NDArray[Any], npt.NDArray[Any] | None]
"""First row, colours (n, k) and alpha (n,) of some pixels. Alpha is None without such a channel."""


@dataclass(eq=False)
class Raster:
    """A picture during decoding. `bands` are all its pixels, some rows at a time.

    `model` is a key of `MODELS`. The `dtype` of the pixels is ``uint8`` (full scale 255),
    ``uint16`` (full scale 65535) or a float type. Integer Lab has L* 100 at 255 or 65280, and a*
    and b* with an offset of half the range (ICC.1:2001-04, annex A). In the file, a channel has
    `bits` bits, and `stored` is OpenImageIO's name of the type, such as ``"half"``. `header` is an
    ImageSpec, made from Pillow's metadata if Pillow decodes. CMYK JPEG has neither of the two.
    """

    format: str
    model: str
    width: int
    height: int
    dtype: np.dtype[Any]
    bits: int
    bands: Iterator[Band]
    premultiplied: bool = False
    profile: bytes = b""
    encoding: Encoding | None = None
    warnings: list[str] = field(default_factory=list)
    has_alpha: bool = False
    stored: str = ""
    header: Any = None


def malformed_picture(
    message: str, where: Where | None = None, remedy: str = _REMEDY
) -> MalformedFileError:
    """Return the error for a picture that breaks its format."""
    return MalformedFileError(message, where=where, remedy=remedy)


@contextlib.contextmanager
def open_raster(data: bytes, file_format: str) -> Iterator[Raster]:
    """Read the header of a picture, and yield its raster while the file is open.

    Faults of the file raise errors here or when the bands are read.
    """
    if file_format == "jpeg":
        _check_scans(data)
    with _TimeLimit() as time_limit:
        if file_format in _BY_PILLOW:
            image = _pillow_image(data, file_format)
            time_limit.set_pixels(image.width * image.height)
            yield _pillow_raster(image, data, file_format)
        else:
            with _openimageio_raster(data, file_format, time_limit) as raster:
                yield raster


@contextlib.contextmanager
def _openimageio_raster(data: bytes, file_format: str, time_limit: _TimeLimit) -> Iterator[Raster]:
    with contextlib.ExitStack() as stack:
        # OpenImageIO for Python reads only files. It chooses the decoder by the extension.
        file = stack.enter_context(tempfile.NamedTemporaryFile(suffix=EXTENSIONS[file_format]))
        file.write(data)
        file.flush()
        path = file.name
        source = stack.enter_context(_open(path, file_format, raw=file_format == "tiff"))
        photometric = source.spec().get_int_attribute("tiff:PhotometricInterpretation", -1)
        raw_model = _TIFF_RAW.get(photometric)
        if file_format == "tiff" and raw_model is None:
            source = stack.enter_context(_open(path, file_format))
        spec = source.spec()
        _check_size(spec.width, spec.height, spec.nchannels * spec.format.size())
        time_limit.set_pixels(spec.width * spec.height)
        if spec.deep or spec.depth > 1:
            raise _unsupported("The picture is deep or has several layers of depth.", "format")
        if text_attribute(spec, "jpeg:ColorSpace") in {"CMYK", "YCCK", "YCbCrK"}:
            yield _cmyk_jpeg(data, spec)
            return
        channels, model = _colour_channels(spec, raw_model)
        if file_format == "tiff" and photometric in {_TIFF_WHITE_IS_ZERO, _TIFF_BLACK_IS_ZERO}:
            channels, model = [0], "gray"  # OpenImageIO takes further channels for RGB
        dtype = _sample_type(spec, model)
        bits = int(spec.get_int_attribute("oiio:BitsPerSample", 8 * spec.format.size()))
        raster = Raster(
            file_format,
            model,
            spec.width,
            spec.height,
            dtype,
            data[24] if file_format == "png" else bits,
            iter(()),
            profile=embedded_profile(spec, data, file_format),
        )
        refuse_film_densities(spec)
        raster.encoding, said = declared_encoding(
            spec, data, file_format, has_profile=bool(raster.profile)
        )
        raster.warnings += said
        unused = spec.nchannels - len(channels)
        alpha = spec.alpha_channel if spec.alpha_channel not in channels else -1
        raster.stored, raster.header = str(spec.format), spec
        if alpha >= 0:
            unused -= 1
            raster.has_alpha = True
            # JPEG XL stores straight alpha unless its header says otherwise; OpenImageIO returns
            # the stored values.
            raster.premultiplied = file_format != "jpeg-xl" and not spec.get_int_attribute(
                "oiio:UnassociatedAlpha"
            )
        if raster.premultiplied and model == "Lab":
            raise _unsupported("Lab colours are multiplied by alpha.", "alpha")
        if unused:
            raster.warnings.append(f"{unused} further channels of the picture are not used.")
        convert: Callable[[npt.NDArray[Any]], npt.NDArray[Any]] | None = None
        if raw_model == "Lab" and photometric == _TIFF_CIELAB:
            convert = _offset_lab
        elif file_format == "tiff" and photometric == _TIFF_WHITE_IS_ZERO:
            # OpenImageIO inverts 8 bits only.
            convert = _inverted if raster.dtype != np.uint8 else None
        elif is_narrow_range(spec, file_format):
            convert, raster.dtype = _full_range, np.dtype(np.uint16)
        blocks = _blocks(source, spec, dtype, path, raster.warnings)
        raster.bands = _bands(blocks, channels, alpha, convert)
        if source.seek_subimage(1, 0):
            raster.warnings.append(_SEVERAL)
        source.seek_subimage(0, 0)
        _decoder_message(source)  # clear the error of a seek beyond the only picture
        yield raster


@cache
def openimageio() -> Any:  # noqa: ANN401 (a module)
    """Import OpenImageIO on first use (0.2 s, 20 MB), and set its limits for this process."""
    import OpenImageIO  # noqa: PLC0415

    for name, value in (
        ("threads", 1),
        ("exr_threads", 1),
        ("limits:channels", MAX_CHANNELS),
        # Some decoders work when the file is opened. OpenImageIO checks this limit before.
        ("limits:imagesize_MB", MAX_DECODED_BYTES >> 20),
    ):
        OpenImageIO.attribute(name, value)
    return OpenImageIO


def _decoder_message(owner: Any) -> str:  # noqa: ANN401 (an ImageInput or the module)
    """Return OpenImageIO's message, and clear it; raise MemoryError if it reports lack of memory.

    A decoder may quote bytes of the file that are not UTF-8.
    """
    try:
        message: str = owner.geterror()
    except UnicodeDecodeError as error:
        message = error.object.decode("utf-8", "replace")
    if _NO_MEMORY.search(message):
        raise MemoryError(message)
    return message


@contextlib.contextmanager
def _open(path: str, file_format: str, *, raw: bool = False) -> Iterator[Any]:
    oiio = openimageio()
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    if raw:
        config.attribute("oiio:RawColor", 1)
    source = oiio.ImageInput.open(path, config)
    if source is None:
        problem = _decoder_message(oiio)
        if "exceeds" in problem and "limit" in problem:
            raise PictureSizeError(
                f"The decoded picture would exceed {MAX_DECODED_BYTES / 1e6:.0f} MB.",
                where={"field": "size"},
                remedy="Send a smaller copy.",
            )
        message = f"The {file_format} picture cannot be opened{_detail(problem, path)}."
        if _UNSUPPORTED.search(problem):
            raise _unsupported(message, "header")
        raise malformed_picture(message, {"field": "header"})
    try:
        yield source
    finally:
        source.close()


def _detail(problem: str, path: str) -> str:
    """Return the first line of a decoder's message as part of a sentence."""
    lines = problem.replace(f' ("{path}")', "").replace(path, "the file").strip().splitlines()
    return f": {lines[0].strip().rstrip('.')[:200]}" if lines else ""


def _check_size(width: int, height: int, pixel_bytes: int) -> None:
    if width <= 0 or height <= 0:
        raise malformed_picture(f"The picture has {width} × {height} pixels.", {"field": "size"})
    most, size = current_limits().pixels, width * height * pixel_bytes
    if width * height > most or size > MAX_DECODED_BYTES:
        raise PictureSizeError(
            f"The picture has {width} × {height} pixels, {size / 1e6:.0f} MB when decoded.",
            where={"field": "size"},
            remedy=f"At most {most / 1e6:g} million pixels and {MAX_DECODED_BYTES / 1e6:.0f} MB "
            "are decoded. Send a smaller copy.",
        )


_BETWEEN_MARKERS = re.compile(rb"\xff+([^\x00\xff])", re.DOTALL)
_RESTART_OR_TEM = frozenset({0x01, *range(0xD0, 0xD8)})
_START, _END, _SCAN = 0xD8, 0xD9, 0xDA
"""Codes of JPEG markers (ITU-T T.81, table B.1). The first and the restarts have no segment."""


def _check_scans(data: bytes) -> None:
    """Refuse a JPEG with too many scans. A decoder finds its markers in the same way."""
    scans = place = 0
    while found := _BETWEEN_MARKERS.search(data, place):
        code, place = found[1][0], found.end()
        if code == _END:
            return
        if code in _RESTART_OR_TEM or code == _START:
            continue
        scans += code == _SCAN
        if scans > MAX_SCANS:
            raise PictureWorkError(
                f"The JPEG has more than {MAX_SCANS} scans.",
                where={"field": "scans"},
                remedy="Save the picture again, as baseline or usual progressive JPEG.",
            )
        place += int.from_bytes(data[place : place + 2], "big")


class _TimeLimit:
    """Limits the processor time of decoding while it is open, if `Limits.overtime` is set."""

    def __init__(self) -> None:
        self._seconds = OPENING_SECONDS
        self._pixels = 0
        self._started = time.process_time()
        self._ended = threading.Event()
        self._overtime = current_limits().overtime

    def __enter__(self) -> Self:
        if self._overtime is not None:
            threading.Thread(target=self._watch, args=(self._overtime,), daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()

    def set_pixels(self, pixels: int) -> None:
        """Set the limit by the size of the picture, which is known once it is open."""
        self._pixels = pixels
        self._seconds = DECODING_SECONDS + SECONDS_PER_MEGAPIXEL * pixels / 1e6

    def _watch(self, overtime: Callable[[GamutError], None]) -> None:
        while not self._ended.wait(_TICK):
            if time.process_time() - self._started > self._seconds:
                size = (
                    f"{number_text(self._pixels / 1e6, 3)} megapixels"
                    if self._pixels
                    else "its header"
                )
                overtime(
                    PictureWorkError(
                        f"Decoding {size} of the picture took more than {self._seconds:.3g} s.",
                        where={"field": "data"},
                        remedy="Save the picture again, as PNG, TIFF or baseline JPEG.",
                    )
                )
                return


def _unsupported(message: str, field: str, remedy: str = "") -> UnsupportedPictureError:
    return UnsupportedPictureError(
        message,
        where={"field": field},
        remedy=remedy or "Send gray, RGB, CMYK or CIELAB pixels of 8 or 16 bits, or floats.",
    )


def _colour_channels(spec: Any, raw_model: str | None) -> tuple[list[int], str]:  # noqa: ANN401
    """Return the indices of the colour channels, and the colour model."""
    names = [name.rpartition(".")[2].upper() for name in spec.channelnames]
    if raw_model is not None:
        if raw_model == "CMYK" and names[:4] != list("CMYK"):
            raise _unsupported("The inks of the picture are not C, M, Y, K.", "channels")
        if len(names) < len(MODELS[raw_model]):
            raise malformed_picture(
                f"The picture has {len(names)} channels; {raw_model} needs "
                f"{len(MODELS[raw_model])}.",
                {"field": "channels"},
            )
        return list(range(len(MODELS[raw_model]))), raw_model
    if {"R", "G", "B"} <= set(names):
        return [names.index(name) for name in "RGB"], "RGB"
    if "RY" not in names and "CB" not in names:
        for name in ("Y", "Y'", "L", "I"):
            if name in names:
                return [names.index(name)], "gray"
        if len(set(names) - {"A"}) == 1 and names[0] != "Z":
            return [0 if names[0] != "A" else 1], "gray"
    shown = ", ".join(spec.channelnames[:8])
    raise _unsupported(f"The picture has the channels {shown[:100]}.", "channels")


def _sample_type(spec: Any, model: str) -> np.dtype[Any]:  # noqa: ANN401 (an ImageSpec)
    """Return the type that samples are read as.

    64-bit floats are refused: OpenImageIO 3.2 returns undefined values for them in TIFF files
    without compression.
    """
    stored = str(spec.format)
    known = {
        "uint8": "uint8",
        "uint16": "uint16",
        "uint": "uint16",
        "half": "float32",
        "float": "float32",
    }
    if model == "Lab":
        # Some writers declare all channels of Lab as signed, because a* and b* are.
        known |= {"int8": "uint8", "int16": "uint16"}
        known.pop("uint")
    if stored not in known:
        raise _unsupported(f"The samples of the picture have the type {stored}.", "bits")
    return np.dtype(known[stored])


def _blocks(
    source: Any,  # noqa: ANN401 (an ImageInput)
    spec: Any,  # noqa: ANN401 (an ImageSpec)
    dtype: np.dtype[Any],
    path: str,
    said: list[str],
) -> Iterator[tuple[int, npt.NDArray[Any]]]:
    """Yield the first row and the samples (rows, columns, channels) of some rows at a time."""
    stored = str(spec.format)
    wanted = stored if stored.startswith("int") else dtype.name.replace("float32", "float")
    step = max(1, BAND_BYTES // (spec.width * spec.nchannels * dtype.itemsize))
    chunk = spec.tile_height or 1
    step = max(chunk, step // chunk * chunk)
    right, bottom = spec.x + spec.width, spec.y + spec.height
    for top in range(spec.y, bottom, step):
        end = min(top + step, bottom)
        if spec.tile_width:
            block = source.read_tiles(
                0, 0, spec.x, right, top, end, 0, 1, 0, spec.nchannels, wanted
            )
        else:
            block = source.read_scanlines(0, 0, top, end, 0, 0, spec.nchannels, wanted)
        problem = _decoder_message(source)
        row = top - spec.y + 1
        if block is None or "Premature end" in problem:
            message = f"The pixels from row {row} on cannot be decoded{_detail(problem, path)}."
            if _UNSUPPORTED.search(problem):
                raise _unsupported(message, "data")
            raise malformed_picture(message, {"row": row})
        if problem and not said:
            said.append(f"The decoder reports damage near row {row}{_detail(problem, path)}.")
        yield top - spec.y, block.reshape(end - top, spec.width, spec.nchannels).view(dtype)


def _bands(
    blocks: Iterator[tuple[int, npt.NDArray[Any]]],
    channels: list[int],
    alpha: int,
    convert: Callable[[npt.NDArray[Any]], npt.NDArray[Any]] | None,
) -> Iterator[Band]:
    for top, block in blocks:
        samples = block.reshape(-1, block.shape[2])
        # A slice is a view; a list of channels would copy.
        whole = channels == list(range(channels[0], channels[0] + len(channels)))
        colours = samples[:, channels[0] : channels[-1] + 1] if whole else samples[:, channels]
        yield (
            top,
            colours if convert is None else convert(colours),
            None if alpha < 0 else samples[:, alpha],
        )


def _offset_lab(colours: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return CIELAB with signed a* and b* as ICCLAB, which has offsets."""
    if colours.dtype.kind == "f":
        return colours
    offset = colours.copy()
    offset[:, 1:] ^= 0x80 if offset.dtype == np.uint8 else 0x8000
    if offset.dtype == np.uint16:  # L* 100 is 65535 in CIELAB and 65280 in ICCLAB
        offset[:, 0] = np.round(offset[:, 0] * (65280 / 65535)).astype(np.uint16)
    return offset


def _inverted(colours: npt.NDArray[Any]) -> npt.NDArray[Any]:
    full: Any = 1.0 if colours.dtype.kind == "f" else np.iinfo(colours.dtype).max
    inverted: npt.NDArray[Any] = full - colours
    return inverted


def _full_range(colours: npt.NDArray[Any]) -> npt.NDArray[np.uint16]:
    """Return narrow-range values (16 to 235 of 8 bits) as full-range values of 16 bits."""
    unit = 1 if colours.dtype == np.uint8 else 256
    table = (np.arange(256 * unit) / unit - 16) / 219 * 65535
    wide: npt.NDArray[np.uint16] = np.clip(np.round(table), 0, 65535).astype(np.uint16)[colours]
    return wide


def _cmyk_jpeg(data: bytes, spec: Any) -> Raster:  # noqa: ANN401 (an ImageSpec)
    """Return the raster of a CMYK JPEG, decoded by Pillow."""
    from PIL.JpegImagePlugin import JpegImageFile  # noqa: PLC0415  # 3 MB, and rarely needed

    # The class does not warn of large pictures, as PIL.Image.open does.
    with _pillow_faults():
        decoded: Any = JpegImageFile(io.BytesIO(data))
        decoded.load()
    said = []
    if "adobe" not in decoded.info:
        said.append("CMYK without Adobe's marker: 0 is assumed to be full ink, as Adobe writes it.")
    return Raster(
        "jpeg",
        "CMYK",
        spec.width,
        spec.height,
        np.dtype(np.uint8),
        8,
        _pillow_bands(decoded),
        profile=embedded_profile(spec, data, "jpeg"),
        warnings=said,
    )


@contextlib.contextmanager
def _pillow_faults() -> Iterator[None]:
    """Turn Pillow's errors into those of this module."""
    from PIL.Image import DecompressionBombError, DecompressionBombWarning  # noqa: PLC0415

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DecompressionBombWarning)  # the size is checked here
            yield
    except DecompressionBombError as error:
        raise PictureSizeError(
            "A frame of the picture has too many pixels.",
            where={"field": "size"},
            remedy="Send a smaller copy.",
        ) from error
    except _PILLOW_FAULTS as error:
        raise malformed_picture(
            "The pixels are damaged or end early.", {"field": "data"}
        ) from error


def _pillow_image(data: bytes, file_format: str) -> Any:  # noqa: ANN401 (a PIL.Image.Image)
    """Return a picture whose header is read and whose pixels are not decoded yet."""
    from PIL.BmpImagePlugin import BmpImageFile  # noqa: PLC0415
    from PIL.GifImagePlugin import GifImageFile  # noqa: PLC0415
    from PIL.WebPImagePlugin import WebPImageFile  # noqa: PLC0415

    plugins: dict[str, Any] = {"webp": WebPImageFile, "gif": GifImageFile, "bmp": BmpImageFile}
    if file_format != "bmp":  # Pillow reserves memory for these when it reads the header
        _check_size(*_stated_size(data, file_format), 4)
    with _pillow_faults():
        image = plugins[file_format](io.BytesIO(data))
    _check_size(image.width, image.height, 4)
    return image


def _stated_size(data: bytes, file_format: str) -> tuple[int, int]:
    """Return the width and height in the header of a WebP (RFC 9649, 2.5 to 2.7) or GIF file."""
    header = data[:30].ljust(30, b"\0")
    if file_format == "gif":
        width, height = struct.unpack_from("<HH", header, 6)
        return width, height
    kind = header[12:16]
    if kind == b"VP8X":
        width, height = (int.from_bytes(header[place : place + 3], "little") for place in (24, 27))
        return width + 1, height + 1
    if kind == b"VP8L":
        packed = int.from_bytes(header[21:25], "little")
        return (packed & 0x3FFF) + 1, (packed >> 14 & 0x3FFF) + 1
    if kind != b"VP8 ":
        raise malformed_picture("The first chunk of the WebP file is unknown.", {"field": "header"})
    width, height = struct.unpack_from("<HH", header, 26)
    return width & 0x3FFF, height & 0x3FFF


def _pillow_raster(image: Any, data: bytes, file_format: str) -> Raster:  # noqa: ANN401
    """Return the raster of the first frame of an opened picture."""
    gray = image.mode in {"1", "L", "LA"}
    has_alpha = image.has_transparency_data
    names = [*("Y" if gray else "RGB"), *("A" if has_alpha else "")]
    spec = openimageio().ImageSpec(image.width, image.height, len(names), "uint8")
    spec.channelnames = names
    said = []
    with _pillow_faults():
        mode = "".join(names).replace("Y", "L")
        first = image.convert(mode)  # a copy: the search for a second frame changes the image
        profile = image.info.get("icc_profile") or b""
        space = exif_colour_space(image.getexif()) if file_format == "webp" else 0
        if getattr(image, "is_animated", False):
            said.append(_SEVERAL)
    if file_format == "bmp":
        profile = bmp_profile(data)
    if space:
        spec.attribute("Exif:ColorSpace", space)
    raster = Raster(
        file_format,
        "gray" if gray else "RGB",
        first.width,
        first.height,
        np.dtype(np.uint8),
        8,
        _pillow_bands(first, has_alpha=has_alpha),
        profile=profile,
        warnings=said,
        has_alpha=has_alpha,
        stored="uint8",
        header=spec,
    )
    raster.encoding, _ = declared_encoding(spec, data, file_format, has_profile=bool(profile))
    return raster


def _pillow_bands(image: Any, *, has_alpha: bool = False) -> Iterator[Band]:  # noqa: ANN401
    """Yield the pixels of a decoded picture. Alpha, if any, is the last channel."""
    channels = len(image.getbands())
    rows = max(1, BAND_BYTES // (channels * image.width))
    for top in range(0, image.height, rows):
        box = (0, top, image.width, min(top + rows, image.height))
        samples = np.asarray(image.crop(box)).reshape(-1, channels)
        if has_alpha:
            yield top, samples[:, :-1], samples[:, -1]
        else:
            yield top, samples, None
