"""Which of several gamuts print a list of colours, and how near the others come.

A colour meets every gamut in turn: its position and distance, and ΔE00 to the nearest colour that
the gamut has. The answer is advice, and ranks gamuts by the share of the list that they print.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from operator import length_hint
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gamutcore.arguments import Number, check_option
from gamutcore.colour_rows import colour_rows
from gamutcore.colours.spaces import srgb
from gamutcore.errors import DeviceModelError, OptionError, errors_in
from gamutcore.number_text import number_text
from gamutcore.questions import (
    check_space,
    colours_in,
    condition_lines,
    nearest,
    positions,
    table_warnings,
)
from gamutcore.reports.document import Report, ReportColumn, ReportTable
from gamutcore.reports.gamuts import (
    GamutSource,
    NamedGamut,
    Progress,
    in_order,
    named_gamuts,
    open_level,
)
from gamutcore.results import ColourMatch, GamutGroup
from gamutcore.tables import ColourTable, frame_colours, read_table

if TYPE_CHECKING:
    from gamutcore.arrays import BooleanArray, FloatArray, LongArray
    from gamutcore.colour_rows import Colours
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.gamut import Gamut
    from gamutcore.results import ColourRecipes, Conditions

__all__ = ["GamutMatch", "MatchTerms", "gathered_match", "match", "match_gamut", "match_report"]

LIMIT = Annotated[float, Number(0.0, 1e6)]

MOST_EXACT = 20
"""Most gamuts of which all pairs and triples are compared: 1,330 groups."""

NO_POINTS = np.empty((0, 3))

MOST_NAMED = 3
"""Most gamuts whose names are in the sentence on those that print most."""

LONGEST = 24
"""Characters of the name of a gamut as a heading."""

MOST_COLUMNS = 20
"""Most gamuts that have a column in the table of colours."""


class MatchTerms(NamedTuple):
    """How colours are matched; see `match`."""

    passing: float | None = None
    edge_width: float | None = None
    delta_e: bool = True
    recipes: bool = False

    def checked(self) -> MatchTerms:
        """Return the terms with checked limits."""
        passing, edge_width = self.passing, self.edge_width
        if passing is not None:
            passing = check_option("passing", passing, LIMIT)
            if not self.delta_e:
                raise OptionError.not_applicable("passing", passing, "delta_e is false")
        if edge_width is not None:
            edge_width = check_option("edge_width", edge_width, LIMIT)
        return self._replace(passing=passing, edge_width=edge_width)


class GamutMatch(NamedTuple):
    """What one gamut answers, for n colours."""

    name: str
    conditions: Conditions
    colour_space: ColourSpace
    points: FloatArray
    spaces: tuple[str, float]  # of the colours; edge width
    distance: FloatArray
    position: NDArray[Any]
    delta_e: FloatArray | None
    recipes: ColourRecipes | None
    triangles: int


def match(
    colours: Colours | ColourTable | str | os.PathLike[str],
    gamuts: Iterable[GamutSource],
    *,
    passing: float | None = None,
    edge_width: float | None = None,
    delta_e: bool = True,
    recipes: bool = False,
    names: Sequence[str] | None = None,
    space: str | None = None,
    max_error: float | None = None,
    progress: Progress | None = None,
    **options: Any,  # noqa: ANN401  # checked by Options
) -> ColourMatch:
    """Find which gamuts print colours, and how near the others come.

    Parameters
    ----------
    colours : array, table or path
        As for the methods of `Gamut`, or a file of colours in any form that ``gamut query`` reads.
    gamuts : iterable of Gamut, path or str
        In the same space. Saved gamuts are opened one after the other, so hundreds need little
        memory. Other files and names of references are built with the options.
    passing : float, optional
        Largest ΔE00 from the nearest colour of a gamut that counts as printed. By default, colours
        inside and at the edge count.
    edge_width : float, optional
        Largest distance from the surface at the edge; by default 1 in CIELAB.
    delta_e : bool, optional
        Whether to find ΔE00 of colours outside, which takes most of the time.
    recipes : bool, optional
        Whether to find device values, which takes about a second for each gamut.
    names : sequence of str, optional
        Of the colours; by default those of the file, or numbers from 1.
    space : str, optional
        Space of the colours.
    max_error : float, optional
        Largest error of the levels that answer: the smallest level of the stored error curve
        within it. Default: 0.2 in CIELAB. 0: the full boundary.
    progress : callable, optional
        Called with the name of a gamut that has answered, and the fraction of those that are done.
    **options
        How gamuts are built from files and names, as for `Gamut`. An option is for those that it
        applies to, and there must be one.

    Returns
    -------
    ColourMatch
        Arrays (n, g), and the figures of each gamut and of each colour.

    Raises
    ------
    OptionError
        No gamuts are given, they are in different spaces, or an option is not accepted.

    Examples
    --------
    >>> import gamutcore
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> small, large = gamutcore.Gamut(cube), gamutcore.Gamut([(l, 3 * a, b) for l, a, b in cube])
    >>> found = gamutcore.match([(50, 0, 0), (50, 20, 0)], [small, large])
    >>> found.share.tolist(), found.printed_by.tolist(), found.best.tolist()
    ([0.5, 1.0], [2, 1], [0, 1])
    """
    terms = MatchTerms(passing, edge_width, delta_e, recipes).checked()
    values, space, labels = _read_colours(colours, space, names)

    def ask(gamut: NamedGamut) -> GamutMatch:
        opened, count = open_level(gamut, max_error=max_error, whole=recipes)
        return match_gamut(gamut.name, opened, count, values, space, terms)

    answers: list[GamutMatch] = []
    for answer in in_order(ask, named_gamuts(gamuts, options)):
        if answers:
            check_space(answers[0], answer)
        answers.append(answer._replace(points=NO_POINTS) if answers else answer)
        if progress is not None:
            progress(answer.name, len(answers) / max(length_hint(gamuts), len(answers)))
    if not answers:
        raise OptionError.refusal("gamuts", "no gamut", "at least one gamut")
    return gathered_match(answers, labels, terms.passing)


def match_gamut(
    name: str,
    gamut: Gamut,
    triangles: int,
    colours: Colours,
    space: str | None,
    terms: MatchTerms,
) -> GamutMatch:
    """Return what the level of a gamut answers about colours, as `match` does for each."""
    rows, conversion = colours_in(gamut, colours, space)
    width = gamut.default_edge_width if terms.edge_width is None else terms.edge_width
    where = positions(gamut, rows.points, distance=True, edge_width=width, triangles=triangles)
    assert where.distance is not None  # noqa: S101  # asked for
    assert where.position is not None  # noqa: S101  # implied by the edge width
    return GamutMatch(
        name,
        gamut.conditions,
        gamut.colour_space,
        rows.points,
        (conversion.name, width),
        where.distance,
        where.position,
        _differences(gamut, rows.points, where.inside, triangles) if terms.delta_e else None,
        _device_values(gamut, rows.points, triangles) if terms.recipes else None,
        triangles,
    )


def gathered_match(
    answers: Sequence[GamutMatch], labels: Sequence[str] | None, passing: float | None
) -> ColourMatch:
    """Return the answers of all gamuts, which have different names, as columns of arrays."""
    one = answers[0]
    distance = np.stack([each.distance for each in answers], axis=1)
    position = np.stack([each.position for each in answers], axis=1)
    known = [each.delta_e for each in answers if each.delta_e is not None]
    delta_e = np.stack(known, axis=1) if known else None
    recipes = tuple(each.recipes for each in answers)
    prints: BooleanArray = position != "outside"
    if passing is not None and delta_e is not None:
        prints = delta_e <= passing
    gamuts = {each.name: each.conditions for each in answers}
    space, width = one.spaces
    excess = np.maximum(distance, 0.0) if delta_e is None else delta_e
    return ColourMatch(
        colours=tuple(map(str, range(1, 1 + len(distance))) if labels is None else labels),
        gamuts=tuple(gamuts),
        points=one.points,
        space=one.colour_space.name,
        distance=distance,
        position=position,
        delta_e=delta_e,
        prints=prints,
        passing=passing,
        edge_width=width,
        together=tuple(_together(tuple(gamuts), prints, excess)),
        recipes=recipes if any(recipes) else (),
        triangles=tuple(each.triangles for each in answers),
        conditions=tuple(gamuts.values()),
        warnings=table_warnings(gamuts, space),
    )


def _read_colours(
    colours: Any,  # noqa: ANN401  # as `match` takes them
    space: str | None,
    names: Sequence[str] | None,
) -> tuple[Any, str | None, Sequence[str] | None]:
    """Return colours as the methods of a gamut take them, their space and their names."""
    if isinstance(colours, str | os.PathLike):
        with errors_in(colours):
            colours = read_table(Path(colours).read_bytes(), space=space)
    if isinstance(colours, ColourTable):
        names = list(colours.labels()) if names is None else names
        colours, space = colours.points, colours.space
    if frame_colours(colours, space, "CIELAB") is None:
        colours = colour_rows(colours).points
    if names is not None and len(names) != len(colours):
        raise OptionError.refusal("names", f"{len(names)} names", f"{len(colours)} names")
    return colours, space, names


def _differences(
    gamut: Gamut, points: FloatArray, inside: BooleanArray, triangles: int
) -> FloatArray:
    """Return ΔE00 from the nearest colour in gamut; nearest by the distance in other spaces."""
    metric = "CIE 2000" if gamut.colour_space.is_icc_cielab else "CIE 1976"
    values = np.zeros(len(points))
    outside = ~inside
    if outside.any():
        near = nearest(gamut, points[outside], metric=metric, triangles=triangles)
        values[outside] = near.delta_e
    return values


def _device_values(gamut: Gamut, points: FloatArray, triangles: int) -> ColourRecipes | None:
    with contextlib.suppress(DeviceModelError):  # a mesh, a picture, or saved by an older version
        return gamut.to_device(points, triangles=triangles)
    return None


def _together(
    gamuts: tuple[str, ...], prints: BooleanArray, excess: FloatArray
) -> Iterator[GamutGroup]:
    """Yield the pair and the triple that print most; of equal ones, that with the least excess."""
    covers, misses = np.ascontiguousarray(prints.T), np.ascontiguousarray(excess.T)

    def merit(group: tuple[int, ...]) -> tuple[int, float]:
        rows = list(group)
        return int(covers[rows].any(axis=0).sum()), -float(misses[rows].min(axis=0).sum())

    numbers = range(len(gamuts))
    chosen: tuple[int, ...] = max(((one,) for one in numbers), key=merit)
    exact = len(gamuts) <= MOST_EXACT
    for size in (2, 3):
        if size > len(gamuts):
            return
        groups: Iterable[tuple[int, ...]] = combinations(numbers, size)
        if not exact:
            groups = ((*chosen, one) for one in numbers if one not in chosen)
        chosen = max(groups, key=merit)
        yield GamutGroup(tuple(gamuts[one] for one in chosen), merit(chosen)[0], exact)


def match_report(match: ColourMatch) -> Report:
    """Return a match as a report: text, CSV, JSON, a workbook, a page or PDF.

    The tables are of the gamuts, the best first, and of the colours. CSV has a row for each colour
    and gamut.
    """
    order = sorted(
        range(len(match.gamuts)), key=lambda at: (-match.share[at], match.excess[:, at].sum())
    )
    gamuts = dict(zip(match.gamuts, match.conditions, strict=True))
    tolerance = (
        f"colours inside, or at most {number_text(match.edge_width)} from the surface (the edge)"
        if match.passing is None
        else f"colours with ΔE00 up to {number_text(match.passing)} from the nearest colour"
    )
    return Report(
        "Which gamut prints these colours",
        _sentences(match, order),
        {"Prints": tolerance, **condition_lines(gamuts)},
        [_gamut_table(match, order), _colour_table(match, order)],
        warnings=match.warnings,
        data=match.to_dict(),
        rows=_pair_table(match),
    )


def _sentences(match: ColourMatch, order: list[int]) -> list[str]:
    """Return the answer in words: the best gamut, what none prints, and the groups."""
    count, one = len(match.colours), order[0]
    printed = np.count_nonzero(match.prints, axis=0)
    words = [_most(match, order, printed)]
    nowhere = np.flatnonzero(match.printed_by == 0)
    if len(nowhere):
        worst = nowhere[np.argsort(-match.excess[nowhere].min(axis=1), kind="stable")]
        shown = ", ".join(
            f"{match.colours[at]} (nearest: {match.gamuts[match.best[at]]})" for at in worst[:3]
        )
        words.append(
            f"{len(nowhere)} {'is' if len(nowhere) == 1 else 'are'} printed by none: {shown}"
            + (f" and {len(nowhere) - 3} more" if len(nowhere) > 3 else "")
        )
    most = int(printed[one])
    for group in match.together:
        if group.printed <= most:
            break
        names = f"{', '.join(group.gamuts[:-1])} and {group.gamuts[-1]}"
        size = {2: "pairs", 3: "triples"}[len(group.gamuts)]
        how = (
            f"all {size} were compared"
            if group.exact
            else f"found by adding one gamut at a time, so other {size} may print more"
        )
        words.append(f"Together, {names} print {group.printed} ({how})")
        most = group.printed
    else:
        return [f"{sentence}." for sentence in words]
    if len(order) > 1 and most < count:
        words.append(f"{'No further' if len(words) > 2 else 'No other'} gamut adds a colour")
    return [f"{sentence}." for sentence in words]


def _most(match: ColourMatch, order: list[int], printed: LongArray) -> str:
    """Return which gamuts print most colours, in words."""
    count, most = len(match.colours), int(printed[order[0]])
    of_all = f", the most of {len(order)} gamuts" if len(order) > 1 else ""
    if not most:
        which = "No gamut" if len(order) > 1 else match.gamuts[order[0]]
        return f"{which} prints {'any' if len(order) > 1 else 'none'} of {count} colours"
    best = [match.gamuts[at] for at in order if printed[at] == most]
    if len(best) == 1:
        return f"{best[0]} prints {most} of {count} colours{of_all}"
    if len(best) == len(order):
        of_all = ""
    names = f"{', '.join(best[:-1])} and {best[-1]}" if len(best) <= MOST_NAMED else ""
    return f"{names or f'{len(best)} gamuts'} print {most} of {count} colours each{of_all}"


def _gamut_table(match: ColourMatch, order: list[int]) -> ReportTable:
    def of(values: Any) -> list[Any]:  # noqa: ANN401
        return [values[at] for at in order]

    columns = [
        ReportColumn("gamut", of(match.gamuts)),
        ReportColumn("prints", of(match.share), kind="share"),
        ReportColumn("colours", of(np.count_nonzero(match.prints, axis=0))),
    ]
    if match.mean_delta_e is not None and match.percentile_95 is not None:
        columns += [
            ReportColumn("mean ΔE00", of(match.mean_delta_e)),
            ReportColumn("95 % ΔE00", of(match.percentile_95)),
        ]
    worst = [
        ", ".join(f"{match.colours[at]} {match.excess[at, gamut]:.1f}" for at in match.worst(gamut))
        for gamut in order
    ]
    columns.append(ReportColumn("worst", worst))
    notes = ["Mean and 95th percentile are over all colours, 0 for those in gamut."]
    return ReportTable("Gamuts", columns, notes if match.delta_e is not None else ())


def _colour_table(match: ColourMatch, order: list[int]) -> ReportTable:
    best = match.best
    rows = np.arange(len(best))
    least = match.excess[rows, best]
    unit = "ΔE76" if match.delta_e is None else "ΔE00"
    columns = [ReportColumn("colour", match.colours)]
    if match.space == "CIELAB":
        colours = np.rint(255 * srgb(match.points)).astype(int)
        columns.append(
            ReportColumn("", [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in colours], kind="colour")
        )
    columns += [
        ReportColumn("printed by", match.printed_by),
        ReportColumn("best", [match.gamuts[at] for at in best]),
        ReportColumn(f"its {unit}", least),
    ]
    notes = []
    if len(order) <= MOST_COLUMNS:
        columns += [
            ReportColumn(name, match.excess[:, at], heading=_heading(name))
            for at, name in ((at, match.gamuts[at]) for at in order)
        ]
        notes.append(
            f"The columns of gamuts have {unit} from the nearest colour of the gamut, 0 in gamut."
        )
    return ReportTable("Colours", columns, notes)


def _heading(name: str) -> str:
    return name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}…"


def _pair_table(match: ColourMatch) -> ReportTable:
    """Return a row for each colour and gamut."""
    count, gamuts = match.distance.shape
    columns = [
        ReportColumn("colour", [name for name in match.colours for _ in range(gamuts)]),
        ReportColumn("gamut", match.gamuts * count),
        ReportColumn("prints", match.prints.ravel()),
        ReportColumn("position", match.position.ravel()),
        ReportColumn("distance", match.distance.ravel()),
    ]
    if match.delta_e is not None:
        columns.append(ReportColumn("delta_e_2000", match.delta_e.ravel()))
    if any(match.recipes):
        texts = [
            [""] * count
            if recipes is None
            else [
                " ".join(
                    f"{name} {value:.1f}" for name, value in zip(recipes.channels, row, strict=True)
                )
                for row in 100.0 * recipes.device
            ]
            for recipes in match.recipes
        ]
        columns.append(
            ReportColumn("recipe", [text for row in zip(*texts, strict=True) for text in row])
        )
    return ReportTable("Colours and gamuts", columns)
