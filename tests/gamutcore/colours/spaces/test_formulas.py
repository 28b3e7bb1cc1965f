"""Every space's formula against published worked examples, colour-science, and its own inverse."""

import warnings

import numpy as np
import pytest

from gamutcore.colours.spaces.appearance_model import AppearanceModel
from gamutcore.colours.spaces.cielab import colour_science
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
    pq_luminance,
    pq_signal,
)
from gamutcore.colours.spaces.white_points import adaptation_matrix, white_point

LINDBLOOM_SRGB = np.array(
    [
        (0.4124564, 0.3575761, 0.1804375),
        (0.2126729, 0.7151522, 0.0721750),
        (0.0193339, 0.1191920, 0.9503041),
    ]
)
"""Linear sRGB to XYZ with the D65 of ASTM E308, by Bruce Lindbloom."""
ASTM_D65 = np.array([0.95047, 1.0, 1.08883])

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
        ("rgb", "expected"),
        [  # ColorAide's tests of IPT: red, yellow, CSS's green, blue
            ((1, 0, 0), (0.45616, 0.62091, 0.44282)),
            ((1, 1, 0), (0.85655, -0.10830, 0.65147)),
            ((0, 128 / 255, 0), (0.39330, -0.23454, 0.27459)),
            ((0, 0, 1), (0.44429, -0.23720, -0.74849)),
        ],
    )
    def test_ipt_of_srgb(self, rgb, expected):
        """ColorAide adapts to Ebner's four digits of D65 first."""
        ebner = adaptation_matrix(D65, np.array([0.9504, 1.0, 1.0889]), "Bradford")
        xyz = ebner @ CSS_SRGB @ linear(rgb)
        np.testing.assert_allclose(one(ipt(), xyz), expected, atol=1e-5)

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
        ("rgb", "expected"),
        [  # ColorAide's tests of Jzazbz, white of 203 cd/m²
            ((1, 1, 1), (0.22207, -0.00016, -0.00012)),
            ((1, 0, 0), (0.13438, 0.11789, 0.11188)),
            ((1, 1, 0), (0.20960, -0.02864, 0.13479)),
            ((0, 128 / 255, 0), (0.09203, -0.07454, 0.07996)),
            ((0, 0, 1), (0.09577, -0.04085, -0.18585)),
        ],
    )
    def test_jzazbz_of_srgb(self, rgb, expected):
        xyz = CSS_SRGB @ linear(rgb)
        np.testing.assert_allclose(one(Jzazbz(203.0), xyz), expected, atol=2e-5)

    @pytest.mark.parametrize(
        ("rgb", "expected"),
        [  # ColorAide's tests of CAM16-UCS: L_A 64/π/5, Y_b 20, average
            ((1, 0, 0), (59.178, 40.820, 21.153)),
            ((1, 1, 0), (96.802, -12.779, 33.037)),
            ((0, 128 / 255, 0), (46.661, -26.746, 20.671)),
            ((0, 0, 1), (36.252, 8.5723, -37.870)),
        ],
    )
    def test_cam16_ucs_of_srgb(self, rgb, expected):
        model = AppearanceModel("CAM16", 100 * D65, 64 / np.pi / 5, 20.0, "average")
        xyz = CSS_SRGB @ linear(rgb)
        np.testing.assert_allclose(one(UniformAppearance(model), xyz), expected, atol=2e-3)

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


def test_the_quantizer_and_its_inverse():
    luminance = np.concatenate([[0.0], np.logspace(-6, 4, 100)])
    np.testing.assert_allclose(pq_luminance(pq_signal(luminance)), luminance, rtol=1e-9, atol=1e-12)
