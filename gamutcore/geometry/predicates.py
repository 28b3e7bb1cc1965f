"""Signs of determinants: the star test of all levels, and exact orientations.

A face (p0, p1, p2), relative to the centre, sees it from inside when det(p0, p1, p2) > 0. If all
faces of a closed mesh of genus 0 do, their radial projection is a triangulation of the sphere. The
mesh then cannot intersect itself, and every ray from the centre meets it exactly once.

An exact determinant is first computed in float64 with a bound of its error. If the bound leaves the
sign open, the determinant is summed up exactly as an expansion: a list of floats whose bits do not
overlap, in increasing order. The last float then has the sign of the sum. The expansion of rounded
differences of points comes first; it is enough but for points within some 2⁻¹⁰⁰ of a plane.

Source of the exact predicates: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and
Fast Robust Geometric Predicates", Discrete & Computational Geometry 18 (1997): two-sum,
two-product, Theorem 10 (grow-expansion) and the error bounds of ORIENT3D in section 4.3.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.geometry.triangle import face_corners
from gamutcore.geometry.vectors import Vector, dot, minus, scaled, triple
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = [
    "MINIMUM_DETERMINANT",
    "TERMS",
    "add_product",
    "area",
    "faces_not_seeing_centre",
    "moved_orientation",
    "orientation",
    "sees_centre",
    "sign_of",
]

MINIMUM_DETERMINANT = 2.0**-44
"""Smallest det(p0, p1, p2) ÷ (|p0| |p1| |p2|) that counts as positive.

The relative error of a determinant in float64 is a few times 2⁻⁵³ of the product of the lengths.
With this margin, the sign is the same in any order of evaluation."""


@leaf_kernel
def sees_centre(a: Vector, b: Vector, c: Vector) -> bool:
    """Whether the face (a, b, c), relative to the centre, sees it from inside beyond rounding.

    Corners are in counter-clockwise order. The answer for NaN is False.
    """
    determinant = triple(a, b, c)
    lengths = dot(c, c) * dot(a, a) * dot(b, b)
    return (
        determinant > 0.0
        and determinant * determinant > MINIMUM_DETERMINANT * MINIMUM_DETERMINANT * lengths
    )


@kernel
def faces_not_seeing_centre(position: FloatArray, faces: IndexArray) -> IndexArray:
    """Return the faces (m,) whose determinant about the centre is not positive beyond rounding.

    `position` (V, 3) is relative to the centre.
    """
    found = np.empty(len(faces), np.int32)
    count = 0
    for face in range(len(faces)):
        a, b, c = face_corners(position, faces, face)
        if not sees_centre(a, b, c):
            found[count] = face
            count += 1
    return found[:count].copy()


TERMS = 160
"""Length of the work array: 36 products of three floats in `moved_orientation` have 144 terms."""

SPLITTER = 2.0**27 + 1.0
"""Splits a float64 into two halves of 26 bits."""

BOUND = (7.0 + 56.0 * 2.0**-53) * 2.0**-53
"""Error of the determinant in float64 ÷ the sum of the magnitudes of its terms."""

CORRECTED_BOUND = 2.0**-100
"""The same when differences of corners alone are rounded, and their errors count to first order:
26 · 2⁻¹⁰⁶ (bound C of ORIENT3D), with a margin for relative errors of the sum."""

ZERO = (0.0, 0.0, 0.0)


@leaf_kernel
def _two_sum(a: float, b: float) -> tuple[float, float]:
    """Return a + b rounded, and the rounding error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@leaf_kernel
def _two_product(a: float, b: float) -> tuple[float, float]:
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
def _add_term(terms: FloatArray, count: int, term: float) -> int:
    """Add a float to an expansion of `count` terms, and return the new number of terms."""
    kept = 0
    for index in range(count):
        term, rest = _two_sum(term, terms[index])
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
    product, rest = _two_product(a, b)
    high, low = _two_product(product, c)
    if low != 0.0:
        count = _add_term(terms, count, low)
    count = _add_term(terms, count, high)
    if rest != 0.0:
        high, low = _two_product(rest, c)
        if low != 0.0:
            count = _add_term(terms, count, low)
        count = _add_term(terms, count, high)
    return count


@leaf_kernel
def sign_of(terms: FloatArray, count: int) -> float:
    """Return the largest term of an expansion, which has its sign, or 0."""
    return terms[count - 1] if count > 0 else 0.0


@leaf_kernel
def _add_determinant(terms: FloatArray, count: int, a: Vector, b: Vector, c: Vector) -> int:
    """Add det(a, b, c) to an expansion, and return the new number of terms."""
    count = add_product(terms, count, b[1], c[2], a[0])
    count = add_product(terms, count, b[2], c[1], -a[0])
    count = add_product(terms, count, b[2], c[0], a[1])
    count = add_product(terms, count, b[0], c[2], -a[1])
    count = add_product(terms, count, b[0], c[1], a[2])
    return add_product(terms, count, b[1], c[0], -a[2])


@inlined_kernel
def _difference_error(a: Vector, b: Vector) -> Vector:
    """Return what rounding loses of a − b."""
    return _two_sum(a[0], -b[0])[1], _two_sum(a[1], -b[1])[1], _two_sum(a[2], -b[2])[1]


@leaf_kernel
def orientation(a: Vector, b: Vector, c: Vector, p: Vector, terms: FloatArray) -> float:
    """Return a number with the exact sign of det(a − p, b − p, c − p).

    It is positive if p, as a centre does, sees a, b, c counter-clockwise from inside, and 0 for
    points in a plane. Coordinates are 0 or of magnitudes from 1e-80 to 1e80, which rules out
    overflow and underflow. The relative error is about 2⁻⁵⁰ where the determinant exceeds its
    rounding error. `terms` (TERMS,) is a work array.
    """
    ux, uy, uz = minus(a, p)
    vx, vy, vz = minus(b, p)
    wx, wy, wz = minus(c, p)
    x1, x2 = vy * wz, vz * wy
    y1, y2 = vz * wx, vx * wz
    z1, z2 = vx * wy, vy * wx
    determinant = ux * (x1 - x2) + uy * (y1 - y2) + uz * (z1 - z2)
    magnitude = (
        abs(ux) * (abs(x1) + abs(x2))
        + abs(uy) * (abs(y1) + abs(y2))
        + abs(uz) * (abs(z1) + abs(z2))
    )
    if abs(determinant) > BOUND * magnitude or magnitude == 0.0:
        return determinant
    u, v, w = (ux, uy, uz), (vx, vy, vz), (wx, wy, wz)
    determinant = sign_of(terms, _add_determinant(terms, 0, u, v, w))
    du, dv, dw = _difference_error(a, p), _difference_error(b, p), _difference_error(c, p)
    if du == ZERO and dv == ZERO and dw == ZERO:  # as for points on a grid
        return determinant
    determinant += triple(du, v, w) + triple(u, dv, w) + triple(u, v, dw)
    if abs(determinant) > CORRECTED_BOUND * magnitude:
        return determinant
    opposite = scaled(-1.0, p)
    count = _add_determinant(terms, 0, a, b, c)
    count = _add_determinant(terms, count, opposite, b, c)
    count = _add_determinant(terms, count, a, opposite, c)
    count = _add_determinant(terms, count, a, b, opposite)
    return sign_of(terms, count)


@leaf_kernel
def moved_orientation(
    e: Vector, s: Vector, a: Vector, b: Vector, p: Vector, terms: FloatArray
) -> float:
    """Return a number with the exact sign of det(e − s, a − p, b − p), as for `orientation`.

    It is 0 if the direction from s to e is parallel to the plane through a, b and p.
    """
    opposite, count = scaled(-1.0, p), 0
    for end in (e, scaled(-1.0, s)):
        count = _add_determinant(terms, count, end, a, b)
        count = _add_determinant(terms, count, end, opposite, b)
        count = _add_determinant(terms, count, end, a, opposite)
    return sign_of(terms, count)


@leaf_kernel
def area(a: Vector, b: Vector, p: Vector, axis: int, terms: FloatArray) -> float:
    """Return a number with the exact sign of det(a − p, b − p) in the plane across an axis."""
    y, z = (axis + 1) % 3, (axis + 2) % 3
    count = add_product(terms, 0, a[y], b[z], 1.0)
    count = add_product(terms, count, a[y], -p[z], 1.0)
    count = add_product(terms, count, p[y], -b[z], 1.0)
    count = add_product(terms, count, a[z], -b[y], 1.0)
    count = add_product(terms, count, a[z], p[y], 1.0)
    count = add_product(terms, count, p[z], b[y], 1.0)
    return sign_of(terms, count)
