"""CIECAM02 and CAM16, and their uniform spaces CAM02-UCS and CAM16-UCS.

Both models have the same structure: responses are adapted to the white, compressed and made
opponent. CIECAM02 adapts in the space of CAT02 and compresses in that of the cones. CAM16 does both
in the space of CAT16, which avoids the failures of CIECAM02 for saturated blues. The inverse is in
closed form (Li et al. 2017, appendix B). Both directions are finite for all finite colours: outside
of the domain of the model, the nearest value in the domain is taken and reported.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces.white_points import ADAPTATIONS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from gamutcore.arrays import FloatArray

__all__ = ["SURROUNDS", "AppearanceModel"]

SURROUNDS = {"average": (1.0, 0.69, 1.0), "dim": (0.9, 0.59, 0.9), "dark": (0.8, 0.525, 0.8)}
"""Factors F, c and N_c of surrounds (CIE 159:2004, table 1; Li et al. 2017, table A1)."""

_CONES = np.array([(0.38971, 0.68898, -0.07868), (-0.22981, 1.18340, 0.04641), (0.0, 0.0, 1.0)])
"""XYZ to the cones of Hunt, Pointer and Estévez, equal energy normalised (CIE 159:2004, 8.5)."""

_C1, _C2 = 0.007, 0.0228
"""Constants of the uniform spaces (Luo, Cui and Li 2006, table 2; Li et al. 2017, equation 4)."""

_OFFSET = 0.305
"""The value of 2R + G + B/20 without light, where each response is 0.1."""

_LEAST_SUM = 1e-3
"""Smallest R + G + 21/20 B, the divisor of chroma. It is 0.305 without light, and more for
colours."""


@dataclass(frozen=True, eq=False)
class AppearanceModel:
    """A colour appearance model under its viewing conditions.

    CIE 159:2004, 8 and 9; Li et al., Comprehensive color solutions: CAM16, CAT16, and CAM16-UCS,
    Color Research and Application 42 (2017), appendices A and B.

    Attributes
    ----------
    name : str
        ``"CAM16"`` or ``"CIECAM02"``.
    white : (3,) float
        X, Y, Z of the adopted white, with Y of about 100.
    adapting_luminance : float
        L_A in cd/m²: usually a fifth of the white's luminance.
    background : float
        Y_b, the luminance factor of the background, in the scale of `white`.
    surround : str
        A key of `SURROUNDS`.
    """

    name: str
    white: FloatArray
    adapting_luminance: float
    background: float
    surround: str

    def correlates(
        self, xyz: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
        """Return lightness J, colourfulness M and hue h, (n,), and whether colours left the domain.

        Colours (n, 3) are in the scale of the white. The hue is in radians, −π to π.
        """
        red, green, blue = self._compression(xyz @ self._to_adapted.T).T
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
        return lightness, chroma * self._luminance_level**0.25, hue, outside

    def uniform(self, xyz: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return J', a', b' (n, 3) in the uniform space, and whether colours left the domain.

        Colours (n, 3) are in the scale of the white.
        """
        lightness, colourfulness, hue, outside = self.correlates(xyz)
        radius = np.log1p(_C2 * colourfulness) / _C2
        coordinates = np.stack(
            [
                (1.0 + 100.0 * _C1) * lightness / (1.0 + _C1 * lightness),
                radius * np.cos(hue),
                radius * np.sin(hue),
            ],
            axis=1,
        )
        return coordinates, outside

    def tristimulus(self, coordinates: FloatArray) -> FloatArray:
        """Return X, Y, Z of J', a', b' in the scale of the white; the inverse of `uniform`.

        J' is below 200. Values outside the range of the model become the nearest in it.
        """
        uniform, first, second = coordinates.T
        uniform = np.clip(uniform, 0.0, 200.0)
        lightness = uniform / (1.0 + 100.0 * _C1 - _C1 * uniform)
        radius = np.minimum(np.hypot(first, second), 500.0)
        colourfulness = np.expm1(_C2 * radius) / _C2
        hue = np.arctan2(second, first)
        root = np.sqrt(lightness / 100.0)
        lit = root > 0.0
        chroma = colourfulness / self._luminance_level**0.25
        strength = np.where(
            lit, chroma / (np.where(lit, root, 1.0) * self._chroma_factor), 0.0
        ) ** (1.0 / 0.9)
        response = self._white_response * root ** (2.0 / self._exponent)
        level = response / self._background_induction
        cosine, sine = np.cos(hue), np.sin(hue)
        divisor = 23.0 * self._eccentricity(hue) + strength * (11.0 * cosine + 108.0 * sine)
        size = 23.0 * (level + _OFFSET) * strength / np.where(divisor > 1e-6, divisor, np.inf)
        a, b = size * cosine, size * sine
        compressed = (
            np.stack(
                [
                    460.0 * level + 451.0 * a + 288.0 * b,
                    460.0 * level - 891.0 * a - 261.0 * b,
                    460.0 * level - 220.0 * a - 6300.0 * b,
                ],
                axis=1,
            )
            / 1403.0
        )
        xyz: FloatArray = self._expansion(compressed) @ np.linalg.inv(self._to_adapted).T
        return xyz

    @cached_property
    def _luminance_level(self) -> float:
        fifth = 5.0 * self.adapting_luminance
        k = 1.0 / (fifth + 1.0)
        return float(0.2 * k**4 * fifth + 0.1 * (1.0 - k**4) ** 2 * fifth ** (1.0 / 3.0))

    @cached_property
    def _ratio(self) -> float:
        return float(self.background / self.white[1])

    @cached_property
    def _background_induction(self) -> float:
        return float(0.725 * self._ratio**-0.2)

    @cached_property
    def _exponent(self) -> float:
        return float(SURROUNDS[self.surround][1] * (1.48 + self._ratio**0.5))

    @cached_property
    def _chroma_factor(self) -> float:
        return float((1.64 - 0.29**self._ratio) ** 0.73)

    @cached_property
    def _to_adapted(self) -> FloatArray:
        """Matrix from XYZ to the adapted responses before compression, (3, 3)."""
        factor, _, _ = SURROUNDS[self.surround]
        degree = factor * (1.0 - np.exp((-self.adapting_luminance - 42.0) / 92.0) / 3.6)
        degree = min(max(float(degree), 0.0), 1.0)
        sharp = np.array(ADAPTATIONS["CAT16" if self.name == "CAM16" else "CAT02"])
        gains = degree * self.white[1] / (sharp @ self.white) + 1.0 - degree
        adapted: FloatArray = gains[:, np.newaxis] * sharp
        if self.name == "CAM16":
            return adapted
        cones: FloatArray = _CONES @ np.linalg.inv(sharp) @ adapted
        return cones

    @cached_property
    def _white_response(self) -> float:
        red, green, blue = self._compression(self._to_adapted @ self.white)
        return float((2.0 * red + green + blue / 20.0 - _OFFSET) * self._background_induction)

    def _compression(self, responses: FloatArray) -> FloatArray:
        powers = (self._luminance_level * np.abs(responses) / 100.0) ** 0.42
        compressed: FloatArray = np.sign(responses) * 400.0 * powers / (powers + 27.13) + 0.1
        return compressed

    def _expansion(self, compressed: FloatArray) -> FloatArray:
        """Inverse of `_compression`, for values without the offset of 0.1."""
        sizes = np.minimum(np.abs(compressed), 399.0)
        powers = (27.13 * sizes / (400.0 - sizes)) ** (1.0 / 0.42)
        expanded: FloatArray = np.sign(compressed) * 100.0 / self._luminance_level * powers
        return expanded

    def _eccentricity(self, hue: FloatArray) -> FloatArray:
        _, _, induction = SURROUNDS[self.surround]
        factor = 50000.0 / 13.0 * induction * self._background_induction
        result: FloatArray = factor * 0.25 * (np.cos(hue + 2.0) + 3.8)
        return result
