"""BT.2100 at a peak luminance: light, volumes in ICtCp and ITP, distinguishable colours."""

import numpy as np
import pytest

import gamutcore
from gamutcore.colours import surface_colours
from gamutcore.colours.colorimetry import colour_science
from gamutcore.colours.reference import rgb_xyz
from gamutcore.errors import OptionError
from gamutcore.references import REFERENCES

PEAKS = {
    "bt2100-pq-1000": 1000,
    "bt2100-pq-4000": 4000,
    "bt2100-pq-10000": 10_000,
    "bt2100-hlg-1000": 1000,
}


@pytest.mark.parametrize("slug", PEAKS)
def test_full_code_is_white_of_the_peak_luminance_and_zero_is_black(slug):
    found = rgb_xyz(REFERENCES[slug], np.array([(1.0, 1, 1), (0, 0, 0)]))
    assert 203 * found[0, 1] == pytest.approx(PEAKS[slug], rel=1e-6)
    np.testing.assert_allclose(found[1], 0, atol=1e-9)


def test_light_is_that_of_colour_science():
    """`eotf_BT2100_PQ` and `eotf_BT2100_HLG` for a peak of 1,000 cd/m², which is clipped for PQ."""
    from colour.models import eotf_BT2100_HLG, eotf_BT2100_PQ

    codes = np.random.default_rng(1).uniform(0, 1, (200, 3))
    matrix = colour_science().RGB_COLOURSPACES["ITU-R BT.2020"].matrix_RGB_to_XYZ
    pq = np.minimum(eotf_BT2100_PQ(codes), 1000)
    hlg = eotf_BT2100_HLG(codes, L_W=1000, gamma=1.2)
    for slug, light in (("bt2100-pq-1000", pq), ("bt2100-hlg-1000", hlg)):
        expected = light @ matrix.T / 203
        np.testing.assert_allclose(rgb_xyz(REFERENCES[slug], codes), expected, rtol=2e-4, atol=1e-5)


def itp_of(codes, peak):
    """ΔE_ITP coordinates of PQ codes (ITU-R BT.2100-2, table 7; BT.2124-0, annex 1)."""
    m1, m2, c1, c2, c3 = 2610 / 16384, 2523 / 32, 3424 / 4096, 2413 / 128, 2392 / 128
    root = codes ** (1 / m2)
    light = 1e4 * (np.maximum(root - c1, 0) / (c2 - c3 * root)) ** (1 / m1)
    cones = (
        np.minimum(light, peak)
        @ np.array([(1688, 2146, 262), (683, 2951, 462), (99, 309, 3688)]).T
        / 4096
    )
    power = (cones / 1e4) ** m1
    signals = ((c1 + c2 * power) / (1 + c3 * power)) ** m2
    opponent = np.array([(2048, 2048, 0), (6610, -13613, 7003), (17933, -17390, -543)]) / 4096
    return 720 * (signals @ opponent.T) * (1, 0.5, 1)


def cells_volume(peak, count):
    """Volume of the image of a lattice of cubes of codes, each as five tetrahedra."""
    top = {1000: 0.751827, 10_000: 1.0}[peak]  # codes of the peaks, ITU-R BT.2100-2, table 4
    axis = np.linspace(0, top, count + 1)
    grid = itp_of(np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1), peak)
    corner = {
        (i, j, k): grid[i : count + i, j : count + j, k : count + k]
        for i in (0, 1)
        for j in (0, 1)
        for k in (0, 1)
    }
    split = [
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(1, 1, 0), (0, 1, 0), (1, 0, 0), (1, 1, 1)],
        [(1, 0, 1), (0, 0, 1), (1, 1, 1), (1, 0, 0)],
        [(0, 1, 1), (1, 1, 1), (0, 0, 1), (0, 1, 0)],
        [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)],
    ]
    return abs(
        sum(
            np.linalg.det(np.stack([corner[each] - corner[a] for each in (b, c, d)], axis=-1)).sum()
            for a, b, c, d in split
        )
        / 6
    )


@pytest.mark.slow
@pytest.mark.parametrize("slug", ["bt2100-pq-1000", "bt2100-pq-10000"])
def test_distinguishable_colours_agree_with_an_independent_integral(slug):
    """Both converge with the square of the spacing, so a refinement by 2 leaves a third of the
    last difference."""
    coarse, fine = (cells_volume(PEAKS[slug], count) for count in (32, 64))
    exact, error = fine + (fine - coarse) / 3, abs(fine - coarse)
    few, many = (
        gamutcore.reference(slug, space="ITP", surface_samples=count).description
        for count in (2500, 10_000)
    )
    error += abs(many["distinguishable_colours"] - few["distinguishable_colours"])
    assert error < 0.01 * exact  # the bound says something
    assert many["distinguishable_colours"] == pytest.approx(exact, abs=error)


@pytest.mark.slow
def test_ictcp_and_itp_count_the_same_colours():
    """BT.2124: T is half of Ct, and 720 units are one of I. The surface is divided by curvature,
    which differs; both divisions have the error that the number of samples bounds."""
    few, itp, ictcp = (
        gamutcore.reference("bt2100-hlg-1000", space=space, surface_samples=samples).description[
            "distinguishable_colours"
        ]
        for space, samples in (("ITP", 2500), ("ITP", 10_000), ("ICtCp", 10_000))
    )
    assert ictcp == pytest.approx(itp, abs=abs(itp - few))


@pytest.mark.slow
def test_only_spaces_of_the_unit_count_colours():
    srgb = gamutcore.reference("srgb", surface_samples=2000)
    assert "distinguishable_colours" not in srgb.description


@pytest.mark.slow
def test_a_display_is_compared_at_its_luminance():
    """In ITP, coordinates are absolute: a white of 1,000 cd/m² is that of BT.2100."""
    options = {"space": "ITP", "surface_samples": 5000}
    bright, dim = (
        gamutcore.reference("bt2020", luminance=luminance, **options)
        for luminance in (1000.0, 100.0)
    )
    # BT.2020 of 1,000 cd/m² and BT.2100 PQ up to it are the same colours
    perceptual_quantizer = gamutcore.reference("bt2100-pq-1000", **options)
    assert bright.coverage_of(perceptual_quantizer) == pytest.approx(1, abs=0.02)
    assert dim.coverage_of(perceptual_quantizer) < 0.7
    assert bright.compare(perceptual_quantizer).white_b[0] == pytest.approx(
        itp_of(np.full((1, 3), 0.751827), 1000)[0, 0], abs=0.1
    )


def test_another_luminance_of_the_white_is_refused():
    with pytest.raises(OptionError, match="states its luminances"):
        gamutcore.reference("bt2100-pq-1000", space="ITP", luminance=1000, surface_samples=500)


def test_codes_reach_to_the_peak():
    found = surface_colours(REFERENCES["bt2100-pq-1000"], surface_samples=500)
    assert found.device.max() == pytest.approx(0.751827, abs=1e-6)  # BT.2100-2, table 4
    assert found.provenance["peak_luminance"] == 1000
