import asyncio
import io
import json
import threading

import numpy as np
import pytest

from service.meshes.library import Library
from service.meshes.requested_levels import RequestedLevels
from service.problems.problem import ProblemError
from service.queries.bodies import CSV, JSON, NPY, Body
from service.queries.operations import OPERATIONS, Operation, Result
from service.queries.queries import INLINE_ROWS, PIECE, Admission, Queries, Question
from service.telemetry.metrics import QueryFigures

VALUES = {"space": None, "distance": False, "tolerance": None}


@pytest.fixture
def run(filled_store):
    """Run a coroutine function with the queries of the filled store."""

    def run_scenario(scenario, most_rows=10**7):
        library = Library(filled_store, 10**9)
        figures = QueryFigures()
        queries = Queries(
            library, RequestedLevels(library), figures, index_bytes=10**8, most_rows=most_rows
        )
        try:
            return asyncio.run(scenario(queries, figures))
        finally:
            queries.close()
            library.close()

    return run_scenario


async def whole(queries, question):
    first, others = await queries.answer(question)
    return first if others is None else first + b"".join([piece async for piece in others])


def points(count):
    return np.random.default_rng(0).uniform(-30, 30, (count, 3)) + np.array([50, 0, 0])


@pytest.mark.parametrize("count", [0, 1, PIECE, 2 * PIECE + 7])
def test_pieces_are_the_whole(run, cube, count):
    colours = points(count)
    contains = OPERATIONS["contains"]

    async def scenario(queries, figures):
        question = Question(contains, cube, Body([colours], {}), VALUES, NPY)
        array = np.load(io.BytesIO(await whole(queries, question)))
        inside = (np.abs(colours - (50, 0, 0)) <= 10).all(axis=1)
        assert array["inside"].tolist() == inside.tolist()
        assert figures.rows == {"contains": count}
        assert sum(figures.seconds["contains"].counts) == max(1, -(-count // PIECE))

    run(scenario)


def test_entries_of_all_pieces_are_counted_first(run, repeats, cube):
    colours = np.zeros((2 * PIECE + 5, 3))
    colours[:: PIECE // 2, 0] = 3

    async def scenario(queries, _figures):
        question = Question(repeats, cube, Body([colours], {}), {}, NPY)
        array = np.load(io.BytesIO(await whole(queries, question)))
        assert (
            array["row"].tolist() == np.repeat(np.arange(0, 2 * PIECE + 5, PIECE // 2), 3).tolist()
        )

    run(scenario)


def test_json_has_limits_that_other_forms_do_not_have(run, cube):
    async def scenario(queries, _figures):
        body = Body([points(10_001)], {})
        for media_type in (NPY, CSV):
            asked = Question(OPERATIONS["contains"], cube, body, VALUES, media_type)
            assert await whole(queries, asked)
        asked = asked._replace(media_type=JSON)
        with pytest.raises(ProblemError) as caught:
            await queries.answer(asked)
        assert caught.value.problem.code == "too-many-rows"
        assert caught.value.problem.where["header"] == "Accept"
        fewer = asked._replace(body=Body([points(10_000)], {}))
        assert len(json.loads(await whole(queries, fewer))["inside"]) == 10_000

    run(scenario)


def test_few_rows_stay_on_the_event_loop_and_many_leave_it(run, cube):
    threads = []

    def note(_level, inputs, _values):
        threads.append(threading.current_thread())
        return Result({"inside": np.zeros(len(inputs[0]), bool)})

    operation = Operation("note", "note", "Note", "Note.", (), (), note, {}, {})

    async def scenario(queries, _figures):
        for count in (INLINE_ROWS, INLINE_ROWS + 1):
            body = Body([points(count)], {})
            await whole(queries, Question(operation, cube, body, {}, JSON))
        assert threads[0] is threading.main_thread()
        assert threads[1] is not threading.main_thread()

    run(scenario)


def test_errors_of_an_answer_come_before_its_first_byte(run, cube):
    def fail(_level, _inputs, _values):
        raise ZeroDivisionError

    operation = Operation("fail", "fail", "Fail", "Fail.", (), (), fail, {}, {})

    async def scenario(queries, _figures):
        with pytest.raises(ZeroDivisionError):
            await queries.answer(Question(operation, cube, Body([points(99)], {}), {}, NPY))

    run(scenario)


class TestAdmission:
    def test_rows_are_counted_until_the_end(self):
        admission = Admission(100)
        with admission.held(60) as correct, admission.held(40):
            assert admission.rows == 100
            with pytest.raises(ProblemError) as caught, admission.held(1):
                pass
            assert caught.value.problem.code == "queries-busy"
            assert caught.value.problem.headers["Retry-After"] == "1"
            correct(10)
            with admission.held(50):
                assert admission.rows == 100
        assert admission.rows == 0

    def test_a_single_query_is_always_admitted(self):
        admission = Admission(100)
        with admission.held(1000):
            assert admission.rows == 1000
        assert admission.rows == 0

    def test_refused_and_failed_rows_are_not_counted(self):
        admission = Admission(100)
        with pytest.raises(ZeroDivisionError), admission.held(50) as correct:
            correct(70 // 0)
        assert admission.rows == 0
