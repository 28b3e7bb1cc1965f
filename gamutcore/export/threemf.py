"""3MF (3MF Consortium, core specification 1.3, materials and properties 1.2), for 3-D printers.

The vertices are the coordinates of the colour space. The transform of the build item turns
lightness upwards, makes the white 100 mm high, and moves the gamut to the corner of the printer's
table. Each vertex has its sRGB colour in a colour group.
"""

from __future__ import annotations

import io
import zipfile
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

import numpy as np

from gamutcore.colours.spaces import CIELAB, ColourSpace, srgb
from gamutcore.export.plain_text import ascii_line
from gamutcore.export.ply import comment_lines
from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.geometry import TriangleMesh

__all__ = ["threemf"]

HEIGHT = 100.0
"""Height of the white of the space, in millimetres."""

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIALS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
XML = '<?xml version="1.0" encoding="UTF-8"?>\n'
PACKAGE = "http://schemas.openxmlformats.org/package/2006"

TYPES = (
    f'{XML}<Types xmlns="{PACKAGE}/content-types">'
    '<Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)

RELATIONS = (
    f'{XML}<Relationships xmlns="{PACKAGE}/relationships"><Relationship Id="rel0" '
    'Target="/3D/3dmodel.model" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)

LEVEL = 6
"""Of the compression."""


def threemf(
    mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB
) -> bytes:
    """Return a mesh as 3MF. The same mesh always gives the same bytes.

    The provenance becomes the description, one line per entry.
    """
    colours = np.rint(srgb(space.appearance_lab(mesh.vertices)) * 255.0).astype(int).tolist()
    title = escape(ascii_line(provenance.get("gamut", "gamut")))
    description = escape("\n".join(map(ascii_line, comment_lines(provenance))))
    parts = [
        f'{XML}<model unit="millimeter" xml:lang="en-US" xmlns="{CORE}" xmlns:m="{MATERIALS}">',
        f'<metadata name="Title">{title}</metadata>',
        f'<metadata name="Application">gamutcore {__version__}</metadata>',
        f'<metadata name="Description">{description}</metadata>',
        '<resources><m:colorgroup id="1">',
        *(f'<m:color color="#{red:02X}{green:02X}{blue:02X}"/>' for red, green, blue in colours),
        '</m:colorgroup><object id="2" type="model" name="gamut" pid="1" pindex="0">',
        "<mesh><vertices>",
        *(f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>' for x, y, z in mesh.vertices.tolist()),
        "</vertices><triangles>",
        *(
            f'<triangle v1="{a}" v2="{b}" v3="{c}" pid="1" p1="{a}" p2="{b}" p3="{c}"/>'
            for a, b, c in mesh.faces.tolist()
        ),
        "</triangles></mesh></object></resources><build>",
        f'<item objectid="2" transform="{_transform(mesh, space)}"/></build></model>\n',
    ]
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as package:
        for name, text in (
            ("[Content_Types].xml", TYPES),
            ("_rels/.rels", RELATIONS),
            ("3D/3dmodel.model", "\n".join(parts)),
        ):
            entry = zipfile.ZipInfo(name)  # of 1980, as the format needs some date
            entry.compress_type = zipfile.ZIP_DEFLATED
            package.writestr(entry, text)
    return file.getvalue()


def _transform(mesh: TriangleMesh, space: ColourSpace) -> str:
    """Return the transform of row vectors: a rotation with a scale, and an offset."""
    lightness = space.definition.lightness
    white, _ = space.coordinates(np.array([[100.0, 0.0, 0.0]]))
    scale = HEIGHT / abs(float(white[0, lightness]))
    matrix = np.zeros((4, 3))
    for axis, source in enumerate(((lightness + 1) % 3, (lightness + 2) % 3, lightness)):
        matrix[source, axis] = scale
        matrix[3, axis] = -scale * float(mesh.vertices[:, source].min())
    return " ".join(f"{number + 0.0:.9g}" for number in matrix.ravel().tolist())
