"""What every query refuses, and what it answers if nothing is asked."""

import numpy as np
import pytest

from gamutcore.errors import InvalidPointsError
from gamutcore.search import (
    contains,
    crossings,
    cusp_points,
    delta_e_2000,
    hue_leaf,
    leaves,
    map_colours,
    nearest,
    nearest_ciede2000,
    signed_distance,
)

OF_POINTS = [
    contains,
    nearest,
    pytest.param(nearest_ciede2000, marks=pytest.mark.slow),
    signed_distance,
    lambda points, level: map_colours(points, level, "clip-hue").points,
    lambda points, level: crossings(np.zeros_like(points), points, level, "segment"),
    lambda points, _: delta_e_2000(points, points),
]
OF_HUES = [
    cusp_points,
    *(
        pytest.param(query, marks=pytest.mark.slow)
        for query in (
            lambda hues, level: leaves(level, hues, [1]),
            lambda lightness, level: leaves(level, [1], lightness),
        )
    ),
]


@pytest.mark.parametrize("query", OF_POINTS)
class TestPoints:
    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e61])
    def test_a_row_that_is_not_finite_is_named(self, cube, query, bad):
        points = np.zeros((5, 3))
        points[3, 1] = points[4, 0] = bad
        with pytest.raises(InvalidPointsError, match="Row 3") as caught:
            query(points, cube)
        assert caught.value.where["row"] == 3

    def test_no_point_is_no_answer(self, cube, query):
        found = query(np.zeros((0, 3)), cube)
        fields = found if isinstance(found, tuple) else (found,)
        assert {len(field) for field in fields} <= {0, 1}  # offsets begin with 0


@pytest.mark.parametrize(
    "points",
    [
        np.zeros(3),
        np.zeros((2, 4)),
        np.zeros((1, 2, 3)),
        [[1, 2, 3], [4, 5]],
        [["a", "b", "c"]],
        np.zeros((2, 3), complex),
        None,
    ],
)
def test_other_shapes_and_types_are_refused(cube, points):
    with pytest.raises(InvalidPointsError) as caught:
        contains(points, cube)
    assert caught.value.where == {"field": "points"}
    assert "(n, 3)" in caught.value.remedy


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.int16, np.uint8])
def test_numbers_of_all_kinds_and_orders_are_colours(cube, kind):
    points = np.array([(1, 0, 0), (9, 9, 9)], kind)
    points.flags.writeable = False
    assert contains(points[:, ::-1], cube).tolist() == [True, False]


@pytest.mark.parametrize("query", OF_HUES)
def test_hues_are_one_list_of_finite_numbers(cube, query):
    assert len(query([], cube).chroma) == 0
    with pytest.raises(InvalidPointsError, match="Row 1 of"):
        query([0, np.nan], cube)
    for wrong in (3, [[1, 2]], [[1], [2, 3]], ["red"], None):
        with pytest.raises(InvalidPointsError, match="one list"):
            query(wrong, cube)


def test_two_lists_of_colours_have_the_same_length_and_a_hue_is_finite(cube):
    with pytest.raises(InvalidPointsError, match="1 rows"):
        delta_e_2000(np.zeros((1, 3)), np.zeros((2, 3)))
    with pytest.raises(InvalidPointsError):
        hue_leaf(cube, np.nan)
