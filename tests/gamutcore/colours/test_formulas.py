"""Coordinates, whites and adaptations of spaces against published figures and colour-science."""

import subprocess
import sys
import warnings

import numpy as np
import pytest

from gamutcore.colours import ICC_D50, lab_to_xyz, xyz_to_lab
from gamutcore.colours.colorimetry import colour_science
from gamutcore.colours.spaces import SPACES, ColourSpace

LINDBLOOM_SRGB = np.array(
    [
        (0.4124564, 0.3575761, 0.1804375),
        (0.2126729, 0.7151522, 0.0721750),
        (0.0193339, 0.1191920, 0.9503041),
    ]
)
"""Linear sRGB to XYZ with the D65 of ASTM E308, by Bruce Lindbloom."""
ASTM_D65 = (0.95047, 1.0, 1.08883)
D65 = ColourSpace(reference_white="D65").white
CSS_SRGB = np.array(
    [
        (0.41239079926595934, 0.357584339383878, 0.1804807884018343),
        (0.21263900587151027, 0.715168678767756, 0.07219231536073371),
        (0.01933081871559182, 0.11919477979462598, 0.9505321522496607),
    ]
)
"""Linear sRGB to XYZ with the D65 of x 0.3127, y 0.3290 (CSS Color 4, clause 18)."""

OF_D65 = [ColourSpace(name, "D65") for name in SPACES]
APPEARANCE = {"CAM16-UCS": "CAM16", "CAM02-UCS": "CIECAM02"}
ADAPTATIONS = ("Bradford", "CAT02", "CAT16", "von-Kries", "XYZ-scaling")


def by_name(space):
    return space.name


def coordinates(space, xyz):
    """Coordinates of tristimulus values that all have some, without adaptation."""
    found, moved = space.from_tristimulus(np.asarray(xyz, float), as_measured=True)
    assert moved == 0
    return found


def one(space, xyz):
    return coordinates(space, [xyz])[0]


def linear(encoded):
    """Linear values of sRGB's (IEC 61966-2-1)."""
    encoded = np.asarray(encoded, float)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def colours(count=3000, seed=0):
    return linear(np.random.default_rng(seed).random((count, 3))) @ CSS_SRGB.T


@pytest.mark.parametrize(
    ("rgb", "lab", "luv"),
    [  # Bruce Lindbloom's calculator, sRGB with D65
        ((1, 0, 0), (53.2408, 80.0925, 67.2032), (53.2408, 175.0151, 37.7564)),
        ((0, 1, 0), (87.7347, -86.1827, 83.1793), (87.7347, -83.0776, 107.3985)),
        ((0, 0, 1), (32.2970, 79.1875, -107.8602), (32.2970, -9.4054, -130.3423)),
        ((1, 1, 1), (100.0, 0.0, 0.0), (100.0, 0.0, 0.0)),
    ],
)
def test_cielab_and_cieluv(rgb, lab, luv):
    xyz = LINDBLOOM_SRGB @ rgb
    np.testing.assert_allclose(one(ColourSpace("CIELAB", ASTM_D65), xyz), lab, atol=2e-3)
    np.testing.assert_allclose(one(ColourSpace("CIELUV", ASTM_D65), xyz), luv, atol=2e-3)


@pytest.mark.parametrize(
    ("xyz", "expected"),
    [
        ((0.950, 1.000, 1.089), (1.000, 0.000, 0.000)),
        ((1.000, 0.000, 0.000), (0.450, 1.236, -0.019)),
        ((0.000, 1.000, 0.000), (0.922, -0.671, 0.263)),
        ((0.000, 0.000, 1.000), (0.153, -1.415, -0.449)),
    ],
)
def test_oklab(xyz, expected):
    """Ottosson's table of pairs, three decimals."""
    np.testing.assert_allclose(one(ColourSpace("Oklab"), xyz), expected, atol=5.01e-4)


def test_ipt():
    """IPT is defined so that Ebner's D65 is (1, 0, 0); its four digits leave 10⁻⁴."""
    space = ColourSpace("IPT")
    np.testing.assert_allclose(one(space, (0.9504, 1.0, 1.0889)), (1, 0, 0), atol=1e-4)
    np.testing.assert_allclose(one(space, (0.0, 0.0, 0.0)), 0.0)


@pytest.mark.parametrize(
    ("luminance", "signal"),
    [  # ITU-R BT.2408-7, table 1: 58 % is 203 cd/m², 38 % is 26; ST 2084's end is 10,000
        (203.0, 0.58),
        (26.0, 0.38),
        (10_000.0, 1.0),
        (1000.0, 0.75),
        (100.0, 0.51),
    ],
)
def test_the_intensity_of_white_is_its_pq_signal(luminance, signal):
    space = ColourSpace("ICtCp", luminance=luminance)
    np.testing.assert_allclose(one(space, D65), (signal, 0, 0), atol=0.005)


@pytest.mark.parametrize(
    ("rgb", "expected"),
    [  # white of 203 cd/m²; culori's tests of `itp` (CSS Color HDR), and ColorAide's
        ((1, 1, 1), (0.5806888810416109, 0.0, 0.0)),
        ((1, 0, 0), (0.4278802843622844, -0.11570435976969046, 0.27872894737532694)),
    ],
)
def test_ictcp_of_srgb(rgb, expected):
    np.testing.assert_allclose(one(ColourSpace("ICtCp"), CSS_SRGB @ rgb), expected, atol=1e-6)


def test_ictcp_of_the_primaries_of_bt_2020():
    """BT.2100's table 7 has 1688, 683 and 99 / 4096 for red's L, M and S."""
    xyz = np.array([0.636958, 0.262700, 0.0])  # BT.2020's red, Y 0.2627 of the white
    # SMPTE ST 2084, with its constants
    power = (np.array([1688, 683, 99]) / 4096) ** (2610 / 16384)
    signal = ((3424 / 4096 + 2413 / 128 * power) / (1 + 2392 / 128 * power)) ** (2523 / 32)
    expected = np.array([(2048, 2048, 0), (6610, -13613, 7003), (17933, -17390, -543)]) @ signal
    found = one(ColourSpace("ICtCp", luminance=10_000.0), xyz)
    np.testing.assert_allclose(found, expected / 4096, atol=2e-6)


def test_distances_in_itp_are_those_of_bt_2124():
    """ΔE_ITP = 720 √(ΔI² + ΔT² + ΔP²), T = 0.5 Ct (ITU-R BT.2124-0, annex 1)."""
    xyz = colours(2)
    (i, t, p), *_ = np.diff(coordinates(ColourSpace("ICtCp"), xyz), axis=0)
    given = np.diff(coordinates(ColourSpace("ITP"), xyz), axis=0)
    assert np.linalg.norm(given) == pytest.approx(720 * np.sqrt(i**2 + 0.25 * t**2 + p**2))


@pytest.mark.parametrize(
    ("lab", "expected"),
    [  # the German Wikipedia's table of DIN99o
        ((50, 10, 10), (54.098, 12.215, 10.979)),
        ((50, 50, 50), (54.098, 31.237, 28.076)),
        ((50, -10, 10), (54.098, -11.067, 9.780)),
        ((50, -50, 50), (54.098, -29.384, 25.968)),
        ((50, -50, -50), (54.098, -31.237, -28.076)),
        ((0, 0, 0), (0, 0, 0)),
        ((100, 0, 0), (100, 0, 0)),
    ],
)
def test_din99o(lab, expected):
    xyz = lab_to_xyz(np.array(lab, float), D65)
    np.testing.assert_allclose(one(ColourSpace("DIN99o"), xyz), expected, atol=6e-4)


@pytest.mark.slow
def test_agrees_with_colour_science():
    """colour-science has no DIN99o; the appearance models have tests of their own."""
    colour = colour_science()
    xyz, white = colours(), colour.XYZ_to_xy(D65)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # colour-science's about domains
        theirs = {
            ("CIELAB", 1e-6): colour.XYZ_to_Lab(xyz, white),
            ("CIELUV", 1e-6): colour.XYZ_to_Luv(xyz, white),
            ("Oklab", 1e-6): colour.XYZ_to_Oklab(xyz),
            ("IPT", 1e-6): colour.XYZ_to_IPT(xyz),
            # its matrix of BT.2020 is rounded
            ("ICtCp", 2e-5): colour.XYZ_to_ICtCp(203 * xyz),
            ("ITP", 0.02): colour.XYZ_to_ICtCp(203 * xyz) * (720, 360, 720),
            ("Jzazbz", 1e-6): colour.XYZ_to_Jzazbz(203 * xyz),
        }
    for (name, tolerance), expected in theirs.items():
        found = coordinates(ColourSpace(name, "D65"), xyz)
        np.testing.assert_allclose(found, expected, atol=tolerance, err_msg=name)


@pytest.mark.parametrize("space", OF_D65, ids=by_name)
class TestBothWays:
    def test_round_trip(self, space):
        xyz = np.concatenate([colours(), np.zeros((1, 3)), D65[np.newaxis], 0.001 * colours(100)])
        back = space.tristimulus(coordinates(space, xyz), as_measured=True)
        np.testing.assert_allclose(back, xyz, atol=1e-8)

    def test_all_is_finite(self, space):
        """Imaginary colours, and coordinates far from any colour."""
        wild = np.random.default_rng(5).normal(0, 1, (5000, 3)) * np.logspace(-6, 3, 5000)[:, None]
        assert np.isfinite(space.from_tristimulus(wild, as_measured=True)[0]).all()
        assert np.isfinite(space.tristimulus(wild, as_measured=True)).all()

    def test_lightness_grows_with_light(self, space):
        steps = np.linspace(0, 1, 200)[:, np.newaxis] * D65
        axis = 1 if space.name == "CIEXYZ" else 0
        assert (np.diff(coordinates(space, steps)[:, axis]) > 0).all()


@pytest.mark.parametrize("name", ["CIELUV", "ICtCp", "ITP", "Jzazbz", *APPEARANCE])
def test_colours_without_coordinates_are_told(name):
    for xyz, expected in ((D65 / 2, 0), ((-0.2, 0.1, 0.3), 1), ((0.1, 0.1, -0.3), 1), (D65, 0)):
        space = ColourSpace(name, "D65")
        assert space.from_tristimulus(np.array([xyz]), as_measured=True)[1] == expected


D65_100 = np.array([95.047, 100.0, 108.883])


def appearance(name, white, luminance, background=20.0, surround="average"):
    return ColourSpace(
        name,
        tuple(np.array(white) / 100),
        adapting_luminance=luminance,
        background=background,
        surround=surround,
    )


def correlates(space, xyz):
    """J, M and h in degrees, by the equations of the uniform spaces (Luo, Cui and Li 2006)."""
    lightness, a, b = one(space, np.array(xyz) / 100)
    colourfulness = np.expm1(0.0228 * np.hypot(a, b)) / 0.0228
    hue = np.degrees(np.arctan2(b, a)) % 360
    return lightness / (1.7 - 0.007 * lightness), colourfulness, hue


@pytest.mark.parametrize(
    ("xyz", "white", "luminance", "expected"),
    [
        ((19.01, 20.00, 21.78), (95.05, 100.0, 108.88), 318.31, (41.73, 0.11, 219.0)),
        ((57.06, 43.06, 31.96), (95.05, 100.0, 108.88), 31.83, (65.96, 41.67, 19.6)),
        ((3.53, 6.56, 2.14), (109.85, 100.0, 35.58), 318.31, (21.79, 48.80, 177.1)),
        ((19.01, 20.00, 21.78), (109.85, 100.0, 35.58), 31.83, (42.53, 44.54, 248.9)),
    ],
)
def test_the_worked_examples_of_fairchild(xyz, white, luminance, expected):
    """Fairchild, Color Appearance Models, 3rd edition (2013), table 16.4."""
    lightness, colourfulness, hue = correlates(appearance("CAM02-UCS", white, luminance), xyz)
    assert (lightness, colourfulness) == pytest.approx(expected[:2], abs=0.0051)
    assert hue == pytest.approx(expected[2], abs=0.051)


def test_the_worked_example_of_cam16():
    """Li et al. 2017 with the conditions of CIECAM02's first example: J, M and h."""
    space = appearance("CAM16-UCS", (95.05, 100.0, 108.88), 318.31)
    expected = (41.7312, 0.1074, 217.068)
    assert correlates(space, (19.01, 20.0, 21.78)) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(
    ("rgb", "expected"),
    [
        ((1, 0, 0), (46.445, 89.494, 27.408)),
        ((0, 1, 0), (79.331, 85.587, 142.139)),
        ((0, 0, 1), (25.465, 68.867, 282.788)),
        ((1, 1, 1), (100.0, 2.265, 209.492)),
    ],
)
def test_the_primaries_of_srgb_are_those_of_material_design(rgb, expected):
    """material-color-utilities' own tests: L_A of a white of 200/π seen at L* 50, Y_b of L* 50."""
    material_srgb = np.array(  # its linear sRGB to XYZ
        [
            (0.41233895, 0.35762064, 0.18051042),
            (0.2126, 0.7152, 0.0722),
            (0.01932141, 0.11916382, 0.95034478),
        ]
    )
    gray = ((50 + 16) / 116) ** 3 * 100
    space = appearance("CAM16-UCS", D65_100, 200 / np.pi * gray / 100, gray)
    assert correlates(space, 100 * material_srgb @ rgb) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("name", APPEARANCE)
@pytest.mark.parametrize("surround", ["average", "dim", "dark"])
@pytest.mark.parametrize(("luminance", "background"), [(4.0, 20.0), (318.31, 10.0), (0.1, 60.0)])
def test_appearance_agrees_with_colour_science(name, surround, luminance, background):
    colour = colour_science()
    xyz = np.random.default_rng(1).random((500, 3)) @ CSS_SRGB.T
    theirs = {"CAM16-UCS": colour.XYZ_to_CAM16, "CAM02-UCS": colour.XYZ_to_CIECAM02}[name](
        100 * xyz, D65_100, luminance, background, colour.VIEWING_CONDITIONS_CAM16[surround.title()]
    )
    uniform = {
        "CAM16-UCS": colour.models.JMh_CAM16_to_CAM16UCS,
        "CAM02-UCS": colour.models.JMh_CIECAM02_to_CAM02UCS,
    }[name]
    space = appearance(name, D65_100, luminance, background, surround)
    expected = uniform(np.stack([theirs.J, theirs.M, theirs.h], axis=1))
    np.testing.assert_allclose(coordinates(space, xyz), expected, atol=1e-6)


@pytest.mark.parametrize(
    ("y", "lightness"),
    [
        # By hand from CIE 15: L* 50 is Y = (66/116)³, L* 8 is 216/24389, and a straight line below.
        ((66 / 116) ** 3, 50),
        (216 / 24389, 8),
        (108 / 24389, 4),
        (0, 0),
        (-108 / 24389, -4),
    ],
)
def test_lightness_of_grays(y, lightness):
    np.testing.assert_allclose(xyz_to_lab(y * ICC_D50), [lightness, 0, 0], atol=1e-9)


@pytest.mark.parametrize("white", [ICC_D50, np.array([1.1114, 1.0, 0.3520])])
def test_cielab_of_any_white_is_that_of_colour_science(white):
    xyz = np.random.default_rng(1).uniform(-0.01, 1.2, (1000, 3))
    chromaticity = white[:2] / white.sum()
    expected = colour_science().XYZ_to_Lab(xyz, chromaticity)
    np.testing.assert_allclose(xyz_to_lab(xyz, white), expected, atol=1e-10)
    back = colour_science().Lab_to_XYZ(expected, chromaticity)
    np.testing.assert_allclose(lab_to_xyz(expected, white), back, atol=1e-12)


@pytest.mark.slow
def test_importing_colour_science_leaves_no_mocks_behind():
    program = (
        "import sys, gamutcore.colours\n"
        "assert 'colour' not in sys.modules\n"
        "from gamutcore.colours.colorimetry import colour_science\n"
        "colour_science()\n"
        "print([n for n, m in sys.modules.items() if 'Mock' in type(m).__name__])\n"
    )
    ended = subprocess.run(
        [sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=False
    )
    assert ended.stderr == ""
    assert ended.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("name", "expected"),
    [  # ASTM E308, as in Lindbloom's table; the last two: SMPTE RP 431-2 and ST 2065-1
        ("A", (1.09850, 0.35585)),
        ("C", (0.98074, 1.18232)),
        ("D50", (0.9642, 0.8249)),  # ICC.1:2022, 7.2.16
        ("D55", (0.95682, 0.92149)),
        ("D65", (0.95047, 1.08883)),
        ("D75", (0.94972, 1.22638)),
        ("E", (1.0, 1.0)),
        ("DCI", (0.89459, 0.95442)),
        ("D60", (0.95265, 1.00883)),
    ],
)
def test_the_white_of_d50_is_adapted_to_the_published_white(name, expected):
    for adaptation in ADAPTATIONS:
        space = ColourSpace("CIEXYZ", name, adaptation)
        (adapted,), _ = space.from_tristimulus(ICC_D50[np.newaxis])
        np.testing.assert_allclose(adapted, space.white, atol=1e-12)
        np.testing.assert_allclose(adapted[[0, 2]], expected, atol=3e-4)
        assert adapted[1] == pytest.approx(1.0)


@pytest.mark.parametrize("adaptation", ADAPTATIONS)
def test_adaptations_are_those_of_colour_science(adaptation):
    theirs = adaptation.replace("-s", " S").replace("-K", " K").replace("von", "Von")
    expected = colour_science().adaptation.matrix_chromatic_adaptation_VonKries(
        ICC_D50, ASTM_D65, transform=theirs
    )
    found, _ = ColourSpace("CIEXYZ", ASTM_D65, adaptation).from_tristimulus(np.eye(3))
    np.testing.assert_allclose(found.T, expected, atol=1e-12)
