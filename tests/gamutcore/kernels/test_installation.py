"""Stamps say whether an installation's kernels are compiled; each group compiles once."""

import os
import subprocess
import sys

import numpy as np
import pytest
from numba.core import config

from gamutcore.kernels import KERNELS, kernel, load_kernels
from gamutcore.kernels import cache as installation

EMPTY = pytest.mark.usefixtures("cache")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path))
    return tmp_path


@EMPTY
def test_a_stamp_holds_for_the_present_sources(monkeypatch):
    assert not installation.is_compiled("default")
    installation.mark_compiled("default")
    assert installation.is_compiled("default")
    assert not installation.is_compiled("optional")
    monkeypatch.setattr(installation, "_sources", lambda: "changed")
    assert not installation.is_compiled("default")


@EMPTY
def test_a_stamp_holds_for_one_processor(monkeypatch):
    installation.mark_compiled("default")
    monkeypatch.setattr(installation, "_processor", lambda: ("another", "processor", ""))
    assert not installation.is_compiled("default")


@EMPTY
def test_a_stamp_of_generic_code_that_came_along_holds(cache, monkeypatch):
    own = installation._processor()
    shipped = cache / "shipped"
    monkeypatch.setattr(installation, "SHIPPED", shipped)
    with monkeypatch.context() as patch:
        patch.setattr(installation, "_processor", lambda: (own[0], "generic", ""))
        installation.mark_compiled("default")
    (stamp,) = cache.rglob("*.stamp")
    shipped.mkdir()
    stamp.rename(shipped / stamp.name)
    assert installation.is_compiled("default")
    monkeypatch.setattr(installation, "VERSIONS", "numba 0.1 numpy 2 cpython-311")
    assert not installation.is_compiled("default")
    assert "machine code for numba" not in installation._shipped_note()
    monkeypatch.setattr(installation.numba, "__version__", "0.1")
    installation._shipped_note.cache_clear()
    assert "machine code for numba" in installation._shipped_note()


@EMPTY
def test_where_nothing_can_be_written_nothing_is_compiled(monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    monkeypatch.setattr(subprocess, "Popen", None)
    assert not installation.stamps_can_be_kept()
    installation.ensure_compiled("default")
    assert not installation.is_compiled("default")


@pytest.mark.slow
def test_a_missing_group_is_compiled_by_another_process(cache, monkeypatch):
    code = (
        "from numba.core import config\n"
        f"config.CACHE_DIR = {str(cache)!r}\n"
        "from gamutcore.kernels import compilation_lock, is_compiled, mark_compiled\n"
        "with compilation_lock('optional'):\n"
        "    assert not is_compiled('optional')\n"
        "    mark_compiled('optional')\n"
    )
    monkeypatch.setattr(installation, "compile_command", lambda _: [sys.executable, "-c", code])
    installation.ensure_compiled("optional")
    assert installation.is_compiled("optional")
    # a second one would fail
    installation.ensure_compiled("optional")


@pytest.mark.slow
def test_a_compilation_ends_with_the_process_that_wants_it():
    command = [sys.executable, "-m", "gamutcore.warm", "--while-stdin-is-open", "default"]
    environment = {**os.environ, "NUMBA_CACHE_DIR": "/dev/null/nowhere"}
    ended = subprocess.run(command, check=False, env=environment, stdin=subprocess.DEVNULL)
    assert ended.returncode == 1


@EMPTY
@pytest.mark.slow
def test_loading_takes_all_signatures_from_the_cache():
    def double(x):
        return 2 * x

    first = kernel(double)
    first(1)
    first(np.ones(2))
    second = kernel(double)
    assert not second.signatures
    try:
        assert second.load()
        assert load_kernels((double.__module__,)) >= 1
        assert len(second.signatures) == 2
        assert second(4) == 8
        assert sum(second.stats.cache_misses.values()) == 0
    finally:
        del KERNELS[-2:]
