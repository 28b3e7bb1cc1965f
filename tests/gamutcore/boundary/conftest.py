"""Difficult point sets, and the checks that every boundary must pass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from gamutcore.decimation import decimate
from gamutcore.history import build_history

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.boundary import Boundary
    from gamutcore.geometry import TriangleMesh


def directions(random: np.random.Generator, count: int) -> np.ndarray:
    """Return unit vectors."""
    found = random.normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1)[:, np.newaxis]


def cloud(kind: str, seed: int) -> np.ndarray:
    """Return points about the origin, of an extent of about 100."""
    random = np.random.default_rng(seed)
    corners = 50.0 * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
    around = directions(random, 500)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    kinds = {
        "star": around * random.uniform(20, 50, (500, 1)),
        "spikes": np.vstack([around * random.choice([50, 0.5], (500, 1), p=(0.03, 0.97)), corners]),
        "nearly flat": random.uniform(-50, 50, (500, 3)) * (1, 1, 1e-3) @ turn,
        "sparse": np.vstack([corners * random.uniform(0.2, 1, (4, 1)), around[:3] * 40]),
        "one side": np.vstack([np.abs(around) * random.uniform(10, 50, (500, 1)), corners * 0.3]),
        "poles": np.vstack([around * (50, 0.05, 0.05), corners]),
        "lattice": random.integers(-3, 4, (300, 3)) * 16.0,
    }
    return kinds[kind]


@pytest.fixture(scope="session")
def hard_cloud() -> Callable[[str, int], np.ndarray]:
    """Return a function from a kind and a seed to points about the origin, 100 across."""
    return cloud


@pytest.fixture(scope="session")
def times_around() -> Callable[[TriangleMesh, np.ndarray], float]:
    """Return the winding number of a mesh about a point: its solid angle ÷ 4π.

    Van Oosterom & Strackee, "The solid angle of a plane triangle" (1983).
    """

    def count(mesh: TriangleMesh, centre: np.ndarray) -> float:
        corners = mesh.vertices[mesh.faces].astype(np.float64) - centre
        corners /= np.linalg.norm(corners, axis=2)[:, :, np.newaxis]
        a, b, c = corners.transpose(1, 0, 2)
        cosines = 1 + (a * b).sum(axis=1) + (b * c).sum(axis=1) + (c * a).sum(axis=1)
        angles = 2 * np.arctan2(np.linalg.det(corners), cosines)
        return float(angles.sum() / (4 * np.pi))

    return count


@pytest.fixture(scope="session")
def assert_decimates(
    assert_every_invariant: Callable[..., None],
    assert_every_level: Callable[..., list[int]],
    times_around: Callable[..., float],
) -> Callable[[Boundary], None]:
    """Return a check that a boundary is a gamut, on its grid, and so is each of its levels."""

    def check(boundary: Boundary) -> None:
        mesh = boundary.mesh
        assert_every_invariant(mesh, boundary.centre, mesh.triangles)
        assert times_around(mesh, boundary.centre) == pytest.approx(1.0, abs=1e-9)
        history = build_history(decimate(mesh, boundary.centre))
        assert history.triangles == mesh.triangles
        np.testing.assert_array_equal(
            np.sort(history.full().vertices, axis=0), np.sort(mesh.vertices, axis=0)
        )
        counts = assert_every_level(history.levels(), history.centre)
        assert counts == list(range(4, mesh.triangles + 2, 2))

    return check
