import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from gamutcore.characterisation.pictures.values import (
    TooManyValuesError,
    distinct_values,
)


@given(
    st.integers(1, 4).flatmap(
        lambda channels: hnp.arrays(
            np.uint8, st.tuples(st.integers(1, 60), st.just(channels)), elements=st.integers(0, 255)
        )
    )
)
def test_every_value_once_with_its_pixels(pixels):
    found = distinct_values([pixels], len(pixels), pixels.shape[1], 8)
    rows, counts = np.unique(pixels, axis=0, return_counts=True)
    order = np.lexsort(found.values.T[::-1])
    np.testing.assert_array_equal(found.values[order], rows)
    np.testing.assert_array_equal(found.counts[order], counts)
    assert (found.distinct, found.levels) == (len(rows), None)


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("bits", [8, 16])
def test_parts_are_joined(noise, channels, bits):
    pixels = noise(500, channels, bits=bits)
    whole = distinct_values([pixels], 500, channels, bits)
    parts = distinct_values(np.array_split(pixels, 7), 600, channels, bits)
    np.testing.assert_array_equal(whole.values, parts.values)
    np.testing.assert_array_equal(whole.counts, parts.counts)
    rows = np.unique(pixels, axis=0)
    np.testing.assert_array_equal(np.unique(whole.values, axis=0), rows)


@pytest.mark.parametrize(("channels", "bits"), [(3, 8), (3, 16), (4, 16)])
def test_too_many_values_are_represented_by_one_of_each_cell(noise, channels, bits):
    pixels = noise(20_000, channels, bits=bits)
    found = distinct_values([pixels], len(pixels), channels, bits, most=3000)
    assert found.levels is not None
    assert len(found.values) <= 3000
    assert found.distinct == len(np.unique(pixels, axis=0))
    assert found.counts.sum() == len(pixels)
    cell = 2**bits // found.levels
    occupied = np.unique(pixels // cell, axis=0)
    np.testing.assert_array_equal(np.unique(found.values // cell, axis=0), occupied)
    assert len(found.values) == len(occupied)
    every = {tuple(row) for row in pixels.tolist()}
    assert every >= {tuple(row) for row in found.values.tolist()}


def test_the_extremes_of_a_picture_represent_their_cells():
    steps = np.linspace(0, 65535, 40).astype(np.uint16)
    cube = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 3)
    found = distinct_values([cube], len(cube), 3, 16, most=5000)
    assert found.levels is not None
    kept = {tuple(row) for row in found.values.tolist()}
    corners = np.array(np.meshgrid([0, 65535], [0, 65535], [0, 65535])).reshape(3, -1).T
    assert kept >= {tuple(row) for row in corners.tolist()}


@pytest.mark.parametrize(("channels", "bits"), [(3, 8), (4, 8), (3, 16)])
@pytest.mark.parametrize("most", [100, 10_000])
def test_values_that_are_joined_in_parts_are_those_that_are_sorted(
    noise, monkeypatch, channels, bits, most
):
    monkeypatch.setattr("gamutcore.characterisation.pictures.values._JOINED", 700)
    pixels = noise(5000, channels, bits=bits) >> (bits - 3) << (bits - 3)  # some of them often
    bands = np.array_split(pixels, 13)
    joined = distinct_values(bands, 5000, channels, bits, most=most, sorted_bytes=100, fewer=5000)
    whole = distinct_values(bands, 5000, channels, bits, most=most)
    np.testing.assert_array_equal(joined.values, whole.values)
    np.testing.assert_array_equal(joined.counts, whole.counts)
    assert (joined.distinct, joined.levels) == (whole.distinct, whole.levels)


def test_more_values_than_may_be_joined_are_refused(noise):
    pixels = noise(2000, 3)
    count = len(np.unique(pixels, axis=0))
    distinct_values([pixels], 2000, 3, 8, sorted_bytes=100, fewer=count)
    with pytest.raises(TooManyValuesError):
        distinct_values([pixels], 2000, 3, 8, sorted_bytes=100, fewer=count - 1)
    distinct_values([pixels], 2000, 3, 8, sorted_bytes=8000, fewer=count - 1)
