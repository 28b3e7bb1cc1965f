"""One real server on loopback, from the first POST to a restart: what every client relies on."""

import hashlib
import io
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from servers import Server

ROOT = Path(__file__).parents[2]
PRESS = ROOT / "examples" / "FOGRA39L.ti3"
PROFILE = ROOT / "tests" / "data" / "sRGB-v4.icc"
SRGB_VOLUME = 830_732
"""Volume of sRGB in CIELAB with D50: 602 points, linear in XYZ (IDMS 1.3, 5.32)."""


def picture():
    """A PNG of 64 × 64 pixels with many colours."""
    ramp = np.linspace(0, 255, 64).astype(np.uint8)
    red, green = np.meshgrid(ramp, ramp)
    file = io.BytesIO()
    Image.fromarray(np.dstack([red, green, 255 - red])).save(file, "png")
    return file.getvalue()


def post(client, name, data, **options):
    """Build a gamut, and return its description."""
    answer = client.post(
        "/v1/gamuts", files={"file": (name, data)}, data={"options": json.dumps(options)}
    )
    assert answer.status_code == 201, answer.text
    return answer.json()


def downloaded(client, gamut, kind, **level):
    """Download a level, check its ETag and that it is a closed mesh, and return it."""
    answer = client.get(f"/v1/gamuts/{gamut}/mesh", params={**level, "format": kind})
    assert answer.status_code == 200, answer.text
    assert hashlib.sha256(answer.content).hexdigest() in answer.headers["ETag"]
    mesh = trimesh.load(io.BytesIO(answer.content), kind, force="mesh", process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0
    return mesh


def assert_problem(answer, status, code):
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    document = answer.json()
    assert document["code"] == code
    assert document["remedy"]
    return document


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("end to end")


@pytest.fixture(scope="module")
def service(folder):
    """A server that the first tests share; the last one stops it."""
    server = Server(folder / "data", folder / "log")
    server.wait_ready()
    yield server
    server.end()


@pytest.fixture(scope="module")
def gamuts(service):
    """Descriptions of the gamuts of a press, a profile and a picture."""
    return {
        "press": post(service.client, PRESS.name, PRESS.read_bytes(), surface_samples=3000),
        "profile": post(service.client, PROFILE.name, PROFILE.read_bytes(), surface_samples=3000),
        "picture": post(service.client, "colours.png", picture()),
    }


def test_a_gamut_says_what_it_was_made_of(service, gamuts):
    press, profile, picture = gamuts.values()
    assert press["provenance"]["channels"] == ["C", "M", "Y", "K"]
    assert profile["volume"] == pytest.approx(SRGB_VOLUME, rel=0.01)
    assert picture["volume"] < profile["volume"]
    for described in gamuts.values():
        read = service.client.get(f"/v1/gamuts/{described['id']}").json()
        assert read["counts"] == described["counts"]


def test_the_same_post_is_answered_without_a_build(service, gamuts):
    again = service.client.post(
        "/v1/gamuts",
        files={"file": (PRESS.name, PRESS.read_bytes())},
        data={"options": json.dumps({"surface_samples": 3000})},
    )
    assert again.status_code == 200
    assert again.json()["id"] == gamuts["press"]["id"]


@pytest.mark.parametrize("kind", ["glb", "ply"])
@pytest.mark.parametrize("source", ["press", "profile", "picture"])
def test_a_mesh_by_count_and_by_error(service, gamuts, source, kind):
    gamut = gamuts[source]["id"]
    assert len(downloaded(service.client, gamut, kind, triangles=101).faces) == 100
    assert len(downloaded(service.client, gamut, kind, triangles=4).faces) == 4
    coarse = downloaded(service.client, gamut, kind, max_error=2.0)
    fine = downloaded(service.client, gamut, kind, max_error=0.5)
    assert 4 < len(coarse.faces) < len(fine.faces)


def test_a_query(service, gamuts):
    body = {"colours": [[50, 0, 0], [50, 120, 0]]}
    gamut = gamuts["press"]["id"]
    answer = service.client.post(f"/v1/gamuts/{gamut}/contains", json=body)
    assert answer.status_code == 200, answer.text
    assert answer.json()["inside"] == [True, False]
    answer = service.client.post(f"/v1/gamuts/{gamut}/nearest", json=body)
    assert answer.json()["distance"][1] > 30


def test_a_range_of_the_history_is_a_coarse_history(service, gamuts):
    address = f"/v1/gamuts/{gamuts['press']['id']}/history"
    whole = service.client.get(address).content
    part = service.client.get(address, headers={"Range": f"bytes=0-{len(whole) // 2}"})
    assert part.status_code == 206
    assert part.content == whole[: len(whole) // 2 + 1]
    beyond = service.client.get(address, headers={"Range": f"bytes={len(whole)}-"})
    assert beyond.status_code == 416


def test_problems_are_documents(service, gamuts):
    client, gamut = service.client, gamuts["press"]["id"]
    problem = assert_problem(
        client.post("/v1/gamuts", files={"file": ("a.icc", b"no profile")}),
        422,
        "unrecognised-format",
    )
    assert problem["detail"]
    assert_problem(client.get(f"/v1/gamuts/{'0' * 64}"), 404, "gamut-not-found")
    field = assert_problem(
        client.get(f"/v1/gamuts/{gamut}/mesh", params={"triangles": 2}), 422, "triangle-count"
    )
    assert field["where"]["field"] == "triangles"


def test_what_is_deleted_is_gone_and_the_rest_is_there_after_a_restart(service, gamuts, folder):
    client = service.client
    press, profile, picture = (described["id"] for described in gamuts.values())
    levels = {
        gamut: client.get(f"/v1/gamuts/{gamut}/mesh", params={"triangles": 500}).content
        for gamut in (press, profile)
    }
    assert client.delete(f"/v1/gamuts/{picture}").status_code == 204
    assert_problem(client.get(f"/v1/gamuts/{picture}"), 404, "gamut-not-found")
    service.stop()
    restarted = Server(folder / "data", folder / "second log")
    try:
        client = restarted.client
        listed = {row["id"] for row in client.get("/v1/gamuts").json()["gamuts"]}
        assert listed == {press, profile}
        for gamut, level in levels.items():
            answer = client.get(f"/v1/gamuts/{gamut}/mesh", params={"triangles": 500})
            assert answer.content == level
            assert client.get(f"/v1/gamuts/{gamut}").json()["id"] == gamut
        assert_problem(client.get(f"/v1/gamuts/{picture}"), 404, "gamut-not-found")
    finally:
        restarted.end()
