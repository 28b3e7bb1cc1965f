from __future__ import annotations

import numpy as np
import pytest

from gamutcore.characterisation.columns import column_roles
from gamutcore.characterisation.samples import samples_from_values
from gamutcore.errors import (
    ConditionError,
    InvalidPointsError,
    MalformedFileError,
    TooFewPointsError,
)

ROLES = column_roles(["RGB_R", "RGB_G", "RGB_B", "LAB_L", "LAB_A", "LAB_B"])


def values(device, lab=(50.0, 1.0, 2.0)):
    return np.array([[*row, *lab] for row in device], dtype=float)


@pytest.mark.parametrize(
    ("highest", "scale"), [(1, 1), (0.5, 1), (100, 100), (90, 100), (255, 255), (1023, 1023)]
)
def test_device_values_are_put_on_the_scale_from_0_to_1(highest, scale):
    samples = samples_from_values("csv", ROLES, values([(0, 0, 0), (highest, 0, highest / 2)]))
    np.testing.assert_allclose(samples.device[1], np.array([1, 0, 0.5]) * highest / scale)
    assert samples.provenance["device_scale"] == scale


def test_rounding_beyond_full_scale_is_cut_off():
    samples = samples_from_values("csv", ROLES, values([(0, 0, 0), (100.0001, 0, -0.00001)]))
    assert samples.device.max() == 1
    assert samples.device.min() == 0


@pytest.mark.parametrize(("value", "problem"), [(-5, "scale"), (70000, "scale")])
def test_device_values_on_no_scale_are_refused_with_their_place(value, problem):
    with pytest.raises(MalformedFileError, match=problem) as caught:
        samples_from_values("csv", ROLES, values([(0, 0, 0), (50, value, 0)]))
    assert caught.value.where == {"row": 2, "column": 2, "field": "RGB_G"}


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e5])
def test_colours_that_are_none_are_refused_with_their_line(value):
    table = values([(0, 0, 0), (1, 1, 1)])
    table[1, 4] = value
    with pytest.raises(InvalidPointsError) as caught:
        samples_from_values("csv", ROLES, table, lines=np.array([7, 9]))
    assert caught.value.where == {"line": 9, "column": 5, "field": "LAB_A"}


def test_no_samples_are_refused():
    with pytest.raises(TooFewPointsError):
        samples_from_values("csv", ROLES, np.empty((0, 6)))


def test_lights_are_additive_and_inks_are_not():
    assert samples_from_values("csv", ROLES, values([(0, 0, 0)])).additive
    inks = column_roles(["CMY_C", "CMY_M", "CMY_Y", "LAB_L", "LAB_A", "LAB_B"])
    assert not samples_from_values("csv", inks, values([(0, 0, 0)])).additive


def test_hostile_conditions_are_cut_short():
    conditions = {f"K{i}": "x" * 10_000 for i in range(1000)}
    samples = samples_from_values("cgats", ROLES, values([(0, 0, 0)]), conditions=conditions)
    assert sum(map(len, samples.conditions.values())) <= 100_000


def test_a_condition_that_rows_state():
    roles = column_roles(["LAB_L", "LAB_A", "LAB_B", "CONDITION"])
    rows = np.array([[1, 0, 0, 0], [2, 0, 0, 1], [3, 0, 0, 0]], float)
    with pytest.raises(ConditionError, match="M0, M1"):
        samples_from_values("csv", roles, rows, row_conditions=("M0", "M1"))
    samples = samples_from_values("csv", roles, rows, row_conditions=("M0", "M1"), condition="M0")
    assert samples.lab[:, 0].tolist() == [1, 3]
    assert samples.provenance["measurement_condition"] == "M0"
    assert samples.provenance["patches"] == {"read": 3, "dropped": 1, "averaged": 0}


def test_black_has_no_chromaticity():
    roles = column_roles(["XYY_X", "XYY_Y", "XYY_CAPY"])
    samples = samples_from_values("csv", roles, np.array([[0, 0, 0], [0.5, 0.25, 10]], float))
    np.testing.assert_allclose(samples.xyz, [[0, 0, 0], [20, 10, 10]])


def test_spectra_are_described():
    roles = column_roles([f"SPEC_{nm}" for nm in range(380, 740, 10)])
    samples = samples_from_values("csv", roles, np.full((2, 36), 0.5))
    assert len(samples) == 2
    assert samples.provenance["spectra"] == {"from": 380, "to": 730, "bands": 36, "step": 10}
    assert samples.provenance["colour_columns"] == ["SPECTRUM"]


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e9])
def test_bands_that_are_no_numbers_are_refused(value):
    roles = column_roles([f"SPEC_{nm}" for nm in range(380, 740, 10)])
    rows = np.full((2, 36), 0.5)
    rows[1, 3] = value
    with pytest.raises(InvalidPointsError) as caught:
        samples_from_values("csv", roles, rows)
    assert caught.value.where == {"row": 2, "column": 4, "field": "SPEC_410"}
