"""Clipped faces: the pieces cover the face, and each lies in its cone."""

import numpy as np
import pytest

from gamutcore.metric.clipping import clipping_workspace, pop_piece, push_face
from gamutcore.metric.cones import MOVES, compute_cones
from gamutcore.metric.distance_bound import make_surface

CENTRE = (50.0, 0.0, 0.0)


def surface_of(mesh, centre=CENTRE):
    return make_surface(
        mesh.vertices.astype(np.float64) - centre, mesh.faces.astype(np.int32).ravel()
    )


def pieces_of(triangle, cones, start=0, moves=MOVES):
    """Return all pieces: the face, and the corners as u, v, N · p − 1."""
    position = np.array(triangle, np.float64)
    work = clipping_workspace()
    reach = float(np.linalg.norm(position, axis=1).max())
    top, pieces = push_face(work, position, 0, 1, 2, start), []
    while True:
        face, count, top = pop_piece(work, top, cones, reach, moves)
        if face < 0:
            return pieces
        pieces.append((face, work.piece[:count].copy()))


def twice_the_area(corners):
    u, v = corners[:, 0], corners[:, 1]
    return float(np.sum(u * np.roll(v, -1) - v * np.roll(u, -1)))


def area_by_face(pieces, faces):
    areas = np.zeros(faces)
    for face, corners in pieces:
        areas[face] += twice_the_area(corners)
    return areas


@pytest.fixture(scope="module")
def cones(star_shaped):
    return compute_cones(surface_of(star_shaped(21)))


@pytest.mark.parametrize("moves", [MOVES, 3, 0, -1])
@pytest.mark.parametrize("size", [0.01, 1.0, 20.0, 60.0])
def test_pieces_make_up_the_face_whatever_its_size(cones, size, moves):
    random = np.random.default_rng(int(100 * size))
    for _ in range(10):
        middle = random.normal(size=3)
        middle *= 50 / np.linalg.norm(middle)
        triangle = middle + size * random.normal(size=(3, 3)) / 3
        if np.linalg.det(triangle) < 0:
            triangle = triangle[::-1]
        pieces = pieces_of(triangle, cones, int(random.integers(len(cones.planes))), moves)
        assert sum(twice_the_area(corners) for _, corners in pieces) == pytest.approx(1, abs=1e-9)
        for face, corners in pieces:
            assert twice_the_area(corners) > -1e-12
            u, v, beyond = corners.T
            points = (1 - u - v)[:, None] * triangle[0] + np.outer(u, triangle[1])
            points += np.outer(v, triangle[2])
            sides = points @ cones.planes[face].reshape(3, 3).T
            assert sides.min() >= -1e-9 * abs(sides).max()
            np.testing.assert_allclose(points @ cones.normal[face] - 1, beyond, atol=1e-9)


def test_it_does_not_matter_where_one_starts_or_how_one_walks(cones):
    triangle = 50 * np.array([(1.0, 0.1, 0.0), (0.2, 1.0, 0.1), (0.0, 0.2, 1.0)])
    expected = area_by_face(pieces_of(triangle, cones), len(cones.planes))
    assert np.count_nonzero(expected > 1e-12) > 10
    for start, moves in ((5, MOVES), (100, MOVES), (0, 1), (0, -1)):
        found = area_by_face(pieces_of(triangle, cones, start, moves), len(cones.planes))
        np.testing.assert_allclose(found, expected, atol=1e-10)


@pytest.mark.slow
def test_a_face_over_thousands_of_others_is_cut_into_all_of_them(icosphere):
    """An octant above a fine sphere gives pieces with many corners, and fills the stack."""
    sphere = icosphere(5)
    cones = compute_cones(surface_of(sphere, (0, 0, 0)))
    triangle = np.diag((1.5, 1.5, 1.5))
    pieces = pieces_of(triangle, cones)
    areas = area_by_face(pieces, sphere.triangles)
    assert areas.sum() == pytest.approx(1, abs=1e-9)
    # a face with all corners inside the octant is covered completely
    corners = np.stack(sphere.corners(), axis=1)
    inside = (corners > 0.01).all(axis=(1, 2))
    projected = 1.5 * corners[inside] / corners[inside].sum(axis=2, keepdims=True)
    expected = np.linalg.norm(
        np.cross(projected[:, 1] - projected[:, 0], projected[:, 2] - projected[:, 0]), axis=1
    ) / np.linalg.norm(np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0]))
    assert inside.sum() > 2000
    np.testing.assert_allclose(areas[inside], expected, rtol=1e-6)
    outside = (corners.max(axis=1) < -0.01).any(axis=1)
    assert areas[outside].max() == 0


def test_a_face_in_one_cone_stays_whole(cones, star_shaped):
    corners = np.stack(star_shaped(21).corners(CENTRE), axis=1)
    for face in range(0, len(corners), 11):
        middle = corners[face].mean(axis=0)
        triangle = middle + 0.5 * (corners[face] - middle)
        ((found, piece),) = pieces_of(triangle, cones, face)
        assert found == face
        np.testing.assert_allclose(piece[:, 2], 0, atol=1e-12)
        assert twice_the_area(piece) == 1
        # a walk from elsewhere may cut the face by the planes of the cones on its way
        pieces = pieces_of(triangle, cones, (face + 50) % len(corners))
        assert area_by_face(pieces, len(corners))[face] == pytest.approx(1, abs=1e-9)
