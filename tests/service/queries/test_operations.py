import numpy as np
import pytest

from service.queries.operations import LEVEL_PARAMETERS, OPERATIONS


@pytest.mark.parametrize("name", OPERATIONS)
def test_entries_are_consistent(name):
    operation = OPERATIONS[name]
    assert operation.name == name
    names = [each.name for each in operation.all_parameters]
    assert len(set(names)) == len(names)
    assert operation.all_parameters[: len(LEVEL_PARAMETERS)] == LEVEL_PARAMETERS
    columns = {column.name for column in operation.columns}
    assert operation.answered.keys() <= columns
    assert not columns & {"level", "row", *operation.inputs}
    assert set(operation.inputs) <= operation.example.keys()
    assert operation.example.keys() <= {*operation.inputs, *names}
    for each in operation.all_parameters:
        for value in (each.default, each.example):
            if value is not None:
                each.checked(value, "body")


@pytest.mark.parametrize("name", OPERATIONS)
def test_columns_have_one_entry_per_row(name, cube):
    operation = OPERATIONS[name]
    values = {each.name: each.default for each in operation.all_parameters}
    colours = np.random.default_rng(0).uniform(-30, 30, (50, 3)) + np.array([50, 0, 0])
    result = operation.answer(cube, [colours] * len(operation.inputs), values)
    assert result.columns.keys() <= {column.name for column in operation.columns}
    entries = 50 if result.offsets is None else result.offsets[-1]
    for column in result.columns.values():
        assert len(column) == entries
