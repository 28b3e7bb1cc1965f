import math

import numpy as np
import pytest

from gamutcore.characterisation.pictures.raster import (
    Raster,
    checked_size,
    picture_of_raster,
)
from gamutcore.errors import MalformedFileError, MalformedProfileError, PictureSizeError
from gamutcore.limits import MAX_PIXELS


@pytest.mark.parametrize("size", [(0, 5), (5, 0), (-1, 5)])
def test_no_pixels(size):
    with pytest.raises(MalformedFileError):
        checked_size(*size, 3, 1000, 1)


def test_sizes_are_compared_with_what_the_bytes_can_hold():
    checked_size(6000, 4000, 3, 6000 * 4000 * 3, 1)
    checked_size(6000, 4000, 3, 80_000, 1032)
    with pytest.raises(MalformedFileError):
        checked_size(6000, 4000, 3, 60_000, 1032)
    with pytest.raises(PictureSizeError):
        checked_size(MAX_PIXELS + 1, 1, 1, 2**40, math.inf)
    with pytest.raises(PictureSizeError):
        checked_size(10_000, 10_000, 8, 2**40, math.inf)


def test_large_pictures_of_next_to_nothing_are_refused():
    checked_size(10_000, 10_000, 3, 3_000_000, 1032)
    with pytest.raises(PictureSizeError, match="unpacks from 350000 bytes"):
        checked_size(10_000, 10_000, 3, 350_000, 1032)
    checked_size(6000, 4000, 3, 80_000, 1032)  # blank, and not large


@pytest.mark.parametrize("profile", [b"no profile", bytes(200), bytes(36) + b"acsp" + bytes(200)])
def test_an_embedded_profile_that_is_none_is_refused(profile):
    raster = Raster("png", "RGB", np.zeros((2, 2, 3), np.uint8), 255, 8, profile=profile)
    with pytest.raises(Exception, match="embedded profile") as caught:
        picture_of_raster(raster)
    assert caught.value.code in {MalformedProfileError.code, "unsupported-profile"}
