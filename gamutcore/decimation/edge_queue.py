"""A priority queue of edges: an indexed 4-ary heap over plain arrays.

``heap[:size[0]]`` holds edge ids in heap order, ``place[e]`` the position of edge e in it (−1: not
queued) and ``priority[e]`` its priority. Smaller priorities come first, equal ones by edge id, so the order in
which edges leave does not depend on how they came in. Four children a node halve the depth of a
binary heap and keep a node's children in one cache line.
"""

from __future__ import annotations

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import kernel

__all__ = ["dequeue", "enqueue", "fill_queue"]


@kernel
def _comes_first(priority: FloatArray, one: int, other: int) -> bool:
    return priority[one] < priority[other] or (priority[one] == priority[other] and one < other)


@kernel
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


@kernel
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


@kernel
def fill_queue(
    heap: IndexArray, place: IndexArray, size: IndexArray, priority: FloatArray
) -> None:
    """Queue all edges at once, in time proportional to their number."""
    count = heap.size
    for edge in range(count):
        heap[edge] = edge
        place[edge] = edge
    size[0] = count
    for position in range((count - 2) >> 2, -1, -1):
        _sift_down(heap, place, priority, position, count)


@kernel
def enqueue(
    heap: IndexArray,
    place: IndexArray,
    size: IndexArray,
    priority: FloatArray,
    edge: int,
    value: float,
) -> None:
    """Queue an edge with a priority, or move it there if it is queued already."""
    priority[edge] = value
    if place[edge] < 0:
        heap[size[0]] = edge
        place[edge] = size[0]
        size[0] += 1
    _sift_up(heap, place, priority, place[edge])
    _sift_down(heap, place, priority, place[edge], size[0])


@kernel
def dequeue(
    heap: IndexArray, place: IndexArray, size: IndexArray, priority: FloatArray, edge: int
) -> None:
    """Take an edge out of the queue, wherever it stands; one that is not queued is left alone."""
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
