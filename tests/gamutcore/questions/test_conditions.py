"""What answers say about the gamut: its conditions, and warnings about other questions."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gamutcore import Gamut
from gamutcore.questions import figure

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def press(press_gamut):
    return press_gamut


@pytest.fixture(scope="module")
def absolute(few_patches):
    return Gamut(few_patches, surface_samples=2000, ink_limit=300, intent="absolute")


@pytest.fixture(scope="module")
def srgb(screen):
    return screen("srgb")


@pytest.fixture(scope="module")
def absolute_srgb(screen):
    return screen("srgb", intent="absolute")


def spots():
    with (ROOT / "examples" / "spots.csv").open(encoding="utf-8") as file:
        return [(row["name"], [float(row[axis]) for axis in "Lab"]) for row in csv.DictReader(file)]


PRINTABLE = {
    *("Harbour Blue", "Meadow", "Brick", "Copper Brown", "Graphite", "Sand", "Olive", "Warm Grey"),
    *("Pine", "Plum", "Denim", "Moss", "Cocoa", "Lagoon", "Silver Birch", "Ink"),
}
"""Spot colours that ISO Coated v2 300 % (ECI), a profile of the same data, prints as they are
measured. Argyll's xicclu inverts its A2B table (-fif -ia) and gives them back exactly; the others
miss by 1.7 and more."""


@pytest.mark.slow
def test_spot_colours_as_measured_need_the_absolute_gamut(fogra39):
    """With white paper (-ir) there are two more, and Apricot misses by 0.13; others by 2.1."""
    relative, absolute = (
        Gamut(fogra39, intent=each, surface_samples=20_000) for each in ("relative", "absolute")
    )
    names = np.array([name for name, _ in spots()])
    lab = np.array([values for _, values in spots()])
    assert set(names[absolute.contains(lab)]) == PRINTABLE
    more = {"Lemon Zest", "Rose Petal"}
    assert set(names[relative.contains(lab)]) - {"Apricot"} == PRINTABLE | more
    apricot = lab[names == "Apricot"]
    assert relative.nearest(apricot).distance[0] < 0.3
    assert relative.nearest(lab).warnings
    assert absolute.nearest(lab).warnings == ()


def test_in_one_line(press, absolute):
    assert str(press.conditions) == "relative intent, ink limit 300 %, white D50, CIELAB"
    assert absolute.conditions.header == "intent=absolute; ink-limit=300; white=D50; space=CIELAB"


def test_paper_is_that_of_the_file(press, absolute):
    for gamut in (press, absolute):
        stated = gamut.conditions.to_dict()
        assert stated["medium_white"] == pytest.approx([95.00, 0.00, -2.00], abs=0.01)
        assert stated["white"] == {"name": "D50", "xyz": [0.9642, 1.0, 0.8249]}


def test_appearance_spaces_state_how_colours_are_seen():
    cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]  # noqa: E741
    seen = Gamut(cube, space="CAM16-UCS", adapting_luminance=60, surround="dim").conditions
    assert seen.to_dict()["viewing_conditions"] == {
        "adapting_luminance": 60,
        "background": 20,
        "surround": "dim",
    }
    assert "adapting luminance 60" in str(seen)
    assert str(seen).startswith("colours as given")


@pytest.mark.slow
def test_every_result_states_its_gamut(press, srgb):
    colour = (50, 90, 0)
    answers = [
        press.nearest(colour),
        press.map(colour),
        press.crossings((50, 0, 0), colour),
        press.cusps(4),
        press.leaves(4, 3),
        press.slice(50),
        press.leaf(0),
        press.rings(srgb, sectors=4),
    ]
    assert all(each.gamut == press.conditions for each in answers)
    assert press.compare(srgb).gamuts == (press.conditions, srgb.conditions)
    assert (press & srgb).gamuts == (press.conditions, srgb.conditions)


class TestColoursOfNoMedium:
    def test_meet_a_gamut_relative_to_its_paper(self, press):
        for answer in (press.nearest((50, 0, 0)), press.map((50, 20, 90), space="LCHab")):
            (warning,) = answer.warnings
            assert "95 0 -2" in warning
            assert "--intent absolute" in warning

    def test_are_no_question_where_the_white_is_that_of_the_space(self, press, absolute, srgb):
        assert absolute.nearest((50, 0, 0)).warnings == ()
        assert srgb.nearest((50, 0, 0)).warnings == ()
        assert press.nearest((1, 0, 0), space="sRGB").warnings == ()


class TestColoursOfAScreen:
    """White of sRGB (hex) is L* 100, which no paper is by the intent absolute."""

    def test_meet_an_absolute_gamut(self, absolute):
        white = (1, 1, 1)
        assert not absolute.contains(white, space="sRGB").item()
        for answer in (
            absolute.nearest(white, space="sRGB"),
            absolute.map(white, space="srgb"),
            absolute.to_device(white, space="sRGB"),
        ):
            (warning,) = answer.warnings
            assert "95 0 -2" in warning
            assert "--intent relative" in warning

    def test_are_no_question_of_their_own_white(self, press, srgb):
        assert press.contains((1, 1, 1), space="sRGB").item()
        for gamut in (press, srgb):
            assert gamut.nearest((1, 1, 1), space="sRGB").warnings == ()

    @pytest.mark.parametrize(("space", "warned"), [("CIELAB", True), ("Oklab", False)])
    def test_meet_a_display_with_another_white_than_the_space(self, screen, space, warned):
        """sRGB's own D65 is the white of Oklab, and not that of CIELAB with D50."""
        display = screen("srgb", intent="absolute", **({} if warned else {"space": space}))
        assert display.contains((1, 1, 1), space="sRGB").item() != warned
        warnings = display.nearest((1, 1, 1), space="sRGB").warnings
        assert any("white of a screen" in each for each in warnings) == warned


class TestOtherConditions:
    def test_two_intents(self, press, absolute, srgb):
        for one, two in ((press, absolute), (absolute, press), (absolute, srgb)):
            assert any("intents differ" in each for each in one.compare(two).warnings)
            assert any("intents differ" in each for each in (one & two).warnings)
            assert any("intents differ" in each for each in one.rings(two).warnings)
            with pytest.warns(UserWarning, match="intents differ"):
                one.coverage_of(two)

    def test_a_source_of_a_mapping(self, press, srgb, absolute_srgb):
        colour = (50, 90, 0)
        assert press.map(colour, "sgck", source=srgb, space="sRGB").warnings == ()
        (warning,) = press.map(colour, "sgck", source=absolute_srgb, space="sRGB").warnings
        assert "intents differ" in warning

    def test_lights_with_another_white(self, absolute, absolute_srgb):
        warning, few_patches = absolute.compare(absolute_srgb).warnings
        assert "81 patches" in few_patches
        assert "whites differ" in warning

    def test_the_same(self, press, absolute, srgb):
        for warning in (*absolute.compare(absolute).warnings, *press.compare(srgb).warnings):
            assert "81 patches" in warning
        assert press.coverage_of(srgb) < 0.6  # a warning would be an error

    def test_bare_colours(self, press, absolute):
        bare = Gamut([values for _, values in spots()])
        assert any("as given" in each for each in press.compare(bare).warnings)
        assert not any("as given" in each for each in absolute.compare(bare).warnings)


class TestPictures:
    def test_a_png_has_a_text(self, press):
        with Image.open(io.BytesIO(press.picture(64))) as picture:
            picture.load()
            assert picture.text == {"Gamut": str(press.conditions)}

    @pytest.mark.slow
    def test_a_reference_is_stated_as_well(self, press, absolute):
        axes = press.plot_rings(absolute, figure().add_subplot())
        words = {word for text in axes.texts for word in text.get_text().split()}
        assert words >= {"reference:", "absolute", "relative", "Warning:"}

    @pytest.mark.slow
    def test_plots(self, press):
        axes = press.plot_slice(50, figure().add_subplot())
        press.plot_slice(60, axes)
        assert sum(text.get_text() == str(press.conditions) for text in axes.texts) == 1
