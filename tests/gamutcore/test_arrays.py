"""The names of array types match their element types."""

import typing

import numpy as np
import pytest

from gamutcore import arrays


def scalar_of(alias):
    """Scalar type that an array alias stands for."""
    _, dtype = typing.get_args(alias)
    (scalar,) = typing.get_args(dtype)
    return typing.get_origin(scalar) or scalar


@pytest.mark.parametrize(
    ("name", "scalar"),
    [
        ("FloatArray", np.float64),
        ("Float32Array", np.float32),
        ("PositionArray", np.floating),
        ("IndexArray", np.int32),
        ("LongArray", np.int64),
        ("ByteArray", np.uint8),
    ],
)
def test_scalars(name, scalar):
    assert scalar_of(getattr(arrays, name)) is scalar


def test_a_level_has_the_types_that_its_annotations_name(small_history):
    level = small_history.level(10)
    assert level.vertices.dtype == scalar_of(arrays.Float32Array)
    assert issubclass(level.vertices.dtype.type, scalar_of(arrays.PositionArray))
    assert level.faces.dtype == scalar_of(arrays.IndexArray)
    assert small_history.centre.dtype == scalar_of(arrays.FloatArray)
