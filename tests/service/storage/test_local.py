import contextlib
import errno
import os
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from service.storage import local as module
from service.storage.blobs import StoreFullError
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs, StoreInUseError

KEY = "jobs/ab/abcd.job"


def left_behind(blobs):
    return list(blobs.scratch("").parent.iterdir())


def opened(directory, **limits):
    blobs = LocalBlobs(directory, **limits)
    blobs.open()
    return blobs


def test_a_directory_belongs_to_one_process(local):
    code = (
        "import sys; from pathlib import Path; from service.storage.local import LocalBlobs;"
        "LocalBlobs(Path(sys.argv[1])).open()"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code, local.directory], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 1
    assert "StoreInUseError" in ended.stderr
    with pytest.raises(StoreInUseError, match="GAMUT_STORE"):
        LocalBlobs(local.directory).open()


def test_work_in_progress_is_swept_and_what_is_not_ours_stays(local):
    local.scratch(".new").write_bytes(b"torn")
    stranger = local.scratch("")
    stranger.mkdir()
    local.close()
    local.open()
    assert left_behind(local) == [stranger]


@pytest.mark.parametrize(
    "key", ["", "a", "/a/b", "a/../b", "a//b", "a/b/", "a/.b", "A/b", "temporary/a", "a/b\n", "a/é"]
)
def test_no_key_leads_out_of_the_directory(local, key):
    for method in (local.read, local.delete, local.size, local.stream):
        with pytest.raises(ValueError, match="key"):
            method(key)
    with pytest.raises(ValueError, match="key"):
        local.create(key, b"")


def test_bytes_are_counted(local):
    version = local.create(KEY, b"12345")
    local.replace(KEY, b"123", version)
    local.create("jobs/ab/other.job", b"1234567")
    local._counting.join()
    assert local.used == 10
    local.move(KEY, "quarantine/abcd")
    local.delete("jobs/ab/other.job")
    assert local.used == 3
    local.close()
    local.open()
    local._counting.join()
    assert local.used == 3


def test_closing_ends_a_count_that_is_under_way(local, monkeypatch):
    for name in "abc":
        local.create(f"jobs/ab/{name}.job", b"12345")
    local.close()
    stat, counted = local.stat, []

    def stat_when_closed(key):
        counted.append(key)
        while local._opened.is_set():
            time.sleep(0.01)
        return stat(key)

    monkeypatch.setattr(local, "stat", stat_when_closed)
    local.open()
    local.close()
    assert len(counted) <= 1


def test_no_more_is_stored_than_the_limit(tmp_path):
    blobs = opened(tmp_path, limit=100)
    version = blobs.create(KEY, b"x" * 60)
    for content in (b"x" * 41, b"x" * 101):
        with pytest.raises(StoreFullError) as caught:
            blobs.create("jobs/ab/other.job", content)
        assert caught.value.errno == errno.ENOSPC
    assert blobs.create("jobs/ab/other.job", b"x" * 40) is not None
    # The state of what is there can be written although the store is full.
    assert blobs.replace(KEY, b"x" * 70, version) is not None
    blobs.close()
    again = opened(tmp_path, limit=100)
    with pytest.raises(StoreFullError):
        again.create("jobs/ab/third.job", b"x")
    assert left_behind(again) == []
    again.close()


def test_simultaneous_writers_do_not_exceed_the_limit_together(tmp_path):
    blobs, barrier = opened(tmp_path, limit=1000), threading.Barrier(8)

    def write(number):
        barrier.wait()
        try:
            return blobs.create(f"jobs/ab/{number}.job", b"x" * 300)
        except StoreFullError:
            return None

    with ThreadPoolExecutor(8) as threads:
        versions = list(threads.map(write, range(8)))
    assert sum(version is not None for version in versions) == 3
    assert blobs.used == 900
    blobs.close()


def test_room_is_made_as_long_as_there_is_something_to_go(tmp_path):
    blobs, asked = opened(tmp_path, limit=100), []
    blobs.create(KEY, b"x" * 100)

    def make_room(nbytes):
        asked.append(nbytes)
        return blobs.delete(KEY)

    blobs.make_room = make_room
    assert blobs.create("jobs/ab/other.job", b"x" * 30) is not None
    assert asked == [30]
    with pytest.raises(StoreFullError):
        blobs.create("jobs/ab/third.job", b"x" * 80)
    assert asked == [30, 10]
    blobs.close()


def test_a_part_of_the_disk_stays_free(tmp_path):
    blobs = opened(tmp_path, reserve=2**62)
    with pytest.raises(StoreFullError):
        blobs.create(KEY, bytes(100_000))
    # What has been admitted can be finished: its result is on the disk, its state is small.
    output = blobs.scratch(".gamut")
    output.write_bytes(bytes(100_000))
    assert blobs.create("published/ab/result", output) is not None
    version = blobs.create(KEY, b"running")
    assert blobs.replace(KEY, b"succeeded", version) is not None
    blobs.close()


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EIO])
@pytest.mark.parametrize("call", ["fsync", "link", "write", "mkdir"])
def test_a_failing_disk_leaves_nothing_and_is_recovered_from(local, monkeypatch, number, call):
    """At every step of a write in turn, and at every occurrence of it."""
    usual = getattr(os, call) if call != "write" else module.LocalBlobs._write
    for failing in range(4):
        calls = iter(range(10))

        def fails(*arguments, calls=calls, failing=failing, **named):
            if next(calls) == failing:
                raise OSError(number, "injected")
            return usual(*arguments, **named)

        with monkeypatch.context() as patch:
            if call == "write":
                patch.setattr(module.LocalBlobs, "_write", fails)
            else:
                patch.setattr(os, call, fails)
            version = None
            with contextlib.suppress(OSError):
                version = local.create(KEY, b"content")
        assert left_behind(local) == []
        assert list(local.keys("")) == ([KEY] if version else [])
        local._counting.join()
        assert local.used == (7 if version else 0)
        assert version is not None or local.create(KEY, b"content") is not None
        local.delete(KEY)
        local._durable.clear()


def test_a_failing_replacement_leaves_the_old_content(local, monkeypatch):
    version = local.create(KEY, b"old")

    def fails(*_):
        raise OSError(errno.ENOSPC, "injected")

    for call in ("fsync", "write"):
        with monkeypatch.context() as patch:
            if call == "write":
                patch.setattr("pathlib.Path.replace", fails)
            else:
                patch.setattr(os, call, fails)
            with pytest.raises(OSError, match="injected"):
                local.replace(KEY, b"new", version)
        assert local.read(KEY) == (b"old", version)
        assert left_behind(local) == []
    assert local.replace(KEY, b"new", version) is not None


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 6 MB, or a skip."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=6m", "tmpfs", folder]
    if os.geteuid() != 0 or subprocess.run(mount, check=False).returncode != 0:
        pytest.skip("mounting is not allowed here")
    yield folder
    subprocess.run(["umount", "--lazy", folder], check=True)


def test_a_full_disk_is_reported_served_from_and_recovered_from(
    small_disk, publish, identity, unfinished
):
    store = GamutStore(LocalBlobs(small_disk / "store"))
    store.open()
    stored = []

    def publish_further(times):
        for _ in range(times):
            number = len(stored)
            stored.append(publish(store, number, bytes([number]) * 600_000).id)

    try:
        with pytest.raises(OSError, match="No space left") as caught:
            publish_further(100)
        assert caught.value.errno == errno.ENOSPC
        assert 5 < len(stored) < 11
        with pytest.raises(StoreFullError):
            store.keep_input(identity("large"), bytes(6_000_000))
        # No debris, what is there is served, it can be deleted, and then there is room again.
        for path in unfinished(store):
            assert path.suffix == ".gamut"  # of the caller whose publication failed
            path.unlink()
        assert [len(store.content(gamut_id)[1]) for gamut_id in stored] == [600_000] * len(stored)
        assert store.delete(stored[0])
        publish_further(1)
    finally:
        store.close()


def test_a_service_on_a_full_disk_serves_what_is_there_and_recovers(
    start_server, small_disk, built, publish_built, sphere, assert_problem
):
    store = GamutStore(LocalBlobs(small_disk / "store"))
    store.open()
    publish_built(store, built[0])
    store.close()
    server = start_server(small_disk / "store", store_reserve_bytes=1_000_000)
    address = f"/v1/gamuts/{built[0].id}"
    ballast = small_disk / "ballast"
    with contextlib.suppress(OSError), ballast.open("wb", buffering=0) as file:
        while True:
            file.write(bytes(100_000))
    request = {"json": {"samples": sphere(seed=62)}, "headers": {"Prefer": "respond-async"}}
    assert_problem(server.client.post("/v1/gamuts", **request), 507, "storage-full")
    for part in ("", "/mesh", "/history"):
        assert server.client.get(f"{address}{part}").status_code == 200
    assert list((small_disk / "store" / "temporary").iterdir()) == []
    ballast.unlink()
    assert server.client.post("/v1/gamuts", **request).status_code == 202
    server.kill()
