"""The log: one line per event in either form, with ids, and never a secret."""

import json
import logging
import re
import subprocess
import sys

import pytest

from service.http.request_context import RequestContext, current_request
from service.telemetry.logs import JsonLines, TextLines, without_secrets

GAMUT = "4f1d9c07b2a85e63" * 4
SECRET = "s3cr3t-Value_42"  # noqa: S105 - of nothing


def record(message, *arguments, exception=None, **extra):
    made = logging.LogRecord(
        "service.builds", logging.WARNING, __file__, 1, message, arguments, exception
    )
    vars(made).update(extra)
    return made


def raised(message):
    try:
        raise ValueError(message)  # noqa: TRY301 - only to be caught
    except ValueError:
        return sys.exc_info()


def parsed(made):
    line = JsonLines().format(made)
    assert "\n" not in line
    return json.loads(line)


class TestJson:
    def test_a_line_says_when_how_severe_where_and_what(self):
        members = parsed(record("%d builds were given up", 3))
        assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z", members.pop("time"))
        assert members == {
            "level": "warning",
            "logger": "service.builds",
            "message": "3 builds were given up",
        }

    def test_it_names_the_gamut_and_the_request(self):
        token = current_request.set(RequestContext("request-7"))
        try:
            members = parsed(record("build of %s started, attempt %d", GAMUT, 1))
        finally:
            current_request.reset(token)
        assert members["gamut_id"] == GAMUT
        assert members["request_id"] == "request-7"

    def test_what_is_given_besides_is_there(self):
        members = parsed(record("GET", status=200, seconds=0.5, request_id="own", color_message=""))
        assert (members["status"], members["seconds"], members["request_id"]) == (200, 0.5, "own")
        assert "color_message" not in members

    def test_an_exception_and_a_stack_are_one_member_of_the_line(self):
        members = parsed(record("failed", exception=raised("because"), stack_info="Stack: here"))
        assert members["exception"].startswith("Traceback")
        assert members["exception"].endswith("ValueError: because\nStack: here")

    @pytest.mark.parametrize("value", ["\ud800", "a\nb\u2028c", "\x1b[31m", "größer 🎨"])
    def test_any_text_is_a_line_that_json_reads(self, value):
        assert parsed(record("%s", value))["message"] == value

    def test_a_value_within_itself_is_a_line(self):
        loop = {"token": SECRET}
        loop["again"] = [loop, {(1, 2): "x"}]
        members = parsed(record("x", of=loop))
        assert SECRET not in json.dumps(members)
        assert "***" in json.dumps(members)

    def test_what_json_does_not_know_is_shown(self):
        assert parsed(record("x", of=[{1}, {"a": 1j}]))["of"] == ["{1}", {"a": "1j"}]


class TestText:
    def test_a_line_is_for_people(self):
        line = TextLines().format(record("it is %s", "late", request_id="r1"))
        assert line.endswith(" WARNING service.builds: it is late [r1]")

    def test_nobody_can_make_up_a_line(self):
        line = TextLines().format(record("no such path: %s", "/x\n2026-01-01 INFO root: all well"))
        assert len(line.splitlines()) == 1
        assert "\\n2026" in line

    def test_an_exception_follows_on_its_own_lines(self):
        lines = TextLines().format(record("failed", exception=raised("because"))).splitlines()
        assert lines[1].startswith("Traceback")
        assert lines[-1] == "ValueError: because"


@pytest.mark.parametrize(
    "text",
    [
        f"Authorization: Bearer {SECRET}",
        f"authorization: {SECRET}",
        f"{{'authorization': 'Basic {SECRET}'}}",
        f"[(b'authorization', b'Bearer {SECRET}'), (b'host', b'x')]",
        f"(b'x-api-key', b'{SECRET}')",
        f"X-API-Key: {SECRET}",
        f"GET /v1/gamuts?api_key={SECRET}&limit=3",
        f"GET /v1/gamuts?limit=3&access_token={SECRET}",
        f"?X-Amz-Signature={SECRET}&X-Amz-Credential={SECRET}",
        f"?sv=2024&sig={SECRET}",
        f'{{"password": "{SECRET}"}}',
        f"AWS_SECRET_ACCESS_KEY={SECRET}",
        f"azure_storage_account_key={SECRET}",
        f"Cannot connect to redis://:{SECRET}@broker:6379/0",
        f"Cannot connect to rediss://gamut:{SECRET}@broker:6379/0",
        f"refused Bearer {SECRET}",
        f"Cookie: {SECRET}",
    ],
)
def test_no_secret_is_logged_wherever_it_is(text):
    assert SECRET not in without_secrets(text)
    assert without_secrets(text).count("***") >= 1
    for lines in (JsonLines(), TextLines()):
        for made in (
            record("%s", text),
            record("x", exception=raised(text)),
            record("x", detail=text),
            record("x", detail=[text]),
        ):
            assert SECRET not in lines.format(made)


@pytest.mark.parametrize(
    "text",
    [
        f"build of {GAMUT} started, attempt 1",
        "Uvicorn running on http://127.0.0.1:8000 (Press CTRL+C to quit)",
        "GET /v1/gamuts?limit=10&after=0a 200",
        "the signature of a profile is 'acsp'",
        "basic colours: 11",
    ],
)
def test_what_is_no_secret_stays(text):
    assert without_secrets(text) == text


EVENTS = """
import logging, sys, threading, warnings
from service.telemetry.logs import configure_logging

configure_logging(sys.argv[1], "info")
logging.getLogger("uvicorn.error").info("from uvicorn")
logging.getLogger("service").debug("too little")
warnings.warn("from a library")
for target in (lambda: 1 / 0, sys.exit):
    thread = threading.Thread(target=target)
    thread.start()
    thread.join()
raise ValueError("at last")
"""


@pytest.mark.parametrize("log_format", ["text", "json"])
def test_a_process_logs_everything_through_one_handler(log_format):
    # a process of its own, because levels, filters and hooks are those of the whole process
    ended = subprocess.run(
        [sys.executable, "-W", "default", "-c", EVENTS, log_format],
        check=False,
        capture_output=True,
        text=True,
    )
    assert (ended.returncode, ended.stdout) == (1, "")
    told = ended.stderr
    for message in ("from uvicorn", "from a library", "ZeroDivisionError", "ValueError: at last"):
        assert message in told
    assert "too little" not in told
    if log_format == "json":
        lines = [json.loads(line) for line in told.splitlines()]
        assert [line["level"] for line in lines] == ["info", "warning", "critical", "critical"]


def test_a_server_s_whole_log_is_json_with_ids_and_without_secrets(observed_server, sphere):
    server = observed_server
    body = {"samples": sphere(seed=41)}
    built = server.client.post("/v1/gamuts", json=body, headers={"x-request-id": "built-here"})
    mesh = f"{built.json()['links']['mesh']}?triangles=100"
    credentials = {"authorization": f"Bearer {SECRET}", "x-api-key": SECRET, "cookie": SECRET}
    for headers in ({}, {"x-request-id": "second"}, credentials):
        assert server.client.get(mesh, headers=headers).status_code == 200
    server.client.get(f"{mesh}&api_key={SECRET}", headers=credentials)
    server.client.get(f"/nowhere?token={SECRET}", headers=credentials)
    server.client.head("/livez", headers={"x-request-id": "the-last"})
    server.wait_for(lambda: "the-last" in server.log())

    log = server.log()
    assert SECRET not in log
    lines = [json.loads(line) for line in log.splitlines()]
    for line in lines:
        assert {"time", "level", "logger", "message"} <= set(line)
    assert {"uvicorn.error", "service.access"} <= {line["logger"] for line in lines}
    assert any("Application startup complete" in line["message"] for line in lines)
    about = [line for line in lines if line.get("gamut_id") == built.json()["id"]]
    assert any("started" in line["message"] for line in about)

    access = [line for line in lines if line["logger"] == "service.access"]
    posted = next(line for line in access if line["request_id"] == "built-here")
    assert (posted["method"], posted["route"], posted["status"]) == ("POST", "/v1/gamuts", 201)
    # those that are answered ahead of the routes as well
    meshes = [line for line in access if line["path"] == mesh.partition("?")[0]]
    assert {line["route"] for line in meshes} == {"/v1/gamuts/{gamut_id}/mesh"}
    assert [line["status"] for line in meshes] == [200, 200, 200, 422]
    assert meshes[1]["request_id"] == "second"
    assert {line["gamut_id"] for line in meshes} == {built.json()["id"]}
    assert meshes[0]["query"] == "triangles=100"
    assert meshes[3]["query"] == "***"
    lost = next(line for line in access if line["path"] == "/nowhere")
    assert (lost["route"], lost["status"], lost["query"]) == ("unmatched", 404, "***")
    assert [line["status"] for line in access if line["method"] == "HEAD"] == [200]


@pytest.mark.slow
def test_a_worker_process_logs_in_the_same_form(monkeypatch):
    monkeypatch.setenv("GAMUT_LOG_FORMAT", "json")
    code = (
        "from service.building import worker; worker.compile_kernels = lambda: None; worker.main()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert json.loads(process.stdout.readline())["event"] == "ready"
        request = {
            "id": "0" * 64,
            "input": "/nowhere/input",
            "output": "/nowhere/output",
            "options": {},
        }
        process.stdin.write(json.dumps({**request, "memory": 0}) + "\n")
        process.stdin.flush()
        assert json.loads(process.stdout.readline())["event"] == "failed"
        process.stdin.close()
        lines = [json.loads(line) for line in process.stderr]
    assert "/nowhere/input" in lines[0]["message"]
    assert lines[0]["level"] == "error"
