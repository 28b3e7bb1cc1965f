"""From splits to bits: a split coded by hand, and splits that do not fit."""

import numpy as np
import pytest

from gamutcore.decimation import decimate
from gamutcore.errors import HistoryFileError, NeighbourLimitError
from gamutcore.history import History, build_history, file, history_bytes, history_from_bytes
from gamutcore.history.bit_codes import stream_bytes
from gamutcore.history.prefix_order import Splits, group_ranges
from gamutcore.history.rings import VISITED, first_replay
from gamutcore.history.split_codes import first_contexts
from gamutcore.history.split_writer import write_group


def one_split():
    """Slot 0, which rises over a triangle, is split into two that stay where it was.

    Its ring is 1, 2, 3, from the face with the smallest number on. It keeps the faces (0, 2, 3) and
    (0, 3, 1); the face (0, 1, 2) passes to slot 4.
    """
    positions = np.array([(0, 0, 8), (8, 0, 0), (-8, 8, 0), (-8, -8, 0)], np.int32)
    here = positions[:1]
    none = np.zeros((0, 3), np.int32)
    return Splits(
        base_positions=positions,
        base_faces=np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32),
        parent=np.zeros(1, np.int32),
        coarse=here,
        fine=here,
        added=here,
        faces=np.array([[(0, 4, 2), (4, 0, 1)]], np.int32),
        moved_end=np.ones(1, np.int32),
        moved=np.zeros(1, np.int32),
        shifted_end=np.zeros(1, np.int32),
        shifted=np.zeros(0, np.int32),
        shifted_coarse=none,
        shifted_fine=none,
    )


def test_a_split_by_hand():
    splits = one_split()
    replay = first_replay(splits.base_positions, splits.base_faces, 5)
    writer, faulty, _ = write_group(first_contexts(), replay, splits, 4, 5)
    assert faulty == 0
    # Relative to slot 0 the ring, from the left slot on, is 2: (-8, 8, -8), 3: (-8, -8, -8) and
    # 1: (8, 0, -8). Their distances add up to 64, so that the mean is below 2⁵; the normal is
    # (0, 0, 256) by symmetry but for x: Σ ay bz - az by = -128 + 64 + 64 = 0. The plane is z = 0,
    # and 8 · 3 off it give a mean of 8, below 2⁴. The kept part is all of the ring, with the sum
    # (-8, 0); the lost part 1 and 2, with the sum (0, 8).
    ahead_u = np.floor((2 * (-8 / 3) - 0 / 2) / 5 + 0.5)
    ahead_v = np.floor((2 * (0 / 3) - 8 / 2) / 5 + 0.5)
    assert (ahead_u, ahead_v) == (-1, -1)
    expected = (
        "0"  # nothing shifts
        "00"  # slot 0 of 4
        "10"  # one face on from the first: 1 of 3
        "1"  # it keeps 2 of 3, the larger half
        # the mean of a class is half its limit: 2⁵ ÷ 2 = 2⁴ gives four bits, 2⁴ ÷ 2 three
        "10010"  # 1, as 2, to undo the expectation of -1; the total is 17, the count 2: 2⁴ again
        "10010"
        "1000"  # 0 off the plane
        "1000"  # where the parent is not, 0: three bits
        "1000"  # the total is 8, the count 2: two bits
        "1000"
    )
    expected = expected[: -len("10001000")] + "100" + "1000"
    bits = "".join(map(str, np.unpackbits(stream_bytes(writer))))
    assert bits[: int(writer.position[0])] == expected
    assert set(bits[int(writer.position[0]) :]) <= {"0"}


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("coarse", lambda a: a + 1),
        ("parent", lambda a: a + 1),
        ("moved", lambda a: a + 3),
        ("moved_end", lambda a: a * 0),
        ("moved_end", lambda a: a + 2),
        ("faces", lambda a: a[:, ::-1]),
        ("faces", lambda a: np.roll(a, 1, axis=2)),
        ("faces", lambda a: np.where(a == 2, 3, a)),
    ],
)
def test_splits_that_do_not_fit_are_not_written(name, change):
    splits = one_split()
    splits = splits._replace(**{name: np.ascontiguousarray(change(getattr(splits, name)))})
    replay = first_replay(splits.base_positions, splits.base_faces, 5)
    assert write_group(first_contexts(), replay, splits, 4, 5)[1] == 4


def test_the_error_names_the_slot(small_history):
    moved = small_history.splits.moved.copy()
    moved[-1] += 3
    history = History(
        small_history.splits._replace(moved=moved), small_history.centre, small_history.step
    )
    with pytest.raises(HistoryFileError) as caught:
        history_bytes(history)
    assert caught.value.where == {"slot": small_history.vertices - 1}


def test_a_shift_of_a_slot_that_is_no_neighbour_is_not_written(shifting_history):
    splits = shifting_history.splits
    shifted = splits.shifted.copy()
    last = int(np.searchsorted(splits.shifted_end, len(shifted)))
    shifted[-1] = splits.parent[last]
    history = History(
        splits._replace(shifted=shifted), shifting_history.centre, shifting_history.step
    )
    with pytest.raises(HistoryFileError) as caught:
        history_bytes(history)
    assert caught.value.where == {"slot": last + 4}


def test_what_readers_would_refuse_is_not_written(small_history, monkeypatch):
    monkeypatch.setattr(file, "MOST_WORK", 0)
    assert history_bytes(small_history)
    monkeypatch.setattr(file, "WORK_PER_VERTEX", 1)
    with pytest.raises(NeighbourLimitError, match="triangles meet") as caught:
        history_bytes(small_history)
    assert 3 <= caught.value.where["neighbours"] < small_history.vertices
    monkeypatch.undo()
    monkeypatch.setattr(file, "MOVED_PER_VERTEX", 0)
    with pytest.raises(NeighbourLimitError):
        history_bytes(small_history)


@pytest.mark.parametrize("name", ["small_history", "shifting_history", "double_pyramid"])
def test_writers_count_what_readers_do(name, request):
    made = request.getfixturevalue(name)
    if name == "double_pyramid":
        made = build_history(decimate(made(600), np.zeros(3), "finest"))
    splits, step = made.splits, made.step
    data = history_bytes(made)
    history, _ = history_from_bytes(data)
    packed = history._packed
    in_steps = splits._replace(
        **{
            field: np.rint(array / step).astype(np.int32)
            for field, array in splits._asdict().items()
            if array.dtype == np.float32
        }
    )
    replay = first_replay(in_steps.base_positions, in_steps.base_faces, splits.vertices)
    contexts = first_contexts()
    for start, end in group_ranges(splits.vertices):
        _, faulty, replay = write_group(contexts, replay, in_steps, start, end)
        assert faulty == 0
        packed.unpack()
        assert packed._replay.used[VISITED] == replay.used[VISITED] > 0
