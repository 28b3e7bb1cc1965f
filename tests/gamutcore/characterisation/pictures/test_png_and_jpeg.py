"""PNG, written by hand, and JPEG: values, profiles, encodings, and files that break the format."""

import io
import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from gamutcore.characterisation import IccProfile
from gamutcore.characterisation import read_characterisation as picture
from gamutcore.errors import (
    GamutError,
    MalformedFileError,
    MalformedProfileError,
    PictureSizeError,
    PictureWorkError,
    UnsupportedPictureError,
)

DATA = Path(__file__).parents[3] / "data"


PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}


@pytest.mark.usefixtures("bands")
@pytest.mark.parametrize(
    ("colour", "depth"),
    [(0, 1), (0, 2), (0, 4), (0, 8), (0, 16), (2, 8), (2, 16), (4, 8), (4, 16), (6, 8), (6, 16)],
)
def test_every_kind_bit_for_bit(png, noise, pixel_counts, counts_of, colour, depth):
    pixels = noise(9, 14, CHANNELS[colour], bits=depth)
    if colour in {4, 6}:
        pixels[::2, :, -1] = 0  # transparent
    found = picture(png(pixels, depth, colour))
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
def test_palettes(png, chunk, noise, pixel_counts, counts_of, depth):
    pixels = noise(9, 14, 1, bits=depth)
    palette = noise(2**depth, 3, seed=1)
    alpha = np.full(2**depth, 255)
    alpha[0] = 0
    chunks = (chunk(b"PLTE", palette.tobytes()), chunk(b"tRNS", b"\0"))
    found = picture(png(pixels, depth, 3, *chunks))
    seen = palette[pixels[:, :, 0]][pixels[:, :, 0] > 0]
    assert counts_of(found, 255) == pixel_counts(seen)


def test_one_colour_may_be_transparent(png, chunk, noise, pixel_counts, counts_of):
    pixels = noise(9, 14, 3)
    pixels[:3] = (1, 2, 3)
    found = picture(png(pixels, 8, 2, chunk(b"tRNS", struct.pack(">3H", 1, 2, 3))))
    assert counts_of(found, 255) == pixel_counts(pixels[3:])


def test_nothing_but_transparent_pixels(png, noise):
    pixels = noise(4, 4, 4)
    pixels[:, :, 3] = 0
    with pytest.raises(GamutError, match="transparent"):
        picture(png(pixels, 8, 6))


def profile_chunk(chunk, profile):
    return chunk(b"iCCP", b"a name\0\0" + zlib.compress(profile))


def test_the_embedded_profile_is_taken(png, chunk, noise):
    profile = (DATA / "DisplayP3-v4.icc").read_bytes()
    found = picture(png(noise(4, 4, 3), 8, 2, profile_chunk(chunk, profile)))
    assert isinstance(found.meaning, IccProfile)
    assert found.meaning.data == profile
    assert found.provenance["profile"]["colour_space"] == "RGB"
    assert found.warnings == ()


def test_code_points_go_before_the_profile_and_others_do_not(png, chunk, noise):
    profile = profile_chunk(chunk, (DATA / "DisplayP3-v4.icc").read_bytes())
    pixels = noise(4, 4, 3)
    points = chunk(b"cICP", bytes([9, 16, 0, 1]))
    assert picture(png(pixels, 8, 2, profile, points)).meaning.name == "BT.2020, PQ"
    unknown = chunk(b"cICP", bytes([99, 99, 0, 1]))
    found = picture(png(pixels, 8, 2, unknown, profile))
    assert isinstance(found.meaning, IccProfile)
    assert "99, 99, 0" in found.warnings[0]
    gamma = chunk(b"gAMA", struct.pack(">I", 100_000))
    assert isinstance(picture(png(pixels, 8, 2, gamma, profile)).meaning, IccProfile)
    srgb = chunk(b"sRGB", b"\0")
    assert picture(png(pixels, 8, 2, gamma, srgb)).meaning.name == "sRGB"
    assert picture(png(pixels, 8, 2, gamma)).meaning.gamma == 1.0


def test_without_anything_srgb_is_assumed_and_said(png, noise):
    found = picture(png(noise(4, 4, 3), 8, 2))
    assert found.provenance["encoding"] == {"name": "sRGB", "from": "assumed"}
    assert any("sRGB is assumed" in warning for warning in found.warnings)


def corners(*numbers):
    """Return the content of cHRM: white, red, green and blue (W3C PNG, third edition, 11.3.2.1)."""
    return struct.pack(">8i", *(round(number * 100_000) for number in numbers))


SRGB_CORNERS = (0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15, 0.06)
GAMMA = struct.pack(">I", 45455)


@pytest.mark.parametrize(
    ("gamma", "numbers", "field"),
    [
        (bytes(4), SRGB_CORNERS, "gAMA"),
        (struct.pack(">I", 2**31), SRGB_CORNERS, "gAMA"),
        (GAMMA[:3], SRGB_CORNERS, "gAMA"),
        (GAMMA, (0.3127, 0.0, *SRGB_CORNERS[2:]), "cHRM"),
        (GAMMA, (0.64, 0.2, *SRGB_CORNERS[2:]), "cHRM"),
        (GAMMA, (0.3127, 0.3290, 0.1, 0.1, 0.3, 0.3, 0.5, 0.5), "cHRM"),
        (GAMMA, (0.3127, 0.3290, *[0.0] * 6), "cHRM"),
    ],
)
def test_impossible_encodings_are_refused_and_not_taken_for_srgb(
    png, chunk, noise, gamma, numbers, field
):
    chunks = chunk(b"gAMA", gamma), chunk(b"cHRM", corners(*numbers))
    with pytest.raises(MalformedFileError) as caught:
        picture(png(noise(4, 4, 3), 8, 2, *chunks))
    assert caught.value.where == {"field": field}


def test_chunks_that_contradict_srgb_are_said(png, chunk, noise):
    srgb, pixels = chunk(b"sRGB", b"\0"), noise(4, 4, 3)
    p3 = chunk(b"cHRM", corners(0.3127, 0.3290, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06))
    found = picture(png(pixels, 8, 2, srgb, chunk(b"gAMA", GAMMA), p3))
    assert found.meaning.name == "sRGB"
    assert found.warnings == ("The chunk cHRM contradicts the chunk sRGB, and is not used.",)
    same = chunk(b"cHRM", corners(*SRGB_CORNERS))
    assert picture(png(pixels, 8, 2, srgb, chunk(b"gAMA", GAMMA), same)).warnings == ()


def test_misplaced_code_points_are_said(png, chunk, noise):
    """They stand before the palette and the pixels (W3C PNG, third edition, 5.6)."""
    points = chunk(b"cICP", bytes([9, 16, 0, 1]))
    data, end = png(noise(4, 4, 3), 8, 2), chunk(b"IEND", b"")
    palette = chunk(b"PLTE", bytes(12))
    for misplaced in (
        data.replace(end, points + end),
        png(noise(4, 4, 3), 8, 2, palette, points),
        png(noise(4, 4, 3), 8, 2, chunk(b"cICP", bytes(3))),
    ):
        found = picture(misplaced)
        assert found.meaning.name == "sRGB"
        assert any("cICP is misplaced or damaged" in warning for warning in found.warnings)


def test_code_points_without_a_meaning_are_refused_where_nothing_else_is_declared(
    png, chunk, noise
):
    with pytest.raises(UnsupportedPictureError) as caught:
        picture(png(noise(4, 4, 3), 8, 2, chunk(b"cICP", bytes([99, 99, 0, 1]))))
    assert caught.value.where == {"field": "CICP"}
    unspecified = chunk(b"cICP", bytes([2, 2, 0, 1]))
    found = picture(png(noise(4, 4, 3), 8, 2, unspecified))
    assert found.provenance["encoding"]["from"] == "assumed"


def test_narrow_range_is_16_to_235(png, chunk):
    pixels = np.array([[[16, 235, 16]], [[235, 16, 235]], [[0, 255, 125]]], np.uint8)
    found = picture(png(pixels, 8, 2, chunk(b"cICP", bytes([1, 13, 0, 0]))))
    wide = {tuple(row) for row in np.round(found.values, 3).tolist()}
    assert {(0, 1, 0), (1, 0, 1)} <= wide
    assert any(row[:2] == (0, 1) and 0.49 < row[2] < 0.51 for row in wide)


def test_a_gray_picture_may_have_an_rgb_profile_and_not_the_other_way(png, chunk, noise):
    rgb = profile_chunk(chunk, (DATA / "DisplayP3-v4.icc").read_bytes())
    gray = profile_chunk(chunk, (DATA / "sGrey-v4.icc").read_bytes())
    assert isinstance(picture(png(noise(4, 4, 1), 8, 0, rgb)).meaning, IccProfile)
    with pytest.raises(MalformedFileError, match="profile is for gray"):
        picture(png(noise(4, 4, 3), 8, 2, gray))


@pytest.mark.parametrize("size", [(60_000, 60_000), (20_000, 20_000), (1_000_000, 150)])
def test_pictures_that_are_too_large(chunk, size):
    header = struct.pack(">IIBBBBB", *size, 8, 2, 0, 0, 0)
    data = chunk(b"IDAT", zlib.compress(bytes(1000)))
    with pytest.raises(PictureSizeError) as caught:
        picture(PNG_SIGNATURE + chunk(b"IHDR", header) + data + chunk(b"IEND", b""))
    assert caught.value.where == {"field": "size"}


@pytest.mark.slow
def test_a_profile_that_unpacks_to_too_much(png, chunk, noise):
    bomb = chunk(b"iCCP", b"a name\0\0" + zlib.compress(bytes(200_000_000), 9))
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


def test_a_damaged_profile_is_not_ignored(png, chunk, noise):
    """The decoder drops such a profile, and the colours would be taken for sRGB."""
    data = bytearray(png(noise(9, 9, 3), 8, 2, profile_chunk(chunk, b"no profile" * 20)))
    with pytest.raises(GamutError, match="embedded profile"):
        picture(bytes(data))


@given(st.binary(max_size=200))
def test_any_bytes_behind_the_signature_are_refused_by_name(data):
    with pytest.raises(GamutError):
        picture(PNG_SIGNATURE + data)


def jpeg(mode, colours, **how):
    """Return a picture of fields of 16 × 16 pixels, which JPEG hardly changes."""
    fields = np.repeat(np.repeat(np.array(colours, np.uint8)[np.newaxis], 16, axis=0), 16, axis=1)
    file = io.BytesIO()
    written = Image.frombytes(mode, fields.shape[1::-1], fields.tobytes())
    # Without subsampling: chroma is smoothed where it is unpacked.
    written.save(file, "JPEG", **{"quality": 100, "subsampling": 0, **how})
    return file.getvalue()


FIELDS = [(255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255), (12, 100, 200)]


def values_near(found, colours, full=255, tolerance=2.0):
    distances = np.abs(found.values[:, np.newaxis] * full - np.array(colours, float)).max(axis=2)
    return (distances.min(axis=0) <= tolerance).all() and (distances.min(axis=1) <= tolerance).all()


@pytest.mark.parametrize(
    "how", [{}, {"progressive": True}, {"restart_marker_rows": 1}, {"optimize": True}]
)
def test_jpeg_of_every_layout(how):
    found = picture(jpeg("RGB", FIELDS, **how))
    assert values_near(found, FIELDS)
    assert found.counts.sum() == 16 * 16 * len(FIELDS)
    assert (found.format, found.model) == ("jpeg", "RGB")


def without_adobe(data):
    return re.sub(rb"\xff\xee\0\x0eAdobe.{7}", b"", data, flags=re.DOTALL)


def test_components_named_r_g_b_are_not_converted():
    """As libjpeg reads them, where no marker says otherwise."""
    stored = without_adobe(jpeg("RGB", FIELDS, keep_rgb=True))
    stored = re.sub(rb"\xff\xe0\0\x10JFIF.{11}", b"", stored, flags=re.DOTALL)
    assert values_near(picture(stored), FIELDS)


def test_cmyk_of_adobe_is_turned_over(shared_data):
    inks = [(0, 0, 0, 0), (255, 0, 0, 0), (0, 255, 0, 0), (10, 20, 30, 255)]
    profile = (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()
    found = picture(jpeg("CMYK", inks, icc_profile=profile))  # 1.8 MB: 28 segments of 64 KB
    assert values_near(found, inks)
    assert isinstance(found.meaning, IccProfile)
    assert found.meaning.data == profile
    assert found.warnings == ()


def test_a_part_of_the_profile_is_missing():
    data = jpeg("RGB", FIELDS, icc_profile=(DATA / "DisplayP3-v4.icc").read_bytes())
    place = data.index(b"ICC_PROFILE\0") + 12
    with pytest.raises(MalformedProfileError, match="embedded profile"):
        picture(data[: place + 1] + b"\2" + data[place + 2 :])


def parts_of(profile, *numbers):
    """Return the segments APP2 of a profile cut in two (ICC.1:2022, B.4), by number and count."""
    halves = {1: profile[:300], 2: profile[300:]}
    segments = b""
    for number, count in numbers:
        part = profile if count == 1 else halves.get(number, b"")
        content = b"ICC_PROFILE\0" + bytes([number, count]) + part
        segments += b"\xff\xe2" + struct.pack(">H", len(content) + 2) + content
    return segments


def with_segments(segments):
    data = jpeg("RGB", FIELDS)
    return data[:2] + segments + data[2:]


@pytest.mark.parametrize(
    "numbers",
    [
        [(1, 2), (2, 2)],
        [(2, 2), (1, 2)],
        [(1, 2), (2, 2), (1, 2), (2, 2)],
        [(1, 1), (1, 2), (2, 2)],
    ],
)
def test_parts_of_a_profile_in_any_order_and_equal_copies(numbers):
    profile = (DATA / "DisplayP3-v4.icc").read_bytes()
    found = picture(with_segments(parts_of(profile, *numbers)))
    assert found.meaning.data == profile


@pytest.mark.parametrize(
    "numbers",
    [[(2, 2)], [(1, 2)], [(1, 2), (2, 3)], [(0, 2), (1, 2)], [(0, 0)], [(1, 1), (1, 2)]],
)
def test_incomplete_profiles_are_refused(numbers):
    profile = (DATA / "DisplayP3-v4.icc").read_bytes()
    with pytest.raises(MalformedProfileError) as caught:
        picture(with_segments(parts_of(profile, *numbers)))
    assert caught.value.where == {"field": "profile"}


def test_two_profiles_that_differ_are_refused():
    names = ("DisplayP3-v4.icc", "sRGB-v4.icc")
    segments = [parts_of((DATA / name).read_bytes(), (1, 1)) for name in names]
    with pytest.raises(MalformedProfileError, match="differ"):
        picture(with_segments(b"".join(segments)))


def test_the_profile_of_a_further_picture_is_not_that_of_the_first():
    profile = (DATA / "DisplayP3-v4.icc").read_bytes()
    listed = b"MPF\0" + bytes(20)
    first = with_segments(b"\xff\xe2" + struct.pack(">H", len(listed) + 2) + listed)
    found = picture(first + with_segments(parts_of(profile, (1, 1))))
    assert found.provenance["encoding"]["from"] == "assumed"
    assert "The file holds several pictures; the first is used." in found.warnings


XMP = b"http://ns.adobe.com/xap/1.0/\0<x:xmpmeta/>"


@pytest.mark.parametrize(
    ("marker", "content", "in_second", "has_gain_map"),
    [
        (0xE1, XMP + b"http://ns.adobe.com/hdr-gain-map/1.0/", False, True),
        (0xE1, XMP + b"http://ns.adobe.com/hdr-gain-map/1.0/", True, True),
        (0xE2, b"urn:iso:std:iso:ts:21496:-1\0\0\0\0\0", False, True),
        (0xE1, XMP + b"urn:com:apple:photo:2020:aux:hdrgainmap", True, True),
        (0xE1, XMP, True, False),
        (0xE1, b"Exif\0\0" + XMP + b"http://ns.adobe.com/hdr-gain-map/1.0/", False, False),
    ],
)
def test_gain_maps_are_said(marker, content, in_second, has_gain_map):
    """Adobe, Gain Map specification; ISO 21496-1; Apple's HDR pictures."""
    segment = bytes([0xFF, marker]) + struct.pack(">H", len(content) + 2) + content
    plain, changed = jpeg("RGB", FIELDS), with_segments(segment)
    found = picture(plain + changed if in_second else changed + plain)
    assert any("gain map" in warning for warning in found.warnings) == has_gain_map


def exif(space, interoperability=b""):
    """Return Exif that states a colour space (Exif 3.0, 4.6.6.2; DCF 2.0 for R03)."""
    linked = struct.pack("<HHII", 40965, 4, 1, 56) if interoperability else bytes(12)
    return (
        b"Exif\0\0II*\0\x08\0\0\0"
        + struct.pack("<HHHIII", 1, 34665, 4, 1, 26, 0)
        + struct.pack("<HHHIHH", 2, 40961, 3, 1, space, 0)
        + linked
        + bytes(4)
        + struct.pack("<HHHI4sI", 1, 1, 2, 4, interoperability, 0)
    )


@pytest.mark.parametrize(
    ("metadata", "name", "source"),
    [
        (exif(1), "sRGB", "the file"),
        (exif(0xFFFF, b"R03\0"), "Adobe RGB (1998)", "the file"),
        (exif(0xFFFF, b"R98\0"), "sRGB", "assumed"),
        (exif(0xFFFF)[:20], "sRGB", "assumed"),
    ],
)
def test_exif_states_the_colour_space(metadata, name, source):
    found = picture(jpeg("RGB", FIELDS, exif=metadata))
    assert found.provenance["encoding"] == {"name": name, "from": source}


def with_size(data, width, height):
    place = data.index(b"\xff\xc0")
    return data[: place + 5] + struct.pack(">HH", height, width) + data[place + 9 :]


def test_impossible_sizes():
    with pytest.raises(PictureSizeError):
        picture(with_size(jpeg("RGB", FIELDS), 65_000, 65_000))
    with pytest.raises(GamutError):
        picture(with_size(jpeg("RGB", FIELDS), 0, 9))


def with_scans(scans):
    """A progressive JPEG of so many scans: the last is repeated."""
    data = jpeg("RGB", FIELDS, progressive=True)
    last = data[data.rindex(b"\xff\xda") : -2]
    return data[:-2] + last * (scans - data.count(b"\xff\xda")) + data[-2:]


def test_a_jpeg_has_as_many_scans_as_writers_write_and_not_more():
    thumbnails = 200 * b"\xff\xda\0\2"
    segment = b"\xff\xe1" + struct.pack(">H", len(thumbnails) + 2) + thumbnails
    most = with_scans(100)
    assert values_near(picture(most[:2] + segment + most[2:]), FIELDS)
    with pytest.raises(PictureWorkError, match="more than 100 scans") as caught:
        picture(with_scans(101))
    assert caught.value.where == {"field": "scans"}
    assert "baseline" in caught.value.remedy


def test_twelve_bits():
    data = bytearray(jpeg("RGB", FIELDS))
    data[data.index(b"\xff\xc0") + 4] = 12
    with pytest.raises(UnsupportedPictureError, match="precision 12"):
        picture(bytes(data))
