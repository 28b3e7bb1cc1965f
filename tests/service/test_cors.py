import asyncio

import httpx
import pytest

from service.cors import ALLOWED_FIELDS, EXPOSED_FIELDS, Cors, origins

ORIGIN = "https://example.org"
PREFLIGHT = {"Origin": ORIGIN, "Access-Control-Request-Method": "DELETE"}


async def app(_scope, _receive, send):
    headers = [(b"vary", b"Accept"), (b"etag", b'"x"')]
    await send({"type": "http.response.start", "status": 200, "headers": headers})
    await send({"type": "http.response.body", "body": b"content"})


@pytest.fixture
def ask():
    def send(method="GET", allowed=(ORIGIN, "https://other.example"), **fields):
        async def request():
            transport = httpx.ASGITransport(Cors(app, allowed))
            async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
                headers = {name.replace("_", "-"): value for name, value in fields.items()}
                return await client.request(method, "/", headers=headers)

        return asyncio.run(request())

    return send


def test_a_listed_origin_may_read(ask):
    response = ask(Origin=ORIGIN)
    assert response.text == "content"
    assert response.headers["access-control-allow-origin"] == ORIGIN
    assert response.headers["timing-allow-origin"] == ORIGIN
    exposed = response.headers["access-control-expose-headers"].split(", ")
    assert set(exposed) == set(EXPOSED_FIELDS)
    assert {"ETag", "Location", "Gamut-Triangles", "X-Request-Id"} <= set(exposed)


def test_no_credentials_are_allowed(ask):
    assert "access-control-allow-credentials" not in ask(Origin=ORIGIN).headers


@pytest.mark.parametrize("origin", ["https://example.org.evil", "http://example.org", "null"])
def test_another_origin_may_not(ask, origin):
    response = ask(Origin=origin)
    assert response.text == "content"
    assert "access-control-allow-origin" not in response.headers


@pytest.mark.parametrize("fields", [{}, {"Origin": ORIGIN}, {"Origin": "https://evil.example"}])
def test_caches_are_told_that_the_origin_matters(ask, fields):
    assert ask(**fields).headers.get_list("vary") == ["Accept", "Origin"]


def test_where_all_may_the_origin_does_not_matter(ask):
    for fields in ({}, {"Origin": ORIGIN}):
        response = ask(allowed=["*"], **fields)
        assert response.headers["access-control-allow-origin"] == "*"
        assert response.headers.get_list("vary") == ["Accept"]


def test_a_preflight_is_answered(ask):
    response = ask("OPTIONS", **PREFLIGHT)
    assert (response.status_code, response.content) == (204, b"")
    assert response.headers["access-control-allow-origin"] == ORIGIN
    assert response.headers["access-control-allow-methods"] == "GET, HEAD, POST, DELETE"
    allowed = response.headers["access-control-allow-headers"].split(", ")
    assert set(allowed) == set(ALLOWED_FIELDS)
    assert {"Authorization", "X-Api-Key", "If-None-Match", "Prefer", "Content-Type"} <= set(allowed)
    assert int(response.headers["access-control-max-age"]) > 0
    assert response.headers["vary"] == "Origin"


def test_a_preflight_of_another_origin_grants_nothing(ask):
    response = ask("OPTIONS", **{**PREFLIGHT, "Origin": "https://evil.example"})
    assert response.status_code == 204
    assert not [name for name in response.headers if name.startswith("access-control-")]


def test_other_options_are_the_apps(ask):
    assert ask("OPTIONS", Origin=ORIGIN).text == "content"


def test_origins_are_separated_by_commas_or_spaces():
    found = origins(" https://a.example:8443, http://localhost:3000 null")
    assert found == ("https://a.example:8443", "http://localhost:3000", "null")
    assert origins("") == ()


@pytest.mark.parametrize("text", ["example.org", "https://a.example/", "https://A.example", "**"])
def test_what_is_no_origin_is_refused(text):
    with pytest.raises(ValueError, match="is not an origin"):
        origins(text)
