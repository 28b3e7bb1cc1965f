"""The queue of edges, compared with Python's heap and a dictionary."""

import heapq

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.decimation.edge_queue import dequeue, empty_queue, enqueue, fill_queue

PRIORITIES = st.one_of(
    st.sampled_from([0.0, 1.0, 2.0, np.inf]),  # many that are equal
    st.floats(0, 1e6),
)


def drain(queue):
    """Edges in the order in which they leave."""
    edges = []
    while queue.size[0]:
        edges.append(int(queue.heap[0]))
        dequeue(queue, edges[-1])
    return edges


def assert_consistent(queue, queued):
    """Check the order of the heap and the index of every edge in it."""
    size = int(queue.size[0])
    assert set(queue.heap[:size].tolist()) == set(queued)
    for position, edge in enumerate(queue.heap[:size].tolist()):
        assert queue.heap_index[edge] == position
        assert queue.priority[edge] == queued[edge]
        if position:
            above = int(queue.heap[(position - 1) // 4])
            assert (queued[above], above) < (queued[edge], edge)
    assert (queue.heap_index >= 0).sum() == size


@given(st.lists(PRIORITIES, min_size=1, max_size=80))
def test_edges_leave_by_priority_then_by_number(priorities):
    queue = empty_queue(len(priorities))
    queue.priority[:] = priorities
    queue.heap[:] = np.arange(len(priorities))
    fill_queue(queue, len(priorities))
    assert_consistent(queue, dict(enumerate(priorities)))
    heap = [(priority, edge) for edge, priority in enumerate(priorities)]
    heapq.heapify(heap)
    assert drain(queue) == [heapq.heappop(heap)[1] for _ in priorities]


@given(st.lists(PRIORITIES, min_size=1, max_size=80), st.randoms(use_true_random=False))
def test_some_of_the_edges_may_be_queued_in_any_order(priorities, random):
    edges = random.sample(range(len(priorities)), random.randint(0, len(priorities)))
    queue = empty_queue(len(priorities))
    queue.priority[:] = priorities
    queue.heap[: len(edges)] = edges
    fill_queue(queue, len(edges))
    assert_consistent(queue, {edge: priorities[edge] for edge in edges})
    assert drain(queue) == sorted(edges, key=lambda edge: (priorities[edge], edge))


@given(
    st.lists(
        st.tuples(st.sampled_from(["enqueue", "dequeue", "pop"]), st.integers(0, 24), PRIORITIES),
        max_size=120,
    )
)
@pytest.mark.slow
def test_any_sequence_of_changes_is_that_of_a_dictionary(changes):
    queue, queued = empty_queue(25), {}
    for change, edge, priority in changes:
        if change == "enqueue":
            enqueue(queue, edge, priority)
            queued[edge] = priority
        elif change == "dequeue":
            dequeue(queue, edge)
            queued.pop(edge, None)
        elif queued:
            first = min((value, key) for key, value in queued.items())[1]
            assert queue.heap[0] == first
            dequeue(queue, first)
            del queued[first]
        assert_consistent(queue, queued)
    assert drain(queue) == sorted(queued, key=lambda key: (queued[key], key))


@given(st.permutations(range(30)))
@pytest.mark.slow
def test_the_order_of_departure_does_not_depend_on_the_order_of_arrival(order):
    queue = empty_queue(30)
    for edge in order:
        enqueue(queue, edge, float(edge % 3))
    assert drain(queue) == sorted(range(30), key=lambda edge: (edge % 3, edge))


def test_a_new_queue_is_empty():
    queue = empty_queue(3)
    assert queue.size[0] == 0
    dequeue(queue, 1)
    assert queue.size[0] == 0
    assert drain(queue) == []
