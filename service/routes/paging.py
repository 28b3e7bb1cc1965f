"""Paging of lists: parameters, page boundaries and links."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Protocol, TypeVar
from urllib.parse import urlencode

from fastapi import Query
from pydantic import AfterValidator

from service.http.requests import ID_OR_NOTHING, ID_PATTERN, LARGEST_WHOLE, POSITIVE_NUMBER
from service.openapi.documentation import EXAMPLE_ID

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["After", "Limit", "next_page", "page_of"]

MOST_ENTRIES = 100
"""Largest number of entries on a page. An entry of gamuts has a few kilobytes."""

Limit = Annotated[
    int,
    Query(
        ge=1,
        description="Largest number of entries on a page. The service has a limit of its own.",
        json_schema_extra={"maximum": LARGEST_WHOLE},
    ),
    POSITIVE_NUMBER,
    AfterValidator(lambda limit: min(limit, MOST_ENTRIES)),
]
"""The query parameter `limit`."""

After = Annotated[
    str,
    Query(
        pattern=f"^({ID_PATTERN})?$",
        description="Id of the last entry of the previous page.",
        examples=[EXAMPLE_ID],
    ),
    ID_OR_NOTHING,
]
"""The query parameter `after`."""


class _Entry(Protocol):
    @property
    def id(self) -> str: ...


_T = TypeVar("_T", bound=_Entry)


def page_of(
    entries: Sequence[_T], limit: int, path: str
) -> tuple[Sequence[_T], str | None, dict[str, str]]:
    """Return the entries on a page, the address of the next page, and the ``Link`` to it.

    `entries` has the entries after the previous page; one more than `limit` means that there is a
    next page of the list at `path`.
    """
    shown = entries[:limit]
    last = shown[-1].id if len(entries) > limit else None
    return shown, *next_page(last, limit, path)


def next_page(
    last: str | None, limit: int, path: str, **query: str
) -> tuple[str | None, dict[str, str]]:
    """Return the address of the page after the entry `last`, and the ``Link`` to it (RFC 8288).

    None for `last` means that there is no next page. Empty parameters in `query` are left out.
    """
    if last is None:
        return None, {}
    parameters = {name: value for name, value in query.items() if value}
    following = f"{path}?{urlencode({'limit': limit, 'after': last, **parameters})}"
    return following, {"Link": f'<{following}>; rel="next"'}
