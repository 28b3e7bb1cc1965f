"""How exact the volumes of boundaries are: ``make bench-boundaries``.

Builds the boundary of RGB spaces and of real devices, with default options and as device surface,
and compares the CIELAB volumes with references that do not use the boundary code.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.common import Rows
from benchmarks.devices import Device, devices
from gamutcore.boundary import wrap_colours
from gamutcore.boundary.radial_envelope import FINE, radial_volume
from gamutcore.characterisation import Characterisation, read_characterisation
from gamutcore.colours import surface_colours
from gamutcore.colours.reference import reference_lab, reference_white, rgb_xyz
from gamutcore.options import Options
from gamutcore.references import REFERENCES, Reference

STEPS = 400
"""Steps along the edges of the dense cube; 800 steps change no volume by 0.001 %."""

DENSE_POINTS = 2_000_000
"""Points of the surface in a device's reference."""

LINDBLOOM = {
    "srgb": 832_870,
    "adobe-rgb-1998": 1_208_631,
    "apple-rgb": 798_403,
    "beta-rgb": 1_717_450,
    "colormatch-rgb": 836_975,
    "ntsc-1953": 1_300_252,
    "prophoto-rgb": 2_879_568,
}
"""CIELAB volumes from http://www.brucelindbloom.com/WorkingSpaceInfo.html, by slug.

His Wide Gamut is left out: its primaries are rounded otherwise, which changes 0.18 %."""


def boundaries(quick: bool) -> Rows:
    """Compare devices, RGB spaces with a published volume, and the least exact of the others."""
    spaces = [each for each in REFERENCES.values() if each.kind == "rgb"]
    if quick:
        return [space_row(spaces[0])]
    published = [space_row(each) for each in spaces if each.slug in LINDBLOOM]
    others = [space_row(each) for each in spaces if each.slug not in LINDBLOOM]
    worst: dict[str, Any] = {"device or space": f"{len(others)} other RGB spaces, largest"}
    for column in ("default, %", "`device-surface`, %"):
        worst[column] = max((row[column] for row in others), key=abs)
    return [*map(device_row, devices()), *published, worst]


def space_row(reference: Reference) -> dict[str, Any]:
    """Compare an RGB space with the faces of its cube, and with Lindbloom's volume."""
    device = read_characterisation(reference.data)
    published = LINDBLOOM.get(reference.slug)
    return row_of(reference.name, cube_volume(reference), device, published)


def device_row(device: Device) -> dict[str, Any]:
    """Compare a device with rays through dense points of its surface."""
    data = read_characterisation(device.path.read_bytes())
    dense = surface_colours(data, surface_samples=DENSE_POINTS)  # type: ignore[arg-type]  # no mesh
    assert dense.faces is not None  # noqa: S101  # devices with a model
    centre = (dense.points.min(axis=0) + dense.points.max(axis=0)) / 2
    exact = radial_volume(dense.points, dense.faces.corners, centre, FINE).volume
    return row_of(device.name, exact, data)


def row_of(
    name: str, exact: float, device: Characterisation, published: float | None = None
) -> dict[str, Any]:
    """Return the errors of both kinds of boundary, and that of the default by a publication."""
    colours = surface_colours(device)  # type: ignore[arg-type]  # no mesh
    volumes = []
    for options in (Options(), Options(boundary="device-surface")):
        parameters = (options.boundary, options.centre, options.boundary_parameters)
        wrapped = wrap_colours(colours.points, colours.faces, *parameters)
        volumes.append(wrapped.boundary.mesh.volume)
    return {
        "device or space": name,
        "volume": round(exact),
        "default, %": round(100 * (volumes[0] / exact - 1), 4),
        "`device-surface`, %": round(100 * (volumes[1] / exact - 1), 4),
        "default beside Lindbloom, %": (
            round(100 * (volumes[0] / published - 1), 3) if published else None
        ),
    }


def cube_volume(reference: Reference, steps: int = STEPS) -> float:
    """Return the CIELAB volume within the six faces of an RGB space's cube.

    By the divergence theorem, over two triangles for each step along the edges.
    """
    axis = np.linspace(0.0, 1.0, steps + 1)
    one, two = (grid.ravel() for grid in np.meshgrid(axis, axis, indexing="ij"))
    white, volume = reference_white(reference), 0.0
    for fixed in range(3):
        for end in (0.0, 1.0):
            rgb = np.insert(np.column_stack([one, two]), fixed, end, axis=1)
            lab = reference_lab(rgb_xyz(reference, rgb), white, "relative", "Bradford")[0]
            at = (lab - (50.0, 0.0, 0.0)).reshape(steps + 1, steps + 1, 3)
            near, left, far, right = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
            part = np.einsum("ijk,ijk->", near, np.cross(left, far) + np.cross(far, right)) / 6
            volume += part if (end == 1.0) == (fixed != 1) else -part
    return abs(float(volume))
