"""Cusps, compared with all edges, a cube, a cylinder of known chroma and points on the axis."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import InvalidPointsError
from gamutcore.queries import build_index
from gamutcore.queries.cusps import cusp_points


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

    def test_of_a_cube_are_on_its_sides(self, cube):
        """Edges along a hue, and hues of vertices."""
        hues = np.array([0, 45, 90, 135, 180, 225, 270, 315, 359, 10])
        turned = np.radians(hues)
        expected = 1 / np.maximum(abs(np.cos(turned)), abs(np.sin(turned)))
        np.testing.assert_allclose(cusp_points(hues, cube).chroma, expected, rtol=1e-15)

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

    def test_refuse_what_is_no_list_of_numbers(self, cube):
        assert cusp_points([], cube).points.shape == (0, 3)
        with pytest.raises(InvalidPointsError, match="Row 1 of hues"):
            cusp_points([0, np.nan], cube)
        for wrong in (3, [[1, 2]], [[1], [2, 3]], ["red"], None):
            with pytest.raises(InvalidPointsError, match="hues"):
                cusp_points(wrong, cube)
