import pytest

from gamutcore.characterisation.pictures.encoding import (
    ADOBE_RGB,
    SRGB,
    code_point_encoding,
    gamma_encoding,
)

CHROMATICITIES = (SRGB.white, *SRGB.primaries)


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
    assert gamma_encoding(None, CHROMATICITIES).transfer == "sRGB"
    found = gamma_encoding(2.2, None)
    assert (found.transfer, found.gamma, found.primaries) == ("power", 2.2, SRGB.primaries)
    adobe = gamma_encoding(2.2, (ADOBE_RGB.white, *ADOBE_RGB.primaries))
    assert adobe.primaries == ADOBE_RGB.primaries


@pytest.mark.parametrize(
    ("gamma", "chromaticities"),
    [
        (0.0, None),
        (50.0, None),
        (2.2, ((0.31, 0.33), (0.64, 0.33), (0.64, 0.33), (0.15, 0.06))),  # two primaries are one
        (2.2, ((0.0, 0.0), *SRGB.primaries)),
        (2.2, ((0.7, 0.29), *SRGB.primaries)),  # the white is no mixture of them
        (2.2, ((9.0, 9.0), *SRGB.primaries)),
    ],
)
def test_no_display_has_such(gamma, chromaticities):
    assert gamma_encoding(gamma, chromaticities) is None
