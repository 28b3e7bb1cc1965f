"""What a question declares: inputs, parameters, columns of the answer, and the words about them.

Each question is declared once, beside the function that answers it. Routes, the OpenAPI document,
the forms of answers and the options of commands follow from the declarations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from gamutcore.arguments import Number, Text, WholeNumber
from gamutcore.colours import GIVEN_SPACE
from gamutcore.questions.conditions import build_warnings, colour_warnings, comparison_warnings
from gamutcore.questions.levels import check_space

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gamutcore.questions.levels import GamutLike
    from gamutcore.results import Conditions

__all__ = [
    "BOOLEAN",
    "COLOUR",
    "DEVICE",
    "LEVEL_PARAMETERS",
    "NULLABLE_NUMBER",
    "NUMBER",
    "OTHER_GAMUT",
    "SPACE",
    "Answer",
    "Column",
    "Parameter",
    "Question",
    "described",
    "list_of",
]


@dataclass(frozen=True)
class Parameter:
    """A parameter of a question.

    `kind` is an annotation of `gamutcore.arguments`. `default` and `example` are as in JSON; None
    stands for no default and for no example.
    """

    name: str
    kind: Any
    description: str
    default: object = None
    example: object = None


@dataclass(frozen=True)
class Column:
    """A column of the answers to rows of colours.

    `schema` is the JSON schema of one value. `parts` is "axes" for a colour, "channels" for device
    values, and empty for one value. `attribute` of the result has the values, by default that of
    the column's name. None stands for an answer without the column.
    """

    name: str
    description: str
    schema: Mapping[str, Any]
    parts: str = ""
    attribute: str = ""


class Answer(NamedTuple):
    """An answer as columns.

    `columns` are arrays (n,) or (n, k) by name; (m,) or (m, k) if rows have several entries, where
    `offsets` (n + 1,) has the first entry of each row. `channels` are the names of the k device
    values. `document` has the members of the JSON of a question about the shape, as arrays or
    lists. `echoed` has the values of parameters that the answer repeats.
    """

    columns: dict[str, NDArray[Any]]
    offsets: NDArray[np.integer[Any]] | None = None
    channels: tuple[str, ...] = ()
    document: Mapping[str, Any] = {}
    echoed: Mapping[str, float | str] = {}


NUMBER = {"type": "number"}
NULLABLE_NUMBER = {"type": ["number", "null"]}
BOOLEAN = {"type": "boolean"}
COLOUR = {"type": "array", "items": NUMBER, "minItems": 3, "maxItems": 3}


def list_of(schema: Mapping[str, Any]) -> dict[str, Any]:
    """Return the JSON schema of an array."""
    return {"type": "array", "items": schema}


def described(schema: Mapping[str, Any], description: str) -> dict[str, Any]:
    """Return a JSON schema with a description."""
    return {**schema, "description": description}


DEVICE = Column(
    "device",
    "Device values from 0 to 1, interpolated between the vertices of the level. Only for gamuts "
    "with device values.",
    list_of(NUMBER),
    "channels",
)
"""The device values of colours on the surface."""

LEVEL_PARAMETERS = (
    Parameter(
        "triangles",
        Annotated[int, WholeNumber(4, 10**12 - 1)],
        "Largest triangle count of the level that answers.",
        example=1000,
    ),
    Parameter(
        "max_error",
        Annotated[float, Number(0.0, 1e12)],
        "Largest distance between the level that answers and the full boundary, in units of the "
        "space. 0: the full boundary. Default without `triangles`: 0.1 in CIELAB, and the same "
        "share of the lightness of white in other spaces.",
        example=0.1,
    ),
)
"""Parameters of all questions: the level."""

SPACE = Parameter(
    "space",
    GIVEN_SPACE,
    "Space of the colours; that of the gamut by default. `LCHab` has the hue in degrees, `sRGB` is "
    "from 0 to 1. The names of the columns of a table decide without it.",
    example="CIELAB",
)
"""The space of colours in questions and answers."""

OTHER_GAMUT = Annotated[str, Text(64, "the id of a gamut or the slug of a reference gamut")]
"""Another gamut, by its name."""


@dataclass(frozen=True)
class Question:
    """The declaration of a question.

    Attributes
    ----------
    name, operation_id, summary, description : str
    parameters : tuple of Parameter
        Besides the level, and the space of the colours.
    function : callable
        Answers the question: from a gamut, the colours of each input, another gamut as `other`, and
        the values of the parameters, by their names.
    columns : tuple of Column
        All that an answer to rows may have; parameters and gamut decide which it has.
    answer_schema : mapping
        JSON schemas of the members of an answer about the shape.
    tabulate_result : callable, optional
        From the result to the answer, for answers about the shape.
    example, example_answer : mapping
        Members of an exemplary question and of its answer.
    inputs : tuple of str
        Names of the colours of a row; empty for questions about the shape.
    other : str
        Parameter of `function` that is another gamut.
    pair_warnings : callable
        From the conditions of the gamut and of the other one to warnings.
    echoed : callable
        From a gamut and the values of parameters to the values that the answer repeats.
    alternatives : tuple of str
        Parameters of which exactly one is given.
    level : tuple of Parameter
        The parameters of the level.
    needs_model : bool
        Whether the gamut must have its device model.
    of_device : bool
        Whether the rows are device values instead of colours.
    """

    name: str
    operation_id: str
    summary: str
    description: str
    parameters: tuple[Parameter, ...]
    function: Callable[..., Any]
    columns: tuple[Column, ...] = ()
    answer_schema: Mapping[str, Any] = field(default_factory=dict)
    tabulate_result: Callable[[Any], Answer] | None = None
    example: Mapping[str, Any] = field(default_factory=dict)
    example_answer: Mapping[str, Any] = field(default_factory=dict)
    inputs: tuple[str, ...] = ()
    other: str = ""
    pair_warnings: Callable[[Conditions, Conditions], tuple[str, ...]] = comparison_warnings
    echoed: Callable[[GamutLike, Mapping[str, Any]], Mapping[str, float | str]] = (
        lambda _gamut, _values: {}
    )
    alternatives: tuple[str, ...] = ()
    level: tuple[Parameter, ...] = LEVEL_PARAMETERS
    needs_model: bool = False
    of_device: bool = False

    @property
    def all_parameters(self) -> tuple[Parameter, ...]:
        """The parameters, those of the level and the space first."""
        return (*self.level, *((SPACE,) if self.inputs else ()), *self.parameters)

    def answer(
        self, gamuts: Sequence[GamutLike], inputs: Sequence[Any], values: Mapping[str, Any]
    ) -> Answer:
        """Return the answer of a gamut, perhaps with another one, as columns."""
        result = self.function(gamuts[0], *inputs, **self._arguments(gamuts, values))
        return self.tabulate(result)._replace(echoed=self.echoed(gamuts[0], values))

    def tabulate(self, result: Any) -> Answer:  # noqa: ANN401  # of `function`
        """Return a result as columns."""
        if self.tabulate_result is not None:
            return self.tabulate_result(result)
        columns = {
            column.name: getattr(result, column.attribute or column.name) for column in self.columns
        }
        return Answer(
            {name: array for name, array in columns.items() if array is not None},
            getattr(result, "offsets", None),
            getattr(result, "channels", ()),
        )

    def _arguments(self, gamuts: Sequence[GamutLike], values: Mapping[str, Any]) -> dict[str, Any]:
        for other in gamuts[1:]:
            check_space(gamuts[0], other)
        arguments = {parameter.name: values[parameter.name] for parameter in self.all_parameters}
        if self.other:
            arguments[self.other] = gamuts[1] if len(gamuts) > 1 else None
        return arguments

    def warnings(self, gamuts: Sequence[GamutLike], space: str | None) -> tuple[str, ...]:
        """Return reasons why the answer may mislead: of the builds, and by the conditions."""
        conditions = [gamut.conditions for gamut in gamuts]
        names = ("A", "B") if self.other in {"", "other"} else ("the gamut", f"the {self.other}")
        warnings = build_warnings(*conditions, names=names)
        # lines between two colours are no colours that meet a gamut
        warnings += colour_warnings(conditions[0], space or "") if len(self.inputs) == 1 else ()
        for other in conditions[1:]:
            warnings += self.pair_warnings(conditions[0], other)
        return warnings
