"""Containment by rational arithmetic on small gamuts, and by boolean operations on a large one."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.booleans import intersection_volume
from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimate
from gamutcore.errors import FlatPointsError, TriangleCountError
from gamutcore.history import build_history
from gamutcore.levels import radial_difference, sided_level
from gamutcore.levels.sides import _SidedLevels


def exact(meshes, centre):
    """Positions about the centre as integers: a common power of two makes them whole."""
    relative = [
        [
            [
                Fraction(float(value)) - Fraction(float(middle))
                for value, middle in zip(row, centre, strict=True)
            ]
            for row in mesh.vertices
        ]
        for mesh in meshes
    ]
    scale = max(value.denominator for mesh in relative for row in mesh for value in row)
    return [[[int(value * scale) for value in row] for row in mesh] for mesh in relative]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def edges(mesh):
    sides = np.sort(
        np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    )
    return np.unique(sides.reshape(-1, 2), axis=0)


def rounded(points):
    """The same positions in double precision, of an extent of about 1, as three columns."""
    largest = max(abs(value) for row in points for value in row)
    return np.array([[value / largest for value in row] for row in points]).T


ROUNDING = 1e-12
"""More than the rounding of products of six coordinates of at most 1 in double precision."""


def along(x, a, b):
    """The sum of the weights of x by a and b, which span its plane; None if x is not between."""
    normal = cross(a, b)
    one, two = dot(cross(x, b), normal), dot(cross(a, x), normal)
    return Fraction(one + two, dot(normal, normal)) if one >= 0 and two >= 0 else None


def heights(points, others, faces):
    """N · x, which is 1 ÷ radius, of every point x and the face whose cone it is in."""
    columns, at = rounded(others), rounded(points).T
    a, b, c = (columns[:, corner] for corner in faces.T)
    weights = [at @ np.array(cross(*pair)) for pair in ((b, c), (c, a), (a, b))]
    possible = np.min(weights, axis=0) >= -ROUNDING
    for x, near in zip(points, possible, strict=True):
        for one, two, three in faces[near].tolist():
            a, b, c = others[one], others[two], others[three]
            first, second, third = dot(x, cross(b, c)), dot(x, cross(c, a)), dot(x, cross(a, b))
            if min(first, second, third) >= 0:
                yield Fraction(first + second + third, dot(a, cross(b, c)))
                break
        else:
            raise AssertionError("the cones fill space")


def possible_crossings(inside, outside, inner_edges, outer_edges):
    """Pairs of edges that cross as seen from the centre; a few more are near to that."""
    (a, b), (c, d) = (
        np.moveaxis(rounded(points)[:, ends], 2, 0)
        for points, ends in ((inside, inner_edges), (outside, outer_edges))
    )
    a, b, c, d = a[:, :, None], b[:, :, None], c[:, None, :], d[:, None, :]
    own, other = cross(a, b), cross(c, d)
    x = cross(own, other)
    weights = np.stack(
        [
            dot(cross(x, b), own),
            dot(cross(a, x), own),
            dot(cross(x, d), other),
            dot(cross(c, x), other),
        ]
    )
    either = (weights >= -ROUNDING).all(axis=0) | (weights <= ROUNDING).all(axis=0)
    for one, two in np.argwhere(either).tolist():
        yield inner_edges[one].tolist(), outer_edges[two].tolist()


def is_contained(inner, outer, centre):
    """Whether a surface is within another one, by all corners of their overlay.

    All decisions are made with integers. Double precision only leaves out edges and cones that are
    far from each other.
    """
    inside, outside = exact((inner, outer), centre)
    if any(height < 1 for height in heights(outside, inside, inner.faces)):
        return False
    if any(height > 1 for height in heights(inside, outside, outer.faces)):
        return False
    crossings = possible_crossings(inside, outside, edges(inner), edges(outer))
    for (a, b), (c, d) in crossings:
        x = cross(cross(inside[a], inside[b]), cross(outside[c], outside[d]))
        for way in (x, [-value for value in x]):
            own, other = along(way, inside[a], inside[b]), along(way, outside[c], outside[d])
            if own is not None and other is not None and own < other:
                return False
    return True


@settings(max_examples=25, deadline=None)
@given(
    st.integers(0, 10**6),
    st.integers(8, 40),
    st.sampled_from(sorted(COSTS)),
    st.sampled_from([0.1, 0.5, 1.0]),
    st.integers(0, 100),
    st.sampled_from(["inside", "outside"]),
)
@pytest.mark.slow
def test_containment_is_exact(random_cloud, seed, count, cost, gamma, share, side):
    boundary = modified_convex_hull(random_cloud(seed, count), gamma)
    history = build_history(decimate(boundary.mesh, boundary.centre, cost))
    triangles = 4 + share * (history.triangles - 4) // 100
    level = sided_level(history, triangles, side)
    full = history.full()
    assert level.vertices.dtype == np.float32
    assert level.triangles == history.level_triangles(triangles)
    np.testing.assert_array_equal(level.faces, history.level(triangles).faces)
    assert level.validity(history.centre).star_shaped
    inner, outer = (level, full) if side == "inside" else (full, level)
    assert is_contained(inner, outer, history.centre)


@pytest.mark.parametrize(
    ("thickness", "far"),
    [(1e-3, 0.0), (1e-3, 1e5), (1e-4, 50.0), (1e-4, 1000.0), (1e-5, 0.0), (1e-5, 1000.0)],
)
def test_bodies_as_thin_as_the_step_of_float32_have_levels(far, thickness):
    points = np.random.default_rng(1).normal(size=(30, 3))
    points *= [50.0, 50.0, 50.0 * thickness] / np.linalg.norm(points, axis=1)[:, np.newaxis]
    try:
        boundary = modified_convex_hull(points + far, 0.5)
    except FlatPointsError:
        return
    history = build_history(decimate(boundary.mesh, boundary.centre, "volume"))
    full = history.full()
    for triangles, side in product((4, 20, history.triangles - 2), ("inside", "outside")):
        level = sided_level(history, triangles, side)
        assert level.triangles <= triangles
        assert level.validity(history.centre).star_shaped
        inner, outer = (level, full) if side == "inside" else (full, level)
        assert is_contained(inner, outer, history.centre)


def test_where_no_level_fits_the_error_names_the_remedy(monkeypatch, fogra39_gamut):
    monkeypatch.setattr(_SidedLevels, "_moved_level", lambda _self, _count: None)
    with pytest.raises(TriangleCountError, match="too thin") as caught:
        sided_level(fogra39_gamut.history, 1000, "inside")
    assert "both" in caught.value.remedy


def test_the_criterion_sees_what_is_not_contained(random_cloud):
    boundary = modified_convex_hull(random_cloud(5, 30), 0.5)
    history = build_history(decimate(boundary.mesh, boundary.centre, "volume"))
    level, full = history.level(16), history.full()
    assert is_contained(full, full, history.centre)
    assert not is_contained(level, full, history.centre)
    assert not is_contained(full, level, history.centre)


def test_both_sides_and_the_full_boundary_are_the_levels_themselves(fogra39_gamut):
    history = fogra39_gamut.history
    np.testing.assert_array_equal(
        sided_level(history, 100, "both").vertices, history.level(100).vertices
    )
    whole = sided_level(history, history.triangles, "inside")
    np.testing.assert_array_equal(whole.vertices, history.full().vertices)


@pytest.mark.parametrize("triangles", [3, 0, 10**7])
def test_a_count_that_is_not_there_is_refused(fogra39_gamut, triangles):
    with pytest.raises(TriangleCountError):
        sided_level(fogra39_gamut.history, triangles, "inside")


@pytest.mark.parametrize("triangles", [4, 100, 1000])
@pytest.mark.parametrize("side", ["inside", "outside"])
@pytest.mark.slow
def test_levels_of_fogra39_are_on_their_side(fogra39_gamut, triangles, side):
    history = fogra39_gamut.history
    full, level = history.full(), sided_level(history, triangles, side)
    common = intersection_volume(full, level)
    inner = level if side == "inside" else full
    assert abs(inner.volume - common) <= 1e-9 * full.volume
    # one side costs a few times the mismatch of a level that crosses the boundary
    found = radial_difference(full, level, history.centre)
    both = radial_difference(full, history.level(triangles), history.centre)
    assert found.difference == pytest.approx(abs(found.other_volume - found.volume), rel=1e-6)
    if triangles >= 100:
        assert found.mismatch < 6.0 * both.mismatch
