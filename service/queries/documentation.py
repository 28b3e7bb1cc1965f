"""The OpenAPI description of queries: bodies, answers and examples, from the declarations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from service.http.conditional import IMMUTABLE
from service.openapi.documentation import binary_content, header
from service.queries.bodies import CSV, FORMS, JSON, NPY, SVG, TABLES
from service.queries.parameters import description
from service.queries.parameters import schema as schema_of

if TYPE_CHECKING:
    from gamutcore.questions import Question

__all__ = ["picture_response", "query_response", "request_body", "stated_header", "view_response"]

_COLOURS = {
    "type": "array",
    "items": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
    "maxItems": FORMS[JSON].most_rows,
}

_LEVEL = {
    "title": "AnsweringLevel",
    "type": "object",
    "properties": {
        "triangles": {"type": "integer", "description": "Triangles of the level."},
        "max_error": {
            "type": "number",
            "description": "Upper bound of its distance from the full boundary.",
        },
    },
    "required": ["triangles", "max_error"],
}

_VIEWING = {"type": ["number", "string"]}

_CONDITIONS = {
    "title": "GamutConditions",
    "type": "object",
    "description": "What the colours of the gamut are relative to.",
    "properties": {
        "intent": {
            "type": "string",
            "description": "`relative`, `absolute`, `perceptual`, `saturation`, or `as given` for "
            "colours whose white is not known.",
        },
        "ink_limit": {"type": ["number", "null"], "description": "In per cent."},
        "black_limit": {"type": ["number", "null"], "description": "In per cent."},
        "white": {
            "type": "object",
            "description": "Reference white of the space.",
            "properties": {
                "name": {"type": "string"},
                "xyz": {"type": "array", "items": {"type": "number"}},
            },
        },
        "medium_white": {
            "type": ["array", "null"],
            "items": {"type": "number"},
            "description": "L\\*, a\\*, b\\* of the white of the medium, as measured.",
        },
        "space": {"type": "string"},
        "viewing_conditions": {
            "type": "object",
            "description": "Luminances, background and surround, in spaces that have any.",
            "additionalProperties": _VIEWING,
        },
    },
    "required": ["intent", "ink_limit", "black_limit", "white", "medium_white", "space"],
}

_WARNINGS = {
    "type": "array",
    "items": {"type": "string"},
    "description": "Reasons why the answer may mislead, such as another intent.",
}

_OWN_SPACE = "For tables: the colours as they were understood, in the space of the gamut."

_READING = {
    "reading": {
        "type": "string",
        "description": "For tables: what was understood, in a sentence: columns, space, scale, "
        "separator and encoding.",
    },
    "labels": {
        "type": "array",
        "items": {"type": "string"},
        "description": "For tables: the first text of each row that has a colour.",
    },
    "lines": {
        "type": "array",
        "items": {"type": "integer"},
        "description": "For tables: the line in the file of each row that has a colour, or the "
        "number of the row if the file is no delimited text.",
    },
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
    """Return the description of the body of an question."""
    names = question.inputs
    colours = {
        name: {**_COLOURS, "description": "Colours, in the space of the gamut."} for name in names
    }
    members = {
        each.name: {**schema_of(each), "description": description(each)}
        for each in question.all_parameters
    }
    schema = {
        "title": f"{_title(question)}Query",
        "type": "object",
        "properties": {**colours, **members},
        "required": list(names),
        "additionalProperties": False,
    }
    width = 3 * len(names)
    others = ", ".join(f"`{each}`" for each in sorted(TABLES - {CSV}))
    return {
        "description": "Colours. Tables are recognised by their content, such as CSV, CGATS, CxF "
        f"and Adobe swatches: `{CSV}` stands for {others} as well.",
        "required": True,
        "content": {
            JSON: {
                "schema": schema,
                "examples": {"colours": {"value": dict(question.example)}},
            },
            NPY: {
                "schema": {"type": "string", "format": "binary"},
                "examples": {"array": {"summary": f"An array (n, {width}) of float32 or float64"}},
            },
            CSV: {
                # client generators pass other types of body as a file
                "schema": {"type": "string", "format": "binary"},
                "examples": {"table": {"value": _table(question)}},
            },
        },
    }


def query_response(question: Question) -> dict[str, Any]:
    """Return the description of the answer of an question."""
    columns = {
        column.name: {
            "type": "array",
            "items": dict(column.schema),
            "description": column.description,
        }
        for column in question.columns
    }
    stated = {
        name: {"type": "number", "description": f"Value of the parameter `{name}`, or its default."}
        for name in question.answered
        if name not in columns
    }
    of_tables = {name: {**_COLOURS, "description": _OWN_SPACE} for name in question.inputs}
    answer = {
        "title": f"{_title(question)}Answer",
        "type": "object",
        "properties": {
            "level": _LEVEL,
            "gamut": _CONDITIONS,
            "warnings": _WARNINGS,
            **stated,
            **_READING,
            **of_tables,
            **columns,
        },
        "required": ["level", "gamut", "warnings", *stated],
    }
    example = {
        "level": _EXAMPLE_LEVEL,
        "gamut": _EXAMPLE_CONDITIONS,
        "warnings": [],
        **question.answered,
    }
    return {
        "description": "One entry per row, in the order of the rows.",
        "content": {
            JSON: {"schema": answer, "examples": {"answer": {"value": example}}},
            NPY: {
                "schema": {"type": "string", "format": "binary"},
                "examples": {"array": {"summary": "A structured array, one field per column"}},
            },
            CSV: {
                "schema": {"type": "string"},
                "examples": {
                    "table": {"summary": "The columns of the body and those of the result"}
                },
            },
        },
        "headers": {
            "Gamut-Triangles": header("Triangles of the level.", 1000),
            "Gamut-Max-Error": header(
                "Upper bound of its distance from the full boundary, in units of the space.",
                "0.268516",
            ),
            **{
                stated_header(name): header(schema["description"], question.answered[name])
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
    """Return the description of the answer to a question."""
    members = dict(question.members)
    if question.name == "comparisons":
        both = {"type": "object", "properties": {"a": _LEVEL, "b": _LEVEL}, "required": ["a", "b"]}
        stated = dict.fromkeys("ab", _CONDITIONS)
        first: dict[str, Any] = {
            "levels": {**both, "title": "ComparedLevels"},
            "gamuts": {
                "title": "ComparedGamuts",
                "type": "object",
                "properties": stated,
                "required": ["a", "b"],
            },
        }
        example: dict[str, Any] = {
            "levels": {"a": _EXAMPLE_LEVEL, "b": _EXAMPLE_LEVEL},
            "gamuts": {"a": _EXAMPLE_CONDITIONS, "b": _EXAMPLE_CONDITIONS},
        }
    else:
        first = {"level": _LEVEL, "gamut": _CONDITIONS}
        example = {"level": _EXAMPLE_LEVEL, "gamut": _EXAMPLE_CONDITIONS}
    first["warnings"], example["warnings"] = _WARNINGS, []
    answer = {
        "title": f"{_title(question)}Answer",
        "type": "object",
        "properties": {**first, **members},
        "required": list(first),
    }
    example = {**example, **question.answered}
    return {
        "description": question.summary,
        "content": {
            JSON: {"schema": answer, "examples": {"answer": {"value": example}}},
            NPY: {
                "schema": {"type": "string", "format": "binary"},
                "examples": {"array": {"summary": "A structured array"}},
            },
            CSV: {"schema": {"type": "string"}, "examples": {"table": {"summary": "A table"}}},
        },
        "headers": _IMMUTABLE_HEADERS,
    }


def picture_response() -> dict[str, Any]:
    """Return the description of a picture."""
    return {
        "description": "The picture.",
        "content": binary_content({SVG: "A picture as SVG"}),
        "headers": _IMMUTABLE_HEADERS,
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
