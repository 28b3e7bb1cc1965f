"""Gamuts as arguments: files, saved gamuts, references, and the options of each."""

import json

import pytest


def test_a_file_is_built_with_the_options(as_json, tmp_path):
    corners = "".join(f"{50 + x},{y},{z}\n" for x in (0, 9) for y in (0, 9) for z in (0, 9))
    path = tmp_path / "cube.csv"
    path.write_text("L,a,b\n" + corners)
    options = as_json("info", path, "--space", "oklab", "--cost", "quadric", "--gamma", "1")[
        "options"
    ]
    assert (options["space"], options["cost"], options["gamma"]) == ("Oklab", "quadric", 1.0)


@pytest.mark.slow
def test_a_reference_leaves_out_options_of_the_other_gamut(command, saved):
    few = ("--surface-samples", "500")
    out, _ = command("compare", saved, "srgb", *few, "--ink-limit", "300", "--json")
    assert json.loads(out)["volume_b"] > 700_000
    command("info", "srgb", *few, "--ink-limit", "300", status=2)


def test_a_name_that_is_neither(command):
    _, err = command("info", "coated", status=2)
    assert "no file of this name" in err.lower()
