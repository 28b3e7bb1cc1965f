"""Open gamuts, levels and meshes in memory: bounded, shared, and gone with the gamut."""

import asyncio
import contextlib
import hashlib
import os
import threading
from types import SimpleNamespace

import httpx
import pytest

from gamutcore.levels import LevelSearch
from service.application import create_app
from service.building.kernels import Kernels
from service.settings import Settings
from service.storage import published
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs

LIMIT = "max_error=0.7&max_mismatch=0.02"
HANG = 600
"""Seconds after which a test gives up; it never waits as long."""


@pytest.fixture
def app(filled_store):
    """An app with the gamuts of `built`, whose lifespan does not run."""

    def make(**settings):
        return create_app(Settings(store=str(filled_store.blobs.directory), **settings))

    return make


@pytest.fixture
def meanwhile(app):
    """Run a coroutine function with clients of an app, and end it if it hangs."""

    def run(scenario, addresses=("127.0.0.1",), **settings):
        async def with_clients():
            made = app(**settings)
            async with contextlib.AsyncExitStack() as stack:
                clients = []
                for address in addresses:
                    transport = httpx.ASGITransport(made, client=(address, 1))
                    client = httpx.AsyncClient(transport=transport, base_url="http://[::1]")
                    clients.append(await stack.enter_async_context(client))
                return await asyncio.wait_for(scenario(*clients), HANG)

        return asyncio.run(with_clients())

    return run


class Gate:
    """Holds calls of a function until it is opened, and counts those inside."""

    def __init__(self, function):
        self.function = function
        self.entered, self.opened = threading.Event(), threading.Event()
        self.lock, self.inside, self.most = threading.Lock(), 0, 0

    def __call__(self, *arguments):
        with self.lock:
            self.inside += 1
            self.most = max(self.most, self.inside)
        self.entered.set()
        assert self.opened.wait(HANG)
        try:
            return self.function(*arguments)
        finally:
            with self.lock:
                self.inside -= 1


@pytest.fixture
def gate(monkeypatch):
    """Put a gate in front of a method."""

    def put(owner, name):
        made = Gate(getattr(owner, name))

        def held(*arguments):
            return made(*arguments)

        monkeypatch.setattr(owner, name, held)
        return made

    return put


def addresses(built):
    return [
        f"/v1/gamuts/{gamut.id}/mesh{rest}"
        for rest in ("?triangles=100", ".obj", f"?{LIMIT}", f".ply?{LIMIT}&side=inside")
        for gamut in built
    ]


@pytest.mark.parametrize(
    "settings",
    [
        {"mesh_cache_bytes": 0},
        {"history_cache_bytes": 0},
        {"history_cache_bytes": 60_000},
        {"mesh_cache_bytes": 20_000},
    ],
    ids=str,
)
def test_without_room_everything_is_answered_alike(app, request_app, built, settings):
    roomy, narrow = app(), app(**settings)
    for address in addresses(built) * 2:
        expected = request_app(roomy, "GET", address)
        answer = request_app(narrow, "GET", address)
        assert answer.status_code == expected.status_code == 200
        assert answer.content == expected.content
        assert answer.headers["etag"] == expected.headers["etag"]


def test_processes_find_the_same_level_whatever_they_were_asked_before(app, request_app, built):
    mesh = f"/v1/gamuts/{built[0].id}/mesh"
    found = set()
    for others in ([], ["max_error=0.4", "max_error=2"], ["max_mismatch=1e-3", "max_error=1"]):
        process = app()
        for query in others:
            assert request_app(process, "GET", f"{mesh}?{query}").status_code == 200
        found.add(request_app(process, "GET", f"{mesh}?{LIMIT}").headers["etag"])
    assert len(found) == 1


def test_levels_are_searched_in_few_places_while_others_are_served(meanwhile, gate, built):
    searches = gate(LevelSearch, "find")
    one, other = (f"/v1/gamuts/{gamut.id}/mesh" for gamut in built)

    async def scenario(client, another):
        queries = [f"max_error={0.5 + 0.02 * place}" for place in range(6)]
        asked = [
            asyncio.create_task(client.get(f"{mesh}?{query}"))
            for query in [*queries, queries[0], queries[1]]
            for mesh in (one, other)
        ]
        await asyncio.to_thread(searches.entered.wait, HANG)
        for query in ("", "?triangles=100", f"?triangles={built[1].history.triangles}"):
            assert (await another.get(other + query)).status_code == 200
        searches.opened.set()
        answers = await asyncio.gather(*asked)
        assert {answer.status_code for answer in answers} == {200}
        assert all(float(answer.headers["gamut-max-error"]) <= 0.6 for answer in answers)
        # whoever waits for a place is told so
        timings = [answer.headers["server-timing"] for answer in answers]
        assert any("wait;" in timing and "choose;" in timing for timing in timings)

    meanwhile(scenario, addresses=("192.0.2.1", "192.0.2.2"))
    assert 1 <= searches.most <= len(os.sched_getaffinity(0))


@pytest.mark.parametrize(
    ("owner", "name"), [(GamutStore, "content"), (LevelSearch, "find")], ids=["open", "search"]
)
def test_nothing_is_served_of_a_gamut_that_is_deleted_meanwhile(
    meanwhile, gate, built, owner, name
):
    own = f"/v1/gamuts/{built[0].id}"
    held = gate(owner, name)

    async def scenario(client):
        asked = [asyncio.create_task(client.get(f"{own}/mesh?{LIMIT}")) for _ in range(3)]
        await asyncio.to_thread(held.entered.wait, HANG)
        assert (await client.delete(own)).status_code == 204
        held.opened.set()
        answers = await asyncio.gather(*asked)
        # who asked before may still get what was read
        assert {answer.status_code for answer in answers} <= {200, 404}
        assert held.most == 1
        for below in ("", "/mesh", f"/mesh?{LIMIT}", "/mesh?triangles=100"):
            answer = await client.get(own + below)
            assert answer.json()["code"] == "gamut-not-found", below

    meanwhile(scenario)


def test_meshes_outlive_the_open_gamut_but_not_the_deleted_one(app, request_app, built):
    process = app(history_cache_bytes=max(gamut.nbytes for gamut in built))
    one, other = built
    full = f"/v1/gamuts/{one.id}/mesh?triangles={one.history.triangles}"
    first = request_app(process, "GET", full)
    assert hashlib.sha256(first.content).hexdigest() == first.headers["etag"].strip('"')
    # the other gamut takes the memory
    request_app(process, "GET", full.replace(one.id, other.id))
    assert request_app(process, "GET", full).content == first.content
    assert request_app(process, "DELETE", f"/v1/gamuts/{one.id}").status_code == 204
    assert request_app(process, "GET", full).status_code == 404


async def ready(*_):
    """Answer in place of `Kernels.wait`, as no lifespan prepares the kernels."""
    return True


def test_a_deletion_reaches_another_replica_within_a_minute(app, filled_store, monkeypatch):
    """In a bucket. What is in memory is served without the store for a minute, and not longer."""
    clock = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(published, "time", SimpleNamespace(monotonic=lambda: clock.now))
    monkeypatch.setattr(LocalBlobs, "remote", True)
    monkeypatch.setattr(Kernels, "wait", ready)
    kept, deleted = (f"/v1/gamuts/{gamut_id}" for gamut_id in filled_store.ids())
    parts = ("", "/mesh?triangles=100", "/mesh?max_error=2", "/picture.png?triangles=100", "/cusps")
    made = [app() for _ in range(2)]
    reads = []
    blobs = made[1].state.service.store.blobs
    for name in ("read", "stream"):
        method = getattr(blobs, name)
        monkeypatch.setattr(
            blobs, name, lambda key, method=method: reads.append(key) or method(key)
        )

    async def scenario(here, there):
        async def statuses(address):
            return {part: (await there.get(f"{address}{part}")).status_code for part in parts}

        for address in (kept, deleted):
            assert set((await statuses(address)).values()) == {200}
        assert (await here.delete(deleted)).status_code == 204
        assert (await here.get(f"{deleted}/mesh?triangles=100")).status_code == 404
        clock.now += 59
        reads.clear()
        assert (await statuses(deleted))["/mesh?triangles=100"] == 200
        assert not [key for key in reads if key.endswith("record")]
        clock.now += 2
        assert set((await statuses(deleted)).values()) == {404}
        assert set((await statuses(kept)).values()) == {200}
        # the store was asked for its record once, and it is in memory still
        assert [key.rpartition(".")[2] for key in reads if kept[-64:] in key].count("record") == 1
        assert not [key for key in reads if key.endswith(".gamut")]

    async def run():
        async with contextlib.AsyncExitStack() as stack:
            transports = [httpx.ASGITransport(each) for each in made]
            clients = [
                await stack.enter_async_context(
                    httpx.AsyncClient(transport=transport, base_url="http://[::1]")
                )
                for transport in transports
            ]
            await asyncio.wait_for(scenario(*clients), HANG)

    asyncio.run(run())
