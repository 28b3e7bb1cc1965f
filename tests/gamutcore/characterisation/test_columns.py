from __future__ import annotations

import pytest

from gamutcore.characterisation.columns import MAX_COLUMNS, column_roles
from gamutcore.errors import ConditionError, MissingColumnError, SampleLimitError


@pytest.mark.parametrize(
    ("names", "channels", "device", "lab", "xyz"),
    [
        ("LAB_L LAB_A LAB_B", "", (), (0, 1, 2), None),
        ("L* a* b*", "", (), (0, 1, 2), None),
        ("x R G B X Y Z", "R G B", (1, 2, 3), None, (4, 5, 6)),
        ("C M Y K L a b", "C M Y K", (0, 1, 2, 3), (4, 5, 6), None),
        ("rgb_r rgb_g rgb_b lab_l lab_a lab_b", "R G B", (0, 1, 2), (3, 4, 5), None),
        ("LAB_B LAB_L LAB_A CMY_Y CMY_M CMY_C", "C M Y", (5, 4, 3), (1, 2, 0), None),
        ("SAMPLE_ID 3CLR_2 3CLR_1 3CLR_3 XYZ_X XYZ_Y XYZ_Z", "1 2 3", (2, 1, 3), None, (4, 5, 6)),
        ("iRGB_R iRGB_G iRGB_B XYZ_X XYZ_Y XYZ_Z", "R G B", (0, 1, 2), None, (3, 4, 5)),
        ("GRAY_W LAB_L LAB_A LAB_B", "W", (0,), (1, 2, 3), None),
        (
            "CMYKcm_C CMYKcm_M CMYKcm_Y CMYKcm_K CMYKcm_c CMYKcm_m LAB_L LAB_A LAB_B",
            "C M Y K c m",
            (0, 1, 2, 3, 4, 5),
            (6, 7, 8),
            None,
        ),
        (
            "CMYKOGV_C CMYKOGV_M CMYKOGV_Y CMYKOGV_K CMYKOGV_O CMYKOGV_G CMYKOGV_V L A B",
            "C M Y K O G V",
            (0, 1, 2, 3, 4, 5, 6),
            (7, 8, 9),
            None,
        ),
    ],
)
def test_columns_are_told_by_their_names(names, channels, device, lab, xyz):
    roles = column_roles(names.split())
    assert roles.channels == tuple(channels.split())
    assert (roles.device, roles.lab, roles.xyz) == (device, lab, xyz)


def test_spectra_densities_and_statistics_are_no_device_values():
    names = ["D_RED", "D_VIS", "STDEV_L", "SPEC_380", "MEAN_DE", "XYY_X", "LAB_L", "LAB_A", "LAB_B"]
    roles = column_roles(names)
    assert roles.device == ()
    assert roles.lab == (6, 7, 8)


def test_a_second_set_of_device_values_is_named_as_ignored():
    names = [
        "CMYK_C",
        "CMYK_M",
        "CMYK_Y",
        "CMYK_K",
        "RGB_R",
        "RGB_G",
        "RGB_B",
        "LAB_L",
        "LAB_A",
        "LAB_B",
    ]
    assert column_roles(names).ignored == ("RGB",)


@pytest.mark.parametrize(
    ("names", "column"),
    [
        ("LAB_L LAB_A", "LAB_B"),
        ("LAB_L LAB_A LAB_B LAB_L", "LAB_L"),
        ("RGB_R RGB_G LAB_L LAB_A LAB_B", "RGB_B"),
        ("CMYK_C CMYK_M CMYK_Y CMYK_K CMYK_K LAB_L LAB_A LAB_B", "CMYK_K"),
        ("7CLR_1 7CLR_2 LAB_L LAB_A LAB_B", "7CLR_3"),
        ("3CLR_1 3CLR_2 3CLR_3 3CLR_4 LAB_L LAB_A LAB_B", "3CLR_4"),
    ],
)
def test_an_incomplete_or_doubled_set_names_the_column(names, column):
    with pytest.raises(MissingColumnError) as caught:
        column_roles(names.split(), where={"line": 3})
    assert caught.value.where["field"] == column
    assert caught.value.where["line"] == 3
    assert caught.value.remedy


def test_without_a_colour_the_columns_that_are_there_are_listed():
    with pytest.raises(MissingColumnError, match="spectra") as caught:
        column_roles(["RGB_R", "RGB_G", "RGB_B", "SPECTRAL_NM_380"])
    assert caught.value.where["columns"] == ["RGB_R", "RGB_G", "RGB_B", "SPECTRAL_NM_380"]


def test_columns_and_channels_are_limited():
    with pytest.raises(SampleLimitError):
        column_roles([f"N{i}" for i in range(MAX_COLUMNS + 1)])
    names = [f"16CLR_{i}" for i in range(1, 17)]
    with pytest.raises(SampleLimitError):
        column_roles([*names, "LAB_L", "LAB_A", "LAB_B"])


BANDS = [f"SPEC_{nm}" for nm in range(380, 740, 10)]


@pytest.mark.parametrize(
    ("names", "kinds"),
    [
        ("LCH_L LCH_C LCH_H", ("LCH",)),
        ("LAB_L LAB_C LAB_H", ("LCH",)),
        ("L* C* h", ("LCH",)),
        ("L* C*ab hab", ("LCH",)),
        ("LAB_L LAB_A LAB_B LAB_C LAB_H", ("LAB",)),
        ("XYY_X XYY_Y XYY_CAPY", ("XYY",)),
        ("x y Y", ("XYY",)),
        ("Y x y", ("XYY",)),
        ("X Y Z x y Y", ("XYZ",)),
        ("LAB_L LAB_A LAB_B x y Y", ("LAB", "XYY")),
        (" ".join(BANDS), ("SPECTRUM",)),
        (" ".join(["X Y Z", *BANDS]), ("XYZ", "SPECTRUM")),
        ("XYZ_X XYZ_Y XYZ_Z XYY_X XYY_Y", ("XYZ",)),
    ],
)
def test_all_kinds_of_colours(names, kinds):
    roles = column_roles(names.split())
    assert roles.colour_columns == kinds
    assert len(roles.selected) == len(roles.kinds) == len(roles.selected_names)


def test_upper_and_lower_case_tell_chromaticities_from_tristimulus_values():
    assert column_roles(["Y", "x", "y"]).xyy == (1, 2, 0)


@pytest.mark.parametrize("form", ["M{0}_{1}", "{1}_M{0}", "{1} (M{0})", "m{0}.{1}"])
def test_conditions_in_names(form):
    names = ["R", "G", "B", *(form.format(c, n) for c in (0, 2) for n in ("L", "a", "b"))]
    with pytest.raises(ConditionError, match="M0, M2"):
        column_roles(names)
    roles = column_roles(names, condition="M2")
    assert (roles.device, roles.lab, roles.condition) == ((0, 1, 2), (6, 7, 8), "M2")
    assert roles.ignored == ("columns of M0",)


def test_colours_of_no_stated_condition_are_not_mixed_with_others():
    roles = column_roles(["LAB_L", "LAB_A", "LAB_B", *(f"M1_{band}" for band in BANDS)])
    assert roles.lab is None
    assert roles.condition == "M1"
    assert len(roles.spectrum) == 36


def test_a_column_of_conditions_is_read_last():
    roles = column_roles(["Condition", "LAB_L", "LAB_A", "LAB_B"])
    assert roles.selected == (1, 2, 3, 0)
    assert roles.kinds[-1] == "condition"
