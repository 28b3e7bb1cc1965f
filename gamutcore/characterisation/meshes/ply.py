"""PLY (Turk, Stanford 1994): text and binary of either byte order, with polygons of any size.

The header says what each element has; its counts are believed only as far as the file is long.
Vertices need the properties x, y and z, which are L*, a* and b*. Comments of the form
``name: value``, as this package's own exports have them, are what the file says of itself. So are
the device values of vertices: properties ``device_C``, with the channels' names in comments.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.gamut_mesh import (
    TOO_MANY_DEVICE_VALUES,
    by_channel,
    gamut_mesh,
    reads_device_values,
    refuse_too_many,
    statements,
    unescaped,
)
from gamutcore.characterisation.meshes.numbers import numbers_of, polygon_triangles
from gamutcore.characterisation.meshes.ply_header import (
    DEVICE,
    FACE_LISTS,
    Element,
    Header,
    Property,
    device_properties,
    ply_header,
)
from gamutcore.errors import MalformedFileError, SampleLimitError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.characterisation.gamut_mesh import GamutMesh

__all__ = ["looks_like_ply", "ply_mesh"]

MAX_NUMBERS = 24_000_000
"""Numbers of a text at most, of all elements: 3 million vertices of 6, 1 million faces of 4 and 2
more. They take 190 MB."""

MAX_WALKED = 2_000_000
"""Numbers and lists that are read one by one at most, where rows differ in length: about 1 s."""


def looks_like_ply(data: bytes) -> bool:
    """Return whether bytes start as PLY files do.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    bool
    """
    return re.match(rb"ply[ \t]*[\r\n]", data) is not None


def ply_mesh(data: bytes) -> GamutMesh:
    """Return the mesh in a PLY file.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    GamutMesh

    Raises
    ------
    MalformedFileError
        The header or the elements are broken; the error names the line of the header or text.
    SampleLimitError, InvalidPointsError
        As for `gamutcore.characterisation.gamut_mesh.gamut_mesh`.
    """
    header = ply_header(data)
    reader = _TextRows(data, header) if not header.order else _BinaryRows(data, header)
    vertices: FloatArray | None = None
    faces: LongArray | None = None
    device: dict[str, FloatArray] = {}
    unread = False
    for element in header.elements:
        if vertices is not None and faces is not None:
            break  # whatever comes after them is not needed
        columns = reader.columns(element)
        if element.name == "vertex" and vertices is None:
            vertices = _positions(element, columns)
            device = by_channel(
                (
                    unescaped(header.said.pop(name, name.removeprefix(DEVICE))),
                    columns.values.get(name, np.empty(0)),
                )
                for name in device_properties(element)
                if reads_device_values(element.count, len(device_properties(element)))
            )
            unread = not device and bool(device_properties(element))
        elif element.name == "face" and faces is None:
            faces = _triangles(element, columns)
    if vertices is None or faces is None:
        missing = "vertex" if vertices is None else "face"
        raise MalformedFileError(
            f"The file has no element {missing}.",
            where={"field": missing},
            remedy="A mesh has elements vertex (with x, y, z) and face (with vertex_indices).",
        )
    return gamut_mesh(
        "ply",
        vertices,
        faces,
        stated=statements(header.said),
        device=device,
        warnings=[TOO_MANY_DEVICE_VALUES] * unread,
    )


class _Columns:
    """Values of an element: a column of numbers for each property, and for lists their lengths."""

    def __init__(self) -> None:
        self.values: dict[str, FloatArray] = {}
        self.lengths: dict[str, LongArray] = {}


class _BinaryRows:
    """Elements of a binary file, from the first on."""

    def __init__(self, data: bytes, header: Header) -> None:
        self.data, self.order, self.place = data, header.order, header.size
        self.walked = 0

    def columns(self, element: Element) -> _Columns:
        """Return the values of the next element."""
        properties = element.properties
        found = _Columns()
        if not properties or not element.count:
            return found
        # first as if all lists had the length of the first row's, which is nearly always so
        lengths = self._first_lengths(element)
        kind = np.dtype(
            [
                part
                for prop, length in zip(properties, lengths, strict=True)
                for part in (
                    ([(f"#{prop.name}", self.order + prop.length)] if prop.length else [])
                    + [
                        (f"={prop.name}", self.order + prop.kind, (length,))
                        if prop.length
                        else (f"={prop.name}", self.order + prop.kind)
                    ]
                )
            ]
        )
        lists = [prop for prop in properties if prop.length]
        if self.place + element.count * kind.itemsize <= len(self.data):
            rows = np.frombuffer(self.data, kind, element.count, self.place)
            if all(
                (rows[f"#{prop.name}"] == length).all()
                for prop, length in zip(properties, lengths, strict=True)
                if prop.length
            ):
                self.place += element.count * kind.itemsize
                for prop, length in zip(properties, lengths, strict=True):
                    if prop.kept:
                        found.values[prop.name] = _doubles(rows[f"={prop.name}"].ravel())
                        if prop.length:
                            found.lengths[prop.name] = np.full(element.count, length, np.int64)
                return found
        if not lists:
            raise self._cut_off(element)
        return self._row_by_row(element)

    def _first_lengths(self, element: Element) -> list[int]:
        place, lengths = self.place, []
        for prop in element.properties:
            length = 1
            if prop.length:
                length = self._length(prop, place, element)
                place += int(prop.length[1])
            lengths.append(length)
            place += length * int(prop.kind[1])
            if place > len(self.data):
                raise self._cut_off(element)
        return lengths

    def _length(self, prop: Property, place: int, element: Element) -> int:
        size = int(prop.length[1])
        raw = self.data[place : place + size]
        if len(raw) < size:
            raise self._cut_off(element)
        length = int.from_bytes(
            raw, "little" if self.order == "<" else "big", signed=prop.length.startswith("i")
        )
        if length < 0:
            raise MalformedFileError(
                f"A list of the element {element.name} has the length {length}.",
                where={"field": prop.name, "byte": place},
                remedy="Lengths are 0 or more.",
            )
        return length

    def _row_by_row(self, element: Element) -> _Columns:
        self.walked = _walked(self.walked, element)
        pieces: dict[str, list[bytes]] = {prop.name: [] for prop in element.properties}
        lengths: dict[str, list[int]] = {prop.name: [] for prop in element.properties}
        place, data = self.place, self.data
        plan = [(prop, int(prop.kind[1]), prop.kept) for prop in element.properties]
        for _ in range(element.count):
            for prop, size, wanted in plan:
                length = 1
                if prop.length:
                    length = self._length(prop, place, element)
                    lengths[prop.name].append(length)
                    place += int(prop.length[1])
                if wanted:
                    pieces[prop.name].append(data[place : place + length * size])
                place += length * size
            if place > len(data):
                raise self._cut_off(element)
        self.place = place
        found = _Columns()
        for prop in element.properties:
            if prop.kept:
                joined = b"".join(pieces[prop.name])
                found.values[prop.name] = _doubles(np.frombuffer(joined, self.order + prop.kind))
                if prop.length:
                    found.lengths[prop.name] = np.array(lengths[prop.name], np.int64)
        return found

    def _cut_off(self, element: Element) -> MalformedFileError:
        return MalformedFileError(
            f"The file ends within the {element.count} rows of the element {element.name}.",
            where={"field": element.name, "byte": len(self.data)},
            remedy="Send the whole file.",
        )


class _TextRows:
    """Elements of a text file, from the first on."""

    def __init__(self, data: bytes, header: Header) -> None:
        self.numbers = numbers_of(data[header.size :], header.lines + 1, MAX_NUMBERS + 1)
        if len(self.numbers) > MAX_NUMBERS:
            raise SampleLimitError(
                f"The file has more than {MAX_NUMBERS} numbers.",
                remedy="Send the mesh alone, without further elements.",
            )
        self.place = 0
        self.walked = 0

    def columns(self, element: Element) -> _Columns:
        """Return the values of the next element."""
        found = _Columns()
        properties, count = element.properties, element.count
        if not properties or not count:
            return found
        width, starts, lengths = self._row(element)
        rest = self.numbers[self.place : self.place + count * width]
        if len(rest) == count * width:
            rows = rest.reshape(count, width)
            if all((rows[:, starts[name] - 1] == length).all() for name, length in lengths.items()):
                self.place += count * width
                for prop in properties:
                    start = starts[prop.name]
                    if not prop.kept:
                        continue
                    if prop.length:
                        length = lengths[prop.name]
                        found.lengths[prop.name] = np.full(count, length, np.int64)
                        found.values[prop.name] = rows[:, start : start + length].ravel()
                    else:
                        found.values[prop.name] = rows[:, start].copy()
                return found
        if not lengths:
            raise self._cut_off(element)
        return self._row_by_row(element)

    def _row(self, element: Element) -> tuple[int, dict[str, int], dict[str, int]]:
        """Return the first row's width, where its properties start, and its lists' lengths."""
        width, starts, lengths = 0, {}, {}
        for prop in element.properties:
            length = 1
            if prop.length:
                length = self._length(prop, self.place + width, element)
                lengths[prop.name] = length
                width += 1
            starts[prop.name] = width
            width += length
            if self.place + width > len(self.numbers):
                raise self._cut_off(element)
        return width, starts, lengths

    def _length(self, prop: Property, place: int, element: Element) -> int:
        if place >= len(self.numbers):
            raise self._cut_off(element)
        length = float(self.numbers[place])
        if not (0 <= length <= len(self.numbers) and length == int(length)):
            raise MalformedFileError(
                f"A list of the element {element.name} has the length {length:g}.",
                where={"field": prop.name},
                remedy="Lengths are whole numbers, and the list follows.",
            )
        return int(length)

    def _row_by_row(self, element: Element) -> _Columns:
        self.walked = _walked(self.walked, element)
        pieces: dict[str, list[FloatArray]] = {prop.name: [] for prop in element.properties}
        lengths: dict[str, list[int]] = {prop.name: [] for prop in element.properties}
        place, numbers = self.place, self.numbers
        for _ in range(element.count):
            for prop in element.properties:
                length = 1
                if prop.length:
                    length = self._length(prop, place, element)
                    lengths[prop.name].append(length)
                    place += 1
                if prop.kept:
                    pieces[prop.name].append(numbers[place : place + length])
                place += length
            if place > len(numbers):
                raise self._cut_off(element)
        self.place = place
        found = _Columns()
        for prop in element.properties:
            if prop.kept:
                found.values[prop.name] = np.concatenate(pieces[prop.name])
                if prop.length:
                    found.lengths[prop.name] = np.array(lengths[prop.name], np.int64)
        return found

    def _cut_off(self, element: Element) -> MalformedFileError:
        return MalformedFileError(
            f"The file ends within the {element.count} rows of the element {element.name}.",
            where={"field": element.name, "line": element.line},
            remedy="Send the whole file.",
        )


def _walked(before: int, element: Element) -> int:
    """Return how much is read one by one with an element's rows; refuse what is too much."""
    walked = before + element.count * len(element.properties)
    if walked > MAX_WALKED:
        raise SampleLimitError(
            f"The element {element.name} has {element.count} rows of different lengths.",
            where={"line": element.line},
            remedy="Send the mesh with triangles only, and without further properties.",
        )
    return walked


def _doubles(values: np.ndarray) -> FloatArray:
    with np.errstate(invalid="ignore"):  # a signalling NaN becomes a quiet one
        return values.astype(np.float64)


def _positions(element: Element, columns: _Columns) -> FloatArray:
    if not element.count:
        return np.empty((0, 3))
    if any(name not in columns.values or name in columns.lengths for name in "xyz"):
        raise MalformedFileError(
            "The vertices have not the properties x, y and z.",
            where={"line": element.line, "field": "vertex"},
            remedy="x, y and z are L*, a* and b*.",
        )
    return np.stack([columns.values[name] for name in "xyz"], axis=1)


def _triangles(element: Element, columns: _Columns) -> LongArray:
    if not element.count:
        return np.empty((0, 3), np.int64)
    name = next((name for name in FACE_LISTS if name in columns.lengths), None)
    if name is None:
        raise MalformedFileError(
            "The faces have no list vertex_indices.",
            where={"line": element.line, "field": "face"},
            remedy="A face is a list of the indices of its vertices.",
        )
    sides, corners = columns.lengths[name], columns.values[name]
    refuse_too_many(0, int(np.maximum(sides - 2, 0).sum()), where={"line": element.line})
    whole = np.abs(corners) < 2**31
    if not (whole.all() and (corners == np.rint(corners)).all()):
        raise MalformedFileError(
            "A face names a vertex by what is no whole number.",
            where={"field": "face"},
            remedy="Vertices are numbered from 0.",
        )
    return polygon_triangles(sides, corners.astype(np.int64))
