"""Tables of text: delimiters, names of columns, conditions, spectra, scales and limits."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation import read_characterisation
from gamutcore.errors import (
    ConditionError,
    GamutError,
    InvalidPointsError,
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
    UnrecognisedFormatError,
)

ROWS = [["50", "0.5", "0"], ["60", "-20", "30"]]
LAB = np.array([[50, 0.5, 0], [60, -20, 30]])
BANDS = [f"SPEC_{nm}" for nm in range(380, 740, 10)]


def read(text, **options):
    return read_characterisation(text.encode(), **options)


def table(names, *rows, **options):
    """Read a table of names, in one text or as a list, and of rows."""
    names = names.split() if isinstance(names, str) else names
    rows = rows or [range(1, len(names) + 1)]
    return read("\n".join(",".join(map(str, row)) for row in [names, *rows]), **options)


def refused(kind, read, *args, **options):
    """Return where and what an error of a kind says."""
    with pytest.raises(kind) as caught:
        read(*args, **options)
    assert caught.value.remedy or kind is SampleLimitError
    return caught.value.where


@pytest.mark.parametrize("header", [["LAB_L", "LAB_A", "LAB_B"], ["L*", "a*", "b*"], None])
@pytest.mark.parametrize("mark", [",", ";", "\t", " ", ", "])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_every_delimiter_and_line_end(header, mark, end):
    lines = [mark.join(row) for row in [header, *ROWS] if row]
    samples = read(end.join(["# a note", "", *lines]) + end)
    np.testing.assert_array_equal(samples.lab, LAB)
    assert bool(samples.warnings) == (header is None)


@pytest.mark.parametrize(
    "text",
    [
        "L;a;b\n50,0;0,5;0\n60;-2,0e1;30\n",
        '"name, of patch","L","a","b"\n"x, y",50,0.5,0\n"z",60,-20,30,\n',
        "L,a,b\n50,.5,0\n+6e1,-20.,30\n",
    ],
)
def test_decimal_commas_quotes_and_further_columns(text):
    np.testing.assert_array_equal(read(text).lab, LAB)


@pytest.mark.parametrize(
    ("names", "channels", "device", "lab", "xyz"),
    [
        ("L* a* b*", "", (), (1, 2, 3), None),
        ("x R G B X Y Z", "R G B", (2, 3, 4), None, (5, 6, 7)),
        ("C M Y K L a b", "C M Y K", (1, 2, 3, 4), (5, 6, 7), None),
        ("rgb_r rgb_g rgb_b lab_l lab_a lab_b", "R G B", (1, 2, 3), (4, 5, 6), None),
        ("LAB_B LAB_L LAB_A CMY_Y CMY_M CMY_C", "C M Y", (6, 5, 4), (2, 3, 1), None),
        ("SAMPLE_ID 3CLR_2 3CLR_1 3CLR_3 XYZ_X XYZ_Y XYZ_Z", "1 2 3", (3, 2, 4), None, (5, 6, 7)),
        ("iRGB_R iRGB_G iRGB_B XYZ_X XYZ_Y XYZ_Z", "R G B", (1, 2, 3), None, (4, 5, 6)),
        ("GRAY_W LAB_L LAB_A LAB_B", "W", (1,), (2, 3, 4), None),
        (
            "CMYKcm_C CMYKcm_M CMYKcm_Y CMYKcm_K CMYKcm_c CMYKcm_m LAB_L LAB_A LAB_B",
            "C M Y K c m",
            (1, 2, 3, 4, 5, 6),
            (7, 8, 9),
            None,
        ),
        # densities and statistics are no device values
        ("D_RED D_VIS STDEV_L SPEC_380 MEAN_DE XYY_X L a b", "", (), (7, 8, 9), None),
    ],
)
def test_columns_are_told_by_their_names(names, channels, device, lab, xyz):
    samples = table(names)
    assert samples.channels == tuple(channels.split())
    if device:
        scale = samples.provenance["device_scale"]
        np.testing.assert_allclose(samples.device[0] * scale, device)
    for found, expected in ((samples.lab, lab), (samples.xyz, xyz)):
        assert (found is None) == (expected is None)
        if expected is not None:
            np.testing.assert_array_equal(found[0], expected)


@pytest.mark.parametrize(
    ("names", "kinds", "colour"),
    [
        ("LCH_L LCH_C LCH_H", ["LCH"], {"lab": (50, 0, 20)}),
        ("LAB_L LAB_C LAB_H", ["LCH"], {"lab": (50, 0, 20)}),
        ("L* C*ab hab", ["LCH"], {"lab": (50, 0, 20)}),
        ("LAB_L LAB_A LAB_B LAB_C LAB_H", ["LAB"], {"lab": (50, 20, 90)}),
        ("XYY_X XYY_Y XYY_CAPY", ["XYY"], {"xyz": (100, 40, 60)}),
        ("x y Y", ["XYY"], {"xyz": (100, 40, 60)}),
        ("X Y Z x y Y", ["XYZ"], {"xyz": (50, 20, 90)}),
        ("LAB_L LAB_A LAB_B x y Y", ["LAB", "XYY"], {"lab": (50, 20, 90), "xyz": (100, 40, 60)}),
        (" ".join(["X Y Z", *BANDS]), ["XYZ", "SPECTRUM"], {"xyz": (50, 20, 90)}),
        ("XYZ_X XYZ_Y XYZ_Z XYY_X XYY_Y", ["XYZ"], {"xyz": (50, 20, 90)}),
    ],
)
def test_all_kinds_of_colours(names, kinds, colour):
    """Lower case tells chromaticities from tristimulus values."""
    chromatic = names.startswith(("XYY", "x"))
    row = [0.5, 0.2, 40] if chromatic else [50, 20, 90, 0.5, 0.2, 40]
    row += [0.5] * (len(names.split()) - len(row))
    samples = table(names, row[: len(names.split())])
    assert samples.provenance["colour_columns"] == kinds
    for kind, values in colour.items():
        np.testing.assert_allclose(getattr(samples, kind), [values], atol=1e-12)


def test_black_has_no_chromaticity_and_a_light_has_one():
    np.testing.assert_allclose(
        table("XYY_X XYY_Y XYY_CAPY", (0, 0, 0), (0.5, 0.25, 10)).xyz, [[0, 0, 0], [20, 10, 10]]
    )
    where = refused(InvalidPointsError, table, "x y Y", (0.3, 0.3, 1), (0.3, 0, 40))
    assert where == {"line": 3, "field": "xyY"}


def test_a_second_set_of_device_values_is_named_as_ignored():
    said = table("CMYK_C CMYK_M CMYK_Y CMYK_K RGB_R RGB_G RGB_B LAB_L LAB_A LAB_B").warnings
    assert any("RGB" in text for text in said)


@pytest.mark.parametrize(
    ("names", "column"),
    [
        ("id LAB_L LAB_A", "LAB_B"),
        ("LAB_L LAB_A LAB_B LAB_L", "LAB_L"),
        ("RGB_R RGB_G LAB_L LAB_A LAB_B", "RGB_B"),
        ("CMYK_C CMYK_M CMYK_Y CMYK_K CMYK_K LAB_L LAB_A LAB_B", "CMYK_K"),
        ("7CLR_1 7CLR_2 LAB_L LAB_A LAB_B", "7CLR_3"),
        ("3CLR_1 3CLR_2 3CLR_3 3CLR_4 LAB_L LAB_A LAB_B", "3CLR_4"),
        (" ".join([*BANDS, "NM_500"]), "NM_500"),
        (" ".join(f"SPEC_{nm}" for nm in range(500, 710, 10)), "SPEC_500"),
    ],
)
def test_an_incomplete_or_doubled_set_names_the_column(names, column):
    where = refused(MissingColumnError, table, names)
    assert (where["line"], where["field"]) == (1, column)


def test_tables_without_colours_list_their_columns():
    names = ["RGB_R", "RGB_G", "RGB_B", "SPECTRAL_NM_380"]
    assert refused(MissingColumnError, table, names)["columns"] == names
    for text in ("Lightness,red,yellow\n1,2,3\n", "1,2,3,4\n1,2,3,4\n"):
        refused(MissingColumnError, read, text)


@pytest.mark.parametrize("text", ["# only a note\n", "This is prose, not data", "one\ntwo\n"])
def test_prose_is_no_table(text):
    refused(UnrecognisedFormatError, read, text)


@pytest.mark.parametrize(
    ("names", "rows"),
    [
        ([f"N{i}" for i in range(5000)], ()),
        ([*(f"16CLR_{i}" for i in range(1, 17)), "LAB_L", "LAB_A", "LAB_B"], ()),
        ("CONDITION L a b", [[f"run {n}", 1, 2, 3] for n in range(1000)]),
    ],
)
def test_columns_channels_and_conditions_are_limited(names, rows):
    refused(SampleLimitError, table, names, *rows)


def test_lines_are_limited(monkeypatch):
    monkeypatch.setattr("gamutcore.characterisation.text.MAX_LINES", 1000)
    refused(SampleLimitError, read, "L,a,b\n" + "\n" * 1001 + "1,2,3\n")


def test_numbers_are_limited_and_not_rows_alone(monkeypatch):
    monkeypatch.setattr("gamutcore.characterisation.text.MAX_TEXT_VALUES", 100_000)
    names = [f"SPEC_{nm}" for nm in range(300, 1200)]
    with pytest.raises(SampleLimitError, match="900 numbers"):
        table(names, *itertools.repeat(["0.5"] * 900, 112))


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("L,a,b\n1,2,3\n1,2\n", {"line": 3, "column": 3}),
        ("L,a,b\n1,2,3\n\n1,2,3,4\n", {"line": 4, "column": 4}),
        *((f"L,a,b\n1,2,3\n\n1,{bad},3\n", {"line": 4, "column": 2, "field": "a"}) for bad in (
            "x", "1_0", "0x10", "1.2.3", "--1", "",
        )),
        ("L,a,b\n" + "1," * 2 + '"' + "3" * 200_000, {"line": 2}),
        ("L,a,b\n" + "1 " * 600_000, {"line": 2}),
    ],
)  # fmt: skip
def test_errors_say_where(text, where):
    found = refused(MalformedFileError, read, text)
    assert {key: found[key] for key in where} == where


@pytest.mark.parametrize("value", ["nan", "inf", "-1e400", "1e5"])
def test_colours_that_are_none_are_refused_with_their_line(value):
    where = refused(InvalidPointsError, table, "R G B L a b", [0] * 6, [1, 1, 1, 50, value, 2])
    assert where == {"line": 3, "column": 5, "field": "a"}
    rows = [[0.5] * 36, [*[0.5] * 3, 1e9 if value == "1e5" else value, *[0.5] * 32]]
    where = refused(InvalidPointsError, table, BANDS, *rows)
    assert where == {"line": 3, "column": 4, "field": "SPEC_410"}


@given(st.floats(-200, 200, width=32))
def test_a_written_number_is_read_back(value):
    assert table("L a b", [repr(value), 0, 0]).lab[0, 0] == value


def test_many_rows_are_read_in_their_order():
    values = np.arange(20_000) / 200
    samples = table("L a b", *([value, 0, "0.5"] for value in values))
    np.testing.assert_array_equal(samples.lab[:, 0], values)
    assert set(samples.lab[:, 2]) == {0.5}


@given(st.lists(st.sampled_from(['"', ",", ";", "\t", "\n", "1", "L", "a", "b", "#", " "])))
def test_any_text_gives_samples_or_a_named_error(pieces):
    try:
        samples = read("".join(pieces))
    except GamutError:
        return
    assert np.isfinite(samples.lab).all()


class TestScales:
    @pytest.mark.parametrize(
        ("highest", "scale"), [(1, 1), (0.5, 1), (100, 100), (90, 100), (255, 255), (1023, 1023)]
    )
    def test_device_values_are_put_on_the_scale_from_0_to_1(self, highest, scale):
        rows = [(0, 0, 0, 50, 1, 2), (highest, 0, highest / 2, 50, 1, 2)]
        samples = table("R G B L a b", *rows)
        np.testing.assert_allclose(samples.device[1], np.array([1, 0, 0.5]) * highest / scale)
        assert samples.provenance["device_scale"] == scale

    def test_rounding_beyond_full_scale_is_cut_off(self):
        rows = [(0, 0, 0, 50, 1, 2), (100.0001, 0, -0.00001, 50, 1, 2)]
        device = table("R G B L a b", *rows).device
        assert (device.min(), device.max()) == (0, 1)

    @pytest.mark.parametrize("value", [-5, 70_000])
    def test_device_values_on_no_scale_are_refused_with_their_place(self, value):
        rows = [(0, 0, 0, 50, 1, 2), (50, value, 0, 50, 1, 2)]
        where = refused(MalformedFileError, table, "RGB_R RGB_G RGB_B L a b", *rows)
        assert where == {"line": 3, "column": 2, "field": "RGB_G"}

    @pytest.mark.parametrize("scale", [1, 100])
    def test_fluorescence_goes_above_full_scale(self, scale):
        row = [0.9 * scale] * 36
        row[6] = 1.31 * scale
        provenance = table(BANDS, row).provenance
        assert provenance["spectra"] == {"from": 380, "to": 730, "bands": 36, "step": 10}
        assert provenance["colour_columns"] == ["SPECTRUM"]


@pytest.mark.parametrize("form", [
    "SPEC_{}", "SPECTRAL_{}", "SPECTRAL_NM{}", "NM_{}", "SPECTRAL_NM_{}", "nm{}", "{}", "{}nm",
    "{} nm", "{}.0", "R_{}", "Spec{}",
])  # fmt: skip
def test_bands_come_in_the_order_of_their_wavelengths_by_all_their_names(form):
    """The first five are those of real files, as the notes on CGATS traps list them."""
    wavelengths = list(range(380, 740, 10))
    names = ["patch", *(form.format(nm) for nm in reversed(wavelengths)), "D_380", "SPEC_38"]
    spectra = table(names, [1, *np.linspace(0.9, 0.2, 36).round(2), 0, 0]).spectra
    assert spectra.wavelengths.tolist() == wavelengths
    assert (np.diff(spectra.values[0]) > 0).all()


def test_a_row_of_wavelengths_is_a_header():
    samples = table([str(nm) for nm in range(380, 740, 10)], [0.5] * 36)
    assert samples.spectra.wavelengths.tolist() == list(range(380, 740, 10))


def test_too_few_bands_and_other_numbers_are_no_spectrum():
    for names in (
        [f"SPEC_{nm}" for nm in range(400, 700, 50)],
        [str(nm) for nm in (*range(380, 740, 10), 1900)],
    ):
        with pytest.raises(GamutError):
            table(names, [0.5] * len(names))


class TestConditions:
    @pytest.mark.parametrize(
        ("text", "label"),
        [
            ("M1", "M1"),
            ("m0", "M0"),
            ("M1_Daylight", "M1"),  # CxF3's DeviceIllumination
            ("M2_UVExcluded", "M2"),
            ("M0_Measurement", "M0"),
            ("MeasurementCondition=M1 Filter=no", "M1"),
            ("Illumination=D50 ObserverAngle=2 WhiteBase=Abs Filter=UVcut", "M2"),
            ("Polarizer", "M3"),
            ("no polarisation filter", "no polarisation filter"),
            ("SM1000", "SM1000"),
        ],
    )
    def test_names_in_rows(self, text, label):
        assert table("CONDITION L a b", [text, 1, 2, 3]).condition == label

    def test_rows_of_one_condition_are_chosen(self):
        rows = [("M0", 50, 1, 2), ("m1", 60, 1, 2), ("M0_Measurement", 70, 1, 2)]
        where = refused(ConditionError, table, "condition L a b", *rows)
        assert where == {"field": "condition", "conditions": ["M0", "M1"]}
        samples = table("condition L a b", *rows, condition="m0")
        assert samples.lab[:, 0].tolist() == [50, 70]
        assert samples.provenance["measurement_condition"] == "M0"
        assert samples.provenance["patches"] == {"read": 3, "dropped": 1, "averaged": 0}
        refused(ConditionError, table, "condition L a b", *rows, condition="M2")

    @pytest.mark.parametrize("form", ["M{0}_{1}", "{1}_M{0}", "{1} (M{0})", "m{0}.{1}"])
    def test_names_of_columns(self, form):
        names = ["R", "G", "B", *(form.format(c, n) for c in (0, 2) for n in ("L", "a", "b"))]
        assert refused(ConditionError, table, names)["conditions"] == ["M0", "M2"]
        samples = table(names, condition="M2")
        assert samples.lab.tolist() == [[7, 8, 9]]
        assert samples.condition == "M2"
        assert any("columns of M0" in said for said in samples.warnings)

    def test_colours_of_no_stated_condition_are_not_mixed_with_others(self):
        names = ["LAB_L", "LAB_A", "LAB_B", *(f"M1_{band}" for band in BANDS)]
        samples = table(names, [1, 2, 3, *[0.5] * 36])
        assert samples.lab is None
        assert samples.condition == "M1"
