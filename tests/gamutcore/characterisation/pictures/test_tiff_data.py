import zlib

import numpy as np
import pytest

from gamutcore.characterisation.pictures.tiff_data import Layout, decoded_samples
from gamutcore.characterisation.pictures.tiff_tags import tiff_directory
from gamutcore.errors import MalformedFileError, UnsupportedPictureError

LAYOUT = {
    "width": 4,
    "height": 4,
    "samples": 3,
    "bits": 8,
    "floats": False,
    "planar": False,
    "compression": 1,
    "predictor": 1,
    "reversed_bits": False,
    "photometric": 2,
}


def decoded(data, **layout):
    tags, _ = tiff_directory(data, 0)
    found = decoded_samples(data, tags, Layout(**LAYOUT | layout))
    return np.concatenate([block for _, block in found.blocks])


def test_samples_have_their_places(tiff, tags, noise):
    pixels = noise(4, 4, 3)
    data = tiff([pixels[:3].tobytes(), pixels[3:].tobytes()], tags(4, 4, 8, 3, 2, t278=3))
    np.testing.assert_array_equal(decoded(data), pixels)


def test_lzw_of_the_specification(tiff, tags):
    """TIFF 6.0, section 13: 7 7 7 8 8 7 7 6 6 is 80 01 E0 40 80 44 08 0C 06 80 80 8."""
    packed = bytes.fromhex("8001E0408044080C0680808" + "0")
    data = tiff([packed], tags(9, 1, 8, 1, 1, t259=5))
    found = decoded(data, width=9, height=1, samples=1, compression=5)
    assert found.reshape(-1).tolist() == [7, 7, 7, 8, 8, 7, 7, 6, 6]


def test_packbits_of_the_specification(tiff, tags):
    """Apple's technical note 1023, which TIFF 6.0, section 9, refers to."""
    packed = bytes.fromhex("FEAA0280002AFDAA0380002A22F7AA")
    wanted = bytes.fromhex("AAAAAA80002AAAAAAAAA80002A22AAAAAAAAAAAAAAAAAAAA")
    data = tiff([packed], tags(24, 1, 8, 1, 1, t259=32773))
    found = decoded(data, width=24, height=1, samples=1, compression=32773)
    assert found.tobytes() == wanted


@pytest.mark.parametrize("part", [zlib.compress(bytes(40)), b"no deflate data"])
def test_a_strip_with_too_little_names_itself(tiff, tags, part):
    data = tiff([part], tags(4, 4, 8, 3, 2, t259=8))
    with pytest.raises(MalformedFileError, match="strip or tile 0") as caught:
        decoded(data, compression=8)
    assert caught.value.where == {"strip": 0}


def test_too_few_strips(tiff, tags):
    data = tiff([bytes(24)], tags(4, 4, 8, 3, 2, t278=2))
    with pytest.raises(MalformedFileError, match="2 strips or tiles are needed"):
        decoded(data)


def test_tiles_without_a_size(tiff, tags):
    with pytest.raises(MalformedFileError, match="Tiles have"):
        decoded(tiff([bytes(48)], tags(4, 4, 8, 3, 2, t322=0, t323=0), tiled=True))


def test_very_many_parts(tiff, tags):
    layout = tags(100, 100_000, 8, 3, 2, t278=1)
    with pytest.raises(UnsupportedPictureError, match="100000 strips"):
        decoded(tiff([bytes(48)], layout), width=100, height=100_000)
