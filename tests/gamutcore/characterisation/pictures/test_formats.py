import numpy as np
import pytest

from gamutcore.characterisation import Picture, characterisation
from gamutcore.characterisation.pictures import looks_like_picture
from gamutcore.errors import OptionError


@pytest.mark.parametrize(
    "data",
    [
        b"\x89PNG\r\n\x1a\n",
        b"\xff\xd8\xff\xe0",
        b"II*\0\x08\0\0\0",
        b"MM\0*\0\0\0\x08",
        b"II+\0\x08\0\0\0",
        b"MM\0+\0\x08\0\0",
    ],
)
def test_pictures_are_told_by_their_first_bytes(data):
    assert looks_like_picture(data)


@pytest.mark.parametrize("data", [b"", b"II", b"MM", b"II, MM\n1, 2\n", b"\xff\xd8", b"\x89PNG"])
def test_other_data_is_not(data):
    assert not looks_like_picture(data)


def test_a_picture_is_characterisation_data(png, tiff, tags):
    pixels = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    for data in (png(pixels, 8, 2), tiff([pixels.tobytes()], tags(4, 4, 8, 3, 2))):
        found = characterisation(data)
        assert isinstance(found, Picture)
        assert found.provenance["format"] == found.format
        with pytest.raises(OptionError) as caught:
            characterisation(data, condition="M1")
        assert caught.value.where == {"field": "condition"}
