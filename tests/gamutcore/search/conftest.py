"""Levels with answers known otherwise: rational arithmetic, a cube, spheres of rough radius."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.spatial import ConvexHull

if TYPE_CHECKING:
    from collections.abc import Callable

CENTRE = np.array([50.0, 1.5, -2.25])


def determinant(rows: list[list[Fraction]]) -> Fraction:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)


def rational_orientation(a, b, c, p) -> Fraction:
    """Return det(a − p, b − p, c − p) in rational arithmetic."""
    origin = [Fraction(float(value)) for value in p]
    return determinant(
        [[Fraction(float(v)) - o for v, o in zip(each, origin, strict=True)] for each in (a, b, c)]
    )


@pytest.fixture(scope="session")
def exact_inside() -> Callable[..., bool]:
    """Return a function that tells in rational arithmetic whether a point is inside a level."""

    def inside(point, level) -> bool:
        vertices, faces, centre = level
        for face in faces:
            a, b, c = (vertices[corner] for corner in face)
            if all(
                rational_orientation(one, two, point, centre) >= 0
                for one, two in ((a, b), (b, c), (c, a))
            ):
                return rational_orientation(a, b, c, point) >= 0
        raise AssertionError("the cones do not fill space")

    return inside


@pytest.fixture(scope="session")
def orientation_of() -> Callable[..., Fraction]:
    """Return `rational_orientation`."""
    return rational_orientation


def rough_sphere(seed: int, count: int, roughness: float = 0.4):
    """Return a star-shaped level in float32: directions of a sphere, each with its own radius."""
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    faces = ConvexHull(directions).simplices
    a, b, c = (directions[faces[:, at]] for at in range(3))
    turned = np.einsum("ij,ij->i", a, np.cross(b, c)) < 0
    faces[turned] = faces[turned][:, ::-1]
    radii = 40 * (1 + roughness * random.uniform(-1, 1, (count, 1)))
    vertices = (CENTRE + radii * directions).astype(np.float32)
    return vertices, faces.astype(np.int32), CENTRE


@pytest.fixture(scope="session")
def rough() -> Callable[..., tuple]:
    """Return `rough_sphere`."""
    return rough_sphere


@pytest.fixture(scope="session")
def cube() -> tuple:
    """Return the cube from −1 to 1 with two triangles on each side."""
    vertices = np.array(list(np.ndindex(2, 2, 2)), np.float32) * 2 - 1
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [corners for a, b, c, d in quads for corners in ((a, b, c), (a, c, d))]
    return vertices, np.array(faces, np.int32), np.zeros(3)
