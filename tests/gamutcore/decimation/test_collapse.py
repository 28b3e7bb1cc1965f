"""A collapse: the record of a decimation is replayed, and each step is computed by other means.

A replay renames vertices in a list of faces. It shows the surface before and after every collapse.
The edge and the position are compared with explicit sums over planes, LAPACK and determinants. A
fault could hide behind the record in three places, which are tested alone: the order of equal
errors, the last resort for a direction, and the repayment of lost volume.
"""

import itertools
import threading
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import lapack
from scipy.optimize import linprog

from benchmarks.booleans import mismatch
from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimate, schedule
from gamutcore.decimation.costs import MEMORYLESS, Parameters, Trials, cost_named
from gamutcore.decimation.edge_queue import dequeue, empty_queue, enqueue, fill_queue
from gamutcore.decimation.record import empty_record
from gamutcore.decimation.surface_mesh import (
    DEFICIT_NOW,
    find_inner_direction,
    scale_to_preserve_volume,
    write_edge_link,
)
from gamutcore.errors import DecimationError
from gamutcore.geometry import TriangleMesh
from gamutcore.history import build_history

CENTRE = (0.0, 0.0, 0.0)

OCTAHEDRON = (
    np.vstack([np.eye(3), -np.eye(3)]),
    [(x, y, z) if (x < 3) ^ (y < 3) ^ (z < 3) else (x, z, y)
     for x, y, z in itertools.product((0, 3), (1, 4), (2, 5))],
)  # fmt: skip
# two tetrahedra on one base: vertices 0, 1, 2 around, 3 above, 4 below
BIPYRAMID = (
    np.array([(1, 0, 0), (-0.5, 0.9, 0), (-0.5, -0.9, 0), (0, 0, 1), (0, 0, -1)]),
    [(0, 1, 3), (1, 2, 3), (2, 0, 3), (1, 0, 4), (2, 1, 4), (0, 2, 4)],
)


@pytest.fixture(scope="module", params=COSTS)
def run(request, random_cloud):
    """Return a boundary and its decimation."""
    boundary = modified_convex_hull(random_cloud(20, 150))
    return boundary.mesh, decimate(boundary.mesh, boundary.centre, request.param)


@pytest.fixture
def with_schedule(monkeypatch):
    """Return a function that replaces the parameters, phases and trials of all costs."""

    def change(**replaced):
        monkeypatch.setattr(
            schedule, "cost_named", lambda name: cost_named(name)._replace(**replaced)
        )

    return change


# --- the record ----------------------------------------------------------------------------------


def counter_clockwise(faces, vertex, start, end):
    """Return the corners at a vertex between two neighbours, counter-clockwise.

    Seen from outside, without the two faces that contain both vertices of the edge.
    """
    follower = {}
    for number, face in faces.items():
        if vertex in face:
            place = face.index(vertex)
            follower[face[(place + 1) % 3]] = (3 * number + place, face[(place + 2) % 3])
    corners, neighbour = [], start
    while neighbour != end:
        corner, neighbour = follower[neighbour]
        corners.append(corner)
    return corners


def degree(faces, vertex):
    return sum(vertex in face for face in faces.values())


class TestRecord:
    def test_is_a_sequence_of_edge_collapses_and_shifts(self, run):
        mesh, decimation = run
        record = decimation.record
        faces = dict(enumerate(mesh.faces.tolist()))
        positions = mesh.vertices.copy()
        start = shift_start = 0
        for step, (kept, dead) in enumerate(
            zip(record.kept.tolist(), record.dead.tolist(), strict=True)
        ):
            np.testing.assert_array_equal(record.position[step, 0], positions[kept])
            np.testing.assert_array_equal(record.position[step, 1], positions[dead])
            vanishing = {n for n, face in faces.items() if kept in face and dead in face}
            left, right = record.sides[step].tolist()
            for corner, expected in zip(
                record.corner[step].tolist(), [(kept, dead, left), (dead, kept, right)], strict=True
            ):
                face = faces[corner // 3]
                assert tuple(face[(corner + place) % 3] for place in range(3)) == expected
                vanishing.remove(corner // 3)
            assert not vanishing
            moved = counter_clockwise(faces, dead, right, left)
            end = int(record.moved_end[step])
            assert record.moved[start:end].tolist() == moved
            assert degree(faces, dead) <= degree(faces, kept)
            for corner in record.corner[step].tolist():
                del faces[corner // 3]
            for corner in moved:
                faces[corner // 3][corner % 3] = kept
            positions[kept] = record.position[step, 2]
            shift_end = int(record.shifted_end[step])
            shifted = record.shifted[shift_start:shift_end].tolist()
            assert len(set(shifted)) == len(shifted)
            around = {vertex for face in faces.values() if kept in face for vertex in face} - {kept}
            assert set(shifted) <= around
            for index, vertex in enumerate(shifted, shift_start):
                np.testing.assert_array_equal(record.shift[index, 0], positions[vertex])
                positions[vertex] = record.shift[index, 1]
            start, shift_start = end, shift_end
        # the record has no unused entries, and all positions are on the grid
        assert start == len(record.moved)
        assert shift_start == len(record.shifted) == len(record.shift)
        for places in (record.position, record.shift, decimation.positions):
            np.testing.assert_array_equal(places.astype(np.float64) % decimation.step, 0.0)
        assert len(faces) == 4
        for number, face in faces.items():
            assert decimation.vertex[3 * number : 3 * number + 3].tolist() == face
            np.testing.assert_array_equal(decimation.positions[face], positions[face])

    def test_every_level_of_it_is_a_gamut(self, run, assert_every_level):
        mesh, decimation = run
        levels = build_history(decimation).levels()
        counts = assert_every_level(levels, decimation.centre)
        assert counts == list(range(4, mesh.triangles + 1, 2))

    @pytest.mark.parametrize("cost", COSTS)
    def test_no_collapse_pinches_the_surface(self, cost):
        """The waist of a bipyramid is a triangle without a face, so its edges cannot collapse."""
        positions, faces = BIPYRAMID
        # the waist is the cheapest by length and by angle
        mesh = TriangleMesh((positions * (0.1, 0.1, 1.0)).astype(np.float32), np.array(faces))
        record = decimate(mesh, CENTRE, cost).record
        assert not {int(record.kept[0]), int(record.dead[0])} <= {0, 1, 2}

    @pytest.mark.parametrize("cost", ["volume", "finest"])
    def test_is_extended_when_it_is_full(self, monkeypatch, assert_every_level, icosphere, cost):
        def scarce(vertices, moved_vertices=0):
            record = empty_record(vertices, moved_vertices)
            return record._replace(moved=record.moved[:9], shifted=record.shifted[:9])

        monkeypatch.setattr(schedule, "empty_record", scarce)
        history = build_history(decimate(icosphere(2), CENTRE, cost))
        assert assert_every_level(history.levels(), CENTRE) == list(range(4, 321, 2))


def assert_same(one, other):
    """Compare decimations bit for bit."""
    for first, second in zip(
        (*one.record, one.vertex, one.positions),
        (*other.record, other.vertex, other.positions),
        strict=True,
    ):
        assert first.tobytes() == second.tobytes()


@pytest.mark.parametrize("cost", COSTS)
def test_reruns_are_bit_identical_and_leave_the_mesh_as_it_was(icosphere, cost):
    mesh, before = icosphere(2), icosphere(2)
    wide = TriangleMesh(mesh.vertices.astype(np.float64), mesh.faces.astype(np.int64))
    assert_same(decimate(mesh, CENTRE, cost), decimate(wide, CENTRE, cost))
    assert mesh == before


# --- the replay ----------------------------------------------------------------------------------


class Step(NamedTuple):
    """A collapse, and the surface before it."""

    positions: np.ndarray
    faces: np.ndarray
    kept: int
    dead: int
    point: np.ndarray
    """Position of the kept vertex after the collapse."""

    def edges(self):
        sides = self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        return np.unique(np.sort(sides, axis=1), axis=0).tolist()


def merged(faces, kept, dead):
    """Faces after a collapse, by renaming."""
    renamed = np.where(faces == dead, kept, faces)
    a, b, c = renamed.T
    return renamed[(a != b) & (b != c) & (c != a)]


def replay(mesh, decimation):
    """Yield the steps of a decimation without shifts."""
    record, faces = decimation.record, mesh.faces
    positions = np.rint(mesh.vertices.astype(np.float64) / decimation.step) * decimation.step
    for kept, dead, places in zip(record.kept, record.dead, record.position, strict=True):
        point = places[2].astype(np.float64)
        yield Step(positions.copy(), faces, int(kept), int(dead), point)
        faces = merged(faces, kept, dead)
        positions[kept] = point


def volume(positions, faces):
    return np.linalg.det(positions[faces]).sum() / 6


def is_valid(step, one, two, point):
    """Whether an edge has two common neighbours, and all faces around the point see the centre."""
    around = [set(step.faces[(step.faces == end).any(axis=1)].ravel()) for end in (one, two)]
    after, moved = merged(step.faces, one, two), step.positions.copy()
    moved[one] = point
    ring = after[(after == one).any(axis=1)]
    return len(around[0] & around[1]) == 4 and np.linalg.det(moved[ring]).min() > 0


REGULARISATION, FLATNESS = 1e-5, 1e-10
"""The pull to the midpoint and the weight of the edge's length, as fractions of the trace. Both are
additions to the published costs, and stand in the manual."""


class Quadric(NamedTuple):
    """Least squares over planes (rows · x = right), relative to the midpoint of an edge."""

    rows: np.ndarray
    right: np.ndarray
    middle: np.ndarray
    length: float

    @property
    def trace(self):
        return (self.rows**2).sum()

    def error(self, point):
        distances = self.rows @ (point - self.middle) - self.right
        return (distances**2).sum() + FLATNESS * self.trace * self.length**2

    def pull(self, best):
        """By how much the pull can raise the error above its least value, at `best`."""
        return REGULARISATION * self.trace * ((best - self.middle) ** 2).sum()

    def is_well_conditioned(self):
        return np.linalg.svd(self.rows, compute_uv=False)[-1] ** 2 > 0.01 * self.trace


def area_vectors(positions, faces):
    a, b, c = positions[faces].transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2


def midpoint(step, one, two):
    ends = step.positions[[one, two]]
    return ends.mean(axis=0), float(np.linalg.norm(ends[0] - ends[1]))


class TestPublishedCost:
    """Garland & Heckbert 1997: squared distances from all planes that the ends have accumulated."""

    @pytest.mark.parametrize("seed", range(2))
    def test_the_cheapest_edge_goes_to_the_point_of_least_error(self, bumpy_mesh, seed):
        mesh = TriangleMesh(*bumpy_mesh(seed, 50))
        decimation = decimate(mesh, CENTRE, "quadric")
        planes, compared = None, 0
        for number, step in enumerate(replay(mesh, decimation)):
            if planes is None:
                normals = area_vectors(step.positions, step.faces)
                normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
                offsets = (normals * step.positions[step.faces[:, 0]]).sum(axis=1)
                sheets = np.column_stack([normals, offsets])
                planes = [sheets[(step.faces == v).any(axis=1)] for v in range(len(mesh.vertices))]

            def quadric(one, two, step=step, planes=planes):
                both = np.vstack([planes[one], planes[two]])
                middle, length = midpoint(step, one, two)
                return Quadric(both[:, :3], both[:, 3] - both[:, :3] @ middle, middle, length)

            chosen = quadric(step.kept, step.dead)
            best = chosen.middle + np.linalg.lstsq(chosen.rows, chosen.right)[0]
            error, rounding = chosen.error(step.point), decimation.step
            if is_valid(step, step.kept, step.dead, best) and chosen.is_well_conditioned():
                away = np.linalg.norm(step.point - best)
                assert away <= 1e-3 * np.linalg.norm(chosen.middle - best) + rounding
                compared += 1
            for one, two in step.edges() if number % 4 == 0 else ():
                other = quadric(one, two)
                least = other.middle + np.linalg.lstsq(other.rows, other.right)[0]
                bound = other.error(least) + other.pull(least)
                assert bound * 1.001 >= error or not is_valid(step, one, two, least)
            planes[step.kept] = np.vstack([planes[step.kept], planes[step.dead]])
        assert compared > number / 3


def memoryless(step, one, two):
    """Planes of the faces at both ends, weighted by area; the two faces at the edge count twice."""
    faces = np.vstack([step.faces[(step.faces == end).any(axis=1)] for end in (one, two)])
    vectors, (middle, length) = area_vectors(step.positions, faces), midpoint(step, one, two)
    rows = vectors / np.sqrt(np.linalg.norm(vectors, axis=1))[:, np.newaxis]
    right = np.sum(rows * (step.positions[faces[:, 0]] - middle), axis=1)
    return Quadric(rows, right, middle, length)


def by_lapack(quadric, step, one, two, wanted):
    """Point of least error among those that make the volume `wanted`; gradient of the volume."""
    after, moved = merged(step.faces, one, two), step.positions.copy()

    def volume_at(point):
        moved[one] = point
        return volume(moved, after)

    # the volume is affine in the position, so differences give its gradient exactly
    at_middle = volume_at(quadric.middle)
    slope = np.array([volume_at(quadric.middle + axis) - at_middle for axis in np.eye(3)])
    right = np.array([wanted - at_middle])
    # GGLSE overwrites its arguments
    *_, solution, info = lapack.dgglse(
        quadric.rows.copy(), slope[np.newaxis].copy(), quadric.right.copy(), right
    )
    assert info == 0
    return quadric.middle + solution, slope


def is_parallel(one, other, tolerance):
    return np.linalg.norm(np.cross(one, other)) <= tolerance * np.linalg.norm(other)


class TestMemorylessQuadrics:
    """Lindstrom & Turk 1998: area by squared distance from present faces, under exact volume."""

    @pytest.fixture
    def steps_of(self, with_schedule):
        """Return a function from a mesh to the steps of a decimation, and the step of the grid."""
        with_schedule(
            parameters=Parameters(MEMORYLESS, preserves_volume=True, compared_vertices=4),
            trials=None,
            compacted=(),
        )

        def make(mesh):
            decimation = decimate(mesh, CENTRE)
            return list(replay(mesh, decimation)), decimation.step

        return make

    @pytest.mark.parametrize("seed", range(2))
    def test_the_position_is_the_constrained_optimum_or_the_first_valid_one_after_it(
        self, bumpy_mesh, steps_of, seed
    ):
        """After collapses as well: the planes are those of the present faces.

        The volume is that of the full boundary but for one rounding to the grid, because each
        collapse makes up for the rounding of the last one.
        """
        positions, faces = bumpy_mesh(seed, 100)
        pulled = 10 ** np.random.default_rng(seed).uniform(-0.7, 0.7, (len(positions), 1))
        steps, grid = steps_of(TriangleMesh((positions * pulled).astype(np.float32), faces))
        whole = volume(steps[0].positions, steps[0].faces)
        optima = others = 0
        for step in steps:
            one, two, point = step.kept, step.dead, step.point
            quadric = memoryless(step, one, two)
            best, slope = by_lapack(quadric, step, one, two, whole)
            rounding = np.sqrt(3) / 2 * grid
            moved = step.positions.copy()
            moved[one] = point
            change = volume(moved, merged(step.faces, one, two)) - whole
            assert abs(change) <= rounding * np.linalg.norm(slope) + 1e-12 * whole
            near = 2e-3 * np.linalg.norm(quadric.middle - best) + rounding
            if not quadric.is_well_conditioned():
                continue
            if np.linalg.norm(point - best) <= near:
                optima += 1
                continue
            assert not is_valid(step, one, two, best)
            others += 1
            ends = step.positions[[one, two]]
            if is_parallel(point, quadric.middle, 2 * rounding):
                continue
            assert not is_valid(step, one, two, quadric.middle)
            if not any(is_parallel(point, end, 2 * rounding) for end in ends):
                assert not any(is_valid(step, one, two, end) for end in ends)
        assert optima > len(steps) / 3
        assert others > 1

    @pytest.mark.parametrize("seed", range(2))
    def test_no_edge_that_nothing_has_changed_is_cheaper(self, bumpy_mesh, steps_of, seed):
        """Changed edges are evaluated when they come to the front, so they may be late."""
        steps, _ = steps_of(TriangleMesh(*bumpy_mesh(seed, 80)))
        whole = volume(steps[0].positions, steps[0].faces)
        changed, compared = set(), 0
        for number, step in enumerate(steps[:50]):
            quadric = memoryless(step, step.kept, step.dead)
            error = quadric.error(step.point) * quadric.trace
            for one, two in step.edges() if number % 8 == 0 else ():
                if {one, two} & changed:
                    continue
                other = memoryless(step, one, two)
                best, _ = by_lapack(other, step, one, two, whole)
                bound = (other.error(best) + other.pull(best)) * other.trace
                assert bound * 1.001 >= error or not is_valid(step, one, two, best)
                compared += 1
            after = merged(step.faces, step.kept, step.dead)
            changed |= set(after[(after == step.kept).any(axis=1)].ravel().tolist())
        assert compared > 200


# --- what could hide behind the record -----------------------------------------------------------

PRIORITIES = st.one_of(
    st.sampled_from([0.0, 1.0, 2.0, np.inf]),  # many that are equal
    st.floats(0, 1e6),
)


@pytest.mark.slow
@given(
    st.dictionaries(st.integers(0, 24), PRIORITIES),
    st.randoms(use_true_random=False),
    st.lists(st.tuples(st.booleans(), st.integers(0, 24), PRIORITIES), max_size=120),
)
def test_edges_leave_the_queue_by_error_and_then_by_number(queued, random, changes):
    """Whatever the order in which they were queued, as from a dictionary."""
    queue = empty_queue(25)
    edges = list(queued)
    random.shuffle(edges)
    queue.heap[: len(edges)] = edges
    queue.priority[edges] = [queued[edge] for edge in edges]
    fill_queue(queue, len(edges))
    for is_queued, edge, priority in changes:
        if is_queued:
            enqueue(queue, edge, priority)
            queued[edge] = priority
        else:
            dequeue(queue, edge)
            queued.pop(edge, None)
        assert queue.size[0] == len(queued)
        if queued:
            assert queue.heap[0] == min(queued, key=lambda edge: (queued[edge], edge))
    left = []
    while queue.size[0]:
        left.append(int(queue.heap[0]))
        dequeue(queue, left[-1])
    assert left == sorted(queued, key=lambda edge: (queued[edge], edge))


def regular_ring(sides):
    turn = np.arange(sides) * 2 * np.pi / sides
    position = np.stack([np.cos(turn), np.sin(turn), np.ones(sides)], axis=1)
    return position, np.stack([np.arange(sides), np.roll(np.arange(sides), -1)], axis=1)


class TestInnerDirection:
    """The last resort where the optimum, the midpoint and the ends are not valid."""

    @settings(max_examples=50)
    @given(seed=st.integers(0, 10**6), sides=st.integers(3, 12), spread=st.floats(0.05, 3.0))
    def test_agrees_with_linear_programming(self, seed, sides, spread):
        """A perturbed ring around the z axis, seen from the centre."""
        random = np.random.default_rng(seed)
        position, ring = regular_ring(sides)
        position += random.normal(size=(sides, 3)) * spread * 0.3
        normals = np.cross(position[ring[:, 0]], position[ring[:, 1]])
        normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
        # the largest t with n·x ≥ t for some x in the cube, whose corners are at √3
        rows = np.hstack([-normals, np.ones((sides, 1))])
        bounds = [(-1, 1)] * 3 + [(None, None)]
        depth = -linprog([0, 0, 0, -1], rows, np.zeros(sides), bounds=bounds).fun
        direction = random.normal(size=3)
        exists = find_inner_direction(position, ring.astype(np.int32), sides, direction)
        if exists:
            assert np.linalg.norm(direction) == pytest.approx(1.0)
            assert 0 < (normals @ direction).min() <= depth * (1 + 1e-9)
        if depth <= 0:
            assert not exists
        if depth > 0.1:
            assert exists
            # well inside: at least a third of the largest depth
            assert (normals @ direction).min() > depth / 3 / np.sqrt(3)

    @pytest.mark.parametrize("start", [(0, 0, -1), (1, 0, 0), (-3, 2, -5)])
    def test_is_the_axis_of_a_regular_ring_from_anywhere(self, start):
        position, ring = regular_ring(6)
        direction = np.array(start, float)
        assert find_inner_direction(position, ring.astype(np.int32), 6, direction)
        np.testing.assert_allclose(direction, (0, 0, 1), atol=0.05)

    def test_there_is_none_where_a_side_of_the_ring_points_at_the_centre_or_from_nowhere(self):
        position, ring = regular_ring(3)
        assert not find_inner_direction(position, ring.astype(np.int32), 3, np.zeros(3))
        position[1] = 2 * position[0]
        start = np.array([0.0, 0.0, 1.0])
        assert not find_inner_direction(position, ring.astype(np.int32), 3, start)


class TestLostVolume:
    """Of an octahedron, whose volume is 4/3; the star of an edge has 6 of its 8 faces."""

    @pytest.mark.parametrize(("missing", "made_up"), [(0.01, 0.01), (-0.1, -0.1), (-0.6, 0.0)])
    def test_is_made_up_unless_it_is_half_the_star(self, surface_from, missing, made_up):
        surface, ring = surface_from(*OCTAHEDRON), np.empty((8, 2), np.int32)
        surface.deficit[DEFICIT_NOW] = 6 * missing
        count = write_edge_link(surface, 0, 1, ring)
        point = np.array([0.5, 0.5, 0.0])
        assert scale_to_preserve_volume(surface, 0, 1, ring, count, point)
        assert point[0] == pytest.approx(point[1], rel=1e-12)
        moved = OCTAHEDRON[0].copy()
        moved[0] = point
        after = volume(moved, merged(np.array(OCTAHEDRON[1]), 0, 1))
        assert after == pytest.approx(4 / 3 + made_up, rel=1e-12)

    @pytest.mark.parametrize("point", [(-1.0, -1.0, 0.0), CENTRE, (np.nan, 1.0, 0.0)])
    def test_cannot_be_made_up_behind_the_centre(self, surface_from, point):
        surface, ring = surface_from(*OCTAHEDRON), np.empty((8, 2), np.int32)
        count = write_edge_link(surface, 0, 1, ring)
        moved = np.array(point)
        assert not scale_to_preserve_volume(surface, 0, 1, ring, count, moved)
        np.testing.assert_array_equal(moved, point)


# --- the schedule --------------------------------------------------------------------------------


class TestSchedule:
    @pytest.mark.parametrize("cost", ["volume", "finest"])
    @pytest.mark.slow
    def test_the_best_of_many_trials_is_better_on_average(self, with_schedule, random_cloud, cost):
        boundaries = [modified_convex_hull(random_cloud(seed, 200)) for seed in range(6)]
        means = []
        for count in (1, 8):
            with_schedule(trials=Trials(100, count, 27))
            levels = [
                build_history(decimate(boundary.mesh, boundary.centre, cost)).level(50)
                for boundary in boundaries
            ]
            pairs = zip(boundaries, levels, strict=True)
            means.append(np.mean([mismatch(boundary.mesh, level) for boundary, level in pairs]))
        assert means[1] < means[0]

    @pytest.mark.parametrize("cost", ["volume", "finest"])
    def test_levels_finer_than_the_trials_do_not_depend_on_them(
        self, with_schedule, icosphere, cost
    ):
        mesh, levels = icosphere(2), []
        for replacement in (None, Trials(60, 3, 27)):
            with_schedule(trials=replacement)
            history = build_history(decimate(mesh, CENTRE, cost))
            levels.append(sorted(history.level(2 * 60 - 4).vertices.tolist()))
        assert levels[0] == levels[1]

    def test_a_trial_that_ends_too_early_is_not_chosen(self, monkeypatch, with_schedule, icosphere):
        _run_phase = schedule._run_phase

        def ends_early(state, until, counter, **options):
            perturbed = len(options.get("perturbation", ())) > 0
            early = "perturbation" in options and perturbed == blocks_perturbed
            return _run_phase(state, until + 1 if early else until, counter, **options)

        monkeypatch.setattr(schedule, "_run_phase", ends_early)
        with_schedule(trials=Trials(60, 3, 27))
        mesh, blocks_perturbed = icosphere(2), True
        only = decimate(mesh, CENTRE)
        blocks_perturbed = False
        with_schedule(trials=Trials(60, 1, 27))
        with pytest.raises(DecimationError, match="triangles left"):
            decimate(mesh, CENTRE)
        monkeypatch.setattr(schedule, "_run_phase", _run_phase)
        assert_same(only, decimate(mesh, CENTRE))


class TestProgress:
    def test_is_reported_in_order_until_the_callback_fails(self, monkeypatch, icosphere):
        """The callback runs in another thread while the work runs; its exception is raised."""
        monkeypatch.setattr(schedule, "_INTERVAL", 0.001)
        parts = []

        def report(part):
            parts.append(part)
            assert threading.current_thread() is not threading.main_thread()
            if part > 0.3:
                raise OSError("nobody listens")

        with pytest.raises(OSError, match="nobody listens"):
            decimate(icosphere(2), CENTRE, "finest", progress=report)
        assert parts == sorted(parts)
        assert 0 <= parts[0] <= parts[-1] <= 1
        assert not any(thread.name == "progress" for thread in threading.enumerate())

    def test_changes_nothing(self, monkeypatch, icosphere):
        monkeypatch.setattr(schedule, "_INTERVAL", 0.001)
        parts = []
        decimation = decimate(icosphere(2), CENTRE, progress=parts.append)
        assert_same(decimation, decimate(icosphere(2), CENTRE))
        assert parts == sorted(parts)
