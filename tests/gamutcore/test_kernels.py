"""Compiled kernels: IEEE arithmetic, and a cache that sees changes and needs no writable folder."""

import importlib.util
import os
import shutil
import sys

import numpy as np
import pytest
from numba.core import config

from gamutcore import kernels
from gamutcore.kernels import KernelCacheLocator, kernel, leaf_kernel, package_digest

SOURCE = """
from gamutcore.kernels import kernel

@kernel
def doubled(values):
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
def module(tmp_path):
    """Return a function that loads a fresh copy of a module with one kernel."""
    path = tmp_path / "folder" / "made_up.py"
    path.parent.mkdir()
    path.write_text(SOURCE)

    def load():
        spec = importlib.util.spec_from_file_location("made_up", path)
        loaded = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loaded)
        return loaded

    return load


def hits(compiled):
    return sum(compiled.stats.cache_hits.values())


def index_files(folder):
    return sorted(folder.rglob("*.nbi"))


class TestArithmetic:
    @pytest.mark.parametrize("decorator", [kernel, leaf_kernel])
    def test_division_by_zero_is_infinity_not_an_exception(self, decorator):
        @decorator
        def ratio(one, other):
            return one / other

        assert ratio(1.0, 0.0) == np.inf
        assert ratio(-1.0, 0.0) == -np.inf
        assert np.isnan(ratio(0.0, 0.0))

    @pytest.mark.parametrize("decorator", [kernel, leaf_kernel])
    def test_sums_are_not_reordered_nor_nan_assumed_away(self, decorator):
        """What fast-math would do to both."""

        @decorator
        def rounding(one, other):
            return (one + other) - one, one != one  # noqa: PLR0124

        assert rounding(1.0, 2.0**-60) == (0.0, False)
        assert rounding(np.nan, 1.0)[1]

    @pytest.mark.parametrize("decorator", [kernel, leaf_kernel])
    def test_the_interpreters_lock_is_released(self, decorator):
        @decorator
        def nothing():
            return 0

        assert nothing.targetoptions["nogil"]
        assert not nothing.targetoptions.get("fastmath")


class TestCache:
    def test_lies_beside_the_source(self, module, tmp_path, monkeypatch):
        monkeypatch.setattr(config, "CACHE_DIR", "")
        first = module().doubled
        np.testing.assert_array_equal(first(np.ones(2)), 2.0)
        assert hits(first) == 0
        (written,) = index_files(tmp_path)
        assert written.parent == tmp_path / "folder" / "__pycache__"
        second = module().doubled
        np.testing.assert_array_equal(second(np.ones(2)), 2.0)
        assert hits(second) == 1

    def test_goes_where_numba_is_told_to_put_it(self, module, tmp_path, monkeypatch):
        monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "elsewhere"))
        module().doubled(np.ones(2))
        (written,) = index_files(tmp_path)
        assert tmp_path / "elsewhere" in written.parents

    def test_a_change_of_any_kernel_makes_it_stale(self, module, monkeypatch):
        monkeypatch.setattr(config, "CACHE_DIR", "")
        module().doubled(np.ones(2))
        monkeypatch.setattr(kernels, "package_digest", lambda: b"changed")
        again = module().doubled
        np.testing.assert_array_equal(again(np.ones(2)), 2.0)
        assert hits(again) == 0

    def test_is_read_where_it_cannot_be_written(self, module, tmp_path, monkeypatch):
        monkeypatch.setattr(config, "CACHE_DIR", "")
        module().doubled(np.ones(2))
        monkeypatch.setattr(os, "access", lambda *_: False)
        again = module().doubled
        again(np.ones(2))
        assert hits(again) == 1
        # another signature is compiled, and not kept
        files = set(tmp_path.rglob("*.nb*"))
        np.testing.assert_array_equal(again(np.ones((2, 2))), 2.0)
        assert set(tmp_path.rglob("*.nb*")) == files

    def test_is_compiled_anew_where_it_names_a_module_that_is_gone(
        self, module, tmp_path, monkeypatch
    ):
        """A kernel that was compiled for a type of another module, which is then deleted."""
        monkeypatch.setattr(config, "CACHE_DIR", "")
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
        for hit in (0, 1):
            again = module().total
            assert again((1.0, 2.0)) == 3.0
            assert hits(again) == hit

    @pytest.mark.parametrize("kind", ["nbi", "nbc"])
    @pytest.mark.parametrize("content", [b"", b"\x80\x05garbage", None])
    def test_is_compiled_anew_where_a_file_is_damaged(
        self, module, tmp_path, monkeypatch, kind, content
    ):
        """None: cut in the middle."""
        monkeypatch.setattr(config, "CACHE_DIR", "")
        module().doubled(1.0)
        (path,) = tmp_path.rglob(f"*doubled*.{kind}")
        whole = path.read_bytes()
        path.write_bytes(whole[: len(whole) // 2] if content is None else content)
        for hit in (0, 1):
            again = module().doubled
            assert again(1.0) == 2.0
            assert hits(again) == hit

    def test_functions_of_one_name_are_told_apart(self):
        def one():
            """One."""

        def other():
            """Another."""

        locators = [
            KernelCacheLocator.from_function(function, __file__) for function in (one, other)
        ]
        assert len({locator.get_disambiguator() for locator in locators}) == 2
        assert {locator.get_source_stamp() for locator in locators} == {package_digest()}


class TestDigest:
    @pytest.fixture
    def copy(self, tmp_path, monkeypatch):
        """Return a copy of the package that the digest is taken of."""
        folder = tmp_path / "gamutcore"
        shutil.copytree(kernels.PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__"))
        monkeypatch.setattr(kernels, "PACKAGE", folder)
        return folder

    def test_does_not_depend_on_where_the_package_lies(self, copy):
        assert copy.is_dir()
        assert package_digest.__wrapped__() == package_digest()

    def test_changes_with_a_module_that_kernels_of_others_call(self, copy):
        before = package_digest.__wrapped__()
        path = copy / "star_shape.py"
        path.write_text(path.read_text().replace("2.0**-44", "2.0**-43"))
        assert package_digest.__wrapped__() != before

    def test_does_not_change_with_one_that_has_no_kernels(self, copy):
        before = package_digest.__wrapped__()
        path = copy / "errors.py"
        path.write_text(path.read_text() + "\n# changed\n")
        assert package_digest.__wrapped__() == before
