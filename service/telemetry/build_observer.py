"""Reports of ended builds: metrics and spans, also across forked processes.

`BuildObserver` is called at the end of every build. A worker with a broker forks one process per
slot, and the counters of these processes would be lost with them. `BuildReports` sends each build
through a pipe to the process that serves the metrics.
"""

from __future__ import annotations

import json
import logging
import os
import threading
import time
from typing import TYPE_CHECKING

from service.telemetry.metrics import TOTAL

if TYPE_CHECKING:
    from collections.abc import Mapping

    from service.jobs.book import JobDocument
    from service.telemetry.metrics import BuildMetrics
    from service.telemetry.traces import Traces

__all__ = ["BuildObserver", "BuildReports"]

logger = logging.getLogger(__name__)

_LONGEST = 512
"""Bytes of a line. POSIX guarantees that a pipe takes this many at once."""


class BuildObserver:
    """Records the end of every build; called in any thread.

    `metrics` counts builds, or forwards them to the process that counts.
    """

    def __init__(self, metrics: BuildMetrics | BuildReports | None, traces: Traces | None) -> None:
        self._metrics = metrics
        self._traces = traces

    def __call__(self, outcome: str, seconds: Mapping[str, float], document: JobDocument) -> None:
        """Record a build that has just ended; arguments as for `BuildMetrics.count_build`.

        `document` holds the trace context of the first request.
        """
        if self._metrics is not None:
            self._metrics.count_build(outcome, seconds)
        if self._traces is None:
            return
        stages = {stage: duration for stage, duration in seconds.items() if stage != TOTAL}
        finished = time.time()
        started = finished - max(seconds.get(TOTAL, 0.0), sum(stages.values()))
        self._traces.write_build(
            document.id,
            outcome,
            stages,
            started=started,
            finished=finished,
            trace=document.trace,
        )


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
