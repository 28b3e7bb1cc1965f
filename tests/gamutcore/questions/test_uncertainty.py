"""Intervals of volumes and comparisons: parts, words, and refusals."""

from __future__ import annotations

import re

import numpy as np
import pytest

from gamutcore import Gamut, reference
from gamutcore.errors import DeviceModelError, InvalidPointsError, OptionError


@pytest.fixture(autouse=True)
def few_draws(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw few errors of a coarse surface, which takes tenths of a second, in the fast tests."""
    if request.node.get_closest_marker("slow") is None:
        for name, value in (("DRAWS", 20), ("SURFACE_SAMPLES", 300), ("PIXELS", 48)):
            monkeypatch.setattr(f"gamutcore.questions.intervals.{name}", value)


def chart(seed: int = 0, noise: float = 0.0, scale: float = 1.0, patches: int = 40) -> bytes:
    """Return RGB patches of a display whose colours are curved functions of its values."""
    random = np.random.default_rng(1)
    corners = np.array([(r, g, b) for r in (0, 1) for g in (0, 1) for b in (0, 1)], float)
    device = np.vstack([corners, random.random((patches - 8, 3))])
    light = device**1.5
    lab = np.column_stack(
        [
            100.0 * (light @ [0.25, 0.65, 0.1]) ** 0.5,
            scale * (80.0 * (light[:, 0] - light[:, 1])),
            scale * (70.0 * (0.6 * light[:, 0] + 0.4 * light[:, 1] - light[:, 2])),
        ]
    )
    lab += np.random.default_rng(seed).normal(0.0, noise / 3.0**0.5, lab.shape)
    rows = "\n".join(
        " ".join(f"{value:.5f}" for value in (*(100.0 * values), *colour))
        for values, colour in zip(device, lab, strict=True)
    )
    return (
        "CGATS.17\nDEVICE_CLASS DISPLAY\nNUMBER_OF_FIELDS 6\nBEGIN_DATA_FORMAT\n"
        "RGB_R RGB_G RGB_B LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\n"
        f"NUMBER_OF_SETS {patches}\nBEGIN_DATA\n{rows}\nEND_DATA\n"
    ).encode()


@pytest.fixture(scope="module")
def display() -> Gamut:
    return Gamut(chart(), surface_samples=500)


def test_parts_add_up_and_are_kept_apart(display: Gamut) -> None:
    alone = display.uncertainty(noise=0.0)
    noisy = display.uncertainty(noise=0.5, instrument=0.5)
    assert alone.volume.noise == alone.volume.instrument == 0.0
    assert alone.volume.patches > 0.0
    parts = (noisy.volume.noise, noisy.volume.patches, noisy.volume.instrument)
    assert min(parts) > 0.0
    half = (noisy.volume.high - noisy.volume.low) / 2.0
    assert half == pytest.approx(np.linalg.norm(parts))
    assert noisy.volume.low < display.volume < noisy.volume.high


def test_the_interval_is_the_same_again(display: Gamut) -> None:
    assert display.uncertainty(0.3).volume == display.uncertainty(0.3).volume


def test_noise_of_twice_the_size_makes_twice_the_part(display: Gamut) -> None:
    small, large = (display.uncertainty(noise).relative.noise for noise in (0.1, 0.2))
    assert large == pytest.approx(2.0 * small, rel=0.05)


def test_a_second_reading_gives_the_noise() -> None:
    first, second = (Gamut(chart(seed, 0.4, patches=90), surface_samples=500) for seed in (1, 2))
    found = first.uncertainty(repeats=second)
    assert found.noise_from == "a second reading"
    # 90 patches: the noise that was added is known to 10 %
    assert found.noise == pytest.approx(0.4, rel=0.25)


def test_repeated_patches_give_the_noise() -> None:
    one, two = (chart(seed, 0.4, patches=90).decode() for seed in (1, 2))
    rows = two.partition("BEGIN_DATA\n")[2].partition("END_DATA")[0]
    head, _, tail = one.rpartition("END_DATA\n")
    both = (head + rows + "END_DATA\n" + tail).replace("SETS 90", "SETS 180")
    found = Gamut(both.encode(), surface_samples=500).uncertainty()
    assert found.noise_from == "repeated patches of the data"
    assert found.noise == pytest.approx(0.4, rel=0.25)


def test_unknown_noise_is_said(display: Gamut) -> None:
    found = display.uncertainty()
    assert found.noise is None
    assert any("noise of readings is not known" in warning for warning in found.warnings)


def test_a_difference_is_larger_than_the_interval(display: Gamut) -> None:
    smaller = Gamut(chart(scale=0.8), surface_samples=500)
    found = display.compare_with_interval(smaller, noise=0.1)
    # a* and b* of 0.8 times: the volume is 0.64 times as large
    assert found.larger.low < 1.0 / 0.64 - 1.0 < found.larger.high
    assert re.match(r"A is larger than B by 5[567]\.", found.summary[0])
    assert found.b_covers_a.low < 0.64 < found.b_covers_a.high
    turned = smaller.compare_with_interval(display, noise=0.1)
    assert re.match(r"B is larger than A by 5[567]\.", turned.summary[0])


def test_equal_gamuts_cannot_be_told_apart(display: Gamut) -> None:
    other = Gamut(chart(), surface_samples=500)
    found = display.compare_with_interval(other, noise=0.3)
    assert found.summary[0].startswith("A and B cannot be told apart by volume")
    # the same patches: their choice cancels, and the noise does not
    assert found.larger.patches == pytest.approx(0.0, abs=1e-9)
    assert found.larger.noise > 0.0


def test_the_error_of_one_instrument_cancels(display: Gamut) -> None:
    other = Gamut(chart(), surface_samples=500)
    apart, common = (
        display.compare_with_interval(other, noise=0.0, instrument=1.0, same_instrument=same)
        for same in (False, True)
    )
    assert common.larger.instrument < 1e-9 < apart.larger.instrument


def test_a_reference_counts_as_exact(display: Gamut) -> None:
    found = display.compare_with_interval(reference("sRGB", surface_samples=500), noise=0.3)
    assert found.patches == (40, None)
    assert "B counts as exact: it has no measured patches." in found.warnings


def test_gamuts_without_patches_are_refused() -> None:
    cube = [(light, a, b) for light in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    with pytest.raises(DeviceModelError, match="no measured patches"):
        Gamut(cube).uncertainty(0.3)


def test_too_few_patches_are_refused() -> None:
    with pytest.raises(InvalidPointsError, match="too few"):
        Gamut(chart(patches=12), surface_samples=200).uncertainty(0.3)


def test_noise_below_zero_is_refused(display: Gamut) -> None:
    with pytest.raises(OptionError):
        display.uncertainty(-1.0)


def test_few_patches_warn_in_comparisons(display: Gamut) -> None:
    warnings = display.compare(Gamut(chart(patches=90), surface_samples=500)).warnings
    assert [text for text in warnings if text.startswith("A: The volume rests on 40 patches")]
    assert not [text for text in warnings if text.startswith("B: The volume rests")]


@pytest.mark.slow
def test_intervals_contain_the_truth() -> None:
    from benchmarks.common import FOGRA39L
    from benchmarks.intervals import Press

    press = Press(FOGRA39L.read_bytes())
    experiments = [press.experiment(100, 0.3, seed) for seed in range(1000, 1006)]
    right = [one["low"] <= 0.0 <= one["high"] for one in experiments]
    # of 95 % intervals, fewer than 4 of 6 contain the truth once in 450 runs
    assert sum(right) >= 4
    assert max(one["high"] - one["low"] for one in experiments) < 0.2
