"""From bits to splits: whatever the bits, the kernel ends, and what it accepts is valid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.history.bit_codes import (
    BitWriter,
    bit_reader,
    stream_bytes,
    write_adaptive,
    write_below,
)
from gamutcore.history.history import History
from gamutcore.history.prefix_order import Splits
from gamutcore.history.rings import MOST_WORK, VISITED, WORK_PER_VERTEX, first_replay
from gamutcore.history.split_codes import KEPT, first_contexts
from gamutcore.history.split_reader import FAULTS, MOVED, SHIFTED, read_group

POSITIONS = np.array(
    [(0, 0, 90_000), (80_000, 0, -30_000), (-40_000, 70_000, -30_000), (-40_000, -70_000, -30_000)],
    np.int32,
)
FACES = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32)
CENTRE = np.zeros(3)
STEP = 2.0**-11


def decoded(stream, vertices, visited=0):
    """Fault, slot, splits with room behind those in use, rows in use, and the bits read."""
    count, used = vertices - 4, np.zeros(2, np.int64)
    splits = Splits(
        np.float32(POSITIONS * STEP),
        FACES,
        np.empty(count, np.int32),
        *np.empty((3, count, 3), np.float32),
        np.empty((count, 2, 3), np.int32),
        np.empty(count, np.int32),
        np.empty(64, np.int32),
        np.empty(count, np.int32),
        np.empty(0, np.int32),
        *np.empty((2, 0, 3), np.float32),
    )
    reader = bit_reader(np.frombuffer(stream, np.uint8))
    replay = first_replay(POSITIONS, FACES, vertices)
    replay.used[VISITED] = visited
    fault, slot, _, splits = read_group(
        reader, first_contexts(), replay, splits, used, 4, vertices, vertices, CENTRE, STEP
    )
    return fault, slot, splits, used, int(reader.position[0])


def history_of_first(slots, splits):
    """Return the history of the splits before a slot."""
    count = slots - 4
    moved = int(splits.moved_end[count - 1]) if count else 0
    shifted = int(splits.shifted_end[count - 1]) if count else 0
    rows = ("parent", "coarse", "fine", "added", "faces", "moved_end", "shifted_end")
    cut = splits._replace(
        moved=splits.moved[:moved],
        shifted=splits.shifted[:shifted],
        shifted_coarse=splits.shifted_coarse[:shifted],
        shifted_fine=splits.shifted_fine[:shifted],
        **{name: getattr(splits, name)[:count] for name in rows},
    )
    return History(cut, CENTRE, STEP)


@settings(max_examples=300)
@given(stream=st.binary(max_size=200), dense=st.booleans())
def test_any_bits(stream, dense):
    """All splits before the faulty one are valid. Bits that are mostly ones have small numbers."""
    if dense:
        stream = bytes(byte | 0x88 for byte in stream)
    fault, slot, splits, used, _ = decoded(stream, 100)
    assert fault in FAULTS  # 100 vertices do not fit into so few bytes
    history = history_of_first(slot, splits)
    assert history.vertices == slot
    for level in history.levels():
        assert level.validity(CENTRE).is_gamut
    assert used[MOVED] <= splits.moved.size
    assert used[SHIFTED] <= splits.shifted.size


def test_some_random_bits_are_splits():
    """The property above is not empty."""
    random = np.random.default_rng(3)
    slots = [decoded(random.bytes(100), 100)[1] for _ in range(200)]
    assert max(slots) >= 6


@pytest.mark.parametrize("size", [0, 1, 3])
def test_a_stream_that_ends_is_reported_as_such(size):
    fault, slot, *_ = decoded(b"\x7f" * size, 50)
    assert "ends" in FAULTS[fault]
    assert slot >= 4


def test_zeros_are_far_off():
    """Zeros announce plain numbers of 32 bits; set, they are beyond any coordinate."""
    fault, slot, *_ = decoded(b"\x04" + b"\0" * 3 + b"\xff" * 60, 50)
    assert "beyond" in FAULTS[fault]
    assert slot == 4


def test_a_parent_that_keeps_too_much():
    writer = BitWriter(np.zeros(100, np.uint8), np.ones(1, np.int64))  # behind the bit of shifts
    write_below(writer, 0, 4)
    write_below(writer, 0, 3)
    write_adaptive(writer, first_contexts(), KEPT, 2)  # 0 and 1 are 2 and 1 of 3 faces
    fault, slot, *_ = decoded(stream_bytes(writer).tobytes() + b"\xff" * 50, 50)
    assert "keeps more" in FAULTS[fault]
    assert slot == 4


def test_walks_along_rings_that_take_too_long_end():
    """Random bits whose first splits are valid, after as much as is allowed but for one split."""
    random = np.random.default_rng(3)
    stream = max((random.bytes(100) for _ in range(200)), key=lambda bits: decoded(bits, 100)[1])
    assert decoded(stream, 100)[1] >= 6
    allowed = MOST_WORK + WORK_PER_VERTEX * 100
    fault, slot, *_ = decoded(stream, 100, allowed - 150)
    assert "too many neighbours" in FAULTS[fault]
    assert slot == 5
    fault, slot, *_ = decoded(stream, 100, allowed)
    assert "too many neighbours" in FAULTS[fault]
    assert slot == 4
