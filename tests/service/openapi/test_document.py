import json
from pathlib import Path

import pytest

from service.application import create_app
from service.command import openapi_document
from service.problems.kinds import KINDS
from service.settings import Settings

COMMITTED = Path(__file__).parents[3] / "openapi" / "openapi.json"

DOCUMENT = json.loads(openapi_document())

OPERATIONS = {
    f"{method} {path}": operation
    for path, operations in DOCUMENT["paths"].items()
    for method, operation in operations.items()
}


def contents(operation):
    """All bodies of an operation's request and responses."""
    bodies = [operation.get("requestBody", {}), *operation["responses"].values()]
    return [content for body in bodies for content in body.get("content", {}).values()]


@pytest.mark.slow
def test_the_committed_document_is_what_the_app_generates():
    assert COMMITTED.read_text() == openapi_document()


def test_the_document_does_not_depend_on_the_environment(monkeypatch):
    monkeypatch.setenv("GAMUT_MAX_PAGE_SIZE", "7")
    assert json.loads(openapi_document()) == DOCUMENT


def test_operation_ids_are_distinct():
    ids = [operation["operationId"] for operation in OPERATIONS.values()]
    assert len(set(ids)) == len(ids)


@pytest.mark.parametrize("name", OPERATIONS)
def test_every_operation_explains_itself(name):
    operation = OPERATIONS[name]
    assert operation["summary"]
    assert operation["description"]
    for parameter in operation.get("parameters", []):
        assert parameter["description"], parameter["name"]
    for content in contents(operation):
        assert content["examples"]
        assert content.get("schema")


@pytest.mark.parametrize("name", OPERATIONS)
def test_every_error_is_documented_as_a_problem(name):
    for status, response in OPERATIONS[name]["responses"].items():
        if status >= "400":
            assert list(response["content"]) == ["application/problem+json"]
            for code, example in response["content"]["application/problem+json"][
                "examples"
            ].items():
                assert KINDS[code].status == int(status)
                assert example["value"]["code"] == code


def test_every_problem_is_documented_somewhere_or_belongs_to_no_operation():
    documented = {
        code
        for operation in OPERATIONS.values()
        for response in operation["responses"].values()
        for code in response.get("content", {})
        .get("application/problem+json", {})
        .get("examples", {})
    }
    assert set(KINDS) - documented == {"method-not-allowed"}


def test_every_reference_leads_somewhere():
    def references(node):
        if isinstance(node, dict):
            yield from ([node["$ref"]] if isinstance(node.get("$ref"), str) else [])
            for child in node.values():
                yield from references(child)
        elif isinstance(node, list):
            for child in node:
                yield from references(child)

    schemas = DOCUMENT["components"]["schemas"]
    for reference in references(DOCUMENT):
        assert reference.removeprefix("#/components/schemas/") in schemas


def test_making_an_app_touches_nothing(tmp_path):
    create_app(Settings(store=str(tmp_path / "data")))
    assert list(tmp_path.iterdir()) == []
