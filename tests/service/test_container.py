"""What the routes of an app share: made of its settings, forgotten and closed together."""

import asyncio
import threading
from types import SimpleNamespace

import pytest

from service.container import Service, service_of
from service.settings import Settings


@pytest.fixture
def service(tmp_path):
    return Service(Settings(store=str(tmp_path / "data")))


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
        warmed = asyncio.Event()
        warm = service._warm

        async def warm_and_say_so():
            await warm()
            warmed.set()

        monkeypatch.setattr(service, "_warm", warm_and_say_so)
        async with service.running():
            assert service.store.blobs.directory.is_dir()
            await warmed.wait()
            assert service.warm
        assert stopped == [True]

    asyncio.run(asyncio.wait_for(scenario(), 300))


def test_a_second_service_can_have_the_store_when_the_first_is_gone(service, monkeypatch):
    other = Service(service.settings)
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
