import signal
import socket

import httpx
import pytest
import uvicorn

from service.application import create_app
from service.server import AddressUnavailableError, Server, bind_sockets, server_config
from service.settings import Settings


def test_the_signal_to_stop_is_passed_on_at_once():
    class ServiceContainer:
        draining = False

        def drain(self):
            self.draining = True

    service = ServiceContainer()
    server = Server(uvicorn.Config("nothing:at_all"), service)
    server.handle_exit(signal.SIGTERM, None)
    assert server.should_exit
    assert service.draining


def test_a_bound_port_does_not_accept_connections_yet():
    (bound,) = bind_sockets("127.0.0.1", 0)
    with bound, pytest.raises(ConnectionRefusedError):
        socket.create_connection(bound.getsockname(), timeout=5)


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
