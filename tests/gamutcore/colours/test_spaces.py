"""Colour spaces: parameters, declarations of files, conversion, and display."""

import contextlib
import json
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from gamutcore import Gamut, Options
from gamutcore.characterisation import read_characterisation
from gamutcore.colours import (
    ICC_D50,
    SurfaceColours,
    colours_in_space,
    lab_to_xyz,
    surface_colours,
    xyz_to_lab,
)
from gamutcore.colours.colorimetry import colour_science
from gamutcore.colours.spaces import (
    CIELAB,
    SPACES,
    ColourConversion,
    ColourSpace,
    linear_srgb,
    srgb,
)
from gamutcore.errors import GamutError, InvalidPointsError, MeshError, OptionError

WHITES = ("A", "C", "D50", "D55", "D60", "D65", "D75", "DCI", "E")
ADAPTATIONS = ("Bradford", "CAT02", "CAT16", "von-Kries", "XYZ-scaling")
ABSOLUTE = {"ICtCp", "ITP", "Jzazbz"}
APPEARANCE = {"CAM16-UCS", "CAM02-UCS"}
D65 = ColourSpace(reference_white="D65").white
# sRGB: IEC 61966-2-1's primaries for the D65 of x 0.3127, y 0.3290
PRIMARIES = np.array([(0.64, 0.33, 0.03), (0.30, 0.60, 0.10), (0.15, 0.06, 0.79)]).T
SRGB_TO_XYZ = PRIMARIES * np.linalg.solve(PRIMARIES, D65)


def light(encoded):
    """Tristimulus values of an ideal sRGB display."""
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return linear @ SRGB_TO_XYZ.T


def display(intent, **options):
    """Colours of a measured sRGB display of 250 cd/m², too few for a model of the device."""
    rgb = np.array([(1.0, 1, 1), (0.2, 0.7, 0.4), (0.9, 0.1, 0.3)])
    document = {
        "columns": ["R", "G", "B", "X", "Y", "Z"],
        "samples": np.concatenate([rgb, 250.0 * light(rgb)], axis=1).tolist(),
        "conditions": {"DEVICE_CLASS": "DISPLAY"},
    }
    found = surface_colours(
        read_characterisation(json.dumps(document).encode()), intent=intent, **options
    )
    assert len(found.points) == len(rgb)
    return found


def real_colours(count=500):
    """CIELAB, D50, of colours of sRGB."""
    rgb = np.random.default_rng(0).random((count, 3))
    return xyz_to_lab(ColourSpace("CIEXYZ", "D65").tristimulus(light(rgb)))


def parameters(name):
    own = SPACES[name].parameters
    return st.fixed_dictionaries(
        {},
        optional={
            "reference_white": st.sampled_from(WHITES)
            | st.tuples(st.floats(0.8, 1.2), st.just(1.0), st.floats(0.3, 1.5)),
            "adaptation": st.sampled_from(ADAPTATIONS),
            **({"luminance": st.floats(1.0, 10_000.0)} if "luminance" in own else {}),
            **(
                {
                    "adapting_luminance": st.floats(0.1, 1000.0),
                    "background": st.floats(5.0, 60.0),
                    "surround": st.sampled_from(["average", "dim", "dark"]),
                }
                if "surround" in own
                else {}
            ),
        },
    )


@given(st.sampled_from(sorted(SPACES)).flatmap(lambda n: st.tuples(st.just(n), parameters(n))))
@pytest.mark.slow
def test_real_colours_come_back(drawn):
    """CIECAM02 fails for some blues under unusual conditions, which is reported."""
    name, given_parameters = drawn
    space, lab = ColourSpace(name, **given_parameters), real_colours()
    coordinates, moved = space.coordinates(lab)
    assert moved == 0 or name in APPEARANCE | ABSOLUTE | {"CIELUV"}
    if moved == 0:
        np.testing.assert_allclose(space.appearance_lab(coordinates), lab, atol=2e-4)


@given(
    st.sampled_from(sorted(SPACES)),
    arrays.arrays(float, (4, 3), elements=st.floats(-1e6, 1e6)),
)
@pytest.mark.slow
def test_whatever_is_sent_is_finite_or_refused(name, lab):
    with contextlib.suppress(InvalidPointsError):
        coordinates, moved = ColourSpace(name).coordinates(lab)
        assert np.isfinite(coordinates).all()
        assert 0 <= moved <= 4


def test_a_refusal_names_the_first_colour_that_is_refused():
    lab = np.array([(50.0, 0.0, 0.0), (1e200, 0.0, 0.0)])
    with pytest.raises(InvalidPointsError) as caught:
        ColourSpace("Oklab").coordinates(lab)
    assert caught.value.where == {"row": 1}
    assert caught.value.remedy


@given(
    st.sampled_from(sorted(SPACES)),
    arrays.arrays(np.float32, (4, 3), elements=st.floats(-(2.0**40), 2.0**40, width=32)),
)
def test_whatever_is_shown_is_finite(name, coordinates):
    shown = ColourSpace(name).appearance_lab(coordinates)
    assert np.isfinite(shown).all()
    assert shown.dtype == np.float32
    assert shown.flags.c_contiguous


@pytest.mark.parametrize("name", SPACES)
def test_the_description_names_all_that_coordinates_depend_on(name):
    space = ColourSpace(name)
    described = space.description()
    json.dumps(described, allow_nan=False)
    assert {"name", "axes", "reference_white", "adaptation", "source"} <= set(described)
    assert set(SPACES[name].parameters) <= set(described)
    assert described["reference_white_xyz"][1] == 1.0
    (white,), _ = space.coordinates(np.array([[100.0, 0.0, 0.0]]))
    np.testing.assert_allclose(white, described["white_coordinates"], atol=1e-5)


@pytest.mark.parametrize("white", [*WHITES, (0.95, 1.0, 1.2)])
def test_the_white_of_spaces_that_take_any_is_neutral(white):
    for name in ("CIELAB", "CIELUV", "DIN99o"):
        coordinates, _ = ColourSpace(name, white).coordinates(np.array([[100.0, 0.0, 0.0]]))
        np.testing.assert_allclose(coordinates, [[100.0, 0.0, 0.0]], atol=1e-9)


@pytest.mark.parametrize("adaptation", ADAPTATIONS)
def test_a_display_comes_back_to_its_own_white_exactly(adaptation):
    """Adaptation from D65 to D50 and back to D65 is the identity."""
    found = display("relative", adaptation=adaptation)
    space = ColourSpace("CIEXYZ", "D65", adaptation)
    points = colours_in_space(found, space).points
    np.testing.assert_allclose(points, light(found.device), atol=1e-9)


@pytest.mark.parametrize("name", ["CIEXYZ", "ICtCp", "Oklab"])
@pytest.mark.parametrize("white", ["D50", "D65"])
def test_absolute_colours_of_a_display_are_as_measured(name, white):
    found = display("absolute")
    assert found.as_measured
    expected, _ = ColourSpace(name).from_tristimulus(light(found.device), as_measured=True)
    placed = colours_in_space(found, ColourSpace(name, white))
    np.testing.assert_allclose(placed.points, expected, atol=1e-8)
    assert placed.provenance["colour_space"]["adaptation"].endswith("as measured")


def test_without_adaptation_colours_are_taken_as_they_are():
    lab = real_colours()
    coordinates, _ = ColourSpace("CIEXYZ", "D65", "none").coordinates(lab)
    np.testing.assert_allclose(coordinates, lab_to_xyz(lab), atol=1e-12)


def test_what_is_shown_is_seen_by_an_eye_that_is_adapted_to_the_white():
    for adaptation in (*ADAPTATIONS, "none"):
        shown = ColourSpace("CIEXYZ", "D65", adaptation).appearance_lab(D65[np.newaxis])
        np.testing.assert_allclose(shown, [[100.0, 0.0, 0.0]], atol=1e-4)


def test_colours_outside_the_domain_of_a_space_are_told():
    lab = np.array([(50.0, 0.0, 0.0), (40.0, 10.0, 200.0), (100.0, 0.0, 0.0)])
    colours = SurfaceColours(lab, None, {"warnings": ["first"], "white": [1, 1, 1]})
    found = colours_in_space(colours, ColourSpace("ICtCp", luminance=1000.0))
    assert found.provenance["white"] == [1, 1, 1]
    assert found.provenance["axes"] == "I Ct Cp"
    assert found.provenance["colour_space"]["luminance"] == 1000.0
    first, second = found.provenance["warnings"]
    assert first == "first"
    assert second.startswith("1 of 3 colours")
    same = colours_in_space(colours, CIELAB)
    assert same.points is lab
    assert same.provenance["warnings"] == ["first"]
    assert same.provenance["colour_space"]["reference_white_xyz"] == ICC_D50.tolist()


@pytest.mark.parametrize("name", SPACES)
def test_lightness_is_shown_upwards(name):
    *axis, cosine = ColourSpace(name).rotation
    up = np.eye(3)[SPACES[name].lightness]
    rotated = up + 2 * np.cross(axis, np.cross(axis, up) + cosine * up)
    np.testing.assert_allclose(rotated, (0, 1, 0), atol=1e-12)
    assert np.linalg.norm([*axis, cosine]) == pytest.approx(1.0)


@pytest.mark.parametrize("name", SPACES)
def test_the_defaults_of_options_are_those_of_the_space(name):
    space = Options(space=name).colour_space()
    assert space.description() == ColourSpace(name).description()
    if name != "CIELAB":
        own = {"luminance"} if name in ABSOLUTE else set()
        own |= {"adapting_luminance", "background", "surround"} if name in APPEARANCE else set()
        names = {field.name for field in fields(space) if getattr(space, field.name) is not None}
        assert names == {"name", "reference_white", "adaptation"} | own


@pytest.mark.parametrize(
    ("space", "name", "value"),
    [
        *[("CIELAB", name, 10.0) for name in ("luminance", "adapting_luminance", "background")],
        ("Oklab", "luminance", 100),
        ("ICtCp", "surround", "average"),
        *[("ICtCp", "luminance", value) for value in (0, 10_001, "100", True, float("nan"))],
        ("ICtCp", "luminance", 10**400),
        ("CAM16-UCS", "adapting_luminance", 0),
        *[("CAM16-UCS", "background", value) for value in (0, 101)],
        *[("CAM16-UCS", "surround", value) for value in ("bright", ["dim"])],
        *[
            ("CIELAB", "reference_white", value)
            for value in (
                "D51", "D5 0 0", "", 50, [1, 1], [1, 0, 1], [0, 1, 1], [1, 1, -1], [1, 1, "1"],
                [1, 1, float("inf")], [1e300, 1e-300, 1], {"X": 1}, True, [9, 1, 1],
                [3, 1, 0.2], [0.2, 1, 3],
            )
        ],
        *[("CIELAB", "adaptation", value) for value in ("brad", "", 1, ["CAT02"])],
    ],
)  # fmt: skip
def test_what_is_not_accepted_is_named(space, name, value):
    with pytest.raises(OptionError) as caught:
        Options.from_mapping({"space": space, name: value})
    assert caught.value.where == {"field": name}
    assert caught.value.remedy


@given(
    st.sampled_from(sorted(SPACES)),
    st.tuples(st.floats(0.05, 6), st.just(1.0), st.floats(0.05, 6)),
    st.sampled_from([*ADAPTATIONS, "none"]),
    st.sampled_from([0.0, 1.0]),
)
def test_every_space_works_with_all_that_is_accepted(name, white, adaptation, end):
    own = {"luminance": (0.1, 1e4), "adapting_luminance": (0.01, 1e4), "background": (1.0, 100.0)}
    extremes = {key: own[key][int(end)] for key in own if key in SPACES[name].parameters}
    asked = {"reference_white": white, "adaptation": adaptation, **extremes}
    with contextlib.suppress(OptionError):
        space = Options(space=name, **asked).colour_space()
        json.dumps(space.description(), allow_nan=False)
        lab = np.array([(0, 0, 0), (50, 60, -20), (100, 0, 0), (80, -80, 80.0)])
        coordinates, _ = space.coordinates(lab)
        assert np.isfinite(coordinates).all()
        assert np.isfinite(space.appearance_lab(coordinates)).all()


def mesh_gamut(size=60.0, notes=None, **options):
    """Gamut of a tetrahedron in a file with these notes."""
    lines = [f"# {name}: {text}" for name, text in (notes or {}).items()]
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    lines += [f"v {x * size!r} {y * size!r} {z * size!r}" for x, y, z in corners]
    lines += ["f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    return Gamut("\n".join(lines).encode(), **options)


@pytest.mark.parametrize("name", [*SPACES, "cielab", " Lab ", "CIE  LAB", "OKLAB", "ictcp"])
def test_a_file_may_name_its_space_in_the_usual_spellings(name):
    space = " ".join(name.split())
    gamut = mesh_gamut(notes={"space": name}, space=space)
    assert gamut.colour_space == Options(space=space).colour_space()
    assert gamut.description["provenance"]["colour_space"]["from"] == "the file"


@pytest.mark.parametrize(
    ("space", "field", "text"),
    [
        ("sRGB", "space", ""),
        ("x" * 400, "space", ""),
        ("Oklab", "scale", "100"),  # of older versions
        ("CIELAB", "scale", "nan"),
        ("CIELAB", "reference_white", "1 2"),
        ("CIELAB", "reference_white", "D5"),
        ("ICtCp", "luminance", "bright"),
        ("ICtCp", "luminance", "measured"),
        ("CAM16-UCS", "surround", "blue"),
    ],
)
def test_declarations_that_are_none_are_refused(space, field, text):
    with pytest.raises(MeshError) as caught:
        mesh_gamut(notes={field: text, "space": space})
    assert caught.value.where["field"] == field
    assert len(caught.value.message) < 200


@pytest.mark.parametrize(
    ("notes", "options"),
    [
        ({"scale": "2", "luminance": "x"}, {}),  # nothing is stated without a space
        ({"space": "Oklab", "scale": "1.0"}, {"space": "Oklab"}),
        # how the colours were found is no parameter of the space
        ({"space": "CIELAB", "adaptation": "ICC media-relative", "luminance": "80"}, {}),
        (
            {"space": "ITP", "luminance": "measured", "white_luminance": "80.5"},
            {"space": "ITP", "luminance": 80.5},
        ),
        # a white is the same by name and by number
        (
            {"space": "Oklab", "reference_white": " ".join(map(repr, D65.tolist()))},
            {"space": "Oklab", "reference_white": "D65"},
        ),
    ],
)
def test_a_declared_space_is_that_of_the_same_options(notes, options):
    assert mesh_gamut(notes=notes, **options).colour_space == Options(**options).colour_space()


@pytest.mark.parametrize(
    ("notes", "options", "field"),
    [
        ({"space": "Oklab"}, {}, "space"),
        ({"space": "CIELAB"}, {"reference_white": "D65"}, "reference_white"),
        (
            {"space": "CIELAB", "reference_white": "D65"},
            {"reference_white": (D65[0], 1.0, D65[2] + 1e-6)},
            "reference_white",
        ),
    ],
)
def test_another_space_than_the_declared_one_is_refused(notes, options, field):
    with pytest.raises(OptionError) as caught:
        mesh_gamut(notes=notes, **options)
    assert caught.value.where == {"field": field}
    assert f"space '{notes['space']}'" in caught.value.remedy


def test_what_is_small_for_cielab_is_told():
    def told(*arguments, **options):
        warnings = mesh_gamut(*arguments, **options).description["provenance"]["warnings"]
        return any("space" in said for said in warnings)

    assert told(1.0)
    assert not told(1.0, space="Oklab")
    assert not told(60.0)


NOTES = ("reference_white", "adaptation", "scale", "luminance", "background", "surround")
TEXTS = (
    st.text(st.characters(exclude_categories=["C", "Z"]), max_size=20)
    | st.floats().map(repr)
    | st.just("1 1 1")
)


@settings(max_examples=40)
@given(st.sampled_from(list(SPACES)), st.dictionaries(st.sampled_from(NOTES), TEXTS))
def test_any_notes_are_read_or_refused(space, said):
    with contextlib.suppress(GamutError):
        gamut = mesh_gamut(notes={**said, "space": space}, space=space)
        assert gamut.colour_space.name == space


LAB = np.array([(50, 20, -30), (80, -10, 60), (30, 5, 5), (100, 0, 0)], float)


@pytest.mark.parametrize("gamut", list(SPACES))
@pytest.mark.parametrize("given", [*SPACES, "LCHab", "sRGB"])
def test_a_space_and_another_there_and_back(gamut, given):
    conversion = ColourConversion(given, ColourSpace(gamut))
    points, _ = ColourSpace(gamut).coordinates(LAB)
    back = conversion.to_gamut(conversion.from_gamut(points))
    np.testing.assert_allclose(back, points, rtol=1e-6, atol=2e-6 * abs(points).max())


@pytest.mark.parametrize("gamut", ["Oklab", "CAM16-UCS", "CIEXYZ", "CIELUV"])
def test_cielab_is_that_of_the_file_whatever_the_space(gamut):
    """A build converts the L*, a*, b* of a file in the same way."""
    space = ColourSpace(gamut)
    points, _ = space.coordinates(LAB)
    np.testing.assert_allclose(ColourConversion("lab", space).to_gamut(LAB), points, atol=1e-9)


def test_srgb_is_that_of_colour_science():
    """With Bradford from D65 to ICC's D50; the matrix of the standard is rounded to 4 digits."""
    rgb = np.array([(0.2, 0.5, 0.9), (1, 1, 1), (0.01, 0.0, 0.03)])
    colour = colour_science()
    d50 = colour.XYZ_to_xy(np.array([0.9642, 1.0, 0.8249]))
    xyz = colour.RGB_to_XYZ(
        rgb,
        "sRGB",
        illuminant=d50,
        chromatic_adaptation_transform="Bradford",
        apply_cctf_decoding=True,
    )
    expected = colour.XYZ_to_Lab(xyz, d50)
    found = ColourConversion("sRGB", CIELAB).to_gamut(rgb)
    np.testing.assert_allclose(found, expected, atol=0.05)


def test_lch_is_polar():
    lch = ColourConversion("CIE LCHab", CIELAB).from_gamut(LAB)
    hue = 360 - np.degrees(np.arctan(30 / 20))
    np.testing.assert_allclose(lch[0], (50, np.sqrt(1300), hue))


@given(st.lists(st.tuples(*[st.floats(-0.5, 1.5)] * 3), min_size=1, max_size=5))
def test_srgb_continues_beyond_its_gamut(rows):
    """The branches of IEC 61966-2-1 differ by 3e-8 where they meet: its constants are rounded."""
    conversion = ColourConversion("sRGB", CIELAB)
    rgb = np.array(rows)
    np.testing.assert_allclose(conversion.from_gamut(conversion.to_gamut(rgb)), rgb, atol=5e-8)


def test_values_of_a_display_are_not_adapted():
    """The white of sRGB is then X, Y, Z of D65 (IEC 61966-2-1)."""
    conversion = ColourConversion("sRGB", ColourSpace("CIEXYZ"), as_measured=True)
    white = conversion.to_gamut(np.ones((1, 3)))
    np.testing.assert_allclose(white, [[0.9505, 1.0, 1.089]], atol=2e-3)


def test_errors_name_the_space_or_the_row():
    with pytest.raises(OptionError):
        ColourConversion("HSV", CIELAB)
    with pytest.raises(InvalidPointsError) as caught:
        ColourConversion("Oklab", CIELAB).to_gamut(np.array([(1, 0, 0), (1e150, 0, 0)]))
    assert caught.value.where["row"] == 1


@pytest.mark.parametrize("convert", [linear_srgb, srgb])
def test_the_ends_of_the_display_are_met_and_what_cannot_be_shown_is_clipped(convert):
    lab = [(100, 0, 0), (0, 0, 0), (150, 0, 0), (-10, 0, 0), (50, 200, 0), (50, -200, 0)]
    shown = convert(np.array([*lab, (90, 0, -128)], float))
    np.testing.assert_allclose(shown[0], 1.0, atol=1e-6)
    np.testing.assert_array_equal(shown[[1, 3]], 0.0)
    np.testing.assert_allclose(shown[2], 1.0, rtol=1e-15)
    assert (shown >= 0).all()
    assert (shown <= 1).all()
    assert shown[4, 1] == 0.0
    assert shown[5, 0] == 0.0


SHOWN = st.tuples(st.floats(0, 100), st.floats(-128, 128), st.floats(-128, 128))


@given(st.lists(SHOWN, min_size=1, max_size=20))
@pytest.mark.slow
def test_all_shown_colours_are_those_of_colour_science(displayed, lab):
    points = np.array(lab)
    np.testing.assert_allclose(linear_srgb(points), displayed(points, encoded=False), atol=2e-6)
    np.testing.assert_allclose(srgb(points), displayed(points, encoded=True), atol=5e-5)
