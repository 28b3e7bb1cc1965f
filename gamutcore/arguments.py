"""Types of arguments: what a parameter accepts, for pydantic, for messages and for tables.

An algorithm declares the type of its parameter next to its code as an annotation, such as
``SUBDIVISIONS = Annotated[int, WholeNumber(0, 7)]``, and checks an argument with `check_option`.
The fields of `gamutcore.options.Options` have the same types, so each bound is written once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from types import UnionType
from typing import Annotated, Any, TypeAlias, Union, get_args, get_origin

from pydantic import (
    BeforeValidator,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    TypeAdapter,
    ValidationError,
)
from pydantic.json_schema import WithJsonSchema
from pydantic_core import CoreSchema, core_schema
from typing_extensions import TypeAliasType

from gamutcore.errors import OptionError
from gamutcore.names import folded, near_match


def finite_number(value: object) -> float | None:
    """Return a number as a finite float, never -0.0.

    None stands for anything else, including booleans and text.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number + 0.0 if math.isfinite(number) else None


def _required(value: Any) -> Any:  # noqa: ANN401  # the value of any type
    if value is None:
        raise ValueError("not accepted")
    return value


def _finite(value: object) -> float:
    number: float = _required(finite_number(value))
    return number


FiniteNumber: TypeAlias = Annotated[float, BeforeValidator(_finite)]
"""A finite float, never -0.0."""


@dataclass(frozen=True)
class Choice:
    """One of some names, or of some whole numbers.

    Names are matched without regard to letter case, spaces and punctuation. `aliases` maps further
    spellings, in lower-case letters and digits, to values.
    """

    values: tuple[str, ...] | tuple[int, ...]
    aliases: Mapping[str, str] = field(default_factory=dict, hash=False)

    @property
    def accepted(self) -> str:
        """Accepted values in words, to follow "Give" in a message."""
        shown = [repr(value) if len(self.values) == 1 else str(value) for value in self.values]
        return shown[0] if len(shown) == 1 else f"one of {', '.join(shown)}"

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self._meant)

    def __get_pydantic_json_schema__(self, schema: object, handler: object) -> dict[str, Any]:
        # Never `const`: some generated clients refuse the other alternatives of a constant.
        json_type = "string" if isinstance(self.values[0], str) else "integer"
        return {"enum": list(self.values), "type": json_type}

    def _meant(self, value: object) -> object:
        if isinstance(value, str):
            folds = {folded(choice): choice for choice in self.values if isinstance(choice, str)}
            return _required({**self.aliases, **folds}.get(folded(value)))
        number = finite_number(value)
        return _required(next((choice for choice in self.values if choice == number), None))


@dataclass(frozen=True)
class Number:
    """A finite number within bounds, which `above_least` and `below_most` exclude.

    Messages and tables state the unit; it is empty for a pure number.
    """

    least: float
    most: float
    above_least: bool = False
    below_most: bool = False
    unit: str = ""

    @property
    def accepted(self) -> str:
        """Accepted values in words, to follow "Give" in a message."""
        least, most = (f"{bound:.10g}" for bound in (self.least, self.most))
        if self.above_least:
            below = f" and below {most}" if self.below_most else f", at most {most}"
            bounds = f"above {least}{below}"
        else:
            bounds = f"from {least} to {most}"
        return f"a number {bounds}" + (f", in {self.unit}" if self.unit else "")

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> CoreSchema:
        bounded = core_schema.float_schema(
            gt=self.least if self.above_least else None,
            ge=None if self.above_least else self.least,
            lt=self.most if self.below_most else None,
            le=None if self.below_most else self.most,
        )
        return core_schema.no_info_before_validator_function(_finite, bounded)


@dataclass(frozen=True)
class WholeNumber:
    """A whole number from `least` to `most`. Booleans and floats are refused."""

    least: int
    most: int

    @property
    def accepted(self) -> str:
        """Accepted values in words, to follow "Give" in a message."""
        return f"a whole number from {self.least} to {self.most}"

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> CoreSchema:
        return core_schema.int_schema(ge=self.least, le=self.most, strict=True)


@dataclass(frozen=True)
class Boolean:
    """True or false."""

    accepted: str = "true or false"

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> CoreSchema:
        return core_schema.bool_schema(strict=True)


@dataclass(frozen=True)
class Text:
    """Printable text of 1 to `longest` characters; `normalise` maps it to its canonical form."""

    longest: int
    accepted: str
    normalise: Callable[[str], str] = str

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> CoreSchema:
        text = core_schema.str_schema(min_length=1, max_length=self.longest, strict=True)
        return core_schema.no_info_after_validator_function(self._canonical, text)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {**handler(schema), "description": self.accepted}

    def _canonical(self, text: str) -> str:
        printable = text.strip() and text.isprintable()
        return self.normalise(text if printable else _required(None))


@dataclass(frozen=True)
class Array:
    """A list or tuple of `length` items as annotated, and no other collection."""

    accepted: str
    length: int

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._array, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        array = handler(schema)
        first, *others = array.get("prefixItems", [None])
        if others and all(item == first for item in others):  # few client generators read these
            del array["prefixItems"]
            array["items"] = first
        return array

    def _array(self, value: object) -> object:
        return _required(value if isinstance(value, list | tuple) else None)


Coordinates = TypeAliasType(
    "Coordinates",
    Annotated[
        tuple[FiniteNumber, FiniteNumber, FiniteNumber],
        Array("three finite numbers", 3),
        WithJsonSchema(
            {
                "description": "Three coordinates.",
                "items": {"type": "number"},
                "maxItems": 3,
                "minItems": 3,
                "type": "array",
            }
        ),
    ],
)
"""A named schema: client generators give an anonymous one the default of the field around it."""


Mark: TypeAlias = Choice | Number | WholeNumber | Boolean | Text | Array
"""What an annotation states of the accepted values. Each also checks values for pydantic."""


def marks(kind: Any) -> list[Mark]:  # noqa: ANN401  # an annotation
    """Return the mark of each alternative of an annotation; None as an alternative has no mark."""
    if isinstance(kind, TypeAliasType):
        return marks(kind.__value__)
    if get_origin(kind) in {Union, UnionType}:
        return [mark for part in get_args(kind) for mark in marks(part)]
    if get_origin(kind) is Annotated:
        own = [mark for mark in kind.__metadata__ if isinstance(mark, Mark)]
        return own or marks(kind.__origin__)
    return []


def accepted_values(kind: object) -> str:
    """Describe the values that a type accepts, such as "'auto' or three finite numbers"."""
    return " or ".join(mark.accepted for mark in marks(kind))


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:  # noqa: ANN401  # an annotation
    return TypeAdapter(kind)


def canonical(value: object, kind: object) -> Any:  # noqa: ANN401  # as the annotation says
    """Return the canonical form of a value of some type; None if the type does not accept it."""
    try:
        return _adapter(kind).validate_python(value)
    except ValidationError:
        return None


def check_option(name: str, value: object, kind: object) -> Any:  # noqa: ANN401  # as annotated
    """Return the canonical form of an option's value, or raise its `refusal`."""
    canonical_value = canonical(value, kind)
    if canonical_value is None:
        raise refusal(name, value, kind)
    return canonical_value


def refusal(name: str, value: object, kind: object) -> OptionError:
    """Return the error of a value that is not of a type, with the name that it resembles."""
    error = OptionError.refusal(name, value, accepted_values(kind))
    names = [
        str(choice) for mark in marks(kind) if isinstance(mark, Choice) for choice in mark.values
    ]
    meant = near_match(value, names) if isinstance(value, str) else None
    if meant is not None:
        error.remedy += f" Did you mean {meant!r}?"
    return error
