"""Colour spaces: parameters, declarations of files, conversion, and display."""

import contextlib
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from gamutcore.characterisation import characterisation
from gamutcore.colours import colours_in_space
from gamutcore.colours.measured_colours import measured_colours
from gamutcore.colours.spaces import (
    CIELAB,
    SPACES,
    ColourSpace,
)
from gamutcore.colours.spaces.cielab import ICC_D50, colour_science, lab_to_xyz, xyz_to_lab
from gamutcore.colours.spaces.conversion import GIVEN_SPACE, ColourConversion
from gamutcore.colours.spaces.declared import (
    assumption_warnings,
    declared_space,
    refuse_far_vertices,
    refuse_other_space,
)
from gamutcore.colours.spaces.parameters import SPACE_PARAMETERS, space_parameters
from gamutcore.colours.spaces.srgb import D50_TO_LINEAR_SRGB, linear_srgb, srgb
from gamutcore.colours.spaces.white_points import ADAPTATIONS, WHITES, white_point
from gamutcore.colours.surface import SurfaceColours
from gamutcore.errors import GamutError, InvalidPointsError, MeshError, OptionError

D65 = white_point("D65")


ABSOLUTE = {"ICtCp", "ITP", "Jzazbz"}
APPEARANCE = {"CAM16-UCS", "CAM02-UCS"}
# sRGB: IEC 61966-2-1's primaries for the D65 of x 0.3127, y 0.3290
PRIMARIES = np.array([(0.64, 0.33, 0.03), (0.30, 0.60, 0.10), (0.15, 0.06, 0.79)]).T
SRGB_TO_XYZ = PRIMARIES * np.linalg.solve(PRIMARIES, D65)


def cube_surface(steps):
    """Device values on the six faces of the RGB cube, and triangles that are seen from outside."""
    line = np.linspace(0, 1, steps)
    u, v = (grid.ravel() for grid in np.meshgrid(line, line, indexing="ij"))
    first = np.arange(steps * steps).reshape(steps, steps)
    a, b, c, d = (
        part.ravel() for part in (first[:-1, :-1], first[1:, :-1], first[1:, 1:], first[:-1, 1:])
    )
    square = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    points, faces = [], []
    for axis in range(3):
        for side in (0.0, 1.0):
            face = np.roll(np.stack([np.full_like(u, side), u, v], 1), axis, axis=1)
            faces.append((square if side else square[:, ::-1]) + len(points) * steps * steps)
            points.append(face)
    return np.concatenate(points), np.concatenate(faces)


def linear(encoded):
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


@pytest.fixture(scope="module")
def cube():
    """Surface of sRGB's cube in XYZ, and its triangles."""
    rgb, faces = cube_surface(129)
    return linear(rgb) @ SRGB_TO_XYZ.T, faces


def srgb_display(rgb, scale=1.0):
    """Measured samples of an ideal sRGB display."""
    xyz = scale * linear(rgb) @ SRGB_TO_XYZ.T
    rows = np.concatenate([rgb, xyz], axis=1).tolist()
    return characterisation(
        json.dumps(
            {
                "columns": ["R", "G", "B", "X", "Y", "Z"],
                "samples": rows,
                "conditions": {"DEVICE_CLASS": "DISPLAY"},
            }
        ).encode()
    )


def real_colours(count=500, seed=0):
    """CIELAB, D50, of colours of sRGB."""
    rgb = np.random.default_rng(seed).random((count, 3))
    return measured_colours(srgb_display(np.vstack([rgb, np.ones((1, 3))])), "relative").lab


def parameters(name):
    own = SPACES[name].parameters
    return st.fixed_dictionaries(
        {},
        optional={
            "reference_white": st.sampled_from(sorted(WHITES))
            | st.tuples(st.floats(0.8, 1.2), st.just(1.0), st.floats(0.3, 1.5)),
            "adaptation": st.sampled_from(sorted(set(ADAPTATIONS) - {"none"})),
            "scale": st.floats(0.01, 1000.0),
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


class TestThereAndBack:
    @given(st.sampled_from(sorted(SPACES)).flatmap(lambda n: st.tuples(st.just(n), parameters(n))))
    @pytest.mark.slow
    def test_real_colours_come_back(self, drawn):
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
    def test_whatever_is_sent_is_finite_or_refused(self, name, lab):
        with contextlib.suppress(InvalidPointsError):
            coordinates, moved = ColourSpace(name).coordinates(lab)
            assert np.isfinite(coordinates).all()
            assert 0 <= moved <= 4

    def test_a_refusal_names_the_first_colour_that_is_refused(self):
        lab = np.array([(50.0, 0.0, 0.0), (1e200, 0.0, 0.0)])
        with pytest.raises(InvalidPointsError) as caught:
            ColourSpace("Oklab").coordinates(lab)
        assert caught.value.where == {"row": 1}
        assert caught.value.remedy

    @given(
        st.sampled_from(sorted(SPACES)),
        arrays.arrays(np.float32, (4, 3), elements=st.floats(-(2.0**40), 2.0**40, width=32)),
    )
    def test_whatever_is_shown_is_finite(self, name, coordinates):
        shown = ColourSpace(name).appearance_lab(coordinates)
        assert np.isfinite(shown).all()
        assert shown.dtype == np.float32
        assert shown.flags.c_contiguous


class TestWhite:
    @pytest.mark.parametrize("name", SPACES)
    def test_media_white_has_the_stated_coordinates(self, name):
        space = ColourSpace(name, scale=2.0)
        coordinates, _ = space.coordinates(np.array([[100.0, 0.0, 0.0]]))
        np.testing.assert_allclose(
            coordinates[0], space.description()["white_coordinates"], atol=1e-5
        )

    @pytest.mark.parametrize("white", [*WHITES, (0.95, 1.0, 1.2)])
    def test_the_white_of_spaces_that_take_any_is_neutral(self, white):
        for name in ("CIELAB", "CIELUV", "DIN99o"):
            coordinates, _ = ColourSpace(name, white).coordinates(np.array([[100.0, 0.0, 0.0]]))
            np.testing.assert_allclose(coordinates, [[100.0, 0.0, 0.0]], atol=1e-9)

    @pytest.mark.parametrize("adaptation", sorted(set(ADAPTATIONS) - {"none"}))
    def test_a_display_comes_back_to_its_own_white_exactly(self, adaptation):
        """Adaptation from D65 to D50 and back to D65 is the identity."""
        rgb = np.vstack([np.random.default_rng(1).random((50, 3)), np.ones((1, 3))])
        medium = measured_colours(srgb_display(rgb, 250.0), "relative", adaptation=adaptation)
        space = ColourSpace("CIEXYZ", "D65", adaptation)
        measured = linear(rgb) @ SRGB_TO_XYZ.T
        coordinates, _ = space.coordinates(medium.lab, as_measured=medium.as_measured)
        np.testing.assert_allclose(coordinates, measured, atol=1e-9)

    @pytest.mark.parametrize("name", ["CIEXYZ", "ICtCp", "Oklab"])
    @pytest.mark.parametrize("white", ["D50", "D65"])
    def test_absolute_colours_of_a_display_are_as_measured(self, name, white):
        rgb = np.vstack([np.random.default_rng(1).random((50, 3)), np.ones((1, 3))])
        medium = measured_colours(srgb_display(rgb, 250.0), "absolute")
        assert medium.as_measured
        space = ColourSpace(name, white)
        measured = linear(rgb) @ SRGB_TO_XYZ.T
        expected, _ = ColourSpace(name, "D50").coordinates(xyz_to_lab(measured))
        coordinates, _ = space.coordinates(medium.lab, as_measured=medium.as_measured)
        np.testing.assert_allclose(coordinates, expected, atol=1e-8)

    def test_without_adaptation_colours_are_taken_as_they_are(self):
        lab = real_colours()
        coordinates, _ = ColourSpace("CIEXYZ", "D65", "none").coordinates(lab)
        np.testing.assert_allclose(coordinates, lab_to_xyz(lab), atol=1e-12)

    def test_what_is_shown_is_seen_by_an_eye_that_is_adapted_to_the_white(self):
        for adaptation in ADAPTATIONS:
            space = ColourSpace("CIEXYZ", "D65", adaptation)
            np.testing.assert_allclose(
                space.appearance_lab(D65[np.newaxis]), [[100.0, 0.0, 0.0]], atol=1e-4
            )


class TestDescription:
    @pytest.mark.parametrize("name", SPACES)
    def test_all_that_coordinates_depend_on_is_named(self, name):
        described = ColourSpace(name).description()
        json.dumps(described, allow_nan=False)
        assert {"name", "axes", "reference_white", "adaptation", "scale", "source"} <= set(
            described
        )
        assert set(SPACES[name].parameters) <= set(described)
        assert len(described["axes"]) == 3
        assert described["reference_white_xyz"][1] == 1.0

    def test_of_colours_in_a_space(self):
        lab = np.array([(50.0, 0.0, 0.0), (40.0, 10.0, 200.0), (100.0, 0.0, 0.0)])
        colours = SurfaceColours(lab, None, {"warnings": ["first"], "white": [1, 1, 1]})
        found = colours_in_space(colours, ColourSpace("ICtCp", luminance=1000.0))
        assert found.provenance["white"] == [1, 1, 1]
        assert found.provenance["axes"] == "I Ct Cp"
        assert found.provenance["colour_space"]["luminance"] == 1000.0
        first, second = found.provenance["warnings"]
        assert first == "first"
        assert second.startswith("1 of 3 colours")
        assert colours.provenance["warnings"] == ["first"]
        same = colours_in_space(colours, CIELAB)
        assert same.points is lab
        assert same.provenance["colour_space"]["reference_white_xyz"] == ICC_D50.tolist()


@pytest.mark.parametrize("name", SPACES)
def test_lightness_is_shown_upwards(name):
    *axis, cosine = ColourSpace(name).rotation
    up = np.eye(3)[SPACES[name].lightness]
    rotated = up + 2 * np.cross(axis, np.cross(axis, up) + cosine * up)
    np.testing.assert_allclose(rotated, (0, 1, 0), atol=1e-12)
    assert np.linalg.norm([*axis, cosine]) == pytest.approx(1.0)


def test_cielab_has_none_by_default():
    assert space_parameters("CIELAB", {}) == dict.fromkeys(SPACE_PARAMETERS)
    same = {"reference_white": "D50", "adaptation": "Bradford", "scale": 1}
    assert space_parameters("CIELAB", same) == dict.fromkeys(SPACE_PARAMETERS)


@pytest.mark.parametrize("name", sorted(set(SPACES) - {"CIELAB"}))
def test_defaults_are_made_explicit(name):
    checked = {k: v for k, v in space_parameters(name, {}).items() if v is not None}
    own = {"luminance"} if name in ABSOLUTE else set()
    own |= {"adapting_luminance", "background", "surround"} if name in APPEARANCE else set()
    assert set(checked) == {"reference_white", "adaptation", "scale"} | own
    assert checked["adaptation"] == "Bradford"
    assert checked["scale"] == 1.0
    assert ColourSpace(name, **checked).description() == ColourSpace(name).description()


@pytest.mark.parametrize(
    ("space", "name", "value"),
    [
        *[("CIELAB", name, 10.0) for name in ("luminance", "adapting_luminance", "background")],
        ("Oklab", "luminance", 100),
        ("CAM16-UCS", "luminance", 100),
        ("ICtCp", "surround", "average"),
        ("ICtCp", "luminance", 0),
        ("ICtCp", "luminance", 10_001),
        ("ICtCp", "luminance", "100"),
        ("ICtCp", "luminance", True),
        ("ICtCp", "luminance", float("nan")),
        ("ICtCp", "luminance", 10**400),
        ("CAM16-UCS", "adapting_luminance", 0),
        ("CAM16-UCS", "background", 0),
        ("CAM16-UCS", "background", 101),
        ("CAM16-UCS", "surround", "bright"),
        ("CAM16-UCS", "surround", ["dim"]),
        *[
            ("CIELAB", "reference_white", value)
            for value in (
                "D51", "D5 0 0", "", 50, [1, 1], [1, 0, 1], [0, 1, 1], [1, 1, -1], [1, 1, "1"],
                [1, 1, float("inf")], [1e300, 1e-300, 1], {"X": 1}, True, [9, 1, 1],
                    [3, 1, 0.2], [0.2, 1, 3],
            )
        ],
        *[("CIELAB", "adaptation", value) for value in ("brad", "", 1, ["CAT02"])],
        *[("CIELAB", "scale", value) for value in (0, -1, 1e7, "1", float("inf"), True)],
    ],
)  # fmt: skip
def test_what_is_not_accepted_is_named(space, name, value):
    with pytest.raises(OptionError) as caught:
        space_parameters(space, {name: value})
    assert caught.value.where == {"field": name}
    assert caught.value.remedy


@given(
    st.sampled_from(sorted(SPACES)),
    st.tuples(st.floats(0.05, 6), st.just(1.0), st.floats(0.05, 6)),
    st.sampled_from(sorted(ADAPTATIONS)),
    st.sampled_from([1e-4, 1.0, 1e6]),
    st.sampled_from([0.0, 1.0]),
)
def test_every_space_works_with_all_that_is_accepted(name, white, adaptation, scale, end):
    own = {"luminance": (0.1, 1e4), "adapting_luminance": (0.01, 1e4), "background": (1.0, 100.0)}
    extremes = {key: own[key][int(end)] for key in own if key in SPACES[name].parameters}
    asked = {"reference_white": white, "adaptation": adaptation, "scale": scale, **extremes}
    with contextlib.suppress(OptionError):
        space = ColourSpace(name, **space_parameters(name, asked))
        json.dumps(space.description(), allow_nan=False)
        lab = np.array([(0, 0, 0), (50, 60, -20), (100, 0, 0), (80, -80, 80.0)])
        coordinates, _ = space.coordinates(lab)
        assert np.isfinite(coordinates).all()
        assert np.isfinite(space.appearance_lab(coordinates)).all()


@pytest.mark.parametrize("name", ["CIELAB", "cielab", " Lab ", "CIE  LAB"])
def test_cielab_has_several_names(name):
    space = declared_space({"space": name})
    assert space is not None
    assert space.is_icc_cielab


@pytest.mark.parametrize("name", SPACES)
def test_every_space_is_known_by_its_name_in_any_case(name):
    for written in (name, name.upper(), name.lower()):
        space = declared_space({"space": written})
        assert space is not None
        assert space.name == name
        refuse_other_space(space, ColourSpace(name))


@pytest.mark.parametrize("name", ["sRGB", "", "x" * 5000])
def test_other_spaces_are_refused(name):
    with pytest.raises(MeshError) as caught:
        declared_space({"space": name})
    assert caught.value.where == {"field": "space"}
    assert len(caught.value.message) < 200


@pytest.mark.parametrize(
    ("space", "field", "text"),
    [
        ("CIELAB", "scale", "0"),
        ("CIELAB", "scale", "nan"),
        ("CIELAB", "reference_white", "1 2"),
        ("CIELAB", "reference_white", "D5"),
        ("ICtCp", "luminance", "bright"),
        ("ICtCp", "luminance", "measured"),
        ("CAM16-UCS", "surround", "blue"),
    ],
)
def test_parameters_that_are_none_are_refused(space, field, text):
    with pytest.raises(MeshError) as caught:
        declared_space({"space": space, field: text})
    assert caught.value.where["field"] == field


def test_how_colours_were_found_is_no_parameter_of_the_space():
    said = "ICC media-relative: XYZ scaled by D50/white"
    space = declared_space({"space": "CIELAB", "adaptation": said, "luminance": "80"})
    assert space is not None
    assert space.is_icc_cielab


def test_a_measured_luminance_is_the_number_that_the_file_has():
    said = {"space": "ITP", "luminance": "measured", "white_luminance": "80.5"}
    space = declared_space(said)
    assert space is not None
    assert space.luminance == 80.5


def test_what_is_small_for_cielab_is_told():
    small = np.array([[0.0, 0, 0], [1, 0.3, -0.2]])
    (warning,) = assumption_warnings(small, ColourSpace())
    assert "space" in warning
    assert not assumption_warnings(small, ColourSpace("Oklab"))
    assert not assumption_warnings(small, ColourSpace(scale=0.01))
    assert not assumption_warnings(small * 100, ColourSpace())


TEXTS = st.text(max_size=20) | st.floats().map(repr) | st.just("1 1 1")


@given(
    st.sampled_from(list(SPACES)), st.dictionaries(st.sampled_from(sorted(SPACE_PARAMETERS)), TEXTS)
)
def test_any_notes_are_read_or_refused(space, said):
    try:
        stated = declared_space({**said, "space": space})
    except GamutError:
        return
    assert stated is not None
    refuse_other_space(stated, stated)


LAB = np.array([(50, 20, -30), (80, -10, 60), (30, 5, 5), (100, 0, 0)], float)


@pytest.mark.parametrize("gamut", list(SPACES))
@pytest.mark.parametrize("given", GIVEN_SPACE.values)
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


def test_errors_name_the_space_or_the_row():
    with pytest.raises(OptionError):
        ColourConversion("HSV", CIELAB)
    with pytest.raises(InvalidPointsError) as caught:
        ColourConversion("Oklab", CIELAB).to_gamut(np.array([(1, 0, 0), (1e150, 0, 0)]))
    assert caught.value.where["row"] == 1


SHOWN = st.tuples(st.floats(0, 100), st.floats(-128, 128), st.floats(-128, 128))


def test_the_matrix_is_bradford_and_the_primaries_of_srgb():
    colour = colour_science()
    space = colour.RGB_COLOURSPACES["sRGB"]
    white = colour.xy_to_XYZ(space.whitepoint)
    matrix = colour.models.normalised_primary_matrix(space.primaries, space.whitepoint)
    adaptation = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        ICC_D50, white, transform="Bradford"
    )
    np.testing.assert_allclose(
        D50_TO_LINEAR_SRGB, np.linalg.inv(matrix) @ adaptation, rtol=1e-6, atol=1e-8
    )


@pytest.mark.parametrize("convert", [linear_srgb, srgb])
class TestEnds:
    def test_white_is_one(self, convert):
        np.testing.assert_allclose(convert(np.array([(100.0, 0, 0)])), 1.0, atol=1e-6)

    def test_black_is_nought(self, convert):
        np.testing.assert_array_equal(convert(np.array([(0.0, 0, 0)])), 0.0)

    def test_what_cannot_be_shown_is_clipped(self, convert):
        beyond = np.array([(150.0, 0, 0), (-10, 0, 0), (50, 200, 0), (50, -200, 0), (90, 0, -128)])
        shown = convert(beyond)
        assert (shown >= 0).all()
        assert (shown <= 1).all()
        np.testing.assert_allclose(shown[0], 1.0, rtol=1e-15)
        np.testing.assert_array_equal(shown[1], 0.0)
        assert shown[2, 1] == 0.0
        assert shown[3, 0] == 0.0


@given(st.lists(SHOWN, min_size=1, max_size=20))
@pytest.mark.slow
def test_all_colours_are_those_of_colour_science(displayed, lab):
    points = np.array(lab)
    np.testing.assert_allclose(linear_srgb(points), displayed(points, encoded=False), atol=2e-6)
    np.testing.assert_allclose(srgb(points), displayed(points, encoded=True), atol=5e-5)


def test_nothing_is_stated_without_a_space():
    assert declared_space({"scale": "2", "luminance": "x"}) is None


def test_a_white_is_the_same_by_name_and_by_number():
    named = ColourSpace(reference_white="D65")
    x, y, z = named.white.tolist()
    refuse_other_space(named, ColourSpace(reference_white=(x, y, z)))
    with pytest.raises(OptionError, match="reference_white"):
        refuse_other_space(named, ColourSpace(reference_white=(x, y, z + 1e-6)))


def test_far_is_relative_to_the_scale():
    vertices = np.array([[0.0, 0, 0], [50, 1.5e4, 0]])
    refuse_far_vertices(vertices, ColourSpace(scale=2.0))
    with pytest.raises(InvalidPointsError, match="Vertex 1"):
        refuse_far_vertices(vertices, ColourSpace())


def test_values_of_a_display_are_not_adapted():
    """The white of sRGB is then X, Y, Z of D65 (IEC 61966-2-1)."""
    conversion = ColourConversion("sRGB", ColourSpace("CIEXYZ"), as_measured=True)
    white = conversion.to_gamut(np.ones((1, 3)))
    np.testing.assert_allclose(white, [[0.9505, 1.0, 1.089]], atol=2e-3)
