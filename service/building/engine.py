"""What every engine does: it takes the ids of accepted jobs and sees to it that they are done.

An engine is transport only. The state of a job is in `service.jobs.book.JobBook`, so an engine may
lose everything it knows, and may be given a job twice.
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
"""Called at the end of every build: the outcome (a state, or the problem's code), seconds by stage,
and the job as it was claimed."""

_LONGEST_RETRY = 600
"""Seconds: beyond that an estimate says nothing, and a client may as well look."""


@dataclass(frozen=True)
class EngineFacts:
    """What an engine is doing.

    Attributes
    ----------
    queued, running : int
        Builds that wait for a worker, and that a worker is busy with.
    workers, warm_workers : int
        Worker processes that there should be, and that are ready to build at once.
    completed : int
        Gamuts that were built since the start.
    capacity : int
        Builds that may wait.
    worker_starts : int
        Worker processes that became ready to build, since the start.
    fault : str, optional
        Why no build can be queued at present.
    """

    queued: int
    running: int
    workers: int
    warm_workers: int
    completed: int
    capacity: int
    worker_starts: int = 0
    fault: str | None = None


class Engine(Protocol):
    """Sees to it that accepted jobs are done.

    Everything here belongs to the event loop's thread.
    """

    def listen(self, listener: Callable[[JobDocument], None]) -> None:
        """Have every change of a job that is known here told, in the event loop's thread."""

    async def start(self) -> None:
        """Begin to work, on what an earlier process left unfinished as well."""

    def drain(self) -> None:
        """Refuse new builds, and begin none; `stop` says what becomes of those that run."""

    async def stop(self) -> None:
        """Finish what can be finished in time, give the rest back to the book, and end."""

    async def check_admission(self, arriving: int = 0) -> None:
        """Raise the problem that a new build would be refused with, if there is one.

        Parameters
        ----------
        arriving : int
            Builds that were let in and are not in the queue yet.

        Raises
        ------
        ProblemError
            ``queue-full`` or ``shutting-down``, with a Retry-After.
        """

    async def enqueue(self, document: JobDocument, *, joined: bool = False) -> None:
        """Queue a job of the book; harmless if it is queued or running already.

        Parameters
        ----------
        document : JobDocument
            The job.
        joined : bool
            Whether somebody else has accepted it, and most likely queued it as well.
        """

    async def cancel(self, job_id: str) -> None:
        """End a job's build now, if it is here; the book says that it is cancelled already."""

    def document(self, job_id: str) -> JobDocument | None:
        """Return a job as far as it is known here, fresher than the book; None if it is not.

        An engine that answers with a job tells every change of it to its listener, the end as
        well. For other jobs the book is asked again and again.
        """

    def facts(self) -> EngineFacts:
        """Return what the engine is doing."""

    def retry_after(self, queued: int = 0) -> int:
        """Return in how many seconds a worker is expected to have done `queued` builds and one."""


def queue_full(waiting: int, retry_after: int) -> ProblemError:
    """Return the refusal of a build because too many wait."""
    return ProblemError(
        Problem(
            "queue-full",
            f"{waiting} builds are waiting already.",
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
