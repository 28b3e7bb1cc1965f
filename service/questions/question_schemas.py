"""The OpenAPI description of queries: bodies, answers and examples, from the declarations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gamutcore.questions.declarations import (
    COLOUR,
    NULLABLE_NUMBER,
    NUMBER,
    described,
    list_of,
)
from service.http.representations import IMMUTABLE
from service.openapi.documentation import header
from service.questions.colour_bodies import CSV, FORMS, JSON, NPY, TABLES
from service.questions.parameter_models import parameter_model

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gamutcore.questions import Question

__all__ = ["query_response", "request_body", "stated_header", "view_response"]


def _object(
    title: str, properties: Mapping[str, Any], required: Iterable[str], description: str = ""
) -> dict[str, Any]:
    """Return the schema of an object, whose title names the class of generated clients."""
    about = {"description": description} if description else {}
    members = {"properties": dict(properties), "required": list(required)}
    return {"title": title, "type": "object", **about, **members}


_TEXT = {"type": "string"}
_BINARY = {"type": "string", "format": "binary"}
_COLOURS = {**list_of(COLOUR), "maxItems": FORMS[JSON].most_rows}
_DEVICE_VALUES = {**list_of(list_of(NUMBER)), "maxItems": FORMS[JSON].most_rows}

_LEVEL = _object(
    "AnsweringLevel",
    {
        "triangles": described({"type": "integer"}, "Triangles of the level."),
        "max_error": described(NUMBER, "Upper bound of its distance from the full boundary."),
    },
    ("triangles", "max_error"),
)

_CONDITIONS = _object(
    "GamutConditions",
    {
        "intent": described(
            _TEXT,
            "`relative`, `absolute`, `perceptual`, `saturation`, or `as given` for colours whose "
            "white is not known.",
        ),
        "ink_limit": described(NULLABLE_NUMBER, "In per cent."),
        "black_limit": described(NULLABLE_NUMBER, "In per cent."),
        "white": {
            "type": "object",
            "description": "Reference white of the space.",
            "properties": {"name": _TEXT, "xyz": list_of(NUMBER)},
        },
        "medium_white": described(
            {"type": ["array", "null"], "items": NUMBER},
            "L\\*, a\\*, b\\* of the white of the medium, as measured.",
        ),
        "space": _TEXT,
        "viewing_conditions": {
            "type": "object",
            "description": "Luminances, background and surround, in spaces that have any.",
            "additionalProperties": {"type": ["number", "string"]},
        },
    },
    ("intent", "ink_limit", "black_limit", "white", "medium_white", "space"),
    "What the colours of the gamut are relative to.",
)

_WARNINGS = described(list_of(_TEXT), "Reasons why the answer may mislead, such as another intent.")

_OWN_SPACE = "For tables: the colours as they were understood, in the space of the gamut."

_READING = {
    "reading": described(
        _TEXT,
        "For tables: what was understood, in a sentence: columns, space, scale, separator and "
        "encoding.",
    ),
    "labels": described(
        list_of(_TEXT), "For tables: the first text of each row that has a colour."
    ),
    "lines": described(
        list_of({"type": "integer"}),
        "For tables: the line in the file of each row that has a colour, or the number of the row "
        "if the file is no delimited text.",
    ),
}

_EXAMPLE_CONDITIONS = {
    "intent": "absolute",
    "ink_limit": 300,
    "black_limit": None,
    "white": {"name": "D50", "xyz": [0.9642, 1.0, 0.8249]},
    "medium_white": [95.0, 0.0, -2.0],
    "space": "CIELAB",
}

_STATED_HEADERS = {
    "Gamut-Conditions": header(
        "Intent, ink limit, white and space of the gamut; of two gamuts separated by a comma.",
        "intent=absolute; ink-limit=300; white=D50; space=CIELAB",
    ),
    "Gamut-Warning": header(
        "Reasons why the answer may mislead, as a list of strings (RFC 9651).",
        '"The intents differ: A has the intent relative, B has absolute."',
    ),
}

_IMMUTABLE_HEADERS = {
    "ETag": header("Strong entity tag: the SHA-256 of the content.", '"4f1d9c07"'),
    "Cache-Control": header("The content is immutable.", IMMUTABLE),
    "Vary": header("Request fields that select the content.", "Accept, Accept-Encoding"),
    **_STATED_HEADERS,
}

_EXAMPLE_LEVEL = {"triangles": 1000, "max_error": 0.268516}


def stated_header(name: str) -> str:
    """Return the header field that states the value of a parameter.

    Examples
    --------
    >>> stated_header("edge_width")
    'Gamut-Edge-Width'
    """
    return f"Gamut-{name.replace('_', '-').title()}"


def request_body(question: Question) -> dict[str, Any]:
    """Return the description of the body of a question."""
    names = question.inputs
    colours = dict.fromkeys(names, described(_COLOURS, "Colours, in the space of the gamut."))
    if question.of_device:
        colours = dict.fromkeys(names, described(_DEVICE_VALUES, "Device values, 0 to 1."))
    title = f"{_title(question)}Query"
    model = parameter_model(title, question.all_parameters)
    members = model.model_json_schema(ref_template="#/components/schemas/{model}")["properties"]
    schema = _object(title, {**colours, **members}, names)
    schema["additionalProperties"] = False
    width = "channels" if question.of_device else 3 * len(names)
    others = ", ".join(f"`{media_type}`" for media_type in sorted(TABLES - {CSV}))
    content = {
        JSON: {"schema": schema, "examples": {"colours": {"value": dict(question.example)}}},
        NPY: {
            "schema": _BINARY,
            "examples": {"array": {"summary": f"An array (n, {width}) of float32 or float64"}},
        },
    }
    if question.of_device:
        about = "Device values, one number for each channel."
        return {"description": about, "required": True, "content": content}
    # client generators pass other types of body as a file
    table = {"schema": _BINARY, "examples": {"table": {"value": _table(question)}}}
    return {
        "description": "Colours. Tables are recognised by their content, such as CSV, CGATS, CxF "
        f"and Adobe swatches: `{CSV}` stands for {others} as well.",
        "required": True,
        "content": {**content, CSV: table},
    }


def query_response(question: Question) -> dict[str, Any]:
    """Return the description of the answer to a question about colours."""
    columns = {
        column.name: described(list_of(column.schema), column.description)
        for column in question.columns
    }
    stated = {
        name: described(
            {"type": "string"} if isinstance(value, str) else NUMBER,
            f"Value of the parameter `{name}`, or its default.",
        )
        for name, value in question.example_answer.items()
        if name not in columns
    }
    of_tables = {**_READING, **dict.fromkeys(question.inputs, described(_COLOURS, _OWN_SPACE))}
    required = {"level": _LEVEL, "gamut": _CONDITIONS, "warnings": _WARNINGS, **stated}
    shown = {"level": _EXAMPLE_LEVEL, "gamut": _EXAMPLE_CONDITIONS, "warnings": []}
    return {
        "description": "One entry per row, in the order of the rows.",
        "content": _forms(
            question,
            required,
            columns if question.of_device else {**of_tables, **columns},
            shown,
            array="A structured array, one field per column",
            table="The columns of the body and those of the result",
        ),
        "headers": {
            "Gamut-Triangles": header("Triangles of the level.", 1000),
            "Gamut-Max-Error": header(
                "Upper bound of its distance from the full boundary, in units of the space.",
                "0.268516",
            ),
            **{
                stated_header(name): header(schema["description"], question.example_answer[name])
                for name, schema in stated.items()
            },
            "Cache-Control": header("Answers to POST are not cached.", "no-store"),
            "Vary": header("Request fields that select the content.", "Accept"),
            "Gamut-Reading": header(
                "For tables: what was understood, as a string or display string (RFC 9651).",
                '"Columns L, a, b are read as CIELAB."',
            ),
            **_STATED_HEADERS,
        },
    }


def view_response(question: Question) -> dict[str, Any]:
    """Return the description of the answer to a question about the shape of gamuts."""
    required = {"level": _LEVEL, "gamut": _CONDITIONS}
    shown: dict[str, Any] = {"level": _EXAMPLE_LEVEL, "gamut": _EXAMPLE_CONDITIONS}
    if question.name == "comparisons":
        required = {
            f"{name}s": _object(f"Compared{name.title()}s", dict.fromkeys("ab", schema), "ab")
            for name, schema in required.items()
        }
        # Last, as in the released document, which stays the same to the byte.
        required["levels"]["title"] = required["levels"].pop("title")
        shown = {f"{name}s": dict.fromkeys("ab", example) for name, example in shown.items()}
    required["warnings"], shown["warnings"] = _WARNINGS, []
    return {
        "description": question.summary,
        "content": _forms(
            question,
            required,
            question.answer_schema,
            shown,
            array="A structured array",
            table="A table",
        ),
        "headers": _IMMUTABLE_HEADERS,
    }


def _forms(
    question: Question,
    required: Mapping[str, Any],
    others: Mapping[str, Any],
    shown: Mapping[str, Any],
    *,
    array: str,
    table: str,
) -> dict[str, Any]:
    """Return the forms of an answer: the schemas of its members in JSON, and words about the rest.

    `required` and `others` are schemas by name. `shown` has examples that all questions share.
    """
    answer = _object(f"{_title(question)}Answer", {**required, **others}, required)
    example = {"value": {**shown, **question.example_answer}}
    return {
        JSON: {"schema": answer, "examples": {"answer": example}},
        NPY: {"schema": _BINARY, "examples": {"array": {"summary": array}}},
        CSV: {"schema": _TEXT, "examples": {"table": {"summary": table}}},
    }


def _title(question: Question) -> str:
    return question.operation_id[:1].upper() + question.operation_id[1:]


def _table(question: Question) -> str:
    """Return the rows of an example as CSV in CIELAB."""
    names = question.inputs
    prefixes = [f"{name}_" for name in names] if len(names) > 1 else [""]
    header_line = ",".join(prefix + axis for prefix in prefixes for axis in "Lab")
    rows = zip(*(question.example[name] for name in names), strict=True)
    lines = [",".join(str(part) for colour in row for part in colour) for row in rows]
    return "\n".join([header_line, *lines, ""])
