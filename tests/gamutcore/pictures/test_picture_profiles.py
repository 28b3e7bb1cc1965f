"""A picture with a faulty profile gets the same warnings when it is mapped and when it is built."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gamutcore import Gamut

DATA = Path(__file__).parents[2] / "data"

PROFILE = (DATA / "DisplayP3-v4.icc").read_bytes()
REPORTS = DATA / "reports"


def without(tag):
    return PROFILE.replace(tag, b"zzzz", 1)


def with_singular_chad():
    entry = PROFILE.index(b"chad")
    start = int.from_bytes(PROFILE[entry + 4 : entry + 8], "big")
    return PROFILE[: start + 8] + bytes(36) + PROFILE[start + 44 :]


FAULTS = {
    "no white": (without(b"wtpt"), "no media white point"),
    "a singular chad": (with_singular_chad(), "(chad) is malformed"),
    "x, y as white": (
        (REPORTS / "display-profile-white-tag-is-x-y-1.icc").read_bytes(),
        "which are x, y and not X, Y, Z",
    ),
    "colorants of the display's white": (
        (REPORTS / "display-profile-colorants-not-adapted.icc").read_bytes(),
        "not adapted to D50",
    ),
}


@pytest.fixture(scope="module")
def solid():
    corners = [[0, 0, 0], [100, 0, 0], [50, 60, 0], [50, -60, 0], [50, 0, 60], [50, 0, -60]]
    return Gamut(np.array(corners, float))


@pytest.mark.parametrize("kind", ["tiff", "png", "jpeg", "webp"])
@pytest.mark.parametrize("fault", FAULTS)
def test_the_profile_is_warned_of_as_by_a_build(solid, tmp_path, kind, fault):
    profile, words = FAULTS[fault]
    pixels = np.random.default_rng(1).integers(0, 256, (8, 8, 3), np.uint8)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, kind, icc_profile=profile)
    built = Gamut(file.getvalue()).description["provenance"]["warnings"]
    assert any(words in each for each in built)
    done = solid.map_picture(file.getvalue(), tmp_path / "mapped.tif")
    assert set(built) <= set(done.warnings)


@pytest.mark.parametrize("kind", ["tiff", "png", "jpeg", "webp"])
def test_nothing_is_said_about_a_sound_profile(solid, tmp_path, kind):
    file = io.BytesIO()
    Image.fromarray(np.zeros((2, 2, 3), np.uint8)).save(file, kind, icc_profile=PROFILE)
    done = solid.map_picture(file.getvalue(), tmp_path / "mapped.tif")
    assert not any("profile" in each or "white point" in each for each in done.warnings)
