"""Reference gamuts: matrices, curves, adaptation, optimal colours, and what no surface can have."""

import json

import numpy as np
import pytest
from scipy.spatial import ConvexHull, KDTree

from gamutcore.characterisation import characterisation
from gamutcore.colours import plausibility, surface_colours
from gamutcore.colours.optimal_colours import (
    optimal_colours,
    optimal_faces,
    spectral_weights,
)
from gamutcore.colours.plausibility import (
    extrapolation_warnings,
    impossible_colour_warnings,
)
from gamutcore.colours.reference_colours import (
    RGB_CURVES,
    decode_rgb,
    encode_rgb,
    primary_matrix,
    reference_lab,
    reference_white,
    rgb_xyz,
    surface_xyz,
)
from gamutcore.colours.spaces.cielab import white_of, xyz_to_lab
from gamutcore.colours.spectral import tristimulus_weights
from gamutcore.errors import OptionError
from gamutcore.mesh import TriangleMesh
from gamutcore.references import REFERENCES

RGB_SPACES = [each for each in REFERENCES.values() if each.kind == "rgb"]


@pytest.mark.parametrize("curve", [*RGB_CURVES, 1.0, 2.2, 563 / 256])
def test_encoding_inverts_decoding(curve):
    values = np.linspace(0, 1, 1001)
    # the published constants of the linear parts are rounded, so the parts do not quite meet
    np.testing.assert_allclose(encode_rgb(decode_rgb(values, curve), curve), values, atol=3e-4)
    assert (np.diff(decode_rgb(values, curve)) > -1e-5).all()


@pytest.mark.parametrize(("slug", "volume"), [("srgb", 0.207094138), ("display-p3", 0.288173460)])
def test_the_parallelepiped_in_xyz_has_the_exact_volume(slug, volume):
    """The determinant, as published (see the figures of the design)."""
    assert np.linalg.det(primary_matrix(REFERENCES[slug])) == pytest.approx(volume, abs=2e-9)


@pytest.mark.parametrize("reference", RGB_SPACES, ids=lambda each: each.slug)
def test_full_scale_is_the_white_and_zero_is_black(reference):
    white = reference_white(reference)
    xyz = rgb_xyz(reference, np.array([[1.0, 1, 1], [0, 0, 0]]))
    np.testing.assert_allclose(xyz, [white, [0, 0, 0]], atol=1e-9)
    lab, _ = reference_lab(xyz, white, "relative", "Bradford")
    np.testing.assert_allclose(lab, [[100, 0, 0], [0, 0, 0]], atol=1e-6)


@pytest.mark.parametrize("intent", ["perceptual", "saturation"])
def test_intents_of_profiles_are_refused(intent):
    with pytest.raises(OptionError, match=intent):
        reference_lab(np.ones((1, 3)), np.ones(3), intent, "Bradford")


def test_the_faces_of_pointers_gamut_are_a_closed_oriented_sphere():
    xyz, white, faces = surface_xyz(REFERENCES["pointer"], 1000)
    assert set(faces.ravel()) == set(range(len(xyz)))
    assert len(faces) == 2 * len(xyz) - 4
    edges = {
        edge for face in faces.tolist() for edge in zip(face, face[1:] + face[:1], strict=True)
    }
    assert len(edges) == 3 * len(faces)
    assert all((b, a) in edges for a, b in edges)
    corners = reference_lab(xyz, white, "relative", "Bradford")[0][faces]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume > 5e5


def test_pointers_colours_have_the_lightness_and_hue_of_his_table():
    xyz, white, _ = surface_xyz(REFERENCES["pointer"], 1000)
    from gamutcore.colours.spaces.cielab import xyz_to_lab

    lab = xyz_to_lab(xyz, white)
    assert len(lab) == 16 * 36 + 2
    np.testing.assert_allclose(np.unique(np.round(lab[:, 0], 6)), np.arange(15, 91, 5), atol=1e-6)
    # Pointer's most saturated colours: a yellow of L* 85 with C*ab 115 or more
    assert np.hypot(lab[:, 1], lab[:, 2]).max() > 110


CASES = [(light, observer) for light in ("D50", "D65", "A") for observer in (2, 10)]


@pytest.mark.parametrize(("light", "observer"), CASES)
def test_all_light_together_is_the_white(light, observer):
    weights = spectral_weights(light, observer)
    np.testing.assert_allclose(weights.sum(axis=0), white_of(light, str(observer)), atol=4e-4)


@pytest.mark.parametrize(("light", "observer"), CASES)
def test_the_complement_of_an_optimal_colour_is_optimal(light, observer):
    """The solid is a zonoid: point-symmetric about half of the white."""
    colours = optimal_colours(light, observer, 3000)
    white = colours[-1]
    distance, _ = KDTree(colours).query(white - colours)
    assert distance.max() < 1e-9


@pytest.mark.parametrize("count", [300, 5000, 60_000, 10**6])
def test_there_are_at_most_as_many_colours_as_asked_for(count):
    colours = optimal_colours("D65", 2, count)
    assert len(colours) <= count
    np.testing.assert_array_equal(colours[0], 0)
    assert colours[-1][1] == pytest.approx(1)


@pytest.mark.parametrize(("light", "observer"), CASES)
def test_the_faces_are_those_of_the_convex_hull(light, observer):
    colours = optimal_colours(light, observer, 4000)
    mesh = TriangleMesh(colours, optimal_faces(len(colours)))
    assert mesh.triangles == 2 * len(colours) - 4
    assert mesh.validity().is_sphere
    # the spectrum locus is concave by a little at its ends
    assert abs(mesh.volume) == pytest.approx(ConvexHull(colours).volume, rel=1e-5)


CORNERS = np.stack(np.meshgrid(*[[0.0, 1.0]] * 3), axis=-1).reshape(-1, 3)


def lab(device):
    """Return the colours of a device whose gamut is a box of 100 × 120 × 120."""
    return np.column_stack([100 * device[:, 0], 120 * (device[:, 1:] - 0.5)])


def test_the_excess_over_the_hull_of_the_samples_is_told():
    """Samples fill the half of the range: the hull is an eighth of the gamut."""
    samples = 0.25 + CORNERS / 2
    far, size = extrapolation_warnings(CORNERS, 0.1 * samples, lab(CORNERS), lab(samples))
    assert far.startswith("7 of the 8 corners")
    assert "8.00 times" in size
    near = extrapolation_warnings(CORNERS, samples, lab(CORNERS), lab(samples))
    assert near == [size]


def test_samples_in_a_plane_have_no_hull_to_exceed():
    flat = CORNERS * [1, 1, 0]
    assert extrapolation_warnings(CORNERS * 0.4, flat * 0.4, lab(CORNERS), lab(flat)) == []


def test_the_bands_are_those_of_astm_e308():
    weights = tristimulus_weights(tuple(np.arange(400.0, 701.0, 10.0)), "D50", 2)
    np.testing.assert_allclose(plausibility._BANDS.T, weights / weights[:, 1].sum(), atol=1e-3)


def test_optimal_colours_are_inside_their_solid_and_lighter_ones_are_not():
    """Reflectances of 0 and 1 with two steps (Schrödinger 1920), by their cumulative sums."""
    optimal = optimal_colours("D50", 2, 4000)[1:]
    assert impossible_colour_warnings(xyz_to_lab(optimal), lights=False) == []
    # Away from the middle of the solid by 5 %: all of them are outside.
    middle = optimal[-1] / 2
    beyond = middle + 1.05 * (optimal - middle)
    assert impossible_colour_warnings(xyz_to_lab(beyond), lights=False)[-1].startswith("100 %")


@pytest.mark.parametrize("stated", [False, True])
def test_a_scanner_target_is_told_to_be_extrapolated(stated):
    """Patches with little saturation, as on targets for scanners; the scanner is linear."""
    values = np.random.default_rng(0).random((300, 1)) ** [[1, 1, 1]]
    device = np.clip(values + np.random.default_rng(1).normal(0, 0.08, (300, 3)), 0, 1)
    matrix = np.array([[0.61, 0.21, 0.14], [0.31, 0.63, 0.06], [0.02, 0.07, 0.74]])
    colours = xyz_to_lab(device**2.2 @ (matrix * 0.85).T + 0.004)
    document = {
        "columns": ["RGB_R", "RGB_G", "RGB_B", "LAB_L", "LAB_A", "LAB_B"],
        "samples": np.column_stack([device, colours]).tolist(),
        "conditions": {"DEVICE_CLASS": "OUTPUT"} if stated else {},
    }
    surface = surface_colours(characterisation(json.dumps(document).encode()))
    warnings = " ".join(str(said) for said in surface.provenance["warnings"])
    assert "corners of the device cube are farther from all samples" in warnings
    assert "times the volume of the convex hull of the measured colours" in warnings
    assert ("assumed to be a display's" in warnings) != stated


def test_profiles_of_lights_are_not_compared_with_surfaces(small_profile):
    surface = surface_colours(characterisation(small_profile("DisplayP3-v4.icc")))
    assert impossible_colour_warnings(surface.points, lights=False)
    assert surface.provenance["warnings"] == []


def test_bare_colours_that_no_surface_has_are_told():
    rows = [[50, 120, -120], [50, -120, 80], [101, 0, 0], [0, 0, 0], [50, 0, 0]]
    surface = surface_colours(characterisation(json.dumps(rows).encode()))
    warnings = surface.provenance["warnings"]
    assert any("60 % of the colours are outside the optimal colour solid" in w for w in warnings)
    assert any("1 of 5 colours have an L* outside 0 to 100" in w for w in warnings)
