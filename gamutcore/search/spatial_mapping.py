"""Spatial mapping: pixels move so that differences between neighbours stay, and are in gamut.

Each pixel o moves on its line towards a neutral colour g of about its lightness: the result is
o − s d with d = o − g. Its hue stays. The boundary limits the share s once, before the iterations:
from `least` to `most`, the line is in gamut. With s = `least` the result is clipping.

The differences between the gradients of the result and those of the picture are the differences of
the shifts s d of neighbours p and q. Iterations reduce their weighted squares,

    E = Σ w |s_p d_p − s_q d_q|²,  w = 1 ÷ (1 + |d_p − d_q|² ÷ κ²),

by exact steps in each s, projected onto its limits. The scalar product d_p · d_q in E projects the
shift of a neighbour onto the pixel's own line of constant hue. w is the conductance of Perona and
Malik: shifts do not spread across edges as halos. The result of n iterations depends on
pixels at most 2n away. The time is linear in pixels and iterations.

Source: A. Alsam & I. Farup, "Spatial colour gamut mapping by orthogonal projection of gradients
onto constant hue lines", ISVC 2012, and "Spatial colour gamut mapping by means of anisotropic
diffusion", CCIW 2011. P. Perona & J. Malik, "Scale-space and edge detection using anisotropic
diffusion", IEEE PAMI 12 (1990). Steps beyond the minimum (over-relaxation) lost more chroma for
little more detail.

Data layout: planes (rows, columns) of float32, pixels from the top, and lines (rows, columns, 3).
Pixels without a colour have d = 0: they take no part. So does whatever is beyond the edge of the
picture. Pixels are updated by the colours of a chessboard: those of one colour depend on those of
the other one only, in any order, so results do not depend on the number of threads.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from gamutcore.arrays import BooleanArray, Float32Array, FloatArray
from gamutcore.kernels import kernel
from gamutcore.search.crossings import crossings
from gamutcore.search.index import LevelIndex
from gamutcore.search.mapping import map_colours

__all__ = ["Lines", "find_lines", "neutral_ends", "relax_shifts"]

FOCUS = 0.8
"""Lightness of the neutral colour of a line, relative to the middle of the neutral colours in
gamut: this part of that of the pixel. 0 gives one focal point, as in the papers, whose lines make
yellow dark; 1 gives lines of constant lightness. docs/decisions/spatial-mapping.md compares."""

INNER = 0.9
"""Part of the neutral colours in gamut that lines lead to: they end well inside."""

EDGE = 0.1
"""κ ÷ the length of the neutral axis in gamut: differences of 10 of 100 count as edges."""

INWARDS = 2.0**-20
"""Addition to `least`: the rounding of float32 and of the shifts."""


class Lines(NamedTuple):
    """Lines of n pixels: o − s d is in gamut for s from `least` to `most`."""

    directions: FloatArray  # (n, 3)
    least: FloatArray
    most: FloatArray


def neutral_ends(index: LevelIndex) -> tuple[float, float] | None:
    """Return the lightness of the darkest and lightest neutral colour in gamut; None without."""
    axis = np.array([[index.box[0, 0] - 1.0, 0.0, 0.0], [index.box[1, 0] + 1.0, 0.0, 0.0]])
    lightness = crossings(axis[:1], axis[1:], index, "line").points[:, 0]
    return (float(lightness[0]), float(lightness[-1])) if len(lightness) else None


def find_lines(
    points: FloatArray, outside: BooleanArray, index: LevelIndex, ends: tuple[float, float]
) -> Lines:
    """Return the lines of pixels (n, 3) in the space of a level, with their limits.

    Pixels that are not `outside` may stay: `least` is 0. Where a line misses the gamut, the pixel
    moves as by ``clip-hue``, and `least` and `most` are 1.
    """
    middle, half = 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])
    focus = np.zeros_like(points)
    away = np.clip(FOCUS * (points[:, 0] - middle), -INNER * half, INNER * half)
    focus[:, 0] = middle + away
    line_crossings = crossings(points, focus, index, "segment")
    rows = np.repeat(np.arange(len(points)), np.diff(line_crossings.offsets))
    least, most = np.full(len(points), np.nan), np.ones(len(points))
    entering = line_crossings.entering
    # in reverse, because the last of several values is assigned
    least[rows[entering][::-1]] = line_crossings.t[entering][::-1]
    most[rows[~entering][::-1]] = line_crossings.t[~entering][::-1]
    least[~outside] = 0.0
    np.minimum(least + INWARDS * outside, most, out=least)
    directions = points - focus
    missed = np.flatnonzero(np.isnan(least))
    if len(missed):
        directions[missed] -= map_colours(points[missed], index, "clip-hue").points - focus[missed]
        least[missed] = most[missed] = 1.0
    return Lines(directions, least, most)


def relax_shifts(
    directions: Float32Array,
    least: Float32Array,
    most: Float32Array,
    iterations: int,
    axis: float,
) -> Float32Array:
    """Return the shares (rows, columns) of the shifts of all pixels.

    `directions` is (rows, columns, 3), `least` and `most` are (rows, columns). `axis` is the
    length of the neutral axis in gamut.
    """
    rows, columns = least.shape
    right, down, inverse = (np.zeros(least.shape, np.float32) for _ in range(3))
    _couple(directions, (EDGE * axis) ** 2, right, down, inverse)
    shares = least.copy()
    threads = min(os.cpu_count() or 1, max(1, rows * columns // 2**16))
    limits = np.linspace(0, rows, threads + 1).astype(int)
    with ThreadPoolExecutor(threads) as workers:
        for _ in range(iterations):
            for colour in (0, 1):

                def sweep(part: int, colour: int = colour) -> None:
                    begin, end = limits[part], limits[part + 1]
                    _sweep(right, down, inverse, least, most, shares, begin, end, colour)

                list(workers.map(sweep, range(threads)))
    return shares


@kernel
def _couple(
    directions: Float32Array,
    square: float,
    right: Float32Array,
    down: Float32Array,
    inverse: Float32Array,
) -> None:
    """Write w d_p · d_q of each pixel with its right and lower neighbour, and 1 ÷ (Σ w |d_p|²)."""
    rows, columns, _ = directions.shape
    # first the sums of w, in `inverse`
    for y in range(rows):
        for x in range(columns):
            a, b, c = directions[y, x, 0], directions[y, x, 1], directions[y, x, 2]
            if a == b == c == 0.0:
                continue
            for step in range(2):
                v, u = y + step, x + 1 - step
                if v == rows or u == columns:
                    continue
                d, e, f = directions[v, u, 0], directions[v, u, 1], directions[v, u, 2]
                if d == e == f == 0.0:
                    continue
                gap = (a - d) * (a - d) + (b - e) * (b - e) + (c - f) * (c - f)
                weight = square / (square + gap)
                coupling = weight * (a * d + b * e + c * f)
                if step == 0:
                    right[y, x] = coupling
                else:
                    down[y, x] = coupling
                inverse[y, x] += weight
                inverse[v, u] += weight
    for y in range(rows):
        for x in range(columns):
            a, b, c = directions[y, x, 0], directions[y, x, 1], directions[y, x, 2]
            total = inverse[y, x] * (a * a + b * b + c * c)
            inverse[y, x] = 1.0 / total if total > 0.0 else 0.0


@kernel
def _sweep(
    right: Float32Array,
    down: Float32Array,
    inverse: Float32Array,
    least: Float32Array,
    most: Float32Array,
    shares: Float32Array,
    begin: int,
    end: int,
    colour: int,
) -> None:
    """Update the pixels of one colour of the chessboard in some rows."""
    rows, columns = shares.shape
    for y in range(begin, end):
        for x in range((y + colour) % 2, columns, 2):
            total = right[y, x] * shares[y, x + 1] if x + 1 < columns else np.float32(0.0)
            if x > 0:
                total += right[y, x - 1] * shares[y, x - 1]
            if y + 1 < rows:
                total += down[y, x] * shares[y + 1, x]
            if y > 0:
                total += down[y - 1, x] * shares[y - 1, x]
            shares[y, x] = min(max(total * inverse[y, x], least[y, x]), most[y, x])
