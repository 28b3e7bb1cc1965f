"""The transport against real brokers: what a message is, how long a dead broker is waited for."""

import base64
import json
import signal
import subprocess
import time

import pytest
from cluster import Cluster, until

from service.broker.celery_app import (
    QUEUE,
    TASK,
    Broker,
    BrokerUnavailableError,
    build_limit,
    celery_app,
)
from service.settings import Settings

JOB = "a" * 64


def settings(url, **values):
    return Settings(store="s3://bucket/prefix", broker=url, **values)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """A Redis of its own."""
    if reason := Cluster.missing():
        pytest.skip(reason)
    started = Cluster(tmp_path_factory.mktemp("redis"), {})
    yield started
    started.close()


@pytest.fixture
def broker(cluster):
    cluster.flush()
    opened = Broker(celery_app(settings(cluster.environment["GAMUT_BROKER"])))
    yield opened
    opened.close()


def redis(cluster, *words):
    command = ["redis-cli", "-p", str(cluster.port), *words]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_what_is_sent_waits(broker):
    assert broker.waiting() == 0
    for _ in range(3):
        broker.send(JOB)
    assert broker.waiting() == 3


def test_a_message_is_the_id_of_a_job_and_nothing_else(cluster, broker):
    broker.send(JOB)
    message = json.loads(redis(cluster, "lrange", QUEUE, "0", "0"))
    args, kwargs, _ = json.loads(base64.b64decode(message["body"]))
    assert (args, kwargs) == ([JOB], {})
    assert message["headers"]["task"] == TASK
    assert message["content-type"] == "application/json"


def test_an_autoscaler_sees_the_queue_under_its_name(cluster, broker):
    broker.send(JOB)
    assert redis(cluster, "llen", QUEUE).strip() == "1"


def test_a_broker_that_was_flushed_takes_messages_as_before(cluster, broker):
    broker.send(JOB)
    cluster.flush()
    assert broker.waiting() == 0
    broker.send(JOB)
    assert broker.waiting() == 1


def test_a_broker_that_was_started_again_takes_messages_as_before(cluster, broker):
    broker.send(JOB)
    cluster.broker.kill()
    cluster.start_broker()
    assert broker.waiting() == 0
    broker.send(JOB)
    assert broker.waiting() == 1


@pytest.mark.parametrize("url", ["redis://127.0.0.1:1/0", "amqp://127.0.0.1:1//"])
def test_a_broker_that_is_not_there_is_told_within_seconds(url):
    broker = Broker(celery_app(settings(url)))
    for call in (broker.waiting, lambda: broker.send(JOB)):
        started = time.monotonic()
        with pytest.raises(BrokerUnavailableError):
            call()
        assert time.monotonic() - started < 5
    broker.close()


def test_a_broker_that_hangs_is_told_within_seconds(cluster, broker):
    broker.send(JOB)
    cluster.broker.signal(signal.SIGSTOP)
    try:
        started = time.monotonic()
        with pytest.raises(BrokerUnavailableError):
            broker.waiting()
        assert time.monotonic() - started < 10
    finally:
        cluster.broker.signal(signal.SIGCONT)
    until(lambda: broker.waiting() >= 1, 10)


@pytest.mark.parametrize("scheme", ["redis", "rediss", "amqp", "amqps"])
def test_messages_are_kept_until_the_build_is_over(scheme):
    conf = celery_app(settings(f"{scheme}://broker/", build_timeout=100)).conf
    assert conf.task_acks_late
    assert conf.task_reject_on_worker_lost
    assert conf.worker_prefetch_multiplier == 1
    assert conf.task_time_limit > 100
    assert conf.result_backend is None
    assert conf.task_ignore_result
    assert conf.accept_content == ["json"]


def test_redis_hands_a_message_out_again_when_its_build_cannot_be_running_any_more():
    chosen = settings("redis://broker/0", build_timeout=100)
    options = celery_app(chosen).conf.broker_transport_options
    assert build_limit(chosen) < options["visibility_timeout"] < build_limit(chosen) + 60


def test_rabbitmq_keeps_messages_in_a_quorum_queue_and_confirms_them():
    conf = celery_app(settings("amqp://broker//")).conf
    (queue,) = conf.task_queues
    assert queue.queue_arguments["x-queue-type"] == "quorum"
    assert queue.queue_arguments["x-delivery-limit"] > Settings().build_attempts
    assert conf.broker_transport_options["confirm_publish"] is True


def test_rabbitmq_itself_takes_all_that(tmp_path):
    if reason := Cluster.missing("rabbitmq"):
        pytest.skip(f"{reason}; tests/faults/cluster.py --broker rabbitmq does more")
    cluster = Cluster(tmp_path, {}, "rabbitmq")
    try:
        broker = Broker(celery_app(settings(cluster.environment["GAMUT_BROKER"])))
        assert broker.waiting() == 0
        broker.send(JOB)
        assert until(broker.waiting, 10) == 1
        broker.close()
    finally:
        cluster.close()
