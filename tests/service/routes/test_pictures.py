"""Pictures over HTTP: options, caching, limits."""

import io

import pytest
from PIL import Image

from gamutcore.export.rendering import VIEWS


def image(answer):
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "image/png"
    return Image.open(io.BytesIO(answer.content))


@pytest.fixture
def address(gamut):
    return f"{gamut['links']['self']}/picture.png"


def test_a_picture_is_immutable(server, gamut, address):
    answer = server.client.get(address)
    assert image(answer).size == (800, 800)
    assert answer.headers["cache-control"] == "public, max-age=31536000, immutable"
    assert answer.headers["gamut-triangles"] == str(min(20_000, gamut["counts"]["triangles"]))
    again = server.client.get(address)
    assert again.content == answer.content
    assert again.headers["etag"] == answer.headers["etag"]
    known = {"If-None-Match": answer.headers["etag"]}
    assert server.client.get(address, headers=known).status_code == 304
    assert server.client.get(address, headers={"If-Match": '"other"'}).status_code == 412


@pytest.mark.parametrize("view", [*VIEWS, "120,-30"])
def test_views_and_options(server, address, view):
    query = {
        "size": 64,
        "view": view,
        "background": "transparent",
        "triangles": 20,
        "axes": "false",
    }
    answer = server.client.get(address, params=query)
    shown = image(answer)
    assert shown.size == (64, 64)
    assert shown.mode == "RGBA"
    assert answer.headers["gamut-triangles"] == "20"
    assert server.client.get(address, params={**query, "axes": "true"}).content != answer.content


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("size=2049", "size"),
        ("size=15", "size"),
        ("size=100.5", "size"),
        ("view=side", "view"),
        ("view=1,2,3", "view"),
        ("view=nan,0", "view"),
        ("background=black", "background"),
        ("axes=1", "axes"),
        ("triangles=100001", "triangles"),
        ("format=png", "format"),
        ("size=64&size=65", "size"),
        ("max_error=2&triangles=100", "triangles"),
    ],
)
def test_other_values_are_refused(server, assert_problem, address, query, field):
    answer = server.client.get(f"{address}?{query}")
    assert assert_problem(answer, 422, "invalid-parameter")["where"]["field"] == field


def test_what_has_no_picture(server, assert_problem, gamut, address):
    answer = server.client.get(address, params={"view": "0,91"})
    assert assert_problem(answer, 422, "invalid-option")["where"] == {"field": "view"}
    answer = server.client.get(address, params={"triangles": gamut["counts"]["triangles"] + 2})
    assert_problem(answer, 422, "triangle-count")
    answer = server.client.get(f"/v1/gamuts/{'0' * 64}/picture.png")
    assert_problem(answer, 404, "gamut-not-found")


def test_an_error_limit_gives_the_picture_of_its_level(server, gamut, address):
    """The level is that of the mesh with this limit."""
    mesh = server.client.get(f"{gamut['links']['self']}/mesh", params={"max_error": 2})
    limited = server.client.get(address, params={"size": 64, "max_error": 2})
    count = limited.headers["gamut-triangles"]
    assert count == mesh.headers["gamut-triangles"] != str(gamut["counts"]["triangles"])
    counted = server.client.get(address, params={"size": 64, "triangles": count})
    assert counted.content == limited.content


def test_the_background_beside_a_slug_is_that_of_the_picture(server, assert_problem):
    """The option `background` of the appearance models has the same name."""
    address = "/v1/gamuts/srgb/picture.png"
    query = {"size": 32, "axes": "false", "surface_samples": 1000}
    clear = image(server.client.get(address, params={**query, "background": "transparent"}))
    assert clear.getpixel((0, 0))[3] == 0
    white = image(server.client.get(address, params={**query, "background": "white"}))
    assert white.convert("RGBA").getpixel((0, 0)) == (255, 255, 255, 255)
    answer = server.client.get(address, params={**query, "background": "black"})
    problem = assert_problem(answer, 422, "invalid-parameter")
    assert "transparent" in problem["remedy"]
