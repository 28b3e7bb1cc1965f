"""Results as text, JSON or CSV."""

import json

import numpy as np
import pytest
import typer

from gamutcore.cli.output import write_facts, write_table

TABLE = {"name": ["a", "b"], "in": [np.True_, np.False_], "value": [1.5, float("nan")]}


def test_csv_has_empty_cells_for_nan(capsys):
    write_table(TABLE, None, as_json=False, as_csv=True)
    assert capsys.readouterr().out == "name,in,value\na,true,1.5\nb,false,\n"


def test_json_has_one_array_for_each_column(capsys):
    write_table(TABLE, None, as_json=True, as_csv=False)
    assert json.loads(capsys.readouterr().out) == {
        "name": ["a", "b"],
        "in": [True, False],
        "value": [1.5, None],
    }


def test_text_is_aligned(capsys):
    write_table(TABLE, None, as_json=False, as_csv=False)
    assert len(set(map(len, capsys.readouterr().out.splitlines()))) == 1


def test_the_suffix_chooses_the_form(tmp_path):
    write_facts({"volume": 1.0}, tmp_path / "facts.json", as_json=False)
    assert json.loads((tmp_path / "facts.json").read_text()) == {"volume": 1.0}
    write_facts({"volume": 1.0}, tmp_path / "facts.csv", as_json=False)
    assert (tmp_path / "facts.csv").read_text() == "volume\n1\n"


def test_two_forms_are_refused():
    with pytest.raises(typer.BadParameter):
        write_table(TABLE, None, as_json=True, as_csv=True)
