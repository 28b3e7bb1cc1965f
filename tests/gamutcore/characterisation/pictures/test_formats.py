"""Formats besides PNG, JPEG and TIFF, the encodings that pictures declare, and distinct values."""

import io
import struct
import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from PIL import Image

from gamutcore import Gamut
from gamutcore.characterisation import IccProfile, Picture, read_characterisation
from gamutcore.characterisation.pictures.encoding import (
    ADOBE_RGB,
    SRGB,
    chromaticity_encoding,
    code_point_encoding,
    named_encoding,
)
from gamutcore.characterisation.pictures.picture import distinct_values
from gamutcore.characterisation.pictures.raster import _decoder_message
from gamutcore.errors import (
    GamutError,
    InvalidPointsError,
    MalformedFileError,
    MalformedProfileError,
    OptionError,
    PictureSizeError,
    UnsupportedPictureError,
)

DATA = Path(__file__).parents[3] / "data"
FIELDS = np.array(
    [[0.9, 0.1, 0.1], [0.1, 0.8, 0.2], [0.1, 0.1, 0.9], [0.5, 0.5, 0.5], [1, 1, 1], [0, 0, 0]]
)


@pytest.fixture
def written(tmp_path):
    """Return a function that writes fields of 16 × 16 pixels, which lossy formats hardly change."""

    def write(extension, sample_type, colours=FIELDS, **attributes):
        pixels = np.repeat(np.repeat(colours[np.newaxis], 16, axis=0), 16, axis=1)
        spec = oiio.ImageSpec(pixels.shape[1], 16, pixels.shape[2], sample_type)
        spec.channelnames = list(attributes.pop("names", "RGBA"[: pixels.shape[2]]))
        for name, value in attributes.items():
            kinds = {"chromaticities": "float[8]", "CICP": "int[4]"}
            if name in kinds:
                spec.attribute(name, oiio.TypeDesc(kinds[name]), value)
            else:
                spec.attribute(name.replace("__", ":"), value)
        path = tmp_path / f"picture{extension}"
        output = oiio.ImageOutput.create(str(path))
        assert output.open(str(path), spec)
        assert output.write_image(np.ascontiguousarray(pixels, np.float32))
        assert output.close()
        return path.read_bytes()

    return write


def has_values(found, colours, tolerance):
    distance = np.abs(found.values[:, np.newaxis] - colours).max(axis=2)
    return (distance.min(axis=0) <= tolerance).all() and (distance.min(axis=1) <= tolerance).all()


@pytest.mark.parametrize(
    ("extension", "sample_type", "name", "tolerance"),
    [
        (".png", "uint16", "png", 1e-5),
        (".tif", "uint16", "tiff", 1e-5),
        (".exr", "half", "exr", 1e-3),
        (".exr", "float", "exr", 1e-3),
        (".hdr", "float", "hdr", 0.01),
        (".jxl", "uint8", "jpeg-xl", 0.02),
        (".jxl", "uint16", "jpeg-xl", 0.02),
        (".dpx", "uint16", "dpx", 1e-5),
    ],
)
def test_formats(written, extension, sample_type, name, tolerance):
    found = read_characterisation(written(extension, sample_type))
    assert (found.format, found.model) == (name, "RGB")
    assert has_values(found, FIELDS, tolerance)
    assert found.counts.sum() == 16 * 16 * len(FIELDS)


@pytest.mark.parametrize(
    ("extension", "name", "how"),
    [(".webp", "webp", {"lossless": True}), (".jp2", "jpeg-2000", {})],
)
def test_formats_that_pillow_writes_without_loss(tmp_path, extension, name, how):
    pixels = np.round(np.repeat(FIELDS[np.newaxis], 16, axis=0) * 255).astype(np.uint8)
    profile = (DATA / "DisplayP3-v4.icc").read_bytes()
    path = tmp_path / f"picture{extension}"
    Image.fromarray(pixels).save(path, icc_profile=profile if name == "webp" else None, **how)
    found = read_characterisation(path.read_bytes())
    assert found.format == name
    assert has_values(found, FIELDS, 0.5 / 255 + 1e-9)
    assert isinstance(found.meaning, IccProfile) == (name == "webp")


ALPHA = np.array([255, 128, 255, 0, 1, 255], np.uint8)


def by_pillow(file_format, mode="RGB", frames=1, **how):
    """Fields of 16 × 16 pixels; later frames are black."""
    rows = np.round(FIELDS * 255).astype(np.uint8)
    rows = np.column_stack([rows, ALPHA]) if mode == "RGBA" else rows
    pixels = np.repeat(np.repeat(rows[np.newaxis], 16, axis=0), 16, axis=1)
    image = Image.fromarray(pixels)
    image = image.quantize() if mode == "P" else image
    if frames > 1:
        black = Image.new("RGB", image.size)
        how |= {"save_all": True, "append_images": [black] * (frames - 1)}
    file = io.BytesIO()
    image.save(file, file_format, **how)
    return file.getvalue()


LOSSLESS = {"lossless": True, "exact": True}


@pytest.mark.parametrize(
    ("data", "name", "tolerance", "transparent", "several"),
    [
        (by_pillow("WEBP", quality=95), "webp", 0.1, 0, False),
        (by_pillow("WEBP", **LOSSLESS), "webp", 1e-9, 0, False),
        (by_pillow("WEBP", "RGBA", **LOSSLESS), "webp", 1e-9, 256, False),
        (by_pillow("WEBP", frames=3, **LOSSLESS), "webp", 1e-9, 0, True),
        (by_pillow("GIF"), "gif", 1e-9, 0, False),
        (by_pillow("GIF", "RGBA"), "gif", 1e-9, 256, False),
        (by_pillow("GIF", frames=3), "gif", 1e-9, 0, True),
        (by_pillow("BMP"), "bmp", 1e-9, 0, False),
        (by_pillow("BMP", "P"), "bmp", 1e-9, 0, False),
    ],
)
def test_webp_gif_and_bmp_are_read_without_a_report_of_damage(
    data, name, tolerance, transparent, several
):
    found = read_characterisation(data)
    assert (found.format, found.model) == (name, "RGB")
    used = [index for index in range(6) if index != 3 or not transparent]
    fields = np.round(FIELDS[used] * 255) / 255
    distance = np.abs(found.values[:, np.newaxis] - fields).max(axis=2)
    assert (distance.min(axis=0) <= tolerance).all()
    assert found.provenance["pixels"]["transparent"] == transparent
    said = ["No profile is embedded: sRGB is assumed."]
    if several:
        said.insert(0, "The file holds several pictures; the first is used.")
    assert list(found.warnings) == said


@pytest.mark.parametrize(
    "data", [by_pillow("WEBP", **LOSSLESS), by_pillow("GIF"), by_pillow("BMP")]
)
def test_a_picture_that_ends_early_is_refused(data):
    for end in (len(data) // 2, 30):
        with pytest.raises(MalformedFileError):
            read_characterisation(data[:end])


def _with_size(name):
    """Return a file whose header states the largest size of its format."""
    if name == "VP8X":
        data = bytearray(by_pillow("WEBP", "RGBA", frames=2))
        data[24:30] = b"\xff" * 6
    elif name == "VP8L":
        data = bytearray(by_pillow("WEBP", **LOSSLESS))
        data[21:25] = b"\xff\xff\xff\x0f"
    elif name == "VP8 ":
        data = bytearray(by_pillow("WEBP"))
        data[26:30] = b"\xff\x3f" * 2
    elif name == "GIF":
        data = bytearray(by_pillow("GIF"))
        data[6:10] = b"\xff" * 4
    else:
        data = bytearray(by_pillow("BMP"))
        data[18:26] = struct.pack("<ii", 2**30, 2**30)
    return bytes(data)


@pytest.mark.parametrize("name", ["VP8X", "VP8L", "VP8 ", "GIF", "BMP"])
def test_the_size_in_the_header_is_checked_before_decoding(name):
    data = _with_size(name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(PictureSizeError):
            read_characterisation(data)


def test_a_gif_frame_larger_than_its_screen_is_refused():
    data = bytearray(by_pillow("GIF"))
    place = data.index(b"\x2c\0\0\0\0")
    data[place + 5 : place + 9] = b"\xff" * 4
    with pytest.raises(PictureSizeError):
        read_characterisation(bytes(data))


def _bmp_with_profile(profile, kind=b"DEBM", size=None):
    """A file with a BITMAPV5HEADER: its profile follows the pixels."""
    pixels = bytes([0, 0, 255, 0]) * 4  # red, 2 × 1 pixels with padding
    header = struct.pack("<IiiHHIIiiII", 124, 2, 1, 1, 24, 0, 8, 0, 0, 0, 0)
    header += bytes(16) + kind + bytes(48) + struct.pack("<III", 4, 124 + 8, size or len(profile))
    header += bytes(4)
    return b"BM" + struct.pack("<IHHI", 0, 0, 0, 138) + header + pixels[:8] + profile


def test_the_profile_of_bmp_is_used_and_a_missing_one_refused():
    profile = (DATA / "DisplayP3-v4.icc").read_bytes()
    assert isinstance(read_characterisation(_bmp_with_profile(profile)).meaning, IccProfile)
    for data in (
        _bmp_with_profile(profile, size=2**31),
        _bmp_with_profile(profile[:-9], size=len(profile)),
        _bmp_with_profile(b"C:\\a.icc", b"KNIL"),
    ):
        with pytest.raises(MalformedProfileError):
            read_characterisation(data)


def test_the_colour_space_in_exif_of_webp_is_used():
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0xA001] = 1
    found = read_characterisation(by_pillow("WEBP", exif=exif))
    assert found.provenance["encoding"] == {"name": "sRGB", "from": "the file"}


def test_a_text_that_starts_with_the_letters_of_bmp_is_not_a_picture():
    with pytest.raises(GamutError) as caught:
        read_characterisation(b"BM of a text, and more words than a header has\n" * 3)
    assert "picture" not in caught.value.message


@pytest.mark.parametrize("extension", [".exr", ".tif"])
def test_tiles(written, extension):
    data = written(extension, "float", tile_width=32, tile_height=32)
    assert has_values(read_characterisation(data), FIELDS, 1e-3)


def test_alpha_of_exr_is_associated(written):
    """OpenEXR, technical introduction: colours are multiplied by alpha."""
    colours = np.array([[0.4, 0.2, 0.1, 0.5], [0.3, 0.6, 0.9, 1.0], [0.7, 0.7, 0.7, 0.0]])
    found = read_characterisation(written(".exr", "float", colours))
    assert has_values(found, np.array([[0.8, 0.4, 0.2], [0.3, 0.6, 0.9]]), 1e-3)
    assert found.provenance["pixels"]["transparent"] == 256


def test_a_size_beyond_the_limit_is_refused_before_decoding(written):
    data = bytearray(written(".exr", "half"))
    place = data.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    data[place : place + 16] = struct.pack("<4i", 0, 0, 59_999, 59_999)
    with pytest.raises(PictureSizeError):
        read_characterisation(bytes(data))


def test_a_decoder_that_quotes_bytes_of_the_file_is_understood():
    """OpenImageIO's messages hold such bytes, and its Python module decodes them as UTF-8."""

    class Owner:
        def geterror(self):
            return b"bad tag \xff in header".decode()

    assert _decoder_message(Owner()) == "bad tag \ufffd in header"


@pytest.mark.parametrize(
    "message",
    [
        'JPEG error: Insufficient memory (case 4) ("a.jpg")',
        "Cannot decode tile, memory error\nFailed to decode the codestream in the JP2 file",
        "Size of tile data exceeds system limits\nFailed to decode tile 1/1",
    ],
)
def test_a_decoder_without_memory_does_not_blame_the_file(message):
    """Messages of libjpeg-turbo 3 and OpenJPEG 2.5 below a limit of RLIMIT_DATA."""
    with pytest.raises(MemoryError):
        _decoder_message(SimpleNamespace(geterror=lambda: message))


ACES_AP1 = [0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767]


@pytest.mark.parametrize(
    ("extension", "attributes", "transfer", "red"),
    [
        (".exr", {"chromaticities": ACES_AP1}, "linear", (0.713, 0.293)),
        (".exr", {"oiio__ColorSpace": "lin_ap1_scene"}, "linear", (0.713, 0.293)),
        (".png", {"CICP": [9, 16, 0, 1]}, "PQ", (0.708, 0.292)),
        (".png", {"CICP": [9, 18, 0, 1]}, "HLG", (0.708, 0.292)),
        (".jxl", {"CICP": [9, 16, 0, 1]}, "PQ", (0.708, 0.292)),
        (".jxl", {"CICP": [9, 18, 0, 1]}, "HLG", (0.708, 0.292)),
    ],
)
def test_declared_encodings(written, extension, attributes, transfer, red):
    kind = "half" if extension == ".exr" else "uint16"
    found = read_characterisation(written(extension, kind, **attributes))
    assert found.provenance["encoding"]["from"] == "the file"
    assert found.meaning.transfer == transfer
    np.testing.assert_allclose(found.meaning.primaries[0], red, atol=1e-6)


@pytest.mark.parametrize(
    ("code", "red"),  # SMPTE ST 268-1:2014, table 5A
    [(5, (0.64, 0.33)), (6, (0.64, 0.33)), (7, (0.64, 0.33)), (8, (0.63, 0.34))],
)
def test_video_in_dpx_is_decoded_by_bt1886(written, code, red):
    data = bytearray(written(".dpx", "uint16"))
    data[801:803] = bytes((code, code))  # transfer and colorimetry of the first image element
    found = read_characterisation(bytes(data)).meaning
    assert (found.transfer, found.gamma, found.primaries[0]) == ("power", 2.4, red)


def test_scene_linear_light_without_metadata_is_that_of_srgb(written):
    found = read_characterisation(written(".exr", "half"))
    assert found.provenance["encoding"]["from"] == "assumed"
    assert found.meaning.transfer == "linear"


def test_primaries_of_radiance_files(written):
    data = written(".hdr", "float")
    stated = b"_rgbe\nPRIMARIES= 0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329\n"
    found = read_characterisation(data.replace(b"_rgbe\n", stated, 1))
    assert found.meaning.primaries[0] == (0.708, 0.292)


@pytest.mark.parametrize(
    "numbers",
    [
        b"nan 0.292 0.17 0.797 0.131 0.046 0.3127 0.329",
        b"0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0",
        b"0.1 0.1 0.2 0.2 0.3 0.3 0.2 0.2",
        b"0.708 0.292 0.17 0.797 0.131 0.046 0.3127",
        b"1 2 3 four",
    ],
)
def test_impossible_primaries_of_radiance_files_are_refused(written, numbers):
    data = written(".hdr", "float").replace(b"_rgbe\n", b"_rgbe\nPRIMARIES=" + numbers + b"\n", 1)
    with pytest.raises(MalformedFileError) as caught:
        read_characterisation(data)
    assert caught.value.where == {"field": "PRIMARIES"}


def test_the_exposure_of_radiance_files_is_said(written):
    """Lines of EXPOSURE multiply (Ward, File Formats, "The RADIANCE picture format")."""
    data = written(".hdr", "float")

    def warnings_of(lines):
        return read_characterisation(data.replace(b"_rgbe\n", b"_rgbe\n" + lines, 1)).warnings

    assert any("exposure of 3 " in text for text in warnings_of(b"EXPOSURE=2\nEXPOSURE= 1.5\n"))
    assert any("COLORCORR" in text for text in warnings_of(b"COLORCORR= 1 1.2 1\n"))
    assert warnings_of(b"EXPOSURE=1\nCOLORCORR=1 1 1\n") == warnings_of(b"")


def test_impossible_or_unknown_encodings_of_openexr_are_refused(written):
    corners = [0.1, 0.1, 0.3, 0.3, 0.5, 0.5, 0.3127, 0.329]
    with pytest.raises(MalformedFileError) as caught:
        read_characterisation(written(".exr", "half", chromaticities=corners))
    assert caught.value.where == {"field": "chromaticities"}
    with pytest.raises(UnsupportedPictureError, match="lin_myspace_scene"):
        read_characterisation(written(".exr", "half", colorInteropID="lin_myspace_scene"))


def test_channels_x_y_z_have_the_white_of_the_file(written):
    """The white is 1, 1, 1; 0.95047, 1.08883 are X and Z of D65 (CIE 15)."""
    light = np.array([[0.95047, 1.0, 1.08883], [0.2, 0.1, 0.05]])
    data = written(".exr", "float", light, names="XYZ")
    found = read_characterisation(data)
    assert found.model == "XYZ"
    np.testing.assert_allclose(found.values.max(axis=0), 1.0, atol=1e-3)
    assert any("white of D65" in warning for warning in found.warnings)


def test_logarithmic_film_densities_are_refused(written):
    data = bytearray(written(".dpx", "uint16"))
    data[801] = 1  # transfer of the first image element: printing density (SMPTE ST 268)
    with pytest.raises(UnsupportedPictureError, match="Printing density"):
        read_characterisation(bytes(data))


CHROMATICITIES = [number for pair in (*SRGB.primaries, SRGB.white) for number in pair]
ACES_AP0 = [0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767]


@pytest.mark.parametrize("codes", [(2, 13), (0, 13), (1, 2), (1, 255), (10, 16)])
def test_code_points_that_displays_do_not_have(codes):
    assert code_point_encoding(*codes) is None


def test_gamma_and_primaries():
    assert chromaticity_encoding(CHROMATICITIES).transfer == "sRGB"
    found = chromaticity_encoding(None, gamma=2.2)
    assert (found.transfer, found.gamma, found.primaries) == ("power", 2.2, SRGB.primaries)
    adobe = [*(n for pair in ADOBE_RGB.primaries for n in pair), *ADOBE_RGB.white]
    assert chromaticity_encoding(adobe, gamma=2.2).primaries == ADOBE_RGB.primaries
    assert chromaticity_encoding(ACES_AP0, linear=True).transfer == "linear"


@pytest.mark.parametrize(
    ("gamma", "place", "pair"),
    [
        (0.0, 0, (0.64, 0.33)),
        (50.0, 0, (0.64, 0.33)),
        (2.2, 2, (0.64, 0.33)),  # two primaries are equal
        (2.2, 6, (0.0, 0.0)),
        (2.2, 6, (0.7, 0.29)),  # the white is outside the triangle
        (2.2, 6, (9.0, 9.0)),
        (2.2, 0, (float("nan"), 0.33)),
    ],
)
def test_impossible_chromaticities_and_exponents(gamma, place, pair):
    numbers = list(CHROMATICITIES)
    numbers[place : place + 2] = pair
    assert chromaticity_encoding(numbers, gamma=gamma) is None


@pytest.mark.parametrize(
    ("name", "transfer", "gamma", "red"),
    [
        ("lin_ap1_scene", "linear", 1.0, (0.713, 0.293)),
        ("srgb_rec709_scene", "sRGB", 1.0, (0.64, 0.33)),
        ("pq_rec2020_display", "PQ", 1.0, (0.708, 0.292)),
        ("hlg_rec2020_display", "HLG", 1.0, (0.708, 0.292)),
        ("g24_rec709_display", "power", 2.4, (0.64, 0.33)),
        ("ocio:lin_p3d65_scene", "linear", 1.0, (0.680, 0.320)),
    ],
)
def test_names_of_the_color_interop_forum(name, transfer, gamma, red):
    found = named_encoding(name)
    assert (found.transfer, found.gamma, found.primaries[0]) == (transfer, gamma, red)


@pytest.mark.parametrize(("channels", "bits"), [(3, 8), (3, 16), (4, 16)])
@pytest.mark.slow
def test_too_many_values_are_represented_by_one_of_each_cell(noise, channels, bits):
    pixels = noise(20_000, channels, bits=bits)
    found = distinct_values([pixels], len(pixels), channels, bits, most=3000)
    assert found.levels is not None
    assert len(found.values) <= 3000
    assert found.distinct == len(np.unique(pixels, axis=0))
    assert found.counts.sum() == len(pixels)
    cell = 2**bits // found.levels
    occupied = np.unique(pixels // cell, axis=0)
    np.testing.assert_array_equal(np.unique(found.values // cell, axis=0), occupied)
    assert len(found.values) == len(occupied)
    every = {tuple(row) for row in pixels.tolist()}
    assert every >= {tuple(row) for row in found.values.tolist()}


def test_the_extremes_of_a_picture_represent_their_cells():
    steps = np.linspace(0, 65535, 40).astype(np.uint16)
    cube = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 3)
    found = distinct_values([cube], len(cube), 3, 16, most=5000)
    assert found.levels is not None
    kept = {tuple(row) for row in found.values.tolist()}
    corners = np.array(np.meshgrid([0, 65535], [0, 65535], [0, 65535])).reshape(3, -1).T
    assert kept >= {tuple(row) for row in corners.tolist()}


def test_a_picture_is_characterisation_data(png, tiff, tags):
    pixels = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    for data in (png(pixels, 8, 2), tiff([pixels.tobytes()], tags(4, 4, 8, 3, 2))):
        found = read_characterisation(data)
        assert isinstance(found, Picture)
        assert found.provenance["format"] == found.format
        with pytest.raises(OptionError) as caught:
            read_characterisation(data, condition="M1")
        assert caught.value.where == {"field": "condition"}


def test_bright_scene_linear_light_is_not_cut(written):
    """65,504 is the largest half float."""
    light = np.array([[0.5, 0.5, 0.5], [20, 30, 40], [-9, 12, 0], [65504, 100, 1000]], float)
    found = read_characterisation(written(".exr", "half", light))
    assert found.values.shape == light.shape
    nearest = np.abs(found.values[:, np.newaxis] - light).sum(axis=2).argmin(axis=0)
    np.testing.assert_allclose(np.cbrt(found.values[nearest]), np.cbrt(light), atol=1e-3)
    assert not any("clipped" in warning for warning in found.warnings)


def test_light_brighter_than_any_half_float_is_refused_with_its_row(written):
    for level in (262_144.0, -1e6, 3e38):
        with pytest.raises(InvalidPointsError) as caught:
            read_characterisation(written(".exr", "float", np.array([[0.5, level, 0.5]])))
        assert caught.value.where == {"row": 1}
    for level in (262_143.0, -262_143.0):
        found = read_characterisation(written(".exr", "float", np.array([[0.5, level, 0.5]])))
        np.testing.assert_allclose(found.values, [[0.5, level, 0.5]], rtol=1e-4)


def test_the_gamut_of_a_bright_picture_reaches_its_highlight(written):
    cube = np.array(list(np.ndindex(2, 2, 2)), float)
    data = written(".exr", "float", np.vstack([cube, [[1000, 1000, 1000]]]))
    gamut = Gamut(data)
    assert gamut.history.full().vertices[:, 0].max() == pytest.approx(116 * 10 - 16, rel=1e-3)
