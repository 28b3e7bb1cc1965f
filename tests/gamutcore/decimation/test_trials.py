"""Schedules of decimations, and multi-start trials of the coarse levels."""

import itertools

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import decimate, decimation, trials
from gamutcore.decimation.costs import COSTS, Trials, cost_named
from gamutcore.decimation.decimation import UNIT_STEPS
from gamutcore.decimation.stage import compact_stage
from gamutcore.decimation.trials import perturbation, progress_of, schedule
from gamutcore.errors import DecimationError
from gamutcore.history import build_history
from gamutcore.metric import mismatch

CENTRE = (0.0, 0.0, 0.0)


@pytest.fixture
def with_trials(monkeypatch):
    """Return a function that replaces the trials of all costs."""

    def change(replacement):
        monkeypatch.setattr(
            decimation, "cost_named", lambda name: cost_named(name)._replace(trials=replacement)
        )

    return change


@pytest.mark.parametrize("cost", ["volume", "finest"])
@pytest.mark.slow
def test_the_best_of_many_trials_is_better_on_average(with_trials, random_cloud, cost):
    boundaries = [modified_convex_hull(random_cloud(seed, 300)) for seed in range(6)]
    means = []
    for count in (1, 12):
        with_trials(Trials(100, count, 27))
        levels = [
            build_history(decimate(boundary.mesh, boundary.centre, cost)).level(50)
            for boundary in boundaries
        ]
        pairs = zip(boundaries, levels, strict=True)
        means.append(np.mean([mismatch(boundary.mesh, level) for boundary, level in pairs]))
    assert means[1] < means[0]


@pytest.mark.parametrize("cost", ["volume", "finest"])
@pytest.mark.slow
def test_levels_finer_than_the_trials_do_not_depend_on_them(with_trials, icosphere, cost):
    mesh, levels = icosphere(3), []
    for replacement in (None, Trials(60, 3, 27)):
        with_trials(replacement)
        history = build_history(decimate(mesh, CENTRE, cost))
        levels.append(sorted(map(tuple, history.level(2 * 60 - 4).vertices.tolist())))
    assert levels[0] == levels[1]


def test_a_smaller_boundary_begins_with_the_trials(with_trials, icosphere, assert_every_level):
    mesh = icosphere(1)
    assert len(mesh.vertices) == 42
    with_trials(Trials(200, 6, 27))
    history = build_history(decimate(mesh, CENTRE))
    assert_every_level(history.levels(), CENTRE)


def test_the_trial_with_the_least_sampled_deviation_is_kept(monkeypatch, with_trials, icosphere):
    run_stage, deviations, levels = trials.run_stage, [], []

    def observed(stage, until, counter, **options):
        result = run_stage(stage, until, counter, **options)
        deviations.append(stage.deviation.error.sum())
        levels.append({*map(tuple, compact_stage(stage).grid.position.tolist())})
        return result

    monkeypatch.setattr(trials, "run_stage", observed)
    with_trials(Trials(200, 6, 27))
    decimated = decimate(icosphere(1), CENTRE)
    unit = decimated.step * 2.0**UNIT_STEPS
    level = build_history(decimated).level(50).vertices / np.float32(unit)
    # six trials, and the coarsest levels
    assert len(deviations) == 6 + 1
    assert len(set(deviations[:6])) > 1
    assert {*map(tuple, level.tolist())} == levels[int(np.argmin(deviations[:6]))]


@pytest.mark.parametrize("cost", COSTS)
@pytest.mark.parametrize("size", [4, 5, 27, 28, 100, 101, 2000, 9000, 10**6])
def test_a_schedule_goes_from_the_boundary_to_four_vertices(cost, size):
    segments = schedule(cost_named(cost), size)
    assert segments[0].vertices == size
    assert segments[-1].until == 4
    for one, two in itertools.pairwise(segments):
        assert one.until == two.vertices < one.vertices
    with_trials = [segment for segment in segments if segment.trials]
    assert len(with_trials) == (cost != "quadric" and size > 27)


@pytest.mark.parametrize("cost", COSTS)
def test_a_tetrahedron_has_one_level(icosphere, cost):
    ends = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], np.float32)
    faces = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32)
    mesh = type(icosphere(1))(ends, faces)
    assert mesh.volume > 0
    history = build_history(decimate(mesh, CENTRE, cost))
    assert [level.triangles for level in history.levels()] == [4]


def test_a_trial_that_ends_too_early_is_not_chosen(monkeypatch, with_trials, icosphere):
    run_stage = trials.run_stage

    def ends_early(stage, until, counter, **options):
        perturbed = len(options.get("perturbation", ())) > 0
        early = "perturbation" in options and perturbed == blocks_perturbed
        return run_stage(stage, until + 1 if early else until, counter, **options)

    monkeypatch.setattr(trials, "run_stage", ends_early)
    with_trials(Trials(60, 3, 27))
    mesh, blocks_perturbed = icosphere(2), True
    only = build_history(decimate(mesh, CENTRE)).level(50)
    monkeypatch.setattr(trials, "run_stage", run_stage)
    with_trials(Trials(60, 1, 27))
    expected = build_history(decimate(mesh, CENTRE)).level(50)
    np.testing.assert_array_equal(only.vertices, expected.vertices)
    monkeypatch.setattr(trials, "run_stage", ends_early)
    blocks_perturbed = False
    with pytest.raises(DecimationError, match="triangles left"):
        decimate(mesh, CENTRE)


@pytest.mark.parametrize("cost", ["volume", "finest"])
def test_progress_advances_with_every_stage_and_trial(monkeypatch, with_trials, icosphere, cost):
    told, run_stage, progresses = [], trials.run_stage, []

    def kept(cost, size):
        progresses.append(progress_of(cost, size))
        return progresses[0]

    def looked_at(*arguments, **options):
        result = run_stage(*arguments, **options)
        told.append(progresses[0].fraction())
        return result

    monkeypatch.setattr(decimation, "progress_of", kept)
    monkeypatch.setattr(trials, "run_stage", looked_at)
    with_trials(Trials(60, 5, 27))
    decimate(icosphere(2), CENTRE, cost)
    # the stage before the trials, five trials, and the coarsest levels
    assert len(told) == 1 + 5 + 1
    assert (np.diff(told) > 0).all()
    assert told[-1] == pytest.approx(1)


@pytest.mark.slow
def test_progress_is_reported_in_order(icosphere):
    mesh, told = icosphere(4), []
    decimate(mesh, CENTRE, "finest", progress=told.append)
    assert told
    assert told == sorted(told)
    assert all(0 <= part <= 1 for part in told)


def test_perturbations_are_uniform_and_differ_between_trials():
    assert len(perturbation(600, 0)) == 0
    first, second = perturbation(10**5, 1), perturbation(10**5, 2)
    np.testing.assert_array_equal(first, perturbation(10**5, 1))
    np.testing.assert_array_equal(first[:600], perturbation(600, 1))
    assert 0 <= first.min() < first.max() < 1
    np.testing.assert_allclose(np.histogram(first, 10, (0, 1))[0], 10**4, rtol=0.05)
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.02
