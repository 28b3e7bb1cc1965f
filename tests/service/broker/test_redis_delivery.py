"""Against a real Redis that stalls: kombu's own counting would wait for ever."""

import signal

import pytest
from cluster import Cluster
from kombu import Connection, Consumer, Queue
from kombu.transport.redis import Channel

from service.broker.redis_delivery import count_deliveries_patiently


@pytest.fixture
def cluster(tmp_path):
    if reason := Cluster.missing():
        pytest.skip(reason)
    started = Cluster(tmp_path, {})
    yield started
    started.close()


@pytest.mark.parametrize("end", ["ack", "reject", "requeue"])
def test_a_redis_that_stalls_at_the_end_of_a_message_costs_no_slot(cluster, monkeypatch, end):
    monkeypatch.setattr(Channel, "QoS", Channel.QoS)
    count_deliveries_patiently()
    queue = Queue("queue")
    with Connection(
        cluster.environment["GAMUT_BROKER"], transport_options={"socket_timeout": 0.5}
    ) as connection:
        with connection.Producer() as producer:
            for number in range(2):
                producer.publish(number, routing_key="queue", declare=[queue])
        taken = []
        with Consumer(connection, queue, on_message=taken.append, prefetch_count=1):
            connection.drain_events(timeout=5)
            cluster.broker.signal(signal.SIGSTOP)
            with pytest.raises(connection.connection_errors):
                getattr(taken[0], end)()
            cluster.broker.signal(signal.SIGCONT)
            connection.drain_events(timeout=5)
            taken[1].ack()
        assert [message.payload for message in taken] == [0, 1]
