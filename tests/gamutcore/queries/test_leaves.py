"""The table of leaves, compared with in-gamut tests, a cube, and hue leaves."""

import numpy as np
import pytest

from gamutcore.errors import InvalidPointsError
from gamutcore.queries import build_index, contains, cusp_points
from gamutcore.queries.leaves import leaves
from gamutcore.queries.sections import hue_leaf


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

    def test_of_a_cube_beside_the_axis(self, cube):
        vertices, faces, centre = cube
        shift = np.array([0, 9, 0])
        table = leaves((vertices + shift, faces, centre + shift), [0, 90, 180], [0])
        np.testing.assert_allclose(table.chroma, [[8, 10]])
        assert table.offsets.tolist() == [0, 1, 1, 1]

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

    def test_no_chroma_is_larger_than_that_of_the_cusp(self, rough):
        index = build_index(*rough(14, 400))
        hues = np.arange(0, 360, 20.0)
        table = leaves(index, hues, np.linspace(0, 100, 2001))
        cusps = cusp_points(hues, index)
        for hue in range(len(hues)):
            begin, end = table.offsets[hue * 2001], table.offsets[(hue + 1) * 2001]
            largest = table.chroma[begin:end].max()
            assert cusps.chroma[hue] - 0.3 < largest <= cusps.chroma[hue] + 1e-9

    def test_add_up_to_the_area_of_a_hue_leaf(self, rough):
        level = rough(15, 500)
        lightness = np.linspace(0, 100, 4000, endpoint=False) + 0.0125
        table = leaves(level, [70], lightness)
        total = np.diff(table.chroma, axis=1).sum() * 0.025
        expected = 0.0
        for polygon in hue_leaf(level, 70).polygons:
            x, y = np.hypot(polygon[:, 1], polygon[:, 2]), polygon[:, 0]
            expected += (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
        assert total == pytest.approx(expected, rel=1e-4)

    def test_nothing_asked_and_what_is_refused(self, cube):
        assert leaves(cube, [], [1, 2]).offsets.tolist() == [0]
        assert leaves(cube, [1], []).chroma.shape == (0, 2)
        with pytest.raises(InvalidPointsError, match="hues"):
            leaves(cube, [np.inf], [1])
        with pytest.raises(InvalidPointsError, match="lightness"):
            leaves(cube, [1], [0, np.nan])
