from __future__ import annotations

import pytest

from gamutcore.characterisation.cxf.element_tree import (
    CXF_NAMESPACE,
    MAX_ATTRIBUTE_LENGTH,
    MAX_ATTRIBUTES,
    MAX_DEPTH,
    MAX_ELEMENTS,
    MAX_TEXT_LENGTH,
    cxf_root,
    element_line,
    looks_like_cxf,
    looks_like_xml,
)
from gamutcore.errors import MalformedFileError, SampleLimitError, UnrecognisedFormatError


def cxf(inside="", head='<?xml version="1.0" encoding="UTF-8"?>\n', root=""):
    return f'{head}<cc:CxF xmlns:cc="{CXF_NAMESPACE}"{root}>{inside}</cc:CxF>'.encode()


RESOURCES = "<cc:Resources><cc:ObjectCollection>{}</cc:ObjectCollection></cc:Resources>"
OBJECT = (
    '\n<cc:Object Name="a" Id="1"><cc:ColorValues><cc:ReflectanceSpectrum StartWL="380" '
    'ColorSpecification="S">0.5 0.6</cc:ReflectanceSpectrum></cc:ColorValues></cc:Object>'
)


OBJECTS = "Resources/ObjectCollection/Object"


def lines(root):
    return [element_line(entry) for entry in root.iterfind(OBJECTS)]


def test_objects_have_line_numbers_and_texts():
    root = cxf_root(cxf(RESOURCES.format(OBJECT * 3)))
    assert lines(root) == [3, 4, 5]
    spectra = root.findall(f"{OBJECTS}/ColorValues/ReflectanceSpectrum")
    assert [spectrum.text for spectrum in spectra] == ["0.5 0.6"] * 3
    assert spectra[0].get("StartWL") == "380"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_any_encoding_that_is_declared(encoding):
    text = cxf(head="").decode()
    data = f'<?xml version="1.0" encoding="{encoding}"?>{text}'.encode(encoding)
    assert looks_like_xml(data)
    assert looks_like_cxf(data)
    assert lines(cxf_root(data)) == []


def test_vendors_own_sections_are_passed_over():
    custom = "<cc:CustomResources>" + "<x><y/></x>" * 50_000 + "</cc:CustomResources>"
    foreign = '<o:thing xmlns:o="urn:other">text<cc:Resources/></o:thing>'
    root = cxf_root(cxf(RESOURCES.format(OBJECT) + foreign + custom))
    assert lines(root) == [3]
    assert [child.tag for child in root] == ["Resources"]


def settings(count):
    attributes = " ".join(f'a{i}="1"' for i in range(count))
    return f'<cc:CustomResources><x:s xmlns:x="urn:vendor" {attributes}/></cc:CustomResources>'


@pytest.mark.parametrize("count", [54, MAX_ATTRIBUTES])
def test_vendors_own_elements_may_have_many_attributes(count):
    # X-Rite's i1Profiler writes <xrp:CustomAttributes> with 54.
    assert lines(cxf_root(cxf(RESOURCES.format(OBJECT) + settings(count)))) == [3]


BOMBS = {
    "entities": '<!DOCTYPE l [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]>\n',
    "an external entity": '<!DOCTYPE l [<!ENTITY a SYSTEM "file:///etc/hostname">]>\n',
    "an external declaration": '<!DOCTYPE l SYSTEM "http://127.0.0.1:9/x.dtd">\n',
    "a parameter entity": '<!DOCTYPE l [<!ENTITY % a SYSTEM "file:///etc/hostname"> %a;]>\n',
}


@pytest.mark.parametrize("name", BOMBS)
def test_declarations_are_refused_with_their_place(name):
    with pytest.raises(MalformedFileError, match="document type") as caught:
        cxf_root(cxf("&a;", head=BOMBS[name]))
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
        cxf_root(data)
    assert caught.value.where["line"] >= 1


@pytest.mark.slow
def test_elements_are_limited():
    with pytest.raises(SampleLimitError):
        cxf_root(cxf(RESOURCES.format("<cc:Object/>" * MAX_ELEMENTS)))


def test_attributes_of_other_namespaces_have_no_effect():
    xsi = ' xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
    text = OBJECT.replace("<cc:Object ", f'<cc:Object{xsi} xsi:type="cc:Tag" xsi:nil="true" ')
    (entry,) = cxf_root(cxf(RESOURCES.format(text))).iterfind(OBJECTS)
    assert entry.get("Name") == "a"
    assert entry.find("ColorValues") is not None


@pytest.mark.parametrize(
    "data",
    [
        b"<CxF/>",
        b'<CXF xmlns="http://www.gretagmacbeth.com/CxF2"/>',
        b'<CxF xmlns="http://colorexchangeformat.com/v2"><a/></CxF>',
        b'<html><CxF xmlns="http://colorexchangeformat.com/CxF3-core"/></html>',
    ],
)
def test_other_schemas_are_not_taken_for_it(data):
    with pytest.raises(UnrecognisedFormatError, match="root"):
        cxf_root(data)


def test_what_looks_like_xml():
    assert looks_like_xml(b"\xef\xbb\xbf \n<a/>")
    assert not looks_like_xml(b"1 < 2")
    assert not looks_like_cxf(b"<a/>")
