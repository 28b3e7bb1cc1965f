import io
import re
import struct
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gamutcore.characterisation import characterisation as picture
from gamutcore.characterisation.icc import IccProfile
from gamutcore.errors import (
    GamutError,
    MalformedProfileError,
    PictureSizeError,
    UnsupportedPictureError,
)

DATA = Path(__file__).parents[4] / "data"
SHARED = Path(__file__).parents[6] / "shared" / "data"


def jpeg(mode, colours, **how):
    """Return a picture of fields of 16 × 16 pixels, which JPEG hardly changes."""
    fields = np.repeat(np.repeat(np.array(colours, np.uint8)[np.newaxis], 16, axis=0), 16, axis=1)
    file = io.BytesIO()
    written = Image.frombytes(mode, fields.shape[1::-1], fields.tobytes())
    # Without subsampling: chroma is smoothed where it is unpacked.
    written.save(file, "JPEG", **{"quality": 100, "subsampling": 0, **how})
    return file.getvalue()


RGB = [(255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255), (12, 100, 200)]


def values_near(found, colours, full=255, tolerance=2.0):
    distances = np.abs(found.values[:, np.newaxis] * full - np.array(colours, float)).max(axis=2)
    return (distances.min(axis=0) <= tolerance).all() and (distances.min(axis=1) <= tolerance).all()


@pytest.mark.parametrize(
    "how", [{}, {"progressive": True}, {"restart_marker_rows": 1}, {"optimize": True}]
)
def test_rgb(how):
    found = picture(jpeg("RGB", RGB, **how))
    assert values_near(found, RGB)
    assert found.counts.sum() == 16 * 16 * len(RGB)
    assert (found.format, found.model) == ("jpeg", "RGB")


def test_gray():
    found = picture(jpeg("L", [(0,), (100,), (255,)]))
    assert values_near(found, [(0,), (100,), (255,)])


def without_adobe(data):
    return re.sub(rb"\xff\xee\0\x0eAdobe.{7}", b"", data, flags=re.DOTALL)


def test_components_named_r_g_b_are_not_converted():
    """As libjpeg reads them, where no marker says otherwise."""
    stored = without_adobe(jpeg("RGB", RGB, keep_rgb=True))
    stored = re.sub(rb"\xff\xe0\0\x10JFIF.{11}", b"", stored, flags=re.DOTALL)
    assert values_near(picture(stored), RGB)


def test_cmyk_of_adobe_is_turned_over(shared_data):
    inks = [(0, 0, 0, 0), (255, 0, 0, 0), (0, 255, 0, 0), (10, 20, 30, 255)]
    profile = (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()
    found = picture(jpeg("CMYK", inks, icc_profile=profile))  # 1.8 MB: 28 segments of 64 KB
    assert values_near(found, inks)
    assert isinstance(found.meaning, IccProfile)
    assert found.meaning.data == profile
    assert found.warnings == ()


def test_a_part_of_the_profile_is_missing():
    data = jpeg("RGB", RGB, icc_profile=(DATA / "DisplayP3-v4.icc").read_bytes())
    place = data.index(b"ICC_PROFILE\0") + 12
    with pytest.raises(MalformedProfileError, match="embedded profile"):
        picture(data[: place + 1] + b"\2" + data[place + 2 :])


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
    found = picture(jpeg("RGB", RGB, exif=metadata))
    assert found.provenance["encoding"] == {"name": name, "from": source}


def with_size(data, width, height):
    place = data.index(b"\xff\xc0")
    return data[: place + 5] + struct.pack(">HH", height, width) + data[place + 9 :]


def test_impossible_sizes():
    with pytest.raises(PictureSizeError):
        picture(with_size(jpeg("RGB", RGB), 65_000, 65_000))
    with pytest.raises(GamutError):
        picture(with_size(jpeg("RGB", RGB), 0, 9))


def test_twelve_bits():
    data = bytearray(jpeg("RGB", RGB))
    data[data.index(b"\xff\xc0") + 4] = 12
    with pytest.raises(UnsupportedPictureError, match="precision 12"):
        picture(bytes(data))


@pytest.mark.parametrize("part", [0.02, 0.3, 0.6, 0.9])
def test_a_file_that_ends_early(part):
    data = jpeg("RGB", RGB)
    with pytest.raises(GamutError):
        picture(data[: int(len(data) * part)])
