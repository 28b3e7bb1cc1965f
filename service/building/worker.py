"""The process that builds gamuts: ``python -m service.building.worker``.

The process compiles all kernels, reports that it is ready, and builds one gamut after the other.
Requests are lines of JSON on standard input, events are lines of JSON on standard output. Inputs
and history files are passed by path. The process ends when its standard input ends, so it never
outlives the service.

A request has the members:

- ``id``: the id of the job.
- ``input``, ``output``: paths of the data and of the history file.
- ``options``, ``limits``: options of the gamut, and members of `Limits`.
- ``memory``: memory limit in bytes; 0 for none.
- ``seconds``: deadline, if any.

``progress`` events name a stage of `gamutcore.building.STAGES`, or ``encoding`` while the history
file is written. The last event has ``seconds`` by stage, and ``last`` if the process ends:

- ``built``: the history file is written. ``id`` is that of the gamut, if another version of the
  algorithm accepted the job.
- ``refused``: the input or an option is at fault.
- ``exhausted``: memory.
- ``failed``: the system, or a defect.

The same process maps pictures, whose decoders need the same protection. Such a request has
``picture``, the path of a picture, and nothing else, which is answered by ``measured`` with its
``pixels``. With ``gamut``, the path of a history file, the picture is mapped to ``output``, with
``arguments`` of `Gamut.map_picture`; ``model``, ``profile`` and ``source`` are paths too, and
``heat_map`` is written if it is given. ``mapped`` has the ``report``. The deadline alone limits the
time, which the service watches.

The service watches the memory of a build and kills the process. The process itself limits single
large allocations. See ``docs/decisions/builds-in-a-worker-process.md``.
"""

import contextlib
import hashlib
import json
import logging
import math
import os
import queue
import resource
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import asdict, fields
from pathlib import Path
from typing import IO, Any

from gamutcore.characterisation.pictures import open_raster, picture_format
from gamutcore.errors import GamutError
from gamutcore.gamut import Gamut
from gamutcore.kernels import ensure_compiled, load_kernels
from gamutcore.limits import Limits, apply_limits
from gamutcore.options import Options
from gamutcore.pictures import no_picture
from service.building.process import NO_NEW_PRIVILEGES, prctl, private_bytes
from service.telemetry.logs import configure_logging

__all__ = ["Events", "build", "main"]

logger = logging.getLogger(__name__)

_PROGRESS_INTERVAL = 0.1
"""Seconds between two progress events of one stage."""

_MOST = {
    resource.RLIMIT_CORE: 0,
    resource.RLIMIT_NOFILE: 1024,
    resource.RLIMIT_FSIZE: 4 << 30,
}
"""Limits of a worker. A build has less than 20 open files, compilers of kernels have more.
Histories have less than 0.1 GB, temporary copies of pictures the size of the request. The
number of processes is not limited: the limit would count those of neighbours, too."""

_ROOM = 1 << 30
"""Address space of the tables of all colours of 8 bits, most of which is never used: 0.6 GB."""

_MARGIN_SECONDS = 10.0
"""Processor time of a build beyond its deadline on all cores."""


class Events:
    """Writes events to the service, one line of JSON each."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream

    def send(self, event: str, **values: object) -> None:
        """Send an event with its values."""
        line = json.dumps({"event": event, **values}, allow_nan=False)
        self._stream.write(line.encode() + b"\n")
        self._stream.flush()


class _Progress:
    """Reports the progress of one build, and measures its stages."""

    def __init__(self, events: Events) -> None:
        self._events = events
        self._stage = ""
        self._sent = self._entered = time.monotonic()
        self._seconds: dict[str, float] = {}

    def __call__(self, stage: str, fraction: float) -> None:
        """Send the progress, unless the same stage was reported a moment ago."""
        now = time.monotonic()
        if stage != self._stage:
            self._leave(now)
            self._stage = stage
        elif now - self._sent < _PROGRESS_INTERVAL:
            return
        self._sent = now
        self._events.send("progress", stage=stage, fraction=float(fraction))

    def seconds(self) -> dict[str, float]:
        """Return the seconds that each stage has taken so far."""
        self._leave(time.monotonic())
        return {stage: round(seconds, 6) for stage, seconds in self._seconds.items()}

    def _leave(self, now: float) -> None:
        if self._stage:
            spent = self._seconds.get(self._stage, 0.0)
            self._seconds[self._stage] = spent + now - self._entered
        self._entered = now


def build(request: dict[str, Any], events: Events) -> None:
    """Build one gamut, write its history file, and send the outcome (see the module)."""
    progress = _Progress(events)

    def end(error: GamutError) -> None:
        # Native code cannot be ended otherwise.
        events.send(**_refusal(error), seconds=progress.seconds(), last=True)
        os._exit(0)

    if "seconds" in request:
        _limit_processor_time(request["seconds"])
    result: dict[str, Any]
    try:
        options, default = Options.from_stored(request["options"]), Options()
        if (options.cost, options.boundary) != (default.cost, default.boundary):
            # outside the limit, which the compiler's processes would inherit
            ensure_compiled("optional")
        with _data_limit(request.get("memory", 0)), _temporary_files_beside(request["output"]):
            data = Path(request["input"]).read_bytes()
            limits = Limits(**request.get("limits", {}), overtime=end)
            gamut = Gamut(data, options, progress=progress, limits=limits)
            progress("encoding", 0.0)
            content = gamut.to_bytes()
            Path(request["output"]).write_bytes(content)
            result = {
                "event": "built",
                "sha256": hashlib.sha256(content).hexdigest(),
                "nbytes": len(content),
                "description": gamut.description,
            }
            if gamut.id != request["id"]:
                # Accepted before an upgrade: the id promises what another version would build.
                result["id"] = gamut.id
    except GamutError as error:
        result = _refusal(error)
    except MemoryError:
        logger.warning("build exceeded its memory limit")
        result = {"event": "exhausted"}
    except OSError as error:
        logger.error("cannot read the input or write the history file: %s", error)  # noqa: TRY400 - no defect
        result = {"event": "failed", "errno": error.errno}
    except Exception:
        # Only this build may fail. The traceback goes to the log.
        logger.exception("build ended with an unexpected error")
        result = {"event": "failed", "errno": None}
    events.send(**result, seconds=progress.seconds())


def map_picture(request: dict[str, Any], events: Events) -> None:
    """Measure or map one picture, and send the outcome (see the module)."""
    result: dict[str, Any]
    try:
        limits = Limits(**request.get("limits", {}))
        if "gamut" in request:
            with (
                apply_limits(limits),
                _data_limit(request["memory"] + _ROOM if request.get("memory") else 0),
                _temporary_files_beside(request["output"]),
            ):
                result = {"event": "mapped", "report": _mapped(request)}
        else:
            with apply_limits(limits), _temporary_files_beside(request["picture"]):
                result = _measured(Path(request["picture"]).read_bytes())
    except Exception as error:  # noqa: BLE001 - only this picture may fail
        result = _failure(error)
    events.send(**result)


def _measured(data: bytes) -> dict[str, Any]:
    file_format = picture_format(data)
    if file_format is None:
        raise no_picture()
    with open_raster(data, file_format) as raster:
        return {"event": "measured", "pixels": raster.width * raster.height}


def _mapped(request: dict[str, Any]) -> dict[str, Any]:
    """Map a picture, and return what became of its pixels."""

    def content(name: str) -> bytes | None:
        return Path(request[name]).read_bytes() if request.get(name) else None

    arguments = dict(request["arguments"])
    history, model, source = content("gamut"), content("model"), content("source")
    gamut = Gamut.from_bytes(history or b"")
    if model is not None:
        gamut.use_device_model(model, content("profile"))
    if source is not None:
        arguments["source"] = Gamut.from_bytes(source)
    done = gamut.map_picture(
        content("picture") or b"",
        request["output"],
        heat_map=request.get("heat_map"),
        **arguments,
    )
    report = {each.name: getattr(done, each.name) for each in fields(done)}
    error, conditions = done.table_error, done.gamut
    report["table_error"] = None if error is None else asdict(error)
    report["gamut"] = None if conditions is None else conditions.to_dict()
    return report


def _failure(error: Exception) -> dict[str, Any]:
    """Return the event of an exception."""
    if isinstance(error, GamutError):
        return _refusal(error)
    if isinstance(error, MemoryError):
        return {"event": "exhausted"}
    if isinstance(error, OSError):
        logger.error("cannot read or write a picture: %s", error)
        return {"event": "failed", "errno": error.errno}
    logger.error("a picture ended with an unexpected error", exc_info=error)
    return {"event": "failed", "errno": None}


def _refusal(error: GamutError) -> dict[str, Any]:
    """Return the event that passes on the whole error."""
    return {
        "event": "refused",
        "code": error.code,
        "message": error.message,
        "where": error.where,
        "remedy": error.remedy,
    }


@contextlib.contextmanager
def _temporary_files_beside(output: str) -> Iterator[None]:
    """Let decoders write to the scratch folder. /tmp may be small, read-only or in memory.

    The names begin with the output's name, so the service finds the files of a killed worker.
    """
    before = tempfile.tempdir, tempfile.template
    path = Path(output)
    tempfile.tempdir, tempfile.template = str(path.parent), f"{path.name}."
    try:
        yield
    finally:
        tempfile.tempdir, tempfile.template = before


@contextlib.contextmanager
def _data_limit(memory: int) -> Iterator[None]:
    """Let allocations fail that would exceed `memory` bytes in use.

    RLIMIT_DATA limits private writable address space, of which compilers and allocators reserve
    more than they use (410 MiB in a warm worker that uses 186). So the limit is the space reserved
    now plus the memory that is left.
    """
    in_use = private_bytes("self")
    reserved = _reserved_bytes()
    if not memory or in_use is None or reserved is None:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limit = _below(hard, reserved + max(memory - in_use, 0))
    resource.setrlimit(resource.RLIMIT_DATA, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def _reserved_bytes() -> int | None:
    """Return this process's private writable address space, which RLIMIT_DATA limits."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmData:"):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    return None


def _confine() -> None:
    """Give up all rights that a worker does not need, before it reads any input."""
    prctl(NO_NEW_PRIVILEGES, 1)
    for limit, most in _MOST.items():
        lowered = _below(resource.getrlimit(limit)[1], most)
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(limit, (lowered, lowered))


def _limit_processor_time(seconds: float) -> None:
    """End this process when it uses all cores for longer than `seconds` plus a margin from now on.

    The service ends builds by the clock. This limit ends a build whose service is gone.
    """
    most = time.process_time() + (os.cpu_count() or 1) * (seconds + _MARGIN_SECONDS)
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_CPU, (_below(hard, math.ceil(most)), hard))


def _below(hard: int, limit: int) -> int:
    """Return a limit, lowered to the hard limit if there is one."""
    return limit if hard == resource.RLIM_INFINITY else min(limit, hard)


def _read_requests(stream: IO[bytes], requests: queue.SimpleQueue[dict[str, Any]]) -> None:
    for line in stream:
        requests.put(json.loads(line))
    # The service has ended, so nobody takes the result of a running build.
    os._exit(0)


def main() -> None:
    """Serve build requests from standard input until it ends."""
    # The service has validated these values.
    configure_logging(
        os.environ.get("GAMUT_LOG_FORMAT", "text"), os.environ.get("GAMUT_LOG_LEVEL", "info")
    )
    # Ctrl-C reaches the whole process group, and SIGTERM of a service manager all processes. The
    # service decides when its workers end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    _confine()
    # If the system runs out of memory, it should end a build, not the service.
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500")
    # Output of libraries goes to the log, not between the events.
    events = Events(os.fdopen(os.dup(sys.stdout.fileno()), "wb"))
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    requests: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    threading.Thread(target=_read_requests, args=(sys.stdin.buffer, requests), daemon=True).start()
    ensure_compiled("default")
    load_kernels()
    events.send("ready")
    while True:
        request = requests.get()
        (map_picture if "picture" in request else build)(request, events)


if __name__ == "__main__":
    main()
