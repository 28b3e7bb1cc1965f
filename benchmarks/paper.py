"""The published experiment on real devices, with exact mismatches.

Bakke and Farup ("Simplified Gamut Boundary Representation using Mesh Decimation") compare
simplified boundaries at equal triangle counts. Their reference is the modified convex hull of about
100,000 surface colours. The methods are decimation, uniform segment visualization (USV), segment
maxima, the convex hull, and the modified hull of a subsample. Each of the other methods determines
its own triangle count, and decimation is read at that count.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from benchmarks.common import FloatArray, build_mesh_history
from benchmarks.devices import Device, exact_mismatch, sphere
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.boundary.segment_maxima import segment_maxima
from gamutcore.boundary.usv import BASES, usv
from gamutcore.decimation import COSTS
from gamutcore.errors import BoundaryError, InvalidPointsError
from gamutcore.history import History
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
"""Least mismatch × triangles on a sphere for many triangles: constants of Ludwig and Böröczky."""

USV_GAMMA = 0.05
"""γ of the modified hull inside USV, as published."""

LARGEST = 12_000
"""Largest triangle count of the other methods."""

SEGMENTS = (3, 4, 5, 7, 9, 11, 16, 22, 35, 50)
"""Polar segments of segment maxima, with twice as many azimuth segments."""

DRAWS = 3
"""Subsamples for each triangle count."""

MOST_DRAWS = 60
"""Attempts at a subsample. A few colours often do not surround the centre."""

Rows = list[dict[str, Any]]


def other_rows(device: Device, histories: dict[str, History]) -> Rows:
    """Measure the other methods, and decimation at their triangle counts.

    Returns
    -------
    list of dict
        ``method``, ``size`` (segments, or triangles asked for), ``triangles``, ``mismatch``,
        ``volume`` (relative to the reference, minus 1), and ``decimated``: the mismatch at the same
        count by cost.
    """
    reference, centre = device.boundary.mesh, device.boundary.centre

    @functools.cache
    def decimation_errors(count: int) -> dict[str, float | None]:
        return {
            cost: exact_mismatch(reference, history.level(count), centre)
            for cost, history in histories.items()
        }

    return [
        {
            "device": device.name,
            "method": method,
            "size": size,
            "triangles": boundary.mesh.triangles,
            "mismatch": exact_mismatch(reference, boundary.mesh, centre),
            "volume": boundary.mesh.volume / reference.volume - 1,
            "decimated": decimation_errors(boundary.mesh.triangles),
        }
        for method, size, boundary in _boundaries(device)
    ]


def floor_row(device: Device) -> dict[str, Any]:
    """Measure the modified hull of all colours with the γ of USV, the limit for USV."""
    reference, centre = device.boundary.mesh, device.boundary.centre
    mesh = modified_convex_hull(device.points, USV_GAMMA, centre).mesh
    return {
        "device": device.name,
        "gamma": USV_GAMMA,
        "triangles": mesh.triangles,
        "mismatch": exact_mismatch(reference, mesh, centre),
        "volume": mesh.volume / reference.volume - 1,
    }


def voxel_rows(device: Device, history: History) -> Rows:
    """Measure levels in voxels as published, beside the exact mismatch."""
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


def sphere_rows() -> Rows:
    """Measure mismatch × triangles on spheres of 10,000 vertices, where the optimum is known."""
    rows = []
    for spread in ("spiral", "random"):
        mesh = sphere(10_000, random=spread == "random")
        for cost in COSTS:
            history = build_mesh_history(mesh, np.array([50.0, 0.0, 0.0]), cost)
            for count in (2000, 1000, 500, 200, 100):
                level = history.level(count)
                product = mismatch(mesh, level) * count
                rows.append({"points": spread, "cost": cost, "asked": count, "product": product})
    return rows


def subsampled(points: FloatArray, centre: FloatArray, triangles: int) -> Boundary:
    """Return the modified hull of a random subsample with that many triangles or slightly fewer."""
    return next(_subsamples(points, centre, triangles))


def _boundaries(device: Device) -> Iterator[tuple[str, int, Boundary]]:
    """Iterate over the boundaries of the other methods: method, size, boundary."""
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
            print(f"{method}, size {size}: no boundary, the colours do not surround the centre")
    for count in CURVE_COUNTS:
        for boundary in _subsamples(points, centre, count):
            yield "subsampled modified hull", count, boundary


def _subsamples(points: FloatArray, centre: FloatArray, triangles: int) -> Iterator[Boundary]:
    """Iterate over modified hulls of random subsamples with at most that many triangles.

    Some colours do not become vertices, so the size of the subsample is found by bisection.
    """
    found = 0
    for seed in range(MOST_DRAWS):
        order = np.random.default_rng(seed).permutation(len(points))
        fewest, most, best = triangles // 2 + 2, len(points), None
        while fewest <= most and (best is None or best.mesh.triangles < triangles - 1):
            # Most colours become vertices, so the size is near the lower end.
            middle = min((fewest + most) // 2, 2 * fewest)
            try:
                hull = modified_convex_hull(points[order[:middle]], 0.2, centre)
            except (BoundaryError, InvalidPointsError):  # the colours do not surround the centre
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
