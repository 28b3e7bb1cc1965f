import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation import characterisation as picture
from gamutcore.characterisation.icc import IccProfile
from gamutcore.errors import GamutError, MalformedFileError, PictureSizeError

DATA = Path(__file__).parents[4] / "data"
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}


@pytest.mark.usefixtures("bands")
@pytest.mark.parametrize("interlaced", [0, 1])
@pytest.mark.parametrize("filtered", [0, 1])
@pytest.mark.parametrize(
    ("colour", "depth"),
    [(0, 1), (0, 2), (0, 4), (0, 8), (0, 16), (2, 8), (2, 16), (4, 8), (4, 16), (6, 8), (6, 16)],
)
def test_every_kind_bit_for_bit(
    png, noise, pixel_counts, counts_of, colour, depth, filtered, interlaced
):
    pixels = noise(9, 14, CHANNELS[colour], bits=depth)
    if colour in {4, 6}:
        pixels[::2, :, -1] = 0  # transparent
    found = picture(png(pixels, depth, colour, filtered=filtered, interlaced=interlaced))
    seen = pixels
    if colour in {4, 6}:
        seen = pixels[pixels[:, :, -1] > 0][:, :-1]
    assert counts_of(found, 2**depth - 1) == pixel_counts(seen)
    assert found.model == ("gray" if colour in {0, 4} else "RGB")
    assert found.provenance["bit_depth"] == depth
    assert found.provenance["size"] == [14, 9]
    pixel_numbers = found.provenance["pixels"]
    assert pixel_numbers["read"] == 126
    assert pixel_numbers["used"] == int(found.counts.sum())
    assert pixel_numbers["transparent"] == 126 - pixel_numbers["used"]


@pytest.mark.usefixtures("bands")
@pytest.mark.parametrize("depth", [1, 2, 4, 8])
def test_palettes(png, noise, pixel_counts, counts_of, depth):
    pixels = noise(9, 14, 1, bits=depth)
    palette = noise(2**depth, 3, seed=1)
    alpha = np.full(2**depth, 255)
    alpha[0] = 0
    chunks = (png.chunk(b"PLTE", palette.tobytes()), png.chunk(b"tRNS", b"\0"))
    found = picture(png(pixels, depth, 3, *chunks))
    seen = palette[pixels[:, :, 0]][pixels[:, :, 0] > 0]
    assert counts_of(found, 255) == pixel_counts(seen)


def test_one_colour_may_be_transparent(png, noise, pixel_counts, counts_of):
    pixels = noise(9, 14, 3)
    pixels[:3] = (1, 2, 3)
    found = picture(png(pixels, 8, 2, png.chunk(b"tRNS", struct.pack(">3H", 1, 2, 3))))
    assert counts_of(found, 255) == pixel_counts(pixels[3:])


def test_nothing_but_transparent_pixels(png, noise):
    pixels = noise(4, 4, 4)
    pixels[:, :, 3] = 0
    with pytest.raises(GamutError, match="transparent"):
        picture(png(pixels, 8, 6))


def profile_chunk(png, profile):
    return png.chunk(b"iCCP", b"a name\0\0" + zlib.compress(profile))


def test_the_embedded_profile_is_taken(png, noise):
    profile = (DATA / "DisplayP3-v4.icc").read_bytes()
    found = picture(png(noise(4, 4, 3), 8, 2, profile_chunk(png, profile)))
    assert isinstance(found.meaning, IccProfile)
    assert found.meaning.data == profile
    assert found.provenance["profile"]["colour_space"] == "RGB"
    assert found.warnings == ()


def test_code_points_go_before_the_profile_and_others_do_not(png, noise):
    profile = profile_chunk(png, (DATA / "DisplayP3-v4.icc").read_bytes())
    pixels = noise(4, 4, 3)
    points = png.chunk(b"cICP", bytes([9, 16, 0, 1]))
    assert picture(png(pixels, 8, 2, profile, points)).meaning.name == "BT.2020, PQ"
    unknown = png.chunk(b"cICP", bytes([99, 99, 0, 1]))
    found = picture(png(pixels, 8, 2, unknown, profile))
    assert isinstance(found.meaning, IccProfile)
    assert "99, 99, 0" in found.warnings[0]
    gamma = png.chunk(b"gAMA", struct.pack(">I", 100_000))
    assert isinstance(picture(png(pixels, 8, 2, gamma, profile)).meaning, IccProfile)
    srgb = png.chunk(b"sRGB", b"\0")
    assert picture(png(pixels, 8, 2, gamma, srgb)).meaning.name == "sRGB"
    assert picture(png(pixels, 8, 2, gamma)).meaning.gamma == 1.0


def test_without_anything_srgb_is_assumed_and_said(png, noise):
    found = picture(png(noise(4, 4, 3), 8, 2))
    assert found.provenance["encoding"] == {"name": "sRGB", "from": "assumed"}
    assert any("sRGB is assumed" in warning for warning in found.warnings)


def test_narrow_range_is_16_to_235(png):
    pixels = np.array([[[16, 235, 16]], [[235, 16, 235]], [[0, 255, 125]]], np.uint8)
    found = picture(png(pixels, 8, 2, png.chunk(b"cICP", bytes([1, 13, 0, 0]))))
    wide = {tuple(row) for row in np.round(found.values, 3).tolist()}
    assert {(0, 1, 0), (1, 0, 1)} <= wide
    assert any(row[:2] == (0, 1) and 0.49 < row[2] < 0.51 for row in wide)


def test_a_gray_picture_may_have_an_rgb_profile_and_not_the_other_way(png, noise):
    rgb = profile_chunk(png, (DATA / "DisplayP3-v4.icc").read_bytes())
    gray = profile_chunk(png, (DATA / "sGrey-v4.icc").read_bytes())
    assert isinstance(picture(png(noise(4, 4, 1), 8, 0, rgb)).meaning, IccProfile)
    with pytest.raises(MalformedFileError, match="profile is for gray"):
        picture(png(noise(4, 4, 3), 8, 2, gray))


@pytest.mark.parametrize("size", [(60_000, 60_000), (20_000, 20_000), (1_000_000, 150)])
def test_pictures_that_are_too_large(png, size):
    header = struct.pack(">IIBBBBB", *size, 8, 2, 0, 0, 0)
    data = png.chunk(b"IDAT", zlib.compress(bytes(1000)))
    with pytest.raises(PictureSizeError) as caught:
        picture(PNG_SIGNATURE + png.chunk(b"IHDR", header) + data + png.chunk(b"IEND", b""))
    assert caught.value.where == {"field": "size"}


@pytest.mark.slow
def test_a_profile_that_unpacks_to_too_much(png, noise):
    bomb = png.chunk(b"iCCP", b"a name\0\0" + zlib.compress(bytes(200_000_000), 9))
    with pytest.raises(GamutError, match="embedded profile"):
        picture(png(noise(4, 4, 3), 8, 2, bomb))


@pytest.mark.parametrize("cut", [10, 20, 40, -20])
def test_a_file_that_ends_early(png, noise, cut):
    with pytest.raises(MalformedFileError):
        picture(png(noise(9, 9, 3), 8, 2)[:cut])


def test_damaged_pixels_are_refused(png, noise):
    data = bytearray(png(noise(9, 9, 3), 8, 2))
    data[data.index(b"IDAT") + 10] ^= 1
    with pytest.raises(MalformedFileError, match="cannot be decoded") as caught:
        picture(bytes(data))
    assert caught.value.where["row"] >= 1


def test_a_damaged_profile_is_not_ignored(png, noise):
    """The decoder drops such a profile, and the colours would be taken for sRGB."""
    data = bytearray(png(noise(9, 9, 3), 8, 2, profile_chunk(png, b"no profile" * 20)))
    with pytest.raises(GamutError, match="embedded profile"):
        picture(bytes(data))


@given(st.binary(max_size=200))
def test_any_bytes_behind_the_signature_are_refused_by_name(data):
    with pytest.raises(GamutError):
        picture(PNG_SIGNATURE + data)
