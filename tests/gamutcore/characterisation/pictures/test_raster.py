import numpy as np
import pytest

from gamutcore.characterisation.pictures.raster import Raster, picture_of_raster
from gamutcore.errors import MalformedProfileError


@pytest.mark.parametrize("profile", [b"no profile", bytes(200), bytes(36) + b"acsp" + bytes(200)])
def test_an_embedded_profile_that_is_none_is_refused(profile):
    black = np.zeros((2, 2, 3), np.uint8)
    raster = Raster(
        "png", "RGB", 2, 2, iter([(0, black)]), black.dtype, 12, 255, 8, profile=profile
    )
    with pytest.raises(Exception, match="embedded profile") as caught:
        picture_of_raster(raster)
    assert caught.value.code in {MalformedProfileError.code, "unsupported-profile"}
