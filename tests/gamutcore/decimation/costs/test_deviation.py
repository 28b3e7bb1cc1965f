"""Changes of the deviation, against sums over all samples before and after the change is made."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.decimation.costs.deviation import (
    DENSE_LINK,
    change_at,
    current_deviation,
    query_edge,
    query_vertex,
)
from gamutcore.decimation.costs.refinement import step_towards_reference
from gamutcore.decimation.costs.sample_assignment import assign_samples, thin_samples
from gamutcore.decimation.costs.samples import (
    LARGEST_SHARE,
    SAMPLES,
    TOP,
    TOTAL_WEIGHT,
    empty_deviation,
    sample_capacity,
    take_samples,
)
from gamutcore.decimation.star import (
    LARGEST_LINK,
    keeps_star_shape,
    link_condition_holds,
    volume_gradient,
    write_edge_link,
    write_vertex_link,
)


def change_by_collapse(deviation, surface, corner, place):
    """Infinite for long and dense links."""
    asked = query_edge(deviation, surface, corner)
    return change_at(deviation, surface, place) if asked else np.inf


def change_by_move(deviation, surface, vertex, place):
    asked = query_vertex(deviation, surface, vertex)
    return change_at(deviation, surface, place) if asked else np.inf


@pytest.fixture(scope="session")
def total(by_hand, all_samples, points_of):
    """Return a function that computes the deviation over all samples for positions and faces."""

    def summed(deviation, positions, faces):
        used = all_samples(deviation)
        weights = deviation.weight[used]
        _, shares = by_hand(positions, faces, points_of(deviation, used), weights)
        return np.minimum(shares, LARGEST_SHARE * weights).sum()

    return summed


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
@pytest.mark.slow
def test_the_change_by_a_collapse_is_that_of_the_sum(deviating, total, faces_left, ends_of, seed):
    deviation, surface = deviating(seed)
    _, faces = faces_left(surface)
    before = total(deviation, surface.position, faces)
    ring, random, compared = np.empty((200, 2), np.int32), np.random.default_rng(seed), 0
    for _query, corner in enumerate(surface.corner_facing.tolist()):
        if corner < 0:
            continue
        one, two = ends_of(surface, corner)
        place = surface.position[[one, two]].mean(axis=0) * random.uniform(0.9, 1.1)
        count = write_edge_link(surface, one, two, ring)
        if not link_condition_holds(surface, one, two) or not keeps_star_shape(
            surface.position, ring, count, *place
        ):
            continue
        merged = np.where(faces == two, one, faces)
        merged = merged[[len(set(face)) == 3 for face in merged.tolist()]]
        positions = surface.position.copy()
        positions[one] = place
        expected = total(deviation, positions, merged) - before
        for at in (corner, int(surface.opposite[corner])):
            change = change_by_collapse(deviation, surface, at, place)
            assert change == pytest.approx(expected, rel=1e-7, abs=1e-9 * before)
        compared += 1
    assert compared > 10


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
@pytest.mark.slow
def test_the_change_by_a_move_is_that_of_the_sum(deviating, total, faces_left, seed):
    deviation, surface = deviating(seed)
    _, faces = faces_left(surface)
    before = total(deviation, surface.position, faces)
    ring, random, compared = np.empty((200, 2), np.int32), np.random.default_rng(seed), 0
    for vertex in np.unique(faces).tolist():
        place = surface.position[vertex] * random.uniform(0.9, 1.1, 3)
        count = write_vertex_link(surface, vertex, ring)
        if not keeps_star_shape(surface.position, ring, count, *place):
            continue
        positions = surface.position.copy()
        positions[vertex] = place
        change = change_by_move(deviation, surface, vertex, place)
        expected = total(deviation, positions, faces) - before
        assert change == pytest.approx(expected, rel=1e-7, abs=1e-9 * before)
        compared += 1
    assert compared > 5


def test_no_move_saves_more_than_the_present_deviation(deviating, total, faces_left):
    """A move saves at most the deviation of the faces that it changes."""
    deviation, surface = deviating(3)
    numbers, faces = faces_left(surface)
    whole = deviation.error[numbers].sum()
    assert whole == pytest.approx(total(deviation, surface.position, faces))
    for vertex in np.unique(faces).tolist():
        place = surface.position[vertex].copy()
        # nothing changes if the vertex stays in place
        change = change_by_move(deviation, surface, vertex, place)
        around = current_deviation(deviation)
        assert change == pytest.approx(0.0, abs=1e-9 * whole)
        expected = deviation.error[numbers[(faces == vertex).any(axis=1)]].sum()
        assert around == pytest.approx(expected, rel=1e-12)
        assert change_by_move(deviation, surface, vertex, place * 1.05) >= -around


def test_queries_change_scratch_only(deviating):
    deviation, surface = deviating(4)
    kept = [deviation.begin, deviation.end, deviation.error]
    # entries behind the last sample and in the other half are unused
    top = int(deviation.counts[TOP])
    kept += [array[:top] for array in (deviation.x, deviation.y, deviation.z, deviation.weight)]
    before = [array.copy() for array in (*surface, *kept)]
    corner = int(surface.corner_facing[surface.corner_facing >= 0][0])
    place = surface.position[surface.vertex[corner]] * 1.01
    change_by_collapse(deviation, surface, corner, place)
    step_towards_reference(deviation, place, np.empty(3))
    change_by_move(deviation, surface, int(surface.vertex[corner]), place)
    for array, expected in zip((*surface, *kept), before, strict=True):
        np.testing.assert_array_equal(array, expected)


def lantern(sides, rows):
    """Two poles with rings of vertices between them. With several rings the caps are small."""
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    rings = [
        np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), height], axis=1)
        for polar in np.linspace(0, np.pi, rows + 2)[1:-1]
        for height in [np.full(sides, np.cos(polar))]
    ]
    here = np.arange(sides)
    after = (here + 1) % sides
    faces = [
        np.stack([here, after, np.full(sides, rows * sides)], axis=1),
        np.stack([after, here, np.full(sides, rows * sides + 1)], axis=1),
    ]
    faces[1][:, :2] += (rows - 1) * sides
    for row in range(rows - 1):
        one, two = row * sides + here, row * sides + after
        faces += [
            np.stack([one, one + sides, two + sides], axis=1),
            np.stack([one, two + sides, two], axis=1),
        ]
    return np.vstack([*rings, [[0, 0, 1], [0, 0, -1]]]), np.vstack(faces)


@pytest.mark.parametrize("more", [0, 1, 200])
@pytest.mark.slow
def test_links_longer_than_the_limit_are_not_evaluated(
    surface_from, corner_of, total, faces_left, more
):
    """A link of exactly the limit is evaluated. One more pair is not."""
    sides, rows = LARGEST_LINK + more, 9
    positions, faces = lantern(sides, rows)
    surface = surface_from(positions, faces)
    deviation = empty_deviation(3 * len(positions), len(faces))
    take_samples(deviation, surface, 1)
    assign_samples(deviation, surface)
    pole, place = sides * rows, np.array([0.01, 0.0, 0.98])
    change = change_by_move(deviation, surface, pole, place)
    moved = surface.position.copy()
    moved[pole] = place
    if more == 0:
        assert change == pytest.approx(total(deviation, moved, faces_left(surface)[1]), rel=1e-7)
        assert change > 0
    else:
        assert change == np.inf
    # the edge from the pole to its ring has as many faces around it, and two from below
    corner = corner_of(surface, pole, 0)
    assert change_by_collapse(deviation, surface, corner, place) == np.inf
    # an edge of the ring has few of its own
    along = change_by_collapse(deviation, surface, corner_of(surface, 0, 1), positions[0])
    assert 0 < along < np.inf


@pytest.mark.parametrize(
    ("sides", "rows", "evaluated"),
    [
        (DENSE_LINK, 1, True),
        (DENSE_LINK + 1, 1, False),
        (DENSE_LINK + 1, 9, True),
        (40, 1, False),
        (40, 9, True),
    ],
)
def test_dense_links_are_not_evaluated(surface_from, corner_of, sides, rows, evaluated):
    """The cap has half of all samples with one ring, and at most a 36th with nine."""
    positions, faces = lantern(sides, rows)
    surface = surface_from(positions, faces)
    deviation = empty_deviation(sample_capacity(10 * len(faces), len(faces)), len(faces))
    take_samples(deviation, surface, 10 * len(faces))
    assign_samples(deviation, surface)
    pole, better = sides * rows, np.array([0.01, 0.0, 0.98])
    assert (change_by_move(deviation, surface, pole, better) < np.inf) == evaluated
    # both ends contain the two removed faces
    around = sides + surface.degree[0] - 4
    edge = change_by_collapse(deviation, surface, corner_of(surface, pole, 0), better)
    assert (edge < np.inf) == (evaluated and (around <= DENSE_LINK or rows > 1))
    for end in (0, sides - 1):
        assert change_by_move(deviation, surface, end, positions[end]) < np.inf
    assert change_by_collapse(deviation, surface, corner_of(surface, 0, 1), positions[0]) < np.inf


@pytest.mark.parametrize("times", [5, 50, 1000])
def test_enclosed_volume_counts_where_there_are_hardly_any_samples(icosphere, surface_from, times):
    """Near the centre a reference has little volume, and many directions have no sample."""
    mesh = icosphere(3)
    positions = mesh.vertices.astype(np.float64) * 40 / np.linalg.norm(mesh.vertices[0])
    surface = surface_from(positions - (0, 0, 38), mesh.faces)
    deviation = empty_deviation(sample_capacity(3000, mesh.triangles), mesh.triangles)
    take_samples(deviation, surface, 3000)
    assign_samples(deviation, surface)
    while thin_samples(deviation, surface, 200):
        pass
    slack = 10 * deviation.sums[TOTAL_WEIGHT] / deviation.counts[SAMPLES]
    ring = np.empty((10, 2), np.int32)
    for vertex in np.argsort(np.linalg.norm(surface.position, axis=1))[:20].tolist():
        count = write_vertex_link(surface, vertex, ring)
        slope = np.array(volume_gradient(surface.position, ring, count))
        here = surface.position[vertex]
        grown = (times - 1) * (slope @ here)
        change = change_by_move(deviation, surface, vertex, times * here)
        assert change >= 0.5 * grown - slack
    # the bound exceeds the slack for some vertices
    assert times < 1000 or grown > 2 * slack
