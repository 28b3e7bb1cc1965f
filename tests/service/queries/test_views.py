import numpy as np
import pytest

from gamutcore import Gamut
from service.problems.problem import ProblemError
from service.queries.levels import QueryLevel
from service.queries.operations import LEVEL_PARAMETERS
from service.queries.views import COMPARISON, VIEWS

ALL = [*VIEWS.values(), COMPARISON]


@pytest.fixture(scope="module")
def levels(cube):
    """The level of the cube, and that of a cube with half of its edge."""
    corners = np.array(list(np.ndindex(2, 2, 2)), np.float64) * 10 - 5
    gamut = Gamut(corners + np.array([50, 0, 0]))
    gamut.levels.indexed(12)
    return [cube, QueryLevel(gamut, 12, 0.0)]


def asked(view, levels, **given):
    values = {each.name: each.default for each in view.all_parameters} | given
    return view.answer(levels[: 2 if view is COMPARISON else 1], values)


@pytest.mark.parametrize("view", ALL, ids=lambda view: view.name)
def test_entries_are_consistent(view, levels):
    assert view.all_parameters[: len(LEVEL_PARAMETERS)] == LEVEL_PARAMETERS
    assert view.example.keys() <= view.members.keys()
    answered = asked(
        view, levels, triangles=12, **({"lightness": 50.0} if view.name == "slice" else {})
    )
    assert answered.document.keys() <= view.members.keys()
    lengths = {len(column) for column in answered.table.values()}
    assert len(lengths) == 1
    for name, column in answered.table.items():
        if column.ndim > 1:
            assert len(answered.parts[name]) == column.shape[1]


def test_cusps_of_a_cube(levels):
    table = asked(VIEWS["cusps"], levels, hues=8).table
    assert table["hue"].tolist() == list(range(0, 360, 45))
    assert np.allclose(table["chroma"], [10, 10 * 2**0.5] * 4)
    assert np.allclose(np.hypot(table["point"][:, 1], table["point"][:, 2]), table["chroma"])


def test_comparison_of_a_cube_with_half_of_it(levels):
    answered = asked(COMPARISON, levels, triangles=12, sectors=4)
    document = answered.document
    expected = {
        "volume_a": 8000,
        "volume_b": 1000,
        "intersection": 1000,
        "union": 8000,
        "a_covers_b": 1,
        "b_covers_a": 0.125,
        "jaccard": 0.125,
        "symmetric_difference": 7000,
    }
    for name, value in expected.items():
        assert document[name] == pytest.approx(value, rel=1e-6)
    assert answered.table["hue_from"].tolist() == [0, 90, 180, 270]
    assert np.allclose(answered.table["volume_b"], 250)
    assert document["white_a"][0] == 60
    assert document["black_b"][0] == 45


def test_sections_of_a_cube(levels):
    for given, area in (
        ({"lightness": 50.0}, 400),
        ({"plane": (0.0, 1.0, 0.0, 5.0)}, 400),
        ({"hue": 0.0}, 200),
    ):
        answered = asked(VIEWS["slice"], levels, **given)
        (polygon,) = answered.document["polygons"]
        spread = np.ptp(polygon, axis=0)
        assert np.prod(spread[spread > 0]) == pytest.approx(area)
        assert answered.table["polygon"].tolist() == [0] * len(polygon)
    assert asked(VIEWS["slice"], levels, lightness=70.0).document["polygons"] == []


@pytest.mark.parametrize("given", [{}, {"lightness": 50.0, "hue": 3.0}])
def test_a_section_needs_one_plane(levels, given):
    with pytest.raises(ProblemError) as caught:
        asked(VIEWS["slice"], levels, **given)
    assert caught.value.problem.code == "invalid-parameter"


def test_intervals_of_a_cube(levels):
    answered = asked(VIEWS["leaves"], levels, hues=2, lightness=3)
    assert answered.document["lightness"].tolist() == [0, 50, 100]
    assert answered.document["intervals"] == [[[], [[0, 10]], []]] * 2
    assert answered.table["hue"].tolist() == [0, 180]
    assert answered.table["chroma_to"].tolist() == [10, 10]


def test_rings_of_a_cube_with_half_of_it(levels):
    alone = asked(VIEWS["rings"], levels[:1], sectors=4, triangles=12)
    assert alone.document["volume"] == pytest.approx(8000)
    # the area within the outer ring is the volume
    outer = alone.document["radius"][-1]
    assert (outer**2).sum() * np.pi / 4 == pytest.approx(8000)
    view = VIEWS["rings"]
    values = {each.name: each.default for each in view.all_parameters}
    both = view.answer(levels, values | {"sectors": 4, "triangles": 12})
    inner = both.document["reference_radius"][-1]
    assert (inner**2).sum() * np.pi / 4 == pytest.approx(1000)
    assert len(both.table["hue"]) == 4 * len(both.document["lightness"])
