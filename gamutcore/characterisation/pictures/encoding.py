"""What RGB and gray values without a profile mean: primaries, white and transfer function.

Files state them by code points (PNG's cICP, ITU-T H.273), by chromaticities and gamma (cHRM, gAMA),
by name (sRGB, Exif), or not at all; then sRGB is assumed, and said to be.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["ADOBE_RGB", "LINEAR", "SRGB", "Encoding", "code_point_encoding", "gamma_encoding"]

Chromaticity = tuple[float, float]

D65: Chromaticity = (0.3127, 0.3290)


@dataclass(frozen=True)
class Encoding:
    """A colour encoding of RGB, or of gray on its neutral axis.

    Parameters
    ----------
    name : str
        As users call it.
    primaries : tuple of three (x, y)
        CIE 1931 chromaticities of red, green and blue.
    white : (x, y)
    transfer : str
        ``"sRGB"``, ``"power"``, ``"linear"``, ``"PQ"`` or ``"HLG"``.
    gamma : float
        Exponent of ``"power"``.
    """

    name: str
    primaries: tuple[Chromaticity, Chromaticity, Chromaticity]
    white: Chromaticity = D65
    transfer: str = "sRGB"
    gamma: float = 1.0


_BT709 = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
_P3 = ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060))

SRGB = Encoding("sRGB", _BT709)
"""IEC 61966-2-1."""

LINEAR = Encoding("linear light of sRGB's primaries", _BT709, transfer="linear")
"""As scRGB has it (IEC 61966-2-2): 1 is white, values beyond 0 to 1 are colours outside sRGB."""

ADOBE_RGB = Encoding(
    "Adobe RGB (1998)",
    ((0.64, 0.33), (0.21, 0.71), (0.15, 0.06)),
    transfer="power",
    gamma=563 / 256,
)
"""Adobe RGB (1998) Color Image Encoding, 4.3.1; the optional colour space of DCF 2.0 (Exif)."""

_PRIMARIES: dict[int, tuple[str, tuple[Chromaticity, Chromaticity, Chromaticity], Chromaticity]] = {
    # ITU-T H.273 (2024), table 2.
    1: ("BT.709", _BT709, D65),
    4: ("BT.470 M", ((0.67, 0.33), (0.21, 0.71), (0.14, 0.08)), (0.310, 0.316)),
    5: ("BT.470 BG", ((0.64, 0.33), (0.29, 0.60), (0.15, 0.06)), D65),
    6: ("BT.601 525", ((0.630, 0.340), (0.310, 0.595), (0.155, 0.070)), D65),
    7: ("SMPTE ST 240", ((0.630, 0.340), (0.310, 0.595), (0.155, 0.070)), D65),
    9: ("BT.2020", ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046)), D65),
    11: ("DCI-P3", _P3, (0.314, 0.351)),
    12: ("Display P3", _P3, D65),
    22: ("EBU Tech. 3213", ((0.630, 0.340), (0.295, 0.605), (0.155, 0.077)), D65),
}
_TRANSFERS: dict[int, tuple[str, str, float]] = {
    # ITU-T H.273 (2024), table 3. Pictures are meant for displays: BT.709's camera curve is shown
    # by the one of BT.1886.
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


def code_point_encoding(primaries: int, transfer: int) -> Encoding | None:
    """Return the encoding of code points of ITU-T H.273.

    Parameters
    ----------
    primaries, transfer : int

    Returns
    -------
    Encoding or None
        None for code points that are reserved, unspecified, or that displays do not have.
    """
    if primaries not in _PRIMARIES or transfer not in _TRANSFERS:
        return None
    name, chromaticities, white = _PRIMARIES[primaries]
    curve, kind, gamma = _TRANSFERS[transfer]
    known = {("BT.709", "sRGB"): "sRGB", ("Display P3", "sRGB"): "Display P3"}
    return Encoding(
        known.get((name, curve), f"{name}, {curve}"), chromaticities, white, kind, gamma
    )


def gamma_encoding(
    gamma: float | None, chromaticities: tuple[Chromaticity, ...] | None
) -> Encoding | None:
    """Return the encoding of an exponent and chromaticities.

    Parameters
    ----------
    gamma : float or None
        Exponent from values to light; sRGB's curve if it is not stated.
    chromaticities : (white, red, green, blue) or None
        Those of sRGB if they are not stated.

    Returns
    -------
    Encoding or None
        None if the chromaticities are those of no display, or the exponent of no curve.
    """
    white, primaries = D65, _BT709
    said = []
    if chromaticities is not None:
        white, red, green, blue = chromaticities
        primaries = (red, green, blue)
        area = (green[0] - red[0]) * (blue[1] - red[1]) - (blue[0] - red[0]) * (green[1] - red[1])
        # ProPhoto's primaries are the largest in use: an area of 0.43, and blue's y 0.0001.
        sane = all(0 <= x <= 1 and 1e-5 <= y <= 1 for x, y in chromaticities)
        if not sane or abs(area) < 0.01 or not _inside(white, primaries, area):
            return None
        said.append("stated primaries")
    if gamma is not None:
        if not 0.1 <= gamma <= 10:
            return None
        said.append(f"gamma {gamma:.4g}")
    name = ", ".join(said) if said else SRGB.name
    if gamma is None:
        return Encoding(name, primaries, white)
    return Encoding(name, primaries, white, "power", gamma)


def _inside(white: Chromaticity, primaries: tuple[Chromaticity, ...], area: float) -> bool:
    """Return whether the white is a mixture of the primaries, each with a part of its own."""
    parts = []
    for index in range(3):
        (ax, ay), (bx, by) = primaries[index], primaries[(index + 1) % 3]
        parts.append(((bx - ax) * (white[1] - ay) - (white[0] - ax) * (by - ay)) / area)
    return all(part > 0.001 for part in parts)
