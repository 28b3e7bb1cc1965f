"""Meshes over HTTP: levels, sides, limits, formats, conditional requests and file names."""

import hashlib
import io
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import trimesh

from benchmarks.booleans import intersection_volume
from gamutcore.export import FORMATS
from gamutcore.geometry import TriangleMesh

PROFILE = Path(__file__).parents[2] / "data" / "sRGB-v4.icc"
WITHOUT_DEVICE = [name for name in FORMATS if name != "cge"]
"""Formats of meshes without device values."""

IMMUTABLE = "public, max-age=31536000, immutable"
FIELDS = ("etag", "content-type", "content-length", "gamut-triangles", "cache-control", "vary")


@pytest.fixture(scope="module")
def mesh(server, gamut):
    """Ask for a mesh of the shared gamut."""

    def ask(suffix="", headers=None, **query):
        return server.client.get(gamut["links"]["mesh"] + suffix, params=query, headers=headers)

    return ask


@pytest.fixture(scope="module")
def profile(server):
    """A gamut with device values: that of a profile, whose white is R = G = B = 1."""
    answer = server.client.post(
        "/v1/gamuts",
        files={"file": PROFILE.read_bytes()},
        data={"options": '{"surface_samples": 2000}'},
    )
    return answer.json()


def vertices(server, gamut, **query):
    """The vertices of a PLY file with everything that is stored of them."""
    answer = server.client.get(gamut["links"]["mesh"] + ".ply", params=query)
    loaded = trimesh.load(io.BytesIO(answer.content), "ply", process=False)
    return loaded.metadata["_ply_raw"]["vertex"]["data"]


# --- levels ---------------------------------------------------------------------------------------


def test_no_more_triangles_come_than_were_asked_for_or_exist(gamut, mesh, assert_problem):
    largest = gamut["counts"]["triangles"]
    for triangles in (4, 5, 100, 333, largest):
        answer = mesh(triangles=triangles)
        count = triangles - triangles % 2
        assert int(answer.headers["gamut-triangles"]) == count
        assert int(answer.headers["gamut-vertices"]) == count // 2 + 2
        loaded = trimesh.load(io.BytesIO(answer.content), "glb", force="mesh", process=False)
        assert len(loaded.faces) == count
        assert loaded.is_watertight
    for triangles in (0, 3, largest + 1, largest + 2, 10**9 + 1, 10**11):
        document = assert_problem(mesh(triangles=triangles), 422, "triangle-count")
        assert document["where"]["field"] == "triangles"
        assert ("4" if triangles < 4 else str(largest)) in document["remedy"]


def test_without_a_count_it_is_a_thousand_or_all(server, gamut, mesh, sphere):
    assert gamut["counts"]["triangles"] < 1000
    assert mesh().headers["gamut-triangles"] == str(gamut["counts"]["triangles"])
    body = {"samples": sphere(seed=31, count=6000)}
    large = server.client.post("/v1/gamuts", json=body).json()
    assert large["counts"]["triangles"] > 10_000
    answer = server.client.get(large["links"]["mesh"])
    assert answer.headers["gamut-triangles"] == "1000"
    # of more triangles than are encoded at once, before and after it is kept
    query = {"triangles": large["counts"]["triangles"]}
    first, again = (server.client.get(large["links"]["mesh"], params=query) for _ in range(2))
    assert first.headers["gamut-triangles"] == str(query["triangles"])
    assert again.content == first.content


def test_device_values_come_along(server, gamut, profile):
    for suffix, names in (
        ("ply", [f"device_{light}" for light in "RGB"]),
        ("glb", [f"_DEVICE_{light}" for light in "RGB"]),
    ):
        content = server.client.get(f"{profile['links']['mesh']}.{suffix}?triangles=500").content
        loaded = trimesh.load(io.BytesIO(content), suffix, force="mesh", process=False)
        if suffix == "ply":
            stored = loaded.metadata["_ply_raw"]["vertex"]["data"]
        else:
            stored = loaded.vertex_attributes
        upwards = 0 if suffix == "ply" else 1  # glTF's scene is turned
        lightest = loaded.vertices[:, upwards].argmax()
        for name in names:
            assert len(stored[name]) == len(loaded.vertices)
            assert stored[name][lightest] > 0.99
        bare = server.client.get(f"{gamut['links']['mesh']}.{suffix}?triangles=100").content
        assert not any(name.encode() in bare for name in names)


# --- sides ----------------------------------------------------------------------------------------


def test_sides_are_contained_in_each_other(gamut, mesh):
    def loaded(**query):
        answer = mesh(format="ply", **query)
        found = trimesh.load(io.BytesIO(answer.content), "ply", process=False)
        return answer, TriangleMesh(found.vertices.astype(np.float32), found.faces)

    _, full = loaded(triangles=gamut["counts"]["triangles"])
    answers = {}
    for side in ("inside", "outside", "both"):
        answer, level = loaded(triangles=60, side=side)
        assert loaded(triangles=60, side=side)[0].content == answer.content
        assert answer.headers["gamut-triangles"] == "60"
        assert level.validity(gamut["centre"]).star_shaped
        common = intersection_volume(full, level)
        if side == "inside":
            assert level.volume == pytest.approx(common, rel=1e-9)
        elif side == "outside":
            assert full.volume == pytest.approx(common, rel=1e-9)
        answers[side] = answer.headers["etag"]
    assert len(set(answers.values())) == 3
    assert mesh(format="ply", triangles=60).headers["etag"] == answers["both"]


@pytest.mark.parametrize("side", ["inside", "outside"])
def test_the_error_curve_of_a_side_holds_for_its_meshes(server, gamut, mesh, side):
    def ask(_):
        return server.client.get(gamut["links"]["levels"], params={"side": side})

    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(ask, range(4)))
    assert len({answer.content for answer in answers}) == 1
    assert answers[0].headers["cache-control"] == IMMUTABLE
    curve = answers[0].json()["levels"]
    whole = curve[-1]
    assert (whole["triangles"], whole["distance_bound"]) == (gamut["counts"]["triangles"], 0.0)
    for level in curve[:-1]:
        assert (level["volume"] < whole["volume"]) == (side == "inside")
        # one contains the other, so the mismatch is the difference of their volumes
        lost = abs(level["volume"] - whole["volume"]) / whole["volume"]
        assert level["mismatch"] == pytest.approx(lost, rel=1e-4)
    for name, bound in (("max_error", "distance_bound"), ("max_mismatch", "mismatch_bound")):
        counts = []
        for level in curve:
            query = {"side": side, name: level[bound]}
            first, second = (mesh(".ply", **query) for _ in range(2))
            assert second.content == first.content
            assert float(first.headers[f"gamut-{name.replace('_', '-')}"]) <= level[bound]
            counts.append(int(first.headers["gamut-triangles"]))
            assert counts[-1] <= level["triangles"]
            assert mesh(".ply", side=side, triangles=counts[-1]).content == first.content
        assert counts == sorted(counts)


def test_vertices_on_one_side_keep_their_device_values(server, profile):
    both = vertices(server, profile, triangles=60, side="both")
    for side in ("inside", "outside"):
        moved = vertices(server, profile, triangles=60, side=side)
        assert not np.array_equal(moved["x"], both["x"])
        for light in "RGB":
            np.testing.assert_array_equal(moved[f"device_{light}"], both[f"device_{light}"])


def test_bodies_as_thin_as_the_step_of_float32_get_no_server_error(server):
    # 10,000 times as wide as thick; L*, a* and b* about 50
    points = np.random.default_rng(1).normal(size=(60, 3))
    points *= [50.0, 50.0, 0.005] / np.linalg.norm(points, axis=1)[:, np.newaxis]
    body = {"samples": (points + 50.0).tolist(), "options": {"gamma": 0.5}}
    thin = server.client.post("/v1/gamuts", json=body)
    assert thin.status_code == 201, thin.text
    links = thin.json()["links"]
    for side in ("inside", "outside"):
        for query in ({"triangles": 4}, {"triangles": 40}, {"max_error": 1e-3}):
            answer = server.client.get(links["mesh"], params={"side": side, **query})
            assert answer.status_code == 200
        assert server.client.get(links["levels"], params={"side": side}).status_code == 200


# --- limits ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["max_error", "max_mismatch"])
def test_a_limit_is_kept_with_no_more_triangles_than_the_curve_would_take(gamut, mesh, name):
    levels = gamut["levels"]
    bound = {"max_error": "distance_bound", "max_mismatch": "mismatch_bound"}[name]
    field = f"gamut-{name.replace('_', '-')}"
    for limit in (levels[5][bound] * 1.01, levels[-3][bound] * 0.99, levels[-2][bound] * 0.99):
        most = min(level["triangles"] for level in levels if level[bound] <= limit)
        for suffix in ("", ".ply"):
            # the route finds it, the front answers from then on
            first, second = (mesh(suffix, **{name: limit}) for _ in range(2))
            assert float(first.headers[field]) <= limit
            triangles = first.headers["gamut-triangles"]
            assert int(triangles) <= most
            for answer in (second, mesh(suffix, triangles=triangles)):
                assert answer.content == first.content
                assert answer.headers["etag"] == first.headers["etag"]
            known = {"If-None-Match": first.headers["etag"]}
            same = mesh(suffix, known, **{name: limit})
            assert same.status_code == 304
            for each in ("gamut-triangles", "gamut-max-error", "gamut-max-mismatch", "etag"):
                assert second.headers[each] == same.headers[each] == first.headers[each]


def test_limits_of_both_kinds_are_both_kept(gamut, mesh):
    levels = gamut["levels"][2::4]
    for error in (level["distance_bound"] for level in levels):
        for mismatch in (level["mismatch_bound"] for level in levels):
            alone = [mesh(max_error=error), mesh(max_mismatch=mismatch)]
            both = mesh(max_error=error, max_mismatch=mismatch)
            assert float(both.headers["gamut-max-error"]) <= error
            assert float(both.headers["gamut-max-mismatch"]) <= mismatch
            count = int(both.headers["gamut-triangles"])
            assert count >= max(int(answer.headers["gamut-triangles"]) for answer in alone)


def test_counts_promise_what_the_curve_states_and_other_counts_nothing(gamut, mesh):
    for level in gamut["levels"]:
        headers = mesh(triangles=level["triangles"]).headers
        assert float(headers["gamut-max-error"]) == level["distance_bound"]
        assert float(headers["gamut-max-mismatch"]) == level["mismatch_bound"]
    headers = mesh(triangles=gamut["levels"][-2]["triangles"] + 2).headers
    assert {"gamut-max-error", "gamut-max-mismatch"}.isdisjoint(headers)


def test_limits_at_the_same_time_are_all_answered(server, sphere):
    """Equal ones, others, and counts; of a gamut that nobody asked for before."""
    made = server.client.post("/v1/gamuts", json={"samples": sphere(seed=32, count=1000)}).json()
    queries = [f"max_error={0.05 * (1 + place // 4)}" for place in range(12)]
    queries += [f"max_mismatch={10**-power}" for power in range(1, 4)] + ["triangles=500"] * 4

    def asked(query):
        return server.client.get(f"{made['links']['mesh']}?{query}")

    with ThreadPoolExecutor(len(queries)) as threads:
        answers = dict(zip(queries, threads.map(asked, queries), strict=True))
    assert {answer.status_code for answer in answers.values()} == {200}
    for query, answer in answers.items():
        again = asked(query)
        assert (again.content, again.headers["etag"]) == (answer.content, answer.headers["etag"])
        name, _, limit = query.partition("=")
        if name != "triangles":
            assert float(answer.headers[f"gamut-{name.replace('_', '-')}"]) <= float(limit)


def test_a_limit_that_no_level_keeps_gives_the_full_boundary(server, gamut):
    for query in ("max_error=0", "max_mismatch=0", "max_mismatch=1&max_error=0", "max_error=1e-99"):
        answer = server.client.get(f"{gamut['links']['mesh']}?{query}")
        assert answer.headers["gamut-triangles"] == str(gamut["counts"]["triangles"])
        assert answer.headers["gamut-max-error"] == answer.headers["gamut-max-mismatch"] == "0"


# --- formats --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", WITHOUT_DEVICE)
def test_a_format_is_named_in_three_ways(mesh, name):
    media_type, suffix = FORMATS[name].media_type, FORMATS[name].suffix
    answers = [
        mesh(format=name, triangles=50),
        mesh(suffix, triangles=50),
        mesh(triangles=50, headers={"Accept": media_type}),
    ]
    assert len({answer.content for answer in answers}) == 1
    for answer in answers:
        assert answer.headers["content-type"] == media_type
        assert answer.headers["vary"] == "Accept, Accept-Encoding"


def test_the_format_goes_before_the_suffix_and_the_suffix_before_accept(mesh):
    headers = {"Accept": "model/stl"}
    answer = mesh(".ply", headers, format="obj")
    assert answer.headers["content-type"] == "model/obj"
    assert mesh(".ply", headers).headers["content-type"] == "application/ply"


@pytest.mark.parametrize(
    ("accept", "expected"),
    [
        ([], "model/gltf-binary"),
        ([""], "model/gltf-binary"),
        (["*/*"], "model/gltf-binary"),
        (["MODEL/Stl"], "model/stl"),
        (["model/*"], "model/gltf-binary"),
        (["application/octet-stream"], "model/gltf-binary"),
        (["model/gltf-binary;q=0.1, model/stl"], "model/stl"),
        (["model/obj;q=0.5, model/stl;q=0.6"], "model/stl"),
        (["text/html, */*;q=0.1"], "model/gltf-binary"),
        (["text/html,application/xhtml+xml,*/*;q=0.8"], "model/gltf-binary"),
        (["text/html", "model/stl"], "model/stl"),
        # The more specific range decides, whatever its quality: RFC 9110, section 12.5.1.
        (["model/*;q=1, model/gltf-binary;q=0.2"], "model/gltf+json"),
        (["*/*, model/gltf-binary;q=0"], "model/gltf+json"),
        (["nonsense, ;q=1, model/stl"], "model/stl"),
        (["model/stl;q=nonsense"], "model/stl"),
        (["text/html"], None),
        (["image/png, text/*"], None),
        (["model/gltf-binary;q=0"], None),
        (["*/*;q=0"], None),
    ],
)
def test_accept_is_weighed(server, gamut, assert_problem, accept, expected):
    address = f"{gamut['links']['mesh']}?triangles=20"
    fields = [("Accept", each) for each in accept]
    if not accept:
        request = server.client.build_request("GET", address)
        del request.headers["accept"]
        answer = server.client.send(request)
    else:
        answer = server.client.get(address, headers=fields)
    if expected is None:
        document = assert_problem(answer, 406, "not-acceptable")
        assert document["where"]["available"] == [entry.media_type for entry in FORMATS.values()]
    else:
        assert answer.headers["content-type"] == expected


def test_an_envelope_is_of_the_full_boundary_and_for_three_channels(server, assert_problem, gamut):
    coarse, accept = {"surface_samples": 2000}, {"Accept": "application/x-idms-cge"}
    answer = server.client.get("/v1/gamuts/srgb/mesh", params=coarse, headers=accept)
    again = server.client.get("/v1/gamuts/srgb/mesh.cge", params=coarse)
    assert answer.content == again.content
    assert answer.content.startswith(b"CGATS.17\n")
    assert b"NUMBER_OF_SETS 602\n" in answer.content
    largest = server.client.get("/v1/gamuts/srgb", params=coarse).json()["counts"]["triangles"]
    assert answer.headers["gamut-triangles"] == str(largest)
    few = server.client.get("/v1/gamuts/srgb/mesh.cge", params={**coarse, "triangles": 500})
    assert few.headers["gamut-triangles"] == "500"
    for address in (gamut["links"]["mesh"] + ".cge", f"{gamut['links']['mesh']}?format=cge"):
        document = assert_problem(server.client.get(address), 422, "invalid-option")
        assert document["where"] == {"field": "format"}
        assert "no device values" in document["detail"]


def test_formats_in_cielab_are_refused_for_other_spaces(server, assert_problem, sphere):
    posted = {"samples": sphere(seed=1), "options": {"space": "Oklab"}}
    made = server.client.post("/v1/gamuts", json=posted).json()
    for name in ("gam", "icc"):
        answer = server.client.get(made["links"]["mesh"], params={"format": name})
        document = assert_problem(answer, 422, "invalid-option")
        assert document["where"] == {"field": "format"}
        assert "Oklab" in document["detail"]


def test_unknown_formats_are_refused(mesh, assert_problem):
    for name in ("vrml", "", "GLB", "../glb"):
        document = assert_problem(mesh(format=name), 422, "invalid-parameter")
        assert document["where"]["field"] == "format"
        assert all(known in document["remedy"] for known in FORMATS)
        assert_problem(mesh(".ply", format=name), 422, "invalid-parameter")
    for suffix in (".vrml", ".GLB", ".glb.gz"):
        assert ".ply" in assert_problem(mesh(suffix), 404, "not-found")["remedy"]


# --- the fast path and the route ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("suffix", "query", "headers"),
    [
        ("", "", {}),
        ("", "triangles=60", {}),
        ("", "triangles=61&format=glb", {}),
        ("", "format=glb&triangles=60", {}),
        ("", "triangles=0000000060", {}),
        ("", "triangles=100&format=ply", {}),
        ("", "side=both", {}),
        ("", "triangles=8&side=inside", {}),
        ("", "side=outside&format=stl", {}),
        (".obj", "triangles=8", {}),
        (".obj", "format=stl", {}),
        ("", "max_error=0.5", {}),
        ("", "max_error=5e-1&format=ply", {}),
        (".ply", "max_error=0&max_mismatch=1E-3", {}),
        ("", "triangles=60", {"Accept": "text/html, model/stl"}),
        ("", "triangles=60", {"Accept-Encoding": "br, gzip, zstd;q=0.5"}),
    ],
)
def test_every_way_to_a_mesh_gives_the_same_response(server, gamut, suffix, query, headers):
    """A precondition is for the route to check, so that it answers. Others may be at hand."""
    address = f"{gamut['links']['mesh']}{suffix}?{query}"
    route = server.client.get(address, headers={**headers, "If-Match": "*"})
    assert route.status_code == 200
    assert route.headers["cache-control"] == IMMUTABLE
    if "content-encoding" not in route.headers:
        assert route.headers["etag"] == f'"{hashlib.sha256(route.content).hexdigest()}"'
    for _ in range(2):
        answer = server.client.get(address, headers=headers)
        assert answer.content == route.content
        assert [answer.headers[name] for name in FIELDS] == [route.headers[name] for name in FIELDS]
    for known in (route.headers["etag"], f'"x", W/{route.headers["etag"]}', "*"):
        same = server.client.get(address, headers={**headers, "If-None-Match": known})
        assert (same.status_code, same.content) == (304, b"")
        for name in ("etag", "cache-control", "vary"):
            assert same.headers[name] == route.headers[name]
        assert "content-type" not in same.headers
    other = server.client.get(address, headers={**headers, "If-None-Match": '"x"'})
    assert other.content == route.content
    head = server.client.head(address, headers=headers)
    assert (head.status_code, head.content) == (200, b"")
    assert [head.headers[name] for name in FIELDS] == [route.headers[name] for name in FIELDS]


@pytest.mark.parametrize(
    ("below", "status", "field"),
    [
        ("/", 404, None),
        ("%0a", 404, None),
        ("?triangles=", 422, "triangles"),
        ("?triangles=-4", 422, "triangles"),
        ("?triangles=4%0a", 422, "triangles"),
        ("?triangles=10&triangles=20", 422, "triangles"),
        ("?triangles=10format=ply", 422, "triangles"),
        ("?triangles=10&max_error=0.5", 422, "triangles"),
        ("?max_mismatch=0.5&triangles=10", 422, "triangles"),
        ("?max_error=1&max_mismatch=1&triangles=10", 422, "triangles"),
        ("?max_error=1e+1", 422, "max_error"),
        ("?max_error=0.5max_mismatch=1", 422, "max_error"),
        ("?side=left", 422, "side"),
        ("?side=", 422, "side"),
        ("?triangles=10&other=1", 422, "other"),
    ],
)
def test_faulty_requests_for_a_mesh_at_hand_are_refused(mesh, server, gamut, below, status, field):
    assert mesh(triangles=10).status_code == mesh(max_error=0.5).status_code == 200
    answer = server.client.get(gamut["links"]["mesh"] + below)
    assert answer.status_code == status
    if field is not None:
        where = answer.json()["where"]
        assert (where["in"], where["field"]) == ("query", field)


# --- names of files -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", WITHOUT_DEVICE)
def test_a_download_has_a_file_name_from_the_cache_too(mesh, gamut, name):
    for query in ({"triangles": 101}, {"max_error": 1}):
        answers = [mesh(format=name, **query) for _ in range(2)]
        answers.append(mesh(headers={"Accept-Encoding": "gzip"}, format=name, **query))
        for answer in answers:
            triangles = answer.headers["gamut-triangles"]
            expected = f'inline; filename="{gamut["name"]}-{triangles}{FORMATS[name].suffix}"'
            assert answer.headers["content-disposition"] == expected


@pytest.mark.parametrize("link", ["mesh", "history", "picture"])
def test_curl_saves_a_download_under_its_name(server, gamut, tmp_path, link):
    if shutil.which("curl") is None:
        pytest.skip("curl is not installed")
    name, own = gamut["name"], gamut["links"]["self"]
    path, name, begin = {
        "mesh": (f"{own}/mesh.ply?triangles=50", f"{name}-50.ply", b"ply"),
        "history": (gamut["links"]["history"], f"{name}.gamut", b""),
        "picture": (f"{own}/picture.png?size=32", f"{name}.png", b"\x89PNG"),
    }[link]
    subprocess.run(["curl", "-sSOJ", server.url + path], cwd=tmp_path, check=True)
    (saved,) = tmp_path.iterdir()
    assert saved.name == name
    assert saved.read_bytes().startswith(begin)
    assert saved.stat().st_size > 100
