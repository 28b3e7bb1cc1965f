"""CxF3 files: targets and measurements apart, under two conditions, with spectra and Lab."""

import re

import fuzz

_cgats = fuzz.target("cgats")
check = _cgats.check

_CORNERS = [(0, 0, 0), (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)]
_SPECTRUM = " ".join(f"{0.1 + band / 50:.3f}" for band in range(36))


def _file(conditions: list[str]) -> bytes:
    objects = []
    for number, (r, g, b) in enumerate(_CORNERS):
        tags = (
            f'<cc:TagCollection Name="i1"><cc:Tag Name="SampleID" Value="{number}"/>'
            "</cc:TagCollection>"
        )
        objects.append(
            f'<cc:Object ObjectType="Target" Name="T{number}" Id="t{number}"><cc:DeviceColorValues>'
            f"<cc:ColorRGB><cc:MaxRange>255</cc:MaxRange><cc:R>{r}</cc:R><cc:G>{g}</cc:G>"
            f"<cc:B>{b}</cc:B></cc:ColorRGB></cc:DeviceColorValues>{tags}</cc:Object>"
        )
        objects += [
            f'<cc:Object ObjectType="{name}_Measurement" Name="{name}_{number}" '
            f'Id="{name}{number}"><cc:ColorValues><cc:ReflectanceSpectrum StartWL="380" '
            f'ColorSpecification="S{name}">{_SPECTRUM}</cc:ReflectanceSpectrum><cc:ColorCIELab '
            f'ColorSpecification="S{name}"><cc:L>{20 * number}</cc:L><cc:A>{r / 9}</cc:A><cc:B>'
            f"{g / 9}</cc:B></cc:ColorCIELab></cc:ColorValues>{tags}</cc:Object>"
            for name in conditions
        ]
    specifications = [
        f'<cc:ColorSpecification Id="S{name}"><cc:TristimulusSpec><cc:Illuminant>D50'
        "</cc:Illuminant><cc:Observer>2_Degree</cc:Observer></cc:TristimulusSpec>"
        "<cc:MeasurementSpec><cc:MeasurementType>Spectrum_Reflectance</cc:MeasurementType>"
        '<cc:WavelengthRange StartWL="380" Increment="10"/><cc:Device><cc:DeviceIllumination>'
        f"{name}_Daylight</cc:DeviceIllumination></cc:Device></cc:MeasurementSpec>"
        "</cc:ColorSpecification>"
        for name in conditions
    ]
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<cc:CxF '
        'xmlns:cc="http://colorexchangeformat.com/CxF3-core"><cc:Resources><cc:ObjectCollection>\n'
        + "\n".join(objects)
        + "</cc:ObjectCollection><cc:ColorSpecificationCollection>"
        + "".join(specifications)
        + "</cc:ColorSpecificationCollection></cc:Resources></cc:CxF>"
    ).encode()


WORD = re.compile(rb'(?<=[">])[^<>"\n]+(?=["<])')
"""Texts and values: what is changed within them leaves the XML well formed."""

SEEDS = [_file(["M1"]), _file(["M0", "M2"])]
TOKENS = [
    b"<cc:Object>", b"</cc:Object>", b"<cc:Tag/>", b"<!DOCTYPE a>", b"<![CDATA[", b"&amp;", b"&#0;",
    b"<cc:ColorCMYK>", b"</cc:ColorCMYK>", b"<cc:ColorCIEXYZ>", b'StartWL="', b'Increment="', b"R",
    b"ColorRGB", b"ColorCIELab", b"ReflectanceSpectrum", b"EmissiveSpectrum", b"ColorValues",
    b"Object", b"ObjectCollection", b"SampleID", b"M0", b"M1", b"M3_Polarized", b' xsi:nil="true"',
    b"Spectrum_Emissive", b"10_Degree", b"D65", b"-->", b"<!--", b"UTF-16", b"cc:", b"xmlns", b">",
]  # fmt: skip
