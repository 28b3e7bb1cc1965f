import contextlib
import os
import tempfile
from itertools import count
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.storage import eviction, uses
from service.storage.blobs import StoreFullError
from service.storage.gamut_store import GamutNotStoredError, GamutStore
from service.storage.local import LocalBlobs
from service.storage.published import blob_key


@pytest.fixture
def limited(tmp_path):
    """A store with a limit that is no multiple of anything: about ten gamuts of 10 kB."""
    opened = GamutStore(LocalBlobs(tmp_path / "store", limit=105_000))
    opened.open()
    yield opened
    opened.close()


def aged(store, gamut_id, seconds):
    path = store.blobs.path(blob_key(gamut_id, "record"))
    os.utime(path, (1_000_000_000 - seconds,) * 2)


def stored(store):
    return set(store.ids())


def test_the_least_recently_used_gamuts_go_first(limited, publish):
    evicted = []
    limited.on_evicted = evicted.append
    ids = [publish(limited, number, bytes(9_000)).id for number in range(9)]
    for place, gamut_id in enumerate(ids):
        aged(limited, gamut_id, 100 - place)
        limited.uses.discard(gamut_id)
    limited.record(ids[0])  # the oldest, but used
    limited.uses.mark(ids[1])
    new = publish(limited, 100, bytes(40_000)).id
    assert evicted == ids[2:5]
    assert limited.evictions == 3
    assert stored(limited) == {*ids[:2], *ids[5:], new}
    assert limited.blobs.used <= 105_000
    with pytest.raises(GamutNotStoredError):
        limited.record(ids[2])


def test_inputs_of_finished_gamuts_go_before_gamuts(limited, publish, identity):
    first, second = (publish(limited, number, bytes(20_000)).id for number in range(2))
    limited.keep_input(first, bytes(20_000))
    limited.keep_input(second, bytes(20_000))
    limited.keep_input(identity(3), bytes(5_000))  # of a job that is not done
    publish(limited, 3, bytes(20_000))
    assert limited.evictions == 0
    assert not limited.input_kept(first)
    assert limited.input_kept(second)
    assert limited.input_kept(identity(3))


def test_what_is_in_quarantine_goes_before_gamuts(limited, publish):
    damaged, sound = (publish(limited, number, bytes(40_000)) for number in range(2))
    limited.set_aside(damaged, "for the test")
    publish(limited, 3, bytes(40_000))
    assert limited.evictions == 0
    assert sound.id in stored(limited)
    assert not any(".gamut." in key for key in limited.blobs.keys("quarantine/"))


def test_inputs_of_unfinished_jobs_never_go(limited, publish, identity):
    for number in range(5):
        limited.keep_input(identity(number), bytes(20_000))
    with pytest.raises(StoreFullError):
        publish(limited, 7, bytes(20_000))
    with pytest.raises(StoreFullError):
        limited.keep_input(identity(8), bytes(20_000))
    assert all(limited.input_kept(identity(number)) for number in range(5))
    assert stored(limited) == set()


@pytest.mark.parametrize("suffix", ["record", "gamut"])
def test_what_is_damaged_is_no_obstacle(limited, publish, suffix):
    """Not even if there is no room for the reason's file."""
    damaged = publish(limited, 1, bytes(104_600)).id
    (path,) = limited.blobs.directory.rglob(f"{damaged}*.{suffix}")
    path.write_bytes(path.read_bytes()[:-1])
    other = publish(limited, 2, bytes(100_000)).id
    assert stored(limited) == {other}


def test_what_cannot_fit_evicts_nothing(limited, publish):
    record = publish(limited, 1, bytes(50_000))
    with pytest.raises(StoreFullError):
        publish(limited, 2, bytes(200_000))
    assert stored(limited) == {record.id}


def test_what_is_being_published_stays(limited, publish):
    """Another's publication, between its record and its answer, must not be evicted."""
    first = publish(limited, 1, bytes(60_000)).id
    with limited._mark_publishing(first), pytest.raises(StoreFullError):
        publish(limited, 2, bytes(60_000))
    assert stored(limited) == {first}


def test_without_a_limit_a_full_disk_costs_nothing(store, publish, identity, monkeypatch):
    first = publish(store, 1).id
    store.keep_input(first, bytes(1000))
    store.keep_input(identity(2), bytes(1000))
    store.set_aside(publish(store, 4), "for the test")
    store.blobs._counting.join()
    before = set(store.blobs.keys(""))
    capacity = store.blobs.used + 500
    monkeypatch.setattr(
        store.blobs, "_missing", lambda nbytes, **_: store.blobs.used + nbytes - capacity
    )
    with pytest.raises(StoreFullError):
        publish(store, 3, bytes(5000))
    assert set(store.blobs.keys("")) == before


def test_a_gamut_that_is_read_after_every_post_stays(tmp_path, publish, identity):
    """As with `GAMUT_STORE_BYTES=1500000` and a client that posts and reads in turn."""
    store = GamutStore(LocalBlobs(tmp_path / "store", limit=1_500_000))
    store.open()
    for number in range(50):
        store.keep_input(identity(number), bytes(9_000))
        publish(store, number, bytes(110_000))
        assert store.record(identity(0))
        # The input of the newest gamut is the only one that there can be when space is short.
        assert sum(1 for _ in store.blobs.keys("inputs/")) <= 1 or not store.evictions
    assert store.evictions > 30
    store.close()


_STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("publish"), st.integers(0, 30), st.integers(1, 5)),
        st.tuples(st.just("job"), st.integers(0, 30), st.integers(1, 3)),
        st.tuples(st.sampled_from(["use", "delete", "flush", "rescan"]), st.integers(0, 30)),
    ),
    max_size=50,
)


@given(_STEPS, st.sampled_from([2, 5, 1000]))
def test_the_order_is_that_of_the_last_use_and_inputs_go_first(publish, identity, steps, most):
    """Whatever was published, used and deleted before, and however many are kept in memory."""
    clock = count(1_000_000_000)
    with (
        tempfile.TemporaryDirectory() as folder,
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setattr(eviction, "_MOST", most)
        patch.setattr(eviction, "_SCANS", 1000)  # few gamuts in memory need many scans
        patch.setattr(uses.time, "time", lambda: float(next(clock)))
        store = GamutStore(LocalBlobs(Path(folder), limit=110_000))
        store.open()
        used, inputs = {}, set()
        evicted = []
        store.on_evicted = evicted.append
        for kind, number, *size in steps:
            gamut_id = identity(number)
            evicted.clear()
            published = False
            if kind == "publish" and gamut_id not in used:
                # Inputs of unfinished jobs may leave no room.
                with contextlib.suppress(StoreFullError):
                    publish(store, number, bytes(8_000 * size[0]))
                    published = True
            elif kind == "job" and gamut_id not in used and gamut_id not in inputs:
                with contextlib.suppress(StoreFullError):
                    store.keep_input(gamut_id, bytes(8_000 * size[0]))
                    inputs.add(gamut_id)
            elif kind == "use" and gamut_id in used:
                store.record(gamut_id)
            elif kind == "delete":
                store.delete(gamut_id)
                inputs -= {gamut_id} & used.keys()
                used.pop(gamut_id, None)
            elif kind == "flush":
                store.uses.flush()
            elif kind == "rescan":
                store._eviction._outdated = True
            oldest_first = sorted(used, key=used.get)
            with_input = [each for each in oldest_first if each in inputs]
            dropped = [each for each in with_input if not store.input_kept(each)]
            assert evicted == oldest_first[: len(evicted)]
            assert dropped == with_input[: len(dropped)]
            assert not evicted or dropped == with_input
            inputs -= set(dropped)
            for each in evicted:
                del used[each]
            if published or (kind == "use" and gamut_id in used):
                used[gamut_id] = store.uses.last(gamut_id)
            assert stored(store) == set(used)
            assert store.blobs.used <= 110_000
        store.close()
