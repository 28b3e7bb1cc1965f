"""``gamut worker``: takes jobs from the broker and builds them, each in a thread.

A thread waits for its build process (`service.building.process`), which can be killed. The clients
of waiting jobs take turns: a thread may run another job than that of its message. It first sends
the message's job again, so every waiting job has a message at any time.

After SIGTERM no message is taken, and running builds may finish for ``drain_seconds``. The other
jobs are given back and sent again. If the process is killed, the leases of its jobs end, and
another worker sends them again.
"""

from __future__ import annotations

import contextlib
import logging
import os
import random
import signal
import socket
import sys
import threading
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue

from celery import signals
from celery.exceptions import Reject

from service.broker.celery_app import (
    RESEND_SECONDS,
    TASK,
    Broker,
    BrokerUnavailableError,
    Outbox,
    celery_app,
)
from service.building.engine import BuildReport, FairQueue
from service.building.job_runner import Interruption, JobRunner, Outcome
from service.building.process import WORKER_COMMAND, ProcessDiedError
from service.jobs.book import JobBook
from service.settings import Settings
from service.storage import StoreLocationError, store_at
from service.storage.blobs import StoreUnavailableError
from service.storage.gamut_store import GamutStore
from service.telemetry.logs import complain
from service.telemetry.metrics import serve_metrics

__all__ = ["Worker", "check_worker", "run_worker"]

logger = logging.getLogger(__name__)

_HEARTBEAT_SECONDS = 1.0
"""Interval of renewals: the resolution of the progress, and the delay of a cancellation."""

_SWEEP_SECONDS = 5.0
"""Mean interval of looking for lost jobs."""

_RETRY_SECONDS = 2.0
"""Delay before a job that could not be claimed goes back to the queue."""


class Worker:
    """Runs the jobs of messages, with one `JobRunner` for each thread of the process."""

    def __init__(
        self,
        settings: Settings,
        store: GamutStore,
        broker: Broker,
        *,
        command: Sequence[str] = WORKER_COMMAND,
        on_build: BuildReport | None = None,
    ) -> None:
        book = JobBook.of_store(store)
        self._settings = settings
        self._broker = broker
        self.outbox = Outbox(store.blobs, book)
        self.interruption = Interruption()
        self.runners = [
            JobRunner(
                settings,
                store,
                book,
                heartbeat=_HEARTBEAT_SECONDS,
                command=command,
                on_build=on_build,
            )
            for _ in range(settings.build_workers)
        ]
        self._idle: SimpleQueue[JobRunner] = SimpleQueue()
        for runner in self.runners:
            self._idle.put(runner)
        self._choosing = threading.Lock()
        self._queue = FairQueue()

    def warm(self) -> None:
        """Start all build processes.

        Raise `ProcessDiedError` or OSError if one cannot be started.
        """
        with ThreadPoolExecutor(len(self.runners)) as threads:
            list(threads.map(lambda runner: runner.warm(self.interruption.check), self.runners))

    def close(self) -> None:
        """End all build processes."""
        for runner in self.runners:
            runner.close()

    def run(self, job_id: str) -> Outcome:
        """Run the job of a message, or the waiting job whose turn it is; return the outcome.

        After `StoreUnavailableError`, `ProcessDiedError` and OSError, the job was not started and
        must be delivered again.
        """
        runner = self._idle.get()
        try:
            with self._choosing:
                job_id = self._turn(job_id)
            return self._run(runner, job_id)
        finally:
            self._idle.put(runner)

    def _turn(self, job_id: str) -> str:
        """Return the job to run instead of a message's job, which is then sent again."""
        # An ended job costs one read, and an empty queue has no turns.
        if not (self.outbox.waits(job_id) and self._others_wait()):
            return job_id
        marked, new = self.outbox.waiting(known=set(self._queue))
        for gone in set(self._queue) - marked:
            self._queue.discard(gone)
        for document in new:
            self._queue.put(document)
        while (chosen := self._queue.take(job_id)) is not None and chosen.id != job_id:
            if self.outbox.waits(chosen.id):  # no other thread or process has taken it
                return chosen.id if self._send(job_id) else job_id
        return job_id

    def _others_wait(self) -> bool:
        try:
            return self._broker.waiting() > 0
        except BrokerUnavailableError:
            return False

    def _run(self, runner: JobRunner, job_id: str) -> Outcome:
        outcome = runner.run(job_id, self.interruption)
        document = outcome.document
        if outcome.state == "released":
            self._send(job_id)
        elif outcome.state != "unwritten" and (document is None or document.final):
            try:
                self.outbox.remove(job_id)
            except (StoreUnavailableError, OSError) as error:
                logger.warning("mark of %s could not be removed yet: %s", job_id, error)
        return outcome

    def _send(self, job_id: str) -> bool:
        """Send a job and return whether it was sent. If not, the next `sweep` finds it."""
        try:
            self._broker.send(job_id)
        except BrokerUnavailableError as error:
            logger.warning("%s could not be sent: %s", job_id, error)
            return False
        return True

    def sweep(self) -> int:
        """Send the jobs whose messages were lost, and return their number.

        While other jobs wait in the queue, an unstarted job may just be behind them, and gets the
        time of one more build. A superfluous message costs one read of the job's document.
        """
        silence = RESEND_SECONDS
        if self._broker.waiting():
            silence += self._settings.build_timeout
        count = 0
        for job_id in self.outbox.overdue(silence):
            logger.warning("message of %s was lost and is sent again", job_id)
            self._broker.send(job_id)
            count += 1
        return count

    def sweep_forever(self) -> None:
        """Sweep repeatedly, at random intervals, so that workers do not sweep in step."""
        while True:
            time.sleep(_SWEEP_SECONDS * random.uniform(0.5, 1.5))  # noqa: S311 - no secret
            try:
                self.sweep()
            except (StoreUnavailableError, BrokerUnavailableError, OSError) as error:
                logger.warning("lost jobs could not be looked up: %s", error)
            except Exception:
                logger.exception("unexpected error while looking for lost jobs")


def run_worker(settings: Settings) -> int:
    """Take jobs and run them until the process is stopped; return the exit status."""
    with contextlib.ExitStack() as closing:
        try:
            store = store_at(settings.store, keep_inputs=settings.keep_inputs)
            closing.callback(store.close)
            store.open()
        except (StoreLocationError, StoreUnavailableError, OSError) as error:
            complain(str(error))
            return 1
        on_build = None
        if settings.worker_metrics_port:
            try:
                metrics, _, stop = serve_metrics(settings.host, settings.worker_metrics_port)
            except OSError as error:
                complain(f"GAMUT_WORKER_METRICS_PORT: {error.strerror}")
                return 1
            on_build = metrics.count_build
            closing.callback(stop)
        broker = Broker(settings)
        closing.callback(broker.close)
        worker = Worker(settings, store, broker, on_build=on_build)
        closing.callback(worker.close)

        def stop_starting(*_: object) -> None:
            worker.interruption.release()
            sys.exit()

        signal.signal(signal.SIGTERM, stop_starting)  # until Celery's own handler
        try:
            worker.warm()
        except (ProcessDiedError, OSError) as error:
            complain(f"build worker did not start: {error}")
            return 1
        threading.Thread(target=worker.sweep_forever, daemon=True).start()
        return _serve(settings, worker)


def _serve(settings: Settings, worker: Worker) -> int:
    """Run Celery's worker until the process is stopped; return the exit status."""
    app = celery_app(settings)

    def build(job_id: str) -> None:
        try:
            worker.run(job_id)
        except (StoreUnavailableError, ProcessDiedError, OSError) as error:
            logger.warning("%s goes back to the queue: %s", job_id, error)
            time.sleep(_RETRY_SECONDS)
            raise Reject(str(error), requeue=True) from error

    def drain(**_: object) -> None:
        logger.info("draining: no more jobs, %g s for running builds", settings.drain_seconds)
        release = threading.Timer(settings.drain_seconds, worker.interruption.release)
        release.daemon = True
        release.start()

    def leave_logging(**_: object) -> None:
        """Keep Celery from configuring the log."""

    app.task(name=TASK)(build)
    signals.setup_logging.connect(leave_logging, weak=False)
    signals.worker_shutting_down.connect(drain, weak=False)
    # Celery's signal handlers write plain text to standard output. The log is on standard error.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    celery_worker = app.Worker(
        hostname=_node_name(),
        pool="threads",
        concurrency=settings.build_workers,
        without_mingle=True,
        without_gossip=True,
        without_heartbeat=True,
        quiet=True,
    )
    celery_worker.start()
    return int(celery_worker.exitcode or 0)


def check_worker(settings: Settings) -> str | None:
    """Ping the worker of this host through the broker; return the fault if there is one."""
    broker = Broker(settings)
    try:
        answers = broker.ping(_node_name())
    except BrokerUnavailableError:
        return "the broker does not answer"
    finally:
        broker.close()
    return None if answers else "no worker on this host answers its broker"


def _node_name() -> str:
    """Name of the worker in the deployment, for ``celery inspect``."""
    return f"gamut@{socket.gethostname()}"
