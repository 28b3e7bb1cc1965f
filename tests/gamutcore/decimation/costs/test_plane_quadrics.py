"""The published cost against the formula of Garland and Heckbert, by explicit sums over planes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.costs.dispatch import (
    error_at,
    find_optimum,
    update_before_collapse,
)

QUADRIC = cost_named("quadric").parameters


def planes_at(positions, faces):
    """For each vertex, (normal, offset) of the planes of its faces."""
    planes = [[] for _ in positions]
    for face in faces:
        one, two, three = positions[face]
        normal = np.cross(two - one, three - one)
        normal /= np.linalg.norm(normal)
        for vertex in face:
            planes[vertex].append((normal, -normal @ one))
    return planes


def squared_distances(planes, place):
    return sum((normal @ place + offset) ** 2 for normal, offset in planes)


def quadric_of(planes):
    """(A, b, c) of the paper, in absolute coordinates."""
    return (
        sum(np.outer(normal, normal) for normal, _ in planes),
        sum(offset * normal for normal, offset in planes),
        sum(offset**2 for _, offset in planes),
    )


def length_penalty(positions, planes, one, two):
    """Penalty of an edge's length: 10⁻¹⁰ of the trace times the squared length."""
    return 1e-10 * len(planes) * np.sum((positions[one] - positions[two]) ** 2)


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_the_error_is_the_sum_over_the_planes_of_both_ends(
    bumpy_mesh, edges_of, corner_of, seed, stage_of
):
    positions, faces = bumpy_mesh(seed, 40)
    stage = stage_of(QUADRIC, positions, faces)
    surface = stage.surface
    planes = planes_at(positions, faces)
    random = np.random.default_rng(seed)
    for one, two in edges_of(faces)[::4]:
        place = positions[one] + 20 * random.normal(size=3)
        both = planes[one] + planes[two]
        A, b, c = quadric_of(both)
        expected = squared_distances(both, place)
        assert place @ A @ place + 2 * b @ place + c == pytest.approx(expected, rel=1e-6)
        assert error_at(stage, corner_of(surface, one, two), place) == pytest.approx(
            expected + length_penalty(positions, both, one, two), rel=1e-9
        )


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
@pytest.mark.slow
def test_the_optimum_is_where_the_gradient_vanishes(
    bumpy_mesh, edges_of, corner_of, seed, stage_of
):
    positions, faces = bumpy_mesh(seed, 40)
    stage = stage_of(QUADRIC, positions, faces)
    surface = stage.surface
    planes = planes_at(positions, faces)
    compared = 0
    for one, two in edges_of(faces):
        both = planes[one] + planes[two]
        A, b, _ = quadric_of(both)
        place = np.empty(3)
        value = find_optimum(stage, corner_of(surface, one, two), place)
        least = squared_distances(both, -np.linalg.solve(A, b))
        assert value >= least
        eigenvalues = np.linalg.eigvalsh(A)
        if eigenvalues[0] > 0.01 * eigenvalues.sum():
            # the pull to the midpoint is 1e-5 of the trace: a thousandth of the way at most
            middle = (positions[one] + positions[two]) / 2
            off = np.linalg.norm(place + np.linalg.solve(A, b))
            assert off <= 1e-3 * np.linalg.norm(middle + np.linalg.solve(A, b))
            assert value <= least * (1 + 1e-5) + length_penalty(positions, both, one, two) + 1e-4
            compared += 1
    assert compared > 10


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_quadrics_accumulate(bumpy_mesh, edges_of, corner_of, seed, stage_of):
    """A vertex keeps the planes of all vertices that were collapsed into it."""
    positions, faces = bumpy_mesh(seed, 40)
    stage = stage_of(QUADRIC, positions, faces)
    surface = stage.surface
    planes = planes_at(positions, faces)
    random = np.random.default_rng(seed)
    edges = edges_of(faces)
    for one, two in [edges[index] for index in random.permutation(len(edges))[:10]]:
        place = (positions[one] + positions[two]) / 2 + random.normal(size=3)
        update_before_collapse(stage, corner_of(surface, one, two), one, two, place)
        surface.position[one] = place
        planes[one] += planes[two]
    for one, two in edges[::7]:
        place = surface.position[two] + 10 * random.normal(size=3)
        both = planes[one] + planes[two]
        assert error_at(stage, corner_of(surface, one, two), place) == pytest.approx(
            squared_distances(both, place) + length_penalty(surface.position, both, one, two),
            rel=1e-9,
        )


def test_a_flat_side_costs_nothing_but_the_length_of_the_edge(corner_of, stage_of):
    """The solve is singular: the midpoint is taken, and shorter edges come first."""
    axis = np.linspace(-1.0, 1.0, 5)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    top = np.stack([x.ravel(), y.ravel() ** 3, np.ones(25)], axis=1)
    index = np.arange(25).reshape(5, 5)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1)
    quads = quads.reshape(-1, 4)
    rim = [*index[:, 0], *index[-1, 1:], *index[-2::-1, -1], *index[0, -2:0:-1]]
    below = [(25, rim[(i + 1) % 16], rim[i]) for i in range(16)]
    faces = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], below])
    positions = np.vstack([top, [[0, 0, -1]]])
    stage = stage_of(QUADRIC, positions, faces)
    surface = stage.surface
    errors = {}
    for one, two in ((12, 17), (12, 13), (12, 11)):
        place = np.empty(3)
        errors[one, two] = find_optimum(stage, corner_of(surface, one, two), place)
        np.testing.assert_allclose(place, (positions[one] + positions[two]) / 2, atol=1e-12)
    assert max(errors.values()) < 1e-8
    assert errors[12, 13] == pytest.approx(errors[12, 11])
    assert 0 < errors[12, 13] < errors[12, 17]


@pytest.mark.parametrize("shift", [0.0, 1e4])
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale_and_translation_cost_no_digits(bumpy_mesh, scale, shift, stage_of):
    positions, faces = bumpy_mesh(5, 40)
    here, there = np.empty(3), np.empty(3)
    expected = find_optimum(stage_of(QUADRIC, positions, faces), 2, here)
    other = (positions + shift) * scale
    value = find_optimum(stage_of(QUADRIC, other, faces), 2, there)
    assert value == pytest.approx(expected * scale**2, rel=1e-6)
    np.testing.assert_allclose(there / scale - shift, here, atol=1e-6)
