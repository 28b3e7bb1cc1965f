"""The history file: self-describing, pickle-free, compact, coarse levels first.

A history file is a safetensors file (an 8-byte length, a JSON header that names type, shape and
place of every array, then the arrays' raw little-endian bytes), so any safetensors library opens
it; the full description is in ``docs/history-format.md``. The splits are stored in groups that
double the number of vertices, each one stream of bits, one group after the other: any prefix that
ends with a group is a complete history of the coarser levels. Device values, where there are any,
come last, divided in the same way. Reading never trusts the file: what is outside of the streams is
checked at once, and a stream when a level that needs it is first asked for. Its splits are replayed
on the way, so that every level that is returned is closed and star-shaped about its centre.
"""

from __future__ import annotations

import json
import math
import struct
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from safetensors import SafetensorError, deserialize

from gamutcore.arrays import ByteArray
from gamutcore.corner_table import opposite_corners
from gamutcore.errors import HistoryFileError, NeighbourLimitError
from gamutcore.history.bit_codes import written
from gamutcore.history.device_history import (
    PackedDeviceValues,
    device_history_in,
    device_section,
    packed_device_values,
)
from gamutcore.history.groups import DAMAGED, DEVICE, group_name, groups_of
from gamutcore.history.history import History
from gamutcore.history.packed_splits import PackedSplits
from gamutcore.history.prefix_order import Splits
from gamutcore.history.rings import MOST_VISITED, VISITED, VISITED_PER_VERTEX, Replay, replay_of
from gamutcore.history.split_codes import LARGEST_COORDINATE, MINIMUM_SPLIT_BITS, first_contexts
from gamutcore.history.split_reader import MOVED_PER_VERTEX
from gamutcore.history.split_writer import write_group

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from gamutcore.arrays import FloatArray, IndexArray

    Tensor = Mapping[str, Any]
    """An array as safetensors has it: ``dtype`` and ``shape`` as in the header, and ``data``."""

__all__ = ["FORMAT", "VERSION", "history_bytes", "history_from_bytes", "history_metadata"]

FORMAT = "gamut-history"
"""Value of ``format`` in the metadata of every history file."""

VERSION = "2"
"""Value of ``version``; raised when a reader of this version could not read the file any more."""

LARGEST_HEADER = 16 * 1024 * 1024
"""Headers longer than this are refused before they are parsed (bytes)."""

LARGEST_VERTICES = 2**25
"""Corner numbers, below 6 V, and the count of moved corners, at most 64 V, must stay within
int32."""

SMALLEST_STEP, LARGEST_STEP = 2.0**-149, 2.0**103
"""Between these, whole numbers of steps up to 2²⁴ are exact in float32."""

TYPES: dict[str, np.dtype[Any]] = {
    "F64": np.dtype("<f8"),
    "I32": np.dtype("<i4"),
    "U8": np.dtype("u1"),
}


def history_bytes(history: History, metadata: Mapping[str, str] | None = None) -> bytes:
    """Write a history to bytes.

    Parameters
    ----------
    history : History
    metadata : mapping of str to str, optional
        Kept in the header beside the format's own ``format``, ``version``, ``vertices`` and
        ``device``.

    Returns
    -------
    bytes

    Raises
    ------
    HistoryFileError
        If positions are not on the history's grid, or its splits not in the canonical order that
        `build_history` gives them.
    NeighbourLimitError
        If readers would refuse the file, since reading it could take minutes.
    """
    splits = _in_steps(history.splits, history.step)
    arrays: list[tuple[str, NDArray[np.generic]]] = [
        ("centre", np.asarray(history.centre, "<f8")),
        ("step", np.array([history.step], "<f8")),
        ("base.positions", np.asarray(splits.base_positions, "<i4")),
        ("base.faces", np.asarray(splits.base_faces, "<i4")),
    ]
    base_in_steps = cast("IndexArray", splits.base_positions)
    replay = replay_of(base_in_steps, splits.base_faces, splits.vertices)
    contexts = first_contexts()
    for number, (start, end) in enumerate(groups_of(splits.vertices)):
        writer, faulty, replay = write_group(contexts, replay, splits, start, end)
        if faulty:
            raise HistoryFileError(
                f"the split that adds slot {faulty} does not fit the level before it",
                where={"slot": int(faulty)},
                remedy="splits in the order that build_history gives them",
            )
        _refuse_long_rings(replay, splits, end)
        arrays.append((group_name(number), written(writer)))
    names = {kind: name for name, kind in TYPES.items()}
    described = {
        **(metadata or {}),
        "format": FORMAT,
        "version": VERSION,
        "vertices": str(splits.vertices),
    }
    described.pop(DEVICE, None)
    if history.device is not None:
        packed = packed_device_values(history.device, history.splits, history.step)
        channels, steps, corrected = packed.section
        section = {"channels": channels, "steps": steps, "corrected": corrected}
        described[DEVICE] = json.dumps(section, separators=(",", ":"))
        arrays.append(("device.base", packed.base))
        arrays += [(group_name(i, DEVICE), stream) for i, stream in enumerate(packed.streams)]
    header: dict[str, object] = {"__metadata__": described}
    offset = 0
    for name, array in arrays:
        header[name] = {
            "dtype": names[array.dtype],
            "shape": list(array.shape),
            "data_offsets": [offset, offset + array.nbytes],
        }
        offset += array.nbytes
    return _assembled(header, b"".join(array.tobytes() for _, array in arrays))


def history_from_bytes(data: bytes, *, partial: bool = False) -> tuple[History, dict[str, str]]:
    """Read a history, whose levels are unpacked and checked as far as they are asked for.

    Parameters
    ----------
    data : bytes
        A whole history file.
    partial : bool, optional
        Whether the file may be cut off anywhere behind its coarsest level. The levels are then
        those whose groups are there as a whole; device values are there if all of theirs are.

    Returns
    -------
    history : History
    metadata : dict of str to str

    Raises
    ------
    HistoryFileError
        If anything in the file is not as it should be; says what and where. Damage within a stream
        is noticed when a level that needs it is first asked for; `History.unpack` asks for all.
    """
    metadata = _parsed_metadata(data)
    vertices = _vertex_count(metadata)
    if partial:
        data, groups = _without_cut_arrays(data)
        vertices = min(vertices, 4 * 2**groups)
    try:
        # of any type: those that this format does not name are not looked at
        arrays = dict(deserialize(data))
    except SafetensorError as cause:
        raise HistoryFileError(
            f"the history file is damaged: {cause}", where={"byte": 8}, remedy=DAMAGED
        ) from cause
    device = _packed_device_values(arrays, metadata, vertices, partial=partial)
    return _history(arrays, vertices, device), metadata


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


def _refuse_long_rings(replay: Replay, splits: Splits, end: int) -> None:
    """Check what readers count at the end of a group, so that none refuses what was written."""
    visited, moved = int(replay.used[VISITED]), int(splits.moved_end[end - 5])
    if visited > MOST_VISITED + VISITED_PER_VERTEX * end or moved > MOVED_PER_VERTEX * end:
        most = int(replay.span[:end, 1].max())
        raise NeighbourLimitError(
            f"Up to {most} triangles meet at a vertex, and levels would take too long to read.",
            where={"neighbours": most},
            remedy="Divide the surface so that fewer triangles meet at a vertex.",
        )


def _in_steps(splits: Splits, step: float) -> Splits:
    """Return the splits with positions as int32 in steps."""
    whole: dict[str, Any] = {}
    for name, array in splits._asdict().items():
        if array.dtype != np.float32:
            continue
        steps = np.rint(array.astype(np.float64) / step)
        if not (np.abs(steps) <= LARGEST_COORDINATE).all() or (steps * step != array).any():
            raise HistoryFileError(
                f"positions in {name!r} are not on the grid of the step {step!r}",
                where={"field": name},
                remedy=f"multiples of the step, at most {LARGEST_COORDINATE} times it",
            )
        whole[name] = steps.astype(np.int32)
    return splits._replace(**whole)


def _assembled(header: Mapping[str, object], body: bytes) -> bytes:
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 8)
    return b"".join([struct.pack("<Q", len(text)), text, body])


def _without_cut_arrays(data: bytes) -> tuple[bytes, int]:
    """Return a file with the arrays that are there as a whole, and how many groups are."""
    size = 8 + struct.unpack("<Q", data[:8])[0]
    header = json.loads(data[8:size])
    # those of other names as well: what lies between two arrays must not be missing
    names = [name for name in header if name != "__metadata__"]
    try:
        ends = {name: int(header[name]["data_offsets"][1]) for name in names}
    except (KeyError, TypeError, ValueError, IndexError, OverflowError) as cause:
        raise HistoryFileError(
            "the header does not say where the arrays are", where={"byte": 8}, remedy=DAMAGED
        ) from cause
    whole = {name: header[name] for name, end in ends.items() if end <= len(data) - size}
    groups = 0
    while group_name(groups) in whole:
        groups += 1
    body = data[size : size + max((ends[name] for name in whole), default=0)]
    return _assembled(whole, body), groups


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


def _taken(
    arrays: Mapping[str, Tensor], name: str, kind: str, shape: tuple[int | None, ...]
) -> NDArray[np.generic]:
    """Return an array of a name if it has the type and shape (None: any length)."""
    tensor = arrays.get(name)
    have = () if tensor is None else tuple(tensor["shape"])
    if (
        tensor is None
        or tensor["dtype"] != kind
        or len(have) != len(shape)
        or any(want not in (None, found) for found, want in zip(have, shape, strict=True))
    ):
        found = "missing" if tensor is None else f"{tensor['dtype']} of the shape {have}"
        raise HistoryFileError(
            f"array {name!r} is {found}",
            where={"field": name},
            remedy=f"{kind} of the shape {shape}",
        )
    array: NDArray[np.generic] = np.frombuffer(tensor["data"], TYPES[kind])
    return array.reshape(have)


def _packed_device_values(
    arrays: Mapping[str, Tensor],
    metadata: Mapping[str, str],
    vertices: int,
    *,
    partial: bool,
) -> PackedDeviceValues | None:
    """Return the section of device values, if there is one; the streams are not read yet."""
    if DEVICE not in metadata:
        return None
    section = device_section(metadata[DEVICE])
    channels, scale, _ = section
    groups = groups_of(vertices)
    wanted = ["device.base", *(group_name(number, DEVICE) for number in range(len(groups)))]
    if partial and any(name not in arrays for name in wanted):
        return None
    base = _taken(arrays, "device.base", "I32", (4, len(channels))).astype(np.int32)
    if base.min() < 0 or base.max() > scale:
        raise HistoryFileError(
            "the coarsest level has device values beyond full scale",
            where={"field": "device.base"},
            remedy=f"numbers from 0 to {scale}",
        )
    streams = []
    for name, (start, end) in zip(wanted[1:], groups, strict=True):
        stream = cast("ByteArray", _taken(arrays, name, "U8", (None,)))
        if 8 * stream.size < len(channels) * (end - start):
            raise HistoryFileError(
                f"{stream.size} bytes are too few for {end - start} device values of each channel",
                where={"field": name},
                remedy=DAMAGED,
            )
        streams.append(stream)
    return PackedDeviceValues(section, base, streams)


def _history(
    arrays: Mapping[str, Tensor], vertices: int, device: PackedDeviceValues | None
) -> History:
    """Check the arrays but for what is in the streams, which must be long enough for their splits.

    So nothing is allocated that the file does not fill.
    """
    centre = cast("FloatArray", _taken(arrays, "centre", "F64", (3,))).astype(np.float64)
    step = float(cast("FloatArray", _taken(arrays, "step", "F64", (1,)))[0])
    if not np.isfinite(centre).all():
        raise HistoryFileError(
            "the centre is not finite", where={"field": "centre"}, remedy="finite numbers"
        )
    if not (SMALLEST_STEP <= step <= LARGEST_STEP and math.frexp(step)[0] == 0.5):
        raise HistoryFileError(
            f"the step of the grid is {step!r}",
            where={"field": "step"},
            remedy="a power of two from 2^-149 to 2^103",
        )
    groups = groups_of(vertices)
    streams = []
    for number, (start, end) in enumerate(groups):
        name = group_name(number)
        stream = cast("ByteArray", _taken(arrays, name, "U8", (None,)))
        if 8 * stream.size < 1 + MINIMUM_SPLIT_BITS * (end - start):
            raise HistoryFileError(
                f"{stream.size} bytes are too few for the splits that add slots {start} to"
                f" {end - 1}",
                where={"field": name},
                remedy=DAMAGED,
            )
        streams.append(stream)
    positions, faces = _base(arrays, centre, step)
    splits = PackedSplits(streams, positions, faces, vertices, centre, step)
    values = None if device is None else device_history_in(device, vertices, step)
    return History(splits, centre, step, values)


def _base(
    arrays: Mapping[str, Tensor], centre: FloatArray, step: float
) -> tuple[IndexArray, IndexArray]:
    """Return the coarsest level, in steps, if it is a tetrahedron around the centre."""
    positions = _taken(arrays, "base.positions", "I32", (4, 3)).astype(np.int32)
    faces = _taken(arrays, "base.faces", "I32", (4, 3)).astype(np.int32)
    if (np.abs(positions.astype(np.int64)) > LARGEST_COORDINATE).any():
        raise HistoryFileError(
            "the coarsest level has coordinates beyond 2^24 steps",
            where={"field": "base.positions"},
            remedy=f"numbers from {-LARGEST_COORDINATE} to {LARGEST_COORDINATE}",
        )
    if (
        faces.min() < 0
        or faces.max() > 3
        or any(len(set(face)) != 3 for face in faces.tolist())
        or (opposite_corners(faces, 4) < 0).any()
    ):
        raise HistoryFileError(
            "the coarsest level is not closed",
            where={"field": "base.faces"},
            remedy="the four faces of a tetrahedron, counter-clockwise from outside",
        )
    one, two, three = np.moveaxis((positions * step - centre)[faces], 1, 0)
    if not ((one * np.cross(two, three)).sum(axis=1) > 0).all():
        raise HistoryFileError(
            "a face of the coarsest level does not see the centre from inside",
            where={"field": "base.positions"},
            remedy=DAMAGED,
        )
    return positions, faces
