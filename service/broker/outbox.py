"""Which jobs were sent to the workers and are not over: an empty blob each, under ``pending/``.

A message can be lost: a broker is flushed, the process that accepted a job dies before it has sent
it, a worker is killed and its message comes back late or never. The mark is made before the message
and removed after the job is over, so that whoever looks here finds every job that may need another
message, without reading the documents of all the jobs there ever were.
"""

from __future__ import annotations

import time
from datetime import datetime
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from service.jobs.book import JobBook, JobDocument
    from service.storage.blobs import Blobs

__all__ = ["Outbox"]

_MARK = b"\n"


class Outbox:
    """The jobs of a deployment that were sent and are not over.

    Parameters
    ----------
    blobs : Blobs
        The store of the deployment.
    book : JobBook
        Its jobs.
    clock : callable
        Seconds of the Unix epoch, as the book has them.
    """

    def __init__(self, blobs: Blobs, book: JobBook, clock: Callable[[], float] = time.time) -> None:
        self._blobs = blobs
        self._book = book
        self._clock = clock
        self._due: dict[str, float] = {}

    def mark(self, job_id: str) -> bool:
        """Note that a job is about to be sent; whether that is new."""
        return self._blobs.create(_key(job_id), _MARK) is not None

    def remove(self, job_id: str) -> None:
        """Forget a job that is over; a new one of the same id that came meanwhile stays."""
        self._blobs.delete(_key(job_id))
        document = self._book.read(job_id)
        if document is not None and not document.final:
            self.mark(job_id)

    def ids(self) -> Iterator[str]:
        """Iterate over the ids of the jobs that were sent and are not known to be over."""
        for key in self._blobs.keys("pending/"):
            yield key.rpartition("/")[2]

    def count(self) -> int:
        """Return the number of jobs that were sent and are not known to be over."""
        return sum(1 for _ in self.ids())

    def overdue(self, silence: float) -> Iterator[str]:
        """Iterate over the jobs that have to be sent again, by this caller and by nobody else.

        A job is read once in the time in which it cannot become overdue, so that this may be asked
        every few seconds.

        Parameters
        ----------
        silence : float
            Seconds after which a queued job that nobody has begun is taken for lost. A running one
            is lost when its lease has ended.
        """
        due, self._due = self._due, {}
        for job_id in self.ids():
            if due.get(job_id, 0.0) > self._clock():
                self._due[job_id] = due[job_id]
                continue
            document = self._book.read(job_id)
            if document is None or document.final:
                self.remove(job_id)
                continue
            self._due[job_id] = _overdue_at(document, silence)
            if self._due[job_id] <= self._clock() and self._book.revived(job_id, silence):
                self._due[job_id] = self._clock() + silence
                yield job_id


def _overdue_at(document: JobDocument, silence: float) -> float:
    if document.state == "running":
        return document.lease_until or 0.0
    return datetime.fromisoformat(document.updated).timestamp() + silence


def _key(job_id: str) -> str:
    return f"pending/{job_id[:2]}/{job_id}"
