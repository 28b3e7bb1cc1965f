"""Admission of queries by their rows, which clients share.

Rows are counted from the moment when a body has arrived to the end of the answer, which bounds the
memory of all queries.
"""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from service.http.shares import Refused, SharedAmount
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["Admission"]


_SMALL_ROWS = 1000
"""Queries of at most so many rows need no share. They are answered within milliseconds."""

_FOR_SMALL = 1 / 20
"""The part of all rows that large queries leave to small ones."""


class Admission:
    """The rows under way. Belongs to the event loop's thread.

    Parameters
    ----------
    most : int
        Largest number of rows of several queries. A single query is always admitted.
    share : float
        The part of them that belongs to one client if others compete.
    """

    def __init__(self, most: int, share: float) -> None:
        self._rows = SharedAmount(most, share)

    @property
    def rows(self) -> int:
        """Rows under way."""
        return self._rows.used

    @contextlib.contextmanager
    def held(self, client: str, estimate: int) -> Iterator[Callable[[int], None]]:
        """Count rows until the end of the context, which gets a function to correct the number.

        Raises
        ------
        ProblemError
            ``queries-busy``: too many rows are under way, of all clients or of this one.
        """
        if refused := self._refusal(client, estimate):
            detail, remedy = f"{self.rows} rows are being answered.", ""
            if refused is Refused.SHARE:
                detail = f"{detail} The client would have more than its share of them."
                remedy = "Wait for the answers to other queries, or try again after Retry-After."
            headers = {"Retry-After": "1"}
            raise ProblemError(Problem("queries-busy", detail, remedy=remedy, headers=headers))
        counted = estimate
        self._rows.take(client, counted)

        def correct(rows: int) -> None:
            nonlocal counted
            self._rows.take(client, rows - counted)
            counted = rows

        try:
            yield correct
        finally:
            self._rows.take(client, -counted)

    def _refusal(self, client: str, rows: int) -> Refused | None:
        most = self._rows.most
        if rows > _SMALL_ROWS:
            return self._rows.refusal(client, rows + int(_FOR_SMALL * most))
        return Refused.FULL if self.rows and self.rows + rows > most else None
