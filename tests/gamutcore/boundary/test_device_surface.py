"""Device surfaces of bent cubes: smooth ones, folded ones, clipped ones, and real devices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore import Gamut
from gamutcore.boundary import compute_boundary, device_surface_boundary, vertex_device_values
from gamutcore.colours.ink_limits import InkCube
from gamutcore.colours.sampling import device_surface, outward_faces
from gamutcore.decimation import decimate
from gamutcore.errors import CentreError, FlatPointsError, OptionError
from gamutcore.history import build_history
from tests.conftest import one_slow_rest_long

MIXTURES = np.array([[30.0, 60, 40], [45, -70, 50], [15, 20, -80], [-35, 10, 5], [-20, -15, 15]])
"""Colours of the single channels. Later ones darken, as inks do."""


def bent(device, strength, phase, top=np.inf):
    """A smooth map of device values to colours, which folds if it is bent strongly."""
    colours = 10.0 + device**1.5 @ MIXTURES[: device.shape[1]]
    waves = np.sin(4.0 * device[:, :3] + np.asarray(phase)) - np.sin(phase)
    bending = strength * 12.0 * waves[:, [1, 2, 0]] * device[:, :3]
    return np.minimum(colours + bending, top)


def sampled(channels, colours, samples, total=None):
    cube = InkCube(np.zeros(channels), np.ones(channels), total)
    surface = device_surface(cube, colours, samples)
    points = colours(surface.device)
    return points, surface.device, outward_faces(points, surface.faces)


def fibonacci(count):
    """Directions of equal solid angle."""
    index = np.arange(count) + 0.5
    polar, turn = 1 - 2 * index / count, np.pi * (1 + 5**0.5) * index
    ring = np.sqrt(1 - polar**2)
    return np.stack([polar, ring * np.cos(turn), ring * np.sin(turn)], axis=1)


def outermost(corners, directions):
    """Largest radius in each direction, by a test of each ray with each triangle."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    distances = (normals * corners[:, 0]).sum(axis=1)
    hit = np.broadcast_to(distances[:, np.newaxis] != 0, (len(corners), len(directions)))
    for i in range(3):
        sides = np.cross(corners[:, i], corners[:, (i + 1) % 3]) * np.sign(distances)[:, np.newaxis]
        hit = hit & (sides @ directions.T >= 0)
    slopes = np.where(hit, normals @ directions.T, np.inf)
    return (distances[:, np.newaxis] / slopes).max(axis=0)


def volume_error(boundary, points, corners):
    """Mean difference of the cubes of radii from those of the outermost faces, and their mean."""
    directions = fibonacci(200)
    expected = outermost((points - boundary.centre)[corners], directions) ** 3
    mesh = boundary.mesh
    found = outermost((mesh.vertices - boundary.centre)[mesh.faces], directions) ** 3
    return np.abs(found - expected).mean() / expected.mean()


PHASES = st.tuples(*[st.floats(0, 6)] * 3)


@settings(max_examples=15)
@given(st.integers(3, 5), st.floats(0, 1.2), PHASES, st.one_of(st.just(np.inf), st.floats(60, 90)))
@pytest.mark.slow
def test_bent_cubes_have_the_radii_of_their_outermost_faces(channels, strength, phase, top):
    def colours(values):
        return bent(values, strength, phase, top)

    points, device, faces = sampled(channels, colours, 1500 * (channels - 2))
    boundary = device_surface_boundary(points, faces)
    mesh = boundary.mesh
    assert mesh.validity(boundary.centre).is_gamut
    assert mesh.vertices.dtype == np.float32
    assert volume_error(boundary, points, faces.corners) < 0.02
    values = vertex_device_values(boundary, points, device, tuple("ABCDE"[:channels])).values
    own = boundary.sources >= 0
    np.testing.assert_array_equal(values[own], device[boundary.sources[own]])
    # a vertex between two points is on an edge of a flat face of the cube, and so are its values
    distances = np.linalg.norm(colours(values) - mesh.vertices, axis=1)
    assert np.median(distances) < 0.1


@settings(max_examples=30)
@given(st.floats(0, 0.1), PHASES)
@pytest.mark.slow
def test_smooth_cubes_are_taken_as_they_are(strength, phase):
    points, _, faces = sampled(3, lambda values: bent(values, strength, phase), 2000)
    boundary = device_surface_boundary(points, faces)
    assert (boundary.sources >= 0).all()
    assert boundary.mesh.triangles == len(faces.corners)
    corners = points[faces.corners]
    exact = np.linalg.det(corners - boundary.centre).sum() / 6
    assert boundary.mesh.volume == pytest.approx(exact, rel=1e-4)


@settings(max_examples=10)
@given(st.floats(1.8, 3.9), PHASES)
@pytest.mark.slow
def test_inks_with_a_limit_have_the_limit_as_a_face(total, phase):
    def colours(values):
        return bent(values, 0.3, phase)

    points, device, faces = sampled(4, colours, 2000, total)
    boundary = device_surface_boundary(points, faces)
    assert boundary.mesh.validity(boundary.centre).is_gamut
    values = vertex_device_values(boundary, points, device, tuple("CMYK")).values
    assert values.sum(axis=1).max() <= total + 1e-9
    assert volume_error(boundary, points, faces.corners) < 0.01


@settings(max_examples=10)
@given(st.integers(3, 4), st.floats(0, 1.2), PHASES)
@pytest.mark.slow
def test_all_levels_are_valid_down_to_four_triangles(channels, strength, phase):
    points, device, faces = sampled(channels, lambda values: bent(values, strength, phase), 600)
    boundary = device_surface_boundary(points, faces)
    values = vertex_device_values(boundary, points, device, tuple("ABCD"[:channels]))
    history = build_history(decimate(boundary.mesh, boundary.centre, "volume"), values)
    assert history.triangles == boundary.mesh.triangles
    for triangles in (4, 6, 50, 300, history.triangles):
        mesh = history.level(min(triangles, history.triangles))
        assert mesh.validity(boundary.centre).is_gamut
        assert mesh.volume == pytest.approx(boundary.mesh.volume, rel=1e-4)


def test_a_requested_centre_is_used():
    points, _, faces = sampled(3, lambda values: bent(values, 0.2, (1, 2, 3)), 2000)
    middle = points.mean(axis=0) + np.array([3, 4, -2])
    boundary = device_surface_boundary(points, faces, middle)
    np.testing.assert_allclose(boundary.centre, middle, atol=1e-3)
    assert boundary.mesh.validity(boundary.centre).is_gamut


def test_a_centre_outside_is_refused():
    points, _, faces = sampled(3, lambda values: bent(values, 0.2, (1, 2, 3)), 2000)
    with pytest.raises(CentreError) as error:
        device_surface_boundary(points, faces, points.max(axis=0) - 1e-2)
    assert error.value.where == {"field": "centre"}


def test_flat_colours_are_refused():
    points, _, faces = sampled(3, lambda values: values @ [[1.0, 2, 0], [3, -1, 0], [2, 5, 0]], 200)
    with pytest.raises(FlatPointsError):
        device_surface_boundary(points, faces)


def test_data_without_a_device_is_refused():
    with pytest.raises(OptionError) as error:
        compute_boundary(np.random.default_rng(1).normal(size=(50, 3)), "device-surface")
    assert error.value.where == {"field": "boundary"}
    assert "device values" in error.value.remedy


@pytest.mark.parametrize(
    "table",
    [
        "LAB_L,LAB_A,LAB_B\n0,0,0\n100,0,0\n50,60,0\n50,-60,50\n50,-60,-50\n",
        "RGB_R,RGB_G,RGB_B,LAB_L,LAB_A,LAB_B\n0,0,0,0,0,0\n1,1,1,9,0,0\n1,0,0,5,6,0\n0,1,0,5,-6,5",
    ],
)
def test_a_build_without_a_device_model_is_refused(table):
    with pytest.raises(OptionError) as error:
        Gamut(table.encode(), {"boundary": "device-surface"})
    assert error.value.where == {"field": "boundary"}


@pytest.mark.parametrize(
    ("file", "options"),
    one_slow_rest_long(
        ("press/FOGRA39L.ti3", {"ink_limit": 250}),
        ("press/FOGRA39L.ti3", {}),
        ("press/TR002.ti3", {}),
        ("press/ISOcoated_v2_300_bas.icc", {"ink_limit": 300, "black_limit": 80}),
        ("display/phone_RGBW_LCD_602.txt", {}),
        ("display/Acer_XB271HU.icc", {}),
        ("display/Panasonic-TV_2014.icc", {"space": "CAM16-UCS"}),
        ("display/Canon_projector.icc", {}),
        ("oracle/Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc", {}),
    ),
)
def test_real_devices(shared_data, file, options):
    """Valid, and the volume of five times as many points, measured with other rays."""
    data = (shared_data / file).read_bytes()
    samples = 4000 if file.endswith(".ti3") else 20_000
    gamut = Gamut(data, {"boundary": "device-surface", "surface_samples": samples, **options})
    centre = gamut.description["centre"]
    full = gamut.level(gamut.history.triangles)
    assert full.validity(centre).is_gamut
    for triangles in (4, 100, 1000):
        assert gamut.level(triangles).validity(centre).is_gamut
    assert gamut.level(1000).device is not None
    dense = Gamut(data, {"boundary": "device-surface", "surface_samples": 5 * samples, **options})
    # seven inks have 672 faces, for which 20,000 points are few
    tolerance = 1e-2 if "FOGRA55" in file else 1e-3
    assert gamut.description["volume"] == pytest.approx(dense.description["volume"], rel=tolerance)
