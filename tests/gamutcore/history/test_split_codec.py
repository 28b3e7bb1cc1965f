"""The codes of splits: bits worked out by hand, any bits, and arrays that are too short."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.decimation import decimate
from gamutcore.errors import HistoryFileError, NeighbourLimitError
from gamutcore.history import (
    History,
    build_history,
    history_bytes,
    history_from_bytes,
    split_codec,
)
from gamutcore.history.bit_codes import (
    BitWriter,
    bit_reader,
    read_bits,
    stream_bytes,
    write_adaptive,
    write_below,
)
from gamutcore.history.replay import (
    LONGEST_LIST,
    MOST_WORK,
    VISITED,
    WORK_PER_VERTEX,
    first_replay,
)
from gamutcore.history.split_codec import (
    FAULTS,
    KEPT,
    MISFIT,
    OK,
    Group,
    first_contexts,
    read_group,
    write_group,
)
from gamutcore.history.splits import Splits, empty_splits, extended_copy

POSITIONS = np.array(
    [(0, 0, 90_000), (80_000, 0, -30_000), (-40_000, 70_000, -30_000), (-40_000, -70_000, -30_000)],
    np.int32,
)
FACES = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32)
CENTRE = np.zeros(3)
STEP = 2.0**-11


def with_room(rows, room):
    """Return rows with room for so many moved corners and neighbours."""
    names = ("moved", "shifted", "shifted_coarse", "shifted_fine")
    return rows._replace(**{name: extended_copy(getattr(rows, name), room) for name in names})


def decoded(stream, vertices, visited=0):
    """Return fault, slot, and splits with spare room."""
    reader = bit_reader(np.frombuffer(stream, np.uint8))
    group = Group(4, vertices, read_bits(reader, 1))
    replay = first_replay(POSITIONS, FACES, vertices)
    replay.used[VISITED] = visited
    rows = with_room(empty_splits(POSITIONS, FACES, vertices - 4), vertices**2)
    fault, slot = read_group(reader, first_contexts(), replay, rows, group, 4, CENTRE / STEP)
    return fault, slot, rows


def in_units(splits):
    """Return splits in steps as splits in units of the colour space."""
    columns = ("base_positions", "coarse", "fine", "added", "shifted_coarse", "shifted_fine")
    units = {name: np.float32(getattr(splits, name) * STEP) for name in columns}
    return splits._replace(**units)


def history_of_first(slots, splits):
    """Return the history of the splits that add the slots before a given one."""
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
    return History(in_units(cut), CENTRE, STEP)


@settings(max_examples=300)
@given(stream=st.binary(max_size=200), dense=st.booleans())
@pytest.mark.slow
def test_any_bits_give_valid_levels(stream, dense):
    """All splits before the faulty one are valid. Bits that are mostly ones code small numbers."""
    if dense:
        stream = bytes(byte | 0x88 for byte in stream)
    fault, slot, splits = decoded(stream, 100)
    assert fault in FAULTS  # so few bytes cannot hold 100 vertices
    history = history_of_first(slot, splits)
    assert history.vertices == slot
    for level in history.levels():
        assert level.validity(CENTRE).is_gamut


@pytest.mark.parametrize("size", [0, 1, 3])
def test_a_stream_that_ends_is_reported_as_such(size):
    fault, slot, _ = decoded(b"\x7f" * size, 50)
    assert "ends" in FAULTS[fault]
    assert slot >= 4


def test_zeros_are_far_off():
    """Zeros announce a plain number of 32 bits; with all bits set it is beyond any coordinate."""
    fault, slot, _ = decoded(b"\x04" + b"\0" * 3 + b"\xff" * 60, 50)
    assert "beyond" in FAULTS[fault]
    assert slot == 4


def test_a_parent_that_keeps_too_much():
    # the first bit, 0, says that no neighbour moves
    writer = BitWriter(np.zeros(100, np.uint8), np.ones(1, np.int64))
    write_below(writer, 0, 4)
    write_below(writer, 0, 3)
    write_adaptive(writer, first_contexts(), KEPT, 2)  # codes 0 and 1 stand for 2 and 1 of 3 faces
    fault, slot, _ = decoded(stream_bytes(writer).tobytes() + b"\xff" * 50, 50)
    assert "keeps more" in FAULTS[fault]
    assert slot == 4


def test_walks_along_rings_that_take_too_long_end():
    """Random bits begin with valid splits, but earlier work leaves room for only one of them."""
    random = np.random.default_rng(3)
    stream = max((random.bytes(100) for _ in range(200)), key=lambda bits: decoded(bits, 100)[1])
    assert decoded(stream, 100)[1] >= 6
    allowed = MOST_WORK + WORK_PER_VERTEX * 100
    fault, slot, _ = decoded(stream, 100, allowed - 150)
    assert "too many neighbours" in FAULTS[fault]
    assert slot == 5
    fault, slot, _ = decoded(stream, 100, allowed)
    assert "too many neighbours" in FAULTS[fault]
    assert slot == 4


def one_split():
    """Split slot 0, above a triangle, into two slots at its own position.

    The ring of slot 0 is 1, 2, 3, beginning with the lowest face. Slot 0 keeps the faces (0, 2, 3)
    and (0, 3, 1). The face (0, 1, 2) passes to slot 4.
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


def written(splits):
    """Write one split without moved neighbours; return the writer and the fault."""
    replay = first_replay(splits.base_positions, splits.base_faces, 5)
    writer = BitWriter(np.zeros(1000, np.uint8), np.ones(1, np.int64))
    fault, _ = write_group(writer, first_contexts(), replay, splits, Group(4, 5, 0), 4)
    return writer, fault


def test_a_split_by_hand():
    splits = one_split()
    writer, fault = written(splits)
    assert fault == OK
    # Relative to slot 0 the ring, beginning with the left slot, is 2: (-8, 8, -8), 3: (-8, -8, -8)
    # and 1: (8, 0, -8). The distances add up to 64, so the mean is below 2⁵. The normal is
    # (0, 0, 256): y is 0 by symmetry, and x is Σ ay bz - az by = -128 + 64 + 64 = 0. The plane is
    # z = 0, and all three slots are 8 off it: a mean of 8, below 2⁴. The kept part is the whole
    # ring, with the sum (-8, 0). The lost part is 1 and 2, with the sum (0, 8).
    ahead_u = np.floor((2 * (-8 / 3) - 0 / 2) / 5 + 0.5)
    ahead_v = np.floor((2 * (0 / 3) - 8 / 2) / 5 + 0.5)
    assert (ahead_u, ahead_v) == (-1, -1)
    expected = (
        "0"  # no neighbour moves
        "00"  # slot 0 of 4
        "10"  # the cut is one face after the lowest: 1 of 3
        "1"  # the parent keeps 2 of 3 faces, the larger half
        # a context starts with half the limit of its class: 2⁵ ÷ 2 gives four bits, 2⁴ ÷ 2 three
        "10010"  # 1, coded as 2, cancels the prediction -1; total 17, count 2: four bits again
        "10010"
        "1000"  # 0 off the plane
        "1000"  # 0, relative to the mirrored parent: three bits
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
    assert written(splits)[1] == MISFIT


def test_the_error_of_a_misfit_names_the_slot(small_history):
    moved = small_history.splits.moved.copy()
    moved[-1] += 3
    history = History(
        small_history.splits._replace(moved=moved), small_history.centre, small_history.step
    )
    with pytest.raises(HistoryFileError) as caught:
        history_bytes(history)
    assert caught.value.where == {"slot": small_history.vertices - 1}


def test_what_readers_would_refuse_is_not_written(small_history, monkeypatch):
    monkeypatch.setattr(split_codec, "MOST_WORK", 0)
    assert history_bytes(small_history)
    monkeypatch.setattr(split_codec, "WORK_PER_VERTEX", 1)
    with pytest.raises(NeighbourLimitError, match="triangles meet") as caught:
        history_bytes(small_history)
    assert 3 <= caught.value.where["neighbours"] < small_history.vertices
    monkeypatch.undo()
    monkeypatch.setattr(split_codec, "MOVED_PER_VERTEX", 0)
    with pytest.raises(NeighbourLimitError):
        history_bytes(small_history)


def test_work_grows_with_the_slots_not_with_their_neighbours(double_pyramid):
    """Two vertices are neighbours of all others. Their degree does not add work per vertex."""
    visited = []
    for rim in (1000, 4000):
        made = build_history(decimate(double_pyramid(rim), np.zeros(3), "volume"))
        read, _ = history_from_bytes(history_bytes(made))
        packed = read._packed
        read.unpack()
        visited.append(packed._replay.used[VISITED] / made.vertices)
    assert visited[1] < 1.1 * visited[0]
    assert visited[1] < 2 * LONGEST_LIST
