"""Repeated readings that contradict each other, and device values whose colours are a sheet.

Right volumes of the reports are those of the same measurements without the failed reading: 794,163
of the display, 365,524 of the press (issue 46).
"""

import json
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.characterisation import embedded_measurements, read_characterisation
from gamutcore.colours import consistent_samples, surface_colours
from gamutcore.errors import FlatPointsError, InvalidPointsError

REPORTS = Path(__file__).parents[2] / "data" / "reports"
WHITE = [95.0, 100.0, 108.9]
SRGB = np.array([[41.24, 35.76, 18.05], [21.26, 71.52, 7.22], [1.93, 11.92, 95.05]])


def samples(columns, rows):
    document = {"columns": columns.split(), "samples": np.asarray(rows, float).tolist()}
    return read_characterisation(json.dumps(document).encode())


def report(name):
    return read_characterisation((REPORTS / name).read_bytes())


def display(*more):
    """A display of 27 patches, and further readings: R, G, B, X, Y, Z."""
    levels = np.array(list(product([0, 50, 100], repeat=3)), float)
    xyz = (levels / 100) ** 2.2 @ SRGB.T + 0.05
    return samples("R G B X Y Z", [*np.hstack([levels, xyz]), *more])


def press(*more):
    """A press of 16 patches, and further readings: C, M, Y, K, L*, a*, b*."""
    inks = np.array(list(product([0, 100], repeat=4)), float)
    lab = inks @ np.array([[-25, -37, -50], [-35, 74, -3], [-5, -5, 93], [-70, 0, 0]]) / 100
    rows = np.hstack([inks, np.maximum(np.add(lab, [95, 0, 0]), [5, -128, -128])])
    return samples("CMYK_C CMYK_M CMYK_Y CMYK_K LAB_L LAB_A LAB_B", [*rows, *more])


@pytest.mark.parametrize(
    ("name", "reference", "line"),
    [
        ("display-one-white-reading-of-four-is-zero.ti3", "display-reference.ti3", 139),
        ("cmy-paper-twice-one-reading-is-zero.txt", "cmy-reference.txt", 36),
    ],
)
def test_a_reading_of_zero_beside_light_ones_is_left_out(name, reference, line):
    surface = surface_colours(report(name), surface_samples=500)
    right = surface_colours(report(reference), surface_samples=500)
    np.testing.assert_array_equal(surface.points, right.points)
    assert any(f"Line {line} is left out" in said for said in surface.provenance["warnings"])
    assert surface.provenance["patches"]["dropped"] == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "volume"),
    [
        ("display-one-white-reading-of-four-is-zero.ti3", 794_163),
        ("cmy-paper-twice-one-reading-is-zero.txt", 365_524),
        ("printer-lab-d65-saved-by-spreadsheet.txt", 676_538),
        ("cgats-saved-as-csv.csv", 676_538),
    ],
)
def test_volumes_of_the_reports(name, volume):
    # colours of the CSV are for another illuminant, with three decimals
    assert Gamut(REPORTS / name).volume == pytest.approx(volume, rel=5e-5)


def test_a_white_of_which_one_reading_is_half_as_bright_is_refused_with_both_lines():
    with pytest.raises(InvalidPointsError, match=r"Line 136 and line 137 contradict") as caught:
        surface_colours(report("display-white-twice-one-half-as-bright.ti3"))
    assert caught.value.where["readings"] == ["Line 136", "Line 137"]
    assert "measure the patch again" in caught.value.remedy


CYAN = [100, 0, 0, 0, 70, -37, -50]


@pytest.mark.parametrize(
    ("data", "rows"),
    [
        (press([100, 0, 0, 0, 0, 0, 0]), [17]),
        (press([99.97, 0.03, 0, 0, 0, 0, 0]), [17]),  # rounded otherwise
        (press([100, 0, 0, 0, 0, 0, 0], [100, 0, 0, 0, 0, 0, 0]), [17, 18]),
        (press(CYAN, [100, 0, 0, 0, 78, -37, -50]), [18]),
        (press(CYAN, [100, 0, 0, 0, 70, -37, -50.4], [100, 0, 0, 0, 0, 0, 0]), [19]),
        (display([100, 0, 0, 0, 0, 0]), [28]),
        (display([100, 100, 100, *WHITE], [100, 100, 100, 855, 900, 980]), [29]),
    ],
)
def test_readings_that_are_left_out(data, rows):
    found = consistent_samples(data)
    assert len(found) == len(data) - len(rows)
    said = [warning for warning in found.warnings if "is left out" in warning]
    assert [warning.partition(" is ")[0] for warning in said] == [f"Row {row}" for row in rows]
    np.testing.assert_array_equal(found.device, np.delete(data.device, np.array(rows) - 1, axis=0))


@pytest.mark.parametrize(
    "more",
    [
        [[100, 0, 0, 0, 78, -37, -50]],
        [[100, 0, 0, 0, 80, -37, -50], [100, 0, 0, 0, 92, -37, -50]],
        [CYAN, *[[100, 0, 0, 0, 50, -20, -30]] * 2],
    ],
)
def test_repeats_without_a_majority_are_refused(more):
    with pytest.raises(InvalidPointsError, match=r"Row 9 and row 1\d contradict each other"):
        consistent_samples(press(*more))


@pytest.mark.parametrize(
    "data",
    [
        press([100, 0, 0, 0, 72, -37, -50]),
        press(*[[100, 0, 0, 0, 70 + step, -37, -50 - step] for step in (0.5, -0.8, 1, -0.3, 1.2)]),
        display([0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0]),  # black may be no light
        display(*[[r, 50, 50, 20 + 40 * r / 100, 25, 30] for r in np.linspace(10, 40, 2000)]),
    ],
)
def test_honest_repeats_and_smooth_ramps_are_all_used(data):
    assert consistent_samples(data) is data


def test_spectra_are_compared_as_colours():
    bands = np.arange(400, 701, 20)
    columns = "CMY_C CMY_M CMY_Y " + " ".join(f"SPEC_{band}" for band in bands)
    inks = np.array(list(product([0, 100], repeat=3)), float)
    parts = np.stack([bands > 600, (bands > 500) & (bands <= 600), bands <= 500])
    rows = np.hstack([inks, 0.9 - inks @ parts * 0.008])
    failed = np.zeros((1, rows.shape[1]))
    found = consistent_samples(samples(columns, np.vstack([rows, failed])))
    assert len(found) == len(found.spectra.values) == len(rows)
    assert "Row 9 is left out: a reading of zero" in found.warnings[-1]


@pytest.mark.parametrize(
    "name",
    ["press/FOGRA39L.ti3", "press/TR002.ti3", "display/phone_RGBW_LCD_602.txt"],
)
def test_repeats_of_real_devices_agree(shared_data, name):
    data = read_characterisation((shared_data / name).read_bytes())
    assert consistent_samples(data) is data


def test_repeats_in_a_real_profile_agree(shared_data):
    profile = read_characterisation((shared_data / "display" / "Acer_XB271HU.icc").read_bytes())
    data = embedded_measurements(profile)
    assert consistent_samples(data) is data


def ramp(*channels):
    """Forty patches in some of four inks; the colours are curved and enclose no volume."""
    chance = np.random.default_rng(1)
    inks = np.full((40, 4), 20.0)
    inks[:, list(channels)] = chance.uniform(0, 100, (40, len(channels)))
    c, m, y, k = inks.T / 100
    lab = [95 - 30 * c - 40 * m - 60 * k, -37 * c**1.5 + 74 * m, 90 * y - 50 * c * (1 + m)]
    return np.hstack([inks, np.transpose(lab)])


def tilted(rows):
    """Inks of a plane that is not parallel to the axes."""
    rows[:, 2] = 0.5 * rows[:, 0] + 0.3 * rows[:, 1]
    return rows


@pytest.mark.parametrize(
    ("rows", "shape"),
    [
        (np.tile(ramp(0)[:1], (10, 1)), "are all equal"),
        (ramp(1), "lie on a line"),
        (ramp(0, 1), "lie in a plane"),
        (tilted(ramp(0, 1)), "lie in a plane"),
        (np.round(tilted(ramp(0, 1)), 1), "lie in a plane"),
    ],
)
def test_device_values_of_fewer_than_three_dimensions_are_refused(rows, shape):
    data = {
        "columns": ["CMYK_C", "CMYK_M", "CMYK_Y", "CMYK_K", "L", "a", "b"],
        "samples": rows.tolist(),
    }
    with pytest.raises(FlatPointsError, match=shape):
        Gamut(json.dumps(data).encode())


def test_ten_patches_of_one_ink_are_refused():
    with pytest.raises(FlatPointsError, match=r"lie in a plane.* vary: M, Y\."):
        Gamut(REPORTS / "cmyk-ten-patches-of-one-ink.txt")


def test_a_patch_that_alone_is_outside_a_plane_has_no_error():
    rows = ramp(0, 1)
    rows[0, 2] = 60
    surface = surface_colours(
        samples("CMYK_C CMYK_M CMYK_Y CMYK_K L a b", rows), intent="absolute", surface_samples=500
    )
    error = surface.provenance["model"]["leave_out_error"]
    assert error["percentile_95"] < 30
    assert any("rests on 1 single patch" in said for said in surface.provenance["warnings"])
