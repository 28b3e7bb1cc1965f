"""Operations on bits that numba does not provide."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from numba.core.extending import overload
from numba.cpython.unsafe.numbers import leading_zeros

__all__ = ["bit_length"]

_leading_zeros = cast("Callable[[int], int]", leading_zeros)


def bit_length(number: int) -> int:
    """Return the number of bits of a number from 0 to 2⁶³ − 1; 0 for 0.

    Kernels compile it to one machine instruction.
    """
    return int(number).bit_length()


@overload(bit_length)
def _compiled_bit_length(number: int) -> Callable[[int], int]:  # noqa: ARG001
    def length(number: int) -> int:
        return 64 - _leading_zeros(int(number))

    return length
