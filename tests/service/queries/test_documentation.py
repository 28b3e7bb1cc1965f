import json

import pytest

from service.queries.bodies import CSV, JSON, parse_body
from service.queries.documentation import query_response, request_body
from service.queries.operations import OPERATIONS


@pytest.mark.parametrize("name", OPERATIONS)
def test_examples_are_accepted_and_equal(name):
    operation = OPERATIONS[name]
    content = request_body(operation)["content"]
    given = content[JSON]["examples"]["colours"]["value"]
    table = content[CSV]["examples"]["table"]["value"]
    axes = ("L*", "a*", "b*")
    bodies = [
        parse_body(bytearray(json.dumps(given).encode()), JSON, operation, axes),
        parse_body(bytearray(table.encode()), CSV, operation, axes),
    ]
    for one, two in zip(*(body.inputs for body in bodies), strict=True):
        assert one.tolist() == two.tolist()


@pytest.mark.parametrize("name", OPERATIONS)
def test_schemas_have_all_members(name):
    operation = OPERATIONS[name]
    schema = request_body(operation)["content"][JSON]["schema"]
    parameters = [each.name for each in operation.all_parameters]
    assert list(schema["properties"]) == [*operation.inputs, *parameters]
    answer = query_response(operation)["content"][JSON]
    assert list(answer["schema"]["properties"]) == [
        "level",
        *(column.name for column in operation.columns),
    ]
    assert answer["examples"]["answer"]["value"].keys() == {"level", *operation.answered}
