"""The process that builds, and the kernels that a service compiles in processes of their own."""

import asyncio
import hashlib
import io
import json
import logging
import mmap
import os
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np
import pytest

from gamutcore import Gamut, Options, reference
from gamutcore.building import gamut_id
from service.building import kernels, worker
from service.building.kernels import Kernels
from service.building.process import BuildProcess, private_bytes


@pytest.fixture
def result(tmp_path):
    """Build from these bytes and options, and return all events."""

    def run(data, options, output="history", memory=0, job=None):
        (tmp_path / "input").write_bytes(data)
        stream = io.BytesIO()
        request = {
            "id": job or expected_id(data, options),
            "input": str(tmp_path / "input"),
            "output": str(tmp_path / output),
            "options": options,
            "memory": memory,
        }
        worker.build(request, worker.Events(stream))
        return [json.loads(line) for line in stream.getvalue().splitlines()]

    return run


def expected_id(data, options):
    known = Options.from_mapping(options if "unknown" not in options else {})
    return gamut_id(known, hashlib.sha256(data).hexdigest())


def document(samples):
    return json.dumps({"samples": samples}).encode()


def test_the_history_file_is_written_and_described(result, sphere, tmp_path):
    options = Options.from_mapping({"gamma": 0.5})
    *progress, built = result(document(sphere()), options.to_mapping())
    content = (tmp_path / "history").read_bytes()
    assert built["event"] == "built"
    assert built["sha256"] == hashlib.sha256(content).hexdigest()
    assert built["nbytes"] == len(content)
    assert built["description"] == json.loads(json.dumps(Gamut.from_bytes(content).description))
    assert built["description"]["options"] == options.to_mapping()
    assert {"characterisation", "boundary", "decimation", "metric"} <= set(built["seconds"])
    assert all(seconds >= 0 for seconds in built["seconds"].values())
    assert progress
    for event in progress:
        assert event["event"] == "progress"
        assert event["stage"]
        assert 0 <= event["fraction"] <= 1


def test_an_error_of_gamutcore_is_passed_on_whole(result):
    (*_, refused) = result(b"LAB_L,LAB_A,LAB_X\n1,2,3\n", {})
    assert refused["event"] == "refused"
    assert refused["code"] == "missing-column"
    assert refused["message"]


def test_a_job_of_another_version_gets_the_gamut_of_this_one(result, sphere):
    content = document(sphere())
    *_, built = result(content, {}, job="0" * 64)
    assert (built["event"], built["id"]) == ("built", Gamut(content).id)
    *_, built = result(content, {}, job=Gamut(content).id)
    assert "id" not in built


@pytest.mark.parametrize(
    ("stored", "options"),
    [
        ({"space": "Oklab", "scale": 1.0}, {"space": "Oklab"}),
        (
            {"boundary": "convex-hull", "gamma": 1.0},
            {"boundary": "modified-convex-hull", "gamma": 1},
        ),
    ],
)
def test_options_that_an_earlier_version_stored_are_built(result, sphere, stored, options):
    content = document(sphere())
    *_, built = result(content, stored, job="0" * 64)
    assert (built["event"], built["id"]) == ("built", Gamut(content, options).id)


def test_coordinates_with_a_factor_are_not_built(result, sphere):
    (refused,) = result(document(sphere()), {"space": "Oklab", "scale": 2.0}, job="0" * 64)
    assert (refused["code"], refused["where"]) == ("invalid-option", {"field": "scale"})
    assert "multiply the coordinates" in refused["remedy"]


def test_an_option_of_another_version_is_refused(result, sphere):
    (refused,) = result(document(sphere()), {"unknown": 1})
    assert refused["seconds"] == {}
    assert (refused["code"], refused["where"]) == ("invalid-option", {"field": "unknown"})


def test_a_disk_error_has_its_number(result, sphere):
    *_, failed = result(document(sphere()), {}, output="no/such/folder/history")
    assert failed.items() >= {"event": "failed", "errno": 2}.items()


def test_decoders_write_to_the_folder_of_the_store(result, tmp_path, monkeypatch):
    folders = []

    def decode(*_, **__):
        folders.append(tempfile.gettempdir())
        raise MemoryError

    monkeypatch.setattr(worker, "Gamut", decode)
    result(document([[0, 0, 0]]), {})
    assert folders == [str(tmp_path)]


def test_a_defect_costs_one_build(result, monkeypatch):
    def defect(*_arguments, **_options):
        raise ZeroDivisionError

    monkeypatch.setattr(worker, "Gamut", defect)
    assert result(b"", {}) == [{"event": "failed", "errno": None, "seconds": {}}]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits what was mapped")
def test_an_allocation_beyond_the_memory_fails_and_the_next_build_works(
    result, sphere, monkeypatch
):
    def greedy(*_arguments, **_options):
        return np.ones(100_000_000)

    limits = resource.getrlimit(resource.RLIMIT_DATA)
    usual = worker.Gamut
    in_use = private_bytes("self")
    monkeypatch.setattr(worker, "Gamut", greedy)
    (exhausted,) = result(document(sphere()), {}, memory=in_use + 400_000_000)
    assert exhausted["event"] == "exhausted"
    assert resource.getrlimit(resource.RLIMIT_DATA) == limits
    monkeypatch.setattr(worker, "Gamut", usual)
    *_, built = result(document(sphere()), {}, memory=in_use + 2_000_000_000)
    assert built["event"] == "built"


@pytest.mark.slow
def test_the_process_is_ready_once_and_ends_with_its_input():
    command = [sys.executable, "-m", "service.building.worker"]
    answer = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, timeout=600, check=False
    )
    assert answer.returncode == 0
    assert answer.stdout in {b"", b'{"event": "ready"}\n'}


CONFINED = """
import json, os, resource, sys
from pathlib import Path
from service.building import worker
def build(request, events):
    usual(request, worker.Events(open(os.devnull, "wb")))
    status = Path("/proc/self/status").read_text()
    names = ("CORE", "NOFILE", "FSIZE", "CPU")
    events.send(
        "found",
        environment=dict(os.environ),
        limits={name: resource.getrlimit(getattr(resource, "RLIMIT_" + name)) for name in names},
        privileges=[line.split()[1] for line in status.splitlines() if "NoNewPrivs" in line],
        files=[os.readlink(f"/proc/self/fd/{name}") for name in os.listdir("/proc/self/fd")[:-1]],
    )
usual, worker.build = worker.build, build
worker.main()
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells and limits all of this")
def test_a_worker_has_no_credentials_no_privileges_and_no_files(monkeypatch, tmp_path):
    secrets = {
        "AWS_SECRET_ACCESS_KEY": "s3cret",
        "AWS_WEB_IDENTITY_TOKEN_FILE": "/var/s3cret",
        "AZURE_STORAGE_KEY": "s3cret",
        "GOOGLE_SERVICE_ACCOUNT": "s3cret",
        "GAMUT_BROKER": "redis://:s3cret@broker",
        "GAMUT_API_KEYS": "s3cret",
        "GAMUT_API_KEYS_FILE": "/var/s3cret",
        "HTTPS_PROXY": "http://u:s3cret@proxy",
    }
    needed = {"GAMUT_LOG_LEVEL": "warning", "NUMBA_CPU_NAME": "generic", "TZ": "UTC"}
    for name, value in (secrets | needed).items():
        monkeypatch.setenv(name, value)
    with (tmp_path / "secret").open("w") as file:
        os.set_inheritable(file.fileno(), True)
        made = BuildProcess([sys.executable, "-c", CONFINED])
        try:
            made.wait_until_ready(lambda: None)
            found = made.result(
                {"id": "", "input": "", "output": "", "options": {}, "seconds": 1000},
                progress=lambda *_: None,
                check=lambda: None,
            )
        finally:
            made.kill()
    assert "s3cret" not in str(found["environment"])
    assert found["environment"].items() >= needed.items()
    assert found["privileges"] == ["1"]
    assert found["limits"]["CORE"] == [0, 0]
    assert 0 < found["limits"]["NOFILE"][1] <= 1024
    assert 1 << 30 <= found["limits"]["FSIZE"][1] <= 1 << 32
    assert 1000 < found["limits"]["CPU"][0] < 1100 * os.cpu_count()
    assert not [name for name in found["files"] if "secret" in name or "socket" in name]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux" or os.getuid() != 0, reason="needs another user")
@pytest.mark.parametrize("hidden", [True, False])
def test_a_worker_cannot_read_the_environment_of_the_service(hidden):
    """As a user without rights; the service itself still counts its open files."""
    program = (
        "import ctypes, os, subprocess, sys\n"
        "from service.building.process import hide_memory\n"
        "os.setgid(65534); os.setuid(65534); ctypes.CDLL(None).prctl(4, 1, 0, 0, 0)\n"
        f"{'hide_memory()' if hidden else ''}\n"
        "name = f'/proc/{os.getpid()}/environ'\n"
        "child = subprocess.run(['/usr/bin/env', 'cat', name], capture_output=True)\n"
        "print(child.returncode, len(os.listdir('/proc/self/fd')) > 2)"
    )
    answer = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=600, check=True
    )
    assert answer.stdout.split() == ["1" if hidden else "0", "True"]


SLEEP = [sys.executable, "-c", "import sys; sys.stdin.read()"]


@pytest.fixture
def nothing_compiled(monkeypatch):
    """Have no group compiled; the returned dictionary has each group's command."""
    commands = {group: [sys.executable, "-c", ""] for group in kernels.GROUPS}
    monkeypatch.setattr(kernels, "is_compiled", lambda _: False)
    monkeypatch.setattr(kernels, "stamps_can_be_kept", lambda: True)
    monkeypatch.setattr(kernels, "compile_command", commands.__getitem__)
    return commands


def prepare(made):
    async def scenario():
        task = asyncio.create_task(made.prepare())
        for group in kernels.GROUPS:
            assert await made.wait(group, 600)
        await task

    asyncio.run(scenario())


@pytest.mark.slow
def test_an_installation_that_is_compiled_is_loaded():
    made = Kernels()
    prepare(made)
    assert made.loaded
    assert dict(made.states) == dict.fromkeys(kernels.GROUPS, "compiled")


@pytest.mark.usefixtures("nothing_compiled")
def test_what_is_missing_is_compiled_first():
    made = Kernels()
    prepare(made)
    assert made.loaded
    assert dict(made.states) == dict.fromkeys(kernels.GROUPS, "compiled")


def test_it_is_ready_while_the_optional_group_compiles(nothing_compiled):
    nothing_compiled["optional"] = SLEEP
    made = Kernels()

    async def scenario():
        task = asyncio.create_task(made.prepare())
        deadline = time.monotonic() + 600
        while made.states["optional"] != "compiling" and time.monotonic() < deadline:  # noqa: ASYNC110
            await asyncio.sleep(0.01)
        assert made.loaded
        assert made.states["default"] == "compiled"
        # requests wait for what they need
        assert await made.wait("default", 0)
        assert not await made.wait("optional", 0.01)
        # a service that stops ends the compiler
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(asyncio.wait_for(scenario(), 600))


def test_searches_by_ciede2000_compile_when_a_request_waits_and_kernels_are_counted(
    nothing_compiled,
):
    # a kernel that two processes use is named twice
    names = "import sys; print('one'); print('two'); print('one', flush=True); sys.stdin.read()"
    nothing_compiled["ciede2000"] = [sys.executable, "-c", names]
    made = Kernels()

    async def scenario():
        task = asyncio.create_task(made.prepare())
        assert await made.wait("optional", 600)
        while made.states["ciede2000"] == "unknown":  # noqa: ASYNC110
            await asyncio.sleep(0.01)
        assert made.states["ciede2000"] == "on first use"
        assert not await made.wait("ciede2000", 0.01)
        deadline = time.monotonic() + 600
        while "2 of" not in made.detail and time.monotonic() < deadline:  # noqa: ASYNC110
            await asyncio.sleep(0.01)
        expected = "default: compiled, optional: compiled, ciede2000: compiling 2 of 11 kernels"
        assert made.detail == expected
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(asyncio.wait_for(scenario(), 600))


def test_a_compiler_that_fails_costs_time_and_not_the_service(nothing_compiled, caplog):
    nothing_compiled["default"] = [sys.executable, "-c", "raise SystemExit(3)"]
    made = Kernels()
    prepare(made)
    assert made.loaded
    assert made.states["default"] == "on first use"
    assert "exit status 3" in caplog.text


@pytest.mark.usefixtures("nothing_compiled")
def test_where_nothing_can_be_kept_the_log_says_what_to_do(monkeypatch, caplog):
    monkeypatch.setattr(kernels, "stamps_can_be_kept", lambda: False)
    made = Kernels()
    with caplog.at_level(logging.WARNING):
        prepare(made)
    assert made.loaded
    assert "NUMBA_CACHE_DIR" in caplog.text


READ_LEVELS = """
import asyncio, sys
from pathlib import Path
from gamutcore.export import FORMATS, mesh_file
from gamutcore import Gamut
from gamutcore.levels import LevelRequest, LevelSearch
from gamutcore.kernels import KERNELS
from service.building.kernels import Kernels

async def prepare():
    kernels = Kernels()
    task = asyncio.create_task(kernels.prepare())
    while not kernels.loaded:
        await asyncio.sleep(0.01)
    task.cancel()

def signatures():
    return {kernel.__name__: len(kernel.signatures) for kernel in KERNELS}

asyncio.run(prepare())
before = signatures()
gamut = Gamut.from_bytes(Path(sys.argv[1]).read_bytes())
search = LevelSearch(gamut.description["levels"])
search.find(gamut.history, LevelRequest(max_error=0.5))
for name in FORMATS:
    mesh_file(gamut.level(100), name)
late = [name for name, count in signatures().items() if count > before[name]]
sys.exit(f"used before they were loaded: {late}" if late or not sum(before.values()) else None)
"""


@pytest.mark.slow
@pytest.mark.skipif(not kernels.is_compiled("default"), reason="the kernels are not compiled")
def test_a_ready_service_has_loaded_all_kernels_that_levels_need(tmp_path):
    path = tmp_path / "gamut"
    # all formats can hold a display's gamut
    path.write_bytes(reference("sRGB", surface_samples=1000).to_bytes())
    subprocess.run([sys.executable, "-c", READ_LEVELS, str(path)], check=True)


@pytest.mark.slow
def test_only_what_was_touched_and_belongs_to_the_process_counts(tmp_path):
    size = 64 << 20
    (tmp_path / "file").write_bytes(bytes(size))
    before = private_bytes("self")
    with (tmp_path / "file").open("rb") as file:
        mapped = mmap.mmap(file.fileno(), size, access=mmap.ACCESS_READ)
        assert sum(mapped[::4096]) == 0
        assert private_bytes(os.getpid()) - before < size / 2
        mapped.close()
    reserved = mmap.mmap(-1, size, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    assert private_bytes("self") - before < size / 2
    for place in range(0, size, 4096):
        reserved[place] = 1
    assert private_bytes("self") - before > size * 0.9
    reserved.close()
    assert private_bytes(0) is private_bytes("none") is None
