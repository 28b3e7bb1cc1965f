"""What all build engines share: their interface, the refusal of builds, and turns of clients.

An engine carries out accepted jobs and is transport only. The state of a job is in
`service.jobs.book.JobBook`, so an engine may lose everything it knows, and may receive a job twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from operator import attrgetter, itemgetter
from typing import Protocol

from service.jobs.book import JobDocument
from service.problems.problem import Problem, ProblemError

__all__ = ["BuildReport", "Engine", "EngineFacts", "FairQueue", "queue_full"]

BuildReport = Callable[[str, dict[str, float]], None]
"""Called at the end of every build with the outcome (a state or a problem's code) and the
seconds by stage."""

_LONGEST_RETRY = 600
"""Largest Retry-After in seconds. A longer estimate is meaningless."""


@dataclass(frozen=True)
class EngineFacts:
    """State of an engine; `fault` states why no build can be queued at present.

    `completed` and `worker_starts` count since the start, and `capacity` is the largest number of
    waiting builds. `oldest` is the age of the oldest waiting build in seconds: 0 if none waits,
    None if unknown. One more build is expected to end in `retry_after` seconds.
    """

    queued: int
    running: int
    capacity: int
    workers: int = 0
    warm_workers: int = 0
    completed: int = 0
    oldest: float | None = None
    worker_starts: int = 0
    retry_after: int = 1
    fault: str | None = None


class Engine(Protocol):
    """Carries out accepted jobs. Everything here belongs to the event loop's thread."""

    async def start(self, changed: Callable[[JobDocument], None]) -> None:
        """Start to work, including jobs that an earlier process left unfinished.

        `changed` is called at every change of a job that `document` knows.
        """

    def drain(self) -> None:
        """Start no builds any more. Running builds continue until `stop`."""

    async def stop(self) -> None:
        """Finish builds that end in time, give the others back to the book, and end."""

    async def check_admission(self, arriving: int) -> None:
        """Raise the problem that would refuse a new build, with a Retry-After, if there is one.

        `arriving` builds were admitted and are not queued yet.
        """

    async def enqueue(self, document: JobDocument, *, joined: bool = False) -> None:
        """Queue a job of the book. A job that is queued or running already is ignored.

        `joined` tells that another process accepted the job, and most likely queued it.
        """

    async def cancel(self, job_id: str) -> None:
        """End a job's build now, if it runs here. The book already has the job as cancelled.

        Builders elsewhere notice at their next heartbeat.
        """

    def document(self, job_id: str) -> JobDocument | None:  # noqa: ARG002 - most know none
        """Return a job that is known here, newer than in the book; None for other jobs."""
        return None

    def facts(self) -> EngineFacts:
        """Return the state of the engine."""


def queue_full(waiting: int, retry_after: int) -> ProblemError:
    """Return the refusal of a build because the queue is full."""
    headers = {"Retry-After": str(max(1, min(retry_after, _LONGEST_RETRY)))}
    return ProblemError(Problem("queue-full", f"{waiting} builds are waiting.", headers=headers))


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
