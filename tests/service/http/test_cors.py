"""Pages of listed origins may use the service, and others may not."""

import json

import pytest
from pydantic import ValidationError

from service.application import create_app
from service.settings import Settings

ORIGIN = "https://example.org"
EVIL = "https://evil.example"
PREFLIGHT = {"Origin": ORIGIN, "Access-Control-Request-Method": "DELETE"}


@pytest.fixture(scope="module")
def ask(request_app, tmp_path_factory):
    store = str(tmp_path_factory.mktemp("cors") / "data")

    def send(method="GET", allowed=f"https://other.example:8443, {ORIGIN}", path="/", **fields):
        app = create_app(Settings(store=store, cors_origins=allowed))
        headers = {name.replace("_", "-"): value for name, value in fields.items()}
        return request_app(app, method, path, headers=headers)

    return send


def vary(response):
    return {
        name.strip() for field in response.headers.get_list("vary") for name in field.split(",")
    }


@pytest.mark.parametrize("path", ["/", "/livez", "/nowhere", "/v1/gamuts/x"])
def test_a_listed_origin_may_read_every_answer_without_credentials(ask, path):
    response = ask(path=path, Origin=ORIGIN)
    assert response.headers["access-control-allow-origin"] == ORIGIN
    assert response.headers["timing-allow-origin"] == ORIGIN
    exposed = response.headers["access-control-expose-headers"].split(", ")
    assert {"ETag", "Location", "Gamut-Triangles", "X-Request-Id", "Retry-After"} <= set(exposed)
    assert "access-control-allow-credentials" not in response.headers
    assert "Origin" in vary(response)


@pytest.mark.parametrize("origin", ["https://example.org.evil", "http://example.org", "null", None])
def test_another_origin_may_not_and_caches_are_told(ask, origin):
    response = ask(**({} if origin is None else {"Origin": origin}))
    assert response.status_code == 200
    assert not [name for name in response.headers if name.startswith("access-control-")]
    assert {"Accept", "Origin"} <= vary(response)


def test_where_all_may_the_origin_does_not_matter(ask):
    for fields in ({}, {"Origin": ORIGIN}):
        response = ask(allowed="*", **fields)
        assert response.headers["access-control-allow-origin"] == "*"
        assert "Origin" not in vary(response)


def test_a_preflight_is_answered(ask):
    response = ask("OPTIONS", **PREFLIGHT)
    assert (response.status_code, response.content) == (204, b"")
    assert response.headers["access-control-allow-origin"] == ORIGIN
    assert response.headers["access-control-allow-methods"] == "GET, HEAD, POST, PUT, DELETE"
    allowed = set(response.headers["access-control-allow-headers"].split(", "))
    assert {"Authorization", "X-Api-Key", "If-None-Match", "Prefer", "Content-Type"} <= allowed
    assert int(response.headers["access-control-max-age"]) > 0
    assert vary(response) == {"Origin"}
    refused = ask("OPTIONS", **{**PREFLIGHT, "Origin": EVIL})
    assert refused.status_code == 204
    assert not [name for name in refused.headers if name.startswith("access-control-")]
    # without a method it is no preflight
    assert ask("OPTIONS", Origin=ORIGIN).status_code == 405


def test_what_is_no_origin_is_refused_at_the_start():
    for text in ("example.org", "https://a.example/", "https://A.example", "**"):
        with pytest.raises(ValidationError, match="is not an origin"):
            Settings(cors_origins=text)


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


def test_the_scripts_of_a_listed_origin_can_use_the_service_and_others_cannot(
    small_server, page_origins, sphere, browser
):
    script = SCRIPT % (json.dumps(small_server.url), json.dumps(sphere(seed=90)))
    listed, other = page_origins
    listed.pages["/"] = f'<!DOCTYPE html><p id="told"></p><script>{script}</script>'

    def told(origin):
        document = browser(origin.url).document
        return json.loads(document.partition('<p id="told">')[2].partition("</p>")[0])

    assert told(other) == {"error": "TypeError"}
    found = told(listed)
    assert (found["posted"], found["removed"]) == (201, 204)
    assert found["location"] == f"/v1/gamuts/{found['id']}"
    assert (found["request"], found["triangles"]) == ("a-page", "20")
    assert found["mesh"] == "ply"
    assert found["etag"].startswith('"')
