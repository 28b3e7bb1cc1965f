"""The tables of ``docs/decimation.md``, from the content of ``benchmarks/decimation.json``."""

from __future__ import annotations

from collections.abc import Callable
from statistics import geometric_mean, mean
from typing import Any

from benchmarks.markdown import count_text, percent, table
from benchmarks.paper import SPHERE_LIMIT
from benchmarks.peers import COUNTS
from benchmarks.summary import (
    PUBLISHED_COST,
    Results,
    best_peer,
    boundary_methods,
    costs_by_accuracy,
    level_errors,
    mean_best_peer,
    mean_errors,
)

__all__ = ["document_blocks"]

DEVICE_COUNTS = (1000, 100)
"""Triangle counts of the table by device."""

LIBRARY_COUNTS = (1000, 100, 20)
SPHERE_COUNTS = (1000, 500, 100)

METHOD_SIZES = (100, 1000, 10_000)
"""Triangle counts near which the other boundary methods are tabulated; the plot has all sizes."""

MEASURABLE_TRIANGLES = 2000
"""The memory of smaller histories is lost in the noise of the process."""

SMALL_LIMITS = (
    ("2 µs per triangle", "us_per_triangle", 2.0),
    ("400 bytes of memory per triangle", "bytes_per_triangle", 400.0),
    ("110 bits per vertex in the history file", "bits_per_vertex", 110.0),
    ("error curve in 30 % of the decimation time", "curve_part", 0.3),
)
"""Properties of device gamuts that small boundaries do not have: text, key, and limit."""


def document_blocks(results: Results) -> dict[str, str]:
    """Return the generated blocks of docs/decimation.md."""
    makers: dict[str, Callable[[Results], str]] = {
        "machine": _machine,
        "mean-mismatch": _mean_mismatch,
        "device-mismatch": _device_mismatch,
        "times": _times,
        "small": _small,
        "files": _files,
        "limits": _limits,
        "libraries": _libraries,
        "sphere": _sphere,
        "methods": _methods,
        "agreement": _agreement,
    }
    return {name: make(results) for name, make in makers.items()}


def _machine(results: Results) -> str:
    about = results["machine"]
    platform = ("cpu", "system", "python", "numpy", "numba")
    libraries = [
        f"{name} {version}"
        for name, version in about.items()
        if name not in {*platform, "date", "cores", "algorithm", "scipy", "trimesh", "uvicorn"}
    ]
    values = [about["date"], str(about["algorithm"]), *(about[name] for name in platform)]
    rows = [[*values, ", ".join(libraries)]]
    return table(["date", "algorithm version", *platform, "libraries"], rows)


def _mean_mismatch(results: Results) -> str:
    rows = [
        [f"`{cost}`", *map(percent, mean_errors(results, cost, COUNTS).values())]
        for cost in costs_by_accuracy(results)[::-1]
    ]
    best = [percent(mean_best_peer(results, count)) for count in COUNTS]
    rows.append(["best other library per device", *best])
    return table(["triangles", *map(count_text, COUNTS)], rows)


def _device_mismatch(results: Results) -> str:
    costs = costs_by_accuracy(results)[:0:-1]  # without the published cost
    rows = []
    for device in results["devices"]:
        name = device["name"]
        row = [f"{name}: {device['kind']}", count_text(device["triangles"])]
        for count in DEVICE_COUNTS:
            row += [percent(level_errors(results, cost, count).get(name)) for cost in costs]
            best = best_peer(results, name, count)
            row.append("–" if best is None else f"{percent(best[1])} ({best[0]})")
        rows.append(row)
    head = [
        f"{name}, {count:,}"
        for count in DEVICE_COUNTS
        for name in (*(f"`{cost}`" for cost in costs), "best other")
    ]
    return table(["device", "full boundary", *head], rows)


def _times(results: Results) -> str:
    rows = [
        [
            f"`{row['cost']}`",
            count_text(row["triangles"]),
            f"{row['seconds']:.2f}",
            f"{row['us_per_triangle']:.2f}",
            f"{row['bytes_per_triangle']:.0f}",
            f"{row['curve_s']:.2f}",
        ]
        for row in results["scaling"]
    ]
    head = ["decimation, s", "µs per triangle", "bytes per triangle", "error curve, s"]
    return table(["cost", "triangles", *head], rows)


def _small(results: Results) -> str:
    """Smallest boundary from which on each limit holds, and the values on both sides of it."""
    histories = [row for device in results["devices"] for row in device["histories"]]
    rows = []
    for text, key, limit in SMALL_LIMITS:
        found = [
            (row["triangles"], row[key])
            for row in (*results["few"], *histories)
            if row["cost"] == "volume"
            and not (key == "bytes_per_triangle" and row["triangles"] <= MEASURABLE_TRIANGLES)
        ]
        largest = max((size for size, value in found if value > limit), default=0)
        smallest = min((size for size, _ in found if size > largest), default=None)
        rows.append(
            [
                text,
                "never" if smallest is None else count_text(smallest),
                _range([value for size, value in found if size > largest], key),
                _range([value for size, value in found if size <= largest], key),
            ]
        )
    return table(["property", "from triangles", "from there", "below"], rows)


def _range(values: list[float], key: str) -> str:
    if not values:
        return "–"
    ends = (min(values), max(values))
    if key == "curve_part":
        return " to ".join(f"{100 * end:.0f} %" for end in ends)
    return " to ".join(f"{end:.1f}" if end < 10 else f"{end:,.0f}" for end in ends)


def _files(results: Results) -> str:
    rows = [
        [
            f"`{row['cost']}`",
            count_text(row["triangles"]),
            count_text(row["bytes"]),
            f"{row['bits_per_vertex']:.1f}",
            f"{row['first_level_ms']:.2f}",
            f"{row['common_level_ms']:.2f}",
            f"{row['all_levels_ms']:.0f}",
        ]
        for row in results["storage"]
    ]
    head = ["bytes", "bits per vertex", "to 4 triangles, ms", "to 1,000, ms", "to all, ms"]
    return table(["cost", "triangles", *head], rows)


def _limits(results: Results) -> str:
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in results["limits"]:
        groups.setdefault((row["cost"], row["limit"]), []).append(row)
    rows = []
    for (cost, limit), group in groups.items():
        coarse = sum(row["coarse"] for row in group)
        excess = sum(row["coarse"] * row["excess"] for row in group) / coarse
        rows.append(
            [
                f"`{cost}`",
                f"`{limit}`",
                f"{excess:.3f} / {max(row['most_excess'] for row in group):.2f}",
                (
                    f"{geometric_mean(row['saved'] for row in group):.2f} / "
                    f"{max(row['most_saved'] for row in group):.1f}"
                ),
                (
                    f"{mean(1e3 * row['median_s'] for row in group):.0f} / "
                    f"{max(1e3 * row['longest_s'] for row in group):.0f}"
                ),
            ]
        )
    return table(["cost", "limit", "excess", "saving", "time, ms"], rows)


def _libraries(results: Results) -> str:
    costs = costs_by_accuracy(results)[::-1]
    peers = dict.fromkeys(row["method"] for row in results["peers"])
    total = len(results["devices"]) * len(COUNTS)
    rows = []
    for method in (*costs, *peers):
        reached = [
            " ".join(row["faults"])
            for row in (*results["levels"], *results["peers"])
            if row["method"] == method and row["asked"] in COUNTS and row["reached"]
        ]
        rows.append(
            [
                f"`{method}`" if method in costs else method,
                *map(percent, mean_errors(results, method, LIBRARY_COUNTS).values()),
                f"{len(reached)} of {total}",
                str(sum(not faults for faults in reached)),
                str(sum("crossings" in faults for faults in reached)),
            ]
        )
    errors = [f"{count:,}, %" for count in LIBRARY_COUNTS]
    faults = ["reached", "valid", "self-intersecting"]
    return table(["method", *errors, *faults], rows)


def _sphere(results: Results) -> str:
    rows = []
    for cost in costs_by_accuracy(results)[::-1]:
        products = [
            max(
                row["product"]
                for row in results["sphere"]
                if row["cost"] == cost and row["asked"] == count
            )
            for count in SPHERE_COUNTS
        ]
        rows.append([f"`{cost}`", *(f"{product:.2f}" for product in products)])
    rows.append(["least possible", *[f"{SPHERE_LIMIT:.2f}"] * len(SPHERE_COUNTS)])
    return table(["triangles", *map(count_text, SPHERE_COUNTS)], rows)


def _methods(results: Results) -> str:
    costs = costs_by_accuracy(results)[::-1]
    rows = []
    for method, sizes in boundary_methods(results).items():
        if method in {"USV, octahedron", "USV, tetrahedron"}:
            continue  # the plot has them
        nearest = [
            min(sizes, key=lambda row: abs(row["triangles"] / count - 1)) for count in METHOD_SIZES
        ]
        rows += [
            [
                method,
                f"{row['triangles']:,.0f}",
                percent(row["mismatch"]),
                f"{100 * row['volume']:+.2f}",
                *(percent(row["decimated"][cost]) for cost in costs),
            ]
            for row in sizes
            if any(row is near for near in nearest)
        ]
    head = [f"`{cost}`, %" for cost in costs]
    return table(["method", "triangles", "mismatch, %", "volume, %", *head], rows)


def _agreement(results: Results) -> str:
    methods = boundary_methods(results)
    usv = sorted(
        (row for name, rows in methods.items() if name.startswith("USV") for row in rows),
        key=lambda row: row["triangles"],
    )
    hull = methods["convex hull"][0]
    drawn = next(row for row in methods["subsampled modified hull"] if row["size"] == 100)

    voxels = max(
        abs(row["voxel_mismatch"] - row["mismatch"]) / row["bound"] for row in results["voxels"]
    )

    def advantage(row: dict[str, Any]) -> str:
        published = row["decimated"][PUBLISHED_COST]
        return (
            f"{100 * (row['mismatch'] - published):.2f} percentage points, "
            f"a factor of {row['mismatch'] / published:.1f}"
        )

    rows = [
        ["comparisons at equal counts in which decimation beats USV",
         f"{sum(row['better'] for row in usv)} of {sum(row['devices'] for row in usv)}"],
        *([f"advantage over USV at {row['triangles']:,.0f} triangles", advantage(row)]
          for row in (usv[0], usv[-1])),
        ["largest difference of a voxel count from the exact mismatch",
         f"{percent(voxels)} % of its bound"],
        ["mismatch of USV with unlimited segments",
         f"{percent(mean(row['mismatch'] for row in results['floors']))} %"],
        ["volume of the convex hull", f"{100 * hull['volume']:+.1f} %"],
        ["volume of the hull of a subsample, 100 triangles", f"{100 * drawn['volume']:+.1f} %"],
        ["least mismatch of segment maxima",
         f"{percent(min(row['mismatch'] for row in methods['segment maxima']))} %"],
    ]  # fmt: skip
    return table(["figure", "mean over the devices"], rows)
