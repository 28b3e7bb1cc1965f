"""Views and comparisons over HTTP: figures of cubes, forms, caching."""

import io

import numpy as np
import pytest

from gamutcore.questions import QUESTIONS

IMMUTABLE = "public, max-age=31536000, immutable"
JSON, NPY, CSV = "application/json", "application/x-npy", "text/csv"
NAMES = [
    name
    for name, question in QUESTIONS.items()
    if question.answer_schema and not question.needs_model
]
"""Views of any gamut."""

PATCHES = [
    [
        *np.multiply(100.0, values),
        100.0 * (0.25 * r + 0.65 * g + 0.1 * b) ** 0.5,
        80.0 * (r - g),
        70.0 * (g - b),
    ]
    for values, (r, g, b) in (
        (rgb, np.power(rgb, 1.5).tolist())
        for rgb in (
            *np.ndindex(2, 2, 2),
            *np.random.default_rng(1).random((40, 3)).tolist(),
        )
    )
]
"""RGB and colours of a display."""


@pytest.fixture(scope="module")
def view(server, cubes):
    """Ask for a view of the larger cube; of both cubes for a comparison."""
    ids = [address.rpartition("/")[2] for address in cubes]

    def ask(name, accept=JSON, **query):
        if name == "slice" and not query:
            query = {"lightness": 50}
        if name == "comparisons":
            query = {"a": ids[0], "b": ids[1], **query}
        path = "/v1/comparisons" if name == "comparisons" else f"{cubes[0]}/{name}"
        return server.client.get(path, params=query, headers={"Accept": accept})

    return ask


# --- figures --------------------------------------------------------------------------------------


def test_cusps_of_a_cube(view):
    answer = view("cusps", hues=8).json()
    assert answer["hue"] == list(range(0, 360, 45))
    np.testing.assert_allclose(answer["chroma"], [10, 10 * 2**0.5] * 4, rtol=1e-6)
    np.testing.assert_allclose(
        np.hypot(*np.array(answer["point"]).T[1:]), answer["chroma"], rtol=1e-6
    )
    assert answer["channels"] == []
    assert "device" not in answer


def test_comparison_of_a_cube_with_half_of_it(view):
    answer = view("comparisons", sectors=4).json()
    expected = {
        "volume_a": 8000,
        "volume_b": 1000,
        "intersection": 1000,
        "union": 8000,
        "a_covers_b": 1,
        "b_covers_a": 0.125,
        "jaccard": 0.125,
        "symmetric_difference": 7000,
    }
    for name, value in expected.items():
        assert answer[name] == pytest.approx(value, rel=1e-6)
    assert answer["sectors"]["hue_from"] == [0, 90, 180, 270]
    assert answer["sectors"]["volume_b"] == pytest.approx([250] * 4, rel=1e-6)
    assert answer["white_a"][0] == 60
    assert answer["black_b"][0] == 45
    assert [answer["levels"][name]["triangles"] for name in "ab"] == [12, 12]


def test_colours_lost_of_a_comparison(view):
    plain, answer = view("comparisons").json(), view("comparisons", lost="true", sectors=4).json()
    assert plain["lost_a"] is plain["lost_b"] is None
    assert "lost_mean_a" not in plain["sectors"]
    assert plain["sectors"]["max_chroma_a"] == pytest.approx(
        np.multiply(plain["sectors"]["max_chroma_b"], 2), rel=1e-3
    )
    assert answer["lost_a"]["share_outside"] == 1
    assert answer["lost_a"]["percentile_95"] > answer["lost_a"]["mean"] > 0
    assert answer["lost_b"] == {"mean": 0, "percentile_95": 0, "share_outside": 0}
    assert min(answer["sectors"]["lost_percentile_95_a"]) > 0
    assert answer["summary"][0].startswith("A reaches further at every hue")
    assert "The whole surface of B is inside A." in answer["summary"]
    table = view("comparisons", CSV, lost="true", sectors=4).text.splitlines()
    assert table[0].endswith("lost_percentile_95_a,lost_percentile_95_b")


@pytest.mark.parametrize(
    ("query", "area"),
    [({"lightness": 50}, 400), ({"plane": "0,1,0,5"}, 400), ({"hue": 0}, 200)],
)
def test_sections_of_a_cube(view, query, area):
    (polygon,) = view("slice", **query).json()["polygons"]
    spread = np.ptp(polygon, axis=0)
    assert np.prod(spread[spread > 1e-6]) == pytest.approx(area)


def test_a_section_needs_one_plane(view, assert_problem):
    assert view("slice", lightness=70).json()["polygons"] == []
    for query in ({"triangles": 12}, {"lightness": 50, "hue": 3}, {"plane": "0,1,0"}):
        assert_problem(view("slice", **query), 422, "invalid-parameter")


def test_intervals_of_a_cube(view):
    answer = view("leaves", hues=2, lightness=3).json()
    assert answer["lightness"] == [0, 50, 100]
    found = [[np.round(each, 6).tolist() for each in leaf] for leaf in answer["intervals"]]
    assert found == [[[], [[0, 10]], []]] * 2


def test_rings_of_a_cube_with_half_of_it(view, cubes):
    alone = view("rings", sectors=4).json()
    assert alone["volume"] == pytest.approx(8000)
    # the area within the outer ring is the volume
    outer = np.array(alone["radius"][-1])
    assert (outer**2).sum() * np.pi / 4 == pytest.approx(8000)
    both = view("rings", sectors=4, reference=cubes[1].rpartition("/")[2]).json()
    inner = np.array(both["reference_radius"][-1])
    assert (inner**2).sum() * np.pi / 4 == pytest.approx(1000)
    assert both["reference_level"]["triangles"] == 12


@pytest.mark.parametrize("name", ["cusps", "slice"])
def test_device_values_of_a_boundary_lie_on_the_cube_of_device_values(server, name):
    query = {"surface_samples": 2000, **({"lightness": 50} if name == "slice" else {"hues": 8})}
    answer = server.client.get(f"/v1/gamuts/srgb/{name}", params=query).json()
    assert answer["channels"] == ["R", "G", "B"]
    parts = answer["device"] if name == "slice" else [answer["device"]]
    points = answer["polygons"] if name == "slice" else [answer["point"]]
    assert [len(part) for part in parts] == [len(part) for part in points]
    device = np.concatenate(parts)
    # within a triangle that crosses an edge of the cube, they lie inside
    assert np.minimum(device, 1 - device).min(axis=1).max() < 0.1


def test_leaves_have_the_device_values_of_both_ends(server):
    """The cusp of red, L* 54.3 and hue 40.9° (Lindbloom), is at R = 1 and G = B = 0."""
    query = {"surface_samples": 2000, "hues": 360, "lightness": 101}
    answer = server.client.get("/v1/gamuts/srgb/leaves", params=query).json()
    assert answer["channels"] == ["R", "G", "B"]
    chroma, device = answer["intervals"][41][54][-1], answer["device"][41][54][-1]
    assert chroma[1] == pytest.approx(106.8, abs=1.5)
    np.testing.assert_allclose(device[1], [1, 0, 0], atol=0.06)
    assert [len(cell) for cell in answer["device"][41]] == [
        len(cell) for cell in answer["intervals"][41]
    ]
    accept = {"accept": "text/csv"}
    query |= {"hues": 4, "lightness": 5}
    table = server.client.get("/v1/gamuts/srgb/leaves", params=query, headers=accept).text
    names = "hue,lightness,chroma_from,chroma_to,device_R,device_G,device_B"
    assert table.splitlines()[0] == names


# --- forms ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_answers_are_immutable_and_have_one_table_in_all_forms(server, view, name, assert_problem):
    answer = view(name)
    assert answer.status_code == 200, answer.text
    assert answer.headers["cache-control"] == IMMUTABLE
    assert answer.headers["gamut-triangles"].startswith("12")
    assert view(name).content == answer.content
    known = {"If-None-Match": answer.headers["etag"]}
    assert server.client.get(answer.url, headers=known).status_code == 304
    packed = server.client.get(answer.url, headers={"Accept-Encoding": "gzip"})
    assert packed.json() == answer.json()
    if "content-encoding" in packed.headers:
        assert packed.headers["etag"] != answer.headers["etag"]
    array = np.load(io.BytesIO(view(name, NPY).content))
    lines = [line.split(",") for line in view(name, CSV).text.splitlines()]
    assert len(lines) == len(array) + 1
    numbers = np.array([[float(cell or "nan") for cell in line] for line in lines[1:]])
    flat = np.concatenate([array[each].reshape(len(array), -1) for each in array.dtype.names], 1)
    assert np.array_equal(numbers, flat, equal_nan=True)
    columns = answer.json().get("sectors", answer.json())
    for each in array.dtype.names:
        stated = columns.get(each, [])
        stated = stated if isinstance(stated, list) else [stated]  # a number has one row
        if len(stated) == len(array):
            assert stated == array[each].tolist()
    refused = assert_problem(view(name, "image/png"), 406, "not-acceptable")
    assert refused["where"]["available"] == [JSON, NPY, CSV]


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
def test_faults_are_problems(server, cubes, assert_problem, query, code, field):
    answer = server.client.get(f"{cubes[0]}/cusps?{query}")
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


def test_reference_gamuts_are_compared_by_slug(server, gamut, assert_problem):
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
    own = gamut["links"]["self"]
    rings = f"{own}/rings?reference=srgb&surface_samples=2000&triangles=100"
    assert len(server.client.get(f"{rings}&sectors=12").json()["reference_radius"][0]) == 12
    faulty = server.client.get(f"{own}/rings?reference=nothing")
    assert assert_problem(faulty, 422, "invalid-parameter")["where"]["field"] == "reference"


@pytest.mark.parametrize("name", ["slice.svg?lightness=50", "rings.svg", "cusps.svg"])
def test_questions_have_no_drawings(server, gamut, assert_problem, name):
    assert_problem(server.client.get(f"{gamut['links']['self']}/{name}"), 404, "not-found")


@pytest.mark.slow
def test_uncertainty_of_measured_patches(server, cubes):
    rows = "\n".join(" ".join(f"{value:.5f}" for value in row) for row in PATCHES)
    chart = (
        "CGATS.17\nDEVICE_CLASS DISPLAY\nBEGIN_DATA_FORMAT\n"
        "RGB_R RGB_G RGB_B LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\n"
        f"NUMBER_OF_SETS {len(PATCHES)}\nBEGIN_DATA\n{rows}\nEND_DATA\n"
    )
    files, data = {"file": chart.encode()}, {"options": '{"surface_samples": 500}'}
    posted = server.client.post("/v1/gamuts", files=files, data=data, timeout=600)
    assert posted.status_code in {200, 201}, posted.text
    path = f"{posted.json()['links']['self']}/uncertainty"
    answer = server.client.get(path, params={"noise": 0.3}, timeout=600)
    assert answer.status_code == 200, answer.text
    found = answer.json()
    assert found["volume"]["low"] < posted.json()["volume"] < found["volume"]["high"]
    assert found["noise"] == 0.3
    assert found["summary"]
    assert answer.headers["cache-control"] == IMMUTABLE
    refused = server.client.get(f"{cubes[0]}/uncertainty", params={"noise": 0.3})
    assert refused.json()["code"] == "no-device-model"
    assert server.client.get(path, params={"noise": -1}).json()["code"] == "invalid-parameter"
