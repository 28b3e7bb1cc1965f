from __future__ import annotations

import numpy as np
import pytest

from gamutcore.characterisation.cxf.element_tree import cxf_root
from gamutcore.characterisation.cxf.objects import cxf_objects, specifications
from gamutcore.errors import MalformedFileError

RGB = "<cc:ColorRGB>{}<cc:R>255</cc:R><cc:G>0</cc:G><cc:B>51</cc:B></cc:ColorRGB>"
CMYK = "<cc:Cyan>100</cc:Cyan><cc:Magenta>0</cc:Magenta><cc:Yellow>50</cc:Yellow>"
SPOT = "<cc:SpotColor><cc:Name>Orange</cc:Name><cc:Percentage>25</cc:Percentage></cc:SpotColor>"


@pytest.fixture
def first(cxf_file, cxf_object, cxf_specification):
    def read(*args, specification=None, **tags):
        data = cxf_file([cxf_object(*args, **tags)], [specification or cxf_specification("S")])
        return next(cxf_objects(cxf_root(data)))

    return read


@pytest.mark.parametrize(
    ("device", "channels", "values"),
    [
        (RGB.format(""), "R G B", (1, 0, 0.2)),
        (RGB.format("<cc:MaxRange>510</cc:MaxRange>"), "R G B", (0.5, 0, 0.1)),
        (
            f"<cc:ColorCMYK>{CMYK}<cc:Black>10</cc:Black></cc:ColorCMYK>",
            "C M Y K",
            (1, 0, 0.5, 0.1),
        ),
        (
            f"<cc:ColorCMYKPlusN>{CMYK}<cc:Black>10</cc:Black>{SPOT}</cc:ColorCMYKPlusN>",
            "C M Y K Orange",
            (1, 0, 0.5, 0.1, 0.25),
        ),
        (f"<cc:ColorCustom>{SPOT}</cc:ColorCustom>", "Orange", (0.25,)),
    ],
)
def test_device_values(first, device, channels, values):
    entry = first(device)
    assert entry.channels == tuple(channels.split())
    assert entry.device == pytest.approx(values)
    assert entry.line == 4


@pytest.mark.parametrize(
    ("colour", "kind", "numbers"),
    [
        ("<cc:ColorCIEXYZ {}><cc:X>1</cc:X><cc:Y>2</cc:Y><cc:Z>3</cc:Z></cc:ColorCIEXYZ>", "xyz",
         (1, 2, 3)),
        ("<cc:ColorCIELCh {}><cc:L>1</cc:L><cc:C>2</cc:C><cc:H>3</cc:H></cc:ColorCIELCh>", "lch",
         (1, 2, 3)),
        ("<cc:ColorCIExyY {}><cc:x>.1</cc:x><cc:y>.2</cc:y><cc:Y>3</cc:Y></cc:ColorCIExyY>", "xyy",
         (0.1, 0.2, 3)),
        ("<cc:ColorCIELab {}><cc:L>1</cc:L><cc:A>-2</cc:A><cc:B>3</cc:B></cc:ColorCIELab>", "lab",
         (1, -2, 3)),
    ],
)  # fmt: skip
def test_colours(first, colour, kind, numbers):
    ((key, values),) = first("", colour.format('ColorSpecification="S"')).colours.items()
    assert (key.kind, key.illuminant, key.observer) == (kind, "D50", "2")
    np.testing.assert_array_equal(values, numbers)


def test_spectra(first, cxf_spectrum, cxf_specification):
    entry = first("", cxf_spectrum(0.25), specification=cxf_specification("S", increment=20))
    ((key, values),) = entry.colours.items()
    assert (key.start, key.step, key.bands) == (380, 20, 36)
    assert set(values) == {0.25}


@pytest.mark.parametrize(
    ("given", "condition"),
    [
        ({"illumination": "M1_Daylight"}, "M1"),
        ({"illumination": "M3_Polarized"}, "M3"),
        ({"device": "<cc:DeviceFilter>Filter_UVExcluded</cc:DeviceFilter>"}, "M2"),
        ({"device": "<cc:DevicePolarization>true</cc:DevicePolarization>"}, "M3"),
        ({"device": "<cc:DeviceFilter>Filter_None</cc:DeviceFilter>"}, None),
        ({}, None),
    ],
)
def test_measurement_conditions(cxf_file, cxf_specification, given, condition):
    root = cxf_root(cxf_file([], [cxf_specification("CS1", **given)]))
    assert specifications(root)["CS1"].condition == condition


def test_the_name_of_a_specification_or_an_object_may_say_the_condition(first, cxf_lab):
    assert {key.condition for key in first("", cxf_lab(1, 2, 3, "M2")).colours} == {"M2"}
    measured = first("", cxf_lab(1, 2, 3), "M0_Measurement")
    assert {key.condition for key in measured.colours} == {"M0"}
    assert measured.measured


def test_what_is_said_of_the_measurement(cxf_file, cxf_specification):
    text = cxf_specification(
        "S", backing="Black", kind="Spectrum_Emissive", illuminant="D65", observer=10,
        device="<cc:Manufacturer>X</cc:Manufacturer><cc:Model>i1</cc:Model>",
    )  # fmt: skip
    found = specifications(cxf_root(cxf_file([], [text])))["S"]
    assert (found.backing, found.illuminant, found.observer) == ("black", "D65", "10")
    assert found.emissive is True
    assert found.facts["INSTRUMENTATION"] == "i1"


@pytest.mark.parametrize(
    ("tags", "identity"),
    [
        ({"SampleID": "7"}, {"sample": "7"}),
        ({"SAMPLE_ID": " A1 "}, {"sample": "A1"}),
        ({"Page": 1, "Row": 2, "Column": 3}, {"location": "1/2/3"}),
        ({"Row": 2, "Column": 3}, {"location": "/2/3"}),
        ({"name": "x"}, {"name": "x"}),
    ],
)
def test_identities(first, tags, identity):
    assert first(RGB.format(""), **tags).identity == identity


@pytest.mark.parametrize(
    ("device", "colours"),
    [
        ("<cc:ColorRGB><cc:R>1</cc:R><cc:G>x</cc:G><cc:B>1</cc:B></cc:ColorRGB>", ""),
        ("<cc:ColorRGB><cc:R>1</cc:R><cc:B>1</cc:B></cc:ColorRGB>", ""),
        (f"<cc:ColorCMYK>{CMYK}<cc:Black>nan</cc:Black></cc:ColorCMYK>", ""),
        (f"<cc:ColorCMYK>{CMYK}<cc:Black>1e400</cc:Black></cc:ColorCMYK>", ""),
        (f"<cc:ColorCMYK>{CMYK}<cc:Black>1,5</cc:Black></cc:ColorCMYK>", ""),
        ("", "<cc:ColorCIELab><cc:L>1</cc:L></cc:ColorCIELab>"),
        ("", '<cc:ReflectanceSpectrum StartWL="380">0.1 x</cc:ReflectanceSpectrum>'),
        ("", '<cc:ReflectanceSpectrum StartWL="380"/>'),
        ("", f"<cc:ReflectanceSpectrum>{'0.1 ' * 36}</cc:ReflectanceSpectrum>"),
        ("", f'<cc:ReflectanceSpectrum StartWL="380">{"nan " * 36}</cc:ReflectanceSpectrum>'),
        ("", f'<cc:ReflectanceSpectrum StartWL="380">{"1_0 " * 36}</cc:ReflectanceSpectrum>'),
        ("", f'<cc:ReflectanceSpectrum StartWL="380">{"0.1 " * 9}</cc:ReflectanceSpectrum>'),
        ("", f'<cc:ReflectanceSpectrum StartWL="380">{"1 " * 5000}</cc:ReflectanceSpectrum>'),
    ],
)
def test_what_is_no_number_or_no_spectrum_is_refused_with_its_line(first, device, colours):
    with pytest.raises(MalformedFileError) as caught:
        first(device, colours)
    assert caught.value.where["line"] == 4
    assert caught.value.remedy
