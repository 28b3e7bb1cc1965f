"""The cache of machine code sees changes, needs no writable folder and survives damage."""

import importlib.util
import shutil
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from numba.core import config

from gamutcore.kernels import cache
from gamutcore.kernels.cache import fingerprint

SOURCE = """
from gamutcore.kernels import kernel

@kernel
def double(values):
    return 2.0 * values

@kernel
def total(pair):
    return pair[0] + pair[1]
"""

OTHER = """
from typing import NamedTuple

class Pair(NamedTuple):
    one: float
    other: float
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Return a function that loads a fresh copy of a module with kernels, cached beside it."""
    monkeypatch.setattr(config, "CACHE_DIR", "")
    path = tmp_path / "folder" / "made_up.py"
    path.parent.mkdir()
    path.write_text(SOURCE)

    def load():
        importlib.invalidate_caches()
        spec = importlib.util.spec_from_file_location("made_up", path)
        loaded = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loaded)
        return loaded

    load.path = path
    return load


def hits(compiled):
    return sum(compiled.stats.cache_hits.values())


@pytest.mark.slow
def test_lies_beside_the_source(module, tmp_path):
    first = module().double
    np.testing.assert_array_equal(first(np.ones(2)), 2.0)
    assert hits(first) == 0
    (written,) = tmp_path.rglob("*.nbc")
    assert written.parent == tmp_path / "folder" / "__pycache__"
    second = module().double
    np.testing.assert_array_equal(second(np.ones(2)), 2.0)
    assert hits(second) == 1


@pytest.mark.slow
def test_an_edit_of_the_kernel_makes_its_entry_stale(module):
    module().double(np.ones(2))
    # of another length: Python's own cache of bytecode goes by size and time
    module.path.write_text(SOURCE.replace("2.0 * values", "3.0 * values + 0.0"))
    again = module().double
    np.testing.assert_array_equal(again(np.ones(2)), 3.0)
    assert hits(again) == 0


@pytest.mark.slow
def test_is_read_where_it_cannot_be_written(module, tmp_path, monkeypatch):
    module().double(np.ones(2))

    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(Path, "write_bytes", refuse)
    again = module().double
    again(np.ones(2))
    assert hits(again) == 1
    # another signature is compiled, and not kept
    files = set(tmp_path.rglob("*.nb*"))
    np.testing.assert_array_equal(again(np.ones((2, 2))), 2.0)
    assert set(tmp_path.rglob("*.nb*")) == files


@pytest.mark.slow
def test_generic_code_that_came_with_the_installation_is_used(module, tmp_path, monkeypatch):
    shipped = tmp_path / "shipped"
    shipped.mkdir()
    own = cache._processor()
    with monkeypatch.context() as patch:
        patch.setattr(cache, "_processor", lambda: (own[0], "generic", ""))
        module().double(np.ones(2))
    (entry,) = tmp_path.rglob("*.nbc")
    entry.rename(shipped / entry.name)
    monkeypatch.setattr(cache, "SHIPPED", shipped)
    again = module().double
    np.testing.assert_array_equal(again(np.ones(2)), 2.0)
    assert hits(again) == 1
    assert module().double.load()


@pytest.mark.slow
def test_lies_in_the_cache_of_the_user_where_the_package_cannot_be_written(
    module, tmp_path, monkeypatch
):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    monkeypatch.setattr(cache, "_is_writable", lambda _: False)
    module().double(np.ones(2))
    (written,) = tmp_path.rglob("*.nbc")
    assert tmp_path / "home" in written.parents
    again = module().double
    again(np.ones(2))
    assert hits(again) == 1


def test_an_entry_that_names_a_module_that_is_gone_is_no_obstacle(module, tmp_path, monkeypatch):
    """A kernel compiled for a type of another module, which is then deleted."""
    monkeypatch.syspath_prepend(str(tmp_path))
    other = tmp_path / "gone_tomorrow.py"
    other.write_text(OTHER)
    gone = importlib.import_module("gone_tomorrow")
    first = module().total
    assert first(gone.Pair(1.0, 2.0)) == first((1.0, 2.0)) == 3.0
    again = module().total
    assert again((1.0, 2.0)) == 3.0
    assert hits(again) == 1

    other.unlink()
    shutil.rmtree(tmp_path / "__pycache__", ignore_errors=True)
    monkeypatch.delitem(sys.modules, "gone_tomorrow")
    importlib.invalidate_caches()
    again = module().total
    assert again((1.0, 2.0)) == 3.0
    assert hits(again) == 1
    assert again.load()


@pytest.mark.parametrize("content", [b"", b"\x80\x05garbage", None])
@pytest.mark.slow
def test_is_compiled_again_where_a_file_is_damaged(module, tmp_path, content):
    """None: cut in the middle."""
    module().double(1.0)
    (path,) = tmp_path.rglob("double*.nbc")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if content is None else content)
    for hit in (0, 1):
        again = module().double
        assert again(1.0) == 2.0
        assert hits(again) == hit


CODE = '''
import numpy as np
from gamutcore.kernels import kernel, leaf_kernel

LIMIT = 2.0
TABLE = np.array([1.0, 2.0])

@leaf_kernel
def limited(x):
    """Limit."""
    return min(x, LIMIT)

@leaf_kernel
def unused(x):
    return x

@kernel
def run(values):
    """Run."""
    total = TABLE[0]
    for value in values:  # all of them
        total += limited(value)
    return total
'''


def made(source):
    module = types.ModuleType("made_up")
    exec(compile(source, "made_up.py", "exec"), vars(module))  # noqa: S102
    return module.run.py_func


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("LIMIT = 2.0", "LIMIT = 2.5"),
        ("[1.0, 2.0]", "[1.0, 3.0]"),
        ("min(x, LIMIT)", "max(x, LIMIT)"),
        ("total += ", "total -= "),
        ("limited(value)", "unused(value)"),
        ("@leaf_kernel\ndef limited", "@kernel\ndef limited"),
    ],
)
def test_changes_with(old, new):
    assert fingerprint(made(CODE)) != fingerprint(made(CODE.replace(old, new)))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("  # all of them", "  # each of them"),
        ('"""Limit."""', '"""Another docstring."""'),
        ('"""Run."""', '"""Another docstring."""'),
        ("\n@leaf_kernel\ndef unused", "\n\n\n@leaf_kernel\ndef unused"),
        ("    return x\n", "    return x + 1.0\n"),
    ],
)
def test_does_not_change_with(old, new):
    assert old in CODE
    assert fingerprint(made(CODE)) == fingerprint(made(CODE.replace(old, new)))


@pytest.mark.slow
def test_an_entry_holds_for_the_same_versions(module, monkeypatch):
    module().double(1.0)
    monkeypatch.setattr(cache, "VERSIONS", "numpy 0.0.0")
    again = module().double
    assert again(1.0) == 2.0
    assert hits(again) == 0


@pytest.mark.slow
def test_an_entry_holds_for_one_processor(module, monkeypatch):
    module().double(1.0)
    again = module().double
    with monkeypatch.context() as context:
        context.setattr(cache, "_processor", lambda: ("another", "processor", ""))
        assert not again.load()
    assert again.load()
