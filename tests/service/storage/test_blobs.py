import errno

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.storage.blobs import BlobDamagedError, StoreFullError, sealed, unsealed


@given(st.binary(max_size=300))
def test_what_was_sealed_is_returned(payload):
    assert unsealed(sealed(payload)) == payload


@given(st.binary(max_size=100), st.data())
def test_no_flipped_bit_goes_unnoticed(payload, data):
    whole = bytearray(sealed(payload))
    position = data.draw(st.integers(0, len(whole) - 1))
    whole[position] ^= 1 << data.draw(st.integers(0, 7))
    with pytest.raises(BlobDamagedError):
        unsealed(bytes(whole))


@given(st.binary(max_size=100), st.data())
def test_no_other_length_goes_unnoticed(payload, data):
    whole = sealed(payload)
    with pytest.raises(BlobDamagedError):
        unsealed(whole[: data.draw(st.integers(0, len(whole) - 1))])
    with pytest.raises(BlobDamagedError):
        unsealed(whole + data.draw(st.binary(min_size=1, max_size=5)))


def test_a_full_store_is_handled_like_a_full_disk():
    assert StoreFullError().errno == errno.ENOSPC
