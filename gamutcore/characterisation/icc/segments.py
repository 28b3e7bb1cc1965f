"""Segmented curves of multi-process elements: formula segments and sampled segments.

Break points divide the real line into segments. Each segment is a formula or equally spaced
samples. Curve sets of `D2Bx` tags have such curves; iccMAX profiles may have them for every curve.
Values are floating-point numbers without a fixed range.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from gamutcore.errors import UnsupportedProfileError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.icc.element import Element

__all__ = ["FormulaSegment", "SampledSegment", "SegmentedCurve", "segmented_curve_at"]

FORMULA_PARAMETERS = (4, 5, 5, 5, 5, 6, 7, 6)
"""Parameters of the function types: 0 to 2 in ICC.1:2022, table 60, 3 to 7 in ICC.2:2023, table
111."""

MAX_SEGMENTS = 256
"""Maximum number of segments. Each needs a pass over the colours. Real curves have 1 to 5."""


def _power(base: FloatArray | float, exponent: FloatArray | float) -> FloatArray:
    # A negative base has a real power only for whole exponents. For other exponents the base is 0,
    # as in parametric curves.
    values, powers = np.broadcast_arrays(
        np.asarray(base, dtype=np.float64), np.asarray(exponent, dtype=np.float64)
    )
    whole = powers == np.floor(powers)
    result: FloatArray = np.where(whole, values, np.maximum(values, 0.0)) ** powers
    return result


@dataclass(frozen=True, eq=False)
class FormulaSegment:
    """A segment of function type 0 to 7, with parameters in the specification's order.

    Sources are ICC.1:2022, table 60, for types 0 to 2, and ICC.2:2023, table 111, for all types.
    """

    function: int
    parameters: FloatArray

    def values(self, x: FloatArray) -> FloatArray:
        """Return the formula at `x`; infinite or NaN for hostile parameters."""
        p = self.parameters.tolist()
        with np.errstate(all="ignore"):
            if self.function == 0:
                y = _power(p[1] * x + p[2], p[0]) + p[3]
            elif self.function == 1:
                y = p[1] * np.log10(p[2] * _power(x, p[0]) + p[3]) + p[4]
            elif self.function == 2:
                y = p[0] * _power(p[1], p[2] * x + p[3]) + p[4]
            elif self.function == 3:
                y = p[1] * _power(np.maximum(p[2] * x + p[3], 0.0), p[0]) + p[4]
            elif self.function == 4:
                y = p[1] * np.log(p[4] * _power(x, p[0]) - p[2]) + p[3]
            elif self.function == 5:
                ratio = (p[4] * _power(x, p[0]) - p[3]) / np.float64(p[1])
                y = p[5] * np.exp(ratio) + p[2]
            elif self.function == 6:
                inner = _power(x, p[1])
                y = p[5] * _power(
                    np.maximum(p[6] * inner - p[2], 0.0) / (p[3] - p[4] * inner), p[0]
                )
            else:
                inner = _power(x, p[1])
                y = p[5] * _power((p[2] + p[3] * inner) / (1.0 + p[4] * inner), p[0])
        return np.asarray(y, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class SampledSegment:
    """A segment through n ≥ 2 equally spaced samples, from break point `start` to `end`."""

    start: float
    end: float
    samples: FloatArray

    def values(self, x: FloatArray) -> FloatArray:
        """Return the segment at `x`, by linear interpolation."""
        return np.interp(x, np.linspace(self.start, self.end, len(self.samples)), self.samples)


Segment: TypeAlias = FormulaSegment | SampledSegment


@dataclass(frozen=True, eq=False)
class SegmentedCurve:
    """A curve of n segments with n - 1 rising break points between them.

    A break point belongs to the segment before it. The first segment starts at minus infinity, and
    the last ends at infinity.
    """

    breaks: FloatArray
    segments: tuple[Segment, ...]

    def values(self, x: FloatArray) -> FloatArray:
        """Return the curve at `x`."""
        if len(self.segments) == 1:
            return self.segments[0].values(x)
        places = np.searchsorted(self.breaks, x, side="left")
        y = np.empty_like(x)
        for number, segment in enumerate(self.segments):
            here = places == number
            if here.any():
                y[here] = segment.values(x[here])
        return y


def segmented_curve_at(element: Element, offset: int = 0) -> tuple[SegmentedCurve, int]:
    """Return the segmented curve (`curf`) at an offset of a tag, and its length in bytes.

    The offset is that of the type signature. The source is ICC.1:2022, 10.18.3, tables 58 to 61.
    """
    kind = element.raw(offset, 4).decode("latin-1")
    if kind != "curf":
        raise _unsupported(element, f"a curve of the type {kind!r}", "segmented curves (curf)")
    count = element.unsigned(offset + 8, 2)
    if count < 1:
        raise element.malformed("has a curve without segments")
    if count > MAX_SEGMENTS:
        raise _unsupported(element, f"a curve of {count} segments", f"at most {MAX_SEGMENTS}")
    breaks = element.floats(offset + 12, count - 1)
    if not (np.isfinite(breaks).all() and (np.diff(breaks) > 0).all()):
        raise element.malformed("has a curve whose break points do not rise")
    start, place = offset, offset + 12 + 4 * (count - 1)
    segments: list[Segment] = []
    for number in range(count):
        sampled = element.raw(place, 4)
        if sampled == b"parf":
            function = element.unsigned(place + 8, 2)
            if function >= len(FORMULA_PARAMETERS):
                raise _unsupported(element, f"the formula type {function}", "types 0 to 7")
            size = FORMULA_PARAMETERS[function]
            segments.append(FormulaSegment(function, element.floats(place + 12, size)))
        elif sampled == b"samf":
            size = element.unsigned(place + 8, 4)
            if number in {0, count - 1} or size < 1:
                raise element.malformed("has a sampled segment that lacks an end or samples")
            low, high = breaks[number - 1], breaks[number]
            # The segment before gives the value at the start (ICC.1:2022, 10.18.3.4).
            first = segments[-1].values(breaks[number - 1 : number])
            samples = np.concatenate([first, element.floats(place + 12, size)])
            segments.append(SampledSegment(float(low), float(high), samples))
        else:
            kind = sampled.decode("latin-1")
            raise _unsupported(
                element, f"a curve segment of the type {kind!r}", "formulas (parf), samples (samf)"
            )
        place += 12 + 4 * size
    return SegmentedCurve(breaks, tuple(segments)), place - start


def _unsupported(element: Element, what: str, evaluated: str) -> UnsupportedProfileError:
    return UnsupportedProfileError(
        f"The tag {element.tag} has {what}.",
        where={"tag": element.tag},
        remedy=f"Supported: {evaluated}.",
    )
