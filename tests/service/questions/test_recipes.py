"""Recipes over HTTP: the device model is made of the kept input, stored, and made again."""

import io
import json
import shutil
from pathlib import Path

import gamutclient
import numpy as np
import pytest

from gamutcore import Gamut

ROOT = Path(__file__).parents[3]
PRESS = ROOT / "examples" / "FOGRA39L.ti3"
OPTIONS = {"surface_samples": 4000, "ink_limit": 300}
COLOURS = [[50.0, 30.0, 20.0], [40.0, 0.0, 0.0], [50.0, 0.0, 110.0]]


@pytest.fixture(scope="module")
def press(server):
    """The address of a press, and the same gamut built here."""
    return post_press(server), Gamut(PRESS, **OPTIONS)


def post_press(server, limit=300):
    answer = server.client.post(
        "/v1/gamuts",
        files={"file": PRESS.read_bytes()},
        data={"options": json.dumps({**OPTIONS, "ink_limit": limit})},
    )
    assert answer.status_code in {200, 201}, answer.text
    return answer.json()["links"]["self"]


def model_file(server, address):
    name = address.rpartition("/")[2]
    return server.data / "models" / name[:2] / f"{name}.model"


def test_recipes_are_those_of_the_package(server, press):
    address, here = press
    answer = server.client.post(f"{address}/recipes", json={"colours": COLOURS, "black": 0.25})
    assert answer.status_code == 200, answer.text
    found, expected = answer.json(), here.to_device(COLOURS, black=0.25)
    assert found["inside"] == [True, True, False]
    np.testing.assert_allclose(found["device"], expected.device, atol=1e-9)
    np.testing.assert_allclose(found["colour"], expected.points, atol=1e-9)
    np.testing.assert_allclose(found["delta_e_2000"], expected.delta_e, atol=1e-9)
    np.testing.assert_allclose(found["black_least"], expected.black_least, atol=1e-9)
    np.testing.assert_allclose(found["black_most"], expected.black_most, atol=1e-9)
    curve = server.client.post(
        f"{address}/recipes", params={"black": "0:1,100:0"}, json={"colours": COLOURS[:1]}
    ).json()
    expected = here.to_device(COLOURS[:1], black=[(0, 1), (100, 0)])
    np.testing.assert_allclose(curve["device"], expected.device, atol=1e-9)


def test_device_values_have_the_colours_of_the_package(server, press):
    address, here = press
    device = np.random.default_rng(0).random((40, 4)).round(3)
    answer = server.client.post(f"{address}/colours", json={"device": device.tolist()})
    assert answer.status_code == 200, answer.text
    np.testing.assert_allclose(answer.json()["colour"], here.to_colour(device), atol=1e-9)
    body = io.BytesIO()
    np.save(body, device)
    answer = server.client.post(
        f"{address}/colours",
        params={"space": "sRGB"},
        content=body.getvalue(),
        headers={"Content-Type": "application/x-npy"},
    )
    rows = np.load(io.BytesIO(answer.content))["colour"]
    np.testing.assert_allclose(rows, here.to_colour(device, space="sRGB"), atol=1e-9)
    with gamutclient.Client(server.url) as client:
        remote = client.gamut(address.rpartition("/")[2])
        found = remote.to_colour(device[0])
    np.testing.assert_allclose(found, here.to_colour(device[0]), atol=1e-9)
    csv = server.client.post(
        f"{address}/colours", json={"device": device[:1].tolist()}, headers={"Accept": "text/csv"}
    )
    assert csv.text.splitlines()[0] == "C,M,Y,K,colour_L*,colour_a*,colour_b*"


@pytest.mark.parametrize(
    ("path", "body", "status", "code"),
    [
        ("srgb", {"device": [[0.5, 0.5]]}, 422, "invalid-points"),
        ("srgb", {"device": [[0.5, 0.5, 1.5]]}, 422, "invalid-points"),
        ("srgb", {"device": [[0.5, 0.5, 1e300]]}, 422, "invalid-points"),
        ("srgb", {"colours": [[50, 0, 0]]}, 422, "invalid-body"),
        ("srgb", {"device": [[0, 0, 0]], "triangles": 100}, 422, "invalid-body"),
    ],
)
def test_other_device_values_are_refused(server, path, body, status, code):
    address = f"/v1/gamuts/{path}/colours"
    answer = server.client.post(address, params={"surface_samples": 2000}, json=body)
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert answer.json()["remedy"]


def test_tables_of_device_values_are_refused(server):
    answer = server.client.post(
        "/v1/gamuts/srgb/colours?surface_samples=2000",
        content="R,G,B\n0,0,0\n",
        headers={"Content-Type": "text/csv"},
    )
    assert answer.status_code == 415
    assert "application/json" in answer.json()["remedy"]


def test_a_reference_has_recipes_by_its_slug(server):
    codes = [[0.2, 0.5, 0.7], [1.0, 1.0, 1.0]]
    answer = server.client.post(
        "/v1/gamuts/srgb/recipes",
        params={"surface_samples": 2000},
        json={"colours": codes, "space": "sRGB"},
    )
    assert answer.status_code == 200, answer.text
    np.testing.assert_allclose(answer.json()["device"], codes, atol=1e-3)
    assert "black_least" not in answer.json()


@pytest.mark.parametrize("black", ["sometimes", 2, "9:0.5", "a:b,c:d"])
def test_rules_that_do_not_exist_are_refused(server, press, black):
    answer = server.client.post(f"{press[0]}/recipes", json={"colours": COLOURS, "black": black})
    assert answer.status_code in {400, 422}
    assert answer.json()["where"]["field"] == "black"


def test_colours_alone_have_no_recipes(server, cubes, assert_problem):
    answer = server.client.post(f"{cubes[0]}/recipes", json={"colours": COLOURS})
    assert_problem(answer, 422, "no-device-model")
    answer = server.client.post(f"{cubes[0]}/colours", json={"device": [[0.5, 0.5, 0.5]]})
    assert_problem(answer, 422, "no-device-model")
    assert "colours only" in answer.json()["detail"]


def test_the_model_is_stored_once_and_removed_with_the_gamut(
    server, start_server, assert_problem, tmp_path
):
    """A second server has a copy of the store, with a damaged model, and with neither model nor
    input."""
    addresses, first = [], []
    for limit in (290, 310):
        address = post_press(server, limit)
        digest = server.client.get(f"{address}/history").headers["etag"]
        assert not model_file(server, address).exists()
        answer = server.client.post(f"{address}/recipes", json={"colours": COLOURS})
        assert answer.status_code == 200, answer.text
        assert model_file(server, address).exists()
        assert server.client.get(f"{address}/history").headers["etag"] == digest
        addresses.append(address)
        first.append(answer.json()["device"])
    damaged, bare = addresses
    for address in addresses:
        for path in server.data.rglob(f"{address.rpartition('/')[2]}*"):
            copy = tmp_path / "data" / path.relative_to(server.data)
            copy.parent.mkdir(parents=True, exist_ok=True)
            if address == damaged or copy.suffix not in {".model", ".input"}:
                shutil.copyfile(path, copy)
    second = start_server(tmp_path / "data")
    # damaged: made again of the input
    content = bytearray(model_file(second, damaged).read_bytes())
    content[len(content) // 2] ^= 1
    model_file(second, damaged).write_bytes(content)
    again = second.client.post(f"{damaged}/recipes", json={"colours": COLOURS})
    assert again.json()["device"] == first[0]
    # neither the model nor the input: the same data has to be posted again
    gone = second.client.post(f"{bare}/recipes", json={"colours": COLOURS})
    assert_problem(gone, 422, "no-device-model")
    assert "Post the same data" in gone.json()["remedy"]
    post_press(second, 310)
    back = second.client.post(f"{bare}/recipes", json={"colours": COLOURS})
    assert back.json()["device"] == first[1]
    assert second.client.delete(bare).status_code == 204
    assert not model_file(second, bare).exists()
