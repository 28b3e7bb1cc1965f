"""Pictures that are written in the encoding of another one."""

import io

import numpy as np
import pytest
from PIL import Image

from gamutcore.characterisation.pictures.raster import open_raster
from gamutcore.errors import UnsupportedPictureError
from gamutcore.export.picture_file import picture_writer


def png(mode, **more):
    """A picture of 8 by 8 pixels."""
    file = io.BytesIO()
    Image.new(mode, (8, 8), **more).save(file, "PNG")
    return file.getvalue()


def copy(data, path):
    with open_raster(data, "png") as raster, picture_writer(path, raster) as write:
        for row, band, alpha in raster.bands:
            samples = np.empty((len(band), 3 if alpha is None else 4), band.dtype)
            samples[:, :3] = band
            if alpha is not None:
                samples[:, 3] = alpha
            write(row, row + len(band) // raster.width, samples)


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_copies_are_exact(tmp_path, suffix):
    pixels = np.random.default_rng(2).integers(0, 256, (8, 8, 4)).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    copy(file.getvalue(), tmp_path / f"copy{suffix}")
    with Image.open(tmp_path / f"copy{suffix}") as found:
        np.testing.assert_array_equal(np.asarray(found), pixels)
    assert [each.name for each in tmp_path.iterdir()] == [f"copy{suffix}"]


@pytest.mark.parametrize(
    ("mode", "suffix"), [("I;16", ".jpg"), ("RGBA", ".jpg"), ("RGB", ".gif"), ("RGB", ".exr")]
)
def test_what_a_format_cannot_store_is_refused(tmp_path, mode, suffix):
    with pytest.raises(UnsupportedPictureError, match=r"store|written") as told:
        copy(png(mode), tmp_path / f"copy{suffix}")
    assert "TIFF" in told.value.remedy
    assert list(tmp_path.iterdir()) == []


def test_a_failure_keeps_the_earlier_file(tmp_path):
    path = tmp_path / "copy.png"
    path.write_bytes(b"earlier")
    with (
        pytest.raises(KeyError),
        open_raster(png("RGB"), "png") as raster,
        picture_writer(path, raster),
    ):
        raise KeyError
    assert path.read_bytes() == b"earlier"
    with pytest.raises(OSError, match="nowhere"):
        copy(png("RGB"), tmp_path / "nowhere" / "copy.png")
