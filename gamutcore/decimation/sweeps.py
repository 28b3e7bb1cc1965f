"""The fine end of a decimation in sweeps: edges in the order of memory, below a rising limit.

In strict order the cheapest edge lies somewhere in memory, and each collapse waits for it. Among
hundreds of thousands of nearly equal edges the order hardly matters, and edges that are near in
memory are near on the surface (`modified_convex_hull` orders them so).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.corner_table import following, preceding
from gamutcore.decimation.costs.interface import optimum, reach
from gamutcore.decimation.record import Record
from gamutcore.decimation.star import Surface, link_condition_holds, ring_faces
from gamutcore.decimation.workspace import (
    Workspace,
    collapse_edge,
    is_stale,
    mark_changed,
    place_is_valid,
)
from gamutcore.kernels import kernel

__all__ = ["SWEPT_DOWN_TO", "collapse_in_sweeps"]

SWEPT_DOWN_TO = 6000
"""Collapses before the end at which strict order begins."""

SWEEP_RATIO = 1.4
"""How much the limit rises from sweep to sweep."""

FIRST_SWEEP = 16
"""The first limit leaves one in so many edges below it."""


@kernel
def collapse_in_sweeps(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    delivered: Float32Array,
    centre: FloatArray,
    step: float,
    record: Record,
    work: Workspace,
    moved: IndexArray,
    wanted: int,
) -> tuple[int, IndexArray]:
    """Collapse edges below a rising limit of the error, in their order in memory.

    Parameters
    ----------
    cost, surface, delivered, centre, step, record
        As for `collapse_all`.
    work : Workspace
        With the errors of all edges.
    moved : (m,) int32
        The record's moved corners.
    wanted : int
        Collapses to make.

    Returns
    -------
    collapses : int
    moved : (≥ m,) int32
    """
    priority = work.queue.priority
    edges = priority.size
    ring = np.empty((64, 2), np.int32)
    # marks begin with −1, and the queries of the strict order count up from 1
    limit, collapses, query = np.sort(priority)[edges // FIRST_SWEEP], 0, -1
    while collapses < wanted:
        before = collapses
        for edge in range(edges):
            corner = surface.corner_facing[edge]
            if corner < 0 or priority[edge] > limit:
                continue
            if is_stale(surface, work, edge):
                work.evaluated[edge] = collapses
                priority[edge] = optimum(cost, surface, corner, work.place)
                if priority[edge] > limit:
                    continue
            kept, dead = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
            query -= 1
            if not link_condition_holds(surface, kept, dead, query):
                continue
            count = ring_faces(surface, kept, dead, ring)
            if count > len(ring) or not place_is_valid(
                cost, surface, work, edge, ring, count, centre, step, False
            ):
                continue
            kept, moved = collapse_edge(
                cost, surface, delivered, record, work, edge, collapses, moved
            )
            collapses += 1
            record.shifted_end[collapses - 1] = 0
            mark_changed(surface, work, kept, collapses)
            if reach(cost, surface, len(delivered) - collapses) or collapses == wanted:
                return collapses, moved
        if collapses == before and not limit < np.inf:
            break
        limit *= SWEEP_RATIO
    return collapses, moved
