from __future__ import annotations

import numpy as np
import pytest

from gamutcore.characterisation import characterisation
from gamutcore.colours.cube_surface import cube_surface
from gamutcore.colours.device_model import device_model
from gamutcore.colours.profile_colours import profile_colours

N_LINEAR = "n-linear interpolation of a complete grid"
FITTED = "radial basis functions"


def grid(levels, channels):
    ticks = np.linspace(0, 1, levels)
    return np.stack(np.meshgrid(*[ticks] * channels, indexing="ij"), axis=-1).reshape(-1, channels)


def bent(device):
    light = device.mean(axis=1) ** 2.2
    ends = device[:, [0]] - device[:, [-1]]
    return np.column_stack([100 * light, 80 * ends**3, 60 * ends * light[:, np.newaxis]])


@pytest.mark.parametrize(("levels", "channels"), [(20, 3), (9, 4), (3, 8), (2, 13)])
def test_no_patch_of_a_complete_grid_is_dropped(levels, channels):
    device = grid(levels, channels)
    model = device_model(device, bent(device))
    assert model.provenance["name"] == N_LINEAR
    assert model.provenance["levels"] == [levels] * channels
    assert len(model.device) == levels**channels
    np.testing.assert_allclose(model.colours(device), bent(device), atol=1e-4)


def test_the_choice_among_small_grids():
    for levels, name in ((3, FITTED), (9, FITTED), (17, N_LINEAR)):
        device = grid(levels, 3)
        assert device_model(device, bent(device)).provenance["name"] == name


def test_kinks_at_levels_are_followed():
    """Lights that clip at three quarters: between the levels of the clipped device nothing bends.

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
def test_grids_of_real_devices_at_their_surface(shared_data, name, levels, bound):
    """Hardly visible, and less than the estimate, which is on the safe side."""
    profile = characterisation((shared_data / name).read_bytes())
    channels = len(profile.channels)

    def colours(values):
        return profile_colours(profile, values, "relative").lab

    device = grid(levels, channels)
    model = device_model(device, colours(device))
    assert model.provenance["name"] == N_LINEAR
    surface = cube_surface(channels, 24)[::7]
    errors = np.linalg.norm(model.colours(surface) - colours(surface), axis=1)
    assert errors.mean() < bound
    assert errors.mean() < model.mean_error
