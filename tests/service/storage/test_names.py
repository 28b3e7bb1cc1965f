"""Names of gamuts: durable, the last writer's, on every kind of store."""

import concurrent.futures
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.storage.gamut_names import (
    LONGEST_NAME,
    GamutName,
    InvalidNameError,
    Names,
    checked_name,
    cleaned_name,
    display_name,
)
from service.storage.published import PublishedGamut

GAMUT = "4f1d9c07b2a85e63" * 4


def test_a_gamut_has_no_name_until_it_is_given_one(blobs):
    names = Names(blobs)
    assert names.read(GAMUT) == GamutName()
    names.give(GAMUT, "Coated")
    assert names.read(GAMUT).given == "Coated"


def test_the_name_of_the_file_stays_beside_given_names_and_never_replaces_one(blobs):
    names = Names(blobs)
    names.keep_file(GAMUT, "press.ti3")
    names.give(GAMUT, "Coated")
    names.keep_file(GAMUT, "other.ti3")
    assert names.read(GAMUT)[:2] == ("Coated", "press.ti3")


def test_the_last_name_counts_for_all_who_read(blobs):
    one, other = Names(blobs), Names(blobs)
    for name in ("first", "second", "first"):
        one.give(GAMUT, name)
        other.give(GAMUT, name + " again")
        assert one.read(GAMUT).given == other.read(GAMUT).given == name + " again"


def test_of_simultaneous_names_one_is_left_and_every_write_succeeds(blobs):
    names = Names(blobs)
    given_names = [f"name {n}" for n in range(8)]
    with concurrent.futures.ThreadPoolExecutor(8) as threads:
        list(threads.map(lambda name: names.give(GAMUT, name), given_names))
    assert names.read(GAMUT).given in given_names
    assert names.read(GAMUT).revision == 8


def test_a_dropped_name_is_gone(blobs):
    names = Names(blobs)
    names.give(GAMUT, "Coated")
    names.drop(GAMUT)
    names.drop(GAMUT)
    assert names.read(GAMUT) == GamutName()


@pytest.mark.parametrize("damage", [b"", b"{}", b"0" * 65 + b"{}\n"])
def test_a_damaged_name_counts_as_none_and_can_be_replaced(blobs, damage):
    names = Names(blobs)
    blobs.create(f"names/{GAMUT[:2]}/{GAMUT}.name", damage)
    assert names.read(GAMUT) == GamutName()
    names.give(GAMUT, "Coated")
    assert names.read(GAMUT).given == "Coated"


@pytest.mark.parametrize(
    "text",
    [
        *("FOGRA39", "印刷機", "Mère", "👩‍🔬", "x" * LONGEST_NAME, " a  b "),
        # Joiners where they decide the form (RFC 5892, appendix A): Persian, Hindi, Sinhala,
        # Malayalam at the end, and emoji with a skin tone and with a presentation selector.
        *("\u0645\u06cc\u200c\u062e\u0648\u0627\u0647\u0645", "\u0915\u094d\u200d\u0937"),
        *("\u0dc1\u0dca\u200d\u0dbb\u0dd3", "\u0d28\u0d4d\u200d"),
        *("\U0001f469\U0001f3fd\u200d\U0001f52c", "\u2764\ufe0f\u200d\U0001f525"),
    ],
)
def test_names_of_all_scripts_are_taken(text):
    assert checked_name(text) == unicodedata.normalize("NFC", text).strip()


@pytest.mark.parametrize(
    "text",
    ["", "  ", "x" * (LONGEST_NAME + 1), "a\nb", "a\0", "\u202eabc", "\ud800", "a\u2028b", 3, None],
)
def test_other_texts_are_refused_with_the_reason(text):
    with pytest.raises(InvalidNameError, match=r"\.$"):
        checked_name(text)


INVISIBLE = (
    # Cc, Cf, Co, Cs, Cn, Zl and Zp of the Unicode Character Database
    *("\x07", "\x9f", "\xad", "\u061c", "\u200b", "\u200e", "\u2060", "\u2064", "\ufeff"),
    *("\ufff9", "\U000e0041", "\ue000", "\U0010fffd", "\udfff", "\u0378", "\uffff", "\u2028"),
    *("\u2029", "\u115f", "\u1160", "\u3164", "\uffa0", "\u200c", "\u200d"),
)


@pytest.mark.parametrize("character", INVISIBLE, ids=ascii)
def test_no_name_has_an_invisible_character(character):
    for text in (character, f"a{character}b", f"{character}a", f"a{character}"):
        if text.strip() == "a":
            continue  # white space at the ends does not count
        with pytest.raises(InvalidNameError, match=r"\.$"):
            checked_name(text)
    assert cleaned_name(character) == ""
    assert cleaned_name(f"a{character}b") in {"ab", "a b"}


@pytest.mark.parametrize(
    "text", ["\u2800", "\ufe0f", "\u034f", "\u3000", "\u2800 \u180b"], ids=ascii
)
def test_a_name_is_visible(text):
    with pytest.raises(InvalidNameError, match=r"characters; it needs|no visible character"):
        checked_name(text)
    assert cleaned_name(text) == ""


def test_equal_names_have_one_form():
    assert checked_name("Me\u0300re") == checked_name("M\u00e8re")


@given(st.text())
def test_every_text_of_a_file_gives_a_name_or_nothing(text):
    name = cleaned_name(text)
    assert not name or checked_name(name) == name


def shown(provenance, file=""):
    record = PublishedGamut(
        "ab" * 32, "0" * 64, 7, "2026-01-31T12:00:00Z", {"provenance": provenance}
    )
    return display_name(record, GamutName("", file, 1))


def test_descriptors_come_before_descriptions_and_both_before_files():
    """The rest is told by pages (`test_naming`)."""
    assert shown({"conditions": {"DESCRIPTOR": "a\tb"}, "description": "Profile"}) == "a b"
    assert shown({"conditions": {"FILE_DESCRIPTOR": "x"}}, file="y.ti3") == "x"
