"""Fluxes through the part of a surface inside a level, where the answer is known."""

import numpy as np
import pytest

from gamutcore.corner_table import opposite_corners
from gamutcore.queries import build_index
from gamutcore.queries.overlap import overlap_cells
from gamutcore.queries.volume_cells import cells_of


def flux(vertices, faces, level):
    index = build_index(*level)
    beside = opposite_corners(index.faces, len(index.vertices)).reshape(-1, 3) // np.int32(3)
    cells = cells_of(1, np.empty(0))
    vertices, faces = np.array(vertices, np.float64), np.array(faces, np.int32)
    return overlap_cells(vertices, faces, index, beside, 1.0, cells)[0, 0]


@pytest.mark.parametrize("height", [0.0, 0.25, 0.5, 1 - 1e-12])
def test_a_wall_through_a_cube(cube, height):
    """The plane a = h passes through the centre, or through edges of the cones."""
    wall = [(-9, height, -9), (9, height, -9), (9, height, 9), (-9, height, 9)]
    assert flux(wall, [(0, 2, 1), (0, 3, 2)], cube) == pytest.approx(4 * height / 2, abs=1e-14)


def test_a_diagonal_wall_in_the_planes_of_edges(cube):
    """The wall a = b is in the planes through the centre and eight edges of the cube."""
    wall = np.array([(-9, -9, -9), (9, -9, -9), (9, 9, 9), (-9, 9, 9)], np.float64)
    # F is parallel to a wall through the axis, so it is moved away together with the cube
    vertices, faces, centre = cube
    shift = np.array([0.0, 3.0, 0.0])
    found = flux(wall + shift, [(0, 1, 2), (0, 2, 3)], (vertices + shift, faces, centre + shift))
    # area 2 × 2√2, distance 3 / √2 from the axis, half of it in F
    assert abs(found) == pytest.approx(2 * 2 * np.sqrt(2) * 3 / np.sqrt(2) / 2)


def test_many_small_faces_and_a_few_large_ones(rough):
    """A cube around the sphere has no part inside; the sphere is inside with its whole volume."""
    vertices, faces, centre = rough(3, 2000, 0.0)
    corners = centre + 60 * (np.array(list(np.ndindex(2, 2, 2))) * 2 - 1)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    sides = [each for a, b, c, d in quads for each in ((a, b, c), (a, c, d))]
    assert flux(corners, sides, (vertices, faces, centre)) == 0
    a, b, c = (vertices.astype(float)[faces[:, at]] - centre for at in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    assert flux(vertices, faces, (corners, sides, centre)) == pytest.approx(volume)


def test_faces_without_an_area_add_nothing(cube):
    line = [(0, 0, 0), (0.5, 0.5, 0.5), (0.25, 0.25, 0.25)]
    assert flux(line, [(0, 1, 2), (0, 0, 1), (0, 0, 0)], cube) == 0
