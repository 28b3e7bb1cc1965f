"""The name that clients see: given, or by the first usable text."""

import pytest

from service.storage.display_names import display_name
from service.storage.names import GamutName
from service.storage.records import Record


def shown(provenance, given="", file=""):
    record = Record("ab" * 32, "0" * 64, 7, "2026-01-31T12:00:00Z", {"provenance": provenance})
    return display_name(record, GamutName(given, file, 1))


@pytest.mark.parametrize(
    ("provenance", "file", "name"),
    [
        ({"description": "Profile"}, "file.icc", "Profile"),
        ({"description": " \x07 "}, "file.icc", "file.icc"),
        ({"conditions": {"DESCRIPTOR": "a\tb"}, "description": "Profile"}, "", "a b"),
        ({"conditions": {"FILE_DESCRIPTOR": "x"}}, "y.ti3", "x"),
        ({"description": 5}, "x.csv", "x.csv"),
        ({}, "", "Gamut abababababab"),
    ],
)
def test_defaults(provenance, file, name):
    assert shown(provenance, file=file) == name


def test_given_names_come_first_except_for_references():
    assert shown({"description": "Profile"}, given="Mine") == "Mine"
    bt2020 = {"format": "reference", "reference": "bt2020"}
    assert shown(bt2020, given="Mine") == "ITU-R BT.2020"
