"""Formats of colour management, whose coordinates are CIELAB relative to D50 by definition.

Argyll's gamut surface (``.gam``), as viewgam, iccgamut and the profilers read it, is a CGATS text
of the type GAMUT with two tables: vertices (VERTEX_NO LAB_L LAB_A LAB_B) and triangles (VERTEX_0
VERTEX_1 VERTEX_2). Corners are clockwise seen from outside. The parser takes numbers without a
decimal point as integers and then refuses the column, so every coordinate has one.

A colour gamut envelope (CGE, IDMS 1.1, 5.32) is a CGATS.17 text with the colours at the surface of
the RGB cube. Each face of the cube has `STEPS`² points, which are 6 m² − 12 m + 8 in total. Readers
rebuild the surface from R, G and B, so the file needs no triangles. Colours are interpolated on the
mesh, at the device values of each point.

An iccMAX profile has a gamut boundary description (ICC.2:2019, 10.2.11). The profile is abstract:
from CIELAB to CIELAB, with an identity as its transform. A gamut has no device model, so no other
class of profile would be true of it. The tag gbd0, gbd1, gbd2 or gbd3 is that of the gamut's
intent. The boundary may also become a tag of an existing profile, then with device values. All
numbers are big-endian.
"""

from __future__ import annotations

import struct
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.icc import icc_profile, looks_like_icc
from gamutcore.characterisation.meshes import GAMUT_BOUNDARY_TAGS
from gamutcore.colours import lab_to_xyz
from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.errors import GamutError, MalformedProfileError, OptionError
from gamutcore.export.icc_file import (
    COPYRIGHT,
    D50,
    data_space,
    description_element,
    icc_file,
    profile_id,
    profile_of,
    xyz_element,
)
from gamutcore.export.provenance import ascii_line
from gamutcore.history import nearest_places
from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.icc import IccProfile
    from gamutcore.geometry import DeviceValues, TriangleMesh

__all__ = ["cge", "gam", "icc", "icc_with_boundary"]


def check_icc_cielab(space: ColourSpace, format_name: str) -> None:
    """Refuse a format for meshes in other spaces than CIELAB relative to D50.

    Straight edges would be curves after a conversion, so the mesh is not converted.
    """
    if not space.is_icc_cielab:
        own = space.name if space.name != "CIELAB" else "CIELAB with another white"
        raise OptionError.not_applicable(
            "format",
            format_name,
            f"the format is for CIELAB relative to D50, and the gamut is in {own}",
            "Build the gamut in the space CIELAB with default parameters, or choose ply or glb.",
        )


CUSPS = {
    "RED": (1, 0, 0),
    "YELLOW": (1, 1, 0),
    "GREEN": (0, 1, 0),
    "CYAN": (0, 1, 1),
    "BLUE": (0, 0, 1),
    "MAGENTA": (1, 0, 1),
}
"""Keywords of the cusps, and R, G, B of each. All six are given or none."""

NEAR = 0.02
"""Largest distance of a device value from that of a cusp. Farther vertices are other colours."""


def gam(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as a gamut surface of Argyll CMS; only CIELAB relative to D50 is accepted.

    White and black are the lightest and the darkest vertex. The cusps are the vertices of the
    primaries and secondaries, if channels R G B, C M Y or C M Y K show them. The provenance's
    ``centre`` becomes GAMUT_CENTER.
    """
    check_icc_cielab(space, "gam")
    vertices = np.asarray(mesh.vertices, np.float64)
    lightest, darkest = vertices[np.argmax(vertices[:, 0])], vertices[np.argmin(vertices[:, 0])]
    keywords = {
        "DESCRIPTOR": provenance.get("gamut", "gamut"),
        "ORIGINATOR": f"gamutcore {__version__}",
        "COLOR_REP": "LAB",
    }
    if "centre" in provenance:
        keywords["GAMUT_CENTER"] = _triple(map(float, provenance["centre"].split()))
    for name, colour in (("WHITE", lightest), ("BLACK", darkest)):
        keywords[f"CSPACE_{name}"] = keywords[f"GAMUT_{name}"] = _triple(colour)
    if mesh.device is not None:
        keywords |= {
            f"CUSP_{name}": _triple(vertices[vertex])
            for name, vertex in _cusps(mesh.device).items()
        }
    head = [f'{name} "{ascii_line(text)}"' for name, text in keywords.items()]
    # nine digits are exact for float32
    rows = [
        f"{row} {lightness:#.9g} {a:#.9g} {b:#.9g}"
        for row, (lightness, a, b) in enumerate(vertices.tolist())
    ]
    corners = [f"{one} {two} {three}" for one, three, two in mesh.faces.tolist()]
    lines = ["GAMUT", "", *head]
    for fields, table in (
        ("VERTEX_NO LAB_L LAB_A LAB_B", rows),
        ("VERTEX_0 VERTEX_1 VERTEX_2", corners),
    ):
        lines += ["", f"NUMBER_OF_FIELDS {len(fields.split())}"]
        lines += ["BEGIN_DATA_FORMAT", fields, "END_DATA_FORMAT"]
        lines += ["", f"NUMBER_OF_SETS {len(table)}", "BEGIN_DATA", *table, "END_DATA"]
    return ("\n".join(lines) + "\n").encode("ascii")


def _cusps(device: DeviceValues) -> dict[str, int]:
    """Return the vertices of the primaries and secondaries; empty unless all six are there."""
    channels, values = "".join(device.channels).upper(), device.values.astype(np.float64)
    if channels == "RGB":
        red_green_blue = values
    elif channels in {"CMY", "CMYK"}:
        red_green_blue = 1.0 - values[:, :3]
    else:
        return {}
    others = values[:, 3:]  # black ink, which cusps have none of
    primaries = {}
    for name, cusp in CUSPS.items():
        apart = np.abs(red_green_blue - cusp).max(axis=1)
        apart = np.maximum(apart, np.abs(others).max(axis=1, initial=0.0))
        nearest = int(np.argmin(apart))
        if apart[nearest] > NEAR:
            return {}
        primaries[name] = nearest
    return primaries


def _triple(numbers: Iterable[float]) -> str:
    return " ".join(f"{number:.6f}" for number in numbers)


STEPS = 11
"""Number m of levels of a channel, which measurements use."""

CANDIDATES = 100
"""Vertices of which the faces are tried. Faces of coarse levels are large; with 500 vertices, the
colours are the same."""

FULL = 255
"""Level of a full channel. Levels are whole numbers, as a display is driven by: 0, 25, 51, …"""


def cge(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return the colours at the surface of a device's RGB cube, in CIELAB relative to D50 only.

    The 602 rows have R, G, B from 0 to 255, then X, Y, Z and L*, a*, b*. X, Y, Z are relative to
    D50, with Y = 100 for the white. Channels C, M, Y become R = 255 − C and so on; other channels
    are refused. The provenance's ``gamut`` becomes the originator's description.
    """
    check_icc_cielab(space, "cge")
    device = mesh.device
    channels = "" if device is None else "".join(device.channels).upper()
    if device is None or channels not in {"RGB", "CMY"}:
        own = f"the channels {' '.join(device.channels)}" if device else "no device values"
        raise OptionError.not_applicable(
            "format",
            "cge",
            f"the format is for the channels R G B or C M Y, and the gamut has {own}",
            "Choose ply or glb, which have any channels.",
        )
    levels = _cube_surface()
    values = device.values.astype(np.float64)
    cube = 1.0 - values if channels == "CMY" else values
    places = nearest_places(levels / FULL, cube, mesh.faces, CANDIDATES)
    weights = np.stack([1.0 - places.second - places.third, places.second, places.third])
    corners = mesh.vertices[mesh.faces[places.faces]].astype(np.float64)
    lab = np.einsum("kn,nkc->nc", weights, corners)
    xyz = 100.0 * lab_to_xyz(lab)
    lines = [
        "CGATS.17",
        "FORMAT_VERSION 1",
        "IDMS_FILE_TYPE CGE_ENVELOPE",
        "IDMS_VERSION 1.1",
        f'ORIGINATOR "gamutcore {__version__}"',
        f'DESCRIPTOR "{ascii_line(provenance.get("gamut", "gamut"))}"',
        "KEYWORD SampleID",
        "NUMBER_OF_FIELDS 10",
        "BEGIN_DATA_FORMAT",
        "SampleID RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z LAB_L LAB_A LAB_B",
        "END_DATA_FORMAT",
        f"NUMBER_OF_SETS {len(levels)}",
        "BEGIN_DATA",
    ]
    for number, row in enumerate(np.column_stack([levels, xyz, lab]).tolist(), 1):
        rgb, colour = row[:3], row[3:]
        texts = [str(number), *(f"{level:.0f}" for level in rgb), *(f"{x:.5f}" for x in colour)]
        lines.append(" ".join(texts))
    return ("\n".join([*lines, "END_DATA"]) + "\n").encode("ascii")


def _cube_surface() -> FloatArray:
    """Return the points of the cube's surface, (6 m² − 12 m + 8, 3), in steps of one level."""
    levels = [FULL * step // (STEPS - 1) for step in range(STEPS)]
    return np.array(
        [point for point in product(levels, repeat=3) if {0, FULL} & set(point)], np.float64
    )


def icc(mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace = CIELAB) -> bytes:
    """Return a mesh as a gamut boundary description in an iccMAX profile, in CIELAB (D50) only.

    The provenance's ``intent`` chooses the tag, and its ``gamut`` is in the description. Device
    values are left out, because the data colour space of the profile is CIELAB.
    """
    check_icc_cielab(space, "icc")
    intent = _intent(provenance)
    description = f"Gamut boundary {provenance.get('gamut', '')[:12]} by gamutcore {__version__}"
    tags = {
        "desc": description_element(description, 5),
        "cprt": description_element(COPYRIGHT, 5),
        "wtpt": xyz_element(D50),
        "A2B0": _identity(),
        GAMUT_BOUNDARY_TAGS[intent]: _boundary(mesh),
    }
    return icc_file(5, "abst", ("Lab ", "Lab "), tags, intent)


def _intent(provenance: Mapping[str, str]) -> str:
    intent = provenance.get("intent", "relative")
    return intent if intent in GAMUT_BOUNDARY_TAGS else "relative"


def icc_with_boundary(
    mesh: TriangleMesh, provenance: Mapping[str, str], space: ColourSpace, profile: bytes
) -> bytes:
    """Return a profile of version 5 with a mesh as its gamut boundary description.

    The mesh's device values are kept, unless the profile is abstract. The description of the same
    intent is replaced. Elements of other tags stay as they are, and the header but for size and id.
    """
    check_icc_cielab(space, "icc")
    try:
        read = _undamaged(profile)
        tags = {tag: read.element(tag).data for tag in read.tags}
    except GamutError as error:
        error.where["field"] = "into"
        raise
    if read.version[0] != 5:
        raise _into(
            f"the profile has version {read.version[0]}, which has no gamut boundaries",
            "Give a profile of version 5 (gamut profile --version 5), or leave it out: the file is "
            "then an abstract profile of version 5.",
        )
    device = mesh.device if read.channels else None
    if device is not None and data_space(device.channels) != data_space(read.channels):
        own, other = " ".join(device.channels), " ".join(read.channels)
        raise _into(
            f"the profile's channels are {other}, and those of the gamut are {own}",
            "Give the profile of the gamut's device.",
        )
    tags[GAMUT_BOUNDARY_TAGS[_intent(provenance)]] = _boundary(mesh, device, read.pcs)
    return profile_of(profile[:128], tags)


def _undamaged(data: bytes) -> IccProfile:
    """Return a profile whose size and id are those of its content."""
    if not looks_like_icc(data):
        fault = "The file is not an ICC profile."
    elif int.from_bytes(data[:4], "big") != len(data):
        fault = f"The profile has {len(data)} bytes, but declares another size."
    elif any(data[84:100]) and data[84:100] != profile_id(data):
        fault = "The profile was changed: its id is not that of its content."
    else:
        return icc_profile(data)
    raise MalformedProfileError(fault, where={}, remedy="Send the whole profile, or make it again.")


def _into(why: str, remedy: str) -> OptionError:
    return OptionError(f"into does not apply: {why}.", where={"field": "into"}, remedy=remedy)


def _identity() -> bytes:
    """Return an element of the type multiProcessElementsType: one matrix, the identity."""
    matrix = struct.pack(">4sI2H12f", b"matf", 0, 3, 3, *np.eye(3).ravel(), 0.0, 0.0, 0.0)
    return struct.pack(">4sI2H3I", b"mpet", 0, 3, 3, 1, 24, len(matrix)) + matrix


def _boundary(mesh: TriangleMesh, device: DeviceValues | None = None, pcs: str = "Lab") -> bytes:
    """Return an element of the type gamutBoundaryDescType, with vertices in a connection space."""
    vertices = np.asarray(mesh.vertices, np.float64)
    vertices = vertices if pcs == "Lab" else lab_to_xyz(vertices)
    clockwise = np.ascontiguousarray(mesh.faces[:, ::-1], ">u4")
    values = np.empty((len(vertices), 0)) if device is None else device.values
    counts = struct.pack(">4sI2H2I", b"gbd ", 0, 3, values.shape[1], len(vertices), len(clockwise))
    numbers = (np.ascontiguousarray(each, ">f4").tobytes() for each in (vertices, values))
    return counts + clockwise.tobytes() + b"".join(numbers)
