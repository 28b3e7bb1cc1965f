"""Keys that build only, expire, and change while the service runs; what the log says of them."""

import json
import os
import re
import signal
import socket
import subprocess
import sys

import pytest
import servers

from service.access.api_keys import ApiKeys, KeyFileError, new_key
from service.application import access_rules, create_app
from service.settings import Settings

GAMUTS = "/v1/gamuts"
READER, READER_KNOWN = servers.READER
WRITER, WRITER_KNOWN = servers.WRITER
BUILDERS = [new_key(f"builder-{n}", frozenset({"read", "build"})) for n in range(2)]
EXPIRED = new_key("expired", frozenset({"read"}), "2001-01-01")


class TestEntries:
    def test_an_expiry_is_a_date_or_a_time_in_utc(self):
        for expiry, last in (
            ("2027-01-31", 1_801_353_600),
            ("2027-01-31T12:00Z", 1_801_396_800),
            ("2027-01-31T12:00:30Z", 1_801_396_830),
        ):
            key, known = new_key("name", frozenset({"read"}), expiry)
            found = ApiKeys(known.entry).find(key.encode())
            assert found == known
            assert not found.is_expired(last - 1)
            assert found.is_expired(last)

    @pytest.mark.parametrize(
        "expiry", ["2027-02-30", "tomorrow", "2027", "2027-01-31T12:00", "x:y"]
    )
    def test_others_are_refused(self, expiry):
        with pytest.raises(ValueError, match="expiry"):
            new_key("name", frozenset({"read"}), expiry)
        with pytest.raises(ValueError, match="expiry"):
            ApiKeys(f"{READER_KNOWN.entry}:")

    def test_an_entry_without_expiry_never_expires(self):
        assert READER_KNOWN.entry.count(":") == 2
        assert not ApiKeys(READER_KNOWN.entry).find(READER.encode()).is_expired(1e12)

    def test_a_file_has_an_entry_per_line_and_comments(self, tmp_path):
        path = tmp_path / "keys"
        path.write_text(f"# ours\n\n  {READER_KNOWN.entry}  # the reader\n{BUILDERS[0][1].entry}\n")
        keys = ApiKeys(WRITER_KNOWN.entry, path)
        assert len(keys) == 3
        for key, name in ((READER, "reader"), (WRITER, "writer"), (BUILDERS[0][0], "builder-0")):
            assert keys.find(key.encode()).name == name

    def test_a_fault_is_named_with_its_line_and_changes_nothing(self, tmp_path):
        path = tmp_path / "keys"
        path.write_text(READER_KNOWN.entry)
        keys = ApiKeys("", path)
        for content, fault in (
            (f"#\n{WRITER}", "line 2"),
            (f"{READER_KNOWN.entry}\n{READER_KNOWN.entry}", "two keys"),
            (b"\xff".decode("latin-1"), "line 1"),
        ):
            path.write_text(content)
            with pytest.raises(KeyFileError, match=fault) as error:
                keys.read_file()
            assert WRITER not in str(error.value)
        path.write_bytes(b"\xff")
        with pytest.raises(KeyFileError, match="UTF-8"):
            keys.read_file()
        path.unlink()
        with pytest.raises(KeyFileError, match="No such file"):
            keys.read_file()
        assert keys.find(READER.encode()) == READER_KNOWN

    def test_an_empty_file_lets_nobody_in(self, tmp_path):
        path = tmp_path / "keys"
        path.write_text("")
        rules = access_rules(Settings(api_keys_file=str(path), host="192.0.2.1"))
        assert rules.limiting
        assert rules.anonymous == set()


def test_an_expired_key_is_told_apart(request_app, tmp_path, assert_problem):
    settings = Settings(store=str(tmp_path / "data"), api_keys=EXPIRED[1].entry)
    app = create_app(settings)
    answer = request_app(app, "GET", GAMUTS, headers={"X-Api-Key": EXPIRED[0]})
    document = assert_problem(answer, 401, "api-key-required")
    assert "expired at 2001-01-01" in document["detail"]
    assert 'error="invalid_token"' in answer.headers["www-authenticate"]


@pytest.fixture(scope="module")
def key_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("keys") / "keys"
    path.write_text("\n".join(known.entry for _, known in (*BUILDERS, servers.WRITER)))
    return path


@pytest.fixture(scope="module")
def keyed_server(start_server, key_file):
    started = start_server(api_keys_file=key_file, log_format="json", access_log="true")
    started.wait_ready()
    return started


@pytest.fixture
def ask(keyed_server):
    """Send a request with a key."""

    def send(key, method, path, **arguments):
        headers = {"X-Api-Key": key, **arguments.pop("headers", {})}
        return keyed_server.client.request(method, path, headers=headers, **arguments)

    return send


def test_a_key_to_build_changes_only_what_it_built(ask, sphere, assert_problem):
    (first, _), (second, _) = BUILDERS
    body = {"samples": sphere(seed=900), "name": "Mine"}
    gamut = ask(first, "POST", GAMUTS, json=body)
    assert gamut.status_code == 201, gamut.text
    address = gamut.json()["links"]["self"]
    # The same data of another client is the same gamut, and keeps its owner and its name.
    again = ask(second, "POST", GAMUTS, json={**body, "name": "Theirs"})
    assert again.status_code == 200
    assert again.json()["name"] == "Mine"
    for method, path, content in (
        ("DELETE", address, None),
        ("PUT", f"{address}/name", {"name": "Theirs"}),
        ("DELETE", f"/v1/jobs/{gamut.json()['id']}", None),
    ):
        answer = ask(second, method, path, json=content)
        assert_problem(answer, 403, "built-by-another")
    assert ask(first, "PUT", f"{address}/name", json={"name": "New"}).status_code == 200
    assert ask(WRITER, "PUT", f"{address}/name", json={"name": "Newer"}).status_code == 200
    assert ask(first, "DELETE", address).status_code == 204
    # A deleted gamut has no owner any more: who builds it again is the new one.
    assert ask(second, "POST", GAMUTS, json=body).status_code == 201
    assert_problem(ask(first, "DELETE", address), 403, "built-by-another")
    assert ask(WRITER, "DELETE", address).status_code == 204


def test_what_a_key_to_write_built_is_not_a_builders(ask, sphere, assert_problem):
    body = {"samples": sphere(seed=901)}
    address = ask(WRITER, "POST", GAMUTS, json=body).json()["links"]["self"]
    assert ask(BUILDERS[0][0], "POST", GAMUTS, json=body).status_code == 200
    assert_problem(ask(BUILDERS[0][0], "DELETE", address), 403, "built-by-another")
    assert ask(WRITER, "DELETE", address).status_code == 204


def test_what_does_not_exist_is_nobodys(ask, assert_problem):
    missing = "0" * 64
    assert_problem(ask(BUILDERS[0][0], "DELETE", f"{GAMUTS}/{missing}"), 404, "gamut-not-found")
    assert_problem(ask(BUILDERS[0][0], "DELETE", f"/v1/jobs/{missing}"), 404, "job-not-found")


def test_the_log_names_keys_and_clients_and_holds_no_key(keyed_server, ask):
    key = BUILDERS[0][0]
    marks = [f"/v1/{key}", f"/nowhere?key={key}", f"/nowhere?name={key}"]
    for path in marks:
        ask(key, "GET", path, headers={"X-Request-Id": key})
    ask(key, "HEAD", GAMUTS)
    address = keyed_server.client.base_url
    with socket.create_connection((address.host, address.port), timeout=servers.PATIENCE) as raw:
        raw.sendall(b"nonsense " + key.encode() + b"\r\n\r\n")
        while raw.recv(4096):
            pass
    keyed_server.logged(re.compile("(Invalid HTTP request)"))
    log = keyed_server.log()
    assert "gamut_builder-0_***" in log
    assert key[-43:] not in log
    lines = [json.loads(line) for line in log.splitlines()]
    named = [line for line in lines if line.get("key") == "builder-0"]
    assert {line["method"] for line in named} >= {"GET", "HEAD"}
    assert all(line["client"] == "127.0.0.1" for line in named)
    assert any(" 127.0.0.1 key builder-0" in line["message"] for line in named)


def test_the_file_is_read_again_and_a_broken_one_is_not_used(
    keyed_server, ask, key_file, assert_problem
):
    entries = key_file.read_text()
    assert_problem(ask(READER, "GET", GAMUTS), 401, "api-key-required")

    def reread(content, told):
        key_file.write_text(content)
        seen = keyed_server.log().count(told)
        os.kill(keyed_server.process.pid, signal.SIGHUP)
        keyed_server.logged(re.compile(told), seen + 1)

    reread(f"{entries}\n{READER_KNOWN.entry}\n", "4 API keys read")
    assert ask(READER, "GET", GAMUTS).status_code == 200
    reread(f"{entries}\nbroken\n", "the API keys stay as they are")
    assert ask(READER, "GET", GAMUTS).status_code == 200
    reread(entries, "3 API keys read")
    assert_problem(ask(READER, "GET", GAMUTS), 401, "api-key-required")


@pytest.mark.parametrize(
    ("environment", "told"),
    [
        ({"GAMUT_BUILD_WORKERS": "none"}, "GAMUT_BUILD_WORKERS"),
        ({"GAMUT_HOST": "192.0.2.1"}, "GAMUT_API_KEYS"),
        ({"GAMUT_API_KEYS_FILE": "/nowhere/keys"}, "/nowhere/keys"),
        ({"GAMUT_STORE": "s4://bucket"}, "s3://bucket/prefix"),
        ({"GAMUT_HOST": "192.0.2.1", "GAMUT_ALLOW_ANONYMOUS": "all"}, "192.0.2.1"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
@pytest.mark.slow
def test_the_reasons_of_a_failed_start_are_json(tmp_path, environment, told):
    usual = {name: value for name, value in os.environ.items() if not name.startswith("GAMUT_")}
    settings = {"GAMUT_LOG_FORMAT": "json", "GAMUT_STORE": str(tmp_path / "data"), **environment}
    command = "import sys; from service.__main__ import main; sys.exit(main())"
    ended = subprocess.run(
        [sys.executable, "-c", command, "serve"],
        env={**usual, **settings, "GAMUT_BULD_QUEUE": "1"},
        capture_output=True,
        text=True,
        timeout=servers.PATIENCE,
        check=False,
    )
    assert ended.returncode in {1, 2}
    lines = [json.loads(line) for line in ended.stderr.splitlines()]
    assert told in lines[-1]["message"]
    assert lines[-1]["level"] == "error"
