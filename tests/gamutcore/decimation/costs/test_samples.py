"""Samples of a surface: their weights, their number, and their transfer to other surfaces."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.decimation.costs.sample_assignment import assign_samples
from gamutcore.decimation.costs.samples import (
    SAMPLES,
    TOP,
    deviation_on_faces,
    empty_deviation,
    sample_capacity,
    take_samples,
)


def six_volumes(positions, faces):
    return np.linalg.det(positions[faces])


@settings(max_examples=20)
@given(seed=st.integers(0, 10**6), wanted=st.integers(1, 3000))
def test_no_sample_has_much_more_than_the_wanted_share(
    bumpy_mesh, surface_from, samples_in, seed, wanted
):
    """Each face has a sample. Faces of several shares have about as many samples."""
    positions, faces = bumpy_mesh(seed)
    room = sample_capacity(wanted, len(faces))
    deviation = empty_deviation(room, len(faces))
    take_samples(deviation, surface_from(positions, faces), wanted)
    assign_samples(deviation, surface_from(positions, faces))
    volumes = six_volumes(positions, faces)
    share = volumes.sum() / wanted
    for face, volume in enumerate(volumes):
        samples = samples_in(deviation, face)
        assert samples
        weights = deviation.weight[samples]
        assert weights.sum() == pytest.approx(volume, rel=1e-12)
        assert np.ptp(weights) == 0
        assert weights[0] <= 1.5**2 * share * (1 + 1e-12)
        if volume > 1.5**2 * share:
            assert weights[0] > share / 1.5**2
    assert deviation.counts[SAMPLES] <= room


def test_sums_over_samples_integrate_linear_functions(bumpy_mesh, surface_from, points_of):
    """Exactly, over the solid, for functions that are linear in the radius (Gauss' rule)."""
    positions, faces = bumpy_mesh(5)
    surface = surface_from(positions, faces)
    deviation = empty_deviation(len(faces) + 1, len(faces))
    take_samples(deviation, surface, 1)
    assign_samples(deviation, surface)
    assert deviation.counts[SAMPLES] == len(faces)
    points = points_of(deviation, slice(len(faces)))
    volumes = six_volumes(positions, faces)
    for form in ([1, 0, 0], [0, 1, 1], [1, -2, 3]):
        exact = (volumes * (positions[faces] @ form).mean(axis=1)).sum()
        summed = deviation.weight[: len(faces)] @ (points @ form)
        assert summed == pytest.approx(exact, rel=1e-10, abs=1e-10 * volumes.sum())


@settings(max_examples=20)
@given(seed=st.integers(0, 10**6), part=st.floats(0.05, 0.95))
@pytest.mark.slow
def test_without_room_half_as_many_samples_have_equal_shares(bumpy_mesh, surface_from, seed, part):
    positions, faces = bumpy_mesh(seed)
    surface = surface_from(positions, faces)
    whole = empty_deviation(sample_capacity(2000, len(faces)), len(faces))
    take_samples(whole, surface, 2000)
    assign_samples(whole, surface)
    all_of_them = int(whole.counts[SAMPLES])
    room = int(part * all_of_them)
    chosen = empty_deviation(room, len(faces))
    take_samples(chosen, surface, 2000)
    assign_samples(chosen, surface)
    count = int(chosen.counts[SAMPLES])
    assert count <= room // 2
    share = six_volumes(positions, faces).sum() / (room // 2)
    marks = chosen.weight[:count] / share
    np.testing.assert_allclose(marks, np.rint(marks), rtol=1e-9)
    # a subset of all samples, in the same order
    rows = np.stack([whole.x, whole.y, whole.z], axis=1)[:all_of_them].tolist()
    found = [
        rows.index(row) for row in np.stack([chosen.x, chosen.y, chosen.z], 1)[:count].tolist()
    ]
    assert found == sorted(set(found))
    # no face differs from its volume by more than a share
    weights = [chosen.weight[b:e].sum() for b, e in zip(chosen.begin, chosen.end, strict=True)]
    assert np.abs(weights - six_volumes(positions, faces)).max() <= share * (1 + 1e-9)


def test_samples_are_transferred_in_the_order_of_their_faces(bumpy_mesh, surface_from, all_samples):
    positions, faces = bumpy_mesh(8)
    deviation, surface = empty_deviation(2000, len(faces)), surface_from(positions, faces)
    take_samples(deviation, surface, 500)
    assign_samples(deviation, surface)
    # the samples of other faces have been reassigned
    gone = np.setdiff1d(np.arange(len(faces)), np.arange(1, len(faces), 3))
    deviation.begin[gone] = deviation.end[gone] = 0
    kept = all_samples(deviation)
    deviation.counts[SAMPLES] = len(kept)
    other = deviation_on_faces(deviation, len(faces) // 3)
    assert other.counts[SAMPLES] == len(kept)
    assert other.counts[TOP] == 0
    assert len(other.begin) == len(faces) // 3
    for name in ("x", "y", "z", "weight"):
        np.testing.assert_array_equal(
            getattr(other, name)[: len(kept)], getattr(deviation, name)[kept]
        )


def test_unassigned_samples_are_transferred_unchanged(bumpy_mesh, surface_from):
    positions, faces = bumpy_mesh(8)
    deviation = empty_deviation(sample_capacity(500, len(faces)), len(faces))
    assert deviation_on_faces(deviation, 7).x.size == deviation.x.size
    take_samples(deviation, surface_from(positions, faces), 500)
    count = int(deviation.counts[SAMPLES])
    assert count > 400
    assert (deviation.end == 0).all()
    other = deviation_on_faces(deviation, 7)
    assert other.counts[SAMPLES] == count
    assert other.counts[TOP] == 0
    for name in ("x", "y", "z", "weight"):
        one, two = getattr(other, name), getattr(deviation, name)
        np.testing.assert_array_equal(one[:count], two[:count])
