"""The transport against a real Redis: what a message is, how long a dead broker is waited for."""

import base64
import json
import signal
import subprocess

import pytest
from cluster import until

from service.broker.celery_app import QUEUE, TASK, Broker, BrokerUnavailableError, celery_app

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


def test_a_broker_that_is_not_there_is_told(settings):
    broker = Broker(settings("redis://127.0.0.1:1/0"))
    for call in (broker.waiting, lambda: broker.send(JOB)):
        with pytest.raises(BrokerUnavailableError):
            call()
    broker.close()


def test_a_broker_that_hangs_is_told_and_asked_again(cluster, settings):
    cluster.flush()
    broker = Broker(settings(cluster.environment["GAMUT_BROKER"]))
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


@pytest.mark.parametrize("url", ["redis://broker/0", "rediss://broker/0"])
def test_messages_are_kept_until_the_build_cannot_be_running_any_more(settings, url):
    conf = celery_app(settings(url, build_timeout=100.5)).conf
    assert conf.task_acks_late
    assert conf.task_reject_on_worker_lost
    assert conf.worker_prefetch_multiplier == 1
    assert conf.task_ignore_result
    assert 100.5 < conf.broker_transport_options["visibility_timeout"] < 200
