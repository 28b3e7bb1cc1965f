"""A broker and a bucket that the tests of this folder share."""

import pytest
from cluster import Cluster

from service.broker import celery_app
from service.broker.celery_app import Broker
from service.settings import Settings


@pytest.fixture(scope="session")
def anyio_backend():
    return "asyncio"


@pytest.fixture(scope="session")
def cluster(tmp_path_factory, s3):
    """A Redis, to be found empty, and the settings of replicas and workers.

    No lease and no message is ever too old, except for what a test makes older.
    """
    if reason := Cluster.missing():
        pytest.skip(reason)
    started = Cluster(
        tmp_path_factory.mktemp("cluster"),
        s3,
        build_timeout=3600,
        build_queue=3,
        drain_seconds=0,
    )
    yield started
    started.close()


@pytest.fixture
def patient(monkeypatch):
    """Have a broker that is there waited for, however slow the machine is."""
    monkeypatch.setattr(celery_app, "_CONNECT_SECONDS", 600.0)
    monkeypatch.setattr(celery_app, "_ANSWER_SECONDS", 600.0)


@pytest.fixture
def settings():
    """The settings of a replica with some broker."""

    def chosen(url, **values):
        return Settings(store="s3://bucket/prefix", broker=url, **values)

    return chosen


@pytest.fixture
def broker(cluster, settings, patient):  # noqa: ARG001
    """A Redis that is empty."""
    cluster.flush()
    opened = Broker(settings(cluster.environment["GAMUT_BROKER"]))
    yield opened
    opened.close()
