"""Many gamuts: boxes whose overlaps are products of lengths, and stored gamuts."""

import csv
import io
import json
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest

import gamutcore
from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.reports import match_report, matrix_report

BOXES = {
    "wide": ((40.0, 60.0), (-30.0, 30.0), (-10.0, 10.0)),
    "high": ((20.0, 80.0), (-10.0, 10.0), (-10.0, 10.0)),
    "deep": ((40.0, 60.0), (-10.0, 10.0), (-30.0, 30.0)),
    "small": ((45.0, 55.0), (-5.0, 5.0), (-5.0, 5.0)),
}


@pytest.fixture(scope="module")
def boxes():
    gamuts = []
    for name, sides in BOXES.items():
        gamut = gamutcore.Gamut(list(product(*sides)))
        gamut.name = name
        gamuts.append(gamut)
    return gamuts


@pytest.fixture(scope="module")
def saved(boxes, tmp_path_factory):
    folder = tmp_path_factory.mktemp("gamuts")
    for gamut in boxes:
        gamut.save(folder / f"{gamut.name}.gamut")
    return [folder / f"{name}.gamut" for name in BOXES]


COLOURS = np.random.default_rng(0).uniform((15, -35, -35), (85, 35, 35), (200, 3))


def signed_distance(points, sides):
    """Return the signed distance from a box: Quilez's formula, independent of the program."""
    low, high = np.array(sides).T
    away = np.abs(points - (low + high) / 2) - (high - low) / 2
    outside = np.linalg.norm(np.maximum(away, 0), axis=1)
    return outside + np.minimum(away.max(axis=1), 0)


def test_positions_are_those_of_boxes(boxes):
    found = gamutcore.match(COLOURS, boxes, delta_e=False)
    exact = np.stack([signed_distance(COLOURS, sides) for sides in BOXES.values()], axis=1)
    assert found.gamuts == tuple(BOXES)
    assert np.allclose(found.distance, exact, atol=1e-3)
    assert (found.prints == (exact <= 1.0)).all()
    assert np.allclose(found.share, (exact <= 1.0).mean(axis=0))
    assert (found.printed_by == (exact <= 1.0).sum(axis=1)).all()


def test_the_best_groups_are_those_of_brute_force(boxes):
    found = gamutcore.match(COLOURS, boxes, delta_e=False)
    assert found.delta_e is None
    for group, size in zip(found.together, (2, 3), strict=True):
        most = max(
            found.prints[:, list(chosen)].any(axis=1).sum()
            for chosen in combinations(range(len(boxes)), size)
        )
        assert (len(group.gamuts), group.printed, group.exact) == (size, most, True)


def test_many_gamuts_are_grouped_greedily_and_the_report_says_so(boxes):
    found = gamutcore.match(COLOURS[:20], boxes * 6, delta_e=False)
    assert not found.together[0].exact
    assert "wide (2)" in found.gamuts
    assert "one gamut at a time" in match_report(found).to_text()


@pytest.mark.slow  # compiles CIEDE2000, as other slow tests do
def test_a_tolerance_in_ciede2000_passes_more(boxes):
    found = gamutcore.match(COLOURS, boxes, passing=5)
    assert ((found.delta_e == 0) == (found.distance <= 1e-3)).all()
    assert (found.prints == (found.delta_e <= 5)).all()
    expected = boxes[0].nearest(COLOURS, metric="CIE 2000").delta_e
    outside = found.distance[:, 0] > 1
    assert np.allclose(found.delta_e[outside, 0], expected[outside], atol=0.05)


@pytest.mark.parametrize("delta_e", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_stored_gamuts_answer_as_open_ones_do(boxes, saved, delta_e):
    stored, whole = (gamutcore.match(COLOURS, gamuts, delta_e=delta_e) for gamuts in (saved, boxes))
    assert np.array_equal(stored.distance, whole.distance)
    assert json.dumps(stored.to_dict()) == json.dumps(whole.to_dict())


def test_only_the_beginning_of_a_file_is_read(tmp_path):
    gamut = gamutcore.reference("srgb", surface_samples=1000)
    path = tmp_path / "srgb.gamut"
    gamut.save(path)
    expected = gamutcore.match(COLOURS, [path], max_error=5, delta_e=False).distance
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    found = gamutcore.match(COLOURS, [path], max_error=5, delta_e=False)
    assert np.array_equal(found.distance, expected)


def test_coverage_is_that_of_boxes(boxes):
    matrix = gamutcore.compare_all(iter(boxes), max_error=0)
    low, high = np.array(list(BOXES.values())).transpose(2, 0, 1)
    sides = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    common = np.maximum(sides, 0).prod(axis=2)
    assert np.allclose(matrix.intersection, common, rtol=1e-3)
    assert np.allclose(matrix.coverage, common / common.diagonal(), rtol=1e-3)


def test_srgb_is_wholly_inside_bt2020():
    matrix = gamutcore.compare_all(["srgb", "bt2020"], surface_samples=1000, max_error=0.5)
    assert matrix.gamuts == ("srgb", "bt2020")
    assert matrix.coverage[1, 0] > 0.995
    assert matrix.coverage[0, 1] < 0.5


def test_what_cannot_be_matched_is_refused(boxes):
    for options in ({}, {"surface_samples": 600}):
        with pytest.raises(OptionError, match="at least one"):
            gamutcore.match(COLOURS, [], **options)
    for one in (boxes[0], "srgb", Path("presses")):
        with pytest.raises(OptionError, match="a list of gamuts"):
            gamutcore.match(COLOURS, one)
    with pytest.raises(OptionError, match="at least two"):
        gamutcore.compare_all(boxes[:1])
    with pytest.raises(OptionError):
        gamutcore.match(COLOURS, boxes, names=["one"])
    with pytest.raises(OptionError):
        gamutcore.match(COLOURS, boxes, passing=2, delta_e=False)
    with pytest.raises(InvalidPointsError):
        gamutcore.match([(1, 2)], boxes)
    oklab = gamutcore.Gamut(list(product((0.4, 0.6), (-0.1, 0.1), (-0.1, 0.1))), space="Oklab")
    with pytest.raises(OptionError, match="Oklab"):
        gamutcore.match(COLOURS, [boxes[0], oklab], delta_e=False)


@pytest.mark.parametrize(
    ("colours", "names", "sentence"),
    [
        ([(50, 25, 0)], ["wide", "high"], "wide prints 1 of 1 colours, the most of 2 gamuts."),
        ([(50, 0, 0)], ["wide", "deep"], "deep and wide print 1 of 1 colours each."),
        (
            [(50, 8, 8)],
            ["small", "high", "deep"],
            "deep and high print 1 of 1 colours each, the most of 3 gamuts.",
        ),
        ([(50, 90, 0)], ["wide", "high"], "No gamut prints any of 1 colours."),
        ([(50, 90, 0)], ["wide"], "wide prints none of 1 colours."),
    ],
)
def test_the_sentence_names_all_that_print_most(boxes, colours, names, sentence):
    gamuts = [gamut for gamut in boxes if gamut.name in names]
    said = match_report(gamutcore.match(colours, gamuts, delta_e=False)).sentences[0]
    words = {str(sorted(text.replace(",", "").split())) for text in (said, sentence)}
    assert len(words) == 1, said  # equal gamuts have no order


@pytest.mark.slow  # compiles CIEDE2000, as other slow tests do
def test_files_have_every_pair_and_text_fits(boxes, tmp_path):
    report = match_report(gamutcore.match(COLOURS, boxes))
    rows = list(csv.DictReader(io.StringIO(report.to_csv())))
    assert len(rows) == len(COLOURS) * len(boxes)
    assert {row["position"] for row in rows} == {"inside", "edge", "outside"}
    assert max(map(len, report.to_text().splitlines())) <= 80
    document = json.loads(report.to_json())
    assert [gamut["name"] for gamut in document["gamuts"]] == list(BOXES)
    matrix = matrix_report(gamutcore.compare_all(boxes))
    assert max(map(len, matrix.to_text().splitlines())) <= 80
    assert "class='number s10'" in matrix.to_html()
    pytest.importorskip("matplotlib")
    matrix.save(tmp_path / "coverage.svg")
    assert (tmp_path / "coverage.svg").read_text().count("<path") > len(BOXES) ** 2
    with pytest.raises(OptionError, match="svg"):
        report.save(tmp_path / "match.svg")
