import numpy as np
import pytest

from gamutcore.characterisation import Picture, characterisation
from gamutcore.characterisation.pictures import picture_format
from gamutcore.errors import OptionError


@pytest.mark.parametrize(
    ("data", "name"),
    [
        (b"\x89PNG\r\n\x1a\n", "png"),
        (b"\xff\xd8\xff\xe0", "jpeg"),
        (b"II*\0\x08\0\0\0", "tiff"),
        (b"MM\0*\0\0\0\x08", "tiff"),
        (b"II+\0\x08\0\0\0", "tiff"),
        (b"MM\0+\0\x08\0\0", "tiff"),
        (b"v/1\x01\2\0\0\0", "exr"),
        (b"#?RADIANCE\nFORMAT", "hdr"),
        (b"\xff\x0a\xf8", "jpeg-xl"),
        (b"\0\0\0\x0cJXL \r\n\x87\n", "jpeg-xl"),
        (b"\0\0\0\x0cjP  \r\n\x87\n", "jpeg-2000"),
        (b"\xff\x4f\xff\x51\0", "jpeg-2000"),
        (b"RIFF\x10\0\0\0WEBPVP8 ", "webp"),
        (b"SDPX\0\0", "dpx"),
        (b"XPDS\0\0", "dpx"),
    ],
)
def test_pictures_are_recognised_by_their_first_bytes(data, name):
    assert picture_format(data) == name


@pytest.mark.parametrize(
    "data", [b"", b"II", b"MM", b"II, MM\n1, 2\n", b"\xff\xd8", b"\x89PNG", b"RIFF\0\0\0\0WAVE"]
)
def test_other_data_is_not_a_picture(data):
    assert picture_format(data) is None


def test_a_picture_is_characterisation_data(png, tiff, tags):
    pixels = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    for data in (png(pixels, 8, 2), tiff([pixels.tobytes()], tags(4, 4, 8, 3, 2))):
        found = characterisation(data)
        assert isinstance(found, Picture)
        assert found.provenance["format"] == found.format
        with pytest.raises(OptionError) as caught:
            characterisation(data, condition="M1")
        assert caught.value.where == {"field": "condition"}
