import asyncio

import httpx
import pytest
from fastapi import FastAPI, Request

from service.http.middleware import BodyLimit, HeadAsGet
from service.problems.handlers import add_exception_handlers


@pytest.fixture
def call():
    """Send a request to a small app with both layers."""
    app = FastAPI()
    app.state.routes = app.router.routes
    add_exception_handlers(app)
    app.add_middleware(BodyLimit, limit=100)
    app.add_middleware(HeadAsGet)

    @app.post("/length")
    async def length(request: Request) -> int:
        return len(await request.body())

    @app.get("/text")
    async def text() -> str:
        return "text"

    def send(method, path, **arguments):
        async def request():
            transport = httpx.ASGITransport(app)
            async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
                return await client.request(method, path, **arguments)

        return asyncio.run(request())

    return send


async def chunks(count, size):
    for _ in range(count):
        yield bytes(size)


def test_bodies_up_to_the_limit_pass(call):
    assert call("POST", "/length", content=bytes(100)).json() == 100
    assert call("POST", "/length", content=chunks(10, 10)).json() == 100


@pytest.mark.parametrize(
    "content", [bytes(101), lambda: chunks(11, 10)], ids=["declared", "chunked"]
)
def test_larger_bodies_are_a_problem(call, assert_problem, content):
    response = call("POST", "/length", content=content() if callable(content) else content)
    document = assert_problem(response, 413, "body-too-large")
    assert document["where"] == {"limit": 100}


def test_a_declared_length_is_refused_wherever_it_goes(call, assert_problem):
    assert_problem(call("POST", "/nowhere", content=bytes(101)), 413, "body-too-large")


def test_head_is_get_without_the_content(call):
    head, get = call("HEAD", "/text"), call("GET", "/text")
    assert head.status_code == get.status_code == 200
    assert head.headers == get.headers
    assert head.content == b""


def test_head_is_not_allowed_where_get_is_not(call):
    response = call("HEAD", "/length")
    assert response.status_code == 405
    assert response.headers["allow"] == "POST"


@pytest.mark.parametrize("character", ["%0a", "%00", "%0d", "%1f", "%7f"])
@pytest.mark.parametrize(
    "path", ["/", "/livez", "/v1/gamuts", f"/v1/gamuts/{'0' * 64}/mesh", "/problems"]
)
def test_there_is_nothing_at_paths_with_control_characters(server, assert_problem, path, character):
    assert_problem(server.client.get(path + character), 404, "not-found")
