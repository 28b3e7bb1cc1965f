"""Speed of the queries on one core, beside trimesh and Manifold: ``make bench-queries``.

The colours are random in twice the bounding box of FOGRA39L. Times are processor times of one
thread: the median of several runs, in which this package and the peer take turns.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial
from statistics import median
from typing import Any, NamedTuple

import numpy as np

import gamutcore
from benchmarks import markdown
from benchmarks.common import FOGRA39L, FloatArray, Rows
from gamutcore import Gamut
from gamutcore.mesh import TriangleMesh
from gamutcore.metric import intersection_volume
from gamutcore.queries import (
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

__all__ = ["main"]

SMALL = 1000
"""Triangles of the level that peers are compared on; the other level is the full boundary."""

ROUNDS = 5

BEHIND = 10.0
"""How far the peer's rays begin behind the first of two colours, so that they are lines."""


class Query(NamedTuple):
    """A query about rows of colours, the same by trimesh, and goals in million rows per second."""

    run: Callable[[FloatArray, LevelIndex], object]
    rows: int
    goals: tuple[float, float]
    peer: Callable[[Any, FloatArray], object] | None = None
    peer_rows: int = 0


QUERIES = {
    "in gamut": Query(
        contains,
        1_000_000,
        (20, 8),
        lambda mesh, points: mesh.ray.contains_points(points),
        100_000,
    ),
    "all crossings of a line": Query(
        lambda points, index: crossings(points, points[::-1], index, "line"),
        300_000,
        (5, 1),
        lambda mesh, points: mesh.ray.intersects_id(
            points + BEHIND * (points - points[::-1]), points[::-1] - points, multiple_hits=True
        ),
        100_000,
    ),
    "`clip-hue`": Query(
        lambda points, index: map_colours(points, index, "clip-hue"), 200_000, (2, 0.5)
    ),
    "`clip-focal`": Query(
        lambda points, index: map_colours(points, index, "clip-focal"), 200_000, (2, 0.5)
    ),
    "nearest point": Query(
        nearest, 300_000, (1, 0.4), lambda mesh, points: mesh.nearest.on_surface(points), 5000
    ),
    "signed distance": Query(
        signed_distance,
        300_000,
        (1, 0.4),
        lambda mesh, points: mesh.nearest.signed_distance(points),
        5000,
    ),
    "nearest by CIEDE2000": Query(nearest_ciede2000, 3000, (0.05, 0.02)),
}

HUES, LIGHTNESS = np.arange(360.0), np.arange(101.0)

LEVEL_QUERIES: dict[
    str, tuple[Callable[[LevelIndex, LevelIndex], object], tuple[float | None, float | None]]
] = {
    "360 cusps": (lambda one, _: cusp_points(HUES, one), (1, 20)),
    "a slice": (lambda one, _: slice_polygons(one, (1.0, 0.0, 0.0), 50.0), (0.5, 5)),
    "360 × 101 leaves": (lambda one, _: leaves(one, HUES, LIGHTNESS), (20, 500)),
    "gamut rings": (lambda one, _: gamut_rings(one), (None, None)),
    "comparison with sRGB": (compare, (20, 1500)),
}
"""Queries about one level or two, and goals in milliseconds."""


def main() -> None:
    """Measure all queries, and write the tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.queries", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a hundredth of the rows, not written")
    quick = parser.parse_args().quick
    gamuts = (Gamut(FOGRA39L), gamutcore.reference("sRGB"))
    levels = [[_level(gamut, count) for gamut in gamuts] for count in (SMALL, None)]
    tables = {
        "queries": colour_queries(levels[0][0], levels[1][0], 100 if quick else 1),
        "level-queries": level_queries(levels),
    }
    if quick:
        print(*map(markdown.rows_table, tables.values()), sep="\n\n")
    else:
        markdown.record(tables)


Level = tuple[TriangleMesh, LevelIndex, Callable[[], LevelIndex]]
"""A mesh, its index, and the function that builds the index."""


def _level(gamut: Gamut, triangles: int | None) -> Level:
    mesh = gamut.level(triangles or gamut.history.triangles)
    build = partial(build_index, mesh.vertices, mesh.faces, gamut.history.centre)
    return mesh, build(), build


def colour_queries(small: Level, full: Level, part: int) -> Rows:
    """Time queries about colours on two levels, and by trimesh on the small one."""
    low, high = full[0].bounds
    middle, half = (low + high) / 2, high - low
    points = np.random.default_rng(0).uniform(middle - half, middle + half, (1_000_000, 3))
    rows = []
    for title, query in QUERIES.items():
        count, peer_count = query.rows // part, query.peer_rows // part
        runs: list[Callable[[], object]] = [
            partial(query.run, points[:count], index) for _, index, _ in (small, full)
        ]
        if query.peer is not None:
            runs.append(partial(query.peer, small[0].to_trimesh(), points[:peer_count]))
        times = alternated(runs)
        rows.append(
            {
                "query": title,
                f"{SMALL:,} triangles, million/s": 1e-6 * count / times[0],
                f"goal at {SMALL:,}": query.goals[0],
                "full boundary, million/s": 1e-6 * count / times[1],
                "goal, full": query.goals[1],
                f"trimesh at {SMALL:,}, million/s": (
                    1e-6 * peer_count / times[2] if query.peer else None
                ),
            }
        )
    return rows


def level_queries(levels: list[list[Level]]) -> Rows:
    """Time queries about whole levels, the comparison by Manifold, and building the index."""
    rows: Rows = []
    for title, (run, goals) in LEVEL_QUERIES.items():
        row: dict[str, Any] = {"query": title}
        for (one, other), goal, name in zip(
            levels, goals, (f"{SMALL:,} triangles", "full boundary"), strict=True
        ):
            runs: list[Callable[[], object]] = [partial(run, one[1], other[1])]
            if run is compare:
                runs.append(partial(intersection_volume, one[0], other[0]))
            times = alternated(runs)
            row[f"{name}, ms"] = 1e3 * times[0]
            row[f"goal, {name}"] = goal
            row[f"manifold3d, {name}, ms"] = 1e3 * times[1] if len(times) > 1 else None
        rows.append(row)
    builds = [1e3 * alternated([one[2]])[0] for one, _ in levels]
    return [
        *rows,
        {
            "query": "the index, once for a level",
            f"{SMALL:,} triangles, ms": builds[0],
            "full boundary, ms": builds[1],
        },
    ]


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


if __name__ == "__main__":
    main()
