"""Formats that OpenImageIO reads, from files that its writers make here."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from PIL import Image

from gamutcore.characterisation import characterisation
from gamutcore.characterisation.icc import IccProfile
from gamutcore.errors import GamutError, PictureSizeError, UnsupportedPictureError

DATA = Path(__file__).parents[3] / "data"
FIELDS = np.array(
    [[0.9, 0.1, 0.1], [0.1, 0.8, 0.2], [0.1, 0.1, 0.9], [0.5, 0.5, 0.5], [1, 1, 1], [0, 0, 0]]
)
ACES_AP1 = [0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767]


@pytest.fixture
def written(tmp_path):
    """Return a function that writes fields of 16 × 16 pixels, which lossy formats hardly change."""

    def write(extension, sample_type, colours=FIELDS, **attributes):
        pixels = np.repeat(np.repeat(colours[np.newaxis], 16, axis=0), 16, axis=1)
        spec = oiio.ImageSpec(pixels.shape[1], 16, pixels.shape[2], sample_type)
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
    found = characterisation(written(extension, sample_type))
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
    found = characterisation(path.read_bytes())
    assert found.format == name
    assert has_values(found, FIELDS, 0.5 / 255 + 1e-9)
    assert isinstance(found.meaning, IccProfile) == (name == "webp")


@pytest.mark.parametrize("extension", [".exr", ".tif"])
def test_tiles(written, extension):
    data = written(extension, "float", tile_width=32, tile_height=32)
    assert has_values(characterisation(data), FIELDS, 1e-3)


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
    found = characterisation(written(extension, kind, **attributes))
    assert found.provenance["encoding"]["from"] == "the file"
    assert found.meaning.transfer == transfer
    np.testing.assert_allclose(found.meaning.primaries[0], red, atol=1e-6)


def test_scene_linear_light_without_metadata_is_that_of_srgb(written):
    found = characterisation(written(".exr", "half"))
    assert found.provenance["encoding"]["from"] == "assumed"
    assert found.meaning.transfer == "linear"


def test_primaries_of_radiance_files(written):
    data = written(".hdr", "float")
    stated = b"_rgbe\nPRIMARIES= 0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329\n"
    found = characterisation(data.replace(b"_rgbe\n", stated, 1))
    assert found.meaning.primaries[0] == (0.708, 0.292)
    with pytest.raises(GamutError):
        characterisation(data.replace(b"_rgbe", b"_xyze"))


def test_alpha_of_exr_is_associated(written):
    """OpenEXR, technical introduction: colours are multiplied by alpha."""
    colours = np.array([[0.4, 0.2, 0.1, 0.5], [0.3, 0.6, 0.9, 1.0], [0.7, 0.7, 0.7, 0.0]])
    found = characterisation(written(".exr", "float", colours))
    assert has_values(found, np.array([[0.8, 0.4, 0.2], [0.3, 0.6, 0.9]]), 1e-3)
    assert found.provenance["pixels"]["transparent"] == 256


def test_logarithmic_film_densities_are_refused(written):
    data = bytearray(written(".dpx", "uint16"))
    data[801] = 1  # transfer of the first image element: printing density (SMPTE ST 268)
    with pytest.raises(UnsupportedPictureError, match="Printing density"):
        characterisation(bytes(data))


@pytest.mark.parametrize("extension", [".exr", ".jxl", ".jp2", ".hdr", ".webp", ".dpx"])
@pytest.mark.parametrize("part", [0.02, 0.1, 0.4])
def test_files_that_end_early(written, extension, part):
    kind = {".exr": "half", ".hdr": "float", ".dpx": "uint16"}.get(extension, "uint8")
    data = written(extension, kind)
    with pytest.raises(GamutError):
        characterisation(data[: int(len(data) * part)])


def test_a_size_beyond_the_limit_is_refused_before_decoding(written):
    data = bytearray(written(".exr", "half"))
    place = data.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    data[place : place + 16] = struct.pack("<4i", 0, 0, 59_999, 59_999)
    with pytest.raises(PictureSizeError):
        characterisation(bytes(data))


def test_reruns_are_identical(written):
    data = written(".jxl", "uint16", np.random.default_rng(0).random((40, 3)))
    one, other = characterisation(data), characterisation(data)
    np.testing.assert_array_equal(one.values, other.values)
    np.testing.assert_array_equal(one.counts, other.counts)
