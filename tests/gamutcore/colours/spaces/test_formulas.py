"""Formulas of spaces, appearance models and whites against published figures and colour-science."""

import subprocess
import sys
import warnings

import numpy as np
import pytest

from gamutcore.colours.spaces.appearance_model import SURROUNDS, AppearanceModel
from gamutcore.colours.spaces.cielab import (
    ICC_D50,
    colour_science,
    lab_to_xyz,
    white_of,
    xyz_to_lab,
)
from gamutcore.colours.spaces.formulas import (
    Cielab,
    Cieluv,
    Ciexyz,
    Din99,
    Jzazbz,
    UniformAppearance,
    ictcp,
    ipt,
    oklab,
    pq_signal,
)
from gamutcore.colours.spaces.white_points import (
    ADAPTATIONS,
    WHITES,
    adaptation_matrix,
    white_point,
)

LINDBLOOM_SRGB = np.array(
    [
        (0.4124564, 0.3575761, 0.1804375),
        (0.2126729, 0.7151522, 0.0721750),
        (0.0193339, 0.1191920, 0.9503041),
    ]
)
"""Linear sRGB to XYZ with the D65 of ASTM E308, by Bruce Lindbloom."""
ASTM_D65 = np.array([0.95047, 1.0, 1.08883])
ASTM_D50 = np.array([0.96422, 1.0, 0.82521])

D65 = white_point("D65")
CSS_SRGB = np.array(
    [
        (0.41239079926595934, 0.357584339383878, 0.1804807884018343),
        (0.21263900587151027, 0.715168678767756, 0.07219231536073371),
        (0.01933081871559182, 0.11919477979462598, 0.9505321522496607),
    ]
)
"""Linear sRGB to XYZ with the D65 of x 0.3127, y 0.3290 (CSS Color 4, clause 18)."""

FORMULAS = {
    "CIEXYZ": Ciexyz(),
    "CIELAB": Cielab(D65),
    "CIELUV": Cieluv(D65),
    "DIN99o": Din99(D65),
    "Oklab": oklab(),
    "IPT": ipt(),
    "ICtCp": ictcp(203.0),
    "ITP": ictcp(1000.0, itp=True),
    "Jzazbz": Jzazbz(203.0),
    "CAM16-UCS": UniformAppearance(AppearanceModel("CAM16", 100 * D65, 4.0, 20.0, "average")),
    "CAM02-UCS": UniformAppearance(AppearanceModel("CIECAM02", 100 * D65, 4.0, 20.0, "dim")),
}


def linear(encoded):
    """Linear values of sRGB's (IEC 61966-2-1)."""
    encoded = np.asarray(encoded, float)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def one(formula, xyz):
    coordinates, outside = formula.coordinates(np.array([xyz], float))
    assert not outside.any()
    return coordinates[0]


def colours(count=3000, seed=0):
    return linear(np.random.default_rng(seed).random((count, 3))) @ CSS_SRGB.T


class TestWorkedExamples:
    @pytest.mark.parametrize(
        ("rgb", "lab", "luv"),
        [  # Bruce Lindbloom's calculator, sRGB with D65
            ((1, 0, 0), (53.2408, 80.0925, 67.2032), (53.2408, 175.0151, 37.7564)),
            ((0, 1, 0), (87.7347, -86.1827, 83.1793), (87.7347, -83.0776, 107.3985)),
            ((0, 0, 1), (32.2970, 79.1875, -107.8602), (32.2970, -9.4054, -130.3423)),
            ((1, 1, 1), (100.0, 0.0, 0.0), (100.0, 0.0, 0.0)),
        ],
    )
    def test_cielab_and_cieluv(self, rgb, lab, luv):
        xyz = LINDBLOOM_SRGB @ rgb
        np.testing.assert_allclose(one(Cielab(ASTM_D65), xyz), lab, atol=2e-3)
        np.testing.assert_allclose(one(Cieluv(ASTM_D65), xyz), luv, atol=2e-3)

    @pytest.mark.parametrize(
        ("xyz", "expected"),
        [
            ((0.950, 1.000, 1.089), (1.000, 0.000, 0.000)),
            ((1.000, 0.000, 0.000), (0.450, 1.236, -0.019)),
            ((0.000, 1.000, 0.000), (0.922, -0.671, 0.263)),
            ((0.000, 0.000, 1.000), (0.153, -1.415, -0.449)),
        ],
    )
    def test_oklab(self, xyz, expected):
        """Ottosson's table of pairs, three decimals."""
        np.testing.assert_allclose(one(oklab(), xyz), expected, atol=5.01e-4)

    def test_ipt(self):
        """IPT is defined so that Ebner's D65 is (1, 0, 0); its four digits leave 10⁻⁴."""
        np.testing.assert_allclose(one(ipt(), (0.9504, 1.0, 1.0889)), (1, 0, 0), atol=1e-4)
        np.testing.assert_allclose(one(ipt(), (0.0, 0.0, 0.0)), 0.0)

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
    def test_the_perceptual_quantizer(self, luminance, signal):
        assert pq_signal(np.array(luminance)) == pytest.approx(signal, abs=0.005)

    @pytest.mark.parametrize(
        ("rgb", "expected"),
        [  # white of 203 cd/m²; culori's tests of `itp` (CSS Color HDR), and ColorAide's
            ((1, 1, 1), (0.5806888810416109, 0.0, 0.0)),
            ((1, 0, 0), (0.4278802843622844, -0.11570435976969046, 0.27872894737532694)),
        ],
    )
    def test_ictcp_of_srgb(self, rgb, expected):
        np.testing.assert_allclose(one(ictcp(203.0), CSS_SRGB @ rgb), expected, atol=1e-6)

    def test_ictcp_of_the_primaries_of_bt_2020(self):
        """BT.2100's table 7 has 1688, 683 and 99 / 4096 for red's L, M and S."""
        xyz = np.array([0.636958, 0.262700, 0.0])  # BT.2020's red, Y 0.2627 of the white
        cones = pq_signal(1e4 * np.array([1688, 683, 99]) / 4096)
        expected = (
            np.array([(2048, 2048, 0), (6610, -13613, 7003), (17933, -17390, -543)]) @ cones
        ) / 4096
        np.testing.assert_allclose(one(ictcp(10_000.0), xyz), expected, atol=2e-6)

    def test_distances_in_itp_are_those_of_bt_2124(self):
        """ΔE_ITP = 720 √(ΔI² + ΔT² + ΔP²), T = 0.5 Ct (ITU-R BT.2124-0, annex 1)."""
        xyz = colours(2)
        (i, t, p), *_ = np.diff(ictcp(203.0).coordinates(xyz)[0], axis=0)
        expected = 720 * np.sqrt(i**2 + 0.25 * t**2 + p**2)
        given = np.diff(ictcp(203.0, itp=True).coordinates(xyz)[0], axis=0)
        assert np.linalg.norm(given) == pytest.approx(expected)

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
    def test_din99o(self, lab, expected):
        xyz = Cielab(D65).xyz(np.array([lab], float))[0]
        np.testing.assert_allclose(one(Din99(D65), xyz), expected, atol=6e-4)


@pytest.mark.parametrize(
    "name", sorted(set(FORMULAS) - {"CIEXYZ", "DIN99o", "CAM16-UCS", "CAM02-UCS"})
)
@pytest.mark.slow
def test_agrees_with_colour_science(name):
    """colour-science has no DIN99o; the appearance models have tests of their own."""
    colour = colour_science()
    xyz, white = colours(), colour.XYZ_to_xy(D65)
    theirs = {
        "CIELAB": lambda: colour.XYZ_to_Lab(xyz, white),
        "CIELUV": lambda: colour.XYZ_to_Luv(xyz, white),
        "Oklab": lambda: colour.XYZ_to_Oklab(xyz),
        "IPT": lambda: colour.XYZ_to_IPT(xyz),
        "ICtCp": lambda: colour.XYZ_to_ICtCp(203 * xyz),
        "ITP": lambda: colour.XYZ_to_ICtCp(1000 * xyz) * (720, 360, 720),
        "Jzazbz": lambda: colour.XYZ_to_Jzazbz(203 * xyz),
    }[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # colour-science's about domains
        expected = theirs()
    tolerance = {"ITP": 0.02, "ICtCp": 2e-5}.get(name, 1e-6)  # its matrix of BT.2020 is rounded
    np.testing.assert_allclose(FORMULAS[name].coordinates(xyz)[0], expected, atol=tolerance)


@pytest.mark.parametrize("name", FORMULAS)
class TestBothWays:
    def test_round_trip(self, name):
        xyz = np.concatenate([colours(), np.zeros((1, 3)), D65[np.newaxis], 0.001 * colours(100)])
        coordinates, outside = FORMULAS[name].coordinates(xyz)
        assert not outside.any()
        np.testing.assert_allclose(FORMULAS[name].xyz(coordinates), xyz, atol=1e-8)

    def test_all_is_finite(self, name):
        """Imaginary colours, and coordinates far from any colour."""
        wild = np.random.default_rng(5).normal(0, 1, (5000, 3)) * np.logspace(-6, 3, 5000)[:, None]
        assert np.isfinite(FORMULAS[name].coordinates(wild)[0]).all()
        assert np.isfinite(FORMULAS[name].xyz(wild)).all()

    def test_lightness_grows_with_light(self, name):
        steps = np.linspace(0, 1, 200)[:, np.newaxis] * D65
        axis = 1 if name == "CIEXYZ" else 0
        assert (np.diff(FORMULAS[name].coordinates(steps)[0][:, axis]) > 0).all()


@pytest.mark.parametrize("name", ["CIELUV", "ICtCp", "ITP", "Jzazbz", "CAM16-UCS", "CAM02-UCS"])
def test_colours_without_coordinates_are_told(name):
    xyz = np.array([D65 / 2, (-0.2, 0.1, 0.3), (0.1, 0.1, -0.3), D65])
    outside = FORMULAS[name].coordinates(xyz)[1]
    np.testing.assert_array_equal(outside, [False, True, True, False])


D65_100 = np.array([95.047, 100.0, 108.883])
MATERIAL_SRGB = np.array(
    [
        (0.41233895, 0.35762064, 0.18051042),
        (0.2126, 0.7152, 0.0722),
        (0.01932141, 0.11916382, 0.95034478),
    ]
)
"""Linear sRGB to XYZ in material-color-utilities."""


def correlates(model, xyz):
    lightness, colourfulness, hue, outside = model.correlates(np.array([xyz]))
    assert not outside.any()
    return lightness[0], colourfulness[0], np.rad2deg(hue[0]) % 360


@pytest.mark.parametrize(
    ("luminance", "expected"),
    [(200.0, (48.0314, 38.7789, 191.0452)), (20.0, (47.6856, 29.7580, 185.3445))],
)
def test_the_worked_examples_of_cie_159(luminance, expected):
    """CIE 159:2004, clause 9, whose white has Y 90 and whose background Y 18."""
    model = AppearanceModel("CIECAM02", np.array([98.88, 90.0, 32.03]), luminance, 18.0, "average")
    assert correlates(model, (19.31, 23.93, 10.14)) == pytest.approx(expected, abs=1e-4)


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
    model = AppearanceModel("CIECAM02", np.array(white), luminance, 20.0, "average")
    lightness, colourfulness, hue = correlates(model, xyz)
    assert (lightness, colourfulness) == pytest.approx(expected[:2], abs=0.0051)
    assert hue == pytest.approx(expected[2], abs=0.051)


def test_the_worked_example_of_cam16():
    """Li et al. 2017 with the conditions of CIECAM02's first example: J, M and h."""
    model = AppearanceModel("CAM16", np.array([95.05, 100.0, 108.88]), 318.31, 20.0, "average")
    expected = (41.7312, 0.1074, 217.068)
    assert correlates(model, (19.01, 20.0, 21.78)) == pytest.approx(expected, abs=1e-3)


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
    gray = ((50 + 16) / 116) ** 3 * 100
    model = AppearanceModel("CAM16", D65_100, 200 / np.pi * gray / 100, gray, "average")
    assert correlates(model, 100 * MATERIAL_SRGB @ rgb) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("name", ["CAM16", "CIECAM02"])
@pytest.mark.parametrize("surround", SURROUNDS)
@pytest.mark.parametrize(("luminance", "background"), [(4.0, 20.0), (318.31, 10.0), (0.1, 60.0)])
class TestUniformSpace:
    def test_agrees_with_colour_science(self, name, surround, luminance, background):
        colour = colour_science()
        rgb = np.random.default_rng(1).random((500, 3))
        xyz = 100 * rgb @ CSS_SRGB.T
        theirs = {"CAM16": colour.XYZ_to_CAM16, "CIECAM02": colour.XYZ_to_CIECAM02}[name](
            xyz, D65_100, luminance, background, colour.VIEWING_CONDITIONS_CAM16[surround.title()]
        )
        jmh = np.stack([theirs.J, theirs.M, theirs.h], axis=1)
        uniform = {"CAM16": colour.models.JMh_CAM16_to_CAM16UCS}.get(
            name, colour.models.JMh_CIECAM02_to_CAM02UCS
        )
        ours, outside = AppearanceModel(name, D65_100, luminance, background, surround).uniform(xyz)
        assert not outside.any()
        np.testing.assert_allclose(ours, uniform(jmh), atol=1e-6)


@pytest.mark.parametrize(
    ("y", "lightness"),
    [
        # By hand from CIE 15: L* 50 is Y = (66/116)³, L* 8 is 216/24389, and a straight line below.
        ((66 / 116) ** 3, 50),
        (216 / 24389, 8),
        (108 / 24389, 4),
        (0, 0),
    ],
)
def test_lightness_of_grays(y, lightness):
    np.testing.assert_allclose(xyz_to_lab(y * ICC_D50), [lightness, 0, 0], atol=1e-9)


def test_colour_science_agrees():
    xyz = np.random.default_rng(1).uniform(-0.01, 1.2, (1000, 3))
    for white in (ICC_D50, white_of("A", "10")):
        chromaticity = white[:2] / white.sum()
        expected = colour_science().XYZ_to_Lab(xyz, chromaticity)
        np.testing.assert_allclose(xyz_to_lab(xyz, white), expected, atol=1e-10)
        back = colour_science().Lab_to_XYZ(expected, chromaticity)
        np.testing.assert_allclose(lab_to_xyz(expected, white), back, atol=1e-12)


def test_slightly_negative_values_go_on_in_a_straight_line():
    lab = xyz_to_lab(np.array([[-0.001, -0.001, -0.001], [0, 0, 0], [0.001, 0.001, 0.001]]))
    np.testing.assert_allclose(lab[1] - lab[0], lab[2] - lab[1], atol=1e-9)


def test_whites_of_illuminants():
    # ASTM E308, table 5: D65, 2° and 10°, and A, 2°.
    np.testing.assert_allclose(white_of("D65", "2"), [0.95047, 1, 1.08883], atol=3e-4)
    np.testing.assert_allclose(white_of("D65", "10"), [0.94811, 1, 1.07304], atol=3e-4)
    np.testing.assert_allclose(white_of("a", "2"), [1.09850, 1, 0.35585], atol=3e-4)
    np.testing.assert_allclose(white_of("F11", "2"), [1.00962, 1, 0.64350], atol=3e-4)
    assert white_of("D50", "2") is ICC_D50
    assert white_of("candle", "2") is None


@pytest.mark.slow
def test_importing_colour_science_leaves_no_mocks_behind():
    program = (
        "import sys, gamutcore.colours\n"
        "assert 'colour' not in sys.modules\n"
        "from gamutcore.colours.spaces.cielab import colour_science\n"
        "colour_science()\n"
        "print([n for n, m in sys.modules.items() if 'Mock' in type(m).__name__])\n"
    )
    ended = subprocess.run(
        [sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=False
    )
    assert ended.stderr == ""
    assert ended.stdout.strip() == "[]"


# Bruce Lindbloom, Chromatic Adaptation: ASTM_D65 to ASTM_D50 of ASTM E308
LINDBLOOM_MATRICES = {
    "Bradford": [
        (1.0478112, 0.0228866, -0.0501270),
        (0.0295424, 0.9904844, -0.0170491),
        (-0.0092345, 0.0150436, 0.7521316),
    ],
    "von-Kries": [
        (1.0160803, 0.0552297, -0.0521326),
        (0.0060666, 0.9955661, -0.0012235),
        (0.0, 0.0, 0.7578869),
    ],
    "XYZ-scaling": [(1.0144665, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.7578869)],
}


@pytest.mark.parametrize("name", LINDBLOOM_MATRICES)
def test_matrices_are_those_of_lindblooms_table(name):
    np.testing.assert_allclose(
        adaptation_matrix(ASTM_D65, ASTM_D50, name), LINDBLOOM_MATRICES[name], atol=2e-6
    )


@pytest.mark.parametrize("name", sorted(set(ADAPTATIONS) - {"none"}))
def test_matrices_are_those_of_colour_science(name):
    theirs = name.replace("-s", " S").replace("-K", " K").replace("von", "Von")
    expected = colour_science().adaptation.matrix_chromatic_adaptation_VonKries(
        ASTM_D65, ASTM_D50, transform=theirs
    )
    np.testing.assert_allclose(adaptation_matrix(ASTM_D65, ASTM_D50, name), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "expected"),
    [  # ASTM E308, as in Lindbloom's table; the last two: SMPTE RP 431-2 and ST 2065-1
        ("A", (1.09850, 0.35585)),
        ("C", (0.98074, 1.18232)),
        ("D55", (0.95682, 0.92149)),
        ("D65", (0.95047, 1.08883)),
        ("D75", (0.94972, 1.22638)),
        ("E", (1.0, 1.0)),
        ("DCI", (0.89459, 0.95442)),
        ("D60", (0.95265, 1.00883)),
    ],
)
def test_whites_are_the_published_ones(name, expected):
    x, y, z = white_point(name)
    assert y == 1.0
    np.testing.assert_allclose((x, z), expected, atol=3e-4)


@pytest.mark.parametrize("name", sorted(set(ADAPTATIONS) - {"none"}))
@pytest.mark.parametrize("white", WHITES)
def test_a_white_becomes_the_other_and_two_steps_are_one(name, white):
    source, middle, target = white_point(white), white_point("D50"), white_point("D65")
    there = adaptation_matrix(source, target, name)
    np.testing.assert_allclose(there @ source, target, atol=1e-12)
    composed = adaptation_matrix(middle, target, name) @ adaptation_matrix(source, middle, name)
    np.testing.assert_allclose(composed, there, atol=1e-12)
