"""The blocks of ``docs/benchmarks.md``: each table of ``benchmarks/results.json``, and a summary.

The summary has the rows in which another program did the same work in the same run. It reads the
committed results of all benchmarks.
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from statistics import median
from typing import Any

from benchmarks import accuracy, decimation_tables
from benchmarks.common import DOCUMENT, RESULTS, Rows
from benchmarks.markdown import rows_table, store

DATES = "dates"
"""Key of results that has the day of each table."""

COUNT = 1000

Figures = dict[str, Any]


def document_blocks(results: Mapping[str, Any]) -> dict[str, str]:
    """Return the generated blocks of docs/benchmarks.md."""
    blocks = {name: rows_table(rows) for name, rows in results.items() if name != DATES}
    return {"summary": rows_table(summary(results)), **blocks}


def record(tables: Mapping[str, Rows]) -> None:
    """Replace tables in ``benchmarks/results.json`` and in docs/benchmarks.md."""
    results = json.loads(RESULTS.read_text())
    dates = results[DATES] | dict.fromkeys(tables, time.strftime("%Y-%m-%d"))
    results |= {**tables, DATES: dates}
    store(results, RESULTS, DOCUMENT, document_blocks(results))


def summary(results: Mapping[str, Any]) -> Rows:
    """Return what users do, with our figure and that of the best other program."""
    dates = results[DATES]

    def row(
        task: str, unit: str, ours: float, peer: float, name: str, table: str
    ) -> dict[str, Any]:
        return {
            "task": task,
            "unit": unit,
            "ours": ours,
            "best other": peer,
            "program": name,
            "date": dates[table],
        }

    def pick(table: str, column: str, value: str, **more: str) -> Figures:
        wanted = {column: value, **more}
        return next(
            each
            for each in results[table]
            if all(each[name] == content for name, content in wanted.items())
        )

    queries = "1,000 triangles, million/s", "trimesh at 1,000, million/s"
    contains, nearest, crossings = (
        [pick("queries", "query", name)[column] for column in queries]
        for name in ("in gamut", "nearest point", "all crossings of a line")
    )
    overlap = pick("level-queries", "query", "comparison with sRGB")
    mesh = results["plain-fastapi"][0]
    recipe = pick("recipes", "device", "FOGRA39L, fit", black="medium")
    profile, colprof = (
        pick("profiles", "press", "FOGRA39L", program=name) for name in ("gamut profile", "colprof")
    )
    links = [each for each in results["links"] if each["link"] == "sRGB to Display P3"]
    link = next(each for each in links if each["program"] == "gamut link")
    best = min((each for each in links if each is not link), key=lambda each: each["mean"])
    return [
        volume_row(),
        level_row(),
        row("`contains`", "million/s", contains[0], contains[1], "trimesh, Embree", "queries"),
        row("`nearest`", "million/s", nearest[0], nearest[1], "trimesh", "queries"),
        row(
            "all crossings of a line",
            "million/s",
            crossings[0],
            crossings[1],
            "trimesh, Embree",
            "queries",
        ),
        row(
            "comparison with sRGB",
            "ms",
            overlap["1,000 triangles, ms"],
            overlap["manifold3d, 1,000 triangles, ms"],
            "manifold3d, intersection only",
            "level-queries",
        ),
        row(
            "comparison, full boundary",
            "ms",
            overlap["full boundary, ms"],
            overlap["manifold3d, full boundary, ms"],
            "manifold3d, intersection only",
            "level-queries",
        ),
        row("mesh over HTTP", "ratio of rates", mesh["ratio"], 1, "plain FastAPI", "plain-fastapi"),
        row(
            "recipe of a colour, FOGRA39L",
            "µs",
            recipe["µs per colour"],
            recipe["xicclu, µs"],
            "Argyll, xicclu",
            "recipes",
        ),
        row("profile of FOGRA39L", "s", profile["s"], colprof["s"], "Argyll, colprof", "profiles"),
        row(
            "link, sRGB to Display P3",
            "mean ΔE00",
            link["mean"],
            best["mean"],
            best["program"],
            "links",
        ),
    ]


def volume_row() -> Figures:
    """Return the errors of volumes, over the devices that the best other program measures."""
    results = json.loads(accuracy.RESULTS.read_text())

    def error(volumes: list[tuple[float, float]]) -> float:
        return median(100 * abs(volume / dense - 1) for volume, dense in volumes)

    others = {}
    for program in accuracy.SOLIDS:
        rows = [row for row in results["devices"] if program in row["volumes"]]
        pairs = [(row["volumes"][program], row["dense"]) for row in rows]
        # manifold3d and iccDEV are given the faces of the dense integral itself
        if program in ("Argyll", "cielab-gamut-tools"):
            ours = error([(row["ours"], row["dense"]) for row in rows])
            others[program] = (ours, error(pairs), len(rows))
    program, (ours, theirs, count) = min(others.items(), key=lambda item: (-item[1][2], item[1][1]))
    return {
        "task": f"volume, devices: {count}",
        "unit": "median error, %",
        "ours": ours,
        "best other": theirs,
        "program": program,
        "date": results["machine"][0]["date"],
    }


def level_row() -> Figures:
    """Return the mean error of levels of 1,000 triangles by the default cost."""
    results = json.loads(decimation_tables.RESULTS.read_text())
    methods = dict.fromkeys(row["method"] for row in results["peers"])
    errors = {
        method: decimation_tables.mean_errors(results, method, [COUNT])[0] for method in methods
    }
    error, method = min((error, name) for name, error in errors.items() if error is not None)
    return {
        "task": f"level of {COUNT:,} triangles, nine devices",
        "unit": "mean error, %",
        "ours": decimation_tables.mean_errors(results, "volume", [COUNT])[0],
        "best other": error,
        "program": method,
        "date": results["machine"]["date"],
    }
