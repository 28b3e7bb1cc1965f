import asyncio
import hashlib
import re
from types import SimpleNamespace

import httpx
import pytest
import servers

from service.access.api_keys import ApiKeys, new_key
from service.access.hosts import Hosts, is_loopback
from service.access.middleware import Access, OpenToAllError
from service.access.rate_limits import TokenBuckets
from service.application import access_rules
from service.http.representations import IMMUTABLE
from service.settings import Settings

(READER, READER_KNOWN), (WRITER, WRITER_KNOWN) = servers.READER, servers.WRITER
KEYS = f"{READER_KNOWN.entry},{WRITER_KNOWN.entry}"
GAMUTS = "/v1/gamuts"


async def app(_scope, _receive, send):
    headers = [(b"cache-control", IMMUTABLE.encode()), (b"content-type", b"text/plain")]
    await send({"type": "http.response.start", "status": 200, "headers": headers})
    await send({"type": "http.response.body", "body": b"let in"})


@pytest.fixture
def guarded():
    """A function that sends a request to an app behind the layer with these settings."""

    def guard(**settings):
        hosts = Hosts((), trusting=False, origins=())
        reading = re.compile(r"/v1/gamuts/x/ask\Z")
        layer = Access(app, hosts, access_rules(Settings(**settings)), reading)

        def send(method="GET", path=GAMUTS, address="192.0.2.1", headers=(), **named):
            async def request():
                transport = httpx.ASGITransport(layer, client=(address, 1))
                async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
                    fields = [(name.replace("_", "-"), value) for name, value in named.items()]
                    return await client.request(method, path, headers=[*headers, *fields])

            return asyncio.run(request())

        return send

    return guard


@pytest.fixture
def ask(guarded):
    return guarded(api_keys=KEYS)


def test_a_key_counts_in_header_fields_only(ask, assert_problem):
    assert ask(Authorization=f"Bearer {READER}").text == "let in"
    assert ask(Authorization=f"bearer {READER}").text == "let in"
    assert ask(Authorization="Basic dTpw", X_Api_Key=READER).text == "let in"
    for name in ("key", "api_key", "access_token", "X-Api-Key"):
        assert_problem(ask(path=f"{GAMUTS}?{name}={READER}"), 401, "api-key-required")


def test_without_a_key_or_with_a_wrong_one_nothing_is_told(ask, assert_problem):
    for method in ("GET", "POST", "DELETE"):
        response = ask(method)
        assert_problem(response, 401, "api-key-required")
        assert response.headers["www-authenticate"].startswith('Bearer realm="gamut"')
    response = ask(Authorization=f"Bearer {READER[:-1]}")
    assert_problem(response, 401, "api-key-required")
    assert 'error="invalid_token"' in response.headers["www-authenticate"]
    assert READER[:-1] not in response.text


@pytest.mark.parametrize(
    "second",
    [f"Bearer {READER}", f"Bearer {WRITER}", "Basic eA==", ""],
    ids=["same", "other", "basic", "empty"],
)
def test_two_keys_are_none(ask, assert_problem, second):
    response = ask(headers=[("Authorization", f"Bearer {READER}"), ("authorization", second)])
    document = assert_problem(response, 400, "bad-request")
    assert document["where"] == {"header": "Authorization"}


@pytest.mark.parametrize(
    ("method", "key", "other"),
    [("GET", READER, WRITER), ("POST", WRITER, READER), ("DELETE", WRITER, READER)],
    ids=["read", "build", "delete"],  # keys are new in each process that runs tests
)
def test_scopes_are_kept_apart(ask, assert_problem, method, key, other):
    assert ask(method, X_Api_Key=key).status_code == 200
    response = ask(method, X_Api_Key=other)
    document = assert_problem(response, 403, "scope-missing")
    assert document["where"]["scope"] in response.headers["www-authenticate"]


def test_probes_and_pages_need_no_key(ask):
    for path in ("/", "/livez", "/readyz", "/openapi.json", "/problems", "/problems/not-found"):
        assert ask(path=path).status_code == 200, path
    for path in ("/docs", "/docs/1.0/style.css"):
        assert ask(path=path).status_code == 200, path


def test_what_needs_a_key_is_kept_by_no_shared_cache(ask, guarded):
    assert ask(X_Api_Key=READER).headers["cache-control"] == IMMUTABLE.replace("public", "private")
    public = guarded(api_keys=KEYS, allow_anonymous="read")
    for headers in ({}, {"X_Api_Key": READER}):
        assert public(**headers).headers["cache-control"] == IMMUTABLE


def test_reading_may_be_free_and_writing_not(guarded, assert_problem):
    ask = guarded(api_keys=KEYS, allow_anonymous="read")
    assert ask().status_code == 200
    assert_problem(ask("POST"), 401, "api-key-required")
    assert_problem(ask(X_Api_Key="wrong"), 401, "api-key-required")


class TestWhoIsLetInBySettings:
    def test_nobody_where_there_are_keys(self):
        assert access_rules(Settings(api_keys=KEYS)).anonymous == set()
        assert access_rules(Settings(api_keys=KEYS, host="::")).anonymous == set()

    def test_elsewhere_it_has_to_be_said(self):
        with pytest.raises(OpenToAllError, match=r"198\.51\.100\.7"):
            access_rules(Settings(host="198.51.100.7"))
        rules = access_rules(Settings(host="198.51.100.7", allow_anonymous="all"))
        assert not rules.limiting

    def test_loopback(self):
        for host in ("127.0.0.1", "127.9.9.9", "::1", "[::1]", "localhost"):
            assert is_loopback(host), host
        for host in ("0.0.0.0", "::", "", "10.0.0.1", "localhost.org"):  # noqa: S104
            assert not is_loopback(host), host


class TestWrongKeys:
    """Without a setting, an address has 20 wrong keys at once, and one more each second."""

    @pytest.mark.parametrize(
        "key", ["wrong", READER[:-1], "gamut_nobody_x", ""], ids=["word", "cut", "other", "empty"]
    )
    def test_they_are_limited_by_address(self, ask, assert_problem, key):
        for _ in range(20):
            assert_problem(ask(X_Api_Key=key), 401, "api-key-required")
        answer = ask(X_Api_Key=key)
        assert assert_problem(answer, 429, "rate-limited")["where"] == {"limit": "wrong keys"}
        assert answer.headers["retry-after"] == "1"
        assert_problem(ask(Authorization="Bearer other"), 429, "rate-limited")
        assert ask(X_Api_Key=key, address="192.0.2.2").status_code == 401

    def test_a_valid_key_is_not_affected(self, ask):
        for _ in range(25):
            ask(X_Api_Key="wrong")
        assert ask(X_Api_Key=READER).text == "let in"
        assert ask().status_code == 401

    def test_expired_keys_are_wrong(self, guarded, assert_problem):
        key, entry = new_key("old", frozenset({"read"}), "2020-01-01")
        ask = guarded(api_keys=entry.entry)
        answers = [ask(X_Api_Key=key) for _ in range(21)]
        assert_problem(answers[0], 401, "api-key-required")
        assert_problem(answers[-1], 429, "rate-limited")

    def test_requests_that_read_for_free_are_not_counted(self, guarded):
        ask = guarded(api_keys=KEYS, allow_anonymous="read")
        assert {ask().status_code for _ in range(30)} == {200}


class TestRateLimits:
    def test_beyond_the_burst_it_is_too_often(self, guarded, assert_problem):
        ask = guarded(rate_limit=0.01, rate_burst=2)
        answers = [ask() for _ in range(3)]
        assert [answer.status_code for answer in answers] == [200, 200, 429]
        assert answers[0].headers["ratelimit-policy"] == '"requests";q=2;w=200'
        assert answers[0].headers["ratelimit"] == '"requests";r=1;t=100'
        assert_problem(answers[2], 429, "rate-limited")
        assert 90 <= int(answers[2].headers["retry-after"]) <= 100
        assert answers[2].headers["ratelimit"].startswith('"requests";r=0;')

    def test_each_address_has_its_own(self, guarded):
        ask = guarded(rate_limit=0.01, rate_burst=1)
        assert [ask(address=f"192.0.2.{n}").status_code for n in (1, 2, 1)] == [200, 200, 429]

    @pytest.mark.parametrize(
        ("other", "status"),
        [("2001:db8::ffff", 429), ("2001:db8:0:1::1", 200), ("::ffff:192.0.2.1", 200)],
    )
    def test_a_network_of_ipv6_is_one_address(self, guarded, other, status):
        ask = guarded(rate_limit=0.01, rate_burst=1)
        assert ask(address="2001:db8::1").status_code == 200
        assert ask(address=other).status_code == status

    def test_each_key_has_its_own_wherever_it_comes_from(self, guarded):
        ask = guarded(api_keys=KEYS, rate_limit=0.01, rate_burst=1, allow_anonymous="read")
        assert ask(X_Api_Key=READER, address="192.0.2.1").status_code == 200
        assert ask(X_Api_Key=READER, address="192.0.2.2").status_code == 429
        assert ask(address="192.0.2.1").status_code == 200

    def test_builds_are_counted_besides(self, guarded, assert_problem):
        ask = guarded(rate_limit=100, build_rate_limit=1, build_rate_burst=1)
        first, second = ask("POST"), ask("POST")
        assert first.headers["ratelimit"].count(";r=") == 2
        document = assert_problem(second, 429, "rate-limited")
        assert document["where"] == {"limit": "builds"}
        assert ask().status_code == 200

    def test_probes_are_not_counted(self, guarded):
        ask = guarded(rate_limit=0.01, rate_burst=1)
        assert {ask(path="/livez").status_code for _ in range(5)} == {200}


PROXY, OTHER = "127.0.0.2", "127.0.0.3"
"""Both are this machine."""


@pytest.fixture(scope="module")
def limited(serve_app):
    """An app that trusts one of them; nothing comes back while the tests last."""
    return serve_app(trusted_proxies=PROXY, rate_limit=0.0001, rate_burst=2)


class TestForwarded:
    @pytest.fixture
    def left(self, limited, assert_problem):
        """A function that asks from an address, and says what the client has left, or None."""

        def ask(source, *forwarded):
            fields = [("X-Forwarded-For", value) for value in forwarded]
            transport = httpx.HTTPTransport(local_address=source)
            with httpx.Client(transport=transport, base_url=limited) as client:
                answer = client.get(GAMUTS, headers=fields)
            if answer.status_code != 200:
                assert_problem(answer, 429, "rate-limited")
                return None
            (remaining,) = re.findall(r";r=(\d+)", answer.headers["ratelimit"])
            return int(remaining)

        return ask

    def test_what_a_trusted_proxy_says_is_counted(self, left):
        for client in ("192.0.2.1", "192.0.2.2", "2001:db8:1::1"):
            assert [left(PROXY, client) for _ in range(3)] == [1, 0, None]
        # the rest of a site's network is the same client
        assert left(PROXY, "2001:db8:1::ffff") is None
        assert left(PROXY, "2001:db8:2::1") == 1

    def test_what_clients_say_to_the_proxy_is_not(self, left):
        """Each proxy appends the address that it sees: only the last may be believed."""
        assert left(PROXY, "198.51.100.1, 192.0.2.10") == 1
        assert left(PROXY, "198.51.100.2", "192.0.2.10") == 0
        assert left(PROXY, f"198.51.100.3, 192.0.2.10, {PROXY}") is None

    def test_what_others_say_is_not(self, left):
        answers = [left(OTHER, f"192.0.2.{number}") for number in range(100, 103)]
        assert answers == [1, 0, None]
        assert left(OTHER, PROXY) is None
        # the proxy's clients have not been counted for it
        assert left(PROXY, "192.0.2.100") == 1


def test_by_default_nobody_is_believed(serve_app, assert_problem):
    address = serve_app(rate_limit=0.0001, rate_burst=1)
    answers = [
        httpx.get(f"{address}{GAMUTS}", headers={"X-Forwarded-For": f"192.0.2.{number}"})
        for number in range(2)
    ]
    assert answers[0].status_code == 200
    assert_problem(answers[1], 429, "rate-limited")


def test_a_server_with_keys(guarded_app, assert_problem, caplog):
    client, (reader, writer) = httpx.Client(base_url=guarded_app), (READER, WRITER)
    caplog.set_level("DEBUG", "service")
    assert_problem(client.get(GAMUTS), 401, "api-key-required")
    answer = client.get(GAMUTS, headers={"Authorization": f"Bearer {reader}"})
    assert answer.json() == {"gamuts": [], "next": None}
    assert_problem(client.post(GAMUTS, headers={"X-Api-Key": reader}), 403, "scope-missing")
    assert_problem(
        client.post(GAMUTS, headers={"X-Api-Key": writer}), 415, "unsupported-media-type"
    )
    assert client.get("/livez").status_code == client.head("/livez").status_code == 200
    refused = client.get(GAMUTS, headers={"Origin": "https://example.org"})
    assert refused.headers["access-control-allow-origin"] == "https://example.org"
    assert reader not in caplog.text
    assert writer not in caplog.text
    client.close()


def test_a_post_that_reads_needs_the_scope_of_reading_only(ask, assert_problem):
    path = f"{GAMUTS}/x/ask"
    assert ask("POST", path, X_Api_Key=READER).text == "let in"
    assert_problem(ask("POST", path, X_Api_Key=WRITER), 403, "scope-missing")
    assert_problem(ask("PUT", path, X_Api_Key=READER), 403, "scope-missing")
    assert_problem(ask("POST", f"{path}/x", X_Api_Key=READER), 403, "scope-missing")


def test_a_post_that_reads_does_not_count_as_a_build(guarded):
    send = guarded(build_rate_limit=1, build_rate_burst=1, rate_limit=1, rate_burst=3)
    for _ in range(2):
        answer = send("POST", f"{GAMUTS}/x/ask")
        assert answer.status_code == 200
        assert "builds" not in answer.headers["ratelimit-policy"]
    assert "builds" in send("POST").headers["ratelimit-policy"]


KEY, KNOWN = new_key("ci", frozenset({"read"}))
PRESS_KEY, PRESS = new_key("press", frozenset({"read", "write"}))


def test_the_digest_is_that_of_the_key():
    assert KNOWN.entry == f"ci:read:{hashlib.sha256(KEY.encode()).hexdigest()}"


def test_only_the_key_itself_is_found():
    keys = ApiKeys(f"{KNOWN.entry}, {PRESS.entry}")
    assert keys.find(KEY.encode()) == KNOWN
    assert keys.find(PRESS_KEY.encode()) == PRESS
    secret = KEY.rpartition("_")[2]
    for other in (
        "",
        "gamut_ci_",
        KNOWN.digest,
        KEY[:-1],
        KEY + "A",
        KEY.upper(),
        f"gamut_press_{secret}",
        f"gamut_nobody_{secret}",
        PRESS_KEY.replace("press", "ci"),
        new_key("ci", frozenset({"read"}))[0],
        KEY + "\n",
    ):
        assert keys.find(other.encode()) is None
    assert keys.find(b"\xff" * 60) is None


@pytest.mark.parametrize(
    "text",
    [
        "ci",
        "ci:read",
        "ci:read:" + "0" * 63,
        "ci:read:" + "G" * 64,
        "ci::" + "0" * 64,
        "ci:admin:" + "0" * 64,
        "CI:read:" + "0" * 64,
        f"ci:read:{'0' * 64},ci:write:{'1' * 64}",
    ],
)
def test_malformed_entries_are_refused(text):
    with pytest.raises(ValueError, match=r"NAME:SCOPES:SHA256|the name ci"):
        ApiKeys(text)


def test_a_pasted_key_is_not_repeated_in_the_message():
    with pytest.raises(ValueError, match="entry 1") as caught:
        ApiKeys(KEY)
    assert KEY[-20:] not in str(caught.value)


@pytest.fixture
def clock():
    return SimpleNamespace(now=0.0)


@pytest.fixture
def buckets(clock):
    return TokenBuckets(2.0, 3, lambda: clock.now)


def test_tokens_come_back_at_the_rate_and_asking_too_early_costs_none(buckets, clock):
    assert [buckets.take("a").granted for _ in range(5)] == [True] * 3 + [False] * 2
    for step in range(50):
        clock.now = step / 100
        refused = buckets.take("a")
        assert not refused.granted
        assert refused.seconds == pytest.approx(0.5 - clock.now)
    clock.now = 0.5
    assert buckets.take("a").granted
    clock.now = 100.0
    assert [buckets.take("a").granted for _ in range(4)] == [True] * 3 + [False]


def test_any_number_of_clients_takes_a_bounded_memory(buckets):
    for number in range(60_000):
        buckets.take(str(number))
    assert len(buckets) == 50_000
    assert buckets.take("59999").remaining == 1
