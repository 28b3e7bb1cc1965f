"""A server process with a new directory, for the programs of this folder."""

import contextlib
import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "service"))

from servers import PATIENCE, Server

__all__ = ["PATIENCE", "Serving", "serving"]


class Serving(Server):
    """A server whose memory is watched."""

    @property
    def port(self):
        return self.client.base_url.port

    def resident(self):
        """Return the resident memory of the process in bytes."""
        pages = int(Path(f"/proc/{self.process.pid}/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")

    def reset_peak(self):
        """Let `peak` begin anew (proc(5), clear_refs)."""
        Path(f"/proc/{self.process.pid}/clear_refs").write_text("5")

    def peak(self):
        """Return the largest resident memory of the process in bytes since the last reset."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.partition("VmHWM:")[2].split()[0]) * 1024


@contextlib.contextmanager
def serving(**settings):
    """Start a server with settings, wait until it is ready, and stop it at the end."""
    with tempfile.TemporaryDirectory() as folder:
        server = Serving(Path(folder) / "data", Path(folder) / "log", **settings)
        try:
            server.wait_ready()
            yield server
        finally:
            server.end()
