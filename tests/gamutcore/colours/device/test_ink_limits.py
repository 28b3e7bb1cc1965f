import json

import numpy as np
import pytest

from gamutcore.characterisation import characterisation
from gamutcore.colours import InkLimits, surface_colours
from gamutcore.colours.device.ink_limits import limited_cube
from gamutcore.errors import OptionError

CMYK = ("C", "M", "Y", "K")


def limited(channels=CMYK, lowest=None, highest=None, *, inks=True, **limits):
    count = len(channels)
    low = np.zeros(count) if lowest is None else np.array(lowest)
    high = np.ones(count) if highest is None else np.array(highest)
    return limited_cube(channels, low, high, InkLimits(**limits), inks=inks)


@pytest.mark.parametrize("name", ["K", "Black", " black ", "Schwarz"])
def test_a_black_limit_shortens_black(name):
    found = limited(("Cyan", name, "Orange"), black=40)
    np.testing.assert_allclose(found.cube.highest, [1, 0.4, 1])


def test_inks_that_never_vary_count_towards_the_limit():
    found = limited(("C", "M", "Y"), [0, 0, 0.5], [1, 1, 0.5], total=200)
    assert found.cube.total == pytest.approx(1.5)


def test_a_limit_below_one_ink_shortens_all():
    found = limited(("C", "M", "Y"), total=50)
    np.testing.assert_allclose(found.cube.highest, 0.5)


def test_black_has_to_be_known():
    with pytest.raises(OptionError, match="black") as caught:
        limited(("1", "2", "3"), black=90)
    assert caught.value.where == {"field": "black_limit"}


@pytest.mark.parametrize("limits", [{"total": 10}, {"black": 5}])
def test_something_has_to_be_left(limits):
    with pytest.raises(OptionError):
        limited(CMYK, [0.1] * 4, [1.0] * 4, **limits)


def press(*, columns="CMYK_C CMYK_M CMYK_Y CMYK_K LAB_L LAB_A LAB_B"):
    levels = np.linspace(0, 100, 4)
    device = np.stack(np.meshgrid(*[levels] * 4), axis=-1).reshape(-1, 4)
    lab = np.column_stack(
        [100 - device @ [0.2, 0.25, 0.1, 0.4], device[:, :2] @ [-0.3, 0.6], device[:, 2] * 0.8]
    )
    document = {"columns": columns.split(), "samples": np.column_stack([device, lab]).tolist()}
    return characterisation(json.dumps(document).encode())


@pytest.mark.parametrize("samples", [50, 500, 5000])
@pytest.mark.parametrize(("total", "black"), [(300, None), (240, 80), (None, 50), (150, 0)])
def test_a_press_keeps_to_its_limits(samples, total, black):
    surface = surface_colours(press(), surface_samples=samples, limits=InkLimits(total, black))
    device = surface.device
    assert device.sum(axis=1).max() <= (total or 400) / 100 + 1e-9
    assert device[:, 3].max() <= (black if black is not None else 100) / 100 + 1e-9
    assert surface.provenance["ink_limits"] == {"total": total, "black": black}
    if total is not None:
        # The cut's own faces, where three or more inks share the limit, are sampled as well.
        on_cut = np.abs(device.sum(axis=1) - total / 100) < 1e-6
        assert on_cut.sum() >= 6
        if samples == 5000:
            between = ((device > 1e-6) & (device < 1 - 1e-6)).sum(axis=1)
            assert (between[on_cut] >= 3).any()


@pytest.mark.parametrize(
    ("columns", "rows"),
    [
        ("R G B L a b", [[0, 0, 0, 0, 0, 0], [1, 1, 1, 90, 0, 0]]),
        ("CMYK_C CMYK_M CMYK_Y CMYK_K L a b", [[0, 0, 0, 0, 90, 0, 0]]),
    ],
)
def test_limits_are_refused_where_there_is_no_model_of_inks(columns, rows):
    document = {"columns": columns.split(), "samples": rows}
    data = characterisation(json.dumps(document).encode())
    with pytest.raises(OptionError) as caught:
        surface_colours(data, limits=InkLimits(300))
    assert caught.value.where == {"field": "ink_limit"}


def test_profiles_of_lights_refuse_limits(small_profile):
    profile = characterisation(small_profile("sRGB-v4.icc"))
    with pytest.raises(OptionError):
        surface_colours(profile, limits=InkLimits(300))
