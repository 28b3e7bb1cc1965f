"""The OpenAPI document: complete, true to the service, and its examples work."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import jsonschema_rs
import pytest

from gamutcore import Gamut, Options, errors
from gamutcore.boundary import BOUNDARIES
from gamutcore.errors import OptionError
from gamutcore.options import OPTIONS
from service.application import create_app
from service.command import openapi_document
from service.openapi.models import StoredDescription
from service.problems.kinds import KINDS
from service.settings import Settings

ROOT = Path(__file__).parents[3]
DOCUMENT = json.loads(openapi_document())
COMPONENTS = DOCUMENT["components"]
SCHEMAS = COMPONENTS["schemas"]


def resolved(node):
    """A parameter or response. Members beside a reference take precedence (OpenAPI 3.1)."""
    _, _, section, name = node.get("$ref", "///").split("/")
    return {**COMPONENTS[section][name], **node} if name else node


OPERATIONS = {
    f"{method} {path}": {
        **operation,
        "parameters": [resolved(parameter) for parameter in operation.get("parameters", [])],
        "responses": {
            status: resolved(response) for status, response in operation["responses"].items()
        },
    }
    for path, operations in DOCUMENT["paths"].items()
    for method, operation in operations.items()
}
GUARDED = {"401", "403", "429"}
"""Statuses of keys and rate limits."""


def contents(operation):
    """All bodies of an operation's request and responses, by media type."""
    bodies = [operation.get("requestBody", {}), *operation["responses"].values()]
    return [entry for body in bodies for entry in body.get("content", {}).items()]


def documented(operation, status="200"):
    """The example of an operation's answer in JSON."""
    content = OPERATIONS[operation]["responses"][status]["content"]["application/json"]
    return next(iter(content["examples"].values()))["value"]


def faults(schema, value):
    """What a schema of the document has against a value."""
    validator = jsonschema_rs.Draft202012Validator({**schema, "components": COMPONENTS})
    return [error.message for error in validator.iter_errors(value)]


# --- the document ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_committed_document_is_what_the_app_generates(monkeypatch):
    monkeypatch.setenv("GAMUT_BUILD_QUEUE", "7")  # does not matter
    current = (ROOT / "openapi" / "openapi.json").read_text() == openapi_document()
    assert current, "openapi/openapi.json is out of date: run `make openapi`"


def test_making_an_app_touches_nothing(tmp_path):
    create_app(Settings(store=str(tmp_path / "data")))
    assert list(tmp_path.iterdir()) == []


def test_every_operation_explains_itself_under_an_id_of_its_own():
    ids = [operation["operationId"] for operation in OPERATIONS.values()]
    assert len(set(ids)) == len(ids)
    for name, operation in OPERATIONS.items():
        assert operation["summary"], name
        assert operation["description"], name
        for parameter in operation["parameters"]:
            assert parameter["description"], (name, parameter["name"])
        for _, content in contents(operation):
            assert content["examples"], name
            assert content.get("schema"), name


def test_every_error_is_documented_as_a_problem():
    seen = set()
    for name, operation in OPERATIONS.items():
        for status, response in operation["responses"].items():
            if status < "400":
                continue
            assert response["$ref"] == f"#/components/responses/Problem{status}", name
            codes = re.findall("`(.*?)`", response["description"])
            assert {str(KINDS[code].status) for code in codes} == {status}, name
            seen |= set(codes)
        # keys and limits apply to what is guarded, and anything may fail
        assert "500" in operation["responses"]
        assert set(operation["responses"]) >= GUARDED or path_is_open(name), name
    by_the_proxy = {"bad-gateway", "no-replica", "gateway-timeout"}
    assert set(KINDS) - seen == {"method-not-allowed", *by_the_proxy}
    codes = {getattr(errors, name).code for name in errors.__all__}
    assert codes <= {code for code, kind in KINDS.items() if kind.status == 422}


def test_every_kind_of_problem_has_an_example_in_the_response_of_its_status():
    shown = {}
    for name, response in COMPONENTS["responses"].items():
        status = name.removeprefix("Problem")
        if status == name:
            continue
        (content,) = response["content"].values()
        for code, example in content["examples"].items():
            shown[code] = example["value"]["code"]
            assert example["value"]["status"] == int(status)
        assert response["headers"]["Cache-Control"]["example"] == "no-store"
        assert ("Retry-After" in response["headers"]) == (status in {"429", "503"})
        assert ("WWW-Authenticate" in response["headers"]) == (status == "401")
    assert shown == {code: code for code in KINDS}


def path_is_open(name):
    return not name.partition(" ")[2].startswith("/v1/")


def test_every_reference_and_link_leads_somewhere():
    def references(node):
        if isinstance(node, dict):
            yield from ([node["$ref"]] if isinstance(node.get("$ref"), str) else [])
            for child in node.values():
                yield from references(child)
        elif isinstance(node, list):
            for child in node:
                yield from references(child)

    for reference in references(DOCUMENT):
        _, _, section, name = reference.split("/")
        assert name in COMPONENTS[section]
    parameters = {
        operation["operationId"]: {each["name"] for each in operation["parameters"]}
        for operation in OPERATIONS.values()
    }
    links = [
        link
        for operation in OPERATIONS.values()
        for response in operation["responses"].values()
        for link in response.get("links", {}).values()
    ]
    assert links
    for link in links:
        assert set(link["parameters"]) <= parameters[link["operationId"]]


# --- examples -------------------------------------------------------------------------------------


def test_every_example_is_of_its_schema():
    paths = DOCUMENT["paths"].values()
    operations = [operation for operations in paths for operation in operations.values()]
    count = 0
    for operation in (*operations, {"responses": COMPONENTS["responses"]}):
        for media_type, content in contents(operation):
            for name, example in content["examples"].items():
                if "json" not in media_type or "value" not in example:
                    continue
                count += 1
                assert faults(content["schema"], example["value"]) == [], name
    assert count > 100


def test_the_example_of_a_gamut_is_possible():
    example = documented("get /v1/gamuts/{gamut_id}")
    counts = example["counts"]
    assert counts["triangles"] == 2 * counts["vertices"] - 4
    lowest, highest = example["bounds"]
    for low, middle, high in zip(lowest, example["centre"], highest, strict=True):
        assert low < middle < high
    # no body of an area holds more than a sphere: 36 π V² ≤ A³
    assert 36 * 3.1416 * example["volume"] ** 2 < example["area"] ** 3
    assert [level["triangles"] for level in example["levels"]] == [4, 510]
    for level in example["levels"]:
        assert level["mismatch"] <= level["mismatch_bound"]
        for direction in ("from_full", "to_full"):
            distances = level[direction]
            assert distances["mean"] <= distances["maximum"] <= level["distance_bound"]
    stated = Options().to_mapping()
    assert {name: stated[name] for name in example["options"]} == example["options"]


def test_all_examples_are_of_one_gamut():
    identity = documented("get /v1/gamuts/{gamut_id}")["id"]
    assert re.fullmatch(r"[0-9a-f]{64}", identity)
    assert documented("get /v1/jobs/{job_id}")["links"]["self"] == f"/v1/jobs/{identity}"
    levels = documented("get /v1/gamuts/{gamut_id}/levels")
    assert levels["id"] == identity
    headers = OPERATIONS["get /v1/gamuts/{gamut_id}/mesh"]["responses"]["200"]["headers"]
    shown = {name: field["example"] for name, field in headers.items() if "example" in field}
    (level,) = (each for each in levels["levels"] if each["triangles"] == shown["Gamut-Triangles"])
    assert shown["Gamut-Vertices"] == level["triangles"] // 2 + 2
    assert float(shown["Gamut-Max-Error"]) == level["distance_bound"]
    assert float(shown["Gamut-Max-Mismatch"]) == level["mismatch_bound"]


def test_submissions_can_be_built():
    content = OPERATIONS["post /v1/gamuts"]["requestBody"]["content"]
    inline = content["application/json"]["examples"]["colours"]["value"]
    sent = content["multipart/form-data"]["examples"]["file"]["value"]
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


SMALL_REFERENCES = {
    "display-p3/mesh?": "display-p3/mesh?surface_samples=1000&",
    "mesh.ply?space=CAM16-UCS": "mesh.ply?surface_samples=1000&space=CAM16-UCS",
    '{"space": "Oklab"}': '{"space": "Oklab", "surface_samples": 1000}',
    "size=33&space=CAM16-UCS": "size=9&space=CAM16-UCS",
    "&black=heavy": "&black=heavy&size=9",
}
"""Parts of the page that build references, and what builds smaller ones of the same kind."""


def test_every_line_of_the_page_works(server, tmp_path):
    if shutil.which("curl") is None:
        pytest.skip("curl is not installed")
    text = (ROOT / "docs" / "http-api.md").read_text()
    script = "".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL))
    script = script.replace("http://127.0.0.1:8000", server.url)
    # Small builds do, but for the one that has to last until it is cancelled.
    press = "-F file=@examples/FOGRA39L.ti3"
    few = f"{press} -F surface_samples=3000"
    script = re.sub(rf"{press}(?!.*0\.32)", few, script)
    for printed, small in SMALL_REFERENCES.items():
        assert script.count(printed) == 1, printed
        script = script.replace(printed, small)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    answer = subprocess.run(
        ["sh", "-e", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    statuses = re.findall(r"HTTP/1\.1 (\d+)", answer.stdout)
    assert [status[0] for status in statuses] == ["2"] * script.count("curl -i")
    assert "202" in statuses
    assert statuses[-4:] == ["200", "204", "200", "200"]
    for name, begin in (
        ("display-p3.glb", b"glTF"),
        ("srgb-dim.ply", b"ply"),
        ("FOGRA39L.glb", b"glTF"),
        ("FOGRA39L.ply", b"ply"),
        ("FOGRA39L-half-a-unit.glb", b"glTF"),
        ("FOGRA39L-both.ply", b"ply"),
    ):
        assert (tmp_path / name).read_bytes().startswith(begin)
    assert (tmp_path / "FOGRA39L.stl").stat().st_size == 84 + 50 * 1000
    history = Gamut.from_bytes((tmp_path / "FOGRA39L.gamut").read_bytes())
    assert history.description["options"]["surface_samples"] == 3000
    assert '"code":"invalid-option"' in answer.stdout
    assert answer.stdout.count("event: finished") == 1
    # the list of jobs may show builds that other tests have cancelled
    shown = [each.partition("\n\n")[2] for each in answer.stdout.split("HTTP/1.1 ")]
    assert sum('"code":"build-cancelled"' in each.partition("\n")[0] for each in shown) == 1


# --- models ---------------------------------------------------------------------------------------


def test_every_member_of_a_description_is_documented():
    """Descriptions are validated before they are stored, and may have more members."""
    press = (ROOT / "examples" / "FOGRA39L.ti3").read_bytes()
    description = Gamut(press, Options(surface_samples=1000)).description
    stored = StoredDescription.model_validate(description)
    described = [stored, stored.counts, *stored.levels, stored.levels[0].to_full]
    assert [each.model_extra for each in described] == [{}] * len(described)
    sent = stored.model_dump(mode="json", by_alias=True, exclude_unset=True)
    assert sent == description


def test_the_documented_options_are_those_of_gamutcore():
    properties = SCHEMAS["GamutOptions"]["properties"]
    assert set(properties) == set(OPTIONS)
    for name, option in OPTIONS.items():
        assert ("default" in properties[name]) == (option.default is not None)
        if option.default is not None:
            assert properties[name]["default"] == getattr(Options(), name)
        # a default that depends on another option is described
        assert option.is_universal or all(
            f"{user}" in properties[name]["description"] for user in option.defaults
        )


def edges(schema):
    """Return values at the limits that a schema states, and values just beyond them."""
    if "anyOf" in schema:
        parts = [edges(part) for part in schema["anyOf"]]
        return [value for within, _ in parts for value in within], parts[-1][1]
    if "prefixItems" in schema:
        (one, no_one), (two, no_two) = (edges(item) for item in schema["prefixItems"])
        wrong = [*([value, two[0]] for value in no_one), *([one[0], value] for value in no_two)]
        return [list(pair) for pair in zip(one, two, strict=True)], wrong
    if "maximum" not in schema:
        return schema.get("enum") or [schema["const"]], ["something else"]
    most = schema["maximum"]
    if "exclusiveMinimum" in schema:
        least = schema["exclusiveMinimum"]
        return [least + 1e-9, most], [least, most + 1e-9]
    least = schema["minimum"]
    step = 1 if schema["type"] == "integer" else least / 2
    return [least, most], [least - step, most + step]


OPTION_CASES = [
    *(
        (boundary, name)
        for boundary in sorted(BOUNDARIES)
        for name in BOUNDARIES[boundary].defaults
    ),
    *((None, name) for name in ("space", "boundary", "cost", "intent", "surface_samples")),
    *(("CAM16-UCS", name) for name in ("adapting_luminance", "background")),
    *(("CAM16-UCS", name) for name in ("adaptation", "surround")),
]


@pytest.mark.parametrize(("chosen", "name"), OPTION_CASES)
def test_values_are_accepted_up_to_the_documented_limits_and_not_beyond(chosen, name):
    schema = SCHEMAS["GamutOptions"]["properties"][name]
    given = {} if chosen is None else {"boundary": chosen}
    if chosen == "CAM16-UCS":
        given = {"space": chosen}
    within, beyond = edges(schema)
    for value in within:
        stated = Options.from_mapping({**given, name: value}).to_mapping()
        assert stated[name] == value
        assert faults({"$ref": "#/components/schemas/GamutOptions"}, stated) == []
    for value in beyond:
        with pytest.raises(OptionError):
            Options.from_mapping({**given, name: value})
        assert faults(schema, value)
