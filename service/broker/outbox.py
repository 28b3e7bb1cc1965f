"""Outbox: marks of jobs that were sent and have not ended, as empty blobs under ``pending/``.

Messages can be lost: a broker is flushed, a process dies before it sends an accepted job, or a
worker is killed. The mark is created before the message and removed after the job. So the marks
lead to every job that may need another message, without reading all jobs.
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    from service.jobs.book import JobBook, JobDocument
    from service.storage.blobs import Blobs

__all__ = ["Outbox"]

_MARK = b"\n"

_READERS = 8
"""Number of documents that are read at the same time."""


class Outbox:
    """The jobs of a deployment that were sent and have not ended.

    `clock` gives seconds of the Unix epoch, as in the book.
    """

    def __init__(self, blobs: Blobs, book: JobBook, clock: Callable[[], float] = time.time) -> None:
        self._blobs = blobs
        self._book = book
        self._clock = clock
        self._due: dict[str, float] = {}

    def mark(self, job_id: str) -> bool:
        """Mark a job that is about to be sent; return whether the mark is new."""
        return self._blobs.create(_key(job_id), _MARK) is not None

    def remove(self, job_id: str) -> None:
        """Remove the mark of an ended job, unless a new job has the same id."""
        self._blobs.delete(_key(job_id))
        document = self._book.read(job_id)
        if document is not None and not document.final:
            self.mark(job_id)

    def ids(self) -> Iterator[str]:
        """Iterate over the ids of the marked jobs."""
        for key in self._blobs.keys("pending/"):
            yield key.rpartition("/")[2]

    def waiting(self, known: Collection[str]) -> tuple[set[str], list[JobDocument]]:
        """Return the ids of all marked jobs, and the waiting jobs not yet `known`, oldest first."""
        marked = set(self.ids())
        with ThreadPoolExecutor(_READERS) as threads:
            found = threads.map(self._book.read, marked.difference(known))
            documents = [each for each in found if each is not None and self._waits(each)]
        return marked, sorted(documents, key=lambda document: document.created)

    def waits(self, job_id: str) -> bool:
        """Return whether a job can be claimed."""
        document = self._book.read(job_id)
        return document is not None and self._waits(document)

    def _waits(self, document: JobDocument) -> bool:
        if document.state == "running":
            return (document.lease_until or 0.0) < self._clock()
        return not document.final

    def count(self) -> int:
        """Return the number of marked jobs."""
        return sum(1 for _ in self.ids())

    def overdue(self, silence: float) -> Iterator[str]:
        """Iterate over the jobs that this caller, and no other, must send again.

        An unstarted job counts as lost after `silence` seconds, a running job when its lease has
        ended. A job is read only once it can be overdue, so frequent calls are cheap.
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
            if self._due[job_id] <= self._clock() and self._book.revive(job_id, silence):
                self._due[job_id] = self._clock() + silence
                yield job_id


def _overdue_at(document: JobDocument, silence: float) -> float:
    if document.state == "running":
        return document.lease_until or 0.0
    return datetime.fromisoformat(document.updated).timestamp() + silence


def _key(job_id: str) -> str:
    return f"pending/{job_id[:2]}/{job_id}"
