"""Operations on bits: the same result compiled and as plain Python."""

import pytest

from gamutcore.kernels import kernel
from gamutcore.kernels.bits import bit_length


@kernel
def compiled(number):
    return bit_length(number)


@pytest.mark.parametrize("number", [0, 1, 2, 3, 4, 255, 256, 2**31 - 1, 2**31, 2**32, 2**63 - 1])
def test_bit_length(number):
    assert compiled(number) == bit_length(number) == len(f"{number:b}".lstrip("0"))
