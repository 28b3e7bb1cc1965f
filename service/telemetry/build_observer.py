"""What is told of a build when it has ended: its figures, and its spans where there are traces.

A process that has builds done, be it a service or a worker of a queue, gives one of these to
whatever performs them.
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
    from service.telemetry.metrics import BuildFigures
    from service.telemetry.traces import Traces

__all__ = ["BuildObserver", "BuildReports"]

logger = logging.getLogger(__name__)

_LONGEST = 512
"""Bytes of a line: POSIX lets no pipe take fewer in one piece."""


class BuildObserver:
    """Is called at the end of every build, in any thread.

    Parameters
    ----------
    figures : BuildFigures or BuildReports, optional
        Where builds are counted, or who tells of them to where they are.
    traces : Traces, optional
        Where each gets its spans.
    """

    def __init__(self, figures: BuildFigures | BuildReports | None, traces: Traces | None) -> None:
        self._figures = figures
        self._traces = traces

    def __call__(self, outcome: str, seconds: Mapping[str, float], document: JobDocument) -> None:
        """Note a build that has ended just now.

        Parameters
        ----------
        outcome : str
            ``succeeded``, ``cancelled``, ``crashed`` or the code of a problem.
        seconds : mapping
            Seconds by stage, and of the whole build as ``total``.
        document : JobDocument
            The job, with what it carries of the trace of the request that began it.
        """
        if self._figures is not None:
            self._figures.ended(outcome, seconds)
        if self._traces is None:
            return
        stages = {stage: duration for stage, duration in seconds.items() if stage != TOTAL}
        finished = time.time()
        started = finished - max(seconds.get(TOTAL, 0.0), sum(stages.values()))
        self._traces.build_ended(
            document.id,
            outcome,
            stages,
            started=started,
            finished=finished,
            trace=document.trace,
        )


class BuildReports:
    """A pipe for builds, to be made before the processes that write to it are forked.

    In those it stands for `BuildFigures`; the process that made it counts with `forward`.
    """

    def __init__(self) -> None:
        self._reading, self._writing = os.pipe()
        os.set_blocking(self._writing, False)

    def ended(self, outcome: str, seconds: Mapping[str, float]) -> None:
        """Tell of a build that ended; see `BuildFigures.ended`."""
        rounded = {stage: round(duration, 6) for stage, duration in seconds.items()}
        line = json.dumps([outcome, rounded], separators=(",", ":")).encode() + b"\n"
        if len(line) > _LONGEST:
            line = json.dumps([outcome[:80], {}]).encode() + b"\n"
        try:
            os.write(self._writing, line)
        except OSError as error:
            # Full, or nobody there to read it any more.
            logger.warning("a build is not counted: %s", error)

    def forward(self, figures: BuildFigures) -> None:
        """Count what is told from now on, in a thread that ends with the process."""
        threading.Thread(
            target=self._forward, args=(figures,), name="build reports", daemon=True
        ).start()

    def _forward(self, figures: BuildFigures) -> None:
        with os.fdopen(os.dup(self._reading), "rb") as lines:
            for line in lines:
                outcome, seconds = json.loads(line)
                figures.ended(outcome, seconds)

    def close(self) -> None:
        """Give the pipe up in this process; once all have, the thread of `forward` ends."""
        os.close(self._reading)
        os.close(self._writing)
