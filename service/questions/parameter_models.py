"""Models of the parameters of questions, made from their declarations in `gamutcore`.

FastAPI reads and documents a model as the query of an operation. The parameters of a question about
colours may also be members of a JSON body, which the same model checks.
"""

from __future__ import annotations

import re
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Any, Self, TypeVar

from fastapi import Query
from pydantic import BaseModel, Field, ValidationError, create_model, field_validator
from pydantic_core import PydanticCustomError

from gamutcore.arguments import refusal
from service.http.requests import (
    DECIMAL_PATTERN,
    LONGEST_SHOWN,
    check_names,
    invalid_parameter,
    request_error,
)

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterable, Iterator, Mapping, Sequence

    from pydantic import ValidationInfo, ValidatorFunctionWrapHandler

    from gamutcore.questions import Parameter

__all__ = ["Parameters", "parameter_model", "query_of"]

_NUMBER = re.compile(rf"-?{DECIMAL_PATTERN}\Z")

_NOTES = {
    "space": " In the query string of a slug, `space` is the option of the build instead.",
}
"""What is particular to HTTP about a parameter."""

_IN_BODY = "body"
"""Context of a validation of JSON values. Without it, values are texts of a query string."""

ModelT = TypeVar("ModelT", bound="Parameters")


class Parameters(BaseModel):
    """Base of the models. Values are in their canonical form, or the default."""

    @field_validator("*", mode="wrap")
    @classmethod
    def _check(
        cls,
        value: Any,  # noqa: ANN401  # a text, or JSON
        accept: ValidatorFunctionWrapHandler,
        info: ValidationInfo,
    ) -> object:
        if info.context == _IN_BODY:
            values = [value]
        else:  # FastAPI has a list of all texts for a parameter that may be an array
            values = list(_meanings(value[0] if isinstance(value, list) else value))
        for meaning in values:
            with suppress(ValidationError):
                return accept(meaning)
        name = str(info.field_name)
        remedy = refusal(name, values[0], cls.model_fields[name].rebuild_annotation()).remedy
        shown = repr(values[0])[:LONGEST_SHOWN]
        message = "{name} is {shown}, which is not accepted"
        context = {"name": name, "shown": shown, "remedy": remedy}
        raise PydanticCustomError("value", message, context)

    @classmethod
    def of_query(cls, items: Sequence[tuple[str, str]], options: Iterable[str] = ()) -> Self:
        """Return the parameters in a query string, for routes without FastAPI's dependencies.

        `options` are further names that the query string may have.
        """
        if items:
            check_names(items, (*cls.model_fields, *options))
        try:
            return cls.model_validate(dict(items))
        except ValidationError as error:
            raise request_error(error, "query") from None

    def with_members(self, members: Mapping[str, object]) -> dict[str, Any]:
        """Return all values, with those of the members of a JSON body."""
        if not members:
            return dict(self)
        for name in members:
            if name in self.model_fields_set:
                fault = f"{name} is given in the query string and in the body."
                raise invalid_parameter(fault, "query", name, "Give each parameter once.")
        try:
            body = self.model_validate(members, context=_IN_BODY)
        except ValidationError as error:
            raise request_error(error, "body") from None
        return dict(self) | {name: getattr(body, name) for name in members}


def parameter_model(title: str, parameters: Iterable[Parameter]) -> type[Parameters]:
    """Return the model of some parameters."""
    fields: dict[str, Any] = {
        parameter.name: (
            parameter.kind,
            Field(
                default=parameter.default,
                description=parameter.description + _NOTES.get(parameter.name, ""),
                examples=None if parameter.example is None else [parameter.example],
                json_schema_extra=_without_null,
            ),
        )
        for parameter in parameters
    }
    return create_model(title, __base__=Parameters, **fields)


def query_of(model: type[ModelT]) -> Callable[..., Awaitable[ModelT]]:
    """Return the dependency of FastAPI whose query parameters are the fields of a model."""

    async def parameters(values: ModelT) -> ModelT:
        return values

    parameters.__annotations__["values"] = Annotated[model, Query()]
    return parameters


def _without_null(schema: dict[str, Any]) -> None:
    """Remove the default None, which no client may send."""
    if schema.get("default", "") is None:
        del schema["default"]


def _meanings(text: str) -> Iterator[object]:
    """Yield the values that a text of a query string may stand for."""
    if text in {"true", "false"}:
        yield text == "true"
    parts = text.split(",")
    if all(_NUMBER.match(part) for part in parts):
        numbers = [int(part) if part.isdigit() else float(part) for part in parts]
        yield numbers if len(numbers) > 1 else numbers[0]
    yield text
