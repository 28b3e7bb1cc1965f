"""Colour encodings of pictures, and how files declare them.

An encoding of RGB or gray has primaries, a white and a transfer function. A file declares it by
code points (ITU-T H.273), by chromaticities and a gamma, by the name of a colour space, or by an
ICC profile. OpenImageIO reports most of this as attributes. PNG's chunks sRGB, gAMA and cHRM, and
the primaries of Radiance HDR, are read here, because OpenImageIO does not report them. What a file
declares is used or refused; sRGB is assumed only where nothing is declared.
"""

from __future__ import annotations

import io
import re
import struct
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gamutcore.characterisation.pictures.containers import png_chunks, radiance_lines
from gamutcore.errors import MalformedFileError, UnsupportedPictureError

__all__ = [
    "D65",
    "EQUAL_ENERGY",
    "LINEAR",
    "SRGB",
    "Encoding",
    "chromaticity_encoding",
    "code_point_encoding",
    "declared_encoding",
    "exif_colour_space",
    "is_narrow_range",
    "named_encoding",
    "refuse_film_densities",
    "text_attribute",
    "tristimulus_encoding",
]

Chromaticity = tuple[float, float]
Primaries = tuple[Chromaticity, Chromaticity, Chromaticity]

D65: Chromaticity = (0.3127, 0.3290)
EQUAL_ENERGY: Chromaticity = (1 / 3, 1 / 3)
"""White of Radiance (Ward, Radiance reference, color.h)."""
_ACES_WHITE: Chromaticity = (0.32168, 0.33767)


@dataclass(frozen=True)
class Encoding:
    """A colour encoding of RGB, or of gray on its neutral axis.

    `primaries` and `white` are CIE 1931 chromaticities. `transfer` is ``"sRGB"``, ``"power"`` with
    the exponent `gamma`, ``"linear"``, ``"PQ"``, ``"HLG"``, or ``"BT709"`` for the inverse of the
    curve of cameras. The name does not count when encodings are compared.
    """

    name: str = field(compare=False)
    primaries: Primaries
    white: Chromaticity = D65
    transfer: str = "sRGB"
    gamma: float = 1.0

    def with_transfer(self, curve: str | float, name: str) -> Encoding:
        """Return the same primaries with a transfer function, or an exponent, of a name."""
        transfer, gamma = (curve, 1.0) if isinstance(curve, str) else ("power", curve)
        named = f"{self.name.partition(',')[0]}, decoded by {name}"
        return replace(self, name=named, transfer=transfer, gamma=gamma)


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
        # Primaries need not be colours of light: those of XYZ have y = 0, and the blue of ACES AP0
        # has y = -0.077. The triangle of sRGB has an area of 0.22. NaN is not in any range.
        sane = all(-1.0 <= number <= 2.0 for number in chromaticities) and white[1] >= 0.01
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


_XYZ: Primaries = ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))


def tristimulus_encoding(white: Chromaticity) -> Encoding:
    """Return the encoding of X, Y, Z that are divided by those of the white."""
    return Encoding("CIE XYZ, linear", _XYZ, white, "linear")


_DPX_CODE_POINTS = {
    # SMPTE ST 268-1:2014, table 5A: transfer characteristics by OpenImageIO's names, as ITU-T H.273
    "Linear": (1, 8),
    "SMPTE 274M": (1, 1),
    "ITU-R 709-4": (1, 1),
    "ITU-R 601-5 system B or G": (5, 6),
    "ITU-R 601-5 system M": (6, 6),
    "NTSC composite video": (6, 6),
    "PAL composite video": (5, 6),
}
_EXIF_UNCALIBRATED = 0xFFFF
_UNSPECIFIED = 2
"""Code point of primaries and transfer functions that are unknown (ITU-T H.273)."""
_PNG_COLOUR = (b"cICP", b"iCCP", b"sRGB", b"gAMA", b"cHRM")
_EQUAL_EXPOSURE = 1e-6
_EQUAL_IN_PNG = 0.0011
"""Difference of chromaticities, or of 1 ÷ gamma, that writers of PNG leave by rounding."""
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
    unsupported = ""
    code_points = spec.getattribute("CICP")
    if code_points is not None:
        primaries, transfer, matrix, _ = (int(number) for number in code_points)
        encoding = None if matrix else code_point_encoding(primaries, transfer)
        if encoding is not None:
            return encoding, said
        unsupported = f"The code points {primaries}, {transfer}, {matrix} are not supported."
        said.append(unsupported)
        if (primaries, transfer) == (_UNSPECIFIED, _UNSPECIFIED):
            unsupported = ""
    if file_format == "png":
        said += _misplaced_chunks(data, has_code_points=code_points is not None)
    if has_profile:
        return None, said
    if file_format == "png":
        encoding, more = _png_encoding(data)
    elif file_format == "exr":
        encoding, more = _exr_encoding(spec)
    elif file_format == "hdr":
        encoding, more = _hdr_encoding(data)
    elif file_format == "dpx":
        code_points = _DPX_CODE_POINTS.get(text_attribute(spec, "dpx:Transfer"))
        encoding, more = code_point_encoding(*code_points) if code_points else None, []
    else:
        encoding, more = _exif_encoding(spec, data), []
    if encoding is None and unsupported:
        raise UnsupportedPictureError(
            unsupported, where={"field": "CICP"}, remedy="Embed an ICC profile, or save as sRGB."
        )
    return encoding, said + more


def _impossible(name: str, kind: str, stated: str) -> MalformedFileError:
    return MalformedFileError(
        f"The {kind} {name} states no possible colours: {stated[:120]}.",
        where={"field": name},
        remedy="The white lies inside the triangle of red, green and blue, and a gamma is between "
        "0.1 and 10. Save the picture again with its right encoding.",
    )


def _misplaced_chunks(data: bytes, *, has_code_points: bool) -> list[str]:
    """Return a warning for each chunk that states colours where decoders do not look for it."""
    late = png_chunks(data, after_pixels=True)
    names = [name for name in _PNG_COLOUR if name in late]
    if b"cICP" in png_chunks(data) and not has_code_points and b"cICP" not in names:
        names.append(b"cICP")  # behind the palette, or of a wrong size
    return [
        f"The chunk {name.decode()} is misplaced or damaged, and is not used." for name in names
    ]


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
    chunks = png_chunks(data)
    for name, size in ((b"gAMA", 4), (b"cHRM", 32)):
        if len(chunks.get(name, bytes(size))) != size:
            raise _impossible(name.decode(), "chunk", f"it has {len(chunks[name])} bytes")
    gamma = chromaticities = None
    if b"gAMA" in chunks:
        stated = int.from_bytes(chunks[b"gAMA"], "big")
        gamma = 100_000 / stated if stated else 0.0
    if b"cHRM" in chunks:  # white first; `chromaticity_encoding` has white last
        numbers = [value / 100_000 for value in struct.unpack(">8i", chunks[b"cHRM"])]
        chromaticities = (*numbers[2:], *numbers[:2])
    if b"sRGB" in chunks:
        return SRGB, _contradictions(gamma, chromaticities)
    if gamma is None and chromaticities is None:
        return None, []
    if chromaticity_encoding(chromaticities) is None:
        raise _impossible("cHRM", "chunk", _listed(chromaticities or ()))
    encoding = chromaticity_encoding(chromaticities, gamma=gamma)
    if encoding is None:
        raise _impossible("gAMA", "chunk", f"gamma {gamma:g}")
    return encoding, []


def _contradictions(gamma: float | None, chromaticities: Sequence[float] | None) -> list[str]:
    """Return warnings about chunks that state something else than the chunk sRGB."""
    corners = [number for pair in (*SRGB.primaries, SRGB.white) for number in pair]
    pairs = zip(corners, chromaticities or corners, strict=True)
    differ = {
        # the exponent of sRGB's fallback (W3C PNG, third edition, 11.3.2.5)
        "gAMA": gamma is not None and (not gamma or abs(1 / gamma - 0.45455) > _EQUAL_IN_PNG),
        "cHRM": any(abs(a - b) > _EQUAL_IN_PNG for a, b in pairs),
    }
    return [
        f"The chunk {name} contradicts the chunk sRGB, and is not used."
        for name, is_other in differ.items()
        if is_other
    ]


def _listed(numbers: Sequence[float]) -> str:
    return ", ".join(f"{number:g}" for number in numbers)


def _exr_encoding(spec: Any) -> tuple[Encoding | None, list[str]]:  # noqa: ANN401
    name = text_attribute(spec, "oiio:ColorSpace")
    encoding = named_encoding(name) if name else None
    if encoding is not None:
        return encoding, []
    stated = spec.getattribute("chromaticities")
    if stated is not None:
        numbers = _numbers(stated) if isinstance(stated, str) else np.ravel(stated).tolist()
        encoding = chromaticity_encoding(numbers, linear=True) if len(numbers) == 8 else None
        if encoding is None:
            raise _impossible("chromaticities", "attribute", _listed(numbers))
        return encoding, []
    if name and name.lower() not in _NO_SPACES:
        raise UnsupportedPictureError(
            f"The colour space {name[:60]} is not supported.",
            where={"field": "colorInteropID"},
            remedy="State the primaries by the attribute chromaticities, or save the picture in a "
            "space of the Color Interop Forum.",
        )
    return None, []


_NO_SPACES = frozenset({"unknown", "data", "linear", "scene_linear"})
"""Names that do not tell the primaries."""


def _hdr_encoding(data: bytes) -> tuple[Encoding | None, list[str]]:
    """Return the encoding of the line PRIMARIES, and warnings about scales of the light."""
    encoding, exposure, correction = None, 1.0, False
    for name, text in radiance_lines(data):
        numbers = _numbers(text)
        if name == "PRIMARIES":
            encoding = chromaticity_encoding(numbers, linear=True) if len(numbers) == 8 else None
            if encoding is None:
                raise _impossible(name, "line", text)
        elif name == "EXPOSURE" and len(numbers) == 1:
            exposure *= numbers[0]  # several lines count together
        elif name == "COLORCORR":
            correction |= any(abs(number - 1) > _EQUAL_EXPOSURE for number in numbers)
    said = []
    if not abs(exposure - 1) <= _EQUAL_EXPOSURE:
        said.append(
            f"The exposure of {exposure:g} that the file states is not taken back: the colours are "
            "those of the stored values, whose white is 1."
        )
    if correction:
        said.append("The line COLORCORR is not taken back: the colours are the stored ones.")
    return encoding, said


def _numbers(text: str) -> list[float]:
    """Return the numbers of a text; empty if a word is none."""
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        return []


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
