import re

import pytest

from service.problems import KINDS


def test_every_link_on_the_landing_page_leads_somewhere(server):
    page = server.client.get("/")
    assert page.headers["content-type"].startswith("text/html")
    links = re.findall(r'href="([^"]+)"', page.text)
    assert {"/docs", "/openapi.json", "/v1/gamuts", "/problems"} <= set(links)
    for link in links:
        assert server.client.get(link).status_code == 200


@pytest.mark.parametrize("code", KINDS)
def test_every_problem_has_its_page(server, code):
    page = server.client.get(f"/problems/{code}")
    assert page.status_code == 200
    assert code in page.text
    assert str(KINDS[code].status) in page.text
    assert f'href="/problems/{code}"' in server.client.get("/problems").text


def test_other_pages_are_not_found(server, assert_problem):
    for path in ("/problems/<script>", "/nowhere", "/v1", "/v1/gamuts/"):
        answer = server.client.get(path)
        assert_problem(answer, 404, "not-found")
