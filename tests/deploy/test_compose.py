"""The compose file as Docker Compose resolves it, without an engine."""

import concurrent.futures
import contextlib
import http.server
import ipaddress
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import httpx
import pytest

from service.problems.kinds import KINDS
from service.problems.problem import Problem
from service.routes.jobs import LONGEST_WAIT
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


@pytest.mark.slow
def test_replicas_know_the_clients_of_the_proxy():
    """The network has a fixed subnet, whose members the replicas trust."""
    answer = compose({**PASSWORDS, "GAMUT_SUBNET": "10.9.8.0/24"})
    assert answer.returncode == 0, answer.stderr
    document = json.loads(answer.stdout)
    (pool,) = document["networks"]["default"]["ipam"]["config"]
    assert pool["subnet"] == "10.9.8.0/24"
    trusted = document["services"]["api"]["environment"]["GAMUT_TRUSTED_PROXIES"]
    assert ipaddress.ip_network(trusted) == ipaddress.ip_network(pool["subnet"])


PASSED_ON = {
    "GAMUT_HOSTS": "gamut.example.org",
    "GAMUT_CORS_ORIGINS": "https://example.org",
    "GAMUT_RATE_LIMIT": "7",
    "GAMUT_RATE_BURST": "8",
    "GAMUT_BUILD_RATE_LIMIT": "9",
    "GAMUT_BUILD_RATE_BURST": "10",
    "GAMUT_API_KEYS": "someone:read:" + "0" * 64,
    "GAMUT_ALLOW_ANONYMOUS": "read",
    "GAMUT_MEMORY_BYTES": "1073741824",
}


def test_settings_of_access_are_passed_on(services, tmp_path, monkeypatch):
    keys = tmp_path / "keys"
    answer = compose({**PASSWORDS, **PASSED_ON, "GAMUT_API_KEYS_FILE": str(keys)})
    assert answer.returncode == 0, answer.stderr
    document = json.loads(answer.stdout)
    environment = document["services"]["api"]["environment"]
    assert PASSED_ON.items() <= environment.items()
    assert document["secrets"]["api-keys"]["file"] == str(keys)
    (secret,) = document["services"]["api"]["secrets"]
    inside = secret.get("target") or secret["source"]
    assert environment["GAMUT_API_KEYS_FILE"] == f"/run/secrets/{Path(inside).name}"
    # Without variables, the service starts with the same values as without compose.
    for name, value in services["api"]["environment"].items():
        if name in PASSED_ON or name == "GAMUT_API_KEYS_FILE":
            monkeypatch.setenv(name, value)
    settings, defaults = Settings(), Settings.model_construct()
    for name in ("hosts", "cors_origins", "rate_limit", "rate_burst", "api_keys_file"):
        assert getattr(settings, name) == getattr(defaults, name)


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


def test_the_service_waits_for_its_bucket(services):
    for name in ("api", "worker"):
        after = services[name]["depends_on"]["store-bucket"]["condition"]
        assert after == "service_completed_successfully"


def test_the_proxy_waits_longer_than_a_client_may():
    wait = int(re.findall(r"timeout server (\d+)s", (FILE.parent / "haproxy.cfg").read_text())[0])
    assert wait > LONGEST_WAIT


class Replica(http.server.BaseHTTPRequestHandler):
    """A replica that answers, is unable to, or ends connections without an answer."""

    protocol_version = "HTTP/1.1"
    how = "answers"
    asked: list[str]
    forwarded: list[list[str]]
    released: threading.Event

    def do(self):
        self.rfile.read(int(self.headers.get("Content-Length") or 0))
        ready = self.path == "/readyz"
        if not ready:
            self.asked.append(f"{self.command} {self.path}")
        if self.how == "ends" and not ready:
            self.close_connection = True
            return
        if not ready:
            self.forwarded.append(self.headers.get_all("X-Forwarded-For"))
        if self.how == "waits" and not ready:
            self.released.wait(30)
        self.send_response(503 if self.how == "is unable" and not ready else 200)
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
            lists = {"asked": [], "forwarded": [], "released": threading.Event()}
            handler = type("Replica", (Replica,), lists)
            server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
            server.daemon_threads = True
            stack.callback(server.server_close)
            stack.callback(server.shutdown)
            threading.Thread(target=server.serve_forever, daemon=True).start()
            found[server.server_port] = handler
        yield found


@pytest.fixture
def proxy(replicas, tmp_path, request):
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
            ["haproxy", "-f", configuration],
            env={**os.environ, "GAMUT_FRONT_PROXIES": getattr(request, "param", "")},
            stdout=stdout,
            stderr=subprocess.STDOUT,
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
def test_a_refusal_of_a_replica_is_the_answer(proxy, replicas):
    """Another replica would refuse it as well, after another wait in its queue."""
    client, _ = proxy
    for replica in replicas.values():
        replica.how = "is unable"
    assert client.get("/read").status_code == 503
    assert sum(len(replica.asked) for replica in replicas.values()) == 1


def refused(answer):
    """Whether an answer refuses a connection, with the problem of the service."""
    if answer.status_code == 429:
        document = answer.json()
        assert (document["code"], document["where"]) == ("rate-limited", {"limit": "connections"})
        assert int(answer.headers["retry-after"]) > 0
    return answer.status_code == 429


@pytest.mark.slow
def test_a_client_has_ten_connections(proxy):
    first, _ = proxy
    with contextlib.ExitStack() as stack:
        clients = [stack.enter_context(httpx.Client(base_url=first.base_url)) for _ in range(12)]
        answers = [client.get("/read") for client in clients]
        assert [refused(answer) for answer in answers] == [False] * 10 + [True] * 2
        assert answers[-1].headers["connection"] == "close"
        assert not refused(clients[0].get("/read"))  # excess connections cost others nothing


@pytest.mark.slow
@pytest.mark.parametrize("proxy", ["192.0.2.9 127.0.0.0/8"], indirect=True)
def test_clients_of_a_proxy_in_front_have_ten_requests_under_way(proxy, replicas):
    """The last address is stated by the proxy; a client may have made up the others."""
    client, _ = proxy
    for replica in replicas.values():
        replica.how = "waits"

    def ask(address):
        fields = {"X-Forwarded-For": f"203.0.113.1, {address}"}
        return httpx.get(f"{client.base_url}/read", headers=fields, timeout=60)

    with concurrent.futures.ThreadPoolExecutor(16) as threads:
        waiting = [threads.submit(ask, "198.51.100.7") for _ in range(10)]
        while sum(len(replica.asked) for replica in replicas.values()) < 10:
            time.sleep(0.01)
        assert refused(ask("198.51.100.7"))
        other = threads.submit(ask, "198.51.100.8")
        for replica in replicas.values():
            replica.released.set()
        assert not any(refused(answer.result()) for answer in [*waiting, other])
    stated = [fields[-1] for replica in replicas.values() for fields in replica.forwarded]
    assert sorted(stated) == ["198.51.100.7"] * 10 + ["198.51.100.8"]


@pytest.mark.slow
def test_a_read_that_a_replica_does_not_answer_is_sent_to_another(proxy, replicas):
    client, log = proxy
    first, second = replicas.values()
    first.how = "ends"
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
