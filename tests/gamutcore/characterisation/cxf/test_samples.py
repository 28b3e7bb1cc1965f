from __future__ import annotations

import ast
import sys
from pathlib import Path

import numpy as np
import pytest

from gamutcore.characterisation import characterisation, cxf
from gamutcore.characterisation.cxf.samples import cxf_samples
from gamutcore.colours import surface_colours
from gamutcore.colours.measured_colours import measured_colours
from gamutcore.errors import (
    ConditionError,
    MalformedFileError,
    MissingColumnError,
    UnrecognisedFormatError,
)

DATA = Path(__file__).parents[3] / "data"
LAB = np.array([[95, 0, -2], [55, -37, -50], [48, 74, -3], [16, 0, 0]], float)
INKS = [(0, 0, 0, 0), (100, 0, 0, 0), (0, 100, 0, 0), (0, 0, 0, 100)]


def cmyk(values):
    names = ("Cyan", "Magenta", "Yellow", "Black")
    inside = "".join(f"<cc:{n}>{v}</cc:{n}>" for n, v in zip(names, values, strict=True))
    return f"<cc:ColorCMYK>{inside}</cc:ColorCMYK>"


@pytest.fixture
def press(cxf_file, cxf_object, cxf_lab, cxf_specification):
    """Return a function that writes four patches of a press under some conditions."""

    def make(conditions=("M1",), tag="SampleID", order=slice(None, None, -1), **more):
        objects = [cxf_object(cmyk(i), kind="Target", **{tag: n}) for n, i in enumerate(INKS)]
        measured = [
            cxf_object("", cxf_lab(*(lab + step), name), f"{name}_Measurement", **{tag: n})
            for step, name in enumerate(conditions)
            for n, lab in enumerate(LAB)
        ]
        return cxf_file(
            [*measured[order], *objects], [cxf_specification(n, **more) for n in conditions]
        )

    return make


def ordered(samples):
    """Return Lab in the order of the inks."""
    ranks = [np.flatnonzero((samples.device == np.array(ink) / 100).all(axis=1)) for ink in INKS]
    return samples.lab[np.concatenate(ranks)]


def test_objects_are_joined_by_their_sample_id_and_not_by_their_order(press):
    samples = cxf_samples(press())
    np.testing.assert_array_equal(ordered(samples), LAB)
    assert samples.channels == ("C", "M", "Y", "K")
    assert samples.condition == "M1"
    assert samples.conditions["ILLUMINANT"] == "D50"
    assert samples.provenance["measurement_condition"] == "M1"
    assert samples.provenance["patches"] == {"read": 4, "dropped": 0, "averaged": 0}
    assert samples.warnings == ()


def test_objects_are_joined_by_their_place_where_they_have_no_sample_id(
    cxf_file, cxf_object, cxf_lab, cxf_specification
):
    targets = [cxf_object(cmyk(i), Page=1, Row=n, Column=0) for n, i in enumerate(INKS)]
    measured = [
        cxf_object("", cxf_lab(*lab, "M0"), name=f"M0_{n}", Column=0, Row=n, Page=1)
        for n, lab in enumerate(LAB)
    ]
    samples = cxf_samples(cxf_file([*measured[::-1], *targets], [cxf_specification("M0")]))
    np.testing.assert_array_equal(ordered(samples), LAB)


def test_a_sample_id_of_minus_one_is_none(cxf_file, cxf_object, cxf_lab, cxf_specification):
    def tags(n):
        return {"SampleID": -1, "Page": 1, "Row": n // 2, "Column": n % 2}

    targets = [cxf_object(cmyk(i), **tags(n)) for n, i in enumerate(INKS)]
    measured = [cxf_object("", cxf_lab(*lab, "M0"), **tags(n)) for n, lab in enumerate(LAB)]
    samples = cxf_samples(cxf_file([*measured[::-1], *targets], [cxf_specification("M0")]))
    np.testing.assert_array_equal(ordered(samples), LAB)
    assert samples.provenance["patches"]["dropped"] == 0


def test_a_key_that_several_patches_share_is_not_used(
    cxf_file, cxf_object, cxf_lab, cxf_specification
):
    """Names such as Target, or one SampleID for all, must not give all patches one colour."""
    for shared, other in (("SampleID", "name"), ("name", "SampleID")):
        pairs = [{shared: "7", other: f"p{n}"} for n in range(len(INKS))]
        targets = [cxf_object(cmyk(i), **pairs[n]) for n, i in enumerate(INKS)]
        measured = [cxf_object("", cxf_lab(*lab, "M0"), **pairs[n]) for n, lab in enumerate(LAB)]
        samples = cxf_samples(cxf_file([*measured[::-1], *targets], [cxf_specification("M0")]))
        np.testing.assert_array_equal(ordered(samples), LAB)


def test_objects_are_joined_by_their_name_last(press):
    np.testing.assert_array_equal(ordered(cxf_samples(press(tag="name"))), LAB)


def test_values_and_measurement_may_be_one_object(cxf_file, cxf_object, cxf_lab):
    one = [cxf_object(cmyk(i), cxf_lab(*lab)) for i, lab in zip(INKS, LAB, strict=True)]
    np.testing.assert_array_equal(ordered(cxf_samples(cxf_file(one))), LAB)


def test_several_conditions_are_refused_until_one_is_chosen(press):
    data = press(("M0", "M1", "M2"))
    with pytest.raises(ConditionError, match="M0") as caught:
        characterisation(data)
    assert sorted(caught.value.where["conditions"]) == ["M0", "M1", "M2"]
    for step, name in enumerate(("M0", "M1", "M2")):
        samples = characterisation(data, condition=name)
        assert samples.condition == name
        np.testing.assert_array_equal(ordered(samples), LAB + step)


def test_two_backings_are_two_conditions(cxf_file, cxf_object, cxf_lab, cxf_specification):
    objects = [
        cxf_object(cmyk(ink), cxf_lab(*lab, "B") + cxf_lab(*(lab + 1), "W"))
        for ink, lab in zip(INKS, LAB, strict=True)
    ]
    specified = [
        cxf_specification("B", illumination="M1_Daylight", backing="Black"),
        cxf_specification("W", illumination="M1_Daylight", backing="White"),
    ]
    data = cxf_file(objects, specified)
    with pytest.raises(ConditionError, match="M1, black backing, M1, white backing"):
        cxf_samples(data)
    white = cxf_samples(data, condition="M1, White Backing")
    np.testing.assert_array_equal(ordered(white), LAB + 1)
    assert white.conditions["SAMPLE_BACKING"] == "White"


def test_colours_for_d50_and_2_degrees_are_preferred(
    cxf_file, cxf_object, cxf_lab, cxf_specification
):
    objects = [
        cxf_object(cmyk(ink), cxf_lab(1, 2, 3, "T") + cxf_lab(*lab, "S"))
        for ink, lab in zip(INKS, LAB, strict=True)
    ]
    specified = [cxf_specification("T", illuminant="D65", observer=10), cxf_specification("S")]
    samples = cxf_samples(cxf_file(objects, specified))
    np.testing.assert_array_equal(ordered(samples), LAB)
    assert samples.conditions["OBSERVER"] == "2 degree"


def test_what_has_no_partner_is_counted(press, cxf_object, cxf_lab):
    extra = cxf_object("", cxf_lab(1, 1, 1, "M1"), "M1_Measurement", SampleID=99)
    data = press().replace(b"</cc:ObjectCollection>", f"{extra}</cc:ObjectCollection>".encode())
    samples = cxf_samples(data)
    assert len(samples) == 4
    assert samples.provenance["patches"]["dropped"] == 1
    assert any("1 object" in said for said in samples.warnings)


def test_lights_are_a_display_and_reflectances_are_not(
    cxf_file, cxf_object, cxf_spectrum, cxf_specification
):
    rgb = "<cc:ColorRGB><cc:R>{}</cc:R><cc:G>{}</cc:G><cc:B>{}</cc:B></cc:ColorRGB>"
    for kind, medium in (("Emissive", "display"), ("Reflectance", "reflective")):
        objects = [
            cxf_object(rgb.format(v, v, v), cxf_spectrum(v / 255 + 0.01, kind=kind))
            for v in (0, 128, 255)
        ]
        data = cxf_file(objects, [cxf_specification("S", kind=f"Spectrum_{kind}")])
        samples = cxf_samples(data)
        colours = measured_colours(samples, "relative")
        assert colours.provenance["medium"] == medium
        np.testing.assert_allclose(colours.lab[2], [100, 0, 0], atol=1e-6)


def test_what_does_not_belong_together_is_refused(
    cxf_file, cxf_object, cxf_lab, cxf_spectrum, cxf_specification
):
    def refused(objects, error, line):
        with pytest.raises(error) as caught:
            cxf_samples(cxf_file(objects, [cxf_specification("S")]))
        assert caught.value.where.get("line") == line
        assert caught.value.remedy

    lab, spectrum = cxf_lab(1, 2, 3), cxf_spectrum(0.5)
    target = cxf_object(cmyk(INKS[0]), SampleID=1)
    refused([target], MissingColumnError, None)
    refused([target, cxf_object("", lab, SampleID=2)], MissingColumnError, 5)
    refused([target, cxf_object(cmyk(INKS[1]), SampleID=1), cxf_object("", lab, SampleID=1)],
            MalformedFileError, 5)  # fmt: skip
    refused([cxf_object("", lab), cxf_object("", spectrum)], MalformedFileError, 5)
    custom = "<cc:ColorRGB><cc:R>1</cc:R><cc:G>1</cc:G><cc:B>1</cc:B></cc:ColorRGB>"
    refused([cxf_object(cmyk(INKS[0]), lab), cxf_object(custom, lab)], MalformedFileError, 5)


def test_xml_that_is_no_cxf_is_not_recognised():
    for data in (b"<a/>", b"<html><body>CxF</body></html>", b"<CxF/>"):
        with pytest.raises(UnrecognisedFormatError):
            characterisation(data)


class TestColorPort:
    """24 patches of a file by X-Rite ColorPort."""

    @pytest.fixture
    def samples(self):
        return characterisation((DATA / "colorport-24.cxf").read_bytes())

    def test_its_patches_are_read(self, samples):
        assert len(samples) == 24
        assert samples.device is None
        np.testing.assert_allclose(samples.lab[0], [17.64167, 1.076669, 0.3338588])
        assert samples.spectra.values.shape == (24, 31)
        assert (samples.spectra.wavelengths[0], samples.spectra.wavelengths[-1]) == (380, 680)
        assert samples.conditions["CREATOR"] == "X-Rite, Inc."

    def test_its_spectra_have_the_colours_that_it_states(self, samples):
        """By ASTM E308 table 5, D50 and 2°, as its specification says; computed by X-Rite."""
        computed = measured_colours(samples, "relative", observer=2, illuminant="D50")
        difference = np.linalg.norm(computed.lab - samples.lab, axis=1)
        assert difference.mean() < 0.1
        assert difference.max() < 0.15

    def test_its_description_names_its_conditions(self, samples):
        provenance = surface_colours(samples, observer=10, illuminant="D65").provenance
        assert provenance["format"] == "cxf"
        assert provenance["illuminant"] == "D65"
        assert provenance["observer"] == "10°"
        assert provenance["patches"]["used"] == 24


def test_only_the_standard_library_and_numpy_are_imported():
    """So that CxF can be read by a new version of Python as soon as NumPy can."""
    imported = set()
    for path in Path(cxf.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                imported |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add(node.module)
    packages = {name.partition(".")[0] for name in imported} - sys.stdlib_module_names
    assert packages == {"gamutcore", "numpy"}
