"""Pictures of CMYK, mapped by their embedded profile to a display."""

import io

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from PIL import Image, ImageCms

from gamutcore.errors import UnsupportedPictureError

INKS = np.array(
    [
        *((0, 0, 0, 0), (255, 0, 0, 0), (0, 255, 0, 0), (0, 0, 255, 0), (0, 0, 0, 255)),
        *((0, 0, 0, 128), (100, 80, 80, 30), (60, 20, 10, 0), (20, 90, 90, 10)),
    ],
    np.uint8,
)
IN_GAMUT = [0, 5, 6, 7, 8]
"""Colours in sRGB: paper, grays and tints. Cyan and yellow are outside."""

DARK = [2, 4]
"""Magenta and black, which depend on the black for compensation: in Little CMS that of the
profile's separation, L* 12.8, and here the darkest neutral within its ink limit, L* 10.6. They
differ by 3 to 6 codes."""


@pytest.fixture(scope="module")
def display(screen):
    return screen("srgb")


@pytest.fixture(scope="module")
def profile(shared_data):
    return (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()


def by_lcms(picture, profile, flags):
    own, srgb = ImageCms.ImageCmsProfile(io.BytesIO(profile)), ImageCms.createProfile("sRGB")
    change = ImageCms.buildTransform(own, srgb, "CMYK", "RGB", 1, flags)
    return np.asarray(ImageCms.applyTransform(picture, change)).reshape(-1, 3).astype(int)


@pytest.mark.parametrize("suffix", ["tif", "jpg"])
@pytest.mark.parametrize("compensated", [False, True])
def test_a_proof_agrees_with_lcms(display, profile, tmp_path, suffix, compensated):
    inks = np.repeat(np.repeat(INKS[np.newaxis], 16, axis=0), 16, axis=1)
    given = Image.frombytes("CMYK", inks.shape[1::-1], inks.tobytes())
    more = {"quality": 100, "subsampling": 0} if suffix == "jpg" else {}
    given.save(tmp_path / f"press.{suffix}", icc_profile=profile, **more)
    done = display.map_picture(
        tmp_path / f"press.{suffix}",
        tmp_path / "proof.png",
        to="srgb",
        black_point_compensation=compensated,
    )
    found = np.asarray(Image.open(tmp_path / "proof.png"))[8, 8::16].astype(int)
    flags = ImageCms.Flags.BLACKPOINTCOMPENSATION if compensated else 0
    wanted = by_lcms(Image.open(tmp_path / f"press.{suffix}"), profile, flags).reshape(16, -1, 3)
    checked = IN_GAMUT if compensated else [*IN_GAMUT, *DARK]
    assert np.abs(found - wanted[8, 8::16])[checked].max() <= 1
    assert (done.encoding, done.pixels, done.missed) == ("sRGB", 16 * inks.shape[1], 0)


@pytest.fixture
def press(profile, tmp_path):
    path = tmp_path / "press.tif"
    inks = INKS[np.newaxis]
    Image.frombytes("CMYK", inks.shape[1::-1], inks.tobytes()).save(path, icc_profile=profile)
    return path


def test_a_proof_has_srgb_if_no_space_is_asked(display, press, tmp_path):
    done = display.map_picture(press, tmp_path / "proof.tif", depth="16")
    assert any("the result has sRGB" in each for each in done.warnings)
    asked = display.map_picture(press, tmp_path / "asked.tif", to="srgb", depth="16")
    assert not any("the result has sRGB" in each for each in asked.warnings)
    # Not the bytes: a TIFF file has the time of its writing.
    proof, stated = (oiio.ImageBuf(str(tmp_path / name)) for name in ("proof.tif", "asked.tif"))
    assert np.array_equal(proof.get_pixels(oiio.UINT16), stated.get_pixels(oiio.UINT16))
    assert np.array_equal(*(each.spec()["ICCProfile"] for each in (proof, stated)))


def test_a_spatial_proof_without_iterations_is_clipping(display, press, tmp_path):
    display.map_picture(press, tmp_path / "spatial.png", "spatial", iterations=0, to="srgb")
    display.map_picture(press, tmp_path / "clipped.png", to="srgb")
    spatial, clipped = (
        np.asarray(Image.open(tmp_path / name))[0, IN_GAMUT].astype(int)
        for name in ("spatial.png", "clipped.png")
    )
    assert np.abs(spatial - clipped).max() <= 1


def test_cmyk_without_a_profile_is_refused(display, tmp_path):
    Image.new("CMYK", (2, 2)).save(tmp_path / "press.tif")
    with pytest.raises(UnsupportedPictureError, match="no embedded profile") as refusal:
        display.map_picture(tmp_path / "press.tif", tmp_path / "proof.png", to="srgb")
    assert refusal.value.where["field"] == "profile"
    assert "Embed the profile" in refusal.value.remedy
