"""The inverse device model: colours to device values, for one rule of black.

A press of four inks has a path of recipes for a colour (`gamutcore.recipes.black_paths`). Presses
with more inks have sets of three chromatic inks and black: cyan, magenta and yellow, neighbours on
the hue circle, and others. A recipe is the mean of the sets that give the colour, weighted by the
width of their range of black. It is corrected on the device model itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.colours import BLACK_NAMES, find_values
from gamutcore.errors import DeviceModelError, OptionError
from gamutcore.number_text import number_text
from gamutcore.recipes.black_paths import (
    GCR,
    LEAST_INK,
    LONGEST_STEP,
    WANTED,
    InkTable,
    correct_recipes,
    ink_table,
    trace_paths,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.arrays import BooleanArray, FloatArray, LongArray
    from gamutcore.colours import DeviceModel

__all__ = ["BlackRule", "InverseModel", "Recipes"]

_THREE, _FOUR, _MORE = (33, 1), (17, 17), (13, 17)
"""Nodes along each chromatic ink, and levels of black, for devices of three, four and more
channels: 36,000, 84,000 and 24,000 evaluations of the device model for each set."""

_MOST_OTHERS = 16
"""Largest number of sets beside the tiles: all that six chromatic inks have."""

_CONVERGED_DE = 0.002
"""Largest difference of L*, a* and b* from the target at which a recipe is not corrected."""

_CORRECTIONS = 8
"""Largest number of corrections. Most recipes need two; those of colours at the surface, more."""

_RETRY_ABOVE_DE = 0.02
"""Largest difference of L*, a* and b* at which no other solution is searched."""

_LARGEST = 1000.0
"""Largest magnitude of L*, a* and b* of a table; that of lights is below 300."""

_RANKS = (0, 1, 2, 4, 7, 12, 20, 35)
"""Nodes from which missed solutions are searched, by their rank of nearness. Gaps between the ranks
lead to other branches."""

_ROUNDING = 1e-9
"""Rounding error of a sum of inks."""

_EXTRA_INK = 4.0
"""Cost of an ink beside cyan, magenta and yellow. These are preferred where both give a colour,
because choices between similar costs jump."""

_OUTSIDE_CMY_COST = 1e3
"""Cost of leaving cyan, magenta and yellow, more than of any recipe."""

_WIDE = 0.7
"""Width of the range of black from which a set counts fully."""

_WHITE = 1e-3
"""The same of white, at least."""

_END = 1e-4
"""Weight of a set at its end, where it may be the only one."""

_LEAST_WEIGHT = 1e-12
"""Sum of weights below which no set gives a colour."""

_AROUND = 4.0 * np.array([(0, 0, 0), (1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / 3**0.5
"""Differences in CIELAB of the colours whose recipes are averaged."""

_SLOPE = 1e-3
"""Step of numerical derivatives by device values."""

_DAMPED = 1e-3
"""Damping of steps, in the squared units of the slopes."""

_SETTLING = 16
"""Largest number of steps of mixed recipes."""

_ENTRY = 0.05
"""Freedom of unused inks in steps after the first `_CORRECTIONS`: a colour may need them."""

_NEIGHBOURS = 24
"""Nearest nodes whose mean starts the search for a colour that no set gives."""

_SUM_WEIGHT = 60.0
"""Weight of the sum of inks beside L*, a* and b*: ΔE*ab of a full ink, about."""

_NO_STARTS: FloatArray = np.empty((0, 4))
"""No starts: solutions are searched in all layers."""

_NEUTRAL = np.arange(0.0, 99.5, 0.5)
"""L* of the neutral colours of which the darkest is sought."""


class BlackRule(NamedTuple):
    """How much black a recipe has: a rule of `gamutcore.recipes.black_paths` and its number.

    `curve` (p, 2) has numbers of the rule, 0 to 1, at ascending L*. For `GCR` it ascends by depth
    instead, which is 0 at L* 100 and 1 at the darkest neutral colour of the device. The numbers
    are halved at the chroma C* of `width`.
    """

    rule: int
    share: float = 0.0
    curve: FloatArray | None = None
    width: float = np.inf

    def wanted(self, targets: FloatArray, darkest: float) -> FloatArray:
        """Return the number of the rule for each colour, (m,), on a device of a darkest L*."""
        if self.curve is None:
            return np.full(len(targets), self.share)
        places = targets[:, 0]
        if self.rule == GCR:
            places = (100.0 - places) / (100.0 - darkest)
        numbers = np.interp(places, self.curve[:, 0], self.curve[:, 1])
        chroma = np.hypot(targets[:, 1], targets[:, 2])
        return np.asarray(numbers / (1.0 + (chroma / self.width) ** 2))


class Recipes(NamedTuple):
    """Device values (m, n) of colours, and the possible range of black (m, 2), 0 to 1.

    `lab` (m, 3) are the colours of the device values. The range is NaN without black.
    """

    device: FloatArray
    lab: FloatArray
    black: FloatArray


@dataclass(frozen=True, eq=False)
class _InkSet:
    """The channels of a set, three chromatic ones and perhaps black, with their table."""

    channels: tuple[int, ...]
    table: InkTable
    scale: FloatArray
    cost: FloatArray
    room: float
    device: FloatArray  # device values (p, 4) of the nodes


class _Trace(NamedTuple):
    """Recipes (m, 4) in a set, the ranges of black (m, 2), and which of them are solutions."""

    recipes: FloatArray
    black: FloatArray
    solved: BooleanArray


class InverseModel:
    """Device values of colours, by a device model.

    Parameters
    ----------
    model : DeviceModel
        Of a device with at least three channels that vary.

    Attributes
    ----------
    black : int or None
        Number of the black channel.

    Raises
    ------
    OptionError
        The device has fewer than three channels that vary.

    Notes
    -----
    It takes 0.1 s for three channels, 0.5 s for four and 1 s for seven, and 10 to 65 MB. RGB spaces
    and profiles of curves and a matrix have an inverse formula, and need no tables.
    """

    def __init__(self, model: DeviceModel) -> None:
        self.model = model
        limited = model.limited
        names = [name.strip().lower() for name in model.channels]
        varied = np.flatnonzero(limited.free).tolist()
        black = [i for i in varied if model.inks and names[i] in BLACK_NAMES]
        self.black = black[0] if black and len(varied) > 3 else None
        chromatic = [i for i in varied if i != self.black]
        if len(chromatic) < 3:
            raise OptionError(
                f"The device has {len(varied)} channels that vary; recipes need three or more.",
                where={"field": "channels"},
                remedy="Give a device such as RGB, CMYK or more inks.",
            )
        self._lowest = limited.base.copy()
        self._lowest[limited.free] = limited.cube.lowest
        self._range = np.zeros(len(names))
        self._range[limited.free] = limited.cube.highest - limited.cube.lowest
        self._room = limited.cube.limit - float(self._lowest[limited.free].sum())
        self._nodes: tuple[Any, LongArray, FloatArray] | None = None
        self._sets: list[_InkSet] = []
        self._has_formula = (
            len(chromatic) == len(names)
            and bool((self._lowest == 0.0).all() and (self._range == 1.0).all())
            and self._room >= len(names)
            and model.closed_values(np.zeros((1, 3))) is not None
        )
        if self._has_formula:
            return
        sets, self._tiles = self._ink_sets(chromatic)
        self._sets = [self._ink_set(inks) for inks in sets]

    @property
    def nbytes(self) -> int:
        """Memory of the tables in bytes."""
        return sum(ink_set.table.nbytes for ink_set in self._sets)

    def recipes(self, targets: FloatArray, black: BlackRule) -> Recipes:
        """Return recipes of colours (m, 3) in CIELAB, relative to D50 as the model's.

        A colour that the device cannot make gets a recipe near it.
        """
        if self._has_formula:
            return self._by_formula(targets)
        wanted = self._wanted(targets, black)
        best = _BestRecipes(self, targets)
        if len(self._sets) > 1:
            self._blend(targets, black, wanted, best)
        else:
            trace = _traced(self._sets[0], targets, black, wanted, _NO_STARTS)
            rows = np.flatnonzero(trace.solved)
            best.widen(rows, trace.black[rows])
            best.correct(rows, trace.recipes[rows], np.zeros(len(rows), np.int64))
        for rank in _RANKS:
            rows = np.flatnonzero(best.error > _RETRY_ABOVE_DE)
            if len(rows) == 0:
                break
            chosen, starts = self._nearest_nodes(targets[rows], rank)
            traced, ranges = np.zeros((len(rows), 4)), np.zeros((len(rows), 2))
            for number in np.unique(chosen).tolist():
                mine, some = np.flatnonzero(chosen == number), self._sets[number]
                own = rows[mine]
                traced[mine], ranges[mine], _ = _traced(
                    some, targets[own], black, wanted[own], starts[mine]
                )
            better = best.correct(rows, traced, chosen)
            best.widen(rows[better], ranges[better])
        if self.black is None:
            best.black[:] = np.nan
        else:
            best.black *= self._range[self.black]
            best.black += self._lowest[self.black]
        return Recipes(best.device, best.lab, best.black)

    def _blend(
        self, targets: FloatArray, black: BlackRule, wanted: FloatArray, best: _BestRecipes
    ) -> None:
        """Find recipes by the mean of the sets that give a colour, corrected on the model.

        Where the core has a wide range of black, it counts alone. Elsewhere, the mean is taken of
        the colour and of colours around it, so that a set which ends does so in steps.
        """
        core = _traced(self._sets[0], targets, black, wanted, _NO_STARTS)
        best.widen(np.flatnonzero(core.solved), core.black[core.solved])
        alone = _set_share(self._sets[0], core, targets[:, 0])
        device = self.device(core.recipes, np.zeros(len(targets), np.int64))
        rows = np.flatnonzero(alone < 1.0)
        around = (targets[rows] + _AROUND[:, np.newaxis]).reshape(-1, 3)
        total, mean = self._weighted_sets(around, black, np.tile(wanted[rows], len(_AROUND)))
        total = total.reshape(len(_AROUND), len(rows)).sum(axis=0)
        mean = mean.reshape(len(_AROUND), len(rows), len(self._range)).sum(axis=0)
        mean /= np.maximum(total, _LEAST_WEIGHT)[:, np.newaxis]
        share = alone[rows, np.newaxis]
        device[rows] = share * device[rows] + (1.0 - share) * mean
        usable = np.ones(len(targets), np.bool_)
        usable[rows] = total > _LEAST_WEIGHT
        made = np.flatnonzero(usable)
        best.settle(made, device[made])

        rows = np.flatnonzero(best.error > _RETRY_ABOVE_DE)
        if len(rows) == 0:
            return
        mean = np.zeros((len(rows), len(self._range)))
        weights = 1.0 / np.arange(1.0, _NEIGHBOURS + 1.0)
        for rank, weight in enumerate(weights / weights.sum()):
            chosen, recipes = self._nearest_nodes(targets[rows], rank)
            mean += weight * self.device(recipes, chosen)
        best.settle(rows, mean)

    def _weighted_sets(
        self, targets: FloatArray, black: BlackRule, wanted: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the sum of the weights of the sets (m,), and of weighted device values (m, k).

        The range of black of a set shrinks to nothing where the set ends, and so does its weight.
        The core counts before the tiles, and these before the other sets.
        """
        count = len(targets)
        total, device = np.zeros(count), np.zeros((count, len(self._range)))
        rest, tiles = np.ones(count), np.zeros(count)
        for number, some in enumerate(self._sets):
            if number == self._tiles:
                rest *= 1.0 - tiles
            rows = np.flatnonzero(rest > _ROUNDING)
            trace = _traced(some, targets[rows], black, wanted[rows], _NO_STARTS)
            share = _set_share(some, trace, targets[rows, 0])
            weight = rest[rows] * (share + _END * trace.solved)
            total[rows] += weight
            values = self.device(trace.recipes, np.full(len(rows), number))
            device[rows] += weight[:, np.newaxis] * values
            if number == 0:
                rest[rows] -= share
            elif number < self._tiles:
                tiles[rows] = np.maximum(tiles[rows], share)
        return total, device

    def settled(self, targets: FloatArray, device: FloatArray) -> FloatArray:
        """Return device values (m, k) corrected on the model by the shortest steps.

        An ink moves in proportion to its distance from the ends of its range, so that unused inks
        stay unused.
        """
        device, rows = device.copy(), np.arange(len(device))
        for step in range(_SETTLING):
            lab = self.model.lab(device[rows])
            far = np.abs(targets[rows] - lab).max(axis=1) > _CONVERGED_DE
            rows, lab = rows[far], lab[far]
            if len(rows) == 0:
                break
            device[rows] = self._stepped(
                device[rows], targets[rows] - lab, lab, _ENTRY if step >= _CORRECTIONS else 0.0
            )
        return device

    def _stepped(
        self, device: FloatArray, rests: FloatArray, lab: FloatArray, entry: float
    ) -> FloatArray:
        """Return device values (m, k) after a least-squares step within the limits.

        `entry` is the freedom of unused inks.
        """
        varied = np.flatnonzero(self._range > 0.0)
        slopes = np.zeros((len(device), 4, device.shape[1]))
        for ink in varied:
            step = np.where(device[:, ink] > self._lowest[ink] + _SLOPE, -_SLOPE, _SLOPE)
            moved = device.copy()
            moved[:, ink] += step
            slopes[:, :3, ink] = (self.model.lab(moved) - lab) / step[:, np.newaxis]
        slopes[:, 3, varied] = _SUM_WEIGHT
        inks = device - self._lowest
        fraction = inks / np.maximum(self._range, _ROUNDING)
        freedom = np.clip(fraction, entry, 1.0) * (1.0 - 0.9 * np.clip(fraction, 0.0, 1.0))
        freedom[:, self._range <= 0.0] = 0.0
        excess = _SUM_WEIGHT * (self._room - inks.sum(axis=1))
        change = _shortest_steps(slopes[:, :3], rests, freedom)
        tight = np.flatnonzero((inks + change).sum(axis=1) > self._room)
        both = np.column_stack([rests[tight], excess[tight]])
        change[tight] = _shortest_steps(slopes[tight], both, freedom[tight])
        change /= np.maximum(1.0, np.abs(change).max(axis=1, keepdims=True) / LONGEST_STEP)
        inks = np.clip(inks + change, 0.0, self._range)
        sums = np.maximum(inks.sum(axis=1, keepdims=True), _ROUNDING)
        return np.asarray(self._lowest + inks * np.minimum(1.0, self._room / sums))

    def _by_formula(self, targets: FloatArray) -> Recipes:
        """Return the recipes of a formula, which a search corrects where it is not exact."""
        formula_values = self.model.closed_values(targets)
        assert formula_values is not None  # noqa: S101  # `_has_formula`
        device = np.clip(formula_values, 0.0, 1.0)
        lab = self.model.lab(device)
        rows = np.flatnonzero(np.abs(targets - lab).max(axis=1) > _CONVERGED_DE)
        device[rows], _ = find_values(targets[rows], device[rows], self.model.lab)
        lab[rows] = self.model.lab(device[rows])
        return Recipes(device, lab, np.full((len(targets), 2), np.nan))

    def _wanted(self, targets: FloatArray, black: BlackRule) -> FloatArray:
        wanted = black.wanted(targets, self._darkest if black.rule == GCR else 0.0)
        if black.rule == WANTED and self.black is not None:
            wanted = (wanted - self._lowest[self.black]) / self._range[self.black]
        return wanted

    @cached_property
    def _darkest(self) -> float:
        """L* of the darkest neutral colour that the core with black gives."""
        neutral = np.zeros((len(_NEUTRAL), 3))
        neutral[:, 0] = _NEUTRAL
        wanted = np.zeros(len(neutral))
        solved = _traced(self._sets[0], neutral, BlackRule(LEAST_INK), wanted, _NO_STARTS).solved
        return float(_NEUTRAL[solved].min()) if solved.any() else 0.0

    def _nearest_nodes(self, targets: FloatArray, rank: int) -> tuple[LongArray, FloatArray]:
        """Return the set and the recipe (m, 4) of the node that is the nearest, or of a rank."""
        if self._nodes is None:
            from scipy.spatial import cKDTree  # noqa: PLC0415  # slow, and few colours need it

            printable = [
                (some.device * some.scale).sum(axis=1) <= some.room + _ROUNDING
                for some in self._sets
            ]
            pairs = list(zip(self._sets, printable, strict=True))
            self._nodes = (
                cKDTree(np.concatenate([some.table.nodes[nodes] for some, nodes in pairs])),
                np.repeat(np.arange(len(pairs)), [nodes.sum() for nodes in printable]),
                np.concatenate([some.device[nodes] for some, nodes in pairs]),
            )
        tree, sets, device = self._nodes
        _, ranked = tree.query(targets, k=[rank + 1])
        nearest = np.asarray(ranked)[:, 0]
        return sets[nearest], device[nearest]

    def corrected(self, rests: FloatArray, recipes: FloatArray, chosen: LongArray) -> FloatArray:
        """Return recipes whose colours differ by `rests`, by the slopes of the tables."""
        for number in np.unique(chosen).tolist():
            mine, some = np.flatnonzero(chosen == number), self._sets[number]
            changed = recipes[mine]
            correct_recipes(some.table, some.scale, some.room, rests[mine], changed)
            recipes[mine] = changed
        return recipes

    def device(self, recipes: FloatArray, chosen: LongArray) -> FloatArray:
        """Return complete device values (m, n) of recipes of their sets, within the limit of inks.

        A recipe between two layers of a path can exceed the limit by a little.
        """
        device = np.tile(self._lowest, (len(recipes), 1))
        used = len(self._sets[0].channels)
        channels = np.array([some.channels for some in self._sets])[chosen]
        scale = np.array([some.scale[:used] for some in self._sets])[chosen]
        inks = recipes[:, :used] * scale
        inks *= np.minimum(1.0, self._room / np.maximum(inks.sum(axis=1), 1e-9))[:, np.newaxis]
        device[np.arange(len(device))[:, None], channels] += inks
        return device

    def _ink_sets(self, chromatic: list[int]) -> tuple[list[tuple[int, ...]], int]:
        """Return sets of three chromatic channels, and how many of them tile the hue circle.

        The tiles are cyan, magenta and yellow, or else the three of the largest area in the plane
        of a* and b*, and those that the other inks form with their neighbours. Two tiles have two
        inks in common, so inks enter and leave at zero where colours cross from one to another.
        The other sets give dark colours that no tile has.
        """
        if len(chromatic) == 3:
            self._core = tuple(chromatic)
            return [self._core], 1
        solids = np.tile(self._lowest, (len(chromatic), 1))
        solids[np.arange(len(chromatic)), chromatic] += self._range[chromatic]
        plane = self.model.lab(solids)[:, 1:]
        order = np.argsort(np.arctan2(plane[:, 1], plane[:, 0]), kind="stable")
        circle = [chromatic[i] for i in order]
        initials = [self.model.channels[i].strip().lower()[:1] for i in circle]
        core = [circle[initials.index(ink)] for ink in "cmy" if ink in initials]
        if len(core) < 3:
            place = dict(zip(chromatic, plane, strict=True))
            core = list(max(combinations(circle, 3), key=lambda each: _area(place, tuple(each))))
        self._core = tuple(sorted(core))
        tiles = [self._core]
        corners = sorted(circle.index(ink) for ink in core)
        for start, end in zip(corners, [*corners[1:], corners[0] + len(circle)], strict=True):
            tiles += [
                tuple(sorted((circle[i - 1], circle[i % len(circle)], circle[end % len(circle)])))
                for i in range(start + 1, end)
            ]
        others = [inks for inks in combinations(sorted(circle), 3) if inks not in tiles]
        return [*tiles, *others[:_MOST_OTHERS]], len(tiles)

    def _ink_set(self, chromatic: Sequence[int]) -> _InkSet:
        channels = (*chromatic, *(() if self.black is None else (self.black,)))
        nodes, layers = _THREE
        if self.black is not None:
            nodes, layers = _FOUR if len(self._range) == 4 else _MORE
        steps, levels = np.linspace(0.0, 1.0, nodes), np.linspace(0.0, 1.0, layers)
        grid = np.meshgrid(levels, steps, steps, steps, indexing="ij")
        fractions = np.stack([grid[1], grid[2], grid[3], grid[0]], axis=-1).reshape(-1, 4)
        scale = np.zeros(4)
        scale[: len(channels)] = self._range[list(channels)]
        device = np.tile(self._lowest, (len(fractions), 1))
        device[:, channels] += (fractions * scale)[:, : len(channels)]
        colours = np.ascontiguousarray(self.model.lab(device))
        if not (np.abs(colours) <= _LARGEST).all():  # also where it is not a number
            raise DeviceModelError(
                f"The device model gives L*, a* or b* beyond {number_text(_LARGEST)}.",
                where={"field": "model"},
                remedy="Correct the data of the device, and build the gamut again.",
            )
        table = ink_table(colours, nodes, layers)
        room = min(self._room, 1e9)  # of a kernel
        weight = [1.0 if i in self._core or i == self.black else _EXTRA_INK for i in channels]
        cost = scale * [*weight, *[1.0] * (4 - len(channels))]
        return _InkSet(channels, table, scale, cost, room, fractions)


def _shortest_steps(slopes: FloatArray, rests: FloatArray, freedom: FloatArray) -> FloatArray:
    """Return the damped least-squares steps (m, k) to changes (m, r), weighted by the freedom."""
    weighted = slopes * freedom[:, np.newaxis]
    matrix = weighted @ slopes.transpose(0, 2, 1) + _DAMPED * np.eye(slopes.shape[1])
    steps = np.linalg.solve(matrix, rests[:, :, np.newaxis])
    return np.asarray((weighted.transpose(0, 2, 1) @ steps)[:, :, 0])


def _set_share(some: _InkSet, trace: _Trace, lightness: FloatArray) -> FloatArray:
    """Return the share of a set in recipes, 0 to 1, by the widths of the ranges of black (m,).

    A range between two layers of the table may be missed, so the share begins beyond this. Light
    colours have narrow ranges, which count as wide. Without black, there is no range.
    """
    if some.table.layers == 1:
        return np.zeros(len(lightness))
    low, high = trace.black.T
    width = high - low - np.minimum(low, 1.0 / (some.table.layers - 1))
    wide = np.clip((100.0 - lightness) / 100.0, _WHITE, _WIDE)
    share = trace.solved * np.clip(width / wide, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


class _BestRecipes:
    """The best recipes so far: device values, their colours, largest errors and ranges of black."""

    def __init__(self, inverse: InverseModel, targets: FloatArray) -> None:
        count = len(targets)
        self._inverse, self._targets = inverse, targets
        self.device = np.zeros((count, len(inverse.model.channels)))
        self.lab = np.zeros((count, 3))
        self.error = np.full(count, np.inf)
        self.black = np.stack([np.full(count, np.inf), np.full(count, -np.inf)], axis=1)

    def widen(self, rows: LongArray, ranges: FloatArray) -> None:
        """Widen the ranges of black of some rows."""
        self.black[rows, 0] = np.minimum(self.black[rows, 0], ranges[:, 0])
        self.black[rows, 1] = np.maximum(self.black[rows, 1], ranges[:, 1])

    def settle(self, rows: LongArray, device: FloatArray) -> None:
        """Correct device values (m, k) of rows on the device model, and keep better ones."""
        device = self._inverse.settled(self._targets[rows], device)
        lab = self._inverse.model.lab(device)
        error = np.abs(self._targets[rows] - lab).max(axis=1)
        better = error < self.error[rows]
        rows = rows[better]
        self.device[rows], self.lab[rows] = device[better], lab[better]
        self.error[rows] = error[better]

    def correct(self, rows: LongArray, recipes: FloatArray, chosen: LongArray) -> BooleanArray:
        """Correct recipes on the device model, and keep better ones; return which are better."""
        inverse, before = self._inverse, self.error[rows]
        current, places = recipes, np.arange(len(rows))
        for step in range(_CORRECTIONS + 1):
            own = rows[places]
            device = inverse.device(current, chosen[places])
            lab = inverse.model.lab(device)
            rests = self._targets[own] - lab
            error = np.abs(rests).max(axis=1)
            better = error < self.error[own]
            improved = own[better]
            self.device[improved], self.lab[improved] = device[better], lab[better]
            self.error[improved] = error[better]
            open_ = error > _CONVERGED_DE
            places = places[open_]
            if step == _CORRECTIONS or len(places) == 0:
                break
            current = inverse.corrected(rests[open_], current[open_], chosen[places])
        return self.error[rows] < before


def _area(place: dict[int, FloatArray], inks: tuple[int, ...]) -> float:
    """Return the area of the triangle of three inks in the plane of a* and b*."""
    one, two, three = (place[ink] for ink in inks)
    (a, b), (c, d) = two - one, three - one
    return float(abs(a * d - b * c))


def _traced(
    some: _InkSet, targets: FloatArray, black: BlackRule, wanted: FloatArray, starts: FloatArray
) -> _Trace:
    """Return what `trace_paths` finds in a set, from starts (m, 4) or anywhere (0, 4)."""
    count = len(targets)
    recipes, ranges = np.zeros((count, 4)), np.zeros((count, 2))
    solved = np.zeros(count, np.bool_)
    trace_paths(
        some.table,
        np.ascontiguousarray(targets),
        some.scale,
        some.cost,
        some.room,
        black.rule,
        wanted,
        starts,
        recipes,
        ranges,
        solved,
    )
    return _Trace(recipes, ranges, solved)
