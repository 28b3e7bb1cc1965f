"""The process that builds gamuts: ``python -m service.building.worker``, started by the service.

It compiles all kernels, says that it is ready, and then builds one gamut after the other. Requests
come as lines of JSON on standard input, events go as lines of JSON to standard output; inputs and
history files are passed by path, so nothing large and nothing pickled crosses the border. It ends
as soon as its standard input does, so it never outlives the service.

A build may be given a limit of memory. The service watches what is in use and ends the process; the
process itself only sees to it that one large allocation fails, before it can be used. See
``docs/decisions/builds-in-a-worker-process.md`` for the measurements behind both.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import os
import queue
import resource
import signal
import sys
import threading
import time
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from gamutcore.errors import GamutError
from gamutcore.gamut import Options, build_gamut
from gamutcore.limits import Limits
from gamutcore.warm import compile_kernels
from service.building.memory import private_bytes
from service.telemetry.logs import configure_logging

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["Events", "Progress", "build", "main"]

logger = logging.getLogger(__name__)

_PROGRESS_INTERVAL = 0.1
"""Seconds between two progress events of one stage: what a person polling a job can tell apart."""


class Events:
    """Writes events to the service, one line of JSON each."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream

    def send(self, event: str, **values: object) -> None:
        """Send an event with its values."""
        line = json.dumps({"event": event, **values}, allow_nan=False)
        self._stream.write(line.encode() + b"\n")
        self._stream.flush()


class Progress:
    """Tells how far one build is, and how long its stages took."""

    def __init__(self, events: Events) -> None:
        self._events = events
        self._stage = ""
        self._sent = self._entered = time.monotonic()
        self._seconds: dict[str, float] = {}

    def __call__(self, stage: str, fraction: float) -> None:
        """Send how far a stage is, unless the same stage was reported a moment ago."""
        now = time.monotonic()
        if stage != self._stage:
            self._leave(now)
            self._stage = stage
        elif now - self._sent < _PROGRESS_INTERVAL:
            return
        self._sent = now
        self._events.send("progress", stage=stage, fraction=float(fraction))

    def seconds(self) -> dict[str, float]:
        """Return how many seconds each stage has taken so far."""
        self._leave(time.monotonic())
        return {stage: round(seconds, 6) for stage, seconds in self._seconds.items()}

    def _leave(self, now: float) -> None:
        if self._stage:
            spent = self._seconds.get(self._stage, 0.0)
            self._seconds[self._stage] = spent + now - self._entered
        self._entered = now


def build(request: dict[str, Any], events: Events) -> None:
    """Build one gamut, write its history file, and send what became of it.

    Parameters
    ----------
    request : dict
        ``input`` and ``output`` are paths, ``options`` the mapping of the gamut's options;
        ``limits``, where there are any, the members of `Limits`; ``memory`` is the number of bytes
        that may be in use, 0 for any.
    events : Events
        Gets ``progress`` events and at last one of ``built``, ``refused`` (the input or an option
        is at fault), ``exhausted`` (more memory was wanted than may be), ``failed`` (the system or
        a defect of the program); each with ``seconds`` by stage.
    """
    progress = Progress(events)
    try:
        with _data_limit(request.get("memory", 0)):
            data = Path(request["input"]).read_bytes()
            options = Options.from_mapping(request["options"])
            limits = Limits(**request.get("limits", {}))
            gamut = build_gamut(data, options, progress=progress, limits=limits)
            progress("encoding", 0.0)
            content = gamut.to_bytes()
            Path(request["output"]).write_bytes(content)
            result: dict[str, Any] = {
                "event": "built",
                "sha256": hashlib.sha256(content).hexdigest(),
                "nbytes": len(content),
                "description": gamut.description,
            }
    except GamutError as error:
        result = {
            "event": "refused",
            "code": error.code,
            "message": error.message,
            "where": error.where,
            "remedy": error.remedy,
        }
    except MemoryError:
        logger.warning("a build wanted more memory than it may have")
        result = {"event": "exhausted"}
    except OSError as error:
        logger.error("cannot read the input or write the history file: %s", error)  # noqa: TRY400 - no defect
        result = {"event": "failed", "errno": error.errno}
    except Exception:
        # A defect must cost this build only; the traceback goes to the log.
        logger.exception("a build ended with an unexpected error")
        result = {"event": "failed", "errno": None}
    events.send(result.pop("event"), **result, seconds=progress.seconds())


@contextlib.contextmanager
def _data_limit(memory: int) -> Iterator[None]:
    """Let allocations fail that would bring the memory in use above `memory` bytes.

    What is limited is private writable address space, of which compilers and allocators reserve
    far more than they use (measured: 410 MiB of it in a warm worker that uses 186). So the limit is
    what is reserved now, and besides what is left until `memory` is in use.
    """
    in_use = private_bytes("self")
    reserved = _reserved_bytes()
    if not memory or in_use is None or reserved is None:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limit = reserved + max(memory - in_use, 0)
    if hard != resource.RLIM_INFINITY:
        limit = min(limit, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def _reserved_bytes() -> int | None:
    """Return this process's private writable address space, which is what RLIMIT_DATA limits."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmData:"):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    return None


def _read_requests(stream: IO[bytes], requests: queue.SimpleQueue[dict[str, Any]]) -> None:
    for line in stream:
        requests.put(json.loads(line))
    # The service is gone, and nobody is left to take the result of a running build.
    os._exit(0)


def main() -> None:
    """Serve build requests from standard input until it ends."""
    # As the service was told to: it has checked what they say.
    configure_logging(
        os.environ.get("GAMUT_LOG_FORMAT", "text"), os.environ.get("GAMUT_LOG_LEVEL", "info")
    )
    # Ctrl-C reaches the whole process group, and a service manager's SIGTERM all processes of the
    # service; the service decides when its workers end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    # If the system runs out of memory, a build is what it should end, not the service.
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500")
    # Whatever a library prints goes to the log, not between the events.
    events = Events(os.fdopen(os.dup(sys.stdout.fileno()), "wb"))
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    requests: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    threading.Thread(target=_read_requests, args=(sys.stdin.buffer, requests), daemon=True).start()
    compile_kernels()
    events.send("ready")
    while True:
        build(requests.get(), events)


if __name__ == "__main__":
    main()
