import concurrent.futures
import hashlib
import io
import json
import socket
import time
import zlib
from pathlib import Path
from urllib.parse import urlsplit

import httpx
import numpy as np
import pytest
import trimesh
from PIL import Image

from gamutcore.colours.appearance import srgb
from gamutcore.colours.spaces import SPACES, ColourSpace

UNKNOWN = "0" * 64
EXAMPLE = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"


def csv(points):
    rows = [",".join(map(repr, row)) for row in points]
    return "\n".join(["LAB_L,LAB_A,LAB_B", *rows]).encode()


# --- create ---------------------------------------------------------------------------------------


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
    broken = picture(np.zeros((4, 4, 3), np.uint8))[:60]
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
        {"samples": points, "options": {"gamma": 0.2}, "columns": ["LAB_L", "LAB_A", "LAB_B"]},
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
    assert "3 edges have one face only" in document["detail"]
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


def test_meshes_and_liveness_are_answered_during_a_build(start_server, slow_build, sphere):
    server = start_server()
    server.wait_ready()
    gamut = server.client.post("/v1/gamuts", json={"samples": sphere()}).json()
    job = server.client.post("/v1/gamuts", **slow_build(), headers={"Prefer": "respond-async"})
    assert job.status_code == 202
    answered = 0
    while server.client.get(job.headers["location"]).json()["state"] in {"queued", "running"}:
        assert server.client.get("/livez").status_code == 200
        assert server.client.get(gamut["links"]["mesh"]).status_code == 200
        answered += 1
    assert answered > 10
    assert server.client.get(job.headers["location"]).json()["state"] == "succeeded"
    server.stop()


# --- what is refused ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "code", "where"),
    [
        (b"LAB_L,LAB_A,LAB_X\n1,2,3\n", "missing-column", "field"),
        (b"\x00\x01\x02 no format at all", "unrecognised-format", None),
        (b"", "unrecognised-format", None),
        (b"LAB_L,LAB_A,LAB_B\n1,2,three\n", "malformed-file", "line"),
        (b"LAB_L,LAB_A,LAB_B\n1,2,3\n4,5,6\n", "too-few-points", None),
    ],
)
def test_files_that_cannot_be_used_are_explained(server, assert_problem, content, code, where):
    answer = server.client.post("/v1/gamuts", files={"file": content})
    document = assert_problem(answer, 422, code)
    assert where is None or where in document["where"]


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"gama": 0.2}, "gama"),
        ({"gamma": 2}, "gamma"),
        ({"gamma": "much"}, "gamma"),
        ({"space": "CMYK"}, "space"),
        ({"centre": [1, 2]}, "centre"),
        ({"surface_samples": 10**9}, "surface_samples"),
        ({"surface_samples": -1}, "surface_samples"),
        ({"segments": [16, 16]}, "segments"),
        ({"boundary": "segment-maxima", "segments": [10**9, 10**9]}, "segments"),
        ({"boundary": "segment-maxima", "segments": [16, None]}, "segments"),
        ({"boundary": "segment-maxima", "gamma": 0.2}, "gamma"),
        ({"boundary": "usv", "basis": "cube"}, "basis"),
        ({"boundary": "usv", "subdivisions": 8}, "subdivisions"),
        ({"boundary": "usv", "subdivisions": None}, "subdivisions"),
        ({"boundary": "convex-hull", "gamma": 0.2}, "gamma"),
        ([], "options"),
        ("gamma", "options"),
        (None, "options"),
    ],
)
def test_options_that_are_not_accepted_are_named(server, assert_problem, options, field):
    inline = server.client.post("/v1/gamuts", json={"samples": [[0, 0, 0]], "options": options})
    assert assert_problem(inline, 422, "invalid-option")["where"]["field"] == field
    part = server.client.post(
        "/v1/gamuts", files={"file": b"x"}, data={"options": json.dumps(options)}
    )
    assert assert_problem(part, 422, "invalid-option")["where"]["field"] == field


@pytest.mark.parametrize(
    ("body", "status", "code"),
    [
        (b"", 400, "malformed-body"),
        (b"{", 400, "malformed-body"),
        (b"\xff\xfe", 400, "malformed-body"),
        (b'{"samples": [[NaN, 0, 0]]}', 400, "malformed-body"),
        (b'{"samples": [[1e999, 0, 0]]}', 400, "malformed-body"),
        (b"[" * 100_000, 400, "malformed-body"),
        (b'{"samples": [[' + b"9" * 10_000 + b", 0, 0]]}", 400, "malformed-body"),
        (b"[[0, 0, 0]]", 422, "invalid-body"),
        (b"7", 422, "invalid-body"),
        (b"{}", 422, "invalid-body"),
        (b'{"samples": []}', 422, None),
        (b'{"samples": 7}', 422, "malformed-file"),
        (b'{"samples": [[0, 0, "a"]]}', 422, "malformed-file"),
        (b'{"samples": [[0, 0, 0]], "columns": ["R", "G", "B"]}', 422, "missing-column"),
        (b'{"samples": [[0, 0, 0]], "\\ud800": 1}', 422, None),
    ],
)
def test_json_that_cannot_be_used_is_explained(server, assert_problem, body, status, code):
    answer = server.client.post(
        "/v1/gamuts", content=body, headers={"Content-Type": "application/json"}
    )
    assert_problem(answer, status, code or answer.json()["code"])


def test_a_syntax_error_has_its_place(server, assert_problem):
    answer = server.client.post(
        "/v1/gamuts",
        content=b'{"samples":\n [[0,,0]]}',
        headers={"Content-Type": "application/json"},
    )
    where = assert_problem(answer, 400, "malformed-body")["where"]
    assert where == {"line": 2, "column": 6}
    part = server.client.post("/v1/gamuts", files={"file": b"x"}, data={"options": "{gamma}"})
    where = assert_problem(part, 400, "malformed-body")["where"]
    assert where == {"field": "options", "line": 1, "column": 2}


@pytest.mark.parametrize(
    ("parts", "field"),
    [
        ([("options", (None, b"{}"))], "file"),
        ([("data", ("a", b"x"))], "data"),
        ([("file", ("a", b"x")), ("file", ("b", b"y"))], "file"),
        ([("file", ("a", b"x")), ("gamma", (None, b"1"))], "gamma"),
    ],
)
def test_parts_that_are_missing_or_too_many_are_named(server, assert_problem, parts, field):
    answer = server.client.post("/v1/gamuts", files=parts)
    assert assert_problem(answer, 422, "invalid-body")["where"] == {"field": field}


@pytest.mark.parametrize(
    "body",
    [b"", b"no boundary here", b"--x\r\n\r\n", b"--x\r\nContent-Disposition: y\r\n\r\n--x--"],
)
@pytest.mark.parametrize("kind", ["multipart/form-data", "multipart/form-data; boundary=x"])
def test_multipart_that_cannot_be_parsed_is_a_problem(server, assert_problem, body, kind):
    answer = server.client.post("/v1/gamuts", content=body, headers={"Content-Type": kind})
    assert answer.status_code in {400, 422}
    assert_problem(answer, answer.status_code, answer.json()["code"])


@pytest.mark.parametrize(
    "kind", ["text/plain", "application/x-www-form-urlencoded", "", "nonsense"]
)
def test_other_media_types_are_refused_with_the_accepted_ones(server, assert_problem, kind):
    answer = server.client.post("/v1/gamuts", content=b"x", headers={"Content-Type": kind})
    document = assert_problem(answer, 415, "unsupported-media-type")
    assert "multipart/form-data" in document["remedy"]
    assert "application/json" in document["remedy"]


@pytest.mark.parametrize("form", ["declared", "chunked", "multipart", "chunked multipart"])
def test_bodies_over_the_limit_are_refused(server, assert_problem, form):
    size = 2_000_001
    head = b'--x\r\nContent-Disposition: form-data; name="file"; filename="a"\r\n\r\n'

    def chunks():
        yield head if "multipart" in form else b""
        for _ in range(size // 1000 + 1):
            yield bytes(1000)

    kind = "multipart/form-data; boundary=x" if "multipart" in form else "application/json"
    content = chunks() if "chunked" in form else b"".join(chunks())
    with httpx.Client(base_url=server.url, timeout=60) as client:
        answer = client.post("/v1/gamuts", content=content, headers={"Content-Type": kind})
    assert assert_problem(answer, 413, "body-too-large")["where"] == {"limit": 2_000_000}


def test_methods_that_are_not_allowed_come_with_those_that_are(server, assert_problem, gamut):
    answer = server.client.put("/v1/gamuts")
    assert_problem(answer, 405, "method-not-allowed")
    assert answer.headers["allow"] == "GET, HEAD, POST"
    answer = server.client.post(gamut["links"]["self"])
    assert answer.headers["allow"] == "DELETE, GET, HEAD"


# --- read -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("below", ["", "/levels", "/history", "/mesh", "/mesh.ply"])
def test_unknown_gamuts_are_not_found(server, assert_problem, below):
    answer = server.client.get(f"/v1/gamuts/{UNKNOWN}{below}")
    assert UNKNOWN in assert_problem(answer, 404, "gamut-not-found")["detail"]


@pytest.mark.parametrize("name", ["x", "A" * 64, "0" * 63, "0" * 65, "..%2f..", "%00", "é"])
@pytest.mark.parametrize("below", ["", "/levels", "/history", "/mesh", "/mesh.ply"])
def test_names_that_are_no_ids_are_refused(server, assert_problem, name, below):
    answer = server.client.get(f"/v1/gamuts/{name}{below}")
    if answer.status_code == 404:
        assert_problem(answer, 404, "not-found")
    else:
        assert_problem(answer, 422, "invalid-parameter")


@pytest.mark.parametrize("link", ["self", "levels", "history"])
def test_what_the_client_has_is_not_sent_again(server, gamut, link):
    first = server.client.get(gamut["links"][link])
    assert first.headers["etag"] == f'"{hashlib.sha256(first.content).hexdigest()}"'
    same = server.client.get(gamut["links"][link], headers={"If-None-Match": first.headers["etag"]})
    assert (same.status_code, same.content) == (304, b"")
    assert same.headers["etag"] == first.headers["etag"]
    other = server.client.get(gamut["links"][link], headers={"If-None-Match": '"other"'})
    assert other.content == first.content
    head = server.client.head(gamut["links"][link])
    assert (head.status_code, head.content) == (200, b"")
    assert head.headers["etag"] == first.headers["etag"]
    assert head.headers["content-length"] == str(len(first.content))


def test_levels_and_history_never_change(server, gamut):
    for link in ("levels", "history"):
        cache = server.client.get(gamut["links"][link]).headers["cache-control"]
        assert cache == "public, max-age=31536000, immutable"


def test_the_levels_are_those_of_the_description(server, gamut):
    answer = server.client.get(gamut["links"]["levels"]).json()
    assert answer == {"id": gamut["id"], "levels": gamut["levels"]}


def test_parts_of_a_history_make_up_the_whole(server, gamut):
    address = gamut["links"]["history"]
    whole = server.client.get(address)
    assert len(whole.content) == gamut["history_bytes"]
    assert whole.headers["accept-ranges"] == "bytes"
    parts = []
    for start in range(0, len(whole.content), 5000):
        part = server.client.get(address, headers={"Range": f"bytes={start}-{start + 4999}"})
        assert part.status_code == 206
        end = start + len(part.content) - 1
        assert part.headers["content-range"] == f"bytes {start}-{end}/{len(whole.content)}"
        parts.append(part.content)
    assert b"".join(parts) == whole.content


@pytest.mark.parametrize("part", ["bytes=0-9", "bytes=99999999-"])
def test_head_is_of_the_whole_history_whatever_part_is_asked_for(server, gamut, part):
    # RFC 9110, 14.2: only GET has ranges.
    answer = server.client.head(gamut["links"]["history"], headers={"Range": part})
    assert answer.status_code == 200
    assert int(answer.headers["content-length"]) == gamut["history_bytes"]
    assert "content-range" not in answer.headers


def test_a_range_behind_the_end_is_a_problem(server, assert_problem, gamut):
    answer = server.client.get(gamut["links"]["history"], headers={"Range": "bytes=99999999-"})
    assert_problem(answer, 416, "range-not-satisfiable")
    assert answer.headers["content-range"] == f"bytes */{gamut['history_bytes']}"


# --- list and delete ------------------------------------------------------------------------------


def test_pages_lead_through_all_gamuts(start_server, sphere):
    server = start_server(max_page_size=2)
    server.wait_ready()
    assert server.client.get("/v1/gamuts").json() == {"gamuts": [], "next": None}
    ids = {
        server.client.post("/v1/gamuts", json={"samples": sphere(seed)}).json()["id"]
        for seed in range(5)
    }
    found, address = [], "/v1/gamuts?limit=100"
    while address:
        answer = server.client.get(address)
        page = answer.json()
        assert 1 <= len(page["gamuts"]) <= 2
        found += [gamut["id"] for gamut in page["gamuts"]]
        address = page["next"]
        assert answer.links.get("next", {}).get("url") == address
    assert found == sorted(ids)
    server.stop()


@pytest.mark.parametrize("query", ["limit=0", "limit=many", "after=x", "after=%00"])
def test_wrong_pages_are_refused(server, assert_problem, query):
    document = assert_problem(server.client.get(f"/v1/gamuts?{query}"), 422, "invalid-parameter")
    assert document["where"] == {"in": "query", "field": query.partition("=")[0]}


def test_nothing_of_a_deleted_gamut_is_left(server, assert_problem, sphere):
    body = {"samples": sphere(seed=20)}
    gamut = server.client.post("/v1/gamuts", json=body).json()
    for link in gamut["links"].values():
        assert server.client.get(link).status_code == 200
    answer = server.client.delete(gamut["links"]["self"])
    assert (answer.status_code, answer.content) == (204, b"")
    for link in gamut["links"].values():
        assert_problem(server.client.get(link), 404, "gamut-not-found")
    assert_problem(server.client.get(f"/v1/jobs/{gamut['id']}"), 404, "job-not-found")
    assert_problem(server.client.delete(gamut["links"]["self"]), 404, "gamut-not-found")
    again = server.client.post("/v1/gamuts", json=body)
    assert again.status_code == 201
    assert again.json()["id"] == gamut["id"]


# --- restarts, damage, death ----------------------------------------------------------------------


def test_what_was_built_outlives_a_power_cut(start_server, sphere):
    first = start_server()
    gamut = first.client.post("/v1/gamuts", json={"samples": sphere()}).json()
    mesh = first.client.get(gamut["links"]["mesh"]).content
    first.kill()
    second = start_server(data=first.data)
    assert second.client.get(gamut["links"]["self"]).json() == gamut
    assert second.client.get(gamut["links"]["mesh"]).content == mesh
    assert second.client.get(f"/v1/jobs/{gamut['id']}").json()["state"] == "succeeded"
    second.wait_ready()
    assert second.client.post("/v1/gamuts", json={"samples": sphere()}).status_code == 200
    second.stop()


def test_damaged_files_are_never_served_and_built_again(start_server, sphere, assert_problem):
    first = start_server()
    bodies = [{"samples": sphere(seed)} for seed in range(4)]
    gamuts = [first.client.post("/v1/gamuts", json=body).json() for body in bodies]
    meshes = [first.client.get(gamut["links"]["mesh"]).content for gamut in gamuts]
    first.stop()
    for gamut, suffix, position in zip(
        gamuts, ("gamut", "gamut", "record", "record"), (0.1, 0.9, 0.1, 0.9), strict=True
    ):
        (path,) = first.data.rglob(f"{gamut['id']}*.{suffix}")
        content = bytearray(path.read_bytes())
        content[int(position * len(content))] ^= 4
        path.write_bytes(content)
    second = start_server(data=first.data)
    for gamut, mesh in zip(gamuts, meshes, strict=True):
        answer = second.client.get(gamut["links"]["mesh"])
        problem = assert_problem(answer, 503, "gamut-rebuilding")
        assert int(answer.headers["retry-after"]) >= 1
        assert second.finished_job(problem["where"]["job"])["state"] == "succeeded"
        assert second.client.get(gamut["links"]["mesh"]).content == mesh
        assert second.client.get(gamut["links"]["history"]).status_code == 200
    assert len(list((first.data / "quarantine").iterdir())) >= 4
    second.stop()


def test_a_build_beyond_its_deadline_is_a_problem(start_server, slow_build, sphere, assert_problem):
    server = start_server(build_timeout=0.5)
    server.wait_ready()
    answer = server.client.post("/v1/gamuts", **slow_build())
    assert_problem(answer, 422, "build-timeout")
    server.worker(2)
    assert server.client.post("/v1/gamuts", json={"samples": sphere()}).status_code == 201
    server.stop()


def test_a_gamut_whose_history_is_gone_is_built_anew_by_posting(server, sphere, assert_problem):
    body = {"samples": sphere(seed=41)}
    first = server.client.post("/v1/gamuts", json=body).json()

    def lose_history():
        (history,) = server.data.rglob(f"published/*/{first['id']}*.gamut")
        history.unlink()

    lose_history()
    assert_problem(server.client.get(first["links"]["self"]), 503, "gamut-rebuilding")
    assert server.client.post("/v1/gamuts", json=body).status_code in {200, 201}
    assert server.client.get(first["links"]["history"]).status_code == 200
    lose_history()
    assert server.client.post("/v1/gamuts", json=body).status_code == 201
