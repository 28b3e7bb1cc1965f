from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation.columns import column_roles
from gamutcore.characterisation.table import (
    MAX_LINES,
    MAX_TEXT_VALUES,
    NumberTable,
    number,
    text_lines,
)
from gamutcore.errors import MalformedFileError, SampleLimitError

ROLES = column_roles(["LAB_L", "LAB_A", "LAB_B"])


@pytest.mark.parametrize(
    ("token", "value"),
    [("12.5", 12.5), ("12,5", 12.5), ("-.5", -0.5), ("+3", 3.0), ("1e-3", 0.001), ("7.", 7.0)],
)
def test_plain_decimal_numbers(token, value):
    assert number(token) == value


@pytest.mark.parametrize("token", ["nan", "inf", "1_0", "0x10", "", "1.2.3", "1,2,3", "--1"])
def test_other_tokens_are_no_numbers(token):
    with pytest.raises(ValueError, match=r".*"):
        number(token)


@given(st.floats(allow_nan=False, allow_infinity=False, width=32))
def test_a_written_number_is_read_back(value):
    assert number(repr(value)) == value


def test_lines_are_counted_with_any_mixture_of_line_ends():
    assert [n for n, _ in text_lines("a\rb\r\nc\nd")] == [1, 2, 3, 4]


def test_a_line_without_end_is_refused():
    with pytest.raises(MalformedFileError) as caught:
        list(text_lines("a\n" + "1 " * 600_000))
    assert caught.value.where == {"line": 2}


@pytest.mark.slow
def test_lines_without_end_are_refused():
    with pytest.raises(SampleLimitError):
        list(text_lines("\n" * (MAX_LINES + 1)))


@pytest.mark.parametrize("bad", ["x", "1_0", "12,x"])
def test_the_cell_at_fault_is_named(bad):
    table = NumberTable(ROLES)
    table.append(["1", "2", "3"], 10)
    table.append(["1", bad, "3"], 12)
    with pytest.raises(MalformedFileError) as caught:
        table.arrays()
    assert caught.value.where == {"line": 12, "column": 2, "field": "LAB_A"}


def test_blocks_are_joined_in_order():
    table = NumberTable(ROLES)
    for i in range(20_000):
        table.append([str(i), "0", "0,5"], i)
    values, lines = table.arrays()
    assert values[:, 0].tolist() == list(range(20_000))
    assert lines.tolist() == list(range(20_000))
    assert set(values[:, 2]) == {0.5}


def test_conditions_become_numbers():
    table = NumberTable(column_roles(["CONDITION", "L", "a", "b"]))
    for label in ("M1", "m0", "M1_Daylight"):
        table.append([label, "1", "2", "3"], 1)
    assert table.row_conditions == ("M1", "M0")
    assert table.arrays()[0][:, -1].tolist() == [0, 1, 0]


def filled(names, rows):
    table = NumberTable(column_roles(names))
    for line, row in enumerate(rows):
        table.append(row, line)


def test_conditions_without_end_are_refused():
    rows = ([f"run {number}", "1", "2", "3"] for number in range(1000))
    with pytest.raises(SampleLimitError, match="conditions"):
        filled(["CONDITION", "L", "a", "b"], rows)


@pytest.mark.slow
def test_numbers_are_limited_and_not_rows_alone():
    rows = itertools.repeat(["0.5"] * 900, MAX_TEXT_VALUES // 900 + 1)
    with pytest.raises(SampleLimitError, match="900 numbers"):
        filled([f"SPEC_{nm}" for nm in range(300, 1200)], rows)
