import pytest

from gamutcore.characterisation.pictures.encoding import (
    ADOBE_RGB,
    SRGB,
    chromaticity_encoding,
    code_point_encoding,
    named_encoding,
)

CHROMATICITIES = [number for pair in (*SRGB.primaries, SRGB.white) for number in pair]
ACES_AP0 = [0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767]


@pytest.mark.parametrize(
    ("codes", "name", "transfer"),
    [((1, 13), "sRGB", "sRGB"), ((12, 13), "Display P3", "sRGB"), ((9, 16), "BT.2020, PQ", "PQ")],
)
def test_code_points_of_h273(codes, name, transfer):
    found = code_point_encoding(*codes)
    assert (found.name, found.transfer) == (name, transfer)


@pytest.mark.parametrize("codes", [(2, 13), (0, 13), (1, 2), (1, 255), (10, 16)])
def test_code_points_that_displays_do_not_have(codes):
    assert code_point_encoding(*codes) is None


def test_gamma_and_primaries():
    assert chromaticity_encoding(CHROMATICITIES).transfer == "sRGB"
    found = chromaticity_encoding(None, gamma=2.2)
    assert (found.transfer, found.gamma, found.primaries) == ("power", 2.2, SRGB.primaries)
    adobe = [*(n for pair in ADOBE_RGB.primaries for n in pair), *ADOBE_RGB.white]
    assert chromaticity_encoding(adobe, gamma=2.2).primaries == ADOBE_RGB.primaries
    assert chromaticity_encoding(ACES_AP0, linear=True).transfer == "linear"


@pytest.mark.parametrize(
    ("gamma", "place", "pair"),
    [
        (0.0, 0, (0.64, 0.33)),
        (50.0, 0, (0.64, 0.33)),
        (2.2, 2, (0.64, 0.33)),  # two primaries are equal
        (2.2, 6, (0.0, 0.0)),
        (2.2, 6, (0.7, 0.29)),  # the white is outside the triangle
        (2.2, 6, (9.0, 9.0)),
        (2.2, 0, (float("nan"), 0.33)),
    ],
)
def test_impossible_chromaticities_and_exponents(gamma, place, pair):
    numbers = list(CHROMATICITIES)
    numbers[place : place + 2] = pair
    assert chromaticity_encoding(numbers, gamma=gamma) is None


@pytest.mark.parametrize(
    ("name", "transfer", "gamma", "red"),
    [
        ("lin_ap1_scene", "linear", 1.0, (0.713, 0.293)),
        ("srgb_rec709_scene", "sRGB", 1.0, (0.64, 0.33)),
        ("pq_rec2020_display", "PQ", 1.0, (0.708, 0.292)),
        ("hlg_rec2020_display", "HLG", 1.0, (0.708, 0.292)),
        ("g24_rec709_display", "power", 2.4, (0.64, 0.33)),
        ("ocio:lin_p3d65_scene", "linear", 1.0, (0.680, 0.320)),
    ],
)
def test_names_of_the_color_interop_forum(name, transfer, gamma, red):
    found = named_encoding(name)
    assert (found.transfer, found.gamma, found.primaries[0]) == (transfer, gamma, red)


@pytest.mark.parametrize("name", ["", "lin_ciexyzd65_scene", "KodakLog", "data", "lin_rec709"])
def test_unknown_names(name):
    assert named_encoding(name) is None
