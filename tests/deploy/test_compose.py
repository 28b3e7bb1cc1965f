"""The compose file as Docker Compose resolves it, without an engine."""

import contextlib
import http.server
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import threading
from pathlib import Path

import httpx
import pytest

from service.problems.kinds import KINDS
from service.problems.problem import Problem
from service.settings import Settings
from tests.conftest import missing

ROOT = Path(__file__).parents[2]
FILE = ROOT / "deploy" / "compose.yaml"
PASSWORDS = {"REDIS_PASSWORD": "r", "STORE_ACCESS_KEY": "a", "STORE_SECRET_KEY": "s"}


def compose(variables):
    """Resolve the file in an environment that has only these variables."""
    found = shutil.which("docker-compose", path=str(Path(sys.executable).parent))
    if found is None:
        missing("docker-compose is not installed: make lint installs it")
    return subprocess.run(
        [found, "-f", FILE, "--env-file", "/dev/null", "config", "--format", "json"],
        env={"PATH": os.environ["PATH"], **variables},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="module")
def services():
    answer = compose(PASSWORDS)
    assert answer.returncode == 0, answer.stderr
    return json.loads(answer.stdout)["services"]


@pytest.mark.parametrize("name", PASSWORDS)
@pytest.mark.slow
def test_a_password_that_is_not_set_is_named(name):
    answer = compose({other: value for other, value in PASSWORDS.items() if other != name})
    assert answer.returncode != 0
    assert name in answer.stderr


def test_the_example_of_an_environment_names_what_the_file_reads():
    example = (FILE.parent / "compose.env.example").read_text()
    named = set(re.findall(r"^#?([A-Z_]+)=", example, re.MULTILINE))
    assert named == set(re.findall(r"\$\{([A-Z_]+)", FILE.read_text()))
    needed = set(re.findall(r"^([A-Z_]+)=$", example, re.MULTILINE))
    assert needed == set(PASSWORDS)


def test_there_are_two_of_either_and_one_broker_and_store_for_all(services):
    for name in ("api", "worker"):
        assert services[name]["deploy"]["replicas"] == 2
        assert services[name]["environment"]["GAMUT_STORE"].startswith("s3://")
        assert services[name]["environment"]["GAMUT_BROKER"] == "redis://:r@redis:6379/0"


def test_nothing_but_the_proxy_is_published_and_that_on_loopback(services):
    published = {name: each["ports"] for name, each in services.items() if each.get("ports")}
    assert set(published) == {"proxy"}
    assert {port["host_ip"] for port in published["proxy"]} == {"127.0.0.1"}


def test_prometheus_in_the_network_reaches_the_figures_of_either(services):
    worker = services["worker"]
    port = worker["environment"]["GAMUT_WORKER_METRICS_PORT"]
    for name, exposed in (("api", services["api"]["environment"]["GAMUT_PORT"]), ("worker", port)):
        assert services[name]["expose"] == [exposed]
        assert services[name]["environment"]["GAMUT_HOST"] == "0.0.0.0"  # noqa: S104
    assert int(port) > 0


def test_what_lasts_is_checked_limited_and_without_rights(services):
    for name, each in services.items():
        assert "no-new-privileges:true" in each.get("security_opt", []) or name == "store-bucket"
        if each.get("restart") == "no":
            continue
        assert each["healthcheck"]["test"], name
        assert int(each["mem_limit"]) > 0, name
    for name in ("api", "worker", "proxy", "redis"):
        assert services[name]["read_only"] is True
        assert services[name]["cap_drop"] == ["ALL"]


def test_the_service_waits_for_a_store_that_was_checked(services):
    check = services["store-check"]
    assert check["command"] == ["gamut", "store", "check", "s3://gamuts"]
    for name in ("api", "worker"):
        after = services[name]["depends_on"]["store-check"]["condition"]
        assert after == "service_completed_successfully"


def test_the_proxy_waits_longer_than_a_client_may():
    wait = int(re.findall(r"timeout server (\d+)s", (FILE.parent / "haproxy.cfg").read_text())[0])
    assert wait > Settings().max_client_wait


class Replica(http.server.BaseHTTPRequestHandler):
    """A replica that answers, is unable to, or ends connections without an answer."""

    protocol_version = "HTTP/1.1"
    how = "answers"
    asked: list[str]

    def do(self):
        self.rfile.read(int(self.headers.get("Content-Length") or 0))
        ready = self.path == "/readyz"
        if not ready:
            self.asked.append(f"{self.command} {self.path}")
        if self.how == "ends" and not ready:
            self.close_connection = True
            return
        self.send_response(200 if ready or self.how == "answers" else 503)
        self.send_header("Content-Length", "0")
        self.end_headers()

    do_GET = do_POST = do  # noqa: N815 - the names it calls

    def log_message(self, *_):
        """Say nothing."""


@pytest.fixture
def replicas():
    """Two replicas: their classes by port."""
    found = {}
    with contextlib.ExitStack() as stack:
        for _ in range(2):
            handler = type("Replica", (Replica,), {"asked": []})
            server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
            server.daemon_threads = True
            stack.callback(server.server_close)
            stack.callback(server.shutdown)
            threading.Thread(target=server.serve_forever, daemon=True).start()
            found[server.server_port] = handler
        yield found


@pytest.fixture
def proxy(replicas, tmp_path):
    """HAProxy with the configuration, in front of the replicas: a client, and the log."""
    if shutil.which("haproxy") is None:
        missing("HAProxy is not installed")
    with socket.create_server(("127.0.0.1", 0)) as unused:
        port = unused.getsockname()[1]
    text = (FILE.parent / "haproxy.cfg").read_text()
    template = "server-template api 10 api:8000 resolvers engine init-addr none"
    assert template in text
    servers = [f"server api{number} 127.0.0.1:{number} check" for number in replicas]
    text = text.replace(template, "\n    ".join(servers))
    text = text.replace("bind :8000", f"bind 127.0.0.1:{port}")
    configuration, log = tmp_path / "haproxy.cfg", tmp_path / "log"
    configuration.write_text(text)
    with (
        log.open("wb") as stdout,
        subprocess.Popen(
            ["haproxy", "-f", configuration], stdout=stdout, stderr=subprocess.STDOUT
        ) as process,
    ):
        try:
            with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=600) as client:
                while True:
                    with contextlib.suppress(httpx.ConnectError):
                        # a connection that has answered may be ended without an answer
                        client.get("/readyz", headers={"Connection": "close"})
                        break
                    with contextlib.suppress(subprocess.TimeoutExpired):
                        process.wait(0.1)
                        pytest.fail(log.read_text())
                yield client, log
        finally:
            process.terminate()


@pytest.mark.slow
@pytest.mark.parametrize("how", ["ends", "is unable"])
def test_a_read_that_a_replica_does_not_answer_is_sent_to_another(proxy, replicas, how):
    client, log = proxy
    first, second = replicas.values()
    first.how = how
    for number in range(4):
        assert client.get(f"/read/{number}").status_code == 200
    assert any(line.startswith("GET /read") for line in first.asked)
    assert len(second.asked) == 4
    assert "GET /read/0" in log.read_text()
    assert " 200 " in log.read_text()


@pytest.mark.slow
def test_a_build_is_sent_once(proxy, replicas):
    client, _ = proxy
    for replica in replicas.values():
        replica.how = "ends"
    answer = client.post("/v1/gamuts", content=b"x")
    assert answer.status_code == 502
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json() == Problem("bad-gateway", KINDS["bad-gateway"].detail).document()
    assert sum(len(replica.asked) for replica in replicas.values()) == 1


def test_errors_of_the_proxy_are_problems_of_the_service():
    text = (FILE.parent / "haproxy.cfg").read_text()
    documents = re.findall(r"http-error status (\d+) .* string '(.*)' hdr", text)
    assert {int(status) for status, _ in documents} >= {400, 408, 500, 502, 503, 504}
    for status, document in documents:
        problem = json.loads(document)
        assert problem["status"] == int(status)
        assert problem == Problem(problem["code"], problem["detail"]).document()


def test_the_proxy_reads_its_configuration():
    if shutil.which("haproxy") is None:
        missing("HAProxy is not installed")
    answer = subprocess.run(
        ["haproxy", "-c", "-f", FILE.parent / "haproxy.cfg"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
