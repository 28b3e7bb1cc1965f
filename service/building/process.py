"""A warm worker process, seen from the service: one build at a time, each of which can be ended.

The process is started afresh (`service.building.worker`) and spoken to in lines of JSON over its
standard streams. While it builds, the deadline, the memory in use and whatever the caller wants to
check are looked at twenty times a second, and at the first objection the process is killed: native
code can be ended in no other way. All methods block: they are called in threads.
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
"""How a worker is started: a process of its own, which shares nothing with this one."""

_LINE_LIMIT = 16 * 1024 * 1024
"""Bytes of the longest event: a description with its whole error curve is well below 1 MB."""

_TICK = 0.05
"""Seconds between two looks at a build. Memory is filled at 2 to 4 GB/s, so that a build gets at
most about 200 MB above its limit."""

_READ = 1 << 16


class ProcessDiedError(Exception):
    """The worker process ended while it was needed."""


class BuildTimeoutError(Exception):
    """A build exceeded its deadline; its process was killed."""


class MemoryExceededError(Exception):
    """A build wanted more memory than it may have."""


class BuildProcess:
    """A running worker process.

    Parameters
    ----------
    command : sequence of str
        The command line of a worker, which speaks the protocol of `service.building.worker`.

    Attributes
    ----------
    idle_bytes : int or None
        Memory that the process had in use before its first build.
    """

    def __init__(self, command: Sequence[str] = WORKER_COMMAND) -> None:
        # glibc gives every thread an arena of its own, which then is never given back.
        environment = {**os.environ, "MALLOC_ARENA_MAX": "2"}
        self._process = subprocess.Popen(  # noqa: S603 - our own worker
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, bufsize=0
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
        """Return the memory that the process has in use; None where the system does not tell."""
        return private_bytes(self.pid)

    def wait_until_ready(self, check: Callable[[], None]) -> None:
        """Wait until the process has compiled its kernels.

        Parameters
        ----------
        check : callable
            Called all the time; what it raises ends the process.

        Raises
        ------
        ProcessDiedError
            It ended instead.
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
        """Have one gamut built, and return the final event.

        Parameters
        ----------
        request : dict
            What `service.building.worker.build` takes, with the limit of memory.
        timeout : float
            Seconds that it may take.
        progress : callable
            Gets stage and fraction.
        check : callable
            Called twenty times a second; what it raises ends the process.

        Raises
        ------
        ProcessDiedError, BuildTimeoutError, MemoryExceededError
            The build was ended. The process is gone.
        """
        deadline = time.monotonic() + timeout
        memory = request.get("memory", 0)

        def check_all() -> None:
            check()
            if time.monotonic() > deadline:
                raise BuildTimeoutError
            in_use = self.private_bytes() if memory else None
            if in_use is not None and in_use > memory:
                logger.warning("a build has %d bytes of memory in use", in_use)
                raise MemoryExceededError

        self._unsent = json.dumps(request).encode() + b"\n"
        try:
            while True:
                event = self._event(check_all)
                if event["event"] != "progress":
                    return event
                progress(event["stage"], event["fraction"])
        except BaseException as error:
            self.kill()
            if isinstance(error, KeyError | TypeError):
                # Whatever speaks there is none of ours any more.
                raise ProcessDiedError(f"an unreadable event: {error!r}") from error
            raise

    def kill(self) -> None:
        """End the process now, whatever it is doing, and wait until it is gone."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        self._process.wait()
        for stream in (self._requests, self._events):
            with contextlib.suppress(OSError):
                stream.close()

    def _event(self, check: Callable[[], None]) -> dict[str, Any]:
        """Return the next event, sending meanwhile what is unsent."""
        while True:
            line, end, rest = self._buffer.partition(b"\n")
            if end:
                self._buffer = rest
                return self._parsed(bytes(line))
            check()
            readable, writable = self._ready()
            try:
                if writable:
                    sent = os.write(self._requests.fileno(), self._unsent)
                    self._unsent = self._unsent[sent:]
                if readable:
                    data = os.read(self._events.fileno(), _READ)
                    if not data or len(self._buffer) > _LINE_LIMIT:
                        raise self._death()
                    self._buffer += data
            except BrokenPipeError as error:
                raise self._death() from error

    def _ready(self) -> tuple[bool, bool]:
        """Return whether there is something to read, and whether what is unsent can be sent."""
        # Not select(), which takes no descriptors from 1024 on: the service may have more open.
        poll = select.poll()
        poll.register(self._events, select.POLLIN)
        if self._unsent:
            poll.register(self._requests, select.POLLOUT)
        found = {descriptor for descriptor, _ in poll.poll(1000 * _TICK)}
        return self._events.fileno() in found, self._requests.fileno() in found

    def _parsed(self, line: bytes) -> dict[str, Any]:
        try:
            event = json.loads(line)
        except ValueError as error:
            raise ProcessDiedError(f"an unreadable event: {error}") from error
        if not isinstance(event, dict):
            raise ProcessDiedError("an unreadable event")
        return event

    def _death(self) -> ProcessDiedError:
        self._process.kill()
        status = self._process.wait()
        return ProcessDiedError(f"signal {-status}" if status < 0 else f"exit status {status}")


def private_bytes(process: int | str) -> int | None:
    """Return the bytes of a process's memory that are neither shared nor read from a file.

    Libraries and cached kernels are mapped from files and shared by all workers, so they do not
    count; neither does address space that is reserved and was never touched.

    Parameters
    ----------
    process : int or str
        Its id, or ``self``.

    Returns
    -------
    int or None
        None if the system does not tell, or if there is no such process.
    """
    try:
        pages = Path(f"/proc/{process}/statm").read_text().split()
        return (int(pages[1]) - int(pages[2])) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError):
        return None
