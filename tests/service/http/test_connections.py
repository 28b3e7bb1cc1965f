"""Limits of an open port without a proxy: uvicorn's own. The proxy has the others."""

import contextlib
import socket
import time

import pytest

from service.application import create_app
from service.server import server_config
from service.settings import Settings

HEAD = b"GET /livez HTTP/1.1\r\nHost: localhost\r\n"
HANG = 600


@pytest.fixture
def open_port(serve_app):
    address = serve_app(host="0.0.0.0", allow_anonymous="all", max_connections=3)  # noqa: S104
    return int(address.rpartition(":")[2])


def connection(port):
    return socket.create_connection(("127.0.0.1", port), timeout=HANG)


@pytest.mark.slow
def test_an_open_port_limits_its_connections_and_heads(open_port):
    with contextlib.ExitStack() as stack:

        def ask(data):
            opened = stack.enter_context(connection(open_port))
            opened.sendall(data)
            return opened.recv(4096).partition(b"\r\n")[0].decode()

        def wait_until_answered():
            while "200" not in ask(HEAD + b"\r\n"):
                stack.close()
                time.sleep(0.02)
            stack.close()

        wait_until_answered()
        endless = connection(open_port)
        with endless, pytest.raises(OSError, match=r"reset|pipe"):
            endless.sendall(HEAD + b"A: " + bytes([97]) * 100_000_000)
        wait_until_answered()
        answers = [ask(HEAD + b"\r\n") for _ in range(4)]
    assert answers[-1] == "HTTP/1.1 503 Service Unavailable"
    assert answers.count("HTTP/1.1 200 OK") == 3


@pytest.mark.parametrize(
    ("settings", "parser"),
    [
        ({}, "httptools"),
        ({"host": "::1"}, "httptools"),
        ({"host": "192.0.2.1"}, "h11"),
        ({"host": "192.0.2.1", "trusted_proxies": "192.0.2.2"}, "httptools"),
    ],
)
def test_heads_have_a_limit_where_no_proxy_has_one(tmp_path, settings, parser):
    given = Settings(store=str(tmp_path), allow_anonymous="all", **settings)
    config = server_config(create_app(given), given)
    assert (config.http, config.h11_max_incomplete_event_size) == (parser, 32 * 1024)
