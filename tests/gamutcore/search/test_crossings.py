"""Crossings, compared with a cube, a sphere, rational arithmetic and what alternation demands."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.search import build_index, contains, crossings

GRID = st.sampled_from([-3.0, -1.0, -0.5, 0.0, 0.25, 1.0, np.nextafter(1.0, 2.0), 2.0, 1e12])


def check(found, starts, ends, index, kind):
    """Check what holds for all lines."""
    counts = np.diff(found.offsets)
    inside = contains(starts, index)
    if kind == "line":
        expected = np.zeros(len(counts), bool)
        inside[:] = False
    else:
        expected = inside if kind == "ray" else inside ^ contains(ends, index)
    np.testing.assert_array_equal(counts % 2 == 1, expected)
    rows = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(rows)) - found.offsets[rows]
    np.testing.assert_array_equal(found.entering, (place % 2 == 0) ^ inside[rows])
    same_row = rows[1:] == rows[:-1]
    assert (np.diff(found.t)[same_row] >= 0).all()
    assert found.weights.min(initial=0) >= 0
    np.testing.assert_allclose(found.weights.sum(axis=1), 1, rtol=1e-14)
    corners = index.vertices[index.faces[found.faces]]
    np.testing.assert_allclose(
        np.einsum("mc,mcx->mx", found.weights, corners), found.points, atol=1e-12
    )
    low, high = {"line": (-np.inf, np.inf), "ray": (0, np.inf), "segment": (0, 1)}[kind]
    assert ((found.t >= low) & (found.t <= high)).all()


@pytest.mark.parametrize("kind", ["line", "ray", "segment"])
class TestCrossings:
    @settings(max_examples=150, deadline=None)
    @given(st.tuples(*[st.tuples(GRID, GRID, GRID)] * 2))
    def test_of_a_cube_alternate_through_edges_and_vertices_and_along_sides(self, cube, kind, ends):
        start, end = np.array(ends)[:, None]
        index = build_index(*cube)
        if (start == end).all() and kind != "segment":
            return
        found = crossings(start, end, index, kind)
        check(found, start, end, index, kind)
        np.testing.assert_allclose(abs(found.points).max(axis=1), 1, atol=1e-12)
        if kind == "line":
            assert len(found.t) <= 2

    @pytest.mark.parametrize("count", [8, 300])
    def test_through_vertices_and_along_edges_alternate(self, rough, kind, count):
        level = vertices, faces, centre = rough(count, count, 0.6)
        index = build_index(*level)
        corners = vertices.astype(np.float64)
        random = np.random.default_rng(2)
        one, two = corners[faces[:, 0]], corners[faces[:, 1]]
        far = random.normal(0, 200, one.shape)
        between = (one + two) / 2
        for start, end in [
            (one, two),
            (2 * one - two, two),
            (np.broadcast_to(centre, one.shape), one),
            (one, 2 * one - centre),
            (far, one),
            (far, between),
            (between, corners[faces[:, 2]]),
            (corners[random.integers(len(corners), size=len(one))], one + 1e-13),
            (centre + 1e9 * (far - centre), one),
            (far, centre + 1e15 * (one - far)),
        ]:
            different = (start != end).any(axis=1)
            found = crossings(start[different], end[different], index, kind)
            check(found, start[different], end[different], index, kind)

    @pytest.mark.slow
    def test_are_those_that_rational_arithmetic_finds(self, rough, orientation_of, kind):
        level = vertices, faces, _ = rough(11, 30, 0.6)
        index = build_index(*level)
        random = np.random.default_rng(3)
        low, high = index.box
        starts, ends = random.uniform(2 * low - high, 2 * high - low, (2, 40, 3))
        found = crossings(starts, ends, index, kind)
        check(found, starts, ends, index, kind)
        for row, (start, end) in enumerate(zip(starts, ends, strict=True)):
            expected = []
            for number, face in enumerate(faces):
                a, b, c = (vertices[corner] for corner in face)
                sides = [orientation_of(end, p, q, start) for p, q in ((a, b), (b, c), (c, a))]
                if len({side > 0 for side in sides}) > 1:
                    continue
                below, beyond = orientation_of(a, b, c, start), orientation_of(a, b, c, end)
                t = Fraction(below, below - beyond)
                if kind == "line" or (t >= 0 and (kind == "ray" or t <= 1)):
                    expected.append((t, number))
            expected.sort()
            rows = slice(found.offsets[row], found.offsets[row + 1])
            assert found.faces[rows].tolist() == [number for _, number in expected]
            np.testing.assert_allclose(found.t[rows], [float(t) for t, _ in expected], atol=1e-12)

    def test_of_a_sphere_are_the_roots_of_a_quadratic_equation(self, rough, kind):
        vertices, faces, centre = rough(9, 3000, 0.0)
        index = build_index(vertices, faces, centre)
        random = np.random.default_rng(1)
        starts, ends = centre + random.uniform(-80, 80, (2, 2000, 3))
        found = crossings(starts, ends, index, kind)
        check(found, starts, ends, index, kind)
        radius = np.linalg.norm(found.points - centre, axis=1)
        assert 39.5 < radius.min() <= radius.max() < 40 + 1e-5
        rows = np.repeat(np.arange(2000), np.diff(found.offsets))
        on_line = starts[rows] + found.t[:, None] * (ends - starts)[rows]
        np.testing.assert_allclose(found.points, on_line, atol=1e-9)
        if kind == "line":
            direction = (ends - starts) / np.linalg.norm(ends - starts, axis=1, keepdims=True)
            distance = np.linalg.norm(np.cross(starts - centre, direction), axis=1)
            clear = abs(distance - 39.8) > 0.3
            np.testing.assert_array_equal(
                np.diff(found.offsets)[clear], 2 * (distance < 39.8)[clear]
            )


@pytest.mark.slow
def test_many_crossings_of_few_lines_find_room(rough):
    """The arrays start with room for 64 crossings and one more for each line."""
    index = build_index(*rough(5, 30_000, 0.9))
    start, end = index.centre + np.array([(-100, -1, -2), (100, 30, 31)])
    starts, ends = np.tile(start, (5, 1)), np.tile(end, (5, 1))
    found = crossings(starts, ends, index, "line")
    assert len(found.t) > 64 + 5
    check(found, starts, ends, index, "line")
    once = crossings(starts[:1], ends[:1], index, "line")
    np.testing.assert_array_equal(np.tile(once.t, 5), found.t)


def test_a_line_that_touches_crosses_twice(cube):
    found = crossings(
        [(-2, 1, 0.3), (-2, 1, 1), (-2, 0, 2)], [(2, 1, 0.3), (2, 1, 1), (0, 2, 0)], cube
    )
    assert np.diff(found.offsets).tolist() == [2, 2, 2]
    np.testing.assert_allclose(found.t, [0.25, 0.75, 0.25, 0.75, 0.5, 0.5])


def test_what_is_no_line_is_refused(cube):
    with pytest.raises(InvalidPointsError, match="Row 1 of ends"):
        crossings(np.zeros((2, 3)), [(0, 0, 0), (0, np.inf, 0)], cube)
    with pytest.raises(InvalidPointsError, match="2 starts and 1 ends"):
        crossings(np.zeros((2, 3)), np.zeros((1, 3)), cube)
    for kind in ("ray", "line"):
        with pytest.raises(InvalidPointsError, match="row 1 are equal") as caught:
            crossings([(0, 0, 0), (1, 1, 1)], [(1, 0, 0), (1, 1, 1)], cube, kind)
        assert caught.value.where == {"field": "ends", "row": 1}
    with pytest.raises(OptionError, match="kind"):
        crossings(np.zeros((1, 3)), np.ones((1, 3)), cube, "circle")
