"""Records: replayed by renaming vertices, the same in phases, in trials and in every run."""

import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.booleans import mismatch
from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimate, schedule
from gamutcore.decimation.costs import Trials, cost_named
from gamutcore.decimation.record import empty_record
from gamutcore.errors import DecimationError
from gamutcore.geometry import TriangleMesh
from gamutcore.history import build_history

CENTRE = (0.0, 0.0, 0.0)


@pytest.fixture(scope="module", params=COSTS)
def run(request, random_cloud):
    """Return a boundary and its decimation."""
    boundary = modified_convex_hull(random_cloud(20, 150))
    return boundary.mesh, decimate(boundary.mesh, boundary.centre, request.param)


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

    def test_every_vertex_dies_at_most_once_and_four_never(self, run):
        mesh, decimation = run
        dead = decimation.record.dead
        assert len(set(dead.tolist())) == len(dead) == len(mesh.vertices) - 4
        gone = decimation.record.corner // 3
        assert len(set(gone.ravel().tolist())) == mesh.triangles - 4


def assert_same(one, other):
    """Compare decimations bit for bit."""
    for first, second in zip(
        (*one.record, one.vertex, one.positions),
        (*other.record, other.vertex, other.positions),
        strict=True,
    ):
        assert first.tobytes() == second.tobytes()


class TestDeterminism:
    def test_reruns_are_bit_identical(self, request, run):
        mesh, first = run
        again = decimate(mesh, first.centre, request.node.callspec.params["run"])
        assert_same(first, again)

    @pytest.mark.parametrize("cost", COSTS)
    def test_the_mesh_is_left_as_it_was_and_its_types_make_no_difference(self, icosphere, cost):
        mesh, before = icosphere(2), icosphere(2)
        wide = TriangleMesh(mesh.vertices.astype(np.float64), mesh.faces.astype(np.int64))
        assert_same(decimate(mesh, CENTRE, cost), decimate(wide, CENTRE, cost))
        assert mesh == before

    @pytest.mark.parametrize("cost", ["volume", "finest"])
    def test_a_record_that_is_full_is_extended(
        self, monkeypatch, assert_every_level, icosphere, cost
    ):
        def scarce(vertices, moved_vertices=0):
            record = empty_record(vertices, moved_vertices)
            return record._replace(moved=record.moved[:9], shifted=record.shifted[:9])

        monkeypatch.setattr(schedule, "empty_record", scarce)
        history = build_history(decimate(icosphere(2), CENTRE, cost))
        assert assert_every_level(history.levels(), CENTRE) == list(range(4, 321, 2))


@pytest.fixture
def with_schedule(monkeypatch):
    """Return a function that replaces the phases and the trials of all costs."""

    def change(**replaced):
        monkeypatch.setattr(
            schedule, "cost_named", lambda name: cost_named(name)._replace(**replaced)
        )

    return change


class TestSchedule:
    @settings(max_examples=15)
    @given(seed=st.integers(0, 10**6), stops=st.sets(st.integers(5, 60), max_size=4))
    def test_a_decimation_in_phases_is_the_same_as_in_one(self, bumpy_mesh, seed, stops):
        """`quadric` stores its state in vertices only, so nothing is lost between phases."""
        mesh = TriangleMesh(*bumpy_mesh(seed, 80))
        whole = build_history(decimate(mesh, CENTRE, "quadric"))
        in_phases = cost_named("quadric")._replace(compacted=tuple(sorted(stops)[::-1]))
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(schedule, "cost_named", lambda _: in_phases)
            parts = build_history(decimate(mesh, CENTRE, "quadric"))
        for one, other in zip(whole.levels(), parts.levels(), strict=True):
            assert one.triangles == other.triangles
            assert sorted(one.vertices.tolist()) == sorted(other.vertices.tolist())
            assert one.volume == pytest.approx(other.volume, rel=1e-12)

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


@pytest.mark.slow
def test_progress_is_reported_in_order_until_the_callback_fails(monkeypatch, icosphere):
    """The callback runs in another thread while the work runs; its exception is raised."""
    monkeypatch.setattr(schedule, "_INTERVAL", 0.01)
    told = []

    def report(part):
        told.append(part)
        assert threading.current_thread() is not threading.main_thread()
        if part > 0.5:
            raise OSError("nobody listens")

    with pytest.raises(OSError, match="nobody listens"):
        decimate(icosphere(4), CENTRE, "finest", progress=report)
    assert told == sorted(told)
    assert told[0] >= 0
    assert told[-1] <= 1
    assert not any(thread.name == "progress" for thread in threading.enumerate())


def test_progress_changes_nothing(monkeypatch, icosphere):
    monkeypatch.setattr(schedule, "_INTERVAL", 0.001)
    told = []
    decimated = decimate(icosphere(3), CENTRE, progress=told.append)
    assert_same(decimated, decimate(icosphere(3), CENTRE))
    assert told == sorted(told)
