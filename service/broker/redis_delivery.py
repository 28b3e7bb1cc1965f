"""Redis transport of kombu that frees a slot even if Redis does not confirm in time.

With Redis, a worker counts its unacknowledged messages. Kombu 5.6 decreases the count only after
Redis has confirmed. If Redis stalls at that moment, Celery logs ``Couldn't ack``. The process then
never gets another message, although its connection and health check look fine. Here the count
always decreases. Redis delivers the message again after the visibility timeout, which costs one
read of an ended job.
"""

from __future__ import annotations

from kombu.transport.redis import Channel, QoS
from kombu.transport.virtual import QoS as Count

__all__ = ["PatientQoS", "count_deliveries_patiently"]


class PatientQoS(QoS):
    """Counts unacknowledged messages."""

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
    """Let all later connections of this process count with `PatientQoS`.

    Kombu creates channels by URL scheme and offers no other hook.
    """
    Channel.QoS = PatientQoS
