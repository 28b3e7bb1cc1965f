"""Colours as arguments: shapes, types, and rows that are no colours."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as arrays

from gamutcore.colour_rows import colour_rows
from gamutcore.errors import InvalidPointsError


@given(arrays.array_shapes(min_dims=1, max_dims=4, max_side=4))
def test_answers_have_the_shape_of_the_colours(shape):
    colours = np.arange(3.0 * np.prod(shape)).reshape(*shape, 3)
    rows = colour_rows(colours)
    assert rows.points.shape == (np.prod(shape), 3)
    assert rows.in_shape(rows.points[:, 0] > 0).shape == shape
    np.testing.assert_array_equal(rows.in_shape(rows.points), colours)


@pytest.mark.parametrize("kind", ["f4", "f8", "i2", "u1", ">f8"])
def test_any_number_is_float64(kind):
    rows = colour_rows(np.array([(50, 1, 2)], kind))
    assert rows.points.dtype == np.float64
    assert rows.points.tolist() == [[50, 1, 2]]


@pytest.mark.parametrize("colours", [5, [], "lab", [("a", "b", "c")], [[1, 2, 3j]], [[1], [2, 3]]])
def test_what_is_no_array_of_colours(colours):
    with pytest.raises(InvalidPointsError) as caught:
        colour_rows(colours, "starts")
    assert caught.value.where["field"] == "starts"
    assert "(..., 3)" in caught.value.remedy
