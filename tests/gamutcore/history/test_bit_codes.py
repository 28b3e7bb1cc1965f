"""Codes of numbers: examples worked out by hand, and round trips."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.history.bit_codes import (
    LONGEST_CODE,
    BitWriter,
    Contexts,
    bit_reader,
    doublings_beyond,
    read_adaptive,
    read_below,
    read_bits,
    read_differences,
    stream_bytes,
    write_adaptive,
    write_below,
    write_bits,
    write_differences,
)


def writer(size=4096):
    return BitWriter(np.zeros(size, np.uint8), np.zeros(1, np.int64))


def contexts(count=2, total=0):
    return Contexts(np.full(count, total, np.int64), np.ones(count, np.int64))


def bits_of(written_to):
    length = int(written_to.position[0])
    return "".join(map(str, np.unpackbits(written_to.data)[:length]))


def reader(bits):
    return bit_reader(np.packbits(np.array([int(bit) for bit in bits], np.uint8)))


class TestPlainBits:
    @given(st.lists(st.tuples(st.integers(0, 2**32 - 1), st.integers(0, 32)), max_size=40))
    def test_what_is_written_is_read(self, numbers):
        out = writer()
        for value, count in numbers:
            write_bits(out, value % (1 << count), count)
        source = bit_reader(stream_bytes(out))
        assert [read_bits(source, count) for _, count in numbers] == [
            value % (1 << count) for value, count in numbers
        ]

    def test_the_first_bit_is_the_highest_of_the_first_byte(self):
        out = writer()
        write_bits(out, 0b1011, 4)
        write_bits(out, 1, 6)
        assert stream_bytes(out).tolist() == [0b10110000, 0b01000000]

    @pytest.mark.parametrize("size", range(10))
    def test_beyond_the_end(self, size):
        source = bit_reader(np.full(size, 255, np.uint8))
        for _ in range(8 * size):
            assert read_bits(source, 1) == 1
        assert source.position[0] == source.length
        for count in (0, 1, 32, 0):
            assert read_bits(source, count) == 0
        assert source.position[0] > source.length
        assert read_below(source, 2**31) == 0
        read_adaptive(source, contexts(), 0)
        assert source.position[0] > source.length


class TestTruncatedBinary:
    @pytest.mark.parametrize(
        ("limit", "codes"),
        [
            (1, [""]),
            (2, ["0", "1"]),
            (3, ["0", "10", "11"]),
            (5, ["00", "01", "10", "110", "111"]),
            (6, ["00", "01", "100", "101", "110", "111"]),
            (8, ["000", "001", "010", "011", "100", "101", "110", "111"]),
        ],
    )
    def test_codes(self, limit, codes):
        for value, code in enumerate(codes):
            out = writer()
            write_below(out, value, limit)
            assert bits_of(out) == code
            assert read_below(reader(code), limit) == value

    @given(st.integers(1, 2**31), st.floats(0, 1, exclude_max=True))
    def test_any_limit(self, limit, part):
        value = int(part * limit)
        out = writer(8)
        write_below(out, value, limit)
        assert read_below(bit_reader(stream_bytes(out)), limit) == value


@given(st.integers(0, 2**40), st.integers(1, 2**25))
def test_doublings_beyond_a_number(number, count):
    doublings = doublings_beyond(number, count)
    assert number < count << doublings
    assert doublings == 0 or number >= count << (doublings - 1)


class TestAdaptiveCode:
    @pytest.mark.parametrize(
        ("total", "value", "code"),
        [
            (0, 0, "1"),  # a mean of 0: unary
            (1, 3, "0001"),
            (2, 3, "011"),  # a mean of 2: one bit after the unary part
            (5, 0, "1000"),  # 2³ is the first power that is not below 5
            (8, 21, "001101"),
            (9, 21, "010101"),
        ],
    )
    def test_codes(self, total, value, code):
        out = writer()
        write_adaptive(out, contexts(total=total), 1, value)
        assert bits_of(out) == code
        assert read_adaptive(reader(code), contexts(total=total), 1) == value

    def test_large_numbers_are_plain(self):
        out = writer()
        write_adaptive(out, contexts(), 0, 24)
        assert bits_of(out) == "0" * 24 + f"{24:032b}"
        assert out.position[0] == LONGEST_CODE

    def test_a_context_forgets_half_after_64_numbers(self):
        seen = contexts()
        out = writer()
        for number in range(62):
            write_adaptive(out, seen, 0, 5)
            assert (seen.totals[0], seen.counts[0]) == (3 * (number + 1), number + 2)
        write_adaptive(out, seen, 0, 6)
        assert (seen.totals[0], seen.counts[0]) == ((3 * 63) // 2, 32)
        assert (seen.totals[1], seen.counts[1]) == (0, 1)

    @given(
        st.lists(
            st.tuples(
                st.integers(0, 4), st.integers(0, 32).flatmap(lambda b: st.integers(0, 2**b - 1))
            ),
            max_size=150,
        )
    )
    def test_what_is_written_is_read(self, numbers):
        out, seen = writer(), contexts(5, 100)
        for context, value in numbers:
            before = int(out.position[0])
            write_adaptive(out, seen, context, value)
            assert out.position[0] - before <= LONGEST_CODE
        source, again = bit_reader(stream_bytes(out)), contexts(5, 100)
        for context, value in numbers:
            assert read_adaptive(source, again, context) == value
        np.testing.assert_array_equal(again.totals, seen.totals)

    @given(*[st.integers(-(2**31), 2**31 - 1)] * 3)
    def test_numbers_of_either_sign(self, one, two, three):
        out = writer()
        write_differences(out, contexts(), 0, 1, one, two, three)
        found = read_differences(bit_reader(stream_bytes(out)), contexts(), 0, 1)
        assert found == (one, two, three)

    def test_the_order_of_signed_numbers(self):
        out = writer()
        write_differences(out, Contexts(np.zeros(2, np.int64), np.full(2, 50)), 0, 1, -1, 1, -2)
        assert bits_of(out) == "010010001"  # 1, 2 and 3 in unary
