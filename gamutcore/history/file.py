"""The history file: self-describing, free of pickles, compact, coarse levels first.

A history file is a safetensors file: an 8-byte length, a JSON header with the type, shape and
offset of every array, then the little-endian bytes of the arrays. ``docs/history-format.md`` is the
full specification. The splits are stored in groups that double the number of vertices, one stream
of bits each. A prefix of the file that ends with a group is a complete history of the coarser
levels. Device values are optional and come last, in the same groups.

Reading never trusts the file. Everything outside the streams is checked at once. A stream is
checked when a level first needs it, by replaying its splits.
"""

from __future__ import annotations

import json
import math
import struct
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from safetensors import SafetensorError, deserialize

from gamutcore.errors import HistoryFileError
from gamutcore.geometry import opposite_corners
from gamutcore.history.bit_codes import DAMAGE_REMEDY, DEVICE, SPLITS, stream_name
from gamutcore.history.device import (
    DeviceHistory,
    device_streams,
    open_device_history,
    parse_device_section,
)
from gamutcore.history.history import History
from gamutcore.history.split_codec import (
    LARGEST_COORDINATE,
    MINIMUM_SPLIT_BITS,
    PackedSplits,
    split_streams,
    splits_in_steps,
)
from gamutcore.history.splits import group_count, group_ranges

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from gamutcore.arrays import ByteArray, FloatArray, IndexArray

    Tensor = Mapping[str, Any]
    """An array as safetensors has it: ``dtype`` and ``shape`` as in the header, and ``data``."""

__all__ = ["FORMAT", "VERSION", "history_bytes", "history_from_bytes", "history_metadata"]

FORMAT = "gamut-history"
"""Value of ``format`` in the metadata of every history file."""

VERSION = "2"
"""Value of ``version``; changes when readers of this version could not read the file."""

LARGEST_HEADER = 16 * 1024 * 1024
"""In bytes; longer headers are refused before they are parsed."""

LARGEST_VERTICES = 2**25
"""Corner numbers, below 6 V, and the number of moved corners, at most 24 V, must fit into int32."""

SMALLEST_STEP, LARGEST_STEP = 2.0**-149, 2.0**103
"""Between these, integers up to 2²⁴ times the step are exact in float32."""

TYPES: dict[str, np.dtype[Any]] = {
    "F64": np.dtype("<f8"),
    "I32": np.dtype("<i4"),
    "U8": np.dtype("u1"),
}


def history_bytes(
    history: History,
    metadata: Mapping[str, str] | None = None,
    sections: Mapping[str, bytes] | None = None,
) -> bytes:
    """Write a history to bytes.

    Parameters
    ----------
    history : History
    metadata : mapping of str to str, optional
        Texts for the header, beside ``format``, ``version``, ``vertices`` and ``device`` of the
        format itself.
    sections : mapping of str to bytes, optional
        Further content by the name of its array, at the end of the file. Readers ignore it.

    Returns
    -------
    bytes

    Raises
    ------
    HistoryFileError
        If positions are not on the grid, or the splits are not in the canonical order of
        `build_history`.
    NeighbourLimitError
        If readers would refuse the file because reading it could take minutes.
    """
    splits = splits_in_steps(history.splits, history.step)
    arrays: list[tuple[str, NDArray[np.generic]]] = [
        ("centre", np.asarray(history.centre, "<f8")),
        ("step", np.array([history.step], "<f8")),
        ("base.positions", np.asarray(splits.base_positions, "<i4")),
        ("base.faces", np.asarray(splits.base_faces, "<i4")),
        *_named_streams(SPLITS, split_streams(splits)),
    ]
    described = {**(metadata or {}), "format": FORMAT, "version": VERSION}
    described["vertices"] = str(splits.vertices)
    described.pop(DEVICE, None)
    if history.device is not None:
        described[DEVICE] = history.device.section.to_json()
        arrays.append(("device.base", history.device.base.astype("<i4")))
        streams = device_streams(history.device, history.splits, history.step)
        arrays += _named_streams(DEVICE, streams)
    for name, content in (sections or {}).items():
        arrays.append((name, np.frombuffer(content, np.uint8)))
    names = {kind: name for name, kind in TYPES.items()}
    header: dict[str, object] = {"__metadata__": described}
    offset = 0
    for name, array in arrays:
        header[name] = {
            "dtype": names[array.dtype],
            "shape": list(array.shape),
            "data_offsets": [offset, offset + array.nbytes],
        }
        offset += array.nbytes
    return _assemble(header, b"".join(array.tobytes() for _, array in arrays))


def history_from_bytes(data: bytes, *, partial: bool = False) -> tuple[History, dict[str, str]]:
    """Read a history. Levels are unpacked and checked when they are first asked for.

    Parameters
    ----------
    data : bytes
        A whole history file.
    partial : bool, optional
        Whether the file may be cut off anywhere behind the coarsest level. The history then has
        the levels whose groups are complete. It has device values if all of theirs are there.

    Returns
    -------
    history : History
    metadata : dict of str to str

    Raises
    ------
    HistoryFileError
        If the file is damaged. Damage in a stream is found when a level first needs the stream;
        `History.unpack` checks all streams.
    """
    metadata = _parse_metadata(data)
    vertices = _vertex_count(metadata)
    if partial:
        data, groups = _without_cut_arrays(data)
        vertices = min(vertices, 4 * 2**groups)
    try:
        # arrays of other names may have any type; they are ignored
        arrays = dict(deserialize(data))
    except SafetensorError as cause:
        raise HistoryFileError(
            f"the history file is damaged: {cause}", where={"byte": 8}, remedy=DAMAGE_REMEDY
        ) from cause
    centre = cast("FloatArray", _array(arrays, "centre", "F64", (3,))).astype(np.float64)
    step = float(cast("FloatArray", _array(arrays, "step", "F64", (1,)))[0])
    if not np.isfinite(centre).all():
        raise _field_error("centre", "the centre is not finite", "finite numbers")
    if not (SMALLEST_STEP <= step <= LARGEST_STEP and math.frexp(step)[0] == 0.5):
        message = f"the step of the grid is {step!r}"
        raise _field_error("step", message, "a power of two from 2^-149 to 2^103")
    positions, faces = _base(arrays, centre, step)
    streams = _streams(arrays, SPLITS, vertices, MINIMUM_SPLIT_BITS, 1)
    splits = PackedSplits(streams, positions, faces, vertices, centre, step)
    device = _device(arrays, metadata, vertices, step, partial=partial)
    return History(splits, centre, step, device), metadata


def history_section(data: bytes, name: str) -> bytes | None:
    """Return the content of an array that `history_bytes` wrote for a section; None without it."""
    size = 8 + struct.unpack("<Q", data[:8])[0]
    entry = json.loads(data[8:size]).get(name)
    if entry is None:
        return None
    start, end = entry["data_offsets"]
    return data[size + start : size + end]


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
        If the file cannot be read.
    """
    with path.open("rb") as file:
        length = file.read(8)
        size = struct.unpack("<Q", length)[0] if len(length) == 8 else 0
        return _parse_metadata(length + file.read(min(size, LARGEST_HEADER)))


def _field_error(field: str, message: str, remedy: str = DAMAGE_REMEDY) -> HistoryFileError:
    return HistoryFileError(message, where={"field": field}, remedy=remedy)


def _named_streams(kind: str, streams: Iterable[ByteArray]) -> list[tuple[str, ByteArray]]:
    return [(stream_name(number, kind), stream) for number, stream in enumerate(streams)]


def _assemble(header: Mapping[str, object], body: bytes) -> bytes:
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 8)
    return b"".join([struct.pack("<Q", len(text)), text, body])


def _without_cut_arrays(data: bytes) -> tuple[bytes, int]:
    """Return a file with the complete arrays only, and the number of complete groups."""
    size = 8 + struct.unpack("<Q", data[:8])[0]
    header = json.loads(data[8:size])
    # unknown arrays are kept: safetensors refuses gaps between arrays
    names = [name for name in header if name != "__metadata__"]
    try:
        ends = {name: int(header[name]["data_offsets"][1]) for name in names}
    except (KeyError, TypeError, ValueError, IndexError, OverflowError) as cause:
        raise HistoryFileError(
            "the header does not say where the arrays are", where={"byte": 8}, remedy=DAMAGE_REMEDY
        ) from cause
    complete = {name: header[name] for name, end in ends.items() if end <= len(data) - size}
    groups = 0
    while stream_name(groups) in complete:
        groups += 1
    body = data[size : size + max((ends[name] for name in complete), default=0)]
    return _assemble(complete, body), groups


def _parse_metadata(data: bytes) -> dict[str, str]:
    remedy = "Give a file as delivered under /history."
    size = struct.unpack("<Q", data[:8])[0] if len(data) >= 8 else 0
    if not 2 <= size <= LARGEST_HEADER or len(data) < 8 + size:
        raise HistoryFileError(
            "this is not a history file: it does not begin with the length of a header",
            where={"byte": 0},
            remedy=remedy,
        )
    try:
        header = json.loads(data[8 : 8 + size])
        metadata = header["__metadata__"]
        kind, version = metadata["format"], metadata["version"]
    except (ValueError, KeyError, TypeError, RecursionError) as cause:
        raise HistoryFileError(
            "this is not a history file: its header is not the JSON of one",
            where={"byte": 8},
            remedy=remedy,
        ) from cause
    if kind != FORMAT or not all(isinstance(value, str) for value in metadata.values()):
        raise _field_error("format", f"the file is of the format {kind!r}", FORMAT)
    if version != VERSION:
        message = f"the history has the version {version!r}; this reader knows version {VERSION}"
        raise _field_error("version", message, "a reader as new as the file, or a new build")
    return dict(metadata)


def _vertex_count(metadata: Mapping[str, str]) -> int:
    text = metadata.get("vertices", "")
    count = int(text) if text.isascii() and text.isdecimal() and len(text) < 12 else 0
    if not 4 <= count <= LARGEST_VERTICES:
        message = f"the history says it has {text[:20]!r} vertices"
        raise _field_error("vertices", message, f"a number from 4 to {LARGEST_VERTICES}")
    return count


def _array(
    arrays: Mapping[str, Tensor], name: str, kind: str, shape: tuple[int | None, ...]
) -> NDArray[np.generic]:
    """Return an array with a given type and shape (None: any length)."""
    tensor = arrays.get(name)
    actual = () if tensor is None else tuple(tensor["shape"])
    if (
        tensor is None
        or tensor["dtype"] != kind
        or len(actual) != len(shape)
        or any(want not in (None, size) for size, want in zip(actual, shape, strict=True))
    ):
        what = "missing" if tensor is None else f"{tensor['dtype']} of the shape {actual}"
        raise _field_error(name, f"array {name!r} is {what}", f"{kind} of the shape {shape}")
    array: NDArray[np.generic] = np.frombuffer(tensor["data"], TYPES[kind])
    return array.reshape(actual)


def _streams(
    arrays: Mapping[str, Tensor], kind: str, vertices: int, split_bits: int, group_bits: int
) -> list[ByteArray]:
    """Return the streams of all groups, which must have a minimum of bits per split and group.

    The check keeps a short file from claiming memory for many splits.
    """
    streams = []
    for number, (start, end) in enumerate(group_ranges(vertices)):
        name = stream_name(number, kind)
        stream = cast("ByteArray", _array(arrays, name, "U8", (None,)))
        if 8 * stream.size < group_bits + split_bits * (end - start):
            raise _field_error(
                name,
                f"{stream.size} bytes are too few for the splits that add slots {start} to"
                f" {end - 1}",
            )
        streams.append(stream)
    return streams


def _device(
    arrays: Mapping[str, Tensor],
    metadata: Mapping[str, str],
    vertices: int,
    step: float,
    *,
    partial: bool,
) -> DeviceHistory | None:
    """Return the device values, if the file has them; no stream is unpacked."""
    if DEVICE not in metadata:
        return None
    section = parse_device_section(metadata[DEVICE])
    channels, scale, _ = section
    names = [stream_name(number, DEVICE) for number in range(group_count(vertices))]
    if partial and any(name not in arrays for name in ["device.base", *names]):
        return None
    base = _array(arrays, "device.base", "I32", (4, len(channels))).astype(np.int32)
    if base.min() < 0 or base.max() > scale:
        message = "the coarsest level has device values beyond full scale"
        raise _field_error("device.base", message, f"numbers from 0 to {scale}")
    streams = _streams(arrays, DEVICE, vertices, len(channels), 0)
    return open_device_history(section, base.astype(np.int16), streams, vertices, step)


def _base(
    arrays: Mapping[str, Tensor], centre: FloatArray, step: float
) -> tuple[IndexArray, IndexArray]:
    """Return the coarsest level in steps, which must be a tetrahedron around the centre."""
    positions = _array(arrays, "base.positions", "I32", (4, 3)).astype(np.int32)
    faces = _array(arrays, "base.faces", "I32", (4, 3)).astype(np.int32)
    if (np.abs(positions.astype(np.int64)) > LARGEST_COORDINATE).any():
        raise _field_error(
            "base.positions",
            "the coarsest level has coordinates beyond 2^24 steps",
            f"numbers from {-LARGEST_COORDINATE} to {LARGEST_COORDINATE}",
        )
    if (
        faces.min() < 0
        or faces.max() > 3
        or any(len(set(face)) != 3 for face in faces.tolist())
        or (opposite_corners(faces, 4) < 0).any()
    ):
        raise _field_error(
            "base.faces",
            "the coarsest level is not closed",
            "the four faces of a tetrahedron, counter-clockwise from outside",
        )
    one, two, three = np.moveaxis((positions * step - centre)[faces], 1, 0)
    if not ((one * np.cross(two, three)).sum(axis=1) > 0).all():
        message = "a face of the coarsest level does not see the centre from inside"
        raise _field_error("base.positions", message)
    return positions, faces
