"""The side of a triangle's plane on which a point lies: the predicate of the convex hull.

Double precision nearly always suffices. The error bound of Shewchuk, "Adaptive Precision
Floating-Point Arithmetic and Fast Robust Geometric Predicates" (1997), tells when it does not. The
predicate is then computed with pairs of doubles (Dekker, "A floating-point technique for extending
the available precision", 1971), in about 100 bits. A volume below some 10⁻³⁰ of the product of the
sides counts as zero: the point is then on the plane.
"""

from __future__ import annotations

from gamutcore.arrays import FloatArray
from gamutcore.kernels import leaf_kernel

__all__ = ["is_above"]

ROUNDING = 2.0**-53
"""Relative error of one operation in float64."""

DOUBLE_ERROR = 8.0 * ROUNDING
"""Error of the determinant ÷ its permanent: (7 + 56 u) u (Shewchuk, 1997, bound A of ORIENT3D)."""

PAIR_ERROR = 2.0**-98
"""The same bound with pairs: 31 u² < 2⁻¹⁰¹ for two products (7 u² each) and three sums (3 u²
each) by the bounds of Joldes, Muller & Popescu, "Tight and rigorous error bounds for basic
building blocks of double-word arithmetic" (2017), with a margin."""

SPLITTER = 2.0**27 + 1.0
"""Splits a float64 into halves with exact products (Dekker, 1971)."""


@leaf_kernel
def is_above(position: FloatArray, one: int, two: int, three: int, point: int) -> bool:
    """Whether a point is above the plane of a triangle, on its counter-clockwise side.

    A point on the plane is not above it. The answer is the same for any cyclic order of the
    corners. Coordinates must be so far from the limits of float64 that products of three neither
    overflow nor underflow.
    """
    x, y, z = position[point, 0], position[point, 1], position[point, 2]
    ax, ay, az = position[one, 0] - x, position[one, 1] - y, position[one, 2] - z
    bx, by, bz = position[two, 0] - x, position[two, 1] - y, position[two, 2] - z
    cx, cy, cz = position[three, 0] - x, position[three, 1] - y, position[three, 2] - z
    by_cz, bz_cy = by * cz, bz * cy
    bz_cx, bx_cz = bz * cx, bx * cz
    bx_cy, by_cx = bx * cy, by * cx
    determinant = ax * (by_cz - bz_cy) + ay * (bz_cx - bx_cz) + az * (bx_cy - by_cx)
    permanent = (
        abs(ax) * (abs(by_cz) + abs(bz_cy))
        + abs(ay) * (abs(bz_cx) + abs(bx_cz))
        + abs(az) * (abs(bx_cy) + abs(by_cx))
    )
    if abs(determinant) > DOUBLE_ERROR * permanent:
        return determinant < 0.0
    return _is_above_in_pairs(position, one, two, three, point)


@leaf_kernel
def _is_above_in_pairs(position: FloatArray, one: int, two: int, three: int, point: int) -> bool:
    """As `is_above`, with every number the sum of two float64 numbers."""
    if two < one and two < three:  # the same rounding in any cyclic order
        one, two, three = two, three, one
    elif three < one:
        one, two, three = three, one, two
    determinant, permanent = (0.0, 0.0), 0.0
    for axis in range(3):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        forwards = _product(
            _sum(position[two, second], -position[point, second]),
            _sum(position[three, third], -position[point, third]),
        )
        backwards = _product(
            _sum(position[two, third], -position[point, third]),
            _sum(position[three, second], -position[point, second]),
        )
        along = _sum(position[one, axis], -position[point, axis])
        minor = _pair_sum(forwards, (-backwards[0], -backwards[1]))
        determinant = _pair_sum(determinant, _product(along, minor))
        permanent += abs(along[0]) * (abs(forwards[0]) + abs(backwards[0]))
    return determinant[0] < -PAIR_ERROR * permanent


@leaf_kernel
def _sum(a: float, b: float) -> tuple[float, float]:
    """Sum of two numbers and its rounding error (two-sum of Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@leaf_kernel
def _pair_sum(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """Sum of two pairs."""
    high, error = _sum(a[0], b[0])
    low, rest = _sum(a[1], b[1])
    error += low
    total = high + error
    error = error - (total - high) + rest
    result = total + error
    return result, error - (result - total)


@leaf_kernel
def _product(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """Product of two pairs."""
    product = a[0] * b[0]
    scaled = SPLITTER * a[0]
    a_high = scaled - (scaled - a[0])
    a_low = a[0] - a_high
    scaled = SPLITTER * b[0]
    b_high = scaled - (scaled - b[0])
    b_low = b[0] - b_high
    error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
    error += a[0] * b[1] + a[1] * b[0]
    result = product + error
    return result, error - (result - product)
