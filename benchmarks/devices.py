"""Real devices whose gamuts are measured, and the exact measures that every method is put to.

With the shared data beside the checkout (``../shared/data``) there are nine devices. Without it
there are the two that the repository contains.
"""

from __future__ import annotations

import importlib.util
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.booleans import mismatch
from benchmarks.common import (
    FOGRA39L,
    SHARED,
    SRGB,
    FloatArray,
    build_mesh_history,
    surface_points,
)
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.decimation import COSTS
from gamutcore.errors import MeshError
from gamutcore.geometry import TriangleMesh
from gamutcore.history import History
from gamutcore.levels import radial_difference


@dataclass(frozen=True)
class Device:
    """A real device: its name in tables and pictures, a description, and its characterisation."""

    name: str
    kind: str
    path: Path

    @cached_property
    def points(self) -> FloatArray:
        """About 100,000 CIELAB colours of the device's surface, shape (n, 3)."""
        return surface_points(self.path)

    @cached_property
    def boundary(self) -> Boundary:
        """The reference: the modified convex hull of the points with γ = 0.2."""
        return modified_convex_hull(self.points)

    @cached_property
    def histories(self) -> dict[str, History]:
        """Histories of the boundary by the name of the cost."""
        mesh, centre = self.boundary.mesh, self.boundary.centre
        return {cost: build_mesh_history(mesh, centre, cost) for cost in COSTS}

    def level_row(self, method: str, asked: int, mesh: TriangleMesh) -> dict[str, Any]:
        """Return the mismatch of a level by a method, and whether it keeps all invariants."""
        valid = mesh.validity(self.boundary.centre).is_gamut
        return {
            "device": self.name,
            "method": method,
            "asked": asked,
            "triangles": mesh.triangles,
            "reached": 4 <= mesh.triangles <= asked,
            "mismatch": self.mismatch(mesh),
            "valid": valid,
            "crossings": 0 if valid else crossings(mesh),
        }

    def mismatch(self, mesh: TriangleMesh) -> float | None:
        """Return the exact relative mismatch of a mesh; None if the mesh bounds no solid.

        Surfaces that are star-shaped about the centre are overlaid, which takes milliseconds. All
        others go through boolean operations.
        """
        reference = self.boundary.mesh
        with suppress(MeshError):
            return radial_difference(reference, mesh, self.boundary.centre).mismatch
        with suppress(MeshError):
            return mismatch(reference, mesh)
        return None


DEVICES = (
    Device("FOGRA39L", "coated offset, measurements", FOGRA39L),
    Device("ISO coated v2", "coated offset, profile", SHARED / "press/ISOcoated_v2_300_bas.icc"),
    Device("TR 002", "newsprint, measurements", SHARED / "press/TR002.ti3"),
    Device("phone", "RGBW phone, measurements", SHARED / "display/phone_RGBW_LCD_602.txt"),
    Device("Acer XB271HU", "display, table profile", SHARED / "display/Acer_XB271HU.icc"),
    Device("MacBook Air M2", "laptop, matrix profile", SHARED / "display/MBA-M2_native.icc"),
    Device("Panasonic", "television, matrix profile", SHARED / "display/Panasonic-TV_2014.icc"),
    Device("Canon", "projector, matrix profile", SHARED / "display/Canon_projector.icc"),
    Device("sRGB", "colour space", SRGB),
)


def devices() -> tuple[Device, ...]:
    """Return the devices whose files are here."""
    return tuple(device for device in DEVICES if device.path.exists())


def crossings(mesh: TriangleMesh) -> int:
    """Count the faces that intersect others, with MeshLib; 0 if MeshLib is not installed."""
    if importlib.util.find_spec("meshlib") is None:
        return 0
    from meshlib import mrmeshnumpy, mrmeshpy

    solid = mrmeshnumpy.meshFromFacesVerts(
        mesh.faces.astype(np.int32), mesh.vertices.astype(np.float64)
    )
    return len(mrmeshpy.findSelfCollidingTriangles(mrmeshpy.MeshPart(solid)))
