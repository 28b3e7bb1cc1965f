"""Execution of queries: answers in threads, piece by piece.

Kernels release the interpreter lock, so threads use all cores and the event loop stays free. A few
rows on a level in memory are answered on the event loop, because passing them to a thread takes
longer. See ``docs/decisions/queries-over-http.md``.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from typing import TYPE_CHECKING, Any, NamedTuple

from gamutcore.errors import InvalidPointsError
from service.admission import Work, needed_bytes
from service.http.request_context import timed
from service.http.requests import invalid_parameter
from service.problems.problem import Problem, ProblemError
from service.questions.answers import WRITERS, level_document, shape_file
from service.questions.colour_bodies import CSV, FORMS, JSON, parse_body

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Mapping, Sequence

    from gamutcore.arrays import FloatArray
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.questions import Answer, Question
    from gamutcore.tables import ColourTable
    from service.http.bodies import Body
    from service.library import Library, QueryLevel
    from service.questions.answers import Writer
    from service.questions.colour_bodies import QuestionBody
    from service.telemetry.metrics import QueryMetrics

__all__ = ["Query", "QuestionRunner", "answer_bytes", "is_inline", "level_values", "work_of"]

PIECE = 65_536
"""Rows that are answered at once: tens of milliseconds, and some megabytes."""

INLINE_ROWS = 16
"""Largest number of rows that are answered on the event loop, in less than a millisecond."""

INLINE_BYTES = 2048
"""Largest body that is parsed on the event loop."""


SMALL_ROWS = 1000
"""Tables of at most so many rows are small work. They are answered within milliseconds."""

_TEXT_ROWS = {JSON: 5, CSV: 2}
"""Memory of a row by media type, in rows of numbers. JSON of a table has labels and lines."""


def work_of(rows: int) -> Work:
    """Return the class of a table."""
    return Work.SMALL if rows <= SMALL_ROWS else Work.VIEW


def answer_bytes(rows: int, media_type: str, *, ahead: int = 1) -> int:
    """Return the memory of the part of an answer that is not sent: pieces, and those ahead."""
    return needed_bytes(rows=_TEXT_ROWS.get(media_type, 1) * min(rows, (1 + ahead) * PIECE))


def is_inline(rows: int, table: ColourTable | None) -> bool:
    """Return whether rows are answered on the event loop."""
    # A table of a few colours may have any number of other rows and cells.
    return rows <= INLINE_ROWS and table is None


class Query(NamedTuple):
    """A question with its levels and its rows.

    `levels` has the level of the gamut, and that of another gamut if the question names one.
    `media_type` is the form of the answer.
    """

    question: Question
    levels: Sequence[QueryLevel]
    body: QuestionBody
    values: Mapping[str, Any]
    media_type: str
    warnings: tuple[str, ...]


def level_values(levels: Sequence[QueryLevel], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of parameters, with the count of the level that answers.

    The levels of two gamuts are chosen by the same values.
    """
    level = {"triangles": levels[0].triangles, "max_error": None} if len(levels) == 1 else {}
    return {**values, **level}


class QuestionRunner:
    """Answers queries about levels.

    `metrics` counts rows and seconds. `library` has the threads. `ahead` is the number of pieces of
    an answer that are computed while an earlier one is sent.
    """

    def __init__(self, metrics: QueryMetrics, library: Library) -> None:
        self._admission = library.admission
        self.ahead = library.admission.places[Work.VIEW]
        self._metrics = metrics
        self._in_thread = library.in_thread

    async def parse(
        self,
        arriving: Body,
        media_type: str,
        question: Question,
        gamut_space: ColourSpace,
        width: int,
        query: Mapping[str, Any],
    ) -> QuestionBody:
        """Return the content of a body that has arrived; see `parse_body`."""

        def parse() -> QuestionBody:
            # The text of a table is kept for its answer, so it is read as bytes at once.
            content = arriving.read(0, arriving.size) if media_type == CSV else arriving.content()
            return parse_body(content, media_type, question, gamut_space, width, query)

        with timed("body"):
            if media_type == JSON and arriving.size <= INLINE_BYTES:
                return parse()
            return await self._in_thread(parse)

    async def answer(
        self, query: Query, client: str
    ) -> tuple[bytes, AsyncGenerator[bytes, None] | None]:
        """Return the first part of an answer, and the others if there are any.

        The others take turns of the client, and the caller holds their bytes.

        Raise ``too-many-rows`` if the answer would be JSON, and `GamutError` if a row cannot be
        answered. Only the first part can raise it.
        """
        rows = query.body.rows
        if query.media_type == JSON and rows > FORMS[JSON].most_rows:
            most = FORMS[JSON].most_rows
            detail = f"There are {rows} rows. An answer in JSON has at most {most}."
            where = {"header": "Accept", "limit": most}
            remedy = "Accept application/x-npy or text/csv."
            raise ProblemError(Problem("too-many-rows", detail, where, remedy))
        writer = WRITERS[query.media_type](
            query.question, query.levels[0], query.body, query.warnings
        )
        if is_inline(rows, query.body.table):
            return self._first(query, writer), None
        first = await self._in_thread(self._first, query, writer)
        return first, self._others(query, writer, client) if rows > PIECE else None

    async def shape(
        self,
        question: Question,
        levels: list[QueryLevel],
        values: Mapping[str, Any],
        media_type: str,
    ) -> bytes:
        """Return the answer to a question about the shape of gamuts as a file."""
        return await self._in_thread(self._shape_file, question, levels, values, media_type)

    def _shape_file(
        self,
        question: Question,
        levels: list[QueryLevel],
        values: Mapping[str, Any],
        media_type: str,
    ) -> bytes:
        clock = time.perf_counter()
        _check_alternatives(question, values)
        gamuts, values = [level.gamut for level in levels], level_values(levels, values)
        with timed("query"):
            answer = question.answer(gamuts, (), values)
        rows = len(next(iter(answer.columns.values())))
        self._metrics.count(question.name, rows, time.perf_counter() - clock)
        documents = [level_document(level) for level in levels]
        conditions = [gamut.conditions.to_dict() for gamut in gamuts]
        named: dict[str, Any]
        if question.name == "comparisons":
            named = {
                "levels": dict(zip("ab", documents, strict=True)),
                "gamuts": dict(zip("ab", conditions, strict=True)),
            }
        else:
            named = dict(zip(("level", "reference_level"), documents, strict=False))
            named |= dict(zip(("gamut", "reference_gamut"), conditions, strict=False))
        named["warnings"] = list(question.warnings(gamuts, None))
        with timed("encode"):
            return shape_file(media_type, named, answer, levels[0].axes)

    def _first(self, query: Query, writer: Writer) -> bytes:
        result = self._result(query, 0)
        entries = query.body.rows
        if query.values.get("space") is not None and not query.question.of_device:
            # Conversion may refuse a row. Later, the answer would have begun.
            for start in range(PIECE, entries, PIECE):
                self._check_conversion(query, start)
        if result.offsets is not None:
            entries = int(result.offsets[-1])
            for start in range(PIECE, query.body.rows, PIECE):
                counted = self._result(query, start).offsets
                entries += 0 if counted is None else int(counted[-1])
        with timed("encode"):
            return writer.head(result, entries) + writer.piece(0, result)

    def _check_conversion(self, query: Query, start: int) -> None:
        """Raise the error of a colour that has no coordinates in the space of the gamut."""
        level, space = query.levels[0], query.values["space"]
        try:
            for points in query.body.inputs:
                rows = points[start : start + PIECE]
                level.gamut.convert(rows, space)
        except InvalidPointsError as error:
            _shift_row(error, start)
            raise

    async def _others(
        self, query: Query, writer: Writer, client: str
    ) -> AsyncGenerator[bytes, None]:
        # The cells of a client's table are read in order; other pieces use all cores.
        ahead = self.ahead if query.body.table is None else 1
        pieces: deque[asyncio.Task[bytes]] = deque()

        async def compute(start: int) -> bytes:
            # First of the client, whose other requests may wait for the bytes of this answer.
            with await self._admission.place(Work.VIEW, client, int, goes_on=True):
                return await self._in_thread(self._piece, query, writer, start)

        try:
            for start in range(PIECE, query.body.rows, PIECE):
                pieces.append(asyncio.create_task(compute(start)))
                if len(pieces) == ahead:
                    yield await pieces.popleft()
            while pieces:
                yield await pieces.popleft()
        finally:
            for piece in pieces:
                piece.cancel()

    def _piece(self, query: Query, writer: Writer, start: int) -> bytes:
        return writer.piece(start, self._result(query, start))

    def _result(self, query: Query, start: int) -> Answer:
        rows: list[FloatArray] = [points[start : start + PIECE] for points in query.body.inputs]
        gamuts = [level.gamut for level in query.levels]
        clock = time.perf_counter()
        try:
            with timed("query"):
                result = query.question.answer(gamuts, rows, query.values)
        except InvalidPointsError as error:
            _shift_row(error, start)
            raise
        seconds = time.perf_counter() - clock
        self._metrics.count(query.question.name, len(rows[0]), seconds)
        return result


def _check_alternatives(question: Question, values: Mapping[str, object]) -> None:
    """Refuse none or several of parameters of which one is needed."""
    names = question.alternatives
    arguments = [name for name in names if values[name] is not None]
    if names and len(arguments) != 1:
        verb = "are" if len(arguments) > 1 else "is"
        fault = f"{' and '.join(arguments) or f'No {names[-1]}'} {verb} given."
        remedy = f"Give one of {', '.join(names[:-1])} and {names[-1]}."
        field = arguments[1] if arguments else names[0]
        raise invalid_parameter(fault, "query", field, remedy)


def _shift_row(error: InvalidPointsError, start: int) -> None:
    """Count the row of an error from the first row of the body, not of the piece."""
    if "row" in error.where:
        error.where["row"] = start + int(str(error.where["row"]))
