"""A warm worker process, seen from the service: one build at a time, which can be ended.

The process is a new program (`service.building.worker`), not a fork, so a decoder that a file takes
over finds neither memory, open files nor credentials of the service. It keeps the rights of the
user: it can read and write a store in a directory, and connect to addresses. Both sides exchange
lines of JSON over standard streams. During a build, the deadline, the memory in use and the
caller's check are tested twenty times per second. If a test fails, the process is killed, because
native code cannot be ended otherwise. All methods block and are called in threads. See
``docs/decisions/builds-in-a-worker-process.md``.
"""

import contextlib
import ctypes
import json
import logging
import os
import re
import select
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

__all__ = [
    "NO_NEW_PRIVILEGES",
    "WORKER_COMMAND",
    "BuildProcess",
    "ProcessDiedError",
    "hide_memory",
    "prctl",
    "private_bytes",
]

logger = logging.getLogger(__name__)

WORKER_COMMAND = (sys.executable, "-m", "service.building.worker")

_ALLOWED = re.compile(
    r"PATH|HOME|TMPDIR|TZ|LANG|LANGUAGE|LC_[A-Z]+|LD_LIBRARY_PATH|PYTHON[A-Z]+"
    r"|(NUMBA|OPENBLAS|OMP|MALLOC|GAMUT_LOG)_[A-Z_]+"
)
"""Variables that a worker gets: paths, language, threads, allocator, compiler and log. Everything
else may be a credential."""

_NO_TELEMETRY = {f"OTEL_{signal}_EXPORTER": "none" for signal in ("TRACES", "METRICS", "LOGS")}
"""``opentelemetry-instrument`` reaches a worker through ``PYTHONPATH``, but its settings do not."""

_LINE_LIMIT = 16 * 1024 * 1024
"""Bytes of the longest event. A description with its error curve has less than 1 MB."""

_TICK = 0.05
"""Seconds between two checks of a build. Memory grows by 2 to 4 GB/s, so a build exceeds its limit
by at most about 200 MB."""

_READ = 1 << 16

_DUMPABLE, NO_NEW_PRIVILEGES = 4, 38
"""Operations of prctl(2)."""


class ProcessDiedError(Exception):
    """The worker process ended while it was needed."""


class _LimitExceededError(Exception):
    """A build exceeded a limit; the argument is the event that reports it."""


class BuildProcess:
    """A running worker process. `command` starts one with the protocol of the worker's module."""

    def __init__(self, command: Sequence[str] = WORKER_COMMAND) -> None:
        environment = {name: text for name, text in os.environ.items() if _ALLOWED.fullmatch(name)}
        # Descriptors other than the standard streams are closed.
        self._process = subprocess.Popen(  # noqa: S603 - our own worker
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            # glibc gives every thread an arena, and never returns its memory.
            env={**environment, **_NO_TELEMETRY, "MALLOC_ARENA_MAX": "2"},
            bufsize=0,
        )
        assert self._process.stdin is not None  # noqa: S101 - pipes were asked for
        assert self._process.stdout is not None  # noqa: S101
        self._requests, self._events = self._process.stdin, self._process.stdout
        os.set_blocking(self._requests.fileno(), False)
        os.set_blocking(self._events.fileno(), False)
        self._buffer = bytearray()
        self._unsent = b""
        self._idle_bytes: int | None = None

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

    def wait_until_ready(self, check: Callable[[], None]) -> None:
        """Wait until the kernels are compiled; raise `ProcessDiedError` if the process ends.

        `check` is called repeatedly, and its exception ends the process.
        """
        try:
            self._event(check)
            self._idle_bytes = private_bytes(self.pid)
        except BaseException:
            self.kill()
            raise

    def result(
        self,
        request: dict[str, Any],
        *,
        progress: Callable[[str, float], None],
        check: Callable[[], None],
    ) -> dict[str, Any]:
        """Build one gamut and return the final event of the worker, or ``timeout``.

        The worker's module explains requests and events. An exception of `check` ends the process,
        which is also gone after `ProcessDiedError` and when a limit was exceeded.
        """
        deadline = time.monotonic() + request["seconds"]
        memory = request.get("memory", 0)

        def check_all() -> None:
            check()
            if time.monotonic() > deadline:
                raise _LimitExceededError("timeout")
            in_use = private_bytes(self.pid) if memory else None
            if in_use is not None and in_use > memory:
                logger.warning("build exceeds its memory limit with %d bytes in use", in_use)
                raise _LimitExceededError("exhausted")

        self._unsent = json.dumps(request).encode() + b"\n"
        try:
            while (event := self._event(check_all))["event"] == "progress":
                progress(event["stage"], event["fraction"])
        except _LimitExceededError as error:
            self.kill()
            return {"event": str(error)}
        except (KeyError, TypeError) as error:
            self.kill()
            # The events are not those of a worker.
            raise ProcessDiedError(f"an unreadable event: {error!r}") from error
        except BaseException:
            self.kill()
            raise
        if event.get("last") or self._is_large(memory):
            self.kill()
        return event

    def kill(self) -> None:
        """Kill the process and wait for its end."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        self._process.wait()
        for stream in (self._requests, self._events):
            with contextlib.suppress(OSError):
                stream.close()

    def _is_large(self, memory: int) -> bool:
        """Return whether the process keeps so much memory that the next build would lack it."""
        in_use, idle = private_bytes(self.pid), self._idle_bytes
        if not memory or in_use is None or idle is None or in_use <= (idle + memory) / 2:
            return False
        logger.info("build worker %d still uses %d bytes and is replaced", self.pid, in_use)
        return True

    def _event(self, check: Callable[[], None]) -> dict[str, Any]:
        """Return the next event; meanwhile send the rest of the request."""
        while True:
            line, end, rest = self._buffer.partition(b"\n")
            if end:
                self._buffer = rest
                try:
                    event = json.loads(line)
                except ValueError as error:
                    raise ProcessDiedError(f"an unreadable event: {error}") from error
                if not isinstance(event, dict):
                    raise ProcessDiedError("an unreadable event")
                return event
            check()
            # Not select(), which fails for descriptors from 1024 on.
            poll = select.poll()
            poll.register(self._events, select.POLLIN)
            if self._unsent:
                poll.register(self._requests, select.POLLOUT)
            ready = {descriptor for descriptor, _ in poll.poll(1000 * _TICK)}
            try:
                if self._requests.fileno() in ready:
                    sent = os.write(self._requests.fileno(), self._unsent)
                    self._unsent = self._unsent[sent:]
                if self._events.fileno() in ready:
                    data = os.read(self._events.fileno(), _READ)
                    if not data or len(self._buffer) > _LINE_LIMIT:
                        raise self._wait_for_death()
                    self._buffer += data
            except BrokenPipeError as error:
                raise self._wait_for_death() from error

    def _wait_for_death(self) -> ProcessDiedError:
        self._process.kill()
        status = self._process.wait()
        return ProcessDiedError(f"signal {-status}" if status < 0 else f"exit status {status}")


def private_bytes(process: int | str) -> int | None:
    """Return the bytes of a process's memory that are neither shared nor mapped from files.

    Address space that was never touched does not count. The result is None without such a process,
    or if the system does not report its memory.
    """
    try:
        pages = Path(f"/proc/{process}/statm").read_text().split()
        return (int(pages[1]) - int(pages[2])) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError):
        return None


def hide_memory() -> None:
    """Close memory and environment of this process, with its credentials, to other processes.

    Root can still read them.
    """
    prctl(_DUMPABLE, 0)


def prctl(operation: int, argument: int) -> None:
    """Call prctl(2) on Linux."""
    if sys.platform != "linux":
        return
    if ctypes.CDLL(None, use_errno=True).prctl(operation, argument, 0, 0, 0) != 0:
        logger.warning("prctl(%d) failed: %s", operation, os.strerror(ctypes.get_errno()))
