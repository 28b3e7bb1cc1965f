import asyncio
import re

import httpx
import pytest

from service.http.request_id import HEADER, RequestIds, current_request_id

MADE = re.compile(r"[0-9a-f]{32}\Z")


@pytest.fixture
def answer():
    """Send a request to an app that answers with the id that it sees."""

    async def app(_scope, _receive, send):
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": current_request_id().encode()})

    def send(headers=()):
        async def request():
            transport = httpx.ASGITransport(RequestIds(app))
            async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
                return await client.get("/", headers=list(headers))

        return asyncio.run(request())

    return send


def test_a_request_without_an_id_gets_one(answer):
    first, second = answer(), answer()
    for response in (first, second):
        assert MADE.match(response.headers[HEADER])
        assert response.text == response.headers[HEADER]
    assert first.text != second.text


@pytest.mark.parametrize("name", ["abc", "4f1d:9c07/B2.a~8+e=_@-", "x" * 128])
def test_a_sane_id_is_the_clients(answer, name):
    response = answer([(HEADER, name)])
    assert response.text == response.headers[HEADER] == name


@pytest.mark.parametrize(
    "headers",
    [
        [(HEADER, "")],
        [(HEADER, "x" * 129)],
        [(HEADER, 'a"b')],
        [(HEADER, "a b")],
        [(HEADER, "a"), (HEADER, "b")],
    ],
    ids=["empty", "long", "quote", "space", "twice"],
)
def test_any_other_is_replaced(answer, headers):
    assert MADE.match(answer(headers).text)


def test_outside_of_requests_there_is_none(answer):
    answer()
    assert current_request_id() == ""


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", "/livez"),
        ("HEAD", "/livez"),
        ("GET", "/nowhere"),
        ("PUT", "/livez"),
        ("POST", "/v1/gamuts"),
        ("GET", "/v1/gamuts/%0a"),
    ],
)
def test_every_answer_has_its_id(server, method, path):
    response = server.client.request(method, path, headers={HEADER: "mine"})
    assert response.headers.get_list(HEADER) == ["mine"]


def test_meshes_from_memory_have_it(server, gamut):
    ids = {server.client.get(gamut["links"]["mesh"]).headers[HEADER] for _ in range(3)}
    assert len(ids) == 3
