"""The point farthest inside of all faces, for bodies with a known answer."""

import numpy as np
import pytest
import trimesh

from gamutcore.boundary.star_kernel import face_planes, star_kernel_point
from gamutcore.mesh import TriangleMesh


def mesh(vertices, faces):
    return TriangleMesh(np.asarray(vertices, float), np.asarray(faces, np.int32))


def star_kernel(mesh):
    planes = face_planes(np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int32))
    return star_kernel_point(planes, float(np.ptp(mesh.vertices, axis=0).max()))


def test_of_a_tetrahedron_it_is_the_incentre():
    """x, y, z ≥ 0 and x + y + z ≤ 1: r = (1 − 3 r) / √3 on the diagonal, 1 / (3 + √3)."""
    found = star_kernel(
        mesh(
            [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
            [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)],
        )
    )
    radius = 1 / (3 + np.sqrt(3))
    np.testing.assert_allclose(found.point, radius, atol=1e-8)
    assert found.margin == pytest.approx(radius)
    assert set(found.decisive) == {0, 1, 2, 3}


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_of_many_faces_it_needs_only_a_few_of_them(scale):
    """A sphere of 81,920 faces: its centre, and a margin of the radius less the facets' depth."""
    ball = trimesh.creation.icosphere(6, 40.0)
    offset = np.array([50.0, 3.0, -7.0])
    found = star_kernel(mesh((ball.vertices + offset) * scale, ball.faces))
    np.testing.assert_allclose(found.point, offset * scale, atol=0.05 * scale)
    assert 39.9 * scale < found.margin <= 40 * scale


def test_of_a_prism_over_an_l_the_corner_decides():
    """All faces of an L see only the square at its corner: its middle is the answer."""
    outline = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    triangles = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    low, high = [(x, y, 0) for x, y in outline], [(x, y, 1) for x, y in outline]
    faces = [(c, b, a) for a, b, c in triangles]
    faces += [(a + 6, b + 6, c + 6) for a, b, c in triangles]
    for one in range(6):
        two = (one + 1) % 6
        faces += [(one, two, two + 6), (one, two + 6, one + 6)]
    found = star_kernel(mesh(low + high, faces))
    assert mesh(low + high, faces).volume == pytest.approx(5)
    np.testing.assert_allclose(found.point, (0.5, 0.5, 0.5), atol=1e-8)
    assert found.margin == pytest.approx(0.5)


def test_of_a_body_without_a_kernel_the_margin_is_negative():
    """A ring has no point that all faces see from inside."""
    body = trimesh.creation.torus(3, 1)
    found = star_kernel(mesh(body.vertices, body.faces))
    assert found.margin < 0
    assert len(found.decisive)
