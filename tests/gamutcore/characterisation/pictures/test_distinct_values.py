import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from gamutcore.characterisation.pictures.distinct_values import distinct_values


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
@pytest.mark.slow
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
