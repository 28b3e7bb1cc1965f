"""Spatial mapping of pictures: what it keeps, what it may move, and where it does not apply."""

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from gamutcore import Gamut
from gamutcore.errors import OptionError
from gamutcore.export.picture_file import png

RING = 2.0 * np.pi * np.arange(24) / 24


@pytest.fixture(scope="module")
def press():
    """A body in IPT, smaller than sRGB: two rings between a black and a white point."""
    rings = [
        np.stack([np.full(24, lightness), chroma * np.cos(RING), chroma * np.sin(RING)], axis=-1)
        for lightness, chroma in ((40, 45), (72, 50))
    ]
    return Gamut(np.vstack([*rings, [(8, 0, 0), (97, 0, 0)]]), space="IPT", gamma=1)


@pytest.fixture(scope="module")
def texture():
    """Saturated red and blue with a fine weave, around a duller square, as 16 bits."""
    y, x = np.mgrid[:64, :96]
    weave = 0.5 + 0.5 * np.sin(x * 0.9) * np.sin(y * 0.8)
    red = np.stack([0.7 + 0.3 * weave, 0.2 * weave, 0.1 * weave], axis=-1)
    pixels = np.where((x < 48)[..., np.newaxis], red, red[..., ::-1])
    pixels[20:44, 30:66] = 0.5 + 0.1 * weave[20:44, 30:66, np.newaxis]
    return np.round(65535 * pixels).astype(np.uint16)


def write(path, pixels):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], str(pixels.dtype))
    spec.attribute("oiio:UnassociatedAlpha", 1)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(np.ascontiguousarray(pixels))
    assert output.close()
    return path


def mapped(gamut, pixels, folder, method="spatial", **options):
    """The result's samples and what is said of it."""
    path = write(folder / f"given{len(list(folder.iterdir()))}.tif", pixels)
    done = gamut.map_picture(path, folder / "mapped.tif", method, max_error=0, **options)
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(folder / "mapped.tif"), config)
    found = source.read_image(source.spec().format)
    source.close()
    return found.reshape(pixels.shape), done


def points(gamut, pixels):
    """Colours of samples of 8 or 16 bits in the space of the gamut."""
    full = np.iinfo(pixels.dtype).max
    return gamut.convert(pixels[..., :3] / full, "sRGB")


def test_no_pixel_is_outside_and_hues_stay(press, texture, tmp_path):
    found, done = mapped(press, texture, tmp_path)
    before, after = points(press, texture), points(press, found)
    steps = 2e-4  # more than those of 16 bits in IPT
    assert press.contains(after, tolerance=steps, max_error=0).all()
    cross = before[..., 1] * after[..., 2] - before[..., 2] * after[..., 1]
    away = cross / np.maximum(np.hypot(before[..., 1], before[..., 2]), 0.02)
    assert np.abs(away).max() < steps
    outside = ~press.contains(before, max_error=0)
    assert (done.pixels, done.outside) == (outside.size, outside.sum())
    assert done.moved > done.outside > 0


def test_differences_between_neighbours_are_kept_better_than_pixel_by_pixel(
    screen, press, texture, tmp_path
):
    before = points(press, texture)

    def loss(method, **options):
        shift = points(press, mapped(press, texture, tmp_path, method, **options)[0]) - before
        return sum(np.abs(np.diff(shift, axis=axis)).mean() for axis in (0, 1))

    spatial, clipping = loss("spatial"), loss("spatial", iterations=0)
    assert spatial < loss("spatial", iterations=3) < clipping
    assert spatial < 0.6 * loss("clip-hue")
    assert spatial < 0.6 * loss("sgck", source=screen("srgb", space="IPT"))


def test_a_picture_in_gamut_stays_and_a_uniform_one_is_clipped(press, texture, tmp_path):
    dull = (texture // 8 + 26000).astype(np.uint16)
    found, done = mapped(press, dull, tmp_path)
    np.testing.assert_array_equal(found, dull)
    assert done.moved == 0
    uniform = np.broadcast_to(texture[5, 5], (9, 7, 3))
    many, _ = mapped(press, uniform, tmp_path)
    once, _ = mapped(press, uniform, tmp_path, iterations=0)
    np.testing.assert_array_equal(many, once)
    on_surface = press.distance(points(press, many), max_error=0)
    assert np.abs(on_surface).max() < 2e-4
    assert (many != uniform).any()


def test_pixels_far_from_colours_out_of_gamut_stay(press, tmp_path):
    pixels = np.full((9, 80, 3), 30000, np.uint16)
    pixels[:, 0] = 60000, 0, 0
    found, _ = mapped(press, pixels, tmp_path, iterations=5)
    np.testing.assert_array_equal(found[:, 11:], pixels[:, 11:])


def test_transparent_pixels_stay_and_do_not_pull(press, texture, tmp_path):
    alpha = np.full((*texture.shape[:2], 1), 65535, np.uint16)
    alpha[:, 40:50] = 0
    filled = np.concatenate([texture, alpha], axis=-1)
    other = filled.copy()
    other[:, 40:50, :3] = 65535, 0, 65535
    one, _ = mapped(press, filled, tmp_path)
    two, _ = mapped(press, other, tmp_path)
    np.testing.assert_array_equal(one[:, :40], two[:, :40])
    np.testing.assert_array_equal(one[:, 50:], two[:, 50:])
    np.testing.assert_array_equal(two[:, 40:50], other[:, 40:50])
    np.testing.assert_array_equal(one[..., 3], filled[..., 3])
    cut, _ = mapped(press, texture[:, :40], tmp_path)  # as if the picture ended there
    np.testing.assert_array_equal(cut, one[:, :40, :3])


def test_depths_agree(press, texture, tmp_path):
    bytes_of = (texture >> 8).astype(np.uint8)
    eight, done = mapped(press, bytes_of, tmp_path)
    wide, _ = mapped(press, 257 * bytes_of.astype(np.uint16), tmp_path)
    assert np.abs(wide / 257 - eight).max() < 0.51
    given = tmp_path / "given.exr"
    values = (bytes_of / 255.0).astype(np.float32)
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    write(given, linear.astype(np.float32))
    output, heat = tmp_path / "mapped.png", tmp_path / "heat.png"
    again = press.map_picture(given, output, "spatial", depth="8", heat_map=heat, max_error=0)
    floats = oiio.ImageInput.open(str(output)).read_image("uint8").reshape(eight.shape)
    assert np.abs(floats.astype(int) - eight).max() <= 1
    assert again.colours == done.colours
    assert oiio.ImageInput.open(str(heat)).read_image("uint8").max() > 0


def test_black_point_compensation_comes_first(press, tmp_path):
    ramp = np.repeat(np.linspace(0, 65535, 40).astype(np.uint16), 3).reshape(1, 40, 3)
    found, _ = mapped(press, ramp, tmp_path, black_point_compensation=True)
    assert press.contains(points(press, found), tolerance=2e-4, max_error=0).all()
    assert (np.diff(found[0, :, 1].astype(int)) > 0).all()


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"table": 17}, "table"),
        ({"focus": (50, 0, 0)}, "focus"),
        ({"iterations": -1}, "iterations"),
        ({"iterations": 10**6}, "iterations"),
        ({"method": "clip-hue", "iterations": 5}, "iterations"),
    ],
)
def test_options_that_do_not_apply(press, tmp_path, options, field):
    data = png(np.zeros((2, 2, 3), np.uint8))
    with pytest.raises(OptionError) as caught:
        press.map_picture(data, tmp_path / "mapped.png", **{"method": "spatial"} | options)
    assert caught.value.where == {"field": field}
    assert caught.value.remedy
    assert not list(tmp_path.iterdir())


def test_colours_have_no_neighbours(press):
    with pytest.raises(OptionError, match="neighbours") as caught:
        press.map([(0.5, 0.4, 0)], "spatial")
    assert caught.value.where == {"field": "method"}
    assert "picture" in caught.value.remedy


def test_a_gamut_without_neutral_colours(tmp_path):
    corners = np.array([(x, y, z) for x in (40, 60) for y in (20, 30) for z in (20, 30)])
    aside = Gamut(corners, space="IPT", gamma=1)
    with pytest.raises(OptionError, match="neutral"):
        aside.map_picture(png(np.zeros((2, 2, 3), np.uint8)), tmp_path / "a.png", "spatial")
    assert not list(tmp_path.iterdir())
