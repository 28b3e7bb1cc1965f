"""The formulas of the colour spaces: tristimulus values to coordinates, and back.

Every class is one kind of space. `coordinates` takes X, Y, Z that are adapted to the space's white,
with Y = 1 for it. It reports colours outside of the domain of a formula, for which the nearest
value in the domain is taken; `xyz` is the inverse. Both are finite for all finite input of
reasonable size. Noise makes some measured tristimulus values negative, where most roots and
logarithms are undefined.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from gamutcore.colours.colorimetry import (
    ADAPTATIONS,
    lab_to_xyz,
    rgb_to_xyz,
    white_point,
    xyz_to_lab,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from gamutcore.arrays import FloatArray

_SLIGHT = 1e-9
"""Tristimulus values this little below zero are rounding errors, not colours outside the domain."""


class Formula(Protocol):
    """Interface of the colour spaces. Arrays are (n, 3) float, and rows are colours."""

    def coordinates(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return the coordinates of colours, and whether each, (n,), was outside the domain."""

    def xyz(self, coordinates: FloatArray) -> FloatArray:
        """Return the tristimulus values of coordinates."""


def _none(xyz: FloatArray) -> NDArray[np.bool_]:
    return np.zeros(len(xyz), dtype=np.bool_)


def _negative(values: FloatArray) -> NDArray[np.bool_]:
    negative: NDArray[np.bool_] = np.any(values < -_SLIGHT, axis=1)
    return negative


@dataclass(frozen=True, eq=False)
class Ciexyz:
    """CIE 1931 tristimulus values themselves, Y = 1 for the white."""

    def coordinates(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Formula`."""
        return xyz, _none(xyz)

    def xyz(self, coordinates: FloatArray) -> FloatArray:
        """See `Formula`."""
        return coordinates


@dataclass(frozen=True, eq=False)
class Cielab:
    """CIE 1976 L*a*b* (CIE 15:2018, 8.2.1); the linear part continues below zero."""

    white: FloatArray

    def coordinates(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Formula`."""
        return xyz_to_lab(xyz, self.white), _none(xyz)

    def xyz(self, coordinates: FloatArray) -> FloatArray:
        """See `Formula`."""
        return lab_to_xyz(coordinates, self.white)


@dataclass(frozen=True, eq=False)
class Cieluv:
    """CIE 1976 L*u*v* (CIE 15:2018, 8.2.2); negative tristimulus values are raised to zero."""

    white: FloatArray

    def coordinates(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Formula`."""
        outside = _negative(xyz)
        x, y, z = np.maximum(xyz, 0.0).T
        ratio = y / self.white[1]
        lightness = np.where(
            ratio > (6 / 29) ** 3, 116 * np.cbrt(ratio) - 16, ratio * (29 / 3) ** 3
        )
        u0, v0 = self._white_chromaticity()
        total = x + 15 * y + 3 * z
        seen = total > 0
        divisor = np.where(seen, total, 1.0)
        u = np.where(seen, 4 * x / divisor - u0, 0.0)
        v = np.where(seen, 9 * y / divisor - v0, 0.0)
        return np.stack([lightness, 13 * lightness * u, 13 * lightness * v], axis=1), outside

    def xyz(self, coordinates: FloatArray) -> FloatArray:
        """See `Formula`."""
        lightness, u, v = coordinates.T
        lit = lightness > 0
        scale = 13 * np.where(lit, lightness, 1.0)
        u0, v0 = self._white_chromaticity()
        u = np.where(lit, u / scale, 0.0) + u0
        v = np.maximum(np.where(lit, v / scale, 0.0) + v0, 1e-4)  # no colour has v' = 0
        y = np.where(lightness > 8, ((lightness + 16) / 116) ** 3, lightness * (3 / 29) ** 3)
        y = np.where(lit, y, 0.0) * self.white[1]
        return np.stack([y * 9 * u / (4 * v), y, y * (12 - 3 * u - 20 * v) / (4 * v)], axis=1)

    def _white_chromaticity(self) -> tuple[float, float]:
        """The chromaticity u′, v′ of the white."""
        x, y, z = self.white
        total = x + 15 * y + 3 * z
        return float(4 * x / total), float(9 * y / total)


@dataclass(frozen=True, eq=False)
class Din99:
    """DIN99o (DIN 6176:2018): CIELAB, rotated by 26° and compressed logarithmically."""

    white: FloatArray

    ANGLE = np.deg2rad(26.0)
    FLATTENING = 0.83
    LIGHTNESS = 0.0039
    LIGHTNESS_SCALE = 100.0 / np.log1p(0.39)
    """303.67 in the standard, rounded from the factor that gives white a lightness of 100."""
    CHROMA, CHROMA_SCALE = 0.075, 1.0 / 0.0435

    def coordinates(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Formula`."""
        lightness, a, b = Cielab(self.white).coordinates(xyz)[0].T
        cosine, sine = np.cos(self.ANGLE), np.sin(self.ANGLE)
        red, yellow = a * cosine + b * sine, self.FLATTENING * (b * cosine - a * sine)
        chroma = self.CHROMA_SCALE * np.log1p(self.CHROMA * np.hypot(red, yellow))
        hue = np.arctan2(yellow, red) + self.ANGLE
        outside: NDArray[np.bool_] = lightness < -100 * _SLIGHT
        light = self.LIGHTNESS_SCALE * np.log1p(self.LIGHTNESS * np.maximum(lightness, 0.0))
        return np.stack([light, chroma * np.cos(hue), chroma * np.sin(hue)], axis=1), outside

    def xyz(self, coordinates: FloatArray) -> FloatArray:
        """See `Formula`."""
        light, first, second = coordinates.T
        chroma = np.minimum(np.hypot(first, second), 200.0)
        radius = np.expm1(chroma / self.CHROMA_SCALE) / self.CHROMA
        hue = np.arctan2(second, first) - self.ANGLE
        red, yellow = radius * np.cos(hue), radius * np.sin(hue) / self.FLATTENING
        cosine, sine = np.cos(self.ANGLE), np.sin(self.ANGLE)
        lightness = np.expm1(np.clip(light, 0.0, 200.0) / self.LIGHTNESS_SCALE) / self.LIGHTNESS
        lab = np.stack([lightness, red * cosine - yellow * sine, red * sine + yellow * cosine], 1)
        return Cielab(self.white).xyz(lab)


@dataclass(frozen=True, eq=False)
class PowerOpponent:
    """Cone responses raised to a power with their sign, and made opponent by a matrix."""

    cones: FloatArray
    exponent: float
    opponent: FloatArray

    def coordinates(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Formula`."""
        responses = xyz @ self.cones.T
        raised = np.sign(responses) * np.abs(responses) ** self.exponent
        return raised @ self.opponent.T, _none(xyz)

    def xyz(self, coordinates: FloatArray) -> FloatArray:
        """See `Formula`."""
        raised = coordinates @ np.linalg.inv(self.opponent).T
        responses = np.sign(raised) * np.abs(raised) ** (1.0 / self.exponent)
        result: FloatArray = responses @ np.linalg.inv(self.cones).T
        return result


OKLAB = PowerOpponent(
    np.array(
        [
            (0.8189330101, 0.3618667424, -0.1288597137),
            (0.0329845436, 0.9293118715, 0.0361456387),
            (0.0482003018, 0.2643662691, 0.6338517070),
        ]
    ),
    1.0 / 3.0,
    np.array(
        [
            (0.2104542553, 0.7936177850, -0.0040720468),
            (1.9779984951, -2.4285922050, 0.4505937099),
            (0.0259040371, 0.7827717662, -0.8086757660),
        ]
    ),
)
"""Ottosson, A perceptual color space for image processing (2020); D65."""

IPT = PowerOpponent(
    np.array([(0.4002, 0.7075, -0.0807), (-0.2280, 1.1500, 0.0612), (0.0, 0.0, 0.9184)]),
    0.43,
    np.array([(0.4, 0.4, 0.2), (4.4550, -4.8510, 0.3960), (0.8056, 0.3572, -1.1628)]),
)
"""Ebner and Fairchild, 6th Color Imaging Conference (1998); D65."""


_M1, _M2 = 2610 / 16384, 2523 / 4096 * 128
_C1, _C2, _C3 = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32
_PEAK = 10_000.0


def pq_signal(luminance: FloatArray, exponent: float = _M2) -> FloatArray:
    """Return the signal of luminances in cd/m², 0 or more, in the perceptual quantizer.

    The signal of 10,000 cd/m² is 1. Jzazbz has another outer exponent. ITU-R BT.2100-2, table 4.
    """
    powers = (luminance / _PEAK) ** _M1
    signal: FloatArray = ((_C1 + _C2 * powers) / (1.0 + _C3 * powers)) ** exponent
    return signal


def pq_luminance(signal: FloatArray, exponent: float = _M2) -> FloatArray:
    """Return the luminances of signals in cd/m²; the inverse of `pq_signal`.

    Signals are at most about 2. Those below the signal of zero luminance are taken as that signal.
    """
    roots = np.minimum(np.maximum(signal, 0.0) ** (1.0 / exponent), 1.0075)  # the pole is at 1.0088
    luminance: FloatArray = _PEAK * (np.maximum(roots - _C1, 0.0) / (_C2 - _C3 * roots)) ** (
        1.0 / _M1
    )
    return luminance


def hlg_luminance(signals: FloatArray, luminance: FloatArray) -> FloatArray:
    """Return linear RGB (n, 3) in cd/m² of HLG signals, on a display of 1,000 cd/m².

    `luminance` (3,) has the luminances of the primaries in parts of the white's. ITU-R BT.2100-2,
    table 5, with the system gamma of 1.2 and without a black level.
    """
    a, b, c = 0.17883277, 0.28466892, 0.55991073
    scene = np.where(signals <= 0.5, signals**2 / 3, (np.exp((signals - c) / a) + b) / 12)
    bright = np.maximum(scene @ luminance, 1e-12)
    light: FloatArray = 1000.0 * bright[:, np.newaxis] ** 0.2 * scene
    return light


@dataclass(frozen=True, eq=False)
class PerceptualQuantizer:
    """Cone responses in cd/m² through the perceptual quantizer, made opponent by a matrix.

    Negative responses are raised to zero, because the quantizer is defined for light only.
    """

    cones: FloatArray
    opponent: FloatArray
    luminance: float

    def coordinates(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Formula`."""
        responses = xyz @ self.cones.T
        outside = _negative(responses)
        return pq_signal(np.maximum(responses, 0.0) * self.luminance) @ self.opponent.T, outside

    def xyz(self, coordinates: FloatArray) -> FloatArray:
        """See `Formula`."""
        signals = coordinates @ np.linalg.inv(self.opponent).T
        result: FloatArray = pq_luminance(signals) / self.luminance @ np.linalg.inv(self.cones).T
        return result


def ictcp(luminance: float, *, itp: bool = False) -> PerceptualQuantizer:
    """Return ICtCp for PQ with a white in cd/m², or the space with ΔE_ITP as its distance.

    With `itp`, T is half of Ct, and all coordinates are scaled by 720. ITU-R BT.2100-2, table 7;
    ΔE_ITP is that of ITU-R BT.2124-0, annex 1. Tristimulus values are first converted to the
    primaries of BT.2020 with D65.
    """
    bt2020 = ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046))
    to_xyz = rgb_to_xyz(bt2020, white_point("D65"))
    to_cones = np.array([(1688, 2146, 262), (683, 2951, 462), (99, 309, 3688)]) / 4096
    opponent = np.array([(2048, 2048, 0), (6610, -13613, 7003), (17933, -17390, -543)]) / 4096
    if itp:
        opponent = opponent * np.array([[720.0], [360.0], [720.0]])
    return PerceptualQuantizer(to_cones @ np.linalg.inv(to_xyz), opponent, luminance)


@dataclass(frozen=True, eq=False)
class Jzazbz:
    """Jzazbz (Safdar et al., Optics Express 25 (2017), equations 8 to 12; D65, absolute)."""

    luminance: float

    B, G = 1.15, 0.66
    D, D0 = -0.56, 1.6295499532821566e-11
    EXPONENT = 1.7 * 2523 / 2**5
    CONES = np.array(
        [
            (0.41478972, 0.579999, 0.0146480),
            (-0.2015100, 1.120649, 0.0531008),
            (-0.0166008, 0.264800, 0.6684799),
        ]
    )
    OPPONENT = np.array(
        [(0.5, 0.5, 0.0), (3.524000, -4.066708, 0.542708), (0.199076, 1.096799, -1.295875)]
    )

    def coordinates(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Formula`."""
        x, y, z = xyz.T
        shifted = np.stack(
            [self.B * x - (self.B - 1) * z, self.G * y - (self.G - 1) * x, z], axis=1
        )
        responses = shifted @ self.CONES.T
        outside = _negative(responses)
        signals = pq_signal(np.maximum(responses, 0.0) * self.luminance, self.EXPONENT)
        intensity, a, b = self.OPPONENT @ signals.T
        lightness = (1 + self.D) * intensity / (1 + self.D * intensity) - self.D0
        return np.stack([lightness, a, b], axis=1), outside

    def xyz(self, coordinates: FloatArray) -> FloatArray:
        """See `Formula`."""
        lightness, a, b = coordinates.T
        lightness = np.clip(lightness + self.D0, 0.0, 2.0)
        intensity = lightness / (1 + self.D - self.D * lightness)
        signals = np.linalg.solve(self.OPPONENT, np.stack([intensity, a, b])).T
        responses = pq_luminance(signals, self.EXPONENT) / self.luminance
        shifted_x, shifted_y, z = np.linalg.solve(self.CONES, responses.T)
        x = (shifted_x + (self.B - 1) * z) / self.B
        return np.stack([x, (shifted_y + (self.G - 1) * x) / self.G, z], axis=1)


SURROUNDS = {"average": (1.0, 0.69, 1.0), "dim": (0.9, 0.59, 0.9), "dark": (0.8, 0.525, 0.8)}
"""Factors F, c and N_c of surrounds (CIE 159:2004, table 1; Li et al. 2017, table A1)."""

_CONES = np.array([(0.38971, 0.68898, -0.07868), (-0.22981, 1.18340, 0.04641), (0.0, 0.0, 1.0)])
"""XYZ to the cones of Hunt, Pointer and Estévez, equal energy normalised (CIE 159:2004, 8.5)."""

_LIGHTNESS_CURVE, _CHROMA_CURVE = 0.007, 0.0228
"""Constants of the uniform spaces (Luo, Cui and Li 2006, table 2; Li et al. 2017, equation 4)."""

_OFFSET = 0.305
"""The value of 2R + G + B/20 without light, where each response is 0.1."""

_LEAST_SUM = 1e-3
"""Smallest R + G + 21/20 B, the divisor of chroma. It is 0.305 without light, and more for
colours."""


class AppearanceModel:
    """The uniform space CAM02-UCS or CAM16-UCS of a colour appearance model.

    Responses are adapted to the white, compressed and made opponent. CIECAM02 adapts in the space
    of CAT02 and compresses in that of the cones. CAM16 does both in the space of CAT16, which
    avoids the failures of CIECAM02 for saturated blues. Negative tristimulus values are raised to
    zero.

    CIE 159:2004, 8 and 9; Li et al., Comprehensive color solutions: CAM16, CAT16, and CAM16-UCS,
    Color Research and Application 42 (2017), appendices A and B.

    Parameters
    ----------
    adaptation : str
        ``"CAT16"`` for CAM16, or ``"CAT02"`` for CIECAM02.
    white : (3,) float
        X, Y, Z of the adopted white, with Y of about 1.
    adapting_luminance, background : float
        L_A in cd/m², usually a fifth of the white's luminance; Y_b in per cent of the white.
    surround : str
        A key of `SURROUNDS`.
    """

    def __init__(
        self,
        adaptation: str,
        white: FloatArray,
        adapting_luminance: float,
        background: float,
        surround: str,
    ) -> None:
        factor, impact, induction = SURROUNDS[surround]
        fifth = 5.0 * adapting_luminance
        k = 1.0 / (fifth + 1.0)
        self._luminance_level = float(
            0.2 * k**4 * fifth + 0.1 * (1.0 - k**4) ** 2 * fifth ** (1.0 / 3.0)
        )
        white = white * 100.0
        ratio = float(background / white[1])
        self._background_induction = 0.725 * ratio**-0.2
        self._exponent = impact * (1.48 + ratio**0.5)
        self._chroma_factor = (1.64 - 0.29**ratio) ** 0.73
        self._chroma_induction = 50000.0 / 13.0 * induction * self._background_induction
        degree = factor * (1.0 - np.exp((-adapting_luminance - 42.0) / 92.0) / 3.6)
        degree = min(max(float(degree), 0.0), 1.0)
        sharp = np.array(ADAPTATIONS[adaptation])
        gains = degree * white[1] / (sharp @ white) + 1.0 - degree
        # from XYZ to the adapted responses before compression
        self._to_adapted: FloatArray = gains[:, np.newaxis] * sharp
        if adaptation != "CAT16":
            self._to_adapted = _CONES @ np.linalg.inv(sharp) @ self._to_adapted
        red, green, blue = self._compression(self._to_adapted @ white)
        response = (2.0 * red + green + blue / 20.0 - _OFFSET) * self._background_induction
        self._white_response = float(response)

    def coordinates(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Formula`."""
        seen = np.maximum(xyz, 0.0) * 100.0
        red, green, blue = self._compression(seen @ self._to_adapted.T).T
        a = red - 12.0 * green / 11.0 + blue / 11.0
        b = (red + green - 2.0 * blue) / 9.0
        achromatic = (2.0 * red + green + blue / 20.0 - _OFFSET) * self._background_induction
        total = red + green + 1.05 * blue
        outside = (achromatic < -1e-9) | (total < _LEAST_SUM)
        hue = np.arctan2(b, a)
        strength = self._eccentricity(hue) * np.hypot(a, b) / np.maximum(total, _LEAST_SUM)
        relative = np.maximum(achromatic, 0.0) / self._white_response
        lightness = 100.0 * relative**self._exponent
        chroma = strength**0.9 * np.sqrt(lightness / 100.0) * self._chroma_factor
        colourfulness = chroma * self._luminance_level**0.25
        radius = np.log1p(_CHROMA_CURVE * colourfulness) / _CHROMA_CURVE
        light = (1.0 + 100.0 * _LIGHTNESS_CURVE) * lightness / (1.0 + _LIGHTNESS_CURVE * lightness)
        coordinates = np.stack([light, radius * np.cos(hue), radius * np.sin(hue)], axis=1)
        return coordinates, _negative(xyz) | outside

    def xyz(self, coordinates: FloatArray) -> FloatArray:
        """See `Formula`. The inverse is in closed form (Li et al. 2017, appendix B)."""
        uniform, first, second = coordinates.T
        uniform = np.clip(uniform, 0.0, 200.0)
        lightness = uniform / (1.0 + 100.0 * _LIGHTNESS_CURVE - _LIGHTNESS_CURVE * uniform)
        radius = np.minimum(np.hypot(first, second), 500.0)
        colourfulness = np.expm1(_CHROMA_CURVE * radius) / _CHROMA_CURVE
        hue = np.arctan2(second, first)
        root = np.sqrt(lightness / 100.0)
        lit = root > 0.0
        chroma = colourfulness / self._luminance_level**0.25
        relative = chroma / (np.where(lit, root, 1.0) * self._chroma_factor)
        strength = np.where(lit, relative, 0.0) ** (1.0 / 0.9)
        response = self._white_response * root ** (2.0 / self._exponent)
        level = response / self._background_induction
        cosine, sine = np.cos(hue), np.sin(hue)
        divisor = 23.0 * self._eccentricity(hue) + strength * (11.0 * cosine + 108.0 * sine)
        size = 23.0 * (level + _OFFSET) * strength / np.where(divisor > 1e-6, divisor, np.inf)
        a, b = size * cosine, size * sine
        responses = [
            460.0 * level + 451.0 * a + 288.0 * b,
            460.0 * level - 891.0 * a - 261.0 * b,
            460.0 * level - 220.0 * a - 6300.0 * b,
        ]
        compressed = np.stack(responses, axis=1) / 1403.0
        # the inverse of `_compression`, without the offset of 0.1
        sizes = np.minimum(np.abs(compressed), 399.0)
        powers = (27.13 * sizes / (400.0 - sizes)) ** (1.0 / 0.42)
        expanded = np.sign(compressed) * 100.0 / self._luminance_level * powers
        xyz: FloatArray = expanded @ np.linalg.inv(self._to_adapted).T / 100.0
        return xyz

    def _compression(self, responses: FloatArray) -> FloatArray:
        powers = (self._luminance_level * np.abs(responses) / 100.0) ** 0.42
        compressed: FloatArray = np.sign(responses) * 400.0 * powers / (powers + 27.13) + 0.1
        return compressed

    def _eccentricity(self, hue: FloatArray) -> FloatArray:
        result: FloatArray = self._chroma_induction * 0.25 * (np.cos(hue + 2.0) + 3.8)
        return result
