"""The published experiment, on real devices and with exact mismatches.

Bakke & Farup ("Simplified Gamut Boundary Representation using Mesh Decimation") take the modified
convex hull of about 100,000 surface colours as the reference and compare simplified boundaries at
equal triangle counts by relative volume mismatch. Here are the same methods: decimation, USV at all
its sizes, segment maxima, the convex hull, and the modified hull of a subsample of the colours.
Each of the other methods has sizes of its own, so decimation is read at exactly the triangle count
that the other method came out with: any count can be read out of a history.

``python -m benchmarks.paper [DEVICE ...]`` prints the comparison of some devices; ``make figures``
makes the whole document.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from benchmarks.devices import Device, FloatArray, asked_devices, exact_mismatch, sphere
from benchmarks.markdown import percent, table
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.boundary.segment_maxima import segment_maxima
from gamutcore.boundary.usv import BASES, usv
from gamutcore.decimation import COSTS, decimate
from gamutcore.errors import BoundaryError, InvalidPointsError
from gamutcore.history import History, build_history
from gamutcore.metric import mismatch
from gamutcore.metric.voxel_mismatch import voxel_mismatch

__all__ = [
    "CURVE_COUNTS",
    "SPHERE_LIMIT",
    "floor_row",
    "other_rows",
    "sphere_rows",
    "subsampled",
    "voxel_rows",
]

CURVE_COUNTS = (10_000, 5000, 2000, 1000, 500, 200, 100, 50, 20, 10)
"""Triangle counts of the curves."""

SPHERE_LIMIT = 12 * np.pi * (1 / (6 * 3**0.5) - 1 / (8 * np.pi))
"""Least mismatch × triangles on a sphere for many triangles: Ludwig's and Böröczky's constants."""

USV_GAMMA = 0.05
"""γ of the modified hull that USV wraps its points with, as published."""

LARGEST = 12_000
"""Sizes of the other methods go up to so many triangles."""

SEGMENTS = (3, 4, 5, 7, 9, 11, 16, 22, 35, 50)
"""Polar segments of segment maxima; twice as many azimuth segments make them even."""

DRAWS = 3
"""Subsamples drawn for each triangle count."""

MOST_DRAWS = 60
"""Subsamples drawn before giving up: few colours often do not surround the centre."""


def other_rows(
    device: Device, histories: dict[str, History], levels: list[dict[str, Any]]
) -> list[dict[str, Any]]:
    """Measure the other methods, and decimation at the triangle counts that they came out with.

    Parameters
    ----------
    device : Device
    histories : dict of History
        By the name of the cost.
    levels : list of dict
        What `peers.level_rows` has measured already.

    Returns
    -------
    list of dict
        ``method``, ``size`` (segments, or triangles asked for), ``triangles``, ``mismatch``,
        ``volume`` (relative to the reference's, less 1), and ``decimated``: mismatch at the same
        count by cost.
    """
    reference, centre = device.boundary.mesh, device.boundary.centre
    rows = []
    errors = {(row["method"], row["triangles"]): row["mismatch"] for row in levels}
    for method, size, boundary in _boundaries(device):
        mesh = boundary.mesh
        for cost, history in histories.items():
            if (cost, mesh.triangles) not in errors:
                level = history.level(mesh.triangles)
                errors[cost, mesh.triangles] = exact_mismatch(reference, level, centre)
        rows.append(
            {
                "device": device.name,
                "method": method,
                "size": size,
                "triangles": mesh.triangles,
                "mismatch": exact_mismatch(reference, mesh, centre),
                "volume": mesh.volume / reference.volume - 1,
                "decimated": {cost: errors[cost, mesh.triangles] for cost in histories},
            }
        )
    return rows


def floor_row(device: Device) -> dict[str, Any]:
    """Measure the modified hull of all colours with USV's γ: USV cannot come closer than that."""
    reference, centre = device.boundary.mesh, device.boundary.centre
    mesh = modified_convex_hull(device.points, USV_GAMMA, centre).mesh
    return {
        "device": device.name,
        "gamma": USV_GAMMA,
        "triangles": mesh.triangles,
        "mismatch": exact_mismatch(reference, mesh, centre),
        "volume": mesh.volume / reference.volume - 1,
    }


def voxel_rows(device: Device, history: History) -> list[dict[str, Any]]:
    """Measure levels as the publication does, in voxels, beside the exact mismatch."""
    reference = device.boundary.mesh
    rows = []
    for count in CURVE_COUNTS:
        level = history.level(count)
        voxels = voxel_mismatch(reference, level)
        rows.append(
            {
                "device": device.name,
                "asked": count,
                "mismatch": exact_mismatch(reference, level, device.boundary.centre),
                "voxel_mismatch": voxels.mismatch,
                "bound": voxels.bound,
                "edge": voxels.edge,
            }
        )
    return rows


def sphere_rows() -> list[dict[str, Any]]:
    """Measure mismatch × triangles on spheres of 10,000 vertices, where the limit is known."""
    rows = []
    for spread in ("spiral", "random"):
        mesh = sphere(10_000, random=spread == "random")
        for cost in COSTS:
            history = build_history(decimate(mesh, (50.0, 0.0, 0.0), cost))
            for count in (2000, 1000, 500, 200, 100):
                level = history.level(count)
                product = mismatch(mesh, level) * count
                rows.append({"points": spread, "cost": cost, "asked": count, "product": product})
    return rows


def subsampled(points: FloatArray, centre: FloatArray, triangles: int) -> Boundary:
    """Wrap a random subsample of colours in a modified hull of so many triangles or just less."""
    return next(_subsamples(points, centre, triangles))


def _boundaries(device: Device) -> Iterator[tuple[str, int, Boundary]]:
    """Boundaries of the other methods: name, size, boundary."""
    points, centre = device.points, device.boundary.centre
    makers: list[tuple[str, int, Callable[[], Boundary]]] = [
        ("convex hull", len(points), lambda: modified_convex_hull(points, 1.0, centre)),
    ]
    for basis, segments in zip(BASES, (4, 8, 20), strict=True):
        for splits in range(8):
            size = segments * 4**splits
            if 2 * size - 4 <= LARGEST:
                makers.append(
                    (
                        f"USV, {basis}",
                        size,
                        functools.partial(usv, points, basis, splits, USV_GAMMA, centre),
                    )
                )
    makers += [
        (
            "segment maxima",
            2 * polar * polar,
            functools.partial(segment_maxima, points, (polar, 2 * polar), centre),
        )
        for polar in SEGMENTS
    ]
    for method, size, make in makers:
        try:
            yield method, size, make()
        except (BoundaryError, InvalidPointsError):
            print(f"  {method} of {size} gives no boundary that surrounds the centre")
    for count in CURVE_COUNTS:
        for boundary in _subsamples(points, centre, count):
            yield "subsampled modified hull", count, boundary


def _subsamples(points: FloatArray, centre: FloatArray, triangles: int) -> Iterator[Boundary]:
    """Modified hulls of as many colours, drawn at random, as give the triangle count or just less.

    Not every drawn colour becomes a vertex, so the number to draw is searched for.
    """
    found = 0
    for seed in range(MOST_DRAWS):
        order = np.random.default_rng(seed).permutation(len(points))
        fewest, most, best = triangles // 2 + 2, len(points), None
        while fewest <= most and (best is None or best.mesh.triangles < triangles - 1):
            # most draws become vertices: look near the lower end first
            middle = min((fewest + most) // 2, 2 * fewest)
            try:
                hull = modified_convex_hull(points[order[:middle]], 0.2, centre)
            except (BoundaryError, InvalidPointsError):  # these do not surround the centre
                fewest = middle + 1
                continue
            if hull.mesh.triangles <= triangles:
                best, fewest = hull, middle + 1
            else:
                most = middle - 1
        if best is not None and best.mesh.triangles > 0.9 * triangles - 2:
            yield best
            found += 1
        if found == DRAWS:
            return


def main() -> None:
    """Print the other methods of each device, and decimation at the same triangle counts."""
    for device in asked_devices(__doc__):
        rows = [
            [
                row["method"],
                f"{row['size']:,}",
                f"{row['triangles']:,}",
                percent(row["mismatch"]),
                *(percent(row["decimated"][cost]) for cost in COSTS),
            ]
            for row in other_rows(device, device.histories, [])
        ]
        print(f"\n{device.name}, mismatch in per cent\n")
        head = ["method", "size", "triangles", "mismatch", *(f"{cost} there" for cost in COSTS)]
        print(table(head, rows), flush=True)


if __name__ == "__main__":
    main()
