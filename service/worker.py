"""The process that builds gamuts: ``python -m service.worker``, started and ended by the service.

It compiles all kernels, says that it is ready, and then builds one gamut after the other. Requests
come as lines of JSON on standard input, events go as lines of JSON to standard output; inputs and
history files are passed by path, so nothing large and nothing pickled crosses the border. It ends
as soon as its standard input does, so it never outlives the service.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import queue
import signal
import sys
import threading
import time
from pathlib import Path
from typing import IO, Any

from gamutcore.errors import GamutError
from gamutcore.gamut import Options, build_gamut
from gamutcore.limits import Limits
from gamutcore.warm import compile_kernels

__all__ = ["Events", "build", "main"]

logger = logging.getLogger(__name__)

_PROGRESS_INTERVAL = 0.1
"""Seconds between two progress events of one stage: what a person polling a job can tell apart."""


class Events:
    """Writes events to the service, one line of JSON each."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._last: tuple[str, float] = ("", 0.0)

    def send(self, event: str, **values: object) -> None:
        """Send an event with its values."""
        line = json.dumps({"event": event, **values}, allow_nan=False)
        self._stream.write(line.encode() + b"\n")
        self._stream.flush()

    def progress(self, stage: str, fraction: float) -> None:
        """Send how far a stage is, unless the same stage was reported a moment ago."""
        now = time.monotonic()
        if stage != self._last[0] or now - self._last[1] >= _PROGRESS_INTERVAL:
            self._last = (stage, now)
            self.send("progress", stage=stage, fraction=float(fraction))


def build(request: dict[str, Any], events: Events) -> None:
    """Build one gamut, write its history file, and send what became of it.

    Parameters
    ----------
    request : dict
        ``input`` and ``output`` are paths, ``options`` the mapping of the gamut's options,
        ``limits``, where there are any, the members of `Limits`.
    events : Events
        Gets ``progress`` events and at last one of ``built``, ``refused`` (the input or an option
        is at fault), ``full`` (no space on the disk), ``failed`` (a defect of the program).
    """
    try:
        data = Path(request["input"]).read_bytes()
        options = Options.from_mapping(request["options"])
        limits = Limits(**request.get("limits", {}))
        gamut = build_gamut(data, options, progress=events.progress, limits=limits)
        content = gamut.to_bytes()
        Path(request["output"]).write_bytes(content)
        events.send(
            "built",
            sha256=hashlib.sha256(content).hexdigest(),
            nbytes=len(content),
            description=gamut.description,
        )
    except GamutError as error:
        events.send(
            "refused",
            code=error.code,
            message=error.message,
            where=error.where,
            remedy=error.remedy,
        )
    except OSError as error:
        logger.exception("cannot read the input or write the history file")
        events.send("failed", errno=error.errno)
    except Exception:
        # A defect must cost this build only; the traceback goes to the log.
        logger.exception("a build ended with an unexpected error")
        events.send("failed", errno=None)


def _read_requests(stream: IO[bytes], requests: queue.SimpleQueue[dict[str, Any]]) -> None:
    for line in stream:
        requests.put(json.loads(line))
    # The service is gone, and nobody is left to take the result of a running build.
    os._exit(0)


def main() -> None:
    """Serve build requests from standard input until it ends."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s worker: %(message)s")
    # Ctrl-C reaches the whole process group; the service decides when its workers end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
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
