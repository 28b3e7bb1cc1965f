import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.storage.records import Record, history_key, id_of, input_key, record_key

RECORD = Record("a" * 64, "b" * 64, 7, "now", {"volume": 1.5}, "c" * 16)


def test_a_record_is_read_back():
    assert Record.from_bytes(RECORD.to_bytes()) == RECORD


@given(st.integers(0, 10**6), st.integers(0, 7))
def test_no_flipped_bit_in_a_record_goes_unnoticed(position, bit):
    data = RECORD.to_bytes()
    position %= len(data)
    flipped = data[:position] + bytes([data[position] ^ 1 << bit]) + data[position + 1 :]
    with pytest.raises((ValueError, TypeError)):
        Record.from_bytes(flipped)


def test_every_key_tells_its_gamut_and_no_two_are_the_same():
    keys = [record_key("a" * 64), input_key("a" * 64), history_key("a" * 64, ""), RECORD.key]
    assert {id_of(key) for key in keys} == {"a" * 64}
    assert len(set(keys)) == 4
