import numpy as np
import pytest

from gamutcore import Gamut
from service.queries.levels import QueryLevel
from service.queries.operations import Column, Operation, Result

CUBE = np.array(list(np.ndindex(2, 2, 2)), np.float64) * 20 - 10


@pytest.fixture(scope="session")
def cube():
    """The level of a cube: 40 to 60, and -10 to 10 twice."""
    gamut = Gamut(CUBE + np.array([50, 0, 0]))
    level = gamut.levels.indexed(12)
    return QueryLevel(gamut, level.triangles, 0.5)


def _sums(_level, inputs, values):
    total = sum(points.sum(axis=1) for points in inputs)
    return Result({"sum": total * values["factor"], "first": inputs[0] * 1.0})


def _repeats(_level, inputs, _values):
    """As many entries per row as the first coordinate says."""
    counts = inputs[0][:, 0].astype(int)
    offsets = np.concatenate([[0], np.cumsum(counts)])
    entries = np.concatenate([np.arange(count) for count in counts] or [np.zeros(0, int)])
    return Result({"t": entries.astype(float), "entering": entries % 2 == 0}, offsets)


@pytest.fixture(scope="session")
def sums():
    """An operation with two colours per row, a parameter and a column with parts."""
    from gamutcore.option_types import Number
    from service.queries.parameters import Parameter

    columns = (
        Column("sum", "The sum.", {"type": "number"}),
        Column("first", "The first.", {"type": "array"}, "axes"),
    )
    return Operation(
        "sums",
        "sumColours",
        "Sum",
        "Sums.",
        (Parameter("factor", (Number(0, 10),), "A factor.", 1.0),),
        columns,
        _sums,
        {"from": [[1, 2, 3]], "to": [[4, 5, 6]]},
        {"sum": [21], "first": [[1, 2, 3]]},
        ("from", "to"),
    )


@pytest.fixture(scope="session")
def repeats():
    """An operation whose rows have several entries."""
    columns = (
        Column("t", "The entry.", {"type": "number"}),
        Column("entering", "Whether it is even.", {"type": "boolean"}),
    )
    return Operation(
        "repeats", "repeatColours", "R", "Repeats.", (), columns, _repeats, {"colours": []}, {}
    )
