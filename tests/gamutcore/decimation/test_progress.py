"""Progress: reports from a thread, and weights of parts."""

import threading
import time

import pytest

from gamutcore.decimation.progress import Progress, report_progress


@pytest.mark.slow
def test_progress_is_reported_while_work_runs():
    done, told, twice = [0], [], threading.Event()

    def progress(part):
        told.append(part)
        done[0] += 1
        if len(told) == 2:
            twice.set()

    with report_progress(lambda: done[0] / 4, progress):
        assert twice.wait(10)
    assert told[:2] == [0.0, 0.25]
    after = len(told)
    time.sleep(0.3)
    assert len(told) == after


def test_without_a_callback_there_is_no_thread():
    before = threading.active_count()
    with report_progress(lambda: 0.0, None):
        assert threading.active_count() == before


def test_an_exception_of_the_callback_is_raised():
    failed = threading.Event()

    def progress(_part):
        failed.set()
        raise OSError("nobody listens")

    with pytest.raises(OSError, match="nobody listens"), report_progress(lambda: 0.0, progress):
        assert failed.wait(10)


def test_parts_are_weighted_by_their_work():
    progress = Progress([(2, 3.0), (10, 1.0), (1, 4.0)])
    assert progress.fraction() == 0
    first = progress.begin_part()
    first[0] = 1
    assert progress.fraction() == 1.5 / 8
    second = progress.begin_part()
    assert progress.fraction() == 3 / 8
    second[0] = 5
    assert progress.fraction() == 3.5 / 8
    progress.begin_part()[0] = 1
    assert progress.fraction() == 1


def test_a_counter_beyond_its_part_counts_as_the_part():
    progress = Progress([(2, 1.0), (2, 1.0)])
    progress.begin_part()[0] = 3
    assert progress.fraction() == 0.5


def test_no_work_is_complete():
    assert Progress([(0, 0.0)]).fraction() == 1
