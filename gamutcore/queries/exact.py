"""Signs of determinants without rounding errors, for the decisions that float64 cannot make.

A determinant is first computed in float64 with a bound of its error. If the bound leaves the sign
open, the determinant is summed up exactly as an expansion: a list of floats whose bits do not
overlap, in increasing order. The last float then has the sign of the sum.

Source: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
Predicates", Discrete & Computational Geometry 18 (1997): two-sum, two-product, Theorem 10
(grow-expansion) and the error bound of ORIENT3D in section 4.3.
"""

from __future__ import annotations

from gamutcore.arrays import FloatArray
from gamutcore.kernels import leaf_kernel

__all__ = ["TERMS", "add_product", "area", "moved_orientation", "orientation", "sign_of"]

TERMS = 160
"""Length of the work array: 36 products of three floats in `moved_orientation` have 144 terms."""

SPLITTER = 2.0**27 + 1.0
"""Splits a float64 into two halves of 26 bits."""

BOUND = (7.0 + 56.0 * 2.0**-53) * 2.0**-53
"""Error of the determinant in float64 ÷ the sum of the magnitudes of its terms."""


@leaf_kernel
def two_sum(a: float, b: float) -> tuple[float, float]:
    """Return a + b rounded, and the rounding error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@leaf_kernel
def two_product(a: float, b: float) -> tuple[float, float]:
    """Return a · b rounded, and the rounding error."""
    product = a * b
    scaled = SPLITTER * a
    a_high = scaled - (scaled - a)
    a_low = a - a_high
    scaled = SPLITTER * b
    b_high = scaled - (scaled - b)
    b_low = b - b_high
    rest = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
    return product, rest


@leaf_kernel
def add_term(terms: FloatArray, count: int, term: float) -> int:
    """Add a float to an expansion of `count` terms, and return the new number of terms."""
    kept = 0
    for index in range(count):
        term, rest = two_sum(term, terms[index])
        if rest != 0.0:
            terms[kept] = rest
            kept += 1
    if term != 0.0:
        terms[kept] = term
        kept += 1
    return kept


@leaf_kernel
def add_product(terms: FloatArray, count: int, a: float, b: float, c: float) -> int:
    """Add a · b · c to an expansion, and return the new number of terms."""
    product, rest = two_product(a, b)
    high, low = two_product(product, c)
    if low != 0.0:
        count = add_term(terms, count, low)
    count = add_term(terms, count, high)
    if rest != 0.0:
        high, low = two_product(rest, c)
        if low != 0.0:
            count = add_term(terms, count, low)
        count = add_term(terms, count, high)
    return count


@leaf_kernel
def sign_of(terms: FloatArray, count: int) -> float:
    """Return the largest term of an expansion, which has its sign, or 0."""
    return terms[count - 1] if count > 0 else 0.0


@leaf_kernel
def _add_determinant(
    terms: FloatArray,
    count: int,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    cx: float,
    cy: float,
    cz: float,
) -> int:
    count = add_product(terms, count, by, cz, ax)
    count = add_product(terms, count, bz, cy, -ax)
    count = add_product(terms, count, bz, cx, ay)
    count = add_product(terms, count, bx, cz, -ay)
    count = add_product(terms, count, bx, cy, az)
    return add_product(terms, count, by, cx, -az)


@leaf_kernel
def orientation(
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    cx: float,
    cy: float,
    cz: float,
    px: float,
    py: float,
    pz: float,
    terms: FloatArray,
) -> float:
    """Return a number with the exact sign of det(a − p, b − p, c − p).

    It is positive if p, as a centre does, sees a, b, c counter-clockwise from inside, and 0 for
    points in a plane. Coordinates are 0 or of magnitudes from 1e-80 to 1e80, which rules out
    overflow and underflow. The relative error is about 2⁻⁵⁰ where the determinant exceeds its
    rounding error. `terms` (TERMS,) is a work array.
    """
    ux, uy, uz = ax - px, ay - py, az - pz
    vx, vy, vz = bx - px, by - py, bz - pz
    wx, wy, wz = cx - px, cy - py, cz - pz
    x1, x2 = vy * wz, vz * wy
    y1, y2 = vz * wx, vx * wz
    z1, z2 = vx * wy, vy * wx
    determinant = ux * (x1 - x2) + uy * (y1 - y2) + uz * (z1 - z2)
    magnitude = (
        abs(ux) * (abs(x1) + abs(x2))
        + abs(uy) * (abs(y1) + abs(y2))
        + abs(uz) * (abs(z1) + abs(z2))
    )
    if abs(determinant) > BOUND * magnitude:
        return determinant
    count = _add_determinant(terms, 0, ax, ay, az, bx, by, bz, cx, cy, cz)
    count = _add_determinant(terms, count, -px, -py, -pz, bx, by, bz, cx, cy, cz)
    count = _add_determinant(terms, count, ax, ay, az, -px, -py, -pz, cx, cy, cz)
    count = _add_determinant(terms, count, ax, ay, az, bx, by, bz, -px, -py, -pz)
    return sign_of(terms, count)


@leaf_kernel
def moved_orientation(
    ex: float,
    ey: float,
    ez: float,
    sx: float,
    sy: float,
    sz: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    px: float,
    py: float,
    pz: float,
    terms: FloatArray,
) -> float:
    """Return a number with the exact sign of det(e − s, a − p, b − p), as for `orientation`.

    It is 0 if the direction from s to e is parallel to the plane through a, b and p.
    """
    count = _add_determinant(terms, 0, ex, ey, ez, ax, ay, az, bx, by, bz)
    count = _add_determinant(terms, count, ex, ey, ez, -px, -py, -pz, bx, by, bz)
    count = _add_determinant(terms, count, ex, ey, ez, ax, ay, az, -px, -py, -pz)
    count = _add_determinant(terms, count, -sx, -sy, -sz, ax, ay, az, bx, by, bz)
    count = _add_determinant(terms, count, -sx, -sy, -sz, -px, -py, -pz, bx, by, bz)
    count = _add_determinant(terms, count, -sx, -sy, -sz, ax, ay, az, -px, -py, -pz)
    return sign_of(terms, count)


@leaf_kernel
def area(
    ax: float, ay: float, bx: float, by: float, px: float, py: float, terms: FloatArray
) -> float:
    """Return a number with the exact sign of det(a − p, b − p) in a plane, as for `orientation`."""
    count = add_product(terms, 0, ax, by, 1.0)
    count = add_product(terms, count, ax, -py, 1.0)
    count = add_product(terms, count, px, -by, 1.0)
    count = add_product(terms, count, ay, -bx, 1.0)
    count = add_product(terms, count, ay, px, 1.0)
    count = add_product(terms, count, py, bx, 1.0)
    return sign_of(terms, count)
