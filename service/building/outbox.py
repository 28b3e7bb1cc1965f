"""Which jobs were sent to the workers and are not over: an empty blob each, under ``pending/``.

A message can be lost: the process that accepted the job dies before it has sent it, a broker is
flushed, a worker is killed and its message comes back late or never. The mark is made before the
message and removed after the job is over, so that whoever looks here finds every job that may need
another message, without reading the documents of all jobs there ever were.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from service.jobs import JobBook
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
    """

    def __init__(self, blobs: Blobs, book: JobBook) -> None:
        self._blobs = blobs
        self._book = book

    def mark(self, job_id: str) -> None:
        """Note that a job is about to be sent."""
        self._blobs.create(_key(job_id), _MARK)

    def remove(self, job_id: str) -> None:
        """Forget a job that is over."""
        self._blobs.delete(_key(job_id))

    def ids(self) -> Iterator[str]:
        """Iterate over the ids of the jobs that were sent and are not known to be over."""
        for key in self._blobs.keys("pending/"):
            yield key.rpartition("/")[2]

    def overdue(self, silence: float) -> Iterator[str]:
        """Iterate over the jobs that have to be sent again, by this caller and by nobody else.

        Parameters
        ----------
        silence : float
            Seconds after which a queued job that nobody has begun is taken for lost. A running one
            is when its lease has ended.
        """
        for job_id in self.ids():
            document = self._book.revived(job_id, silence)
            if document is None:
                continue
            if document.final:
                self.remove(job_id)
                # Somebody may have asked for it anew in between.
                document = self._book.revived(job_id, 0.0)
                if document is None or document.final:
                    continue
                self.mark(job_id)
            yield job_id


def _key(job_id: str) -> str:
    return f"pending/{job_id[:2]}/{job_id}"
