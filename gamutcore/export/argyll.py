"""Gamut surfaces of Argyll CMS (``.gam``), as viewgam, iccgamut and the profilers read them.

A CGATS text of the type GAMUT with two tables: vertices (VERTEX_NO LAB_L LAB_A LAB_B) and triangles
(VERTEX_0 VERTEX_1 VERTEX_2). Coordinates are L*, a*, b* relative to D50. Corners are clockwise
seen from outside. The parser takes numbers without a decimal point as integers and then refuses the
column, so every coordinate has one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.export.icc_cielab import check_icc_cielab
from gamutcore.export.plain_text import ascii_line
from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gamutcore.geometry import DeviceValues, TriangleMesh

__all__ = ["gam"]

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
    found = {}
    for name, cusp in CUSPS.items():
        apart = np.abs(red_green_blue - cusp).max(axis=1)
        apart = np.maximum(apart, np.abs(others).max(axis=1, initial=0.0))
        nearest = int(np.argmin(apart))
        if apart[nearest] > NEAR:
            return {}
        found[name] = nearest
    return found


def _triple(numbers: Iterable[float]) -> str:
    return " ".join(f"{number:.6f}" for number in numbers)
