"""What ``docs/decimation.md`` says of speed, memory and stored sizes; as `benchmarks.document`."""

from __future__ import annotations

from benchmarks.markdown import table
from benchmarks.speed import LEVEL
from benchmarks.summary import LOST, Measured

__all__ = ["speed_text"]


def speed_text(measured: Measured) -> str:
    """Return the section on them.

    Parameters
    ----------
    measured : dict
        The content of ``benchmarks/decimation.json``.
    """
    times = [
        [
            f"`{row['cost']}`", f"{row['triangles']:,}", f"{row['seconds']:.2f}",
            f"{row['median_s']:.2f}", f"{row['us_per_triangle']:.2f}", f"{row['curve_s']:.3f}",
            f"{100 * row['curve_part']:.0f} %",
        ]
        for row in measured["history"]
        if "cost" in row
    ]  # fmt: skip
    libraries = [
        [row["peer"], f"{row['level']:,}", f"{row['seconds']:.2f}", f"{row['median_s']:.2f}"]
        for row in measured["history"]
        if "peer" in row
    ]
    scaling = [
        [
            f"`{row['cost']}`", f"{row['triangles']:,}", f"{row['seconds']:.2f}",
            f"{row['us_per_triangle']:.2f}", f"{row['bytes_per_triangle']:.0f}",
            f"{row['curve_s']:.2f}", f"{100 * row['curve_part']:.0f} %",
        ]
        for row in measured["scaling"]
    ]  # fmt: skip
    devices = measured["devices"]
    by_cost = [{row["cost"]: row for row in device["histories"]} for device in devices]
    sizes = [device["triangles"] for device in devices]
    each = [rows["volume"]["us_per_triangle"] for rows in by_cost]
    ratios = [rows["finest"]["seconds"] / rows["volume"]["seconds"] for rows in by_cost]
    few = [
        [
            f"`{row['cost']}`", f"{row['triangles']:,}", f"{1e3 * row['seconds']:.1f}",
            f"{row['us_per_triangle']:.2f}",
            f"{row['bytes_per_triangle']:,.0f}" if row["triangles"] > LOST else "–",
            f"{1e3 * row['curve_s']:.1f}", f"{row['bits_per_vertex']:.0f}",
            f"{row['delivered_bits_per_vertex']:.0f}",
        ]
        for row in measured["few"]
    ]  # fmt: skip
    storage = [
        [
            f"`{row['cost']}`", f"{row['triangles']:,}", f"{row['bytes']:,}",
            f"{row['bits_per_vertex']:.1f}", f"{row['first_level_ms']:.2f}",
            f"{row['common_level_ms']:.2f}", f"{row['all_levels_ms']:.0f}",
        ]
        for row in measured["storage"]
    ]  # fmt: skip
    hubs = {
        cost: {row["ring"]: row["seconds"] for row in measured["hubs"] if row["cost"] == cost}
        for cost in ("volume", "finest")
    }
    parts = [hubs["finest"][ring] / seconds for ring, seconds in hubs["volume"].items()]
    million = measured["million"]
    others = ""
    if libraries:
        others = f"""
Other libraries on the same boundary, asked for one level of {LEVEL:,} triangles:

{table(["library", "triangles", "s", "median, s"], libraries)}
"""
    return f"""\
## Speed and memory

The complete history of the sRGB boundary, all levels down to four triangles, and the error curve that
every build has:

{
        table(
            [
                "cost",
                "triangles",
                "s",
                "median, s",
                "µs per triangle",
                "error curve, s",
                "its part",
            ],
            times,
        )
    }
{others}
By size of the boundary, the time for the boundary itself aside; memory is the growth of a fresh
process at its peak, everything that the history holds included:

{
        table(
            [
                "cost",
                "triangles",
                "s",
                "µs per triangle",
                "bytes per triangle",
                "error curve, s",
                "its part",
            ],
            scaling,
        )
    }

Of the devices' boundaries, with {min(sizes):,} to {max(sizes):,} triangles, `volume` takes
{min(each):.2f} to {max(each):.2f} µs per triangle, and `finest` {min(ratios):.1f} to {
        max(ratios):.1f} times as long.
Of small boundaries the coarse end, which is ordered by samples and gone several ways, is most of the
work, and much the same whatever there was before it: by the triangle they take more time and memory than
is set out for above. So do their error curves beside `quadric`, which takes hardly any time for so
few, and their files, of whose splits most take large steps, and of `finest` move vertices (what less
than {LOST:,} triangles take of memory is lost in what else a process does):

{
        table(
            [
                "cost",
                "triangles",
                "ms",
                "µs per triangle",
                "bytes per triangle",
                "error curve, ms",
                "bits per vertex",
                "with description",
            ],
            few,
        )
    }

Double pyramids, two poles and a ring of {min(hubs["volume"])} to {
        max(hubs["volume"]):,} vertices, are what takes `finest`
longest: {1e3 * min(hubs["finest"].values()):.0f} to {1e3 * max(hubs["finest"].values()):.0f} ms, {
        min(parts):.1f} to {max(parts):.1f} times as long as `volume`.

From {million["points"]:,} surface colours to a boundary of {
        million["triangles"]:,} triangles it takes
{million["boundary_s"]:.1f} s, to its complete history with the default cost {
        million["history_s"]:.1f} s
more: {million["total_s"]:.1f} s.

History files, and the times from their bytes to the first level, to the one of {LEVEL:,}
triangles, and to the full boundary, by which all levels are unpacked and checked, in ms:

{
        table(
            ["cost", "triangles", "bytes", "bits per vertex", "first", f"{LEVEL:,}", "full"],
            storage,
        )
    }
"""
