"""Signs of life of the workers on this host, and the check that reads them.

A worker has no port that could be asked, so it leaves a small file, written anew every few seconds
while its connection to the broker stands and Celery's loop turns. ``gamut worker --check`` and, for
probes that run all day, ``python -m service.broker.health`` say whether all is well; the latter
needs the standard library only, and hardly any time.
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
"""Between two signs of life."""

_STALE_SECONDS = 15.0


def sign(warm: int, slots: int) -> None:
    """Write this process's sign of life.

    Parameters
    ----------
    warm : int
        Its processes that can build or are building.
    slots : int
        The processes that it should have.
    """
    folder = _folder()
    folder.mkdir(mode=0o700, exist_ok=True)
    state = {"time": time.time(), "warm": warm, "slots": slots}
    new = folder / f"{os.getpid()}.new"
    new.write_text(json.dumps(state))
    new.replace(folder / f"{os.getpid()}.json")


def leave() -> None:
    """Take this process's sign of life away: it is about to end, or has no broker."""
    (_folder() / f"{os.getpid()}.json").unlink(missing_ok=True)


def faults() -> list[str]:
    """Return what is wrong with the workers on this host, a sentence each; none if all is well."""
    found = []
    running = 0
    for path in sorted(_folder().glob("*.json")):
        if not Path(f"/proc/{path.stem}").exists() and Path("/proc/self").exists():
            path.unlink(missing_ok=True)  # of a worker that was killed
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
            found.append(f"worker {path.stem}: no sign of life for {age:.0f} s")
        elif warm == 0:
            found.append(f"worker {path.stem}: none of its {slots} processes is warm yet")
    if not running:
        found.append("no worker is running here, or none that has reached its broker")
    return found


def main() -> int:
    """Print what is wrong, and return the exit status: 0 if nothing is."""
    found = faults()
    sys.stdout.writelines(f"{fault}\n" for fault in found)
    return 1 if found else 0


def _folder() -> Path:
    return Path(tempfile.gettempdir()) / f"gamut-workers-{os.getuid()}"


if __name__ == "__main__":
    sys.exit(main())
