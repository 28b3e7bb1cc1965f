"""The printable part of a device's cube: ink limits, and the patches of its surface.

A press does not print all inks in full. A total limit is the largest sum of all inks (240 % on
newsprint, 300 to 340 % on coated paper). It cuts off the corner of the cube beyond a plane of equal
sums. A black limit shortens one axis. Below the limit, black is an ink like the others: gamuts
without black are up to a fifth smaller.

The colours at the boundary of the rest come from its two-dimensional faces. These are the cube's
own faces, clipped at the plane, and the intersections of the plane with its three-dimensional faces
(triangles to hexagons). Each face is divided into quadrilaterals and triangles between its own
corners. Neighbouring faces share whole edges, so a lattice covers them without gaps.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, combinations
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gamutcore.errors import OptionError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.samples import JSON, IntArray

BLACK_NAMES = frozenset({"k", "black", "process black", "schwarz", "noir", "nero", "negro"})
"""Names, in lower case, of the channel of the black ink."""

_APART = 1e-6
"""Smallest range of a varying channel, as a fraction of full ink."""


@dataclass(frozen=True)
class InkLimits:
    """Largest amounts of ink: all inks in per cent of one full ink, and black in per cent.

    None stands for no limit. `stated_by` is the part of the data that states the total; it is empty
    for a total that was given.
    """

    total: float | None = None
    black: float | None = None
    stated_by: str = ""

    @property
    def given(self) -> bool:
        """Whether a limit was given, rather than stated by the data."""
        return self.black is not None or (self.total is not None and not self.stated_by)

    @property
    def provenance(self) -> dict[str, JSON]:
        """The limits as the description of a gamut has them."""
        stated: dict[str, JSON] = {"stated_by": self.stated_by} if self.stated_by else {}
        return {"ink_limits": {"total": self.total, "black": self.black, **stated}}

    def refusal(self, why: str) -> OptionError:
        """Return the error for limits of a device that cannot have them, for the reason `why`."""
        field = "black_limit" if self.total is None or self.stated_by else "ink_limit"
        return OptionError(
            f"{field} does not apply: {why}",
            where={"field": field},
            remedy="Leave it out; limits are for profiles and measurements of inks, such as CMYK.",
        )


@dataclass(frozen=True, eq=False)
class LimitedCube:
    """The printable device values, and the channels that are constant.

    `cube` has the channels that vary, `free` (n,) tells which of the device's n channels do, and
    `base` (n,) has the values of the others. `provenance` has the limits of a device with inks.
    """

    cube: InkCube
    free: npt.NDArray[np.bool_]
    base: FloatArray
    provenance: dict[str, JSON]

    def device(self, values: FloatArray) -> FloatArray:
        """Return complete device values (m, n) from the values (m, k) of the channels that vary."""
        if self.free.all():
            return values
        device = np.tile(self.base, (len(values), 1))
        device[:, self.free] = values
        return device

    def contains(self, device: FloatArray) -> npt.NDArray[np.bool_]:
        """Whether complete device values, (m, n), are printable, (m,)."""
        values, cube = device[:, self.free], self.cube
        printable = (values >= cube.lowest - _APART).all(axis=1)
        printable &= (values <= cube.highest + _APART).all(axis=1)
        printable &= (np.abs(device - self.base)[:, ~self.free] <= _APART).all(axis=1)
        printable &= values.sum(axis=1) <= cube.largest_sum + _APART
        return np.asarray(printable)


def limited_cube(
    channels: Sequence[str],
    lowest: FloatArray,
    highest: FloatArray,
    limits: InkLimits,
    *,
    inks: bool,
) -> LimitedCube:
    """Return the part of a device's cube that is within the ink limits.

    `lowest` and `highest` are the range of each of n channels, 0 to 1.
    """
    if limits.given and not inks:
        raise limits.refusal(f"the channels {', '.join(channels)} are not inks.")
    lowest, highest = np.array(lowest, dtype=np.float64), np.array(highest, dtype=np.float64)
    provenance = limits.provenance if inks else {}
    if limits.black is not None:
        black = _black_channel(channels)
        if limits.black / 100 < lowest[black]:
            raise _nothing_left("black_limit", limits.black, f"{100 * lowest[black]:.4g}")
        highest[black] = min(highest[black], limits.black / 100)
    free = highest - lowest > _APART
    total = None
    if limits.total is not None:
        total = limits.total / 100 - float(lowest[~free].sum())
        if total <= float(lowest[free].sum()) + _APART:
            least = f"{100 * lowest.sum():.4g}"
            raise _nothing_left("ink_limit", limits.total, least, ", or none")
        # a limit below the range of a single ink shortens that range
        room = total - (float(lowest[free].sum()) - lowest[free])
        highest[free] = np.minimum(highest[free], room)
    cube = InkCube(lowest[free], highest[free], total)
    return LimitedCube(cube, free, lowest, provenance)


def lacks_black(channels: Sequence[str], inks: bool) -> bool:
    """Whether channels are more than three inks, none of which is named as black."""
    names = {name.strip().lower() for name in channels}
    return inks and len(channels) > 3 and not names & BLACK_NAMES


def _nothing_left(field: str, value: float, least: str, others: str = "") -> OptionError:
    return OptionError(
        f"{field} is {value:g} %, but the lowest amount in the data is {least} %.",
        where={"field": field},
        remedy=f"Give more than {least} %{others}.",
    )


def _black_channel(channels: Sequence[str]) -> int:
    for number, name in enumerate(channels):
        if name.strip().lower() in BLACK_NAMES:
            return number
    raise OptionError(
        f"black_limit does not apply: none of the inks {', '.join(channels)} is named as black.",
        where={"field": "black_limit"},
        remedy="Leave it out, or name the inks, such as --inks C,M,Y,K,O,G,V.",
    )


_TINY = 1e-9
"""Smallest extent of a piece of a face, as a fraction of full ink."""

_FREE = 2.5
"""Mean number of channels of spread values that are not at an end of their range. The boundary of
a gamut is the image of the cube's two-dimensional faces, or of folds inside of the cube."""


@dataclass(frozen=True, eq=False)
class InkCube:
    """The printable device values: the range of each of n channels, and the largest sum, if any.

    No range is empty.
    """

    lowest: FloatArray
    highest: FloatArray
    total: float | None = None

    @property
    def limit(self) -> float:
        """The limit of the sum; infinite without one."""
        return float("inf") if self.total is None else self.total

    @property
    def cut(self) -> bool:
        """Whether the limit of the sum cuts off a part of the cube."""
        return self.limit < float(self.highest.sum()) - _TINY

    @property
    def largest_sum(self) -> float:
        """The largest sum of a printable device value."""
        return min(float(self.highest.sum()), self.limit)


@dataclass(frozen=True, eq=False)
class Patches:
    """Quadrilaterals that cover the surface of a cut cube; two corners of a triangle coincide.

    `corners` (p, 2, 2, n) are device values at s and t of 0 and 1. `axes` (p, 2) are the channels
    that alone change, over their whole range, along s and along t; -1 in a cube with a cut.
    """

    corners: FloatArray
    axes: IntArray


def surface_patches(cube: InkCube, most: int) -> Patches | None:
    """Return the patches of a cut cube of at least two channels; None if they are too many.

    A cube of n channels without a cut has C(n, 2)·2^(n-2) patches: 860,160 for fifteen inks.
    """
    corners, axes, count = [], [], 0
    for some, their_axes in chain(_clipped_faces(cube), _cutting_faces(cube) if cube.cut else ()):
        corners.append(some)
        axes.append(their_axes)
        count += len(some)
        if count > most:
            return None
    return Patches(np.concatenate(corners), np.concatenate(axes))


def surface_corners(cube: InkCube) -> FloatArray:
    """Return the cube's corners (m, n) within the limit, and where its edges meet the limit."""
    n = len(cube.lowest)
    cube_corners = _cube_corners(cube)
    corners = [cube_corners[cube_corners.sum(axis=1) <= cube.limit + _TINY]]
    if cube.cut:
        for axis in range(n):
            fixed = _cube_corners(cube, axis)
            value = cube.limit - fixed.sum(axis=1)
            low, high = cube.lowest[axis] + _TINY, cube.highest[axis] - _TINY
            crossing = (value > low) & (value < high)
            points = fixed[crossing]
            points[:, axis] = value[crossing]
            corners.append(points)
    return np.concatenate(corners)


def spread_values(cube: InkCube, count: int) -> FloatArray:
    """Return device values (count, n) of low discrepancy, inside of the cut cube and on its faces.

    Their positions are the sequence R of M. Roberts, The Unreasonable Effectiveness of Quasirandom
    Sequences (2018). Channels beyond a middle part of the positions are at an end of their range.
    """
    channels, ratio = len(cube.lowest), 2.0
    for _ in range(64):  # the root of x^(n + 1) = x + 1
        ratio = (1.0 + ratio) ** (1.0 / (channels + 1))
    number = np.arange(1, count + 1)[:, np.newaxis]
    position = (0.5 + number * ratio ** -np.arange(1.0, channels + 1)) % 1.0 - 0.5
    position = np.clip(position * max(channels / _FREE, 1.0) + 0.5, 0.0, 1.0)
    return printable_values(cube, cube.lowest + position * (cube.highest - cube.lowest))


def values_beside(
    cube: InkCube, values: FloatArray, step: float, random: np.random.Generator
) -> FloatArray:
    """Return printable device values near others (m, n), each with about half of its channels.

    `step` is the largest change as a share of the range of a channel.
    """
    change = random.uniform(-step, step, values.shape) * (cube.highest - cube.lowest)
    return printable_values(cube, values + change * (random.random(values.shape) < 0.5))


def printable_values(cube: InkCube, values: FloatArray) -> FloatArray:
    """Return values (m, n) that are clipped to the ranges, and scaled to the largest sum."""
    added = np.clip(values, cube.lowest, cube.highest) - cube.lowest
    room = cube.largest_sum - float(cube.lowest.sum())
    scale = np.minimum(1.0, room / np.maximum(added.sum(axis=1), _TINY))
    printable: FloatArray = cube.lowest + added * scale[:, np.newaxis]
    return printable


def _cube_corners(cube: InkCube, *free: int) -> FloatArray:
    """All corners of the cube in the channels that are not free, (2^k, n), with those at 0."""
    axes = [axis for axis in range(len(cube.lowest)) if axis not in free]
    points = np.zeros((1 << len(axes), len(cube.lowest)))
    for bit, axis in enumerate(axes):
        high = ((np.arange(len(points)) >> bit) & 1).astype(bool)
        points[:, axis] = np.where(high, cube.highest[axis], cube.lowest[axis])
    return points


def corners_within(cube: InkCube, *free: int) -> FloatArray:
    """The corners in all other channels that leave room below the limit for the free ones."""
    corners = _cube_corners(cube, *free)
    within: FloatArray = corners[corners.sum(axis=1) < cube.limit]
    return within


def _clipped_faces(cube: InkCube) -> Iterator[tuple[FloatArray, IntArray]]:
    """Yield the parts of the cube's own faces that are within the limit.

    A face is a rectangle, of which the limit may cut off a corner.
    """
    for a, b in combinations(range(len(cube.lowest)), 2):
        fixed = corners_within(cube, a, b)
        low_a, low_b, high_a, high_b = _ranges(cube, a, b)
        fixed = fixed[fixed.sum(axis=1) < cube.limit - low_a - low_b]
        rest = cube.limit - fixed.sum(axis=1)
        right, top = np.minimum(high_a, rest - low_b), np.minimum(high_b, rest - low_a)
        bend_b = np.clip(rest - high_a, low_b, high_b)
        bend_a = np.clip(rest - high_b, low_a, high_a)
        first = (np.full(len(rest), low_a), np.full(len(rest), low_b))
        second, third = (right, first[1]), (np.minimum(high_a, rest - bend_b), bend_b)
        fourth, fifth = (bend_a, np.minimum(high_b, rest - bend_a)), (first[0], top)
        axes = (-1, -1) if cube.cut else (a, b)
        yield _quadrilaterals(fixed, (a, b), (first, second, third, fifth), axes)
        yield _quadrilaterals(fixed, (a, b), (third, fourth, fifth, third), axes)


def _cutting_faces(cube: InkCube) -> Iterator[tuple[FloatArray, IntArray]]:
    """Yield the parts of the limiting plane within the cube's three-dimensional faces.

    The channels a and b are free, and c is the rest of the limit. The range of c limits the sum of
    a and b from below and above, so the part is a hexagon or less.
    """
    for a, b, c in combinations(range(len(cube.lowest)), 3):
        fixed = corners_within(cube, a, b, c)
        rest = cube.limit - fixed.sum(axis=1)
        low_a, low_b, high_a, high_b = _ranges(cube, a, b)
        room = (rest - cube.highest[c] < high_a + high_b) & (rest - cube.lowest[c] > low_a + low_b)
        fixed, rest = fixed[room], rest[room]
        least, most = rest - cube.highest[c], rest - cube.lowest[c]  # of a + b
        start_a, start_b = np.maximum(low_a, least - high_b), np.maximum(low_b, least - high_a)
        end_a, end_b = np.minimum(high_a, most - low_b), np.minimum(high_b, most - low_a)
        bend_b, rise_b = (
            np.clip(most - high_a, start_b, high_b),
            np.clip(least - low_a, low_b, end_b),
        )
        bend_a, rise_a = (
            np.clip(most - high_b, start_a, high_a),
            np.clip(least - low_b, low_a, end_a),
        )
        hexagon = (
            (end_a, start_b),
            (np.minimum(high_a, most - bend_b), bend_b),
            (bend_a, np.minimum(high_b, most - bend_a)),
            (start_a, end_b),
            (np.maximum(low_a, least - rise_b), rise_b),
            (rise_a, np.maximum(low_b, least - rise_a)),
        )
        for half in (hexagon[:4], (*hexagon[3:], hexagon[0])):
            corners, axes = _quadrilaterals(fixed, (a, b), half, (-1, -1))
            corners[..., c] = cube.limit - corners.sum(axis=-1)
            yield corners, axes


def _ranges(cube: InkCube, a: int, b: int) -> tuple[float, float, float, float]:
    lowest, highest = cube.lowest, cube.highest
    return float(lowest[a]), float(lowest[b]), float(highest[a]), float(highest[b])


def _quadrilaterals(
    fixed: FloatArray,
    channels: tuple[int, int],
    corners: Sequence[tuple[FloatArray, FloatArray]],
    axes: tuple[int, int],
) -> tuple[FloatArray, IntArray]:
    """Quadrilaterals in two channels, from their corners in cyclic order; none without area."""
    outline = np.array(corners)  # (4, 2, m)
    across, along = outline[2] - outline[0], outline[3] - outline[1]
    areas = across[0] * along[1] - across[1] * along[0]
    real = np.abs(areas) > _TINY**2
    real &= np.abs(across).max(axis=0) > _TINY
    count = int(real.sum())
    quadrilaterals = np.empty((count, 2, 2, fixed.shape[1]))
    quadrilaterals[:] = fixed[real, np.newaxis, np.newaxis]
    for corner, (s, t) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        quadrilaterals[:, s, t, list(channels)] = outline[corner][:, real].T
    return quadrilaterals, np.tile(np.array(axes, np.int64), (count, 1))
