"""Reports by standard: published figures, independent sums, and what every report states."""

import csv
import itertools

import numpy as np
import pytest

import gamutcore
from gamutcore import Gamut
from gamutcore.errors import OptionError
from gamutcore.reports import STANDARDS, report, signal_codes, standard_intent, write_signals

BOX = Gamut([(50 + 30 * x, 30 * y, 30 * z) for x, y, z in itertools.product((-1, 1), repeat=3)])


@pytest.fixture(scope="module")
def srgb():
    return gamutcore.reference("srgb", surface_samples=1000)


@pytest.mark.parametrize(("count", "levels"), [(98, 5), (218, 7), (386, 9), (602, 11)])
def test_signals_are_the_surface_of_the_cube(count, levels):
    """6m² − 12m + 8 (IDMS 1.3, 5.32)."""
    codes = signal_codes(count, 10)
    assert len(codes) == count == 6 * levels**2 - 12 * levels + 8
    assert ((codes == 0) | (codes == 1023)).any(axis=1).all()
    assert len(np.unique(codes, axis=0)) == count
    assert len(np.unique(codes)) == levels


def test_signals_of_8_bits_are_those_of_the_published_sets():
    assert np.unique(signal_codes(602)).tolist() == [
        0, 25, 51, 76, 102, 127, 153, 178, 204, 229, 255,
    ]  # fmt: skip


def test_too_few_bits_are_refused():
    with pytest.raises(OptionError, match="not distinct") as error:
        signal_codes(602, 3)
    assert "4 bits" in error.value.remedy


def test_a_file_of_signals_with_readings_is_data(tmp_path):
    path = tmp_path / "signals.csv"
    write_signals(path, 98, 10)
    with path.open() as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["SAMPLE_ID", "RGB_R", "RGB_G", "RGB_B"]
    lines = [",".join([*rows[0], "XYZ_X", "XYZ_Y", "XYZ_Z"])]
    matrix = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    for row in rows[1:]:
        light = (np.array(row[1:], float) / 1023) ** 2.2
        lines.append(",".join([*row, *(f"{value:.5f}" for value in 100 * matrix @ light)]))
    path.write_text("\n".join(lines))
    document = report(Gamut(path, surface_samples=500), "idms")
    assert any("estimate" in sentence for sentence in document.sentences)
    # 602 signals of this display have 830,427 by a separate program; 98 are an estimate
    assert document.data["volume"] == pytest.approx(830_427, rel=0.02)


def test_srgb_has_the_published_volume(srgb):
    """830,732 by the MATLAB tools of the authors of the standard, 830,766 by their Python."""
    assert report(srgb, "idms").data["volume"] == pytest.approx(830_732, rel=1e-3)


def test_rings_hold_the_volume_and_coverage_of_a_box():
    """A cube of 60 a side, and the part of it that a smaller cube has."""
    small = Gamut(
        [(50 + 20 * x, 20 * y, 20 * z) for x, y, z in itertools.product((-1, 1), repeat=3)]
    )
    data = report(BOX, "iec-62977", small).data
    assert data["volume"] == pytest.approx(60**3, rel=1e-3)
    assert data["intersection_volume"] == pytest.approx(40**3, rel=1e-3)
    assert data["coverage"] == pytest.approx(1.0)
    assert data["rings"]["gamut"].shape == (100, 360)
    area = (data["rings"]["gamut"][-1] ** 2).sum() * np.pi / 360
    assert area == pytest.approx(data["volume"], rel=1e-5)


def test_figures_of_cie_246_are_those_of_boxes():
    shifted = Gamut(
        [(50 + 30 * x, 30 + 30 * y, 30 * z) for x, y, z in itertools.product((-1, 1), repeat=3)]
    )
    data = report(BOX, "cie-246", shifted).data
    expected = {"Vi/Vx": 0.5, "Vi/Vy": 0.5, "(Vx - Vi)/Vx": 0.5, "Vx/Vy": 1.0, "GCI": 0.5}
    assert {name: data[name] for name in expected} == pytest.approx(expected, abs=1e-3)
    with pytest.raises(OptionError, match="no reference"):
        report(BOX, "cie-246")


def e_paper():
    """A reflective display with a white of 40 % and a black of 8 %."""
    lines = ["CGATS.17", "CGV_DISPLAY_TYPE REFLECTIVE"]
    lines += ["ILLUMINATION_PERFECT_DIFFUSE_REFLECTOR_XYZ 96.42 100 82.49"]
    lines += ["BEGIN_DATA_FORMAT", "RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z", "END_DATA_FORMAT"]
    lines += ["BEGIN_DATA"]
    primaries = np.array([[0.436, 0.385, 0.143], [0.222, 0.717, 0.061], [0.014, 0.097, 0.714]])
    for code in signal_codes(98):
        xyz = 8 * np.array([0.9642, 1, 0.8249]) + 32 * primaries @ (code / 255) ** 2.2
        lines.append(" ".join(f"{value:.5f}" for value in (*code, *xyz)))
    return "\n".join([*lines, "END_DATA"]).encode()


def test_the_white_of_a_reflective_display_is_the_perfect_diffuser():
    """With its own white, an e-paper looks several times as large."""
    right = Gamut(e_paper(), surface_samples=300, intent="absolute")
    wrong = Gamut(e_paper(), surface_samples=300)
    assert standard_intent(wrong, "idms") == "absolute"
    assert not any("intent" in warning for warning in report(right, "idms").warnings)
    document = report(wrong, "idms")
    assert any("absolute" in warning for warning in document.warnings)
    assert document.data["volume"] > 1.8 * report(right, "idms").data["volume"]


@pytest.mark.parametrize("slug", STANDARDS)
def test_every_report_states_its_conditions_and_what_was_not_checked(slug, srgb, tmp_path):
    document = report(srgb, slug, BOX)
    stated = {"Standard", "Method", "Medium", "White", "Intent", "Patches", "Not checked"}
    assert stated <= set(document.conditions)
    assert all(len(line) <= 80 for line in document.to_text().splitlines())
    document.save(tmp_path / "report.json")


def test_unknown_standards_and_other_spaces_are_refused(srgb):
    with pytest.raises(OptionError, match="standard"):
        report(srgb, "iso-9001")
    with pytest.raises(OptionError, match="Oklab"):
        report(gamutcore.reference("srgb", surface_samples=300, space="Oklab"), "idms")
