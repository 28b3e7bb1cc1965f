"""Volumes in cells of hue and lightness, of a cube and a sphere, and clipping."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.queries.volume_cells import CORNERS, cells_of, clip, enclosed_cells


def cells(level, sectors, bounds=()):
    vertices, faces, _ = level
    divided = cells_of(sectors, np.array(bounds, np.float64))
    return enclosed_cells(np.array(vertices, np.float64), faces, divided)


class TestEnclosedCells:
    def test_a_cube_on_the_axis(self, cube):
        found = cells(cube, 8, (-0.5, 0.0, 0.75))
        np.testing.assert_allclose(found, np.outer([0.5, 0.5, 0.75, 0.25], np.full(8, 0.5)))

    def test_a_cube_beside_the_axis(self, cube):
        vertices, faces, centre = cube
        found = cells((vertices + np.array([10, 5, 0]), faces, centre), 4, (10,))
        np.testing.assert_allclose(found, [[2, 0, 0, 2], [2, 0, 0, 2]], atol=1e-12)

    def test_bands_outside_are_empty(self, cube):
        found = cells(cube, 1, (-3, -2, 2, 3))
        np.testing.assert_allclose(found[:, 0], [0, 0, 8, 0, 0], atol=1e-12)

    @pytest.mark.parametrize("sectors", [1, 2, 5, 360])
    def test_cells_add_up_to_the_volume(self, rough, sectors):
        vertices, faces, centre = rough(3, 200)
        a, b, c = (vertices.astype(float)[faces[:, at]] - centre for at in range(3))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
        found = cells((vertices, faces, centre), sectors, (20, 45, 50, 80))
        assert found.sum() == pytest.approx(volume, rel=1e-12)
        assert found.shape == (5, sectors)
        assert found.min() > -1e-9


class TestClip:
    @settings(max_examples=60)
    @given(
        normal=st.tuples(*[st.floats(-1, 1)] * 3),
        constant=st.floats(-0.5, 0.5),
        corners=st.lists(st.floats(0, 6.28), min_size=3, max_size=8, unique=True),
    )
    def test_keeps_the_side_and_both_sides_make_the_whole(self, normal, constant, corners):
        angles = np.sort(corners)
        polygon = np.zeros((CORNERS, 3))
        polygon[: len(angles), 1] = np.cos(angles)
        polygon[: len(angles), 2] = np.sin(angles)
        total = 0.0
        for sign in (1, -1):
            kept = np.empty((CORNERS, 3))
            x, y, z = (sign * value for value in normal)
            count = clip(polygon, len(angles), x, y, z, sign * constant, kept)
            assert (kept[:count] @ [x, y, z] + sign * constant >= -1e-12).all()
            total += area(kept[:count])
        flat = normal[1] == normal[2] == constant == 0
        assert total == pytest.approx(area(polygon[: len(angles)]) * (1 + flat), abs=1e-9)


def area(corners):
    y, z = corners[:, 1], corners[:, 2]
    return float((y * np.roll(z, -1) - z * np.roll(y, -1)).sum() / 2)
