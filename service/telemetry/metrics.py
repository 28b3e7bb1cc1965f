"""What this process counts of its requests and builds, for whoever looks from outside.

Counting is plain addition to dictionaries and lists, because it happens on every request, within
fractions of a microsecond; `service.telemetry.metrics_endpoint` renders the figures in
Prometheus' formats on request. The event loop's thread counts requests, any thread builds, and any
thread may read.
Builds are done by other processes: their figures come with the event that ends a build, to the
process that had it done.
See ``docs/decisions/metrics.md``.
"""

from __future__ import annotations

import threading
from bisect import bisect_left
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["TOTAL", "BuildFigures", "Distribution", "Metrics", "RequestFigures"]

TOTAL = "total"
"""Among the seconds by stage: those of the whole build, publication included."""

_RESPONSE_BOUNDS = (
    *(0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1),
    *(0.25, 0.5, 1, 2.5, 5, 10, 30),
)
"""Seconds: a cached mesh takes a part of the first, a request that waits for a build the last."""

_BUILD_BOUNDS = (0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 120, 300)
"""Seconds of a build or a stage of it: from reading a small file to the most that is allowed."""

_METHODS = frozenset(
    {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "CONNECT"}
)


class Distribution:
    """How many values fell between which bounds, and their sum.

    Parameters
    ----------
    bounds : iterable of float
        Ascending; a value counts for the first bound that is not below it, or for the rest.
    """

    __slots__ = ("bounds", "counts", "sum")

    def __init__(self, bounds: Iterable[float]) -> None:
        self.bounds = tuple(bounds)
        self.counts = [0] * (len(self.bounds) + 1)
        self.sum = 0.0

    def add(self, value: float) -> None:
        """Count a value."""
        self.counts[bisect_left(self.bounds, value)] += 1
        self.sum += value

    def cumulative(self) -> list[tuple[float, int]]:
        """Return each bound, infinity at last, with the number of values up to it."""
        total, result = 0, []
        for bound, count in zip((*self.bounds, float("inf")), list(self.counts), strict=True):
            total += count
            result.append((bound, total))
        return result


class RequestFigures:
    """Requests by method, route and status, and how long their responses took to begin.

    A route is the template that a path matched, such as ``/v1/gamuts/{gamut_id}/mesh``, so that
    clients cannot make up series of their own.

    Attributes
    ----------
    counts : dict
        Requests answered, by method, route and status.
    seconds : dict of Distribution
        From the arrival of a request to the beginning of its response, by route.
    refusals : dict
        Answers that the server gave without the app, by the code of the problem; not in `counts`.
    in_progress : int
        Requests under way.
    sent_bytes : int
        Bytes of content in all responses.
    """

    def __init__(self) -> None:
        self.counts: dict[tuple[str, str, int], int] = {}
        self.seconds: dict[str, Distribution] = {}
        self.refusals: dict[str, int] = {}
        self.in_progress = 0
        self.sent_bytes = 0

    def answered(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count a request."""
        key = (method if method in _METHODS else "other", route, status)
        self.counts[key] = self.counts.get(key, 0) + 1
        distribution = self.seconds.get(route)
        if distribution is None:
            distribution = self.seconds[route] = Distribution(_RESPONSE_BOUNDS)
        distribution.add(seconds)

    def refused(self, problem: str, nbytes: int) -> None:
        """Count an answer that the server gave without the app."""
        self.refusals[problem] = self.refusals.get(problem, 0) + 1
        self.sent_bytes += nbytes


class BuildFigures:
    """Builds that this process had done, by outcome, and the time that they and their stages took.

    Several threads may count at the same time.

    Attributes
    ----------
    outcomes : dict
        Builds that ended, by ``succeeded``, ``cancelled`` or the code of the problem.
    seconds : Distribution
        Of whole builds.
    stages : dict of Distribution
        By the stage of `gamutcore`.
    """

    def __init__(self) -> None:
        self.outcomes: dict[str, int] = {}
        self.seconds = Distribution(_BUILD_BOUNDS)
        self.stages: dict[str, Distribution] = {}
        self._lock = threading.Lock()

    def ended(self, outcome: str, seconds: Mapping[str, float]) -> None:
        """Count a build that ended.

        Parameters
        ----------
        outcome : str
            ``succeeded``, ``cancelled``, ``crashed`` (an attempt, of several) or the code of a
            problem.
        seconds : mapping
            Seconds by stage, as the build's last event has them, and of all as ``total``; without
            the stages where they are not known.
        """
        with self._lock:
            self.outcomes[outcome] = self.outcomes.get(outcome, 0) + 1
            for stage, duration in seconds.items():
                if stage == TOTAL:
                    self.seconds.add(duration)
                    continue
                distribution = self.stages.get(stage)
                if distribution is None:
                    distribution = self.stages[stage] = Distribution(_BUILD_BOUNDS)
                distribution.add(duration)


class Metrics:
    """All that a process counts itself."""

    def __init__(self) -> None:
        self.requests = RequestFigures()
        self.builds = BuildFigures()
