"""Folds inside of a device's cube are part of the boundary, with their own device values."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from gamutcore import Gamut, reference

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

pytestmark = pytest.mark.slow

AXIS = np.arange(13) / 12
FEW = AXIS[::2]


def bulging(values: FloatArray) -> FloatArray:
    """Colours whose a* is largest inside of the cube: 30 at its faces, but for their edges."""
    x, y, z = values.T
    bulge = x + 8 * np.sin(np.pi * x) * y * (1 - y) * z * (1 - z)
    return np.column_stack([20 + 60 * y, 60 * bulge - 30, 60 * z - 30])


def data(lab: FloatArray, values: FloatArray) -> bytes:
    columns = ["RGB_R", "RGB_G", "RGB_B", "L", "a", "b"]
    rows = np.column_stack([values, lab]).tolist()
    return json.dumps({"columns": columns, "samples": rows}).encode()


def grid(axis: FloatArray = AXIS) -> FloatArray:
    axes = np.meshgrid(axis, axis, axis, indexing="ij")
    return np.column_stack([each.ravel() for each in axes])


@pytest.fixture(scope="module")
def bulge() -> Gamut:
    options: dict[str, Any] = {"intent": "absolute", "surface_samples": 5000}
    return Gamut(data(bulging(grid()), grid()), **options)


def test_the_volume_is_that_of_the_bulge(bulge: Gamut) -> None:
    """Both columns along a* are linear between the nodes: the largest a* of each, integrated."""
    x = np.linspace(0.0, 1.0, 13)
    y, z = (each.ravel() for each in np.meshgrid(AXIS, AXIS, indexing="ij"))
    height = 8 * y * (1 - y) * z * (1 - z)
    most = (x + height[:, np.newaxis] * np.sin(np.pi * x)).max(axis=1).reshape(13, 13)
    expected = 60**3 * np.trapezoid(np.trapezoid(most, AXIS), AXIS)
    assert expected > 1.01 * 60**3
    assert bulge.volume == pytest.approx(expected, rel=2e-3)


def test_the_tolerance_is_hundredths(bulge: Gamut) -> None:
    assert bulge.description["boundary_error"] < 0.1
    values = np.random.default_rng(3).random((20_000, 3))
    corner = np.minimum((values * 12).astype(int), 11)
    share = values * 12 - corner
    lab = np.zeros((len(values), 3))
    for step in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(np.array(step), share, 1 - share), axis=1)
        lab += weight[:, np.newaxis] * bulging((corner + step) / 12)
    assert bulge.contains(lab, max_error=0).all()


def test_device_values_of_the_bulge_give_its_colours(bulge: Gamut) -> None:
    level = bulge.level(bulge.description["counts"]["triangles"])
    assert level.device is not None
    beyond = level.vertices[:, 1] > 30.5
    assert beyond.sum() > 50
    found = bulging(level.device.values[beyond])
    # the bulge is linear between nodes a twelfth apart: up to 0.6 below
    assert np.abs(found - level.vertices[beyond]).max() < 0.8


def test_measured_patches_are_in_gamut() -> None:
    """A patch that the fit misses counts; the residual is stated."""
    values = grid(FEW)
    lab = bulging(values)
    noisy = lab + np.random.default_rng(1).normal(0.0, 0.5, lab.shape)
    gamut = Gamut(data(noisy, values), intent="absolute", surface_samples=2000, device_model="fit")
    assert gamut.contains(noisy, max_error=0).all()
    residual = gamut.description["provenance"]["model"]["residual"]
    assert 0.05 < residual["mean"] < residual["largest"]
    assert gamut.distance(noisy, max_error=0).max() <= residual["largest"]


def test_sheets_that_are_crumpled_are_not_raised() -> None:
    """CAM16-UCS turns imaginary colours of ProPhoto near black inside out: 16 million crossings.

    The boundary stays as it is without folds, with an error that is said.
    """
    gamut = reference("prophoto-rgb", space="CAM16-UCS", surface_samples=2000)
    assert gamut.description["boundary_error"] > 1.0
    assert any("outside of the full" in each for each in gamut.conditions.build_warnings)
