"""Volumes within a surface by hue and lightness, from fluxes through pieces of the surface.

The vector field F = (0, a / 2, b / 2) has the divergence 1. By the divergence theorem, its flux out
of a closed surface is the volume inside. F is parallel to every plane of constant hue and to
every plane of constant lightness. The volume of a cell between such planes therefore flows through
its part of the surface alone. The pieces are clipped, and no caps are needed.

Polygons are rows of corners in counter-clockwise order from outside, relative to an origin. The
coordinates are lightness, a and b.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = [
    "BUFFERS",
    "CORNERS",
    "WHOLE_TURN",
    "Cells",
    "add_polygon",
    "cells_of",
    "clip",
    "enclosed_cells",
    "hue_span",
]

CORNERS = 24
"""Most corners of a polygon: a triangle gets one more from each of at most eight planes."""

BUFFERS = 9
"""Number of work polygons. The first five are free for the caller of `add_polygon`."""

WHOLE_TURN = 2.0 * np.pi


class Cells(NamedTuple):
    """Planes that divide a colour space into sectors of hue and bands of lightness.

    Attributes
    ----------
    directions : (sectors + 1, 2) float64
        Cosine and sine of the hues between the sectors. The last repeats the first.
    bounds : (bands − 1,) float64
        Lightnesses between the bands, in increasing order.
    """

    directions: FloatArray
    bounds: FloatArray


def cells_of(sectors: int, bounds: FloatArray) -> Cells:
    """Return equal sectors of hue from 0°, and bands between lightnesses (bands − 1,)."""
    hues = WHOLE_TURN * np.arange(sectors + 1) / sectors
    return Cells(np.column_stack([np.cos(hues), np.sin(hues)]), bounds)


@leaf_kernel
def clip(
    source: FloatArray,
    count: int,
    x: float,
    y: float,
    z: float,
    constant: float,
    target: FloatArray,
) -> int:
    """Clip a convex polygon to x L + y a + z b + constant ≥ 0; return the number of corners.

    `source` and `target` are (`CORNERS`, 3); the part is written to `target`.
    """
    kept, last = 0, count - 1
    if count == 0:
        return 0
    before = x * source[last, 0] + y * source[last, 1] + z * source[last, 2] + constant
    for index in range(count):
        here = x * source[index, 0] + y * source[index, 1] + z * source[index, 2] + constant
        if (before < 0.0) != (here < 0.0):
            share = before / (before - here)
            for axis in range(3):
                start = source[last, axis]
                target[kept, axis] = start + share * (source[index, axis] - start)
            kept += 1
        if here >= 0.0:
            for axis in range(3):
                target[kept, axis] = source[index, axis]
            kept += 1
        last, before = index, here
    return kept


@leaf_kernel
def _flux(polygon: FloatArray, count: int, origin: FloatArray) -> float:
    """Return the flux of F through a polygon."""
    x, y, z = polygon[0, 0], polygon[0, 1], polygon[0, 2]
    total = 0.0
    for index in range(1, count - 1):
        ux, uy, uz = polygon[index, 0] - x, polygon[index, 1] - y, polygon[index, 2] - z
        vx, vy, vz = polygon[index + 1, 0] - x, polygon[index + 1, 1] - y, polygon[index + 1, 2] - z
        # the mean of F over a triangle is that of its corners; the vector area is u × v ÷ 2
        total += (uz * vx - ux * vz) * (3.0 * (y + origin[1]) + uy + vy)
        total += (ux * vy - uy * vx) * (3.0 * (z + origin[2]) + uz + vz)
    return total / 12.0


@leaf_kernel
def _band(bounds: FloatArray, lightness: float) -> int:
    """Return the band of a lightness."""
    low, high = 0, len(bounds)
    while low < high:
        middle = (low + high) // 2
        if bounds[middle] < lightness:
            low = middle + 1
        else:
            high = middle
    return low


@leaf_kernel
def hue_span(polygon: FloatArray, count: int, origin: FloatArray) -> tuple[float, float]:
    """Return the first hue of a convex polygon, from −2 π to π, and its span, in radians.

    The span is a whole turn for a polygon around the neutral axis. Corners on the axis have no hue.
    """
    start, low, high = np.inf, 0.0, 0.0
    for index in range(count):
        a, b = polygon[index, 1] + origin[1], polygon[index, 2] + origin[2]
        if a == 0.0 and b == 0.0:
            continue
        hue = np.arctan2(b, a)
        if start == np.inf:
            start = hue
        turn = hue - start
        if turn > np.pi:
            turn -= WHOLE_TURN
        elif turn < -np.pi:
            turn += WHOLE_TURN
        low, high = min(low, turn), max(high, turn)
    if start == np.inf:
        return 0.0, 0.0
    if high - low >= np.pi:
        return 0.0, WHOLE_TURN
    return start + low, high - low


@leaf_kernel
def add_polygon(
    polygon: FloatArray,
    count: int,
    origin: FloatArray,
    cells: Cells,
    buffers: FloatArray,
    volumes: FloatArray,
) -> None:
    """Add the flux through a convex polygon to the cells that it meets, `volumes` (bands, sectors).

    The polygon (`CORNERS`, 3) is relative to `origin`. The last four of `buffers` (`BUFFERS`,
    `CORNERS`, 3) are overwritten.
    """
    if count < 3:
        return
    bounds, directions = cells.bounds, cells.directions
    sectors = len(directions) - 1
    first_band = last_band = 0
    if len(bounds) > 0:
        low = high = polygon[0, 0]
        for index in range(1, count):
            low, high = min(low, polygon[index, 0]), max(high, polygon[index, 0])
        first_band, last_band = _band(bounds, low + origin[0]), _band(bounds, high + origin[0])
    first = last = 0
    if sectors > 1:
        begin, span = hue_span(polygon, count, origin)
        scale = sectors / WHOLE_TURN
        first = int(np.floor(begin * scale))
        # a whole turn ends where it begins
        last = min(int(np.floor((begin + span) * scale)), first + sectors - 1)
    if first == last and first_band == last_band:
        volumes[first_band, first % sectors] += _flux(polygon, count, origin)
        return
    wedge = polygon
    for turn in range(first, last + 1):
        sector = turn % sectors
        corners = count
        if first < last:
            a, b = directions[sector, 0], directions[sector, 1]
            constant = a * origin[2] - b * origin[1]
            corners = clip(polygon, count, 0.0, -b, a, constant, buffers[5])
            a, b = directions[sector + 1, 0], directions[sector + 1, 1]
            constant = b * origin[1] - a * origin[2]
            corners = clip(buffers[5], corners, 0.0, b, -a, constant, buffers[6])
            wedge = buffers[6]
        for band in range(first_band, last_band + 1):
            part, rest = wedge, corners
            if band > first_band:
                rest = clip(part, rest, 1.0, 0.0, 0.0, origin[0] - bounds[band - 1], buffers[7])
                part = buffers[7]
            if band < last_band:
                rest = clip(part, rest, -1.0, 0.0, 0.0, bounds[band] - origin[0], buffers[8])
                part = buffers[8]
            volumes[band, sector] += _flux(part, rest, origin)


@kernel
def enclosed_cells(vertices: FloatArray, faces: IndexArray, cells: Cells) -> FloatArray:
    """Return the volume within a closed surface in each cell, (bands, sectors)."""
    volumes = np.zeros((len(cells.bounds) + 1, len(cells.directions) - 1))
    buffers, origin = np.empty((BUFFERS, CORNERS, 3)), np.zeros(3)
    for face in range(len(faces)):
        for corner in range(3):
            for axis in range(3):
                buffers[0, corner, axis] = vertices[faces[face, corner], axis]
        add_polygon(buffers[0], 3, origin, cells, buffers, volumes)
    return volumes
