from __future__ import annotations

import numpy as np
import pytest

from gamutcore.characterisation.spectra import (
    are_wavelengths,
    reflectance_scale,
    spans_the_visible_range,
    spectral_columns,
    wavelength,
)
from gamutcore.errors import MissingColumnError


@pytest.mark.parametrize(
    "name",
    [
        "SPEC_380", "SPECTRAL_380", "SPECTRAL_NM380", "NM_380", "SPECTRAL_NM_380", "nm380", "380",
        "380nm", "380 nm", "380.0", "R_380", "Spec380",
    ],
)  # fmt: skip
def test_the_names_that_bands_go_by(name):
    """The first five are those of real files, as the notes on CGATS traps list them."""
    assert wavelength(name) == 380


@pytest.mark.parametrize("name", ["LAB_L", "SPEC", "D_380", "12", "1500", "SPEC_38", "0380", ""])
def test_other_names(name):
    assert wavelength(name) is None


def test_columns_come_in_the_order_of_their_wavelengths():
    names = ["ID", *(f"NM_{nm}" for nm in range(730, 370, -10))]
    columns, wavelengths = spectral_columns(names)
    assert wavelengths == tuple(range(380, 740, 10))
    assert columns == tuple(range(36, 0, -1))


def test_too_few_bands_are_no_spectrum():
    assert spectral_columns([f"SPEC_{nm}" for nm in range(400, 700, 50)]) == ((), ())


@pytest.mark.parametrize(
    ("names", "column"),
    [
        ([*(f"SPEC_{nm}" for nm in range(400, 710, 10)), "NM_500"], "NM_500"),
        ([f"SPEC_{nm}" for nm in range(500, 710, 10)], "SPEC_500"),
    ],
)
def test_doubled_bands_and_narrow_spectra_are_refused(names, column):
    with pytest.raises(MissingColumnError) as caught:
        spectral_columns(names, {"line": 4})
    assert caught.value.where == {"line": 4, "field": column}


def test_numbers_that_are_names_of_bands():
    assert are_wavelengths([str(nm) for nm in range(380, 740, 10)])
    assert not are_wavelengths([str(nm) for nm in range(380, 440, 10)])
    assert not are_wavelengths([str(nm) for nm in (*range(380, 740, 10), 900)])
    assert not are_wavelengths([*(str(nm) for nm in range(380, 740, 10)), "x"])


def test_fluorescence_goes_above_full_scale_on_both_scales():
    assert reflectance_scale(np.array([[0.1, 1.31]])) == 1
    assert reflectance_scale(np.array([[10.0, 131.0]])) == 100


def test_what_spans_the_visible_range():
    assert spans_the_visible_range((380, 680))
    assert not spans_the_visible_range((380, 600))
    assert not spans_the_visible_range((450, 730))
