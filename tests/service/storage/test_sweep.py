from dataclasses import replace

from service.storage.records import Record, record_key
from service.storage.sweep import remove_uncommitted


def put(blobs, name, copies, record=None):
    """Histories of a gamut, and perhaps the record that names one of them."""
    whole = Record(name * 64, "", 1, "", {})
    for copy in copies:
        blobs.create(replace(whole, copy=copy * 16).key, b"x")
    if record is not None:
        blobs.create(record_key(whole.id), record or replace(whole, copy=copies[0] * 16).to_bytes())
    return whole.id


def test_what_no_record_names_goes_and_all_else_stays(local):
    sound = put(local, "a", "0", b"")
    winner = put(local, "b", "012", b"")
    put(local, "c", "01")
    damaged = put(local, "d", "01", b"damaged")
    making = put(local, "e", "0")
    assert remove_uncommitted(local, making.__eq__, lambda: True) == 4
    left = [key.partition("/")[2].partition("/")[2] for key in local.keys("published/")]
    assert left == [
        f"{sound}.{'0' * 16}.gamut",
        f"{sound}.record",
        f"{winner}.{'0' * 16}.gamut",
        f"{winner}.record",
        f"{damaged}.{'0' * 16}.gamut",
        f"{damaged}.{'1' * 16}.gamut",
        f"{damaged}.record",
        f"{making}.{'0' * 16}.gamut",
    ]


def test_it_ends_when_it_is_told_to(local):
    put(local, "c", "01")
    assert remove_uncommitted(local, lambda _: False, lambda: False) == 0
