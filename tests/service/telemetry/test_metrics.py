"""Figures in Prometheus' formats: as its own parsers read them, and as they were counted."""

import asyncio
import json
import subprocess
import sys
import urllib.request
from collections import Counter

import pytest
from prometheus_client.openmetrics.parser import (
    text_string_to_metric_families as openmetrics_families,
)
from prometheus_client.parser import text_string_to_metric_families as text_families

from gamutcore.levels import LevelRequest
from service.admission import Work
from service.application import create_app
from service.settings import Settings
from service.telemetry.metrics import Metrics, exposition, serve_metrics
from service.telemetry.processes import Usage, descendants_usage

OPENMETRICS = (  # what Prometheus sends
    "application/openmetrics-text;version=1.0.0;escaping=allow-utf-8;q=0.6,"
    "application/openmetrics-text;version=0.0.1;q=0.5,text/plain;version=1.0.0;q=0.4,*/*;q=0.1"
)


@pytest.fixture
def app(tmp_path):
    made = create_app(Settings(store=str(tmp_path / "store")))
    made.state.service.store.open()
    yield made
    made.state.service.store.close()


@pytest.fixture
def service(app):
    return app.state.service


def values(families):
    """Return the value of every sample by its name and labels, none twice."""
    samples = [sample for family in families for sample in family.samples]
    keys = [(sample.name, tuple(sorted(sample.labels.items()))) for sample in samples]
    assert max(Counter(keys).values()) == 1
    return dict(zip(keys, (sample.value for sample in samples), strict=True))


def read(service, accept=""):
    body, _ = exposition(service.metrics.registry, accept)
    parse = openmetrics_families if accept else text_families
    return values(parse(body.decode()))


def test_the_parsers_read_every_sample_and_both_formats_say_the_same(service):
    service.metrics.requests.count_answer("GET", '/a"b\\{c}', 200, 0.01)
    service.metrics.builds.count_build("succeeded", {"boundary": 0.5, "total": 1.0})
    service.metrics.queries.count("contains", 5, 0.01)
    asyncio.run(service.readiness.report())
    found, other = read(service), read(service, OPENMETRICS)
    changing = ("process_", "gamut_worker_", "gamut_store_free_bytes")
    for one, another in ((found, other), (other, found)):
        for key, value in one.items():
            assert key in another
            assert key[0].startswith(changing) or another[key] == value
    labels = (("method", "GET"), ("route", '/a"b\\{c}'), ("status", "200"))
    assert found["gamut_http_requests_total", labels] == 1
    assert found["gamut_builds_total", (("outcome", "succeeded"),)] == 1
    assert found["gamut_build_stage_seconds_sum", (("stage", "boundary"),)] == 0.5
    assert found["gamut_build_seconds_bucket", (("le", "1.0"),)] == 1
    assert found["gamut_query_rows_total", (("operation", "contains"),)] == 5
    assert found["gamut_ready", ()] == 0
    assert found["gamut_probe_ok", (("probe", "store"),)] == 1
    assert found["process_resident_memory_bytes", ()] > 10**7
    assert found["process_open_fds", ()] > 3
    names = {name for name, _ in found}
    assert all(name.startswith(("gamut_", "process_")) for name in names)


@pytest.mark.parametrize(
    ("accept", "media_type"),
    [
        ("", "text/plain"),
        ("*/*", "text/plain"),
        ("text/html,nonsense;;q=x", "text/plain"),
        (OPENMETRICS, "application/openmetrics-text"),
    ],
)
def test_the_format_is_the_one_that_is_asked_for(service, accept, media_type):
    assert exposition(service.metrics.registry, accept)[1].startswith(f"{media_type};")


def test_requests_are_counted_as_they_are_answered(app, request_app):
    for _ in range(3):
        request_app(app, "GET", "/livez")
    answer = request_app(app, "GET", "/metrics")
    assert answer.headers["cache-control"] == "no-store"
    found = values(text_families(answer.text))
    labels = (("method", "GET"), ("route", "/livez"), ("status", "200"))
    assert found["gamut_http_requests_total", labels] == 3
    assert found["gamut_http_requests_in_progress", ()] == 1  # the one that asks
    assert found["gamut_http_sent_bytes_total", ()] == 3 * len("live\n")


@pytest.fixture
def filled(service, built, publish_built):
    """A service with two gamuts."""
    for gamut in built:
        publish_built(service.store, gamut)
    return service


def test_the_caches_and_the_store_tell_what_happened(filled, built):
    one, other = (gamut.id for gamut in built)

    async def asked():
        wanted = LevelRequest(100)
        for name in (one, one, one, other):
            await filled.library.mesh(name, wanted, "ply")

    asyncio.run(asked())
    found = read(filled)
    meshes, gamuts = (("cache", "meshes"),), (("cache", "gamuts"),)
    assert found["gamut_cache_misses_total", meshes] == 2
    assert found["gamut_cache_hits_total", meshes] == 2
    assert found["gamut_cache_misses_total", gamuts] == 2
    assert found["gamut_cache_bytes", meshes] > 1000
    assert found["gamut_store_hits_total", ()] >= 2
    assert found["gamut_store_bytes", ()] > sum(len(gamut.to_bytes()) for gamut in built)
    assert found["gamut_store_corruptions_total", ()] == 0


def test_work_that_waits_is_told_of(filled, built):
    mesh = filled.library.mesh

    async def asked():
        wanted = [LevelRequest(max_error=0.5 + 0.02 * place) for place in range(8)]
        meshes = [asyncio.create_task(mesh(built[0].id, one, "obj")) for one in wanted]
        most = running = 0
        while not all(each.done() for each in meshes):
            found = read(filled)
            most = max(most, found["gamut_work_waiting", (("work", "view"),)])
            running = max(running, found["gamut_work_running", (("work", "view"),)])
            await asyncio.sleep(0)
        await asyncio.gather(*meshes)
        assert running == filled.admission.places[Work.VIEW]
        assert most == len(wanted) - running

    asyncio.run(asked())
    found = read(filled)
    assert found["gamut_work_waiting", (("work", "view"),)] == 0
    assert found["gamut_memory_charged_bytes", (("kind", "work"),)] == 0
    assert found["gamut_memory_charged_bytes", (("kind", "gamuts"),)] > 1000
    assert found["gamut_cache_bytes", (("cache", "tables"),)] > 1000


def test_counting_and_reading_at_the_same_time(service):
    """Series appear while they are read, in another thread."""

    async def scenario():
        reading = asyncio.get_running_loop().run_in_executor(
            None, lambda: [exposition(service.metrics.registry, "") for _ in range(2)]
        )
        number = 0
        while not reading.done():
            for _ in range(200):
                service.metrics.requests.count_answer("GET", f"/{number % 100}", 200, 0.01)
                number += 1
            await asyncio.sleep(0)
        await reading

    asyncio.run(scenario())


@pytest.mark.slow
def test_a_worker_elsewhere_serves_its_builds():
    builds, port, stop = serve_metrics("127.0.0.1", 0)
    builds.count_build("succeeded", {"boundary": 0.5, "total": 1.0})
    try:
        address = f"http://127.0.0.1:{port}/metrics"
        found = []
        for _ in range(2):
            with urllib.request.urlopen(address, timeout=600) as answer:
                found.append(values(text_families(answer.read().decode())))
            builds.count_build("cancelled", {"total": 2.0})
    finally:
        stop()
    assert found[0]["gamut_builds_total", (("outcome", "succeeded"),)] == 1
    assert found[1]["gamut_builds_total", (("outcome", "cancelled"),)] == 1
    assert found[1]["gamut_build_seconds_sum", ()] == 3.0
    assert found[1]["process_resident_memory_bytes", ()] > 0


def test_made_up_methods_are_one_series():
    metrics = Metrics()
    for number in range(50):
        metrics.requests.count_answer(f"METHOD{number}", "unmatched", 405, 0.001)
    found = values(text_families(exposition(metrics.registry, "")[0].decode()))
    labels = (("method", "other"), ("route", "unmatched"), ("status", "405"))
    answers = {key: value for key, value in found.items() if key[0] == "gamut_http_requests_total"}
    assert answers == {("gamut_http_requests_total", labels): 50}


def test_a_build_that_never_told_how_long_it_took_is_no_build_of_no_time():
    metrics = Metrics()
    for seconds in ({"boundary": 1.0, "total": 1.75}, {"boundary": 3.0, "total": 3.75}, {}):
        metrics.builds.count_build("succeeded" if seconds else "build-crashed", seconds)
    value = metrics.registry.get_sample_value
    assert value("gamut_builds_total", {"outcome": "succeeded"}) == 2
    assert value("gamut_builds_total", {"outcome": "build-crashed"}) == 1
    assert value("gamut_build_stage_seconds_sum", {"stage": "boundary"}) == 4.0
    assert value("gamut_build_seconds_count") == 2


WORK = """
import sys
block = bytearray(50_000_000)
for place in range(0, len(block), 4096):
    block[place] = 1
import time
end = time.process_time() + 0.3
while time.process_time() < end:
    pass
print("done", flush=True)
sys.stdin.read()
"""


PARENT = f"""
import json, subprocess, sys
from service.telemetry.processes import descendants_usage
usages = [descendants_usage()]
child = subprocess.Popen(
    [sys.executable, "-c", {WORK!r}], stdin=subprocess.PIPE, stdout=subprocess.PIPE
)
assert child.stdout.readline() == b"done\\n"
usages.append(descendants_usage())
child.stdin.close()
child.wait()
usages.append(descendants_usage())
print(json.dumps(usages))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has /proc")
@pytest.mark.slow
def test_memory_and_time_of_children_are_told_and_time_is_kept():
    # of a process that has no other children, which may end or shrink meanwhile
    told = subprocess.run([sys.executable, "-c", PARENT], check=True, stdout=subprocess.PIPE)
    before, during, after = (Usage(*usage) for usage in json.loads(told.stdout))
    assert [usage.processes for usage in (before, during, after)] == [0, 1, 0]
    assert during.resident_bytes > 50_000_000
    assert during.cpu_seconds >= 0.28
    # as a counter has to: a process that ends takes nothing with it
    assert after.cpu_seconds >= during.cpu_seconds


def test_a_process_that_is_not_there_has_no_usage():
    assert descendants_usage("nobody") is None


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has /proc")
def test_those_that_they_have_started_are_among_them():
    code = (
        "import subprocess, sys;"
        "child = subprocess.Popen([sys.executable, '-c', 'import sys; sys.stdin.read()'],"
        " stdin=subprocess.PIPE); print('started', flush=True); sys.stdin.read();"
        "child.stdin.close(); child.wait()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as child:
        assert child.stdout.readline() == b"started\n"
        assert descendants_usage(str(child.pid)).processes == 1
        assert descendants_usage().processes >= 2
        child.stdin.close()
