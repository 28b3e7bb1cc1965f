"""Counters of requests and builds of this process.

Counting is plain addition to dictionaries and lists, because it runs on every request.
`service.telemetry.metrics_endpoint` renders the counters. The event loop's thread counts requests,
any thread counts builds, and any thread may read. Builds run in other processes and are counted by
the process that started them. See ``docs/decisions/metrics.md``.
"""

from __future__ import annotations

import threading
from bisect import bisect_left
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["TOTAL", "BuildFigures", "Distribution", "Metrics", "QueryFigures", "RequestFigures"]

TOTAL = "total"
"""Key of the seconds of a whole build, publication included."""

_RESPONSE_BOUNDS = (
    *(0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1),
    *(0.25, 0.5, 1, 2.5, 5, 10, 30),
)
"""Seconds. A cached mesh is in the first bucket, a request that waits for a build in the last."""

_BUILD_BOUNDS = (0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 120, 300)
"""Seconds of a build or a stage, from reading a small file to the largest deadline."""

_METHODS = frozenset(
    {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "CONNECT"}
)


class Distribution:
    """A histogram with the sum of its values, by ascending upper bounds.

    Values above the last bound are counted in an additional bucket.
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
        """Return each bound, infinity last, with the number of values up to it."""
        total, result = 0, []
        for bound, count in zip((*self.bounds, float("inf")), list(self.counts), strict=True):
            total += count
            result.append((bound, total))
        return result


class RequestFigures:
    """Requests by method, route and status; seconds until the response starts, by route.

    A route is the template of the path, such as ``/v1/gamuts/{gamut_id}/mesh``, so clients cannot
    create new series. `refusals` counts the server's answers without the app, by code of the
    problem; they are not in `counts`.
    """

    def __init__(self) -> None:
        self.counts: dict[tuple[str, str, int], int] = {}
        self.seconds: dict[str, Distribution] = {}
        self.refusals: dict[str, int] = {}
        self.in_progress = 0
        self.sent_bytes = 0

    def count_answer(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count a request."""
        key = (method if method in _METHODS else "other", route, status)
        self.counts[key] = self.counts.get(key, 0) + 1
        distribution = self.seconds.get(route)
        if distribution is None:
            distribution = self.seconds[route] = Distribution(_RESPONSE_BOUNDS)
        distribution.add(seconds)

    def count_refusal(self, problem: str, nbytes: int) -> None:
        """Count an answer of the server without the app."""
        self.refusals[problem] = self.refusals.get(problem, 0) + 1
        self.sent_bytes += nbytes


class BuildFigures:
    """Builds of this process by outcome, and seconds of builds and of their stages. Thread-safe."""

    def __init__(self) -> None:
        self.outcomes: dict[str, int] = {}
        self.seconds = Distribution(_BUILD_BOUNDS)
        self.stages: dict[str, Distribution] = {}
        self._lock = threading.Lock()

    def count_build(self, outcome: str, seconds: Mapping[str, float]) -> None:
        """Count an ended build.

        The outcome is ``succeeded``, ``cancelled``, ``crashed`` (one attempt) or the code of a
        problem. `seconds` are by stage, if known, and of the whole build as ``total``.
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


class QueryFigures:
    """Answered rows and seconds of computation by operation. Thread-safe.

    Large queries are answered piece by piece, and every piece counts.
    """

    def __init__(self) -> None:
        self.rows: dict[str, int] = {}
        self.seconds: dict[str, Distribution] = {}
        self._lock = threading.Lock()

    def count(self, operation: str, rows: int, seconds: float) -> None:
        """Count answered rows and the time of their computation."""
        with self._lock:
            self.rows[operation] = self.rows.get(operation, 0) + rows
            distribution = self.seconds.get(operation)
            if distribution is None:
                distribution = self.seconds[operation] = Distribution(_RESPONSE_BOUNDS)
            distribution.add(seconds)


class Metrics:
    """All counters of a process."""

    def __init__(self) -> None:
        self.requests = RequestFigures()
        self.builds = BuildFigures()
        self.queries = QueryFigures()
