"""Rendered pictures: areas, colours and depths that are known without a renderer."""

import io

import numpy as np
import pytest
from PIL import Image

from gamutcore.colours.spaces import SPACES, ColourSpace, linear_srgb
from gamutcore.errors import OptionError
from gamutcore.export.rendering import (
    VIEWS,
    camera,
    mesh_picture,
    rasterise,
    scene_triangles,
)
from gamutcore.geometry import TriangleMesh


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


def test_views_are_what_their_names_say():
    a, b, lightness = np.eye(3)
    for name, right, up in (
        ("front", a, lightness),
        ("right", b, lightness),
        ("back", -a, lightness),
        ("left", -b, lightness),
        ("top", a, b),
        ("bottom", a, -b),
    ):
        np.testing.assert_allclose(camera(*VIEWS[name])[:2], [right, up], atol=1e-12)
    assert camera(*VIEWS["standard"])[1, 2] > 0.9  # lightness upwards


def octahedron(space, size):
    """Around a grey of the space, elongated along the axis of lightness."""
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    steps = np.concatenate([[side * row for side in (1, -1)] for row in np.eye(3)])
    steps[:, space.definition.lightness] *= 1.5
    centre = np.zeros(3)
    centre[space.definition.lightness] = 2 * size
    return TriangleMesh(centre + size * steps, np.array(faces))


@pytest.mark.parametrize("axes", [True, False])
@pytest.mark.parametrize("view", [*VIEWS, "other"])
@pytest.mark.parametrize("name", SPACES)
def test_everything_is_in_the_picture(name, view, axes):
    space = ColourSpace(name)
    mesh = octahedron(space, 0.1)
    directions = camera(*VIEWS.get(view, (33.0, 44.0)))
    corners, colours = scene_triangles(mesh, space, directions, 200, axes=axes)
    assert len(corners) == len(colours)
    assert (len(corners) > len(mesh.faces)) == axes
    assert corners[..., :2].min() >= 0
    assert corners[..., :2].max() <= 200
    assert colours.min() >= 0
    assert colours.max() <= 1


def pixels(data):
    with Image.open(io.BytesIO(data)) as image:
        assert image.format == "PNG"
        return np.asarray(image)


@pytest.mark.parametrize("size", [16, 100, 1025])
def test_size_and_background(level, size):
    white = pixels(mesh_picture(level, size=size))
    assert white.shape == (size, size, 3)
    assert white[0, 0].tolist() == [255, 255, 255]
    clear = pixels(mesh_picture(level, size=size, background="transparent"))
    assert clear.shape == (size, size, 4)
    assert clear[0, 0, 3] == 0
    assert clear[..., 3].max() == 255


def test_from_above_colours_are_where_they_are_in_the_a_b_plane(fogra39_gamut):
    """The upper side of the gamut at some places, found by the gamut's own crossings."""
    level = fogra39_gamut.level(20_000)
    size = 400
    shown = pixels(mesh_picture(level, size=size, view="top", axes=False)).astype(float)
    place = level.vertices[:, 1:]
    low, high = place.min(axis=0), place.max(axis=0)
    scale = 0.94 * size / (high - low).max()
    for a, b in ((40.0, 30.0), (-40.0, 10.0), (0.0, 60.0), (-20.0, -30.0), (30.0, -5.0)):
        column = round((a - (low + high)[0] / 2) * scale + size / 2 - 0.5)
        row = round(size / 2 - (b - (low + high)[1] / 2) * scale - 0.5)
        found = fogra39_gamut.crossings((120.0, a, b), (-120.0, 0.0, 0.0))
        (top,) = linear_srgb(np.array([[max(found.points[:, 0]), a, b]]))
        encoded = shown[row, column] / 255
        light = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
        # the same colour, darker by the shading at most
        shade = light.sum() / top.sum()
        assert 0.69 <= shade <= 1.02
        np.testing.assert_allclose(light, shade * top, atol=0.03)


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"size": 15}, "size"),
        ({"size": 2049}, "size"),
        ({"size": 64.0}, "size"),
        ({"view": "side"}, "view"),
        ({"view": (0, 91)}, "view"),
        ({"view": (0, float("nan"))}, "view"),
        ({"view": (0, 1, 2)}, "view"),
        ({"background": "black"}, "background"),
    ],
)
def test_other_options_are_refused(level, options, field):
    with pytest.raises(OptionError) as caught:
        mesh_picture(level, **options)
    assert caught.value.where == {"field": field}


def test_any_direction_is_a_view(level):
    named = mesh_picture(level, size=50, view="front")
    assert mesh_picture(level, size=50, view=(270, 0)) == named
    assert mesh_picture(level, size=50, view=[-90, 0]) == named
    assert mesh_picture(level, size=50, view=(200, 0)) != named
