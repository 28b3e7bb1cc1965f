import io

import numpy as np
import pytest
from PIL import Image

from gamutcore import Gamut
from gamutcore.errors import PictureSizeError, SampleLimitError
from gamutcore.limits import Limits, apply_limits, current_limits

SAMPLES = np.array([[50, 40, 0], [50, -40, 0], [50, 0, 40], [50, 0, -40], [90, 0, 0], [10, 0, 0]])


def csv():
    rows = "".join("{},{},{}\n".format(*row) for row in SAMPLES.tolist())
    return f"LAB_L,LAB_A,LAB_B\n{rows}".encode()


def png():
    file = io.BytesIO()
    values = np.random.default_rng(0).integers(0, 256, (8, 8, 3)).astype(np.uint8)
    Image.fromarray(values).save(file, "png")
    return file.getvalue()


NPY = io.BytesIO()
np.save(NPY, SAMPLES.astype(np.float64))
INLINE = f'{{"samples": {SAMPLES.tolist()}}}'.encode()


@pytest.mark.parametrize("data", [csv(), NPY.getvalue(), INLINE], ids=["csv", "npy", "json"])
def test_as_many_samples_as_allowed(data):
    assert Gamut(data, gamma=1.0, limits=Limits(samples=6)).history.triangles == 8
    with pytest.raises(SampleLimitError, match=r"6 samples, more than 5"):
        Gamut(data, gamma=1.0, limits=Limits(samples=5))


def test_as_many_pixels_as_allowed():
    Gamut(png(), gamma=1.0, limits=Limits(pixels=64))
    with pytest.raises(PictureSizeError) as caught:
        Gamut(png(), gamma=1.0, limits=Limits(pixels=63))
    assert "6.3e-05 million pixels" in caught.value.remedy


def test_limits_end_with_what_they_are_for():
    with apply_limits(Limits(samples=5)):
        assert current_limits().samples == 5
    assert current_limits() == Limits()
