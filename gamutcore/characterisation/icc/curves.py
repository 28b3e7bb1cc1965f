"""One-dimensional curves of ICC profiles, sampled and parametric.

Sampled curves have the type `curv`, or are tables of lut8 and lut16. They interpolate linearly and
are constant outside their domain. Parametric curves have the type `para` and are evaluated in
floating point, as in the reference implementation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from gamutcore.characterisation.icc.segments import SegmentedCurve, segmented_curve_at

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.icc.element import Element

__all__ = ["Curve", "ParametricCurve", "SampledCurve", "curve_at"]

PARAMETER_COUNTS = (1, 3, 4, 5, 7)
"""Parameters of the function types 0 to 4 (ICC.1:2022, table 68)."""


@dataclass(frozen=True, eq=False)
class SampledCurve:
    """A curve through n ≥ 2 equally spaced samples: outputs, 0 to 1, for inputs from 0 to 1."""

    samples: FloatArray

    def values(self, x: FloatArray) -> FloatArray:
        """Return the curve at `x`; outside 0 to 1 the curve is constant."""
        last = len(self.samples) - 1
        return np.interp(x * last, np.arange(last + 1), self.samples)


@dataclass(frozen=True, eq=False)
class ParametricCurve:
    """A curve of function type 0 to 4 (ICC.1:2022, 10.18, table 68).

    `parameters` are the first of g, a, b, c, d, e, f, as many as the function has.
    """

    function: int
    parameters: FloatArray

    def values(self, x: FloatArray) -> FloatArray:
        """Return the curve at `x`, clipped to 0 to 1.

        Results are 0 to 1, but infinite or NaN for hostile parameters. Transforms check their
        results.
        """
        # Domain and range are 0 to 1, and values outside are clipped (ICC.1:2022, 10.18).
        y = self._formula(np.clip(x, 0.0, 1.0))
        return np.where(np.isfinite(y), np.clip(y, 0.0, 1.0), y)

    def _formula(self, x: FloatArray) -> FloatArray:
        g, a, b, c, d, e, f = np.append(
            self.parameters, np.zeros(7 - len(self.parameters))
        ).tolist()
        if self.function == 0:
            return _power(x, g)
        base = a * x + b
        power = _power(base, g)
        # Types 1 and 2 start at x = -b/a, where the base becomes positive. Type 1 is type 2 with
        # c = 0; type 3 is type 4 with e = f = 0.
        if self.function in {1, 2}:
            return np.asarray(np.where(base >= 0, power, 0.0) + c, dtype=np.float64)
        return np.asarray(np.where(x >= d, power + e, c * x + f), dtype=np.float64)


Curve: TypeAlias = SampledCurve | ParametricCurve | SegmentedCurve


def _power(base: FloatArray, exponent: float) -> FloatArray:
    with np.errstate(all="ignore"):
        power: FloatArray = np.maximum(base, 0.0) ** exponent
        return power


def curve_at(element: Element, offset: int = 0) -> tuple[Curve, int]:
    """Return the curve (`curv`, `para` or `curf`) at an offset of a tag, and its length.

    The offset is that of the curve's type signature. The length is in bytes, without padding.
    """
    kind = element.raw(offset, 4)
    if kind == b"curv":
        count = element.unsigned(offset + 8, 4)
        if count == 0:
            return ParametricCurve(0, np.ones(1)), 12
        if count == 1:
            # One value is an exponent of the type u8Fixed8Number (ICC.1:2022, 10.6).
            return ParametricCurve(0, np.array([element.unsigned(offset + 12, 2) / 256.0])), 14
        return SampledCurve(element.integers(offset + 12, count, 2) / 65535.0), 12 + 2 * count
    if kind == b"para":
        function = element.unsigned(offset + 8, 2)
        if function >= len(PARAMETER_COUNTS):
            raise element.malformed(
                f"has a parametric curve of the unknown function type {function}"
            )
        count = PARAMETER_COUNTS[function]
        return ParametricCurve(function, element.fixed(offset + 12, count)), 12 + 4 * count
    if kind == b"curf":
        return segmented_curve_at(element, offset)
    raise element.malformed(
        f"has {kind.decode('latin-1')!r} in place of a curve",
        "Curves are of the type curv or para, or curf in iccMAX profiles.",
    )
