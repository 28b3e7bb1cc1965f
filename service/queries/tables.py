"""Tables of colours in bodies: read as everywhere, with the space and the scale of the API."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from gamutcore.arguments import Number, Text
from gamutcore.colours.spaces import ColourConversion
from gamutcore.errors import CharacterisationError, OptionError, SampleLimitError
from gamutcore.questions import Parameter
from gamutcore.tables import read_table
from service.problems.problem import Problem, ProblemError
from service.queries.parameters import refuse

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.tables import ColourTable

__all__ = ["TABLE_PARAMETERS", "TableRequest", "read_colours"]

TABLE_PARAMETERS = (
    Parameter(
        "columns",
        Annotated[str, Text(200, "names or numbers of columns, separated by commas")],
        "For tables: names or numbers of the three columns of the colours, or of the one with "
        "texts such as `#e4002b`. By default, the names of the columns decide.",
        example="L,a,b",
    ),
    Parameter(
        "table_scale",
        Annotated[float, Number(0.0, 1e6, above_least=True, below_most=True)],
        "For tables: the value of white, such as 1, 100 or 255. By default, the values decide, and "
        "with `space` it is 1 for `sRGB` and `CIEXYZ`.",
        example=255,
    ),
)
"""Parameters of queries whose body is a table."""

_SCALED = frozenset({"sRGB", "CIEXYZ"})
"""Spaces that tables have on several scales. That of the API is 0 to 1."""

_MOST_BYTES = 4 * 2**20
"""Largest body of measurements or swatches. CGATS of this size, in rows of 15 bytes, takes 0.13 GB
and some seconds."""

_NPY_MAGIC = b"\x93NUMPY"


class TableRequest(NamedTuple):
    """What the request says about the table in its body.

    Attributes
    ----------
    own : ColourSpace
        The space of the gamut, whose coordinates come first.
    space, columns : str or None
    scale : float or None
    """

    own: ColourSpace
    space: str | None = None
    columns: str | None = None
    scale: float | None = None

    @classmethod
    def of(cls, own: ColourSpace, values: Mapping[str, Any]) -> TableRequest:
        """Return what the parameters say."""
        return cls(own, *(values.get(name) for name in ("space", "columns", "table_scale")))


def read_colours(
    content: bytes, names: Sequence[str], asked: TableRequest, most: int
) -> ColourTable:
    """Return the table in a body.

    Parameters
    ----------
    content : bytes
    names : sequence of str
        Names of the colours of a row. With several, columns have them as a prefix: ``from_L``.
    asked : TableRequest
    most : int
        Largest number of rows.

    Raises
    ------
    ProblemError
        There are no such columns, the table is malformed, or there are too many rows.
    InvalidPointsError
        A cell is not a number, or outside the scale of the space.
    """
    if content.startswith(_NPY_MAGIC):
        remedy = "Send it with Content-Type: application/x-npy."
        raise ProblemError(Problem("invalid-body", "The body is an .npy file.", {}, remedy))
    scale = asked.scale
    if scale is None and asked.columns is None and asked.space in _SCALED:
        scale = 1.0
    try:
        table = read_table(
            content,
            space=asked.space,
            columns=asked.columns,
            scale=scale,
            names=names,
            own=asked.own.name,
            most=most,
            most_bytes=_MOST_BYTES,
            limits=ColourConversion(None, asked.own).unscaled,
        )
    except SampleLimitError as error:
        limit = error.where.get("limit", most)
        raise ProblemError(
            Problem("too-many-rows", error.message, {"limit": limit}, error.remedy)
        ) from error
    except OptionError as error:
        field = str(error.where.get("field", "columns"))
        raise refuse(error.message, "query", field, error.remedy) from error
    except CharacterisationError as error:
        raise ProblemError(
            Problem("invalid-body", error.message, error.where, error.remedy)
        ) from error
    if len(table.inputs) != len(names):
        detail = f"The file has one colour in each row, and {' and '.join(names)} are needed."
        remedy = "Send a table whose columns have the prefixes of the operation."
        raise ProblemError(Problem("invalid-body", detail, {"field": names[-1]}, remedy))
    return table
