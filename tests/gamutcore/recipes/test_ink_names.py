"""Inks that data only numbers: their names, and rules of black without a black ink."""

from pathlib import Path

import pytest

from gamutcore import Gamut
from gamutcore.errors import OptionError

ROOT = Path(__file__).parents[3]

SOLIDS = {
    (0, 0, 0, 0): (95, 0, -2),
    (1, 0, 0, 0): (55, -37, -50),
    (0, 1, 0, 0): (48, 74, -3),
    (0, 0, 1, 0): (89, -5, 93),
    (0, 0, 0, 1): (16, 0, 0),
    (1, 1, 0, 0): (24, 22, -46),
    (1, 0, 1, 0): (50, -65, 27),
    (0, 1, 1, 0): (47, 68, 48),
    (1, 1, 1, 0): (23, 0, 0),
}
"""Paper, solid inks and overprints of ISO 12647-2, coated paper."""


def numbered(names="4CLR_1 4CLR_2 4CLR_3 4CLR_4"):
    rows = [(*colour, *SOLIDS[colour]) for colour in SOLIDS]
    # overprints with black are dark
    rows += [
        (*colour[:3], 1, *(value * 0.1 + 5 * (place == 0) for place, value in enumerate(lab)))
        for colour, lab in SOLIDS.items()
        if sum(colour[:3]) and not colour[3]
    ]
    lines = [
        f"{number} {' '.join(f'{100 * value:g}' for value in row[:4])} "
        f"{' '.join(f'{value:g}' for value in row[4:])}"
        for number, row in enumerate(rows, 1)
    ]
    head = f"CTI3\nBEGIN_DATA_FORMAT\nSAMPLE_ID {names} LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\n"
    return (head + "BEGIN_DATA\n" + "\n".join(lines) + "\nEND_DATA\n").encode()


@pytest.fixture(scope="module")
def unnamed():
    return Gamut(numbered(), surface_samples=500)


@pytest.mark.slow
def test_names_are_offered_by_the_colours_of_the_inks(unnamed):
    warnings = unnamed.description["provenance"]["warnings"]
    (warning,) = [each for each in warnings if "no names" in each]
    assert "--inks" in warning
    assert "they may be C,M,Y,K" in warning


@pytest.mark.parametrize("black", ["max", "none", 0.5, "10:90, 50:30, 90:0"])
def test_a_rule_of_black_needs_a_name(unnamed, black):
    with pytest.raises(OptionError) as caught:
        unnamed.to_device((50, 0, 0), black=black)
    assert caught.value.where == {"field": "black"}
    assert "--inks" in caught.value.remedy


@pytest.mark.slow
def test_named_inks_have_black():
    named = Gamut(numbered(), surface_samples=500, inks="C, M, Y, K")
    assert named.channels == ("C", "M", "Y", "K")
    by_columns = Gamut(numbered("CMYK_C CMYK_M CMYK_Y CMYK_K"), surface_samples=500)
    for black in ("max", "10:90, 50:30, 90:0"):
        one, two = (each.to_device((50, 0, 0), black=black) for each in (named, by_columns))
        assert one.device.tolist() == pytest.approx(two.device.tolist())
    assert one.device[3] == pytest.approx(0.3, abs=0.01)


@pytest.mark.slow
def test_a_curve_of_black_is_in_per_cent_or_in_fractions():
    gamut = Gamut(numbered("CMYK_C CMYK_M CMYK_Y CMYK_K"), surface_samples=500)
    one, two = (
        gamut.to_device([(50, 0, 0), (30, 5, 5)], black=curve).device
        for curve in ("10:90, 50:30, 90:0", [(10, 0.9), (50, 0.3), (90, 0)])
    )
    assert one.tolist() == two.tolist()
    with pytest.raises(OptionError):
        gamut.to_device((50, 0, 0), black="10:900, 50:30")


@pytest.mark.parametrize("inks", ["C,M,Y", "C,M,Y,K,O", "C,M,Y,y", "C,,Y,K"])
def test_names_that_do_not_fit_the_inks(inks):
    with pytest.raises(OptionError) as caught:
        Gamut(numbered(), surface_samples=500, inks=inks)
    assert caught.value.where["field"] == "inks"


def test_lights_have_no_inks():
    with pytest.raises(OptionError) as caught:
        Gamut(ROOT / "examples" / "Panasonic-TV.icc", surface_samples=500, inks="C,M,Y")
    assert caught.value.where["field"] == "inks"
