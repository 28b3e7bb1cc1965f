"""Measure the way to the first gamut in a fresh clone: ``make bench-startup``.

Clones a revision of this repository, serves it with ``make serve``, posts the example, restarts it,
and compiles all kernels from nothing and after edits. The figures go to ``benchmarks/startup.json``
and into ``docs/benchmarks.md``. ``--revision`` measures another revision, for a comparison in one
run. Packages come from pip's cache, if they were installed before.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import http.client
import json
import os
import resource
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks import markdown
from benchmarks.bench import DOCUMENT, machine
from benchmarks.common import ROOT
from benchmarks.http import posted

__all__ = ["GOALS", "main", "measure", "table_of"]

RESULTS = Path(__file__).with_name("startup.json")

GOALS: dict[str, tuple[str, float | None]] = {
    "serve_seconds": ("`make serve` in a fresh clone to ready, s", 60.0),
    "first_post_seconds": ("`POST examples/FOGRA39L.ti3` at once after that, s", None),
    "all_compiled_seconds": ("`make serve` to all optional kernels compiled, s", None),
    "compile_cpu_seconds": ("processor time to compile all kernels, s", 100.0),
    "machine_code_megabytes": ("machine code of all kernels, MB", 15.0),
    "edit_usv_seconds": ("compiled again after an edit in `usv.py`, processor time, s", 10.0),
    "edit_queue_seconds": ("the same in `edge_queue.py`, s", 40.0),
    "edit_comment_seconds": ("the same after an edit of a comment, s", None),
    "server_megabytes": ("resident memory of the warm idle server, MiB", 200.0),
    "worker_megabytes": ("resident memory of the warm idle build worker, MiB", 200.0),
    "restart_seconds": ("restart of a warm installation to ready, s", 2.5),
}
"""What is measured, and the most that it should be."""

LIMIT_SECONDS = 900.0
"""A server that is not ready after so long has failed."""


def main() -> None:
    """Measure revisions and write the figures of the working tree's."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.startup", description=__doc__)
    parser.add_argument("--revision", default="HEAD", help="what to measure; HEAD by default")
    parser.add_argument("--key", default="now", choices=["now", "before"], help="column to write")
    arguments = parser.parse_args()
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    results["machine"] = machine()
    results[arguments.key] = measure(arguments.revision)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")
    text = table_of(results)
    print(text)
    markdown.update_document(DOCUMENT, {"startup": text})


def table_of(results: dict[str, Any]) -> str:
    """Return the figures as a Markdown table.

    Parameters
    ----------
    results : dict
        ``now`` and, optionally, ``before``: figures by the names of `GOALS`.
    """
    columns = [key for key in ("before", "now") if key in results]
    rows = []
    for name, (title, goal) in GOALS.items():
        cells = [
            "–" if results[key][name] is None else f"{results[key][name]:.3g}" for key in columns
        ]
        rows.append([title, *cells, "–" if goal is None else f"≤ {goal:g}"])
    return markdown.table(["figure", *columns, "goal"], rows)


def measure(revision: str) -> dict[str, float | None]:
    """Return the figures of a revision by the names of `GOALS`.

    Parameters
    ----------
    revision : str
        Anything that git resolves to a commit.
    """
    figures: dict[str, float | None] = {}
    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder) / "clone"
        subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
        commit = _output(["git", "rev-parse", revision], ROOT)
        subprocess.run(["git", "checkout", "-q", commit], cwd=clone, check=True)
        with _server(["make", "serve"], clone) as server:
            figures["serve_seconds"] = server.wait_ready()
            clock = time.monotonic()
            posted(server.port, {})
            figures["first_post_seconds"] = time.monotonic() - clock
            figures["all_compiled_seconds"] = server.wait_compiled()
        with _server([str(clone / ".venv/bin/gamut"), "serve"], clone) as server:
            server.wait_ready()
        restarts = []
        for _ in range(3):
            with _server([str(clone / ".venv/bin/gamut"), "serve"], clone) as server:
                restarts.append(server.wait_ready())
                time.sleep(3.0)
                figures["server_megabytes"], figures["worker_megabytes"] = server.memory()
        figures["restart_seconds"] = sorted(restarts)[1]
        figures.update(_compilation(clone))
    return figures


def _compilation(clone: Path) -> dict[str, float | None]:
    """Compile all kernels from nothing, and after edits."""
    figures: dict[str, float | None] = {}
    cache = clone / "kernels"
    figures["compile_cpu_seconds"] = _compile(clone, cache)
    figures["machine_code_megabytes"] = (
        sum(path.stat().st_size for path in cache.rglob("*.nbc")) / 1e6
    )
    warm = min(_compile(clone, cache) for _ in range(2))
    for name, module in (("usv", "boundary/usv.py"), ("queue", "decimation/edge_queue.py")):
        path = clone / "gamutcore" / module
        source = path.read_text()
        path.write_text(_edited(source))
        figures[f"edit_{name}_seconds"] = max(_compile(clone, cache) - warm, 0.0)
        path.write_text("# A comment.\n" + _edited(source))
        figures["edit_comment_seconds"] = max(_compile(clone, cache) - warm, 0.0)
        path.write_text(source)
        _compile(clone, cache)
    return figures


def _edited(source: str) -> str:
    """Change the bytecode of every kernel of a module, and not what it computes."""
    lines = source.splitlines(keepends=True)
    for node in reversed(list(ast.walk(ast.parse(source)))):
        if isinstance(node, ast.FunctionDef) and any(
            "kernel" in ast.unparse(decorator) for decorator in node.decorator_list
        ):
            lines.insert(node.body[-1].lineno - 1, f"{' ' * node.body[-1].col_offset}_edited = 0\n")
    return "".join(lines)


def _compile(clone: Path, cache: Path) -> float:
    """Return the processor time that ``gamutcore.warm`` takes."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [str(clone / ".venv/bin/python"), "-m", "gamutcore.warm"],
        cwd=clone,
        check=True,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
        stderr=subprocess.DEVNULL,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class _Server:
    """A server that has been started, in a process group of its own."""

    def __init__(self, command: list[str], clone: Path) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        environment = {name: value for name, value in os.environ.items() if name != "MAKEFLAGS"}
        self._clock = time.monotonic()
        self._log = (clone / "serve.log").open("w")
        self.process = subprocess.Popen(
            command,
            cwd=clone,
            env={**environment, "GAMUT_PORT": str(self.port)},
            stdout=self._log,
            stderr=self._log,
            start_new_session=True,
        )

    def _get(self, path: str) -> tuple[int, bytes]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        try:
            connection.request("GET", path)
            answer = connection.getresponse()
            return answer.status, answer.read()
        except OSError:
            return 0, b""
        finally:
            connection.close()

    def _wait(self, path: str, satisfied: Any) -> float:  # noqa: ANN401
        while time.monotonic() - self._clock < LIMIT_SECONDS:
            if satisfied(*self._get(path)):
                return time.monotonic() - self._clock
            if self.process.poll() is not None:
                break
            time.sleep(0.02)
        raise RuntimeError(f"the server did not answer {path} as expected; see {self._log.name}")

    def wait_ready(self) -> float:
        """Return the seconds from the start until ``/readyz`` answers 200."""
        return self._wait("/readyz", lambda status, _: status == 200)

    def wait_compiled(self) -> float | None:
        """Return the seconds from the start until all kernels are compiled, if the server tells."""
        _, body = self._get("/readyz")
        if b"optional" not in body:
            return None
        return self._wait("/readyz", lambda _, body: b"optional: compiled" in body)

    def memory(self) -> tuple[float, float]:
        """Return the resident memory of the server and of its largest build worker, in MiB."""
        resident: dict[str, list[float]] = {"server": [], "worker": []}
        for entry in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
                if int(fields[2]) != self.process.pid:
                    continue
                command = (entry / "cmdline").read_bytes()
                pages = int((entry / "statm").read_text().split()[1])
                kind = "worker" if b"service.building.worker" in command else "server"
                resident[kind].append(pages * os.sysconf("SC_PAGE_SIZE") / 2**20)
        return max(resident["server"]), max(resident["worker"])

    def stop(self) -> None:
        """End the server and all that it has started."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGTERM)
        self.process.wait(60)
        self._log.close()


@contextlib.contextmanager
def _server(command: list[str], clone: Path) -> Iterator[_Server]:
    server = _Server(command, clone)
    try:
        yield server
    finally:
        server.stop()


def _output(command: list[str], folder: Path) -> str:
    return subprocess.run(
        command, cwd=folder, check=True, capture_output=True, text=True
    ).stdout.strip()


if __name__ == "__main__":
    main()
