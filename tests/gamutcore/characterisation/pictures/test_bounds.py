import math

import pytest

from gamutcore.characterisation.pictures.bounds import checked_held, checked_size
from gamutcore.errors import MalformedFileError, PictureSizeError
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


def test_what_is_decoded_at_once_is_compared_with_its_bytes():
    checked_held(96e6, 168e6, 1000)  # moderate, whatever it is made of
    checked_held(96e6, 240e6, 3_000_000)  # a progressive photograph of 24 megapixels
    for held, decoded in ((96e6, 240e6), (180e6, 180e6)):
        with pytest.raises(PictureSizeError, match="300000 bytes") as caught:
            checked_held(held, decoded, 300_000)
        assert caught.value.where == {"field": "size"}
    with pytest.raises(PictureSizeError):
        checked_held(96e6, 240e6, 3_000_000, 20)
