import os
import resource
import socket
import subprocess
import sys

import pytest

from gamutcore.version import __version__
from service.__main__ import main
from service.access.api_keys import ApiKeys
from service.settings import Settings
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs


@pytest.mark.slow
def test_the_document_is_printed(capsys):
    assert main(["openapi"]) == 0
    assert capsys.readouterr().out.startswith('{\n  "openapi": "3.1')


def test_the_version_is_printed(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == __version__


def test_a_wrong_setting_is_named_and_nothing_is_served(capsys, monkeypatch):
    monkeypatch.setenv("GAMUT_BUILD_WORKERS", "none")
    assert main(["serve"]) == 2
    assert "GAMUT_BUILD_WORKERS" in capsys.readouterr().err


def test_what_looks_like_a_setting_and_is_none_is_named_without_its_value(capsys, monkeypatch):
    monkeypatch.setenv("GAMUT_BUILD_WORKER", "a-value")
    monkeypatch.setenv("GAMUT_BUILD_QUEUE", "7")
    assert main(["serve", "--host", "192.0.2.1"]) == 2
    told = capsys.readouterr().err
    assert "unknown settings are ignored: GAMUT_BUILD_WORKER\n" in told
    assert "a-value" not in told


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1", "gamuts.example.org"])  # noqa: S104
def test_nothing_is_served_to_everybody_unless_that_is_said(capsys, host):
    assert main(["serve", "--host", host]) == 2
    sentence = capsys.readouterr().err
    assert host in sentence
    assert "GAMUT_API_KEYS" in sentence
    assert "GAMUT_ALLOW_ANONYMOUS=all" in sentence


def test_a_key_is_printed_with_what_the_service_has_to_know(capsys):
    assert main(["key", "press-room", "--scopes", "read"]) == 0
    key, entry = (line.split()[-1] for line in capsys.readouterr().out.splitlines())
    known = ApiKeys(entry).find(key.encode())
    assert (known.name, known.scopes) == ("press-room", {"read"})
    assert key not in entry


@pytest.mark.parametrize("arguments", [["Name"], ["a_b"], [""], ["name", "--scopes", "all"]])
def test_a_key_needs_a_plain_name_and_known_scopes(capsys, arguments):
    assert main(["key", *arguments]) == 2
    assert "NAME:SCOPES:SHA256" in capsys.readouterr().err


def test_a_store_in_use_is_named_and_nothing_is_served(capsys, tmp_path):
    store = GamutStore(LocalBlobs(tmp_path))
    store.open()
    assert main(["serve", "--store", str(tmp_path)]) == 1
    assert str(tmp_path) in capsys.readouterr().err
    store.close()


def test_an_unwritable_store_is_named_and_nothing_is_served(capsys, tmp_path):
    (tmp_path / "file").touch()
    assert main(["serve", "--store", str(tmp_path / "file" / "data")]) == 1
    assert str(tmp_path) in capsys.readouterr().err


def gamut(*arguments, **settings):
    """The ended process of a command line with settings."""
    environment = {name: value for name, value in os.environ.items() if name[:6] != "GAMUT_"}
    return subprocess.run(
        [sys.executable, "-m", "service", *arguments],
        env=environment | settings,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )


@pytest.mark.slow
def test_a_busy_port_is_one_line_before_the_application_starts(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = str(other.getsockname()[1])
        ended = gamut("serve", "--port", port, "--store", str(tmp_path / "data"))
    assert ended.returncode == 1
    (line,) = (ended.stdout + ended.stderr).splitlines()
    assert port in line
    assert "GAMUT_PORT" in line


class TestPrintSettings:
    @pytest.mark.slow
    def test_shows_every_setting_under_its_source(self, tmp_path):
        path = tmp_path / "not yet there"
        ended = gamut(
            *("serve", "--port", "7001", "--print-settings"),
            GAMUT_PORT="7000",
            GAMUT_STORE=str(path),
            GAMUT_ACCESS_LOG="1",
        )
        assert ended.returncode == 0, ended.stderr
        sources, found = {}, None
        for line in ended.stdout.splitlines():
            if line.startswith("# "):
                found = sources.setdefault(line[2:], {})
            else:
                name, value = line.split("=", 1)
                found[name] = value
        assert sources["command line"] == {"GAMUT_PORT": "7001"}
        assert sources["environment"] == {"GAMUT_STORE": str(path), "GAMUT_ACCESS_LOG": "true"}
        names = {name for group in sources.values() for name in group}
        assert names == {f"GAMUT_{name.upper()}" for name in Settings.model_fields}
        assert not path.exists()

    @pytest.mark.slow
    def test_gives_settings_that_can_be_read_again(self):
        shown = gamut("serve", "--print-settings", GAMUT_RATE_LIMIT="2.5").stdout
        lines = {line for line in shown.splitlines() if line[0] != "#"}
        again = gamut("serve", "--print-settings", **dict(line.split("=", 1) for line in lines))
        assert {line for line in again.stdout.splitlines() if line[0] != "#"} == lines

    @pytest.mark.parametrize(
        "broker",
        [
            "redis://:hidden@host:6379/0",
            "amqps://user:hid@hidden/x@host//",
            "redis://host/0?password=hidden",
        ],
    )
    @pytest.mark.slow
    def test_masks_secrets(self, broker):
        keys = f"press:read:{'a' * 64},office:read+write:{'b' * 64}"
        ended = gamut(
            *("serve", "--print-settings"),
            GAMUT_BROKER=broker,
            GAMUT_STORE="s3://b",
            GAMUT_API_KEYS=keys,
        )
        assert ended.returncode == 0, ended.stderr
        assert "hidden" not in ended.stdout
        assert "host" in ended.stdout
        assert "GAMUT_API_KEYS=press:read:***,office:read+write:***\n" in ended.stdout

    @pytest.mark.slow
    def test_names_a_wrong_setting(self):
        ended = gamut("serve", "--print-settings", GAMUT_PORT="no")
        assert ended.returncode == 2
        assert "GAMUT_PORT" in ended.stderr


@pytest.mark.slow
def test_the_limit_of_open_files_is_raised_as_far_as_it_goes():
    code = (
        "import resource as r; from service.command import raise_file_limit;"
        "_, hard = r.getrlimit(r.RLIMIT_NOFILE); r.setrlimit(r.RLIMIT_NOFILE, (200, hard));"
        "raise_file_limit(); print(r.getrlimit(r.RLIMIT_NOFILE) == (hard, hard))"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == "True"


def test_a_server_raises_its_limit_of_open_files(server):
    soft, hard = resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE)
    assert soft == hard


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has prlimit")
def test_exhausted_file_descriptors_are_a_problem_to_retry(start_server, sphere, assert_problem):
    server = start_server()
    server.wait_ready()
    body = {"samples": sphere(seed=31)}
    limits = resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE)
    # No number below the limit is free: those in use begin at 0.
    resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (3, limits[1]))
    refused = server.client.post("/v1/gamuts", json=body)
    document = assert_problem(refused, 503, "overloaded")
    assert int(refused.headers["retry-after"]) > 0
    assert document["type"] == "/problems/overloaded"
    resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, limits)
    assert server.client.post("/v1/gamuts", json=body).status_code == 201
    server.kill()


class TestWorker:
    def test_it_needs_a_broker(self, capsys, monkeypatch):
        monkeypatch.setenv("GAMUT_STORE", "s3://bucket")
        assert main(["worker"]) == 2
        assert "GAMUT_BROKER" in capsys.readouterr().err

    def test_it_needs_a_store_that_is_shared(self, capsys, monkeypatch, tmp_path):
        monkeypatch.setenv("GAMUT_STORE", str(tmp_path))
        monkeypatch.setenv("GAMUT_BROKER", "redis://127.0.0.1:1/0")
        assert main(["worker"]) == 2
        assert "must be a bucket" in capsys.readouterr().err

    def test_a_store_of_another_kind_is_told(self, capsys, monkeypatch):
        monkeypatch.setenv("GAMUT_STORE", "ftp://host/folder")
        monkeypatch.setenv("GAMUT_BROKER", "redis://127.0.0.1:1/0")
        assert main(["worker"]) == 1
        assert "s3://bucket/prefix" in capsys.readouterr().err

    def test_its_check_says_that_none_is_running(self, capsys, monkeypatch, tmp_path):
        monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
        assert main(["worker", "--check"]) == 1
        assert "no worker that is connected" in capsys.readouterr().out


def test_without_the_extra_the_command_says_what_to_install(capsys, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "fastapi" else ...)
    assert main(["serve"]) == 1
    told = capsys.readouterr().err
    assert "fastapi" in told
    assert "gamut-boundary-service[service]" in told


WEB = ("fastapi", "starlette")
BROKER = ("celery", "kombu", "redis", "amqp")
SOME = ("OpenImageIO", "PIL", "colour", "manifold3d", "obstore", "prometheus_client", "trimesh")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "not_loaded"),
    [
        ("service.building.worker", WEB),
        ("service.telemetry.logs", WEB),
        ("service.application", (*BROKER, *SOME)),
        ("service.command", (*BROKER, *SOME, "scipy.optimize", "scipy.sparse", "scipy.spatial")),
    ],
)
def test_a_process_starts_without_what_only_others_or_some_requests_need(module, not_loaded):
    """Each of these takes memory of every process, and time of every start."""
    code = f"import sys, {module}; sys.exit(sorted({set(not_loaded)} & set(sys.modules)) or None)"
    ended = subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, check=False)
    assert not ended.stderr
