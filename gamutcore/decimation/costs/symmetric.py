"""Inverses of symmetric 3 × 3 matrices. All costs propose the minimum of a quadratic form."""

from __future__ import annotations

from gamutcore.kernels import leaf_kernel

__all__ = ["adjugate"]


@leaf_kernel
def adjugate(
    a00: float, a01: float, a02: float, a11: float, a12: float, a22: float
) -> tuple[float, float, float, float, float, float, float]:
    """Adjugate and determinant of a symmetric matrix. The inverse is their quotient.

    Parameters
    ----------
    a00, a01, a02, a11, a12, a22 : float
        The matrix on and above its diagonal.

    Returns
    -------
    i00, i01, i02, i11, i12, i22, determinant : float
    """
    i00, i01, i02 = a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11
    i11, i12, i22 = a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01
    return i00, i01, i02, i11, i12, i22, a00 * i00 + a01 * i01 + a02 * i02
