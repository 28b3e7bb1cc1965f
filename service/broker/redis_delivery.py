"""Redis as kombu's transport, with a slot that is free again when Redis did not answer in time.

With Redis a worker may have as many messages as it has processes, and counts them itself. Kombu
(5.6) takes one out of that count only after Redis has confirmed that it is done with. Where Redis
stalls for longer than the timeout in that very moment, Celery logs ``Couldn't ack``, and the
process would never get another message, though its connection stands and its health check finds
nothing wrong. Here the message is out of the count whatever Redis says. Redis hands it out once
more after the visibility timeout, which costs a look at a job that is over.
"""

from __future__ import annotations

from kombu.transport.redis import Channel, QoS
from kombu.transport.virtual import QoS as Count

__all__ = ["PatientQoS", "count_deliveries_patiently"]


class PatientQoS(QoS):
    """Counts the messages that were delivered and are not done with."""

    def ack(self, delivery_tag: str) -> None:
        """Tell Redis that a message is done with; it is not counted any more in any case."""
        try:
            super().ack(delivery_tag)
        except Exception:
            Count.ack(self, delivery_tag)
            raise

    def reject(self, delivery_tag: str, requeue: bool = False) -> None:
        """Give a message back or drop it; it is not counted any more in any case."""
        try:
            super().reject(delivery_tag, requeue=requeue)
        except Exception:
            Count.ack(self, delivery_tag)
            raise


def count_deliveries_patiently() -> None:
    """Have all connections of this process that are made from now on count in this way.

    Kombu makes its channels by the name of the scheme, and offers no other place for it.
    """
    Channel.QoS = PatientQoS
