from __future__ import annotations

import struct

import pytest

from gamutcore.characterisation.icc.element import Element
from gamutcore.characterisation.icc.names import colorant_names, profile_description
from gamutcore.errors import MalformedProfileError


def tags(**data):
    def element(tag):
        if tag not in data:
            raise MalformedProfileError("missing")
        return Element(tag, data[tag])

    return element


def test_descriptions_of_both_versions():
    old = b"desc" + bytes(4) + struct.pack(">I", 6) + b"Press\0"
    assert profile_description(tags(desc=old)) == "Press"
    text = "Drück".encode("utf-16-be")
    new = b"mluc" + bytes(4) + struct.pack(">II2s2sII", 1, 12, b"de", b"DE", len(text), 28) + text
    assert profile_description(tags(desc=new)) == "Drück"


@pytest.mark.parametrize("data", [{}, {"desc": b"desc"}, {"desc": b"text" + bytes(8)}])
def test_a_missing_or_broken_description_is_nothing(data):
    assert profile_description(tags(**data)) == ""


def colorants(*names):
    entries = b"".join(name.ljust(32, b"\0") + bytes(6) for name in names)
    return b"clrt" + bytes(4) + struct.pack(">I", len(names)) + entries


def test_names_of_inks():
    assert colorant_names(tags(clrt=colorants(b"Cyan", b"Orange")), 2) == ("Cyan", "Orange")


@pytest.mark.parametrize(
    "data",
    [
        {},
        {"clrt": colorants(b"Cyan")},
        {"clrt": colorants(b"Cyan", b"Cyan")},
        {"clrt": colorants(b"Cyan", b"")},
        {"clrt": colorants(b"Cyan", b"Orange")[:50]},
    ],
)
def test_names_that_are_not_of_the_inks_are_none(data):
    assert colorant_names(tags(**data), 2) == ()
