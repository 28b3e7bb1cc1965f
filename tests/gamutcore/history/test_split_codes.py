"""What writer and reader of splits agree on."""

import numpy as np

from gamutcore.history import split_codes
from gamutcore.history.prediction import CLASSES
from gamutcore.history.split_codes import LARGEST_COORDINATE, first_contexts


def test_the_kinds_of_contexts_do_not_overlap():
    kinds = [
        split_codes.KEPT,
        split_codes.PARENT_ALONG,
        split_codes.PARENT_OFF,
        split_codes.ADDED_ALONG,
        split_codes.ADDED_OFF,
        split_codes.SHIFTED_ALONG,
        split_codes.SHIFTED_OFF,
    ]
    used = {kind + length_class for kind in kinds for length_class in range(CLASSES)}
    assert used == set(range(len(first_contexts().totals)))


def test_contexts_begin_with_half_the_limit_of_their_class():
    contexts = first_contexts()
    assert (contexts.counts == 1).all()
    assert contexts.totals[split_codes.ADDED_OFF + 10] == 512
    assert contexts.totals[split_codes.KEPT] == 0


def test_the_largest_coordinate_is_the_last_that_float32_counts_to():
    assert np.float32(LARGEST_COORDINATE) + np.float32(-1) == LARGEST_COORDINATE - 1
    assert np.float32(LARGEST_COORDINATE) + np.float32(1) == LARGEST_COORDINATE
