"""The transport against real brokers: what a message is, how long a dead broker is waited for."""

import base64
import json
import signal
import subprocess

import pytest
from cluster import Cluster, until
from kombu import Connection, Consumer, Queue
from kombu.transport.redis import Channel
from redis import Connection as Redis

from service.broker.celery_app import (
    QUEUE,
    TASK,
    Broker,
    BrokerUnavailableError,
    build_limit,
    celery_app,
)
from service.broker.celery_worker import count_deliveries_patiently

JOB = "a" * 64


def redis(cluster, *words):
    command = ["redis-cli", "-p", str(cluster.port), *words]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_a_message_is_the_id_of_a_job_in_a_queue_that_autoscalers_find(cluster, broker):
    assert broker.waiting() == 0
    for number in range(3):
        broker.send(JOB)
        assert broker.waiting() == number + 1
    assert redis(cluster, "llen", QUEUE).strip() == "3"
    message = json.loads(redis(cluster, "lrange", QUEUE, "0", "0"))
    args, kwargs, _ = json.loads(base64.b64decode(message["body"]))
    assert (args, kwargs) == ([JOB], {})
    assert message["headers"]["task"] == TASK
    assert message["content-type"] == "application/json"


def test_a_broker_that_was_flushed_or_started_again_takes_messages_as_before(cluster, broker):
    def restart():
        cluster.broker.kill()
        cluster.start_broker()

    for loss in (cluster.flush, restart):
        broker.send(JOB)
        loss()
        assert broker.waiting() == 0
        broker.send(JOB)
        assert broker.waiting() == 1


@pytest.mark.parametrize("url", ["redis://127.0.0.1:1/0", "amqp://127.0.0.1:1//"])
def test_a_broker_that_is_not_there_is_told(settings, url):
    broker = Broker(celery_app(settings(url)))
    for call in (broker.waiting, lambda: broker.send(JOB)):
        with pytest.raises(BrokerUnavailableError):
            call()
    broker.close()


def test_a_broker_that_hangs_is_told_and_asked_again(cluster, settings):
    cluster.flush()
    broker = Broker(celery_app(settings(cluster.environment["GAMUT_BROKER"])))
    until(lambda: sent(broker))
    cluster.broker.signal(signal.SIGSTOP)
    try:
        with pytest.raises(BrokerUnavailableError):
            broker.waiting()
    finally:
        cluster.broker.signal(signal.SIGCONT)
    until(lambda: sent(broker))
    broker.close()


def sent(broker):
    """Whether a message arrived; a slow machine may take longer than the broker is given."""
    try:
        broker.send(JOB)
        return broker.waiting() >= 1
    except BrokerUnavailableError:
        return False


@pytest.mark.parametrize("end", ["ack", "reject", "requeue"])
def test_a_redis_that_stalls_at_the_end_of_a_message_costs_no_slot(cluster, monkeypatch, end):
    """Kombu's own counting would wait for ever."""
    monkeypatch.setattr(Channel, "QoS", Channel.QoS)
    count_deliveries_patiently()
    cluster.flush()
    queue = Queue("queue")
    read = Redis.read_response

    def read_soon(connection, *arguments, **named):
        return read(connection, *arguments, **{**named, "timeout": 0.1})

    url = cluster.environment["GAMUT_BROKER"]
    with Connection(url, transport_options={"socket_timeout": 600}) as connection:
        with connection.Producer() as producer:
            for number in range(2):
                producer.publish(number, routing_key="queue", declare=[queue])
        taken = []
        with Consumer(connection, queue, on_message=taken.append, prefetch_count=1):
            connection.drain_events(timeout=600)
            cluster.broker.signal(signal.SIGSTOP)
            try:
                # Nothing answers now, so no machine is too slow for this limit.
                with monkeypatch.context() as patch:
                    patch.setattr(Redis, "read_response", read_soon)
                    with pytest.raises(connection.connection_errors):
                        getattr(taken[0], end)()
            finally:
                cluster.broker.signal(signal.SIGCONT)
            connection.drain_events(timeout=600)
            taken[1].ack()
        assert [message.payload for message in taken] == [0, 1]


@pytest.mark.parametrize(
    "url", ["redis://broker/0", "rediss://broker/0", "amqp://broker//", "amqps://broker//"]
)
def test_messages_are_kept_until_the_build_cannot_be_running_any_more(settings, url):
    chosen = settings(url, build_timeout=100)
    conf = celery_app(chosen).conf
    assert conf.task_acks_late
    assert conf.task_reject_on_worker_lost
    assert conf.worker_prefetch_multiplier == 1
    assert conf.task_time_limit == build_limit(chosen) > 100
    assert conf.result_backend is None
    assert conf.task_ignore_result
    assert conf.accept_content == ["json"]
    options, (queue,) = conf.broker_transport_options, conf.task_queues
    if url.startswith("redis"):
        assert build_limit(chosen) < options["visibility_timeout"] < build_limit(chosen) + 60
    else:
        assert queue.queue_arguments["x-queue-type"] == "quorum"
        assert queue.queue_arguments["x-delivery-limit"] > chosen.build_attempts
        assert options["confirm_publish"] is True


@pytest.mark.usefixtures("patient")
def test_rabbitmq_itself_takes_all_that(settings, tmp_path):
    if reason := Cluster.missing("rabbitmq"):
        pytest.skip(f"{reason}; tests/faults/cluster.py --broker rabbitmq does more")
    cluster = Cluster(tmp_path, {}, "rabbitmq")
    try:
        broker = Broker(celery_app(settings(cluster.environment["GAMUT_BROKER"])))
        assert broker.waiting() == 0
        broker.send(JOB)
        assert until(broker.waiting) == 1
        broker.close()
    finally:
        cluster.close()
