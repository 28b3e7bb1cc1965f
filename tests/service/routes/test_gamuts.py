"""Gamuts are built from whatever is posted, once each, and while their clients come and go."""

import io
import json
import socket
import zlib
from urllib.parse import urlsplit

import numpy as np
import pytest
import trimesh
from PIL import Image

from gamutcore.colours.spaces import SPACES, ColourSpace, srgb
from service.application import create_app
from service.routes import paging
from service.settings import Settings

ASYNC = {"Prefer": "respond-async"}


def csv(points):
    rows = [",".join(map(repr, row)) for row in points]
    return "\n".join(["LAB_L,LAB_A,LAB_B", *rows]).encode()


def test_inline_samples_are_built_and_found_again(server, sphere):
    body = {"samples": sphere(seed=2), "options": {"gamma": 0.5}}
    first = server.client.post("/v1/gamuts", json=body)
    assert first.status_code == 201
    gamut = first.json()
    assert first.headers["location"] == gamut["links"]["self"] == f"/v1/gamuts/{gamut['id']}"
    assert gamut["options"]["gamma"] == 0.5
    assert gamut["options"]["space"] == "CIELAB"
    again = server.client.post("/v1/gamuts", json=body)
    assert again.status_code == 200
    assert again.headers["content-location"] == first.headers["location"]
    assert again.json() == gamut == server.client.get(gamut["links"]["self"]).json()
    assert server.builds_started(gamut["id"]) == 1


def picture(pixels, file_format="PNG"):
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, file_format)
    return stream.getvalue()


def test_a_picture_is_built_and_its_least_used_colours_left_out(server):
    pixels = np.random.default_rng(0).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    pixels[:, 1:] = pixels[:, :1] // 2  # the full range is in a thirtieth of the pixels
    posted = {"files": {"file": picture(pixels)}}
    every = server.client.post("/v1/gamuts", **posted)
    assert every.status_code == 201
    assert every.json()["provenance"]["size"] == [30, 20]
    popular = server.client.post("/v1/gamuts", **posted, data={"options": '{"popularity": 0.04}'})
    assert popular.status_code == 201
    assert popular.json()["options"]["popularity"] == 0.04
    assert popular.json()["volume"] < every.json()["volume"]


def test_pictures_that_cannot_be_used_are_refused_by_name(server):
    bomb = bytearray(picture(np.zeros((4, 4, 3), np.uint8)))
    bomb[16:24] = (60_000).to_bytes(4, "big") * 2
    bomb[29:33] = zlib.crc32(bomb[12:29]).to_bytes(4, "big")
    cmyk = io.BytesIO()
    Image.new("CMYK", (8, 8)).save(cmyk, "JPEG")
    broken = picture(np.zeros((4, 4, 3), np.uint8))[:45]
    for content, code in (
        (bytes(bomb), "picture-too-large"),
        (cmyk.getvalue(), "unsupported-picture"),
        (broken, "malformed-file"),
        (picture(np.zeros((4, 4), np.uint8)), "too-few-points"),
    ):
        answer = server.client.post("/v1/gamuts", files={"file": content})
        assert (answer.status_code, answer.json()["code"]) == (422, code)
        assert answer.json()["remedy"]


def test_a_file_is_recognised_by_its_content(server, sphere):
    files = {"file": ("data.bin", csv(sphere(seed=4)), "application/octet-stream")}
    answer = server.client.post("/v1/gamuts", files=files, data={"options": '{"gamma": 1}'})
    assert answer.status_code == 201
    assert answer.json()["options"]["gamma"] == 1
    as_parts = {**files, "options": ("o.json", b'{"gamma": 1}', "application/json")}
    assert server.client.post("/v1/gamuts", files=as_parts).status_code == 200


@pytest.mark.parametrize(
    ("options", "triangles"),
    [
        ({"gamma": 1}, None),
        ({"boundary": "segment-maxima"}, 512),
        ({"boundary": "segment-maxima", "segments": [5, 7]}, 70),
        ({"boundary": "segment-maxima", "segments": [180, 360]}, 129_600),
        ({"boundary": "usv", "basis": "tetrahedron", "subdivisions": 1}, 28),
        ({"boundary": "usv", "subdivisions": 7, "gamma": 1}, None),
    ],
)
def test_every_boundary_is_built_and_decimated(server, sphere, assert_problem, options, triangles):
    body = {"samples": sphere(seed=90, count=600), "options": options}
    answer = server.client.post("/v1/gamuts", json=body)
    assert answer.status_code == 201, answer.text
    gamut = answer.json()
    assert options.items() <= gamut["options"].items()
    assert triangles is None or gamut["counts"]["triangles"] == triangles
    # the options as they are answered ask the same question again
    again = server.client.post("/v1/gamuts", json={**body, "options": gamut["options"]})
    assert (again.status_code, again.json()["id"]) == (200, gamut["id"])
    mesh = server.client.get(gamut["links"]["mesh"], params={"triangles": 20})
    assert mesh.headers["gamut-triangles"] == "20"
    if triangles and triangles > 100_000:
        picture = server.client.get(f"{gamut['links']['self']}/picture.png?max_error=0")
        document = assert_problem(picture, 422, "triangle-count")
        assert document["where"] == {"field": "max_error"}


@pytest.mark.parametrize("name", SPACES)
def test_every_colour_space_is_built_and_exported(server, sphere, name):
    body = {"samples": sphere(seed=91, count=500), "options": {"space": name, "gamma": 1}}
    answer = server.client.post("/v1/gamuts", json=body)
    assert answer.status_code == 201, answer.text
    gamut = answer.json()
    assert gamut["options"]["space"] == gamut["provenance"]["colour_space"]["name"] == name
    assert gamut["provenance"]["axes"] == " ".join(SPACES[name].axes)
    # the options as they are answered ask the same question again
    again = server.client.post("/v1/gamuts", json={**body, "options": gamut["options"]})
    assert (again.status_code, again.json()["id"]) == (200, gamut["id"])
    query = {"triangles": gamut["counts"]["triangles"]}
    ply = server.client.get(gamut["links"]["mesh"], params={**query, "format": "ply"}).content
    header = ply.partition(b"end_header")[0].decode()
    assert f"comment space: {name}\n" in header
    assert f"comment axes: {' '.join(SPACES[name].axes)}\n" in header
    mesh = trimesh.load(io.BytesIO(ply), file_type="ply", process=False)
    lab = ColourSpace(name).appearance_lab(np.asarray(mesh.vertices, np.float32))
    # back in CIELAB all vertices are on the sphere that was sent
    np.testing.assert_allclose(np.linalg.norm(lab - (50, 0, 0), axis=1), 40, atol=0.01)
    shown = 255 * srgb(np.ascontiguousarray(lab, np.float32))
    assert np.abs(shown - mesh.visual.vertex_colors[:, :3]).max() <= 1
    glb = server.client.get(gamut["links"]["mesh"], params=query)
    scene = trimesh.load(io.BytesIO(glb.content), file_type="glb", process=False)
    (placed,) = scene.dump()
    # lightness is shown along y
    lightest = placed.vertices[np.argmax(lab[:, 0]), 1]
    assert lightest >= np.sort(placed.vertices[:, 1])[-len(lab) // 20]


def test_segments_that_do_not_surround_the_centre_are_a_problem(server, assert_problem):
    """Of a cube's corners the farthest in the four segments of a tetrahedron, all on one side."""
    corners = [[50 + x, y, z] for x in (-30, 30) for y in (-30, 30) for z in (-39, 51)]
    options = {"boundary": "usv", "basis": "tetrahedron", "subdivisions": 0, "centre": [65, 15, 15]}
    answer = server.client.post("/v1/gamuts", json={"samples": corners, "options": options})
    document = assert_problem(answer, 422, "boundary-failed")
    assert document["where"] == {"field": "subdivisions"}
    assert "more subdivisions" in document["remedy"]


@pytest.mark.parametrize("name", ["ply", "glb", "gltf", "stl", "obj", "3mf", "gam"])
def test_a_downloaded_mesh_is_a_gamut_again(server, gamut, name):
    """Its full boundary are the triangles that were downloaded, about the same centre."""
    address = gamut["links"]["mesh"]
    mesh = server.client.get(address, params={"triangles": 100, "format": name})
    answer = server.client.post("/v1/gamuts", files={"file": ("mesh", mesh.content)})
    assert answer.status_code in {200, 201}, answer.text
    made = answer.json()
    assert made["counts"]["triangles"] == 100
    (level,) = [level for level in gamut["levels"] if level["triangles"] == 100] or [None]
    assert level is None or made["volume"] == pytest.approx(level["volume"], rel=1e-9)
    assert made["provenance"]["format"] == {"gam": "argyll-gam"}.get(name, name)
    assert made["provenance"]["mesh"]["triangles_read"] == 100
    if name != "stl":  # has no place for a centre
        assert made["centre"] == gamut["centre"]
    again = server.client.post(
        "/v1/gamuts",
        files={"file": ("mesh", mesh.content)},
        data={"options": json.dumps(made["options"])},
    )
    assert (again.status_code, again.json()["id"]) == (200, made["id"])


@pytest.mark.parametrize("name", ["webp", "gif", "bmp"])
def test_pictures_of_the_web_are_gamuts_and_damaged_ones_a_problem(server, assert_problem, name):
    pixels = np.array(list(np.ndindex(2, 2, 2)), np.uint8).reshape(2, 4, 3) * 255
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, name, **({"lossless": True} if name == "webp" else {}))
    answer = server.client.post("/v1/gamuts", files={"file": file.getvalue()})
    assert answer.status_code in {200, 201}, answer.text
    provenance = answer.json()["provenance"]
    assert provenance["format"] == name
    assert provenance["warnings"] == ["No profile is embedded: sRGB is assumed."]
    answer = server.client.post("/v1/gamuts", files={"file": file.getvalue()[:-6]})
    assert_problem(answer, 422, "malformed-file")


def test_a_mesh_that_is_no_boundary_is_a_problem(server, gamut, assert_problem):
    text = server.client.get(gamut["links"]["mesh"], params={"triangles": 20, "format": "obj"}).text
    lines = text.strip().splitlines()
    answer = server.client.post("/v1/gamuts", files={"file": "\n".join(lines[:-1]).encode()})
    document = assert_problem(answer, 422, "invalid-mesh")
    assert "3 edges" in document["detail"]
    assert document["where"]["field"] == "faces"
    files = {"file": text.encode()}
    answer = server.client.post("/v1/gamuts", files=files, data={"options": '{"gamma": 0.5}'})
    assert assert_problem(answer, 422, "invalid-option")["where"] == {"field": "gamma"}


def test_a_build_goes_on_when_its_client_leaves(server, sphere):
    body = json.dumps({"samples": sphere(seed=9, count=10_000)}).encode()
    address = urlsplit(server.url)
    head = (
        f"POST /v1/gamuts HTTP/1.1\r\nHost: {address.netloc}\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\n\r\n"
    )
    before = server.log().count("started, attempt")
    with socket.create_connection((address.hostname, address.port)) as connection:
        connection.sendall(head.encode() + body)
        server.wait_for(lambda: server.log().count("started, attempt") > before)
    answer = server.client.post(
        "/v1/gamuts", content=body, headers={"Content-Type": "application/json"}
    )
    assert answer.status_code in {200, 201}
    assert server.builds_started(answer.json()["id"]) == 1


def test_meshes_and_liveness_are_answered_during_a_build(server, slow_build, gamut):
    job = server.client.post("/v1/gamuts", **slow_build(10_000), headers=ASYNC)
    assert job.status_code == 202
    address = job.headers["location"]
    answered = 0
    while server.client.get(address).json()["finished"] is None:
        assert server.client.get("/livez").status_code == 200
        assert server.client.get(gamut["links"]["mesh"]).status_code == 200
        answered += 1
    assert answered > 0
    assert server.client.get(address).json()["state"] == "succeeded"


# --- reading and deleting -------------------------------------------------------------------------


def test_a_gamut_has_its_levels_and_a_history_that_never_change(server, gamut):
    levels = server.client.get(gamut["links"]["levels"])
    assert levels.json() == {"id": gamut["id"], "levels": gamut["levels"]}
    history = server.client.get(gamut["links"]["history"])
    assert len(history.content) == gamut["history_bytes"]
    for answer in (levels, history):
        assert answer.headers["cache-control"] == "public, max-age=31536000, immutable"


def test_pages_lead_through_all_gamuts_and_jobs_once_and_in_order(small_server, sphere):
    server = small_server
    ids = {
        server.client.post("/v1/gamuts", json={"samples": sphere(seed, count=40)}).json()["id"]
        for seed in range(300, 305)
    }
    for kind in ("gamuts", "jobs"):
        found, address = [], f"/v1/{kind}?limit=2"
        while address:
            answer = server.client.get(address)
            page = answer.json()
            assert 1 <= len(page[kind]) <= 2
            found += [each["id"] for each in page[kind]]
            address = page["next"]
            assert answer.links.get("next", {}).get("url") == address
        assert found == sorted(set(found))
        assert ids <= set(found)
    nothing = {"gamuts": [], "next": None}
    assert server.client.get("/v1/gamuts", params={"name": "nobody"}).json() == nothing


def test_a_page_has_no_more_than_the_service_gives(filled_store, request_app, monkeypatch):
    monkeypatch.setattr(paging, "MOST_ENTRIES", 1)
    app = create_app(Settings(store=str(filled_store.blobs.directory)))
    page = request_app(app, "GET", "/v1/gamuts?limit=100").json()
    assert [each["id"] for each in page["gamuts"]] == list(filled_store.ids())[:1]
    assert page["next"]


def test_nothing_of_a_deleted_gamut_is_left(server, assert_problem, sphere):
    body = {"samples": sphere(seed=20), "name": "Gone"}
    gamut = server.client.post("/v1/gamuts", json=body).json()
    own = gamut["links"]["self"]
    for link in gamut["links"].values():
        assert server.client.get(link).status_code == 200
    for named in ('"x"', server.client.get(gamut["links"]["history"]).headers["etag"]):
        kept = server.client.delete(own, headers={"If-Match": named})
        assert_problem(kept, 412, "precondition-failed")
    etag = server.client.get(own, headers={"Accept-Encoding": "gzip"}).headers["etag"]
    answer = server.client.delete(own, headers={"If-Match": etag})
    assert (answer.status_code, answer.content) == (204, b"")
    for link in (*gamut["links"].values(), f"{own}/mesh.ply", f"{own}/viewer.html"):
        assert_problem(server.client.get(link), 404, "gamut-not-found")
    assert_problem(server.client.get(f"/v1/jobs/{gamut['id']}"), 404, "job-not-found")
    assert_problem(server.client.delete(own), 404, "gamut-not-found")
    again = server.client.post("/v1/gamuts", json={"samples": body["samples"]})
    assert (again.status_code, again.json()["id"]) == (201, gamut["id"])
    assert again.json()["name"] != "Gone"
