"""Kernels: IEEE arithmetic, calls from Python and from kernels, linking, and plain Python."""

import logging
import subprocess
import sys

import numpy as np
import pytest
from numba.core import config
from numba.core.compiler import Flags

from gamutcore.kernels import cache, inlined_kernel, kernel, leaf_kernel
from gamutcore.kernels.linking import ComparedFlags

DECORATORS = pytest.mark.parametrize("decorator", [kernel, leaf_kernel, inlined_kernel])


@DECORATORS
def test_division_by_zero_is_infinity_not_an_exception(decorator):
    @decorator
    def ratio(one, other):
        return one / other

    assert ratio(1.0, 0.0) == np.inf
    assert ratio(-1.0, 0.0) == -np.inf
    assert np.isnan(ratio(0.0, 0.0))


@DECORATORS
def test_sums_are_not_reordered_nor_nan_assumed_away(decorator):
    """Fast-math would do both."""

    @decorator
    def rounding(one, other):
        return (one + other) - one, one != one  # noqa: PLR0124

    assert rounding(1.0, 2.0**-60) == (0.0, False)
    assert rounding(np.nan, 1.0)[1]


@pytest.mark.slow
def test_chains_of_calls_and_of_numbas_own_functions_are_linked():
    @leaf_kernel
    def clip(x):
        return min(max(x, 0.0), 1.0)

    @leaf_kernel
    def smooth(x):
        t = clip(x)
        return t * t * (3.0 - 2.0 * t)

    @inlined_kernel
    def half(x):
        return 0.5 * max(smooth(x), clip(-x))

    @kernel
    def run(values):
        total = 0.0
        for value in values:
            total += half(value) + min(value, 0.0)
        return total, np.sort(values)

    total, ordered = run(np.array([2.0, 0.5, -3.0]))
    assert total == 0.5 + 0.25 + 0.5 - 3.0
    np.testing.assert_array_equal(ordered, [-3.0, 0.5, 2.0])


def test_a_long_compilation_is_announced_and_a_short_one_is_not(caplog, monkeypatch, tmp_path):
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path))

    @kernel
    def one(x):
        return x + 1

    with caplog.at_level(logging.WARNING):
        one(1)
    assert caplog.messages == []
    monkeypatch.setattr(cache, "LONG_COMPILATION", 0.0)
    with caplog.at_level(logging.WARNING):
        one(1.0)
    (message,) = caplog.messages
    assert f"{__name__}." in message
    assert str(tmp_path) in message
    caplog.clear()
    one(2.0)
    assert caplog.messages == []


@pytest.mark.slow
def test_runs_as_plain_python_where_compilation_is_disabled():
    code = """
import types
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel
for decorator in (kernel, leaf_kernel, inlined_kernel):
    assert isinstance(decorator(lambda x: x), types.FunctionType)
"""
    subprocess.run([sys.executable, "-c", code], check=True, env={"NUMBA_DISABLE_JIT": "1"})


@pytest.mark.parametrize("changed", [{}, {"error_model": "numpy"}, {"nrt": True}])
@pytest.mark.parametrize("stated", [{}, {"error_model": "python"}, {"error_model": "numpy"}])
def test_options_are_compared_as_numba_compares_them(stated, changed):
    """An option that is left out has its default."""
    one, other = Flags(), Flags()
    for flags, values in ((one, stated), (other, changed)):
        for name, value in values.items():
            setattr(flags, name, value)
    for first, second in ((ComparedFlags(one), ComparedFlags(other)), (ComparedFlags(one), other)):
        assert (first == second) == (second == first) == (one == other)
        assert hash(first) == hash(second) == hash(one)
