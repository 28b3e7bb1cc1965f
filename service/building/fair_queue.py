"""Waiting jobs, shared out fairly among the clients that asked for them."""

from __future__ import annotations

from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from service.jobs.documents import JobDocument

__all__ = ["FairQueue"]


class FairQueue:
    """Waiting jobs, shared out fairly among clients: start-time fair queueing (Goyal 1996).

    Every client has one job in each round, and the round advances by one job of each waiting
    client. A client without waiting jobs joins the round under way, so another client's queue
    delays it by one build at most.
    """

    def __init__(self) -> None:
        self._jobs: dict[str, tuple[float, JobDocument]] = {}
        self._next_round: dict[str, float] = {}
        self._round = self._following = 0.0

    def __len__(self) -> int:
        return len(self._jobs)

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._jobs))

    @property
    def oldest(self) -> JobDocument | None:
        """The job that was accepted first; None if there is none."""
        documents = (document for _, document in self._jobs.values())
        return min(documents, key=attrgetter("created"), default=None)

    def put(self, document: JobDocument) -> None:
        """Add a job behind the other jobs of its client."""
        number = max(self._round, self._next_round.get(document.client, 0.0))
        self._next_round[document.client] = number + 1
        self._jobs[document.id] = number, document

    def find(self, job_id: str) -> JobDocument | None:
        """Return a waiting job; None if it does not wait."""
        return self._jobs[job_id][1] if job_id in self._jobs else None

    def discard(self, job_id: str) -> None:
        """Remove a job, if it waits."""
        self._jobs.pop(job_id, None)

    def take(self, preferred: str = "") -> JobDocument | None:
        """Remove and return the next job; None if there is none.

        The preferred job comes before other jobs of its client.
        """
        if not self._jobs:
            return None
        clients = len({document.client for _, document in self._jobs.values()})
        # The oldest of equals, because a dictionary keeps the order of insertion.
        number, document = min(self._jobs.values(), key=itemgetter(0))
        self._round = max(self._following, number)
        self._following = self._round + 1 / clients
        ahead = {name: next_ for name, next_ in self._next_round.items() if next_ > self._round}
        self._next_round = ahead
        del self._jobs[document.id]
        other = self.find(preferred)
        if other is None or other.client != document.client:
            return document
        self._jobs[document.id] = self._jobs.pop(preferred)[0], document
        return other
