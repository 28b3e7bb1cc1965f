import threading
import time

import numpy as np
import pytest

from gamutcore.decimation.watching import watched


def test_what_is_done_is_told_while_it_is_being_done():
    done, told, twice = np.zeros(1, np.int64), [], threading.Event()

    def progress(part):
        told.append(part)
        done[0] += 1
        if len(told) == 2:
            twice.set()

    with watched(done, 4, progress):
        assert twice.wait(10)
    assert told[:2] == [0.0, 0.25]
    after = len(told)
    time.sleep(0.3)
    assert len(told) == after


def test_nobody_looks_where_nobody_wants_to_know():
    before = threading.active_count()
    with watched(np.zeros(1, np.int64), 4, None):
        assert threading.active_count() == before


def test_a_fault_of_the_one_who_is_told_is_raised():
    failed = threading.Event()

    def progress(_part):
        failed.set()
        raise OSError("nobody listens")

    with pytest.raises(OSError, match="nobody listens"), watched(np.zeros(1, int), 4, progress):
        assert failed.wait(10)
