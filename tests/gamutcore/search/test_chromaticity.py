"""Chromaticity gamuts: areas and coverage of published primaries, devices and prints."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import gamutcore
from gamutcore import Gamut
from gamutcore.characterisation import read_characterisation
from gamutcore.colours import ICC_D50
from gamutcore.results import ChromaticityGamut
from gamutcore.search import chromaticity_gamut

PRIMARIES = {
    "bt709": [(0.640, 0.330), (0.300, 0.600), (0.150, 0.060)],  # ITU-R BT.709-6, 1.3
    "display-p3": [(0.680, 0.320), (0.265, 0.690), (0.150, 0.060)],  # SMPTE RP 431-2, 8.2
    "bt2020": [(0.708, 0.292), (0.170, 0.797), (0.131, 0.046)],  # ITU-R BT.2020-2, table 3
    "adobe-rgb-1998": [(0.640, 0.330), (0.210, 0.710), (0.150, 0.060)],  # Adobe RGB (1998), 4.3.1
}

FEW = {"surface_samples": 2000}


def shoelace(corners):
    (ax, ay), (bx, by), (cx, cy) = corners
    return abs(ax * (by - cy) + bx * (cy - ay) + cx * (ay - by)) / 2


def uv(corners):
    """CIE 15:2018, 8.2.2."""
    return [(4 * x / (3 + 12 * y - 2 * x), 9 * y / (3 + 12 * y - 2 * x)) for x, y in corners]


def inside(points, corners):
    """Whether points are in a triangle: the same side of all edges."""
    points, corners = np.asarray(points), np.asarray(corners)
    signs = [
        (b - a)[0] * (points - a)[:, 1] - (b - a)[1] * (points - a)[:, 0]
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
    ]
    return np.all(np.array(signs) >= 0, axis=0) | np.all(np.array(signs) <= 0, axis=0)


@pytest.fixture(scope="module")
def described():
    return {
        slug: gamutcore.reference(slug, **FEW).description["chromaticity"] for slug in PRIMARIES
    }


@pytest.mark.slow
@pytest.mark.parametrize("slug", PRIMARIES)
def test_areas_are_those_of_the_published_primaries(described, slug):
    found, corners = described[slug], PRIMARIES[slug]
    assert found["basis"] == "primaries"
    np.testing.assert_allclose(sorted(found["corners"]), sorted(map(list, corners)), atol=2e-7)
    for diagram, own, bt709 in (
        ("xy", corners, PRIMARIES["bt709"]),
        ("uv", uv(corners), uv(PRIMARIES["bt709"])),
    ):
        assert found[diagram]["area"] == pytest.approx(shoelace(own), abs=1e-6)
        ratio = shoelace(own) / shoelace(bt709)
        assert found[diagram]["of_bt709"] == pytest.approx(ratio, abs=1e-5)


@pytest.mark.slow
def test_coverage_agrees_with_the_figures_in_common_use(described):
    """BT.709 and P3 of BT.2020 in xy are quoted as 52.9 % and 71.7 %; both lie inside of it."""
    for slug, percent in (("bt709", 52.9), ("display-p3", 71.7)):
        assert round(100 * described[slug]["xy"]["coverage"]["bt2020"], 1) == percent
    for diagram in ("xy", "uv"):
        for slug in PRIMARIES:
            assert described[slug][diagram]["coverage"][slug] == pytest.approx(1, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("diagram", ["xy", "uv"])
def test_coverage_agrees_with_counting_random_chromaticities(described, diagram):
    """The bound is four standard deviations of the binomial distribution."""
    convert = uv if diagram == "uv" else list
    one, two = convert(PRIMARIES["display-p3"]), convert(PRIMARIES["adobe-rgb-1998"])
    shares = np.random.default_rng(6).dirichlet((1, 1, 1), 200_000)  # uniform in a triangle
    counted = inside(shares @ np.array(two), one).mean()
    stated = described["display-p3"][diagram]["coverage"]["adobe-rgb-1998"]
    assert abs(stated - counted) <= 4 * np.sqrt(counted * (1 - counted) / len(shares))


def random_gamut(generator):
    xyz = generator.uniform(0.05, 1, (30, 3))
    return chromaticity_gamut(xyz, xyz[:, 1])


def test_overlaps_of_random_polygons_are_consistent():
    generator = np.random.default_rng(1)
    for _ in range(200):
        one, two = random_gamut(generator), random_gamut(generator)
        there, back = one.compare(two), two.compare(one)
        for diagram in ("xy", "uv"):
            a, b = getattr(there, diagram), getattr(back, diagram)
            assert a.intersection == pytest.approx(b.intersection, abs=1e-12)
            assert 0 <= a.intersection <= min(a.area_a, a.area_b)
            assert a.area_ratio == pytest.approx(1 / b.area_ratio)
            hull = ConvexHull(getattr(one, diagram))
            assert hull.volume == pytest.approx(a.area_a)  # convex in both diagrams


def test_disjoint_and_contained_polygons():
    square = np.array([(0.2, 0.2), (0.4, 0.2), (0.4, 0.4), (0.2, 0.4)])
    whole, part = (
        ChromaticityGamut(square, "colours"),
        ChromaticityGamut(square / 2 + 0.15, "colours"),
    )
    away = ChromaticityGamut(square + np.array([0.0, 0.3]), "colours")
    assert whole.compare(part).xy.b_covers_a == pytest.approx(0.25)
    assert whole.compare(part).xy.a_covers_b == 1
    assert whole.compare(away).xy.intersection == 0
    assert whole.compare(away).uv.intersection == 0


@pytest.mark.parametrize(
    "xyz",
    [
        np.empty((0, 3)),
        np.ones((5, 3)),
        np.array([(0.2, 0.2, 0.2), (0.5, 0.5, 0.1), (0.8, 0.8, 0.0)]),
        np.full((5, 3), np.nan),
    ],
    ids=["none", "one", "a line", "not finite"],
)
def test_chromaticities_without_an_area_are_no_gamut(xyz):
    assert chromaticity_gamut(xyz, np.ones(len(xyz))) is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "slug"), [("DisplayP3-v4.icc", "display-p3"), ("sRGB-v2-magic.icc", "bt709")]
)
def test_a_display_has_the_chromaticities_of_its_primaries_before_adaptation(file, slug):
    """Colorants and the tag chad are rounded to 2⁻¹⁶, the darkest sum of X, Y and Z is 0.15."""
    found = Gamut(Path("tests/data") / file, **FEW).chromaticity()
    assert found.basis == "primaries"
    np.testing.assert_allclose(
        sorted(found.xy.tolist()), sorted(map(list, PRIMARIES[slug])), atol=2 * 2**-16 / 0.15
    )


@pytest.mark.slow
def test_a_display_without_chad_is_adapted_from_its_white():
    """Linear Bradford transform of ICC.1:2022, annex E, from D50 to the media white."""
    path = Path("examples/Panasonic-TV.icc")
    profile = read_characterisation(path.read_bytes())
    colorants = np.array([profile.xyz(f"{channel}XYZ") for channel in "rgb"])
    cones = np.array(
        [(0.8951, 0.2664, -0.1614), (-0.7502, 1.7135, 0.0367), (0.0389, -0.0685, 1.0296)]
    )
    gains = (cones @ profile.xyz("wtpt")) / (cones @ ICC_D50)
    own = colorants @ (np.linalg.inv(cones) @ np.diag(gains) @ cones).T
    expected = own[:, :2] / own.sum(axis=1, keepdims=True)
    for intent in ("relative", "absolute"):
        found = Gamut(path, intent=intent, **FEW).chromaticity()
        np.testing.assert_allclose(sorted(found.xy.tolist()), sorted(expected.tolist()), atol=1e-6)


@pytest.mark.slow
def test_a_print_has_the_hull_of_its_absolute_colours_whatever_the_intent():
    gamuts = [
        Gamut("examples/FOGRA39L.ti3", intent=intent, **FEW) for intent in ("relative", "absolute")
    ]
    relative, absolute = (each.chromaticity() for each in gamuts)
    assert relative.basis == absolute.basis == "colours"
    assert relative.compare(absolute).xy.intersection == pytest.approx(
        relative.compare(absolute).xy.area_a, rel=1e-5
    )
    # the paper and the solid inks of the file, ISO 12647-2 measured under D50, are inside
    xyz = gamuts[1].colour_space.tristimulus(gamuts[1].level(2000).vertices)
    bright = xyz[xyz[:, 1] > 0.011]
    xy = bright[:, :2] / bright.sum(axis=1, keepdims=True)
    assert len(ConvexHull(np.vstack([xy, absolute.xy])).vertices) <= len(absolute.xy) + 3
    white = ICC_D50[:2] / ICC_D50.sum()
    assert ConvexHull(np.vstack([absolute.xy, white])).volume == pytest.approx(
        absolute.compare(absolute).xy.area_a
    )


@pytest.mark.slow
def test_a_comparison_states_chromaticities_beside_volumes():
    one, two = gamutcore.reference("sRGB", **FEW), gamutcore.reference("bt2020", **FEW)
    found = one.compare(two)
    expected = shoelace(PRIMARIES["bt709"]) / shoelace(PRIMARIES["bt2020"])
    assert found.chromaticity.xy.area_ratio == pytest.approx(expected, abs=1e-6)
    assert found.chromaticity.xy.a_covers_b == pytest.approx(expected, abs=1e-6)
    assert found.chromaticity.xy.b_covers_a == pytest.approx(1)
    del two.description["chromaticity"]  # as built by an earlier version
    assert two.chromaticity() is None
    assert one.compare(two).chromaticity is None
