"""Speed of the queries about whole levels on one core: ``make bench-queries``.

Cusps, slices, leaves and rings of FOGRA39L, and its comparison with sRGB, beside the booleans of
Manifold. Times are processor times as in `benchmarks.queries`. Figures go to
``benchmarks/level_queries.json`` and into ``docs/benchmarks.md``.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import gamutcore
from benchmarks import markdown
from benchmarks.bench import DOCUMENT
from benchmarks.common import FOGRA39L
from benchmarks.queries import COUNTS, SMALL, alternated
from gamutcore import Gamut
from gamutcore.mesh import TriangleMesh
from gamutcore.metric import intersection_volume
from gamutcore.queries import (
    LevelIndex,
    build_index,
    compare,
    cusp_points,
    gamut_rings,
    leaves,
    slice_polygons,
)

__all__ = ["LEVEL_QUERIES", "RESULTS", "document_blocks", "main"]

RESULTS = Path(__file__).with_suffix(".json")

HUES, LIGHTNESS = np.arange(360.0), np.arange(101.0)


class LevelQuery(NamedTuple):
    """A query about a level, or about two, that is timed.

    Attributes
    ----------
    title : str
    run : callable
        Answers on the indexes of a level and of another gamut's level.
    goals : tuple of float, or None
        Milliseconds on 1,000 triangles and on the full boundary.
    """

    title: str
    run: Callable[[LevelIndex, LevelIndex], object]
    goals: tuple[float, float] | None


LEVEL_QUERIES = {
    "cusps": LevelQuery("360 cusps", lambda one, _: cusp_points(HUES, one), (1.0, 20.0)),
    "slice": LevelQuery(
        "a slice", lambda one, _: slice_polygons(one, (1.0, 0.0, 0.0), 50.0), (0.5, 5.0)
    ),
    "leaves": LevelQuery(
        "360 × 101 leaves", lambda one, _: leaves(one, HUES, LIGHTNESS), (20.0, 500.0)
    ),
    "rings": LevelQuery("gamut rings", lambda one, _: gamut_rings(one), None),
    "comparison": LevelQuery("comparison with sRGB", compare, (20.0, 1500.0)),
}


def main() -> None:
    """Measure all queries, and write the figures and the table."""
    press, display = Gamut(FOGRA39L), gamutcore.reference("sRGB")
    rows = [_row(press, display, count) for count in (*COUNTS, press.history.triangles)]
    RESULTS.write_text(json.dumps({"levels": rows}, indent=2) + "\n")
    blocks = document_blocks({"levels": rows})
    print("\n\n".join(blocks.values()))
    markdown.update_document(DOCUMENT, blocks)


def document_blocks(results: dict[str, Any]) -> dict[str, str]:
    """Return the generated block of the document.

    Parameters
    ----------
    results : dict
        As in the file of results.
    """
    levels = results["levels"]
    small, full = next(row for row in levels if row["triangles"] == SMALL), levels[-1]
    rows = []
    for name, query in LEVEL_QUERIES.items():
        cells = [query.title]
        for place, level in enumerate((small, full)):
            peer = level["manifold3d_ms"] if name == "comparison" else None
            cells += [
                _figure(level["ms"][name]),
                "–" if query.goals is None else f"{query.goals[place]:g}",
                "–" if peer is None else _figure(peer),
            ]
        rows.append(cells)
    head = ["query"]
    for which in (f"{SMALL:,} triangles", "full boundary"):
        head += [f"{which}, ms", "goal", "manifold3d"]
    costs_head = ["triangles", *(f"{query.title}, ms" for query in LEVEL_QUERIES.values())]
    costs = [
        [f"{row['triangles']:,}", *(_figure(row["ms"][name]) for name in LEVEL_QUERIES)]
        for row in levels
    ]
    return {
        "level-queries": markdown.table(head, rows),
        "level-query-costs": markdown.table(costs_head, costs),
    }


def _figure(milliseconds: float) -> str:
    """Return a time with two digits, or as a whole number."""
    return f"{milliseconds:,.0f}" if milliseconds >= 10.0 else f"{milliseconds:.2g}"


def _row(press: Gamut, display: Gamut, triangles: int) -> dict[str, Any]:
    """Time all queries on a level of each gamut."""
    full = triangles == press.history.triangles
    one, index = _level(press, triangles)
    other, other_index = _level(display, display.history.triangles if full else triangles)
    runs: list[Callable[[], object]] = [
        partial(query.run, index, other_index) for query in LEVEL_QUERIES.values()
    ]
    times = alternated([*runs, partial(intersection_volume, one, other)])
    names = list(LEVEL_QUERIES)
    return {
        "triangles": one.triangles,
        "other_triangles": other.triangles,
        "ms": {name: 1e3 * seconds for name, seconds in zip(names, times[:-1], strict=True)},
        "manifold3d_ms": 1e3 * times[-1],
    }


def _level(gamut: Gamut, triangles: int) -> tuple[TriangleMesh, LevelIndex]:
    mesh = gamut.level(triangles)
    return mesh, build_index(mesh.vertices, mesh.faces, gamut.history.centre)


if __name__ == "__main__":
    main()
