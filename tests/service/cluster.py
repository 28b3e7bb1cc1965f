"""A deployment on this machine: a broker, API replicas and workers, each a process of its own.

Used by the tests and by ``tests/faults/cluster.py``. Every process begins a session, so that it can
be killed with all that it has started, as a machine that is lost.
"""

import contextlib
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import httpx

PATIENCE = 600
"""Seconds that end a test that hangs."""

COMMAND = f"""
import os, sys
import service.broker.celery_app as transport
import service.building.job_runner as job_runner
import service.storage.cloud as cloud
transport.RESEND_SECONDS = float(os.environ["RESEND"])
job_runner.LEASE_SECONDS = float(os.environ["LEASE"])
transport._CONNECT_SECONDS = transport._ANSWER_SECONDS = {PATIENCE}
cloud._CONNECT_SECONDS = cloud._SILENT_SECONDS = cloud._REQUEST_SECONDS = {PATIENCE}
from service.__main__ import main
sys.exit(main())
"""
"""Wait for a broker or a bucket that is there, however slow the machine is. Lease and resending are
those of the cluster."""

GATED = f"""
import os, sys
import service.building.process as process
process.WORKER_COMMAND = (sys.executable, "-c", '''
import os, sys, time
from service.building import worker
build = worker.build
def build_at_the_gate(*arguments):
    while os.path.exists(sys.argv[1]):
        time.sleep(0.02)
    build(*arguments)
worker.build = build_at_the_gate
worker.main()
''', os.environ["GATE"])
{COMMAND}"""
"""A worker whose builds begin, and wait as long as the gate of the cluster is closed."""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def listens(port):
    """Whether somebody listens on a port of this machine."""
    try:
        socket.create_connection(("127.0.0.1", port), PATIENCE).close()
    except OSError:
        return False
    return True


def until(condition, seconds=PATIENCE, pause=0.02):
    """Wait until a condition holds, and return its value."""
    deadline = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < deadline, f"not within {seconds} s: {condition}"
        time.sleep(pause)
    return value


class Process:
    """A process with its log, and all that it starts."""

    def __init__(self, command, environment, log):
        self.log_path = log
        self.client = None
        with log.open("ab") as output:
            self.popen = subprocess.Popen(
                command,
                env=environment,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    @property
    def running(self):
        return self.popen.poll() is None

    def log(self):
        return self.log_path.read_text(errors="replace")

    def logged(self, pattern):
        """The first group of a pattern in the log, waited for."""

        def found():
            match = re.search(pattern, self.log())
            assert match or self.running, self.log()
            return match

        return until(found)[1]

    def signal(self, number):
        """Send a signal to all of it."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.popen.pid, number)

    def kill(self):
        """End all of it at once, as a power cut does."""
        if self.client is not None:
            self.client.close()
        self.signal(signal.SIGKILL)
        self.popen.wait(PATIENCE)

    def stop(self):
        """End it as an operator does, and return its exit status."""
        self.popen.terminate()
        return self.popen.wait(PATIENCE)


class Cluster:
    """Processes that share a broker and a bucket.

    ``settings`` are those of all API replicas and workers; ``s3`` the environment that finds the
    bucket. By default no lease and no message is ever too old. Everything that still runs is killed
    by `close`.
    """

    def __init__(self, folder, s3, *, lease=3600, resend=3600, **settings):
        self.folder = folder
        self.port = free_port()
        url = f"redis://127.0.0.1:{self.port}/0"
        values = {"store": f"s3://bucket/{folder.name}", "broker": url, **settings}
        self.environment = {
            **{name: value for name, value in os.environ.items() if not name.startswith("GAMUT_")},
            **s3,
            **{f"GAMUT_{name.upper()}": str(value) for name, value in values.items()},
            "TMPDIR": str(folder),
            "GATE": str(folder / "closed"),
            "LEASE": str(lease),
            "RESEND": str(resend),
        }
        self.processes = []
        self.broker = None
        self.start_broker()

    @staticmethod
    def missing():
        """Why there can be no such cluster here; empty if there can."""
        return "" if shutil.which("redis-server") else "redis-server is not installed"

    def start_broker(self):
        """Start the broker, empty."""
        command = ["redis-server", "--port", str(self.port), "--bind", "127.0.0.1"]
        command += ["--save", "", "--appendonly", "no", "--dir", str(self.folder)]
        self.broker = self._started(command, dict(os.environ), "broker")
        until(self.broker_answers)
        return self.broker

    def broker_answers(self):
        assert self.broker.running, self.broker.log()
        return listens(self.port)

    def flush(self):
        """Have the broker lose all that it has."""
        command = ["redis-cli", "-p", str(self.port), "flushall"]
        subprocess.run(command, check=True, capture_output=True)

    def api(self):
        """Start an API replica, and return it when it answers."""
        replica = self._gamut("api", "serve", "--port", "0")
        replica.url = replica.logged(r"Uvicorn running on (http://127\.0\.0\.1:\d+)")
        replica.client = httpx.Client(base_url=replica.url, timeout=PATIENCE)
        return replica

    def worker(self, code=COMMAND, **settings):
        """Start a worker, with settings of its own; `figures` is where it serves its figures."""
        port = free_port()
        settings["worker_metrics_port"] = port
        process = self._gamut("worker", "worker", code=code, settings=settings)
        process.figures = f"http://127.0.0.1:{port}/metrics"
        return process

    @contextlib.contextmanager
    def closed_gate(self):
        """Keep the builds of workers with `GATED` from ending."""
        gate = Path(self.environment["GATE"])
        gate.touch()
        try:
            yield
        finally:
            gate.unlink()

    def close(self):
        for process in self.processes:
            process.kill()

    def _gamut(self, name, *arguments, code=COMMAND, settings=()):
        environment = self.environment | {
            f"GAMUT_{setting.upper()}": str(value) for setting, value in dict(settings).items()
        }
        command = [sys.executable, "-c", code, *arguments]
        return self._started(command, environment, f"{name}{len(self.processes)}")

    def _started(self, command, environment, name):
        process = Process(command, environment, self.folder / f"{name}.log")
        self.processes.append(process)
        return process
