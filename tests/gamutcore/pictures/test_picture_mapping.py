"""Mapping of picture files: what stays, what moves, and what the result can store."""

import struct
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
import trimesh
from PIL import Image

from gamutcore import Gamut
from gamutcore.characterisation.pictures import raster
from gamutcore.colours.colorimetry import colour_science
from gamutcore.errors import (
    InvalidPointsError,
    MalformedFileError,
    OptionError,
    UnsupportedPictureError,
)
from gamutcore.pictures import picture_mapping
from gamutcore.pictures.picture_mapping import BLACK_MOVES, HEAT_STEP, VISIBLE

colour = colour_science()

PROFILES = Path("tests/data")
CORNERS = 2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1


@pytest.fixture(scope="module")
def body():
    """L* 10 to 90, a* and b* from −25 to 25: clipping at constant lightness ends on its sides."""
    return Gamut(CORNERS * (40, 25, 25) + (50, 0, 0), gamma=1)


def write(path, pixels, kind, **attributes):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    for name, value in attributes.items():
        if isinstance(value, bytes):
            spec.attribute(name, f"uint8[{len(value)}]", np.frombuffer(value, np.uint8))
        else:
            spec.attribute(name.replace("__", ":"), value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(np.ascontiguousarray(pixels))
    assert output.close()
    return path


def read(path):
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), config)
    pixels, spec = source.read_image(source.spec().format), source.spec()
    source.close()
    return pixels.reshape(spec.height, spec.width, spec.nchannels), spec


def lab_of(rgb):
    """CIELAB relative to D50 of sRGB from 0 to 1, by colour-science."""
    xyz = colour.sRGB_to_XYZ(rgb)
    white = colour.xy_to_XYZ(colour.RGB_COLOURSPACES["sRGB"].whitepoint)
    d50 = np.array([0.96422, 1.0, 0.82521])
    adapted = colour.chromatic_adaptation(xyz, white, d50, method="Von Kries", transform="Bradford")
    return colour.XYZ_to_Lab(adapted, colour.XYZ_to_xy(d50))


def noise(full, *shape, seed=3):
    return np.random.default_rng(seed).integers(0, full + 1, shape)


@pytest.mark.parametrize(("kind", "suffix"), [("uint8", ".png"), ("uint16", ".tif")])
def test_colours_are_clipped_as_the_body_is_and_others_stay(body, tmp_path, kind, suffix):
    full = np.iinfo(kind).max
    pixels = noise(full, 60, 50, 3).astype(kind)
    pixels[:30] = pixels[:30] // 8 + full // 2  # nearly neutral
    given = write(tmp_path / f"given{suffix}", pixels, kind)
    output = tmp_path / f"mapped{suffix}"
    done = body.map_picture(given, output, "clip-chroma", max_error=0)
    mapped, spec = read(tmp_path / f"mapped{suffix}")
    assert str(spec.format) == kind
    before, after = lab_of(pixels / full), lab_of(mapped / full)
    outside = (np.abs(before - (50, 0, 0)) > (40, 25, 25)).any(axis=-1)
    clear = (np.abs(np.abs(before - (50, 0, 0)) - (40, 25, 25)) > 0.01).all(axis=-1)
    changed = (mapped != pixels).any(axis=-1)
    assert not changed[~outside & clear].any()
    assert (done.pixels, done.moved) == (3000, pytest.approx(outside.sum(), abs=5))
    assert done.missed == 0
    # lightness and hue stay, and the larger of a* and b* becomes 25: within a step of the depth
    chromatic = outside & clear & (np.abs(before[..., 0] - 50) < 39)
    step = 1.5 if kind == "uint8" else 0.02
    assert np.abs(after - before)[chromatic, 0].max() < step
    assert np.abs(after[chromatic][:, 1:]).max(axis=1) == pytest.approx(25, abs=step)
    cross = before[..., 1] * after[..., 2] - before[..., 2] * after[..., 1]
    assert np.abs(cross[chromatic] / np.hypot(*before[chromatic].T[1:])).max() < step


def test_a_gamma_and_the_primaries_of_srgb_are_written_as_they_were_read(body, tmp_path):
    # The colour of PNG files of ImageMagick: gAMA 45455, and cHRM of sRGB (W3C PNG, 11.3.2).
    corners = (31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
    gamma = b"gAMA" + struct.pack(">I", 45455)
    stated = [gamma, b"cHRM" + struct.pack(">8i", *corners)]
    given = tmp_path / "given.png"
    Image.fromarray(noise(255, 8, 8, 3).astype(np.uint8)).save(given)
    content, end = given.read_bytes(), 33  # of IHDR
    for each in stated:
        chunk = struct.pack(">I", len(each) - 4) + each + struct.pack(">I", zlib.crc32(each))
        content = content[:end] + chunk + content[end:]
    given.write_bytes(content)
    output = tmp_path / "mapped.png"
    body.map_picture(given, output, heat_map=tmp_path / "heat.png")
    assert output.read_bytes().count(gamma) == 1


def test_alpha_stays_and_transparent_pixels_too(body, tmp_path):
    pixels = noise(255, 40, 30, 4).astype(np.uint8)
    pixels[:5, :, 3] = 0
    given = write(tmp_path / "given.png", pixels, "uint8", oiio__UnassociatedAlpha=1)
    done = body.map_picture(given, tmp_path / "mapped.png")
    mapped, _ = read(tmp_path / "mapped.png")
    np.testing.assert_array_equal(mapped[..., 3], pixels[..., 3])
    transparent = pixels[..., 3] == 0
    np.testing.assert_array_equal(mapped[transparent], pixels[transparent])
    assert done.pixels == (~transparent).sum()
    opaque = write(tmp_path / "opaque.png", pixels[..., :3], "uint8")
    body.map_picture(opaque, tmp_path / "whole.png")
    whole, _ = read(tmp_path / "whole.png")
    np.testing.assert_array_equal(mapped[~transparent][:, :3], whole[~transparent])


def test_linear_light_with_associated_alpha(body, tmp_path):
    colours = np.array([[0.2, 0.2, 0.2], [0.8, 0.0, 0.0], [2.0, 2.0, 2.0]])
    alpha = np.array([0.5, 1.0, 0.25])
    pixels = np.hstack([colours * alpha[:, np.newaxis], alpha[:, np.newaxis]])[np.newaxis]
    given = write(tmp_path / "given.exr", pixels.astype(np.float32), "half")
    done = body.map_picture(given, tmp_path / "mapped.exr", "clip-nearest", max_error=0)
    mapped, spec = read(tmp_path / "mapped.exr")
    assert str(spec.format) == "half"
    stored, _ = read(given)
    np.testing.assert_array_equal(mapped[0, 0], stored[0, 0])
    assert done.moved == 2
    linear = mapped[0, 1:, :3].astype(float) / alpha[1:, np.newaxis]
    lab = lab_of(colour.cctf_encoding(linear, "sRGB"))
    assert lab[:, 0] == pytest.approx([lab_of([0.906, 0, 0])[0], 90], abs=0.3)
    assert lab[0, 1:] == pytest.approx([25, 25], abs=0.3)


@pytest.mark.parametrize("name", ["DisplayP3-v4.icc", "sRGB-v2-magic.icc"])
def test_an_embedded_profile_is_kept_and_used(tmp_path, name):
    """A second mapping moves the colours by steps of 16 bits only."""
    profile = (PROFILES / name).read_bytes()
    pixels = noise(65535, 20, 20, 3).astype(np.uint16)
    given = write(tmp_path / "given.tif", pixels, "uint16", ICCProfile=profile)
    gamut = Gamut(CORNERS * (40, 25, 25) + (50, 0, 0), gamma=1)
    gamut.map_picture(given, tmp_path / "mapped.tif", max_error=0)
    assert raster_profile(tmp_path / "mapped.tif") == profile
    again = gamut.map_picture(tmp_path / "mapped.tif", tmp_path / "twice.tif", max_error=0)
    assert again.delta_e < 2e-3
    once, twice = read(tmp_path / "mapped.tif")[0], read(tmp_path / "twice.tif")[0]
    assert np.abs(once.astype(int) - twice).max() <= 8
    assert (once != pixels).any(axis=-1).mean() > 0.5


def raster_profile(path):
    with raster.open_raster(path.read_bytes(), "tiff") as found:
        return found.profile


def test_colours_beyond_the_encoding_are_counted(tmp_path):
    """The neutral colours of sRGB, moved to where sRGB has no colours."""
    far = Gamut(CORNERS * (40, 5, 5) + (50, 0, 100), gamma=1)
    pixels = np.full((4, 4, 3), 128, np.uint8)
    given = write(tmp_path / "given.png", pixels, "uint8")
    done = far.map_picture(given, tmp_path / "mapped.png", "clip-nearest")
    assert done.missed == done.moved == 16
    mapped, _ = read(tmp_path / "mapped.png")
    lab = lab_of(mapped[0, 0] / 255)
    wanted = far.map(lab_of([128 / 255] * 3), "clip-nearest").points
    grid = lab_of(np.array(list(np.ndindex(52, 52, 52))) / 51)
    nearest = np.linalg.norm(grid - wanted, axis=1).min()
    assert VISIBLE < np.linalg.norm(lab - wanted) < nearest + 1


def test_bands_make_no_difference(body, tmp_path, monkeypatch):
    pixels = noise(255, 64, 32, 3).astype(np.uint8)
    given = write(tmp_path / "given.png", pixels, "uint8")
    body.map_picture(given, tmp_path / "one.png")
    monkeypatch.setattr(raster, "BAND_BYTES", 1000)
    body.map_picture(given, tmp_path / "many.png")
    np.testing.assert_array_equal(read(tmp_path / "one.png")[0], read(tmp_path / "many.png")[0])


@pytest.mark.parametrize(
    ("kind", "suffix"),
    [("uint16", ".jpg"), ("uint8", ".gif"), ("uint8", ".exr"), ("uint8", ".jpg")],
)
def test_what_a_format_cannot_store_is_refused_and_an_earlier_file_kept(
    body, tmp_path, kind, suffix
):
    channels = 4 if (kind, suffix) == ("uint8", ".jpg") else 3
    given = write(tmp_path / "given.png", np.zeros((8, 8, channels), kind), kind)
    output = tmp_path / f"mapped{suffix}"
    output.write_bytes(b"earlier")
    with pytest.raises(UnsupportedPictureError, match=r"store|written") as told:
        body.map_picture(given, output)
    assert "TIFF" in told.value.remedy
    assert output.read_bytes() == b"earlier"
    with pytest.raises(OSError, match="nowhere"):
        body.map_picture(given, tmp_path / "nowhere" / "mapped.png")


def test_faults_leave_no_file(body, tmp_path):
    with pytest.raises(MalformedFileError, match="not a picture"):
        body.map_picture(b"L,a,b\n1,2,3\n", tmp_path / "mapped.png")
    pixels = np.full((2, 2, 3), np.nan, np.float32)
    given = write(tmp_path / "given.exr", pixels, "float")
    with pytest.raises(InvalidPointsError, match="finite"):
        body.map_picture(given, tmp_path / "mapped.exr")
    grey = (PROFILES / "sGrey-v4.icc").read_bytes()
    dots = write(tmp_path / "grey.png", np.zeros((2, 2, 1), np.uint8), "uint8", ICCProfile=grey)
    with pytest.raises(UnsupportedPictureError, match="gray"):
        body.map_picture(dots, tmp_path / "mapped.png")
    good = write(tmp_path / "good.png", np.zeros((2, 2, 3), np.uint8), "uint8")
    with pytest.raises(OptionError):
        body.map_picture(good, tmp_path / "mapped.png", "clip-somehow")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["given.exr", "good.png", "grey.png"]


LIGHT = np.array([[0.2, 0.2, 0.2], [0.05, 0.1, 0.15], [0.8, 0.0, 0.0], [20.0, 20.0, 20.0]])


@pytest.mark.parametrize("kind", ["half", "float"])
@pytest.mark.parametrize(("suffix", "depth"), [(".png", "8"), (".png", "16"), (".tif", "16")])
def test_linear_light_is_written_as_srgb_in_a_stated_depth(body, tmp_path, kind, suffix, depth):
    """The colours are those of the mapping itself, within a step of the depth."""
    given = write(tmp_path / "given.exr", LIGHT[np.newaxis].astype(np.float32), kind)
    output = tmp_path / f"mapped{suffix}"
    done = body.map_picture(given, output, "clip-nearest", depth=depth, max_error=0)
    assert (done.encoding, done.pixels, done.moved, done.missed) == ("sRGB", 4, 2, 0)
    mapped, spec = read(output)
    assert str(spec.format) == f"uint{depth}"
    stored = read(given)[0][0].astype(float)
    wanted = body.map(lab_of(colour.cctf_encoding(stored, "sRGB")), "clip-nearest", max_error=0)
    found = lab_of(mapped[0] / np.iinfo(mapped.dtype).max)
    np.testing.assert_allclose(found, wanted.points, atol=1.0 if depth == "8" else 0.02)


def test_integers_of_a_picture_with_associated_alpha_have_straight_alpha(body, tmp_path):
    alpha = np.array([[0.5], [1.0], [0.25], [0.0]])
    light = np.hstack([LIGHT * alpha, alpha])[np.newaxis].astype(np.float32)
    given = write(tmp_path / "given.exr", light, "float")
    opaque = write(tmp_path / "opaque.exr", LIGHT[np.newaxis].astype(np.float32), "float")
    for source, name in ((given, "mapped.png"), (opaque, "opaque.png")):
        body.map_picture(source, tmp_path / name, depth="16", max_error=0)
    mapped, whole = read(tmp_path / "mapped.png")[0], read(tmp_path / "opaque.png")[0]
    np.testing.assert_array_equal(mapped[0, :, 3], np.round(alpha[:, 0] * 65535))
    np.testing.assert_allclose(mapped[0, :3, :3].astype(int), whole[0, :3], atol=1)


def test_half_floats_become_floats_in_tiff(body, tmp_path):
    given = write(tmp_path / "given.exr", LIGHT[np.newaxis].astype(np.float32), "half")
    body.map_picture(given, tmp_path / "mapped.tif", max_error=0)
    mapped, spec = read(tmp_path / "mapped.tif")
    assert str(spec.format) == "float"
    np.testing.assert_array_equal(mapped[0, :2], read(given)[0][0, :2])


@pytest.mark.parametrize("depth", ["8", "16"])
def test_the_depth_of_integers_changes_with_the_profile_kept(body, tmp_path, depth):
    profile = (PROFILES / "DisplayP3-v4.icc").read_bytes()
    kind = {"8": "uint16", "16": "uint8"}[depth]
    full, other = np.iinfo(kind).max, np.iinfo(f"uint{depth}").max
    given = write(
        tmp_path / "given.tif", noise(full, 9, 9, 3).astype(kind), kind, ICCProfile=profile
    )
    body.map_picture(given, tmp_path / "same.tif", max_error=0)
    body.map_picture(given, tmp_path / "mapped.tif", depth=depth, max_error=0)
    assert raster_profile(tmp_path / "mapped.tif") == profile
    same, mapped = read(tmp_path / "same.tif")[0] / full, read(tmp_path / "mapped.tif")[0] / other
    np.testing.assert_allclose(mapped, same, atol=1.01 / 255)


def test_floats_without_a_depth_are_refused_as_png_with_the_remedy(body, tmp_path):
    given = write(tmp_path / "given.exr", LIGHT[np.newaxis].astype(np.float32), "float")
    with pytest.raises(UnsupportedPictureError) as told:
        body.map_picture(given, tmp_path / "mapped.png")
    assert "depth 8 or 16" in told.value.remedy
    with pytest.raises(OptionError) as told:
        body.map_picture(given, tmp_path / "mapped.png", depth="12")
    assert told.value.where["field"] == "depth"
    Image.new("RGB", (4, 4), (255, 0, 0)).save(tmp_path / "unstated.png")
    with pytest.raises(UnsupportedPictureError, match="encoding"):
        body.map_picture(tmp_path / "unstated.png", tmp_path / "mapped.tif", depth="float")


def test_bright_light_inside_the_gamut_stays_and_brighter_light_is_mapped(tmp_path):
    """A gamut up to L* 500, which is 88 × white."""
    bright = Gamut(CORNERS * (245, 25, 25) + (255, 0, 0), gamma=1)
    light = np.repeat([[0.5], [50.0], [500.0]], 3, axis=1)[np.newaxis].astype(np.float32)
    given = write(tmp_path / "given.exr", light, "float")
    done = bright.map_picture(given, tmp_path / "mapped.exr", "clip-nearest", max_error=0)
    assert (done.moved, done.missed) == (1, 0)
    mapped = read(tmp_path / "mapped.exr")[0][0]
    np.testing.assert_array_equal(mapped[:2], light[0, :2])
    np.testing.assert_allclose(mapped[2], (516 / 116) ** 3, rtol=1e-3)
    write(tmp_path / "sun.exr", np.full((1, 1, 3), 1e6, np.float32), "float")
    with pytest.raises(InvalidPointsError, match="white"):
        bright.map_picture(tmp_path / "sun.exr", tmp_path / "mapped.exr")


@pytest.fixture(scope="module")
def smooth():
    """An ellipsoid in IPT, whose surface has no edges."""
    ellipsoid = trimesh.creation.icosphere(subdivisions=6)
    ellipsoid.apply_scale([0.35, 0.25, 0.25])
    ellipsoid.apply_translation([0.55, 0, 0])
    return Gamut(ellipsoid, space="IPT")


def test_a_smooth_picture_stays_smooth(smooth, tmp_path):
    """The triangles of a coarser level are visible as arcs: colours bend where a triangle ends."""
    share = np.linspace(0, 1, 1500)
    ramps = [(0 * share, share, 0 * share + 1), (0 * share + 1, 0 * share, 1 - share)]
    pixels = np.round(65535 * np.moveaxis(ramps, 1, 2)).astype(np.uint16)
    given, mapped = write(tmp_path / "given.png", pixels, "uint16"), tmp_path / "mapped.png"

    def largest_bend(**level):
        """Return the largest second difference in CIELAB over 20 pixels: larger than a triangle."""
        assert smooth.map_picture(given, mapped, **level).moved == pixels[..., 0].size
        along = lab_of(read(mapped)[0] / 65535)
        bends = along[:, 40:] - 2 * along[:, 20:-20] + along[:, :-40]
        return np.linalg.norm(bends, axis=-1).max()

    chosen = largest_bend()
    written = mapped.read_bytes()
    assert chosen < 0.5 * largest_bend(max_error=smooth.default_error)
    assert chosen < 0.5 * largest_bend(triangles=500)
    assert largest_bend(max_error=0) == chosen
    assert mapped.read_bytes() == written


def test_blue_that_cielab_turns_to_purple_is_told(body, smooth, tmp_path):
    blue = write(tmp_path / "blue.png", np.full((2, 2, 3), (0, 0, 255), np.uint8), "uint8")
    red = write(tmp_path / "red.png", np.full((2, 2, 3), (255, 0, 0), np.uint8), "uint8")

    def told(gamut, given, *method):
        done = gamut.map_picture(given, tmp_path / "mapped.png", *method)
        assert done.moved == done.pixels
        return any("purple" in warning for warning in done.warnings)

    assert told(body, blue)
    assert not told(body, blue, "clip-nearest")
    assert not told(body, red)
    assert not told(smooth, blue)


def shadows(path):
    """Write black, white and a grey ramp between them; return the file."""
    grey = np.linspace(0, 65535, 200).round().astype(np.uint16)
    return write(path, np.repeat(grey[np.newaxis, :, np.newaxis], 3, axis=2), "uint16")


def test_black_becomes_the_darkest_neutral_and_white_stays(tmp_path):
    """ISO 18619: luminance is scaled linearly, relative to white."""
    body = Gamut(CORNERS * (45, 25, 25) + (55, 0, 0), gamma=1)  # L* 10 to 100
    given, mapped = shadows(tmp_path / "given.png"), tmp_path / "mapped.png"
    body.map_picture(given, mapped)
    clipped = lab_of(read(mapped)[0][0] / 65535)
    body.map_picture(given, mapped, black_point_compensation=True)
    scaled = lab_of(read(mapped)[0][0] / 65535)
    assert scaled[0] == pytest.approx([10, 0, 0], abs=0.01)
    assert scaled[-1] == pytest.approx(clipped[-1], abs=1e-9)
    before = lab_of(read(given)[0][0] / 65535)
    dark = before[:, 0] < 9.9
    assert dark.sum() > 5
    assert np.ptp(clipped[dark, 0]) < 0.01  # without compensation, shadows are lost
    assert (np.diff(scaled[:, 0]) > 0).all()
    luminance, own = (colour.colorimetry.luminance_CIE1976(each[:, 0]) for each in (before, scaled))
    black = colour.colorimetry.luminance_CIE1976(10)
    assert own == pytest.approx(black + (100 - black) / 100 * luminance, abs=0.01)


def test_pixels_that_only_round_are_not_moved_and_compensation_is_named(tmp_path):
    """Black of L* 0.1 scales all colours, and most by less than half a step of 8 bits."""
    body = Gamut(CORNERS * (49.95, 30, 30) + (50.05, 0, 0), gamma=1, intent="relative")
    grey = np.repeat(np.arange(256, dtype=np.uint8)[np.newaxis, :, np.newaxis], 3, axis=2)
    given = write(tmp_path / "given.png", grey, "uint8")
    done = body.map_picture(given, tmp_path / "mapped.png", black_point_compensation=True)
    changed = (read(tmp_path / "mapped.png")[0] != grey).any(axis=-1)
    assert done.moved == changed.sum() < 20
    assert BLACK_MOVES not in done.warnings  # it was asked for


def test_nothing_moves_between_equal_blacks(tmp_path):
    whole = Gamut(CORNERS * (50, 25, 25) + (50, 0, 0), gamma=1)  # L* 0 to 100
    given = shadows(tmp_path / "given.png")
    done = whole.map_picture(given, tmp_path / "mapped.png", black_point_compensation=True)
    assert done.moved == 0
    np.testing.assert_array_equal(read(given)[0], read(tmp_path / "mapped.png")[0])


def test_the_black_of_an_embedded_profile_counts(tmp_path, made_profile):
    """A display that reflects 2 % of its white: R = G = B = v is the luminance 0.02 + 0.98 v."""
    primaries = {"r": (0.4361, 0.2225, 0.0139), "g": (0.3851, 0.7169, 0.0971)}
    primaries["b"] = tuple(np.array([0.9642, 1, 0.8249]) - primaries["r"] - primaries["g"])
    tags = {}
    for channel, xyz in primaries.items():
        fixed = [round(65536 * value) for value in xyz]
        tags[f"{channel}XYZ"] = b"XYZ \0\0\0\0" + struct.pack(">3i", *fixed)
        tags[f"{channel}TRC"] = struct.pack(">4sII2H", b"curv", 0, 2, round(0.02 * 65535), 65535)
    profile = made_profile(tags, pcs="XYZ ", kind="mntr")
    pixels = np.repeat(np.array([[0, 20_000, 65535]], np.uint16)[..., np.newaxis], 3, axis=2)
    given = write(tmp_path / "given.tif", pixels, "uint16", ICCProfile=profile)
    body = Gamut(CORNERS * (40, 25, 25) + (60, 0, 0), gamma=1)  # L* 20 to 100
    body.map_picture(given, tmp_path / "mapped.tif", black_point_compensation=True)
    values = read(tmp_path / "mapped.tif")[0][0, :, 1] / 65535
    black = colour.colorimetry.luminance_CIE1976(20) / 100
    expected = black + (1 - black) * pixels[0, :, 1] / 65535
    assert 0.02 + 0.98 * values == pytest.approx(expected, abs=1e-4)


def test_compensation_that_does_not_apply(body, tmp_path):
    given = shadows(tmp_path / "given.png")
    beside = Gamut(CORNERS * (40, 10, 10) + (50, 60, 0), gamma=1)
    with pytest.raises(OptionError, match="no neutral"):
        beside.map_picture(given, tmp_path / "mapped.png", black_point_compensation=True)
    with pytest.raises(OptionError, match="black itself"):
        body.map([50, 0, 0], "sgck", source=body, black_point_compensation=True)


def ramps(kind, rows=90, columns=120):
    """Colours of 0 to 1 that change smoothly, of which a part is out of the gamut `body`."""
    x, y = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    pixels = np.stack([x, y, 0.5 + 0.5 * np.sin(5 * x) * y], axis=-1)
    if kind == "float":
        return pixels.astype(np.float32)
    return np.round(pixels * np.iinfo(kind).max).astype(kind)


def difference(one, two):
    return colour.difference.delta_E_CIE2000(lab_of(one), lab_of(two))


@pytest.mark.parametrize(
    ("kind", "suffix"), [("uint8", ".png"), ("uint16", ".tif"), ("float", ".exr")]
)
def test_the_stated_error_of_a_table_is_that_of_its_pixels(body, tmp_path, kind, suffix):
    pixels = ramps(kind)
    given = write(tmp_path / f"given{suffix}", pixels, kind)
    files = [tmp_path / f"{name}{suffix}" for name in ("exact", "table", "coarse")]
    exact, done, coarse = (
        body.map_picture(given, file, table=nodes, max_error=0)
        for file, nodes in zip(files, (0, 33, 9), strict=True)
    )
    assert exact.table_error is None
    full = 1 if kind == "float" else np.iinfo(kind).max
    whole, mapped = (read(file)[0] / full for file in files[:2])
    if kind == "float":
        whole, mapped = (colour.cctf_encoding(each, "sRGB") for each in (whole, mapped))
    errors = difference(whole, mapped).ravel()
    stated = done.table_error
    assert (stated.nodes, stated.pixels) == (33, errors.size)  # all, as there are few
    assert stated.mean == pytest.approx(errors.mean(), rel=1e-2, abs=1e-5)
    assert stated.percentile_95 == pytest.approx(np.percentile(errors, 95), rel=1e-2, abs=1e-5)
    assert stated.largest == pytest.approx(errors.max(), rel=1e-2)
    assert stated.mean < min(0.1, 0.5 * coarse.table_error.mean)
    assert done.moved == pytest.approx(exact.moved, rel=0.01)
    assert done.delta_e == pytest.approx(exact.delta_e, rel=0.01)


@pytest.mark.parametrize("kind", ["uint8", "uint16", "float"])
def test_a_table_keeps_pixels_in_gamut(body, tmp_path, kind):
    pixels = ramps(kind)
    suffix = ".exr" if kind == "float" else ".tif"
    given, output = write(tmp_path / f"given{suffix}", pixels, kind), tmp_path / f"mapped{suffix}"
    body.map_picture(given, output, table=33, max_error=0)
    values = pixels / (1 if kind == "float" else np.iinfo(kind).max)
    if kind == "float":
        values = colour.cctf_encoding(values, "sRGB")
    inside = (np.abs(lab_of(values) - (50, 0, 0)) < (39, 24, 24)).all(axis=-1)
    assert 0.05 < inside.mean() < 0.9
    np.testing.assert_array_equal(read(output)[0][inside], pixels[inside])


def test_large_pictures_have_a_table_by_default(body, tmp_path, monkeypatch):
    given = write(tmp_path / "given.png", ramps("uint8"), "uint8")
    assert body.map_picture(given, tmp_path / "mapped.png").table_error is None
    monkeypatch.setattr(picture_mapping, "TABLE_PIXELS", 1000)
    assert body.map_picture(given, tmp_path / "mapped.png").table_error.nodes == 65
    assert body.map_picture(given, tmp_path / "mapped.png", table=0).table_error is None


@pytest.mark.parametrize("kind", ["uint8", "uint16"])
def test_figures_and_heat_map_are_those_of_each_pixel(body, tmp_path, kind):
    pixels = ramps("uint8")[:, ::2].repeat(2, axis=1)
    if kind == "uint16":
        pixels = pixels.astype(np.uint16) * 257
    given = write(tmp_path / "given.png", pixels, kind)
    heat_file = tmp_path / "heat.png"
    done = body.map_picture(given, tmp_path / "mapped.png", heat_map=heat_file, max_error=0)
    rows = pixels.reshape(-1, 3)
    values = rows / np.iinfo(kind).max
    outside = ~body.contains(values, space="sRGB", max_error=0)
    found = body.map(values, space="sRGB", max_error=0)
    changed = (read(tmp_path / "mapped.png")[0] != pixels).any(axis=-1).ravel()
    assert (done.outside, done.moved) == (outside.sum(), changed.sum())
    assert (changed <= found.moved).all()
    # moves of less than half a step of 8 bits are rounded away
    assert found.delta_e[found.moved & ~changed].max(initial=0.0) < 0.5
    found.delta_e[~changed] = 0.0
    assert done.colours == len(np.unique(rows, axis=0)) < done.pixels
    assert done.colours_outside == len(np.unique(rows[outside], axis=0)) > 0
    moved = found.delta_e[changed]
    assert (done.delta_e, done.moved_delta_e) == pytest.approx(
        (found.delta_e.mean(), moved.mean()), rel=1e-5
    )
    for stated, differences in (done.delta_e_95, found.delta_e), (done.moved_delta_e_95, moved):
        assert stated == pytest.approx(np.percentile(differences, 95), abs=0.02)
    with Image.open(heat_file) as heat:
        assert (heat.mode, heat.size) == ("L", pixels.shape[1::-1])
        assert heat.text["Description"] == done.heat_map
        gray = np.asarray(heat).ravel()
    np.testing.assert_array_equal(gray > 0, changed)
    shown = np.minimum(found.delta_e, 255 * HEAT_STEP)
    assert (np.abs(gray * HEAT_STEP - shown) < HEAT_STEP * 1.01).all()


def test_transparent_pixels_are_black_in_the_heat_map(body, tmp_path):
    pixels = np.full((4, 6, 4), (255, 0, 0, 255), np.uint8)
    pixels[:2, :, 3] = 0
    given = write(tmp_path / "given.png", pixels, "uint8", oiio__UnassociatedAlpha=1)
    options = {"heat_map": tmp_path / "heat.png", "table": 17}
    done = body.map_picture(given, tmp_path / "mapped.png", **options)
    assert (done.pixels, done.colours, done.table_error.pixels) == (12, 1, 12)
    np.testing.assert_array_equal(read(tmp_path / "heat.png")[0][..., 0] > 0, pixels[..., 3] > 0)


@pytest.mark.parametrize(
    ("options", "field"),
    [({"table": 3}, "table"), ({"table": 500}, "table"), ({"heat_map": "heat.jpg"}, "heat_map")],
)
def test_impossible_tables_and_heat_maps_write_nothing(body, tmp_path, options, field):
    given = write(tmp_path / "given.png", ramps("uint8"), "uint8")
    with pytest.raises(OptionError) as told:
        body.map_picture(given, tmp_path / "mapped.png", **options)
    assert told.value.where["field"] == field
    with pytest.raises(OSError, match="nowhere"):
        body.map_picture(given, tmp_path / "mapped.png", heat_map=tmp_path / "nowhere" / "heat.png")
    assert [each.name for each in tmp_path.iterdir()] == ["given.png"]
