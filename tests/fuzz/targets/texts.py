"""Texts and arrays: the CGATS family, CxF3, tables with named columns, bodies of queries."""

import io
import json
import re
import struct
from pathlib import Path

import numpy as np

from gamutcore import Gamut
from gamutcore.questions import QUESTIONS
from gamutcore.tables import read_table
from service.library import QueryLevel
from service.problems.problem import ProblemError
from service.questions.answers import WRITERS
from service.questions.colour_bodies import CSV, JSON, NPY, parse_body
from service.questions.parameter_models import parameter_model
from targets.checks import Target, refused_by_name

ROOT = Path(__file__).parents[3]


def _spectral():
    bands = [f"SPECTRAL_NM{nm}" for nm in range(380, 740, 10)]
    rows = [
        [str(i), *(str(100 * bit) for bit in divmod(i, 2)), *(f"{1 / (i + 2):.4f}" for _ in bands)]
        for i in range(4)
    ]
    names = " ".join(["SAMPLE_ID", "2CLR_1", "2CLR_2", *bands])
    lines = "\r\n".join(" ".join(row) for row in rows)
    return (
        f'CGATS.17\r\nMEASUREMENT_SOURCE "MeasurementCondition=M1 Filter=no"\r\n'
        f"BEGIN_DATA_FORMAT\r\n{names}\r\nEND_DATA_FORMAT\r\nNUMBER_OF_SETS 4\r\nBEGIN_DATA\r\n"
        f"{lines}\r\nEND_DATA\r\n"
    ).encode()


_PRESS = (ROOT / "examples" / "FOGRA39L.ti3").read_bytes()
_DISPLAY = b"""CGATS.17
IDMS_FILE_TYPE\tCGE_MEASUREMENT
IDMS_VERSION 1.3
CGV_DISPLAY_TYPE REFLECTIVE
ILLUMINATION_PERFECT_DIFFUSE_REFLECTOR_XYZ 102 100 63.7
BEGIN_DATA_FORMAT
SampleID RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z
END_DATA_FORMAT
NUMBER_OF_SETS 4
BEGIN_DATA
1 0 0 0 3,9 4,5 4,1
2 255 0 0 28.1 18.8 4.6
3 0 255 0 5.5 10.1 5.9
4 255 255 255 46.7 48.8 7.5
END_DATA
"""
_CGATS = [
    _PRESS[:4000] + b"\nEND_DATA\n",
    _DISPLAY,
    _DISPLAY.replace(b"XYZ_", b"M0_XYZ_") + b"CAL\n" + _DISPLAY,
    _spectral(),
]
_CGATS_TOKENS = [
    *b"BEGIN_DATA END_DATA BEGIN_DATA_FORMAT END_DATA_FORMAT NUMBER_OF_SETS LAB_L XYZ_X".split(),
    *b"CMYK_C RGB_R SPECTRAL_NM380 SPEC_400 M1_LAB_L M2 MEASUREMENT_CONDITION FILTER".split(),
    *b'DEVICE_CLASS DISPLAY OUTPUT ILLUMINANT D65 OBSERVER "10 degree" KEYWORD XYY_CAPY'.split(),
    *(b"\n", b"\r", b"\r\n", b"\t", b" ", b'"', b"#", b";"),
]


_DEVICE = [(0, 0, 0), (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)]


def _npy():
    fields = [("name", "U4"), ("R", "u1"), ("G", "u1"), ("B", "u1"), ("CONDITION", "S2")]
    array = np.zeros(5, [*fields, *((f"SPEC_{nm}", "f4") for nm in range(380, 740, 20))])
    for name, column in zip("RGB", zip(*_DEVICE, strict=True), strict=True):
        array[name] = column
    array["CONDITION"] = b"M1"
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


_ROWS = [[*device, 20 * i, i, -i] for i, device in enumerate(_DEVICE)]
_TABLES = [
    ("R;G;B;L*;C*;h\n" + "\n".join(";".join(map(str, row)) for row in _ROWS)).encode(),
    (
        "R,G,B,x,y,Y\n" + "\n".join(f"{r},{g},{b},0.31,0.33,{s}" for r, g, b, s, *_ in _ROWS)
    ).encode(),
    ",".join(map(str, range(400, 710, 10))).encode() + b"\n" + b",".join([b"0.5"] * 31),
    (
        '{"columns": ["RGB_R", "RGB_G", "RGB_B", "XYZ_X", "XYZ_Y", "XYZ_Z"], "white": [9, 9, 9], '
        f'"samples": {_ROWS}, "conditions": {{"ILLUMINANT": "D65"}}}}'
    ).encode(),
    _npy(),
]
_TABLES_TOKENS = [
    b",", b";", b"\t", b"\n", b'"', b"[", b"]", b"{", b"}", b"null", b"true", b"1e5", b"LAB_L",
    b"M0_", b"CONDITION", b"samples", b"columns", b"white", b"x", b"Y", b"SPEC_380", b"<f8", b"|O",
    b"descr", b"shape", b"(5,)", b"(99999999999,)", b"fortran_order", b"True", b"U999999",
]  # fmt: skip


_CORNERS = [(0, 0, 0), (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)]
_SPECTRUM = " ".join(f"{0.1 + band / 50:.3f}" for band in range(36))


def _cxf(conditions):
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


_CXF_WORD = re.compile(rb'(?<=[">])[^<>"\n]+(?=["<])')
"""Texts and values: what is changed within them leaves the XML well formed."""

_CXF = [_cxf(["M1"]), _cxf(["M0", "M2"])]
_CXF_TOKENS = [
    b"<cc:Object>", b"</cc:Object>", b"<cc:Tag/>", b"<!DOCTYPE a>", b"<![CDATA[", b"&amp;", b"&#0;",
    b"<cc:ColorCMYK>", b"</cc:ColorCMYK>", b"<cc:ColorCIEXYZ>", b'StartWL="', b'Increment="', b"R",
    b"ColorRGB", b"ColorCIELab", b"ReflectanceSpectrum", b"EmissiveSpectrum", b"ColorValues",
    b"Object", b"ObjectCollection", b"SampleID", b"M0", b"M1", b"M3_Polarized", b' xsi:nil="true"',
    b"Spectrum_Emissive", b"10_Degree", b"D65", b"-->", b"<!--", b"UTF-16", b"cc:", b"xmlns", b">",
]  # fmt: skip


CUBE = Gamut((2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) * 20 + (50, 0, 0), gamma=1)
MODELS = {
    name: parameter_model(name, question.all_parameters) for name, question in QUESTIONS.items()
}
LEVEL = QueryLevel(CUBE, CUBE.history.triangles, 0.0)


def npy(array):
    """Return an array as a file."""
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


COLOURS = np.array([[50, 0, 0], [50, 90, 0], [10.5, -3, 1e-3]])
ENDS = np.hstack([COLOURS, COLOURS[::-1]])
_BODIES = [
    json.dumps({"colours": COLOURS.tolist(), "distance": True, "tolerance": 0.5}).encode(),
    json.dumps({"colours": COLOURS.tolist(), "metric": "CIE 2000", "space": "LCHab"}).encode(),
    json.dumps({"colours": COLOURS.tolist(), "method": "clip-focal", "focus": [50, 0, 0]}).encode(),
    json.dumps({"from": COLOURS.tolist(), "to": COLOURS[::-1].tolist(), "kind": "ray"}).encode(),
    npy(COLOURS),
    npy(COLOURS.astype(np.float32)),
    npy(np.asfortranarray(ENDS)),
    b"name,L*,a*,b*\nRed,48,68,48\nBlue,20,60,-90\n",
    b'name;LAB_L;LAB_A;LAB_B\r\n"Red; pale";48,5;68;48\r\n',
    b"from_L*,from_a*,from_b*,to_L*,to_a*,to_b*\n50,0,0,50,90,0\n",
]
_BODIES_TOKENS = [
    *b"colours from to triangles max_error space metric method focus source kind tolerance".split(),
    *b"distance true false null cusp sgck clip-nearest clip-hue clip-lightness LCHab sRGB".split(),
    *b"L* a* b* LAB_L from_L* to_b* descr fortran_order shape <f4 <f8 >f8 |O (3,) (0, 3)".split(),
    *(b"[", b"]", b"{", b"}", b",", b";", b'"', b"\n", b"\r\n", b"[" * 500, b"1e308", b"1e-320"),
]


def check_body(data):
    """Raise unless each operation refuses the body by name, or answers every row."""
    form = NPY if data.startswith(b"\x93NUMPY") else JSON if data.startswith(b"{") else CSV
    for question in QUESTIONS.values():
        if not question.inputs:
            continue
        with refused_by_name(ProblemError):
            body = parse_body(bytearray(data), form, question, CUBE.colour_space, 3, {})
            values = MODELS[question.name]().with_members(body.members)
            values |= {"triangles": LEVEL.triangles, "max_error": None}
            if body.table is not None:
                values["space"] = body.table.space
                written = WRITERS[JSON](question, LEVEL, body, ())
                understood = written.piece(0, question.answer([LEVEL.gamut], body.inputs, values))
                assert len(json.loads(understood)["labels"]) == body.rows
            if values.get("source") is not None:
                continue
            result = question.answer([LEVEL.gamut], body.inputs, values)
            written = WRITERS[form](question, LEVEL, body, ())
            content = written.head(result, body.rows) + written.piece(0, result)
            assert all(np.isfinite(points).all() for points in body.inputs)
            if form == JSON:
                columns = json.loads(content)
                assert all(len(columns[name]) == body.rows for name in result.columns)


def _ase(*swatches):
    """Return Adobe swatches of names, models and values."""
    data = b"ASEF" + struct.pack(">HHI", 1, 0, len(swatches))
    for name, model, values in swatches:
        content = struct.pack(">H", len(name) + 1) + f"{name}\0".encode("utf-16-be") + model
        content += struct.pack(f">{len(values)}fH", *values, 0)
        data += struct.pack(">HI", 1, len(content)) + content
    return data


_COLOURS = [
    'name;h;C;L;"note\nof two lines"\r\nRed;40,5;60;50;"a;b"\r\n;;;;\r\nGrün;0;0;5;\r\n'.encode(),
    "sep=\t\nGröße\tX\tY\tZ\n1\t40.1\t30\t10\n\n2\t.5\t.4\t.3\n".encode("utf-16"),
    "R,G,B,naïve\n228,0,43,a\n# remark\n0,0,0,b\n".encode("cp1252"),
    b"name,hex\nred,#e4002b\nblue,rgb(0 0 255)\nx,lab(50% 40 -59.5)\ny,oklch(0.5 0.1 20deg)\n",
    b"x y Y L a b\n0.31 0.33 20 50 1 2\n0.2 0.3 40 10 -1 2\n",
    _ase(("Grün", b"LAB ", (0.5, -40, 20)), ("x", b"RGB ", (1, 0, 0)), ("y", b"Gray", (0.5,))),
    (
        b"CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\n"
        b'NUMBER_OF_SETS 2\nBEGIN_DATA\n"Grey 1" 50 0 0\nred 48 68 48\nEND_DATA\n'
    ),
    _spectral(),
    _cxf(["M1"]),
    npy(COLOURS),
]
_COLOURS_TOKENS = [
    *b"L a b C h X Y Z R G B hex css LAB_L LAB_A XYZ_X RGB_R CIE-L L*(D50) sep=; #fff 1,5".split(),
    *b"LAB RGB CMYK Gray ASEF BEGIN_DATA END_DATA hsl(1 none 1e40deg lab( #".split(),
    *(b",", b";", b"\t", b"|", b" ", b"\n", b"\r", b'"', b'""', b"\xef\xbb\xbf", b"\0\0\0\1"),
    *(b"\xc0\x01", b"\xff\xff\xff\xff", b"\x7f\xc0\0\0", b"(99999999999, 3)", b"descr", b"|O"),
]


def check_colours(data):
    """Raise unless a table of colours is refused by name, or finite and written with an answer."""
    for options in ({}, {"own": "CIELAB"}, {"space": "sRGB", "scale": 255}, {"columns": "1,2,3"}):
        with refused_by_name():
            table = read_table(data, **options)
            rows = len(table.points)
            assert np.isfinite(table.points).all()
            assert table.reading
            assert len(list(table.labels())) == len(table.lines_of_rows) == rows
            assert table.answer_text({"answer": np.zeros(rows)})


TARGETS = {
    "colours": Target(_COLOURS, _COLOURS_TOKENS, check_colours),
    "cgats": Target(_CGATS, _CGATS_TOKENS),
    "cxf": Target(_CXF, _CXF_TOKENS, word=_CXF_WORD),
    "tables": Target(_TABLES, _TABLES_TOKENS),
    "query_bodies": Target(_BODIES, _BODIES_TOKENS, check_body),
}
