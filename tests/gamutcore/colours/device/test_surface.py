"""Points and faces on the surface of a device, its limits, and the patches that they share."""

from math import comb, factorial, isqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from gamutcore.boundary import compute_boundary
from gamutcore.characterisation import characterisation
from gamutcore.colours.device.ink_cube import InkCube, surface_corners, surface_patches
from gamutcore.colours.device.surface import (
    device_surface,
    distinct_rows,
    outward_faces,
)
from gamutcore.colours.profile_colours import profile_colours
from gamutcore.mesh import TriangleMesh
from gamutcore.metric import radial_difference


def unit(channels, total=None):
    return InkCube(np.zeros(channels), np.ones(channels), total)


def areas(corners):
    """Areas of trapezoids (p, 2, 2, n) in any number of dimensions: two triangles each."""

    def triangle(a, b, c):
        u, v = b - a, c - a
        gram = (u * u).sum(-1) * (v * v).sum(-1) - (u * v).sum(-1) ** 2
        return np.sqrt(np.maximum(gram, 0)) / 2

    p = corners
    first = triangle(p[:, 0, 0], p[:, 1, 0], p[:, 0, 1])
    return first + triangle(p[:, 1, 1], p[:, 1, 0], p[:, 0, 1])


@pytest.mark.parametrize("channels", [2, 3, 4, 7])
def test_a_whole_cube_has_its_faces(channels):
    patches = surface_patches(unit(channels))
    assert len(patches.corners) == comb(channels, 2) * 2 ** (channels - 2)
    np.testing.assert_allclose(areas(patches.corners), 1)
    assert (patches.axes >= 0).all()
    assert len(np.unique(patches.corners.reshape(-1, channels), axis=0)) == 2**channels


def simplex_slice_volume(channels, total):
    """Volume of the unit cube up to a sum (Irwin-Hall distribution)."""
    return sum(
        (-1) ** k * comb(channels, k) * (total - k) ** channels for k in range(int(total) + 1)
    ) / factorial(channels)


@pytest.mark.parametrize("total", [0.4, 1.0, 1.5, 2.0, 2.3, 2.9])
def test_three_inks_are_enclosed_without_a_gap(total):
    patches = surface_patches(unit(3, total))
    # The patches' area is that of the convex hull of the cut cube, and so is the hull's volume.
    hull = ConvexHull(patches.corners.reshape(-1, 3))
    assert areas(patches.corners).sum() == pytest.approx(hull.area)
    assert hull.volume == pytest.approx(simplex_slice_volume(3, total))


@pytest.mark.parametrize(("channels", "total"), [(4, 3.0), (4, 2.4), (5, 1.7), (7, 3.0)])
def test_every_two_dimensional_face_is_covered_once(channels, total):
    corners = surface_patches(unit(channels, total)).corners
    expected = 0.0
    # The cube's faces: what is left of the unit square at each corner of the other channels.
    for ones in range(channels - 1):
        rest = total - ones
        share = np.clip([rest, rest - 1], 0, None) ** 2 / 2
        area = min(1.0, share[0] - 2 * share[1]) if rest < 2 else 1.0
        expected += comb(channels, 2) * comb(channels - 2, ones) * max(area, 0.0)
    # The cut's: a plane section of the unit cube at each corner of the others; its area is √3
    # times that of its projection, the part of the square where the third is within 0 and 1.
    for ones in range(channels - 2):
        rest = total - ones
        below = [max(rest - k, 0) ** 2 / 2 for k in range(4)]
        section = below[0] - 3 * below[1] + 3 * below[2] - below[3]
        faces = comb(channels, 3) * comb(channels - 3, ones)
        expected += faces * np.sqrt(3) * max(section, 0)
    assert areas(corners).sum() == pytest.approx(expected)


@pytest.mark.parametrize(("channels", "total"), [(3, 1.5), (4, 3.0), (4, 2.4), (7, 3.5)])
def test_corners_are_where_channels_or_the_limit_end(channels, total):
    corners = surface_corners(unit(channels, total))
    found = {tuple(row) for row in corners.round(9)}
    assert len(found) == len(corners)
    patches = surface_patches(unit(channels, total)).corners.reshape(-1, channels)
    assert found <= {tuple(row) for row in patches.round(9)}
    whole = int(total)
    expected = sum(comb(channels, k) for k in range(whole + 1))
    if total > whole:
        expected += comb(channels, whole) * (channels - whole)
    assert len(found) == expected


def bent(device):
    """Colours with the largest curvature at low values of the first channel."""
    a, b, c = (device[:, i % device.shape[1]] for i in range(3))
    return np.column_stack(
        [50 + 40 * a**0.3, 60 * (a**0.3 - b), 60 * (b - c) + 10 * device.sum(axis=1)]
    )


@given(
    st.integers(1, 6),
    st.integers(8, 4000),
    st.one_of(st.none(), st.floats(0.1, 6)),
)
@pytest.mark.slow
def test_points_are_on_the_surface_and_no_more_than_asked_for(channels, wanted, total):
    cube = unit(channels, total)
    surface = device_surface(cube, bent, wanted)
    device = surface.device
    assert device.min() >= -1e-9
    assert device.max() <= 1 + 1e-9
    assert len(device) <= max(wanted, len(surface_corners(cube)))
    if total is not None:
        assert device.sum(axis=1).max() <= total + 1e-6
    ends = ((device < 1e-6) | (device > 1 - 1e-6)).sum(axis=1)
    if total is not None and channels > 1:
        ends += np.abs(device.sum(axis=1) - total) < 1e-6
    assert (ends >= channels - 2).all()


@pytest.mark.parametrize(("channels", "total"), [(3, None), (4, None), (4, 2.5), (5, None)])
def test_nearly_as_many_as_asked_for_each_once(channels, total):
    surface = device_surface(unit(channels, total), bent, 20_000)
    assert surface.density == "by curvature"
    assert 0.95 * 20_000 <= len(surface.device) <= 20_000
    if total is None:
        assert len(np.unique(surface.device.round(12), axis=0)) == len(surface.device)


def test_flat_colours_are_sampled_evenly():
    def flat(device):
        return device @ np.array([[40.0, 10, 0], [30, -50, 20], [20, 30, -60]])

    device = device_surface(unit(3), flat, 20_000).device
    for values in device.T:
        counts, _ = np.histogram(values, bins=4, range=(0.01, 0.99))
        assert counts.max() < 1.25 * counts.min()


def test_nodes_of_the_model_are_among_the_points():
    nodes = np.tile([0.0, 0.13, 0.4, 1.0], (3, 1))
    device = device_surface(unit(3), bent, 20_000, nodes).device
    for i in range(3):
        assert {0.13, 0.4} <= set(device[:, i].round(9))


def test_few_points_for_many_inks():
    assert device_surface(unit(15), bent, 1000).density == "corners"
    assert len(device_surface(unit(15), bent, 1000).device) == 2**15
    assert device_surface(unit(7), bent, 2000).density == "uniform"
    assert device_surface(unit(7, 3.0), bent, 2000).device.sum(axis=1).max() <= 3 + 1e-9


@pytest.mark.parametrize(
    ("file", "points", "gain"),
    [
        # docs/decisions/surface-sampling.md: 0.62, 0.42, 0.97 and 0.72 of the mismatch of uniform
        # points, against a denser reference than this one.
        ("oracle/SWOP2013C3_CRPC5.icc", 20_000, 0.85),
        ("oracle/Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc", 20_000, 0.7),
        ("display/Acer_XB271HU.icc", 20_000, 1.0),
        ("spaces/sRGB-v4.icc", 20_000, 0.85),
    ],
)
@pytest.mark.slow
def test_more_accurate_than_as_many_uniform_points(
    shared_data, uniform_surface, file, points, gain
):
    profile = characterisation((shared_data / file).read_bytes())
    channels = len(profile.channels)

    def colours(device):
        return profile_colours(profile, device, "relative").lab

    def boundary(device, centre="auto"):
        return compute_boundary(colours(device), "modified-convex-hull", centre, gamma=0.2)

    faces = comb(channels, 2) << (channels - 2)
    # forty times as dense
    reference = boundary(uniform_surface(channels, isqrt(40 * points // faces)))
    centre = tuple(reference.centre)
    nodes = profile.transform("relative")[0].nodes
    uniform = uniform_surface(channels, isqrt(points // faces))
    shared_out = device_surface(unit(channels), colours, points, nodes).device
    assert len(shared_out) <= points
    errors = [
        radial_difference(reference.mesh, boundary(device, centre).mesh, centre).difference
        for device in (uniform, shared_out)
    ]
    assert errors[1] < gain * errors[0]


@given(
    st.integers(1, 15).flatmap(
        lambda columns: st.lists(
            st.lists(
                st.sampled_from([0.0, 0.1, 0.25, 0.5, 1.0]), min_size=columns, max_size=columns
            ),
            min_size=1,
            max_size=60,
        )
    )
)
@pytest.mark.slow
def test_distinct_rows_are_those_of_numpy(rows):
    distinct, places = distinct_rows(np.array(rows))
    expected, inverse = np.unique(np.array(rows), axis=0, return_inverse=True)
    np.testing.assert_array_equal(distinct, expected)
    np.testing.assert_array_equal(places, inverse.reshape(-1))


@pytest.mark.parametrize(("channels", "total"), [(11, 5.5), (12, 6.0), (13, 3.25)])
@pytest.mark.slow
def test_the_cut_of_many_inks_is_sampled_at_its_corners_and_on_its_faces(channels, total):
    """Half a million corners of trapezoids that share vertices and edges."""
    surface = device_surface(unit(channels, total), bent, 100_000)
    device = surface.device
    assert surface.density == "uniform"
    assert len(device) <= 100_000
    assert device.sum(axis=1).max() <= total + 1e-9
    # Two-dimensional faces: of the cube's, or of the plane's, where three channels may vary.
    inner = ((device > 1e-9) & (device < 1 - 1e-9)).sum(axis=1)
    on_plane = np.abs(device.sum(axis=1) - total) < 1e-9
    assert (inner <= np.where(on_plane, 3, 2)).all()
    corners = {tuple(row) for row in np.round(surface_corners(unit(channels, total)), 9).tolist()}
    assert corners <= {tuple(row) for row in np.round(device, 9).tolist()}


CUTS = st.one_of(st.none(), st.floats(0.1, 3))


@given(st.integers(20, 3000), CUTS, st.floats(0.05, 0.9))
@pytest.mark.slow
def test_three_channels_have_a_closed_surface(wanted, total, power):
    """Closed, oriented outwards, and with the volume of the cut cube."""
    surface = device_surface(unit(3, total), lambda device: bent(device**power), wanted)
    faces = surface.faces
    assert faces.closed
    assert faces.labels.shape == (len(faces.corners),)
    mesh = TriangleMesh(surface.device, faces.corners)
    assert mesh.validity().is_sphere
    assert mesh.volume == pytest.approx(ConvexHull(surface_corners(unit(3, total))).volume)


@given(st.integers(4, 5), st.integers(1000, 5000), st.one_of(st.none(), st.floats(0.3, 5)))
@pytest.mark.slow
def test_faces_of_more_channels_meet_edge_to_edge(channels, wanted, total):
    """Triangles of one patch cover its area once, and its rim is the rim of other patches."""
    surface = device_surface(unit(channels, total), bent, wanted)
    faces, device = surface.faces, surface.device
    assert not faces.closed
    corners = device[faces.corners]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    gram = (one**2).sum(1) * (two**2).sum(1) - (one * two).sum(1) ** 2
    areas = np.bincount(faces.labels, np.sqrt(np.maximum(gram, 0)) / 2)
    expected = surface_patches(unit(channels, total)).corners
    across, along = expected[:, 1, 1] - expected[:, 0, 0], expected[:, 0, 1] - expected[:, 1, 0]
    gram = (across**2).sum(1) * (along**2).sum(1) - (across * along).sum(1) ** 2
    np.testing.assert_allclose(areas, np.sqrt(np.maximum(gram, 0)) / 2, rtol=1e-6, atol=1e-9)
    # every edge of the cube is an edge of n - 1 faces; of the limit's plane, of two or more
    edges = np.sort(np.concatenate([faces.corners[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]))
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert uses.min() >= 2


def test_a_mirrored_device_is_turned_outwards():
    surface = device_surface(unit(3), bent, 500)
    for sign in (-1.0, 1.0):
        points = surface.device * [1.0, 1.0, sign]
        faces = outward_faces(points, surface.faces)
        assert TriangleMesh(points, faces.corners).volume == pytest.approx(1.0)


def test_there_are_no_faces_where_nothing_is_enclosed():
    assert device_surface(unit(1), bent, 50).faces is None
    assert device_surface(unit(2), bent, 50).faces is None
    assert device_surface(unit(15), bent, 1000).faces is None


def test_rows_that_are_not_told_apart_at_once_are_distinct(monkeypatch):
    """With factors for the first column only, rows with equal first columns collide."""

    class Chance:
        def integers(self, *_limits, size, dtype):
            return np.full(size, 2**63, dtype)  # doubled, that is nothing: all factors are 1

    rows = np.array([[0.5, 1.0], [1.0, 0.5], [0.5, 1.0], [0.25, 0.25]])  # two of equal sums
    monkeypatch.setattr(np.random, "default_rng", lambda _seed: Chance())
    distinct, places = distinct_rows(rows)
    np.testing.assert_array_equal(distinct, [[0.25, 0.25], [0.5, 1.0], [1.0, 0.5]])
    np.testing.assert_array_equal(places, [1, 2, 1, 0])
