from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator
from threadpoolctl import threadpool_limits

from gamutcore.characterisation import characterisation
from gamutcore.colours.device.scattered_model import (
    SMOOTHING,
    DegenerateSamplesError,
    fill_cubed_distances,
    scattered_model,
)


def scattered(count, channels, seed=0):
    chance = np.random.default_rng(seed)
    device = chance.random((count, channels))
    colours = np.column_stack(
        [np.sin(device @ chance.normal(size=channels) * 2 + i) for i in range(3)]
    )
    return device, 50 * colours


@pytest.mark.parametrize(("count", "channels"), [(20, 1), (60, 2), (150, 3), (300, 4), (200, 7)])
def test_it_is_scipys_interpolator(count, channels):
    device, colours = scattered(count, channels)
    reference = RBFInterpolator(device, colours, kernel="cubic", smoothing=SMOOTHING)
    points = np.random.default_rng(1).random((500, channels))
    model = scattered_model(device, colours)
    np.testing.assert_allclose(model.colours(points), reference(points), atol=1e-6)


def test_leave_out_errors_are_those_of_refitted_models():
    device, colours = scattered(40, 3)
    model = scattered_model(device, colours)
    for i in range(len(device)):
        kept = np.arange(len(device)) != i
        predicted = scattered_model(device[kept], colours[kept]).colours(device[i : i + 1])[0]
        np.testing.assert_allclose(
            model.leave_out_errors[i], np.linalg.norm(predicted - colours[i]), rtol=1e-6
        )


def test_a_linear_device_is_met_exactly():
    device, _ = scattered(30, 4)
    colours = device @ np.arange(12).reshape(4, 3) + [1, 2, 3]
    model = scattered_model(device, colours)
    points = np.random.default_rng(2).random((10, 4))
    np.testing.assert_allclose(
        model.colours(points), points @ np.arange(12).reshape(4, 3) + [1, 2, 3]
    )
    np.testing.assert_allclose(model.leave_out_errors, 0, atol=1e-9)


def test_cubed_distances():
    points, centres = np.random.default_rng(3).random((2, 9, 4))
    out = np.empty((9, 9))
    fill_cubed_distances(points, np.ascontiguousarray(centres.T), out)
    expected = np.linalg.norm(points[:, np.newaxis] - centres, axis=2) ** 3
    np.testing.assert_allclose(out, expected)


@pytest.mark.parametrize(
    "device",
    [
        np.zeros((1, 3)),
        np.eye(3),
        np.repeat(np.linspace(0, 1, 50)[:, np.newaxis], 3, axis=1),
        np.column_stack([np.random.default_rng(0).random((50, 2)), np.full(50, 0.3)]),
    ],
)
def test_samples_that_do_not_spread_are_refused(device):
    with pytest.raises(DegenerateSamplesError):
        scattered_model(device, np.zeros((len(device), 3)))


def test_reruns_are_identical():
    device, colours = scattered(200, 4)
    points = np.random.default_rng(1).random((1000, 4))
    runs = [scattered_model(device, colours).colours(points) for _ in range(2)]
    np.testing.assert_array_equal(*runs)


def test_held_out_patches_of_a_real_press(fogra39):
    # reference/characterisation.md: held-out ΔE76 of FOGRA39L by this method is 0.13 on average.
    samples = characterisation(fogra39)
    device, first = np.unique(samples.device, axis=0, return_index=True)
    lab = samples.lab[first]
    held_out = np.random.default_rng(0).permutation(len(device)) % 10 == 0
    model = scattered_model(device[~held_out], lab[~held_out])
    errors = np.linalg.norm(model.colours(device[held_out]) - lab[held_out], axis=1)
    assert 0.1 < errors.mean() < 0.17
    assert scattered_model(device, lab).leave_out_errors.mean() == pytest.approx(0.13, abs=0.01)


@pytest.mark.slow
def test_the_fit_does_not_depend_on_the_number_of_blas_threads():
    """A rerun gives the same model, bit for bit, with any number of BLAS threads."""
    device, colours = scattered(1500, 4)
    fits = []
    for threads in (1, 2):
        with threadpool_limits(limits=threads, user_api="blas"):
            fits.append(scattered_model(device, colours))
    np.testing.assert_array_equal(fits[0].weights, fits[1].weights)
    np.testing.assert_array_equal(fits[0].linear, fits[1].linear)
