"""Colour encodings of pictures, and how files declare them.

An encoding of RGB or gray has primaries, a white and a transfer function. A file declares it by
code points (ITU-T H.273), by chromaticities and a gamma, by the name of a colour space, or by an
ICC profile. OpenImageIO reports most of this as attributes. PNG's chunks sRGB, gAMA and cHRM, and
the primaries of Radiance HDR, are read here, because OpenImageIO does not report them.
"""

from __future__ import annotations

import io
import re
import struct
import warnings
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gamutcore.errors import MalformedProfileError, UnsupportedPictureError

__all__ = [
    "LINEAR",
    "MAX_PROFILE_BYTES",
    "SRGB",
    "Encoding",
    "bmp_profile",
    "chromaticity_encoding",
    "code_point_encoding",
    "declared_encoding",
    "embedded_profile",
    "exif_colour_space",
    "is_narrow_range",
    "named_encoding",
    "refuse_film_densities",
    "text_attribute",
]

Chromaticity = tuple[float, float]
Primaries = tuple[Chromaticity, Chromaticity, Chromaticity]

D65: Chromaticity = (0.3127, 0.3290)
_ACES_WHITE: Chromaticity = (0.32168, 0.33767)


@dataclass(frozen=True)
class Encoding:
    """A colour encoding of RGB, or of gray on its neutral axis.

    `primaries` and `white` are CIE 1931 chromaticities. `transfer` is ``"sRGB"``, ``"power"`` with
    the exponent `gamma`, ``"linear"``, ``"PQ"`` or ``"HLG"``.
    """

    name: str
    primaries: Primaries
    white: Chromaticity = D65
    transfer: str = "sRGB"
    gamma: float = 1.0


_BT709: Primaries = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
_ADOBE: Primaries = ((0.64, 0.33), (0.21, 0.71), (0.15, 0.06))
_BT2020: Primaries = ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046))
_P3: Primaries = ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060))
_SMPTE_C: Primaries = ((0.630, 0.340), (0.310, 0.595), (0.155, 0.070))

SRGB = Encoding("sRGB", _BT709)
"""IEC 61966-2-1."""

LINEAR = Encoding("linear light of sRGB's primaries", _BT709, transfer="linear")
"""scRGB (IEC 61966-2-2): 1 is white; values outside 0 to 1 are colours outside sRGB."""

ADOBE_RGB = Encoding("Adobe RGB (1998)", _ADOBE, transfer="power", gamma=563 / 256)
"""Adobe RGB (1998) Color Image Encoding, 4.3.1; the optional colour space of DCF 2.0 (Exif)."""

_CODE_POINT_PRIMARIES: dict[int, tuple[str, Primaries, Chromaticity]] = {
    # ITU-T H.273 (2024), table 2.
    1: ("BT.709", _BT709, D65),
    4: ("BT.470 M", ((0.67, 0.33), (0.21, 0.71), (0.14, 0.08)), (0.310, 0.316)),
    5: ("BT.470 BG", ((0.64, 0.33), (0.29, 0.60), (0.15, 0.06)), D65),
    6: ("BT.601 525", _SMPTE_C, D65),
    7: ("SMPTE ST 240", _SMPTE_C, D65),
    9: ("BT.2020", _BT2020, D65),
    11: ("DCI-P3", _P3, (0.314, 0.351)),
    12: ("Display P3", _P3, D65),
    22: ("EBU Tech. 3213", ((0.630, 0.340), (0.295, 0.605), (0.155, 0.077)), D65),
}
_CODE_POINT_TRANSFERS: dict[int, tuple[str, str, float]] = {
    # ITU-T H.273 (2024), table 3. Pictures are made for displays. The inverse of BT.709's camera
    # curve is therefore the display curve of BT.1886.
    1: ("BT.1886", "power", 2.4),
    4: ("gamma 2.2", "power", 2.2),
    5: ("gamma 2.8", "power", 2.8),
    6: ("BT.1886", "power", 2.4),
    8: ("linear", "linear", 1.0),
    13: ("sRGB", "sRGB", 1.0),
    14: ("BT.1886", "power", 2.4),
    15: ("BT.1886", "power", 2.4),
    16: ("PQ", "PQ", 1.0),
    17: ("SMPTE ST 428", "power", 2.6),
    18: ("HLG", "HLG", 1.0),
}

_SPACE_NAME = re.compile(r"(?:.*:)?(lin|srgb|g\d\d|pq|hlg)_([a-z0-9]+)_(?:scene|display)")
_SPACE_PRIMARIES: dict[str, tuple[str, Primaries, Chromaticity]] = {
    # Color Interop Forum, "Color space encodings for texture assets and CG rendering" (2024).
    "rec709": ("BT.709", _BT709, D65),
    "rec2020": ("BT.2020", _BT2020, D65),
    "p3d65": ("Display P3", _P3, D65),
    "adobergb": ("Adobe RGB", _ADOBE, D65),
    "ap0": ("ACES AP0", ((0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.077)), _ACES_WHITE),
    "ap1": ("ACES AP1", ((0.713, 0.293), (0.165, 0.830), (0.128, 0.044)), _ACES_WHITE),
}
_SPACE_TRANSFERS = {"lin": "linear", "srgb": "sRGB", "pq": "PQ", "hlg": "HLG"}


def code_point_encoding(primaries: int, transfer: int) -> Encoding | None:
    """Return the encoding of code points of ITU-T H.273; None for those that no display has."""
    if primaries not in _CODE_POINT_PRIMARIES or transfer not in _CODE_POINT_TRANSFERS:
        return None
    name, chromaticities, white = _CODE_POINT_PRIMARIES[primaries]
    curve, kind, gamma = _CODE_POINT_TRANSFERS[transfer]
    known = {("BT.709", "sRGB"): "sRGB", ("Display P3", "sRGB"): "Display P3"}
    return Encoding(
        known.get((name, curve), f"{name}, {curve}"), chromaticities, white, kind, gamma
    )


def named_encoding(name: str) -> Encoding | None:
    """Return the encoding of a Color Interop ID such as ``"lin_ap1_scene"``; None if unknown."""
    match = _SPACE_NAME.fullmatch(name)
    if match is None or match[2] not in _SPACE_PRIMARIES:
        return None
    title, primaries, white = _SPACE_PRIMARIES[match[2]]
    transfer = _SPACE_TRANSFERS.get(match[1], "power")
    gamma = int(match[1][1:]) / 10 if transfer == "power" else 1.0
    if (match[1], match[2]) == ("srgb", "rec709"):
        return SRGB
    curve = f"gamma {gamma:g}" if transfer == "power" else transfer
    return Encoding(f"{title}, {curve}", primaries, white, transfer, gamma)


def chromaticity_encoding(
    chromaticities: Sequence[float] | None, *, gamma: float | None = None, linear: bool = False
) -> Encoding | None:
    """Return the encoding of chromaticities and a transfer function; None if they are impossible.

    Chromaticities are x and y of red, green, blue and white; None stands for those of sRGB. `gamma`
    is the exponent from values to light; without it, the curve of sRGB applies.
    """
    white, primaries = D65, _BT709
    said = []
    if chromaticities is not None:
        x, y = chromaticities[::2], chromaticities[1::2]
        red, green, blue, white = zip(x, y, strict=True)
        primaries = (red, green, blue)
        area = (green[0] - red[0]) * (blue[1] - red[1]) - (blue[0] - red[0]) * (green[1] - red[1])
        # The triangle of ProPhoto has an area of 0.43, and its blue has y = 0.0001. The blue of
        # ACES AP0 has y = -0.077.
        sane = all(-0.2 <= u <= 1.2 and 1e-5 <= abs(v) <= 1.2 for u, v in zip(x, y, strict=True))
        if not sane or abs(area) < 0.01 or not _inside(white, primaries, area):
            return None
        said.append("stated primaries")
    if linear:
        return Encoding(", ".join([*said, "linear"]), primaries, white, "linear")
    if gamma is None:
        return Encoding(", ".join(said) or SRGB.name, primaries, white)
    if not 0.1 <= gamma <= 10:
        return None
    return Encoding(", ".join([*said, f"gamma {gamma:.4g}"]), primaries, white, "power", gamma)


def _inside(white: Chromaticity, primaries: Primaries, area: float) -> bool:
    """Return whether the white is a mixture of all three primaries."""
    parts = []
    for index in range(3):
        (ax, ay), (bx, by) = primaries[index], primaries[(index + 1) % 3]
        parts.append(((bx - ax) * (white[1] - ay) - (white[0] - ax) * (by - ay)) / area)
    return all(part > 0.001 for part in parts)


MAX_PROFILE_BYTES = 2**25
"""Maximum size of an embedded profile. The largest press profiles have about 10 MB."""

_RADIANCE_PRIMARIES = re.compile(rb"^PRIMARIES=((?:[ \t]*[-+\d.eE]+){8})[ \t]*$", re.MULTILINE)
_DPX_SPACES = {"Linear": "lin_rec709_scene", "ITU-R 709-4": "g24_rec709_display"}
_EXIF_UNCALIBRATED = 0xFFFF
_BMP_V5_SIZE = 124
_DPX_LOGARITHMIC = {"Logarithmic", "Printing density", "ADX"}


def declared_encoding(
    spec: Any,  # noqa: ANN401 (an ImageSpec)
    data: bytes,
    file_format: str,
    *,
    has_profile: bool = False,
) -> tuple[Encoding | None, list[str]]:
    """Return the encoding that a picture declares, or None, and warnings.

    Only code points take precedence over an ICC profile (W3C PNG, third edition, 4.3).
    """
    said: list[str] = []
    code_points = spec.getattribute("CICP")
    if code_points is not None:
        primaries, transfer, matrix, _ = (int(number) for number in code_points)
        encoding = None if matrix else code_point_encoding(primaries, transfer)
        if encoding is not None:
            return encoding, said
        said.append(f"The code points {primaries}, {transfer}, {matrix} are not supported.")
    if has_profile:
        return None, said
    if file_format == "png":
        encoding, more = _png_encoding(data)
    elif file_format == "exr":
        encoding, more = _exr_encoding(spec)
    elif file_format == "hdr":
        encoding, more = _hdr_encoding(data)
    elif file_format == "dpx":
        name = _DPX_SPACES.get(text_attribute(spec, "dpx:Transfer"), "")
        encoding, more = named_encoding(name), []
    else:
        encoding, more = _exif_encoding(spec, data), []
    return encoding, said + more


def text_attribute(spec: Any, name: str) -> str:  # noqa: ANN401 (an ImageSpec)
    """Return a text from a picture's header; empty if it is missing or not UTF-8."""
    try:
        text: str = spec.get_string_attribute(name)
    except UnicodeDecodeError:
        return ""
    return text


def is_narrow_range(spec: Any, file_format: str) -> bool:  # noqa: ANN401 (an ImageSpec)
    """Return whether code points state that integers use the narrow range, 16 to 235 of 8 bits."""
    if file_format != "png" or spec.getattribute("CICP") is None:
        return False
    primaries, transfer, matrix, is_full = map(int, spec.getattribute("CICP"))
    known = code_point_encoding(primaries, transfer) is not None
    return known and not (matrix or is_full)


def refuse_film_densities(spec: Any) -> None:  # noqa: ANN401 (an ImageSpec)
    """Refuse DPX with logarithmic film densities, which are not light."""
    transfer = text_attribute(spec, "dpx:Transfer")
    if transfer in _DPX_LOGARITHMIC:
        raise UnsupportedPictureError(
            f"The DPX picture has values of the kind {transfer}.",
            where={"field": "transfer"},
            remedy="Convert it to linear light or to a display encoding.",
        )


def _png_encoding(data: bytes) -> tuple[Encoding | None, list[str]]:
    """Return the encoding of the chunks sRGB, gAMA and cHRM (W3C PNG, third edition, 11.3.2)."""
    chunks = _png_chunks(data)
    if b"sRGB" in chunks:
        return SRGB, []
    gamma = chromaticities = None
    if len(chunks.get(b"gAMA", b"")) == 4:
        stated = int.from_bytes(chunks[b"gAMA"], "big")
        gamma = 100_000 / stated if stated else 0.0
    if len(chunks.get(b"cHRM", b"")) == 32:
        chromaticities = tuple(value / 100_000 for value in struct.unpack(">8I", chunks[b"cHRM"]))
    if gamma is None and chromaticities is None:
        return None, []
    if chromaticities is not None:  # white first; `chromaticity_encoding` has white last
        chromaticities = (*chromaticities[2:], *chromaticities[:2])
    encoding = chromaticity_encoding(chromaticities, gamma=gamma)
    if encoding is None:
        return None, ["The chunks gAMA and cHRM state impossible values and are not used."]
    return encoding, []


def _png_chunks(data: bytes) -> dict[bytes, bytes]:
    """Return the chunks before the pixels by their names."""
    chunks, place = {}, 8
    while place + 8 <= len(data):
        size, name = struct.unpack_from(">I4s", data, place)
        if name == b"IDAT":
            break
        chunks[name] = data[place + 8 : place + 8 + size]
        place += size + 12
    return chunks


def _exr_encoding(spec: Any) -> tuple[Encoding | None, list[str]]:  # noqa: ANN401
    name = text_attribute(spec, "oiio:ColorSpace")
    if name:
        encoding = named_encoding(name)
        if encoding is not None:
            return encoding, []
        return None, [f"The colour space {name[:60]} is not supported and was not used."]
    stated = spec.getattribute("chromaticities")
    if stated is None:
        return None, []
    encoding = chromaticity_encoding(tuple(float(value) for value in stated), linear=True)
    if encoding is None:
        return None, ["The attribute chromaticities states impossible values and is not used."]
    return encoding, []


def _hdr_encoding(data: bytes) -> tuple[Encoding | None, list[str]]:
    found = _RADIANCE_PRIMARIES.search(data[:4096])
    if found is None:
        return None, []
    try:
        numbers = tuple(float(word) for word in found[1].split())
    except ValueError:
        numbers = ()
    encoding = chromaticity_encoding(numbers, linear=True) if len(numbers) == 8 else None
    if encoding is None:
        return None, ["The line PRIMARIES states impossible values and is not used."]
    return encoding, []


def _exif_encoding(spec: Any, data: bytes) -> Encoding | None:  # noqa: ANN401 (an ImageSpec)
    """Return sRGB, or the optional colour space of DCF 2.0, Adobe RGB, from Exif."""
    space = spec.get_int_attribute("Exif:ColorSpace")
    if space == 1 and spec.nchannels >= 3:
        return SRGB
    if space == _EXIF_UNCALIBRATED and spec.nchannels >= 3:
        from PIL import ExifTags, Image  # noqa: PLC0415  # 3 MB, and rarely needed

        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                exif = Image.open(io.BytesIO(data)).getexif()
                index = exif.get_ifd(ExifTags.IFD.Interop).get(1, "")
        except (OSError, SyntaxError, ValueError, TypeError, LookupError, struct.error):
            return None
        if str(index).startswith("R03"):
            return ADOBE_RGB
    return None


def exif_colour_space(exif: Any) -> int:  # noqa: ANN401 (a PIL.Image.Exif)
    """Return the number of Exif's tag ColorSpace; 0 without one."""
    from PIL import ExifTags  # noqa: PLC0415

    space = exif.get_ifd(ExifTags.IFD.Exif).get(ExifTags.Base.ColorSpace)
    return space if isinstance(space, int) else 0


def bmp_profile(data: bytes) -> bytes:
    """Return the embedded profile of a BMP file with a BITMAPV5HEADER; empty without one."""
    # offsets in the file: bV5Size 14, bV5CSType 70, bV5ProfileData 126, bV5ProfileSize 130
    if len(data) < 138 or data[14] != _BMP_V5_SIZE or data[70:74] not in {b"DEBM", b"KNIL"}:
        return b""
    start, size = struct.unpack_from("<II", data, 126)
    profile = data[14 + start : 14 + start + size]
    if data[70:74] == b"KNIL" or not 0 < size == len(profile) <= MAX_PROFILE_BYTES:
        raise _damaged_profile()
    return profile


def _damaged_profile() -> MalformedProfileError:
    return MalformedProfileError(
        "The embedded profile is damaged, incomplete, too large or in another file.",
        where={"field": "profile"},
        remedy="Embed the profile again, or save the picture without a profile.",
    )


def embedded_profile(spec: Any, data: bytes, file_format: str) -> bytes:  # noqa: ANN401
    """Return the embedded ICC profile of a picture; empty without one.

    A damaged profile of a PNG or JPEG file is an error: OpenImageIO ignores it, and the colours
    would be taken for sRGB. OpenImageIO also ignores the RGB profile of a gray PNG file, which is
    read here.
    """
    profile = spec.getattribute("ICCProfile")
    if profile is not None:
        return np.asarray(profile, np.uint8).tobytes()
    damaged = False
    if file_format == "png":
        content = _png_chunks(data).get(b"iCCP")
        if content is None:
            return b""
        unpacker = zlib.decompressobj()
        try:
            found = unpacker.decompress(content[content.index(b"\0") + 2 :], MAX_PROFILE_BYTES)
        except (zlib.error, ValueError):
            found = b""
        if unpacker.eof:
            return found
        damaged = True
    elif file_format == "jpeg":
        damaged = b"ICC_PROFILE\0" in data[: data.find(b"\xff\xda")]
    if damaged:
        raise _damaged_profile()
    return b""
