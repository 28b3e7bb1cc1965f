"""Formats are told by content; other content is refused with what is read."""

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation import IccProfile, Samples, read_characterisation
from gamutcore.errors import GamutError

TABLE = "L,a,b\n50,0,0\n60,10,10\n"


def npy():
    stream = io.BytesIO()
    np.save(stream, np.zeros((4, 3)))
    return stream.getvalue()


@pytest.mark.parametrize(
    ("data", "name"),
    [
        (npy(), "npy"),
        (b"\n  [[50, 0, 0]]", "json"),
        (b"\xef\xbb\xbf" + b'{"samples": [[50, 0, 0]]}', "json"),
        (TABLE.encode(), "csv"),
        (TABLE.encode("utf-16"), "csv"),
        (TABLE.encode("utf-8-sig"), "csv"),
        (
            b"BEGIN_DATA_FORMAT\nL A B\nEND_DATA_FORMAT\nBEGIN_DATA\n1 2 3\nEND_DATA\n",
            "cgats",
        ),
    ],
)
def test_formats_are_told_by_content(data, name):
    samples = read_characterisation(data)
    assert isinstance(samples, Samples)
    assert samples.format == name
    assert samples.provenance["format"] == name


def test_profiles_are_told_by_their_signature(small_profile):
    profile = read_characterisation(small_profile("sRGB-v4.icc"))
    assert isinstance(profile, IccProfile)
    assert profile.format == "icc"


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b" \r\n",
        bytes(500),
        b"RIFF\0\0\0\0AVI " + bytes(range(256)),
        b"<html><body>502</body></html>",
        b"%PDF-1.4\n%\xe2\xe3\xcf\xd3 not, a, table",
        b"PK\x03\x04" + bytes(30),
        b"Dear Sirs, please find below, etc.",
    ],
)
def test_anything_else_is_refused_with_what_is_read(data):
    with pytest.raises(GamutError) as caught:
        read_characterisation(data)
    assert caught.value.code in {"unrecognised-format", "missing-column"}
    assert caught.value.remedy


@given(st.binary(max_size=300))
def test_any_bytes_give_samples_or_a_named_error(data):
    try:
        read = read_characterisation(data)
    except GamutError:
        return
    assert read.format


@pytest.mark.parametrize("name", ["profile", "picture", "mesh", "array"])
def test_what_has_no_measurement_condition_refuses_one(small_profile, name):
    data = {
        "profile": small_profile("sRGB-v4.icc"),
        "picture": b"\x89PNG\r\n\x1a\n",
        "mesh": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
        "array": npy(),
    }[name]
    with pytest.raises(GamutError) as caught:
        read_characterisation(data, condition="M1")
    assert caught.value.where["field"] == "condition"
