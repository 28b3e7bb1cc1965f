"""The queue of edges, compared with a dictionary."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.decimation.edge_queue import dequeue, empty_queue, enqueue, fill_queue

PRIORITIES = st.one_of(
    st.sampled_from([0.0, 1.0, 2.0, np.inf]),  # many that are equal
    st.floats(0, 1e6),
)


def assert_consistent(queue, queued):
    """Check the order of the heap and the index of every edge in it."""
    size = int(queue.size[0])
    assert set(queue.heap[:size].tolist()) == set(queued)
    for position, edge in enumerate(queue.heap[:size].tolist()):
        assert queue.heap_index[edge] == position
        assert queue.priority[edge] == queued[edge]
    assert (queue.heap_index >= 0).sum() == size
    if queued:
        first = min((value, key) for key, value in queued.items())
        assert queue.heap[0] == first[1]


@given(
    st.dictionaries(st.integers(0, 24), PRIORITIES),
    st.randoms(use_true_random=False),
    st.lists(
        st.tuples(st.sampled_from(["enqueue", "dequeue", "pop"]), st.integers(0, 24), PRIORITIES),
        max_size=120,
    ),
)
@pytest.mark.slow
def test_any_sequence_of_changes_is_that_of_a_dictionary(queued, random, changes):
    """Edges leave by priority, then by number, whatever the order in which they were queued."""
    queue = empty_queue(25)
    assert queue.size[0] == 0
    edges = list(queued)
    random.shuffle(edges)
    queue.heap[: len(edges)] = edges
    queue.priority[edges] = [queued[edge] for edge in edges]
    fill_queue(queue, len(edges))
    assert_consistent(queue, queued)
    for change, edge, priority in changes:
        if change == "enqueue":
            enqueue(queue, edge, priority)
            queued[edge] = priority
        elif change == "dequeue":
            dequeue(queue, edge)
            queued.pop(edge, None)
        elif queued:
            first = int(queue.heap[0])
            dequeue(queue, first)
            del queued[first]
        assert_consistent(queue, queued)
    while queued:
        first = int(queue.heap[0])
        dequeue(queue, first)
        del queued[first]
        assert_consistent(queue, queued)
