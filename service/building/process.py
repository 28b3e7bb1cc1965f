"""A warm worker process, seen from the service: one build at a time, which can be ended.

The process is a new program (`service.building.worker`), not a fork. Both sides exchange lines of
JSON over standard streams. During a build, the deadline, the memory in use and the caller's check
are tested twenty times per second. If a test fails, the process is killed, because native code
cannot be ended otherwise. All methods block and are called in threads.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import select
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from service.building.confinement import worker_environment

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = [
    "WORKER_COMMAND",
    "BuildProcess",
    "BuildTimeoutError",
    "MemoryExceededError",
    "ProcessDiedError",
    "private_bytes",
]

logger = logging.getLogger(__name__)

WORKER_COMMAND = (sys.executable, "-m", "service.building.worker")
"""Command line of a worker. It shares no memory with this process."""

_LINE_LIMIT = 16 * 1024 * 1024
"""Bytes of the longest event. A description with its error curve has less than 1 MB."""

_TICK = 0.05
"""Seconds between two checks of a build. Memory grows by 2 to 4 GB/s, so a build exceeds its limit
by at most about 200 MB."""

_READ = 1 << 16


class ProcessDiedError(Exception):
    """The worker process ended while it was needed."""


class BuildTimeoutError(Exception):
    """A build exceeded its deadline, and its process was killed."""


class MemoryExceededError(Exception):
    """A build exceeded its memory limit."""


class BuildProcess:
    """A running worker process; `idle_bytes` is the memory in use before the first build.

    `command` starts a worker with the protocol of `service.building.worker`.
    """

    def __init__(self, command: Sequence[str] = WORKER_COMMAND) -> None:
        # Descriptors other than the standard streams are closed.
        self._process = subprocess.Popen(  # noqa: S603 - our own worker
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=worker_environment(),
            bufsize=0,
        )
        assert self._process.stdin is not None  # noqa: S101 - pipes were asked for
        assert self._process.stdout is not None  # noqa: S101
        self._requests = self._process.stdin
        self._events = self._process.stdout
        os.set_blocking(self._requests.fileno(), False)
        os.set_blocking(self._events.fileno(), False)
        self._buffer = bytearray()
        self.idle_bytes: int | None = None
        self._unsent = b""

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process.poll() is None

    def fileno(self) -> int:
        """Return a descriptor that becomes readable when an idle process ends."""
        return self._events.fileno()

    def private_bytes(self) -> int | None:
        """Return the memory in use; None if the system does not report it."""
        return private_bytes(self.pid)

    def wait_until_ready(self, check: Callable[[], None]) -> None:
        """Wait until the process has compiled its kernels; raise `ProcessDiedError` if it ends.

        `check` is called repeatedly, and its exception ends the process.
        """
        try:
            self._event(check)
            self.idle_bytes = self.private_bytes()
        except BaseException:
            self.kill()
            raise

    def result(
        self,
        request: dict[str, Any],
        *,
        timeout: float,
        progress: Callable[[str, float], None],
        check: Callable[[], None],
    ) -> dict[str, Any]:
        """Build one gamut and return the final event; the worker's module explains `request`.

        `timeout` is the deadline in seconds, and an exception of `check` ends the process. After
        `ProcessDiedError`, `BuildTimeoutError` and `MemoryExceededError` the process is gone.
        """
        deadline = time.monotonic() + timeout
        memory = request.get("memory", 0)

        def check_all() -> None:
            check()
            if time.monotonic() > deadline:
                raise BuildTimeoutError
            in_use = self.private_bytes() if memory else None
            if in_use is not None and in_use > memory:
                logger.warning("build exceeds its memory limit with %d bytes in use", in_use)
                raise MemoryExceededError

        self._unsent = json.dumps(request).encode() + b"\n"
        try:
            while True:
                event = self._event(check_all)
                if event["event"] != "progress":
                    if event.get("last"):
                        self.kill()
                    return event
                progress(event["stage"], event["fraction"])
        except BaseException as error:
            self.kill()
            if isinstance(error, KeyError | TypeError):
                # The events are not those of a worker.
                raise ProcessDiedError(f"an unreadable event: {error!r}") from error
            raise

    def kill(self) -> None:
        """Kill the process and wait for its end."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        self._process.wait()
        for stream in (self._requests, self._events):
            with contextlib.suppress(OSError):
                stream.close()

    def _event(self, check: Callable[[], None]) -> dict[str, Any]:
        """Return the next event; meanwhile send the rest of the request."""
        while True:
            line, end, rest = self._buffer.partition(b"\n")
            if end:
                self._buffer = rest
                return self._parse(bytes(line))
            check()
            readable, writable = self._ready()
            try:
                if writable:
                    sent = os.write(self._requests.fileno(), self._unsent)
                    self._unsent = self._unsent[sent:]
                if readable:
                    data = os.read(self._events.fileno(), _READ)
                    if not data or len(self._buffer) > _LINE_LIMIT:
                        raise self._wait_for_death()
                    self._buffer += data
            except BrokenPipeError as error:
                raise self._wait_for_death() from error

    def _ready(self) -> tuple[bool, bool]:
        """Return whether events can be read, and whether the request can be written."""
        # Not select(), which fails for descriptors from 1024 on.
        poll = select.poll()
        poll.register(self._events, select.POLLIN)
        if self._unsent:
            poll.register(self._requests, select.POLLOUT)
        found = {descriptor for descriptor, _ in poll.poll(1000 * _TICK)}
        return self._events.fileno() in found, self._requests.fileno() in found

    def _parse(self, line: bytes) -> dict[str, Any]:
        try:
            event = json.loads(line)
        except ValueError as error:
            raise ProcessDiedError(f"an unreadable event: {error}") from error
        if not isinstance(event, dict):
            raise ProcessDiedError("an unreadable event")
        return event

    def _wait_for_death(self) -> ProcessDiedError:
        self._process.kill()
        status = self._process.wait()
        return ProcessDiedError(f"signal {-status}" if status < 0 else f"exit status {status}")


def private_bytes(process: int | str) -> int | None:
    """Return the bytes of a process's memory that are neither shared nor mapped from files.

    Mapped libraries, cached kernels and address space that was never touched do not count. The
    result is None without such a process, or if the system does not report its memory.
    """
    try:
        pages = Path(f"/proc/{process}/statm").read_text().split()
        return (int(pages[1]) - int(pages[2])) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError):
        return None
