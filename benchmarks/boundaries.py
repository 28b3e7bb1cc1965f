"""Measure how exact the volumes of boundaries are: ``make bench-boundaries``.

Builds the boundary of every RGB space of colour-science and of real devices, with default options
and as device surface, and compares volumes with references that do not use the boundary code: dense
faces of the cube by the divergence theorem, published volumes, and rays through two million points
of the device's surface. The figures go to ``benchmarks/boundaries.json`` and into
``docs/benchmarks.md``. Devices need the shared data beside the checkout (``../shared/data``).
"""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks import markdown
from benchmarks.bench import DOCUMENT
from benchmarks.common import SHARED
from gamutcore.boundary.radial_volume import FINE, radial_volume
from gamutcore.boundary.wrapping import wrap_colours
from gamutcore.characterisation import characterisation
from gamutcore.colours import surface_colours
from gamutcore.colours.reference_colours import reference_lab, reference_white, rgb_xyz
from gamutcore.options import Options
from gamutcore.references import NOT_OFFERED, REFERENCES

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation import Characterisation
    from gamutcore.references import Reference

__all__ = ["cube_volume", "main", "tables"]

RESULTS = Path(__file__).with_name("boundaries.json")

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
"""CIELAB volumes from http://www.brucelindbloom.com/WorkingSpaceInfo.html, by slug."""

WIDE_GAMUT = "adobe-wide-gamut-rgb"
WIDE_GAMUT_VOLUME = 2_164_221
WIDE_GAMUT_PRIMARIES = ((0.735, 0.265), (0.115, 0.826), (0.157, 0.018))
"""Lindbloom's Wide Gamut. The primaries of colour-science have four decimals, and its cube is
0.18 % larger for that reason alone, so it is measured with his."""

DEVICES = {
    "FOGRA39L": "press/FOGRA39L.ti3",
    "TR002": "press/TR002.ti3",
    "phone RGBW": "display/phone_RGBW_LCD_602.txt",
    "television": "display/Panasonic-TV_2014.icc",
    "projector": "display/Canon_projector.icc",
}


def main() -> None:
    """Measure all, and write the figures and the document."""
    results = {"spaces": [_space(each) for each in REFERENCES.values() if each.kind == "rgb"]}
    results["published"] = [_wide_gamut()]
    results["devices"] = [_device(name, SHARED / path) for name, path in DEVICES.items()]
    RESULTS.write_text(json.dumps(results, indent=1) + "\n")
    markdown.update_document(DOCUMENT, tables(results))


def cube_volume(reference: Reference, steps: int = STEPS) -> float:
    """Return the CIELAB volume within the six faces of an RGB space's cube.

    Parameters
    ----------
    reference : Reference
    steps : int
        Steps along each edge.

    Returns
    -------
    float
        By the divergence theorem, over two triangles for each step.
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


def _boundaries(device: Characterisation) -> dict[str, Any]:
    """Volumes of the default boundary and of the device surface, with the choices and times."""
    found: dict[str, Any] = {}
    for name, options in (("default", Options()), ("surface", Options(boundary="device-surface"))):
        began = time.process_time()
        colours = surface_colours(device)  # type: ignore[arg-type]  # no mesh
        wrapping = wrap_colours(
            colours.points,
            colours.faces,
            options.boundary,
            options.centre,
            options.boundary_parameters,
        )
        found[name] = {
            "volume": wrapping.boundary.mesh.volume,
            "device_volume": wrapping.device_volume,
            "choices": wrapping.choices,
            "seconds": time.process_time() - began,
        }
    return found


def _space(reference: Reference) -> dict[str, Any]:
    found = _boundaries(characterisation(reference.data))
    exact = cube_volume(reference)
    return {"name": reference.name, "slug": reference.slug, "exact": exact, **found}


def _wide_gamut() -> dict[str, Any]:
    reference = REFERENCES[WIDE_GAMUT]
    definition = {**reference.definition, "primaries": WIDE_GAMUT_PRIMARIES}
    with_his = replace(reference, definition=definition, primaries=WIDE_GAMUT_PRIMARIES)
    name = f"{reference.name}, Lindbloom's primaries"
    exact = cube_volume(with_his)
    return {"name": name, "slug": WIDE_GAMUT, "exact": exact, **_boundaries(with_his)}


def _device(name: str, path: Path) -> dict[str, Any]:
    device = characterisation(path.read_bytes())
    dense = surface_colours(device, surface_samples=DENSE_POINTS)  # type: ignore[arg-type]  # no mesh
    assert dense.faces is not None  # noqa: S101  # devices with a model
    centre: FloatArray = (dense.points.min(axis=0) + dense.points.max(axis=0)) / 2
    exact = radial_volume(dense.points, dense.faces.corners, centre, FINE).volume
    return {"name": name, "exact": exact, **_boundaries(device)}


def tables(results: dict[str, list[dict[str, Any]]]) -> dict[str, str]:
    """Return the blocks of the document.

    Parameters
    ----------
    results : dict
        As in ``benchmarks/boundaries.json``.

    Returns
    -------
    dict of str to str
    """
    spaces = sorted(results["spaces"], key=lambda row: -abs(_error(row, "default")))
    blocks = {
        "boundary_spaces": [_row(row) for row in spaces],
        "boundary_devices": [_row(row) for row in results["devices"]],
    }
    head = ["", "volume", "default, %", "`device-surface`, %", "centre", "depth, ΔE", "γ"]
    texts = {name: markdown.table(head, rows) for name, rows in blocks.items()}
    published = [
        [row["name"], f"{volume:,}"]
        + [f"{100 * (row[kind]['volume'] / volume - 1):+.3f}" for kind in ("default", "surface")]
        for row, volume in [
            *(
                (row, LINDBLOOM[row["slug"]])
                for row in results["spaces"]
                if row["slug"] in LINDBLOOM
            ),
            *((row, WIDE_GAMUT_VOLUME) for row in results["published"]),
        ]
    ]
    texts["boundary_published"] = markdown.table(
        ["space", "published", "default, %", "`device-surface`, %"], published
    )
    texts["boundary_refused"] = markdown.table(
        ["space", "reason"], [[name, why] for name, why in NOT_OFFERED.items()]
    )
    return texts


def _error(row: dict[str, Any], kind: str) -> float:
    return float(row[kind]["volume"] / row["exact"] - 1)


def _row(row: dict[str, Any]) -> list[str]:
    choices = row["default"]["choices"]
    return [
        row["name"],
        f"{row['exact']:,.0f}",
        *(f"{100 * _error(row, kind):+.4f}" for kind in ("default", "surface")),
        choices["centre"]["from"],
        f"{choices['centre']['depth']:.3g}",
        f"{choices['gamma']:g}",
    ]


if __name__ == "__main__":
    main()
