"""The compose file as Docker Compose resolves it, without an engine."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

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


@pytest.mark.skipif(shutil.which("haproxy") is None, reason="HAProxy is not there to read it")
def test_the_proxy_reads_its_configuration():
    answer = subprocess.run(
        ["haproxy", "-c", "-f", FILE.parent / "haproxy.cfg"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
