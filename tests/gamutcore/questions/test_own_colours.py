"""Colours of a device model, and measured patches, are in the device's gamut."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from gamutcore import Gamut, reference
from gamutcore.characterisation import IccProfile, Samples, read_characterisation
from gamutcore.colours import InkLimits, measured_colours, surface_colours
from gamutcore.colours.device_model import device_model
from gamutcore.colours.reference import reference_lab, reference_white, rgb_xyz
from gamutcore.references import REFERENCES
from tests.conftest import one_slow_rest_long

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

ROOT = Path(__file__).parents[3]
RGB_SPACES = [slug for slug, each in REFERENCES.items() if each.kind == "rgb"]
PRESSES = ["FOGRA39L.ti3", "FOGRA29L.ti3"]

CUBE = list(product((40, 60), (-10, 10), (-10, 10)))

LEVELS: tuple[dict[str, Any], ...] = ({}, {"max_error": 0.0}, {"triangles": 100})


def _edge_codes() -> FloatArray:
    """All 8-bit codes on the twelve edges of the cube of RGB."""
    ramp = np.arange(256) / 255.0
    edges = []
    for axis, ends in product(range(3), product((0.0, 1.0), repeat=2)):
        codes = np.empty((256, 3))
        codes[:, axis] = ramp
        codes[:, [other for other in range(3) if other != axis]] = ends
        edges.append(codes)
    return np.concatenate(edges)


def _face_values(count: int) -> FloatArray:
    """Random values on the six faces of the cube of RGB."""
    random = np.random.default_rng(31)
    values = random.random((count, 3))
    values[np.arange(count), random.integers(3, size=count)] = random.integers(2, size=count)
    return values


@pytest.mark.parametrize("slug", one_slow_rest_long(*RGB_SPACES))
def test_no_colour_of_an_rgb_space_is_outside(slug: str) -> None:
    gamut, space = reference(slug), REFERENCES[slug]
    values = np.concatenate([_edge_codes(), _face_values(100_000)])
    lab, _ = reference_lab(rgb_xyz(space, values), reference_white(space), "relative", "Bradford")
    assert gamut.contains(lab).all()
    assert gamut.contains(lab, max_error=0.0).all()
    if space.peak is None:  # white is at L* = 100
        assert gamut.description["boundary_error"] < 0.05  # a tenth of the hull's


@pytest.mark.parametrize(("name", "limit"), one_slow_rest_long(*product(PRESSES, (None, 300))))
def test_samples_are_outside_by_the_misfit_of_the_model_at_most(
    name: str, limit: int | None
) -> None:
    data = (ROOT / "examples" / name).read_bytes()
    limits = {} if limit is None else {"ink_limit": limit}
    gamut = Gamut(data, surface_samples=20_000, **limits)
    samples = read_characterisation(data)
    assert isinstance(samples, Samples)
    assert samples.device is not None
    lab = measured_colours(samples, "relative").lab
    # the mean of samples of the same device values, as in the build
    distinct, which = np.unique(samples.device, axis=0, return_inverse=True)
    which = which.reshape(-1)
    mean = np.zeros((len(distinct), 3))
    np.add.at(mean, which, lab)
    mean /= np.bincount(which)[:, np.newaxis]
    model = device_model(distinct, mean, None)
    assert model.function is not None
    misfit = np.linalg.norm(model.function.fitted(samples.device) - lab, axis=1)
    printable = samples.device.sum(axis=1) <= (limit or 400) / 100 + 1e-9
    assert printable.sum() > 500
    for level in LEVELS:
        distance = gamut.distance(lab, **level)
        assert (distance <= misfit + gamut.tolerance(**level))[printable].all()
        assert gamut.contains(lab[printable], **level).all()


def _device_values(channels: int, limit: float | None, count: int) -> FloatArray:
    """Random values within an ink limit in %: a half inside of the cube, a half on its faces."""
    random = np.random.default_rng(8)
    values = random.random((5 * count, channels))
    ends = random.integers(2, size=values.shape)
    values[::2] = np.where(random.random(values.shape) < 0.5, ends, values)[::2]
    printable: FloatArray = values[values.sum(axis=1) <= (limit or np.inf) / 100]
    assert len(printable) >= count
    return printable[:count]


@pytest.mark.parametrize(
    ("name", "limit"),
    one_slow_rest_long(
        ("display/phone_RGBW_LCD_602.txt", None),
        ("display/Acer_XB271HU.icc", None),
        ("press/TR002.ti3", None),
        ("press/TR002.ti3", 260),
        ("press/ISOcoated_v2_300_bas.icc", 300),
        ("oracle/Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc", 300),
    ),
)
def test_no_colour_of_a_device_is_outside(
    shared_data: Path, name: str, limit: float | None
) -> None:
    """Neither of the surface of the device's cube, nor of its inside."""
    path = shared_data / name
    limits = {} if limit is None else {"ink_limit": limit}
    gamut = Gamut(path, surface_samples=20_000, **limits)
    parsed = read_characterisation(path.read_bytes())
    assert isinstance(parsed, Samples | IccProfile)
    device = surface_colours(parsed, limits=InkLimits(limit), surface_samples=1000).device_colours
    assert device is not None
    lab = device.points(_device_values(len(device.cube.lowest), limit, 50_000))
    for level in LEVELS:
        assert gamut.contains(lab, **level).all()
    missed = gamut.description["boundary_error"]
    said = gamut.description["provenance"]["warnings"]
    assert any("outside of the full boundary" in each for each in said) == (missed > 0.25)


@pytest.mark.slow
def test_the_boundary_error_covers_colours_of_the_inside() -> None:
    """At the surface of this device's cube, a* is 30 at most; inside, it is larger.

    The device surface is raised to such colours; the hull of its points is not.
    """
    axis = np.arange(13) / 12
    x, y, z = (each.ravel() for each in np.meshgrid(axis, axis, axis, indexing="ij"))
    bulge = x + 8 * np.sin(np.pi * x) * y * (1 - y) * z * (1 - z)
    lab = np.column_stack([20 + 60 * y, 60 * bulge - 30, 60 * z - 30])
    rows = np.column_stack([x, y, z, lab])
    columns = ["RGB_R", "RGB_G", "RGB_B", "L", "a", "b"]
    data = json.dumps({"columns": columns, "samples": rows.tolist()}).encode()
    options: dict[str, Any] = {"intent": "absolute", "surface_samples": 2000}
    gamut = Gamut(data, boundary="modified-convex-hull", **options)
    assert gamut.description["boundary_error"] == pytest.approx(lab[:, 1].max() - 30, rel=1e-2)
    assert gamut.contains(lab).all()


@pytest.mark.slow
def test_colours_beyond_the_tolerance_are_outside() -> None:
    gamut = Gamut(ROOT / "examples/FOGRA39L.ti3", surface_samples=5000)
    for level in LEVELS:
        tolerance = gamut.tolerance(**level)
        found = gamut.level(gamut.nearest([50, 0, 0], **level).triangles)
        vertices = found.vertices.astype(np.float64)
        centre = np.array(gamut.description["centre"])
        outwards = (vertices - centre) / np.linalg.norm(vertices - centre, axis=1)[:, np.newaxis]
        moved = vertices + 20.0 * tolerance * outwards
        far = gamut.distance(moved, **level) > tolerance
        assert far.mean() > 0.9
        assert not gamut.contains(moved[far], **level).any()
        assert gamut.contains(moved[~far], **level).all()


def test_tolerance_is_the_sum_of_the_errors() -> None:
    gamut = Gamut(CUBE)
    corner = 3**0.5 / 2 * gamut.description["grid_step"]
    assert gamut.tolerance(max_error=0.0) == pytest.approx(
        corner + gamut.description["boundary_error"]
    )
    near = (50, 0, 10 + corner / 2)
    assert gamut.contains(near)
    assert not gamut.contains(near, tolerance=0)


def test_edge_width_is_separate_from_the_tolerance() -> None:
    gamut = Gamut(CUBE)
    colours = [(50, 0, b) for b in (8.5, 9.5, 10.5, 11.5)]
    assert gamut.classify(colours).tolist() == ["inside", "edge", "edge", "outside"]
    assert gamut.contains(colours).tolist() == [True, True, False, False]
    assert gamut.classify(colours, edge_width=2).tolist() == ["edge"] * 4
    assert gamut.classify(colours, edge_width=0).tolist() == ["inside"] * 2 + ["outside"] * 2
    assert gamut.classify(colours, tolerance=1).tolist() == ["inside", "edge", "edge", "outside"]
    assert gamut.contains(colours, tolerance=1).tolist() == [True, True, True, False]
