import asyncio
import contextlib
import http.server
import json
import threading

import httpx
import pytest

from service.http.cors import ALLOWED_FIELDS, EXPOSED_FIELDS, Cors, origins

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
    assert response.headers["access-control-allow-methods"] == "GET, HEAD, POST, PUT, DELETE"
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


SCRIPT = """
const service = %s, samples = %s;
const told = document.getElementById("told");
async function used() {
  const request = {method: "POST", body: JSON.stringify({samples}),
                   headers: {"Content-Type": "application/json", "X-Request-Id": "a-page"}};
  const posted = await fetch(service + "/v1/gamuts", request);
  const gamut = await posted.json();
  const mesh = await fetch(service + gamut.links.self + "/mesh.ply?triangles=20");
  const removed = await fetch(service + gamut.links.self, {method: "DELETE"});
  return {
    posted: posted.status, location: posted.headers.get("Location"), id: gamut.id,
    request: posted.headers.get("X-Request-Id"), triangles: mesh.headers.get("Gamut-Triangles"),
    etag: mesh.headers.get("ETag"), mesh: (await mesh.text()).slice(0, 3), removed: removed.status,
  };
}
used().then(found => { told.textContent = JSON.stringify(found); },
            error => { told.textContent = JSON.stringify({error: error.name}); });
"""


@contextlib.contextmanager
def origin_of_pages(pages):
    """An origin that serves pages, which may be named later."""

    class Pages(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            text = pages.get(self.path)
            self.send_response(404 if text is None else 200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            self.wfile.write((text or "").encode())

        def log_message(self, *_):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Pages) as opened:
        thread = threading.Thread(target=opened.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{opened.server_port}"
        finally:
            opened.shutdown()
            thread.join()


def test_the_scripts_of_a_listed_origin_can_use_the_service_and_others_cannot(
    start_server, sphere, browser
):
    pages = {}
    with origin_of_pages(pages) as listed, origin_of_pages(pages) as other:
        server = start_server(cors_origins=listed)
        script = SCRIPT % (json.dumps(server.url), json.dumps(sphere(seed=90)))
        pages["/"] = f'<!DOCTYPE html><p id="told"></p><script>{script}</script>'

        def told(origin):
            document = browser(origin).document
            return json.loads(document.partition('<p id="told">')[2].partition("</p>")[0])

        assert told(other) == {"error": "TypeError"}
        found = told(listed)
        server.stop()
    assert (found["posted"], found["removed"]) == (201, 204)
    assert found["location"] == f"/v1/gamuts/{found['id']}"
    assert (found["request"], found["triangles"]) == ("a-page", "20")
    assert found["mesh"] == "ply"
    assert found["etag"].startswith('"')
