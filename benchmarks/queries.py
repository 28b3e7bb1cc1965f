"""Speed of the queries on one core, beside trimesh with Embree: ``make bench-queries``.

The colours are random in twice the bounding box of FOGRA39L. Times are processor times of one
thread: the median of several runs, in which this package and the peer take turns. Figures go to
``benchmarks/queries.json`` and into ``docs/benchmarks.md``.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from benchmarks import markdown
from benchmarks.bench import DOCUMENT
from benchmarks.common import FOGRA39L, FloatArray
from gamutcore import Gamut
from gamutcore.metric.error_curve import error_curve
from gamutcore.queries import (
    LevelIndex,
    build_index,
    contains,
    crossings,
    map_colours,
    nearest,
    nearest_ciede2000,
    signed_distance,
)

__all__ = ["COUNTS", "QUERIES", "RESULTS", "SMALL", "alternated", "document_blocks", "main"]

RESULTS = Path(__file__).with_suffix(".json")

SMALL = 1000
"""Triangles of the level that the peer is compared on."""

COUNTS = (4, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000)
"""Triangles of the levels that show how the cost falls; the full boundary comes last."""

ROUNDS = 5

BEHIND = 10.0
"""How far the peer's rays begin behind the first of two colours, so that they are lines."""


class Query(NamedTuple):
    """A query that is timed.

    Attributes
    ----------
    title : str
    run : callable
        Answers rows of colours on an index.
    rows : int
    peer : callable or None
        Answers rows on a `trimesh.Trimesh`.
    peer_rows : int
    goals : tuple of float
        Rows per second on 1,000 triangles and on the full boundary.
    """

    title: str
    run: Callable[[FloatArray, LevelIndex], object]
    rows: int
    peer: Callable[[Any, FloatArray], object] | None
    peer_rows: int
    goals: tuple[float, float]


QUERIES = {
    "contains": Query(
        "in gamut",
        contains,
        1_000_000,
        lambda mesh, points: mesh.ray.contains_points(points),
        100_000,
        (20e6, 8e6),
    ),
    "crossings": Query(
        "all crossings of a line",
        lambda points, index: crossings(points, points[::-1], index, "line"),
        300_000,
        lambda mesh, points: mesh.ray.intersects_id(
            points + BEHIND * (points - points[::-1]), points[::-1] - points, multiple_hits=True
        ),
        100_000,
        (5e6, 1e6),
    ),
    "clip_hue": Query(
        "`clip-hue`",
        lambda points, index: map_colours(points, index, "clip-hue"),
        200_000,
        None,
        0,
        (2e6, 0.5e6),
    ),
    "clip_focal": Query(
        "`clip-focal`",
        lambda points, index: map_colours(points, index, "clip-focal"),
        200_000,
        None,
        0,
        (2e6, 0.5e6),
    ),
    "nearest": Query(
        "nearest point",
        nearest,
        300_000,
        lambda mesh, points: mesh.nearest.on_surface(points),
        5000,
        (1e6, 0.4e6),
    ),
    "signed_distance": Query(
        "signed distance",
        signed_distance,
        300_000,
        lambda mesh, points: mesh.nearest.signed_distance(points),
        5000,
        (1e6, 0.4e6),
    ),
    "nearest_ciede2000": Query(
        "nearest by CIEDE2000", nearest_ciede2000, 3000, None, 0, (0.05e6, 0.02e6)
    ),
}


def main() -> None:
    """Measure all queries, and write the figures and the tables."""
    gamut = Gamut(FOGRA39L)
    counts = [*COUNTS, gamut.history.triangles]
    errors = error_curve(gamut.history, counts)
    results = {
        "levels": [
            {**_level_row(gamut, count), "error": error.to_mapping()["distance_bound"]}
            for count, error in zip(counts, errors, strict=True)
        ]
    }
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")
    blocks = document_blocks(results)
    print("\n\n".join(blocks.values()))
    markdown.update_document(DOCUMENT, blocks)


def document_blocks(results: dict[str, Any]) -> dict[str, str]:
    """Return the generated blocks of the document.

    Parameters
    ----------
    results : dict
        As in the file of results.
    """
    levels = results["levels"]
    small, full = next(row for row in levels if row["triangles"] == SMALL), levels[-1]
    shown = {name: query for name, query in QUERIES.items() if name in small["queries"]}
    speeds = []
    for name, query in shown.items():
        peer = small["peers"].get(name)
        speeds.append(
            [
                query.title,
                f"{small['queries'][name] / 1e6:.3g}",
                f"{query.goals[0] / 1e6:g}",
                f"{full['queries'][name] / 1e6:.3g}",
                f"{query.goals[1] / 1e6:g}",
                "–" if peer is None else f"{peer / 1e6:.2g}",
            ]
        )
    head = ["query", f"{SMALL:,} triangles, million/s", "goal", "full boundary, million/s"]
    head += ["goal", f"trimesh at {SMALL:,}, million/s"]
    index_head = ["triangles", "build, ms", "memory, MB"]
    index_rows = [
        [f"{row['triangles']:,}", f"{row['build_ms']:.2g}", f"{row['bytes'] / 1e6:.2g}"]
        for row in (small, full)
    ]
    level_head = [
        "triangles",
        "error, ΔE",
        *(f"{query.title}, million/s" for query in shown.values()),
    ]
    level_rows = [
        [
            f"{row['triangles']:,}",
            f"{row['error']:.2g}",
            *(f"{row['queries'][name] / 1e6:.3g}" for name in shown),
        ]
        for row in levels
    ]
    return {
        "queries": markdown.table(head, speeds),
        "query-index": markdown.table(index_head, index_rows),
        "query-levels": markdown.table(level_head, level_rows),
    }


def _level_row(gamut: Gamut, triangles: int) -> dict[str, Any]:
    """Time all queries on a level."""
    mesh, centre = gamut.level(triangles), gamut.history.centre
    index = build_index(mesh.vertices, mesh.faces, centre)
    low, high = gamut.history.full().bounds
    middle, half = (low + high) / 2, high - low
    random = np.random.default_rng(0)
    points = random.uniform(middle - half, middle + half, (1_000_000, 3))
    speeds, peers = {}, {}
    for name, query in QUERIES.items():
        runs: list[Callable[[], object]] = [partial(query.run, points[: query.rows], index)]
        if query.peer is not None and triangles == SMALL:
            runs.append(partial(query.peer, mesh.to_trimesh(), points[: query.peer_rows]))
        times = alternated(runs)
        speeds[name] = query.rows / times[0]
        if len(times) > 1:
            peers[name] = query.peer_rows / times[1]
    build = alternated([lambda: build_index(mesh.vertices, mesh.faces, centre)])[0]
    return {
        "triangles": mesh.triangles,
        "build_ms": 1e3 * build,
        "bytes": index.nbytes,
        "queries": speeds,
        "peers": peers,
    }


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
