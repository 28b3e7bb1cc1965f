"""Colours of measured samples: media, whites, illuminants, observers, adaptation, spectra."""

import json
from dataclasses import replace

import numpy as np
import pytest

from gamutcore.characterisation import characterisation
from gamutcore.colours.declared_observer import declared_observer
from gamutcore.colours.measured_colours import measured_colours
from gamutcore.colours.spaces.cielab import (
    ICC_D50,
    lab_to_xyz,
    white_of,
    xyz_to_lab,
)
from gamutcore.colours.spectral import (
    ILLUMINANTS,
    OBSERVERS,
    emission_xyz,
    reflectance_xyz,
    tristimulus_weights,
)
from gamutcore.errors import InvalidPointsError, OptionError

D65 = np.array([0.95047, 1.0, 1.08883])
RED_D65 = np.array([0.4124564, 0.2126729, 0.0193339])
"""sRGB's red, D65 (Lindbloom's table of RGB working spaces)."""


def samples(columns, rows, **members):
    document = {"columns": columns.split(), "samples": rows, **members}
    return characterisation(json.dumps(document).encode())


def display(white=D65, scale=100.0, **members):
    rows = [[255, 255, 255, *(white * scale)], [255, 0, 0, *(RED_D65 * scale)], [0, 0, 0, 0, 0, 0]]
    return samples("R G B X Y Z", [list(map(float, row)) for row in rows], **members)


def press(columns="CMYK_C CMYK_M CMYK_Y CMYK_K XYZ_X XYZ_Y XYZ_Z", scale=100.0, **members):
    paper, ink = np.array([0.8448, 0.8762, 0.7457]), np.array([0.14, 0.22, 0.53])
    rows = [[0, 0, 0, 0, *(paper * scale)], [100, 0, 0, 0, *(ink * scale)]]
    return samples(columns, [list(map(float, row)) for row in rows], **members)


@pytest.mark.parametrize("scale", [1.0, 100.0, 250.0])
def test_a_display_relative_to_its_white(scale):
    medium = measured_colours(display(scale=scale), "relative")
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)
    # sRGB's red in CIELAB D50: 54.29, 80.81, 69.89 (Lindbloom; also what image editors show).
    np.testing.assert_allclose(medium.lab[1], [54.29, 80.81, 69.89], atol=0.05)
    assert "Bradford" in medium.provenance["adaptation"]
    assert medium.provenance["medium"] == "display (assumed, not stated)"
    assert "assumed to be a display's" in medium.warnings[0]
    np.testing.assert_allclose(medium.provenance["white"], D65 * scale)


@pytest.mark.parametrize("stated", [{"device_class": "DISPLAY"}, {"cgv_display_type": "EMISSIVE"}])
def test_a_stated_display_is_not_an_assumption(stated):
    medium = measured_colours(display(**stated), "relative")
    assert medium.provenance["medium"] == "display"
    assert medium.warnings == ()


@pytest.mark.parametrize("scale", [1.0, 100.0, 250.0])
def test_a_display_as_measured(scale):
    medium = measured_colours(display(scale=scale), "absolute")
    np.testing.assert_allclose(medium.lab[:2], xyz_to_lab(np.array([D65, RED_D65])), atol=1e-9)
    assert medium.provenance["adaptation"].startswith("none")


@pytest.mark.parametrize("scale", [1.0, 100.0])
def test_a_press_relative_to_its_paper(scale):
    medium = measured_colours(press(scale=scale), "relative")
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-6)
    # ICC media-relative: each of X, Y, Z by its own ratio.
    expected = np.array([0.14, 0.22, 0.53]) * ICC_D50 / [0.8448, 0.8762, 0.7457]
    np.testing.assert_allclose(lab_to_xyz(medium.lab[1]), expected, atol=1e-9)
    assert medium.provenance["medium"] == "reflective"


@pytest.mark.parametrize("scale", [1.0, 100.0])
def test_a_press_as_measured(scale):
    medium = measured_colours(press(scale=scale), "absolute")
    np.testing.assert_allclose(lab_to_xyz(medium.lab[1]), [0.14, 0.22, 0.53], atol=1e-9)


def test_absolute_lab_of_a_press_is_untouched(fogra39):
    data = characterisation(fogra39)
    medium = measured_colours(data, "absolute")
    assert medium.lab is data.lab
    assert medium.provenance["illuminant"] == "D50"
    assert medium.provenance["observer"] == "2°"
    assert medium.warnings == ()
    # ISO 12647-2: the paper, L* 95, a* 0, b* -2.
    np.testing.assert_allclose(
        xyz_to_lab(np.array(medium.provenance["white"])), [95, 0, -2], atol=1e-3
    )


def test_rgb_printers_are_no_displays():
    for members in ({"device_class": "OUTPUT"}, {"color_rep": "iRGB_XYZ"}):
        medium = measured_colours(display(scale=0.9, **members), "relative")
        assert medium.provenance["medium"] == "reflective"


def test_without_a_white_patch_the_lightest_is_taken_and_said():
    data = samples("R G B X Y Z", [[255, 0, 0, 40, 21, 2], [0, 255, 0, 36, 72, 12]])
    medium = measured_colours(data, "relative")
    assert any("white was not measured" in said for said in medium.warnings)
    assert medium.lab[1, 0] == pytest.approx(100)


def test_a_declared_white_wins():
    data = samples("R G B X Y Z", [[255, 0, 0, *(RED_D65 * 80)]], white=list(D65 * 80))
    np.testing.assert_allclose(
        measured_colours(data, "relative").lab, [[54.29, 80.81, 69.89]], atol=0.05
    )


def test_bare_colours_are_taken_as_they_are():
    data = samples("L a b", [[50, 10, -10]])
    medium = measured_colours(data, "relative")
    assert medium.lab is data.lab
    assert medium.provenance["medium"] == "unknown"
    assert medium.provenance["white"] is None
    assert medium.provenance["intent"] == "none: the colours as given"
    assert "not made relative" in medium.warnings[0]
    with pytest.raises(OptionError) as caught:
        measured_colours(data, "absolute")
    assert caught.value.where == {"field": "intent"}
    assert len(measured_colours(replace(data, white=D65), "absolute").lab) == 1


@pytest.mark.parametrize("scale", [1.0, 100.0])
def test_bare_tristimulus_values_of_either_scale(scale):
    data = samples("X Y Z", (np.array([ICC_D50, ICC_D50 / 2]) * scale).tolist())
    np.testing.assert_allclose(measured_colours(data, "relative").lab[0], [100, 0, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("conditions", "illuminant", "observer"),
    [
        ({"illuminant": "D65", "observer": "10 degree"}, "D65", "10°"),
        ({"weighting_function": "ILLUMINANT, D50"}, "D50", "2° (assumed, not stated)"),
        (
            {"measurement_source": "Illumination=D50 ObserverAngle=2° WhiteBase=Abs"},
            "D50",
            "2°",
        ),
        ({"instrumentation": "D50, 2 degree, geometry 45/0"}, "D50", "2°"),
        ({"illuminant": "A", "observer": "2"}, "A", "2°"),
        ({"observer": "1931_2"}, "D50 (assumed, not stated)", "2°"),
        ({"observer": "1964_10"}, "D50 (assumed, not stated)", "10°"),
        ({"cie_observer": "1964", "cie_observer_angle": "10"}, "D50 (assumed, not stated)", "10°"),
        ({}, "D50 (assumed, not stated)", "2° (assumed, not stated)"),
    ],
)
def test_illuminant_and_observer_are_found(conditions, illuminant, observer):
    provenance = measured_colours(press(**conditions), "absolute").provenance
    assert (provenance["illuminant"], provenance["observer"]) == (illuminant, observer)


def test_another_illuminant_is_adapted_to_d50():
    white = white_of("A", "2")
    data = samples(
        "CMY_C CMY_M CMY_Y X Y Z", [[0, 0, 0, *(white * 90)], [1, 1, 1, 1, 1, 1]], illuminant="A"
    )
    medium = measured_colours(data, "absolute")
    np.testing.assert_allclose(lab_to_xyz(medium.lab[0]), 0.9 * ICC_D50, atol=1e-9)
    assert medium.provenance["adaptation"] == "Bradford from A to D50"


@pytest.mark.parametrize("observer", ["2012_2", "2012_10", "1978_2", "shaw", "Judd-Vos", "moon"])
def test_an_observer_that_is_neither_of_the_two_is_warned_of(observer):
    medium = measured_colours(press(observer=observer), "absolute")
    assert any(observer in said and "2°" in said for said in medium.warnings)
    assert "not known" in medium.provenance["observer"]


def test_colours_for_an_observer_that_is_not_known_give_way_to_spectra():
    stated = {"ILLUMINANT": "D50", "OBSERVER": "2012_2"}
    both = spectral(colours="LAB_L LAB_A LAB_B", conditions=stated)
    medium = measured_colours(both, "absolute")
    assert medium.provenance["colours_from"].startswith("SPECTRUM")
    assert len(medium.warnings) == 1
    assert measured_colours(both, "absolute", observer=10).warnings == ()


def test_columns_that_disagree_are_warned_of():
    rows = [[0, 0, 0, 90, 0, 0, 20, 20, 20], [1, 0, 0, 50, 0, 0, 20, 20, 20]]
    medium = measured_colours(samples("CMY_C CMY_M CMY_Y L A B X Y Z", rows), "absolute")
    assert "differ" in medium.warnings[0]


def test_intents_of_profiles_are_refused(fogra39):
    for intent in ("perceptual", "saturation"):
        with pytest.raises(OptionError, match="profiles") as caught:
            measured_colours(characterisation(fogra39), intent)
        assert caught.value.where == {"field": "intent"}


def test_a_white_without_light_is_refused():
    data = samples("R G B X Y Z", [[255, 255, 255, 0, 0, 0], [0, 0, 0, 0, 0, 0]])
    with pytest.raises(InvalidPointsError):
        measured_colours(data, "relative")


BANDS = [f"SPEC_{nm}" for nm in range(380, 740, 10)]


def spectral(device="CMYK_C CMYK_M CMYK_Y CMYK_K", white=(0, 0, 0, 0), colours="", **members):
    """Return a white and a dark patch, with spectra that fall towards blue."""
    slope = np.linspace(0.6, 0.9, 36)
    dark = tuple(1 - (value or 0) for value in white) if max(white) <= 1 else (0,) * len(white)
    given = [[95.0, 0, -2], [20, 0, 0]] if colours else [[], []]
    rows = [[*white, *given[0], *slope], [*dark, *given[1], *(slope * 0.1)]]
    return samples(" ".join([device, colours, *BANDS]), rows, **members)


def test_spectra_are_seen_under_d50_by_2_degrees_unless_asked_otherwise():
    medium = measured_colours(spectral(), "absolute")
    assert (medium.provenance["illuminant"], medium.provenance["observer"]) == ("D50", "2°")
    assert medium.provenance["colours_from"].startswith("SPECTRUM, ASTM E308")
    same = measured_colours(spectral(), "absolute", observer=2, illuminant="D50")
    np.testing.assert_array_equal(medium.lab, same.lab)
    other = measured_colours(spectral(), "absolute", observer=10, illuminant="A")
    assert (other.provenance["illuminant"], other.provenance["observer"]) == ("A", "10°")
    assert other.provenance["adaptation"] == "Bradford from A to D50"
    assert not np.allclose(other.lab, medium.lab, atol=0.1)


@pytest.mark.parametrize("illuminant", ["A", "D65", "FL11"])
def test_the_paper_is_white_under_any_illuminant(illuminant):
    medium = measured_colours(spectral(), "relative", illuminant=illuminant)
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("stated", "asked", "illuminant", "observer"),
    [
        ({}, {}, "D50 (usual)", "2° (usual)"),
        ({"OBSERVER": "10"}, {}, "D50 (usual)", "10° (stated)"),
        ({"OBSERVER": "1964_10", "ILLUMINANT": "A"}, {}, "A (stated)", "10° (stated)"),
        ({"ILLUMINANT": "F11"}, {}, "FL11 (stated)", "2° (usual)"),
        ({"OBSERVER": "10"}, {"observer": 2}, "D50 (usual)", "2° (asked for)"),
        ({"ILLUMINANT": "A"}, {"illuminant": "D50"}, "D50 (asked for)", "2° (usual)"),
        ({"ILLUMINANT": "moon"}, {}, "D50 (usual)", "2° (usual)"),
    ],
)
def test_spectra_alone_are_seen_as_their_file_states(stated, asked, illuminant, observer):
    medium = measured_colours(spectral(conditions=stated), "absolute", **asked)
    said = medium.provenance["colours_from"]
    assert f"observer {observer}, illuminant {illuminant}, reflectances" in said
    given = {"observer": int(observer.split("°")[0]), "illuminant": illuminant.split()[0]}
    same = measured_colours(spectral(), "absolute", **given)
    np.testing.assert_array_equal(medium.lab, same.lab)
    assert medium.provenance["illuminant"] == given["illuminant"]


def test_what_is_stated_beside_colours_is_of_the_colours():
    stated = {"ILLUMINANT": "D65", "OBSERVER": "10"}
    both = spectral(colours="LAB_L LAB_A LAB_B", conditions=stated)
    medium = measured_colours(both, "absolute")
    assert "observer 2° (usual), illuminant D50 (usual)" in medium.provenance["colours_from"]


def test_lights_alone_are_seen_by_the_observer_that_is_stated():
    conditions = {"DEVICE_CLASS": "DISPLAY", "OBSERVER": "1964_10"}
    light = spectral("R G B", (255, 255, 255), conditions=conditions)
    medium, same = (measured_colours(light, "absolute", observer=given) for given in (None, 10))
    assert medium.provenance["observer"] == "10°"
    np.testing.assert_array_equal(medium.lab, same.lab)


def test_stated_colours_are_taken_unless_the_spectra_are_asked_for():
    both = spectral(colours="LAB_L LAB_A LAB_B", conditions={"ILLUMINANT": "D50"})
    stated = measured_colours(both, "absolute")
    assert stated.provenance["colours_from"] == "LAB"
    np.testing.assert_allclose(stated.lab[0], [95, 0, -2])
    assert measured_colours(both, "absolute", observer=2).lab[0, 2] > 5
    elsewhere = spectral(colours="LAB_L LAB_A LAB_B", conditions={"ILLUMINANT": "D65"})
    assert measured_colours(elsewhere, "absolute").provenance["illuminant"] == "D50"


def test_colours_without_spectra_cannot_be_seen_otherwise():
    for given in ({"observer": 10}, {"illuminant": "D65"}):
        with pytest.raises(OptionError) as caught:
            measured_colours(press(), "relative", **given)
        assert list(given) == [caught.value.where["field"]]
    own = measured_colours(press(), "relative", observer=2, illuminant="D50")
    assert own.provenance["observer"] == "2° (assumed, not stated)"


def test_lights_have_no_illuminant():
    display_class = {"DEVICE_CLASS": "DISPLAY"}
    light = spectral("R G B", (255, 255, 255), conditions=display_class)
    medium = measured_colours(light, "relative", observer=10)
    assert medium.provenance["medium"] == "display"
    assert medium.provenance["observer"] == "10°"
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)
    assert medium.warnings == ()
    with pytest.raises(OptionError, match="illuminant"):
        measured_colours(light, "relative", illuminant="D65")


def test_spectra_of_rgb_values_are_lights_unless_something_says_otherwise():
    unsaid = measured_colours(spectral("R G B", (255, 255, 255)), "relative")
    assert unsaid.provenance["medium"] == "display (assumed, not stated)"
    assert any("DEVICE_CLASS OUTPUT" in said for said in unsaid.warnings)
    for said in ({"DEVICE_CLASS": "OUTPUT"}, {"MEASUREMENT_CONDITION": "M1"}):
        printed = spectral("R G B", (255, 255, 255), conditions=said)
        assert measured_colours(printed, "relative").provenance["medium"] == "reflective"


@pytest.mark.parametrize("adaptation", ["CAT02", "CAT16", "von-Kries", "XYZ-scaling"])
def test_another_adaptation_takes_the_white_to_d50_as_well(adaptation):
    medium = measured_colours(display(), "relative", adaptation=adaptation)
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)
    assert medium.provenance["adaptation"].startswith(f"{adaptation} from the white to D50")
    assert np.abs(medium.lab[1] - measured_colours(display(), "relative").lab[1]).max() > 0.1
    assert not medium.as_measured


@pytest.mark.parametrize(
    ("stated", "expected"),
    [
        ("112.3 118.2 130.0", 118.2),
        ("118.2", None),
        ("1 -5 3", None),
        ("1 1e999 3", None),
        ("a b c", None),
    ],
)
def test_the_luminance_that_argyll_states_of_a_display(stated, expected):
    data = display(conditions={"LUMINANCE_XYZ_CDM2": stated})
    for intent in ("relative", "absolute"):
        assert measured_colours(data, intent).provenance.get("white_luminance") == expected
    printed = press(conditions={"LUMINANCE_XYZ_CDM2": stated})
    assert "white_luminance" not in measured_colours(printed, "relative").provenance


@pytest.mark.parametrize(
    ("text", "observer"),
    [
        ("1931_2", "2"),  # Argyll, `spotread -Q`; DisplayCAL writes the same
        ("1964_10", "10"),
        ("2", "2"),
        ("10.0", "10"),
        ("2 degree", "2"),
        ("10deg", "10"),
        ("2°", "2"),
        ("2\ufffd", "2"),
        ("2_Degree", "2"),  # CxF3
        ("10º", "10"),
        ("CIE 1931", "2"),
        ("CIE 1964", "10"),
        ("CIE 15:2004, 2 degree", "2"),
        ("two", "2"),
        ("TEN", "10"),
        ("D50/2", "2"),
        ("D65/10", "10"),
        ("1955_2", None),
        ("1955_10", None),
        ("1978_2", None),
        ("2012_2", None),
        ("2012_10", None),
        ("shaw", None),
        ("Judd-Vos", None),
        ("CIE 170-2:2015 10 degree", None),
        ("CIE 1931 10 degree", None),
        ("2 10", None),
        ("0.2", None),
        ("4", None),
        ("", None),
        ("9" * 10_000, None),
    ],
)
def test_spellings(text, observer):
    assert declared_observer(text) == observer


PRESS_BANDS = tuple(float(nm) for nm in range(380, 740, 10))


@pytest.mark.parametrize(
    ("illuminant", "observer", "steps", "white"),
    [  # ASTM E308-18, table 5: white points of the weights
        ("A", 2, (5, 10, 20), (109.850, 35.585)),
        ("D50", 2, (5, 10, 20), (96.422, 82.521)),
        ("D65", 2, (5, 10, 20), (95.047, 108.883)),
        ("D50", 10, (5, 10, 20), (96.720, 81.427)),
        ("D65", 10, (10, 20), (94.811, 107.304)),
        # CIE 15 tabulates these illuminants in steps of 5 nm; between, interpolations differ.
        ("C", 2, (5,), (98.074, 118.232)),
        ("FL11", 2, (5,), (100.962, 64.350)),
    ],
)
@pytest.mark.slow
def test_the_weights_add_up_to_the_published_white(illuminant, observer, steps, white):
    for step in steps:
        bands = tuple(float(nm) for nm in range(380, 740, step))
        x, y, z = 100 * tristimulus_weights(bands, illuminant, observer).sum(axis=0)
        assert y == pytest.approx(100)
        assert (x, z) == pytest.approx(white, abs=0.02)


@pytest.mark.parametrize("illuminant", ILLUMINANTS)
@pytest.mark.parametrize("observer", OBSERVERS)
def test_the_perfect_diffuser_is_the_white(illuminant, observer):
    xyz, scale = reflectance_xyz(
        np.array(PRESS_BANDS), np.full((1, 36), 100.0), illuminant, observer
    )
    white = white_of(illuminant, str(observer))
    assert scale == 100
    np.testing.assert_allclose(xyz[0], white, rtol=1e-12)
    np.testing.assert_allclose(xyz_to_lab(xyz, white)[0], [100, 0, 0], atol=1e-9)


@pytest.mark.parametrize("bands", [
    np.arange(380, 731, 1.0), np.arange(380, 732, 4.0), np.arange(383, 733, 10.0),
    np.arange(380, 731, 5.0), np.linspace(380, 730, 106), np.arange(300, 1000, 10.0),
    np.array([380, 395, 420, *range(430, 735, 10)], float),
])  # fmt: skip
def test_a_smooth_spectrum_has_one_colour_however_it_is_sampled(bands):
    """ASTM E308 itself is accurate to a few hundredths of ΔE for smooth spectra."""

    def smooth(wavelengths):
        return 0.1 + 0.8 / (1 + np.exp(-(np.asarray(wavelengths) - 580) / 30))

    expected, _ = reflectance_xyz(np.array(PRESS_BANDS), smooth(PRESS_BANDS)[None], "D50", 2)
    found, _ = reflectance_xyz(bands, smooth(bands)[None], "D50", 2)
    assert np.linalg.norm(xyz_to_lab(found) - xyz_to_lab(expected)) < 0.1


def test_lights_in_candela_per_square_metre():
    """Of 1 W/(m² sr nm) at all wavelengths: 683 lm/W times the functions' sums (CIE 15)."""
    for bands in (np.arange(360, 785, 5.0), np.arange(360, 781, 1.0)):
        xyz = emission_xyz(bands, np.ones((1, len(bands))), 2)
        assert xyz[0, 1] == pytest.approx(683 * 106.857, rel=1e-4)
    assert xyz[0] / 683 == pytest.approx([106.865, 106.857, 106.892], rel=1e-4)


def test_a_narrow_light_has_the_chromaticity_of_its_wavelength():
    """CIE 15:2018, table 1, at 550 nm."""
    bands = np.arange(360, 781, 1.0)
    x, y, z = emission_xyz(bands, (bands == 550)[None].astype(float), 2)[0]
    assert (x / (x + y + z), y / (x + y + z)) == pytest.approx((0.3016, 0.6923), abs=2e-4)
