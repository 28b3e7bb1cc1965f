"""What the documents say of the measurements: means over devices, best peers, goals.

Works on the content of ``benchmarks/decimation.json`` alone, so that whoever reads that file gets
the same tables.
"""

from __future__ import annotations

from collections.abc import Iterable
from statistics import mean
from typing import Any, NamedTuple

__all__ = [
    "GOAL_COUNTS",
    "LOST",
    "HeldFrom",
    "best_peer",
    "costs_by_accuracy",
    "families",
    "goals",
    "level_errors",
    "mean_errors",
    "ratios",
    "smaller_boundaries",
]

Measured = dict[str, Any]

GOAL_COUNTS = (1000, 500, 100, 50, 20)
"""Triangle counts that accuracy is claimed for."""

LOST = 2000
"""The memory that the histories of fewer triangles take is not told from what a process takes for
other things in the meantime."""

YARDSTICK = "quadric"
"""The published cost, which the others are compared to."""

RATIO_GOALS = {
    "volume": {1000: 0.53, 500: 0.53, 100: 0.58, 50: 0.58, 20: 0.58},
    "finest": {1000: 0.44, 500: 0.44, 100: 0.48, 50: 0.48, 20: 0.48},
}
"""Mean mismatch relative to the yardstick's, at most."""

SPHERE_GOALS = {"volume": 3.0, "finest": 2.4}
"""Mismatch × triangles on a sphere at 1000 triangles, at most."""


def level_errors(measured: Measured, method: str, count: int) -> dict[str, float]:
    """Mismatches of a cost or peer at a triangle count, by device; where it has one."""
    rows = [*measured["levels"], *measured["peers"]]
    return {
        row["device"]: row["mismatch"]
        for row in rows
        if row["method"] == method
        and row["asked"] == count
        and row["reached"]
        and row["mismatch"] is not None
    }


def ratios(measured: Measured, method: str, count: int) -> dict[str, float]:
    """Mismatches relative to the yardstick's at a triangle count, by device."""
    least = level_errors(measured, YARDSTICK, count)
    return {
        name: error / least[name] for name, error in level_errors(measured, method, count).items()
    }


def costs_by_accuracy(measured: Measured) -> list[str]:
    """Names of the costs, the least accurate at 1000 triangles first."""

    def error(cost: str) -> float:
        return mean(level_errors(measured, cost, 1000).values())

    return sorted(measured["costs"], key=error, reverse=True)


def best_peer(measured: Measured, device: str, count: int) -> tuple[str, float] | None:
    """Name and mismatch of the most accurate other library for a device and count."""
    rows = [
        (row["mismatch"], row["method"])
        for row in measured["peers"]
        if row["device"] == device
        and row["asked"] == count
        and row["reached"]
        and row["mismatch"] is not None
    ]
    return (min(rows)[1], min(rows)[0]) if rows else None


def mean_errors(measured: Measured, method: str, counts: Iterable[int]) -> dict[int, float]:
    """Mean mismatch of a cost over all devices, by triangle count."""
    return {count: mean(level_errors(measured, method, count).values()) for count in counts}


def families(measured: Measured) -> dict[str, list[dict[str, Any]]]:
    """Means over the devices for every size of the other methods.

    Returns
    -------
    dict of list of dict
        By method, in the order of size: ``size``, ``triangles``, ``mismatch``, ``volume``,
        ``decimated`` (mean mismatch by cost at the same counts), ``better`` (devices on which the
        yardstick is more accurate), ``devices``. Sizes that fail on a device are left out.
    """
    groups: dict[tuple[str, int], list[dict[str, Any]]] = {}
    for row in measured["others"]:
        # all colours are all colours: devices have slightly different numbers of them
        whole = row["method"] == "convex hull"
        groups.setdefault((row["method"], 0 if whole else row["size"]), []).append(row)
    names = {each["name"] for each in measured["devices"]}
    found: dict[str, list[dict[str, Any]]] = {}
    for (method, size), rows in sorted(groups.items()):
        if {row["device"] for row in rows} != names:
            continue
        found.setdefault(method, []).append(
            {
                "size": size,
                "triangles": mean(row["triangles"] for row in rows),
                "mismatch": mean(row["mismatch"] for row in rows),
                "volume": mean(row["volume"] for row in rows),
                "decimated": {
                    cost: mean(row["decimated"][cost] for row in rows) for cost in measured["costs"]
                },
                "better": sum(row["decimated"][YARDSTICK] < row["mismatch"] for row in rows),
                "devices": len(rows),
            }
        )
    return found


def goals(measured: Measured) -> list[tuple[str, str, bool]]:
    """What was set out for, what was measured, and whether it is enough."""
    return [
        *_accuracy_goals(measured),
        *_peer_goals(measured),
        *_speed_goals(measured),
        *_storage_goals(measured),
        *_device_goals(measured),
        *_limit_goals(measured),
    ]


def _accuracy_goals(measured: Measured) -> list[tuple[str, str, bool]]:
    found = []
    for cost in costs_by_accuracy(measured):
        limits = RATIO_GOALS.get(cost, {})
        for limit in sorted(set(limits.values())):
            counts = [count for count in limits if limits[count] == limit]
            values = [mean(ratios(measured, cost, count).values()) for count in counts]
            found.append(
                (
                    f"`{cost}` ÷ `{YARDSTICK}` at {', '.join(map(str, counts))} ≤ {limit}",
                    ", ".join(f"{value:.3f}" for value in values),
                    max(values) <= limit,
                )
            )
        if cost in SPHERE_GOALS:
            products = {
                row["points"]: row["product"]
                for row in measured["sphere"]
                if row["cost"] == cost and row["asked"] == 1000
            }
            found.append(
                (
                    f"sphere of 10,000 vertices, `{cost}`: mismatch × 1000 ≤ {SPHERE_GOALS[cost]}",
                    ", ".join(f"{value:.2f} ({name})" for name, value in products.items()),
                    max(products.values()) <= SPHERE_GOALS[cost],
                )
            )
    return found


def _peer_goals(measured: Measured) -> list[tuple[str, str, bool]]:
    found = []
    for cost in costs_by_accuracy(measured):
        if cost == YARDSTICK:
            continue
        compared, worse = 0, []
        for count in GOAL_COUNTS:
            for device, error in level_errors(measured, cost, count).items():
                best = best_peer(measured, device, count)
                compared += best is not None
                if best is not None and error > best[1]:
                    worse.append(f"{device} at {count} ({error / best[1]:.2f} × {best[0]})")
        if compared:
            found.append(
                (
                    f"`{cost}` no worse than the best peer, every device, every count",
                    f"{compared - len(worse)} of {compared}"
                    + (f"; not {', '.join(worse)}" if worse else ""),
                    not worse,
                )
            )
    return found


def _times_of_finest(measured: Measured) -> list[float]:
    """Times of `finest` relative to `volume`: devices, sRGB, small, hubs and large boundaries."""
    rows = [row for device in measured["devices"] for row in device["histories"]]
    rows += [row for part in ("history", "few", "hubs", "scaling") for row in measured[part]]
    # each is timed with all costs, one after the other
    volume, finest = (
        [row["seconds"] for row in rows if row.get("cost") == cost] for cost in ("volume", "finest")
    )
    return [slow / fast for slow, fast in zip(finest, volume, strict=True)]


def _speed_goals(measured: Measured) -> list[tuple[str, str, bool]]:
    found = []
    times = {row["cost"]: row["seconds"] for row in measured["history"] if "cost" in row}
    vtk = [row["seconds"] for row in measured["history"] if row.get("peer") == "VTK"]
    if "volume" in times:
        found.append(
            ("complete sRGB history, `volume` ≤ 0.45 s", f"{times['volume']:.2f} s",
             times["volume"] <= 0.45)
        )  # fmt: skip
    if "volume" in times and vtk:
        found.append(
            ("less than VTK takes for one level", f"{times['volume']:.2f} s against {vtk[0]:.2f} s",
             times["volume"] < vtk[0])
        )  # fmt: skip
    if "finest" in times:
        parts = _times_of_finest(measured)
        shown = f"{times['finest'] / times['volume']:.1f} × on sRGB, {min(parts):.1f} to"
        found.append(
            (f"`finest` ≤ 10 × the time of `volume`, on all {len(parts)} boundaries measured",
             f"{shown} {max(parts):.1f} ×", max(parts) <= 10)
        )  # fmt: skip
    rows = [row for row in measured["scaling"] if row["cost"] == "volume"]
    each = [row["us_per_triangle"] for row in rows]
    memory = [row["bytes_per_triangle"] for row in rows]
    shown = ", ".join(f"{row['triangles'] / 1e6:.2f}M" for row in rows)
    found += [
        (f"µs per triangle at {shown} ≤ 2, `volume`", ", ".join(f"{t:.2f}" for t in each),
         max(each) <= 2),
        ("bytes per triangle at these ≤ 400, `volume`", ", ".join(f"{b:.0f}" for b in memory),
         max(memory) <= 400),
        ("1M surface points to boundary and history ≤ 8 s",
         f"{measured['million']['total_s']:.1f} s", measured["million"]["total_s"] <= 8),
    ]  # fmt: skip
    return found


def _storage_goals(measured: Measured) -> list[tuple[str, str, bool]]:
    found = []
    for row in measured["storage"]:
        bits, opening = row["bits_per_vertex"], row["first_level_ms"]
        found += [
            (f"history file, `{row['cost']}` ≤ 110 bits per vertex", f"{bits:.1f}", bits <= 110),
            (f"first level of {row['triangles']:,} triangles, `{row['cost']}` ≤ 60 ms",
             f"{opening:.2f} ms", opening <= 60),
        ]  # fmt: skip
    return found


def _device_goals(measured: Measured) -> list[tuple[str, str, bool]]:
    rows = [row for device in measured["devices"] for row in device["histories"]]
    larger = [row for row in measured["scaling"] if row["triangles"] > max(_sizes(rows))]
    where = f"on {len(measured['devices'])} devices"
    curves = f"error curve {where} and of {len(_sizes(larger))} larger boundaries"
    found = []
    for unit, limit, form in (("us_per_triangle", 2, ".2f"), ("bytes_per_triangle", 400, ".0f")):
        each = [row[unit] for row in rows if row["cost"] == "volume"]
        name = unit.replace("us", "µs").replace("_", " ")
        found.append(
            (f"{name} {where} ≤ {limit}, `volume`",
             f"{min(each):{form}} to {max(each):{form}}", max(each) <= limit)
        )  # fmt: skip
    for cost in measured["costs"]:
        each = [row["bits_per_vertex"] for row in rows if row["cost"] == cost]
        parts = [100 * row["curve_part"] for row in rows + larger if row["cost"] == cost]
        found += [
            (f"history files {where} ≤ 110 bits per vertex, `{cost}`",
             f"{min(each):.0f} to {max(each):.0f}", max(each) <= 110),
            (f"{curves} ≤ 30 % of the decimation, `{cost}`",
             f"{min(parts):.0f} to {max(parts):.0f} %", max(parts) <= 30),
        ]  # fmt: skip
    return found


def _sizes(rows: list[dict[str, Any]]) -> set[int]:
    return {row["triangles"] for row in rows}


class HeldFrom(NamedTuple):
    """From which size on a limit is kept by boundaries smaller than those of devices.

    Attributes
    ----------
    limit : str
    size : int or None
        Triangles of the smallest boundary from which on all keep it; None if none does.
    kept, broken : str
        What was measured there, and on the smaller ones.
    """

    limit: str
    size: int | None
    kept: str
    broken: str


def smaller_boundaries(measured: Measured) -> list[HeldFrom]:
    """Limits by the triangle, by the vertex and by the part, where fixed parts count."""

    def of(cost: str, rows: list[dict[str, Any]], value: str) -> list[tuple[int, float]]:
        return [(row["triangles"], row[value]) for row in rows if row.get("cost") == cost]

    rows = [row for device in measured["devices"] for row in device["histories"]]
    rows += measured["few"]
    heavy = [row for row in rows if row["triangles"] > LOST]
    curves = [{**row, "percent": 100 * row["curve_part"]} for row in rows]
    found = [
        _held_from("2 µs per triangle, `volume`", of("volume", rows, "us_per_triangle"), 2, ".1f"),
        _held_from("400 bytes per triangle, `volume`",
                   of("volume", heavy, "bytes_per_triangle"), 400, ",.0f"),
    ]  # fmt: skip
    for cost in measured["costs"]:
        bits, percents = of(cost, rows, "bits_per_vertex"), of(cost, curves, "percent")
        delivered = of(cost, measured["few"], "delivered_bits_per_vertex")
        found += [
            _held_from(f"110 bits per vertex, `{cost}`", bits, 110, ".0f"),
            _held_from(f"with the description, `{cost}`", delivered, 110, ".0f"),
            _held_from(f"error curve 30 % of the decimation, `{cost}`", percents, 30, ".0f"),
        ]
    return found


def _held_from(name: str, measured: list[tuple[int, float]], limit: float, form: str) -> HeldFrom:
    beyond = max((size for size, value in measured if value > limit), default=0)

    def told(keeps: bool) -> str:
        values = [value for size, value in measured if (size > beyond) == keeps]
        ends = dict.fromkeys(f"{end(values):{form}}" for end in (min, max)) if values else ["–"]
        return " to ".join(ends)

    kept_from = min((size for size, _ in measured if size > beyond), default=None)
    return HeldFrom(name, kept_from, told(True), told(False))


def _limit_goals(measured: Measured) -> list[tuple[str, str, bool]]:
    rows = measured["limits"]
    asked = sum(row["coarse"] for row in rows)
    excess = sum(row["coarse"] * row["excess"] for row in rows) / asked
    return [
        (
            (
                "`max_error`, `max_mismatch`: triangles ÷ those of the smallest level that keeps "
                f"the limit, mean of {asked} ≤ 1.01"
            ),
            f"{excess:.3f}, at most {max(row['most_excess'] for row in rows):.2f}",
            excess <= 1.01,
        )
    ]
