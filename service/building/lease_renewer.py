"""Lease renewer: a thread that renews a claim and stores the progress while a build runs.

A download or an upload may last longer than a lease, so the building thread cannot renew it.
"""

from __future__ import annotations

import logging
import threading
from dataclasses import replace
from typing import TYPE_CHECKING, Self

from service.jobs.book import LeaseLostError
from service.storage.blobs import StoreUnavailableError

if TYPE_CHECKING:
    from types import TracebackType

    from service.jobs.book import Claim, JobBook, JobDocument

__all__ = ["LeaseRenewer"]

logger = logging.getLogger(__name__)


class LeaseRenewer:
    """A claim that is renewed in the background, every `interval` seconds, inside a context.

    Several intervals must fit into a lease.
    """

    def __init__(self, book: JobBook, claim: Claim, interval: float) -> None:
        self._book = book
        self._claim = claim
        self._interval = interval
        self._stage, self._fraction = claim.document.stage, claim.document.fraction
        self._lost: LeaseLostError | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._renew, name="lease renewer", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._ended.set()
        self._thread.join()

    @property
    def document(self) -> JobDocument:
        """The job with its newest progress, stored or not."""
        return replace(self._claim.document, stage=self._stage, fraction=self._fraction)

    @property
    def claim(self) -> Claim:
        """The newest claim, for use after the context."""
        return replace(self._claim, document=self.document)

    def note(self, stage: str, fraction: float) -> None:
        """Set the progress. The next renewal stores it."""
        self._stage, self._fraction = stage, fraction

    def check(self) -> None:
        """Raise `LeaseLostError` if the claim is known to be lost."""
        if self._lost is not None:
            raise self._lost

    def _renew(self) -> None:
        while not self._ended.wait(self._interval):
            try:
                self._claim = self._book.heartbeat(self._claim, self._stage, self._fraction)
            except LeaseLostError as error:
                self._lost = error
                return
            except (OSError, StoreUnavailableError) as error:
                # A lease has room for more renewals. If all fail, another builder takes over.
                logger.warning("lease of %s was not renewed: %s", self.document.id, error)
