"""The page of a gamut over HTTP: a download under its name."""

import pytest


@pytest.fixture(scope="module")
def page(server, gamut):
    return server.client.get(f"/v1/gamuts/{gamut['id']}/viewer.html")


def test_it_is_downloaded_under_the_name_of_the_gamut(page, gamut):
    assert page.status_code == 200
    kind, name = page.headers["content-disposition"].split("; ")
    assert kind == "attachment"
    assert name == f'filename="{gamut["name"]}.html"'
    assert page.headers["content-type"] == "text/html; charset=utf-8"
    assert page.headers["x-content-type-options"] == "nosniff"


def test_a_new_name_is_another_page(server, sphere):
    made = server.client.post("/v1/gamuts", json={"samples": sphere(seed=791, count=40)}).json()
    address = f"/v1/gamuts/{made['id']}"
    before = server.client.get(f"{address}/viewer.html")
    name = 'Größe "M" 50/50 <b>'
    assert server.client.put(f"{address}/name", json={"name": name}).status_code < 300
    after = server.client.get(f"{address}/viewer.html")
    assert after.headers["etag"] != before.headers["etag"]
    assert (
        "filename*=UTF-8''Gr%C3%B6%C3%9Fe%20_M_%2050_50%20_b_.html"
        in after.headers["content-disposition"]
    )
    assert b"<b>" not in after.content.split(b"<script type", 1)[0]
