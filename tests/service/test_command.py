import resource
import socket
import subprocess
import sys

import pytest

from gamutcore.version import __version__
from service.__main__ import main
from service.access.api_keys import ApiKeys
from service.settings import Settings
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs


@pytest.mark.slow
def test_the_document_is_printed(capsys):
    assert main(["openapi"]) == 0
    assert capsys.readouterr().out.startswith('{\n"openapi":"3.1')


def test_the_version_is_printed(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == __version__


@pytest.mark.parametrize("arguments", [["serve", "--port", "0"], ["openapi"], ["store", "list"]])
def test_an_unexpected_error_of_a_command_is_one_line(capsys, monkeypatch, arguments):
    def fail(*_arguments, **_options):
        raise LookupError("a defect")

    for name in ("serve", "openapi_document", "list_store"):
        monkeypatch.setattr(f"service.command.{name}", fail)
    monkeypatch.delenv("GAMUTCORE_TRACEBACK", raising=False)
    assert main(arguments) == 70
    told = capsys.readouterr().err
    assert told.startswith("gamut: unexpected error: LookupError: a defect. ")
    assert told.count("\n") == 1


def test_a_wrong_setting_is_named_and_nothing_is_served(capsys, monkeypatch):
    monkeypatch.setenv("GAMUT_BUILD_WORKERS", "none")
    assert main(["serve"]) == 2
    assert "GAMUT_BUILD_WORKERS" in capsys.readouterr().err


def test_what_looks_like_a_setting_and_is_none_is_named_without_its_value(capsys, monkeypatch):
    monkeypatch.setenv("GAMUT_BUILD_WORKER", "a-value")
    monkeypatch.setenv("GAMUT_BUILD_QUEUE", "7")
    assert main(["serve", "--host", "192.0.2.1"]) == 2
    told = capsys.readouterr().err
    assert "GAMUT_BUILD_WORKER is not a setting and is ignored. Did you mean GAMUT_BUILD_W" in told
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


def test_a_busy_port_is_one_line_before_the_application_starts(capfd, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = str(other.getsockname()[1])
        assert main(["serve", "--port", port, "--store", str(tmp_path / "data")]) == 1
    (line,) = "".join(capfd.readouterr()).splitlines()
    assert port in line
    assert "GAMUT_PORT" in line


@pytest.fixture
def printed(capsys, monkeypatch):
    """A function from arguments and settings to the exit status, the output and the errors."""

    def show(*arguments, **settings):
        with monkeypatch.context() as environment:
            for name, value in settings.items():
                environment.setenv(name, value)
            status = main(["serve", "--print-settings", *arguments])
        return status, *capsys.readouterr()

    return show


class TestPrintSettings:
    def test_shows_every_setting_under_its_source(self, printed, tmp_path):
        path = tmp_path / "not yet there"
        given = {"GAMUT_STORE": str(path), "GAMUT_ACCESS_LOG": "1"}
        status, output, _ = printed("--port", "7001", GAMUT_PORT="7000", **given)
        assert status == 0
        sources, found = {}, None
        for line in output.splitlines():
            if line.startswith("# "):
                found = sources.setdefault(line[2:], {})
            else:
                name, value = line.split("=", 1)
                found[name] = value
        assert sources["command line"] == {"GAMUT_PORT": "7001"}
        assert sources["environment"] == {**given, "GAMUT_ACCESS_LOG": "true"}
        names = {name for group in sources.values() for name in group}
        assert names == {f"GAMUT_{name.upper()}" for name in Settings.model_fields}
        assert not path.exists()

    def test_gives_settings_that_can_be_read_again(self, printed):
        def lines(**settings):
            _, output, _ = printed(**settings)
            return {line for line in output.splitlines() if line[0] != "#"}

        shown = lines(GAMUT_RATE_LIMIT="2.5")
        assert lines(**dict(line.split("=", 1) for line in shown)) == shown

    @pytest.mark.parametrize(
        "broker",
        [
            "redis://:hidden@host:6379/0",
            "rediss://user:hid@hidden/x@host/0",
            "redis://host/0?password=hidden",
        ],
    )
    def test_masks_secrets(self, printed, broker):
        keys = f"press:read:{'a' * 64},office:read+write:{'b' * 64}"
        _, output, _ = printed(GAMUT_BROKER=broker, GAMUT_STORE="s3://b", GAMUT_API_KEYS=keys)
        assert "hidden" not in output
        assert "host" in output
        assert "GAMUT_API_KEYS=press:read:***,office:read+write:***\n" in output

    def test_names_a_wrong_setting(self, printed):
        status, _, told = printed(GAMUT_PORT="no")
        assert status == 2
        assert "GAMUT_PORT" in told


def test_a_server_raises_its_limit_of_open_files_as_far_as_it_goes(server):
    soft, hard = resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE)
    assert soft == hard


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has prlimit")
def test_exhausted_file_descriptors_are_a_problem_to_retry(server, sphere, assert_problem):
    body = {"samples": sphere(seed=31)}
    limits = resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE)
    server.wait_ready()  # The connection is kept: no other one could be opened.
    # No number below the limit is free: those in use begin at 0.
    resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (3, limits[1]))
    try:
        refused = server.client.post("/v1/gamuts", json=body)
    finally:
        resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, limits)
    document = assert_problem(refused, 503, "overloaded")
    assert int(refused.headers["retry-after"]) > 0
    assert document["type"] == "/problems/overloaded"
    assert server.client.post("/v1/gamuts", json=body).status_code == 201
    server.wait_ready()


class TestWorker:
    @pytest.mark.parametrize(
        ("store", "broker", "status", "told"),
        [
            ("s3://bucket", "", 2, "GAMUT_BROKER"),
            ("var/gamuts", "redis://127.0.0.1:1/0", 2, "must be a bucket"),
            ("s3://bucket", "redis://host:port/0", 2, "a host and a port"),
            ("s3://bucket", "redis://:pass/word@host:6379/0", 2, "%2F"),
            ("s3://bucket", "redis://[::1/0", 2, "a host and a port"),
            pytest.param(  # it needs Celery
                *("ftp://host/folder", "redis://127.0.0.1:1/0", 1, "s3://bucket/prefix"),
                marks=pytest.mark.slow,
            ),
        ],
    )
    def test_it_needs_a_broker_and_a_store_that_is_shared(
        self, capsys, monkeypatch, store, broker, status, told
    ):
        monkeypatch.setenv("GAMUT_STORE", store)
        monkeypatch.setenv("GAMUT_BROKER", broker)
        assert main(["worker"]) == status
        assert told in capsys.readouterr().err

    @pytest.mark.slow
    def test_its_check_says_that_the_broker_is_not_there(self, capsys, monkeypatch):
        monkeypatch.setenv("GAMUT_STORE", "s3://bucket")
        monkeypatch.setenv("GAMUT_BROKER", "redis://127.0.0.1:1/0")
        assert main(["worker", "--check"]) == 1
        assert "the broker does not answer" in capsys.readouterr().out


def test_without_the_extra_the_command_says_what_to_install(capsys, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "fastapi" else ...)
    assert main(["serve"]) == 1
    told = capsys.readouterr().err
    assert "fastapi" in told
    assert "gamut-boundary-service[service]" in told


WEB = ("fastapi", "starlette")
BROKER = ("celery", "kombu", "redis")
SOME = ("OpenImageIO", "PIL", "colour", "obstore", "trimesh")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "not_loaded"),
    [
        ("service.building.worker", WEB),
        ("service.application", (*BROKER, *SOME)),
        ("service.command", (*BROKER, *SOME, "scipy.optimize", "scipy.sparse", "scipy.spatial")),
    ],
)
def test_a_process_starts_without_what_only_others_or_some_requests_need(module, not_loaded):
    """Each of these takes memory of every process, and time of every start."""
    code = f"import sys, {module}; sys.exit(sorted({set(not_loaded)} & set(sys.modules)) or None)"
    ended = subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, check=False)
    assert not ended.stderr
