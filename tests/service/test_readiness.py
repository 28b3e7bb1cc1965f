"""Readiness: what is wrong is named, asking costs nothing, and a disk that hangs occupies none."""

import asyncio
import errno
import logging
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from service import readiness
from service.building.engine import EngineFacts
from service.container import ServiceContainer
from service.readiness import (
    Finding,
    Probe,
    Readiness,
    Report,
    disk_probe,
    service_readiness,
    store_probe,
)
from service.settings import Settings
from service.storage.blobs import Blob, StoreFullError, StoreUnavailableError
from service.storage.local import LocalBlobs


def facts(**changes):
    usual = {"queued": 0, "running": 0, "workers": 2, "warm_workers": 2, "completed": 0}
    return EngineFacts(**{**usual, "capacity": 4, **changes})


@pytest.fixture
def service(tmp_path, monkeypatch):
    """A service that is warm, of which nothing runs."""
    made = ServiceContainer(Settings(store=str(tmp_path / "store")))
    made.kernels.loaded = True
    made.store.open()
    monkeypatch.setattr(made.builds, "facts", facts)
    yield made
    made.store.close()


def probes_of(service):
    return service_readiness(
        service.builds,
        service.store.blobs,
        service.kernels,
        stopping=lambda: service.stopping,
        needed_bytes=service.settings.store_reserve_bytes + service.settings.max_body_bytes,
    )


def report(of):
    return asyncio.run(of.report())


def found(service):
    """What each probe of a service finds."""
    return {probe.name: probe.status for probe in report(probes_of(service)).probes}


class TestService:
    def test_all_is_well(self, service):
        names = ("kernels", "workers", "queue", "builds", "store", "disk")
        assert found(service) == dict.fromkeys(names, "ok")

    def test_it_is_not_ready_before_its_kernels_are_loaded_or_when_it_stops(self, service):
        service.kernels.loaded, service.stopping = False, True
        assert (found(service)["kernels"], found(service)["builds"]) == ("failed", "failed")

    @pytest.mark.parametrize(
        ("found", "told"),
        [
            (facts(queued=4), "4 of 4 builds are waiting"),
            (facts(fault="the broker does not answer"), "the broker does not answer"),
        ],
    )
    def test_a_full_queue_or_a_lost_broker_sends_nobody_elsewhere(
        self, service, monkeypatch, found, told
    ):
        monkeypatch.setattr(service.builds, "facts", lambda: found)
        made = report(probes_of(service))
        assert made.ready
        assert told in made.wrong

    def test_workers_have_to_be_warm_once_and_may_then_be_started_anew(self, service, monkeypatch):
        probes = probes_of(service)

        def with_warm(count):
            monkeypatch.setattr(service.builds, "facts", lambda: facts(warm_workers=count))
            return report(probes).ready

        assert [with_warm(count) for count in (0, 1, 2, 1, 0)] == [False, False, True, True, True]
        later = time.monotonic() + readiness._GRACE_SECONDS + 1
        monkeypatch.setattr(readiness.time, "monotonic", lambda: later)
        assert [with_warm(count) for count in (0, 1, 0)] == [False, True, True]

    def test_a_service_without_workers_of_its_own_needs_none(self, service, monkeypatch):
        monkeypatch.setattr(service.builds, "facts", lambda: facts(workers=0, warm_workers=0))
        assert report(probes_of(service)).ready

    def test_a_directory_that_is_gone_is_named_without_its_path(self, service, tmp_path, caplog):
        (tmp_path / "store" / "temporary").rmdir()
        made = report(probes_of(service))
        assert not made.ready
        assert made.wrong == "store: not writable: No such file or directory"
        # the operator's log has it
        assert str(tmp_path) in caplog.text


class _Bucket:
    """A remote storage that does as it is told."""

    remote = True

    def __init__(self, error=None, changed=b""):
        self.blobs = {}
        self.error = error
        self.changed = changed

    def create(self, key, content):
        if self.error is not None:
            raise self.error
        self.blobs[key] = content + self.changed
        return "1"

    def read(self, key):
        return Blob(self.blobs[key], "1")

    def delete(self, key):
        return self.blobs.pop(key, None) is not None


class TestStore:
    def test_a_bucket_is_written_read_and_left_as_it_was(self):
        bucket = _Bucket()
        assert store_probe(bucket).status == "ok"
        assert bucket.blobs == {}

    @pytest.mark.parametrize(
        ("error", "status"),
        [
            (StoreUnavailableError("connection refused"), "degraded"),
            (StoreFullError(), "degraded"),
            (OSError(errno.ENOSPC, "full"), "degraded"),
            (OSError(errno.EIO, "Input/output error", "/secret/path"), "failed"),
        ],
    )
    def test_what_is_wrong_decides_whether_requests_go_elsewhere(self, error, status):
        finding = store_probe(_Bucket(error))
        assert finding.status == status
        assert "/secret" not in finding.detail

    def test_a_storage_that_changes_its_content_is_not_used(self):
        assert store_probe(_Bucket(changed=b"!")).status == "failed"

    def test_a_directory_is_left_as_it_was(self, tmp_path):
        blobs = LocalBlobs(tmp_path)
        blobs.open()
        before = sorted(tmp_path.rglob("*"))
        assert store_probe(blobs).status == "ok"
        assert sorted(tmp_path.rglob("*")) == before
        blobs.close()

    def test_room_is_compared_with_what_is_needed(self, tmp_path):
        assert disk_probe(tmp_path, 1).status == "ok"
        assert disk_probe(tmp_path, 10**18).status == "degraded"
        assert disk_probe(Path(tmp_path / "nothing"), 1).status == "failed"


class TestProbes:
    def test_a_slow_one_holds_for_a_moment_and_a_quick_one_does_not(self, monkeypatch):
        clock = SimpleNamespace(now=1000.0)
        monkeypatch.setattr(readiness, "time", SimpleNamespace(monotonic=lambda: clock.now))
        looks = []
        probes = Readiness()
        probes.add("quick", lambda: looks.append("quick") or Finding("ok", ""))
        probes.add_slow("slow", lambda: looks.append("slow") or Finding("ok", ""))
        for _ in range(3):
            report(probes)
        assert (looks.count("quick"), looks.count("slow")) == (3, 1)
        clock.now += readiness.HOLDS_SECONDS + 0.1
        report(probes)
        assert looks.count("slow") == 2

    def test_many_who_ask_at_once_share_one_look(self):
        looks, all_have_asked = [], threading.Event()

        def look():
            looks.append(1)
            all_have_asked.wait(600)
            return Finding("ok", "")

        probes = Readiness()
        probes.add_slow("slow", look)

        async def asked():
            asking = [asyncio.create_task(probes.report()) for _ in range(50)]
            await asyncio.sleep(0)
            all_have_asked.set()
            return await asyncio.gather(*asking)

        assert all(made.ready for made in asyncio.run(asked()))
        assert looks == [1]

    def test_one_that_hangs_makes_one_answer_late_and_takes_one_thread(self, monkeypatch):
        monkeypatch.setattr(readiness, "TIMEOUT_SECONDS", 0.2)
        looks, hanging = [], threading.Event()

        def look():
            looks.append(1)
            hanging.wait(600)
            return Finding("ok", "")

        probes = Readiness()
        probes.add_slow("disk", look)
        patience = []
        wait_for = asyncio.wait_for

        def noting(awaited, seconds):
            patience.append(seconds)
            return wait_for(awaited, seconds)

        async def asked():
            with monkeypatch.context() as patch:
                patch.setattr(asyncio, "wait_for", noting)
                made = [await probes.report() for _ in range(20)]
            hanging.set()
            while not (after := await probes.report()).ready:  # noqa: ASYNC110 - a thread
                await asyncio.sleep(0.01)
            return made, after

        made, after = asyncio.run(asked())
        assert not any(one.ready for one in made)
        assert made[0].wrong == "disk: no answer within 0.2 s"
        assert patience == [0.2] + [0.0] * 19
        assert looks == [1]
        assert after.ready

    def test_what_all_replicas_share_and_hangs_makes_none_of_them_unready(self, monkeypatch):
        monkeypatch.setattr(readiness, "SHARED_TIMEOUT_SECONDS", 0.2)
        hanging = threading.Event()
        probes = Readiness()
        probes.add_slow("store", lambda: hanging.wait(600) and Finding("ok", ""), shared=True)

        async def asked():
            made = await probes.report()
            hanging.set()
            return made

        made = asyncio.run(asked())
        assert made.ready
        assert made.wrong == "store: no answer within 0.2 s"

    def test_a_defect_of_a_probe_is_a_finding(self, caplog):
        probes = Readiness()
        probes.add_slow("odd", lambda: 1 / 0)
        assert report(probes).wrong == "odd: the check failed; see the log"
        assert "ZeroDivisionError" in caplog.text

    def test_a_change_is_logged_once(self, caplog):
        caplog.set_level(logging.INFO, logger="service.readiness")
        state = SimpleNamespace(finding=Finding("ok", ""))
        probes = Readiness()
        probes.add("thing", lambda: state.finding)
        for finding in ("ok", "failed", "failed", "degraded", "ok", "ok"):
            state.finding = Finding(finding, "so it is")
            report(probes)
        assert caplog.messages == [
            "not ready: thing: so it is",
            "degraded: thing: so it is",
            "all probes are ok again",
        ]


def test_only_what_has_failed_makes_a_report_say_no():
    probes = [Probe(status, status, "d") for status in ("ok", "degraded", "failed")]
    assert Report(tuple(probes[:2])).ready
    assert not Report(tuple(probes)).ready
    assert Report(tuple(probes)).wrong == "degraded: d; failed: d"
