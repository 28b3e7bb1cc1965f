"""Pictures as PNG, decoded by Pillow."""

import io

import numpy as np
import pytest
from PIL import Image

from gamutcore.colours.spaces.srgb import linear_srgb
from gamutcore.errors import OptionError
from gamutcore.export.rendering import mesh_picture


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


def test_reruns_are_bit_identical(level):
    assert mesh_picture(level, size=64) == mesh_picture(level, size=64)


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
