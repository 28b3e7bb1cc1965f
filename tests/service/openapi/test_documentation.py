"""The documentation's examples are what the service answers; its lines do what they say."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from gamutcore import Gamut, Options
from gamutcore.options import Options as CoreOptions
from service.application import create_app
from service.openapi import documentation, models, request_models
from service.problems.kinds import KINDS
from service.problems.problem import MEDIA_TYPE
from service.settings import Settings

ROOT = Path(__file__).parents[3]


def test_every_line_of_the_page_works(server, tmp_path):
    if shutil.which("curl") is None:
        pytest.skip("curl is not installed")
    text = (ROOT / "docs" / "http-api.md").read_text()
    script = "".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL))
    script = script.replace("http://127.0.0.1:8000", server.url)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    answer = subprocess.run(
        ["sh", "-e", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    statuses = re.findall(r"HTTP/1\.1 (\d+)", answer.stdout)
    assert [status[0] for status in statuses] == ["2"] * script.count("curl -i")
    assert "202" in statuses
    assert statuses[-4:] == ["200", "204", "200", "200"]
    assert (tmp_path / "display-p3.glb").read_bytes()[:4] == b"glTF"
    assert (tmp_path / "srgb-dim.ply").read_bytes()[:3] == b"ply"
    assert (tmp_path / "references.zip").read_bytes()[:2] == b"PK"
    assert (tmp_path / "FOGRA39L.glb").read_bytes()[:4] == b"glTF"
    assert (tmp_path / "FOGRA39L.ply").read_bytes()[:3] == b"ply"
    assert (tmp_path / "FOGRA39L-half-a-unit.glb").read_bytes()[:4] == b"glTF"
    assert (tmp_path / "FOGRA39L-both.ply").read_bytes()[:3] == b"ply"
    assert (tmp_path / "FOGRA39L.stl").stat().st_size == 84 + 50 * 1000
    assert (tmp_path / "FOGRA39L.gamut").stat().st_size > 10**5
    assert '"code":"invalid-option"' in answer.stdout
    assert answer.stdout.count("event: finished") == 1
    assert answer.stdout.count('"code":"build-cancelled"') == 1


def stated(document):
    """Return a document without the options that the chosen boundary does not have."""
    if isinstance(document, list):
        return [stated(member) for member in document]
    if not isinstance(document, dict):
        return document
    return {
        name: {option: value for option, value in member.items() if value is not None}
        if name == "options"
        else stated(member)
        for name, member in document.items()
    }


class TestExamples:
    @pytest.mark.parametrize(
        ("model", "example"),
        [
            (models.GamutDescription, documentation.EXAMPLE_GAMUT),
            (models.GamutList, documentation.EXAMPLE_LIST),
            (models.ErrorCurve, documentation.EXAMPLE_LEVELS),
            (models.JobDescription, documentation.EXAMPLE_JOB),
            (models.Readiness, documentation.EXAMPLE_READINESS),
        ],
    )
    def test_are_of_their_models_with_nothing_left_out(self, model, example):
        assert stated(model.model_validate(example).model_dump(mode="json")) == example

    def test_of_a_gamut_is_possible(self):
        example = documentation.EXAMPLE_GAMUT
        counts = example["counts"]
        assert counts["triangles"] == 2 * counts["vertices"] - 4
        lowest, highest = example["bounds"]
        for low, middle, high in zip(lowest, example["centre"], highest, strict=True):
            assert low < middle < high
        # no body of an area holds more than a sphere: 36 π V² ≤ A³
        assert 36 * 3.1416 * example["volume"] ** 2 < example["area"] ** 3
        levels = example["levels"]
        assert [level["triangles"] for level in levels] == [4, 510]
        for level in levels:
            assert level["mismatch"] <= level["mismatch_bound"]
            for direction in ("from_full", "to_full"):
                distances = level[direction]
                assert distances["mean"] <= distances["maximum"] <= level["distance_bound"]

    def test_of_a_mesh_s_headers_is_a_level_of_the_example(self):
        shown = {name: field["example"] for name, field in documentation.MESH_HEADERS.items()}
        (level,) = (
            level
            for level in documentation.EXAMPLE_LEVELS["levels"]
            if level["triangles"] == shown["Gamut-Triangles"]
        )
        assert shown["Gamut-Vertices"] == level["triangles"] // 2 + 2
        assert float(shown["Gamut-Max-Error"]) == level["distance_bound"]
        assert float(shown["Gamut-Max-Mismatch"]) == level["mismatch_bound"]

    def test_options_are_the_defaults(self):
        assert documentation.EXAMPLE_GAMUT["options"] == CoreOptions().to_mapping()

    def test_belong_to_one_gamut(self):
        identity = documentation.EXAMPLE_ID
        assert re.fullmatch(r"[0-9a-f]{64}", identity)
        for example in (documentation.EXAMPLE_GAMUT, documentation.EXAMPLE_JOB):
            assert example["id"] == identity
            assert example["links"]["self"].endswith(identity)

    def test_submissions_can_be_built(self):
        content = documentation.SUBMISSION_BODY["content"]
        inline = content["application/json"]["examples"]["colours"]["value"]
        sent = content["multipart/form-data"]["examples"]["file"]["value"]
        request_models.InlineSamples.model_validate(inline)
        samples = {name: inline[name] for name in ("columns", "samples")}
        gamuts = [
            Gamut(data, Options.from_mapping(options))
            for data, options in (
                (json.dumps(samples).encode(), inline["options"]),
                (sent["file"].encode(), sent["options"]),
            )
        ]
        # the same five colours, said in two ways
        assert gamuts[0].history.full() == gamuts[1].history.full()


class TestProblems:
    def test_of_a_code_are_under_its_status(self):
        responses = documentation.problems("triangle-count", "gamut-not-found", guarded=False)
        assert set(responses) == {
            KINDS["triangle-count"].status,
            KINDS["gamut-not-found"].status,
            KINDS["internal-error"].status,
        }

    def test_of_keys_and_limits_are_said_of_what_is_guarded(self):
        assert {401, 403, 429} <= set(documentation.problems())
        assert set(documentation.problems(guarded=False)) == {500}

    @pytest.mark.parametrize("code", KINDS)
    def test_of_every_code_have_an_example_of_the_document(self, code):
        kind = KINDS[code]
        response = documentation.problems(code, guarded=False)[kind.status]
        (content,) = response["content"].items()
        assert content[0] == MEDIA_TYPE
        document = content[1]["examples"][code]["value"]
        assert document["code"] == code
        assert document["status"] == kind.status
        models.ProblemDocument.model_validate(document)
        assert kind.title in response["description"]
        assert response["headers"]["Cache-Control"]["example"] == "no-store"
        assert ("Retry-After" in response["headers"]) == (kind.status in {429, 503})


def test_headers_say_their_type():
    assert documentation.header("How many.", 5)["schema"] == {"type": "integer"}
    assert documentation.header("Which.", "a")["schema"] == {"type": "string"}


def test_links_lead_to_operations_and_their_parameters():
    operations = {
        operation["operationId"]: {
            parameter["name"] for parameter in operation.get("parameters", [])
        }
        for operations in create_app(Settings()).openapi()["paths"].values()
        for operation in operations.values()
    }
    for link in documentation.gamut_links("$response.body#/id").values():
        assert set(link["parameters"]) <= operations[link["operationId"]]
