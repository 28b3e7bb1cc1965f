"""Colour gamut envelopes as text (CGE, IDMS 1.1, 5.32): colours at the surface of the RGB cube.

A CGATS.17 file with IDMS_FILE_TYPE CGE_ENVELOPE. Each face of the cube has `STEPS`² points, which
are 6 m² − 12 m + 8 in total. Readers rebuild the surface from R, G and B, so the file needs
no triangles. Colours are interpolated on the mesh, at the device values of each point.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours import lab_to_xyz
from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.errors import OptionError
from gamutcore.export.icc_cielab import check_icc_cielab
from gamutcore.export.plain_text import ascii_line
from gamutcore.history import nearest_places
from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.arrays import FloatArray
    from gamutcore.geometry import TriangleMesh

__all__ = ["cge"]

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
