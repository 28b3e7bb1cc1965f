"""Colours of measured samples: media, whites, illuminants, observers, adaptation, spectra."""

import json
from dataclasses import replace

import numpy as np
import pytest

from gamutcore.characterisation import read_characterisation
from gamutcore.colours import (
    ICC_D50,
    ILLUMINANTS,
    OBSERVERS,
    lab_to_xyz,
    surface_colours,
    xyz_to_lab,
)
from gamutcore.colours.measured import emission_xyz, reflectance_xyz, tristimulus_weights
from gamutcore.errors import InvalidPointsError, OptionError

D65 = np.array([0.95047, 1.0, 1.08883])
RED_D65 = np.array([0.4124564, 0.2126729, 0.0193339])
"""sRGB's red, D65 (Lindbloom's table of RGB working spaces)."""
RED_D50 = [54.29, 80.81, 69.89]
"""sRGB's red in CIELAB D50 (Lindbloom; also what image editors show)."""
PAPER, INK = np.array([0.8448, 0.8762, 0.7457]), np.array([0.14, 0.22, 0.53])


def samples(columns, rows, **members):
    rows = [list(map(float, row)) for row in rows]
    document = {"columns": columns.split(), "samples": rows, **members}
    return read_characterisation(json.dumps(document).encode())


def display(white=D65, scale=100.0, **members):
    """White, red and black: too few samples for a model, so their own colours are the surface."""
    rows = [[255, 255, 255, *(white * scale)], [255, 0, 0, *(RED_D65 * scale)], [0, 0, 0, 0, 0, 0]]
    return samples("R G B X Y Z", rows, **members)


def press(scale=100.0, **members):
    """Paper and one mixture of inks: too few samples for a model as well."""
    rows = [[0, 0, 0, 0, *(PAPER * scale)], [100, 60, 30, 10, *(INK * scale)]]
    return samples("CMYK_C CMYK_M CMYK_Y CMYK_K XYZ_X XYZ_Y XYZ_Z", rows, **members)


class Medium:
    """Colours of samples by their device value, and what is said of them."""

    def __init__(self, data, intent, **options):
        found = surface_colours(data, intent=intent, **options)
        self.lab, self.provenance = found.points, found.provenance
        self.as_measured = found.as_measured
        if found.device is not None:
            ends = np.argsort(
                found.device.sum(axis=1)
            )  # black and red, or paper and ink, come last
            self.lab = found.points[ends[::-1] if data.additive else ends]
        self.warnings = [
            said
            for said in found.provenance["warnings"]
            if not said.startswith("No device model") and "optimal colour solid" not in said
        ]


@pytest.mark.parametrize("scale", [1.0, 100.0, 250.0])
def test_a_display_relative_to_its_white_and_as_measured(scale):
    medium = Medium(display(scale=scale), "relative")
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)
    np.testing.assert_allclose(medium.lab[1], RED_D50, atol=0.05)
    assert "Bradford" in medium.provenance["adaptation"]
    assert medium.provenance["medium"] == "display (assumed, not stated)"
    assert "assumed to be a display's" in medium.warnings[0]
    np.testing.assert_allclose(medium.provenance["white"], D65 * scale)
    measured = Medium(display(scale=scale), "absolute")
    np.testing.assert_allclose(measured.lab[:2], xyz_to_lab(np.array([D65, RED_D65])), atol=1e-9)
    assert measured.provenance["adaptation"].startswith("none")


@pytest.mark.parametrize("scale", [1.0, 100.0])
def test_a_press_relative_to_its_paper_and_as_measured(scale):
    medium = Medium(press(scale), "relative")
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-6)
    # ICC media-relative: each of X, Y, Z by its own ratio.
    np.testing.assert_allclose(lab_to_xyz(medium.lab[1]), INK * ICC_D50 / PAPER, atol=1e-9)
    assert medium.provenance["medium"] == "reflective"
    measured = Medium(press(scale), "absolute")
    np.testing.assert_allclose(lab_to_xyz(measured.lab[1]), INK, atol=1e-9)


@pytest.mark.parametrize(
    ("conditions", "medium"),
    [
        ({"device_class": "DISPLAY"}, "display"),
        ({"cgv_display_type": "EMISSIVE"}, "display"),
        ({"cgv_display_type": "REFLECTIVE"}, "reflective"),
        ({"device_class": "OUTPUT"}, "reflective"),
        ({"color_rep": "iRGB_XYZ"}, "reflective"),
        ({"measurement_condition": "M1"}, "reflective"),
    ],
)
def test_a_stated_medium_is_not_an_assumption(conditions, medium):
    found = Medium(display(scale=0.9, **conditions), "relative")
    assert found.provenance["medium"] == medium
    assert found.warnings == []


def test_absolute_lab_of_a_press_is_untouched():
    lab = [[95, 0, -2], [20, 3, 4]]
    rows = [[0, 0, 0, *lab[0]], [9, 5, 1, *lab[1]]]
    medium = Medium(samples("CMY_C CMY_M CMY_Y L A B", rows), "absolute")
    np.testing.assert_array_equal(medium.lab, lab)
    paper = xyz_to_lab(np.array(medium.provenance["white"]))
    np.testing.assert_allclose(paper, lab[0], atol=1e-3)
    assert medium.warnings == []


def test_without_a_white_patch_a_sample_beside_it_is_taken_and_said():
    rows = [[250, 255, 255, 92, 98, 107], [255, 0, 0, 40, 21, 2], [0, 255, 0, 36, 72, 12]]
    rows.append([0, 0, 255, 18, 7, 95])
    medium = Medium(samples("R G B X Y Z", rows), "relative")
    assert any("white was not measured" in said for said in medium.warnings)
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)


def test_a_declared_white_wins():
    data = samples("R G B X Y Z", [[255, 0, 0, *(RED_D65 * 80)]], white=list(D65 * 80))
    np.testing.assert_allclose(Medium(data, "relative").lab, [RED_D50], atol=0.05)


def test_bare_colours_are_taken_as_they_are():
    data = samples("L a b", [[50, 10, -10]])
    medium = Medium(data, "relative")
    np.testing.assert_array_equal(medium.lab, [[50, 10, -10]])
    assert medium.provenance["medium"] == "unknown"
    assert medium.provenance["white"] is None
    assert medium.provenance["intent"] == "none: the colours as given"
    assert "not made relative" in medium.warnings[0]
    with pytest.raises(OptionError) as caught:
        surface_colours(data, intent="absolute")
    assert caught.value.where == {"field": "intent"}
    assert len(Medium(replace(data, white=D65), "absolute").lab) == 1


@pytest.mark.parametrize("scale", [1.0, 100.0])
def test_bare_tristimulus_values_of_either_scale(scale):
    data = samples("X Y Z", np.array([ICC_D50, ICC_D50 / 2]) * scale)
    np.testing.assert_allclose(Medium(data, "relative").lab[0], [100, 0, 0], atol=1e-9)


def test_a_luminance_that_no_reflectance_has_is_the_whites():
    medium = Medium(samples("X Y Z", [ICC_D50 * 300, ICC_D50]), "relative")
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)
    assert any("largest Y is 300" in said for said in medium.warnings)


@pytest.mark.parametrize(
    ("illuminant", "observer", "white"),
    [  # ASTM E308, table 5
        ("D65", "2", (0.95047, 1, 1.08883)),
        ("D65", "10", (0.94811, 1, 1.07304)),
        ("a", "2", (1.09850, 1, 0.35585)),
        ("F11", "2", (1.00962, 1, 0.64350)),
    ],
)
def test_the_white_of_an_illuminant_is_that_of_d50_after_adaptation(illuminant, observer, white):
    data = samples("X Y Z", [np.array(white) * 100], illuminant=illuminant, observer=observer)
    medium = Medium(data, "relative")
    np.testing.assert_allclose(medium.lab, [[100, 0, 0]], atol=0.06)
    assert medium.provenance["adaptation"] == f"Bradford from {illuminant.upper()} to D50"


ASSUMED = "2° (assumed, not stated)"
UNKNOWN = "2° (assumed, the one that is stated is not known)"


@pytest.mark.parametrize(
    ("conditions", "illuminant", "observer"),
    [
        ({"illuminant": "D65", "observer": "10 degree"}, "D65", "10°"),
        ({"weighting_function": "ILLUMINANT, D50"}, "D50", ASSUMED),
        ({"measurement_source": "Illumination=D50 ObserverAngle=2° WhiteBase=Abs"}, "D50", "2°"),
        ({"instrumentation": "D50, 2 degree, geometry 45/0"}, "D50", "2°"),
        ({"illuminant": "A", "observer": "2"}, "A", "2°"),
        ({"illuminant": "candle"}, "D50 (assumed, not stated)", ASSUMED),
        ({"illuminant": "F44"}, "D50 (assumed)", ASSUMED),
        ({"cie_observer": "1964", "cie_observer_angle": "10"}, None, "10°"),
        ({}, None, ASSUMED),
        *[
            ({"observer": text}, None, "2°")
            for text in (
                "1931_2",  # Argyll, `spotread -Q`; DisplayCAL writes the same
                "2", "2 degree", "2°", "2\ufffd",
                "2_Degree",  # CxF3
                "CIE 1931", "CIE 15:2004, 2 degree", "two", "D50/2",
            )
        ],
        *[
            ({"observer": text}, None, "10°")
            for text in ("1964_10", "10.0", "10deg", "10º", "CIE 1964", "TEN", "D65/10")
        ],
        *[
            ({"observer": text}, None, UNKNOWN)
            for text in (
                "1955_2", "1955_10", "1978_2", "2012_2", "2012_10", "shaw", "Judd-Vos", "moon",
                "CIE 170-2:2015 10 degree", "CIE 1931 10 degree", "2 10", "0.2", "4", "9" * 10_000,
            )
        ],
        ({"observer": ""}, None, ASSUMED),
    ],
)  # fmt: skip
def test_illuminant_and_observer_are_found(conditions, illuminant, observer):
    medium = Medium(press(**conditions), "absolute")
    assert medium.provenance["illuminant"] == (illuminant or "D50 (assumed, not stated)")
    assert medium.provenance["observer"] == observer
    stated = conditions.get("observer", "")
    told = any(stated[:40] in said and "2° is used" in said for said in medium.warnings)
    assert told == (observer == UNKNOWN)


def test_columns_that_disagree_are_warned_of():
    rows = [[0, 0, 0, 90, 0, 0, 20, 20, 20], [1, 0, 0, 50, 0, 0, 20, 20, 20]]
    medium = Medium(samples("CMY_C CMY_M CMY_Y L A B X Y Z", rows), "absolute")
    assert "differ" in medium.warnings[0]


def test_intents_of_profiles_are_refused():
    for intent in ("perceptual", "saturation"):
        with pytest.raises(OptionError, match="profiles") as caught:
            surface_colours(press(), intent=intent)
        assert caught.value.where == {"field": "intent"}


def test_a_white_without_light_is_refused():
    data = samples("R G B X Y Z", [[255, 255, 255, 0, 0, 0], [0, 0, 0, 0, 0, 0]])
    with pytest.raises(InvalidPointsError):
        surface_colours(data)


BANDS = [f"SPEC_{nm}" for nm in range(380, 740, 10)]


def spectral(device="CMYK_C CMYK_M CMYK_Y CMYK_K", white=(0, 0, 0, 0), colours="", **members):
    """Return a white and a dark patch, with spectra that fall towards blue."""
    slope = np.linspace(0.6, 0.9, 36)
    dark = tuple(1 - (value or 0) for value in white) if max(white) <= 1 else (0,) * len(white)
    given = [[95.0, 0, -2], [20, 0, 0]] if colours else [[], []]
    rows = [[*white, *given[0], *slope], [*dark, *given[1], *(slope * 0.1)]]
    return samples(" ".join([device, colours, *BANDS]), rows, **members)


@pytest.mark.parametrize("illuminant", ["A", "D65", "FL11"])
def test_the_paper_is_white_under_any_illuminant(illuminant):
    medium = Medium(spectral(), "relative", illuminant=illuminant)
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("stated", "asked", "illuminant", "observer"),
    [
        ({}, {}, "D50 (usual)", "2° (usual)"),
        ({}, {"observer": 10, "illuminant": "A"}, "A (asked for)", "10° (asked for)"),
        ({"OBSERVER": "10"}, {}, "D50 (usual)", "10° (stated)"),
        ({"OBSERVER": "1964_10", "ILLUMINANT": "A"}, {}, "A (stated)", "10° (stated)"),
        ({"ILLUMINANT": "F11"}, {}, "FL11 (stated)", "2° (usual)"),
        ({"OBSERVER": "10"}, {"observer": 2}, "D50 (usual)", "2° (asked for)"),
        ({"ILLUMINANT": "A"}, {"illuminant": "D50"}, "D50 (asked for)", "2° (usual)"),
        ({"ILLUMINANT": "moon"}, {}, "D50 (usual)", "2° (usual)"),
    ],
)
def test_spectra_alone_are_seen_as_their_file_states(stated, asked, illuminant, observer):
    medium = Medium(spectral(conditions=stated), "absolute", **asked)
    said = medium.provenance["colours_from"]
    assert said.startswith("SPECTRUM, ASTM E308")
    assert f"observer {observer}, illuminant {illuminant}, reflectances" in said
    name, degrees = illuminant.split()[0], int(observer.split("°")[0])
    same = Medium(spectral(), "absolute", observer=degrees, illuminant=name)
    np.testing.assert_array_equal(medium.lab, same.lab)
    assert medium.provenance["illuminant"] == name
    assert medium.provenance["observer"] == f"{degrees}°"
    usual = Medium(spectral(), "absolute")
    assert np.allclose(usual.lab, medium.lab, atol=0.1) == ((name, degrees) == ("D50", 2))
    if name != "D50":
        assert medium.provenance["adaptation"] == f"Bradford from {name} to D50"


@pytest.mark.parametrize(
    ("conditions", "asked", "source"),
    [
        ({"ILLUMINANT": "D50"}, {}, "LAB"),
        ({"ILLUMINANT": "D50"}, {"observer": 2}, "observer 2° (asked for), illuminant D50 (usual)"),
        # what is stated beside colours is of the colours
        ({"ILLUMINANT": "D65"}, {}, "observer 2° (usual), illuminant D50 (usual)"),
        (
            {"ILLUMINANT": "D65", "OBSERVER": "10"},
            {},
            "observer 2° (usual), illuminant D50 (usual)",
        ),
        ({"ILLUMINANT": "D50", "OBSERVER": "2012_2"}, {}, "observer 2° (usual)"),
        ({"ILLUMINANT": "D50", "OBSERVER": "2012_2"}, {"observer": 10}, "observer 10°"),
    ],
)
def test_stated_colours_give_way_to_spectra_where_they_are_of_other_conditions(
    conditions, asked, source
):
    both = spectral(colours="LAB_L LAB_A LAB_B", conditions=conditions)
    medium = Medium(both, "absolute", **asked)
    assert source in medium.provenance["colours_from"]
    if source == "LAB":
        np.testing.assert_allclose(medium.lab[0], [95, 0, -2])
    else:
        assert medium.lab[0, 2] > 5
    told = any("2012_2" in said for said in medium.warnings)
    assert told == (conditions.get("OBSERVER") == "2012_2" and not asked)


def test_colours_without_spectra_cannot_be_seen_otherwise():
    for given in ({"observer": 10}, {"illuminant": "D65"}):
        with pytest.raises(OptionError) as caught:
            surface_colours(press(), **given)
        assert list(given) == [caught.value.where["field"]]
    own = Medium(press(), "relative", observer=2, illuminant="D50")
    assert own.provenance["observer"] == ASSUMED


@pytest.mark.parametrize("stated", [{"OBSERVER": "1964_10"}, {}])
def test_lights_have_an_observer_and_no_illuminant(stated):
    light = spectral("R G B", (255, 255, 255), conditions={"DEVICE_CLASS": "DISPLAY", **stated})
    medium = Medium(light, "relative", observer=None if stated else 10)
    assert medium.provenance["medium"] == "display"
    assert medium.provenance["observer"] == "10°"
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)
    assert medium.warnings == []
    with pytest.raises(OptionError, match="illuminant"):
        surface_colours(light, illuminant="D65")


def test_spectra_of_rgb_values_are_lights_unless_something_says_otherwise():
    unsaid = Medium(spectral("R G B", (255, 255, 255)), "relative")
    assert unsaid.provenance["medium"] == "display (assumed, not stated)"
    assert any("DEVICE_CLASS OUTPUT" in said for said in unsaid.warnings)
    for said in ({"DEVICE_CLASS": "OUTPUT"}, {"MEASUREMENT_CONDITION": "M1"}):
        printed = spectral("R G B", (255, 255, 255), conditions=said)
        assert Medium(printed, "relative").provenance["medium"] == "reflective"


@pytest.mark.parametrize("adaptation", ["CAT02", "CAT16", "von-Kries", "XYZ-scaling"])
def test_another_adaptation_takes_the_white_to_d50_as_well(adaptation):
    medium = Medium(display(), "relative", adaptation=adaptation)
    np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)
    assert medium.provenance["adaptation"].startswith(f"{adaptation} from the white to D50")
    assert np.abs(medium.lab[1] - Medium(display(), "relative").lab[1]).max() > 0.1
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
        assert Medium(data, intent).provenance.get("white_luminance") == expected
    printed = press(conditions={"LUMINANCE_XYZ_CDM2": stated})
    assert "white_luminance" not in Medium(printed, "relative").provenance


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


@pytest.mark.parametrize(
    "illuminant",
    [
        each if each in {"A", "D50", "D65", "FL11"} else pytest.param(each, marks=pytest.mark.slow)
        for each in ILLUMINANTS
    ],
)
def test_the_perfect_diffuser_is_the_white(illuminant):
    rows = [[0, 0, 0, *[100.0] * 36], [9, 5, 1, *[50.0] * 36]]
    data = samples(" ".join(["CMY_C CMY_M CMY_Y", *BANDS]), rows)
    for observer in OBSERVERS:
        medium = Medium(data, "absolute", observer=observer, illuminant=illuminant)
        np.testing.assert_allclose(medium.lab[0], [100, 0, 0], atol=1e-9)


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
