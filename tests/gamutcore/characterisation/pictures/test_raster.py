"""Formats that OpenImageIO reads, from files that its writers make here."""

from __future__ import annotations

import struct
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from gamutcore.characterisation import characterisation
from gamutcore.characterisation.icc import IccProfile
from gamutcore.characterisation.pictures.raster import _decoder_message
from gamutcore.errors import GamutError, PictureSizeError

DATA = Path(__file__).parents[3] / "data"
FIELDS = np.array(
    [[0.9, 0.1, 0.1], [0.1, 0.8, 0.2], [0.1, 0.1, 0.9], [0.5, 0.5, 0.5], [1, 1, 1], [0, 0, 0]]
)


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


def test_alpha_of_exr_is_associated(written):
    """OpenEXR, technical introduction: colours are multiplied by alpha."""
    colours = np.array([[0.4, 0.2, 0.1, 0.5], [0.3, 0.6, 0.9, 1.0], [0.7, 0.7, 0.7, 0.0]])
    found = characterisation(written(".exr", "float", colours))
    assert has_values(found, np.array([[0.8, 0.4, 0.2], [0.3, 0.6, 0.9]]), 1e-3)
    assert found.provenance["pixels"]["transparent"] == 256


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
