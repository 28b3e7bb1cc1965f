"""A server process with a new directory, for the programs of this folder."""

from __future__ import annotations

import contextlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[2]
PATIENCE = 600.0
COMMAND = "import sys; from service.__main__ import main; sys.exit(main())"


class Serving(NamedTuple):
    """A server that is ready: its port on 127.0.0.1, its process id and its log."""

    port: int
    pid: int
    log: Path

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def resident(self) -> int:
        """Return the resident memory of the process in bytes."""
        pages = int(Path(f"/proc/{self.pid}/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")

    def built(self, samples: list[list[float]]) -> dict[str, object]:
        """Build a gamut of inline colours and return its description."""
        body = json.dumps({"samples": samples}).encode()
        headers = {"Content-Type": "application/json", "Prefer": "wait=300"}
        request = urllib.request.Request(f"{self.url}/v1/gamuts", body, headers)
        with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
            return json.load(answer)


@contextlib.contextmanager
def serving(**settings: object) -> Iterator[Serving]:
    """Start a server with settings, wait until it is ready, and stop it at the end."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {
            **{name: value for name, value in os.environ.items() if not name.startswith("GAMUT_")},
            **{f"GAMUT_{name.upper()}": str(value) for name, value in settings.items()},
            "PYTHONPATH": str(ROOT),
        }
        log = Path(folder) / "log"
        with log.open("wb") as output:
            process = subprocess.Popen(
                [sys.executable, "-c", COMMAND, "serve", "--port", "0"],
                cwd=folder,  # the default place of the store
                env=environment,
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        try:
            yield Serving(ready_port(process, log), process.pid, log)
        finally:
            process.terminate()
            process.wait(PATIENCE)


def ready_port(process: subprocess.Popen[bytes], log: Path) -> int:
    """Wait until the server is ready and return its port, which the log names."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline and process.poll() is None:
        found = re.search(r"Uvicorn running on http://127\.0\.0\.1:(\d+)", log.read_text())
        if found:
            with contextlib.suppress(OSError):
                urllib.request.urlopen(
                    f"http://127.0.0.1:{found[1]}/readyz", timeout=PATIENCE
                ).close()
                return int(found[1])
        time.sleep(0.05)
    raise RuntimeError(log.read_text())
