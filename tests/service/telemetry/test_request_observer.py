"""Every request is seen: counted under its route, logged without what may be secret, traced."""

import asyncio
import json
import logging
import re
import socket
from urllib.parse import urlsplit

import httpx
import pytest

from service.application import create_app
from service.http.protocol import Refusal
from service.settings import Settings
from service.telemetry.logs import JsonLines
from service.telemetry.metrics import RequestFigures
from service.telemetry.request_observer import (
    KNOWN_PARAMETERS,
    UNMATCHED,
    MatchedRoute,
    Refusals,
    RequestObserver,
)


def request(app, figures, *, access_log=False, query=b"", path="/x", **scope):
    """Send a request through the layer, and return the messages that came back."""
    sent = []

    async def send(message):
        sent.append(message)

    layer = RequestObserver(app, figures, access_log=access_log, traces=None)
    whole = {"type": "http", "method": "GET", "path": path, "query_string": query, **scope}
    asyncio.run(layer({"headers": [], "client": ("192.0.2.1", 5), **whole}, None, send))
    return sent


def answer(app, method, path):
    """Return an app's answer to a request."""

    async def asked():
        transport = httpx.ASGITransport(app=app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
            return await client.request(method, path)

    return asyncio.run(asked())


def answering(status=200, body=b"four", route="/v1/{x}"):
    async def app(scope, _receive, send):
        scope["route"] = MatchedRoute(route)
        await send({"type": "http.response.start", "status": status, "headers": []})
        await send({"type": "http.response.body", "body": body})

    return app


@pytest.fixture
def figures():
    return RequestFigures()


@pytest.fixture
def lines(caplog):
    """Return a function to the lines of the access log as JSON has them."""
    caplog.set_level(logging.INFO, logger="service.access")
    return lambda: [json.loads(JsonLines().format(record)) for record in caplog.records]


class TestFigures:
    def test_a_request_is_counted_with_its_route_and_its_bytes(self, figures):
        assert len(request(answering(), figures)) == 2
        assert figures.counts == {("GET", "/v1/{x}", 200): 1}
        assert figures.sent_bytes == 4
        assert figures.in_progress == 0
        assert figures.seconds["/v1/{x}"].cumulative()[-1][1] == 1

    def test_a_defect_is_a_500_and_goes_on(self, figures):
        async def app(_scope, _receive, _send):
            raise ArithmeticError

        with pytest.raises(ArithmeticError):
            request(app, figures)
        assert figures.counts == {("GET", UNMATCHED, 500): 1}
        assert figures.in_progress == 0

    def test_a_client_that_left_is_no_defect(self, figures):
        async def app(_scope, _receive, _send):
            pass

        request(app, figures)
        assert figures.counts == {("GET", UNMATCHED, 499): 1}

    def test_what_is_no_request_passes(self, figures):
        seen = []

        async def app(scope, _receive, _send):
            seen.append(scope["type"])

        asyncio.run(
            RequestObserver(app, figures, access_log=True, traces=None)(
                {"type": "lifespan"}, None, None
            )
        )
        assert seen == ["lifespan"]
        assert figures.counts == {}

    def test_the_time_is_that_until_the_answer_begins(self, figures):
        async def slow(scope, _receive, send):
            await answering()(scope, None, send)
            await asyncio.sleep(0.2)

        request(slow, figures)
        assert figures.seconds["/v1/{x}"].sum < 0.15

    def test_requests_under_way_are_told(self, figures):
        async def app(_scope, _receive, _send):
            assert figures.in_progress == 1

        request(app, figures)


class TestLog:
    def test_a_line_has_all_that_is_known(self, figures, lines):
        request(answering(404, b"no"), figures, access_log=True, query=b"triangles=1000&format=glb")
        (line,) = lines()
        assert line["message"].startswith("GET /x?triangles=1000&format=glb 404, 2 bytes, ")
        assert line["logger"] == "service.access"
        assert (line["method"], line["path"], line["route"]) == ("GET", "/x", "/v1/{x}")
        assert (line["status"], line["bytes"], line["client"]) == (404, 2, "192.0.2.1")
        assert line["milliseconds"] >= 0

    @pytest.mark.parametrize(
        "query",
        [
            b"api_key=hidden-value",
            b"triangles=10&token=hidden-value",
            b"hidden-value",
            b"limit=5&hidden-value=",
            b"triangles=10&X-Amz-Signature=hidden-value&format=glb",
            b"triangles=hidden-value%0a",
        ],
    )
    def test_a_query_that_may_hold_a_secret_is_not_repeated(self, figures, lines, query):
        request(answering(), figures, access_log=True, query=query)
        assert "hidden-value" not in json.dumps(lines())
        assert lines()[0]["query"] == "***"

    def test_the_parameters_that_are_repeated_are_those_of_the_service(self):
        document = create_app(Settings.model_construct()).openapi()
        parameters = {
            parameter["name"]
            for operations in document["paths"].values()
            for operation in operations.values()
            for parameter in operation.get("parameters", [])
            if parameter["in"] == "query"
        }
        assert set(KNOWN_PARAMETERS) == parameters

    def test_header_fields_are_not_repeated(self, figures, lines):
        headers = [(b"authorization", b"Bearer hidden-value"), (b"x-api-key", b"hidden-value")]
        request(answering(), figures, access_log=True, headers=headers)
        assert "hidden-value" not in json.dumps(lines())

    def test_a_path_cannot_make_up_a_line(self, figures, lines):
        path = "/a\n2026 INFO all well\u2028" + "x" * 9999
        request(answering(), figures, access_log=True, path=path)
        (line,) = lines()
        assert line["path"].startswith("/a%0A2026%20INFO")
        assert len(line["path"]) < 600

    def test_there_is_none_unless_asked_for(self, figures, lines):
        request(answering(), figures)
        assert lines() == []


REFUSAL = Refusal("head-too-large", 431, 200, 0.25, "192.0.2.1", "0" * 32)


class TestRefusals:
    def test_they_are_counted_by_their_problem_and_not_as_requests(self, figures, lines):
        seen = Refusals(figures, access_log=False)
        for _ in range(2):
            seen(REFUSAL)
        assert figures.refusals == {"head-too-large": 2}
        assert (figures.counts, figures.sent_bytes, lines()) == ({}, 400, [])

    def test_each_has_a_line(self, figures, lines):
        Refusals(figures, access_log=True)(REFUSAL)
        (line,) = lines()
        assert line["message"] == "- - 431 head-too-large, 200 bytes, 250.0 ms"
        assert (line["status"], line["bytes"], line["problem"]) == (431, 200, "head-too-large")
        assert (line["client"], line["request_id"]) == ("192.0.2.1", "0" * 32)

    def test_a_real_server_tells_them(self, observed_server):
        address = urlsplit(observed_server.url)
        with socket.create_connection((address.hostname, address.port)) as connection:
            connection.sendall(b"GET\r\n\r\n")
            answered = b""
            while part := connection.recv(65536):
                answered += part
        (request_id,) = re.findall(rb"(?i)x-request-id: ([0-9a-f]{32})", answered)
        counted = 'gamut_http_refusals_total{problem="bad-request"} 1.0'
        assert counted in observed_server.client.get("/metrics").text
        records = [json.loads(line) for line in observed_server.log().splitlines()]
        (line,) = [each for each in records if each.get("request_id") == request_id.decode()]
        assert (line["logger"], line["status"]) == ("service.access", 400)


class TestApp:
    """The layer sees what the routes and the other layers answer."""

    @pytest.fixture
    def app(self, tmp_path):
        return create_app(Settings(store=str(tmp_path / "store")))

    @pytest.mark.parametrize(
        ("method", "path", "counted"),
        [
            ("GET", "/livez", ("GET", "/livez", 200)),
            ("HEAD", "/livez", ("HEAD", "/livez", 200)),
            ("GET", "/nowhere/at/all", ("GET", UNMATCHED, 404)),
            ("GET", f"/v1/gamuts/{'0' * 64}/mesh", ("GET", "/v1/gamuts/{gamut_id}/mesh", 404)),
            (
                "GET",
                f"/v1/gamuts/{'0' * 64}/mesh.ply",
                ("GET", "/v1/gamuts/{gamut_id}/mesh.{suffix}", 404),
            ),
            ("GET", "/v1/gamuts/short", ("GET", "/v1/gamuts/{gamut_id}", 422)),
            ("GET", f"/v1/jobs/{'0' * 64}", ("GET", "/v1/jobs/{job_id}", 404)),
            ("PUT", "/v1/gamuts", ("PUT", "/v1/gamuts", 405)),
            ("GET", "/a%00b", ("GET", UNMATCHED, 404)),
            ("GET", "/problems/not-found", ("GET", "/problems/{code}", 200)),
        ],
    )
    def test_a_request_is_counted_under_the_template_of_its_route(self, app, method, path, counted):
        app.state.service.store.open()
        answer(app, method, path)
        assert app.state.service.metrics.requests.counts == {counted: 1}
        app.state.service.store.close()

    def test_the_answer_to_a_defect_is_seen(self, app, monkeypatch):
        monkeypatch.setattr(app.state.service.store, "page", lambda *_: 1 / 0)
        assert answer(app, "GET", "/v1/gamuts").status_code == 500
        assert app.state.service.metrics.requests.counts == {("GET", "/v1/gamuts", 500): 1}
