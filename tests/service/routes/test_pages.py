"""The pages over a real connection: every link leads somewhere, and JSON says the same."""

import base64
import hashlib
import html
import json
import re

import pytest

from gamutcore.version import __version__
from service.problems.kinds import KINDS

HTML = {"accept": "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"}
JSON = {"accept": "application/json"}
PAGES = ("/", "/problems", "/problems/not-found")


class TestLanding:
    def test_every_link_leads_somewhere(self, server):
        page = server.client.get("/", headers=HTML)
        assert page.headers["content-type"].startswith("text/html")
        links = set(re.findall(r'href="([^"]+)"', page.text))
        expected = {"/docs", "/openapi.json", "/v1/gamuts", "/problems", "/metrics", "/readyz"}
        assert expected <= links
        for link in links:
            assert server.client.get(link).status_code == 200

    def test_it_tells_the_state_of_the_moment(self, server):
        page = server.client.get("/", headers=HTML)
        assert page.headers["cache-control"] == "no-store"
        assert '<span class="ok">ready</span>' in page.text
        assert "1 of 1 warm" in page.text
        for probe in ("kernels", "workers", "queue", "store", "disk"):
            assert f'<th scope="row">{probe}</th><td><span class="ok">ok</span></td>' in page.text

    def test_it_is_json_for_who_asks_for_it(self, server):
        answer = server.client.get("/", headers=JSON)
        assert answer.headers["content-type"] == "application/json"
        assert answer.headers["vary"] == "Accept"
        document = answer.json()
        assert document["version"] == __version__
        assert document["state"]["ready"] is True
        assert set(document["state"]) == set(server.client.get("/readyz").json())
        for address in document["links"].values():
            assert server.client.get(address).status_code == 200

    def test_its_example_names_this_service(self, server):
        assert f"{server.url}/v1/gamuts" in server.client.get("/", headers=HTML).text


@pytest.mark.parametrize("path", PAGES)
def test_pages_can_neither_run_nor_load_anything(server, path):
    page = server.client.get(path, headers=HTML)
    (style,) = re.findall(r"<style>(.*?)</style>", page.text, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    assert f"'sha256-{digest}'" in page.headers["content-security-policy"]
    assert "default-src 'none'" in page.headers["content-security-policy"]
    assert page.headers["vary"] == "Accept"
    assert re.findall(r'(?:src|href)="(?!/)[^"]*"', page.text) == []


@pytest.mark.parametrize("headers", [HTML, JSON])
@pytest.mark.parametrize("path", ["/problems", "/problems/not-found", "/docs", "/openapi.json"])
def test_what_stays_the_same_is_not_sent_again(server, path, headers):
    first = server.client.get(path, headers=headers)
    assert first.headers["cache-control"] == "no-cache"
    known = {**headers, "If-None-Match": first.headers["etag"]}
    same = server.client.get(path, headers=known)
    assert (same.status_code, same.content) == (304, b"")
    assert same.headers["etag"] == first.headers["etag"]
    other = server.client.get(path, headers={**headers, "If-None-Match": '"x"'})
    assert other.content == first.content


class TestProblems:
    @pytest.mark.parametrize("code", KINDS)
    def test_each_has_its_page_with_what_to_do_and_an_example(self, server, code):
        kind = KINDS[code]
        page = server.client.get(f"/problems/{code}", headers=HTML)
        assert page.status_code == 200
        text = html.unescape(page.text)
        for part in (code, str(kind.status), kind.title, kind.remedy, kind.detail):
            assert part in text
        (example,) = re.findall(r"<pre[^>]*><code>(.*?)</code>", page.text, re.DOTALL)
        document = json.loads(html.unescape(example))
        assert document["type"] == f"/problems/{code}"
        # the same for programs
        answer = server.client.get(f"/problems/{code}", headers=JSON).json()
        assert answer["example"] == document
        assert (answer["status"], answer["remedy"]) == (kind.status, kind.remedy)

    def test_the_index_has_all(self, server):
        page = server.client.get("/problems", headers=HTML).text
        document = server.client.get("/problems", headers=JSON).json()
        assert {kind["code"] for kind in document["problems"]} == set(KINDS)
        for code, kind in KINDS.items():
            assert f'href="/problems/{code}"' in page
            assert html.escape(kind.title) in page

    def test_the_type_of_a_problem_is_the_address_of_its_page(self, server):
        problem = server.client.get("/v1/gamuts/nonsense").json()
        assert server.client.get(problem["type"], headers=JSON).json()["code"] == problem["code"]


def test_other_pages_are_not_found(server, assert_problem):
    for path in ("/problems/<script>", "/nowhere", "/v1", "/v1/gamuts/"):
        answer = server.client.get(path)
        assert_problem(answer, 404, "not-found")


@pytest.mark.parametrize("path", PAGES)
def test_a_browser_shows_every_page_and_complains_of_nothing(server, browser, path):
    page = browser(f"{server.url}{path}")
    assert page.complaints == []
    assert "<h1" in page.document
