"""Lists in pages: every one of them is asked for, cut and linked in this way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Protocol, TypeVar

from fastapi import Query

from service.http.parameters import ID_OR_NOTHING, ID_PATTERN, LARGEST_WHOLE, POSITIVE_NUMBER
from service.openapi.documentation import EXAMPLE_ID

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["After", "Limit", "page_of"]

Limit = Annotated[
    int,
    Query(
        ge=1,
        description="Entries on a page at most; the service has a limit as well.",
        json_schema_extra={"maximum": LARGEST_WHOLE},
    ),
    POSITIVE_NUMBER,
]
"""The query parameter `limit`."""

After = Annotated[
    str,
    Query(
        pattern=f"^({ID_PATTERN})?$",
        description="Id of the last entry of the page before.",
        examples=[EXAMPLE_ID],
    ),
    ID_OR_NOTHING,
]
"""The query parameter `after`."""


class _Listed(Protocol):
    @property
    def id(self) -> str: ...


_T = TypeVar("_T", bound=_Listed)


def page_of(
    found: Sequence[_T], limit: int, path: str
) -> tuple[Sequence[_T], str | None, dict[str, str]]:
    """Return one page of a list.

    Parameters
    ----------
    found : sequence
        What there is after the page before: one more than `limit` tells that there is a next one.
    limit : int
        How many are shown at most.
    path : str
        The path of the list.

    Returns
    -------
    shown : sequence
        What is on the page.
    following : str or None
        The path and query of the next one, if there is more.
    headers : dict
        The ``Link`` to that one (RFC 8288).
    """
    shown = found[:limit]
    if len(found) <= limit:
        return shown, None, {}
    following = f"{path}?limit={limit}&after={shown[-1].id}"
    return shown, following, {"Link": f'<{following}>; rel="next"'}
