import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation.pictures.inflate import Inflated


@given(
    st.binary(max_size=300),
    st.integers(1, 50),
    st.lists(st.integers(0, 400), max_size=8),
    st.integers(1, 40),
)
def test_what_is_read_in_pieces_is_what_was_packed(content, times, sizes, cut):
    whole = content * times
    packed = zlib.compress(whole)
    stream = Inflated(memoryview(packed[i : i + cut]) for i in range(0, len(packed), cut))
    place = 0
    for size in sizes:
        assert stream.read(size) == whole[place : place + size]
        place += size
    assert stream.read(len(whole) + 1) == whole[place:]
    assert stream.read(10) == b""


def test_large_streams_are_fed_in_parts():
    content = np.random.default_rng(0).integers(0, 256, 2_000_000, dtype=np.uint8).tobytes()
    stream = Inflated([memoryview(zlib.compress(content, 1))])
    assert b"".join(stream.read(300_001) for _ in range(7)) == content


def test_what_ends_early_gives_what_is_there():
    content = bytes(range(256)) * 40
    packed = zlib.compress(content)
    found = Inflated([memoryview(packed[:-20])]).read(len(content))
    assert found
    assert content.startswith(found)


def test_what_follows_the_stream_is_not_read():
    assert Inflated([memoryview(zlib.compress(b"abc") + b"more")]).read(9) == b"abc"


def test_what_is_no_stream_is_refused():
    with pytest.raises(zlib.error):
        Inflated([memoryview(b"no deflate data")]).read(1)
