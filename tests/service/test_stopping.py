"""Requests that the server cancels when it stops."""

import asyncio

import httpx
import pytest

from service.application import create_app
from service.problems.handlers import AnswerStopped
from service.settings import Settings

PATH = "/v1/gamuts"


@pytest.fixture
def app(tmp_path):
    """An app whose requests wait for ever, after the first part of an answer if it is asked for."""
    app = create_app(Settings(store=str(tmp_path / "data")))

    async def wait(scope, _receive, send):
        if scope["path"] == "/begun":
            start = {"type": "http.response.start", "status": 200, "headers": []}
            await send(start)
            await send({"type": "http.response.body", "body": b"a", "more_body": True})
        await asyncio.Event().wait()

    app.router.routes.clear()
    app.mount("/", wait)
    return app


async def cancelled(app, path):
    """Send a request, and cancel it as uvicorn does; return what was sent."""
    sent = []

    async def send(message):
        sent.append(message)

    async def receive():
        return {"type": "http.request", "body": b"", "more_body": False}

    scope = scope_of(path)
    task = asyncio.create_task(app(scope, receive, send))
    await asyncio.sleep(0.05)
    task.cancel(msg="Task cancelled, timeout graceful shutdown exceeded")
    await task
    return sent


def scope_of(path):
    return {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": "GET",
        "scheme": "http",
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"",
        "root_path": "",
        "headers": [(b"host", b"localhost")],
        "client": ("127.0.0.1", 1),
        "server": ("127.0.0.1", 8000),
    }


def test_a_request_that_is_not_finished_gets_503_without_a_traceback(app, assert_problem, caplog):
    app.state.service.stopping = True
    start, body = asyncio.run(cancelled(app, PATH))[:2]
    answer = httpx.Response(start["status"], headers=start["headers"], content=body["body"])
    assert_problem(answer, 503, "shutting-down")
    assert int(answer.headers["retry-after"]) > 0
    assert answer.headers["x-request-id"]
    assert "Traceback" not in caplog.text


def test_an_answer_that_has_begun_is_cut_off(app, caplog):
    app.state.service.stopping = True
    start, body = asyncio.run(cancelled(app, "/begun"))
    assert (start["status"], body["body"], body["more_body"]) == (200, b"a", True)
    assert "Traceback" not in caplog.text


def test_another_cancellation_is_passed_on(app):
    with pytest.raises(asyncio.CancelledError):
        asyncio.run(cancelled(app, PATH))
    with pytest.raises(asyncio.CancelledError):
        asyncio.run(cancelled(AnswerStopped(app, lambda: False), PATH))
