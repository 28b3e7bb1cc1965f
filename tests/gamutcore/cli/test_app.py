"""The program: help, version, completion, exit status, and errors as one line."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import typer

from gamutcore import Gamut
from gamutcore.cli.app import app
from gamutcore.questions import QUESTIONS
from gamutcore.version import __version__

COMMANDS = sorted(typer.main.get_command(app).commands)


def test_help_lists_all_commands_with_whole_sentences(command):
    shown, _ = command("--help")
    listed = shown.split("Commands:")[1].split("\n\n")[0]
    assert all(name in listed for name in COMMANDS)
    assert "..." not in listed
    assert "Exit status" in " ".join(shown.split())


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_with_the_options_of_builds(command, name):
    shown, _ = command(name, "--help")
    assert "Usage: gamut" in shown
    asked_most = [name for name in ("--ink-limit", "--intent", "--space") if name in shown]
    assert len(asked_most) == (0 if name == "reference" else 3)
    assert len(shown.splitlines()) <= 40
    assert max(map(len, shown.splitlines())) <= 80
    assert "--gamma VALUE" not in shown
    if name != "reference":
        whole, _ = command(name, "--help-all")
        assert "--gamma VALUE" in whole
        options = set(re.findall(r"^  (?:-o, )?(--[a-z-]+)", shown, re.MULTILINE))
        assert options < set(re.findall(r"^  (?:-o, )?(--[a-z-]+)", whole, re.MULTILINE))


def test_the_version_is_printed(command):
    assert command("--version")[0].strip() == __version__


class TestForms:
    """Results as text, JSON or CSV."""

    def test_texts_are_on_the_left_and_the_usual_ones_first(self, command):
        lines = command("reference")[0].splitlines()
        starts = {re.match(r"\S+ +(?=\S)", line).end() for line in lines}
        assert len(starts) == 1
        usual = [line.split()[0] for line in lines[1:6]]
        assert usual == ["srgb", "display-p3", "bt2020", "adobe-rgb-1998", "prophoto-rgb"]

    def test_numbers_are_on_the_right_with_units_and_without_a_negative_zero(self, command, cubes):
        shown, _ = command("slice", cubes / "large.gamut", "--lightness", 50)
        heading, *lines = shown.splitlines()
        assert heading.split() == ["polygon", "L*", "a*", "b*"]
        assert {len(line) for line in lines} == {len(heading)}
        assert all(re.fullmatch(r" +1( +-?\d+\.\d\d){3}", line) for line in lines)
        assert "-0.00" not in shown
        rings, _ = command("rings", cubes / "large.gamut", "--sectors", 2)
        assert "hue (°)" in rings.splitlines()[0]

    def test_missing_numbers_are_empty_cells_and_null(self, as_json, as_rows, cubes):
        """Beside the axis, most hues have no cusp."""
        asked = ("export", cubes / "beside.gamut", "--table", "cusps")
        chroma = as_json(*asked)["chroma"]
        assert chroma[0] == pytest.approx(70)
        assert chroma[180] is None
        cells = [row["chroma"] for row in as_rows(*asked, "--csv")]
        assert [cell == "" for cell in cells] == [value is None for value in chroma]

    def test_the_suffix_chooses_the_form_and_two_are_refused(self, command, saved, tmp_path):
        shown = json.loads(command("info", saved, "--json")[0])
        command("info", saved, "-o", tmp_path / "facts.json")
        assert json.loads((tmp_path / "facts.json").read_text()) == shown
        command("info", saved, "-o", tmp_path / "facts.csv")
        assert (tmp_path / "facts.csv").read_text().count("\n") == 2
        command("reference", "-o", tmp_path / "all.csv")
        assert (tmp_path / "all.csv").read_text().startswith("slug,")
        command("reference", "--json", "--csv", status=2)

    def test_a_suffix_of_no_form_is_refused(self, command, saved, tmp_path):
        _, told = command("info", saved, "-o", tmp_path / "facts.xlsx", status=2)
        assert "Give a name that ends in .txt, .json or .csv." in told
        assert not (tmp_path / "facts.xlsx").exists()


@pytest.mark.parametrize(
    ("arguments", "status", "told"),
    [
        (["info", "nothing.ti3"], 1, "nothing.ti3"),
        (["info", "srbg"], 2, "Did you mean srgb?"),
        (["info", "srgb", "--gamma", "7"], 2, "gamma"),
        (["info", "srgb", "--spaces", "Oklab"], 2, "--space"),
        (["info"], 2, "GAMUT"),
        (["inform"], 2, "info"),
        (["info", "pyproject.toml"], 1, "gamut: "),
        (["info", "coated"], 2, "no file of this name"),
    ],
)
def test_errors_are_one_line_with_a_remedy(command, arguments, status, told):
    out, err = command(*arguments, status=status)
    assert out == ""
    assert told.lower() in err.lower()
    assert len(err.strip().splitlines()[-1:]) == 1
    assert "Traceback" not in err


@pytest.mark.parametrize(
    "arguments",
    [
        ("build", "beside.csv", "--centre"),
        ("slice", "large.gamut", "--plane"),
        ("map", "beside.csv", "--gamut", "large.gamut", "--method", "clip-focal", "--focus"),
    ],
)
def test_numbers_are_separated_by_commas_or_spaces(command, cubes, monkeypatch, arguments):
    monkeypatch.chdir(cubes)
    rows = [f"{50 + 10 * x},{60 + 10 * y},{10 * z}" for x, y, z in np.ndindex(2, 2, 2)]
    Path("beside.csv").write_text("\n".join(["L,a,b", *rows]))
    numbers = ("1", "0", "0", "50") if "--plane" in arguments else ("55", "65", "5")
    shown = {command(*arguments, mark.join(numbers))[0] for mark in (",", " ", ", ")}
    assert len(shown) == 1


class TestDefects:
    """Errors that no one expected."""

    @pytest.fixture
    def broken(self, monkeypatch):
        """Let the command reference raise an error; return a function that chooses it."""

        def breaks(error):
            def fail(*_arguments, **_options):
                raise error

            monkeypatch.setattr("gamutcore.cli.gamuts.write_table", fail)

        return breaks

    @pytest.mark.parametrize(
        "error", [ZeroDivisionError("by\nzero"), AssertionError(), MemoryError()]
    )
    def test_an_unexpected_error_is_one_line_that_says_how_to_get_details(
        self, command, broken, monkeypatch, error
    ):
        broken(error)
        monkeypatch.delenv("GAMUTCORE_TRACEBACK", raising=False)
        out, err = command("reference", status=70)
        assert out == ""
        assert err.startswith(f"gamut: unexpected error: {type(error).__name__}")
        assert err.count("\n") == 1
        assert "GAMUTCORE_TRACEBACK=1" in err
        monkeypatch.setenv("GAMUTCORE_TRACEBACK", "1")
        _, err = command("reference", status=70)
        assert err.startswith("Traceback")
        assert err.splitlines()[-1].startswith("gamut: unexpected error: ")

    def test_an_interrupt_ends_the_program_without_a_word(self, command, broken):
        broken(KeyboardInterrupt())
        assert command("reference", status=130) == ("", "")


def test_an_option_of_a_gamut_that_is_built_is_refused(command, saved):
    _, err = command("info", saved, "--cost", "finest", status=2)
    assert "built already" in err


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
@pytest.mark.slow
def test_completion(shell):
    """As the installed script calls it, which does not depend on the shell that runs the tests."""
    typed = {
        "COMP_WORDS": "gamut que",
        "COMP_CWORD": "1",
        "_TYPER_COMPLETE_ARGS": "gamut que",
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
    }
    gamut = Path(sys.executable).with_name("gamut")
    script, words = (
        subprocess.run(
            [gamut],
            env={**os.environ, **typed, "_GAMUT_COMPLETE": f"{action}_{shell}"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for action in ("source", "complete")
    )
    assert f"complete_{shell}" in script
    assert "query" in words
    assert "slice" not in words


@pytest.mark.parametrize(
    ("name", "question"),
    [("query", "nearest"), ("compare", "comparisons")]
    + [(name, name) for name in ("map", "slice", "rings", "picture")],
)
def test_options_of_questions_have_the_declared_descriptions(command, name, question):
    """Also where a level is chosen, and where the option is a flag."""
    shown = "".join(command(name, "--help-all")[0].split())  # lines may break at hyphens
    described = {each.name: each.description for each in QUESTIONS[question].all_parameters}
    declared = {each: "".join(text.split()) for each, text in described.items()}
    own = {"space", "focus", "source", "reference"}  # what they mean differs in a shell
    assert [text for each, text in declared.items() if each not in own and text not in shown] == []


@pytest.mark.slow
def test_help_does_not_import_the_computation():
    """It is what makes `gamut --help` fast: 0.1 s of processor time."""
    code = (
        "import sys; from gamutcore.cli.app import app, run; run(app, ['--help']);"
        "print(sorted({'numpy', 'numba', 'rich', 'scipy'} & set(sys.modules)), file=sys.stderr)"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stderr.strip() == "[]"


NOTES = "notes.txt"

READERS = [
    ("info", NOTES),
    ("build", NOTES),
    ("mesh", NOTES, "-o", "x.ply"),
    ("export", NOTES),
    ("query", NOTES, "--gamut", "good.gamut"),
    ("query", "colours.csv", "--gamut", NOTES),
    ("recipe", NOTES, "--gamut", "good.gamut"),
    ("recipe", "colours.csv", "--gamut", NOTES),
    ("map", NOTES, "--gamut", "good.gamut"),
    ("map", "colours.csv", "--gamut", NOTES),
    ("map", "colours.csv", "--gamut", "good.gamut", "--method", "sgck", "--from", NOTES),
    ("map", "cut.png", "--gamut", "good.gamut", "-o", "x.png"),
    ("compare", "good.gamut", NOTES),
    ("slice", NOTES, "--lightness", "50"),
    ("rings", NOTES),
    ("rings", "good.gamut", "--reference", NOTES),
    ("picture", NOTES, "-o", "x.png"),
    ("link", NOTES, "srgb", "-o", "x.icc"),
    ("link", "srgb", NOTES, "-o", "x.icc"),
    ("profile", NOTES, "-o", "x.icc"),
    ("info", "cut.gamut"),
    ("profile", "cut.gamut", "-o", "x.icc"),
    ("link", "cut.gamut", "srgb", "-o", "x.icc"),
    ("mesh", "good.gamut", "-o", "x.icc", "--into", NOTES),
]


@pytest.mark.parametrize("line", READERS, ids=" ".join)
def test_a_file_that_cannot_be_read_is_named(command, saved, tmp_path, monkeypatch, line):
    monkeypatch.chdir(tmp_path)
    Path(NOTES).write_text("these are notes of a meeting\n")
    Path("colours.csv").write_text("L,a,b\n50,0,0\n")
    Path("good.gamut").write_bytes(Path(saved).read_bytes())
    Path("cut.gamut").write_bytes(Path(saved).read_bytes()[:5000])
    Path("cut.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
    _, err = command(*line, status=1)
    (name,) = {NOTES, "cut.gamut", "cut.png"} & set(line)
    assert f"(file {name}" in err.splitlines()[-1]


def test_an_option_that_a_file_refuses_is_named_with_the_file(command, cubes, tmp_path):
    path = tmp_path / "colours.csv"
    path.write_text("L,a,b\n" + "".join(f"{50 + x},{y},{z}\n" for x, y, z in CORNERS))
    for line in (("info", path), ("compare", cubes / "large.gamut", path)):
        _, err = command(*line, "--ink-limit", "300", status=2)
        assert f"(file {path})" in err


CORNERS = [(9 * x, 9 * y, 9 * z) for x, y, z in np.ndindex(2, 2, 2)]


def test_large_and_small_numbers_have_no_exponent(command, tmp_path):
    corners = np.array(list(np.ndindex(2, 2, 2))) - 0.5
    for edge, volume in ((200.0, "8000000"), (0.04, "0.000064")):
        path = tmp_path / "cube.gamut"
        gamut = Gamut(edge * corners + (50, 0, 0), gamma=1)
        gamut.save(path)
        shown, _ = command("info", path)
        (line,) = [line for line in shown.splitlines() if line.startswith("volume ")]
        assert line.split()[1].replace(",", "").startswith(volume[:5])
        assert not re.search(r"\de[+-]\d", shown + repr(gamut))
    _, err = command("mesh", path, "-o", tmp_path / "cube.ply")
    assert not re.search(r"\de[+-]\d", err)
