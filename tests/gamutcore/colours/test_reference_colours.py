"""Reference gamuts: their colours and faces, and what no surface can have."""

import json

import numpy as np
import pytest
from scipy.spatial import ConvexHull, KDTree

from gamutcore.characterisation import read_characterisation
from gamutcore.colours import colours_in_space, device_model, surface_colours, xyz_to_lab
from gamutcore.colours.colorimetry import colour_science
from gamutcore.colours.device_model import extrapolation_warnings, impossible_colour_warnings
from gamutcore.colours.measured import tristimulus_weights
from gamutcore.colours.spaces import ColourSpace
from gamutcore.errors import OptionError
from gamutcore.geometry import TriangleMesh
from gamutcore.references import REFERENCES

RGB_SPACES = [each for each in REFERENCES.values() if each.kind == "rgb" and not each.peak]


DISPLAYS = {
    # ITU-R BT.1886, annex 1, with a black of 0: L = Lw V^2.4
    "bt709": lambda values: values**2.4,
    "bt2020": lambda values: values**2.4,
    # ITU-R BT.470-6, table 1, system M; ITU-T H.273, table 3, transfer 4
    "bt470-525": lambda values: values**2.2,
    "ntsc-1953": lambda values: values**2.2,
}
"""Curves of displays where colour-science has those of cameras, or another number."""


def in_xyz(slug, count=1000):
    """Colours of a reference as tristimulus values of its own white."""
    found = surface_colours(REFERENCES[slug], intent="absolute", surface_samples=count)
    return colours_in_space(found, ColourSpace("CIEXYZ"))


def at(found, *device):
    """Colour of a device value that is among the surface's."""
    return found.points[(found.device == device).all(axis=1)][0]


@pytest.mark.parametrize("reference", RGB_SPACES, ids=lambda each: each.slug)
def test_colours_of_rgb_spaces_are_those_of_colour_science(reference):
    """The published constants of the linear parts of curves are rounded."""
    colour = colour_science()
    space = colour.RGB_COLOURSPACES[reference.name].copy()
    space.use_derived_matrix_RGB_to_XYZ = True
    found = in_xyz(reference.slug)
    with np.errstate(all="ignore"):
        decode = DISPLAYS.get(reference.slug, space.cctf_decoding)
        linear = np.asarray(decode(found.device), np.float64)
        full = float(space.cctf_decoding(1.0))
    if reference.definition["curve"] == 1.0:
        # linear light, a logarithmic curve, or one that reaches beyond the white
        assert np.allclose(linear, found.device) or abs(full - 1) > 0.5 or "Pro" in reference.name
        linear = found.device
    expected = linear @ space.matrix_RGB_to_XYZ.T
    np.testing.assert_allclose(found.points, expected, atol=2e-4 * expected.max())


@pytest.mark.parametrize("reference", RGB_SPACES, ids=lambda each: each.slug)
def test_full_scale_is_the_white_and_zero_is_black(reference):
    found = surface_colours(reference, surface_samples=100)
    np.testing.assert_allclose(at(found, 1, 1, 1), [100, 0, 0], atol=1e-6)
    np.testing.assert_allclose(at(found, 0, 0, 0), [0, 0, 0], atol=1e-6)


@pytest.mark.parametrize(("slug", "volume"), [("srgb", 0.207094138), ("display-p3", 0.288173460)])
def test_the_parallelepiped_in_xyz_has_the_exact_volume(slug, volume):
    """The determinant, as published (see the figures of the design)."""
    primaries = [at(in_xyz(slug), *corner) for corner in np.eye(3)]
    assert np.linalg.det(primaries) == pytest.approx(volume, abs=2e-9)


@pytest.mark.parametrize("slug", ["srgb", "pointer", "optimal-colours-d50-2"])
@pytest.mark.parametrize("intent", ["perceptual", "saturation"])
def test_intents_of_profiles_are_refused(slug, intent):
    with pytest.raises(OptionError, match=intent):
        surface_colours(REFERENCES[slug], intent=intent)


def test_pointers_gamut_is_a_closed_sphere_of_the_lightness_and_chroma_of_his_table():
    found = surface_colours(REFERENCES["pointer"])
    mesh = TriangleMesh(found.points, found.faces.corners)
    assert set(mesh.faces.ravel()) == set(range(16 * 36 + 2))
    validity = mesh.validity()
    assert (validity.closed, validity.manifold, validity.euler_characteristic) == (True, True, 2)
    assert mesh.volume > 5e5
    xyz, white = in_xyz("pointer").points, found.provenance["white"]
    lab = xyz_to_lab(xyz, np.array(white))
    np.testing.assert_allclose(np.unique(np.round(lab[:, 0], 4)), np.arange(15, 91, 5), atol=1e-4)
    # Pointer's most saturated colours: a yellow of L* 85 with C*ab 115 or more
    assert np.hypot(lab[:, 1], lab[:, 2]).max() > 110


CASES = [(light, observer) for light in ("D50", "D65", "A") for observer in (2, 10)]


def optimal_colours(light, observer, count):
    """Optimal colours with black first, white last."""
    found = in_xyz(f"optimal-colours-{light.lower()}-{observer}", count)
    assert len(found.points) <= count
    np.testing.assert_allclose(found.points[0], 0, atol=1e-12)
    assert found.points[-1][1] == pytest.approx(1)
    return found


@pytest.mark.parametrize(
    ("light", "observer", "white"),
    [  # ASTM E308, table 5
        ("D50", 2, (0.96422, 0.82521)),
        ("D50", 10, (0.96720, 0.81427)),
        ("D65", 2, (0.95047, 1.08883)),
        ("D65", 10, (0.94811, 1.07304)),
        ("A", 2, (1.09850, 0.35585)),
        ("A", 10, (1.11144, 0.35200)),
    ],
)
def test_all_light_together_is_the_white(light, observer, white):
    colours = optimal_colours(light, observer, 300).points
    np.testing.assert_allclose(colours[-1, [0, 2]], white, atol=4e-4)


@pytest.mark.parametrize(("light", "observer"), CASES)
def test_the_solid_is_symmetric_and_its_faces_are_those_of_the_convex_hull(light, observer):
    """A zonoid: the complement of an optimal colour is optimal."""
    found = optimal_colours(light, observer, 4000)
    colours = found.points
    distance, _ = KDTree(colours).query(colours[-1] - colours)
    assert distance.max() < 1e-9
    mesh = TriangleMesh(colours, found.faces.corners)
    assert mesh.triangles == 2 * len(colours) - 4
    assert mesh.validity().is_sphere
    # the spectrum locus is concave by a little at its ends
    assert abs(mesh.volume) == pytest.approx(ConvexHull(colours).volume, rel=1e-5)


def test_there_are_at_most_as_many_colours_as_asked_for():
    sizes = [len(optimal_colours("D65", 2, count).points) for count in (300, 60_000, 10**6)]
    assert sizes[0] < sizes[1] < sizes[2]


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
    np.testing.assert_allclose(device_model._BANDS.T, weights / weights[:, 1].sum(), atol=1e-3)


def test_optimal_colours_are_inside_their_solid_and_lighter_ones_are_not():
    """Reflectances of 0 and 1 with two steps (Schrödinger 1920), by their cumulative sums."""
    optimal = optimal_colours("D50", 2, 4000).points[1:]
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
    surface = surface_colours(read_characterisation(json.dumps(document).encode()))
    warnings = " ".join(str(said) for said in surface.provenance["warnings"])
    assert "corners of the device cube are farther from all samples" in warnings
    assert "times the volume of the convex hull of the measured colours" in warnings
    assert ("assumed to be a display's" in warnings) != stated


def test_profiles_of_lights_are_not_compared_with_surfaces(small_profile):
    surface = surface_colours(read_characterisation(small_profile("DisplayP3-v4.icc")))
    assert impossible_colour_warnings(surface.points, lights=False)
    assert surface.provenance["warnings"] == []


def test_bare_colours_that_no_surface_has_are_told():
    rows = [[50, 120, -120], [50, -120, 80], [101, 0, 0], [0, 0, 0], [50, 0, 0]]
    surface = surface_colours(read_characterisation(json.dumps(rows).encode()))
    warnings = surface.provenance["warnings"]
    assert any("60 % of the colours are outside the optimal colour solid" in w for w in warnings)
    assert any("1 of 5 colours have an L* outside 0 to 100" in w for w in warnings)
