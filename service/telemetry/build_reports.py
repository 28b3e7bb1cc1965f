"""Figures of builds from forked processes to the one that forked them, which has the port for them.

A worker of a queue forks a process for every slot. What a slot counts would be lost with it, and
nobody could ask it; so it writes each build down a pipe, a line that is shorter than what a pipe
takes whole (PIPE_BUF). There is no lock, so a slot may be killed at any moment, and a pipe that
nobody empties makes no build wait.
"""

from __future__ import annotations

import json
import logging
import os
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from service.telemetry.metrics import BuildFigures

__all__ = ["BuildReports"]

logger = logging.getLogger(__name__)

_LONGEST = 512
"""Bytes of a line: POSIX lets no pipe take fewer in one piece."""


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
