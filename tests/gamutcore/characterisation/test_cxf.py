"""CxF3: the XML within limits, its objects, and their joining to samples."""

from pathlib import Path

import numpy as np
import pytest

from gamutcore.characterisation import read_characterisation
from gamutcore.characterisation.cxf import (
    CXF_NAMESPACE,
    MAX_ATTRIBUTE_LENGTH,
    MAX_ATTRIBUTES,
    MAX_DEPTH,
    MAX_TEXT_LENGTH,
)
from gamutcore.colours import surface_colours
from gamutcore.errors import (
    ConditionError,
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
    UnrecognisedFormatError,
)

NAMESPACE = "http://colorexchangeformat.com/CxF3-core"


def cxf_file(objects, specifications=()):
    return (
        f'<?xml version="1.0"?>\n<cc:CxF xmlns:cc="{NAMESPACE}">\n<cc:Resources>'
        "<cc:ObjectCollection>\n" + "\n".join(objects) + "\n</cc:ObjectCollection>"
        "<cc:ColorSpecificationCollection>"
        + "".join(specifications)
        + "</cc:ColorSpecificationCollection></cc:Resources></cc:CxF>"
    ).encode()


def cxf_object(
    device: str = "", colours: str = "", kind: str = "", name: str = "", **tags: object
) -> str:
    written = "".join(f'<cc:Tag Name="{tag}" Value="{value}"/>' for tag, value in tags.items())
    return (
        f'<cc:Object ObjectType="{kind}" Name="{name}" Id="i">'
        + (f"<cc:ColorValues>{colours}</cc:ColorValues>" if colours else "")
        + (f"<cc:DeviceColorValues>{device}</cc:DeviceColorValues>" if device else "")
        + f'<cc:TagCollection Name="x">{written}</cc:TagCollection></cc:Object>'
    )


def cxf_specification(
    identifier: str,
    *,
    illumination: str = "",
    backing: str = "",
    kind: str = "Spectrum_Reflectance",
    illuminant: str = "D50",
    observer: int = 2,
    device: str = "",
    increment: int = 10,
) -> str:
    if illumination:
        device += f"<cc:DeviceIllumination>{illumination}</cc:DeviceIllumination>"
    return (
        f'<cc:ColorSpecification Id="{identifier}"><cc:TristimulusSpec><cc:Illuminant>'
        f"{illuminant}</cc:Illuminant><cc:Observer>{observer}_Degree</cc:Observer>"
        "</cc:TristimulusSpec><cc:MeasurementSpec>"
        f"<cc:MeasurementType>{kind}</cc:MeasurementType>"
        f'<cc:WavelengthRange StartWL="380" Increment="{increment}"/>'
        + (f"<cc:Backing>{backing}</cc:Backing>" if backing else "")
        + (f"<cc:Device>{device}</cc:Device>" if device else "")
        + "</cc:MeasurementSpec></cc:ColorSpecification>"
    )


def cxf_lab(lightness: float, a: float, b: float, specification: str = "S") -> str:
    return (
        f'<cc:ColorCIELab ColorSpecification="{specification}"><cc:L>{lightness}</cc:L>'
        f"<cc:A>{a}</cc:A><cc:B>{b}</cc:B></cc:ColorCIELab>"
    )


def cxf_spectrum(value: float, specification: str = "S", kind: str = "Reflectance") -> str:
    return (
        f'<cc:{kind}Spectrum StartWL="380" ColorSpecification="{specification}">'
        + " ".join([f"{value:g}"] * 36)
        + f"</cc:{kind}Spectrum>"
    )


def read(objects, *specifications, **options):
    data = cxf_file(objects, specifications or [cxf_specification("S")])
    return read_characterisation(data, **options)


ONE = cxf_object("", cxf_lab(1, 2, 3))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_any_encoding_that_is_declared(encoding):
    text = cxf_file([ONE]).decode().replace('"1.0"?>', f'"1.0" encoding="{encoding}"?>')
    assert len(read_characterisation(text.encode(encoding))) == 1


def settings(count):
    attributes = " ".join(f'a{i}="1"' for i in range(count))
    return f'<cc:CustomResources><x:s xmlns:x="urn:vendor" {attributes}/></cc:CustomResources>'


@pytest.mark.parametrize(
    "section",
    [
        "<cc:CustomResources>" + "<x><y/></x>" * 50_000 + "</cc:CustomResources>",
        '<o:thing xmlns:o="urn:other">text<cc:Resources/></o:thing>',
        settings(54),  # X-Rite's i1Profiler writes <xrp:CustomAttributes> with 54
        settings(MAX_ATTRIBUTES),
    ],
)
def test_vendors_own_sections_are_passed_over(section):
    data = cxf_file([ONE]).replace(b"</cc:CxF>", f"{section}</cc:CxF>".encode())
    assert len(read_characterisation(data)) == 1


def test_attributes_of_other_namespaces_have_no_effect():
    xsi = ' xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
    strange = ONE.replace("<cc:Object ", f'<cc:Object{xsi} xsi:type="cc:Tag" xsi:nil="true" ')
    assert len(read([strange])) == 1


def cxf(inside="", head='<?xml version="1.0" encoding="UTF-8"?>\n', root=""):
    return f'{head}<cc:CxF xmlns:cc="{CXF_NAMESPACE}"{root}>{inside}</cc:CxF>'.encode()


RESOURCES = "<cc:Resources><cc:ObjectCollection>{}</cc:ObjectCollection></cc:Resources>"
OBJECT = (
    '\n<cc:Object Name="a" Id="1"><cc:ColorValues><cc:ReflectanceSpectrum StartWL="380" '
    'ColorSpecification="S">0.5 0.6</cc:ReflectanceSpectrum></cc:ColorValues></cc:Object>'
)


BOMBS = {
    "entities": '<!DOCTYPE l [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]>\n',
    "an external entity": '<!DOCTYPE l [<!ENTITY a SYSTEM "file:///etc/hostname">]>\n',
    "an external declaration": '<!DOCTYPE l SYSTEM "http://127.0.0.1:9/x.dtd">\n',
    "a parameter entity": '<!DOCTYPE l [<!ENTITY % a SYSTEM "file:///etc/hostname"> %a;]>\n',
}


@pytest.mark.parametrize("name", BOMBS)
def test_declarations_are_refused_with_their_place(name):
    with pytest.raises(MalformedFileError, match="document type") as caught:
        read_characterisation(cxf("&a;", head=BOMBS[name]))
    assert caught.value.where["line"] == 1
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (cxf("<cc:Resources>" * (MAX_DEPTH + 1)), "nested"),
        (cxf("<x>" * 500_000), "nested"),
        (cxf(root=f' Id="{"a" * (MAX_ATTRIBUTE_LENGTH + 1)}"'), "attributes"),
        (cxf(root=f' Id="{"a" * 10_000_000}"'), "attributes"),
        (cxf(root=" ".join(f' a{i}="1"' for i in range(100_000))), "attributes"),
        (cxf(settings(MAX_ATTRIBUTES + 1)), "attributes"),
        (cxf(RESOURCES.format(OBJECT.replace("0.5 0.6", "1 " * MAX_TEXT_LENGTH))), "text"),
        (cxf("<cc:Resources>"), "well formed"),
        (cxf("&a;"), "well formed"),
        (cxf() + b"<more/>", "well formed"),
        (cxf()[:-3], "well formed"),
        (cxf("\0"), "well formed"),
        (cxf(head='<?xml version="1.0" encoding="no-such"?>'), "well formed|encoding"),
        (cxf(head='<?xml version="1.0" encoding="big5"?>'), "well formed|encoding"),
    ],
)
def test_hostile_and_broken_xml_is_refused_with_its_place(data, problem):
    with pytest.raises(MalformedFileError, match=problem) as caught:
        read_characterisation(data)
    assert caught.value.where["line"] >= 1


def test_elements_are_limited(monkeypatch):
    monkeypatch.setattr("gamutcore.characterisation.cxf.MAX_ELEMENTS", 1000)
    with pytest.raises(SampleLimitError):
        read_characterisation(cxf(RESOURCES.format("<cc:Object/>" * 1000)))


@pytest.mark.parametrize(
    "data",
    [
        b"<a/>",
        b"<CxF/>",
        b'<CXF xmlns="http://www.gretagmacbeth.com/CxF2"/>',
        b'<CxF xmlns="http://colorexchangeformat.com/v2"><a/></CxF>',
        b'<html><CxF xmlns="http://colorexchangeformat.com/CxF3-core"/></html>',
    ],
)
def test_other_schemas_are_not_taken_for_it(data):
    with pytest.raises(UnrecognisedFormatError):
        read_characterisation(data)


RGB = "<cc:ColorRGB>{}<cc:R>255</cc:R><cc:G>0</cc:G><cc:B>51</cc:B></cc:ColorRGB>"
CMYK = "<cc:Cyan>100</cc:Cyan><cc:Magenta>0</cc:Magenta><cc:Yellow>50</cc:Yellow>"
SPOT = "<cc:SpotColor><cc:Name>Orange</cc:Name><cc:Percentage>25</cc:Percentage></cc:SpotColor>"


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
def test_device_values(device, channels, values):
    samples = read([cxf_object(device, cxf_lab(1, 2, 3))])
    assert samples.channels == tuple(channels.split())
    assert samples.device[0] == pytest.approx(values)


@pytest.mark.parametrize(
    ("colour", "kind", "numbers"),
    [
        (
            "<cc:ColorCIEXYZ {}><cc:X>1</cc:X><cc:Y>2</cc:Y><cc:Z>3</cc:Z></cc:ColorCIEXYZ>",
            "xyz",
            (1, 2, 3),
        ),
        (
            "<cc:ColorCIELCh {}><cc:L>9</cc:L><cc:C>2</cc:C><cc:H>90</cc:H></cc:ColorCIELCh>",
            "lab",
            (9, 0, 2),
        ),
        (
            "<cc:ColorCIExyY {}><cc:x>.25</cc:x><cc:y>.5</cc:y><cc:Y>10</cc:Y></cc:ColorCIExyY>",
            "xyz",
            (5, 10, 5),
        ),
        (
            "<cc:ColorCIELab {}><cc:L>1</cc:L><cc:A>-2</cc:A><cc:B>3</cc:B></cc:ColorCIELab>",
            "lab",
            (1, -2, 3),
        ),
    ],
)
def test_colours(colour, kind, numbers):
    samples = read([cxf_object("", colour.format('ColorSpecification="S"'))])
    np.testing.assert_allclose(getattr(samples, kind), [numbers], atol=1e-12)


def test_spectra_have_the_range_of_their_specification():
    samples = read([cxf_object("", cxf_spectrum(0.25))], cxf_specification("S", increment=20))
    assert samples.spectra.wavelengths.tolist() == list(range(380, 1100, 20))
    assert set(samples.spectra.values[0]) == {0.25}


@pytest.mark.parametrize(
    ("given", "condition"),
    [
        ({"illumination": "M1_Daylight"}, "M1"),
        ({"illumination": "M3_Polarized"}, "M3"),
        ({"device": "<cc:DeviceFilter>Filter_UVExcluded</cc:DeviceFilter>"}, "M2"),
        ({"device": "<cc:DevicePolarization>true</cc:DevicePolarization>"}, "M3"),
        ({"device": "<cc:DeviceFilter>Filter_None</cc:DeviceFilter>"}, None),
    ],
)
def test_measurement_conditions(given, condition):
    samples = read([cxf_object("", cxf_lab(1, 2, 3))], cxf_specification("S", **given))
    assert samples.condition == condition


def test_the_name_of_a_specification_or_an_object_may_say_the_condition():
    assert read([cxf_object("", cxf_lab(1, 2, 3, "M2"))]).condition == "M2"
    assert read([cxf_object("", cxf_lab(1, 2, 3), "M0_Measurement")]).condition == "M0"


def test_what_is_said_of_the_measurement():
    said = cxf_specification(
        "S",
        backing="Black",
        illuminant="D65",
        observer=10,
        device="<cc:Manufacturer>X</cc:Manufacturer><cc:Model>i1</cc:Model>",
    )
    conditions = read([cxf_object("", cxf_lab(1, 2, 3))], said).conditions
    assert conditions["SAMPLE_BACKING"] == "Black"
    assert conditions["ILLUMINANT"] == "D65"
    assert conditions["OBSERVER"] == "10 degree"
    assert conditions["INSTRUMENTATION"] == "i1"


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
def test_what_is_no_number_or_no_spectrum_is_refused_with_its_line(device, colours):
    with pytest.raises(MalformedFileError) as caught:
        read([cxf_object(device, colours)])
    assert caught.value.where["line"] == 4
    assert caught.value.remedy


DATA = Path(__file__).parents[2] / "data"
LAB = np.array([[95, 0, -2], [55, -37, -50], [48, 74, -3], [16, 0, 0]], float)
INKS = [(0, 0, 0, 0), (100, 0, 0, 0), (0, 100, 0, 0), (0, 0, 0, 100)]


def cmyk(values):
    names = ("Cyan", "Magenta", "Yellow", "Black")
    inside = "".join(f"<cc:{n}>{v}</cc:{n}>" for n, v in zip(names, values, strict=True))
    return f"<cc:ColorCMYK>{inside}</cc:ColorCMYK>"


def press(conditions=("M1",), tag="SampleID", order=slice(None, None, -1), **more):
    """Write four patches of a press under some conditions."""
    objects = [cxf_object(cmyk(i), kind="Target", **{tag: n}) for n, i in enumerate(INKS)]
    measured = [
        cxf_object("", cxf_lab(*(lab + step), name), f"{name}_Measurement", **{tag: n})
        for step, name in enumerate(conditions)
        for n, lab in enumerate(LAB)
    ]
    return cxf_file(
        [*measured[order], *objects], [cxf_specification(n, **more) for n in conditions]
    )


def ordered(samples):
    """Return Lab in the order of the inks."""
    ranks = [np.flatnonzero((samples.device == np.array(ink) / 100).all(axis=1)) for ink in INKS]
    return samples.lab[np.concatenate(ranks)]


@pytest.mark.parametrize("tag", ["SampleID", "SAMPLE_ID", "name"])
def test_objects_are_joined_by_what_names_them_and_not_by_their_order(tag):
    samples = read_characterisation(press(tag=tag))
    np.testing.assert_array_equal(ordered(samples), LAB)
    assert samples.channels == ("C", "M", "Y", "K")
    assert samples.condition == "M1"
    assert samples.conditions["ILLUMINANT"] == "D50"
    assert samples.provenance["measurement_condition"] == "M1"
    assert samples.provenance["patches"] == {"read": 4, "dropped": 0, "averaged": 0}
    assert samples.warnings == ()


def test_objects_are_joined_by_their_place_where_they_have_no_sample_id():
    targets = [cxf_object(cmyk(i), Page=1, Row=n, Column=0) for n, i in enumerate(INKS)]
    measured = [
        cxf_object("", cxf_lab(*lab, "M0"), name=f"M0_{n}", Column=0, Row=n, Page=1)
        for n, lab in enumerate(LAB)
    ]
    samples = read_characterisation(
        cxf_file([*measured[::-1], *targets], [cxf_specification("M0")])
    )
    np.testing.assert_array_equal(ordered(samples), LAB)


def test_a_sample_id_of_minus_one_is_none():
    def tags(n):
        return {"SampleID": -1, "Page": 1, "Row": n // 2, "Column": n % 2}

    targets = [cxf_object(cmyk(i), **tags(n)) for n, i in enumerate(INKS)]
    measured = [cxf_object("", cxf_lab(*lab, "M0"), **tags(n)) for n, lab in enumerate(LAB)]
    samples = read_characterisation(
        cxf_file([*measured[::-1], *targets], [cxf_specification("M0")])
    )
    np.testing.assert_array_equal(ordered(samples), LAB)
    assert samples.provenance["patches"]["dropped"] == 0


def test_a_key_that_several_patches_share_is_not_used():
    """Names such as Target, or one SampleID for all, must not give all patches one colour."""
    for shared, other in (("SampleID", "name"), ("name", "SampleID")):
        pairs = [{shared: "7", other: f"p{n}"} for n in range(len(INKS))]
        targets = [cxf_object(cmyk(i), **pairs[n]) for n, i in enumerate(INKS)]
        measured = [cxf_object("", cxf_lab(*lab, "M0"), **pairs[n]) for n, lab in enumerate(LAB)]
        samples = read_characterisation(
            cxf_file([*measured[::-1], *targets], [cxf_specification("M0")])
        )
        np.testing.assert_array_equal(ordered(samples), LAB)


def test_values_and_measurement_may_be_one_object():
    one = [cxf_object(cmyk(i), cxf_lab(*lab)) for i, lab in zip(INKS, LAB, strict=True)]
    np.testing.assert_array_equal(ordered(read_characterisation(cxf_file(one))), LAB)


def test_several_conditions_are_refused_until_one_is_chosen():
    data = press(("M0", "M1", "M2"))
    with pytest.raises(ConditionError, match="M0") as caught:
        read_characterisation(data)
    assert sorted(caught.value.where["conditions"]) == ["M0", "M1", "M2"]
    for step, name in enumerate(("M0", "M1", "M2")):
        samples = read_characterisation(data, condition=name)
        assert samples.condition == name
        np.testing.assert_array_equal(ordered(samples), LAB + step)


def test_two_backings_are_two_conditions():
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
        read_characterisation(data)
    white = read_characterisation(data, condition="M1, White Backing")
    np.testing.assert_array_equal(ordered(white), LAB + 1)
    assert white.conditions["SAMPLE_BACKING"] == "White"


def test_colours_for_d50_and_2_degrees_are_preferred():
    objects = [
        cxf_object(cmyk(ink), cxf_lab(1, 2, 3, "T") + cxf_lab(*lab, "S"))
        for ink, lab in zip(INKS, LAB, strict=True)
    ]
    specified = [cxf_specification("T", illuminant="D65", observer=10), cxf_specification("S")]
    samples = read_characterisation(cxf_file(objects, specified))
    np.testing.assert_array_equal(ordered(samples), LAB)
    assert samples.conditions["OBSERVER"] == "2 degree"


def test_what_has_no_partner_is_counted():
    extra = cxf_object("", cxf_lab(1, 1, 1, "M1"), "M1_Measurement", SampleID=99)
    data = press().replace(b"</cc:ObjectCollection>", f"{extra}</cc:ObjectCollection>".encode())
    samples = read_characterisation(data)
    assert len(samples) == 4
    assert samples.provenance["patches"]["dropped"] == 1
    assert any("1 object" in said for said in samples.warnings)


def test_lights_are_a_display_and_reflectances_are_not():
    rgb = "<cc:ColorRGB><cc:R>{}</cc:R><cc:G>{}</cc:G><cc:B>{}</cc:B></cc:ColorRGB>"
    for kind, medium in (("Emissive", "display"), ("Reflectance", "reflective")):
        objects = [
            cxf_object(rgb.format(v, v, v), cxf_spectrum(v / 255 + 0.01, kind=kind))
            for v in (0, 128, 255)
        ]
        data = cxf_file(objects, [cxf_specification("S", kind=f"Spectrum_{kind}")])
        samples = read_characterisation(data)
        colours = surface_colours(samples)
        assert colours.provenance["medium"] == medium
        np.testing.assert_allclose(colours.points[2], [100, 0, 0], atol=1e-6)


def test_what_does_not_belong_together_is_refused():
    def refused(objects, error, line):
        with pytest.raises(error) as caught:
            read_characterisation(cxf_file(objects, [cxf_specification("S")]))
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


class TestColorPort:
    """24 patches of a file by X-Rite ColorPort."""

    @pytest.fixture
    def samples(self):
        return read_characterisation((DATA / "colorport-24.cxf").read_bytes())

    def test_its_patches_are_read(self, samples):
        assert len(samples) == 24
        assert samples.device is None
        np.testing.assert_allclose(samples.lab[0], [17.64167, 1.076669, 0.3338588])
        assert samples.spectra.values.shape == (24, 31)
        assert (samples.spectra.wavelengths[0], samples.spectra.wavelengths[-1]) == (380, 680)
        assert samples.conditions["CREATOR"] == "X-Rite, Inc."

    def test_its_spectra_have_the_colours_that_it_states(self, samples):
        """By ASTM E308 table 5, D50 and 2°, as its specification says; computed by X-Rite."""
        computed = surface_colours(samples, observer=2, illuminant="D50")
        difference = np.linalg.norm(computed.points - samples.lab, axis=1)
        assert difference.mean() < 0.1
        assert difference.max() < 0.15

    def test_its_description_names_its_conditions(self, samples):
        provenance = surface_colours(samples, observer=10, illuminant="D65").provenance
        assert provenance["format"] == "cxf"
        assert provenance["illuminant"] == "D65"
        assert provenance["observer"] == "10°"
        assert provenance["patches"]["used"] == 24
