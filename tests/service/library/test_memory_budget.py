"""The caches, the default of the budget, and the memory of simultaneous requests."""

import asyncio
import contextlib
import hashlib
from pathlib import Path

import httpx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore import Gamut
from service.application import create_app
from service.library import PROCESS_BYTES, ByteBoundedCache, memory_budget
from service.settings import Settings
from service.storage.published import PublishedGamut

MEBIBYTE = 1024 * 1024
CAPACITY = 50
KEYS = st.integers(0, 7)
SIZES = st.integers(0, 60)
USES = st.one_of(
    st.tuples(st.just("put"), KEYS, SIZES),
    st.tuples(st.just("get"), KEYS, SIZES),
    st.tuples(st.sampled_from(["discard", "discard_where"]), KEYS, SIZES),
)


@given(st.lists(USES, max_size=60))
def test_a_cache_keeps_what_was_used_last_up_to_its_bytes(steps):
    """The expectation is a list of entries, the least recently used first."""
    cache, expected, hits, added = ByteBoundedCache(CAPACITY), [], 0, 0
    for name, key, size in steps:
        kept = next((entry for entry in expected if entry[0] == key), None)
        if name == "put":
            value = [key]
            cache.put(key, value, size)
            added += kept is None
            expected = [entry for entry in expected if entry[0] != key]
            if size <= CAPACITY:
                expected.append((key, value, size))
        elif name == "get":
            found = cache.get(key)
            assert found is (kept and kept[1])
            hits += kept is not None
            if kept:
                expected.remove(kept)
                expected.append(kept)
        elif name == "discard":
            cache.discard(key)
            expected = [entry for entry in expected if entry[0] != key]
        elif name == "discard_where":
            cache.discard_where(lambda each, least=key: each >= least)
            expected = [entry for entry in expected if entry[0] < key]
        while sum(entry[2] for entry in expected) > CAPACITY:
            expected.pop(0)
        assert cache.nbytes == sum(entry[2] for entry in expected) <= CAPACITY
        assert (cache.hits, cache.misses, len(cache)) == (hits, added, len(expected))


def fake_system(root, files):
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return root


GIBIBYTE = 1024 * MEBIBYTE
MEMINFO = {"proc/meminfo": f"MemTotal:       {100 * MEBIBYTE} kB\nMemFree: 1 kB\n"}
V1 = "9:memory:/docker/x\n8:cpu:/docker/x\n"


@pytest.mark.parametrize(
    ("files", "available"),
    [
        ({}, 100 * GIBIBYTE),
        (
            {"proc/self/cgroup": "0::/a/b\n", "sys/fs/cgroup/a/b/memory.max": "max\n"},
            100 * GIBIBYTE,
        ),
        (
            {"proc/self/cgroup": "0::/a/b\n", "sys/fs/cgroup/a/memory.max": f"{20 * GIBIBYTE}\n"},
            20 * GIBIBYTE,
        ),
        (
            {"proc/self/cgroup": "0::/\n", "sys/fs/cgroup/memory.max": f"{20 * GIBIBYTE}\n"},
            20 * GIBIBYTE,
        ),
        (
            {
                "proc/self/cgroup": V1,
                "sys/fs/cgroup/memory/memory.limit_in_bytes": f"{20 * GIBIBYTE}\n",
            },
            20 * GIBIBYTE,
        ),
        (
            {
                "proc/self/cgroup": V1,
                "sys/fs/cgroup/memory/docker/x/memory.limit_in_bytes": f"{30 * GIBIBYTE}\n",
                "sys/fs/cgroup/memory/memory.limit_in_bytes": f"{2**63 - 4096}\n",
            },
            30 * GIBIBYTE,
        ),
    ],
)
def test_the_default_is_a_share_of_the_memory_without_that_of_the_workers(
    tmp_path, files, available
):
    root = fake_system(tmp_path, {**MEMINFO, **files})
    settings = Settings(build_workers=2, build_memory_bytes=GIBIBYTE)
    assert memory_budget(settings, root) == int(0.6 * available) - 2 * GIBIBYTE


def test_the_default_suffices_for_a_comparison_and_a_given_budget_is_taken(tmp_path):
    small = fake_system(tmp_path, {"proc/meminfo": "MemTotal: 1000000 kB\n"})
    assert memory_budget(Settings(), small) == 448 * MEBIBYTE
    assert memory_budget(Settings(memory_bytes=10**9), small) == 10**9


PRESS = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"
QUERIES = ("contains", "comparison", "viewer.html", "picture.png?size=512", "mesh.3mf?max_error=0")


@pytest.fixture(scope="module")
def presses():
    """Gamuts of one press with different ink limits: 20,000 triangles each."""
    return [Gamut(PRESS, surface_samples=15_000, ink_limit=limit) for limit in range(240, 320, 10)]


@pytest.mark.long
def test_simultaneous_full_boundaries_stay_within_the_budget(presses, filled_store, published):
    """The process itself is not bounded here: the test's process has other things in memory."""
    ids = [published(gamut) for gamut in presses]
    filled_store.close()
    budget = PROCESS_BYTES + 40 * MEBIBYTE
    settings = Settings(
        store=str(filled_store.blobs.directory), memory_bytes=budget, client_requests=99
    )

    async def scenario():
        app = create_app(settings)
        admission, most, statuses = app.state.service.admission, [], []
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:

            async def ask(number, what):
                one, other = ids[number % len(ids)], ids[(number + 1) % len(ids)]
                address = f"/v1/gamuts/{one}"
                if what == "contains":
                    question = {"colours": [[50, 0, 0]], "max_error": 0}
                    answer = await client.post(f"{address}/contains", json=question)
                elif what == "comparison":
                    pair = f"a={one}&b={other}&max_error=0"
                    answer = await client.get(f"/v1/comparisons?{pair}")
                else:
                    answer = await client.get(f"{address}/{what}")
                statuses.append(answer.status_code)

            async def watch():
                while True:
                    most.append(admission.granted.total())
                    await asyncio.sleep(0)

            async with app.router.lifespan_context(app):
                watching = asyncio.create_task(watch())
                await asyncio.gather(*(ask(n, what) for n in range(16) for what in QUERIES))
                watching.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await watching
                metrics = (await client.get("/metrics")).text
        assert set(statuses) == {200}
        assert 10 * MEBIBYTE < max(most) <= admission.budget == 40 * MEBIBYTE
        assert admission.total <= admission.budget
        assert "gamut_memory_budget_bytes 4.194304e+07" in metrics
        assert 'gamut_memory_charged_bytes{kind="work"} 0.0' in metrics

    asyncio.run(scenario())


@pytest.fixture
def published(filled_store):
    """Store a gamut and return its id."""

    def publish(gamut):
        content = gamut.to_bytes()
        path = filled_store.scratch(".gamut")
        path.write_bytes(content)
        digest = hashlib.sha256(content).hexdigest()
        record = PublishedGamut(gamut.id, digest, len(content), "", gamut.description)
        return filled_store.publish(record, path).id

    return publish
