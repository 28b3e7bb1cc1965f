"""A service compiles its kernels in processes of their own, and says how far that is."""

import asyncio
import logging
import subprocess
import sys
import time

import pytest

from gamutcore import reference
from service.building import kernels
from service.building.kernels import Kernels

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
    asyncio.run(asyncio.wait_for(made.prepare(), 60))


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
        deadline = time.monotonic() + 60
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

    asyncio.run(asyncio.wait_for(scenario(), 120))


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
from gamutcore.kernels.decorators import KERNELS
from gamutcore.metric.level_search import Bounds, LevelSearch
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
search.find(gamut.history, Bounds(distance=0.5))
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
