"""Comparisons, against boxes, spheres, Manifold's booleans and published figures."""

import manifold3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gamutcore
from benchmarks.booleans import intersection_volume
from gamutcore.errors import MeshError, OptionError
from gamutcore.geometry import TriangleMesh
from gamutcore.search import build_index, compare


def moved(level, shift, scale=1.0):
    """Return a level that is magnified about its centre and moved."""
    vertices, faces, centre = level
    shift = np.asarray(shift, np.float64)
    return centre + scale * (vertices.astype(np.float64) - centre) + shift, faces, centre + shift


def volume(level):
    return TriangleMesh(level[0], level[1]).volume


def box(cube, low, high, share):
    vertices, faces, _ = cube
    low, high = np.array(low, np.float64), np.array(high, np.float64)
    return low + (vertices + 1) / 2 * (high - low), faces, low + share * (high - low)


SIDE = st.tuples(st.integers(-3, 3), st.integers(1, 3))
SIDES = st.tuples(SIDE, SIDE, SIDE)
SHARE = st.sampled_from([0.25, 1 / 3, 0.5, 0.75])


class TestCompare:
    @settings(max_examples=40)
    @given(one=SIDES, two=SIDES, shares=st.tuples(SHARE, SHARE))
    def test_boxes_on_a_lattice(self, cube, one, two, shares):
        """Faces, edges and planes through the centres coincide in every way."""
        low, other_low = ([start for start, _ in each] for each in (one, two))
        high, other_high = ([start + length for start, length in each] for each in (one, two))
        found = compare(
            box(cube, low, high, shares[0]), box(cube, other_low, other_high, shares[1]), 7
        )
        sides = np.minimum(high, other_high) - np.maximum(low, other_low)
        assert found.intersection == pytest.approx(np.prod(np.maximum(sides, 0)), abs=1e-8)
        assert found.volume_a == pytest.approx(np.prod(np.subtract(high, low)))

    @settings(max_examples=30)
    @given(
        seeds=st.tuples(st.integers(0, 99), st.integers(100, 199)),
        shift=st.tuples(*[st.floats(-30, 30)] * 3),
    )
    def test_rough_spheres_are_what_manifold_says(self, rough, seeds, shift):
        one, two = rough(seeds[0], 60), moved(rough(seeds[1], 40), shift)
        expected = intersection_volume(TriangleMesh(*one[:2]), TriangleMesh(*two[:2]))
        found, turned = compare(one, two), compare(two, one)
        whole = min(volume(one), volume(two))
        assert found.intersection == pytest.approx(expected, abs=1e-9 * whole)
        assert turned.intersection == pytest.approx(found.intersection, abs=1e-9 * whole)
        assert turned.a_covers_b == pytest.approx(found.b_covers_a, abs=1e-9)

    @given(scale=st.floats(0.01, 0.999), seed=st.integers(0, 20))
    def test_of_concentric_bodies_the_larger_covers_the_smaller(self, rough, scale, seed):
        level = rough(seed, 50)
        found = compare(level, moved(level, np.zeros(3), scale))
        assert found.a_covers_b == pytest.approx(1, abs=1e-9)
        assert found.b_covers_a == pytest.approx(scale**3, rel=1e-9)
        assert found.symmetric_difference / found.volume_a == pytest.approx(1 - scale**3, abs=1e-9)

    @pytest.mark.slow
    def test_the_lens_of_two_spheres(self, rough):
        one = rough(1, 20_000, 0.0)
        two = moved(rough(2, 20_000, 0.0), (10, 20, -20))  # 30 apart
        lens = np.pi * (4 * 40 + 30) * (2 * 40 - 30) ** 2 / 12
        assert compare(one, two).intersection == pytest.approx(lens, rel=2e-3)

    def test_gamuts_that_do_not_meet(self, rough):
        level = rough(5, 30)
        found = compare(level, moved(level, (0, 200, 0)))
        assert (found.intersection, found.a_covers_b, found.jaccard) == (0, 0, 0)
        assert found.union == found.volume_a + found.volume_b == found.symmetric_difference
        # each is in few of the sectors
        assert np.isnan(found.sectors.a_covers_b).any()

    def test_sectors_add_up_and_are_what_manifold_cuts(self, rough):
        one, two = rough(6, 80), moved(rough(7, 70), (3, 12, -9))
        found = compare(one, two, 9)
        np.testing.assert_array_equal(found.hues, np.arange(0, 361, 40))
        assert found.sectors.intersection.sum() == pytest.approx(found.intersection)
        assert found.intersection == pytest.approx(compare(one, two, 1).intersection)
        solids = [
            manifold3d.Manifold(
                manifold3d.Mesh64(level[0].astype(float), level[1].astype(np.uint64))
            )
            for level in (one, two)
        ]
        for sector, hue in enumerate(np.radians(found.hues[:-1])):
            wedge, end = (solids[0], solids[1], solids[0] ^ solids[1]), hue + np.radians(40)
            volumes = [
                solid.trim_by_plane((0, -np.sin(hue), np.cos(hue)), 0)
                .trim_by_plane((0, np.sin(end), -np.cos(end)), 0)
                .volume()
                for solid in wedge
            ]
            of_sector = [
                values[sector]
                for values in (
                    found.sectors.volume_a,
                    found.sectors.volume_b,
                    found.sectors.intersection,
                )
            ]
            np.testing.assert_allclose(of_sector, volumes, rtol=1e-8, atol=1e-6)

    def test_what_is_refused(self, cube):
        for sectors in (0, 3601, 2.5, True):
            with pytest.raises(OptionError) as caught:
                compare(cube, cube, sectors)
            assert caught.value.where["field"] == "sectors"
        with pytest.raises(MeshError):
            compare(cube, (cube[0], cube[1][1:], cube[2]))


@pytest.fixture(scope="module")
def full():
    """Return a function that gives the full boundary of a reference gamut."""

    def build(name):
        history = gamutcore.reference(name, surface_samples=20_000).history
        mesh = history.full()
        return mesh, build_index(mesh.vertices, mesh.faces, history.centre)

    return build


@pytest.mark.slow
def test_published_coverage_of_rgb_spaces(full):
    # coverage of Adobe RGB by sRGB in CIELAB, D50, as published for colour-management tools
    found = compare(full("srgb")[1], full("adobe-rgb-1998")[1])
    assert found.a_covers_b == pytest.approx(0.689, abs=1e-3)
    # Display P3 in BT.2020
    found = compare(full("display-p3")[1], full("bt2020")[1])
    assert found.a_covers_b == pytest.approx(0.6640, abs=3e-4)
