"""How much of each of several gamuts each other one covers, as a table and a heat map."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore import search
from gamutcore.errors import OptionError
from gamutcore.number_text import volume_unit
from gamutcore.questions import check_space, condition_lines, plot_text, table_warnings
from gamutcore.reports.document import Chart, Report, ReportColumn, ReportTable
from gamutcore.reports.gamuts import (
    GamutSource,
    NamedGamut,
    Progress,
    in_order,
    named_gamuts,
    open_level,
)
from gamutcore.results import CoverageMatrix

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gamutcore.arrays import FloatArray
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.results import Conditions
    from gamutcore.search import LevelIndex

__all__ = ["compare_all", "matrix_report"]

MOST_LABELS = 20
"""Most gamuts whose shares are written into a heat map."""


class _Solid(NamedTuple):
    """The level of a gamut that is compared."""

    name: str
    conditions: Conditions
    colour_space: ColourSpace
    level: LevelIndex


def compare_all(
    gamuts: Iterable[GamutSource],
    *,
    triangles: int | None = None,
    max_error: float | None = None,
    progress: Progress | None = None,
    **options: Any,  # noqa: ANN401  # checked by Options
) -> CoverageMatrix:
    """Compare each of several gamuts with each other one by volume.

    Parameters
    ----------
    gamuts : iterable of Gamut, path or str
        At least two, in the same space. Files and names are opened as by `match`.
    triangles, max_error : optional
        The levels: those of a count, or the smallest within an error of the stored error curve, by
        default 0.2 in CIELAB. A comparison takes some milliseconds per 1,000 triangles.
    progress : callable, optional
        Called with the names of two gamuts, and the fraction of the pairs that are done.
    **options
        How gamuts are built from files and names, as for `Gamut`. An option is for those that it
        applies to, and there must be one.

    Returns
    -------
    CoverageMatrix
        Volumes, intersections and coverage (g, g).

    Raises
    ------
    OptionError
        Fewer than two gamuts are given, they are in different spaces, or an option is not accepted.

    Examples
    --------
    >>> import gamutcore
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> small, large = gamutcore.Gamut(cube), gamutcore.Gamut([(l, 2 * a, b) for l, a, b in cube])
    >>> gamutcore.compare_all([small, large]).coverage.round(3).tolist()
    [[1.0, 0.5], [1.0, 1.0]]
    """
    solids: list[_Solid] = []
    load = partial(_solid, triangles=triangles, max_error=max_error)
    for solid in in_order(load, named_gamuts(gamuts, options)):
        if solids:
            check_space(solids[0], solid)
        solids.append(solid)
    if len(solids) < 2:
        raise OptionError.refusal("gamuts", f"{len(solids)} gamuts", "at least two gamuts")
    common = np.empty((len(solids), len(solids)))
    pairs = list(combinations(range(len(solids)), 2))
    compared = in_order(
        lambda pair: search.compare(solids[pair[0]].level, solids[pair[1]].level, 1), pairs
    )
    for done, ((one, two), found) in enumerate(zip(pairs, compared, strict=True), 1):
        common[one, two] = common[two, one] = found.intersection
        common[one, one], common[two, two] = found.volume_a, found.volume_b
        if progress is not None:
            progress(f"{solids[one].name}, {solids[two].name}", done / len(pairs))
    conditions = {solid.name: solid.conditions for solid in solids}
    return CoverageMatrix(
        gamuts=tuple(conditions),
        volume=common.diagonal().copy(),
        intersection=common,
        space=solids[0].colour_space.name,
        triangles=tuple(len(solid.level.faces) for solid in solids),
        conditions=tuple(conditions.values()),
        warnings=table_warnings(conditions),
    )


def _solid(gamut: NamedGamut, triangles: int | None, max_error: float | None) -> _Solid:
    opened, count = open_level(gamut, triangles=triangles, max_error=max_error)
    mesh, centre = opened.history.level(count), opened.history.centre
    index = search.build_index(mesh.vertices, mesh.faces, centre)
    return _Solid(gamut.name, opened.conditions, opened.colour_space, index)


def matrix_report(matrix: CoverageMatrix) -> Report:
    """Return a matrix as a report, with a heat map."""
    names, coverage = matrix.gamuts, matrix.coverage
    numbers = [str(number) for number in range(1, len(names) + 1)]
    columns = [
        ReportColumn("no.", list(range(1, len(names) + 1))),
        ReportColumn("gamut", names),
        ReportColumn("volume", matrix.volume, volume_unit(matrix.space), decimals=0),
        *(
            ReportColumn(f"covers {name}", coverage[:, at], kind="heat", heading=number)
            for at, (name, number) in enumerate(zip(names, numbers, strict=True))
        ),
    ]
    note = (
        "A cell is the share of the volume of the gamut of its column that the gamut of its row "
        "covers, in per cent."
    )
    return Report(
        f"Coverage of {len(names)} gamuts by each other",
        _sentences(names, matrix.volume, coverage),
        condition_lines(dict(zip(names, matrix.conditions, strict=True))),
        [ReportTable("Coverage", columns, [note])],
        [Chart("Share of the volume of the column that the row covers", partial(_draw, matrix))],
        matrix.warnings,
        matrix.to_dict(),
    )


def _sentences(names: tuple[str, ...], volume: FloatArray, coverage: FloatArray) -> list[str]:
    """Return the largest gamut, and the one that covers most of the others, in words."""
    largest = int(np.argmax(volume))
    others = (coverage.sum(axis=1) - 1.0) / (len(names) - 1)
    widest = int(np.argmax(others))
    apart = coverage + coverage.T + 4.0 * np.eye(len(names))
    one, two = sorted(map(int, np.unravel_index(np.argmin(apart), apart.shape)))
    least = (
        f"{names[one]} and {names[two]} have least in common: they cover "
        f"{100 * coverage[one, two]:.1f} % and {100 * coverage[two, one]:.1f} % of each other."
    )
    return [
        f"{names[largest]} is the largest.",
        f"{names[widest]} covers most of the others: {100 * others[widest]:.1f} % on average.",
        least,
    ]


def _draw(matrix: CoverageMatrix, figure: Figure) -> None:
    """Draw the heat map."""
    count = len(matrix.gamuts)
    side = max(4.5, min(2.5 + 0.45 * count, 24.0))
    figure.set_size_inches(side + 1.0, side)
    axes = figure.add_subplot()
    shares = 100.0 * matrix.coverage
    image = axes.imshow(shares, vmin=0.0, vmax=100.0, cmap="viridis")
    size = 9.0 if count <= MOST_LABELS else max(2.0, 180.0 / count)
    shortened = [name if len(name) <= 24 else f"{name[:23]}…" for name in matrix.gamuts]
    names = list(map(plot_text, shortened))
    axes.set_xticks(range(count), names, rotation=45, ha="right", fontsize=size)
    axes.set_yticks(range(count), names, fontsize=size)
    axes.set_xlabel("covered")
    axes.set_ylabel("covers")
    figure.colorbar(image, ax=axes, label="%", shrink=0.8)
    if count <= MOST_LABELS:
        for (row, column), share in np.ndenumerate(shares):
            colour = "black" if share > 60.0 else "white"
            axes.text(column, row, f"{share:.0f}", ha="center", va="center", color=colour, size=8)
