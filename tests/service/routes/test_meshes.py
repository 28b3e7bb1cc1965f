import hashlib
import io
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import trimesh

from gamutcore.export import FORMATS
from gamutcore.mesh import TriangleMesh
from gamutcore.metric import intersection_volume

PROFILE = Path(__file__).parents[2] / "data" / "sRGB-v4.icc"
WITHOUT_DEVICE = [name for name in FORMATS if name != "cge"]
"""Formats of meshes without device values."""

IMMUTABLE = "public, max-age=31536000, immutable"


@pytest.mark.parametrize("triangles", [4, 5, 100, 333])
def test_no_more_triangles_come_than_were_asked_for(server, gamut, triangles):
    answer = server.client.get(gamut["links"]["mesh"], params={"triangles": triangles})
    assert answer.status_code == 200
    assert int(answer.headers["gamut-triangles"]) == triangles - triangles % 2
    assert int(answer.headers["gamut-vertices"]) == triangles // 2 + 2
    mesh = trimesh.load(io.BytesIO(answer.content), "glb", force="mesh", process=False)
    assert len(mesh.faces) == triangles - triangles % 2
    assert mesh.is_watertight


def test_the_largest_level_and_no_larger_one(server, assert_problem, gamut):
    largest = gamut["counts"]["triangles"]
    mesh = gamut["links"]["mesh"]
    answer = server.client.get(mesh, params={"triangles": largest})
    assert answer.headers["gamut-triangles"] == str(largest)
    assert answer.headers["gamut-vertices"] == str(gamut["counts"]["vertices"])
    for triangles in (largest + 1, largest + 2, 10**9 + 1, 10**11):
        document = assert_problem(
            server.client.get(mesh, params={"triangles": triangles}), 422, "triangle-count"
        )
        assert document["where"]["field"] == "triangles"
        assert str(largest) in document["remedy"]


def test_sides_are_contained_in_each_other(server, gamut):
    def mesh(**query):
        answer = server.client.get(gamut["links"]["mesh"], params={"format": "ply", **query})
        assert answer.status_code == 200
        loaded = trimesh.load(io.BytesIO(answer.content), "ply", process=False)
        return answer, TriangleMesh(loaded.vertices.astype(np.float32), loaded.faces)

    _, full = mesh(triangles=gamut["counts"]["triangles"])
    answers = {}
    for side in ("inside", "outside", "both"):
        answer, level = mesh(triangles=60, side=side)
        again, _ = mesh(triangles=60, side=side)
        assert again.content == answer.content
        assert answer.headers["gamut-triangles"] == "60"
        assert level.validity(gamut["centre"]).star_shaped
        common = intersection_volume(full, level)
        if side == "inside":
            assert level.volume == pytest.approx(common, rel=1e-9)
        elif side == "outside":
            assert full.volume == pytest.approx(common, rel=1e-9)
        answers[side] = answer.headers["etag"]
    assert len(set(answers.values())) == 3
    assert mesh(triangles=60)[0].headers["etag"] == answers["both"]


@pytest.mark.parametrize("link", ["mesh", "levels"])
@pytest.mark.parametrize("side", ["left", ""])
def test_other_sides_are_refused(server, assert_problem, gamut, link, side):
    answer = server.client.get(gamut["links"][link], params={"side": side})
    document = assert_problem(answer, 422, "invalid-parameter")
    assert document["where"] == {"in": "query", "field": "side"}


@pytest.mark.parametrize("side", ["inside", "outside"])
def test_the_error_curve_of_a_side_holds_for_its_meshes(server, gamut, side):
    levels, mesh = gamut["links"]["levels"], gamut["links"]["mesh"]

    def curve(_):
        return server.client.get(levels, params={"side": side})

    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(curve, range(4)))
    assert len({answer.content for answer in answers}) == 1
    assert answers[0].headers["cache-control"] == IMMUTABLE
    curve = answers[0].json()["levels"]
    whole = curve[-1]
    assert (whole["triangles"], whole["distance_bound"]) == (gamut["counts"]["triangles"], 0.0)
    for level in curve[:-1]:
        smaller = level["volume"] < whole["volume"]
        assert smaller == (side == "inside")
        # one contains the other, so the mismatch is the difference of their volumes
        lost = abs(level["volume"] - whole["volume"]) / whole["volume"]
        assert level["mismatch"] == pytest.approx(lost, rel=1e-4)
    for name, bound in (("max_error", "distance_bound"), ("max_mismatch", "mismatch_bound")):
        counts = []
        for level in curve:
            for address in (mesh, mesh + ".ply"):
                query = {"side": side, name: level[bound]}
                first, second = (server.client.get(address, params=query) for _ in range(2))
                assert first.status_code == 200
                assert second.content == first.content
                assert float(first.headers[f"gamut-{name.replace('_', '-')}"]) <= level[bound]
            counts.append(int(first.headers["gamut-triangles"]))
            assert counts[-1] <= level["triangles"]
            exact = {"side": side, "triangles": counts[-1]}
            assert server.client.get(mesh + ".ply", params=exact).content == first.content
        assert counts == sorted(counts)


def test_vertices_on_one_side_keep_their_device_values(server):
    made = server.client.post(
        "/v1/gamuts",
        files={"file": PROFILE.read_bytes()},
        data={"options": '{"surface_samples": 2000}'},
    ).json()

    def mesh(side):
        query = {"triangles": 60, "side": side}
        answer = server.client.get(made["links"]["mesh"] + ".ply", params=query)
        data = trimesh.load(io.BytesIO(answer.content), "ply", process=False)
        return data.metadata["_ply_raw"]["vertex"]["data"]

    both = mesh("both")
    for side in ("inside", "outside"):
        moved = mesh(side)
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


@pytest.mark.parametrize("triangles", [3, 0])
def test_fewer_than_four_triangles_close_nothing(server, assert_problem, gamut, triangles):
    answer = server.client.get(gamut["links"]["mesh"], params={"triangles": triangles})
    assert "4" in assert_problem(answer, 422, "triangle-count")["remedy"]


@pytest.mark.parametrize("triangles", ["", "many", "1.5", "1e3", "0x10", "\x00", "9" * 5000])
def test_what_is_no_count_is_refused(server, assert_problem, gamut, triangles):
    answer = server.client.get(gamut["links"]["mesh"], params={"triangles": triangles})
    document = assert_problem(answer, 422, "invalid-parameter")
    assert document["where"] == {"in": "query", "field": "triangles"}


def test_without_a_count_it_is_a_thousand_or_all(server, gamut, sphere):
    assert gamut["counts"]["triangles"] < 1000
    answer = server.client.get(gamut["links"]["mesh"])
    assert answer.headers["gamut-triangles"] == str(gamut["counts"]["triangles"])
    larger = server.client.post("/v1/gamuts", json={"samples": sphere(seed=30, count=2000)}).json()
    answer = server.client.get(larger["links"]["mesh"])
    assert answer.headers["gamut-triangles"] == "1000"


@pytest.mark.parametrize("name", ["max_error", "max_mismatch"])
def test_a_limit_is_kept_with_no_more_triangles_than_the_curve_would_take(server, gamut, name):
    levels = server.client.get(gamut["links"]["levels"]).json()["levels"]
    bound = {"max_error": "distance_bound", "max_mismatch": "mismatch_bound"}[name]
    field = f"gamut-{name.replace('_', '-')}"
    for limit in (levels[5][bound] * 1.01, levels[-3][bound] * 0.99, levels[-2][bound] * 0.99):
        most = min(level["triangles"] for level in levels if level[bound] <= limit)
        for address in (gamut["links"]["mesh"], gamut["links"]["mesh"] + ".ply"):
            # the route finds it, the front answers from then on
            first, second = (server.client.get(address, params={name: limit}) for _ in range(2))
            assert float(first.headers[field]) <= limit
            triangles = first.headers["gamut-triangles"]
            assert int(triangles) <= most
            same = server.client.get(address, params={"triangles": triangles})
            for answer in (second, same):
                assert answer.content == first.content
                assert answer.headers["etag"] == first.headers["etag"]
            fields = {"gamut-triangles", "gamut-max-error", "gamut-max-mismatch", "cache-control"}
            assert {each: second.headers[each] for each in fields} == {
                each: first.headers[each] for each in fields
            }
            known = {"If-None-Match": first.headers["etag"]}
            answer = server.client.get(address, params={name: limit}, headers=known)
            assert answer.status_code == 304
            assert answer.headers[field] == first.headers[field]


def test_limits_at_the_same_time_are_all_answered(server, sphere):
    """Equal ones, others, and counts; of a gamut that nobody asked for before."""
    made = server.client.post("/v1/gamuts", json={"samples": sphere(seed=32, count=2000)}).json()
    queries = [f"max_error={0.05 * (1 + place // 4)}" for place in range(16)]
    queries += [f"max_mismatch={10**-power}" for power in range(1, 5)] + ["triangles=500"] * 4

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


@pytest.mark.parametrize("limit", ["max_error=1", "max_mismatch=1", "max_error=1&max_mismatch=1"])
def test_a_count_and_a_limit_exclude_each_other(server, assert_problem, gamut, limit):
    for query in (f"triangles=10&{limit}", f"{limit}&triangles=10"):
        document = assert_problem(
            server.client.get(f"{gamut['links']['mesh']}?{query}"), 422, "invalid-parameter"
        )
        assert document["where"] == {"in": "query", "field": "triangles"}


@pytest.mark.parametrize("name", WITHOUT_DEVICE)
def test_a_format_is_named_in_three_ways(server, gamut, name):
    mesh = gamut["links"]["mesh"]
    media_type, suffix = FORMATS[name].media_type, FORMATS[name].suffix
    answers = [
        server.client.get(mesh, params={"format": name, "triangles": 50}),
        server.client.get(f"{mesh}{suffix}", params={"triangles": 50}),
        server.client.get(mesh, params={"triangles": 50}, headers={"Accept": media_type}),
    ]
    assert len({answer.content for answer in answers}) == 1
    for answer in answers:
        assert answer.headers["content-type"] == media_type
        assert answer.headers["vary"] == "Accept, Accept-Encoding"


def test_the_format_goes_before_the_suffix_and_the_suffix_before_accept(server, gamut):
    headers = {"Accept": "model/stl"}
    mesh = gamut["links"]["mesh"]
    answer = server.client.get(f"{mesh}.ply", headers=headers, params={"format": "obj"})
    assert answer.headers["content-type"] == "model/obj"
    answer = server.client.get(f"{mesh}.ply", headers=headers)
    assert answer.headers["content-type"] == "application/ply"


@pytest.mark.parametrize(
    ("accept", "expected"),
    [
        ("*/*", "model/gltf-binary"),
        ("model/gltf-binary;q=0.1, model/stl", "model/stl"),
        ("text/html, */*;q=0.1", "model/gltf-binary"),
        ("*/*, model/gltf-binary;q=0", "model/gltf+json"),
    ],
)
def test_accept_is_weighed(server, gamut, accept, expected):
    answer = server.client.get(gamut["links"]["mesh"], headers={"Accept": accept})
    assert answer.headers["content-type"] == expected


@pytest.mark.parametrize("accept", ["text/html", "image/png, text/*", "model/gltf-binary;q=0"])
def test_what_is_not_available_is_a_problem(server, assert_problem, gamut, accept):
    answer = server.client.get(gamut["links"]["mesh"], headers={"Accept": accept})
    document = assert_problem(answer, 406, "not-acceptable")
    assert document["where"]["available"] == [entry.media_type for entry in FORMATS.values()]


def test_an_envelope_is_of_the_full_boundary_and_for_three_channels(server, assert_problem, gamut):
    answer = server.client.get("/v1/gamuts/srgb/mesh", headers={"Accept": "application/x-idms-cge"})
    again = server.client.get("/v1/gamuts/srgb/mesh.cge")
    assert answer.content == again.content
    assert answer.content.startswith(b"CGATS.17\n")
    assert b"NUMBER_OF_SETS 602\n" in answer.content
    largest = server.client.get("/v1/gamuts/srgb").json()["counts"]["triangles"]
    assert answer.headers["gamut-triangles"] == str(largest)
    few = server.client.get("/v1/gamuts/srgb/mesh.cge", params={"triangles": 500})
    assert few.headers["gamut-triangles"] == "500"
    for address in (gamut["links"]["mesh"] + ".cge", f"{gamut['links']['mesh']}?format=cge"):
        document = assert_problem(server.client.get(address), 422, "invalid-option")
        assert document["where"] == {"field": "format"}
        assert "no device values" in document["detail"]
    batch = {"gamuts": f"srgb,{gamut['id']}", "triangles": 100, "format": "cge"}
    answer = server.client.get("/v1/meshes", params=batch)
    assert answer.status_code == 200
    assert answer.headers["gamut-failures"] == "1"
    assert answer.headers["cache-control"] == "no-store"


@pytest.mark.parametrize("name", ["gam", "icc"])
def test_formats_in_cielab_are_refused_for_other_spaces(server, assert_problem, sphere, name):
    posted = {"samples": sphere(seed=1), "options": {"space": "Oklab"}}
    gamut = server.client.post("/v1/gamuts", json=posted).json()
    answer = server.client.get(gamut["links"]["mesh"], params={"format": name})
    document = assert_problem(answer, 422, "invalid-option")
    assert document["where"] == {"field": "format"}
    assert "Oklab" in document["detail"]


def test_bytes_of_any_type_are_the_preferred_format(server, gamut):
    answer = server.client.get(
        gamut["links"]["mesh"], headers={"Accept": "application/octet-stream"}
    )
    assert answer.headers["content-type"] == "model/gltf-binary"
    assert answer.content[:4] == b"glTF"


def test_repeated_accept_fields_are_one_list(server, gamut):
    headers = [("Accept", "text/html"), ("Accept", "model/stl")]
    answer = server.client.get(gamut["links"]["mesh"], headers=headers)
    assert answer.headers["content-type"] == "model/stl"


@pytest.mark.parametrize("name", ["vrml", "", "GLB", "../glb"])
def test_unknown_formats_are_refused(server, assert_problem, gamut, name):
    answer = server.client.get(gamut["links"]["mesh"], params={"format": name})
    document = assert_problem(answer, 422, "invalid-parameter")
    assert document["where"]["field"] == "format"
    assert all(known in document["remedy"] for known in FORMATS)


@pytest.mark.parametrize("suffix", ["vrml", "GLB", "glb.gz"])
def test_unknown_suffixes_are_not_found(server, assert_problem, gamut, suffix):
    answer = server.client.get(f"{gamut['links']['mesh']}.{suffix}")
    assert ".ply" in assert_problem(answer, 404, "not-found")["remedy"]


@pytest.mark.parametrize(
    "query",
    ["triangles=60", "format=glb&triangles=60", "triangles=61&format=glb", "triangles=0000000060"],
    ids=["front", "front or route", "odd", "route"],
)
def test_every_way_to_a_mesh_gives_the_same_response(server, gamut, query):
    mesh = gamut["links"]["mesh"]
    first = server.client.get(f"{mesh}?{query}")
    assert first.headers["etag"] == f'"{hashlib.sha256(first.content).hexdigest()}"'
    assert first.headers["cache-control"] == IMMUTABLE
    reference = server.client.get(f"{mesh}?triangles=0000000060")
    fields = ("etag", "content-type", "content-length", "gamut-triangles", "cache-control", "vary")
    assert [first.headers[name] for name in fields] == [reference.headers[name] for name in fields]
    for known in (first.headers["etag"], f'"x", W/{first.headers["etag"]}', "*"):
        same = server.client.get(f"{mesh}?{query}", headers={"If-None-Match": known})
        assert (same.status_code, same.content) == (304, b"")
        assert same.headers["etag"] == first.headers["etag"]
        assert same.headers["cache-control"] == IMMUTABLE
        assert same.headers["vary"] == "Accept, Accept-Encoding"
        assert "content-type" not in same.headers
    other = server.client.get(f"{mesh}?{query}", headers={"If-None-Match": '"x"'})
    assert other.content == first.content
    head = server.client.head(f"{mesh}?{query}")
    assert (head.status_code, head.content) == (200, b"")
    assert [head.headers[name] for name in fields] == [first.headers[name] for name in fields]


def test_levels_of_a_large_gamut_are_served_as_well(server, sphere):
    gamut = server.client.post("/v1/gamuts", json={"samples": sphere(seed=31, count=6000)}).json()
    largest = gamut["counts"]["triangles"]
    assert largest > 10_000
    for _ in range(2):
        answer = server.client.get(gamut["links"]["mesh"], params={"triangles": largest})
        assert answer.headers["gamut-triangles"] == str(largest)


def test_device_values_come_along(server, gamut):
    """Of a profile, whose white is R = G = B = 1; not of bare colours."""
    made = server.client.post(
        "/v1/gamuts",
        files={"file": PROFILE.read_bytes()},
        data={"options": '{"surface_samples": 2000}'},
    ).json()
    for suffix, names in (
        ("ply", [f"device_{light}" for light in "RGB"]),
        ("glb", [f"_DEVICE_{light}" for light in "RGB"]),
    ):
        content = server.client.get(f"{made['links']['mesh']}.{suffix}?triangles=500").content
        mesh = trimesh.load(io.BytesIO(content), suffix, force="mesh", process=False)
        if suffix == "ply":
            stored = mesh.metadata["_ply_raw"]["vertex"]["data"]
        else:
            stored = mesh.vertex_attributes
        upwards = 0 if suffix == "ply" else 1  # glTF's scene is turned
        lightest = mesh.vertices[:, upwards].argmax()
        for name in names:
            assert len(stored[name]) == len(mesh.vertices)
            assert stored[name][lightest] > 0.99
        bare = server.client.get(f"{gamut['links']['mesh']}.{suffix}?triangles=100").content
        assert not any(name.encode() in bare for name in names)


@pytest.mark.parametrize("query", ["triangles=101", "max_error=1"])
@pytest.mark.parametrize("name", WITHOUT_DEVICE)
def test_a_download_has_a_file_name_from_the_cache_too(server, gamut, name, query):
    address = f"{gamut['links']['mesh']}?{query}&format={name}"
    answers = [server.client.get(address) for _ in range(2)]
    answers.append(server.client.get(address, headers={"Accept-Encoding": "gzip"}))
    for answer in answers:
        triangles = answer.headers["gamut-triangles"]
        expected = f'inline; filename="{gamut["name"]}-{triangles}{FORMATS[name].suffix}"'
        assert answer.headers["content-disposition"] == expected


@pytest.mark.parametrize("link", ["mesh", "history", "batch"])
def test_curl_saves_a_download_under_its_name(server, gamut, tmp_path, link):
    if shutil.which("curl") is None:
        pytest.skip("curl is not installed")
    start = gamut["id"][:12]
    path, name, begin = {
        "mesh": (f"{gamut['links']['mesh']}.ply?triangles=50", f"{gamut['name']}-50.ply", b"ply"),
        "history": (gamut["links"]["history"], f"{gamut['name']}.gamut", b""),
        "batch": (f"/v1/meshes?gamuts={gamut['id']}&triangles=50", f"{start}-meshes.zip", b"PK"),
    }[link]
    subprocess.run(["curl", "-sSOJ", server.url + path], cwd=tmp_path, check=True)
    (saved,) = tmp_path.iterdir()
    assert saved.name == name
    assert saved.read_bytes().startswith(begin)
    assert saved.stat().st_size > 100
