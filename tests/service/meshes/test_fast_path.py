import asyncio

import pytest

from service.meshes.encoding import EncodedMesh
from service.meshes.fast_path import MeshFastPath
from service.meshes.requested_levels import LevelRequest

NAME = "0a" * 32
MESH = EncodedMesh.of(b"body", "model/stl", ("a", "-4.stl"), 4, 4)


class Recorder:
    """Stands for the meshes: everything is at hand, and every question is written down."""

    def __init__(self):
        self.asked = None

    def find_ready(self, *question):
        self.asked = question
        return MESH


@pytest.fixture
def ask():
    """Send a request to the front; what it asked for, and whether the app behind it was reached."""

    def request(path, query="", headers=(), method="GET"):
        meshes, reached, sent = Recorder(), [], []

        async def app(_scope, _receive, _send):
            reached.append(True)

        async def send(message):
            sent.append(message)

        scope = {
            "type": "http",
            "method": method,
            "path": path,
            "query_string": query.encode(),
            "headers": list(headers),
        }
        asyncio.run(MeshFastPath(app, meshes)(scope, None, send))
        return meshes.asked, bool(reached), sent

    return request


@pytest.mark.parametrize(
    ("suffix", "query", "headers", "question"),
    [
        ("", "", [], (LevelRequest(), "glb")),
        ("", "triangles=100", [], (LevelRequest(100), "glb")),
        ("", "triangles=100&format=ply", [], (LevelRequest(100), "ply")),
        ("", "format=ply", [], (LevelRequest(), "ply")),
        ("", "side=both", [], (LevelRequest(), "glb")),
        ("", "triangles=8&side=inside", [], (LevelRequest(8, side="inside"), "glb")),
        ("", "side=outside&format=stl", [], (LevelRequest(side="outside"), "stl")),
        (".obj", "triangles=7", [], (LevelRequest(7), "obj")),
        (".obj", "format=stl", [], (LevelRequest(), "stl")),
        ("", "max_error=0.5", [], (LevelRequest(None, 0.5), "glb")),
        ("", "max_error=5e-1&format=ply", [], (LevelRequest(None, 0.5), "ply")),
        ("", "max_mismatch=0.001", [], (LevelRequest(None, None, 0.001), "glb")),
        (".ply", "max_error=0&max_mismatch=1E-3", [], (LevelRequest(None, 0.0, 0.001), "ply")),
        ("", "", [(b"accept", b"model/stl")], (LevelRequest(), "stl")),
        ("", "", [(b"accept", b"text/html"), (b"accept", b"model/stl")], (LevelRequest(), "stl")),
    ],
)
def test_plain_requests_are_answered_here(ask, suffix, query, headers, question):
    asked, reached, sent = ask(f"/v1/gamuts/{NAME}/mesh{suffix}", query, headers)
    assert asked == (NAME, *question, "")
    assert not reached
    assert [message["type"] for message in sent] == ["http.response.start", "http.response.body"]
    assert sent[1]["body"] == b"body"


def test_the_coding_is_the_one_that_the_client_likes_best(ask):
    headers = [(b"accept-encoding", b"br, gzip"), (b"accept-encoding", b"zstd;q=0.5")]
    assert ask(f"/v1/gamuts/{NAME}/mesh", headers=headers)[0][-1] == "gzip"


def test_what_the_client_has_is_not_sent_again(ask):
    known = [(b"if-none-match", b'"x"'), (b"if-none-match", MESH.etag.encode())]
    _, _, sent = ask(f"/v1/gamuts/{NAME}/mesh", headers=known)
    assert (sent[0]["status"], sent[1]["body"]) == (304, b"")


@pytest.mark.parametrize(
    ("path", "query"),
    [
        (f"/v1/gamuts/{NAME}", ""),
        (f"/v1/gamuts/{NAME[:-1]}/mesh", ""),
        (f"/v1/gamuts/{NAME.upper()}/mesh", ""),
        (f"/v1/gamuts/{NAME}/mesh/", ""),
        (f"/v1/gamuts/{NAME}/mesh\n", ""),
        (f"/v1/gamuts/{NAME}/mesh.vrml", ""),
        (f"/v1/gamuts/{NAME}/mesh", "format=vrml"),
        (f"/v1/gamuts/{NAME}/mesh", "triangles="),
        (f"/v1/gamuts/{NAME}/mesh", "triangles=1e3"),
        (f"/v1/gamuts/{NAME}/mesh", "triangles=-4"),
        (f"/v1/gamuts/{NAME}/mesh", "triangles=4\n"),
        (f"/v1/gamuts/{NAME}/mesh", "triangles=10&triangles=20"),
        (f"/v1/gamuts/{NAME}/mesh", "triangles=10format=ply"),
        (f"/v1/gamuts/{NAME}/mesh", "other=1"),
        (f"/v1/gamuts/{NAME}/mesh", "max_error="),
        (f"/v1/gamuts/{NAME}/mesh", "max_error=-1"),
        (f"/v1/gamuts/{NAME}/mesh", "max_error=nan"),
        (f"/v1/gamuts/{NAME}/mesh", "max_error=1e+1"),
        (f"/v1/gamuts/{NAME}/mesh", "max_error=0.5max_mismatch=1"),
        (f"/v1/gamuts/{NAME}/mesh", "triangles=10&max_error=0.5"),
        (f"/v1/gamuts/{NAME}/mesh", "max_error=0.5&triangles=10"),
        (f"/v1/gamuts/{NAME}/mesh", f"triangles={'9' * 10}"),
    ],
)
def test_everything_else_is_left_to_the_routes(ask, path, query):
    asked, reached, sent = ask(path, query)
    assert (asked, reached, sent) == (None, True, [])


def test_a_precondition_is_left_to_the_routes(ask):
    assert ask(f"/v1/gamuts/{NAME}/mesh", headers=[(b"if-match", b"*")]) == (None, True, [])


@pytest.mark.parametrize("method", ["POST", "DELETE", "HEAD"])
def test_only_get_is_answered_here(ask, method):
    assert ask(f"/v1/gamuts/{NAME}/mesh", method=method)[1]


def test_what_nobody_accepts_is_left_to_the_routes(ask):
    asked, reached, _ = ask(f"/v1/gamuts/{NAME}/mesh", headers=[(b"accept", b"text/html")])
    assert asked is None
    assert reached
