"""A saved gamut, and a function that runs a command line."""

import json

import pytest

from gamutcore.cli.app import app, run


@pytest.fixture(scope="session")
def saved(small_gamut, tmp_path_factory):
    path = tmp_path_factory.mktemp("gamuts") / "small.gamut"
    small_gamut.save(path)
    return str(path)


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
