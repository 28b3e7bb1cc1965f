import builtins
import subprocess
import sys

import pytest

import service.broker
from service.building.choice import EngineMissingError, engine_for, run_worker
from service.building.embedded import EmbeddedEngine
from service.jobs.book import JobBook
from service.settings import Settings
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs

REMOTE = {"store": "s3://bucket/prefix", "broker": "redis://127.0.0.1:1/0"}


@pytest.fixture
def parts(tmp_path):
    store = GamutStore(LocalBlobs(tmp_path / "store"))
    return store, JobBook(store.blobs)


@pytest.fixture
def _nothing_installed(monkeypatch):
    usual = builtins.__import__

    def without(name, *arguments, **keywords):
        if name.partition(".")[0] in {"celery", "kombu", "billiard"}:
            raise ModuleNotFoundError(name)
        return usual(name, *arguments, **keywords)

    for name in [name for name in sys.modules if name.startswith("service.broker.celery_")]:
        monkeypatch.delitem(sys.modules, name)
        # `from package import module` finds what was imported before in the package itself.
        monkeypatch.delattr(service.broker, name.rpartition(".")[2], raising=False)
    monkeypatch.setattr(builtins, "__import__", without)


def test_without_a_broker_builds_are_done_here(parts):
    assert isinstance(engine_for(Settings(), *parts), EmbeddedEngine)


def test_with_a_broker_they_are_done_elsewhere(parts):
    engine = engine_for(Settings(**REMOTE), *parts)
    assert type(engine).__name__ == "CeleryEngine"
    assert engine.facts().workers == 0


@pytest.mark.usefixtures("_nothing_installed")
def test_what_is_not_installed_is_named(parts):
    for ask in (
        lambda: engine_for(Settings(**REMOTE), *parts),
        lambda: run_worker(Settings(**REMOTE)),
    ):
        with pytest.raises(EngineMissingError, match=r"\[celery,cloud\]"):
            ask()


def test_a_service_without_a_broker_loads_none_of_it():
    code = (
        "import sys, service.application;"
        "print([name for name in sys.modules if name.partition('.')[0] in"
        " {'celery', 'kombu', 'redis', 'amqp', 'obstore'}])"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == "[]"
