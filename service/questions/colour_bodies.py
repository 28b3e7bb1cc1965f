"""Bodies of queries: JSON, .npy and tables to arrays of colours.

All rows are checked before anything is computed, so an answer is complete or a problem. Rows are
counted from 0. See ``docs/decisions/queries-over-http.md``.
"""

from __future__ import annotations

import io
import tokenize
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from pydantic_core import from_json

from gamutcore.arguments import Number, Text
from gamutcore.errors import (
    CharacterisationError,
    InvalidPointsError,
    OptionError,
    SampleLimitError,
)
from gamutcore.questions import Parameter
from gamutcore.search import LARGEST_COORDINATE, checked_points
from gamutcore.tables import read_table
from service.http.bodies import parse_json
from service.http.requests import invalid_parameter
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import FloatArray
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.questions import Question
    from gamutcore.tables import ColourTable

__all__ = [
    "CSV",
    "FORMS",
    "JSON",
    "NPY",
    "TABLES",
    "TABLE_PARAMETERS",
    "Form",
    "QuestionBody",
    "parse_body",
]

JSON = "application/json"
NPY = "application/x-npy"
CSV = "text/csv"


class Form(NamedTuple):
    """A form of bodies and answers, with the limits of a body."""

    most_rows: int
    row_bytes: int
    """Smallest size of a row of three coordinates, to estimate the rows of a body by its size."""
    most_bytes: int


_MEBIBYTE = 2**20

FORMS = {
    # two colours of three numbers, each of up to 25 characters and a comma, are 156 bytes
    JSON: Form(10_000, 8, 2 * _MEBIBYTE),
    NPY: Form(1_000_000, 12, 64 * _MEBIBYTE),
    CSV: Form(1_000_000, 6, 160 * _MEBIBYTE),
}
"""Forms by media type."""

TABLES = frozenset({CSV, "text/plain", "text/tab-separated-values", "application/octet-stream"})
"""Media types of tables, whose form is recognised by the content: CSV, CGATS, CxF, swatches."""

TABLE_PARAMETERS = (
    Parameter(
        "columns",
        Annotated[str, Text(200, "names or numbers of columns, separated by commas")],
        "For tables: names or numbers of the three columns of the colours, or of the one with "
        "texts such as `#e4002b`. By default, the names of the columns decide.",
        example="L,a,b",
    ),
    Parameter(
        "table_scale",
        Annotated[float, Number(0.0, 1e6, above_least=True, below_most=True)],
        "For tables: the value of white, such as 1, 100 or 255. By default, the values decide, and "
        "with `space` it is 1 for `sRGB` and `CIEXYZ`.",
        example=255,
    ),
)
"""Parameters of queries whose body is a table."""

_SCALED = frozenset({"sRGB", "CIEXYZ"})
"""Spaces that tables have on several scales. That of the API is 0 to 1."""

_TABLE_BYTES = 4 * 2**20
"""Largest body of measurements or swatches. CGATS of this size, in rows of 15 bytes, takes 0.13 GB
and some seconds."""

_NPY_MAGIC = b"\x93NUMPY"

_HEADER_BYTES = 10_000
"""Largest header of an .npy file, as NumPy accepts it by default."""

_BROKEN_HEADER = (
    *(ValueError, TypeError, SyntaxError, KeyError, MemoryError, RecursionError),
    tokenize.TokenError,
)
"""What NumPy raises for the headers of damaged files."""


class QuestionBody(NamedTuple):
    """The content of a body: an array (n, 3) for each name of the question's inputs."""

    inputs: list[FloatArray]
    members: dict[str, object]
    """Parameters in a JSON body, not checked."""
    table: ColourTable | None = None
    """The client's own columns, if the body is a table."""
    axes: Sequence[str] = ()
    """Names of the coordinates in the space of the colours; those of the gamut's if empty."""

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.inputs[0])


def parse_body(
    content: bytes | bytearray,
    media_type: str,
    question: Question,
    gamut_space: ColourSpace,
    width: int,
    query: Mapping[str, Any],
) -> QuestionBody:
    """Return the content of a body of a form of `FORMS`. A table is not copied if it is bytes.

    `width` is the number of values in a row of an input, and `query` has the parameters in the
    query string. Raise `ProblemError` if the body is malformed, has other members, columns or
    shapes, or too many rows, and `InvalidPointsError` if a row is not as many finite numbers.
    """
    if media_type == JSON:
        body = _json(content, question, width)
    elif media_type == NPY:
        body = QuestionBody(_npy(content, question.inputs, width), {})
    else:
        table = _table(bytes(content), question.inputs, gamut_space, query)
        body = QuestionBody(table.inputs, {}, table)
    checked = []
    for name, points in zip(question.inputs, body.inputs, strict=True):
        try:
            checked.append(checked_points(points, name, width))
        except InvalidPointsError as error:
            if body.table is not None and "row" in error.where:
                error.where |= body.table.place(int(str(error.where["row"])))
            raise
    return body._replace(inputs=checked)


def _json(content: bytes | bytearray, question: Question, width: int) -> QuestionBody:
    most = FORMS[JSON].most_rows
    # Decoding makes an object of two bytes, so the number is limited before.
    if content.count(b"[") > most * len(question.inputs) + 100:
        raise _too_many(f"more than {most}", most)
    document = _decoded(content)
    known = [*question.inputs, *(parameter.name for parameter in question.all_parameters)]
    if not isinstance(document, dict):
        raise _invalid("The JSON is not an object.", question.inputs[0])
    for name in document:
        if name not in known:
            detail = f"There is a member {name[:40]!r}."
            raise _invalid(detail, name[:40], f"Members are {', '.join(known)}.")
    inputs = []
    for name in question.inputs:
        if name not in document:
            raise _invalid(f"The JSON object has no member {name}.", name)
        inputs.append(_points(document.pop(name), name, most, width))
    _same_rows(question.inputs, inputs)
    return QuestionBody(inputs, document)


def _decoded(content: bytes | bytearray) -> Any:  # noqa: ANN401 - JSON before its shape is known
    """Return JSON by a fast parser. What it refuses or cannot judge goes to the strict parser."""
    try:
        document = from_json(content, allow_inf_nan=False, cache_strings="keys")
    except ValueError:
        return parse_json(content)
    if not isinstance(document, dict):
        return document
    texts = sum(isinstance(value, str) for value in document.values()) + len(document)
    # More quotes than those of the members: a name is repeated, or there are texts elsewhere.
    return document if content.count(b'"') == 2 * texts else parse_json(content)


def _points(rows: object, name: str, most: int, width: int) -> FloatArray:
    """Return the points in a list of lists, unchecked for infinities."""
    if not isinstance(rows, list):
        raise _invalid(f"{name} is not a list of rows.", name)
    if len(rows) > most:
        raise _too_many(str(len(rows)), most)
    if not rows:
        return np.empty((0, width))
    try:
        points = np.array(rows, np.float64)
    except (ValueError, TypeError, OverflowError):
        points = np.empty(0)
    # NumPy takes texts, booleans and null for numbers.
    if points.shape != (len(rows), width) or not _are_numbers(rows):
        for row, colour in enumerate(rows):
            if not _is_row(colour, width):
                raise InvalidPointsError(
                    f"Row {row} of {name} is {str(colour)[:60]}.",
                    where={"field": name, "row": row},
                    remedy=f"Give {width} numbers.",
                )
    return points


def _are_numbers(rows: list[Any]) -> bool:
    return {type(value) for row in rows for value in row} <= {int, float}


def _is_row(colour: object, width: int) -> bool:
    return (
        isinstance(colour, list)
        and len(colour) == width
        and _are_numbers([colour])
        and max(map(abs, colour)) <= LARGEST_COORDINATE
    )


def _npy(content: bytes | bytearray, names: Sequence[str], width: int) -> list[FloatArray]:
    file = io.BytesIO(content[: _HEADER_BYTES + 12])
    try:
        version = np.lib.format.read_magic(file)
        readers = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }
        shape, is_fortran, dtype = readers[version](file, max_header_size=_HEADER_BYTES)
    except _BROKEN_HEADER as error:
        raise _no_npy("The body is not an .npy file with a valid header.") from error
    columns = width * len(names)
    if len(shape) != 2 or shape[1] != columns or dtype.kind != "f" or dtype.itemsize not in {4, 8}:
        detail = f"The array has the shape {shape} and the type {dtype}"[:200] + "."
        remedy = f"Send an (n, {columns}) array of float32 or float64: {', '.join(names)}."
        raise _no_npy(detail, remedy)
    most = FORMS[NPY].most_rows
    if shape[0] > most:
        raise _too_many(str(shape[0]), most)
    size = len(content) - file.tell()
    if size != shape[0] * columns * dtype.itemsize:
        raise _no_npy(f"The array of shape {shape} has {size} bytes of data.")
    flat = np.frombuffer(content, dtype, offset=file.tell())
    array = flat.reshape(shape, order="F" if is_fortran else "C")
    return [array[:, first : first + width] for first in range(0, columns, width)]


def _table(
    content: bytes, names: Sequence[str], gamut_space: ColourSpace, query: Mapping[str, Any]
) -> ColourTable:
    """Return the table in a body. With several names, columns have them as a prefix: ``from_L``."""
    most = FORMS[CSV].most_rows
    space, columns, scale = (query.get(name) for name in ("space", "columns", "table_scale"))
    if content.startswith(_NPY_MAGIC):
        remedy = "Send it with Content-Type: application/x-npy."
        raise ProblemError(Problem("invalid-body", "The body is an .npy file.", {}, remedy))
    if scale is None and columns is None and space in _SCALED:
        scale = 1.0
    try:
        table = read_table(
            content,
            space=space,
            columns=columns,
            scale=scale,
            names=names,
            own=gamut_space.name,
            most=most,
            most_bytes=_TABLE_BYTES,
        )
    except SampleLimitError as error:
        limit = error.where.get("limit", most)
        raise ProblemError(
            Problem("too-many-rows", error.message, {"limit": limit}, error.remedy)
        ) from error
    except OptionError as error:
        field = str(error.where.get("field", "columns"))
        raise invalid_parameter(error.message, "query", field, error.remedy) from error
    except CharacterisationError as error:
        raise ProblemError(
            Problem("invalid-body", error.message, error.where, error.remedy)
        ) from error
    if len(table.inputs) != len(names):
        detail = f"The file has one colour in each row, and {' and '.join(names)} are needed."
        remedy = "Send a table whose columns have the prefixes of the operation."
        raise ProblemError(Problem("invalid-body", detail, {"field": names[-1]}, remedy))
    return table


def _same_rows(names: Sequence[str], inputs: list[FloatArray]) -> None:
    if len({len(points) for points in inputs}) > 1:
        counts = ", ".join(
            f"{name} {len(points)}" for name, points in zip(names, inputs, strict=True)
        )
        raise _invalid(f"The numbers of rows differ: {counts}.", names[-1])


def _no_npy(detail: str, remedy: str = "") -> ProblemError:
    remedy = remedy or "Save an (n, 3) array of float32 or float64 with numpy.save."
    return ProblemError(Problem("invalid-body", detail, {"field": "header"}, remedy))


def _invalid(detail: str, field: str, remedy: str = "") -> ProblemError:
    remedy = remedy or 'Send an object such as {"colours": [[50, 0, 0]]}.'
    return ProblemError(Problem("invalid-body", detail, {"field": field}, remedy))


def _too_many(rows: str, most: int) -> ProblemError:
    return ProblemError(Problem("too-many-rows", f"There are {rows} rows.", {"limit": most}))
