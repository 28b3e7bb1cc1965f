"""Estimate the machines that a load needs from measured figures: ``make scaling``.

Reads ``benchmarks/results.json`` (requests and builds), ``benchmarks/gamuts.json`` (sizes and
opening times of gamuts) and ``benchmarks/cluster.json`` (a cluster on one machine, written by
``tests/faults/cluster.py``). Updates the tables of ``docs/scaling.md``. With another load on the
command line the tables are printed and the document stays as it is. ``--measure`` renews
``gamuts.json`` first.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import dataclass, fields
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np

from benchmarks.markdown import count_text, table, update_document
from service.settings import Settings

__all__ = ["Load", "Measured", "document_blocks", "hit_ratio", "read_results", "update"]

FOLDER = Path(__file__).parent
DOCUMENT = FOLDER.parent / "docs" / "scaling.md"
GAMUTS = FOLDER / "gamuts.json"

DAY_SECONDS = 86_400.0
CDN_HIT_RATIOS = (0.0, 0.9, 0.99, 0.999)
HISTORY_CACHE_GIB = (0.5, 2, 8, 32)
LOAD_TEXTS = {
    "gamuts": "stored gamuts",
    "requests": "mesh requests per second, at the CDN",
    "levels": "different meshes per gamut (triangle counts and formats)",
    "exponent": "exponent s of the popularity: the i-th gamut gets requests in proportion to 1/i^s",
    "days": "days in which all gamuts are built",
    "utilisation": "mean utilisation of a core",
}


@dataclass(frozen=True)
class Load:
    """The assumed load. `LOAD_TEXTS` describes the fields."""

    gamuts: int = 1_000_000
    requests: float = 100_000.0
    levels: int = 20
    exponent: float = 1.0
    days: float = 30.0
    utilisation: float = 0.6


@dataclass(frozen=True)
class Measured:
    """Measured figures of one core and of one gamut.

    Attributes
    ----------
    repeated, encoded : float
        Meshes per second of one API process: from the mesh cache, and encoded from an open history.
    answer_bytes : float
        Bytes of a 200 answer with a mesh of 1,000 triangles, header fields included.
    opening_seconds : float
        Time from the bytes of a history to a level of 1,000 triangles, digest check included.
    history_bytes, record_bytes, input_bytes, open_bytes : float
        Mean over the inputs: history file, description, input file, and open history in memory.
    build_seconds : float
        Mean time from a POST to the gamut, with one worker on one core.
    """

    repeated: float
    encoded: float
    answer_bytes: float
    opening_seconds: float
    history_bytes: float
    record_bytes: float
    input_bytes: float
    open_bytes: float
    build_seconds: float

    @classmethod
    def from_results(cls, results: dict[str, Any], gamuts: list[dict[str, Any]]) -> Measured:
        """Return the figures from the content of results.json and gamuts.json."""
        rates = {row["request"]: row for row in results["meshes"]}
        repeated, encoded = rates["repeated, 1000 triangles"], rates["uncached, 500 counts in turn"]
        return cls(
            repeated=repeated["requests_per_s"],
            encoded=encoded["requests_per_s"],
            answer_bytes=repeated["bytes_per_answer"],
            opening_seconds=mean(row["opening_s"] for row in gamuts),
            history_bytes=mean(row["history_bytes"] for row in gamuts),
            record_bytes=mean(row["record_bytes"] for row in gamuts),
            input_bytes=mean(row["input_bytes"] for row in gamuts),
            open_bytes=mean(row["open_bytes"] for row in gamuts),
            build_seconds=mean(row["http_s"] for row in results["inputs"]),
        )

    def seconds_per_request(self, mesh_hits: float, history_hits: float) -> float:
        """Mean processor time of a request for the hit ratios of the mesh and history caches."""
        miss = 1 / self.encoded + (1 - history_hits) * self.opening_seconds
        return mesh_hits / self.repeated + (1 - mesh_hits) * miss


def hit_ratio(objects: int, exponent: float, capacity: float) -> float:
    """Hit ratio of a least-recently-used cache under independent Zipf requests.

    Parameters
    ----------
    objects : int
        Number of objects. Object i is requested in proportion to 1/i^exponent.
    exponent : float
        0 for uniform popularity.
    capacity : float
        Number of objects that fit into the cache.

    Returns
    -------
    float
        0 to 1.

    References
    ----------
    H. Che, Y. Tung, Z. Wang, "Hierarchical Web caching systems: modeling, design and experimental
    results", IEEE JSAC 20 (7), 2002.

    Examples
    --------
    >>> round(hit_ratio(10_000, 0.0, 1000), 3)
    0.1
    """
    if capacity >= objects:
        return 1.0
    if capacity <= 0:
        return 0.0
    # Popularity hardly changes between neighbours of the tail, so groups share one weight.
    edges = np.unique(np.geomspace(1, objects + 1, 20_000).astype(np.int64))
    counts = np.diff(edges)
    weights = ((edges[:-1] + edges[1:] - 1) / 2.0) ** -exponent
    weights /= (weights * counts).sum()
    low, high = 0.0, 1.0
    while (counts * -np.expm1(-weights * high)).sum() < capacity:
        high *= 2.0
    for _ in range(100):
        middle = (low + high) / 2
        inside = (counts * -np.expm1(-weights * middle)).sum()
        low, high = (middle, high) if inside < capacity else (low, middle)
    return float((counts * weights * -np.expm1(-weights * low)).sum())


def document_blocks(
    results: dict[str, Any], gamuts: list[dict[str, Any]], cluster: dict[str, Any], load: Load
) -> dict[str, str]:
    """Return the generated blocks of docs/scaling.md."""
    one = Measured.from_results(results, gamuts)
    settings = Settings.model_construct()
    used = f"{load.utilisation:g}"

    meshes = settings.mesh_cache_bytes / one.answer_bytes
    histories = settings.history_cache_bytes / one.open_bytes
    # All levels of a gamut are equally popular, so a gamut occupies `levels` entries.
    mesh_hits = hit_ratio(load.gamuts, load.exponent, meshes / load.levels)
    history_hits = hit_ratio(load.gamuts, load.exponent, histories)
    cached = one.seconds_per_request(1.0, 1.0)
    usual = one.seconds_per_request(mesh_hits, history_hits)
    cold = one.seconds_per_request(0.0, 0.0)

    origin = []
    for ratio in CDN_HIT_RATIOS:
        rate = load.requests * (1 - ratio)
        cores = [math.ceil(rate * seconds / load.utilisation) for seconds in (cached, usual, cold)]
        traffic = f"{size_text(rate * one.answer_bytes)}/s"
        origin.append([f"{100 * ratio:g} %", f"{rate:,.0f}", traffic, *map(count_text, cores)])
    history_cache = []
    for gibibytes in HISTORY_CACHE_GIB:
        capacity = gibibytes * 2**30 / one.open_bytes
        hits = hit_ratio(load.gamuts, load.exponent, capacity)
        rate = load.utilisation / one.seconds_per_request(0.0, hits)
        history_cache.append(
            [f"{gibibytes:g} GiB", f"{capacity:,.0f}", f"{100 * hits:.1f} %", f"{rate:,.0f}"]
        )
    sizes = ("triangles", "history_bytes", "record_bytes", "input_bytes", "open_bytes")
    inputs = [
        [row["input"], *(f"{row[name]:,}" for name in sizes), f"{1e3 * row['opening_s']:.1f}"]
        for row in gamuts
    ]
    states = (
        ("mesh in the mesh cache", cached),
        ("history open, mesh not cached", 1 / one.encoded),
        ("history not open", cold),
    )
    return {
        "machine": _machine_table(results["machine"][0], cluster),
        "load": table(
            ["assumption", "value", "option"],
            [
                [text, f"{getattr(load, name):,.10g}", f"`--{name}`"]
                for name, text in LOAD_TEXTS.items()
            ],
        ),
        "measured": _measured_table(one),
        "inputs": table(["input", "triangles", "history file", "description", "input file",
                         "open history", "opening, ms"], inputs),
        "cluster": table(
            ["measurement", "result", "sample"],
            [[row["what"], row["figure"], row["counted"]] for row in cluster["figures"]],
        ),
        "storage": _storage_table(one, load),
        "answers": table(
            ["state of the replica", "processor time", f"per second at {used} of a core"],
            [[name, f"{1e6 * seconds:,.0f} µs", f"{load.utilisation / seconds:,.0f}"]
             for name, seconds in states],
        ),
        "caches": table(
            ["cache", "bytes", "capacity", "hit ratio without a CDN"],
            [["`GAMUT_MESH_CACHE_BYTES`", f"{settings.mesh_cache_bytes:,}",
              f"{meshes:,.0f} meshes", f"{100 * mesh_hits:.1f} %"],
             ["`GAMUT_HISTORY_CACHE_BYTES`", f"{settings.history_cache_bytes:,}",
              f"{histories:,.0f} histories", f"{100 * history_hits:.1f} %"]],
        ),
        "origin": table(["CDN hit ratio", "requests/s at the origin", "traffic",
                         "cores, all cached", "cores, caches as above", "cores, nothing cached"],
                        origin),
        "limits": _limits_table(one, load, load.utilisation / cold, settings.max_page_size),
        "history-cache": table(["`GAMUT_HISTORY_CACHE_BYTES`", "open histories", "hit ratio",
                                "requests/s of one core"], history_cache),
    }  # fmt: skip


def _machine_table(machine: dict[str, Any], cluster: dict[str, Any]) -> str:
    process = f"{machine['cpu']}, {machine['cores']} cores, Python {machine['python']}"
    deployment = (
        f"{cluster['api']} API processes, {cluster['workers']} workers, {cluster['broker']} and an "
        f"S3 emulator on {cluster['cores']} cores"
    )
    rows = [["one process", process, machine["date"]], ["cluster", deployment, cluster["date"]]]
    return table(["figures", "machine", "date"], rows)


def _measured_table(one: Measured) -> str:
    rows = [
        ["mesh from the mesh cache", f"{one.repeated:,.0f} per second",
         "results.json, `meshes`, repeated"],
        ["mesh encoded from an open history", f"{one.encoded:,.0f} per second",
         "results.json, `meshes`, uncached"],
        ["answer with a mesh of 1,000 triangles", f"{one.answer_bytes:,.0f} bytes",
         "results.json, `meshes`, repeated"],
        ["opening a history, to 1,000 triangles", f"{1e3 * one.opening_seconds:.1f} ms",
         "gamuts.json, `opening_s`"],
        ["building a gamut, POST to 201", f"{one.build_seconds:.2f} s",
         "results.json, `inputs`, `http_s`"],
        ["history file", f"{one.history_bytes:,.0f} bytes", "gamuts.json"],
        ["description", f"{one.record_bytes:,.0f} bytes", "gamuts.json"],
        ["input file", f"{one.input_bytes:,.0f} bytes", "gamuts.json"],
        ["open history in memory", f"{one.open_bytes:,.0f} bytes", "gamuts.json"],
    ]  # fmt: skip
    return table(["figure of one core or one gamut", "value", "source"], rows)


def _storage_table(one: Measured, load: Load) -> str:
    parts = (one.history_bytes, one.record_bytes, one.input_bytes)
    core_days = load.gamuts * one.build_seconds / DAY_SECONDS
    gamuts = f"{load.gamuts:,}"
    rows = [
        ["one gamut", " + ".join(f"{part:,.0f}" for part in parts), size_text(sum(parts))],
        ["all gamuts", f"{gamuts} × {size_text(sum(parts))}", size_text(load.gamuts * sum(parts))],
        ["all gamuts with `GAMUT_KEEP_INPUTS=false`", f"{gamuts} × {size_text(sum(parts[:2]))}",
         size_text(load.gamuts * sum(parts[:2]))],
        ["all builds", f"{gamuts} × {one.build_seconds:.2f} s", f"{core_days:,.1f} core days"],
        ["worker cores", f"{core_days:,.1f} ÷ {load.days:g} ÷ {load.utilisation:g}",
         count_text(math.ceil(core_days / load.days / load.utilisation))],
        ["mean rate of builds", f"{gamuts} ÷ {load.days:g} ÷ 86,400 s",
         f"{load.gamuts / load.days / DAY_SECONDS:.2f} per second"],
    ]  # fmt: skip
    return table(["quantity", "arithmetic", "result"], rows)


def _limits_table(one: Measured, load: Load, openings: float, page_size: int) -> str:
    rows = [
        ["memory for open histories", f"{load.gamuts:,} × {one.open_bytes:,.0f} bytes",
         size_text(load.gamuts * one.open_bytes)],
        ["network of a replica", f"{one.repeated:,.0f} × {one.answer_bytes:,.0f} bytes/s",
         f"{8e-9 * one.repeated * one.answer_bytes:.1f} Gbit/s"],
        ["answers per second on 10 Gbit/s", f"10¹⁰ ÷ 8 ÷ {one.answer_bytes:,.0f}",
         f"{1e10 / 8 / one.answer_bytes:,.0f}"],
        ["reads from the bucket, per core", f"{openings:,.0f} × {one.history_bytes:,.0f} bytes/s",
         f"{size_text(openings * one.history_bytes)}/s"],
        ["builds per second, per core", f"{load.utilisation:g} ÷ {one.build_seconds:.2f} s",
         f"{load.utilisation / one.build_seconds:.2f}"],
        ["pages of `GET /v1/gamuts`", f"{load.gamuts:,} ÷ {page_size}",
         f"{load.gamuts / page_size:,.0f}"],
    ]  # fmt: skip
    return table(["limit", "arithmetic", "result"], rows)


def size_text(nbytes: float) -> str:
    """Format a number of bytes with three significant digits and a decimal unit.

    Examples
    --------
    >>> size_text(32_920)
    '32.9 kB'
    """
    exponent = min(int(math.log10(max(nbytes, 1)) // 3), 4)
    return f"{nbytes / 1000**exponent:,.3g} {('bytes', 'kB', 'MB', 'GB', 'TB')[exponent]}"


def read_results() -> tuple[dict[str, Any], list[dict[str, Any]], dict[str, Any]]:
    """Return the content of results.json, gamuts.json and cluster.json."""
    files = (FOLDER / "results.json", GAMUTS, FOLDER / "cluster.json")
    results, gamuts, cluster = (json.loads(path.read_text()) for path in files)
    return results, gamuts, cluster


def update(load: Load) -> None:
    """Update docs/scaling.md for the default load; print the tables of any other load."""
    contents = document_blocks(*read_results(), load)
    if load == Load():
        update_document(DOCUMENT, contents)
    else:
        print("\n\n".join(contents.values()))


def main() -> int:
    """Measure sizes if asked, and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measure", action="store_true", help="write gamuts.json first")
    for field in fields(Load):
        kind = type(field.default)
        parser.add_argument(
            f"--{field.name}", type=kind, default=field.default, help=LOAD_TEXTS[field.name]
        )
    arguments = vars(parser.parse_args())
    if arguments.pop("measure"):
        from benchmarks.inputs import gamut_sizes  # imports the client of a running service

        GAMUTS.write_text(json.dumps(gamut_sizes(), indent=1) + "\n")
    update(Load(**arguments))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
