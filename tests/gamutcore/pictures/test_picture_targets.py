"""Mapped pictures in another encoding: RGB spaces with their profiles, and device values."""

import io
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from PIL import Image, ImageCms, TiffTags

from gamutcore import Gamut
from gamutcore.characterisation.pictures.containers import tiff_fields
from gamutcore.errors import DeviceModelError, OptionError, UnsupportedPictureError
from gamutcore.search import delta_e_2000

SMOOTH = np.stack(np.meshgrid(np.linspace(0, 1, 20), np.linspace(0, 1, 25)), axis=-1)
PIXELS = np.round(255 * np.dstack([SMOOTH, (SMOOTH[..., :1] + 1 - SMOOTH[..., 1:]) / 2]))


@pytest.fixture(scope="module")
def press(press_gamut):
    return press_gamut


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "photo.png"
    Image.fromarray(PIXELS.astype(np.uint8)).save(path)
    return path


def lab_by_lcms(picture):
    """CIELAB of an RGB picture by its embedded profile, computed by Little CMS with 8 bits."""
    own = ImageCms.ImageCmsProfile(io.BytesIO(picture.info["icc_profile"]))
    change = ImageCms.buildTransform(
        own, ImageCms.createProfile("LAB", 5000), picture.mode, "LAB", 1
    )
    lab = np.asarray(ImageCms.applyTransform(picture, change)).astype(float)
    signed = np.where(lab[..., 1:] > 127, lab[..., 1:] - 256, lab[..., 1:])
    return np.dstack([lab[..., 0] / 2.55, signed])


@pytest.mark.parametrize("space", ["display-p3", "prophoto-rgb", "bt2020", "adobe-rgb-1998"])
def test_a_picture_in_an_rgb_space_has_its_colours_by_its_profile(screen, photo, tmp_path, space):
    gamut = screen(space)
    done = gamut.map_picture(photo, tmp_path / "mapped.png", "clip-nearest", to=space)
    assert (done.moved, done.missed) == (0, 0)
    found = Image.open(tmp_path / "mapped.png")
    given = Image.open(photo)
    given.info["icc_profile"] = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    # Little CMS rounds CIELAB to 1, and the encodings round to 1/255
    assert np.abs(lab_by_lcms(found) - lab_by_lcms(given)).max() < 2.5
    assert (np.asarray(found) != np.asarray(given)).any()


@pytest.mark.slow
def test_the_own_space_keeps_the_values(photo, tmp_path, press):
    press.map_picture(photo, tmp_path / "own.png")
    done = press.map_picture(photo, tmp_path / "srgb.png", to="sRGB")
    own, found = (np.asarray(Image.open(tmp_path / name)) for name in ("own.png", "srgb.png"))
    np.testing.assert_array_equal(own, found)
    assert done.encoding == "sRGB"


def test_openexr_has_linear_light_of_the_space(photo, tmp_path, press):
    press.map_picture(photo, tmp_path / "own.png")
    press.map_picture(photo, tmp_path / "p3.exr", to="display-p3", depth="float")
    unscaled = {"black_point_compensation": False}  # black is scaled once
    again = press.map_picture(
        tmp_path / "p3.exr", tmp_path / "back.png", to="srgb", depth="8", **unscaled
    )
    own, back = (np.asarray(Image.open(tmp_path / name)) for name in ("own.png", "back.png"))
    assert again.warnings == press.conditions.build_warnings
    assert np.abs(own.astype(int) - back).max() <= 1


@pytest.mark.slow
@pytest.mark.parametrize(("depth", "table"), [("8", 0), ("16", 0), ("16", 17)])
def test_device_values_give_the_mapped_colours(press, photo, tmp_path, depth, table):
    done = press.map_picture(
        photo, tmp_path / "press.tif", to="device", depth=depth, table=table, black="medium"
    )
    assert done.encoding == "device values C M Y K"
    assert any("No profile" in each for each in done.warnings)
    with Image.open(tmp_path / "press.tif") as found:
        assert (found.mode, found.tag_v2[262], found.tag_v2[332]) == ("CMYK", 5, 1)
    config = oiio.ImageSpec()
    config.attribute("oiio:RawColor", 1)
    source = oiio.ImageInput.open(str(tmp_path / "press.tif"), config)
    codes = np.asarray(source.read_image(f"uint{depth}")).reshape(-1, 4).astype(float)
    full = 2.0 ** int(depth) - 1
    assert codes.sum(axis=1).max() <= 3.0 * full
    given = press.convert(PIXELS.reshape(-1, 3) / 255, "sRGB")
    wanted = press.map(given, max_error=0, black_point_compensation=True).points
    reached = press.to_device(wanted, max_error=0).points  # triangles reach beyond the model
    errors = delta_e_2000(press.to_colour(codes / full), reached)
    rounding = 1.0 if depth == "8" else 0.02
    if table:
        assert done.table_error.nodes == 17
        assert np.percentile(errors, 95) < done.table_error.percentile_95 + rounding
        assert done.table_error.mean < 0.5
    else:
        assert np.percentile(errors, 95) < rounding


def test_the_profile_of_the_gamut_is_embedded(photo, tmp_path):
    profile = Path("tests/data/DisplayP3-v4.icc").read_bytes()
    display = Gamut(profile, surface_samples=1000)
    Image.open(photo).save(photo, dpi=(300, 150))
    done = display.map_picture(photo, tmp_path / "p3.tif", to="device")
    told = "No profile is embedded: sRGB is assumed."  # in the given picture
    assert done.warnings == (*display.conditions.build_warnings, told)
    found = Image.open(tmp_path / "p3.tif")
    assert (found.mode, found.info["icc_profile"]) == ("RGB", profile)
    assert found.info["dpi"] == pytest.approx((300, 150), rel=1e-4)
    display.map_picture(photo, tmp_path / "space.png", to="display-p3")
    space = np.asarray(Image.open(tmp_path / "space.png"))
    assert np.abs(np.asarray(found).astype(int) - space).max() <= 1


@pytest.mark.slow
def test_black_is_as_asked_and_transparent_pixels_are_blank(press, tmp_path):
    pixels = np.dstack([PIXELS, np.full(PIXELS.shape[:2], 255)]).astype(np.uint8)
    pixels[:3, :, 3] = 0
    Image.fromarray(pixels).save(tmp_path / "photo.png")
    done = press.map_picture(
        tmp_path / "photo.png", tmp_path / "press.tif", to="device", black="none"
    )
    found = np.asarray(Image.open(tmp_path / "press.tif"))
    assert any("alpha" in each for each in done.warnings)
    assert not found[:3].any()
    inside = press.contains(PIXELS[3:].reshape(-1, 3) / 255, space="sRGB")
    assert np.median(found[3:].reshape(-1, 4)[inside, 3]) == 0
    assert found[3:, :, 0].any()


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 5])
def test_other_inks_are_named(tmp_path, photo, count):
    """All samples are inks, and none an extra sample (TIFF 6.0, section 16)."""
    rng = np.random.default_rng(2)
    corners = np.eye(count), np.zeros((1, count)), np.ones((1, count))
    inks = np.concatenate([*corners, rng.random((80, count))])
    steps = np.array([[-45, -60, -10], [-50, 70, -5], [-10, -5, 90], [-70, 0, 0], [-35, 60, 70]])
    lab = (100, 0, 0) + (inks @ steps[:count]) * (0.45, 0.8, 0.8)
    head = f"CGATS.17\nNUMBER_OF_FIELDS {count + 4}\nBEGIN_DATA_FORMAT\nSAMPLE_ID "
    head += (
        " ".join(f"{count}CLR_{number}" for number in range(1, count + 1)) + " LAB_L LAB_A LAB_B\n"
    )
    rows = np.column_stack([np.arange(len(inks)), 100 * inks, np.maximum(lab, (1, -200, -200))])
    text = f"{head}END_DATA_FORMAT\nNUMBER_OF_SETS {len(rows)}\nBEGIN_DATA\n"
    text += "\n".join(" ".join(f"{value:.4f}" for value in row) for row in rows) + "\nEND_DATA\n"
    gamut = Gamut(text.encode(), surface_samples=500)
    Image.fromarray(PIXELS[::5, ::5].astype(np.uint8)).save(photo)
    gamut.map_picture(photo, tmp_path / "inks.tif", to="device")
    source = oiio.ImageInput.open(str(tmp_path / "inks.tif"))
    assert source.spec().nchannels == count
    fields = tiff_fields((tmp_path / "inks.tif").read_bytes())
    tags = TiffTags.TAGS_V2
    named = {tags[tag].name: value for tag, value in fields.items() if tag in tags}
    assert (named["InkSet"], named["NumberOfInks"]) == ((2,), (count,))
    assert named["InkNames"].decode().split("\0")[:-1] == [*gamut.channels]
    assert "ExtraSamples" not in named


@pytest.mark.parametrize(
    ("options", "field", "remedy"),
    [
        ({"to": "nonsense"}, "to", "display-p3"),
        ({"to": "pointer"}, "to", "display-p3"),
        ({"to": "bt2100-pq-1000"}, "to", "display-p3"),
        ({"to": "srgb", "black": "none"}, "black", "Leave it out"),
        ({"to": "device", "black": "much"}, "black", "medium"),
        pytest.param(
            *({"to": "device", "depth": "half"}, "depth", "8 or 16"), marks=pytest.mark.slow
        ),
    ],
)
def test_encodings_that_do_not_fit_are_refused(press, photo, tmp_path, options, field, remedy):
    with pytest.raises(OptionError, match=remedy) as caught:
        press.map_picture(photo, tmp_path / "mapped.tif", **options)
    assert caught.value.where["field"] == field
    assert list(tmp_path.iterdir()) == [photo]


@pytest.mark.slow
def test_devices_need_a_model_and_tiff(press, photo, tmp_path):
    colours = Gamut(2.0 * np.array(list(np.ndindex(2, 2, 2))) * 20 + 20, gamma=1)
    with pytest.raises(DeviceModelError, match="colours only"):
        colours.map_picture(photo, tmp_path / "mapped.tif", to="device")
    with pytest.raises(UnsupportedPictureError, match=r"\.tif"):
        press.map_picture(photo, tmp_path / "mapped.png", to="device")
    assert list(tmp_path.iterdir()) == [photo]
