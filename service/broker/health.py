"""Heartbeat files of the workers on this host, and the check that reads them.

A worker has no port. It writes a small file every few seconds while it is connected to the broker
and Celery's loop runs. ``gamut worker --check`` and ``python -m service.broker.health`` read the
files. This module imports only the standard library, so probes can run it often.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from pathlib import Path

__all__ = ["SIGN_SECONDS", "faults", "leave", "main", "sign"]

SIGN_SECONDS = 2.0
"""Interval of heartbeats."""

_STALE_SECONDS = 15.0


def sign(warm: int, slots: int) -> None:
    """Write this process's heartbeat file.

    `warm` of its `slots` processes can build or are building.
    """
    folder = _folder()
    folder.mkdir(mode=0o700, exist_ok=True)
    state = {"time": time.time(), "warm": warm, "slots": slots}
    new = folder / f"{os.getpid()}.new"
    new.write_text(json.dumps(state))
    new.replace(folder / f"{os.getpid()}.json")


def leave() -> None:
    """Remove this process's heartbeat file: it ends, or has lost its broker."""
    (_folder() / f"{os.getpid()}.json").unlink(missing_ok=True)


def faults() -> list[str]:
    """Return the faults of the workers on this host, one sentence each."""
    found = []
    running = 0
    for path in sorted(_folder().glob("*.json")):
        if not Path(f"/proc/{path.stem}").exists() and Path("/proc/self").exists():
            path.unlink(missing_ok=True)  # left by a killed worker
            continue
        running += 1
        try:
            state = json.loads(path.read_bytes())
            age, warm, slots = time.time() - state["time"], state["warm"], state["slots"]
        except FileNotFoundError:
            continue
        except (OSError, ValueError, KeyError) as error:
            found.append(f"worker {path.stem}: {path} cannot be read: {error}")
            continue
        if age > _STALE_SECONDS:
            found.append(f"worker {path.stem}: no heartbeat for {age:.0f} s")
        elif warm == 0:
            found.append(f"worker {path.stem}: none of its {slots} processes is warm yet")
    if not running:
        found.append("no worker that is connected to its broker runs on this host")
    return found


def main() -> int:
    """Print the faults, and return the exit status: 0 if there are none."""
    found = faults()
    sys.stdout.writelines(f"{fault}\n" for fault in found)
    return 1 if found else 0


def _folder() -> Path:
    return Path(tempfile.gettempdir()) / f"gamut-workers-{os.getuid()}"


if __name__ == "__main__":
    sys.exit(main())
