"""The cube map, compared with testing every face."""

import numpy as np
import pytest

from gamutcore.queries.directions import cell_of, direction_cells


@pytest.mark.parametrize("resolution", [1, 2, 7, 40])
@pytest.mark.parametrize("count", [4, 12, 400])
def test_the_cell_of_a_direction_lists_the_face_that_it_meets(rough, count, resolution):
    vertices, faces, centre = rough(count, max(count, 4), 0.0) if count > 4 else _tetrahedron()
    position = vertices.astype(np.float64) - centre
    start, listed = direction_cells(position, faces, resolution)
    assert len(start) == 6 * resolution**2 + 1
    assert start[-1] == len(listed)
    random = np.random.default_rng(2)
    inverse = np.linalg.inv(position[faces].transpose(0, 2, 1))
    edges = np.vstack([np.eye(3), -np.eye(3), list(np.ndindex(3, 3, 3))]) - 1e-9
    for direction in np.vstack([random.normal(size=(300, 3)), edges, position]):
        face = np.einsum("fij,j->fi", inverse, direction).min(axis=1).argmax()
        cell = cell_of(*direction, resolution)
        assert face in listed[start[cell] : start[cell + 1]]


def test_no_face_is_listed_twice_in_a_cell(rough):
    vertices, faces, centre = rough(5, 50)
    start, listed = direction_cells(vertices - centre, faces, 9)
    for cell in range(len(start) - 1):
        candidates = listed[start[cell] : start[cell + 1]]
        assert len(candidates) == len(set(candidates.tolist())) > 0


def _tetrahedron():
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], np.float32)
    return corners, np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32), np.zeros(3)
