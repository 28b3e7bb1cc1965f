"""PNG files, read by Pillow."""

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from gamutcore.export.png import png


@given(
    rows=st.integers(1, 20),
    columns=st.integers(1, 20),
    channels=st.sampled_from([3, 4]),
    seed=st.integers(0, 2**32 - 1),
)
def test_pixels_come_back(rows, columns, channels, seed):
    pixels = np.random.default_rng(seed).integers(0, 256, (rows, columns, channels), np.uint8)
    with Image.open(io.BytesIO(png(pixels))) as image:
        image.verify()
    with Image.open(io.BytesIO(png(pixels, 0))) as image:
        assert image.mode == {3: "RGB", 4: "RGBA"}[channels]
        np.testing.assert_array_equal(np.asarray(image), pixels)


@pytest.mark.parametrize("channels", [1, 2, 5])
def test_other_numbers_of_channels_are_an_error(channels):
    with pytest.raises(KeyError):
        png(np.zeros((2, 2, channels), np.uint8))
