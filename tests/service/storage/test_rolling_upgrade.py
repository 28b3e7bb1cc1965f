"""A store that revision 36d52e7 wrote is opened: its gamut is served, and its jobs end."""

import json
import shutil
from pathlib import Path

import pytest

STORE = Path(__file__).parents[2] / "data" / "store-36d52e7"
GAMUT = "066e3575cabaac9f75983e622a0c51d006797a5f3ccdcba84d9f382a5acc9ed1"
RUNNING = "8bfaf70c010695fb3f3451f29f8f42dc814d3f7d432d392a83efcdee1f43e92b"
WAITING = "b07f816277abcd61c33ff82be078c4a3a33ee9e52a0642e3ad8191575c0c66ef"


@pytest.fixture(scope="module")
def upgraded(tmp_path_factory, start_server):
    store = tmp_path_factory.mktemp("upgraded") / "store"
    shutil.copytree(STORE, store)
    return start_server(store)


@pytest.mark.slow
def test_gamuts_names_and_jobs_of_an_earlier_revision_are_read(upgraded):
    client = upgraded.client
    # The jobs of the store may have added theirs.
    names = {gamut["id"]: gamut["name"] for gamut in client.get("/v1/gamuts").json()["gamuts"]}
    assert names[GAMUT] == "A small press"
    described = client.get(f"/v1/gamuts/{GAMUT}")
    # The bytes are those that the earlier revision served: the address is immutable.
    published = STORE / "published" / GAMUT[:2] / f"{GAMUT}.record"
    stored = json.loads(published.read_bytes().partition(b"\n")[2])["description"]
    assert {name: described.json()[name] for name in stored} == stored
    assert client.get(f"/v1/jobs/{GAMUT}").json()["state"] == "succeeded"
    # Its history has an earlier format, so it is built again from the input that the store keeps.
    mesh = client.get(f"/v1/gamuts/{GAMUT}/mesh.ply?max_error=0")
    assert (mesh.status_code, mesh.json()["code"]) == (503, "gamut-rebuilding")
    ended = upgraded.finished_job(mesh.json()["where"]["job"])
    assert ended["state"] == "succeeded", ended
    address = ended["links"]["gamut"]
    # The full mesh is closed around the sphere of radius 30 that the samples are from.
    mesh = client.get(f"{address}/mesh.ply?max_error=0")
    assert int(mesh.headers["gamut-triangles"]) == stored["counts"]["triangles"]
    asked = {"colours": [[50, 0, 0], [50, 31, 0]]}
    answer = client.post(f"{address}/contains", json=asked)
    assert answer.json()["inside"] == [True, False], answer.text


@pytest.mark.slow
def test_builds_of_an_earlier_algorithm_are_done_by_this_one(upgraded):
    """The job points to the gamut, which has the id that a new post gives."""
    client = upgraded.client
    for job in (RUNNING, WAITING):
        ended = upgraded.finished_job(f"/v1/jobs/{job}")
        assert (ended["id"], ended["state"], ended["problem"]) == (job, "succeeded", None)
        address = ended["links"]["gamut"]
        assert address != f"/v1/gamuts/{job}"
        described = client.get(address).json()
        assert address == f"/v1/gamuts/{described['id']}"
        # The data was copied under the new id: the same post finds the gamut, and repair has it.
        (kept,) = (upgraded.data / "inputs").rglob(f"{described['id']}.input")
        _, head, data = kept.read_bytes().split(b"\n", 2)
        options = json.loads(head)["options"]
        posted = client.post(
            "/v1/gamuts", files={"file": data}, data={"options": json.dumps(options)}
        )
        assert (posted.status_code, posted.json()["id"]) == (200, described["id"])
        assert not list((upgraded.data / "inputs").rglob(f"{job}.input"))
        assert client.get(f"/v1/gamuts/{job}").status_code == 404
