"""Links over HTTP: the files of the package, caching, refusals."""

import json
from pathlib import Path

import numpy as np
import pytest

from gamutcore import Gamut, link, reference

PRESS = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"
COARSE = {"surface_samples": 2000}


@pytest.fixture(scope="module")
def press(server):
    """The id of a press, and the same gamut built here."""
    answer = server.client.post(
        "/v1/gamuts",
        files={"file": PRESS.read_bytes()},
        data={"options": json.dumps(COARSE)},
    )
    assert answer.status_code in {200, 201}, answer.text
    return answer.json()["id"], Gamut(PRESS, **COARSE)


def ask(server, headers=None, **query):
    return server.client.get("/v1/links", params=query | COARSE, headers=headers or {})


def test_a_link_between_slugs_is_the_file_of_the_package(server):
    answer = ask(server, source="display-p3", destination="srgb", method="clip-hue", size=5)
    assert answer.status_code == 200, answer.text
    sides = (reference(name, **COARSE) for name in ("display-p3", "srgb"))
    expected = link(*sides, method="clip-hue", size=5)
    assert answer.content == expected.to_bytes("cube")
    assert answer.headers["gamut-link-error"] == str(expected.errors)
    assert answer.headers["content-type"] == "text/plain; charset=us-ascii"
    assert 'filename="display-p3-to-srgb.cube"' in answer.headers["content-disposition"]
    known = {"If-None-Match": answer.headers["etag"]}
    again = ask(server, known, source="display-p3", destination="srgb", method="clip-hue", size=5)
    assert (again.status_code, again.content) == (304, b"")


def test_a_separation_for_a_press_is_a_device_link(server, press):
    name, here = press
    chosen = {"method": "clip-nearest", "size": 5, "black": "maximum"}
    answer = ask(server, source="srgb", destination=name, **chosen)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/vnd.iccprofile"
    assert answer.content[12:24] == b"linkRGB CMYK"
    expected = link(reference("srgb", **COARSE), here, **chosen)
    nodes = np.round(65535 * expected.table.nodes).astype(">u2").tobytes()
    start = answer.content.index(b"mft2") + 52 + 3 * 4  # the head and the curves of three inputs
    table = np.frombuffer(answer.content[start:][: len(nodes)], ">u2").astype(int)
    assert np.abs(table - np.frombuffer(nodes, ">u2").astype(int)).max() <= 1


@pytest.mark.parametrize(
    ("query", "status", "code"),
    [
        ({}, 422, "invalid-parameter"),
        ({"source": "srgb"}, 422, "invalid-parameter"),
        ({"source": "srgb", "destination": "unknown"}, 422, "invalid-parameter"),
        ({"source": "srgb", "destination": "srgb", "size": 1}, 422, "invalid-parameter"),
        ({"source": "srgb", "destination": "srgb", "size": 66}, 422, "invalid-option"),
        ({"source": "srgb", "destination": "srgb", "sise": 5}, 422, "invalid-parameter"),
        ({"source": "srgb", "destination": "srgb", "black": "much"}, 422, "invalid-option"),
        ({"source": "srgb", "destination": "srgb", "format": "3dl"}, 422, "invalid-parameter"),
    ],
)
def test_refusals(server, query, status, code):
    answer = ask(server, **query)
    assert (answer.status_code, answer.json()["code"]) == (status, code)


def test_gamuts_without_a_model_and_formats_that_do_not_fit(server, cubes, press, assert_problem):
    colours = cubes[0].rpartition("/")[2]
    answer = ask(server, source="srgb", destination=colours, size=3)
    assert_problem(answer, 422, "no-device-model")
    answer = ask(
        server, source="srgb", destination=press[0], size=3, method="clip-hue", format="cube"
    )
    assert_problem(answer, 422, "invalid-option")
