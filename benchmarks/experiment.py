"""What the document says of the published experiment: the methods' table, verdicts, pictures."""

from __future__ import annotations

from statistics import mean

from benchmarks.markdown import count_text, percent, table
from benchmarks.paper import CURVE_COUNTS
from benchmarks.summary import YARDSTICK, Measured, costs_by_accuracy, families, mean_errors

__all__ = ["experiment_text", "pictures_text"]


def experiment_text(measured: Measured) -> str:
    """Return the section on the published experiment, as Markdown."""
    found = families(measured)
    costs = costs_by_accuracy(measured)
    rows = [
        [
            method,
            f"{row['size']:,}" if row["size"] else "all",
            f"{row['triangles']:,.0f}",
            percent(row["mismatch"]),
            f"{100 * row['volume']:+.2f}",
            *(percent(row["decimated"][cost]) for cost in costs),
            f"{row['mismatch'] / row['decimated'][YARDSTICK]:.1f}",
        ]
        for method, sizes in found.items()
        for row in sizes
    ]
    return f"""\
## The published experiment

Bakke and Farup ("Simplified Gamut Boundary Representation using Mesh Decimation") compare the methods
below on five devices by a mismatch counted in voxels. Here are the same methods on
{
        len(measured["devices"])
    } devices, with exact mismatches: decimation with the published cost and with
ours; *uniform segment visualization* (USV) on three bodies at all sizes up to about 10,000 triangles;
segment maxima; the convex hull; and the modified hull of a subsample of the colours, drawn at random
so that it has as many triangles as asked for (three draws each).

![Mean mismatch by triangle count](pictures/mismatch.svg)

The dotted line is the least that a sphere needs; gamuts have sides that are nearly flat, and less will do.

Means over the devices. Decimation is read at exactly the triangle count that the other method came out
with on each device; the last column is the method's mismatch ÷ that of decimation with the published
cost.

{
        table(
            [
                "method",
                "size",
                "triangles",
                "mismatch, %",
                "volume, %",
                *(f"`{cost}` there, %" for cost in costs),
                f"÷ `{YARDSTICK}`",
            ],
            rows,
        )
    }

Counted in voxels, as published (256 along the largest extent), decimation with the published cost is
measured as follows, mean over the devices:

{_voxels(measured)}

### What agrees with the publication, and what does not

{_verdicts(measured)}
"""


def _voxels(measured: Measured) -> str:
    counts = sorted({row["asked"] for row in measured["voxels"]}, reverse=True)
    rows = []
    for name, key in (
        ("exact, %", "mismatch"),
        ("in voxels, %", "voxel_mismatch"),
        ("bound of the difference, %", "bound"),
    ):
        by_count = [[row[key] for row in measured["voxels"] if row["asked"] == n] for n in counts]
        rows.append([name, *(percent(mean(each)) for each in by_count)])
    farthest = max(
        abs(row["voxel_mismatch"] - row["mismatch"]) / row["bound"] for row in measured["voxels"]
    )
    return f"""\
{table(["triangles", *map(count_text, counts)], rows)}

No count is farther from the exact value than {100 * farthest:.1f} % of its bound."""


def _verdicts(measured: Measured) -> str:
    found = families(measured)
    usv = sorted(
        (row for name, rows in found.items() if name.startswith("USV") for row in rows),
        key=lambda row: row["triangles"],
    )
    pairs = sum(row["devices"] for row in usv)
    better = sum(row["better"] for row in usv)
    few, many = usv[0], usv[-1]
    gaps = [100 * (row["mismatch"] - row["decimated"][YARDSTICK]) for row in usv]
    factors = [row["mismatch"] / row["decimated"][YARDSTICK] for row in usv]
    floor = {
        name: 100 * mean(row[name] for row in measured["floors"]) for name in ("mismatch", "volume")
    }
    hull = found["convex hull"][0]
    drawn = {row["size"]: row for row in found["subsampled modified hull"]}
    segments = min(found["segment maxima"], key=lambda row: row["mismatch"])
    agree = "Agrees" if better == pairs else "Agrees with exceptions"
    most = "Agrees" if gaps[0] == max(gaps) else "Does not agree"
    ratio = "Agrees" if factors[0] == max(factors) else "Does not agree"
    errors = mean_errors(measured, YARDSTICK, CURVE_COUNTS)
    return f"""\
- *Decimation is better than USV at every triangle count.* {agree}: the published cost has the smaller
  mismatch in {better} of {pairs} comparisons at equal counts (every body, size and device).
- *Most at few triangles.* {most}, in the terms of its Figure 8: the difference in mean mismatch is
  {gaps[0]:.1f} percentage points at {few["triangles"]:.0f} triangles and {gaps[-1]:.2f} at
  {many["triangles"]:,.0f}. {ratio} as a ratio: USV's mismatch is {factors[0]:.1f} times that of
  decimation at {few["triangles"]:.0f} triangles and {factors[-1]:.0f} times at
  {many["triangles"]:,.0f}, because decimation goes on falling nearly as 1 ÷ n
  (from {100 * errors[100]:.2g} % at 100 triangles to {100 * errors[10_000]:.2g} % at 10,000) while USV
  levels off.
- *Why USV levels off.* It wraps its points with γ = 0.05, the reference with γ = 0.2: the two differ by
  {floor["mismatch"]:.2f} % in the mean even with all colours ({floor["volume"]:+.2f} % of
  volume), so no number of segments gets below that. Above it USV is limited by its even segments, which
  meet edges and corners of a gamut only by chance; below about 1,000 triangles it is this that counts.
- *The convex hull overstates gamuts:* by {100 * hull["volume"]:.1f} % in the mean with
  {hull["triangles"]:,.0f} triangles; decimation with as many has a mismatch of
  {100 * hull["decimated"][YARDSTICK]:.2g} %.
- *Wrapping a subsample is no simplification.* The modified hull of as many random colours as give 1,000
  triangles has a mismatch of {percent(drawn[1000]["mismatch"])} %, of those that give 100
  {percent(drawn[100]["mismatch"])} %: {drawn[1000]["mismatch"] / errors[1000]:.0f} and
  {drawn[100]["mismatch"] / errors[100]:.0f} times that of decimation. It misses volume
  ({100 * drawn[100]["volume"]:+.1f} % at 100) because the corners of the gamut are rarely drawn.
- *Segment maxima* come down to {percent(segments["mismatch"])} % at
  {segments["triangles"]:,.0f} triangles and no further: every maximum is on the
  surface, as with γ → 0, so narrow segments follow concavities and the spacing of the colours that the
  reference bridges.
- *Other conditions.* Five devices there, {len(measured["devices"])} here; voxels there, exact volumes
  here. What is compared are the publication's conclusions, not its digits.
"""


def pictures_text(measured: Measured) -> str:
    """Return the section with the pictures, as Markdown."""
    names = [each["name"] for each in measured["devices"]]
    shown = [
        (name, file)
        for name, file in (
            ("FOGRA39L", "levels-fogra39l"), ("phone", "levels-phone"), ("sRGB", "levels-srgb"),
        )
        if name in names
    ]  # fmt: skip
    parts = [f"![{name} at 10,000 to 10 triangles](pictures/{file}.png)" for name, file in shown]
    images = "\n\n".join(parts)
    return f"""\
### Pictures

The publication's Figure 7 shows a gamut at 10,000, 1,000, 500, 100, 50 and 10 triangles; these are
{", ".join(name for name, _ in shown)}, with the default cost. Lightness points upwards, every point is
shown in its own colour, as far as sRGB has it, with its triangles' edges.

{images}

{names[0]} by all methods, at about as many triangles as USV has with 80 segments:

![One gamut by all methods](pictures/methods-fogra39l.png)
"""
