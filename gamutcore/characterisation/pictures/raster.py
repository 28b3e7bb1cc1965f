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
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from gamutcore.characterisation.pictures.containers import (
    JPEG_SCAN,
    TIFF_EXTRA_SAMPLES,
    TIFF_INK_NAMES,
    TIFF_INK_SET,
    bmp_profile,
    embedded_profile,
    has_gain_map,
    holds_several_jpegs,
    jpeg_segments,
    radiance_lines,
    tiff_fields,
)
from gamutcore.characterisation.pictures.encoding import (
    D65,
    EQUAL_ENERGY,
    Encoding,
    declared_encoding,
    exif_colour_space,
    is_narrow_range,
    refuse_film_densities,
    text_attribute,
    tristimulus_encoding,
)
from gamutcore.characterisation.pictures.layers import chosen_layer, exr_layers, layer_warning
from gamutcore.errors import (
    GamutError,
    MalformedFileError,
    OptionError,
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
    "XYZ": ("X", "Y", "Z"),
}
"""Colour models and their channels. X, Y, Z are divided by those of the encoding's white."""

_TIFF_WHITE_IS_ZERO, _TIFF_BLACK_IS_ZERO = 0, 1
_TIFF_CMYK, _TIFF_CIELAB, _TIFF_ICCLAB = 5, 8, 9
_OTHER_INKS = 2
"""Value of the TIFF tag InkSet for inks that InkNames names."""
_MORE_INKS = re.compile(r"[5-9A-F]CLR")
"""Colour space signatures of profiles for more than four inks."""
_D65 = D65, "D65"
_XYZE, _RGBE = "32-bit_rle_xyze", "32-bit_rle_rgbe"
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

_GAIN_MAP = (
    "The gain map of the picture is not used: the colours are those without it, of standard range."
)

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


_Conversion = Callable[[npt.NDArray[Any]], npt.NDArray[Any]]


@dataclass(eq=False)
class Raster:
    """A picture during decoding. `bands` are all its pixels, some rows at a time.

    `model` is a key of `MODELS`. The `dtype` of the pixels is ``uint8`` (full scale 255),
    ``uint16`` (full scale 65535) or a float type. Integer Lab has L* 100 at 255 or 65280, and a*
    and b* with an offset of half the range (ICC.1:2001-04, annex A). In the file, a channel has
    `bits` bits, and `stored` is OpenImageIO's name of the type, such as ``"half"``. `header` is an
    ImageSpec, made from Pillow's metadata if Pillow decodes. That of CMYK JPEG is empty.
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
def open_raster(data: bytes, file_format: str, layer: str | None = None) -> Iterator[Raster]:
    """Read the header of a picture, and yield its raster while the file is open.

    `layer` names a layer of OpenEXR. Faults of the file raise errors here or when the bands are
    read.
    """
    if layer is not None and file_format != "exr":
        raise OptionError.not_applicable("layer", layer, "only OpenEXR files have layers")
    if file_format == "jpeg":
        _check_scans(data)
    with _TimeLimit() as time_limit:
        if file_format in _BY_PILLOW:
            yield _pillow_raster(data, file_format, time_limit)
        else:
            with _openimageio_raster(data, file_format, time_limit, layer) as raster:
                if has_gain_map(data, file_format):
                    raster.warnings.append(_GAIN_MAP)
                elif file_format == "jpeg" and holds_several_jpegs(data):
                    raster.warnings.append(_SEVERAL)
                yield raster


@contextlib.contextmanager
def _openimageio_raster(
    data: bytes, file_format: str, time_limit: _TimeLimit, layer_name: str | None
) -> Iterator[Raster]:
    with contextlib.ExitStack() as stack:
        # OpenImageIO for Python reads only files. It chooses the decoder by the extension.
        file = stack.enter_context(tempfile.NamedTemporaryFile(suffix=EXTENSIONS[file_format]))
        is_xyze = file_format == "hdr" and ("FORMAT", _XYZE) in radiance_lines(data)
        # OpenImageIO refuses X, Y, Z with a common exponent; the bytes are stored as those of RGB.
        file.write(data.replace(_XYZE.encode(), _RGBE.encode(), 1) if is_xyze else data)
        file.flush()
        path = file.name
        source = stack.enter_context(_open(path, file_format, raw=file_format == "tiff"))
        photometric = source.spec().get_int_attribute("tiff:PhotometricInterpretation", -1)
        raw_model = _TIFF_RAW.get(photometric)
        if file_format == "tiff" and raw_model is None:
            source = stack.enter_context(_open(path, file_format))
        part, samples, said = 0, None, list[str]()
        if file_format == "exr":
            part, samples, said = _layer_samples(source, layer_name)
        spec = source.spec()
        _check_size(spec.width, spec.height, spec.nchannels * spec.format.size())
        time_limit.set_pixels(spec.width * spec.height)
        if spec.deep or spec.depth > 1:
            raise _unsupported("The picture is deep or has several layers of depth.", "format")
        if text_attribute(spec, "jpeg:ColorSpace") in {"CMYK", "YCCK", "YCbCrK"}:
            yield _cmyk_jpeg(data, spec)
            return
        profile = embedded_profile(spec, data, file_format)
        if raw_model == "CMYK":
            samples = _ink_samples(spec, tiff_fields(data), profile, said)
        elif samples is None:
            samples = _colour_samples(spec, file_format, raw_model, photometric)
        if is_xyze:
            samples.model = "XYZ"
        dtype = _sample_type(spec, samples)
        bits = int(spec.get_int_attribute("oiio:BitsPerSample", 8 * spec.format.size()))
        refuse_film_densities(spec)
        encoding, more = declared_encoding(spec, data, file_format, has_profile=bool(profile))
        raster = Raster(
            file_format,
            samples.model,
            spec.width,
            spec.height,
            dtype,
            data[24] if file_format == "png" else bits,
            iter(()),
            premultiplied=samples.is_premultiplied,
            profile=profile,
            encoding=encoding,
            warnings=[*said, *more, *samples.warnings],
            has_alpha=samples.alpha >= 0,
            stored=str(spec.format),
            header=spec,
        )
        if raster.premultiplied and raster.model == "Lab":
            raise _unsupported("Lab colours are multiplied by alpha.", "alpha")
        convert: _Conversion | None = None
        if raster.model == "XYZ":
            convert = _tristimulus(raster, *((EQUAL_ENERGY, "equal energy") if is_xyze else _D65))
        elif file_format == "tiff":
            # OpenImageIO inverts 8 bits only
            inverts = raster.dtype != np.uint8
            convert = {
                _TIFF_CIELAB: _offset_lab,
                _TIFF_WHITE_IS_ZERO: _inverted if inverts else None,
            }.get(photometric)
        elif is_narrow_range(spec, file_format):
            convert, raster.dtype = _full_range, np.dtype(np.uint16)
        blocks = _blocks(source, spec, part, dtype, path, raster.warnings)
        raster.bands = _bands(blocks, samples.channels, samples.alpha, convert)
        if file_format != "exr" and source.seek_subimage(1, 0):
            raster.warnings.append(_SEVERAL)
        source.seek_subimage(part, 0)
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


def _check_scans(data: bytes) -> None:
    """Refuse a JPEG with too many scans."""
    scans = 0
    for code, _, _ in jpeg_segments(data):
        scans += code == JPEG_SCAN
        if scans > MAX_SCANS:
            raise PictureWorkError(
                f"The JPEG has more than {MAX_SCANS} scans.",
                where={"field": "scans"},
                remedy="Save the picture again, as baseline or usual progressive JPEG.",
            )


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


@dataclass
class _Samples:
    """The indices of a picture's colour channels and alpha, -1 without it, and what is not used."""

    model: str
    channels: list[int]
    alpha: int = -1
    is_premultiplied: bool = False
    unused: int = 0
    unused_names: tuple[str, ...] = ()

    @property
    def warnings(self) -> list[str]:
        """A warning about channels that are not used."""
        if not self.unused:
            return []
        names = ", ".join(name[:40] for name in self.unused_names)
        what, verb = ("channel", "is") if self.unused == 1 else ("channels", "are")
        title = f" ({names})" if names else ""
        return [f"{self.unused} further {what} of the picture{title} {verb} not used."]


def _layer_samples(
    source: Any,  # noqa: ANN401 (an ImageInput)
    name: str | None,
) -> tuple[int, _Samples | None, list[str]]:
    """Return the part of an OpenEXR file with the layer to read, its samples, and warnings.

    The samples are None if all parts are deep. The source is left at the part.
    """
    layers = exr_layers(source)
    _decoder_message(source)  # clear the error of a seek beyond the last part
    if not layers:
        return 0, None, []
    layer = chosen_layer(layers, name)
    source.seek_subimage(layer.part, 0)
    samples = _Samples(
        layer.model, list(layer.channels), layer.alpha, layer.alpha >= 0, layer.unused
    )
    return layer.part, samples, layer_warning(layers, layer)


_INK_NAMES = {
    "C": re.compile(r"(process\W*)?c(yan)?", re.IGNORECASE),
    "M": re.compile(r"(process\W*)?m(agenta)?", re.IGNORECASE),
    "Y": re.compile(r"(process\W*)?y(ellow)?", re.IGNORECASE),
    "K": re.compile(r"(process\W*)?(k|key|black)", re.IGNORECASE),
}


def _ink_samples(
    spec: Any,  # noqa: ANN401 (an ImageSpec)
    fields: Mapping[int, tuple[int, ...] | bytes],
    profile: bytes,
    said: list[str],
) -> _Samples:
    """Return the channels of separated inks (TIFF 6.0, section 16), and add warnings.

    The last samples are those that ExtraSamples lists: spot colours, or alpha. InkSet 1 is C, M,
    Y, K in this order. Other sets are named by InkNames.
    """
    extra = tuple(fields.get(TIFF_EXTRA_SAMPLES, ()))[: spec.nchannels]
    inks = spec.nchannels - len(extra)
    names: list[str] = []
    text = fields.get(TIFF_INK_NAMES, b"")
    if _OTHER_INKS in fields.get(TIFF_INK_SET, ()) and isinstance(text, bytes):
        names = [name.strip() for name in text.decode("utf-8", "replace").split("\0") if name]
    space = profile[16:20].decode("latin-1")
    if _MORE_INKS.fullmatch(space):
        shown = f" ({', '.join(name[:40] for name in names[:16])})" if names else ""
        raise _unsupported(
            f"The picture has {spec.nchannels} inks{shown} and a profile of {space}.",
            "channels",
            "Pictures have at most four inks here. Send its profile for the gamut of the device, "
            "or convert the picture to CMYK, RGB or CIELAB.",
        )
    if inks < 4:
        raise _unsupported(f"The separated picture has {inks} inks without C, M, Y, K.", "channels")
    channels = list(range(4))
    if names:
        channels = [
            next((place for place, name in enumerate(names[:inks]) if ink.fullmatch(name)), -1)
            for ink in _INK_NAMES.values()
        ]
        if -1 in channels:
            shown = ", ".join(name[:40] for name in names[:16])
            raise _unsupported(
                f"The inks of the picture are {shown}, without C, M, Y, K.", "channels"
            )
    elif _OTHER_INKS in fields.get(TIFF_INK_SET, ()):
        said.append("The inks have no names: the first four are taken for C, M, Y, K.")
    alpha = next((place for place, kind in enumerate(extra) if kind in {1, 2}), -1)
    return _Samples(
        "CMYK",
        channels,
        inks + alpha if alpha >= 0 else -1,
        is_premultiplied=alpha >= 0 and extra[alpha] == 1,
        unused=spec.nchannels - 4 - (alpha >= 0),
        unused_names=tuple(name for place, name in enumerate(names) if place not in channels),
    )


def _colour_samples(
    spec: Any,  # noqa: ANN401 (an ImageSpec)
    file_format: str,
    raw_model: str | None,
    photometric: int,
) -> _Samples:
    """Return the channels of a picture without layers and inks."""
    if file_format == "tiff" and photometric in {_TIFF_WHITE_IS_ZERO, _TIFF_BLACK_IS_ZERO}:
        channels, model = [0], "gray"  # OpenImageIO takes further channels for RGB
    else:
        channels, model = _colour_channels(spec, raw_model)
    alpha = spec.alpha_channel if spec.alpha_channel not in channels else -1
    # JPEG XL stores straight alpha unless its header says otherwise; OpenImageIO returns the stored
    # values.
    straight = file_format == "jpeg-xl" or spec.get_int_attribute("oiio:UnassociatedAlpha")
    unused = spec.nchannels - len(channels) - (alpha >= 0)
    return _Samples(model, channels, alpha, alpha >= 0 and not straight, unused)


def _colour_channels(spec: Any, raw_model: str | None) -> tuple[list[int], str]:  # noqa: ANN401
    """Return the indices of the colour channels, and the colour model."""
    names = [name.upper() for name in spec.channelnames]
    if raw_model is not None:
        if len(names) < len(MODELS[raw_model]):
            raise malformed_picture(
                f"The picture has {len(names)} channels; {raw_model} needs "
                f"{len(MODELS[raw_model])}.",
                {"field": "channels"},
            )
        return list(range(len(MODELS[raw_model]))), raw_model
    if {"R", "G", "B"} <= set(names):
        return [names.index(name) for name in "RGB"], "RGB"
    for name in ("Y", "L", "I"):
        if name in names:
            return [names.index(name)], "gray"
    if len(set(names) - {"A"}) == 1:
        return [0 if names[0] != "A" else 1], "gray"
    shown = ", ".join(spec.channelnames[:8])
    raise _unsupported(f"The picture has the channels {shown[:100]}.", "channels")


def _sample_type(spec: Any, samples: _Samples) -> np.dtype[Any]:  # noqa: ANN401
    """Return the type that samples are read as.

    64-bit floats are refused: OpenImageIO 3.2 returns undefined values for them in TIFF files
    without compression.
    """
    stored = str(spec.format)
    if spec.channelformats:  # channels of OpenEXR have types of their own, such as uint for ids
        stored = str(spec.channelformats[samples.channels[0]])
    known = {
        "uint8": "uint8",
        "uint16": "uint16",
        "uint": "uint16",
        "half": "float32",
        "float": "float32",
    }
    if samples.model == "Lab":
        # Some writers declare all channels of Lab as signed, because a* and b* are.
        known |= {"int8": "uint8", "int16": "uint16"}
        known.pop("uint")
    if stored not in known:
        raise _unsupported(f"The samples of the picture have the type {stored}.", "bits")
    return np.dtype(known[stored])


def _blocks(
    source: Any,  # noqa: ANN401 (an ImageInput)
    spec: Any,  # noqa: ANN401 (an ImageSpec)
    part: int,
    dtype: np.dtype[Any],
    path: str,
    said: list[str],
) -> Iterator[tuple[int, npt.NDArray[Any]]]:
    """Yield the first row and the samples (rows, columns, channels) of some rows at a time.

    `part` is the number of the picture in the file.
    """
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
                part, 0, spec.x, right, top, end, 0, 1, 0, spec.nchannels, wanted
            )
        else:
            block = source.read_scanlines(part, 0, top, end, 0, 0, spec.nchannels, wanted)
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
    convert: _Conversion | None,
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


def _tristimulus(raster: Raster, white: tuple[float, float], title: str) -> _Conversion:
    """Set the encoding of a raster of X, Y, Z, and return the function that divides by its white.

    `white` is that of files that state no other.
    """
    if raster.encoding is None:
        raster.warnings.append(f"X, Y, Z without primaries: a white of {title} is assumed.")
    else:
        white = raster.encoding.white
    raster.encoding = tristimulus_encoding(white)
    x, y = white
    scale = np.array([y / x, 1.0, y / (1 - x - y)], np.float32)

    def divided(colours: npt.NDArray[Any]) -> npt.NDArray[Any]:
        relative: npt.NDArray[Any] = colours * scale
        return relative

    return divided


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
        image: Any = JpegImageFile(io.BytesIO(data))
    said = []
    if "adobe" not in image.info:
        said.append("CMYK without Adobe's marker: 0 is assumed to be full ink, as Adobe writes it.")
    return Raster(
        "jpeg",
        "CMYK",
        spec.width,
        spec.height,
        np.dtype(np.uint8),
        8,
        _bands_of(image),
        profile=embedded_profile(spec, data, "jpeg"),
        warnings=said,
        stored="uint8",
        header=openimageio().ImageSpec(),
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


def _pillow_raster(data: bytes, file_format: str, time_limit: _TimeLimit) -> Raster:
    """Return the raster of the first frame of a picture, which is decoded when bands are read."""
    image = _pillow_image(data, file_format)
    time_limit.set_pixels(image.width * image.height)
    gray = image.mode in {"1", "L", "LA"}
    has_alpha = image.has_transparency_data
    names = [*("Y" if gray else "RGB"), *("A" if has_alpha else "")]
    spec = openimageio().ImageSpec(image.width, image.height, len(names), "uint8")
    spec.channelnames = names
    said = []
    with _pillow_faults():
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
        image.width,
        image.height,
        np.dtype(np.uint8),
        8,
        _pillow_bands(data, file_format, "".join(names).replace("Y", "L")),
        profile=profile,
        warnings=said,
        has_alpha=has_alpha,
        stored="uint8",
        header=spec,
    )
    raster.encoding, _ = declared_encoding(spec, data, file_format, has_profile=bool(profile))
    return raster


def _pillow_bands(data: bytes, file_format: str, mode: str) -> Iterator[Band]:
    """Yield the pixels of the first frame in a mode of Pillow; A is alpha.

    The decoder of WebP takes up to 20 bytes per pixel. The pixels are stored in a file, so that the
    rest of the picture is read, as that of JPEG, with the memory of a band.
    """
    has_alpha = mode.endswith("A")
    with tempfile.SpooledTemporaryFile(BAND_BYTES) as pixels:
        with _pillow_faults():
            image = _pillow_image(data, file_format)
            if image.mode != mode:
                image = image.convert(mode)
        width, height = image.size
        for _, samples, _ in _bands_of(image):
            pixels.write(samples.tobytes())
        del image
        pixels.seek(0)
        rows = max(1, BAND_BYTES // (len(mode) * width))
        for top in range(0, height, rows):
            content = pixels.read((min(top + rows, height) - top) * width * len(mode))
            samples = np.frombuffer(content, np.uint8).reshape(-1, len(mode))
            if has_alpha:
                yield top, samples[:, :-1], samples[:, -1]
            else:
                yield top, samples, None


def _bands_of(image: Any) -> Iterator[Band]:  # noqa: ANN401 (a PIL.Image.Image)
    """Yield the pixels of a picture, which is decoded first, with all its channels as colours."""
    with _pillow_faults():
        image.load()
    channels = len(image.getbands())
    rows = max(1, BAND_BYTES // (channels * image.width))
    for top in range(0, image.height, rows):
        box = (0, top, image.width, min(top + rows, image.height))
        yield top, np.asarray(image.crop(box)).reshape(-1, channels), None
