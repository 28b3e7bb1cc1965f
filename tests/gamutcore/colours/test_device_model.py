"""Device models: interpolation of complete grids, and fits to scattered samples."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator, RegularGridInterpolator
from threadpoolctl import threadpool_limits

from gamutcore.characterisation import Picture, read_characterisation
from gamutcore.colours import surface_colours
from gamutcore.colours.device_model import SMOOTHING, device_model, scattered_model
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
    np.testing.assert_allclose(model.function.fitted(device), bent(device), atol=1e-4)


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
    np.testing.assert_allclose(model.function.fitted(points), reference(points), atol=1e-4)


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
    assert model.function is None
    assert "one distinct device value" in model.degenerate
    with pytest.raises(OptionError, match="one distinct device value") as caught:
        device_model(one, bent(one), "interpolation")
    assert caught.value.where == {"field": "device_model"}
    assert "two or more levels" in caught.value.remedy


def test_levels_are_told_apart_beyond_rounding():
    device = grid(4, 3)
    noise = 1e-8 * np.random.default_rng(0).random(device.shape)
    assert device_model(device + noise, bent(device)).provenance["levels"] == [4, 4, 4]
    # As many as a grid of the same levels has, one of them twice within rounding.
    moved = device.copy()
    moved[20] = device[21] + 1e-9
    assert device_model(moved, bent(device)).provenance["name"] == FITTED


def test_the_error_is_that_at_the_nodes_left_out():
    """The error of linear interpolation of x² over steps of 2h is h² in the middle."""
    device = grid(9, 1)
    model = device_model(device, device**2 * [64.0, 0, 0])
    assert model.provenance["leave_out_error"]["mean"] == pytest.approx(1, abs=1e-5)
    # And a quarter of it between the nodes of the whole grid.
    middle = (device[1:] + device[:-1]) / 2
    errors = model.function.fitted(middle)[:, 0] - 64 * middle[:, 0] ** 2
    np.testing.assert_allclose(errors, 0.25, atol=1e-5)


def test_what_would_take_too_long_is_refused():
    model = device_model(grid(2, 13), np.zeros((8192, 3)))
    with pytest.raises(OptionError) as caught:
        model.function.fitted(np.full((100_000, 13), 0.5))
    assert caught.value.where == {"field": "surface_samples"}


def test_a_fit_of_a_grid_can_be_asked_for():
    """The fit equals SciPy's, and is more accurate on a coarse grid of a smooth device."""
    device = grid(5, 3)
    model = device_model(device, bent(device), "fit")
    assert model.provenance["name"] == FITTED
    points = np.random.default_rng(0).random((1000, 3))
    reference = RBFInterpolator(device, bent(device), kernel="cubic", smoothing=1e-3)
    np.testing.assert_allclose(model.function.fitted(points), reference(points), atol=1e-6)
    interpolated = device_model(device, bent(device), "interpolation")
    assert interpolated.provenance["name"] == N_LINEAR

    def missed(some):
        return np.linalg.norm(some.function.fitted(points) - bent(points), axis=1).mean()

    assert missed(model) < missed(interpolated) / 1.5
    (said,) = device_model(device, bent(device)).warnings
    assert "device_model 'fit'" in said


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
    np.testing.assert_allclose(model.function.fitted(points), clipped(points), atol=1e-4)


@pytest.mark.parametrize(
    ("name", "levels", "bound"),
    [("display/Acer_XB271HU.icc", 17, 0.25), ("press/ISOcoated_v2_300_bas.icc", 9, 0.25)],
)
def test_grids_of_real_devices_at_their_surface(shared_data, uniform_surface, name, levels, bound):
    """The error is hardly visible, and smaller than the estimate."""
    profile = read_characterisation((shared_data / name).read_bytes())
    channels = len(profile.channels)

    def colours(values):
        picture = Picture("tiff", "CMYK", values, np.ones(len(values), np.int64), profile)
        return surface_colours(picture).points

    device = grid(levels, channels)
    model = device_model(device, colours(device))
    assert model.provenance["name"] == N_LINEAR
    surface = uniform_surface(channels, 24)[::7]
    errors = np.linalg.norm(model.function.fitted(surface) - colours(surface), axis=1)
    assert errors.mean() < bound
    assert errors.mean() < model.mean_error


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


def test_held_out_patches_of_a_real_press(fogra39):
    # reference/characterisation.md: held-out ΔE76 of FOGRA39L by this method is 0.13 on average.
    samples = read_characterisation(fogra39)
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
