"""The recipes of docs/recipes run as printed. `make docs` runs them in notebooks as well."""

import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from colour import delta_E

ROOT = Path(__file__).parents[1]
RECIPES = ROOT / "docs" / "recipes"
CELL = re.compile(r"^```\{code-cell\}[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)

pytestmark = pytest.mark.slow


@pytest.fixture
def run(monkeypatch, tmp_path):
    """A function that runs the cells of a recipe with its paths, and returns their variables."""
    mpl.use("agg")
    for folder in ("examples", "gamutcore"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    monkeypatch.chdir(tmp_path)

    def variables(name):
        found = {}
        for number, cell in enumerate(CELL.findall((RECIPES / f"{name}.md").read_text()), 1):
            exec(compile(cell, f"{name}.md, cell {number}", "exec"), found)  # noqa: S102
        return found

    yield variables
    mpl.pyplot.close("all")


def test_every_recipe_is_run_here():
    tested = set(re.findall(r'run\("([\w-]+)"\)', Path(__file__).read_text()))
    assert {path.stem for path in RECIPES.glob("*.md")} == tested


def test_coverage_of_a_display(run):
    found = run("display-coverage")
    coverage, standards = found["coverage"], found["standards"]
    assert all(0 < share <= 1 for share in coverage.values())
    # Display P3 and Adobe RGB contain sRGB's red and blue, and Rec. 2020 nearly all of them.
    assert coverage["ITU-R BT.2020"] < min(coverage["sRGB"], coverage["Display P3"])
    for name, share in coverage.items():
        assert share <= found["display"].volume / standards[name].volume + 1e-3


def test_two_papers(run):
    found = run("two-papers")
    comparison = found["comparison"]
    assert found["uncoated"].volume < found["coated"].volume
    assert comparison.b_covers_a < comparison.a_covers_b <= 1
    union = comparison.volume_a + comparison.volume_b - comparison.intersection
    assert comparison.jaccard == pytest.approx(comparison.intersection / union)


def test_spot_colours(run):
    found = run("spot-colours")
    inside, near = found["inside"], found["near"]
    assert 0 < inside.sum() < len(inside)
    assert np.all(near.delta_e > 0)
    assert near.device.min() >= 0
    assert near.device.sum(axis=-1).max() <= 3.0 + 1e-6  # the ink limit
    # no vertex of the boundary is nearer, by the formula of another library
    vertices = found["press"].mesh(2000).vertices.astype(float)
    for colour, least in zip(found["lab"][found["outside"]], near.delta_e, strict=True):
        others = delta_E(np.broadcast_to(colour, vertices.shape), vertices, method="CIE 2000")
        assert least <= others.min() + 0.1


def test_mapping_a_picture(run):
    found = run("mapping-a-picture")
    press, rgb, inside = found["press"], found["rgb"], found["inside"]
    assert 0 < inside.mean() < 1
    for method, result in found["mapped"].items():
        # within the error of the level that answers
        assert press.distance(result.points, space="sRGB").max() < 0.2, method
        if method != "sgck":
            assert not result.moved[inside].any(), method
            assert np.abs(result.points - rgb)[inside].max() < 1e-6, method


def test_profile_and_measurements(run):
    found = run("profile-and-measurements")
    comparison, distance = found["comparison"], found["distance"]
    assert 0 < comparison.intersection <= min(comparison.volume_a, comparison.volume_b)
    assert distance.min() < 0 < distance.max()


def test_links_and_profiles(run):
    found = run("links-and-profiles")
    given, cube = found["picture"].reshape(-1, 3), found["cube"]
    np.testing.assert_allclose(
        found["shown"].reshape(-1, 3), cube.table.values(given), rtol=0, atol=1e-6
    )
    assert found["separation"].table.nodes.sum(axis=-1).max() <= 3.0 + 1e-5
    assert found["profile"].round_trip.mean < 0.3
    assert not list(Path().glob("*.icc"))


def test_picture_and_paper(run):
    found = run("picture-and-paper")
    papers, picture = found["papers"], found["picture"]
    shares = {name: paper.coverage_of(picture) for name, paper in papers.items()}
    assert 0 < shares["uncoated"] < shares["coated"] <= 1
