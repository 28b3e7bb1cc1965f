from __future__ import annotations

import pytest

from gamutcore.characterisation.conditions import (
    chosen_condition,
    condition_label,
    is_reflective_condition,
    stated_condition,
)
from gamutcore.errors import ConditionError


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("M1", "M1"),
        ("m0", "M0"),
        ("M1_Daylight", "M1"),  # CxF3's DeviceIllumination
        ("M2_UVExcluded", "M2"),
        ("M0_Measurement", "M0"),
        ("MeasurementCondition=M1\tFilter=no", "M1"),
        ("Illumination=D50 ObserverAngle=2 WhiteBase=Abs Filter=UVcut", "M2"),
        ("Polarizer", "M3"),
        ("no polarisation filter", "no polarisation filter"),
        ("SM1000", "SM1000"),
        ("  wet,   fresh ", "wet, fresh"),
    ],
)
def test_names_of_conditions(text, label):
    assert condition_label(text) == label


@pytest.mark.parametrize(
    ("keywords", "label"),
    [
        ({"MEASUREMENT_CONDITION": "M2"}, "M2"),
        ({"MEASUREMENT_SOURCE": "MeasurementCondition=M1 Filter=no"}, "M1"),
        ({"FILTER": "UVcut"}, "M2"),
        ({"INSTRUMENTATION": "Spectrolino, ISO 13655 M0, white backing"}, "M0"),
        ({"MEASUREMENT_GEOMETRY": "45/0, Reflection, M1"}, "M1"),
        # No filter says nothing: the lamp may be anything.
        ({"FILTER": "None", "INSTRUMENTATION": "GretagMacbeth Spectrolino"}, None),
        ({"DESCRIPTOR": "M1"}, None),
        ({}, None),
    ],
)
def test_conditions_that_keywords_state(keywords, label):
    assert stated_condition(keywords) == label


def test_one_condition_needs_no_choice():
    assert chosen_condition(["M1", "M1"], None) == "M1"
    assert chosen_condition([None], None) is None
    assert chosen_condition([], None) is None


def test_several_conditions_are_named_and_so_is_the_option_that_chooses():
    with pytest.raises(ConditionError, match=r"M0, M1, M2") as caught:
        chosen_condition(["M0", "M1", "M2"], None)
    assert caught.value.where == {"field": "condition", "conditions": ["M0", "M1", "M2"]}
    assert "`condition`" in caught.value.remedy
    assert chosen_condition(["M0", "M1", "M2"], "m1") == "M1"
    assert chosen_condition(["M1, black backing", "M1, white backing"], "M1, White backing") == (
        "M1, white backing"
    )


def test_known_and_unknown_conditions_are_not_mixed():
    with pytest.raises(ConditionError, match="without one"):
        chosen_condition(["M0", None], None)


@pytest.mark.parametrize("found", [["M0"], [None], []])
def test_a_condition_that_is_not_there_is_refused(found):
    with pytest.raises(ConditionError) as caught:
        chosen_condition(found, "M2")
    assert caught.value.where["field"] == "condition"


def test_conditions_of_iso_13655_are_of_reflecting_samples():
    assert is_reflective_condition("M2")
    assert is_reflective_condition("M1, black backing")
    assert not is_reflective_condition("dark room")
    assert not is_reflective_condition(None)
