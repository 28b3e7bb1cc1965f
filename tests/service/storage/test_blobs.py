"""What every storage promises, asked of a directory and of every kind of bucket."""

import errno
import itertools
import secrets
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.storage.blobs import (
    UNVERSIONED,
    BlobDamagedError,
    BlobNotFoundError,
    StoreFullError,
    seal,
    unseal,
)

KEY = "jobs/ab/abcd.job"


def scratch_file(blobs, content):
    path = blobs.scratch(".test")
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("size", [0, 1, 10_000_000])
@pytest.mark.parametrize("form", ["bytes", "pieces", "file"])
@pytest.mark.slow
def test_what_is_created_is_read_back(blobs, size, form):
    content = bytes(range(256)) * (size // 256) + b"x" * (size % 256)
    pieces = [content[: size // 3], content[size // 3 :]]
    given_as = {"bytes": content, "pieces": pieces, "file": scratch_file(blobs, content)}[form]
    version = blobs.create(KEY, given_as)
    blob = blobs.read(KEY)
    assert blob.data == content
    assert version == blob.version or (form != "bytes" and version == UNVERSIONED)
    assert blobs.size(KEY) == size
    with blobs.stream(KEY) as file:
        assert file.read() == content
        file.seek(size // 2)
        assert file.read() == content[size // 2 :]
    assert form != "file" or not given_as.exists()


def test_what_is_not_there_is_not_found(blobs):
    for read in (blobs.read, blobs.stream, blobs.size):
        with pytest.raises(BlobNotFoundError):
            read(KEY)
    assert not blobs.move(KEY, "quarantine/abcd")
    assert blobs.replace(KEY, b"x", blobs.create("jobs/ab/other.job", b"x")) is None
    assert list(blobs.keys("jobs/")) == ["jobs/ab/other.job"]


def test_what_is_there_is_not_created_again(blobs):
    version = blobs.create(KEY, b"first")
    assert blobs.create(KEY, b"second") is None
    path = scratch_file(blobs, b"third")
    assert blobs.create(KEY, path) is None
    assert not path.exists()
    assert blobs.read(KEY) == (b"first", version)


def race(stores, write, writers=16):
    """Write at the same moment; return the data and the version of the only success."""
    barrier = threading.Barrier(writers)

    def attempt(number):
        data = secrets.token_bytes(8)  # equal data could have equal versions
        barrier.wait()
        return data, write(stores[number % len(stores)].blobs, data)

    with ThreadPoolExecutor(writers) as threads:
        (winner,) = [each for each in threads.map(attempt, range(writers)) if each[1] is not None]
    return winner


@pytest.mark.slow
def test_of_simultaneous_writers_exactly_one_succeeds_and_others_see_it_at_once(replicas):
    data, version = race(replicas, lambda blobs, data: blobs.create(KEY, data))
    for _ in range(3):
        for store in replicas:
            assert store.blobs.read(KEY) == (data, version)
            assert list(store.blobs.keys("jobs/")) == [KEY]
        data, version = race(
            replicas, lambda blobs, data, old=version: blobs.replace(KEY, data, old)
        )


def test_an_outdated_version_replaces_nothing(blobs):
    old = blobs.create(KEY, b"first")
    new = blobs.replace(KEY, b"second", old)
    assert new not in {None, old}
    assert blobs.replace(KEY, b"third", old) is None
    assert blobs.read(KEY) == (b"second", new)
    blobs.delete(KEY)
    assert blobs.replace(KEY, b"fourth", new) is None
    with pytest.raises(BlobNotFoundError):
        blobs.read(KEY)


def test_a_deleted_blob_is_gone_and_its_name_free(blobs):
    blobs.create(KEY, b"first")
    with blobs.stream(KEY) as file:
        assert blobs.delete(KEY)
        assert file.read() == b"first"
    with pytest.raises(BlobNotFoundError):
        blobs.read(KEY)
    assert list(blobs.keys("")) == []
    assert blobs.create(KEY, b"second") is not None


def test_a_moved_blob_has_another_key(blobs):
    blobs.create(KEY, b"first")
    assert blobs.move(KEY, "quarantine/abcd.job.1")
    assert list(blobs.keys("")) == ["quarantine/abcd.job.1"]
    assert blobs.read("quarantine/abcd.job.1").data == b"first"


def test_keys_are_listed_in_their_order_from_any_of_them(blobs):
    names = [
        f"{folder}/{inner}/{name}"
        for folder, inner, name in itertools.product(
            ("inputs", "jobs", "published"), ("0a", "a0"), ("0.a", "0.record", "1", "10.x")
        )
    ]
    for name in reversed(names):
        blobs.create(name, b"x")
    assert list(blobs.keys("")) == sorted(names)
    for prefix in ("jobs/", "jobs/a0/"):
        wanted = sorted(name for name in names if name.startswith(prefix))
        assert list(blobs.keys(prefix)) == wanted
        for place, after in enumerate(wanted):
            assert list(blobs.keys(prefix, after)) == wanted[place + 1 :]
        assert list(blobs.keys(prefix, "jobs/a0/0.b")) == [
            name for name in wanted if name > "jobs/a0/0.b"
        ]
    assert list(blobs.keys("nothing/")) == []


@given(st.binary(max_size=300))
def test_what_was_sealed_is_returned(payload):
    assert unseal(seal(payload)) == payload


@given(st.binary(max_size=100), st.data())
def test_no_flipped_bit_goes_unnoticed(payload, data):
    whole = bytearray(seal(payload))
    position = data.draw(st.integers(0, len(whole) - 1))
    whole[position] ^= 1 << data.draw(st.integers(0, 7))
    with pytest.raises(BlobDamagedError):
        unseal(bytes(whole))


@given(st.binary(max_size=100), st.data())
def test_no_other_length_goes_unnoticed(payload, data):
    whole = seal(payload)
    with pytest.raises(BlobDamagedError):
        unseal(whole[: data.draw(st.integers(0, len(whole) - 1))])
    with pytest.raises(BlobDamagedError):
        unseal(whole + data.draw(st.binary(min_size=1, max_size=5)))


def test_a_full_store_is_handled_like_a_full_disk():
    assert StoreFullError().errno == errno.ENOSPC
