"""The history file: self-describing, free of pickles, compact, coarse levels first.

A file begins with the length and the CRC-32 of a JSON header. The header describes the gamut, the
coarsest level and the columns, and has one line for each group of splits. The groups follow, each
deflated, with a CRC-32 in its line. A group doubles the number of vertices, so the file up to the
end of any group is a complete history of the coarser levels. Named sections come last.
``docs/history-format.md`` is the full specification.

Reading never trusts the file. The header is tested at once, and a group when a level first needs
it (`columns`).
"""

from __future__ import annotations

import json
import math
import operator
import struct
import zlib
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

import numpy as np

from gamutcore.errors import HistoryFileError, NeighbourLimitError
from gamutcore.history.columns import (
    CORNERS_PER_VERTEX,
    DAMAGE_REMEDY,
    LARGEST_COORDINATE,
    LARGEST_WORK,
    Group,
    StoredGroups,
    columns_of,
    group_name,
    pack_group,
    star_test_work,
)
from gamutcore.history.device import DeviceHistory, SplitValues, parse_device_section
from gamutcore.history.history import History
from gamutcore.history.splits import group_count, group_ranges, no_splits

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from gamutcore.arrays import FloatArray, IndexArray
    from gamutcore.history.splits import Splits

__all__ = [
    "FORMAT",
    "VERSION",
    "history_bytes",
    "history_description",
    "history_from_bytes",
    "history_prefix",
    "history_section",
]

FORMAT = "gamut-history"
"""Value of ``format`` in the header of every history file."""

VERSION = 3
"""Value of ``version``; changes when readers of this version could not read the file."""

LARGEST_HEADER = 16 * 1024 * 1024
"""In bytes; longer headers are refused before they are parsed."""

LARGEST_VERTICES = 2**25
"""Corner numbers, below 6 V, and the number of moved corners, at most 24 V, must fit into int32."""

SMALLEST_STEP, LARGEST_STEP = 2.0**-149, 2.0**103
"""Between these, integers up to 2²⁴ times the step are exact in float32."""

LARGEST_PART = 2**62
"""In bytes: no group or section of a file is larger."""

PREFIX = struct.Struct("<II")
"""The begin of a file: length and CRC-32 of the header."""


def history_bytes(
    history: History,
    description: Mapping[str, Any] | None = None,
    sections: Mapping[str, bytes] | None = None,
) -> bytes:
    """Write a history to bytes.

    Parameters
    ----------
    history : History
    description : mapping, optional
        Description of the gamut for the header, as JSON has it.
    sections : mapping of str to bytes, optional
        Further content by name, at the end of the file. Readers of levels ignore it.

    Returns
    -------
    bytes

    Raises
    ------
    HistoryFileError
        If positions are not on the grid.
    NeighbourLimitError
        If readers would refuse the file because reading it could take minutes.
    """
    splits = _splits_in_steps(history.splits, history.step)
    _refuse_much_work(splits)
    device = history.device
    values = () if device is None else device.splits
    groups, contents = [], []
    for number, (start, end) in enumerate(group_ranges(splits.vertices)):
        group, content = pack_group(splits, values, number, start, end)
        groups.append(group)
        contents.append(content)
    channels = 0 if device is None else len(device.section.channels)
    header: dict[str, object] = {
        "format": FORMAT,
        "version": VERSION,
        "vertices": splits.vertices,
        "centre": np.asarray(history.centre, np.float64).tolist(),
        "step": history.step,
        "base": {
            "positions": splits.base_positions.tolist(),
            "faces": splits.base_faces.tolist(),
        },
        "columns": [column._asdict() for column in columns_of(channels)],
        "groups": [dict(zip(LINE, group[2:], strict=True)) for group in groups],
    }
    if device is not None:
        header["device"] = {
            "channels": device.section.channels,
            "steps": device.section.scale,
            "base": device.base.tolist(),
        }
    if description is not None:
        header["gamut"] = description
    if sections:
        header["sections"] = [
            {"name": name, "bytes": len(content), "crc32": zlib.crc32(content)}
            for name, content in sections.items()
        ]
        contents += sections.values()
    text = json.dumps(header, separators=(",", ":"), allow_nan=False).encode()
    return b"".join([PREFIX.pack(len(text), zlib.crc32(text)), text, *contents])


def history_from_bytes(
    data: bytes, *, partial: bool = False
) -> tuple[History, dict[str, Any] | None]:
    """Read a history. Groups of splits are read and tested when a level first needs them.

    Parameters
    ----------
    data : bytes
        A whole history file.
    partial : bool, optional
        Whether the file may be cut off anywhere behind the header. The history then has the levels
        whose groups are complete.

    Returns
    -------
    history : History
    description : dict or None
        Description of the gamut; None if the file has none.

    Raises
    ------
    HistoryFileError
        If the file is damaged. Damage of a group is found when a level first needs the group;
        `History.unpack` tests all groups.
    """
    header, begin = _parse_header(data)
    vertices = _vertex_count(header)
    centre, step = _centre_and_step(header)
    positions, faces = _base(header, centre, step)
    section = None
    if "device" in header:
        section, base = parse_device_section(header["device"])
    channels = 0 if section is None else len(section.channels)
    if header.get("columns") != [column._asdict() for column in columns_of(channels)]:
        raise _field_error("columns", "the columns are not those of this version")
    groups = _groups(header, vertices)
    parts = [group.nbytes for group in groups] + [part.nbytes for part in _sections(header)]
    ends = np.add.accumulate([begin, *parts]) if parts else [begin]
    if partial:
        complete = sum(int(end) <= len(data) for end in ends[1 : len(groups) + 1])
        groups = groups[:complete]
        vertices = groups[-1].end if groups else 4
    elif ends[-1] != len(data):
        number = int(np.searchsorted(ends, len(data), "right")) - 1
        names = [group_name(group.number) for group in groups] + ["sections"]
        field = names[min(number, len(groups))]
        if len(data) < ends[-1]:
            raise _field_error(field, f"the file is cut off after {len(data)} of {ends[-1]} bytes")
        raise _field_error(field, f"the file has {len(data)} bytes, not {ends[-1]}")
    contents = [data[ends[group.number] : ends[group.number + 1]] for group in groups]
    device = None
    if section is not None:
        none = np.empty((5, 0, channels), np.int16)
        device = DeviceHistory(section, [base], SplitValues(*none))
    stored = StoredGroups(groups, contents, 0 if section is None else section.scale)
    splits = no_splits((positions * step).astype(np.float32), faces)
    history = History(splits, centre, step, device, stored, vertices)
    description = header.get("gamut")
    return history, description if isinstance(description, dict) else None


def history_section(data: bytes, name: str) -> bytes | None:
    """Return the content of a section that `history_bytes` wrote; None without it.

    Damage raises a `HistoryFileError`.
    """
    header, begin = _parse_header(data)
    start = begin + sum(group.nbytes for group in _groups(header, _vertex_count(header)))
    for section in _sections(header):
        if section.name == name:
            content = data[start : start + section.nbytes]
            if len(content) != section.nbytes or zlib.crc32(content) != section.crc32:
                message = f"section {name!r} does not have the CRC-32 that the header states"
                raise _field_error(name, message)
            return content
        start += section.nbytes
    return None


def history_description(path: Path) -> dict[str, Any] | None:
    """Read the description of a gamut from a history file without the groups.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict or None
        None if the file has no description.

    Raises
    ------
    HistoryFileError
        If the file does not begin like a history.
    OSError
        If the file cannot be read.
    """
    with path.open("rb") as file:
        header, _ = _parse_header(_header_bytes(file))
    description = header.get("gamut")
    return description if isinstance(description, dict) else None


def history_prefix(path: Path, triangles: Callable[[dict[str, Any] | None], int]) -> bytes:
    """Return the beginning of a history file, as `history_from_bytes` reads it with `partial`.

    It is the header and the groups of the level that `triangles` gives for the description of the
    gamut. The rest of the file is not read. Damage raises a `HistoryFileError`.
    """
    with path.open("rb") as file:
        head = _header_bytes(file)
        header, _ = _parse_header(head)
        description = header.get("gamut")
        count = triangles(description if isinstance(description, dict) else None)
        groups = _groups(header, _vertex_count(header))[: group_count(count // 2 + 2)]
        size = sum(group.nbytes for group in groups)
        content = file.read(size)
    if len(content) < size:
        message = f"the file is cut off after {len(head) + len(content)} bytes"
        raise _field_error("groups", message)
    return head + content


def _header_bytes(file: BinaryIO) -> bytes:
    begin = file.read(PREFIX.size)
    size = PREFIX.unpack(begin)[0] if len(begin) == PREFIX.size else 0
    return begin + file.read(min(size, LARGEST_HEADER))


LINE = ("vertices", "moved", "shifted", "bytes", "crc32")
"""Keys of the line of a group: the fields of `Group` from `end` on."""


class _Section(NamedTuple):
    name: str
    nbytes: int
    crc32: int


def _field_error(field: str, message: str, remedy: str = DAMAGE_REMEDY) -> HistoryFileError:
    return HistoryFileError(message, where={"field": field}, remedy=remedy)


def _parse_header(data: bytes) -> tuple[dict[str, Any], int]:
    """Return the header and where the groups begin."""
    remedy = "Give a file as delivered under /history."
    size, crc32 = PREFIX.unpack(data[: PREFIX.size]) if len(data) >= PREFIX.size else (0, 0)
    begin = PREFIX.size + size
    if PREFIX.size < len(data) < begin <= LARGEST_HEADER and data[PREFIX.size :].startswith(b'{"'):
        message = f"the file is cut off after {len(data)} bytes, within its header"
        raise HistoryFileError(message, where={"byte": 0}, remedy=DAMAGE_REMEDY)
    if not 2 <= size <= LARGEST_HEADER or len(data) < begin:
        raise HistoryFileError(
            "this is not a history file: it does not begin with the length of a header",
            where={"byte": 0},
            remedy=remedy,
        )
    text = data[PREFIX.size : begin]
    if text.startswith(b'{"__metadata__"'):
        message = f"the history has version 2; this reader knows version {VERSION}"
        raise _field_error("version", message, "Build the gamut again from its data.")
    if zlib.crc32(text) != crc32:
        raise HistoryFileError(
            "the header is damaged: its CRC-32 is not the one that is stated",
            where={"field": "header"},
            remedy=remedy,
        )
    try:
        header = json.loads(text)
        kind, version = header["format"], header["version"]
    except (ValueError, KeyError, TypeError, RecursionError) as cause:
        raise HistoryFileError(
            "this is not a history file: its header is not the JSON of one",
            where={"byte": PREFIX.size},
            remedy=remedy,
        ) from cause
    if kind != FORMAT:
        raise _field_error("format", f"the file is of the format {str(kind)[:40]!r}", FORMAT)
    if version != VERSION:
        message = f"the history has the version {version!r}; this reader knows version {VERSION}"
        raise _field_error("version", message, "a reader as new as the file, or a new build")
    return header, begin


def _vertex_count(header: Mapping[str, Any]) -> int:
    count = header.get("vertices")
    if type(count) is not int or not 4 <= count <= LARGEST_VERTICES:
        message = f"the history says it has {str(count)[:20]} vertices"
        raise _field_error("vertices", message, f"a number from 4 to {LARGEST_VERTICES}")
    return count


def _numbers(value: object, shape: tuple[int, ...], *, whole: bool) -> FloatArray | None:
    """Return numbers of a header in a given shape as float64; None if they are none."""
    try:
        array = np.array(value)
    except (ValueError, OverflowError):
        return None
    if array.shape != shape or array.dtype.kind not in ("i" if whole else "if"):
        return None
    return array.astype(np.float64)


def _centre_and_step(header: Mapping[str, Any]) -> tuple[FloatArray, float]:
    centre = _numbers(header.get("centre"), (3,), whole=False)
    if centre is None or not np.isfinite(centre).all():
        raise _field_error("centre", "the centre is not a point", "three finite numbers")
    number = _numbers(header.get("step"), (), whole=False)
    step = math.nan if number is None else float(number)
    if not (SMALLEST_STEP <= step <= LARGEST_STEP and math.frexp(step)[0] == 0.5):
        message = f"the step of the grid is {str(header.get('step'))[:20]}"
        raise _field_error("step", message, "a power of two from 2^-149 to 2^103")
    return centre, step


def _base(
    header: Mapping[str, Any], centre: FloatArray, step: float
) -> tuple[FloatArray, IndexArray]:
    """Return the coarsest level in steps, which must be a tetrahedron around the centre."""
    base = header.get("base")
    mapping = base if isinstance(base, dict) else {}
    positions = _numbers(mapping.get("positions"), (4, 3), whole=True)
    if positions is None or (np.abs(positions) > LARGEST_COORDINATE).any():
        raise _field_error(
            "base.positions",
            "the coarsest level does not have four positions",
            f"four times three numbers from {-LARGEST_COORDINATE} to {LARGEST_COORDINATE}",
        )
    corners = _numbers(mapping.get("faces"), (4, 3), whole=True)
    # a tetrahedron has all twelve directed edges between four slots
    pairs = (
        set()
        if corners is None
        else {(int(face[place]), int(face[place - 2])) for face in corners for place in range(3)}
    )
    if pairs != {(one, other) for one in range(4) for other in range(4) if one != other}:
        raise _field_error(
            "base.faces",
            "the coarsest level is not closed",
            "the four faces of a tetrahedron, counter-clockwise from outside",
        )
    faces = np.array(mapping["faces"], np.int32)
    one, two, three = np.moveaxis((positions * step - centre)[faces], 1, 0)
    if not ((one * np.cross(two, three)).sum(axis=1) > 0).all():
        message = "a face of the coarsest level does not see the centre from inside"
        raise _field_error("base.positions", message)
    return positions, faces


def _groups(header: Mapping[str, Any], vertices: int) -> list[Group]:
    lines = header.get("groups")
    ranges = group_ranges(vertices)
    if not isinstance(lines, list) or len(lines) != len(ranges):
        raise _field_error("groups", f"there are not {len(ranges)} groups")
    groups = []
    for number, (line, (start, end)) in enumerate(zip(lines, ranges, strict=True)):
        values = [line.get(name) if isinstance(line, dict) else None for name in LINE]
        numbers = [value for value in values if type(value) is int and value >= 0]
        most = CORNERS_PER_VERTEX * end
        limits = (end, most, most, LARGEST_PART, 2**32 - 1)
        if len(numbers) < len(LINE) or numbers[0] != end or any(map(operator.gt, numbers, limits)):
            message = f"the line of group {number} is {str(line)[:100]}"
            raise _field_error(group_name(number), message)
        groups.append(Group(number, start, *numbers))
    return groups


def _sections(header: Mapping[str, Any]) -> list[_Section]:
    lines = header.get("sections", [])
    sections = []
    for line in lines if isinstance(lines, list) else [None]:
        values = line if isinstance(line, dict) else {}
        name, size, crc32 = values.get("name"), values.get("bytes"), values.get("crc32")
        if (
            not isinstance(name, str)
            or type(size) is not int
            or type(crc32) is not int
            or not 0 <= size <= LARGEST_PART
        ):
            raise _field_error("sections", f"the line of a section is {str(line)[:100]}")
        sections.append(_Section(name, size, crc32))
    return sections


def _splits_in_steps(splits: Splits, step: float) -> Splits:
    """Return the splits with positions as int32 in steps, or raise a `HistoryFileError`."""
    whole: dict[str, Any] = {}
    for name, array in splits._asdict().items():
        if array.dtype != np.float32:
            continue
        steps = np.rint(array.astype(np.float64) / step)
        if not (np.abs(steps) <= LARGEST_COORDINATE).all() or (steps * step != array).any():
            message = f"positions in {name!r} are not on the grid of the step {step!r}"
            remedy = f"Give multiples of the step, at most {LARGEST_COORDINATE} times it."
            raise HistoryFileError(message, where={"field": name}, remedy=remedy)
        whole[name] = steps.astype(np.int32)
    return splits._replace(**whole)


def _refuse_much_work(splits: Splits) -> None:
    """Refuse what readers would refuse, because a test of a group would take too long."""
    work, most = star_test_work(splits)
    elements = max(
        (
            count / end
            for _, end in group_ranges(splits.vertices)
            for count in (splits.moved_end[end - 5], splits.shifted_end[end - 5])
        ),
        default=0,
    )
    if work > LARGEST_WORK or elements > CORNERS_PER_VERTEX:
        raise NeighbourLimitError(
            f"Up to {most} triangles meet at a vertex, and levels would take too long to read.",
            where={"neighbours": most},
            remedy="Divide the surface so that fewer triangles meet at a vertex.",
        )
