"""What the routes of an app share: made of its settings, forgotten and closed together."""

import asyncio
import builtins
import os
import socket
import subprocess
import sys
import threading

import httpx
import pytest
from pydantic import ValidationError

from service import broker
from service.application import create_app
from service.container import EngineMissingError, ServiceContainer, _build_engine
from service.jobs.book import JobBook
from service.server import AddressUnavailableError, bind_sockets, server_config
from service.settings import Settings
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs


@pytest.fixture
def service(tmp_path):
    return ServiceContainer(Settings(store=str(tmp_path / "data")))


async def nothing():
    pass


def test_the_signal_to_stop_reaches_the_builds_from_any_thread(service, monkeypatch):
    monkeypatch.setattr(service.builds, "start", nothing)
    service.drain()  # nothing runs yet

    async def scenario():
        async with service.running():
            thread = threading.Thread(target=service.drain)
            thread.start()
            while not service.builds.draining:  # noqa: ASYNC110 - a thread
                await asyncio.sleep(0.01)
            thread.join()

    asyncio.run(asyncio.wait_for(scenario(), 600))


def test_many_calls_of_a_bucket_wait_at_the_same_time(service, monkeypatch):
    monkeypatch.setattr(service.builds, "start", nothing)
    monkeypatch.setattr(service.store.blobs, "remote", True)
    all_of_them = threading.Barrier(32, timeout=600)

    async def scenario():
        async with service.running():
            await asyncio.gather(*[asyncio.to_thread(all_of_them.wait) for _ in range(32)])

    asyncio.run(asyncio.wait_for(scenario(), 600))


def test_it_runs_warms_up_and_leaves_the_store_to_another(service, monkeypatch):
    other, stopped = ServiceContainer(service.settings), []

    async def stop():
        stopped.append(True)

    for each in (service, other):
        monkeypatch.setattr(each.builds, "start", nothing)
        monkeypatch.setattr(each.builds, "stop", stop)

    async def scenario():
        async with service.running():
            assert service.store.blobs.directory.is_dir()
            while not service.kernels.loaded:  # noqa: ASYNC110
                await asyncio.sleep(0.01)
            assert service.kernels.states["default"] == "compiled"
        async with other.running():
            assert stopped == [True]

    asyncio.run(asyncio.wait_for(scenario(), 600))


def test_what_is_not_installed_is_named(monkeypatch, tmp_path):
    usual = builtins.__import__

    def without(name, *arguments, **keywords):
        if name.partition(".")[0] in {"celery", "redis"}:
            raise ModuleNotFoundError(name)
        return usual(name, *arguments, **keywords)

    for name in [name for name in sys.modules if name.startswith("service.broker.celery_")]:
        monkeypatch.delitem(sys.modules, name)
        # `from package import module` finds what was imported before in the package itself.
        monkeypatch.delattr(broker, name.rpartition(".")[2], raising=False)
    monkeypatch.setattr(builtins, "__import__", without)
    store = GamutStore(LocalBlobs(tmp_path / "store"))
    settings = Settings(store="s3://bucket/prefix", broker="redis://127.0.0.1:1/0")
    with pytest.raises(EngineMissingError, match=r"\[celery,cloud\]"):
        _build_engine(settings, store, JobBook(store.blobs), None)


def test_a_bound_port_does_not_accept_connections_yet():
    (bound,) = bind_sockets("127.0.0.1", 0)
    with bound, pytest.raises(ConnectionRefusedError):
        socket.create_connection(bound.getsockname(), timeout=600)


@pytest.mark.parametrize(
    ("host", "remedy"), [("127.0.0.1", "--port"), ("192.0.2.1", "--host"), ("no.invalid", "--host")]
)
def test_an_address_that_cannot_be_bound_is_named_with_a_remedy(host, remedy):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(AddressUnavailableError, match=f"{host} port {port}") as caught:
            bind_sockets(host, port)
    assert remedy in str(caught.value)


def test_idle_connections_stay_longer_than_clients_reuse_them():
    """Otherwise a request may meet the end of its connection: httpx gives up at its own limit."""
    settings = Settings()
    config = server_config(create_app(settings), settings)
    assert config.timeout_keep_alive > 2 * httpx.Limits().keepalive_expiry


@pytest.mark.parametrize("value", ["inf", "nan", "1e999"])
def test_seconds_and_rates_have_an_end(monkeypatch, value):
    for name, field in Settings.model_fields.items():
        if field.annotation is float:
            with monkeypatch.context() as environment:
                environment.setenv(f"GAMUT_{name.upper()}", value)
                with pytest.raises(ValidationError, match=name):
                    Settings()


def test_a_build_may_have_no_limit_of_memory():
    assert Settings(build_memory_bytes=0).build_memory_bytes == 0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("port", 65536),
        ("build_workers", 0),
        ("build_timeout", 0),
        ("build_memory_bytes", 5),
        ("build_memory_bytes", (256 << 20) - 1),
        ("log_level", "loud"),
        ("api_keys", "name:read:secret"),
        ("cors_origins", "example.org"),
        ("trusted_proxies", "proxy.example.org"),
        ("trusted_proxies", "10.0.0.1,10.0.0.0/33"),
    ],
)
def test_values_out_of_range_are_refused(name, value):
    with pytest.raises(ValidationError, match=name):
        Settings(**{name: value})


def test_proxies_are_addresses_networks_or_all():
    for proxies in ("", "*", "10.0.0.1, 10.1.0.0/16,::1", "2001:db8::/32"):
        assert Settings(trusted_proxies=proxies).trusted_proxies == proxies


@pytest.mark.parametrize("broker", ["localhost", "http://broker", "sqs://", "memory://"])
def test_a_broker_of_another_kind_is_refused(broker):
    with pytest.raises(ValidationError, match="redis://"):
        Settings(store="s3://bucket", broker=broker)


def test_a_broker_needs_a_store_that_is_shared():
    with pytest.raises(ValidationError, match="GAMUT_STORE must be a bucket"):
        Settings(store="var/gamuts", broker="redis://broker/0")


def test_the_password_of_a_broker_is_not_told():
    assert "secret" not in repr(Settings(store="s3://bucket", broker="redis://:secret@broker/0"))


THREADS = """
import service.server, threadpoolctl
print({each["num_threads"] for each in threadpoolctl.threadpool_info()})
"""


@pytest.mark.slow
@pytest.mark.parametrize(("given", "threads"), [(None, "{1}"), ("2", "{2}")])
def test_linear_algebra_has_one_thread_unless_the_operator_gives_more(given, threads):
    environment = {name: text for name, text in os.environ.items() if "NUM_THREADS" not in name}
    if given is not None:
        environment["OPENBLAS_NUM_THREADS"] = given
    printed = subprocess.check_output([sys.executable, "-c", THREADS], env=environment, text=True)
    assert printed.strip() == threads
