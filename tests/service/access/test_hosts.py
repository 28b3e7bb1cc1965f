"""A service without keys on a loopback address answers to its own names and own pages only."""

import asyncio
import functools

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from service.access.api_keys import new_key
from service.application import create_app
from service.settings import Settings

OWN = "127.0.0.1:8000"
ORIGIN = "https://example.org"
GAMUTS = "/v1/gamuts"
KEY = new_key("someone", frozenset({"read", "write"}))


@pytest.fixture(scope="module")
def ask(request_app, tmp_path_factory):
    store = str(tmp_path_factory.mktemp("hosts") / "data")

    @functools.cache
    def app_with(**settings):
        return create_app(Settings(store=store, **settings))

    def send(method="GET", path="/", name=OWN, fields=(), **settings):
        app = app_with(**settings)
        return request_app(app, method, path, headers={"Host": name, **dict(fields)})

    return send


@pytest.mark.parametrize(
    "host",
    ["localhost", "LOCALHOST:1", "127.0.0.1", "127.8.9.10:80", "[::1]", "[::1]:8000"],
)
def test_every_loopback_name_is_its_own(ask, host):
    assert ask(name=host).status_code == 200


@pytest.mark.parametrize(
    "host",
    [
        *("evil.example", "127.0.0.1.evil.example", "localhost.evil.example", "192.0.2.1:8000"),
        *("[2001:db8::1]", "0.0.0.0:8000", "", ":8000"),
    ],
)
def test_another_name_is_refused_for_reading_as_well(ask, assert_problem, host):
    """A page whose name resolves to this machine would otherwise read everything."""
    for method, path in (("GET", "/"), ("GET", GAMUTS), ("POST", GAMUTS), ("GET", "/view")):
        answer = ask(method, path, host, {"X-Forwarded-Host": OWN})
        document = assert_problem(answer, 403, "host-not-allowed")
        assert document["where"] == {"header": "Host"}
        assert "GAMUT_HOSTS" in document["remedy"]


def test_probes_have_any_name(ask):
    for path in ("/livez", "/readyz", "/metrics"):
        assert ask(path=path, name="evil.example").status_code != 403


@pytest.mark.parametrize(
    ("hosts", "host", "status"),
    [
        ("gamut.example", "gamut.example", 200),
        ("gamut.example", "Gamut.Example:8443", 200),
        ("gamut.example:8443", "gamut.example:8443", 200),
        ("gamut.example:8443", "gamut.example", 403),
        ("gamut.example", "other.gamut.example", 403),
        ("a.example, *.example.org", "b.c.example.org:1", 200),
        ("*.example.org", "example.org", 403),
        ("*.example.org:80", "b.example.org:80", 200),
        ("*.example.org:80", "b.example.org", 403),
        ("gamut.example", "localhost:8000", 200),
    ],
)
@pytest.mark.parametrize(
    "settings", [{}, {"host": "192.0.2.1", "api_keys": KEY[1].entry}], ids=["loopback", "public"]
)
def test_configured_names_are_its_own_everywhere(ask, hosts, host, status, settings):
    assert ask(name=host, hosts=hosts, **settings).status_code == status


def test_with_keys_or_on_a_public_address_any_name_is_right(ask):
    for settings in ({"api_keys": KEY[1].entry}, {"host": "192.0.2.1", "allow_anonymous": "all"}):
        assert ask(name="gamut.example", **settings).status_code == 200


@pytest.mark.parametrize("hosts", ["https://gamut.example", "gamut.example/x", "*", "a:b"])
def test_what_is_no_name_is_refused_at_the_start(hosts):
    with pytest.raises(ValidationError, match="is not a host"):
        Settings(hosts=hosts)


@pytest.mark.parametrize(
    "fields",
    [
        {"Origin": ORIGIN},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:9000"},
        {"Origin": "http://localhost:8000"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
    ids=str,
)
def test_pages_of_other_origins_change_nothing(ask, assert_problem, fields):
    name = "a" * 64
    for method, path in (
        ("POST", GAMUTS),
        ("DELETE", f"{GAMUTS}/{name}"),
        ("PUT", f"{GAMUTS}/{name}/name"),
        ("DELETE", f"/v1/jobs/{name}"),
    ):
        document = assert_problem(ask(method, path, fields=fields), 403, "origin-not-allowed")
        assert document["where"]["header"] in fields
        assert "GAMUT_CORS_ORIGINS" in document["remedy"]


@pytest.mark.parametrize(
    ("fields", "settings"),
    [
        ({}, {}),
        ({"Origin": f"http://{OWN}"}, {}),
        ({"Origin": f"http://{OWN}", "Sec-Fetch-Site": "same-origin"}, {}),
        ({"Sec-Fetch-Site": "none"}, {}),
        ({"Origin": ORIGIN}, {"cors_origins": ORIGIN}),
        ({"Origin": ORIGIN, "Sec-Fetch-Site": "cross-site"}, {"cors_origins": "*"}),
        ({"Origin": ORIGIN}, {"api_keys": KEY[1].entry}),
        ({"Origin": ORIGIN}, {"host": "192.0.2.1", "allow_anonymous": "all"}),
    ],
)
def test_programs_own_pages_and_listed_origins_pass(ask, fields, settings):
    fields = {**fields, "X-Api-Key": KEY[0]} if "api_keys" in settings else fields
    assert ask("POST", GAMUTS, fields=fields, **settings).status_code == 415


def test_the_default_port_is_the_same_host(ask):
    fields = {"Origin": "https://gamut.example"}
    for host in ("gamut.example", "gamut.example:443"):
        answer = ask("POST", GAMUTS, host, fields, hosts="gamut.example")
        assert answer.status_code == 415
    answer = ask("POST", GAMUTS, "gamut.example:80", fields, hosts="gamut.example")
    assert answer.status_code == 403


NOT_STORED = f"{GAMUTS}/{'a' * 64}"
COMPUTING = (
    *(("GET", path) for path in (f"{NOT_STORED}/mesh", f"{NOT_STORED}/levels", GAMUTS)),
    *(("POST", f"{NOT_STORED}/{name}") for name in ("contains", "map", "nearest", "recipes")),
    *(("HEAD", f"{NOT_STORED}/mesh"), ("POST", f"{NOT_STORED}/link")),
)


@pytest.mark.parametrize(("method", "path"), COMPUTING)
def test_pages_of_other_origins_compute_nothing(ask, assert_problem, method, path):
    """The media type text/plain needs no preflight, so a browser sends such a request at once."""
    for fields in (
        {"Origin": ORIGIN},
        {"Origin": ORIGIN, "Sec-Fetch-Site": "cross-site"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"},
        {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "iframe"},
    ):
        answer = ask(method, path, fields={"Content-Type": "text/plain", **fields})
        assert answer.status_code == 403
        if method != "HEAD":
            assert_problem(answer, 403, "origin-not-allowed")
    for fields in ({}, {"Origin": f"http://{OWN}"}, {"Sec-Fetch-Site": "same-origin"}):
        assert ask(method, path, fields=fields).status_code != 403
    for origins in (ORIGIN, "*"):
        fields = {"Origin": ORIGIN, "Sec-Fetch-Site": "cross-site"}
        assert ask(method, path, fields=fields, cors_origins=origins).status_code != 403


LINK = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document"}


def test_pages_of_other_origins_may_lead_here(ask, assert_problem):
    assert ask(path="/view", fields={"Origin": ORIGIN}).status_code == 200
    assert ask(path="/view", fields=LINK).status_code == 200
    assert ask(path=NOT_STORED, fields=LINK).status_code != 403
    # Pictures in pages of other programs on this machine, such as a notebook.
    assert ask(path=NOT_STORED, fields={"Sec-Fetch-Site": "same-site"}).status_code != 403
    for fields in (LINK, {"Sec-Fetch-Site": "same-site"}):
        answer = ask(path=f"{GAMUTS}/srgb?surface_samples=3000", fields=fields)
        assert_problem(answer, 403, "origin-not-allowed")


def status_of(app, headers, version="1.1"):
    """The status of an answer to a request with any header fields."""
    sent = []

    async def receive():
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message):
        sent.append(message)

    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": version,
        "method": "GET",
        "scheme": "http",
        "path": "/",
        "raw_path": b"/",
        "query_string": b"",
        "root_path": "",
        "headers": headers,
        "client": ("127.0.0.1", 1),
        "server": ("127.0.0.1", 8000),
    }
    asyncio.run(app(scope, receive, send))
    return sent[0]["status"]


def test_a_missing_or_repeated_host_is_malformed(tmp_path):
    public = {"host": "192.0.2.1", "allow_anonymous": "all"}
    for settings in ({}, public):
        app = create_app(Settings(store=str(tmp_path / "data"), **settings))
        assert status_of(app, []) == 400
        assert status_of(app, [], "1.0") == 200
        assert status_of(app, [(b"host", b"localhost")] * 2) == 400
        assert status_of(app, [(b"host", b"localhost")] * 2, "1.0") == 400
        for host in (b"a b", b"localhost:x", b"localhost/", b"a@localhost", b"[::1", b"\xff"):
            assert status_of(app, [(b"host", host)]) == 400


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    return create_app(Settings(store=str(tmp_path_factory.mktemp("hosts") / "data")))


@given(st.binary(max_size=40), st.binary(max_size=40))
def test_no_field_is_a_defect(app, host, origin):
    assert status_of(app, [(b"host", host), (b"origin", origin)]) in {200, 400, 403}


FORM = (
    b'--x\r\nContent-Disposition: form-data; name="file"; filename="a"\r\n'
    b"Content-Type: text/plain; charset=%s\r\n\r\nabc\r\n"
    b'--x\r\nContent-Disposition: form-data; name="options"\r\n\r\n[]\r\n--x--\r\n'
)
CHARSETS = ["undefined", "punycode", "idna", "hex", "rot13", "unicode_escape", "utf-16", "mbcs"]


@pytest.mark.parametrize("charset", [*CHARSETS, "nonsense", "\xff", "'", "a\\"])
def test_an_odd_charset_is_an_unsupported_media_type(app, request_app, assert_problem, charset):
    for media_type in ("multipart/form-data; boundary=x", "application/json", "text/csv"):
        path = f"{GAMUTS}/{'a' * 64}/contains" if media_type == "text/csv" else GAMUTS
        fields = {
            b"Host": b"localhost",
            b"Content-Type": f"{media_type}; charset={charset}".encode("latin-1"),
        }
        answer = request_app(app, "POST", path, headers=fields, content=FORM % b"utf-8")
        document = assert_problem(answer, 415, "unsupported-media-type")
        assert document["where"] == {"header": "Content-Type"}


@pytest.mark.parametrize("charset", [*CHARSETS, "utf-8"])
def test_the_charset_of_a_part_does_not_matter(app, request_app, assert_problem, charset):
    for stated in ("", "; charset=utf-8", '; charset="US-ASCII"', "; charset=latin-1"):
        fields = {"Host": "localhost", "Content-Type": f"multipart/form-data; boundary=x{stated}"}
        content = FORM % charset.encode()
        answer = request_app(app, "POST", GAMUTS, headers=fields, content=content)
        assert_problem(answer, 422, "invalid-option")


@pytest.mark.parametrize("settings", [{}, {"rate_limit": 1000}], ids=["alone", "with limits"])
def test_pages_of_other_origins_build_nothing_by_reading(ask, assert_problem, settings):
    """The address of a reference gamut with options builds."""
    path = f"{GAMUTS}/srgb?surface_samples=3000"
    answer = ask(path=path, fields={"Origin": ORIGIN}, **settings)
    assert_problem(answer, 403, "origin-not-allowed")
