from __future__ import annotations

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation import IccProfile, Samples, characterisation
from gamutcore.errors import GamutError, MissingColumnError, OptionError, UnrecognisedFormatError

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
    samples = characterisation(data)
    assert isinstance(samples, Samples)
    assert samples.format == name
    assert samples.provenance["format"] == name


def test_profiles_are_told_by_their_signature(small_profile):
    profile = characterisation(small_profile("sRGB-v4.icc"))
    assert isinstance(profile, IccProfile)
    assert profile.format == "icc"


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b" \r\n",
        bytes(500),
        b"GIF89a" + bytes(range(256)),
        b"<html><body>502</body></html>",
        b"%PDF-1.4\n%\xe2\xe3\xcf\xd3 not, a, table",
        b"PK\x03\x04" + bytes(30),
        b"Dear Sirs, please find below, etc.",
    ],
)
def test_anything_else_is_refused_with_what_is_read(data):
    with pytest.raises(GamutError) as caught:
        characterisation(data)
    assert caught.value.code in {"unrecognised-format", "missing-column"}
    assert caught.value.remedy


def test_empty_content_is_unrecognised():
    with pytest.raises(UnrecognisedFormatError):
        characterisation(b"")


@given(st.binary(max_size=300))
def test_any_bytes_give_samples_or_a_named_error(data):
    try:
        read = characterisation(data)
    except GamutError:
        return
    assert read.format


def test_a_profile_has_no_measurement_condition(small_profile):
    with pytest.raises(OptionError) as caught:
        characterisation(small_profile("sRGB-v4.icc"), condition="M1")
    assert caught.value.where == {"field": "condition"}


def test_cxf_is_told_by_its_root():
    data = b'<c:CxF xmlns:c="http://colorexchangeformat.com/CxF3-core"/>'
    with pytest.raises(MissingColumnError, match="CxF"):
        characterisation(data)
