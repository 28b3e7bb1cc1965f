"""A priority queue of edges: an indexed 4-ary heap over plain arrays.

Smaller priorities come first, equal ones by edge id, so the order in
which edges leave does not depend on how they came in. Four children a node halve the depth of a
binary heap and keep a node's children in one cache line.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import kernel, leaf_kernel

__all__ = ["EdgeQueue", "dequeue", "empty_queue", "enqueue", "fill_queue"]


class EdgeQueue(NamedTuple):
    """A queue of the edges 0 to E − 1.

    Attributes
    ----------
    heap : (E,) int32
        The queued edges in heap order: the first is the next to leave.
    place : (E,) int32
        Where an edge stands in the heap; −1: not queued.
    size : (1,) int32
        Number of queued edges.
    priority : (E,) float64
        Priority of every queued edge.
    """

    heap: IndexArray
    place: IndexArray
    size: IndexArray
    priority: FloatArray


@kernel
def empty_queue(edges: int) -> EdgeQueue:
    """Return a queue for so many edges, none of them queued."""
    return EdgeQueue(
        np.empty(edges, np.int32),
        np.full(edges, -1, np.int32),
        np.zeros(1, np.int32),
        np.empty(edges, np.float64),
    )


@leaf_kernel
def _comes_first(priority: FloatArray, one: int, other: int) -> bool:
    return priority[one] < priority[other] or (priority[one] == priority[other] and one < other)


@leaf_kernel
def _sift_up(heap: IndexArray, place: IndexArray, priority: FloatArray, position: int) -> None:
    edge = heap[position]
    while position > 0:
        above = (position - 1) >> 2
        if not _comes_first(priority, edge, heap[above]):
            break
        heap[position] = heap[above]
        place[heap[position]] = position
        position = above
    heap[position] = edge
    place[edge] = position


@leaf_kernel
def _sift_down(
    heap: IndexArray, place: IndexArray, priority: FloatArray, position: int, size: int
) -> None:
    edge = heap[position]
    while True:
        child = 4 * position + 1
        if child >= size:
            break
        least = child
        for other in range(child + 1, min(child + 4, size)):
            if _comes_first(priority, heap[other], heap[least]):
                least = other
        if not _comes_first(priority, heap[least], edge):
            break
        heap[position] = heap[least]
        place[heap[position]] = position
        position = least
    heap[position] = edge
    place[edge] = position


@leaf_kernel
def fill_queue(queue: EdgeQueue, count: int) -> None:
    """Queue edges by the priorities that stand there already, in time linear in their number.

    Parameters
    ----------
    queue : EdgeQueue
        Empty, but for the edges to queue at the beginning of `heap`.
    count : int
        How many they are.
    """
    heap, place, priority = queue.heap, queue.place, queue.priority
    for position in range(count):
        place[heap[position]] = position
    queue.size[0] = count
    for position in range((count - 2) >> 2, -1, -1):
        _sift_down(heap, place, priority, position, count)


@leaf_kernel
def enqueue(queue: EdgeQueue, edge: int, value: float) -> None:
    """Queue an edge with a priority, or move it there if it is queued already."""
    heap, place, size, priority = queue.heap, queue.place, queue.size, queue.priority
    known = place[edge] >= 0
    rises = known and value < priority[edge]
    priority[edge] = value
    if not known:
        heap[size[0]] = edge
        place[edge] = size[0]
        size[0] += 1
    if rises or not known:
        _sift_up(heap, place, priority, place[edge])
    else:
        _sift_down(heap, place, priority, place[edge], size[0])


@leaf_kernel
def dequeue(queue: EdgeQueue, edge: int) -> None:
    """Take an edge out of the queue, wherever it stands; one that is not queued is left alone."""
    heap, place, size, priority = queue.heap, queue.place, queue.size, queue.priority
    position = place[edge]
    if position < 0:
        return
    place[edge] = -1
    size[0] -= 1
    last = heap[size[0]]
    if last != edge:
        heap[position] = last
        place[last] = position
        _sift_up(heap, place, priority, position)
        _sift_down(heap, place, priority, place[last], size[0])
