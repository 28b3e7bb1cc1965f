"""Names of downloads, as the standard library and browsers read them."""

from email.message import Message

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.http.file_names import content_disposition


def read(value):
    """Return the kind and the name, decoded by the standard library (RFC 2231)."""
    message = Message()
    message["Content-Disposition"] = value
    return message.get_content_disposition(), message.get_filename()


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("Coated FOGRA39L", "Coated FOGRA39L-50.ply"),
        ("a/b\\c: 300 %", "a_b_c_ 300 _-50.ply"),
        ("..hidden", "hidden-50.ply"),
        ("  ", "gamut-50.ply"),
    ],
)
def test_names_in_ascii(name, file):
    value = content_disposition("inline", name, "-50.ply")
    assert value == f'inline; filename="{file}"'


def test_other_names_are_given_twice():
    value = content_disposition("attachment", "Größe „M“", ".gamut")
    assert 'filename="Groe M.gamut"' in value
    assert value.endswith("filename*=UTF-8''Gr%C3%B6%C3%9Fe%20%E2%80%9EM%E2%80%9C.gamut")
    assert content_disposition("inline", "印刷", ".glb").startswith(
        'inline; filename="gamut.glb"; '
    )


@given(st.text(st.characters(codec="utf-8"), max_size=200))
def test_any_name_is_one_field_in_ascii_and_one_file(name):
    value = content_disposition("inline", name, "-4.glb")
    assert value.isascii()
    assert value.isprintable()
    assert value.count('"') == 2
    kind, _ = read(value)
    assert kind == "inline"
    file = value.split('"')[1]
    assert not set("/\\:*?<>|%;") & set(file)
    assert file.endswith("-4.glb")
    assert len(file) < 200
