"""What the routes of an app share: made of its settings, forgotten and closed together."""

import asyncio
import builtins
import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest

from service import broker
from service.building.embedded import EmbeddedEngine
from service.container import EngineMissingError, ServiceContainer, _build_engine, service_of
from service.jobs.book import JobBook
from service.settings import Settings
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs


@pytest.fixture
def service(tmp_path):
    return ServiceContainer(Settings(store=str(tmp_path / "data")))


async def nothing():
    pass


def test_the_signal_to_stop_reaches_the_builds_from_any_thread(service, monkeypatch):
    monkeypatch.setattr(service.builds, "start", nothing)
    service.drain()  # nothing runs yet

    async def scenario():
        async with service.running():
            thread = threading.Thread(target=service.drain)
            thread.start()
            while not service.builds.draining:  # noqa: ASYNC110 - a thread
                await asyncio.sleep(0.01)
            thread.join()

    asyncio.run(asyncio.wait_for(scenario(), 60))


def test_many_calls_of_a_bucket_wait_at_the_same_time(service, monkeypatch):
    monkeypatch.setattr(service.builds, "start", nothing)
    monkeypatch.setattr(service.store.blobs, "remote", True)
    all_of_them = threading.Barrier(32, timeout=30)

    async def scenario():
        async with service.running():
            await asyncio.gather(*[asyncio.to_thread(all_of_them.wait) for _ in range(32)])

    asyncio.run(asyncio.wait_for(scenario(), 60))


def test_it_is_made_of_its_settings(service, tmp_path):
    assert service.store.blobs.directory == tmp_path / "data"
    assert not (tmp_path / "data").exists()  # nothing is opened before it runs


def test_a_deleted_gamut_is_forgotten_by_all_who_keep_it(service, monkeypatch):
    forgotten = []
    monkeypatch.setattr(service.library, "discard", lambda name: forgotten.append(("gamut", name)))
    monkeypatch.setattr(
        service.meshes, "discard_gamut", lambda name: forgotten.append(("meshes", name))
    )
    service.forget("ab" * 32)
    assert forgotten == [("gamut", "ab" * 32), ("meshes", "ab" * 32)]


def test_it_runs_warms_up_and_closes(service, monkeypatch):
    stopped = []

    async def stop():
        stopped.append(True)

    monkeypatch.setattr(service.builds, "start", nothing)
    monkeypatch.setattr(service.builds, "stop", stop)

    async def scenario():
        async with service.running():
            assert service.store.blobs.directory.is_dir()
            while not service.kernels.loaded:  # noqa: ASYNC110
                await asyncio.sleep(0.01)
            assert service.kernels.states["default"] == "compiled"
        assert stopped == [True]

    asyncio.run(asyncio.wait_for(scenario(), 300))


def test_a_second_service_can_have_the_store_when_the_first_is_gone(service, monkeypatch):
    other = ServiceContainer(service.settings)
    for each in (service, other):
        monkeypatch.setattr(each.builds, "start", nothing)

    async def scenario():
        for each in (service, other):
            async with each.running():
                pass

    asyncio.run(asyncio.wait_for(scenario(), 300))


def test_a_request_finds_it_at_its_app(service):
    request = SimpleNamespace(app=SimpleNamespace(state=SimpleNamespace(service=service)))
    assert service_of(request) is service


REMOTE = {"store": "s3://bucket/prefix", "broker": "redis://127.0.0.1:1/0"}


@pytest.fixture
def parts(tmp_path):
    store = GamutStore(LocalBlobs(tmp_path / "store"))
    return store, JobBook(store.blobs)


@pytest.fixture
def _nothing_installed(monkeypatch):
    usual = builtins.__import__

    def without(name, *arguments, **keywords):
        if name.partition(".")[0] in {"celery", "kombu", "billiard"}:
            raise ModuleNotFoundError(name)
        return usual(name, *arguments, **keywords)

    for name in [name for name in sys.modules if name.startswith("service.broker.celery_")]:
        monkeypatch.delitem(sys.modules, name)
        # `from package import module` finds what was imported before in the package itself.
        monkeypatch.delattr(broker, name.rpartition(".")[2], raising=False)
    monkeypatch.setattr(builtins, "__import__", without)


def test_without_a_broker_builds_are_done_here(parts):
    assert isinstance(_build_engine(Settings(), *parts, None), EmbeddedEngine)


def test_with_a_broker_they_are_done_elsewhere(parts):
    engine = _build_engine(Settings(**REMOTE), *parts, None)
    assert type(engine).__name__ == "CeleryEngine"
    assert engine.facts().workers == 0


@pytest.mark.usefixtures("_nothing_installed")
def test_what_is_not_installed_is_named(parts):
    with pytest.raises(EngineMissingError, match=r"\[celery,cloud\]"):
        _build_engine(Settings(**REMOTE), *parts, None)


@pytest.mark.slow
def test_a_service_without_a_broker_loads_none_of_it():
    code = (
        "import sys, service.application;"
        "print([name for name in sys.modules if name.partition('.')[0] in"
        " {'celery', 'kombu', 'redis', 'amqp', 'obstore'}])"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == "[]"
