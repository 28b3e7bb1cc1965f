"""Vectors and symmetric matrices of three dimensions as tuples, which kernels hold in registers.

A symmetric matrix is the tuple (a00, a01, a02, a11, a12, a22).
"""

from __future__ import annotations

from typing import Any, SupportsIndex, TypeVar

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import inlined_kernel

__all__ = [
    "Symmetric",
    "Vector",
    "add_outer",
    "adjugate",
    "copy_row",
    "cross",
    "dot",
    "linear_combination",
    "minus",
    "plus",
    "product",
    "quadratic_form",
    "row",
    "scaled",
    "symmetric_row",
    "triple",
    "vector",
    "write_row",
    "write_symmetric_row",
]

Vector = tuple[float, float, float]
Symmetric = tuple[float, float, float, float, float, float]
Scalar = TypeVar("Scalar", bound="np.generic[Any]")


@inlined_kernel
def vector(array: FloatArray) -> Vector:
    """Return the first three numbers of an array."""
    return array[0], array[1], array[2]


@inlined_kernel
def row(array: FloatArray | IndexArray, index: SupportsIndex, column: int) -> Vector:
    """Return three numbers of a row, from a column on."""
    return array[index, column], array[index, column + 1], array[index, column + 2]


@inlined_kernel
def symmetric_row(array: FloatArray, index: int) -> Symmetric:
    """Return the first six numbers of a row as a symmetric matrix."""
    a00, a01, a02 = row(array, index, 0)
    a11, a12, a22 = row(array, index, 3)
    return a00, a01, a02, a11, a12, a22


@inlined_kernel
def write_row(array: FloatArray, index: int, column: int, a: Vector) -> None:
    """Write three numbers of a row, from a column on."""
    array[index, column], array[index, column + 1], array[index, column + 2] = a[0], a[1], a[2]


@inlined_kernel
def copy_row(target: NDArray[Scalar], to: int, source: NDArray[Scalar], index: int) -> None:
    """Copy a row of an array; numba takes 3 s to compile an assignment of arrays."""
    for column in range(source.shape[1]):
        target[to, column] = source[index, column]


@inlined_kernel
def write_symmetric_row(array: FloatArray, index: int, m: Symmetric) -> None:
    """Write the first six numbers of a row."""
    write_row(array, index, 0, (m[0], m[1], m[2]))
    write_row(array, index, 3, (m[3], m[4], m[5]))


@inlined_kernel
def dot(a: Vector, b: Vector) -> float:
    """Return the inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined_kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Return the cross product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined_kernel
def triple(a: Vector, b: Vector, c: Vector) -> float:
    """Return det(a, b, c)."""
    return dot(c, cross(a, b))


@inlined_kernel
def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined_kernel
def minus(a: Vector, b: Vector) -> Vector:
    """Return a − b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined_kernel
def scaled(factor: float, a: Vector) -> Vector:
    """Return a multiple of a vector."""
    return factor * a[0], factor * a[1], factor * a[2]


@inlined_kernel
def product(m: Symmetric, a: Vector) -> Vector:
    """Return the product of a matrix and a vector."""
    return dot((m[0], m[1], m[2]), a), dot((m[1], m[3], m[4]), a), dot((m[2], m[4], m[5]), a)


@inlined_kernel
def quadratic_form(m: Symmetric, a: Vector) -> float:
    """Return aᵀM a."""
    x, y, z = a
    squares = m[0] * x * x + m[3] * y * y + m[5] * z * z
    return squares + 2.0 * (m[1] * x * y + m[2] * x * z + m[4] * y * z)


@inlined_kernel
def linear_combination(m: Symmetric, factor: float, n: Symmetric) -> Symmetric:
    """Return M + factor · N."""
    a00, a01, a02 = m[0] + factor * n[0], m[1] + factor * n[1], m[2] + factor * n[2]
    a11, a12, a22 = m[3] + factor * n[3], m[4] + factor * n[4], m[5] + factor * n[5]
    return a00, a01, a02, a11, a12, a22


@inlined_kernel
def add_outer(m: Symmetric, weight: float, a: Vector) -> Symmetric:
    """Return M + weight · a aᵀ."""
    x, y, z = scaled(weight, a)
    return (
        m[0] + x * a[0],
        m[1] + x * a[1],
        m[2] + x * a[2],
        m[3] + y * a[1],
        m[4] + y * a[2],
        m[5] + z * a[2],
    )


@inlined_kernel
def adjugate(m: Symmetric, pull: float) -> tuple[Symmetric, float]:
    """Return the adjugate and the determinant of M + pull · I. The inverse is their quotient."""
    a00, a01, a02, a11, a12, a22 = m[0] + pull, m[1], m[2], m[3] + pull, m[4], m[5] + pull
    i00, i01, i02 = a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11
    i11, i12, i22 = a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01
    return (i00, i01, i02, i11, i12, i22), a00 * i00 + a01 * i01 + a02 * i02
