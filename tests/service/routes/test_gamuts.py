"""Gamuts are built from whatever is posted, once each, and while their clients come and go."""

import concurrent.futures
import io
import json
import socket
import time
import zlib
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
import trimesh
from PIL import Image

from gamutcore.colours.spaces import SPACES, ColourSpace
from gamutcore.colours.spaces.srgb import srgb

EXAMPLE = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"


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


def test_the_same_question_has_the_same_address(server, sphere):
    points = sphere(seed=3)
    text = json.dumps({"columns": ["LAB_L", "LAB_A", "LAB_B"], "samples": points})
    shuffled = json.dumps(
        {"samples": points, "options": {"gamma": "auto"}, "columns": ["LAB_L", "LAB_A", "LAB_B"]},
        indent=3,
    )
    headers = {"Content-Type": "application/json; charset=utf-8"}
    answers = [
        server.client.post("/v1/gamuts", content=body, headers=headers) for body in (text, shuffled)
    ]
    assert [answer.status_code for answer in answers] == [201, 200]
    other = server.client.post("/v1/gamuts", json={"samples": points, "options": {"gamma": 0.3}})
    assert other.json()["id"] != answers[0].json()["id"]


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"ink_limit": 300}, "ink_limit"),
        ({"black_limit": 90}, "black_limit"),
        ({"source": "measurements"}, "source"),
        ({"device_model": "fit"}, "device_model"),
    ],
)
def test_options_that_the_data_does_not_have_are_refused(
    server, sphere, assert_problem, options, field
):
    body = {"samples": sphere(seed=5), "options": options}
    answer = server.client.post("/v1/gamuts", json=body)
    assert assert_problem(answer, 422, "invalid-option")["where"] == {"field": field}


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
        ({"boundary": "convex-hull"}, None),
        ({"boundary": "segment-maxima"}, 512),
        ({"boundary": "segment-maxima", "segments": [5, 7]}, 70),
        ({"boundary": "segment-maxima", "segments": [180, 360]}, 129_600),
        ({"boundary": "usv", "basis": "tetrahedron", "subdivisions": 1}, 28),
        ({"boundary": "usv", "subdivisions": 7, "gamma": 1}, None),
    ],
)
def test_every_boundary_is_built_and_decimated(server, sphere, options, triangles):
    body = {"samples": sphere(seed=90, count=600), "options": options}
    answer = server.client.post("/v1/gamuts", json=body, headers={"Prefer": "wait=60"})
    assert answer.status_code == 201, answer.text
    gamut = answer.json()
    assert options.items() <= gamut["options"].items()
    assert triangles is None or gamut["counts"]["triangles"] == triangles
    # the options as they are answered ask the same question again
    again = server.client.post("/v1/gamuts", json={**body, "options": gamut["options"]})
    assert (again.status_code, again.json()["id"]) == (200, gamut["id"])
    mesh = server.client.get(gamut["links"]["mesh"], params={"triangles": 20})
    assert mesh.headers["gamut-triangles"] == "20"


@pytest.mark.parametrize("name", SPACES)
def test_every_colour_space_is_built_and_exported(server, sphere, name):
    body = {"samples": sphere(seed=91, count=500), "options": {"space": name, "gamma": 1}}
    answer = server.client.post("/v1/gamuts", json=body, headers={"Prefer": "wait=60"})
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


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"space": "CIELAB", "luminance": 100}, "luminance"),
        ({"space": "ICtCp", "luminance": 1e5}, "luminance"),
        ({"space": "ICtCp", "luminance": "measured"}, "luminance"),  # of bare colours
        ({"space": "Oklab", "background": 20}, "background"),
        ({"space": "CAM16-UCS", "surround": "bright"}, "surround"),
        ({"space": "CIEXYZ", "reference_white": [0, 1, 1]}, "reference_white"),
        ({"adaptation": "best"}, "adaptation"),
        ({"space": "HSV"}, "space"),
    ],
)
def test_options_that_a_space_does_not_have_are_refused(
    server, sphere, assert_problem, options, field
):
    body = {"samples": sphere(seed=92), "options": options}
    answer = server.client.post("/v1/gamuts", json=body)
    assert assert_problem(answer, 422, "invalid-option")["where"] == {"field": field}


def test_segments_that_do_not_surround_the_centre_are_a_problem(server, assert_problem):
    """Of a cube's corners the farthest in the four segments of a tetrahedron, all on one side."""
    corners = [[50 + x, y, z] for x in (-30, 30) for y in (-30, 30) for z in (-39, 51)]
    options = {"boundary": "usv", "basis": "tetrahedron", "subdivisions": 0, "centre": [65, 15, 15]}
    answer = server.client.post("/v1/gamuts", json={"samples": corners, "options": options})
    document = assert_problem(answer, 422, "boundary-failed")
    assert document["where"] == {"field": "subdivisions"}
    assert "more subdivisions" in document["remedy"]


def test_a_real_press_is_built_while_the_client_waits(server):
    if not EXAMPLE.exists():
        pytest.skip("examples/FOGRA39L.ti3 is not there")
    answer = server.client.post("/v1/gamuts", files={"file": EXAMPLE.read_bytes()})
    assert answer.status_code == 201
    gamut = answer.json()
    assert gamut["provenance"]["format"] == "cgats"
    mesh = server.client.get(gamut["links"]["mesh"], params={"triangles": 1000})
    assert mesh.headers["gamut-triangles"] == "1000"
    assert mesh.content[:4] == b"glTF"


@pytest.mark.parametrize("name", ["ply", "glb", "gltf", "stl", "obj"])
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
    assert made["provenance"]["format"] == name
    assert made["provenance"]["mesh"]["triangles_read"] == 100
    if name != "stl":  # has no place for a centre
        assert made["centre"] == gamut["centre"]
    again = server.client.post(
        "/v1/gamuts",
        files={"file": ("mesh", mesh.content)},
        data={"options": json.dumps(made["options"])},
    )
    assert (again.status_code, again.json()["id"]) == (200, made["id"])


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


@pytest.mark.parametrize("prefer", ["respond-async", "wait=0"])
def test_a_client_that_does_not_wait_gets_a_job(server, sphere, prefer):
    body = {"samples": sphere(seed={"wait=0": 5}.get(prefer, 6))}
    answer = server.client.post("/v1/gamuts", json=body, headers={"Prefer": prefer})
    assert answer.status_code == 202
    assert answer.headers["preference-applied"] == prefer
    assert int(answer.headers["retry-after"]) >= 0
    address = answer.headers["location"]
    job = server.finished_job(address)
    assert server.client.get(job["links"]["gamut"]).status_code == 200
    found = server.client.post("/v1/gamuts", json=body, headers={"Prefer": "wait=3"})
    assert found.status_code == 200


def test_a_wait_that_is_honoured_is_confirmed(server, sphere):
    answer = server.client.post(
        "/v1/gamuts", json={"samples": sphere(seed=7)}, headers={"Prefer": "respond-async, wait=60"}
    )
    assert answer.status_code == 201
    assert answer.headers["preference-applied"] == "wait=60"


def test_identical_requests_at_the_same_time_are_built_once(server, sphere):
    body = {"samples": sphere(seed=8, count=20000)}
    with concurrent.futures.ThreadPoolExecutor(20) as threads:
        answers = list(
            threads.map(lambda _: server.client.post("/v1/gamuts", json=body), range(40))
        )
    assert {answer.status_code for answer in answers} <= {200, 201}
    assert len({answer.content for answer in answers}) == 1
    assert server.builds_started(answers[0].json()["id"]) == 1


def test_a_build_goes_on_when_its_client_leaves(server, sphere):
    body = json.dumps({"samples": sphere(seed=9, count=20000)}).encode()
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


def test_a_client_that_leaves_in_its_upload_does_no_harm(server):
    address = urlsplit(server.url)
    for kind in ("application/json", "multipart/form-data; boundary=x"):
        head = (
            f"POST /v1/gamuts HTTP/1.1\r\nHost: {address.netloc}\r\nContent-Type: {kind}\r\n"
            "Content-Length: 1000\r\n\r\n--x\r\n"
        )
        with socket.create_connection((address.hostname, address.port)) as connection:
            connection.sendall(head.encode())
            time.sleep(0.05)
    assert server.client.get("/livez").status_code == 200
    assert "Traceback" not in server.log()


def test_meshes_and_liveness_are_answered_during_a_build(server, slow_build, gamut):
    arguments = slow_build(40_000)
    job = server.client.post("/v1/gamuts", **arguments, headers={"Prefer": "respond-async"})
    assert job.status_code == 202
    answered = 0
    while server.client.get(job.headers["location"]).json()["state"] in {"queued", "running"}:
        assert server.client.get("/livez").status_code == 200
        assert server.client.get(gamut["links"]["mesh"]).status_code == 200
        answered += 1
    assert answered > 10
    assert server.client.get(job.headers["location"]).json()["state"] == "succeeded"
