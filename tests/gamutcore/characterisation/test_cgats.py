from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.characterisation import characterisation
from gamutcore.characterisation.cgats import cgats_samples, looks_like_cgats
from gamutcore.errors import (
    CharacterisationError,
    GamutError,
    MissingColumnError,
    SampleLimitError,
)

FORMAT = "BEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\n"
ROWS = "1 0 0 0 5 0 0\n2 255 0 0 50 70 50\n3 0 255 0 80 -70 60\n4 255 255 255 100 0 0\n"
PLAIN = f"CTI3\n{FORMAT}NUMBER_OF_SETS 4\nBEGIN_DATA\n{ROWS}END_DATA\n"
LAB = np.array([[5, 0, 0], [50, 70, 50], [80, -70, 60], [100, 0, 0]], dtype=float)


def assert_plain(samples):
    np.testing.assert_array_equal(samples.lab, LAB)
    np.testing.assert_array_equal(samples.device[1], [1, 0, 0])
    assert samples.channels == ("R", "G", "B")


def test_a_plain_file():
    assert_plain(cgats_samples(PLAIN))


@pytest.mark.parametrize(
    "first_line",
    ["CTI3", "CGATS.17", "ISO28178", "ECI2002", "IT8.7/2", "SPECT", "CGATS.17\t\t", ""],
)
def test_any_first_line_or_none(first_line):
    assert_plain(cgats_samples(PLAIN.replace("CTI3", first_line, 1)))


@pytest.mark.parametrize(
    ("text", "warning"),
    [
        (PLAIN.replace("SETS 4", "SETS 1624"), "1624"),
        (PLAIN.replace("NUMBER_OF_SETS 4\n", ""), "NUMBER_OF_SETS is missing"),
        (PLAIN.replace("CTI3", "CTI3\nNUMBER_OF_FIELDS 3"), "NUMBER_OF_FIELDS says 3"),
        (PLAIN.replace("END_DATA\n", ""), "END_DATA is missing"),
        (PLAIN.replace("END_DATA_FORMAT\nNUMBER_OF_SETS 4\n", ""), "END_DATA_FORMAT is missing"),
        (PLAIN + f"CAL\n{FORMAT}BEGIN_DATA\n1 0 0 0 1 1 1\nEND_DATA\n", "1 further table"),
    ],
)
def test_what_is_tolerated_is_said(text, warning):
    samples = cgats_samples(text)
    assert_plain(samples)
    assert any(warning in said for said in samples.warnings)


@pytest.mark.parametrize(
    "text",
    [
        PLAIN.replace("\n", "\r"),
        PLAIN.replace("\n", "\r\n"),
        PLAIN.replace("\n", "\r", 5).replace("\n", "\r\n", 3),
        PLAIN.replace(" ", "\t").replace("\n", "\t\t\n"),
        PLAIN.replace("CTI3\n", "CTI3 NUMBER_OF_FIELDS 7 ").replace("_FORMAT\n", "_FORMAT "),
        PLAIN.replace(
            "NUMBER_OF_SETS 4\nBEGIN_DATA\n", "NUMBER_OF_SETS 4 BEGIN_DATA 1 0 0 0 5 0 0\n"
        ).replace("1 0 0 0 5 0 0\n1 0 0 0 5 0 0", "1 0 0 0 5 0 0"),
        PLAIN.replace("0 0\nEND_DATA\n", "0 0 END_DATA\n"),
        PLAIN.replace("2 255", '"patch two" 255').replace("3 0", '"#3" 0'),
        PLAIN.replace("2 255", "patch two red 255"),
        PLAIN.replace("255 0 0 50", "255 0 0\n50"),
        PLAIN.replace("70 50\n", "70 50 # red\n").replace("BEGIN_DATA\n", "BEGIN_DATA # data\n"),
        PLAIN.replace("CTI3", 'CTI3\nCREATED ""May, 2001""\nKEYWORD "CREATED"\nCREATED "June"'),
        PLAIN.replace("CTI3", 'CTI3\nDESCRIPTOR "BEGIN_DATA inside" ORIGINATOR "me" # END_DATA'),
        PLAIN.replace("CTI3", "CTI3\nKEYWORD\nCREATED\nNUMBER_OF_FIELDS"),
        PLAIN.replace("50 70 50", "50,0 70,00 5,0e1"),
        PLAIN.replace("BEGIN_DATA_FORMAT", "begin_data_format").replace("END_DATA\n", "end_data\n"),
        "\n" + FORMAT + "BEGIN_DATA\n\n\n" + ROWS + "\n# end\n",
        *(PLAIN.replace("SAMPLE_ID", i) for i in ("SampleID", "SAMPLE_NAME", "SAMPLE_LOC")),
        PLAIN.replace("SAMPLE_ID ", "")
        .replace("\n1 0", "\n0")
        .replace("\n2 255", "\n255")
        .replace("\n3 0", "\n0")
        .replace("\n4 255", "\n255"),
    ],
)
def test_dialects(text):
    assert_plain(cgats_samples(text))


def test_keywords_become_conditions():
    text = PLAIN.replace(
        "CTI3", 'CTI3\nILLUMINANT "D50"\nINSTRUMENT\tKonica\tCA-410\nA "1" B "2"\nCREATED ""x y""'
    )
    conditions = cgats_samples(text).conditions
    assert conditions["ILLUMINANT"] == "D50"
    assert conditions["INSTRUMENT"] == "Konica CA-410"
    assert (conditions["A"], conditions["B"], conditions["CREATED"]) == ("1", "2", "x y")


def test_the_first_table_that_has_colours_is_taken():
    other = "BEGIN_DATA_FORMAT\nI R G B\nEND_DATA_FORMAT\nBEGIN_DATA\n1 x y z\nEND_DATA\n"
    assert_plain(cgats_samples("CAL\n" + other + PLAIN))


def test_seven_inks_by_number():
    names = " ".join(f"7CLR_{i}" for i in range(1, 8))
    text = PLAIN.replace("RGB_R RGB_G RGB_B", names).replace(" 0 0 0 5", " 0 0 0 0 0 0 0 5")
    text = text[: text.index("2 255")] + "END_DATA"
    assert cgats_samples(text).device.shape == (1, 7)


def test_cp1252_is_read():
    data = PLAIN.replace("CTI3", "CTI3\nORIGINATOR \u201cGr\u00e4fin\u201d").encode("cp1252")
    samples = characterisation(data)
    assert samples.conditions["ORIGINATOR"] == "\u201cGr\u00e4fin\u201d"


@pytest.mark.parametrize(
    ("text", "where"),
    [
        (PLAIN.replace("70 50\n", "70 fifty\n"), {"line": 8, "column": 7, "field": "LAB_B"}),
        (PLAIN.replace("70 50\n", "70 50 1\n"), {"line": 8, "column": 8}),
        (PLAIN.replace("70 50\n", "70\n"), {"line": 8, "column": 8}),
        (PLAIN.replace("100 0 0\n", "100 0\n"), {"line": 10, "column": 7}),
        (PLAIN.replace("70 50\n", "70 nan\n"), {"line": 8, "column": "LAB_B"}),
        (PLAIN.replace(FORMAT, ""), {"line": 3}),
        (FORMAT, {"line": 2}),
    ],
)
def test_errors_say_where(text, where):
    with pytest.raises(GamutError) as caught:
        cgats_samples(text)
    assert caught.value.where == where
    assert caught.value.remedy


def test_a_table_without_colours_lists_its_columns():
    with pytest.raises(MissingColumnError) as caught:
        cgats_samples(PLAIN.replace("LAB_L LAB_A LAB_B", "SPEC_380 SPEC_390 SPEC_400"))
    assert "SPEC_380" in caught.value.where["columns"]
    assert caught.value.where["line"] == 3


@pytest.mark.parametrize(
    "text",
    [
        "BEGIN_DATA_FORMAT " + "A " * 5000,
        "".join(f"KEY{i} x\n" for i in range(20_000)) + PLAIN,
    ],
)
def test_columns_and_keywords_are_limited(text):
    with pytest.raises(SampleLimitError):
        cgats_samples(text)


@pytest.mark.parametrize(
    "text",
    [
        FORMAT + "BEGIN_DATA\n" + '"' * 500_000,
        FORMAT + '"" ' * 300_000 + "\nBEGIN_DATA x",
        ("BEGIN_DATA\n" + " " * 100) * 1000,
        "BEGIN_DATA_FORMAT END_DATA_FORMAT BEGIN_DATA END_DATA\n" * 10_000,
        "\n" * 1_000_000 + "BEGIN_DATA",
        "BEGIN_DATA_FORMAT END_DATA_FORMAT BEGIN_DATA END_DATA " * 15_000,
    ],
)
def test_hostile_texts_end_with_an_error(text):
    with pytest.raises(CharacterisationError):
        cgats_samples(text)


def test_words_within_other_words_are_no_data_section():
    assert not looks_like_cgats("NOT_BEGIN_DATA_X")
    assert looks_like_cgats("\tbegin_data\n")


SECTIONS = "BEGIN_DATA END_DATA BEGIN_DATA_FORMAT END_DATA_FORMAT NUMBER_OF_SETS"
words = st.sampled_from(
    [*f'{SECTIONS} LAB_L LAB_A LAB_B RGB_R RGB_G RGB_B " # 1 0.5 1e308 x'.split(), "\n", "\r"]
)


@given(st.lists(words, max_size=60))
def test_any_order_of_words_gives_samples_or_a_named_error(tokens):
    try:
        samples = cgats_samples(" ".join(tokens))
    except GamutError:
        return
    assert np.isfinite(samples.lab).all()


@settings(max_examples=60)
@given(seed=st.integers(0, 2**32))
def test_mutated_files_give_samples_or_a_named_error(seed, fogra39):
    chance = random.Random(seed)  # noqa: S311
    data = bytearray(fogra39[:3000] + fogra39[-300:])
    for _ in range(chance.randint(1, 20)):
        place = chance.randrange(len(data))
        if chance.random() < 0.5:
            data[place] = chance.randrange(256)
        else:
            del data[place : place + chance.randint(1, 40)]
    try:
        samples = characterisation(bytes(data))
    except GamutError:
        return
    assert np.isfinite(samples.device).all()


def test_fogra39_as_it_is_distributed(fogra39):
    samples = characterisation(fogra39)
    assert len(samples) == 1617
    assert samples.channels == ("C", "M", "Y", "K")
    assert samples.warnings == ()
    # ISO 12647-2:2004, table 2, paper types 1 and 2, and table 3, solid cyan, black backing aside.
    paper = samples.lab[(samples.device == 0).all(axis=1)]
    np.testing.assert_array_equal(paper, np.tile([95, 0, -2], (len(paper), 1)))
    cyan = samples.lab[(samples.device == [1, 0, 0, 0]).all(axis=1)]
    np.testing.assert_allclose(cyan, np.tile([55, -37, -50], (len(cyan), 1)), atol=0.1)


def test_other_real_files(shared_data):
    newsprint = characterisation((shared_data / "press" / "TR002.ti3").read_bytes())
    assert len(newsprint) == 928
    assert newsprint.conditions["SAMPLE_BACKING"] == "Black"
    phone = characterisation((shared_data / "display" / "phone_RGBW_LCD_602.txt").read_bytes())
    assert len(phone) == 602
    assert phone.provenance["device_scale"] == 255
    assert phone.lab is None


def test_many_tables_are_refused_in_time_linear_in_their_number():
    """Each table costs a look at its columns, so their number is bounded."""
    table = "BEGIN_DATA_FORMAT\nA B C\nEND_DATA_FORMAT\nBEGIN_DATA\nEND_DATA\n"
    with pytest.raises(SampleLimitError, match="tables") as caught:
        characterisation(("CGATS.17\n" + table * 50_000).encode())
    assert caught.value.where["line"] > 0
