"""What is told of a build when it has ended: its figures, and its spans where there are traces.

A process that has builds done, be it a service or a worker of a queue, gives one of these to
whatever performs them.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from service.telemetry.metrics import TOTAL

if TYPE_CHECKING:
    from collections.abc import Mapping

    from service.jobs.book import JobDocument
    from service.telemetry.build_reports import BuildReports
    from service.telemetry.metrics import BuildFigures
    from service.telemetry.traces import Traces

__all__ = ["BuildObserver"]


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
