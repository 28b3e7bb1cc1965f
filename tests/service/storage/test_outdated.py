"""`gamut store list` and `gamut store prune`: gamuts of earlier versions of the algorithm."""

import os
from pathlib import Path

import pytest

from gamutcore.version import ALGORITHM_VERSION
from service.__main__ import main
from service.storage.cloud import CloudBlobs
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs
from service.storage.published import PublishedGamut, blob_key

DAY = 86_400
OLD, UNUSED, CURRENT, UNKNOWN = (letter * 64 for letter in "abcd")


@pytest.fixture(params=["directory", "bucket"])
def location(request, tmp_path):
    """The location of a store with two outdated gamuts, a current one and one of no version."""
    where = str(tmp_path / "store")
    if request.param == "bucket":
        where = request.getfixturevalue("address")("s3")
    store = opened(where)
    for gamut_id, version, created in (
        (OLD, ALGORITHM_VERSION - 1, "2999-01-01T00:00:00Z"),
        (UNUSED, 1, "2020-01-01T00:00:00Z"),
        (CURRENT, ALGORITHM_VERSION, "2020-01-01T00:00:00Z"),
        (UNKNOWN, None, "2020-01-01T00:00:00Z"),
    ):
        algorithm = {"algorithm": {"version": version}} if version else {}
        content = store.scratch(".gamut")
        content.write_bytes(b"history")
        digest = "0" * 64
        record = PublishedGamut(gamut_id, digest, 7, created, {"provenance": algorithm})
        store.publish(record, content)
        store.keep_input(gamut_id, b"input")
        store.names.give(gamut_id, f"Press {gamut_id[0]}")
    store.close()  # writes the times of last use
    if request.param == "directory":
        for gamut_id in (OLD, UNUSED, CURRENT, UNKNOWN):
            when = 4_000_000_000 if gamut_id == OLD else DAY
            os.utime(store.blobs.path(blob_key(gamut_id, "record")), (when, when))
    return where


def opened(where):
    blobs = CloudBlobs(where) if "://" in where else LocalBlobs(Path(where))
    store = GamutStore(blobs)
    store.open()
    return store


def ids(where):
    store = opened(where)
    try:
        return list(store.ids())
    finally:
        store.close()


def listed(capsys):
    """The rows of the table by id, and the line below it."""
    *rows, last = capsys.readouterr().out.splitlines()
    return {row.split()[0]: row.split()[1:] for row in rows if row[:2] != "id"}, last


@pytest.mark.slow
def test_outdated_gamuts_are_listed_with_version_size_last_use_and_name(location, capsys):
    assert main(["store", "list", location, "--outdated"]) == 0
    rows, last = listed(capsys)
    assert set(rows) == {OLD, UNUSED, UNKNOWN}
    version, nbytes, used, *name = rows[UNUSED]
    assert (version, name) == ("1", ["Press", "b"])
    assert int(nbytes) > len("history") + len("input")
    assert used[:4] == ("2020" if "://" in location else "1970")
    assert last.startswith("3 gamuts, ")
    assert main(["store", "list", location]) == 0
    assert set(listed(capsys)[0]) == {OLD, UNUSED, CURRENT, UNKNOWN}


@pytest.mark.slow
def test_outdated_gamuts_are_removed_with_their_inputs_and_names_when_confirmed(location, capsys):
    assert main(["store", "prune", location]) == 0
    rows, last = listed(capsys)
    assert set(rows) == {OLD, UNUSED, UNKNOWN}
    assert "--yes" in last
    assert ids(location) == [OLD, UNUSED, CURRENT, UNKNOWN]
    assert main(["store", "prune", location, "--older-than", "30", "--yes"]) == 0
    assert set(listed(capsys)[0]) == {UNUSED, UNKNOWN}
    assert ids(location) == [OLD, CURRENT]
    assert main(["store", "prune", location, "--yes"]) == 0
    store = opened(location)
    left = [key for key in store.blobs.keys("") if not key.endswith("lock")]
    store.close()
    assert {key.rpartition("/")[2].partition(".")[0] for key in left} <= {CURRENT}


def test_a_directory_in_use_is_listed_and_not_pruned(tmp_path, capsys):
    store = GamutStore(LocalBlobs(tmp_path))
    store.open()
    try:
        assert main(["store", "list", str(tmp_path)]) == 0
        assert main(["store", "prune", str(tmp_path), "--yes"]) == 1
    finally:
        store.close()
    assert "in use by another process" in capsys.readouterr().err


def test_a_store_that_is_not_there_is_not_made(tmp_path, capsys):
    assert main(["store", "list", str(tmp_path / "none")]) == 2
    assert "none" in capsys.readouterr().err
    assert main(["store", "prune", "ftp://somewhere"]) == 2
    assert list(tmp_path.iterdir()) == []
