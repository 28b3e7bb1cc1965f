"""Points that are refused, and the row that the error names."""

import numpy as np
import pytest

from gamutcore.errors import InvalidPointsError
from gamutcore.queries.rows import checked_points


class TestCheckedPoints:
    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e61])
    def test_a_row_that_is_not_finite_is_named(self, bad):
        points = np.zeros((5, 3))
        points[3, 1] = points[4, 0] = bad
        with pytest.raises(InvalidPointsError, match="Row 3 of colours") as caught:
            checked_points(points, "colours")
        assert caught.value.where == {"field": "colours", "row": 3}

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
    def test_other_shapes_and_types_are_refused(self, points):
        with pytest.raises(InvalidPointsError) as caught:
            checked_points(points)
        assert caught.value.where == {"field": "points"}
        assert "(n, 3)" in caught.value.remedy

    def test_numbers_of_all_kinds_become_float64(self):
        for kind in (np.float32, np.float64, np.int16, np.uint8):
            found = checked_points(np.ones((2, 3), kind)[:, ::-1])
            assert found.dtype == np.float64
            assert found.flags.c_contiguous
        assert checked_points(np.zeros((0, 3))).shape == (0, 3)
