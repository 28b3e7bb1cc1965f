"""HTTP/1.1 at the level of connections: limits that a framework behind it cannot keep.

uvicorn parses requests and runs the app. This protocol adds what protects it from clients that are
slow, endless or malformed, whether they mean it or not: time limits for the head and the body of a
request and for taking the answer, a limit for the size of the head, a number of connections beyond
which idle ones give way to new ones, and problem documents wherever the app is never reached; these
are reported, since no layer of the app sees them. See ``docs/decisions/hostile-clients.md``.
"""

from __future__ import annotations

import itertools
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from uvicorn.protocols.http.httptools_impl import (
    STATUS_LINE,
    HttpToolsProtocol,
    RequestResponseCycle,
)
from uvicorn.protocols.utils import get_remote_addr

from service.http.request_id import HEADER
from service.problems.problem import Problem, problem_response

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

    from service.settings import Settings

__all__ = ["ConnectionLimits", "LimitedProtocol", "Refusal", "limited_protocol"]

_SWEEP_SECONDS = 0.5
"""How often connections are looked at, so how late a time limit may be noticed."""

_LINGER_SECONDS = 5.0
"""How long the rest of a body is taken and dropped whose answer is sent already: a client that
reads its answer only behind its body gets it, and nobody can send for ever."""

_REFUSED_SECONDS = 0.5
"""How long a client that was refused has to read the answer, while what it sends is dropped."""


_MOST_WAITING = 32
"""Requests that may wait behind one that is being answered on the same connection; programs that
send ahead at all send about ten. Each takes memory, and one packet may hold thousands."""

_numbers = itertools.count()
"""Of the connections, in the order in which they came."""


@dataclass(frozen=True)
class ConnectionLimits:
    """What one connection may take.

    Attributes
    ----------
    connections : int
        Open ones at the same time.
    head_bytes : int
        Address and header fields of a request.
    head_seconds : float
        From the first byte of a request, or from connecting, to the end of its head.
    body_seconds : float
        For a body, besides what its size allows.
    body_rate : int
        Bytes per second that a body has to arrive with.
    write_seconds : float
        How long a client may take none of an answer that waits for it.
    """

    connections: int
    head_bytes: int
    head_seconds: float
    body_seconds: float
    body_rate: int
    write_seconds: float

    @classmethod
    def of(cls, settings: Settings) -> ConnectionLimits:
        """Return the limits that settings ask for."""
        return cls(
            settings.max_connections,
            settings.max_head_bytes,
            settings.head_timeout,
            settings.body_timeout,
            settings.min_body_rate,
            settings.write_timeout,
        )


class Refusal(NamedTuple):
    """An answer that was given without the app.

    Attributes
    ----------
    problem : str
        Its code.
    status : int
        Of HTTP.
    nbytes : int
        Of the content.
    seconds : float
        Since the wait for what the client was sending began.
    client : str or None
        Address of the other side of the connection, which may be a proxy's.
    request_id : str
        That the answer names.
    """

    problem: str
    status: int
    nbytes: int
    seconds: float
    client: str | None
    request_id: str


class LimitedProtocol(HttpToolsProtocol):
    """A connection with limits.

    The time limits of all connections are kept by one timer of the server: a request costs it
    nothing but noting the time.
    """

    limits: ConnectionLimits
    report: Callable[[Refusal], None]
    sweeping = False
    """Whether the timer of all connections of this class is running."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a connection, or tell it that there are too many."""
        self._number = next(_numbers)
        self._since = self.loop.time()  # when the wait for what the client sends now began
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
            self.loop.call_later(_SWEEP_SECONDS, self._sweep)

    def connection_lost(self, exc: Exception | None) -> None:
        """Let the request that is being answered know that nobody listens any more."""
        if self._answering is not None:
            # uvicorn tells the newest one, which may wait behind others.
            self._answering.disconnected = True
            self._answering.message_event.set()
        super().connection_lost(exc)

    def _start_asgi_task(self, cycle: RequestResponseCycle, app: Any) -> None:  # noqa: ANN401 - uvicorn's own
        self._answering = cycle
        super()._start_asgi_task(cycle, app)

    def data_received(self, data: bytes) -> None:
        """Take a part of a request."""
        if self._refused or self.transport.is_closing():
            return
        if not self._reading_body:
            if not self._reading_head and self._head_bytes == 0:
                self._since = self.loop.time()
            # The parser keeps the beginning of a long field to itself, so all bytes count.
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
        """Take a part of the address."""
        self._count_field(len(url))
        super().on_url(url)

    def on_header(self, name: bytes, value: bytes) -> None:
        """Take a header field, or one behind a chunked body."""
        self._count_field(len(name) + len(value) + 4)
        super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """Let the app begin."""
        self._reading_head = False
        self._reading_body = True
        self._head_bytes = self._body_bytes = 0
        self._since = self.loop.time()
        if len(self.pipeline) >= _MOST_WAITING:
            message = "too many"
            raise ValueError(message)  # ends the parser; there is no place for a word
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        """Take a part of the body."""
        self._body_bytes += len(body)
        super().on_body(body)

    def on_message_complete(self) -> None:
        """End a request."""
        self._reading_body = False
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """End an answer, whose request may still be arriving."""
        self._since = self.loop.time()
        super().on_response_complete()

    def send_400_response(self, msg: str) -> None:
        """Answer what the parser does not understand; uvicorn calls it."""
        del msg  # uvicorn's, a sentence that is always the same
        self._refuse(self._refusal or Problem("bad-request", "The request is not HTTP/1.1."))

    def _unsupported_upgrade_warning(self) -> None:
        # RFC 9110, 7.8: a server may ignore it. It is no event that an operator has to know of.
        pass

    def _count_field(self, size: int) -> None:
        self._fields_bytes += size
        if self._fields_bytes > self.limits.head_bytes:
            self._refusal = self._head_problem()
            message = "too large"
            raise ValueError(message)  # ends the parser; uvicorn then calls send_400_response

    def _head_problem(self) -> Problem:
        limit = self.limits.head_bytes
        detail = f"The address and the header fields are larger than {limit} bytes."
        return Problem("head-too-large", detail, {"limit": limit})

    def _refuse(self, problem: Problem) -> None:
        """End the connection with a problem document, where there is a place for one."""
        cycle = self._answering
        if cycle is not None and not cycle.response_complete:
            if cycle.response_started or cycle is not self.cycle or self._reading_head:
                self._abort()
                return
            # Lets the app know that nobody reads what it may answer.
            cycle.disconnected = True
            cycle.message_event.set()
        self._send_problem(problem)

    def _abort(self) -> None:
        """End the connection without a word, whatever is under way."""
        if self._answering is not None:
            self._answering.disconnected = True
        self.pipeline.clear()
        self.transport.abort()

    def _send_problem(self, problem: Problem) -> None:
        answer = problem_response(problem)
        request_id = answer.headers[HEADER] = os.urandom(16).hex()
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
                self.loop.time() - self._since,
                client[0] if client else None,
                request_id,
            )
        )
        if self.transport.can_write_eof():
            # Closing while something unread is there would take the answer back (a reset).
            self.transport.write_eof()
            self.loop.call_later(_REFUSED_SECONDS, self.transport.abort)
        else:
            self.transport.close()

    @property
    def _idle(self) -> bool:
        """Whether nothing of a request that could be answered has come."""
        return self._refused or (
            not self._reading_body and (self.cycle is None or self.cycle.response_complete)
        )

    def _make_room(self) -> bool:
        """Close the connection that has waited longest without a request; whether there is one."""
        others = cast("set[LimitedProtocol]", self.connections)
        idle = [other for other in others if other._idle]  # noqa: SLF001 - of the same class
        if not idle:
            return False
        # Event loops count milliseconds, in which many may come: among those, the first to come.
        oldest = min(idle, key=lambda other: (other._since, other._number))  # noqa: SLF001
        oldest._abort()  # noqa: SLF001
        self.connections.discard(oldest)
        return True

    def _sweep(self) -> None:
        """End the connections whose time is over, and look again later if any are left."""
        now = self.loop.time()
        for connection in list(cast("set[LimitedProtocol]", self.connections)):
            connection._look(now)  # noqa: SLF001 - of the same class
        type(self).sweeping = bool(self.connections)
        if self.connections:
            self.loop.call_later(_SWEEP_SECONDS, self._sweep)

    def _look(self, now: float) -> None:
        if self._is_stalled(now):
            self._abort()
        elif self._refused or self.transport.is_closing():
            return
        elif self._reading_body:
            self._look_at_body(now)
        elif self._idle and now - self._since > self.limits.head_seconds:
            if self._head_bytes == 0:
                # Nothing was asked. Between requests uvicorn's shorter time has closed it before.
                self.transport.close()
            else:
                detail = (
                    f"The head of the request did not come within {self.limits.head_seconds:g} s."
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
            detail = f"{self._body_bytes} bytes of the body came within {now - self._since:.0f} s."
            self._refuse(Problem("request-timeout", detail))

    def _is_stalled(self, now: float) -> bool:
        """Whether the client has taken nothing for too long of what waits for it."""
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
    """Return the protocol class, as uvicorn wants it: made without arguments.

    Parameters
    ----------
    limits : ConnectionLimits
    report : callable
        Hears of every answer that the app knows nothing of.
    """
    attributes: dict[str, Any] = {"limits": limits, "report": staticmethod(report)}
    return type("LimitedProtocol", (LimitedProtocol,), attributes)
