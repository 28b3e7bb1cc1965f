"""The space in which pictures and links are clipped: size of the change, and blue.

The figures of other programs are for the same relative colours of sRGB, mapped into a profile of
FOGRA39: ``collink -G -ir`` of Argyll 2.3.1 has a 95th percentile of 13.8 and a worst of 17.8 ΔE00.
"""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gamutcore import Gamut
from gamutcore.questions import PICTURE_SPACE

PRESS = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"
COARSE = {"surface_samples": 5000}

COLLINK_95 = 13.84
SRGB_BLUE = (29.57, 68.29, -112.03)  # by transicc, from Argyll's sRGB.icm
MAKER_BLUE = 15.9  # ΔE00 by the relative table of ISOcoated_v2_300_bas.icc
BLUE_TURN = 20.0  # degrees of CIELAB hue


@pytest.fixture(scope="module")
def press():
    return Gamut(PRESS, space=PICTURE_SPACE, **COARSE)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["clip-hue", "clip-nearest"])
def test_clipping_is_as_near_as_that_of_other_programs(press, method):
    rgb = np.random.default_rng(46).random((3000, 3))
    assert np.percentile(press.map(rgb, method, space="sRGB").delta_e, 95) <= COLLINK_95


@pytest.mark.parametrize("method", ["clip-hue", "clip-nearest"])
def test_blue_stays_blue(press, method):
    mapped = press.map([SRGB_BLUE], method, space="CIELAB")
    assert mapped.delta_e[0] < MAKER_BLUE
    (_, a, b), (_, old_a, old_b) = mapped.points[0], SRGB_BLUE
    turn = np.degrees(np.arctan2(b, a) - np.arctan2(old_b, old_a))
    assert abs(turn) < BLUE_TURN


@pytest.mark.parametrize(("space", "told"), [("IPT", True), ("CIELAB", False)])
def test_distances_that_are_no_colour_differences_are_told(screen, space, told):
    """The definition of IPT has no colour difference: its nearest colour of blue is cyan."""
    gamut = screen("srgb", **({"space": space} if told else {}))

    def warned(method):
        answer = gamut.map([SRGB_BLUE], method, space="CIELAB")
        return any("not colour differences" in each for each in answer.warnings)

    assert warned("clip-nearest") is told
    assert not warned("clip-hue")
    recipe = gamut.to_device([SRGB_BLUE, (50, 0, 0)], space="CIELAB")
    assert any("not colour differences" in each for each in recipe.warnings) is told
    inside = gamut.to_device([(50, 0, 0)], space="CIELAB")
    assert not any("not colour differences" in each for each in inside.warnings)


@pytest.mark.parametrize("name", ["srgb", "display-p3"])
@pytest.mark.parametrize("method", ["clip-hue", "clip-nearest", "sgck", "spatial"])
def test_a_picture_of_srgb_keeps_its_pixels(screen, tmp_path, name, method):
    """Near black, the boundary in CAM16-UCS misses colours of the space by up to 1.8."""
    gamut, srgb = (screen(each, space=PICTURE_SPACE) for each in (name, "srgb"))
    random = np.random.default_rng(46)
    pixels = random.integers(0, 256, (24, 64, 3))
    pixels[:8] = random.choice([0, 255], (8, 64, 3))  # corners and edges of the cube
    pixels[:8, :, 0] = random.integers(0, 256, (8, 64))
    pixels[8:16] //= 32  # dark
    path = tmp_path / "picture.png"
    Image.fromarray(pixels.astype(np.uint8)).save(path)
    source = {"source": srgb} if method == "sgck" else {}
    done = gamut.map_picture(path, tmp_path / "mapped.png", method, **source)
    assert (done.moved, done.missed) == (0, 0)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "mapped.png")), pixels)
