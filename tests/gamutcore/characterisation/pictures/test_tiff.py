"""TIFF, written by hand: layouts, colour models, sample types, and files that break the format."""

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gamutcore.characterisation import read_characterisation as picture
from gamutcore.errors import (
    GamutError,
    InvalidPointsError,
    MalformedFileError,
    PictureSizeError,
    UnsupportedPictureError,
)

DATA = Path(__file__).parents[3] / "data"


def raw(pixels, order="<"):
    return pixels.astype(pixels.dtype.newbyteorder(order)).tobytes()


@pytest.mark.usefixtures("bands")
@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("bits", [8, 16])
def test_strips(tiff, tags, noise, pixel_counts, counts_of, bits, order, big):
    pixels = noise(7, 5, 3, bits=bits)
    parts = [raw(pixels[top : top + 3], order) for top in (0, 3, 6)]
    found = picture(tiff(parts, tags(5, 7, bits, 3, 2, t278=3), order=order, big=big))
    assert counts_of(found, 2**bits - 1) == pixel_counts(pixels)
    assert (found.format, found.model) == ("tiff", "RGB")


@pytest.mark.usefixtures("bands")
@pytest.mark.parametrize("planar", [1, 2])
def test_tiles_and_planes(tiff, tags, noise, pixel_counts, counts_of, planar):
    pixels = noise(20, 35, 3)
    padded = np.zeros((32, 48, 3), np.uint8)
    padded[:20, :35] = pixels
    tiles = [padded[top : top + 16, left : left + 16] for top in (0, 16) for left in (0, 16, 32)]
    if planar == 2:
        parts = [raw(tile[:, :, plane]) for plane in range(3) for tile in tiles]
    else:
        parts = [raw(tile) for tile in tiles]
    layout = tags(35, 20, 8, 3, 2, t322=16, t323=16, t284=planar)
    assert counts_of(picture(tiff(parts, layout, tiled=True)), 255) == pixel_counts(pixels)


@pytest.mark.parametrize("bits", [1, 2, 4, 6, 10, 12, 14])
@pytest.mark.parametrize("photometric", [0, 1])
def test_bits_that_do_not_fill_bytes(tiff, tags, noise, pixel_counts, counts_of, bits, photometric):
    pixels = noise(6, 11, 1, bits=bits)
    digits = ["".join(f"{value:0{bits}b}" for value in row) for row in pixels[:, :, 0]]
    rows = [row + "0" * (-len(row) % 8) for row in digits]  # each begins in a byte of its own
    data = b"".join(int(row, 2).to_bytes(len(row) // 8, "big") for row in rows)
    found = picture(tiff([data], tags(11, 6, bits, 1, photometric)))
    full = 2**bits - 1
    # Decoders scale to 8 or 16 bits.
    found = replace(found, values=np.round(found.values * full) / full)
    assert counts_of(found, full) == pixel_counts(pixels if photometric else full - pixels)


def test_palettes(tiff, tags, noise, pixel_counts, counts_of):
    pixels = noise(8, 6, 1, bits=4)
    palette = noise(16, 3, seed=3)
    row = (pixels[:, ::2, 0] << 4) | pixels[:, 1::2, 0]
    layout = tags(6, 8, 4, 1, 3) | {320: (3, (257 * palette.T.astype(int)).reshape(-1).tolist())}
    found = picture(tiff([row.tobytes()], layout))
    assert counts_of(found, 255) == pixel_counts(palette[pixels[:, :, 0]])


def test_alpha_is_divided_out_and_nothing_seen_is_dropped(tiff, tags):
    pixels = np.array([[[110, 50, 0, 200], [9, 9, 9, 0], [10, 20, 30, 255]]], np.uint8)
    found = picture(tiff([raw(pixels)], tags(3, 1, 8, 4, 2, t338=1)))
    rows = {tuple(row) for row in np.round(found.values * 255).astype(int).tolist()}
    assert rows == {(140, 64, 0), (10, 20, 30)}  # 110 · 255 / 200, rounded
    assert found.provenance["pixels"] == {"read": 3, "transparent": 1, "used": 2}
    straight = picture(tiff([raw(pixels)], tags(3, 1, 8, 4, 2, t338=2)))
    rows = {tuple(row) for row in np.round(straight.values * 255).astype(int).tolist()}
    assert rows == {(110, 50, 0), (10, 20, 30)}


def test_further_channels_are_named(tiff, tags, noise):
    found = picture(tiff([raw(noise(4, 4, 5))], tags(4, 4, 8, 5, 2, t338=0)))
    assert any("2 further channels" in warning for warning in found.warnings)


def test_cielab_has_signs(tiff, tags):
    """TIFF 6.0, section 23: L* 100 is 255, a* and b* are whole numbers with a sign."""
    pixels = np.array([[[255, 0, 0], [51, 0x80, 0x7F], [0, 0xFF, 1]]], np.uint8)
    found = picture(tiff([raw(pixels)], tags(3, 1, 8, 3, 8)))
    rows = {tuple(row) for row in found.values.round(9).tolist()}
    assert rows == {(100, 0, 0), (20, -128, 127), (0, -1, 1)}
    assert (found.model, found.meaning) == ("Lab", None)


def test_cielab_of_16_bits(tiff, tags):
    pixels = np.array([[[65535, 256, 0xFF00], [0, 0x8000, 128]]], np.uint16)
    found = picture(tiff([raw(pixels)], tags(2, 1, 16, 3, 8)))
    rows = {tuple(row) for row in found.values.round(9).tolist()}
    assert rows == {(100, 1, -1), (0, -128, 0.5)}


def test_icclab_is_offset(tiff, tags):
    """Photoshop technical notes: as profiles of version 2 have it."""
    eight = picture(tiff([bytes([255, 128, 0, 0, 255, 129])], tags(2, 1, 8, 3, 9)))
    assert {tuple(row) for row in eight.values.tolist()} == {(100, 0, -128), (0, 127, 1)}
    pixels = np.array([[[65280, 0x8000, 0], [0, 0x8100, 0x8080]]], np.uint16)
    sixteen = picture(tiff([raw(pixels)], tags(2, 1, 16, 3, 9)))
    assert {tuple(row) for row in sixteen.values.tolist()} == {(100, 0, -128), (0, 1, 0.5)}


def test_lab_as_floats(tiff, tags):
    values = np.array([[[100, 0, 0], [50, -60.5, 70.25]]], np.float32)
    found = picture(tiff([raw(values)], tags(2, 1, 32, 3, 8, t339=3)))
    order = np.argsort(found.values[:, 0])
    np.testing.assert_allclose(found.values[order], values[0][::-1], atol=1 / 512)


@pytest.mark.parametrize("bits", [16, 32])
def test_floats_without_a_profile_are_linear_light(tiff, tags, bits):
    values = np.array([[[0, 0.5, 1], [-0.25, 2, 0.001]]], f"f{bits // 8}")
    found = picture(tiff([raw(values)], tags(2, 1, bits, 3, 2, t339=3)))
    order = np.argsort(found.values[:, 0])
    np.testing.assert_allclose(
        np.cbrt(found.values[order]), np.cbrt(values[0][::-1].astype(float)), atol=1 / 16384
    )
    assert found.meaning.transfer == "linear"
    assert any("linear light" in warning for warning in found.warnings)


def test_floats_with_a_profile_are_its_values(tiff, tags):
    profile = (DATA / "DisplayP3-v4.icc").read_bytes()
    values = np.array([[[0, 0.5, 1], [-0.25, 2, 0.001]]], np.float32)
    found = picture(tiff([raw(values)], tags(2, 1, 32, 3, 2, t339=3) | {34675: (7, profile)}))
    rows = found.values[np.argsort(found.values[:, 1])]
    np.testing.assert_allclose(rows, [[0, 0.5, 1], [0, 1, 0.001]], atol=1 / 65535)
    assert any(warning.startswith("2 channel values") for warning in found.warnings)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_values_that_are_no_numbers(tiff, tags, value):
    values = np.full((3, 2, 3), 0.5, np.float32)
    values[1, 0, 2] = value
    with pytest.raises(InvalidPointsError, match="must be finite"):
        picture(tiff([raw(values)], tags(2, 3, 32, 3, 2, t339=3)))


def test_cmyk_has_the_profile_in_the_file(tiff, tags, noise, pixel_counts, counts_of, made_profile):
    pixels, profile = noise(6, 5, 4), made_profile({}, space="CMYK")
    found = picture(tiff([raw(pixels)], tags(5, 6, 8, 4, 5) | {34675: (7, profile)}))
    assert counts_of(found, 255) == pixel_counts(pixels)
    assert found.meaning.data == profile


def test_cmyk_needs_a_profile(tiff, tags, noise):
    with pytest.raises(UnsupportedPictureError, match="no embedded profile") as caught:
        picture(tiff([raw(noise(3, 3, 4))], tags(3, 3, 8, 4, 5)))
    assert caught.value.where == {"field": "profile"}


def test_the_first_of_several_pictures_is_used():
    file = io.BytesIO()
    first, other = (Image.new("RGB", (4, 4), colour) for colour in ((255, 0, 0), (0, 255, 0)))
    first.save(file, "TIFF", save_all=True, append_images=[other])
    found = picture(file.getvalue())
    assert any("several pictures" in warning for warning in found.warnings)
    np.testing.assert_array_equal(found.values, [[1, 0, 0]])


@pytest.mark.parametrize(
    "more",
    [
        {"t259": 4},  # fax compression of 8 bits
        {"t259": 50000},  # Zstandard
        {"t262": 32845},  # LogLuv
        {"t339": 2},  # integers with a sign
        {"t259": 8, "t317": 4},  # an unknown predictor
    ],
)
def test_unsupported_kinds(tiff, tags, noise, more):
    with pytest.raises((UnsupportedPictureError, MalformedFileError)) as caught:
        picture(tiff([raw(noise(3, 3, 3))], tags(3, 3, 8, 3, 2, **more)))
    assert caught.value.remedy


def test_64_bit_floats_are_refused(tiff, tags):
    """OpenImageIO 3.2 returns undefined values for them."""
    with pytest.raises(UnsupportedPictureError, match="double"):
        picture(tiff([raw(np.ones((1, 2, 3)))], tags(2, 1, 64, 3, 2, t339=3)))


def test_pictures_that_are_too_large(tiff, tags):
    with pytest.raises(PictureSizeError):
        picture(tiff([bytes(90)], tags(100_000, 100_000, 8, 3, 2)))


def test_every_cut_of_a_file_is_refused(tiff, tags, noise):
    data = tiff([raw(noise(3, 3, 3))], tags(3, 3, 8, 3, 2))
    for size in range(4, len(data) - 8):
        with pytest.raises(GamutError):
            picture(data[:size])


def separated(tiff, tags, made_profile, pixels, names=b"", extra=(), space="CMYK"):
    """Return a TIFF of separated inks (TIFF 6.0, section 16), and its profile."""
    fields = tags(*pixels.shape[1::-1], 8, pixels.shape[2], 5)
    fields[34675] = (7, made_profile({}, space=space))
    if names:
        fields |= {332: (3, [2]), 333: (2, names)}
    if extra:
        fields[338] = (3, list(extra))
    return tiff([pixels.tobytes()], fields)


@pytest.mark.parametrize(
    ("names", "places", "unused"),
    [
        (b"Cyan\0Magenta\0Yellow\0Black\0Orange\0", [0, 1, 2, 3], "Orange"),
        (b"Black\0PANTONE 300 C\0Yellow\0Magenta\0Cyan\0", [4, 3, 2, 0], "PANTONE 300 C"),
        (b"Process Cyan\0Process Magenta\0Process Yellow\0Process Black\0Gloss\0",
         [0, 1, 2, 3], "Gloss"),
    ],
)  # fmt: skip
def test_inks_are_found_by_their_names(
    tiff, tags, made_profile, noise, counts_of, pixel_counts, names, places, unused
):
    pixels = noise(6, 5, 5)
    found = picture(separated(tiff, tags, made_profile, pixels, names))
    assert counts_of(found, 255) == pixel_counts(pixels[:, :, places])
    assert f"1 further channel of the picture ({unused}) is not used." in found.warnings


@pytest.mark.parametrize("kind", [1, 2])
def test_alpha_beside_spot_colours(tiff, tags, made_profile, noise, counts_of, pixel_counts, kind):
    """ExtraSamples: 0 is unspecified, 1 associated and 2 unassociated alpha (section 18)."""
    pixels = noise(6, 5, 6)
    pixels[:, :, 5] = 255
    pixels[:2, :, 5] = 0
    found = picture(separated(tiff, tags, made_profile, pixels, extra=(0, kind)))
    assert counts_of(found, 255) == pixel_counts(pixels[2:, :, :4])
    assert "1 further channel of the picture is not used." in found.warnings


def test_associated_alpha_is_divided_out(tiff, tags, made_profile):
    pixels = np.array([[[100, 50, 20, 0, 128]]], np.uint8)
    found = picture(separated(tiff, tags, made_profile, pixels, extra=(1,)))
    np.testing.assert_allclose(found.values[0] * 255, np.array([199, 100, 40, 0]), atol=0.6)


@pytest.mark.parametrize(
    ("channels", "names", "extra", "space", "message"),
    [
        (4, b"Orange\0Green\0Violet\0Black\0", (), "CMYK", "Orange, Green, Violet, Black"),
        (4, b"", (2,), "CMYK", "3 inks"),
        (6, b"", (0, 0), "6CLR", "6 inks and a profile of 6CLR"),
        (5, b"C\0M\0Y\0K\0O\0", (), "5CLR", "5 inks .C, M, Y, K, O. and a profile of 5CLR"),
    ],
)
def test_other_inks_are_refused_by_name(
    tiff, tags, made_profile, noise, channels, names, extra, space, message
):
    data = separated(tiff, tags, made_profile, noise(4, 4, channels), names, extra, space)
    with pytest.raises(UnsupportedPictureError, match=message) as caught:
        picture(data)
    assert caught.value.where == {"field": "channels"}
