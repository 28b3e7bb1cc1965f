"""The CGATS family: dialects, traps of real files, conditions, and files that break it."""

import random
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.characterisation import read_characterisation
from gamutcore.colours import surface_colours
from gamutcore.errors import (
    CharacterisationError,
    ConditionError,
    GamutError,
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
    UnrecognisedFormatError,
)


def read(text, **options):
    return read_characterisation(text.encode(), **options)


FORMAT = "BEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\n"
ROWS = "1 0 0 0 5 0 0\n2 255 0 0 50 70 50\n3 0 255 0 80 -70 60\n4 255 255 255 100 0 0\n"
PLAIN = f"CTI3\n{FORMAT}NUMBER_OF_SETS 4\nBEGIN_DATA\n{ROWS}END_DATA\n"
LAB = np.array([[5, 0, 0], [50, 70, 50], [80, -70, 60], [100, 0, 0]], dtype=float)


def assert_plain(samples):
    np.testing.assert_array_equal(samples.lab, LAB)
    np.testing.assert_array_equal(samples.device[1], [1, 0, 0])
    assert samples.channels == ("R", "G", "B")


@pytest.mark.parametrize(
    "first_line",
    ["CTI3", "CGATS.17", "ISO28178", "ECI2002", "IT8.7/2", "SPECT", "CGATS.17\t\t", ""],
)
def test_any_first_line_or_none(first_line):
    assert_plain(read(PLAIN.replace("CTI3", first_line, 1)))


@pytest.mark.parametrize(
    ("text", "warning"),
    [
        (PLAIN.replace("SETS 4", "SETS 1624"), "1624"),
        (PLAIN.replace("NUMBER_OF_SETS 4\n", ""), "NUMBER_OF_SETS is missing"),
        (PLAIN.replace("CTI3", "CTI3\nNUMBER_OF_FIELDS 3"), "NUMBER_OF_FIELDS is 3"),
        (PLAIN.replace("END_DATA\n", ""), "END_DATA is missing"),
        (PLAIN.replace("END_DATA_FORMAT\nNUMBER_OF_SETS 4\n", ""), "END_DATA_FORMAT is missing"),
        (PLAIN + f"CAL\n{FORMAT}BEGIN_DATA\n1 0 0 0 1 1 1\nEND_DATA\n", "1 further table"),
    ],
)
def test_what_is_tolerated_is_said(text, warning):
    samples = read(text)
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
    assert_plain(read(text))


def test_keywords_become_conditions():
    text = PLAIN.replace(
        "CTI3", 'CTI3\nILLUMINANT "D50"\nINSTRUMENT\tKonica\tCA-410\nA "1" B "2"\nCREATED ""x y""'
    )
    conditions = read(text).conditions
    assert conditions["ILLUMINANT"] == "D50"
    assert conditions["INSTRUMENT"] == "Konica CA-410"
    assert (conditions["A"], conditions["B"], conditions["CREATED"]) == ("1", "2", "x y")


def test_all_texts_of_a_repeated_keyword_are_kept():
    """MeasureTool and ProfileMaker state illuminant and observer in two lines of one keyword."""
    repeated = (
        'WEIGHTING_FUNCTION "ILLUMINANT, D50"\nWEIGHTING_FUNCTION "OBSERVER, 10 degree"\n'
        'WEIGHTING_FUNCTION "ILLUMINANT, D50"\nDEVICE_CLASS "DISPLAY"\nDEVICE_CLASS "OUTPUT"\n'
        'MEASUREMENT_GEOMETRY "45/0"\nMEASUREMENT_GEOMETRY "Reflection, M1"'
    )
    samples = read(PLAIN.replace("CTI3", f"CTI3\n{repeated}"), condition="M1")
    assert samples.conditions["WEIGHTING_FUNCTION"] == "ILLUMINANT, D50; OBSERVER, 10 degree"
    assert samples.conditions["DEVICE_CLASS"] == "OUTPUT"
    assert samples.condition == "M1"
    provenance = surface_colours(samples, surface_samples=50).provenance
    assert (provenance["illuminant"], provenance["observer"]) == ("D50", "10°")


def test_keywords_of_a_later_header_replace_those_before():
    other = (
        'WEIGHTING_FUNCTION "ILLUMINANT, D65"\nBEGIN_DATA_FORMAT\nI R G B\nEND_DATA_FORMAT\n'
        "BEGIN_DATA\n1 x y z\nEND_DATA\n"
    )
    text = PLAIN.replace("CTI3", f'{other}WEIGHTING_FUNCTION "ILLUMINANT, D50"')
    assert read(text).conditions["WEIGHTING_FUNCTION"] == "ILLUMINANT, D50"


@pytest.mark.slow
def test_many_repetitions_are_bounded():
    text = "".join(f"REMARK {i}\n" for i in range(20_000)) + PLAIN
    assert len(read(text).conditions["REMARK"]) < 500


def test_the_first_table_that_has_colours_is_taken():
    other = "BEGIN_DATA_FORMAT\nI R G B\nEND_DATA_FORMAT\nBEGIN_DATA\n1 x y z\nEND_DATA\n"
    assert_plain(read("CAL\n" + other + PLAIN))


def test_seven_inks_by_number():
    names = " ".join(f"7CLR_{i}" for i in range(1, 8))
    text = PLAIN.replace("RGB_R RGB_G RGB_B", names).replace(" 0 0 0 5", " 0 0 0 0 0 0 0 5")
    text = text[: text.index("2 255")] + "END_DATA"
    assert read(text).device.shape == (1, 7)


def test_cp1252_is_read():
    data = PLAIN.replace("CTI3", "CTI3\nORIGINATOR \u201cGr\u00e4fin\u201d").encode("cp1252")
    samples = read_characterisation(data)
    assert samples.conditions["ORIGINATOR"] == "\u201cGr\u00e4fin\u201d"


@pytest.mark.parametrize(
    ("text", "where"),
    [
        (PLAIN.replace("70 50\n", "70 fifty\n"), {"line": 8, "column": 7, "field": "LAB_B"}),
        (PLAIN.replace("70 50\n", "70 50 1\n"), {"line": 8, "column": 8}),
        (PLAIN.replace("70 50\n", "70\n"), {"line": 8, "column": 8}),
        (PLAIN.replace("100 0 0\n", "100 0\n"), {"line": 10, "column": 7}),
        (PLAIN.replace("70 50\n", "70 nan\n"), {"line": 8, "column": 7, "field": "LAB_B"}),
        (PLAIN.replace(FORMAT, ""), {"line": 3}),
    ],
)
def test_errors_say_where(text, where):
    with pytest.raises(GamutError) as caught:
        read(text)
    assert caught.value.where == where
    assert caught.value.remedy


def test_a_table_without_colours_lists_its_columns():
    with pytest.raises(MissingColumnError) as caught:
        read(PLAIN.replace("LAB_L LAB_A LAB_B", "SPEC_380 SPEC_390 SPEC_400"))
    assert "SPEC_380" in caught.value.where["columns"]
    assert caught.value.where["line"] == 3


@pytest.mark.parametrize(
    "text",
    [
        "BEGIN_DATA_FORMAT " + "A " * 5000 + "\nEND_DATA_FORMAT\nBEGIN_DATA\nEND_DATA\n",
        "".join(f"KEY{i} x\n" for i in range(20_000)) + PLAIN,
    ],
)
def test_columns_and_keywords_are_limited(text):
    with pytest.raises(SampleLimitError):
        read(text)


@pytest.mark.parametrize(
    "text",
    [
        FORMAT + "BEGIN_DATA\n" + '"' * 500_000,
        FORMAT + '"" ' * 300_000 + "\nBEGIN_DATA x",
        ("BEGIN_DATA\n" + " " * 100) * 1000,
        "BEGIN_DATA_FORMAT END_DATA_FORMAT BEGIN_DATA END_DATA\n" * 10_000,
        "\n" * 200_000 + "BEGIN_DATA",
        "BEGIN_DATA_FORMAT END_DATA_FORMAT BEGIN_DATA END_DATA " * 15_000,
    ],
)
@pytest.mark.slow
def test_hostile_texts_end_with_an_error(text):
    with pytest.raises(CharacterisationError):
        read(text)


SECTIONS = "BEGIN_DATA END_DATA BEGIN_DATA_FORMAT END_DATA_FORMAT NUMBER_OF_SETS"
words = st.sampled_from(
    [*f'{SECTIONS} LAB_L LAB_A LAB_B RGB_R RGB_G RGB_B " # 1 0.5 1e308 x'.split(), "\n", "\r"]
)


@given(st.lists(words, max_size=60))
def test_any_order_of_words_gives_samples_or_a_named_error(tokens):
    try:
        samples = read(" ".join(tokens))
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
        samples = read_characterisation(bytes(data))
    except GamutError:
        return
    assert np.isfinite(samples.device).all()


def test_fogra39_as_it_is_distributed(fogra39):
    samples = read_characterisation(fogra39)
    assert len(samples) == 1617
    assert samples.channels == ("C", "M", "Y", "K")
    assert samples.warnings == ()
    # ISO 12647-2:2004, table 2, paper types 1 and 2, and table 3, solid cyan, black backing aside.
    paper = samples.lab[(samples.device == 0).all(axis=1)]
    np.testing.assert_array_equal(paper, np.tile([95, 0, -2], (len(paper), 1)))
    cyan = samples.lab[(samples.device == [1, 0, 0, 0]).all(axis=1)]
    np.testing.assert_allclose(cyan, np.tile([55, -37, -50], (len(cyan), 1)), atol=0.1)


def test_other_real_files(shared_data):
    newsprint = read_characterisation((shared_data / "press" / "TR002.ti3").read_bytes())
    assert len(newsprint) == 928
    assert newsprint.conditions["SAMPLE_BACKING"] == "Black"
    phone = read_characterisation((shared_data / "display" / "phone_RGBW_LCD_602.txt").read_bytes())
    assert len(phone) == 602
    assert phone.provenance["device_scale"] == 255
    assert phone.lab is None


def test_many_tables_are_refused_in_time_linear_in_their_number():
    """Each table costs a look at its columns, so their number is bounded."""
    table = "BEGIN_DATA_FORMAT\nA B C\nEND_DATA_FORMAT\nBEGIN_DATA\nEND_DATA\n"
    with pytest.raises(SampleLimitError, match="tables") as caught:
        read_characterisation(("CGATS.17\n" + table * 50_000).encode())
    assert caught.value.where["line"] > 0


BANDS = range(380, 740, 10)


def table(names, rows, head=""):
    """Return a table of the CGATS family."""
    lines = "\n".join(" ".join(str(cell) for cell in row) for row in rows)
    return (
        f"{head}\nBEGIN_DATA_FORMAT\n{names}\nEND_DATA_FORMAT\nNUMBER_OF_SETS {len(rows)}\n"
        f"BEGIN_DATA\n{lines}\nEND_DATA\n"
    )


class TestTrapsOfRealFiles:
    """Those of the notes on characterisation data that the tests above do not have."""

    def test_a_calibration_after_the_measurements_is_not_read(self):
        """Argyll's .ti3 with its CAL: the second table has device values alone."""
        cal = table("RGB_I RGB_R RGB_G RGB_B", [(i / 3, i / 3, i / 3, i / 3) for i in range(4)])
        samples = read(PLAIN + 'CAL\nDESCRIPTOR "Argyll"\nCREATED "June"' + cal)
        assert_plain(samples)
        assert "CREATED" not in samples.conditions

    def test_reflectances_above_one_are_legitimate(self):
        names = " ".join(["CMY_C CMY_M CMY_Y", *(f"SPEC_{nm}" for nm in BANDS)])
        paper = [1.25 if nm == 440 else 0.9 for nm in BANDS]
        samples = read(table(names, [(0, 0, 0, *paper), (100, 50, 20, *[0.3] * 36)]))
        assert samples.spectra.values.max() == 1.25
        plain = read(table(names, [(0, 0, 0, *[0.9] * 36), (100, 50, 20, *[0.3] * 36)]))
        bluer, gray = (surface_colours(each, intent="absolute") for each in (samples, plain))
        assert bluer.points[0, 2] < gray.points[0, 2] - 1

    @pytest.mark.parametrize("scale", [1, 100, 417.3])
    def test_xyz_on_its_three_scales(self, scale):
        """0-1, 0-100 and cd/m²: a display's colours are relative to its white in any."""
        rows = [(0, 0, 0, 0, 0, 0), (255, 0, 0, 0.41, 0.21, 0.02), (255, 255, 255, 0.95, 1, 1.09)]
        rows = [(*row[:3], *(value * scale for value in row[3:])) for row in rows]
        samples = read(table("RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z", rows))
        lab = surface_colours(samples).points
        np.testing.assert_allclose(lab[2], [100, 0, 0], atol=1e-9)
        np.testing.assert_allclose(lab[1, 0], 116 * 0.21 ** (1 / 3) - 16, atol=2)

    def test_the_colorchecker_of_measuretool(self):
        """Decimal commas, names as Lab_L, and a quoted line without keyword."""
        text = (
            'LGOROWLENGTH 12\nORIGINATOR "ColorChecker24 - November2014 edition and newer"\n'
            '"i1Pro 2 ; Serial number 1"\n"MeasurementCondition=M0\tFilter=no"\n\n'
            "NUMBER_OF_FIELDS 4\nBEGIN_DATA_FORMAT\nSAMPLE_NAME Lab_L   Lab_a   Lab_b\n"
            "END_DATA_FORMAT\nNUMBER_OF_SETS 2\nBEGIN_DATA\nA1\t37,54\t14,37\t14,92\n"
            "A2\t62,73\t35,83\t56,5\nEND_DATA\n"
        )
        samples = read(text)
        np.testing.assert_array_equal(samples.lab, [[37.54, 14.37, 14.92], [62.73, 35.83, 56.5]])
        assert samples.condition == "M0"


class TestMeasurementConditions:
    M0 = PLAIN.replace("CTI3", "CTI3\nMEASUREMENT_CONDITION M0")
    M2 = table("RGB_R RGB_G RGB_B LAB_L LAB_A LAB_B", [(0, 0, 0, 7, 1, 1), (1, 1, 1, 90, 1, 1)])

    def test_one_condition_is_read_and_named(self):
        samples = read(self.M0)
        assert samples.condition == "M0"
        assert read(self.M0, condition="m0").condition == "M0"
        with pytest.raises(ConditionError, match="M0"):
            read(self.M0, condition="M1")

    def test_tables_of_two_conditions_are_refused_until_one_is_chosen(self):
        text = self.M0 + 'CGATS.17\nFILTER "UVcut"' + self.M2
        with pytest.raises(ConditionError, match="M0, M2") as caught:
            read(text)
        assert caught.value.where["conditions"] == ["M0", "M2"]
        assert "`condition`" in caught.value.remedy
        assert_plain(read(text, condition="M0"))
        second = read(text, condition="M2")
        assert second.lab[:, 0].tolist() == [7, 90]
        assert second.condition == "M2"

    def test_columns_of_two_conditions_are_refused_until_one_is_chosen(self):
        names = "RGB_R RGB_G RGB_B M0_LAB_L M0_LAB_A M0_LAB_B LAB_L_M1 LAB_A_M1 LAB_B_M1"
        text = table(names, [(0, 0, 0, 1, 2, 3, 4, 5, 6)])
        with pytest.raises(ConditionError, match="M0, M1"):
            read(text)
        assert read(text, condition="M1").lab.tolist() == [[4, 5, 6]]

    def test_a_condition_that_no_file_states_is_refused(self):
        with pytest.raises(ConditionError, match="states none"):
            read(PLAIN, condition="M1")


class TestColourGamutEnvelopes:
    """IDMS 1.3; the form is that of the tools at github.com/CIELab-gamut-tools."""

    HEAD = (
        "CGATS.17\nFORMAT_VERSION 2\nIDMS_FILE_TYPE\t{}\nIDMS_VERSION  1.3\n"
        "CGV_DISPLAY_TYPE {}\nDISPLAY_MFR DisplayCo\nCIE_OBSERVER 1931 \nCIE_OBSERVER_ANGLE 2\n"
        "ILLUMINATION_PERFECT_DIFFUSE_REFLECTOR_XYZ\t1.02E+02\t1.00E+02\t6.37E+01\n"
        "KEYWORD SampleID\nNUMBER_OF_FIELDS 7"
    )
    XYZ = "SampleID RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z"
    HALF = ((1, 0, 0, 0, 4.08, 4, 2.548), (2, 255, 255, 255, 51, 50, 31.85))

    def test_a_measurement_of_a_reflective_display(self):
        text = table(self.XYZ, self.HALF, self.HEAD.format("CGE_MEASUREMENT", "REFLECTIVE"))
        samples = read(text)
        assert samples.provenance["dialect"] == "CGE_MEASUREMENT"
        assert samples.illumination.tolist() == [102, 100, 63.7]
        absolute = surface_colours(samples, intent="absolute")
        # Half and a 25th of the perfect diffuser: neutral, L* by CIE 15.
        np.testing.assert_allclose(absolute.points[:, 0], 116 * np.cbrt([0.04, 0.5]) - 16)
        np.testing.assert_allclose(absolute.points[:, 1:], 0, atol=1e-6)
        assert absolute.provenance["observer"] == "2°"
        assert "102, 100, 63.7" in absolute.provenance["illuminant"]
        relative = surface_colours(samples)
        np.testing.assert_allclose(relative.points[1], [100, 0, 0], atol=1e-6)

    def test_a_measurement_of_an_emissive_display(self):
        text = table(self.XYZ, self.HALF, self.HEAD.format("CGE_MEASUREMENT", "EMISSIVE"))
        medium = surface_colours(read(text))
        assert medium.provenance["medium"] == "display"
        np.testing.assert_allclose(medium.points[1], [100, 0, 0], atol=1e-6)

    def test_an_envelope(self):
        names = "SampleID RGB_R RGB_G RGB_B LAB_L LAB_A LAB_B"
        rows = [(1, 0, 0, 0, 0, 0, 0), (2, 255, 0, 0, 54, 81, 70), (3, 255, 255, 255, 100, 0, 0)]
        samples = read(table(names, rows, self.HEAD.format("CGE_ENVELOPE", "EMISSIVE")))
        assert samples.provenance["dialect"] == "CGE_ENVELOPE"
        np.testing.assert_allclose(surface_colours(samples).points[1], [54, 81, 70], atol=1e-3)

    def test_signals_alone_are_no_gamut(self):
        with pytest.raises(MissingColumnError):
            read(table("SampleID RGB_R RGB_G RGB_B", [(1, 0, 0, 0)]))

    @pytest.mark.parametrize("text", ["102 100", "102 100 x", "0 100 60", "1 2 3 4"])
    def test_a_broken_illumination_is_refused_with_its_line(self, text):
        head = self.HEAD.format("CGE_MEASUREMENT", "REFLECTIVE")
        broken = head.replace("1.02E+02\t1.00E+02\t6.37E+01", text)
        with pytest.raises(MalformedFileError) as caught:
            read(table(self.XYZ, self.HALF, broken))
        assert caught.value.where["line"] == 9


REPORTS = Path(__file__).parents[2] / "data" / "reports"


def saved(text, separator, *, quoted=False, decimal=".", width=0, keywords=True):
    """The text as a spreadsheet saves it; keyword and value are one cell, or a cell each."""
    lines = []
    for line in text.splitlines():
        cells = [line] if '"' in line else line.split()
        if '"' in line and keywords:
            cells = list(line.partition(" ")[::2])
        cells = [cell.replace(".", decimal) if cell[-1:].isdigit() else cell for cell in cells]
        marks = ('"', separator)
        cells = [
            '"' + cell.replace('"', '""') + '"'
            if quoted or any(mark in cell for mark in marks)
            else cell
            for cell in cells
        ]
        lines.append(separator.join(cells + [""] * (width - len(cells))))
    return "\r\n".join(lines) + "\r\n"


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"keywords": False},
        {"quoted": True},
        {"width": 9},
        {"decimal": ",", "width": 8},
        {"quoted": True, "decimal": ",", "keywords": False, "width": 12},
    ],
)
def test_files_that_a_spreadsheet_saved(separator, options):
    text = (REPORTS / "printer-lab-d65-reference.txt").read_text()
    right = read(text)
    found = read(saved(text, separator, **options))
    np.testing.assert_array_equal(found.lab, right.lab)
    np.testing.assert_array_equal(found.device, right.device)
    assert found.conditions == right.conditions
    assert found.warnings == right.warnings


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "cp1252"])
def test_files_of_a_spreadsheet_in_its_encodings(encoding):
    text = (REPORTS / "printer-lab-d65-reference.txt").read_text()
    found = read_characterisation(saved(text, ";", decimal=",").encode(encoding))
    assert found.conditions == read(text).conditions
    assert read("sep=;\r\n" + saved(text, ";")).conditions == found.conditions


@pytest.mark.parametrize(
    "name", ["printer-lab-d65-saved-by-spreadsheet.txt", "cgats-saved-as-csv.csv"]
)
def test_reports_of_files_that_a_spreadsheet_saved(name):
    samples = read_characterisation((REPORTS / name).read_bytes())
    assert samples.conditions["DEVICE_CLASS"] == "OUTPUT"
    assert samples.conditions["ORIGINATOR"] == "A writer"
    assert len(samples) == 125
    assert samples.warnings == ()


def test_lines_that_are_single_cells():
    text = (REPORTS / "printer-lab-d65-reference.txt").read_text()
    lines = ['"' + line.replace('"', '""') + '"' for line in text.splitlines()]
    for found in (read("\n".join(lines)), read(text.replace('"', "").replace("\n", ",,,\n"))):
        np.testing.assert_array_equal(found.lab, read(text).lab)
        assert found.conditions["OBSERVER"] == "10 degree"


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (("\r\n2,0,0,64,", "\r\n2,0,0,"), {"line": 13, "field": "LAB_B"}),
        (("\r\n2,0,0,64,", "\r\n2,0,,64,"), {"line": 13, "field": "RGB_G"}),
        (("\r\n2,0,0,64,", "\r\n2,0,0,1,2,64,"), {"line": 13, "column": 8}),
    ],
)
def test_damaged_rows_of_a_spreadsheet(change, where):
    text = saved((REPORTS / "printer-lab-d65-reference.txt").read_text(), ",")
    with pytest.raises(MalformedFileError) as caught:
        read(text.replace(*change))
    assert where.items() <= caught.value.where.items()


@settings(max_examples=60)
@given(seed=st.integers(0, 2**32), separator=st.sampled_from(",;\t"), quoted=st.booleans())
def test_mutated_spreadsheets_give_samples_or_a_named_error(seed, separator, quoted):
    chance = random.Random(seed)  # noqa: S311
    text = list(saved(PLAIN.replace("CTI3", 'CTI3\nORIGINATOR "A"'), separator, quoted=quoted))
    for _ in range(chance.randint(1, 8)):
        place = chance.randrange(len(text))
        text[place : place + chance.randint(0, 4)] = chance.choice('",;\t\n 0aE')
    try:
        samples = read("".join(text))
    except GamutError:
        return
    assert np.isfinite(samples.lab).all()


@pytest.mark.parametrize("first_line", ["CTI1", "CTI2   ", "cti1", '"CTI1"\t'])
def test_charts_of_argyll_hold_estimates(first_line):
    text = PLAIN.replace("CTI3", first_line + '\nORIGINATOR "Argyll targen"')
    if '"' in first_line:
        text = text.replace("BEGIN_DATA_FORMAT", '"BEGIN_DATA_FORMAT"', 1)
    with pytest.raises(UnrecognisedFormatError, match="colours are estimates") as caught:
        read(text)
    assert ".ti3" in caught.value.remedy
    assert caught.value.where == {"line": 1}


@pytest.mark.slow
def test_charts_that_targen_makes_are_refused(tmp_path):
    targen = shutil.which("targen")
    if targen is None:
        pytest.skip("targen of ArgyllCMS is not installed")
    for inks in ("-d3", "-d4"):
        subprocess.run(
            [targen, inks, "-f20", "chart"], cwd=tmp_path, check=True, capture_output=True
        )
        with pytest.raises(UnrecognisedFormatError, match="colours are estimates"):
            read_characterisation((tmp_path / "chart.ti1").read_bytes())
