"""Fixtures of the tests of histories."""

from __future__ import annotations

import json
import struct
import zlib
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from gamutcore.geometry import TriangleMesh
from gamutcore.history import History, history_bytes

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any


@pytest.fixture(scope="session")
def note() -> dict[str, str]:
    """Return a description of the caller with characters beyond ASCII."""
    return {"note": "größer\nals 🎨"}


@pytest.fixture(scope="session")
def file(small_history: History, note: dict[str, str]) -> bytes:
    """Return the bytes of a small history."""
    return history_bytes(small_history, note)


@pytest.fixture(scope="session")
def shifting_history(small_history: History) -> History:
    """Return a history whose splits also move neighbours, by a few steps of the grid."""
    random = np.random.default_rng(5)
    splits, step = small_history.splits, small_history.step
    position = np.zeros((splits.vertices, 3), np.float32)
    position[:4] = splits.base_positions
    coarse = np.empty_like(splits.coarse)
    ends, shifted, before, after = [], [], [], []
    for split, parent in enumerate(splits.parent.tolist()):
        coarse[split] = position[parent]
        position[parent], position[split + 4] = splits.fine[split], splits.added[split]
        level = small_history.level(2 * split + 4).faces
        ring = np.unique(level[(level == parent).any(axis=1)])
        for neighbour in ring[ring != parent].tolist():
            if split % 3 and random.random() < 0.4:
                shifted.append(neighbour)
                before.append(position[neighbour].copy())
                position[neighbour] += np.float32(step) * random.integers(-9, 10, 3)
                after.append(position[neighbour].copy())
        ends.append(len(shifted))
    return History(
        splits._replace(
            coarse=coarse,
            shifted_end=np.array(ends, np.int32),
            shifted=np.array(shifted, np.int32),
            shifted_coarse=np.array(before, np.float32),
            shifted_fine=np.array(after, np.float32),
        ),
        small_history.centre,
        step,
    )


@pytest.fixture(scope="session")
def first_levels() -> Callable[[History, int], History]:
    """Return a function that cuts a history off after a number of vertices."""

    def beginning(history: History, vertices: int) -> History:
        splits, steps = history.splits, vertices - 4
        columns = {
            name: array[:steps]
            for name, array in splits._asdict().items()
            if not name.startswith(("base", "moved", "shifted"))
        }
        for end, names in (
            ("moved_end", ["moved"]),
            ("shifted_end", ["shifted", "shifted_coarse", "shifted_fine"]),
        ):
            columns[end] = getattr(splits, end)[:steps]
            length = int(columns[end][-1]) if steps else 0
            columns |= {name: getattr(splits, name)[:length] for name in names}
        return History(splits._replace(**columns), history.centre, history.step)

    return beginning


@pytest.fixture(scope="session")
def double_pyramid() -> Callable[[int], TriangleMesh]:
    """Return a function that makes a double pyramid with a given number of vertices on its rim."""

    def body(rim: int) -> TriangleMesh:
        turn = 2 * np.pi * np.arange(rim) / rim
        around = np.stack([50 * np.cos(turn), 50 * np.sin(turn), np.zeros(rim)], axis=1)
        one, other = np.arange(rim), (np.arange(rim) + 1) % rim
        above = np.stack([one, other, np.full(rim, rim)], axis=1)
        below = np.stack([other, one, np.full(rim, rim + 1)], axis=1)
        return TriangleMesh(
            np.vstack([around, (0, 0, 50), (0, 0, -50)]),
            np.vstack([above, below]).astype(np.int32),
        )

    return body


def _parts(data: bytes) -> tuple[dict[str, Any], list[bytes]]:
    """Return the header and the bytes of each group of a file; sections are left out."""
    size, _ = struct.unpack("<II", data[:8])
    header, begin, groups = json.loads(data[8 : 8 + size]), 8 + size, []
    for group in header["groups"]:
        groups.append(data[begin : begin + group["bytes"]])
        begin += group["bytes"]
    return header, groups


def _assembled(header: dict[str, Any], groups: list[bytes]) -> bytes:
    """Return the file of a header and groups."""
    text = json.dumps(header).encode()
    return struct.pack("<II", len(text), zlib.crc32(text)) + text + b"".join(groups)


def _with_header(data: bytes, **changes: object) -> bytes:
    """Return a file with other values in its header, whose checksum is right; None removes one."""
    header, groups = _parts(data)
    header |= changes
    return _assembled({key: value for key, value in header.items() if value is not None}, groups)


def _column_layout(header: dict[str, Any], number: int) -> list[tuple[str, str, int, int]]:
    group = header["groups"][number]
    splits = group["vertices"] - 4 * 2**number
    rows = {"splits": splits, "moved": group["moved"], "shifted": group["shifted"]}
    return [(c["name"], "<" + c["dtype"], c["width"], rows[c["rows"]]) for c in header["columns"]]


def _columns(data: bytes, number: int) -> dict[str, np.ndarray]:
    """Return the columns of a group by name, (rows, width)."""
    header, groups = _parts(data)
    content, begin, arrays = zlib.decompress(groups[number]), 0, {}
    for name, dtype, width, rows in _column_layout(header, number):
        size = rows * width * np.dtype(dtype).itemsize
        planes = np.frombuffer(content[begin : begin + size], np.uint8)
        planes = planes.reshape(width * np.dtype(dtype).itemsize, rows)
        arrays[name] = planes.T.copy().view(dtype).reshape(rows, width)
        begin += size
    return arrays


def _with_columns(data: bytes, number: int, arrays: dict[str, np.ndarray]) -> bytes:
    """Return a file with other columns in a group; lengths and checksums are right."""
    header, groups = _parts(data)
    group = header["groups"][number]
    group["moved"], group["shifted"] = len(arrays["moved"]), len(arrays["shifted"])
    content = b"".join(
        np.ascontiguousarray(arrays[name], dtype).view(np.uint8).reshape(rows, -1).T.tobytes()
        for name, dtype, _, rows in _column_layout(header, number)
        if rows
    )
    return _with_group(_assembled(header, groups), number, zlib.compress(content))


def _with_group(data: bytes, number: int, content: bytes) -> bytes:
    """Return a file with other bytes in a group; lengths and checksums are right."""
    header, groups = _parts(data)
    groups[number] = content
    header["groups"][number] |= {"bytes": len(content), "crc32": zlib.crc32(content)}
    return _assembled(header, groups)


def _group_end(data: bytes, number: int) -> int:
    """Return where a group ends in the file."""
    _, groups = _parts(data)
    return 8 + struct.unpack("<I", data[:4])[0] + sum(map(len, groups[: number + 1]))


@pytest.fixture(scope="session")
def layout() -> SimpleNamespace:
    """Return functions that take a history file apart and put it together, checksums and all.

    They were written from docs/history-format.md.
    """
    return SimpleNamespace(
        parts=_parts,
        with_header=_with_header,
        columns=_columns,
        with_columns=_with_columns,
        with_group=_with_group,
        group_end=_group_end,
    )
