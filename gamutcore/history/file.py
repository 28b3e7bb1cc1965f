"""The history file: self-describing, pickle-free, coarse levels first.

A history file is a safetensors file (an 8-byte length, a JSON header that names type, shape and
place of every array, then the arrays' raw little-endian bytes), so any safetensors library reads
it; the full description is in ``docs/history-format.md``. The splits are stored in groups that
double the number of vertices, one group after the other: any prefix that ends with a group is a
complete history of the coarser levels. Loading never trusts the file: every number that is used as
an index is checked, all splits are replayed on the way, and the coarsest and the finest level must
be closed. Whether levels are star-shaped is not derived again; who wrote the file is known by its
digest.
"""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from safetensors import SafetensorError, deserialize

from gamutcore.arrays import IndexArray
from gamutcore.corner_table import opposite_corners
from gamutcore.errors import HistoryFileError
from gamutcore.history.history import History
from gamutcore.history.prefix_order import Splits
from gamutcore.kernels import kernel

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from numpy.typing import NDArray

__all__ = ["FORMAT", "VERSION", "history_bytes", "history_from_bytes", "history_metadata"]

FORMAT = "gamut-history"
"""Value of ``format`` in the metadata of every history file."""

VERSION = "1"
"""Value of ``version``; raised when a reader of this version could not read the file any more."""

LARGEST_HEADER = 16 * 1024 * 1024
"""Headers longer than this are refused before they are parsed (bytes)."""

LARGEST_VERTICES = 2**28
"""Corner numbers, below 6 V, must stay within int32."""

COLUMNS: dict[str, tuple[str, tuple[int, ...]]] = {
    "parent": ("I32", ()),
    "coarse": ("F32", (3,)),
    "fine": ("F32", (3,)),
    "added": ("F32", (3,)),
    "faces": ("I32", (2, 3)),
    "moved_end": ("I32", ()),
}
"""Arrays of every group with one row per split: type and shape of a row."""

TYPES: dict[str, np.dtype[Any]] = {
    "F64": np.dtype("<f8"),
    "F32": np.dtype("<f4"),
    "I32": np.dtype("<i4"),
}


def history_bytes(history: History, metadata: Mapping[str, str] | None = None) -> bytes:
    """Write a history to bytes.

    Parameters
    ----------
    history : History
    metadata : mapping of str to str, optional
        Kept in the header beside the format's own ``format``, ``version`` and ``vertices``.

    Returns
    -------
    bytes
    """
    splits = history.splits
    arrays: list[tuple[str, NDArray[np.generic]]] = [
        ("centre", np.asarray(history.centre, "<f8")),
        ("base.positions", np.asarray(splits.base_positions, "<f4")),
        ("base.faces", np.asarray(splits.base_faces, "<i4")),
    ]
    for number, (start, end) in enumerate(_groups(splits.vertices)):
        rows = slice(start - 4, end - 4)
        first = int(splits.moved_end[start - 5]) if start > 4 else 0
        last = int(splits.moved_end[end - 5])
        group: dict[str, NDArray[np.generic]] = {
            name: getattr(splits, name)[rows] for name in COLUMNS
        }
        group["moved_end"] = splits.moved_end[rows] - np.int32(first)
        group["moved"] = splits.moved[first:last]
        for name, array in group.items():
            stored = TYPES[COLUMNS[name][0] if name in COLUMNS else "I32"]
            arrays.append((f"splits.{number:02d}.{name}", array.astype(stored, copy=False)))
    names = {kind: name for name, kind in TYPES.items()}
    described = {
        **(metadata or {}),
        "format": FORMAT,
        "version": VERSION,
        "vertices": str(splits.vertices),
    }
    header: dict[str, object] = {"__metadata__": described}
    offset = 0
    for name, array in arrays:
        header[name] = {
            "dtype": names[array.dtype],
            "shape": list(array.shape),
            "data_offsets": [offset, offset + array.nbytes],
        }
        offset += array.nbytes
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 8)
    return b"".join([struct.pack("<Q", len(text)), text, *(array.tobytes() for _, array in arrays)])


def history_from_bytes(data: bytes) -> tuple[History, dict[str, str]]:
    """Read a history and check it.

    Parameters
    ----------
    data : bytes
        A whole history file.

    Returns
    -------
    history : History
    metadata : dict of str to str

    Raises
    ------
    HistoryFileError
        If anything in the file is not as it should be; says what and where.
    """
    metadata = _parsed_metadata(data)
    try:
        arrays = {name: _array(name, tensor) for name, tensor in deserialize(data)}
    except SafetensorError as cause:
        raise HistoryFileError(
            f"the history file is damaged: {cause}",
            remedy="the file as it was delivered, unchanged",
        ) from cause
    vertices = _vertex_count(metadata)
    splits = _assembled(arrays, vertices)
    _check_replay(splits)
    centre = arrays["centre"].astype(np.float64)
    return History(splits, centre, 2.0**-11), metadata


def history_metadata(path: Path) -> dict[str, str]:
    """Read the metadata of a history file without its arrays.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict of str to str

    Raises
    ------
    HistoryFileError
        If the file does not begin like a history.
    OSError
        If it cannot be read.
    """
    with path.open("rb") as file:
        length = file.read(8)
        size = struct.unpack("<Q", length)[0] if len(length) == 8 else 0
        return _parsed_metadata(length + file.read(min(size, LARGEST_HEADER)))


def _groups(vertices: int) -> list[tuple[int, int]]:
    """Slot ranges of the groups: [4, 8), [8, 16), ..., the last one cut at the vertex count."""
    groups = []
    start = 4
    while start < vertices:
        groups.append((start, min(2 * start, vertices)))
        start *= 2
    return groups


def _parsed_metadata(data: bytes) -> dict[str, str]:
    size = struct.unpack("<Q", data[:8])[0] if len(data) >= 8 else 0
    if not 2 <= size <= LARGEST_HEADER or len(data) < 8 + size:
        raise HistoryFileError(
            "this is not a history file: it does not begin with the length of a header",
            where={"byte": 0},
            remedy="a file as delivered under /history",
        )
    try:
        header = json.loads(data[8 : 8 + size])
        metadata = header["__metadata__"]
        kind, version = metadata["format"], metadata["version"]
    except (ValueError, KeyError, TypeError, RecursionError) as cause:
        raise HistoryFileError(
            "this is not a history file: its header is not the JSON of one",
            where={"byte": 8},
            remedy="a file as delivered under /history",
        ) from cause
    if kind != FORMAT or not all(isinstance(value, str) for value in metadata.values()):
        raise HistoryFileError(
            f"the file is of the format {kind!r}", where={"field": "format"}, remedy=FORMAT
        )
    if version != VERSION:
        raise HistoryFileError(
            f"the history has the version {version!r}; this reader knows version {VERSION}",
            where={"field": "version"},
            remedy="a reader as new as the file, or a file built anew",
        )
    return dict(metadata)


def _vertex_count(metadata: Mapping[str, str]) -> int:
    text = metadata.get("vertices", "")
    count = int(text) if text.isascii() and text.isdecimal() and len(text) < 12 else 0
    if not 4 <= count <= LARGEST_VERTICES:
        raise HistoryFileError(
            f"the history says it has {text[:20]!r} vertices",
            where={"field": "vertices"},
            remedy=f"a number from 4 to {LARGEST_VERTICES}",
        )
    return count


def _array(name: str, tensor: Mapping[str, object]) -> NDArray[np.generic]:
    kind = TYPES.get(str(tensor["dtype"]))
    if kind is None:
        raise HistoryFileError(
            f"array {name!r} has the type {tensor['dtype']}",
            where={"field": name},
            remedy=f"one of {', '.join(TYPES)}",
        )
    shape = cast("list[int]", tensor["shape"])
    array: NDArray[np.generic] = np.frombuffer(cast("bytes", tensor["data"]), kind)
    return array.reshape(shape)


def _taken(
    arrays: dict[str, NDArray[np.generic]], name: str, kind: str, shape: tuple[int | None, ...]
) -> NDArray[np.generic]:
    """Return an array of a name if it has the type and shape (None: any length)."""
    array = arrays.get(name)
    if (
        array is None
        or array.dtype != TYPES[kind]
        or array.ndim != len(shape)
        or any(
            want is not None and have != want for have, want in zip(array.shape, shape, strict=True)
        )
    ):
        found = "missing" if array is None else f"{array.dtype} of the shape {array.shape}"
        raise HistoryFileError(
            f"array {name!r} is {found}",
            where={"field": name},
            remedy=f"{kind} of the shape {shape}",
        )
    return array


def _assembled(arrays: dict[str, NDArray[np.generic]], vertices: int) -> Splits:
    """Join the groups to whole columns, after checking the shape of each of their arrays."""
    centre = _taken(arrays, "centre", "F64", (3,))
    base_positions = _taken(arrays, "base.positions", "F32", (4, 3))
    base_faces = _taken(arrays, "base.faces", "I32", (4, 3))
    columns: dict[str, list[NDArray[np.generic]]] = {name: [] for name in (*COLUMNS, "moved")}
    moved_total = 0
    for number, (start, end) in enumerate(_groups(vertices)):
        prefix = f"splits.{number:02d}."
        for name, (kind, shape) in COLUMNS.items():
            columns[name].append(_taken(arrays, prefix + name, kind, (end - start, *shape)))
        ends = columns["moved_end"][-1].astype(np.int64)
        moved = _taken(arrays, prefix + "moved", "I32", (None,))
        if ends[0] < 0 or (np.diff(ends) < 0).any() or ends[-1] != len(moved):
            raise HistoryFileError(
                f"array {prefix}moved_end does not divide the {len(moved)} moved corners",
                where={"field": f"{prefix}moved_end"},
                remedy="ascending numbers that end with the number of moved corners",
            )
        columns["moved_end"][-1] = (ends + moved_total).astype(np.int32)
        columns["moved"].append(moved)
        moved_total += len(moved)
    empty = {"parent": (0,), "moved_end": (0,), "moved": (0,), "faces": (0, 2, 3)}
    joined = {
        name: np.concatenate(parts)
        if parts
        else np.empty(empty.get(name, (0, 3)), TYPES[COLUMNS.get(name, ("I32",))[0]])
        for name, parts in columns.items()
    }
    splits = Splits(base_positions, base_faces, **joined)  # type: ignore[arg-type]
    positions = (centre, base_positions, splits.coarse, splits.fine, splits.added)
    if not all(np.isfinite(array).all() for array in positions):
        raise HistoryFileError(
            "a position is not a finite number",
            where={"field": "positions"},
            remedy="finite numbers",
        )
    return splits


def _check_replay(splits: Splits) -> None:
    """Refuse splits that do not fit the level they are applied to."""
    corners = np.empty(6 * splits.vertices - 12, np.int32)
    if splits.base_faces.min() < 0 or splits.base_faces.max() > 3:
        raise HistoryFileError(
            "the coarsest level's faces name vertices that it does not have",
            where={"field": "base.faces"},
            remedy="numbers from 0 to 3",
        )
    faulty = _first_faulty_slot(
        corners, splits.base_faces, splits.parent, splits.faces, splits.moved_end, splits.moved
    )
    if faulty >= 0:
        raise HistoryFileError(
            f"the split that adds slot {faulty} does not fit the level before it",
            where={"slot": int(faulty)},
            remedy="a parent, moved corners and two new faces of that level",
        )
    for faces, count in ((splits.base_faces, 4), (corners.reshape(-1, 3), splits.vertices)):
        if (opposite_corners(np.ascontiguousarray(faces), count) < 0).any():
            raise HistoryFileError(
                f"the level with {len(faces)} triangles is not closed",
                where={"triangles": len(faces)},
                remedy="the file as it was delivered, unchanged",
            )


@kernel
def _first_faulty_slot(
    corners: IndexArray,
    base_faces: IndexArray,
    parent: IndexArray,
    faces: IndexArray,
    moved_end: IndexArray,
    moved: IndexArray,
) -> int:
    """Replay all splits into `corners`; the first slot whose split does not fit, −1 if all do."""
    for corner in range(12):
        corners[corner] = base_faces[corner // 3, corner % 3]
    for split in range(len(parent)):
        slot = split + 4
        above, known = parent[split], 3 * (2 * slot - 4)
        if above < 0 or above >= slot:
            return slot
        for index in range(moved_end[split - 1] if split > 0 else 0, moved_end[split]):
            corner = moved[index]
            if corner < 0 or corner >= known or corners[corner] != above:
                return slot
            corners[corner] = slot
        for side in range(2):
            own, others = 0, 0
            for place in range(3):
                named = faces[split, side, place]
                if named < 0 or named > slot:
                    return slot
                if named == above or named == slot:  # noqa: SIM109
                    own += 1
                else:
                    others += 1
                corners[known + 3 * side + place] = named
            first, second, third = (
                faces[split, side, 0],
                faces[split, side, 1],
                faces[split, side, 2],
            )
            if own != 2 or others != 1 or first == second or second == third or third == first:
                return slot
    return -1
