"""A priority queue of edges: an indexed 4-ary heap over plain arrays.

Smaller priorities leave first, and equal priorities leave in the order of edge ids. The order of
departure therefore does not depend on the order of arrival. Four children per node halve the depth
of a binary heap and keep the children of a node in one cache line.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import leaf_kernel

__all__ = ["EdgeQueue", "dequeue", "empty_queue", "enqueue", "fill_queue"]


class EdgeQueue(NamedTuple):
    """A queue of the edges 0 to E − 1."""

    heap: IndexArray  # (E,) the queued edges in heap order; the first one leaves next
    heap_index: IndexArray  # (E,) index of an edge in `heap`; −1 if it is not queued
    size: IndexArray  # (1,) number of queued edges
    priority: FloatArray  # (E,) priority of every queued edge


def empty_queue(edges: int) -> EdgeQueue:
    """Return an empty queue with room for `edges` edges."""
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
def _sift_up(queue: EdgeQueue, index: int) -> None:
    """Move an edge towards the root until its parent comes before it."""
    heap, heap_index, priority = queue.heap, queue.heap_index, queue.priority
    edge = int(heap[index])
    while index > 0:
        parent = (index - 1) >> 2
        if not _comes_first(priority, edge, int(heap[parent])):
            break
        heap[index] = heap[parent]
        heap_index[heap[index]] = index
        index = parent
    heap[index] = edge
    heap_index[edge] = index


@leaf_kernel
def _sift_down(queue: EdgeQueue, index: int, size: int) -> None:
    """Move an edge away from the root until it comes before its children."""
    heap, heap_index, priority = queue.heap, queue.heap_index, queue.priority
    edge = int(heap[index])
    while True:
        child = 4 * index + 1
        if child >= size:
            break
        least = child
        for other in range(child + 1, min(child + 4, size)):
            if _comes_first(priority, int(heap[other]), int(heap[least])):
                least = other
        if not _comes_first(priority, int(heap[least]), edge):
            break
        heap[index] = heap[least]
        heap_index[heap[index]] = index
        index = least
    heap[index] = edge
    heap_index[edge] = index


@leaf_kernel
def fill_queue(queue: EdgeQueue, count: int) -> None:
    """Queue edges whose priorities are set, in time linear in their number.

    The queue is empty. The first `count` entries of `heap` name the edges to queue.
    """
    for index in range(count):
        queue.heap_index[queue.heap[index]] = index
    queue.size[0] = count
    for index in range((count - 2) >> 2, -1, -1):
        _sift_down(queue, index, count)


@leaf_kernel
def enqueue(queue: EdgeQueue, edge: int, value: float) -> None:
    """Queue an edge with a priority, or change the priority of a queued edge."""
    queued = queue.heap_index[edge] >= 0
    rises = queued and value < queue.priority[edge]
    queue.priority[edge] = value
    if not queued:
        queue.heap[queue.size[0]] = edge
        queue.heap_index[edge] = queue.size[0]
        queue.size[0] += 1
    if rises or not queued:
        _sift_up(queue, int(np.int64(queue.heap_index[edge])))
    else:
        _sift_down(queue, int(np.int64(queue.heap_index[edge])), int(np.int64(queue.size[0])))


@leaf_kernel
def dequeue(queue: EdgeQueue, edge: int) -> None:
    """Remove an edge from the queue, wherever it stands. Does nothing if it is not queued."""
    index = int(np.int64(queue.heap_index[edge]))
    if index < 0:
        return
    queue.heap_index[edge] = -1
    queue.size[0] -= 1
    last = int(queue.heap[queue.size[0]])
    if last != edge:
        queue.heap[index] = last
        queue.heap_index[last] = index
        _sift_up(queue, index)
        _sift_down(queue, int(np.int64(queue.heap_index[last])), int(np.int64(queue.size[0])))
