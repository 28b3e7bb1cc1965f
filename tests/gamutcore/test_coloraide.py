"""Plug-ins for coloraide: in gamut and fit, for gamuts that were measured."""

from pathlib import Path

import numpy as np
import pytest

import gamutcore.errors

coloraide = pytest.importorskip("coloraide")
plugins = pytest.importorskip("gamutcore.coloraide")

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def colour_class():
    class Colour(coloraide.Color):
        pass

    plugins.register(
        Colour, "press", gamutcore.Gamut(ROOT / "examples" / "FOGRA39L.ti3", surface_samples=2000)
    )
    plugins.register(Colour, "screen", gamutcore.reference("srgb", surface_samples=5000))
    oklab = gamutcore.reference("srgb", space="Oklab", surface_samples=5000)
    plugins.register(Colour, "nearest-oklab", oklab, method="clip-nearest")
    return Colour


def test_a_press_has_its_paper_and_no_blue_of_screens(colour_class):
    assert colour_class("lab", [100, 0, 0]).in_gamut("press")
    assert colour_class("lab", [60, 20, 20]).in_gamut("press")
    blue = colour_class("blue")
    assert not blue.in_gamut("press")
    assert blue.in_gamut("press", tolerance=200)
    assert not colour_class("lab", [100.5, 0, 0]).in_gamut("press", tolerance=0)


def test_fitted_colours_are_in_gamut_and_keep_hue_and_alpha(colour_class):
    colour = colour_class("color(display-p3 0 0.4 1 / 0.5)")
    hue = colour.convert("lch")["hue"]
    fitted = colour.clone().fit("press")
    assert fitted.space() == "display-p3"
    assert fitted.in_gamut("press")
    assert fitted.convert("lch")["hue"] == pytest.approx(hue, abs=1e-6)
    assert fitted[-1] == 0.5
    kept = colour.clone().fit("press", method="clip-chroma")
    assert kept.convert("lab")[0] == pytest.approx(colour.convert("lab")[0], abs=1e-6)
    with pytest.raises(gamutcore.errors.OptionError, match="clip-hue"):
        colour.clone().fit("press", method="clip-everything")


def test_a_colour_in_gamut_stays_with_its_undefined_hue(colour_class):
    grey = colour_class("lch", [50, 0, np.nan])
    assert grey.in_gamut("press")
    fitted = grey.clone().fit("press")
    assert fitted.coords()[:2] == [50, 0]
    assert np.isnan(fitted["hue"])


def test_a_gamut_of_srgb_answers_as_the_space(colour_class):
    rng = np.random.default_rng(5)
    inside = [colour_class("srgb", row) for row in rng.uniform(0.03, 0.97, (40, 3))]
    assert all(colour.in_gamut("screen") for colour in inside)
    vivid = rng.uniform(0, 1, (40, 3))
    vivid[np.arange(40), rng.integers(0, 3, 40)] = 1.2
    assert not any(colour_class("srgb", row).in_gamut("screen") for row in vivid)


def test_a_fit_plugin_is_nearer_in_its_space_than_clipping(colour_class):
    for text in ("color(rec2020 0 1 0)", "color(display-p3 1 0 0)", "oklch(70% 0.3 200)"):
        colour = colour_class(text)
        fitted = colour.clone().fit("srgb", method="nearest-oklab")
        clipped = colour.clone().clip("srgb")
        assert fitted.in_gamut("srgb")
        near, far = (colour.distance(each, space="oklab") for each in (fitted, clipped))
        assert near <= far + 1e-3


def test_names_of_spaces_are_refused(colour_class):
    gamut = gamutcore.reference("srgb", surface_samples=1000)
    with pytest.raises(ValueError, match="srgb"):
        plugins.register(colour_class, "srgb", gamut)
