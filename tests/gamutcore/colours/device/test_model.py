from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator, RegularGridInterpolator

from gamutcore.characterisation import characterisation
from gamutcore.colours.device.model import device_model
from gamutcore.colours.device.scattered_model import MAX_MODEL_SAMPLES
from gamutcore.colours.profile_colours import profile_colours
from gamutcore.errors import OptionError

N_LINEAR = "n-linear interpolation of a complete grid"
FITTED = "radial basis functions"


def grid(levels, channels):
    ticks = np.linspace(0, 1, levels)
    return np.stack(np.meshgrid(*[ticks] * channels, indexing="ij"), axis=-1).reshape(-1, channels)


def bent(device):
    light = device.mean(axis=1) ** 2.2
    ends = device[:, [0]] - device[:, [-1]]
    return np.column_stack([100 * light, 80 * ends**3, 60 * ends * light[:, np.newaxis]])


@pytest.mark.parametrize(
    ("levels", "channels"),
    [(2, 3), (3, 3), (5, 4), (9, 3), (17, 3), (20, 3), (9, 4), (3, 8), (2, 13)],
)
def test_complete_grids_are_interpolated_between_all_their_patches(levels, channels):
    device = grid(levels, channels)
    model = device_model(device, bent(device))
    assert model.provenance["name"] == N_LINEAR
    assert model.provenance["levels"] == [levels] * channels
    assert len(model.device) == levels**channels
    np.testing.assert_allclose(model.colours(device), bent(device), atol=1e-4)


@pytest.mark.parametrize("counts", [(3, 4, 5), (2, 3, 2, 4)])
def test_the_model_of_a_grid_is_scipys_n_linear_interpolation(counts):
    chance = np.random.default_rng(3)
    levels = [np.sort(chance.random(count)) for count in counts]
    device = np.stack(np.meshgrid(*levels, indexing="ij"), axis=-1).reshape(-1, len(counts))
    order = chance.permutation(len(device))
    model = device_model(device[order], bent(device)[order])
    reference = RegularGridInterpolator(levels, bent(device).reshape(*counts, 3))
    lowest, highest = device.min(axis=0), device.max(axis=0)
    points = lowest + chance.random((500, len(counts))) * (highest - lowest)
    np.testing.assert_allclose(model.colours(points), reference(points), atol=1e-4)


def test_one_patch_less_or_beside_and_samples_are_scattered():
    device = grid(5, 3)
    for samples in (device[1:], np.concatenate([device, [[0.1, 0.2, 0.3]]])):
        model = device_model(samples, bent(samples))
        assert model.provenance["name"] == FITTED
        assert device_model(samples, bent(samples), "fit").provenance == model.provenance
        with pytest.raises(OptionError, match=f"{len(samples)} distinct device values") as caught:
            device_model(samples, bent(samples), "interpolation")
        assert caught.value.where == {"field": "device_model"}


def test_one_device_value_is_neither_a_grid_nor_fitted():
    one = np.full((1, 4), 0.5)
    model = device_model(one, bent(one), "fit")
    assert model.colours is None
    assert "one distinct device value" in model.degenerate
    with pytest.raises(OptionError, match="one distinct device value") as caught:
        device_model(one, bent(one), "interpolation")
    assert caught.value.where == {"field": "device_model"}
    assert "two or more levels" in caught.value.remedy


def test_a_fit_of_a_grid_can_be_asked_for():
    """The fit equals SciPy's, and is more accurate on a coarse grid of a smooth device."""
    device = grid(5, 3)
    model = device_model(device, bent(device), "fit")
    assert model.provenance["name"] == FITTED
    points = np.random.default_rng(0).random((1000, 3))
    reference = RBFInterpolator(device, bent(device), kernel="cubic", smoothing=1e-3)
    np.testing.assert_allclose(model.colours(points), reference(points), atol=1e-6)
    interpolated = device_model(device, bent(device), "interpolation")
    assert interpolated.provenance["name"] == N_LINEAR

    def missed(some):
        return np.linalg.norm(some.colours(points) - bent(points), axis=1).mean()

    assert missed(model) < missed(interpolated) / 1.5
    (said,) = device_model(device, bent(device)).warnings
    assert "device_model 'fit'" in said


@pytest.mark.slow
def test_a_fit_of_a_large_grid_is_of_some_of_its_patches():
    device = grid(9, 4)
    model = device_model(device, bent(device), "fit")
    assert model.provenance["name"] == FITTED
    assert len(model.device) == MAX_MODEL_SAMPLES < len(device)


def test_what_a_fit_is_estimated_to_miss_stands_beside_the_grids_own_estimate():
    device = grid(5, 3)
    told = device_model(device, bent(device)).provenance["fit"]["leave_out_error"]
    fitted = device_model(device, bent(device), "fit").provenance["leave_out_error"]
    assert told == fitted
    # That costs as much as the fit itself, so it is for small grids only.
    large = grid(13, 3)
    assert "fit" not in device_model(large, bent(large)).provenance


@pytest.mark.parametrize("levels", [3, 5, 9])
def test_a_device_that_interpolation_follows_is_not_warned_of(levels):
    device = grid(levels, 3)
    straight = device @ np.array([[30.0, 60, 20], [40, -70, 30], [30, 10, -50]])
    model = device_model(device, straight)
    assert model.mean_error < 1e-4
    assert model.warnings == ()


def test_the_error_of_two_levels_is_not_known():
    device = grid(2, 3)
    model = device_model(device, bent(device))
    assert model.provenance["leave_out_error"] is None
    assert len(model.warnings) == 1


def test_kinks_at_levels_are_followed():
    """Lights that clip at three quarters: colours are linear between the levels.

    Smooth functions swing around the kink.
    """

    def clipped(device):
        return 100 * np.minimum(device / 0.75, 1.0)

    device = grid(9, 3)
    model = device_model(device, clipped(device))
    assert model.provenance["name"] == N_LINEAR
    assert model.provenance["leave_out_error"]["mean"] < 1e-4
    points = np.random.default_rng(0).random((1000, 3))
    np.testing.assert_allclose(model.colours(points), clipped(points), atol=1e-4)


@pytest.mark.parametrize(
    ("name", "levels", "bound"),
    [("display/Acer_XB271HU.icc", 17, 0.25), ("press/ISOcoated_v2_300_bas.icc", 9, 0.25)],
)
def test_grids_of_real_devices_at_their_surface(shared_data, uniform_surface, name, levels, bound):
    """The error is hardly visible, and smaller than the estimate."""
    profile = characterisation((shared_data / name).read_bytes())
    channels = len(profile.channels)

    def colours(values):
        return profile_colours(profile, values, "relative").lab

    device = grid(levels, channels)
    model = device_model(device, colours(device))
    assert model.provenance["name"] == N_LINEAR
    surface = uniform_surface(channels, 24)[::7]
    errors = np.linalg.norm(model.colours(surface) - colours(surface), axis=1)
    assert errors.mean() < bound
    assert errors.mean() < model.mean_error
