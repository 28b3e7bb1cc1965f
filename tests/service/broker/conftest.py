"""A broker and a bucket that the tests of this folder share."""

import pytest
from cluster import Cluster

from service.broker import celery_app


@pytest.fixture(scope="session")
def cluster(tmp_path_factory, s3):
    """A Redis, to be found empty, and the settings of replicas and workers."""
    if reason := Cluster.missing():
        pytest.skip(reason)
    started = Cluster(
        tmp_path_factory.mktemp("cluster"),
        s3,
        build_lease=3600,
        build_timeout=3600,
        resend_seconds=1,
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
