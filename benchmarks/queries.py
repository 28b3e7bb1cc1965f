"""Speed of the queries on one core, beside trimesh and Manifold: ``make bench-queries``.

The colours are random in twice the bounding box of FOGRA39L. Times are processor times of one
thread: the median of several runs, in which this package and the peer take turns.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache, partial
from statistics import median
from typing import Any, NamedTuple

import numpy as np

import gamutcore
from benchmarks.booleans import intersection_volume
from benchmarks.common import FOGRA39L, FloatArray, Rows
from gamutcore import Gamut
from gamutcore.geometry import TriangleMesh
from gamutcore.search import (
    LevelIndex,
    build_index,
    compare,
    contains,
    crossings,
    cusp_points,
    gamut_rings,
    leaves,
    map_colours,
    nearest,
    nearest_ciede2000,
    signed_distance,
    slice_polygons,
)

ROUNDS = 5


class Query(NamedTuple):
    """A query about rows of colours, goals in million rows per second, and the same by trimesh."""

    run: Callable[[FloatArray, LevelIndex], object]
    rows: int
    goals: tuple[float, float]
    peer: Callable[[Any, FloatArray], object] | None = None
    peer_rows: int = 0


def lines_by_trimesh(mesh: Any, points: FloatArray) -> object:  # noqa: ANN401  # untyped
    """Cross a mesh with lines through pairs of points: rays that begin far behind the first."""
    along = points[::-1] - points
    return mesh.ray.intersects_id(points - 10 * along, along, multiple_hits=True)


QUERIES = {
    "in gamut": Query(
        contains, 1_000_000, (20, 8), lambda mesh, points: mesh.ray.contains_points(points), 100_000
    ),
    "all crossings of a line": Query(
        lambda points, index: crossings(points, points[::-1], index, "line"),
        300_000,
        (5, 1),
        lines_by_trimesh,
        100_000,
    ),
    "`clip-hue`": Query(partial(map_colours, method="clip-hue"), 200_000, (2, 0.5)),
    "`clip-focal`": Query(partial(map_colours, method="clip-focal"), 200_000, (2, 0.5)),
    "nearest point": Query(
        nearest, 300_000, (1, 0.4), lambda mesh, points: mesh.nearest.on_surface(points), 5000
    ),
    "signed distance": Query(signed_distance, 300_000, (1, 0.4)),
    "nearest by CIEDE2000": Query(nearest_ciede2000, 3000, (0.05, 0.02)),
}

LEVEL_QUERIES: dict[
    str, tuple[Callable[[LevelIndex, LevelIndex], object], float | None, float | None]
] = {
    "360 cusps": (lambda one, _: cusp_points(np.arange(360.0), one), 1, 20),
    "a slice": (lambda one, _: slice_polygons(one, (1.0, 0.0, 0.0), 50.0), 0.5, 5),
    "360 × 101 leaves": (lambda one, _: leaves(one, np.arange(360.0), np.arange(101.0)), 20, 500),
    "gamut rings": (lambda one, _: gamut_rings(one), None, None),
    "comparison with sRGB": (compare, 20, 1500),
}
"""Queries about one level or two, and goals in milliseconds."""


class Level(NamedTuple):
    """Levels of FOGRA39L and of sRGB, and their indices."""

    meshes: list[TriangleMesh]
    indices: list[LevelIndex]
    build: Callable[[], LevelIndex]


@cache
def levels() -> dict[str, Level]:
    """Return a small level, on which peers are compared, and the full boundary."""
    gamuts = (Gamut(FOGRA39L), gamutcore.reference("sRGB"))
    found = {}
    for name, triangles in (("1,000 triangles", 1000), ("full boundary", None)):
        meshes = [gamut.level(triangles or gamut.history.triangles) for gamut in gamuts]
        builds = [
            partial(build_index, mesh.vertices, mesh.faces, gamut.history.centre)
            for mesh, gamut in zip(meshes, gamuts, strict=True)
        ]
        found[name] = Level(meshes, [build() for build in builds], builds[0])
    return found


def colour_queries(quick: bool) -> Rows:
    """Time queries about colours on two levels, and by trimesh on the small one."""
    small, full = levels().values()
    low, high = full.meshes[0].bounds
    middle, half = (low + high) / 2, high - low
    points = np.random.default_rng(0).uniform(middle - half, middle + half, (1_000_000, 3))
    rows = []
    for title, query in QUERIES.items():
        part = 100 if quick else 1
        count, peer_count = query.rows // part, query.peer_rows // part
        runs: list[Callable[[], object]] = [
            partial(query.run, points[:count], level.indices[0]) for level in (small, full)
        ]
        if query.peer is not None:
            runs.append(partial(query.peer, small.meshes[0].to_trimesh(), points[:peer_count]))
        times = alternated(runs)
        rows.append(
            {
                "query": title,
                "1,000 triangles, million/s": 1e-6 * count / times[0],
                "goal at 1,000": query.goals[0],
                "full boundary, million/s": 1e-6 * count / times[1],
                "goal, full": query.goals[1],
                "trimesh at 1,000, million/s": 1e-6 * peer_count / times[2] if query.peer else None,
            }
        )
    return rows


def level_queries(_quick: bool) -> Rows:
    """Time queries about whole levels, the comparison by Manifold, and building the index."""
    rows: Rows = [{"query": title} for title in (*LEVEL_QUERIES, "the index, once for a level")]
    for name, level in levels().items():
        for (run, *goals), row in zip(LEVEL_QUERIES.values(), rows, strict=False):
            runs: list[Callable[[], object]] = [partial(run, *level.indices)]
            if run is compare:
                runs.append(partial(intersection_volume, *level.meshes))
            times = [1e3 * seconds for seconds in alternated(runs)]
            row[f"{name}, ms"] = times[0]
            row[f"goal, {name}"] = goals[name == "full boundary"]
            row[f"manifold3d, {name}, ms"] = times[1] if run is compare else None
        rows[-1][f"{name}, ms"] = 1e3 * alternated([level.build])[0]
    return rows


def alternated(runs: list[Callable[[], object]]) -> list[float]:
    """Return the median processor time of each function, which take turns.

    Only this thread counts: threads of the peer's linear algebra spin after they have finished.
    """
    times: list[list[float]] = [[] for _ in runs]
    for run in runs:
        run()  # compiles
    for _ in range(ROUNDS):
        for run, found in zip(runs, times, strict=True):
            start = time.thread_time()
            run()
            found.append(time.thread_time() - start)
    return [median(found) for found in times]
