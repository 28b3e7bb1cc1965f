"""Every request is seen: counted under its route, logged without what may be secret, traced."""

import asyncio
import json
import logging
import re
from types import SimpleNamespace

import pytest

from service.application import create_app
from service.http import request_context
from service.http.request_context import timed
from service.settings import Settings
from service.telemetry import request_observer
from service.telemetry.logs import JsonLines
from service.telemetry.metrics import Metrics
from service.telemetry.request_observer import (
    KNOWN_PARAMETERS,
    UNMATCHED,
    MatchedRoute,
    RequestObserver,
)


def answers(metrics):
    """Return the number of answers by method, route and status."""
    family = next(each for each in metrics.registry.collect() if each.name == "gamut_http_requests")
    return {
        (each.labels["method"], each.labels["route"], int(each.labels["status"])): each.value
        for each in family.samples
    }


def request(app, metrics, *, access_log=False, query=b"", path="/x", **scope):
    """Send a request through the layer, and return the messages that came back."""
    sent = []

    async def send(message):
        sent.append(message)

    layer = RequestObserver(app, metrics.requests, access_log=access_log)
    whole = {"type": "http", "method": "GET", "path": path, "query_string": query, **scope}
    asyncio.run(layer({"headers": [], "client": ("192.0.2.1", 5), **whole}, None, send))
    return sent


def answering(status=200, body=b"four", route="/v1/{x}"):
    async def app(scope, _receive, send):
        scope["route"] = MatchedRoute(route)
        await send({"type": "http.response.start", "status": status, "headers": []})
        await send({"type": "http.response.body", "body": body})

    return app


@pytest.fixture
def metrics():
    return Metrics()


@pytest.fixture
def lines(caplog):
    """Return a function to the lines of the access log as JSON has them."""
    caplog.set_level(logging.INFO, logger="service.access")
    return lambda: [json.loads(JsonLines().format(record)) for record in caplog.records]


class TestFigures:
    def test_a_defect_is_a_500_and_goes_on(self, metrics):
        async def app(_scope, _receive, _send):
            raise ArithmeticError

        with pytest.raises(ArithmeticError):
            request(app, metrics)
        assert answers(metrics) == {("GET", UNMATCHED, 500): 1}
        assert metrics.registry.get_sample_value("gamut_http_requests_in_progress") == 0

    def test_what_is_no_request_passes(self, metrics):
        seen = []

        async def app(scope, _receive, _send):
            seen.append(scope["type"])

        layer = RequestObserver(app, metrics.requests, access_log=True)
        asyncio.run(layer({"type": "lifespan"}, None, None))
        assert seen == ["lifespan"]
        assert answers(metrics) == {}

    def test_a_client_that_left_is_no_defect(self, metrics, lines):
        async def app(_scope, _receive, _send):
            pass

        request(app, metrics)
        assert answers(metrics) == {("GET", UNMATCHED, 499): 1}
        assert lines() == []  # unless it is asked for

    def test_the_time_is_that_until_the_answer_begins(self, metrics, monkeypatch):
        clock = SimpleNamespace(now=0.0)
        monkeypatch.setattr(request_observer, "perf_counter", lambda: clock.now)

        async def slow(scope, _receive, send):
            clock.now += 0.125
            await answering()(scope, None, send)
            clock.now += 100

        request(slow, metrics)
        labels = {"route": "/v1/{x}"}
        value = metrics.registry.get_sample_value("gamut_http_response_seconds_sum", labels)
        assert value == 0.125


class TestLog:
    def test_a_line_has_all_that_is_known(self, metrics, lines):
        request(answering(404, b"no"), metrics, access_log=True, query=b"triangles=1000&format=glb")
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
    def test_a_query_that_may_hold_a_secret_is_not_repeated(self, metrics, lines, query):
        request(answering(), metrics, access_log=True, query=query)
        assert "hidden-value" not in json.dumps(lines())
        assert lines()[0]["query"] == "***"

    def test_the_parameters_that_are_repeated_are_those_of_the_service(self):
        document = create_app(Settings.model_construct()).openapi()
        parameters = [
            *document["components"]["parameters"].values(),
            *(
                parameter
                for operations in document["paths"].values()
                for operation in operations.values()
                for parameter in operation.get("parameters", [])
            ),
        ]
        names = {each["name"] for each in parameters if each.get("in") == "query"}
        assert set(KNOWN_PARAMETERS) == names

    def test_a_path_cannot_make_up_a_line(self, metrics, lines):
        path = "/a\n2026 INFO all well\u2028" + "x" * 9999
        request(answering(), metrics, access_log=True, path=path)
        (line,) = lines()
        assert line["path"].startswith("/a%0A2026%20INFO")
        assert len(line["path"]) < 600


class TestApp:
    """The layer sees what the routes and the other layers answer."""

    @pytest.fixture
    def app(self, tmp_path):
        return create_app(Settings(store=str(tmp_path / "store")))

    @pytest.mark.parametrize(
        ("method", "path", "counted"),
        [
            ("HEAD", "/livez", ("HEAD", "/livez", 200)),
            ("GET", "/a%00b", ("GET", UNMATCHED, 404)),
            ("GET", f"/v1/gamuts/{'0' * 64}/mesh", ("GET", "/v1/gamuts/{gamut_id}/mesh", 404)),
            ("GET", "/v1/gamuts/short", ("GET", "/v1/gamuts/{gamut_id}", 422)),
            ("PUT", "/v1/gamuts", ("PUT", "/v1/gamuts", 405)),
            ("GET", "/problems/not-found", ("GET", "/problems/{code}", 200)),
        ],
    )
    def test_a_request_is_counted_under_the_template_of_its_route(
        self, app, request_app, method, path, counted
    ):
        app.state.service.store.open()
        request_app(app, method, path)
        assert answers(app.state.service.metrics) == {counted: 1}
        app.state.service.store.close()

    def test_the_answer_to_a_defect_is_seen(self, app, request_app, monkeypatch):
        monkeypatch.setattr(app.state.service.store, "page", lambda *_: 1 / 0)
        assert request_app(app, "GET", "/v1/gamuts").status_code == 500
        assert answers(app.state.service.metrics) == {("GET", "/v1/gamuts", 500): 1}


METRIC = re.compile(r"([a-z]+);dur=([0-9.]+)")


def times(response):
    return {name: float(value) for name, value in METRIC.findall(response.headers["server-timing"])}


@pytest.fixture
def clock(monkeypatch):
    made = SimpleNamespace(now=0.0)
    monkeypatch.setattr(request_context, "time", SimpleNamespace(perf_counter=lambda: made.now))
    monkeypatch.setattr(request_observer, "perf_counter", lambda: made.now)
    return made


def test_parts_of_one_name_add_up_and_the_total_holds_them(clock, metrics, request_app):
    async def part():
        with timed("part"):
            clock.now += 0.008

    async def work(scope, _receive, send):
        for _ in range(2):
            with timed("encode"):
                clock.now += 0.016
        with timed("open"):
            clock.now += 0.032
        await asyncio.create_task(part())  # belongs to who began it
        await answering()(scope, None, send)

    expected = {"total": 72, "encode": 32, "open": 32, "part": 8}
    layer = RequestObserver(work, metrics.requests, access_log=False)
    assert times(request_app(layer, "GET", "/")) == expected


def test_meshes_tell_what_they_cost(server, gamut):
    path = gamut["links"]["mesh"] + "?triangles=222"
    first, second = server.client.get(path), server.client.get(path)
    assert "encode" in times(first)
    assert list(times(second)) == ["total"]
