"""The documents made from the measurements: ``docs/decimation.md`` and a table in the README.

Every number in them is written here from ``benchmarks/decimation.json``; the words around them are
templates, and where a sentence depends on what was measured, so does the template.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from statistics import mean
from typing import Any

from benchmarks.experiment import experiment_text, pictures_text
from benchmarks.markdown import count_text, percent, table
from benchmarks.paper import SPHERE_LIMIT
from benchmarks.peers import COUNTS
from benchmarks.speed_text import speed_text
from benchmarks.summary import (
    GOAL_COUNTS,
    YARDSTICK,
    Measured,
    best_peer,
    costs_by_accuracy,
    goals,
    level_errors,
    mean_errors,
    ratios,
    smaller_boundaries,
)
from gamutcore.version import ALGORITHM_VERSION

__all__ = ["DOCUMENT", "README", "json_text", "page", "readme_table", "with_table", "write"]

ROOT = Path(__file__).parent.parent
DOCUMENT = ROOT / "docs" / "decimation.md"
README = ROOT / "README.md"

BEGIN, END = "<!-- decimation table -->", "<!-- end of decimation table -->"
"""The README's table is between these."""


def write(measured: Measured) -> None:
    """Write ``docs/decimation.md`` and the README's table."""
    DOCUMENT.write_text(page(measured))
    README.write_text(with_table(README.read_text(), readme_table(measured)))


def json_text(measured: Measured) -> str:
    """Measurements as JSON: a row of a table on a line, numbers to six significant digits."""

    def rounded(value: Any) -> Any:  # noqa: ANN401  # whatever JSON holds
        if isinstance(value, float):
            return float(f"{value:.6g}")
        if isinstance(value, dict):
            return {name: rounded(each) for name, each in value.items()}
        return [rounded(each) for each in value] if isinstance(value, list) else value

    parts = []
    for name, value in rounded(measured).items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = ",\n  ".join(json.dumps(row, ensure_ascii=False) for row in value)
            parts.append(f"{json.dumps(name)}: [\n  {rows}\n ]")
        else:
            parts.append(f"{json.dumps(name)}: {json.dumps(value, ensure_ascii=False)}")
    return "{\n " + ",\n ".join(parts) + "\n}\n"


def with_table(text: str, table: str) -> str:
    """Replace what is between the markers of a text.

    Parameters
    ----------
    text, table : str

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If the text does not have both markers once.
    """
    if text.count(BEGIN) != 1 or text.count(END) != 1:
        raise ValueError(f"the text has not one {BEGIN} and one {END}")
    found = re.compile(f"{BEGIN}.*{END}", re.DOTALL)
    return found.sub(lambda _: f"{BEGIN}\n{table}\n{END}", text)


def readme_table(measured: Measured) -> str:
    """Return the README's table: mean mismatches at the counts that accuracy is claimed for."""
    counts = GOAL_COUNTS
    rows = []
    for cost in reversed(costs_by_accuracy(measured)):
        name = f"`{cost}`" + (" (published)" if cost == YARDSTICK else "")
        rows.append([name, *map(percent, mean_errors(measured, cost, counts).values())])
    peers = [_peer_mean(measured, count) for count in counts]
    if all(error is not None for error in peers):
        rows.append(["best of other libraries", *(percent(error or 0.0) for error in peers)])
    return table(["mean mismatch, %", *(f"{count} triangles" for count in counts)], rows)


def page(measured: Measured) -> str:
    """Return the whole of ``docs/decimation.md``."""
    return "\n".join(
        [
            _introduction(measured),
            _goals(measured),
            _accuracy(measured),
            _sphere(measured),
            _peers(measured),
            speed_text(measured),
            _limits(measured),
            experiment_text(measured),
            pictures_text(measured),
        ]
    )


# --- sections -------------------------------------------------------------------------------------


def _introduction(measured: Measured) -> str:
    about = measured["machine"]
    versions = ", ".join(
        f"{name} {about[name]}"
        for name in (
            "numpy", "numba", "vtk", "pymeshlab", "meshlib", "fast-simplification", "pyfqmr",
            "manifold3d",
        )
        if name in about
    )  # fmt: skip
    rows = [
        [each["name"], each["kind"], f"{each['points']:,}", f"{each['triangles']:,}"]
        for each in measured["devices"]
    ]
    few = ""
    if len(rows) < 6:
        few = "\nThe shared data was not there: these are the devices that the repository itself has.\n"
    older = ""
    if about["algorithm"] != ALGORITHM_VERSION:
        older = (
            f"\n**These are figures of algorithm version {about['algorithm']}; the present one is "
            f"{ALGORITHM_VERSION}, and not measured here yet.**\n"
        )
    return f"""\
# Decimation: accuracy, speed, and the published experiment

Written by `make figures` (benchmarks/figures.py) on {about["date"]}: {about["cpu"]}, one core,
{about["system"]}, Python {about["python"]}.
{versions}, algorithm version {about["algorithm"]}.
The same figures, to six digits, are in
[benchmarks/decimation.json](../benchmarks/decimation.json).
{older}
*Mismatch* is the volume of the symmetric difference of a simplified boundary and its full boundary,
as a part of the latter's volume. All of them here are exact: by laying surfaces that are star-shaped
about one centre over each other, and by boolean operations on the meshes (Manifold) for all others; at
levels of 1,000 and 50 triangles the two ways agree within {measured["disagreement"]:.0e} of the value.
Times are processor time, warm, the shortest of several runs. The full boundary of each device is the
modified convex hull (γ = 0.2) of about 100,000 colours of its surface:

{table(["device", "what it is", "colours", "triangles"], rows)}
{few}"""


def _goals(measured: Measured) -> str:
    rows = [[goal, found, "yes" if met else "**no**"] for goal, found, met in goals(measured)]
    sizes = {row["triangles"] for row in measured["few"]}
    smaller = [
        [limit, "–" if size is None else f"{size:,}", kept, broken]
        for limit, size, kept, broken in smaller_boundaries(measured)
    ]
    return f"""\
## What was set out for

{table(["goal", "measured", "met"], rows)}

Those by the triangle, by the vertex and by the part of the time are for gamuts as devices have them, and
larger ones. A boundary of some thousand triangles takes a tenth of a second and two megabytes whatever it
has, and its file a header. {len(sizes)} boundaries of {min(sizes):,} to {max(sizes):,} triangles say from how many triangles
on each of these limits is kept, and what was measured from there on and below:

{table(["limit", "from triangles", "there", "below"], smaller)}
"""


def _accuracy(measured: Measured) -> str:
    costs = costs_by_accuracy(measured)
    counts = COUNTS
    relative = []
    for cost in costs:
        found = [list(ratios(measured, cost, count).values()) for count in counts]
        relative.append([f"`{cost}`", *(f"{mean(each):.3f}" for each in found)])
    sums = mean_errors(measured, YARDSTICK, counts)
    relative += [
        [
            f"`{cost}`, of the means",
            *(f"{error / sums[n]:.3f}" for n, error in mean_errors(measured, cost, counts).items()),
        ]
        for cost in costs[1:]
    ]
    absolute = []
    for device in measured["devices"]:
        for cost in costs:
            errors = [level_errors(measured, cost, n).get(device["name"]) for n in counts]
            absolute.append([device["name"], f"`{cost}`", *map(percent, errors)])
    invalid = sum(bool(row["faults"]) for row in measured["levels"])
    return f"""\
## Accuracy of the costs

Mismatch relative to `{YARDSTICK}`, the published cost, which is 1: mean over the devices of the
ratios, and below them the ratios of the mean mismatches.

{table(["triangles", *map(count_text, counts)], relative)}

![Mismatch relative to the published cost](pictures/relative.svg)

In %, for each device:

{table(["device", "cost", *map(count_text, counts)], absolute)}

Of the {len(measured["levels"])} levels measured for this document {f"{invalid} break an" if invalid else "none breaks an"}
invariant (closed, manifold, genus 0, no degenerate or duplicate face, star-shaped about the centre,
and so free of self-intersections), and each has the triangle count asked for.
"""


def _sphere(measured: Measured) -> str:
    counts = sorted({row["asked"] for row in measured["sphere"]}, reverse=True)
    rows = []
    for cost in costs_by_accuracy(measured):
        for spread in ("spiral", "random"):
            found = {
                row["asked"]: row["product"]
                for row in measured["sphere"]
                if row["cost"] == cost and row["points"] == spread
            }
            rows.append([f"`{cost}`", spread, *(f"{found[count]:.2f}" for count in counts)])
    return f"""\
## How far from the limit

On a smooth convex body the least possible mismatch with n triangles falls as C ÷ n. For a sphere,
C = 12π·(1/(6√3) − 1/(8π)) = {SPHERE_LIMIT:.3f} (Ludwig, Böröczky). Mismatch × n for spheres of 10,000
vertices, spread evenly along a spiral or at random:

{table(["cost", "vertices", *map(count_text, counts)], rows)}
"""


def _peers(measured: Measured) -> str:
    if not measured["peers"]:
        return """\
## Beside other libraries

None was installed: `make figures` installs them (the group `peers` of pyproject.toml).
"""
    costs = costs_by_accuracy(measured)
    counts = COUNTS
    beside = []
    for device in measured["devices"]:
        name = device["name"]
        beside.append(
            [
                name,
                "best other",
                *(
                    "–" if best is None else f"{percent(best[1])} {best[0]}"
                    for best in (best_peer(measured, name, count) for count in counts)
                ),
            ]
        )
        for cost in costs[1:]:
            errors = [level_errors(measured, cost, count).get(name) for count in counts]
            beside.append([name, f"`{cost}`", *map(percent, errors)])
    names = list(dict.fromkeys(row["method"] for row in measured["peers"]))
    means, reached = [], []
    for method in [*costs, *names]:
        found = [level_errors(measured, method, count) for count in counts]
        everywhere = [
            percent(mean(each.values())) if len(each) == len(measured["devices"]) else "–"
            for each in found
        ]
        means.append([f"`{method}`" if method in costs else method, *everywhere])
        rows = [
            row
            for row in [*measured["levels"], *measured["peers"]]
            if row["method"] == method and row["asked"] in counts
        ]
        asked = len(measured["devices"]) * len(counts)
        got = [row for row in rows if row["reached"]]
        said = [" ".join(row["faults"]) for row in got]
        reached.append(
            [
                f"`{method}`" if method in costs else method,
                f"{len(got)} of {asked}",
                str(sum(not text for text in said)),
                str(sum("not closed" in text or "not manifold" in text for text in said)),
                str(sum("crossings" in text for text in said)),
                str(sum("turned away" in text for text in said)),
                str(sum("genus" in text or "faces" in re.sub(r"\d+ faces turned away", "", text)
                        or "pieces" in text for text in said)),
            ]
        )  # fmt: skip
    return f"""\
## Beside other libraries

The same full boundaries through other libraries, in the same run, each with the settings that served
it best here. A library is taken to reach a count if it returns at most so many triangles; whoever
stalls above a count is not asked for smaller ones. The best of the others at each count, whatever the
validity of its mesh, beside our costs, in %:

{table(["device", "method", *map(count_text, counts)], beside)}

Mean over the devices, in %, where a library reaches the count and encloses a volume on all of them:

{table(["method", *map(count_text, counts)], means)}

Validity: of {len(measured["devices"])} devices × {len(counts)} counts, how many are reached; of
these, how many are valid in every respect, not a closed manifold, cross themselves, have faces turned
away from the centre (so that directions meet the surface more than once), or have handles, pieces,
degenerate or duplicate faces. A mesh can be counted under several.

{
        table(
            [
                "method",
                "reached",
                "valid",
                "not a closed manifold",
                "crosses itself",
                "turned away",
                "handles, pieces, faulty faces",
            ],
            reached,
        )
    }

Each run of another library gives one level (fast-simplification can also replay the collapses of a
run), and none promises validity. A history gives all levels:

![Processor time of all levels and of one](pictures/times.svg)
"""


def _limits(measured: Measured) -> str:
    rows = [
        [
            row["device"], f"`{row['cost']}`", f"`{row['limit']}`", str(row["coarse"]),
            f"{row['excess']:.3f}", f"{row['most_excess']:.2f}", f"{row['saved']:.2f}",
            f"{row['most_saved']:.1f}", f"{1e3 * row['median_s']:.0f}",
            f"{1e3 * row['longest_s']:.0f}",
        ]
        for row in measured["limits"]
    ]  # fmt: skip
    asked = measured["limits"][0]["limits"]
    return f"""\
## Levels by their error

The error curve of a description knows some twenty levels. A level that is asked for by a limit to its
error is searched among all, and compared with the full boundary where the curve cannot tell. Below,
{
        asked
    } limits each, `max_error` from 0.005 to 5 ΔE and `max_mismatch` from 10⁻⁵ to 10⁻², evenly on a
logarithmic scale. *Excess*: triangles of the level found ÷ those of the smallest of all levels that keep
the limit, where that has at most 1,000 (how many limits), mean and largest; the curve can promise a
little more than the comparison that this is counted by. *Saved*: triangles of the smallest level of the
curve that promises as much ÷ those of the level found, geometric mean and largest. Processor time of a
search with nothing remembered, median and longest, in ms.

{
        table(
            ["device", "cost", "limit", "coarse", "excess", "most", "saved", "most", "ms", "most"],
            rows,
        )
    }
"""


def _peer_mean(measured: Measured, count: int) -> float | None:
    """Mean over the devices of the best peer's mismatch; None if a device has none."""
    found = [best_peer(measured, each["name"], count) for each in measured["devices"]]
    errors = [best[1] for best in found if best is not None]
    return mean(errors) if len(errors) == len(found) else None
