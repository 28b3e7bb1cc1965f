"""Keeps a claim alive while its build is busy: a thread that renews the lease and writes progress.

The build itself may be inside of a download or an upload for longer than a lease lasts, so renewing
cannot be left to whoever builds.
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

__all__ = ["ClaimKeeper"]

logger = logging.getLogger(__name__)


class ClaimKeeper:
    """A claim that is renewed in the background, between entering and leaving the context.

    Parameters
    ----------
    book : JobBook
        Where the claim is from.
    claim : Claim
        The claim.
    interval : float
        Seconds between two renewals; several have to fit into a lease.
    """

    def __init__(self, book: JobBook, claim: Claim, interval: float) -> None:
        self._book = book
        self._claim = claim
        self._interval = interval
        self._stage, self._fraction = claim.document.stage, claim.document.fraction
        self._lost: LeaseLostError | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._renew, name="claim keeper", daemon=True)

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
        """The job with its newest progress, whether that was written down or not."""
        return replace(self._claim.document, stage=self._stage, fraction=self._fraction)

    @property
    def claim(self) -> Claim:
        """The claim, to be used once the context was left."""
        return replace(self._claim, document=self.document)

    def note(self, stage: str, fraction: float) -> None:
        """Take note of how far the build is; it is written down with the next renewal."""
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
                # There are more renewals in a lease; if all fail, whoever takes over is told so.
                logger.warning("the claim of %s was not renewed: %s", self.document.id, error)
