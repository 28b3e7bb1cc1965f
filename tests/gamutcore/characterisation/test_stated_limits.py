"""Ink limits that data states itself."""

import struct

import numpy as np
import pytest
from PIL import Image, ImageCms

from gamutcore import Gamut, Options
from gamutcore.building import ink_limits
from gamutcore.characterisation import read_characterisation
from gamutcore.characterisation.embedded_data import stated_ink_limit

TABLE = """CTI3
{}BEGIN_DATA_FORMAT
SAMPLE_ID CMYK_C CMYK_M CMYK_Y CMYK_K LAB_L LAB_A LAB_B
END_DATA_FORMAT
BEGIN_DATA
1 0 0 0 0 95 0 -2
2 100 0 0 0 55 -37 -50
3 0 100 0 0 48 74 -3
4 0 0 100 0 89 -5 93
5 0 0 0 100 16 0 0
6 100 100 100 100 10 0 0
END_DATA
"""
KEYWORD = 'KEYWORD "TOTAL_INK_LIMIT"\nTOTAL_INK_LIMIT "{}"\n'


def target(limit):
    return TABLE.format(KEYWORD.format(limit))


def lut(values, curve=(0, 65535)):
    """A tag lut16 (ICC.1:2022, 10.12) with 2 nodes along each axis of Lab."""
    nodes = np.asarray(values, np.float64).reshape(8, -1)
    channels = nodes.shape[1]
    head = b"mft2" + bytes(4) + bytes([3, channels, 2, 0])
    head += struct.pack(">9i", *(65536 * (i % 4 == 0) for i in range(9))) + struct.pack(">HH", 2, 2)
    tables = [[0, 65535] * 3, np.rint(65535 * nodes).astype(int).ravel(), list(curve) * channels]
    return head + b"".join(struct.pack(f">{len(each)}H", *each) for each in tables)


def stated(data):
    found = stated_ink_limit(read_characterisation(data))
    return None if found is None else found.total


def test_the_keyword_of_measurements():
    assert stated(target("320.5").encode()) == 320.5
    assert stated(TABLE.format("").encode()) is None


@pytest.mark.parametrize("limit", ["400", "0", "-1", "nan", "much", ""])
def test_what_is_no_limit(limit):
    assert stated(target(limit).encode()) is None


def test_the_target_of_a_profile(made_profile):
    tags = {"targ": b"text" + bytes(4) + target("280").encode(), "B2A1": lut(np.ones((8, 4)))}
    assert stated(made_profile(tags, space="CMYK")) == 280


def test_the_largest_sum_of_a_separation(made_profile):
    inks = np.full((8, 4), 0.5)
    inks[3] = (1.0, 0.9, 0.8, 0.6)
    assert stated(made_profile({"B2A1": lut(inks)}, space="CMYK")) == 330
    halved = lut(inks, curve=(0, 32768))
    assert stated(made_profile({"B2A0": halved}, space="CMYK")) == 165
    colorimetric_first = {"B2A0": halved, "B2A1": lut(inks)}
    assert stated(made_profile(colorimetric_first, space="CMYK")) == 330


@pytest.mark.parametrize("cut", [9, 30, 60, 100])
def test_a_damaged_separation_does_not_matter(made_profile, cut):
    assert stated(made_profile({"B2A1": lut(np.full((8, 4), 0.5))[:cut]}, space="CMYK")) is None


def test_displays_have_no_ink_limit(made_profile):
    assert stated(made_profile({"B2A1": lut(np.full((8, 3), 0.5))})) is None


def test_a_real_profile_states_what_a_colour_engine_separates(shared_data):
    """LittleCMS separates colours of the whole CIELAB cube; 300 % is in the profile's name."""
    path = shared_data / "press" / "ISOcoated_v2_300_bas.icc"
    steps = np.linspace(0, 255, 33).astype(np.uint8)
    lab = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(1, -1, 3)
    engine = ImageCms.buildTransform(
        ImageCms.createProfile("LAB"), ImageCms.getOpenProfile(str(path)), "LAB", "CMYK", 1
    )
    inks = np.asarray(ImageCms.applyTransform(Image.fromarray(lab, "LAB"), engine), np.float64)
    assert stated(path.read_bytes()) == pytest.approx(100 * inks.sum(axis=2).max() / 255, abs=2)
    assert stated(path.read_bytes()) == 300


def test_a_stated_limit_holds_for_the_gamut_and_its_device_values():
    data = target("300").encode()
    told = Gamut(data, surface_samples=500)
    assert [each for each in warnings_of(told) if "ink limit of 300 %" in each]
    assert told.conditions.ink_limit == 300
    assert told.description["provenance"]["ink_limits"]["stated_by"] == "TOTAL_INK_LIMIT"
    assert told.volume == Gamut(data, surface_samples=500, ink_limit=300).volume
    device = told.nearest([(0, 0, 0), (10, 20, 0)]).device
    assert device.sum(axis=1).max() <= 3.0005


@pytest.mark.slow
@pytest.mark.parametrize("value", ["none", "None", None])
def test_none_is_all_inks_in_full(value):
    data, silent = target("300").encode(), Gamut(TABLE.format("").encode(), surface_samples=500)
    full = Gamut(data, {"ink_limit": value}, surface_samples=500)
    assert full.volume == silent.volume
    assert full.conditions.ink_limit is None
    assert warnings_of(full) == warnings_of(silent)


def test_a_given_limit_comes_before_the_stated_one():
    limited = Gamut(target("300").encode(), surface_samples=500, ink_limit=250)
    assert limited.conditions.ink_limit == 250
    assert not [each for each in warnings_of(limited) if "states" in each]


def test_a_stated_limit_below_one_ink_is_not_used():
    gamut = Gamut(target("3").encode(), surface_samples=500)
    assert gamut.conditions.ink_limit is None
    assert [each for each in warnings_of(gamut) if "less than one full ink" in each]


def test_answers_pass_on_the_warnings_of_the_build():
    gamut = Gamut(target("300").encode(), surface_samples=500)
    (warning,) = [each for each in warnings_of(gamut) if "ink limit of 300 %" in each]
    assert warning in gamut.nearest((50, 0, 0)).warnings
    assert warning in gamut.map((50, 0, 0)).warnings
    assert f"B: {warning}" in gamut.compare(gamut, sectors=1).warnings


@pytest.mark.slow
def test_separations_by_a_real_profile_keep_its_limit(shared_data):
    """300 % is in the profile's name; without it, black has up to 400 %."""
    path = shared_data / "press" / "ISOcoated_v2_300_bas.icc"
    gamut = Gamut(path, surface_samples=1000)
    dark = [(lightness, 0, 0) for lightness in range(0, 30, 3)]
    recipes = gamut.to_device(dark)
    assert recipes.device.sum(axis=1).max() <= 3.0 + 1e-6
    assert [each for each in recipes.warnings if "ink limit of 300 %" in each]
    full = Gamut(path, surface_samples=1000, ink_limit="none").to_device(dark)
    assert full.device.sum(axis=1).max() > 3.2


def test_a_limit_that_was_meant_in_full_inks_warns(fogra39):
    data = read_characterisation(fogra39)
    assert "per cent" in ink_limits(data, Options(ink_limit=3))[1][0]
    assert ink_limits(data, Options(ink_limit=50))[1] == ink_limits(data, Options())[1] == []


def warnings_of(gamut):
    return gamut.description["provenance"]["warnings"]
