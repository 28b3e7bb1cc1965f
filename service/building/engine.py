"""The interface of build engines, which carry out accepted jobs.

An engine is transport only. The state of a job is in `service.jobs.book.JobBook`, so an engine may
lose everything it knows, and may receive a job twice.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from service.jobs.book import JobDocument

__all__ = ["BuildReport", "Engine", "EngineFacts", "queue_full", "shutting_down"]

BuildReport = Callable[[str, dict[str, float], "JobDocument"], None]
"""Called at the end of every build with the outcome (a state or a problem's code), the seconds by
stage, and the claimed job."""

_LONGEST_RETRY = 600
"""Largest Retry-After in seconds. A longer estimate is meaningless."""


@dataclass(frozen=True)
class EngineFacts:
    """State of an engine; `fault` states why no build can be queued at present.

    `completed` and `worker_starts` count since the start, and `capacity` is the largest number of
    waiting builds. `oldest` is the age of the oldest waiting build in seconds: 0 if none waits,
    None if unknown.
    """

    queued: int
    running: int
    workers: int
    warm_workers: int
    completed: int
    capacity: int
    oldest: float | None = None
    worker_starts: int = 0
    fault: str | None = None


class Engine(Protocol):
    """Carries out accepted jobs.

    Everything here belongs to the event loop's thread.
    """

    def listen(self, listener: Callable[[JobDocument], None]) -> None:
        """Report every change of a job that is known here, in the event loop's thread."""

    async def start(self) -> None:
        """Start to work, including jobs that an earlier process left unfinished."""

    def drain(self) -> None:
        """Refuse new builds and start none. Running builds continue until `stop`."""

    async def stop(self) -> None:
        """Finish builds that end in time, give the others back to the book, and end."""

    async def check_admission(self, arriving: int = 0) -> None:
        """Raise the problem that would refuse a new build, with a Retry-After, if there is one.

        The problem is ``queue-full`` or ``shutting-down``. `arriving` builds were admitted and are
        not queued yet.
        """

    async def enqueue(self, document: JobDocument, *, joined: bool = False) -> None:
        """Queue a job of the book. A job that is queued or running already is ignored.

        `joined` tells that another process accepted the job, and most likely queued it.
        """

    async def cancel(self, job_id: str) -> None:
        """End a job's build now, if it runs here. The book already has the job as cancelled."""

    def document(self, job_id: str) -> JobDocument | None:
        """Return a job that is known here, newer than in the book; None for other jobs.

        The engine reports every change of such a job to the listener. Other jobs are polled from
        the book.
        """

    def facts(self) -> EngineFacts:
        """Return the state of the engine."""

    def retry_after(self, queued: int = 0) -> int:
        """Return the seconds in which `queued` builds and one more are expected to end."""


def queue_full(waiting: int, retry_after: int) -> ProblemError:
    """Return the refusal of a build because the queue is full."""
    return ProblemError(
        Problem(
            "queue-full",
            f"{waiting} builds are waiting.",
            headers={"Retry-After": str(max(1, min(retry_after, _LONGEST_RETRY)))},
        )
    )


def shutting_down() -> ProblemError:
    """Return the refusal of a build because the service is stopping."""
    return ProblemError(
        Problem(
            "shutting-down",
            "The service is stopping and accepts no new builds.",
            headers={"Retry-After": "5"},
        )
    )
