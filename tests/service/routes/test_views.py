"""Views over HTTP, for all entries of the table."""

import io

import numpy as np
import pytest

from service.queries.bodies import CSV, JSON, NPY
from service.queries.views import COMPARISON, VIEWS

IMMUTABLE = "public, max-age=31536000, immutable"


@pytest.fixture(scope="module")
def addresses(server, gamut, sphere):
    """The address of every view, with its parameters."""
    other = server.client.post("/v1/gamuts", json={"samples": sphere(seed=2, radius=30.0)}).json()
    own = gamut["links"]["self"]
    return {
        **{name: f"{own}/{name}?triangles=100" for name in VIEWS},
        "slice": f"{own}/slice?lightness=50&triangles=100",
        "leaves": f"{own}/leaves?hues=12&lightness=21&triangles=100",
        COMPARISON.name: f"/v1/comparisons?a={gamut['id']}&b={other['id']}&triangles=100",
    }


NAMES = [*VIEWS, COMPARISON.name]


@pytest.mark.parametrize("name", NAMES)
def test_answers_are_immutable_and_conditional(server, addresses, name):
    answer = server.client.get(addresses[name])
    assert answer.status_code == 200, answer.text
    assert answer.headers["cache-control"] == IMMUTABLE
    assert answer.headers["gamut-triangles"].startswith("100")
    assert server.client.get(addresses[name]).content == answer.content
    known = {"If-None-Match": answer.headers["etag"]}
    assert server.client.get(addresses[name], headers=known).status_code == 304
    packed = server.client.get(addresses[name], headers={"Accept-Encoding": "gzip"})
    assert packed.json() == answer.json()
    if "content-encoding" in packed.headers:
        assert packed.headers["etag"] != answer.headers["etag"]


@pytest.mark.parametrize("name", NAMES)
def test_all_forms_have_the_same_table(server, addresses, name):
    document = server.client.get(addresses[name]).json()
    array = np.load(io.BytesIO(server.client.get(addresses[name], headers={"Accept": NPY}).content))
    text = server.client.get(addresses[name], headers={"Accept": CSV}).text
    lines = [line.split(",") for line in text.splitlines()]
    assert len(lines) == len(array) + 1
    numbers = np.array([[float(cell or "nan") for cell in line] for line in lines[1:]])
    flat = np.concatenate([array[each].reshape(len(array), -1) for each in array.dtype.names], 1)
    assert np.array_equal(numbers, flat, equal_nan=True)
    columns = document.get("sectors", document)
    for each in array.dtype.names:
        if each in columns and len(columns[each]) == len(array):
            assert columns[each] == array[each].tolist()


def test_cusps_of_a_sphere(server, gamut):
    answer = server.client.get(f"{gamut['links']['self']}/cusps?hues=12&max_error=0").json()
    assert len(answer["hue"]) == 12
    # chords of a sphere of radius 40
    assert all(33 < chroma <= 40 for chroma in answer["chroma"])
    assert answer["channels"] == []
    assert "device" not in answer


def test_a_sphere_inside_another(server, addresses):
    answer = server.client.get(addresses["comparisons"]).json()
    assert answer["b_covers_a"] == pytest.approx((30 / 40) ** 3, rel=0.1)
    assert answer["a_covers_b"] == pytest.approx(1, abs=1e-6)
    assert answer["levels"]["a"]["triangles"] == 100


@pytest.mark.parametrize(
    ("query", "code", "field"),
    [
        ("hues=0", "invalid-parameter", "hues"),
        ("hues=1e2", "invalid-parameter", "hues"),
        ("triangles=3", "invalid-parameter", "triangles"),
        ("triangles=20&max_error=1", "invalid-parameter", "triangles"),
        ("hue=3", "invalid-parameter", "hue"),
        ("triangles=99999998", "triangle-count", "triangles"),
    ],
)
def test_faults_are_problems(server, gamut, assert_problem, query, code, field):
    answer = server.client.get(f"{gamut['links']['self']}/cusps?{query}")
    assert assert_problem(answer, 422, code)["where"]["field"] == field


def test_comparisons_need_two_gamuts_in_one_space(server, gamut, sphere, assert_problem):
    own = gamut["id"]
    for query in (f"a={own}", f"a={own}&a={own}&b={own}", f"a={own}&b=nothing"):
        answer = server.client.get(f"/v1/comparisons?{query}")
        assert assert_problem(answer, 422, "invalid-parameter")["where"]["in"] == "query"
    missing = server.client.get(f"/v1/comparisons?a={own}&b={'0' * 64}")
    assert_problem(missing, 404, "gamut-not-found")
    body = {"samples": sphere(seed=2), "options": {"space": "CIELUV"}}
    other = server.client.post("/v1/gamuts", json=body).json()["id"]
    answer = server.client.get(f"/v1/comparisons?a={own}&b={other}")
    assert_problem(answer, 422, "invalid-option")


def test_rings_are_compared_with_a_reference(server, gamut, assert_problem):
    own = gamut["links"]["self"]
    query = "reference=srgb&surface_samples=2000&triangles=100"
    answer = server.client.get(f"{own}/rings?{query}&sectors=12").json()
    assert answer["reference_level"]["triangles"] == 100
    assert len(answer["reference_radius"][0]) == 12
    few, many = (server.client.get(f"{own}/rings.svg?{query}&sectors={n}") for n in (4, 72))
    assert few.headers["content-type"] == many.headers["content-type"] == "image/svg+xml"
    assert few.content != many.content
    faulty = server.client.get(f"{own}/rings?reference=nothing")
    assert assert_problem(faulty, 422, "invalid-parameter")["where"]["field"] == "reference"


def test_reference_gamuts_are_compared_by_slug(server):
    address = "/v1/comparisons?a=srgb&b=display-p3&surface_samples=2000&triangles=500"
    answer = server.client.get(address)
    assert answer.status_code == 200, answer.text
    assert answer.headers["cache-control"] == "public, max-age=300"
    # the primaries of Display P3 are those of sRGB or beyond them
    assert answer.json()["b_covers_a"] > 0.98
    assert answer.json()["a_covers_b"] < 0.8
    by_id = server.client.get(answer.headers["content-location"])
    assert by_id.headers["cache-control"] == IMMUTABLE
    assert by_id.content == answer.content


def test_other_forms_are_refused(server, addresses, assert_problem):
    answer = server.client.get(addresses["cusps"], headers={"Accept": "image/png"})
    assert assert_problem(answer, 406, "not-acceptable")["where"]["available"] == [JSON, NPY, CSV]


@pytest.mark.parametrize("query", ["slice.svg?lightness=50", "slice.svg?hue=40", "rings.svg"])
def test_pictures_are_immutable_svg(server, gamut, query):
    address = f"{gamut['links']['self']}/{query}"
    answer = server.client.get(address)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"].startswith("image/svg+xml")
    assert answer.headers["cache-control"] == IMMUTABLE
    assert answer.text.startswith("<?xml ")
    assert answer.text.endswith("</svg>\n")
    assert server.client.get(address).content == answer.content
    known = {"If-None-Match": answer.headers["etag"]}
    assert server.client.get(address, headers=known).status_code == 304


def test_pictures_check_their_parameters(server, gamut, assert_problem):
    own = gamut["links"]["self"]
    assert_problem(server.client.get(f"{own}/rings.svg?sectors=0"), 422, "invalid-parameter")
    assert_problem(server.client.get(f"{own}/rings.svg?hues=3"), 422, "invalid-parameter")
    assert_problem(server.client.get(f"{own}/slice.svg"), 422, "invalid-parameter")
    assert_problem(server.client.get(f"{own}/cusps.svg"), 404, "not-found")
