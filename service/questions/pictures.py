"""Pictures that are mapped: one at a time, in a process of their own, within the memory budget.

Decoders of pictures are native code, and a hostile file may take them over, so the API process
decodes none. The process is the worker of builds (`service.building.worker`), which is started for
the first picture and ended when no picture has come for a while. A picture is measured first. Its
place is then exchanged for one with its memory (`service.admission`), which is the limit of the
process.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from service.admission import MODEL_BYTES, needed_bytes
from service.building.process import WORKER_COMMAND, BuildProcess, ProcessDiedError, private_bytes
from service.http.request_context import timed
from service.problems.problem import Problem, ProblemError, sentence

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from service.admission import Place
    from service.settings import Settings

__all__ = ["MOST_PIXELS", "MappingRequest", "Pictures", "report_header"]

MOST_PIXELS = 24_000_000
"""Pixels of the largest picture: that of most cameras, which takes 10 s. A proxy gives up after a
minute."""

IDLE_SECONDS = 60.0
"""Time without pictures after which the process ends."""

_FIRST_PIXELS = 8_000_000
"""Pixels whose colours are distinct. There are at most 16.8 million distinct colours of 8 bits, so
further pixels take half as much."""

_SPATIAL = 2
"""Memory that the spatial mapping adds, as a multiple of that of the pixels."""

_MAPPING_MODELS = 2
"""Memory of the process beside the pixels, in device models: a full boundary with its index, and
the tables of recipes."""

_COMMAND_LINE = "Send a smaller picture, or map it on your computer with `gamut map`."


@dataclass(frozen=True)
class MappingRequest:
    """What the process needs: paths of files, and arguments of `Gamut.map_picture`."""

    picture: Path
    output: Path
    gamut: Path
    arguments: dict[str, Any] = field(default_factory=dict)
    model: Path | None = None
    profile: Path | None = None
    source: Path | None = None
    heat_map: Path | None = None

    def document(self) -> dict[str, Any]:
        """Return the request of the worker."""
        names = ("picture", "output", "gamut", "model", "profile", "source", "heat_map")
        paths = {name: getattr(self, name) for name in names}
        files = {name: str(path) for name, path in paths.items() if path is not None}
        return {**files, "arguments": self.arguments}


class Pictures:
    """The mapping of pictures. Belongs to the event loop's thread, unless stated otherwise."""

    def __init__(self, settings: Settings, command: Sequence[str] = WORKER_COMMAND) -> None:
        self._settings, self._command = settings, command
        self._is_mapping = False
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="pictures")
        self._process: BuildProcess | None = None
        self._idle: asyncio.TimerHandle | None = None
        self._closing = False

    async def mapped(self, request: MappingRequest, place: Place) -> dict[str, Any]:
        """Map a picture in the place of its class, and return the report.

        Raise `ProblemError` for whatever is wrong with the picture, the arguments or the limits.
        """
        limits = {"pixels": MOST_PIXELS}
        measure = {"picture": str(request.picture), "limits": limits}
        pixels = (await self._result(measure, 0))["pixels"]
        counted = (pixels + min(pixels, _FIRST_PIXELS)) / 2
        if request.arguments.get("method") == "spatial":
            counted += _SPATIAL * pixels
        nbytes = needed_bytes(models=_MAPPING_MODELS, pixels=counted)
        await place.exchange(nbytes)
        with timed("query"):
            document = {**request.document(), "limits": limits}
            report: dict[str, Any] = (await self._result(document, nbytes))["report"]
        return report

    async def close(self) -> None:
        """End the process."""
        self._closing = True
        if self._idle is not None:
            self._idle.cancel()
        await asyncio.to_thread(self._thread.shutdown)
        if self._process is not None:
            self._process.kill()

    async def _result(self, document: dict[str, Any], nbytes: int) -> dict[str, Any]:
        """Return the outcome of the worker, or raise its problem."""
        if self._idle is not None:
            self._idle.cancel()
        self._is_mapping = True
        loop = asyncio.get_running_loop()
        work = loop.run_in_executor(self._thread, self._run, document, nbytes)
        try:
            event = await asyncio.shield(work)
        except asyncio.CancelledError:
            await asyncio.wait([work])  # the next picture needs the process
            raise
        finally:
            self._is_mapping = False
            self._idle = loop.call_later(IDLE_SECONDS, self._end_idle)
        problem = self._problem(event)
        if problem is not None:
            raise ProblemError(problem)
        return event

    def _run(self, document: dict[str, Any], nbytes: int) -> dict[str, Any]:
        """Send a request to the process, in the thread, and return the last event."""
        try:
            process = self._process
            if process is None or not process.alive:
                process = BuildProcess(self._command)
                process.wait_until_ready(self._check)
                self._process = process
        except ProcessDiedError as error:
            return {"event": "unstarted", "message": str(error)}
        try:
            memory = (private_bytes(process.pid) or 0) + (nbytes or _MAPPING_MODELS * MODEL_BYTES)
            request = {**document, "memory": memory, "seconds": self._settings.build_timeout}
            return process.result(request, progress=_ignore, check=self._check)
        except ProcessDiedError as error:
            return {"event": "died", "message": str(error)}

    def _check(self) -> None:
        if self._closing:
            raise ProcessDiedError("the service is stopping")

    def _end_idle(self) -> None:
        if self._process is None or self._is_mapping or self._closing:
            return
        process, self._process = self._process, None
        self._thread.submit(process.kill)

    def _problem(self, event: dict[str, Any]) -> Problem | None:
        """Return the problem that an event reports; None for a result."""
        kind, fault = event["event"], event.get("message", "")
        if kind == "refused":
            return _refusal(event)
        if kind in {"unstarted", "died"} and self._closing:
            return Problem("shutting-down", "The service is stopping.")
        if kind == "failed":
            detail = "The mapping ended with an unexpected error."
            return Problem.from_errno(event["errno"]) or Problem("internal-error", detail)
        seconds = self._settings.build_timeout
        data, again = {"field": "data"}, "Save the picture again, as PNG, TIFF or baseline JPEG."
        slow, large = "picture-too-complex", "more memory than pictures of its size should"
        problems = {
            "timeout": Problem(
                slow, f"The mapping was ended after {seconds:g} s.", data, _COMMAND_LINE
            ),
            "exhausted": Problem(slow, f"The picture needs {large}.", data, _COMMAND_LINE),
            "died": Problem(
                "malformed-file", f"The process that reads pictures died ({fault}).", data, again
            ),
            "unstarted": Problem(
                "overloaded",
                f"The process that reads pictures did not start ({fault}).",
                headers={"Retry-After": "5"},
            ),
        }
        return problems.get(kind)


def _refusal(event: dict[str, Any]) -> Problem:
    """Return the problem of an error of `gamutcore`."""
    code, where, remedy = event["code"], dict(event["where"]), event["remedy"]
    if code == "invalid-option":
        code, where = "invalid-parameter", {"in": "query", **where}
    if code == "picture-too-large":
        remedy = f"{remedy} Larger ones are mapped by `gamut map` on your computer."
    return Problem(code, sentence(event["message"]), where, remedy)


def _ignore(_stage: str, _fraction: float) -> None:
    """Take no notice of progress, which pictures do not report."""


_REPORTED = ("pixels", "outside", "moved", "missed", "colours", "colours_outside")
_DIFFERENCES = ("delta_e", "delta_e_95", "moved_delta_e", "moved_delta_e_95")


def report_header(report: dict[str, Any]) -> str:
    """Return the header field with what became of the pixels, a dictionary (RFC 9651, 3.2)."""
    members = {name: str(report[name]) for name in _REPORTED}
    members |= {name: f"{report[name]:.4f}" for name in _DIFFERENCES}
    error = report["table_error"]
    if error is not None:
        members |= {f"table_{name}": f"{error[name]:.4f}" for name in ("mean", "percentile_95")}
        members["table_nodes"] = str(error["nodes"])
    return ", ".join(f"{name.replace('_', '-')}={value}" for name, value in members.items())
