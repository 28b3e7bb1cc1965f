"""The real devices that accuracy is measured on, and the exact measure that all are put to.

With the project's shared data beside the checkout (``../shared/data``) these are nine devices: two
presses, newsprint, a phone, three displays, a projector and sRGB. Without it they are what the
repository itself has, and every document says which they were.
"""

from __future__ import annotations

import argparse
import importlib.util
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.files import device_data
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.colours import surface_colours
from gamutcore.decimation import COSTS, decimate
from gamutcore.errors import MeshError
from gamutcore.history import History, build_history
from gamutcore.mesh import TriangleMesh
from gamutcore.metric import mismatch
from gamutcore.metric.radial_overlay import radial_difference

__all__ = [
    "Device",
    "asked_devices",
    "devices",
    "disagreement",
    "exact_mismatch",
    "faults",
    "sphere",
]

ROOT = Path(__file__).parent.parent
SHARED = ROOT.parent / "shared" / "data"

FloatArray = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class Device:
    """A real device.

    Attributes
    ----------
    name : str
        What tables and pictures call it.
    kind : str
        What it is, and what it is known by.
    path : Path
        Its characterisation.
    """

    name: str
    kind: str
    path: Path

    @cached_property
    def points(self) -> FloatArray:
        """About 100,000 CIELAB colours of its surface, (n, 3)."""
        return surface_colours(device_data(self.path.read_bytes())).points

    @cached_property
    def histories(self) -> dict[str, History]:
        """Its boundary's histories, by the name of the cost."""
        mesh, centre = self.boundary.mesh, self.boundary.centre
        return {cost: build_history(decimate(mesh, centre, cost)) for cost in COSTS}

    @cached_property
    def boundary(self) -> Boundary:
        """The modified convex hull of those with γ = 0.2: what everything is measured against."""
        return modified_convex_hull(self.points)


DEVICES = (
    Device("FOGRA39L", "coated offset, measurements", SHARED / "press/FOGRA39L.ti3"),
    Device("ISO coated v2", "coated offset, profile", SHARED / "press/ISOcoated_v2_300_bas.icc"),
    Device("TR 002", "newsprint, measurements", SHARED / "press/TR002.ti3"),
    Device("phone", "RGBW phone, measurements", SHARED / "display/phone_RGBW_LCD_602.txt"),
    Device("Acer XB271HU", "display, table profile", SHARED / "display/Acer_XB271HU.icc"),
    Device("MacBook Air M2", "laptop, matrix profile", SHARED / "display/MBA-M2_native.icc"),
    Device("Panasonic", "television, matrix profile", SHARED / "display/Panasonic-TV_2014.icc"),
    Device("Canon", "projector, matrix profile", SHARED / "display/Canon_projector.icc"),
    Device("sRGB", "colour space", ROOT / "tests/data/sRGB-v4.icc"),
)

FALLBACK = (
    Device("FOGRA39L", "coated offset, measurements", ROOT / "examples/FOGRA39L.ti3"),
    Device("Display P3", "colour space", ROOT / "tests/data/DisplayP3-v4.icc"),
    DEVICES[-1],
)


def devices() -> tuple[Device, ...]:
    """Return the devices whose files are there: all of them, or the repository's own."""
    return DEVICES if all(device.path.exists() for device in DEVICES) else FALLBACK


def asked_devices(description: str | None) -> list[Device]:
    """Return the devices that a program's command line names, all of them if none.

    Parameters
    ----------
    description : str or None
        Of the program.
    """
    there = {device.name: device for device in devices()}
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "device", nargs="*", help=f"{', '.join(map(repr, there))}; all of them if none is named"
    )
    names: list[str] = parser.parse_args().device or list(there)
    for name in names:
        if name not in there:
            parser.error(f"there is no device {name!r}")
    return [there[name] for name in names]


def sphere(vertices: int, *, random: bool = False) -> TriangleMesh:
    """Triangulate a sphere of radius 50 about (50, 0, 0).

    Parameters
    ----------
    vertices : int
    random : bool, optional
        Spread at random (always alike), instead of along a spiral with even spacing.

    Returns
    -------
    TriangleMesh
        The convex hull of the points.
    """
    if random:
        points = np.random.default_rng(1).standard_normal((vertices, 3))
    else:
        number = np.arange(vertices) + 0.5
        height = 1 - 2 * number / vertices
        turn = np.pi * (1 + 5**0.5) * number
        flat = np.sqrt(1 - height**2)
        points = np.stack([height, flat * np.cos(turn), flat * np.sin(turn)], axis=1)
    middle = np.array([50.0, 0.0, 0.0])
    points *= 50 / np.linalg.norm(points, axis=1)[:, np.newaxis]
    return modified_convex_hull(points + middle, 1.0, middle).mesh


def exact_mismatch(reference: TriangleMesh, mesh: TriangleMesh, centre: FloatArray) -> float | None:
    """Exact relative mismatch of a mesh; None if it bounds no solid and so has none.

    Surfaces that are star-shaped about the centre are laid over each other, which takes
    milliseconds; all others go through boolean operations. `disagreement` tells how well the two
    ways agree.
    """
    try:
        return radial_difference(reference, mesh, centre).mismatch
    except MeshError:
        pass
    try:
        return mismatch(reference, mesh)
    except MeshError:
        return None


def disagreement(reference: TriangleMesh, mesh: TriangleMesh, centre: FloatArray) -> float:
    """Difference of the two exact ways to a mismatch, as a part of it."""
    return abs(radial_difference(reference, mesh, centre).mismatch / mismatch(reference, mesh) - 1)


def faults(mesh: TriangleMesh, centre: FloatArray) -> list[str]:
    """Say what a level must be and this mesh is not, in words; none for a valid gamut."""
    found = mesh.validity(centre)
    genus = (2 - found.euler_characteristic) // 2
    said = {
        "not closed": not found.closed,
        "not manifold": found.closed and not found.manifold,
        "several pieces": found.manifold and not found.connected,
        f"genus {genus}": found.manifold and found.connected and genus != 0,
        f"{found.degenerate_faces} degenerate faces": found.degenerate_faces > 0,
        f"{found.duplicate_faces} duplicate faces": found.duplicate_faces > 0,
    }
    wrong = [text for text, holds in said.items() if holds]
    if not found.star_shaped:
        turned = int((mesh.determinants(centre) <= 0).sum())
        crossing = crossings(mesh)
        wrong += [f"{turned} faces turned away"] + [f"{crossing} crossings"] * bool(crossing)
    return wrong


def crossings(mesh: TriangleMesh) -> int | None:
    """Count pairs of faces that pass through each other, by MeshLib; None where it is not there.

    A mesh that is star-shaped has none; others are told from it by this.
    """
    if importlib.util.find_spec("meshlib") is None:
        return None
    from meshlib import mrmeshnumpy, mrmeshpy

    solid = mrmeshnumpy.meshFromFacesVerts(
        mesh.faces.astype(np.int32), mesh.vertices.astype(np.float64)
    )
    return len(mrmeshpy.findSelfCollidingTriangles(mrmeshpy.MeshPart(solid)))
