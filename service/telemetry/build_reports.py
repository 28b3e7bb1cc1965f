"""Reports of ended builds across forked processes.

A worker with a broker forks one process per slot, and the counters of these processes would be lost
with them. `BuildReports` sends each build through a pipe to the process that serves the metrics.
"""

from __future__ import annotations

import json
import logging
import os
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from service.telemetry.metrics import BuildMetrics

__all__ = ["BuildReports"]

logger = logging.getLogger(__name__)

_LONGEST = 512
"""Bytes of a line. POSIX guarantees that a pipe takes this many at once."""


class BuildReports:
    """A pipe for ended builds, made before the fork of the processes that write to it.

    In these processes it replaces `BuildMetrics`; the process that made the pipe counts with
    `forward`. A slot can be killed at any moment, as there is no lock, and a full pipe never delays
    a build.
    """

    def __init__(self) -> None:
        self._reading, self._writing = os.pipe()
        os.set_blocking(self._writing, False)

    def count_build(self, outcome: str, seconds: Mapping[str, float]) -> None:
        """Send an ended build; see `BuildMetrics.count_build`."""
        rounded = {stage: round(duration, 6) for stage, duration in seconds.items()}
        line = json.dumps([outcome, rounded], separators=(",", ":")).encode() + b"\n"
        if len(line) > _LONGEST:
            line = json.dumps([outcome[:80], {}]).encode() + b"\n"
        try:
            os.write(self._writing, line)
        except OSError as error:
            # The pipe is full or has no reader.
            logger.warning("build was not counted: %s", error)

    def forward(self, metrics: BuildMetrics) -> None:
        """Count all further builds, in a thread that ends with the process."""
        threading.Thread(
            target=self._forward, args=(metrics,), name="build reports", daemon=True
        ).start()

    def _forward(self, metrics: BuildMetrics) -> None:
        with os.fdopen(os.dup(self._reading), "rb") as lines:
            for line in lines:
                outcome, seconds = json.loads(line)
                metrics.count_build(outcome, seconds)

    def close(self) -> None:
        """Close the pipe in this process. The thread of `forward` ends after the last close."""
        os.close(self._reading)
        os.close(self._writing)
