"""Distances by brute force, and pairs of surfaces, for the tests of the metrics."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from gamutcore.boundary import modified_convex_hull

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.geometry import TriangleMesh


@pytest.fixture(scope="session")
def distances_to() -> Callable[[np.ndarray, TriangleMesh], np.ndarray]:
    """Return a function that measures distances of points from a mesh with trimesh.

    A face is skipped only if its bounding sphere is farther away than some face is. Faces of about
    the same size are searched together.
    """

    def measure(points: np.ndarray, mesh: TriangleMesh) -> np.ndarray:
        points = np.asarray(points, np.float64)
        triangles = mesh.vertices.astype(np.float64)[mesh.faces]
        centroids = triangles.mean(axis=1)
        reach = np.linalg.norm(triangles - centroids[:, None], axis=2).max(axis=1)

        def distances(point: np.ndarray, face: np.ndarray) -> np.ndarray:
            closest = trimesh.triangles.closest_point(triangles[face], points[point])
            return np.linalg.norm(closest - points[point], axis=1)

        everywhere = np.arange(len(points))
        found = distances(everywhere, cKDTree(centroids).query(points)[1])
        size = np.ceil(np.log2(np.maximum(reach, reach.max() / 2**20)))
        for one in np.unique(size):
            faces = np.flatnonzero(size == one)
            tree = cKDTree(centroids[faces])
            radii = found * (1 + 1e-9) + reach[faces].max()
            for some in np.array_split(everywhere, -(-len(points) // 50)):
                around = tree.query_ball_point(points[some], radii[some])
                point = np.repeat(some, [len(near) for near in around])
                face = faces[np.concatenate([*around, []]).astype(np.intp)]
                away = np.linalg.norm(centroids[face] - points[point], axis=1) - reach[face]
                near = away <= found[point] * (1 + 1e-9)
                if near.any():
                    np.minimum.at(found, point[near], distances(point[near], face[near]))
        return found

    return measure


@pytest.fixture(scope="session")
def sampled() -> Callable[..., np.ndarray]:
    """Return a function that samples a mesh evenly by area."""

    def draw(mesh: TriangleMesh, count: int, seed: int = 0) -> np.ndarray:
        random = np.random.default_rng(seed)
        triangles = mesh.vertices.astype(np.float64)[mesh.faces]
        edges = triangles[:, 1:] - triangles[:, :1]
        area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        share = (np.arange(count) + random.random(count)) / count
        face = np.searchsorted(np.cumsum(area), share * area.sum()).clip(max=len(area) - 1)
        u, v = random.random((2, count))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        return triangles[face, 0] + u[:, None] * edges[face, 0] + v[:, None] * edges[face, 1]

    return draw


@pytest.fixture(scope="session")
def star_shaped(random_cloud: Callable[..., np.ndarray]) -> Callable[..., TriangleMesh]:
    """Return a function that makes a bumpy surface, star-shaped about (50, 0, 0), from a seed."""

    def make(seed: int, count: int = 200) -> TriangleMesh:
        # an octahedron keeps the centre inside, however few points there are
        axes = 35.0 * np.vstack([np.eye(3), -np.eye(3)]) + (50.0, 0.0, 0.0)
        points = np.vstack([random_cloud(seed, count), axes])
        return modified_convex_hull(points, 0.3, (50.0, 0.0, 0.0)).mesh

    return make
