"""``gamut worker``: takes jobs from the broker and runs them, one per process at a time.

The clients of waiting jobs take turns. A slot may run another job than the job of its message. It
first sends the message's job again, so every waiting job has a message at any time.

Celery's main process talks to the broker and never opens the store, because the store client's
threads would not survive a fork. Each forked process has a `JobRunner` with a warm build process. A
hard time limit kills a stuck slot; the job's lease then ends, and the job is sent again. After
SIGTERM no message is taken, and running builds may finish for ``drain_seconds``. The other jobs are
given back and sent again.
"""

from __future__ import annotations

import contextlib
import logging
import mmap
import multiprocessing
import os
import random
import signal
import socket
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import billiard
import celery.apps.worker
from celery import bootsteps, signals
from celery.exceptions import Reject
from celery.worker.consumer import Consumer
from kombu.transport.redis import Channel, QoS
from kombu.transport.virtual import QoS as Count

from service.broker.celery_app import TASK, Broker, BrokerUnavailableError, Outbox, celery_app
from service.broker.health import SIGN_SECONDS, leave, sign
from service.building.engine import BuildReport, FairQueue
from service.building.job_runner import Interruption, JobRunner, Outcome
from service.building.process import ProcessDiedError
from service.jobs.book import JobBook
from service.settings import Settings
from service.storage import StoreLocationError, gamut_store
from service.storage.blobs import StoreUnavailableError
from service.storage.gamuts import GamutStore
from service.telemetry.build_reports import BuildReports
from service.telemetry.logs import complain
from service.telemetry.metrics import serve_metrics

__all__ = ["Slot", "count_deliveries_patiently", "run_worker"]

logger = logging.getLogger(__name__)

_HEARTBEAT_SECONDS = 1.0
"""Interval of renewals: the resolution of the progress, and the delay of a cancellation."""

_SWEEP_SECONDS = 5.0
"""Mean interval of looking for lost jobs."""

_RETRY_SECONDS = 2.0
"""Delay before a job that could not be claimed goes back to the queue."""

_START_SECONDS = 600.0
"""Time limit for the start of a slot, during which the store may be unavailable."""

_FIRST_LOOK_SECONDS = 120.0
"""Time limit of the first access to the store, retries included."""

_LOOK_SECONDS = 0.5
"""Interval of checking a slot's build process."""


class Slot:
    """State of one worker process, made after the fork."""

    def __init__(
        self,
        settings: Settings,
        store: GamutStore,
        broker: Broker,
        on_build: BuildReport | None = None,
    ) -> None:
        book = JobBook.of_store(store, settings.build_attempts)
        self._settings = settings
        self._broker = broker
        self.outbox = Outbox(store.blobs, book)
        self.interruption = Interruption()
        self.runner = JobRunner(
            settings,
            store,
            book,
            heartbeat=_HEARTBEAT_SECONDS,
            lease=settings.build_lease,
            on_build=on_build,
        )
        self._busy = threading.Lock()
        self._queue = FairQueue()

    def run(self, job_id: str) -> Outcome:
        """Run the job of a message, or the waiting job whose turn it is; return the outcome.

        After `StoreUnavailableError`, `ProcessDiedError` and OSError, the job was not started and
        must be delivered again.
        """
        with self._busy:
            return self._run(self._turn(job_id))

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
            if self.outbox.waits(chosen.id):  # no other process has taken it
                return chosen.id if self.send(job_id) else job_id
        return job_id

    def _others_wait(self) -> bool:
        try:
            return self._broker.waiting() > 0
        except BrokerUnavailableError:
            return False

    def _run(self, job_id: str) -> Outcome:
        outcome = self.runner.run(job_id, self.interruption)
        document = outcome.document
        if outcome.state == "released":
            self.send(job_id)
        elif outcome.state != "unwritten" and (document is None or document.final):
            try:
                self.outbox.remove(job_id)
            except (StoreUnavailableError, OSError) as error:
                logger.warning("mark of %s could not be removed yet: %s", job_id, error)
        return outcome

    def send(self, job_id: str) -> bool:
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
        silence = self._settings.resend_seconds
        if self._broker.waiting():
            silence += self._settings.build_timeout
        count = 0
        for job_id in self.outbox.overdue(silence):
            logger.warning("message of %s was lost and is sent again", job_id)
            self._broker.send(job_id)
            count += 1
        return count

    def keep_warm(self, report: Callable[[bool], None]) -> None:
        """Start the build process whenever there is none, as long as this process lives.

        `report` receives repeatedly whether the process is warm.
        """
        while True:
            # In a busy slot, the runner starts the process.
            if self.runner.process is None and self._busy.acquire(blocking=False):
                try:
                    report(False)
                    self.runner.warm()
                except Exception as error:
                    if isinstance(error, ProcessDiedError | OSError):  # no defect
                        logger.error("build worker did not start: %s", error)  # noqa: TRY400
                    else:
                        logger.exception("build worker did not start")
                    time.sleep(_RETRY_SECONDS)
                finally:
                    self._busy.release()
            report(self.runner.process is not None)
            time.sleep(_LOOK_SECONDS)

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


class _Sign(bootsteps.StartStopStep):
    """Writes the worker's heartbeat file while its connection to the broker is open."""

    requires = ("celery.worker.consumer.tasks:Tasks",)

    def __init__(self, parent: Any, **options: Any) -> None:  # noqa: ANN401 - Celery's
        super().__init__(parent, **options)
        self._timer: Any = None

    def start(self, parent: Any) -> None:  # noqa: ANN401
        """Start writing: the connection is open."""
        slots, count = parent.app.slots

        def write() -> None:
            sign(sum(slots[:count]), count)

        write()
        self._timer = parent.timer.call_repeatedly(SIGN_SECONDS, write)

    def stop(self, parent: Any) -> None:  # noqa: ANN401, ARG002
        """Stop writing: the connection is lost, or the worker ends."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        leave()


class _PlainConsumer(Consumer):
    """Celery's consumer with only the steps that this task needs.

    Delayed delivery would declare 28 exchanges and queues in RabbitMQ.
    """

    class Blueprint(Consumer.Blueprint):
        """The steps of the consumer."""

        default_steps = [  # noqa: RUF012 - as Celery declares it
            "celery.worker.consumer.connection:Connection",
            "celery.worker.consumer.mingle:Mingle",
            "celery.worker.consumer.tasks:Tasks",
            "celery.worker.consumer.consumer:Evloop",
        ]


class _PatientQoS(QoS):
    """Counts unacknowledged messages of Redis, also if it does not confirm in time.

    Kombu 5.6 decreases the count only after Redis has confirmed. If Redis stalls at that moment,
    Celery logs ``Couldn't ack``. The process then never gets another message, although its
    connection and health check look fine. Here the count always decreases. Redis delivers the
    message again after the visibility timeout, which costs one read of an ended job.
    """

    def ack(self, delivery_tag: str) -> None:
        """Acknowledge a message, which no longer counts in any case."""
        try:
            super().ack(delivery_tag)
        except Exception:
            Count.ack(self, delivery_tag)
            raise

    def reject(self, delivery_tag: str, requeue: bool = False) -> None:
        """Reject a message, which no longer counts in any case."""
        try:
            super().reject(delivery_tag, requeue=requeue)
        except Exception:
            Count.ack(self, delivery_tag)
            raise


def count_deliveries_patiently() -> None:
    """Let all later connections of this process count with `_PatientQoS`.

    Kombu creates channels by URL scheme and offers no other hook.
    """
    Channel.QoS = _PatientQoS


def run_worker(settings: Settings) -> int:
    """Take jobs and run them until the process is stopped; return the exit status."""
    reports = BuildReports()
    fault = _store_fault(settings)
    if fault is None:
        fault = _metrics_fault(settings, reports) if settings.worker_metrics_port else None
    if fault is not None:
        complain(fault)
        return 1
    app = celery_app(settings)
    count_deliveries_patiently()
    slots = mmap.mmap(-1, mmap.PAGESIZE)  # shared with the processes that are forked
    app.slots = (slots, settings.build_workers)
    app.conf.worker_consumer = _PlainConsumer
    app.conf.worker_proc_alive_timeout = _START_SECONDS
    app.steps["consumer"].add(_Sign)
    slot: list[Slot] = []
    closing = contextlib.ExitStack()

    def start_slot(**_: object) -> None:
        number = billiard.current_process().index
        slots[number] = False  # an earlier process may have left True
        on_build = reports.count_build if settings.worker_metrics_port else None
        slot[:] = [Slot(settings, _open_store(settings), Broker(app), on_build)]
        closing.callback(slot[0].runner.close)
        _in_background(slot[0].keep_warm, lambda warm: slots.__setitem__(number, warm))
        if number == 0:
            _in_background(slot[0].sweep_forever)

    @app.task(name=TASK)
    def build(job_id: str) -> None:
        # Set here, because the pool overwrites handlers before the first task.
        idle = signal.signal(signal.SIGTERM, lambda *_: slot[0].interruption.release())
        try:
            slot[0].run(job_id)
        except (StoreUnavailableError, ProcessDiedError, OSError) as error:
            logger.warning("%s goes back to the queue: %s", job_id, error)
            time.sleep(_RETRY_SECONDS)
            raise Reject(str(error), requeue=True) from error
        finally:
            signal.signal(signal.SIGTERM, idle)

    celery.apps.worker.safe_say = _say
    signals.setup_logging.connect(_leave_logging, weak=False)
    signals.worker_process_init.connect(start_slot, weak=False)
    signals.worker_process_shutdown.connect(lambda **_: closing.close(), weak=False)
    worker = app.Worker(
        hostname=f"{socket.gethostname()}-{os.getpid()}",
        concurrency=settings.build_workers,
        pool="prefork",
        without_mingle=True,
        without_gossip=True,
        without_heartbeat=True,
        quiet=True,
    )

    def drain(**_: object) -> None:
        logger.info("draining: no more jobs, %g s for running builds", settings.drain_seconds)
        leave()
        waiting = threading.Timer(settings.drain_seconds, _release_all, (worker,))
        waiting.daemon = True
        waiting.start()

    signals.worker_shutting_down.connect(drain, weak=False)
    try:
        worker.start()
    finally:
        leave()
    return int(worker.exitcode or 0)


def _store_fault(settings: Settings) -> str | None:
    """Return why the store cannot be used; None if it can."""

    def look(answer: Callable[[str | None], None]) -> None:
        try:
            store = gamut_store(settings.store, keep_inputs=settings.keep_inputs)
            store.open()
            store.close()
            answer(None)
        except (StoreLocationError, StoreUnavailableError, OSError) as error:
            answer(str(error))

    return _answer_of_fork(look, "checked the store", _FIRST_LOOK_SECONDS)


def _metrics_fault(settings: Settings, reports: BuildReports) -> str | None:
    """Serve the worker's metrics in a process that ends with this one.

    Return why they cannot be served; None if they are.
    """
    worker = os.getpid()
    descriptors = os.open("/proc/self/fd", os.O_RDONLY) if Path("/proc/self/fd").exists() else None

    def serve(answer: Callable[[str | None], None]) -> None:
        # Ctrl-C reaches the whole process group.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            host, port = settings.host, settings.worker_metrics_port
            metrics, _, _ = serve_metrics(host, port, str(worker), descriptors)
        except OSError as error:
            answer(f"GAMUT_WORKER_METRICS_PORT: {error.strerror}")
            return
        reports.forward(metrics)
        answer(None)
        while os.getppid() == worker:
            time.sleep(1.0)

    fault = _answer_of_fork(serve, "serves the metrics")
    if descriptors is not None:
        os.close(descriptors)
    return fault


def _answer_of_fork(
    work: Callable[[Callable[[str | None], None]], None], task: str, seconds: float | None = None
) -> str | None:
    """Run `work` in a forked process, and return its answer: a fault or None.

    Work that starts threads must not run here, because a process with threads must not fork. A
    process that has a time limit is over at the return.
    """
    context = multiprocessing.get_context("fork")
    receiving, sending = context.Pipe(duplex=False)
    process = context.Process(target=work, args=(sending.send,), name=task, daemon=True)
    process.start()
    sending.close()
    try:
        if receiving.poll(seconds):
            answer: str | None = receiving.recv()
        else:
            process.kill()
            answer = f"the store did not answer within {seconds:g} s"
    except EOFError:
        answer = f"the process that {task} died"
    if seconds is not None:
        process.join()
    return answer


def _open_store(settings: Settings) -> GamutStore:
    """Return the store as soon as it can be opened."""
    store = gamut_store(settings.store, keep_inputs=settings.keep_inputs)
    while True:
        try:
            store.open()
        except (StoreUnavailableError, OSError) as error:
            logger.error("the store is unavailable: %s", error)  # noqa: TRY400 - no defect
            time.sleep(_RETRY_SECONDS)
        else:
            return store


def _in_background(function: Callable[..., None], *arguments: object) -> None:
    threading.Thread(target=function, args=arguments, daemon=True).start()


def _leave_logging(**_: object) -> None:
    """Keep Celery from configuring the log, and from logging each task."""
    for name in ("celery.app.trace", "celery.worker.strategy"):
        logging.getLogger(name).setLevel(logging.WARNING)


def _say(text: str, *_: object) -> None:
    """Log the plain text that Celery would write to standard output in its signal handlers."""
    logger.info("%s", text.strip())


def _release_all(worker: Any) -> None:  # noqa: ANN401 - Celery's
    """Tell every slot to give back its build, unless all have ended."""
    try:
        processes = worker.pool.info["processes"]
    except AttributeError:  # the pool has ended
        return
    for process in processes:
        logger.info("process %d must give back its build", process)
        try:
            os.kill(process, signal.SIGTERM)
        except ProcessLookupError:
            continue
