"""HTTP/1.1 connections with limits that an ASGI app cannot enforce.

uvicorn parses requests and runs the app. This protocol adds time limits for the head, the body and
the reading of the answer, a size limit for the head, and a limit of open connections. Requests that
never reach the app get problem documents and are reported to a callback. See
``docs/decisions/hostile-clients.md``.
"""

from __future__ import annotations

import itertools
import logging
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from uvicorn.protocols.http.httptools_impl import (
    STATUS_LINE,
    HttpToolsProtocol,
    RequestResponseCycle,
)
from uvicorn.protocols.utils import get_remote_addr

from service.http.request_context import REQUEST_ID
from service.problems.problem import Problem, problem_response

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

__all__ = ["ConnectionLimits", "LimitedProtocol", "Refusal", "limited_protocol"]

_SWEEP_SECONDS = 0.5
"""Interval between checks of all connections."""

_LINGER_SECONDS = 5.0
"""How long the rest of a body is read and dropped after the answer was sent. Some clients read the
answer only after sending the body."""

_REFUSED_SECONDS = 0.5
"""How long a refused client can read the answer while its data is dropped."""

_MOST_WAITING = 32
"""Largest number of pipelined requests behind the current one. Each takes memory, and one packet
can hold thousands. Clients that pipeline send about ten."""

_numbers = itertools.count()
"""Sequence numbers of connections, in the order of arrival."""


@dataclass(frozen=True)
class ConnectionLimits:
    """Limits of connections: number, bytes, seconds, and bytes per second.

    `connections` is the largest number of open connections. The time of a head starts with its
    first byte, or with the connection.
    """

    connections: int
    head_bytes: int
    head_seconds: float
    body_seconds: float
    body_rate: int
    write_seconds: float


class Refusal(NamedTuple):
    """An answer that was given without the app.

    `problem` is the code, `seconds` the time since the server began to wait for the client's data,
    and `client` the address of the peer, which may be a proxy.
    """

    problem: str
    status: int
    nbytes: int
    seconds: float
    client: str | None
    request_id: str


class LimitedProtocol(HttpToolsProtocol):
    """A connection with limits.

    One timer of the server checks the time limits of all connections. A request only records the
    time.
    """

    limits: ConnectionLimits
    report: Callable[[Refusal], None]
    sweeping = False
    """Whether the timer of all connections of this class is running."""
    stalled = 0.0
    """Seconds in which this process could not serve its connections."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Accept a connection, or refuse it if there are too many."""
        self._number = next(_numbers)
        self._since = self._time()  # start of the wait for the client
        self._reading_head = False
        self._reading_body = False
        self._head_bytes = 0
        self._body_bytes = 0
        self._refusal: Problem | None = None
        self._refused = False
        self._answering: RequestResponseCycle | None = None
        self._stalled_since: float | None = None
        self._unsent = 0
        if len(self.connections) >= self.limits.connections and not self._make_room():
            self.transport = transport
            detail = f"{self.limits.connections} connections are open."
            self._send_problem(Problem("overloaded", detail, headers={"Retry-After": "1"}))
            return
        super().connection_made(transport)
        if not type(self).sweeping:
            type(self).sweeping = True
            self._schedule_sweep()

    def connection_lost(self, exc: Exception | None) -> None:
        """Tell the request that is being answered that the client is gone."""
        if self._answering is not None:
            # uvicorn tells the newest request, which may wait behind others.
            self._answering.disconnected = True
            self._answering.message_event.set()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Receive a part of a request."""
        if self._refused or self.transport.is_closing():
            return
        if not self._reading_body:
            if not self._reading_head and self._head_bytes == 0:
                self._since = self._time()
            # The parser buffers the start of a long field, so all bytes count.
            self._head_bytes += len(data)
        super().data_received(data)
        if self._reading_head and self._head_bytes > self.limits.head_bytes:
            self._refuse(self._head_problem())

    def on_message_begin(self) -> None:
        """Begin a request."""
        super().on_message_begin()
        self._reading_head = True
        self._fields_bytes = 0

    def on_url(self, url: bytes) -> None:
        """Receive a part of the request target."""
        self._count_field(len(url))
        super().on_url(url)

    def on_header(self, name: bytes, value: bytes) -> None:
        """Receive a header field or a trailer field."""
        self._count_field(len(name) + len(value) + 4)
        super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """Start the app."""
        self._reading_head = False
        self._reading_body = True
        self._head_bytes = self._body_bytes = 0
        self._since = self._time()
        if len(self.pipeline) >= _MOST_WAITING:
            message = "too many"
            raise ValueError(message)  # ends the parser without an answer
        super().on_headers_complete()
        if not self.pipeline:
            self._answering = self.cycle

    def on_body(self, body: bytes) -> None:
        """Receive a part of the body."""
        self._body_bytes += len(body)
        super().on_body(body)

    def on_message_complete(self) -> None:
        """End a request."""
        self._reading_body = False
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """End an answer. Its request may still be arriving."""
        self._since = self._time()
        if self.pipeline:
            self._answering = self.pipeline[-1][0]
        super().on_response_complete()

    def send_400_response(self, msg: str) -> None:
        """Answer a request that the parser refused. Called by uvicorn."""
        del msg  # always the same text
        self._refuse(self._refusal or Problem("bad-request", "The request is not HTTP/1.1."))

    def _count_field(self, size: int) -> None:
        self._fields_bytes += size
        if self._fields_bytes > self.limits.head_bytes:
            self._refusal = self._head_problem()
            message = "too large"
            raise ValueError(message)  # ends the parser; uvicorn then calls send_400_response

    def _head_problem(self) -> Problem:
        limit = self.limits.head_bytes
        detail = f"The request target and the header fields are larger than {limit} bytes."
        return Problem("head-too-large", detail, {"limit": limit})

    def _refuse(self, problem: Problem) -> None:
        """End the connection with a problem document, if one can still be sent."""
        if self._refused:
            # uvicorn has passed on the parser's error already.
            return
        cycle = self._answering
        if cycle is not None and not cycle.response_complete:
            if cycle.response_started or cycle is not self.cycle or self._reading_head:
                self._abort()
                return
            # The app must stop: nobody reads its answer.
            cycle.disconnected = True
            cycle.message_event.set()
        self._send_problem(problem)

    def _abort(self) -> None:
        """Close the connection without an answer."""
        if self._answering is not None:
            self._answering.disconnected = True
        self.pipeline.clear()
        self.transport.abort()

    def _send_problem(self, problem: Problem) -> None:
        answer = problem_response(problem)
        request_id = answer.headers[REQUEST_ID] = os.urandom(16).hex()
        answer.headers["Connection"] = "close"
        head = [STATUS_LINE[answer.status_code]]
        for name, value in answer.raw_headers:
            head += [name, b": ", value, b"\r\n"]
        self.transport.write(b"".join([*head, b"\r\n", bytes(answer.body)]))
        self._refused = True
        client = get_remote_addr(self.transport)
        self.report(
            Refusal(
                problem.code,
                answer.status_code,
                len(answer.body),
                self._time() - self._since,
                client[0] if client else None,
                request_id,
            )
        )
        if self.transport.can_write_eof():
            # Closing with unread data would send a reset and discard the answer.
            self.transport.write_eof()
            self.loop.call_later(_REFUSED_SECONDS, self.transport.abort)
        else:
            self.transport.close()

    @property
    def _idle(self) -> bool:
        """Whether no complete request has arrived."""
        return self._refused or (
            not self._reading_body and (self.cycle is None or self.cycle.response_complete)
        )

    def _make_room(self) -> bool:
        """Close the connection that has been idle longest; return whether there is one."""
        others = cast("set[LimitedProtocol]", self.connections)
        idle = [other for other in others if other._idle]  # noqa: SLF001 - of the same class
        if not idle:
            return False
        # Many connections may share one millisecond; the sequence number decides.
        oldest = min(idle, key=lambda other: (other._since, other._number))  # noqa: SLF001
        oldest._abort()  # noqa: SLF001
        self.connections.discard(oldest)
        return True

    def _time(self) -> float:
        """Return the seconds that this process could serve its connections."""
        return self.loop.time() - self.stalled

    def _schedule_sweep(self) -> None:
        due = self.loop.time() + _SWEEP_SECONDS
        self.loop.call_at(due, self._sweep, due)

    def _sweep(self, due: float) -> None:
        """Close the connections that exceeded a time limit, and schedule the next check."""
        # Clients are not blamed for the time in which this process did not run.
        type(self).stalled += max(self.loop.time() - due, 0.0)
        now = self._time()
        for connection in list(cast("set[LimitedProtocol]", self.connections)):
            connection._look(now)  # noqa: SLF001 - of the same class
        type(self).sweeping = bool(self.connections)
        if self.connections:
            self._schedule_sweep()

    def _look(self, now: float) -> None:
        if self._is_stalled(now):
            self._abort()
        elif self._refused or self.transport.is_closing():
            return
        elif self._reading_body:
            self._look_at_body(now)
        elif self._idle and now - self._since > self.limits.head_seconds:
            if self._head_bytes == 0:
                # No request was sent. Between requests, uvicorn's timeout applies.
                if self._answering is None:
                    self.transport.close()
            else:
                detail = (
                    f"The head of the request did not arrive within {self.limits.head_seconds:g} s."
                )
                self._refuse(Problem("request-timeout", detail))

    def _look_at_body(self, now: float) -> None:
        if self.cycle.response_complete:
            if now - self._since > _LINGER_SECONDS:
                self._abort()
            return
        if self.flow.read_paused:
            # The app is slow, not the client.
            self._since = max(self._since, now - self.limits.body_seconds)
            return
        allowed = self.limits.body_seconds + self._body_bytes / self.limits.body_rate
        if now - self._since > allowed:
            detail = (
                f"{self._body_bytes} bytes of the body arrived within {now - self._since:.0f} s."
            )
            self._refuse(Problem("request-timeout", detail))

    def _is_stalled(self, now: float) -> bool:
        """Return whether the client has read nothing of the waiting data for too long."""
        unsent = self.transport.get_write_buffer_size()
        if unsent == 0 or self._stalled_since is None or unsent < self._unsent:
            self._stalled_since = now if unsent else None
        self._unsent = unsent
        return self._stalled_since is not None and (
            now - self._stalled_since > self.limits.write_seconds
        )


def limited_protocol(
    limits: ConnectionLimits, report: Callable[[Refusal], None]
) -> type[LimitedProtocol]:
    """Return a protocol class that uvicorn can instantiate without further arguments.

    `report` is called for every answer that is given without the app.
    """
    # A server may ignore the wish for another protocol (RFC 9110, section 7.8).
    logging.getLogger("uvicorn.error").addFilter(_concerns_operators)
    attributes: dict[str, Any] = {"limits": limits, "report": staticmethod(report)}
    return type("LimitedProtocol", (LimitedProtocol,), attributes)


def _concerns_operators(record: logging.LogRecord) -> bool:
    """Return whether a log record is not one of uvicorn's two about unsupported upgrades."""
    return not record.getMessage().startswith(("Unsupported upgrade", "No supported WebSocket"))
