"""Requests with retries, without input or output.

The function of a `method` returns a generator of steps, which yields requests, perhaps delayed,
and gets the response or the error of the connection. `run` and `run_async` carry the steps out.
What a method sends and when it tries again is therefore written once.
"""

from __future__ import annotations

import asyncio
import datetime as dt
import email.utils
import functools
import time
from collections.abc import Callable, Coroutine, Generator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from types import MethodType
from typing import Any, Concatenate, Generic, ParamSpec, TypeAlias, TypeVar, cast, overload

import httpx

from gamutclient.errors import ConnectionLostError, ServiceError

__all__ = [
    "Awaiting",
    "Blocking",
    "Connections",
    "Request",
    "Retries",
    "Steps",
    "method",
    "run",
    "run_async",
    "sent",
]

T = TypeVar("T")
P = ParamSpec("P")


@dataclass(frozen=True)
class Request:
    """A request, relative to the address of the service.

    Parameters that are None are left out. `body` has arguments of httpx, such as `content`. The
    request is sent after `delay` seconds.
    """

    method: str
    path: str
    params: Mapping[str, Any] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    body: Mapping[str, Any] = field(default_factory=dict)
    delay: float = 0.0

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of `httpx.Client.request`."""
        params = {name: _text(value) for name, value in self.params.items() if value is not None}
        sent = {"method": self.method, "url": self.path, "headers": dict(self.headers)}
        return {**sent, "params": params, **self.body}


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return ",".join(map(_text, value))
    return str(value)


Connections: TypeAlias = Any
"""An `httpx.Client` where methods wait, an `httpx.AsyncClient` where they are coroutines."""

Outcome: TypeAlias = httpx.Response | httpx.TransportError
Steps: TypeAlias = Generator[Request, Any, T]
"""Steps of a method that returns T: each yields an `Outcome`, after the None that starts it."""

LONGEST_BACKOFF = 8.0
"""Longest wait in seconds before an attempt for which the service asked for no time."""

ATTEMPTS_WHILE_BUILT = 12
"""Least attempts for the state of a build: 56 s without the service, in which it can restart."""


@dataclass(frozen=True)
class Retries:
    """When a request is sent again. Every request of the client may be repeated safely.

    Attributes
    ----------
    attempts : int
        Largest number of times that a request is sent. Waits between them begin with 0.25 s and
        double up to 8 s.
    longest_wait : float
        Longest wait before one attempt, in seconds. A request for which the service asks for
        more fails at once.
    """

    attempts: int = 6
    longest_wait: float = 60.0

    def wait(self, outcome: Outcome, attempt: int) -> float | None:
        """Return the seconds to wait after so many attempts; None if there is no further one."""
        seconds = min(0.25 * 2.0 ** (attempt - 1), LONGEST_BACKOFF)
        if isinstance(outcome, httpx.Response):
            if outcome.status_code not in {429, 503}:
                return None
            asked = retry_after(outcome.headers.get("retry-after", ""))
            seconds = seconds if asked is None else asked
        elif isinstance(outcome, httpx.UnsupportedProtocol):  # an address without http://
            return None
        return seconds if attempt < self.attempts and seconds <= self.longest_wait else None

    @property
    def while_built(self) -> Retries:
        """Return the retries of requests for the state of a build."""
        return replace(self, attempts=max(self.attempts, ATTEMPTS_WHILE_BUILT))


def retry_after(text: str) -> float | None:
    """Return the seconds of a ``Retry-After`` field: a number, or a date (RFC 9110, 10.2.3)."""
    if text.strip().isascii() and text.strip().isdigit():
        return float(text)
    try:
        moment = email.utils.parsedate_to_datetime(text)
    except ValueError:
        return None
    if moment.tzinfo is None:
        return None
    return max(0.0, (moment - dt.datetime.now(dt.UTC)).total_seconds())


def sent(request: Request, retries: Retries) -> Steps[httpx.Response]:
    """Send a request, again if the service or the connection fails, and return the response.

    A problem of the service is a `ServiceError`, and a connection that failed at each attempt is a
    `ConnectionLostError`.
    """
    attempt = 1
    outcome: Outcome = yield request
    while (seconds := retries.wait(outcome, attempt)) is not None:
        outcome = yield replace(request, delay=seconds)
        attempt += 1
    if isinstance(outcome, httpx.TransportError):
        reason = str(outcome) or type(outcome).__name__
        message = f"{request.method} {request.path} failed {attempt} times: {reason}"
        raise ConnectionLostError(message) from outcome
    if outcome.is_error:
        raise ServiceError.from_document(_problem(outcome), outcome.status_code)
    return outcome


def _problem(response: httpx.Response) -> Mapping[str, Any]:
    """Return the problem document; an intermediary may answer with something else."""
    with suppress(ValueError):
        document = response.json()
        if isinstance(document, dict):
            return document
    return {"detail": f"HTTP status {response.status_code}: {response.text[:200]}"}


def run(steps: Steps[T], client: httpx.Client) -> T:
    """Carry out the steps of a method, and return its result."""
    outcome: Outcome | None = None
    while True:
        try:
            step = steps.send(outcome)
        except StopIteration as end:
            return cast("T", end.value)
        time.sleep(step.delay)
        try:
            outcome = client.request(**step.arguments())
        except httpx.TransportError as error:
            outcome = error


async def run_async(steps: Steps[T], client: httpx.AsyncClient) -> T:
    """Carry out the steps of a method in an event loop, and return its result."""
    outcome: Outcome | None = None
    while True:
        try:
            step = steps.send(outcome)
        except StopIteration as end:
            return cast("T", end.value)
        await asyncio.sleep(step.delay)
        try:
            outcome = await client.request(**step.arguments())
        except httpx.TransportError as error:
            outcome = error


class Blocking:
    """A class whose methods wait for their results."""

    http: Connections


class Awaiting:
    """A class whose methods are coroutines."""

    http: Connections


class method(Generic[P, T]):  # noqa: N801  # a decorator, as `property`
    """The method that carries out the steps of a function.

    It waits for them in a class that is `Blocking`, and is a coroutine in one that is `Awaiting`.
    """

    def __init__(self, func: Callable[Concatenate[Any, P], Steps[T]]) -> None:
        self.func = func

    @overload
    def __get__(self, instance: None, owner: type) -> Callable[..., Any]: ...
    @overload
    def __get__(self, instance: Blocking, owner: type) -> Callable[P, T]: ...
    @overload
    def __get__(self, instance: Awaiting, owner: type) -> Callable[P, Coroutine[Any, Any, T]]: ...
    def __get__(self, instance: object, owner: type) -> Callable[..., Any]:
        steps = self.func

        @functools.wraps(steps)
        def blocking(self: Blocking, /, *args: P.args, **kwargs: P.kwargs) -> T:
            return run(steps(self, *args, **kwargs), self.http)

        @functools.wraps(steps)
        async def awaiting(self: Awaiting, /, *args: P.args, **kwargs: P.kwargs) -> T:
            return await run_async(steps(self, *args, **kwargs), self.http)

        found = awaiting if issubclass(owner, Awaiting) else blocking
        return found if instance is None else MethodType(found, instance)
