"""Steps of vertices towards a reference, on surfaces with known solutions."""

import numpy as np
import pytest

from gamutcore.decimation.costs.deviation import change_at, query_vertex
from gamutcore.decimation.costs.refinement import step_towards_reference
from gamutcore.decimation.costs.sample_assignment import NO_FACE, assign_samples, reassign_samples
from gamutcore.decimation.costs.samples import (
    empty_deviation,
    sample_capacity,
    take_samples,
)
from gamutcore.decimation.star import keeps_star_shape, write_vertex_link


def change_by_move(deviation, surface, vertex, place):
    asked = query_vertex(deviation, surface, vertex)
    return change_at(deviation, surface, place) if asked else np.inf


def test_steps_lower_the_deviation_of_a_noisy_sphere(icosphere, surface_from):
    """The vertices of a sphere have 2 % of noise. At least three of four steps must help."""
    mesh = icosphere(3)
    positions = mesh.vertices.astype(np.float64)
    surface = surface_from(positions, mesh.faces)
    room = sample_capacity(9 * mesh.triangles, mesh.triangles)
    deviation = empty_deviation(room, mesh.triangles)
    take_samples(deviation, surface, 9 * mesh.triangles)
    assign_samples(deviation, surface)
    random = np.random.default_rng(0)
    surface.position[:] *= 1 + 0.02 * random.normal(size=(len(positions), 1))
    for vertex in range(len(positions)):
        reassign_samples(deviation, surface, vertex, NO_FACE, NO_FACE)
    start, lowered, better = deviation.error.sum(), 0, np.empty(3)
    for vertex in range(len(positions)):
        place = surface.position[vertex].copy()
        change_by_move(deviation, surface, vertex, place)
        assert step_towards_reference(deviation, place, better)
        lowered += change_by_move(deviation, surface, vertex, better) < 0
    assert lowered >= 0.75 * len(positions)
    # one vertex after the other: the noise disappears
    ring = np.empty((10, 2), np.int32)
    for vertex in range(len(positions)):
        place = surface.position[vertex].copy()
        change_by_move(deviation, surface, vertex, place)
        found = step_towards_reference(deviation, place, better)
        count = write_vertex_link(surface, vertex, ring)
        # as in decimation, the change at an invalid position has no meaning
        valid = keeps_star_shape(surface.position, ring, count, *better)
        if found and valid and change_by_move(deviation, surface, vertex, better) < 0:
            surface.position[vertex] = better
            reassign_samples(deviation, surface, vertex, NO_FACE, NO_FACE)
    assert deviation.error.sum() < 0.35 * start


def patch():
    """A square side of 5 × 5 vertices at z = 1, its rim joined to a vertex below."""
    axis = np.linspace(-1.0, 1.0, 5)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    index = np.arange(25).reshape(5, 5)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1)
    quads = quads.reshape(-1, 4)
    rim = [*index[:, 0], *index[-1, 1:], *index[-2::-1, -1], *index[0, -2:0:-1]]
    below = [(25, rim[(i + 1) % 16], rim[i]) for i in range(16)]
    positions = np.vstack([np.stack([x.ravel(), y.ravel(), np.ones(25)], axis=1), [[0, 0, -1]]])
    return positions, np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], below])


@pytest.mark.parametrize("place", [(0.1, -0.05, 1.1), (0.0, 0.0, 0.9), (0.05, 0.1, 1.001)])
def test_steps_end_exactly_on_a_flat_reference(surface_from, place):
    """All residuals vanish at the same position, so it is the least-absolute-values solution."""
    positions, faces = patch()
    surface = surface_from(positions, faces)
    deviation = empty_deviation(len(positions) + len(faces), len(faces))
    take_samples(deviation, surface, 1)
    assign_samples(deviation, surface)
    surface.position[12] = place
    reassign_samples(deviation, surface, 12, NO_FACE, NO_FACE)
    start, better = deviation.error.sum(), np.empty(3)
    assert start > 1e-6
    heights = [abs(place[2] - 1)]
    for _ in range(8):
        here = surface.position[12].copy()
        change_by_move(deviation, surface, 12, here)
        if not step_towards_reference(deviation, here, better):
            break
        surface.position[12] = better
        reassign_samples(deviation, surface, 12, NO_FACE, NO_FACE)
        heights.append(abs(better[2] - 1))
    # the pull towards the present position shortens each step by about a hundredth
    assert heights[1] < 0.3 * heights[0]
    assert heights[-1] < 1e-9
    assert deviation.error.sum() < 1e-8 * start


def test_there_is_no_step_from_a_surface_on_the_reference(surface_from):
    positions, faces = patch()
    surface = surface_from(positions, faces)
    deviation = empty_deviation(len(positions) + len(faces), len(faces))
    take_samples(deviation, surface, 1)
    assign_samples(deviation, surface)
    better = np.full(3, 7.0)
    change_by_move(deviation, surface, 25, surface.position[25].copy())
    moved = step_towards_reference(deviation, surface.position[25].copy(), better)
    if moved:
        # the step is rounding error only
        np.testing.assert_allclose(better, surface.position[25], atol=1e-9)


def test_there_is_no_step_without_samples(surface_from):
    positions, faces = patch()
    surface = surface_from(positions, faces)
    deviation = empty_deviation(1, len(faces))
    place = np.array([0.0, 0.0, 1.2])
    assert change_by_move(deviation, surface, 12, place) == 0.0
    assert not step_towards_reference(deviation, place, np.empty(3))
