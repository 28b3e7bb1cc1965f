import hashlib

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from service.storage.blobs import BlobNotFoundError
from service.storage.records import input_key

ANY = settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])


@ANY
@given(st.binary(max_size=3000), st.dictionaries(st.text(), st.integers() | st.text()))
def test_data_and_options_are_read_back(store, identity, data, options):
    gamut_id = identity("any")
    store.drop_input(gamut_id)
    store.keep_input(gamut_id, data, options)
    path = store.input_path(gamut_id)
    assert path.read_bytes() == data
    assert store.input_options(gamut_id) == options
    path.unlink()


def test_an_input_stays_until_it_is_dropped(store, identity, unfinished):
    assert not store.input_kept(identity(1))
    store.keep_input(identity(1), b"data")
    store.keep_input(identity(1), b"data")
    assert store.input_kept(identity(1))
    assert unfinished(store) == []
    assert store.drop_input(identity(1))
    assert not store.drop_input(identity(1))
    for read in (store.input_path, store.input_options):
        with pytest.raises(BlobNotFoundError):
            read(identity(1))
    assert unfinished(store) == []


@ANY
@given(st.data())
@pytest.mark.slow
def test_no_damage_goes_unnoticed_and_keeping_mends_it(store, identity, unfinished, data):
    gamut_id = identity("damaged")
    store.drop_input(gamut_id)
    store.keep_input(gamut_id, b"the data of an input", {"gamma": 0.2})
    path = store.blobs.path(input_key(gamut_id))
    content = bytearray(path.read_bytes())
    position = data.draw(st.integers(0, len(content) - 1))
    if data.draw(st.booleans()):
        content[position] ^= 1 << data.draw(st.integers(0, 7))
    else:
        del content[position:]
    path.write_bytes(content)
    before = store.corruptions
    if data.draw(st.booleans()):
        with pytest.raises(BlobNotFoundError):
            store.input_path(gamut_id)
        assert not store.input_kept(gamut_id)
    store.keep_input(gamut_id, b"the data of an input", {"gamma": 0.2})
    assert store.corruptions == before + 1
    path = store.input_path(gamut_id)
    assert path.read_bytes() == b"the data of an input"
    path.unlink()
    assert unfinished(store) == []


@pytest.mark.parametrize("data", [b"the data of an input", b""])
def test_inputs_of_earlier_versions_are_read(store, identity, data):
    # SHA-256 of everything after the first line, a line with the options, the data
    rest = b'{"gamma":0.2}\n' + data
    content = hashlib.sha256(rest).hexdigest().encode() + b"\n" + rest
    store.blobs.create(input_key(identity("early")), content)
    path = store.input_path(identity("early"))
    assert path.read_bytes() == data
    assert store.input_options(identity("early")) == {"gamma": 0.2}
    path.unlink()
