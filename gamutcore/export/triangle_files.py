"""PLY, STL, OBJ and 3MF: triangles for 3-D programs and printers.

PLY (Turk, Stanford 1994) is binary little-endian: x y z, red green blue, vertex_indices. The
colours are 8-bit sRGB, as PLY readers expect. The provenance is in comments. Device values are one
float property per channel after the colours, with the name of the channel in a comment.

3MF is of the core specification 1.3, materials and properties 1.2 (3MF Consortium). The vertices
are the coordinates of the colour space. The transform of the build item turns lightness upwards,
makes the white 100 mm high, and moves the gamut to the corner of the printer's table. Each vertex
has its sRGB colour in a colour group.

trimesh writes PLY, STL and OBJ.
"""

from __future__ import annotations

import io
import zipfile
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

import numpy as np

from gamutcore.colours.spaces import CIELAB, ColourSpace, srgb
from gamutcore.export.provenance import ascii_line, comment_lines, property_names
from gamutcore.geometry import imported_trimesh
from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from gamutcore.geometry import TriangleMesh

__all__ = ["obj", "ply", "stl", "threemf"]


def _colours(mesh: TriangleMesh, space: ColourSpace) -> NDArray[np.uint8]:
    """Return the sRGB of vertices in 8 bits, (v, 3)."""
    return np.rint(srgb(space.appearance_lab(mesh.vertices)) * 255.0).astype(np.uint8)


def ply(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as binary PLY."""
    export_ply = imported_trimesh().exchange.ply.export_ply
    colours = _colours(mesh, space)
    coloured = mesh.to_trimesh()
    for channel, name in enumerate(("red", "green", "blue")):
        coloured.vertex_attributes[name] = colours[:, channel]
    facts = dict(provenance)
    if mesh.device is not None:
        for channel, name in enumerate(property_names(mesh.device.channels)):
            values = mesh.device.values[:, channel].astype(np.float32)
            coloured.vertex_attributes[name] = values
            facts[name] = mesh.device.channels[channel]
    exported: bytes = export_ply(coloured, encoding="binary", vertex_normal=False)
    head, comment, rest = exported.partition(b"comment https://github.com/mikedh/trimesh\n")
    if not comment:  # insert after the line that names the encoding
        head, end, rest = exported.partition(b"1.0\n")
        head += end
    lines = "".join(f"comment {line}\n" for line in comment_lines(facts))
    lines = lines.replace("end_header", "end-header")  # trimesh ends the header at this word
    return head + lines.encode("ascii", "backslashreplace") + rest


def stl(mesh: TriangleMesh, _provenance: Mapping[str, str], _space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as binary STL, which has neither colours nor provenance."""
    exported: bytes = imported_trimesh().exchange.stl.export_stl(mesh.to_trimesh())
    return exported


def obj(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as Wavefront OBJ, with sRGB and provenance in comments.

    The colours are lines ``#MRGB`` as ZBrush writes them, which Blender reads. Colours behind the
    positions would be extra coordinates to other readers, such as meshio.
    """
    export_obj = imported_trimesh().exchange.obj.export_obj
    colours = _colours(mesh, space)
    header = "\n# ".join(
        line.encode("ascii", "backslashreplace").decode() for line in comment_lines(provenance)
    )
    exported: str = export_obj(mesh.to_trimesh(), include_normals=False, digits=12, header=header)
    vertices, first_face, faces = exported.partition("\nf ")
    return f"{vertices}\n{_polypaint(colours)}{first_face[1:]}{faces}".encode()


def _polypaint(colours: np.ndarray) -> str:
    """Return lines of vertex colours: ``#MRGB`` and 64 times mask, red, green and blue in hex."""
    words = [f"ff{red:02x}{green:02x}{blue:02x}" for red, green, blue in colours.tolist()]
    return "".join(
        f"#MRGB {''.join(words[start : start + 64])}\n" for start in range(0, len(words), 64)
    )


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
    colours = _colours(mesh, space).tolist()
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
