"""Boundaries of devices whose surface is known: bent cubes, smooth, folded and clipped."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gamutcore.boundary.wrapping import wrap_colours
from gamutcore.colours.ink_limits import InkCube
from gamutcore.colours.sampling import device_surface, outward_faces
from gamutcore.errors import CentreError
from gamutcore.geometry import faces_not_seeing_centre

SEEDS = st.integers(0, 2**32 - 1)
FEW = settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def smooth(seed, strength):
    """A map of the cube that is bent by waves, one to one for a small strength."""
    rng = np.random.default_rng(seed)
    waves, phases = rng.normal(size=(3, 3)), rng.uniform(0, 6, 3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]

    def colours(device):
        middle = device[:, :3] - 0.5
        return 100 * (middle + strength * np.sin(2 * middle @ waves + phases)) @ turn

    return colours


def wrapped(
    colours,
    count=4000,
    gamma="auto",
    centre="auto",
    channels=3,
    total=None,
    method="modified-convex-hull",
):
    cube = InkCube(np.zeros(channels), np.ones(channels), total)
    surface = device_surface(cube, colours, count)
    points = colours(surface.device)
    faces = outward_faces(points, surface.faces)
    parameters = {} if method == "device-surface" else {"gamma": gamma}
    return wrap_colours(points, faces, method, centre, parameters)


def cube_volume(colours, steps=150):
    """Volume within the image of the cube's six faces, by the divergence theorem."""
    axis = np.linspace(0, 1, steps + 1)
    one, two = np.meshgrid(axis, axis, indexing="ij")
    total = 0.0
    for fixed in range(3):
        for end in (0.0, 1.0):
            device = np.insert(np.stack([one.ravel(), two.ravel()], 1), fixed, end, axis=1)
            at = colours(device).reshape(steps + 1, steps + 1, 3)
            a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
            parts = np.einsum("ijk,ijk->", a, np.cross(b, c)) + np.einsum(
                "ijk,ijk->", a, np.cross(c, d)
            )
            total += parts * (1 if (end == 1) == (fixed != 1) else -1) / 6
    return abs(total)


@given(SEEDS)
@FEW
@pytest.mark.slow
def test_the_gamut_of_a_smooth_map_has_the_volume_of_its_cube(seed):
    colours = smooth(seed, 0.08)
    found = wrapped(colours, 20_000)
    exact = cube_volume(colours)
    assert found.choices["centre"]["from"] == "star-kernel"
    assert found.device_volume == pytest.approx(exact, rel=5e-4)
    assert found.boundary.mesh.volume == pytest.approx(exact, rel=1e-3)
    assert found.warnings == []


@given(SEEDS)
@FEW
@pytest.mark.slow
def test_the_gamut_of_a_folded_map_is_valid_and_says_what_is_hidden(seed):
    found = wrapped(smooth(seed, 0.5))
    mesh, centre = found.boundary.mesh, found.boundary.centre
    relative = np.ascontiguousarray(mesh.vertices - centre, np.float64)
    assert not faces_not_seeing_centre(relative, np.ascontiguousarray(mesh.faces)).size
    assert mesh.triangles == 2 * len(mesh.vertices) - 4
    chosen = found.choices["centre"]
    if chosen["from"] == "star-kernel":
        assert chosen["hidden_area"] == 0
        assert chosen["depth"] > 0
    difference = mesh.volume / found.device_volume - 1
    assert any("gamut is" in text for text in found.warnings) == (abs(difference) > 0.005)


@given(SEEDS)
@FEW
@pytest.mark.slow
def test_the_gamut_of_a_clipped_map_is_as_large_as_its_surface(seed):
    """Colours beyond a plane are moved into it, which makes whole areas of faces flat or equal."""
    bent = smooth(seed, 0.08)

    def colours(device):
        return np.clip(bent(device), -45.0, 45.0)

    found = wrapped(colours, 20_000)
    assert found.boundary.mesh.volume == pytest.approx(cube_volume(colours), rel=2e-3)


def ink(device):
    """Four inks on paper: colours multiply, and black darkens all."""
    transmitted = np.prod(
        1
        - device[:, :, np.newaxis]
        * np.array([(0.9, 0.3, 0.1), (0.2, 0.9, 0.3), (0.05, 0.1, 0.9), (0.93, 0.93, 0.93)]),
        axis=1,
    )
    return 100 * np.cbrt(transmitted)


@pytest.mark.parametrize("total", [None, 2.4])
def test_inks_get_a_larger_gamma_and_do_not_fall_into_inner_points(total):
    found = wrapped(ink, 20_000, channels=4, total=total)
    assert found.choices["gamma"] > 0.01
    assert found.boundary.mesh.volume == pytest.approx(found.device_volume, rel=2e-3)
    tiny = wrapped(ink, 20_000, 0.0005, channels=4, total=total)
    assert tiny.choices["gamma"] == 0.0005
    assert tiny.boundary.mesh.volume < 0.995 * found.device_volume
    assert "smaller than the device's sampled surface" in tiny.warnings[0]


def test_a_given_centre_is_kept_and_described():
    found = wrapped(smooth(1, 0.0), centre=(5.0, 0.0, 0.0))
    np.testing.assert_allclose(found.boundary.centre, (5, 0, 0), atol=1e-3)
    assert found.choices["centre"]["from"] == "the option centre"
    assert 45 < found.choices["centre"]["depth"] < 50


def test_scattered_points_get_the_gamma_of_the_paper():
    points = np.random.default_rng(0).normal(size=(500, 3))
    found = wrap_colours(points, None, "modified-convex-hull", "auto", {"gamma": "auto"})
    assert found.choices["gamma"] == 0.2
    assert found.choices["centre"]["from"] == "middle of the bounding box"
    assert found.choices["centre"]["depth"] > 0
    assert found.device_volume is None


def folded(device):
    """A cube that is folded in its middle: its surface is a box without a lid."""
    return 100 * np.column_stack([np.abs(device[:, 0] - 0.5), device[:, 1:3]])


@pytest.mark.parametrize("centre", ["auto", (25.0, 50.0, 50.0)])
def test_a_surface_that_is_no_boundary_leaves_the_hull_to_auto(centre):
    found = wrapped(folded, 500, centre=centre, method="auto")
    assert found.choices["method"] == "modified-convex-hull"
    mesh = found.boundary.mesh
    np.testing.assert_allclose(mesh.bounds, [(0, 0, 0), (50, 100, 100)], atol=1e-3)
    assert mesh.triangles == 2 * len(mesh.vertices) - 4
    assert "the device's surface cannot be the boundary: The centre [" in found.warnings[0]
    with pytest.raises(CentreError):
        wrapped(folded, 500, centre=centre, method="device-surface")


def test_a_centre_outside_of_the_hull_as_well_is_refused():
    with pytest.raises(CentreError, match="is not"):
        wrapped(folded, 500, centre=(60.0, 50.0, 50.0), method="auto")
