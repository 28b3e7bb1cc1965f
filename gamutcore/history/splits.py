"""Splits: a history in the one numbering in which every level is a prefix of vertices and faces.

Vertices are called slots here and are numbered by the reverse order of their removal. The last four
vertices are slots 0 to 3. Slot k ≥ 4 and faces 2k − 4 and 2k − 3 are added by the split that leads
to k + 1 vertices. The level with v vertices is slots [0, v) and faces [0, 2v − 4).

A vertex is renumbered once, from the boundary's order to its slot (`vertex_slots`). A corner is
renumbered once, from 3 · boundary face + place to 3 · face + place. Each face begins with its
oldest corner. Everything after this module (columns, device values, levels) uses these numbers.
The *part* of a split in `moved` or `shifted` is its range of entries: in the order of the ring in
`moved`, ascending in `shifted`.

A split writes the new positions of the parent and of neighbours that move, and the position of the
new slot. It writes the new slot into the corners that pass to it, and adds two faces. A collapse
writes the old positions and the parent back into the same corners. Slots and faces behind the end
of a level are not part of it.
"""

from __future__ import annotations

from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from gamutcore.arrays import Float32Array, IndexArray, LongArray, ShortArray
from gamutcore.geometry import copy_row
from gamutcore.kernels import inlined_kernel, kernel

if TYPE_CHECKING:
    from gamutcore.decimation import Decimation

__all__ = [
    "Splits",
    "apply_splits",
    "ascending_order",
    "extended_copy",
    "fine_columns",
    "group_count",
    "group_ranges",
    "joined_splits",
    "no_splits",
    "part_begin",
    "prefix_order_splits",
    "refine",
    "undo_splits",
    "vertex_slots",
]


Scalar = TypeVar("Scalar", bound="np.generic[Any]")


class Splits(NamedTuple):
    """A history as the splits that lead from four triangles to the full boundary.

    While a file is written, positions are int32, in steps of the grid.

    Row i of `parent`, `coarse`, `fine`, `added`, `faces` and of both `…_end` arrays belongs to the
    split that adds slot k = i + 4.

    Attributes
    ----------
    base_positions : (4, 3) float32
        Slots 0 to 3 at the coarsest level.
    base_faces : (4, 3) int32
        Faces 0 to 3 at the coarsest level, each beginning with its smallest slot.
    parent : (V − 4,) int32
        The slot < k that is split.
    coarse, fine : (V − 4, 3) float32
        Position of the parent before and after the split.
    added : (V − 4, 3) float32
        Position of the new slot.
    faces : (V − 4, 2, 3) int32
        Faces 2k − 4 and 2k − 3: (parent, k, left) and (k, parent, right). `left` and `right` are
        neighbours of the parent before the split.
    moved_end : (V − 4,) int32
        End of each split's part of `moved`; the part begins at the end of the part before.
    moved : (m,) int32
        Corners (3 · face + place in the face) that pass from the parent to the new slot. Their
        order is counter-clockwise around the new slot, from `right` to `left`.
    shifted_end : (V − 4,) int32
        End of each split's part of the next three arrays.
    shifted : (s,) int32
        Neighbours of the parent before the split that the split moves, ascending.
    shifted_coarse, shifted_fine : (s, 3) float32
        Their positions before and after the split.
    """

    base_positions: Float32Array
    base_faces: IndexArray
    parent: IndexArray
    coarse: Float32Array
    fine: Float32Array
    added: Float32Array
    faces: IndexArray
    moved_end: IndexArray
    moved: IndexArray
    shifted_end: IndexArray
    shifted: IndexArray
    shifted_coarse: Float32Array
    shifted_fine: Float32Array

    @property
    def vertices(self) -> int:
        """Number of vertices of the full boundary."""
        return len(self.parent) + 4

    @property
    def nbytes(self) -> int:
        """Memory of the arrays in bytes."""
        return sum(array.nbytes for array in self)


def no_splits(base_positions: Float32Array, base_faces: IndexArray) -> Splits:
    """Return the history of the coarsest level alone."""
    numbers = np.empty(0, np.int32)
    positions = np.empty((0, 3), np.float32)
    return Splits(
        base_positions=base_positions,
        base_faces=base_faces,
        parent=numbers,
        coarse=positions,
        fine=positions,
        added=positions,
        faces=np.empty((0, 2, 3), np.int32),
        moved_end=numbers,
        moved=numbers,
        shifted_end=numbers,
        shifted=numbers,
        shifted_coarse=positions,
        shifted_fine=positions,
    )


def joined_splits(splits: Splits, rows: Splits) -> Splits:
    """Return splits followed by the next group, whose arrays `…_end` count from its own begin."""
    rows = rows._replace(
        moved_end=rows.moved_end + np.int32(len(splits.moved)),
        shifted_end=rows.shifted_end + np.int32(len(splits.shifted)),
    )
    pairs: Any = zip(splits[2:], rows[2:], strict=True)
    columns: list[Any] = [np.concatenate(pair) for pair in pairs]
    return Splits(splits.base_positions, splits.base_faces, *columns)


def group_ranges(vertices: int) -> list[tuple[int, int]]:
    """Return the first slot and the end of each group of splits: (4, 8), (8, 16), and so on.

    Each group doubles the number of vertices. A history keeps one snapshot per group.
    """
    starts = [4 << number for number in range(group_count(vertices))]
    return [(start, min(2 * start, vertices)) for start in starts]


def group_count(vertices: int) -> int:
    """Return the number of groups that a level with so many vertices (≥ 4) needs."""
    return (vertices - 1).bit_length() - 2


def vertex_slots(decimation: Decimation) -> IndexArray:
    """Return the slot of each vertex of the full boundary, (V,) int32."""
    dead = decimation.record.dead
    slots = np.full(len(dead) + 4, -1, np.int32)
    slots[dead] = np.arange(len(dead) + 3, 3, -1, dtype=np.int32)
    slots[slots < 0] = np.arange(4, dtype=np.int32)
    return slots


def prefix_order_splits(decimation: Decimation, slots: IndexArray) -> Splits:
    """Turn the collapses of a decimation into splits, with slots by `vertex_slots`."""
    record = decimation.record
    splits = len(record.dead)
    # new number of each face, and the place of its first corner
    first_corner = np.full(2 * splits + 4, -1, np.int32)
    removed = record.corner[::-1].ravel()
    removed_face = removed // 3
    first_corner[removed_face] = removed - 3 * removed_face
    left = np.flatnonzero(first_corner < 0)
    base = slots[decimation.vertex.reshape(-1, 3)[left]]
    first_corner[left] = base.argmin(axis=1)
    face = np.empty(2 * splits + 4, np.int32)
    face[left] = np.arange(4, dtype=np.int32)
    face[removed_face] = np.arange(4, 2 * splits + 4, dtype=np.int32)

    added = np.arange(4, splits + 4, dtype=np.int32)
    parent, sides = slots[record.kept[::-1]], slots[record.sides[::-1]]
    new_faces = (parent, added, sides[:, 0], added, parent, sides[:, 1])
    moved_end, moved_order = _reversed_parts(record.moved_end)
    moved_face, place = np.divmod(record.moved[moved_order], 3)
    shifted_end, shifted_order = _reversed_parts(record.shifted_end)
    shifted_order = shifted_order[
        ascending_order(shifted_end, slots[record.shifted[shifted_order]])
    ]
    return Splits(
        base_positions=decimation.positions[np.flatnonzero(slots < 4)],
        base_faces=np.take_along_axis(
            base, (first_corner[left][:, np.newaxis] + np.arange(3)) % 3, axis=1
        ),
        parent=parent,
        coarse=np.ascontiguousarray(record.position[::-1, 2]),
        fine=np.ascontiguousarray(record.position[::-1, 0]),
        added=np.ascontiguousarray(record.position[::-1, 1]),
        faces=np.stack(new_faces, axis=1).reshape(-1, 2, 3),
        moved_end=moved_end,
        moved=3 * face[moved_face] + (place - first_corner[moved_face]) % 3,
        shifted_end=shifted_end,
        shifted=slots[record.shifted[shifted_order]],
        shifted_coarse=record.shift[shifted_order, 1],
        shifted_fine=record.shift[shifted_order, 0],
    )


def ascending_order(ends: IndexArray, slots: IndexArray) -> LongArray:
    """Return the order in which slots ascend within the part of each split."""
    part = np.repeat(np.arange(len(ends)), np.diff(ends, prepend=0))
    return np.lexsort((slots, part))


def extended_copy(array: NDArray[Scalar], rows: int) -> NDArray[Scalar]:
    """Return a copy of an array with so many rows; further rows are not initialised."""
    longer: NDArray[Scalar] = np.empty((rows, *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


@inlined_kernel
def part_begin(ends: NDArray[Scalar], part: int) -> int:
    """Begin of a part, if the parts have these ends and follow one another."""
    return int(ends[part - 1]) if part > 0 else 0


def _reversed_parts(ends: LongArray) -> tuple[IndexArray, LongArray]:
    """Ends of the parts in reverse order of the parts, and the order of their elements."""
    sizes = np.diff(ends, prepend=0)[::-1]
    reversed_ends = sizes.cumsum()
    shift = np.repeat(ends[::-1] - reversed_ends, sizes)
    return reversed_ends.astype(np.int32), np.arange(len(shift)) + shift


# arrays one by one: numba takes three microseconds more for a tuple of them
fine_columns = attrgetter(
    "parent",
    "fine",
    "added",
    "faces",
    "moved_end",
    "moved",
    "shifted_end",
    "shifted",
    "shifted_fine",
)
"""The last arguments of `apply_splits`, from `Splits`."""


def refine(
    splits: Splits, positions: Float32Array, corners: IndexArray, start: int, end: int
) -> None:
    """Split a level with `start` vertices until it has `end`, in place.

    The arrays have room for the finer level; `corners` are the slots at the corners, face by face.
    """
    apply_splits(positions, corners, start, end, *fine_columns(splits))


@kernel
def apply_splits(
    positions: Float32Array,
    corners: IndexArray,
    start: int,
    end: int,
    parent: IndexArray,
    fine: Float32Array,
    added: Float32Array,
    faces: IndexArray,
    moved_end: IndexArray,
    moved: IndexArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_fine: Float32Array,
) -> None:
    """Split a level as `refine` does, from a kernel. The last arrays are fields of `Splits`."""
    for slot in range(start, end):
        split = slot - 4
        copy_row(positions, parent[split], fine, split)
        copy_row(positions, slot, added, split)
        for index in range(part_begin(shifted_end, split), shifted_end[split]):
            copy_row(positions, shifted[index], shifted_fine, index)
        for index in range(part_begin(moved_end, split), moved_end[split]):
            corners[moved[index]] = slot
        first = 3 * (2 * slot - 4)
        for side in range(2):
            for place in range(3):
                corners[first + 3 * side + place] = faces[split, side, place]


@inlined_kernel
def undo_splits(
    rows: Float32Array | ShortArray,
    columns: int,
    start: int,
    end: int,
    parent: IndexArray,
    coarse: Float32Array | ShortArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_coarse: Float32Array | ShortArray,
) -> None:
    """Turn the first rows of a level with `start` slots into those of the level with `end` slots.

    Rows are positions or device values. Only `end` rows are needed. With a constant number of
    columns the loops over columns are unrolled.
    """
    for split in range(start - 5, end - 5, -1):
        if parent[split] < end:
            for column in range(columns):
                rows[parent[split], column] = coarse[split, column]
        for index in range(part_begin(shifted_end, split), shifted_end[split]):
            if shifted[index] < end:
                for column in range(columns):
                    rows[shifted[index], column] = shifted_coarse[index, column]
