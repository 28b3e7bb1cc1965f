"""What answers over HTTP state about their gamuts, and what they warn of."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[3]
NPY, CSV = "application/x-npy", "text/csv"
WARNING = '"intent": "absolute"'


@pytest.fixture(scope="module")
def presses(server):
    """Addresses of a press relative to its paper, and as measured."""
    made = {}
    for intent in ("relative", "absolute"):
        options = json.dumps({"surface_samples": 1000, "ink_limit": 300, "intent": intent})
        file = (ROOT / "examples" / "FOGRA39L.ti3").read_bytes()
        answer = server.client.post(
            "/v1/gamuts", files={"file": file}, data={"options": options}, timeout=600
        )
        assert answer.status_code in {200, 201}, answer.text
        made[intent] = answer.json()["links"]["self"]
    return made


def ask(server, address, operation, accept="application/json", **members):
    body = {"colours": [[50, 90, 0]], **members}
    headers = {"Accept": accept}
    answer = server.client.post(f"{address}/{operation}", json=body, headers=headers)
    assert answer.status_code == 200, answer.text
    return answer


@pytest.mark.slow
@pytest.mark.parametrize("operation", ["contains", "nearest", "map"])
def test_colours_as_measured_and_a_relative_gamut(server, presses, operation):
    relative = ask(server, presses["relative"], operation)
    assert relative.json()["gamut"]["intent"] == "relative"
    assert relative.json()["gamut"]["medium_white"] == pytest.approx([95, 0, -2], abs=0.01)
    (warning,) = relative.json()["warnings"]
    assert WARNING in warning
    absolute = ask(server, presses["absolute"], operation)
    assert (absolute.json()["gamut"]["intent"], absolute.json()["warnings"]) == ("absolute", [])
    assert ask(server, presses["relative"], operation, space="sRGB").json()["warnings"] == []
    (warning,) = ask(server, presses["absolute"], operation, space="sRGB").json()["warnings"]
    assert '"intent": "relative"' in warning


@pytest.mark.slow
@pytest.mark.parametrize("accept", [NPY, CSV, "application/json"])
def test_header_fields(server, presses, accept):
    answer = ask(server, presses["relative"], "nearest", accept)
    stated = "intent=relative; ink-limit=300; white=D50; space=CIELAB"
    assert answer.headers["gamut-conditions"] == stated
    field = answer.headers["gamut-warning"]
    assert json.loads(f"[{field}]")[0].endswith(f"(--intent absolute, or {WARNING}).")
    assert "gamut-warning" not in ask(server, presses["absolute"], "nearest", accept).headers


@pytest.mark.slow
def test_two_intents(server, presses):
    names = [presses[intent].rpartition("/")[2] for intent in ("relative", "absolute")]
    answer = server.client.get("/v1/comparisons", params=dict(zip("ab", names, strict=True)))
    found = answer.json()
    assert [found["gamuts"][name]["intent"] for name in "ab"] == ["relative", "absolute"]
    assert "intents differ" in found["warnings"][0]
    assert answer.headers["gamut-conditions"].count("intent=") == 2
    rings = f"{presses['relative']}/rings"
    answer = server.client.get(rings, params={"reference": names[1], "sectors": 4})
    assert "intents differ" in answer.json()["warnings"][0]
    assert answer.json()["reference_gamut"]["intent"] == "absolute"
    assert "intents differ" in answer.headers["gamut-warning"]


@pytest.mark.slow
def test_pictures(server, presses):
    drawn = server.client.get(f"{presses['absolute']}/picture.png?size=64").content
    with Image.open(io.BytesIO(drawn)) as picture:
        picture.load()
        assert picture.text["Gamut"] == "absolute intent, ink limit 300 %, white D50, CIELAB"


@pytest.mark.slow
def test_a_description_has_both_volumes(server, presses):
    found = [server.client.get(each).json() for each in presses.values()]
    relative, absolute = (each["volumes"] for each in found)
    for intent, own in (("relative", found[0]), ("absolute", found[1])):
        for volumes in (relative, absolute):
            assert volumes[intent]["volume"] == pytest.approx(own["volume"], rel=5e-3)
    np.testing.assert_allclose(
        relative["absolute"]["times_srgb"],
        relative["absolute"]["volume"] / relative["srgb"],
        atol=1e-6,
    )
