"""Saved gamuts, and functions that run a command line."""

import csv
import io
import json

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.cli.app import app, run


@pytest.fixture(scope="session")
def saved(small_gamut, tmp_path_factory):
    path = tmp_path_factory.mktemp("gamuts") / "small.gamut"
    small_gamut.save(path)
    return str(path)


@pytest.fixture(scope="session")
def cubes(tmp_path_factory):
    """Return a folder with cubes of edge 40 and 20 about L* 50, and a small one beside the axis."""
    folder = tmp_path_factory.mktemp("cubes")
    unit = 2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1
    for name, half, a in (("large", 20, 0), ("small", 10, 0), ("beside", 10, 60)):
        Gamut(half * unit + (50, a, 0), gamma=1).save(folder / f"{name}.gamut")
    return folder


@pytest.fixture
def command(capsys):
    """Run a command line; return its status, standard output and standard error."""

    def call(*arguments, status=0):
        ended = run(app, list(map(str, arguments)))
        out, err = capsys.readouterr()
        assert ended == status, err
        return out, err

    return call


@pytest.fixture
def as_json(command):
    return lambda *arguments: json.loads(command(*arguments, "--json")[0])


@pytest.fixture
def as_rows(command):
    """Run a command line whose output is CSV; return its rows."""
    return lambda *arguments: list(csv.DictReader(io.StringIO(command(*arguments)[0])))
