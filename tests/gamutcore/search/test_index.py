"""The index: which meshes it refuses, margins of planes, directions and the order of faces."""

import numpy as np
import pytest

from gamutcore.errors import InvalidPointsError, MeshError
from gamutcore.search.index import MARGIN, build_index


class TestBuildIndex:
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
