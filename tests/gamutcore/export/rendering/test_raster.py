"""Filled triangles: areas, colours and depths that are known without a renderer."""

import time

import numpy as np
import pytest

from gamutcore.export.rendering import raster
from gamutcore.export.rendering.raster import rasterise


def triangle(*corners):
    return np.array([corners], np.float64)


def plain(colour, count=1):
    return np.broadcast_to(np.array(colour, np.float32), (count, 3, 3)).copy()


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_coverage_is_the_area(order):
    corners = triangle((3.3, 2.1, 0), (50.7, 8.4, 0), (20.2, 55.9, 0))[:, order]
    (a, b, c) = corners[0, :, :2]
    area = abs((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) / 2
    pixels = rasterise(corners, plain((1, 1, 1)), 64, 3)
    assert pixels[..., 3].sum() == pytest.approx(area, rel=2e-3)
    assert pixels[..., 0].sum() == pytest.approx(pixels[..., 3].sum())


def test_colours_are_interpolated_linearly():
    corners = triangle((0, 0, 0), (64, 0, 0), (0, 64, 0))
    colours = np.array([[(0, 0, 1), (1, 0, 1), (0, 1, 1)]], np.float32)
    pixels = rasterise(corners, colours, 64, 1)
    for row, column in ((0, 0), (10, 20), (30, 5)):
        expected = ((column + 0.5) / 64, (row + 0.5) / 64, 1, 1)
        np.testing.assert_allclose(pixels[row, column], expected, atol=1e-6)


@pytest.mark.parametrize("first", [0, 1])
def test_the_higher_of_two_is_seen(first):
    low = triangle((0, 0, 1), (64, 0, 1), (0, 64, 1))
    high = triangle((0, 0, 2), (64, 0, 0), (0, 64, 2))  # above and, at the right, below
    corners = np.concatenate([low, high])[[first, 1 - first]]
    colours = np.concatenate([plain((1, 0, 0)), plain((0, 1, 0))])[[first, 1 - first]]
    pixels = rasterise(corners, colours, 64, 1)
    assert pixels[5, 10, :3].tolist() == [0, 1, 0]
    assert pixels[5, 50, :3].tolist() == [1, 0, 0]


def test_neighbours_leave_no_gap():
    """A fan around a point covers a square once and everywhere."""
    turn = np.linspace(0, 2 * np.pi, 38)
    rim = 31 + 100 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    middle = np.full((37, 3), 31.37)
    corners = np.stack([middle, rim[:-1], rim[1:]], axis=1)
    assert (rasterise(corners, plain((1, 1, 1), 37), 64, 3)[..., 3] == 1).all()


def test_bands_do_not_change_the_picture(monkeypatch):
    rng = np.random.default_rng(5)
    corners, colours = rng.uniform(-10, 74, (50, 3, 3)), rng.random((50, 3, 3), np.float32)
    whole = rasterise(corners, colours, 64, 2)
    monkeypatch.setattr(raster, "BAND_SAMPLES", 64 * 4 * 5)
    np.testing.assert_array_equal(rasterise(corners, colours, 64, 2), whole)


def test_what_is_outside_or_flat_is_not_drawn():
    outside = triangle((-50, -50, 0), (-1, -50, 0), (-1, -1, 0))
    flat = triangle((3, 3, 0), (9, 9, 0), (30, 30, 0))
    pixels = rasterise(np.concatenate([outside, flat]), plain((1, 1, 1), 2), 32, 2)
    assert not pixels.any()


@pytest.mark.slow
def test_thin_triangles_take_time_by_their_rows_not_by_their_boxes():
    rng = np.random.default_rng(1)
    start, end = rng.uniform(0, 1024, (2, 20_000, 3))
    corners = np.stack([start, end, end + np.array([0.01, 0, 0])], axis=1)
    rasterise(corners[:1], plain((1, 1, 1)), 16, 3)  # compiled
    clock = time.perf_counter()
    rasterise(corners, plain((1, 1, 1), len(corners)), 1024, 3)
    # the boxes have 2 × 10¹⁰ samples, which would take a minute
    assert time.perf_counter() - clock < 15
