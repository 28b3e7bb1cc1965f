"""A fingerprint changes with the code that a kernel reaches, and with nothing else."""

import types

import numpy as np
import pytest

from gamutcore.kernels import kernel
from gamutcore.kernels.fingerprint import fingerprint, reached_functions

SOURCE = '''
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
    assert fingerprint(made(SOURCE)) != fingerprint(made(SOURCE.replace(old, new)))


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
    assert old in SOURCE
    assert fingerprint(made(SOURCE)) == fingerprint(made(SOURCE.replace(old, new)))


def test_reaches_kernels_once_through_chains_and_modules():
    functions = reached_functions(made(SOURCE))
    assert sorted(function.__name__ for function in functions) == ["limited", "run"]


def test_survives_recursion():
    @kernel
    def count(n):
        return 0 if n == 0 else 1 + count(n - 1)

    assert len(fingerprint(count.py_func)) == 32
    assert [each.__name__ for each in reached_functions(count.py_func)] == ["count"]


def test_of_numpy_only_the_version_counts(monkeypatch):
    before = fingerprint(made(SOURCE))
    monkeypatch.setattr(np, "__version__", "0.0.0")
    assert fingerprint(made(SOURCE)) != before
