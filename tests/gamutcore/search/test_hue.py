"""Cusps and leaves: all edges, in-gamut tests, cubes, and hues of vertices."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.search import build_index, contains, cusp_points, leaves


def chroma_of_all_edges(level, hue):
    """Return the largest chroma where any edge crosses the half-plane."""
    vertices, faces, _ = level
    corners = vertices.astype(np.float64)[:, 1:]
    cosine, sine = np.cos(np.radians(hue)), np.sin(np.radians(hue))
    across = cosine * corners[:, 1] - sine * corners[:, 0]
    along = cosine * corners[:, 0] + sine * corners[:, 1]
    found = []
    for at in range(3):
        one, two = faces[:, at], faces[:, (at + 1) % 3]
        p, q = across[one], across[two]
        crossed = (p * q <= 0) & (p != q)
        share = p[crossed] / (p - q)[crossed]
        found += [along[one][crossed] + share * (along[two] - along[one])[crossed]]
    chroma = np.concatenate(found)
    return chroma[chroma >= 0].max(initial=-1)


class TestCuspPoints:
    @pytest.mark.parametrize("shift", [(0, 0, 0), (0, 20, -10), (0, 90, 0)])
    @pytest.mark.parametrize("count", [5, 40, 700])
    def test_are_the_largest_chroma_of_any_edge(self, rough, count, shift):
        vertices, faces, centre = rough(count, count, 0.5)
        level = vertices + np.array(shift), faces, centre + shift
        hues = np.random.default_rng(0).uniform(-400, 400, 100)
        found = cusp_points(hues, level)
        expected = [chroma_of_all_edges(level, hue) for hue in hues]
        np.testing.assert_allclose(np.nan_to_num(found.chroma, nan=-1), expected, atol=1e-11)
        seen = found.faces >= 0
        assert seen.any()
        np.testing.assert_array_equal(seen, ~np.isnan(found.points).any(axis=1))
        on_face = np.einsum("nc,ncx->nx", found.weights, level[0][faces[found.faces]])
        np.testing.assert_allclose(on_face[seen], found.points[seen], atol=1e-11)
        assert found.weights[seen].min() >= 0
        angles = np.degrees(np.arctan2(found.points[seen, 2], found.points[seen, 1]))
        np.testing.assert_allclose(np.cos(np.radians(angles - hues[seen])), 1, atol=1e-15)

    @settings(max_examples=200, deadline=None)
    @given(vertex=st.integers(0, 59), end=st.integers(0, 59))
    @pytest.mark.slow
    def test_at_the_hue_of_a_vertex_is_at_least_its_chroma(self, rough, vertex, end):
        vertices, faces, _ = rough(3, 60)
        # the axis goes through a vertex
        vertices = vertices - vertices[end] * (0, 1, 1)
        centre = vertices.mean(axis=0)
        index = build_index(vertices, faces, centre)
        _, a, b = vertices[vertex]
        # hues of vertices are rounded, and the level may end there
        hues = np.degrees(np.arctan2(b, a)) + np.array([-1e-9, 0, 1e-9])
        found = np.nanmax(cusp_points(hues, index).chroma)
        assert found >= np.hypot(a, b) * (1 - 1e-9)


def intervals(table, hue, row):
    cell = hue * len(table.lightness) + row
    return table.chroma[table.offsets[cell] : table.offsets[cell + 1]]


class TestLeaves:
    def test_of_a_cube_on_the_axis(self, cube):
        """Hues through edges and corners, lightnesses of faces."""
        hues, lightness = np.arange(0, 360, 15), [1, 0.5, 0, -1, 2]
        table = leaves(cube, hues, lightness)
        for hue in range(24):
            radians = np.radians(hues[hue])
            width = 1 / max(abs(np.cos(radians)), abs(np.sin(radians)))
            for row in (0, 1, 2):
                np.testing.assert_allclose(intervals(table, hue, row), [[0, width]], rtol=1e-12)
            assert len(intervals(table, hue, 4)) == 0

    @pytest.mark.parametrize("shift", [0.0, 25.0, 60.0])
    def test_intervals_are_where_the_level_contains_colours(self, rough, shift):
        vertices, faces, centre = rough(11, 300)
        moved = np.array([0, shift, 0])
        index = build_index(vertices + moved, faces, centre + moved)
        random = np.random.default_rng(0)
        hues, lightness = random.uniform(-90, 400, 50), random.uniform(0, 100, 30)
        table = leaves(index, hues, lightness)
        hue, row = random.integers(0, 50, 4000), random.integers(0, 30, 4000)
        chroma = random.uniform(0, 130, 4000)
        radians = np.radians(hues[hue])
        points = np.column_stack(
            [lightness[row], chroma * np.cos(radians), chroma * np.sin(radians)]
        )
        expected = contains(points, index)
        found = [
            any(low <= c <= high for low, high in intervals(table, h, r))
            for h, r, c in zip(hue, row, chroma, strict=True)
        ]
        np.testing.assert_array_equal(found, expected)
        assert 50 < expected.sum() < 3000
        assert (np.diff(table.offsets).max() > 1) == (shift >= 0)

    def test_ends_are_on_the_surface(self, rough):
        level = vertices, faces, _ = rough(12, 200)
        hues, lightness = np.arange(0, 360, 10.0), np.arange(0, 101, 5.0)
        table = leaves(level, hues, lightness)
        cell = np.repeat(np.arange(len(table.offsets) - 1), np.diff(table.offsets))
        radians = np.radians(hues[cell // len(lightness)])
        for end in (0, 1):
            known = table.faces[:, end] >= 0
            assert (table.chroma[~known, end] == 0).all()
            assert np.isnan(table.weights[~known, end]).all()
            corners = vertices.astype(np.float64)[faces[table.faces[known, end]]]
            points = np.einsum("mc,mcx->mx", table.weights[known, end], corners)
            chroma, angle = table.chroma[known, end], radians[known]
            expected = [
                lightness[cell[known] % len(lightness)],
                chroma * np.cos(angle),
                chroma * np.sin(angle),
            ]
            np.testing.assert_allclose(points, np.transpose(expected), atol=1e-10)
            assert table.weights[known, end].min() > -1e-12
        assert (table.faces[:, 1] >= 0).all()
        assert (table.faces[:, 0] < 0).any()

    def test_through_corners_of_the_level(self, rough):
        """At hues and lightnesses of vertices, intervals are the limits of those nearby."""
        level = vertices, _, _ = rough(13, 80)
        for lightness, a, b in vertices[:40].astype(np.float64):
            hue = np.degrees(np.arctan2(b, a))
            here = leaves(level, [hue], [lightness])
            near = leaves(level, [hue], [lightness - 1e-9])
            widths = [np.diff(table.chroma, axis=1).sum() for table in (here, near)]
            assert widths[0] == pytest.approx(widths[1], abs=1e-5)
