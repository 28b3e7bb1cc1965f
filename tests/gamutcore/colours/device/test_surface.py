from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.boundary import compute_boundary
from gamutcore.characterisation import characterisation
from gamutcore.colours.device.cube_surface import cube_surface, surface_steps
from gamutcore.colours.device.ink_cube import InkCube, surface_corners
from gamutcore.colours.device.surface import device_surface, distinct_rows
from gamutcore.colours.profile_colours import profile_colours
from gamutcore.metric import radial_difference


def unit(channels, total=None):
    return InkCube(np.zeros(channels), np.ones(channels), total)


def bent(device):
    """Colours with the largest curvature at low values of the first channel."""
    a, b, c = (device[:, i % device.shape[1]] for i in range(3))
    return np.column_stack(
        [50 + 40 * a**0.3, 60 * (a**0.3 - b), 60 * (b - c) + 10 * device.sum(axis=1)]
    )


@given(
    st.integers(1, 6),
    st.integers(8, 4000),
    st.one_of(st.none(), st.floats(0.1, 6)),
)
def test_points_are_on_the_surface_and_no_more_than_asked_for(channels, wanted, total):
    cube = unit(channels, total)
    surface = device_surface(cube, bent, wanted)
    device = surface.device
    assert device.min() >= -1e-9
    assert device.max() <= 1 + 1e-9
    assert len(device) <= max(wanted, len(surface_corners(cube)))
    if total is not None:
        assert device.sum(axis=1).max() <= total + 1e-6
    ends = ((device < 1e-6) | (device > 1 - 1e-6)).sum(axis=1)
    if total is not None and channels > 1:
        ends += np.abs(device.sum(axis=1) - total) < 1e-6
    assert (ends >= channels - 2).all()


@pytest.mark.parametrize(("channels", "total"), [(3, None), (4, None), (4, 2.5), (5, None)])
def test_nearly_as_many_as_asked_for_each_once(channels, total):
    surface = device_surface(unit(channels, total), bent, 20_000)
    assert surface.density == "by curvature"
    assert 0.95 * 20_000 <= len(surface.device) <= 20_000
    if total is None:
        assert len(np.unique(surface.device.round(12), axis=0)) == len(surface.device)


@pytest.mark.parametrize("total", [None, 1.5])
def test_all_corners_are_there(total):
    cube = unit(3, total)
    found = {tuple(row) for row in device_surface(cube, bent, 5000).device.round(6)}
    assert {tuple(row) for row in surface_corners(cube).round(6)} <= found


def test_points_are_denser_where_colours_curve():
    device = device_surface(unit(3), bent, 20_000).device
    assert (device[:, 0] < 0.25).sum() > 2 * (device[:, 0] > 0.75).sum() / 1.5


def test_flat_colours_are_sampled_evenly():
    def flat(device):
        return device @ np.array([[40.0, 10, 0], [30, -50, 20], [20, 30, -60]])

    device = device_surface(unit(3), flat, 20_000).device
    for values in device.T:
        counts, _ = np.histogram(values, bins=4, range=(0.01, 0.99))
        assert counts.max() < 1.25 * counts.min()


def test_nodes_of_the_model_are_among_the_points():
    nodes = np.tile([0.0, 0.13, 0.4, 1.0], (3, 1))
    device = device_surface(unit(3), bent, 20_000, nodes).device
    for i in range(3):
        assert {0.13, 0.4} <= set(device[:, i].round(9))


def test_few_points_for_many_inks():
    assert device_surface(unit(15), bent, 1000).density == "corners"
    assert len(device_surface(unit(15), bent, 1000).device) == 2**15
    assert device_surface(unit(7), bent, 2000).density == "uniform"
    assert device_surface(unit(7, 3.0), bent, 2000).device.sum(axis=1).max() <= 3 + 1e-9


def test_reruns_are_identical():
    first, second = (device_surface(unit(4, 3.1), bent, 5000).device for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(
    ("file", "points", "gain"),
    [
        # docs/decisions/surface-sampling.md: 0.53, 0.62, 0.42, 0.97 and 0.72 of the mismatch of
        # uniform points, against a denser reference than this one.
        ("press/ISOcoated_v2_300_bas.icc", 20_000, 0.75),
        ("oracle/SWOP2013C3_CRPC5.icc", 20_000, 0.85),
        ("oracle/Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc", 20_000, 0.7),
        ("display/Acer_XB271HU.icc", 20_000, 1.0),
        ("spaces/sRGB-v4.icc", 20_000, 0.85),
    ],
)
@pytest.mark.slow
def test_more_accurate_than_as_many_uniform_points(shared_data, file, points, gain):
    profile = characterisation((shared_data / file).read_bytes())
    channels = len(profile.channels)

    def colours(device):
        return profile_colours(profile, device, "relative").lab

    def boundary(device, centre="auto"):
        return compute_boundary(colours(device), "modified-convex-hull", centre, gamma=0.2)

    dense = 3_000_000 if channels > 4 else 800_000
    reference = boundary(cube_surface(channels, surface_steps(channels, dense)))
    centre = tuple(reference.centre)
    nodes = profile.transform("relative")[0].nodes
    uniform = cube_surface(channels, surface_steps(channels, points))
    shared_out = device_surface(unit(channels), colours, points, nodes).device
    assert len(shared_out) <= points
    errors = [
        radial_difference(reference.mesh, boundary(device, centre).mesh, centre).difference
        for device in (uniform, shared_out)
    ]
    assert errors[1] < gain * errors[0]


@given(
    st.integers(1, 15).flatmap(
        lambda columns: st.lists(
            st.lists(
                st.sampled_from([0.0, 0.1, 0.25, 0.5, 1.0]), min_size=columns, max_size=columns
            ),
            min_size=1,
            max_size=60,
        )
    )
)
def test_distinct_rows_are_those_of_numpy(rows):
    distinct, places = distinct_rows(np.array(rows))
    expected, inverse = np.unique(np.array(rows), axis=0, return_inverse=True)
    np.testing.assert_array_equal(distinct, expected)
    np.testing.assert_array_equal(places, inverse.reshape(-1))


def test_rows_that_are_not_told_apart_at_once_are_distinct(monkeypatch):
    """With factors for the first column only, rows with equal first columns collide."""

    class Chance:
        def integers(self, *_limits, size, dtype):
            return np.full(size, 2**63, dtype)  # doubled, that is nothing: all factors are 1

    rows = np.array([[0.5, 1.0], [1.0, 0.5], [0.5, 1.0], [0.25, 0.25]])  # two of equal sums
    monkeypatch.setattr(np.random, "default_rng", lambda _seed: Chance())
    distinct, places = distinct_rows(rows)
    np.testing.assert_array_equal(distinct, [[0.25, 0.25], [0.5, 1.0], [1.0, 0.5]])
    np.testing.assert_array_equal(places, [1, 2, 1, 0])


@pytest.mark.parametrize(("channels", "total"), [(11, 5.5), (12, 6.0), (13, 3.25)])
@pytest.mark.slow
def test_the_cut_of_many_inks_is_sampled_at_its_corners_and_on_its_faces(channels, total):
    """Half a million corners of trapezoids that share vertices and edges."""
    surface = device_surface(unit(channels, total), bent, 100_000)
    device = surface.device
    assert surface.density == "uniform"
    assert len(device) <= 100_000
    assert device.sum(axis=1).max() <= total + 1e-9
    # Two-dimensional faces: of the cube's, or of the plane's, where three channels may vary.
    inner = ((device > 1e-9) & (device < 1 - 1e-9)).sum(axis=1)
    on_plane = np.abs(device.sum(axis=1) - total) < 1e-9
    assert (inner <= np.where(on_plane, 3, 2)).all()
    corners = {tuple(row) for row in np.round(surface_corners(unit(channels, total)), 9).tolist()}
    assert corners <= {tuple(row) for row in np.round(device, 9).tolist()}
