"""Entry points hold all that they call, optimised once, and nothing else."""

import numpy as np
import pytest
from numba.core import config
from numba.core.compiler import Flags

from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.kernels.linking import ComparedFlags


@pytest.fixture
def library(tmp_path, monkeypatch):
    """The library of a kernel that has just been compiled, and calls another one."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path))

    @leaf_kernel
    def weight(x):
        return 1.0 / (1.0 + x * x)

    @kernel
    def weigh(values):
        total = 0.0
        for value in values:
            total += weight(value)
        return total

    assert weigh(np.ones(3)) == 1.5
    (compiled,) = weigh.overloads.values()
    return compiled.library


def test_inlined_subroutines_leave_no_code_of_their_own(library):
    defined = [function.name for function in library.get_defined_functions()]
    assert any("weigh" in name for name in defined)
    assert not any("weight" in name for name in defined)


def test_the_cache_keeps_machine_code_and_no_ir_to_link(library):
    _name, kind, (code, stubs) = library.serialize_using_object_code()
    assert kind == "object"
    assert code[:4] in {b"\x7fELF", b"\xcf\xfa\xed\xfe"}
    assert len(stubs) < len(code)


def test_a_subroutine_has_no_machine_code_until_python_calls_it():
    @leaf_kernel
    def third(x):
        return x / 3.0

    @kernel
    def thirds(x):
        return third(x) + third(2.0 * x)

    assert thirds(1.0) == 1.0
    assert not third.overloads
    assert third(6.0) == 2.0
    assert third.overloads


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
