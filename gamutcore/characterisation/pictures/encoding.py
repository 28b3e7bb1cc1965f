"""Colour encodings of RGB and gray without a profile: primaries, white and transfer function.

A file declares its encoding by code points (ITU-T H.273), by chromaticities and a gamma, or by the
name of a colour space. Without a declaration, `SRGB` or `LINEAR` is assumed.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = [
    "ADOBE_RGB",
    "LINEAR",
    "SRGB",
    "Encoding",
    "chromaticity_encoding",
    "code_point_encoding",
    "named_encoding",
]

Chromaticity = tuple[float, float]
Primaries = tuple[Chromaticity, Chromaticity, Chromaticity]

D65: Chromaticity = (0.3127, 0.3290)
_ACES_WHITE: Chromaticity = (0.32168, 0.33767)


@dataclass(frozen=True)
class Encoding:
    """A colour encoding of RGB, or of gray on its neutral axis.

    Parameters
    ----------
    name : str
        The usual name.
    primaries : tuple of three (x, y)
        CIE 1931 chromaticities of red, green and blue.
    white : (x, y)
    transfer : str
        ``"sRGB"``, ``"power"``, ``"linear"``, ``"PQ"`` or ``"HLG"``.
    gamma : float
        Exponent of ``"power"``.
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
    """Return the encoding of code points of ITU-T H.273.

    Reserved and unspecified code points give None, as do those that no display has.
    """
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
