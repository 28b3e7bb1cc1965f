from __future__ import annotations

from math import comb, factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from gamutcore.colours.device.ink_cube import InkCube, surface_corners, surface_patches


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


def test_a_limit_beyond_all_inks_cuts_nothing():
    assert not unit(4, 4.0).cut
    assert len(surface_patches(unit(4, 4.5)).corners) == 24


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


@given(
    st.integers(2, 5),
    st.floats(0.05, 5.0),
    st.lists(st.floats(0, 0.4), min_size=5, max_size=5),
    st.lists(st.floats(0.5, 1), min_size=5, max_size=5),
)
@pytest.mark.slow
def test_patches_lie_within_and_on_the_surface(channels, total, low, high):
    cube = InkCube(np.array(low[:channels]), np.array(high[:channels]), sum(low[:channels]) + total)
    corners = surface_patches(cube).corners
    points = corners.mean(axis=(1, 2))
    assert (points >= cube.lowest - 1e-6).all()
    assert (points <= cube.highest + 1e-6).all()
    assert (points.sum(axis=1) <= cube.total + 1e-6).all()
    at_end = (np.abs(points - cube.lowest) < 1e-6) | (np.abs(points - cube.highest) < 1e-6)
    on_cut = np.abs(points.sum(axis=1) - cube.total) < 1e-6
    assert (at_end.sum(axis=1) + on_cut >= channels - 2).all()


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


def test_axes_say_which_channel_changes_alone():
    patches = surface_patches(unit(4, 2.5))
    for corners, axes in zip(patches.corners, patches.axes, strict=True):
        for side, axis in enumerate(axes):
            if axis >= 0:
                change = np.take(corners, 1, axis=side) - np.take(corners, 0, axis=side)
                np.testing.assert_allclose(change, np.tile(np.eye(4)[axis], (2, 1)), atol=1e-9)


@pytest.mark.slow
def test_no_more_than_are_wanted():
    assert surface_patches(unit(15), 1000) is None
    assert len(surface_patches(unit(4), 24).corners) == 24
    assert surface_patches(unit(4), 23) is None
    # Fifteen inks of which no more than two are printed at once have few faces.
    assert len(surface_patches(unit(15, 2.0), 10_000).corners) < 10_000
