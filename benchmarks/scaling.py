"""How many machines a load needs, by arithmetic from what was measured: ``make scaling``.

Reads ``benchmarks/results.json`` (requests, builds), ``benchmarks/gamuts.json`` (bytes and opening
times of gamuts, which ``--measure`` writes anew) and ``benchmarks/cluster.json`` (figures of a
cluster on one machine, written by ``tests/faults/cluster.py``), and writes ``docs/scaling.md``. Not
one figure of a machine is in this file; what is assumed about the load is in `Load`, and can be
given on the command line.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import textwrap
from dataclasses import dataclass, fields
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np

from benchmarks.markdown import table
from service.settings import Settings

__all__ = ["Load", "Measured", "hit_ratio", "page", "write"]

FOLDER = Path(__file__).parent
DOCUMENT = FOLDER.parent / "docs" / "scaling.md"
RESULTS = FOLDER / "results.json"
GAMUTS = FOLDER / "gamuts.json"
CLUSTER = FOLDER / "cluster.json"

_DAY = 86_400.0

_EDGES = (0.0, 0.9, 0.99, 0.999)
"""Hit ratios of the CDN for which the origin is worked out: nobody measures those but the CDN."""


@dataclass(frozen=True)
class Load:
    """What is assumed: a load, and how far a machine is to be loaded by it.

    Attributes
    ----------
    gamuts : int
        Gamuts that are kept.
    requests : float
        Requests for meshes per second, at the CDN.
    levels : int
        Different meshes (triangle counts and formats) that are asked for of a gamut.
    exponent : float
        How uneven gamuts are asked for: the i-th most popular in proportion to 1/i^exponent.
    days : float
        Days in which all gamuts are built.
    utilisation : float
        Part of a core that may be busy on the average.
    """

    gamuts: int = 1_000_000
    requests: float = 100_000.0
    levels: int = 20
    exponent: float = 1.0
    days: float = 30.0
    utilisation: float = 0.6


@dataclass(frozen=True)
class Measured:
    """The figures that everything else follows from.

    Attributes
    ----------
    repeated, encoded : float
        Meshes per second of one API process: from memory, and read from an open history.
    answer_bytes : float
        Bytes of a mesh of 1,000 triangles.
    opening_seconds : float
        From the bytes of a history, whose digest is compared, to a level of 1000 triangles.
    history_bytes, record_bytes, input_bytes, open_bytes : float
        Of one gamut: its history file, the description, what it was built from, and in memory.
    build_seconds : float
        From a POST to the gamut, one worker on one core.
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
    def read(cls, results: dict[str, Any], gamuts: list[dict[str, Any]]) -> Measured:
        """Return the figures out of the two files."""
        rates = {row["request"]: row for row in results["meshes"]}
        repeated, encoded = rates["repeated, 1000 triangles"], rates["uncached, 500 counts in turn"]

        def typical(name: str) -> float:
            figure: float = mean(row[name] for row in gamuts)
            return figure

        return cls(
            repeated=repeated["requests_per_s"],
            encoded=encoded["requests_per_s"],
            answer_bytes=repeated["bytes_per_answer"],
            opening_seconds=typical("opening_s"),
            history_bytes=typical("history_bytes"),
            record_bytes=typical("record_bytes"),
            input_bytes=typical("input_bytes"),
            open_bytes=typical("open_bytes"),
            build_seconds=mean(row["http_s"] for row in results["inputs"]),
        )

    def seconds_per_request(self, meshes: float, histories: float) -> float:
        """Return the processor time of a request by the hit ratios of both caches."""
        read = 1 / self.encoded + (1 - histories) * self.opening_seconds
        return meshes / self.repeated + (1 - meshes) * read


def hit_ratio(objects: int, exponent: float, kept: float) -> float:
    """Return the part of requests that a cache answers which keeps what was used last.

    Parameters
    ----------
    objects : int
        How many there are; the i-th is asked for in proportion to 1/i^exponent, independently.
    exponent : float
        See above; 0 is evenly.
    kept : float
        How many fit.

    Returns
    -------
    float
        0 to 1, by the approximation of H. Che, Y. Tung, Z. Wang, "Hierarchical Web caching systems:
        modeling, design and experimental results", IEEE JSAC 20 (7), 2002: an object is in the
        cache if it was asked for within a time that is the same for all.
    """
    if kept >= objects:
        return 1.0
    if kept <= 0:
        return 0.0
    # The tail is nearly even, so that groups of neighbours stand for their members.
    edges = np.unique(np.geomspace(1, objects + 1, 20_000).astype(np.int64))
    counts = np.diff(edges)
    weights = ((edges[:-1] + edges[1:] - 1) / 2.0) ** -exponent
    weights /= (weights * counts).sum()
    low, high = 0.0, 1.0
    while (counts * -np.expm1(-weights * high)).sum() < kept:
        high *= 2.0
    for _ in range(100):
        middle = (low + high) / 2
        inside = (counts * -np.expm1(-weights * middle)).sum()
        low, high = (middle, high) if inside < kept else (low, middle)
    return float((counts * weights * -np.expm1(-weights * low)).sum())


def page(
    results: dict[str, Any], gamuts: list[dict[str, Any]], cluster: dict[str, Any], load: Load
) -> str:
    """Return the text of docs/scaling.md."""
    figures = Measured.read(results, gamuts)
    text = "\n".join(
        (
            _introduction(results, load),
            _measured(gamuts, cluster, figures),
            _a_million(figures, load),
            _origin(figures, load),
            _limits(figures, load),
        )
    )
    return "\n\n".join(map(_filled, text.strip().split("\n\n"))) + "\n"


def _introduction(results: dict[str, Any], load: Load) -> str:
    machine = results["machine"][0]
    command = "".join(
        f" --{field.name} {getattr(load, field.name):g}"
        for field in fields(Load)
        if getattr(load, field.name) != field.default
    )
    return f"""\
# How far it scales, and what breaks first

Written by `make scaling` (`python -m benchmarks.scaling{command}`) from figures that were measured on
one machine: {machine["cpu"]}, {machine["cores"]} cores, Python {machine["python"]}, {machine["date"]}.
Nothing here was run at this size. Every number is either **measured** (with the file and the name of
its figure), **assumed** (in the list below, and an option of the program), or worked out from those by
the arithmetic beside it. Another machine: measure there (`make bench`, then
`python -m benchmarks.scaling --measure`), and this page says what follows.

Assumed of the load:

- {load.gamuts:,} gamuts, built within {load.days:g} days;
- {load.requests:,.0f} requests per second for meshes of about 1,000 triangles, at a CDN;
- {load.levels} different meshes of each gamut (triangle counts and formats);
- the i-th most popular gamut is asked for in proportion to 1/i^{load.exponent:g};
- a core may be busy {100 * load.utilisation:g} % of the time.
"""


def _measured(
    gamuts: list[dict[str, Any]],
    cluster: dict[str, Any],
    figures: Measured,
) -> str:
    rows = [
        ["mesh from memory", f"{figures.repeated:,.0f} requests/s of one API process",
         "results.json, `meshes`, repeated"],
        ["mesh from an open history", f"{figures.encoded:,.0f} requests/s of one API process",
         "results.json, `meshes`, uncached"],
        ["bytes of such a mesh", f"{figures.answer_bytes:,.0f}", "results.json, `meshes`"],
        ["a history opened, to 1,000 triangles", f"{1e3 * figures.opening_seconds:.1f} ms of one core",
         "gamuts.json, `opening_s`, mean"],
        ["a gamut built, POST to 201", f"{figures.build_seconds:.2f} s of one core",
         "results.json, `inputs`, `http_s`, mean"],
        ["history file", f"{figures.history_bytes:,.0f} bytes", "gamuts.json, mean"],
        ["description", f"{figures.record_bytes:,.0f} bytes", "gamuts.json, mean"],
        ["input", f"{figures.input_bytes:,.0f} bytes", "gamuts.json, mean"],
        ["open history, to 1,000 triangles", f"{_size(figures.open_bytes)} of memory", "gamuts.json, mean"],
    ]  # fmt: skip
    each = [
        [
            row["input"], f"{row['triangles']:,}", f"{row['history_bytes']:,}",
            f"{row['record_bytes']:,}", f"{row['input_bytes']:,}", _size(row["open_bytes"]),
            f"{1e3 * row['opening_s']:.1f}",
        ]
        for row in gamuts
    ]  # fmt: skip
    text = f"""\
## Measured

{table(["what", "figure", "from"], rows)}

By input:

{
        table(
            ["input", "triangles", "history, bytes", "description", "input", "open", "opening, ms"],
            each,
        )
    }
"""
    if cluster:
        rows = [[row["what"], row["figure"], row["counted"]] for row in cluster["figures"]]
        text += f"""
With a broker: {cluster["api"]} API processes, {cluster["workers"]} workers, {cluster["broker"]} and an
S3 server (moto's) on the same {cluster["cores"]} cores, {cluster["date"]}; cluster.json, written by
`tests/faults/cluster.py`:

{table(["what", "figure", "counted"], rows)}
"""
    return text


def _a_million(figures: Measured, load: Load) -> str:
    per_gamut = figures.history_bytes + figures.record_bytes + figures.input_bytes
    core_days = load.gamuts * figures.build_seconds / _DAY
    cores = core_days / load.days / load.utilisation
    rate = load.gamuts / load.days / _DAY
    return f"""\
## {load.gamuts:,} gamuts

| | arithmetic | result |
| --- | --- | --- |
| a gamut in the bucket | {figures.history_bytes:,.0f} + {figures.record_bytes:,.0f} + {
        figures.input_bytes:,.0f} bytes | {_size(per_gamut)} |
| all of them | × {load.gamuts:,} | {_size(per_gamut * load.gamuts)} |
| without the inputs (`GAMUT_KEEP_INPUTS=false`) | | {
        _size((figures.history_bytes + figures.record_bytes) * load.gamuts)
    } |
| building them | {load.gamuts:,} × {figures.build_seconds:.2f} s ÷ 86,400 s | {
        core_days:,.1f} core days |
| worker cores for {load.days:g} days | {core_days:,.1f} ÷ {load.days:g} ÷ {load.utilisation:g} | {
        _up(cores)
    } |
| builds per second, on the average | {load.gamuts:,} ÷ {load.days:g} ÷ 86,400 | {rate:.2f} |

Builds are independent and share nothing but the broker and the bucket, so cores may be exchanged for
days. What a build asks of the broker is one message.
"""


def _origin(figures: Measured, load: Load) -> str:
    settings = Settings.model_construct()
    meshes_kept = settings.mesh_cache_bytes / figures.answer_bytes
    histories_kept = settings.history_cache_bytes / figures.open_bytes
    # As likely as each other, the levels of a gamut are together what it would be alone.
    meshes = hit_ratio(load.gamuts, load.exponent, meshes_kept / load.levels)
    histories = hit_ratio(load.gamuts, load.exponent, histories_kept)
    best = figures.seconds_per_request(1.0, 1.0)
    worst = figures.seconds_per_request(0.0, 0.0)
    seconds = figures.seconds_per_request(meshes, histories)
    rows = []
    for edge in _EDGES:
        arriving = load.requests * (1 - edge)
        rows.append(
            [
                f"{100 * edge:g} %",
                f"{arriving:,.0f}",
                f"{_size(arriving * figures.answer_bytes)}/s",
                _up(arriving * best / load.utilisation),
                _up(arriving * seconds / load.utilisation),
                _up(arriving * worst / load.utilisation),
            ]
        )
    return f"""\
## {load.requests:,.0f} mesh requests per second

The answers never change, so a CDN may keep each for good. All of them together are {
        load.gamuts:,} ×
{load.levels} × {figures.answer_bytes:,.0f} bytes = {
        _size(load.gamuts * load.levels * figures.answer_bytes)
    }, and {load.requests:,.0f} × {figures.answer_bytes:,.0f} bytes = {
        _size(load.requests * figures.answer_bytes)
    }/s leave the CDN.

What the CDN does not have comes from an API replica, by one of three ways:

| way | processor time |
| --- | --- |
| the mesh is in memory | 1 ÷ {figures.repeated:,.0f} = {1e6 * best:.0f} µs |
| its history is open | 1 ÷ {figures.encoded:,.0f} = {1e6 / figures.encoded:.0f} µs |
| neither | {1e6 / figures.encoded:.0f} µs + {1e3 * figures.opening_seconds:.1f} ms = {
        1e3 * worst:.1f} ms, and {figures.history_bytes:,.0f} bytes out of the bucket |

With its default settings a replica keeps {settings.mesh_cache_bytes:,} ÷ {
        figures.answer_bytes:,.0f} = {meshes_kept:,.0f} meshes and {
        settings.history_cache_bytes:,} ÷ {figures.open_bytes:,.0f} = {
        histories_kept:,.0f} open histories. Asked for in proportion to
1/i^{load.exponent:g}, without a CDN before it, memory would have {
        100 * meshes:.1f} % of the meshes and
{
        100
        * histories:.1f} % of the histories (Che's approximation of a cache that drops what was not used for
the longest time; every level of a gamut taken for as popular as the next, and the
two caches for independent), so that a request takes
{
        1e3
        * seconds:.2f} ms on the average. A CDN that takes the popular ones away makes what is left less
even, and the last column is nearer to the truth then.

| hits at the CDN | requests/s at the origin | out of the origin | cores, all in memory | cores, as above | cores, nothing in memory |
| --- | --- | --- | --- | --- | --- |
{chr(10).join(f"| {' | '.join(row)} |" for row in rows)}

Cores are requests/s × time ÷ {load.utilisation:g}. An API process was measured on one
core, so there is to be a replica for each.
"""


def _limits(figures: Measured, load: Load) -> str:
    settings = Settings.model_construct()
    histories_kept = settings.history_cache_bytes / figures.open_bytes
    cold = load.utilisation / figures.seconds_per_request(0.0, 0.0)
    warm = load.utilisation * figures.encoded
    hot = load.utilisation * figures.repeated
    needed = load.gamuts * figures.open_bytes
    ratios = [
        [
            f"{size:g} GiB",
            f"{size * 2**30 / figures.open_bytes:,.0f}",
            f"{100 * (part := hit_ratio(load.gamuts, load.exponent, size * 2**30 / figures.open_bytes)):.1f} %",
            f"{load.utilisation / figures.seconds_per_request(0.0, part):,.0f}",
        ]
        for size in (0.5, 2, 8, 32)
    ]
    return f"""\
## What breaks first

In this order:

1. **Cold gamuts.** A replica that has a gamut open answers {
        warm:,.0f} requests/s of one core, and {
        hot:,.0f}/s of a mesh that it has in memory; one that has to open it first, {
        cold:,.0f}/s: the {1e3 * figures.opening_seconds:.1f} ms of opening are {
        figures.opening_seconds * figures.encoded:,.1f} times the rest. Only {
        histories_kept:,.0f} fit into
   `GAMUT_HISTORY_CACHE_BYTES` of {_size(settings.history_cache_bytes)}; all {
        load.gamuts:,} would need {
        _size(needed)
    }. What helps, the cheapest first: more memory for each replica (below); a proxy
   that sends the same gamut to the same replica (hashing the path), so that N replicas keep N times as
   many; a CDN with one shield in front of the origin.

{
        table(
            ["`GAMUT_HISTORY_CACHE_BYTES`", "open histories", "hits", "requests/s of one core"],
            ratios,
        )
    }

2. **The line out of a replica.** At {figures.repeated:,.0f} requests/s a process sends {
        _size(figures.repeated * figures.answer_bytes)
    }/s = {
        8e-9 * figures.repeated * figures.answer_bytes:.1f} Gbit/s: a network of 10 Gbit/s carries {
        10e9 / 8 / figures.answer_bytes:,.0f} such answers per second, whatever the number of cores.
3. **The bucket, for cold gamuts**: {figures.history_bytes:,.0f} bytes for each opening, so that {
        cold:,.0f} openings/s of one core draw {_size(cold * figures.history_bytes)}/s.
4. **Workers**, where gamuts arrive faster than {load.utilisation:g} ÷ {
        figures.build_seconds:.2f} s = {
        load.utilisation
        / figures.build_seconds:.2f} builds/s of each core: the queue fills, and POST is
   answered with 429 beyond `GAMUT_BUILD_QUEUE`; what exists is served as before. More workers help
   at once, and an autoscaler that looks at the queue starts them.
5. **The list of all gamuts.** `GET /v1/gamuts` pages through the bucket's keys in their order, at most
   {settings.max_page_size} to a page: {
        load.gamuts / settings.max_page_size:,.0f} pages for everything.
   Nothing else looks at more than one gamut.

The broker is not in this list: a message for each build, and none for a mesh.
"""


def _filled(block: str) -> str:
    """Return a paragraph or a list in lines of 100 characters; tables and headings as they are."""
    if block.lstrip().startswith(("|", "#")):
        return block
    items = re.split(r"\n(?=- |\d+\. )", block.strip("\n"))
    filled = []
    for item in items:
        mark = re.match(r"(- |\d+\. )?", item)
        indent = " " * (len(mark[0]) if mark else 0)
        filled.append(
            textwrap.fill(
                " ".join(item.split()),
                100,
                subsequent_indent=indent,
                break_long_words=False,
                break_on_hyphens=False,
            )
        )
    return "\n".join(filled)


def _size(nbytes: float) -> str:
    for unit in ("bytes", "kB", "MB", "GB", "TB"):
        if nbytes < 1000 or unit == "TB":
            break
        nbytes /= 1000
    return f"{nbytes:,.3g} {unit}" if nbytes < 1000 else f"{nbytes:,.0f} {unit}"


def _up(cores: float) -> str:
    return f"{int(np.ceil(cores)):,}"


def write(load: Load) -> None:
    """Write the page from the files of figures."""
    cluster = json.loads(CLUSTER.read_text()) if CLUSTER.is_file() else {}
    results, gamuts = (json.loads(path.read_text()) for path in (RESULTS, GAMUTS))
    DOCUMENT.write_text(page(results, gamuts, cluster, load))


def main() -> int:
    """Write the page, after measuring what is to be measured."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measure", action="store_true", help="write gamuts.json anew, first")
    for field in fields(Load):
        parser.add_argument(f"--{field.name}", type=type(field.default), default=field.default)
    given = vars(parser.parse_args())
    if given.pop("measure"):
        from benchmarks.inputs import gamut_sizes  # it brings the service's server along

        GAMUTS.write_text(json.dumps(gamut_sizes(), indent=1) + "\n")
    write(Load(**given))
    return 0


if __name__ == "__main__":
    sys.exit(main())
