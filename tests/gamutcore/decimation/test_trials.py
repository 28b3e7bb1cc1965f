"""Several ways down: the best of them is taken, and a cost without any goes one."""

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import decimate, decimate, ways
from gamutcore.decimation.costs import COSTS, cost_module, finest, volume
from gamutcore.decimation.plan import Fork
from gamutcore.decimation.stages import NOTHING_KNOWN
from gamutcore.errors import DecimationError
from gamutcore.history import history_of
from gamutcore.metric import mismatch

CENTRE = (0.0, 0.0, 0.0)


@pytest.fixture
def planned(monkeypatch):
    """Return a function that changes parts of a cost's plan."""

    def change(module, **parts):
        monkeypatch.setattr(module, "PLAN", module.PLAN._replace(**parts))

    return change


@pytest.mark.parametrize("module", [volume, finest])
def test_of_many_ways_the_one_that_deviates_least_is_taken(planned, random_cloud, module):
    """By the samples; exactly it may be another one, but not on average."""
    boundaries = [modified_convex_hull(random_cloud(seed, 300)) for seed in range(6)]
    means = []
    for number in (1, 12):
        planned(module, forks=(Fork(100, number, (27,)),))
        cost = module.__name__.rpartition(".")[2]
        levels = [
            history_of(decimate(boundary.mesh, boundary.centre, cost)).level(50)
            for boundary in boundaries
        ]
        pairs = zip(boundaries, levels, strict=True)
        means.append(np.mean([mismatch(boundary.mesh, level) for boundary, level in pairs]))
    assert means[1] < means[0]


@pytest.mark.parametrize("cost", ["volume", "finest"])
def test_levels_above_the_fork_do_not_depend_on_it(planned, icosphere, cost):
    mesh, module, levels = icosphere(3), cost_module(cost), []
    for forks in ((), (Fork(60, 3, (27, 12)),)):
        planned(module, forks=forks)
        history = history_of(decimate(mesh, CENTRE, cost))
        levels.append(sorted(map(tuple, history.level(2 * 60 - 4).vertices.tolist())))
    assert levels[0] == levels[1]


def test_a_boundary_of_fewer_vertices_forks_at_once(planned, icosphere, assert_every_invariant):
    mesh = icosphere(1)
    assert len(mesh.vertices) == 42
    planned(volume, forks=(Fork(200, 6, (52, 27)), Fork(27, 2, (12,)), Fork(90, 2, (50,))))
    history = history_of(decimate(mesh, CENTRE))
    for level in history.levels():
        assert_every_invariant(level, CENTRE, level.triangles)
    several = mismatch(mesh, history.level(50))
    planned(volume, forks=())
    assert several <= mismatch(mesh, history_of(decimate(mesh, CENTRE)).level(50))


@pytest.mark.parametrize("cost", COSTS)
def test_a_tetrahedron_has_one_level(icosphere, cost):
    ends = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], np.float32)
    faces = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32)
    mesh = type(icosphere(1))(ends, faces)
    assert mesh.volume > 0
    history = history_of(decimate(mesh, CENTRE, cost))
    assert [level.triangles for level in history.levels()] == [4]


def test_a_way_that_ends_too_early_is_not_taken(monkeypatch, planned, icosphere):
    run_stage = ways.run_stage

    def ends_early(stage, until, record, done, **options):
        early = options.get("way", (0, 0.0))[0] in blocked
        return run_stage(stage, until + 1 if early else until, record, done, **options)

    planned(volume, forks=(Fork(60, 3, (27,)),))
    monkeypatch.setattr(ways, "run_stage", ends_early)
    mesh, blocked = icosphere(2), {1, 2}
    only = history_of(decimate(mesh, CENTRE)).level(50)
    planned(volume, forks=(Fork(60, 1, (27,)),))
    expected = history_of(decimate(mesh, CENTRE)).level(50)
    np.testing.assert_array_equal(only.vertices, expected.vertices)
    blocked = {0}
    with pytest.raises(DecimationError, match="triangles left"):
        decimate(mesh, CENTRE)


@pytest.mark.parametrize("cost", ["volume", "finest"])
def test_progress_moves_on_while_ways_are_tried(monkeypatch, planned, icosphere, cost):
    courses, told = [], []
    run_stage, course_of = ways.run_stage, decimate.course_of

    def kept(plan, size):
        courses.append(course_of(plan, size))
        return courses[0]

    def looked_at(*arguments, **options):
        passage = run_stage(*arguments, **options)
        told.append(courses[0].done())
        return passage

    monkeypatch.setattr(decimate, "course_of", kept)
    monkeypatch.setattr(ways, "run_stage", looked_at)
    planned(cost_module(cost), forks=(Fork(60, 5, (40, 27)), Fork(27, 3, (12,))))
    decimate(icosphere(2), CENTRE, cost)
    # to the first fork, five ways in two stages, three in one, and what is left
    assert len(told) == 1 + 5 * 2 + 3 + 1
    assert (np.diff(told) > 0).all()
    assert told[-1] == pytest.approx(1)


@pytest.mark.parametrize("module", [volume, finest])
def test_errors_that_are_known_lead_the_same_way(monkeypatch, planned, icosphere, module):
    """As those that each way evaluates for itself."""
    planned(module, forks=(Fork(100, 3, (27,)),))
    cost, run_stage = module.__name__.rpartition(".")[2], ways.run_stage
    mesh, ways_gone = icosphere(3), []
    for keeping in (True, False):
        records = []

        def carried(*arguments, keeping=keeping, records=records, **options):
            known = options.pop("known", NOTHING_KNOWN)
            if len(known):
                options["known"] = known if keeping else np.full(len(known), np.nan)
            passage = run_stage(*arguments, **options)
            records.append(passage.record)
            assert not np.isnan(known).any() or not keeping
            return passage

        monkeypatch.setattr(ways, "run_stage", carried)
        decimate(mesh, CENTRE, cost)
        ways_gone.append(records)
    assert len(ways_gone[0]) >= 5
    for one, other in zip(*ways_gone, strict=True):
        for array, same in zip(one, other, strict=True):
            np.testing.assert_array_equal(array, same)


def test_all_collapses_are_told_once(icosphere):
    """Whatever is tried on other ways."""
    mesh, told = icosphere(4), []
    decimate(mesh, CENTRE, "finest", progress=told.append)
    assert told
    assert told == sorted(told)
    assert all(0 <= part <= 1 for part in told)
