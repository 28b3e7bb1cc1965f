"""The index: what it holds, and which meshes it refuses."""

import numpy as np
import pytest

from gamutcore.errors import InvalidPointsError, MeshError
from gamutcore.queries.index import MARGIN, as_index, build_index


class TestBuildIndex:
    def test_planes_are_positive_inside_their_cones(self, rough):
        index = build_index(*rough(1, 200))
        corners = index.vertices[index.faces] - index.centre
        middle = corners.mean(axis=1)
        edges = index.planes[:, :9].reshape(-1, 3, 3)
        assert (np.einsum("fij,fj->fi", edges, middle) > 1).all()
        for at in range(3):
            for other in ((at + 1) % 3, (at + 2) % 3):
                assert abs(np.einsum("fj,fj->f", edges[:, at], corners[:, other])).max() < 1
        heights = index.planes[:, None, 12] - np.einsum(
            "fj,fcj->fc", index.planes[:, 9:12], corners
        )
        assert abs(heights).max() < 1
        assert (index.planes[:, 12] > 1).all()

    def test_the_margin_covers_errors_against_rational_arithmetic(self, rough, orientation_of):
        """A plane's product ÷ its scale is a determinant, up to the margin."""
        index = build_index(*rough(2, 30))
        random = np.random.default_rng(0)
        for face in range(20):
            a, b, _ = index.vertices[index.faces[face]]
            point = random.uniform(*index.box)
            lengths = np.linalg.norm(np.array([a, b]) - index.centre, axis=1)
            reach = np.linalg.norm(abs(index.box - index.centre).max(axis=0))
            product = index.planes[face, 6:9] @ (point - index.centre)
            exact = float(orientation_of(a, b, point, index.centre))
            assert abs(product - exact / (MARGIN * reach * lengths.prod())) < 1

    def test_the_ball_is_inside(self, rough, cube):
        assert 1 - 1e-9 < build_index(*cube).inner <= 1
        index = build_index(*rough(3, 100))
        a, b, c = (index.vertices[index.faces[:, at]] - index.centre for at in range(3))
        normal = np.cross(b - a, c - a)
        distance = np.einsum("ij,ij->i", normal, a) / np.linalg.norm(normal, axis=1)
        assert distance.min() * (1 - 1e-9) < index.inner <= distance.min()

    def test_the_memory_is_that_of_the_arrays(self, cube):
        index = build_index(*cube)
        assert index.planes.nbytes < index.nbytes < 10_000
        assert as_index(index) is index

    def test_meshes_that_are_no_level_are_refused(self, cube):
        vertices, faces, centre = cube
        with pytest.raises(MeshError, match="not closed") as caught:
            build_index(vertices, faces[1:], centre)
        assert caught.value.where["field"] == "faces"
        with pytest.raises(MeshError, match="star-shaped"):
            build_index(vertices, faces[:, ::-1], centre)
        with pytest.raises(MeshError, match="star-shaped") as caught:
            build_index(vertices, faces, (0.0, 0.0, 2.0))
        assert caught.value.where["row"] in range(12)
        with pytest.raises(MeshError, match="several times"):
            build_index(np.vstack([vertices, vertices]), np.vstack([faces, faces + 8]), centre)
        with pytest.raises(MeshError):
            build_index(vertices, np.zeros((0, 3), int), centre)
        with pytest.raises(InvalidPointsError, match="Row 7 of vertices"):
            build_index(np.vstack([vertices[:-1], [[np.nan] * 3]]), faces, centre)
        with pytest.raises(InvalidPointsError, match="centre"):
            build_index(vertices, faces, (0.0, np.inf, 0.0))
