"""Default names, and pages of the list filtered by name."""

import hashlib

import pytest

from service.problems.problem import ProblemError
from service.routes.naming import named, named_page, refuse_reference
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs
from service.storage.records import Record


@pytest.fixture
def store(tmp_path):
    opened = GamutStore(LocalBlobs(tmp_path / "store"))
    opened.open()
    yield opened
    opened.close()


def publish(store, number, **provenance):
    """A gamut with some provenance; its history is not read here."""
    gamut_id = hashlib.sha256(str(number).encode()).hexdigest()
    content = store.scratch(".gamut")
    content.write_bytes(b"history")
    digest = hashlib.sha256(b"history").hexdigest()
    record = Record(gamut_id, digest, 7, "2026-01-31T12:00:00Z", {"provenance": provenance})
    return store.publish(record, content)


def name_of(store, record):
    return named(store, [record])[0].name


def test_given_names_come_before_descriptors_descriptions_and_files(store):
    record = publish(store, 1, conditions={"DESCRIPTOR": "Offset"}, description="Profile")
    store.names.keep_file(record.id, "file.icc")
    assert name_of(store, record) == "Offset"
    store.names.give(record.id, "Mine")
    assert name_of(store, record) == "Mine"


@pytest.mark.parametrize(
    ("provenance", "file", "name"),
    [
        ({"description": "Profile"}, "file.icc", "Profile"),
        ({"description": " \x07 "}, "file.icc", "file.icc"),
        ({"conditions": {"DESCRIPTOR": "a\tb"}}, "", "a b"),
        ({"description": 5}, "x.csv", "x.csv"),
        ({"format": "reference", "reference": "bt2020"}, "x.json", "ITU-R BT.2020"),
        ({"format": "reference", "reference": "of-an-older-version"}, "", "of-an-older-version"),
    ],
)
def test_the_default_is_the_first_usable_text(store, provenance, file, name):
    record = publish(store, 2, **provenance)
    store.names.keep_file(record.id, file)
    assert name_of(store, record) == name


def test_without_any_text_the_id_is_the_name(store):
    record = publish(store, 3)
    assert name_of(store, record) == f"Gamut {record.id[:12]}"


@pytest.mark.parametrize("limit", [1, 2, 7, 100])
def test_pages_have_every_match_once(store, limit):
    for number in range(30):
        publish(store, number, description=f"{'Paper' if number % 3 else 'PLATE'} {number}")
    found, after = [], ""
    while after is not None:
        page, after = named_page(store, after, limit, "plate")
        assert len(page) <= limit
        found += page
    assert sorted(each.name for each in found) == sorted(f"PLATE {n}" for n in range(0, 30, 3))
    assert len({each.id for each in found}) == 10
    everything, after = named_page(store, "", 30, "")
    assert (len(everything), after) == (30, None)


def test_only_references_are_refused(store):
    refuse_reference(publish(store, 4))
    with pytest.raises(ProblemError, match="srgb"):
        refuse_reference(publish(store, 5, format="reference", reference="srgb"))
