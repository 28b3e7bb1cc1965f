import contextlib
import json
import re
import socket
import threading
import time

import pytest
import uvicorn

from service.http.protocol import ConnectionLimits, limited_protocol

pytestmark = pytest.mark.slow

GET = b"GET / HTTP/1.1\r\nHost: test\r\n\r\n"
POST = b"POST / HTTP/1.1\r\nHost: test\r\n"

LIMITS = {
    "connections": 8,
    "head_bytes": 2000,
    "head_seconds": 1.5,
    "body_seconds": 0.6,
    "body_rate": 100,
    "write_seconds": 0.5,
}

STALL = 1.2


async def app(scope, receive, send):
    """Answers with the length of the body; at /early before the body, at /large with 64 MiB.

    At /stall the whole server does nothing else for a while.
    """
    if scope["type"] != "http":
        return
    length, more = 0, scope["path"] != "/early"
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            return
        length += len(message["body"])
        more = message["more_body"]
    if scope["path"] == "/stall":
        time.sleep(STALL)  # noqa: ASYNC251 - the loop itself must stop
    content = bytes(64 << 20) if scope["path"] == "/large" else b"%d" % length
    fields = [(b"content-length", b"%d" % len(content))]
    await send({"type": "http.response.start", "status": 200, "headers": fields})
    await send({"type": "http.response.body", "body": content})


@pytest.fixture(scope="module")
def reports():
    """What the server says that it has answered without the app."""
    return []


@pytest.fixture(scope="module")
def address(reports):
    """A server in this process, whose limits are small."""
    config = uvicorn.Config(
        app,
        port=0,
        http=limited_protocol(ConnectionLimits(**LIMITS), reports.append),
        ws="none",
        lifespan="off",
        log_level="critical",
        timeout_keep_alive=5,
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    yield server.servers[0].sockets[0].getsockname()
    server.should_exit = True
    thread.join(10)
    assert not thread.is_alive()


@pytest.fixture
def connect(address):
    """Open connections that are closed at the end."""
    opened = []

    def connection(data=b""):
        made = socket.create_connection(address, timeout=10)
        opened.append(made)
        made.sendall(data)
        return made

    yield connection
    for made in opened:
        made.close()


def answer(connection):
    """Status, fields and body of all that a connection still has to say."""
    data = b""
    while part := connection.recv(65536):
        data += part
    return parsed(data)


def parsed(data):
    head, _, body = data.partition(b"\r\n\r\n")
    status, *lines = head.decode().split("\r\n")
    fields = dict(line.lower().split(": ", 1) for line in lines)
    return int(status.split()[1]), fields, body


def assert_problem(connection, status, code):
    found, fields, body = answer(connection)
    document = json.loads(body)
    assert (found, document["code"]) == (status, code)
    assert document["status"] == status
    assert fields["content-type"] == "application/problem+json"
    assert fields["cache-control"] == "no-store"
    assert fields["connection"] == "close"
    assert re.fullmatch("[0-9a-f]{32}", fields["x-request-id"])
    return document


def seconds_of_drops(connection, data, meanwhile=lambda: True):
    """Send byte for byte until the other side ends the connection."""
    start = time.monotonic()
    with contextlib.suppress(OSError):
        for number in data:
            connection.sendall(bytes([number]))
            time.sleep(0.05)
            assert meanwhile()
    return time.monotonic() - start


def whole(connection):
    """Whether a good request on this connection is answered."""
    connection.sendall(GET)
    return connection.recv(1000).startswith(b"HTTP/1.1 200")


def is_open(connection):
    """Whether the server has not ended this connection."""
    connection.setblocking(False)
    try:
        return connection.recv(1) != b""
    except BlockingIOError:
        return True
    except ConnectionResetError:
        return False


def busy_connections(connect):
    busy = [connect(POST + b"Content-Length: 2\r\n\r\nx") for _ in range(LIMITS["connections"])]
    time.sleep(0.2)
    return busy


@pytest.mark.parametrize(
    "data",
    [
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"GET\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"GET / HTTP/1.1\r\nno colon\r\n\r\n",
        b"GET http://[ HTTP/1.1\r\n\r\n",
        POST + b"Content-Length: -1\r\n\r\n",
        POST + b"Content-Length: 1\r\nContent-Length: 2\r\n\r\n",
        POST + b"Content-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n",
        POST + b"Transfer-Encoding: chunked\r\n\r\nnot a number\r\n",
    ],
)
def test_what_is_not_http_is_a_problem(connect, data):
    assert_problem(connect(data), 400, "bad-request")


@pytest.mark.parametrize(
    "data",
    [
        b"GET /" + b"x" * 3000 + b" HTTP/1.1\r\n\r\n",
        GET[:-2] + b"a: " + b"x" * 3000 + b"\r\n\r\n",
        GET[:-2] + b"a: 1\r\n" * 500 + b"\r\n",
        GET[:-2] + b"a: " + b"x" * 3000,
        POST + b"Transfer-Encoding: chunked\r\n\r\n0\r\n" + b"a: b\r\n" * 500,
    ],
    ids=["address", "field", "fields", "endless field", "trailers"],
)
def test_a_large_head_is_refused(connect, data):
    document = assert_problem(connect(data), 431, "head-too-large")
    assert document["where"] == {"limit": 2000}


@pytest.mark.slow
def test_a_head_that_comes_in_drops_is_refused_while_others_are_served(connect):
    slow, good = connect(GET[:10]), connect()
    assert seconds_of_drops(slow, GET[10:-1] * 100, lambda: whole(good)) < 5


@pytest.mark.slow
def test_half_a_head_is_refused_in_time(connect):
    assert_problem(connect(GET[:-2]), 408, "request-timeout")


@pytest.mark.slow
def test_who_says_nothing_is_left_without_a_word(connect):
    assert connect().recv(100) == b""


@pytest.mark.slow
def test_a_second_head_has_its_own_time(connect):
    connection = connect()
    assert whole(connection)
    time.sleep(LIMITS["head_seconds"] * 0.6)
    connection.sendall(GET[:20])
    time.sleep(LIMITS["head_seconds"] * 0.6)
    connection.sendall(GET[20:])
    assert connection.recv(1000).startswith(b"HTTP/1.1 200")


@pytest.mark.slow
def test_a_body_that_stops_is_refused(connect):
    connection = connect(POST + b"Content-Length: 100\r\n\r\n" + bytes(10))
    document = assert_problem(connection, 408, "request-timeout")
    assert document["detail"].startswith("10 bytes")


@pytest.mark.slow
def test_a_body_that_comes_in_drops_is_refused(connect):
    connection = connect(POST + b"Content-Length: 1000\r\n\r\n")
    assert seconds_of_drops(connection, bytes(1000)) < 5


@pytest.mark.slow
def test_a_body_that_is_slow_but_fast_enough_is_taken(connect):
    connection = connect(POST + b"Content-Length: 400\r\n\r\n")
    for _ in range(10):
        connection.sendall(bytes(40))
        time.sleep(0.15)
    status, _, body = parsed(connection.recv(1000))
    assert (status, body) == (200, b"400")


@pytest.mark.slow
def test_clients_are_not_blamed_when_the_server_stalls(connect):
    begun = connect(POST + b"Content-Length: 6\r\n\r\nabc")
    stalling = connect(GET.replace(b"/", b"/stall", 1))
    assert stalling.recv(1000).startswith(b"HTTP/1.1 200")
    time.sleep(0.1)
    begun.sendall(b"def")
    assert begun.recv(1000).endswith(b"6")


def test_whoever_does_not_read_the_answer_is_disconnected(connect):
    connection = connect(b"GET /large HTTP/1.1\r\nHost: test\r\n\r\n")
    time.sleep(2)
    received = 0
    with contextlib.suppress(ConnectionResetError):
        while part := connection.recv(1 << 20):
            received += len(part)
    assert received < 64 << 20


def test_idle_connections_give_way_to_new_ones(connect):
    idle = [connect() for _ in range(LIMITS["connections"] * 3)]
    assert whole(connect())
    # the one just served and the newest of the idle ones are left
    assert whole(idle[-1])
    assert not any(is_open(older) for older in idle[: -LIMITS["connections"] + 1])


@pytest.mark.slow
def test_the_limit_of_a_head_does_not_end_connections_between_requests(connect):
    connection, silent = connect(), connect()
    assert whole(connection)
    time.sleep(LIMITS["head_seconds"] + 0.7)
    assert not is_open(silent)
    assert whole(connection)


def test_busy_connections_do_not(connect):
    busy = busy_connections(connect)
    assert_problem(connect(GET), 503, "overloaded")
    for connection in busy:
        connection.sendall(b"x")
        assert connection.recv(1000).startswith(b"HTTP/1.1 200")
    assert whole(connect())


def test_an_answer_before_the_body_is_read_by_clients_that_send_first(connect):
    connection = connect(b"POST /early HTTP/1.1\r\nHost: test\r\nContent-Length: 1000000\r\n\r\n")
    connection.sendall(bytes(1_000_000))
    assert connection.recv(1000).startswith(b"HTTP/1.1 200")
    assert whole(connection)


def test_requests_behind_one_another_are_answered_in_order(connect):
    connection = connect(GET * 3)
    data = b""
    while data.count(b"HTTP/1.1 200") < 3:
        data += connection.recv(1000)
    assert whole(connection)


def test_a_connection_with_thousands_of_requests_ahead_is_ended(connect):
    connection, good = connect(GET * 5000), connect()
    with contextlib.suppress(ConnectionResetError):
        assert connection.recv(1 << 20).count(b"HTTP/1.1 200") < 100
        assert connection.recv(1 << 20) == b""
    assert whole(good)


def test_a_wish_for_another_protocol_is_ignored(connect):
    fields = b"Connection: Upgrade, HTTP2-Settings\r\nUpgrade: h2c\r\nHTTP2-Settings: \r\n\r\n"
    connection = connect(GET[:-2] + fields)
    assert connection.recv(1000).startswith(b"HTTP/1.1 200")


@pytest.mark.parametrize(
    ("data", "status", "problem", "seconds"),
    [
        (b"GET\r\n\r\n", 400, "bad-request", 0.0),
        (GET[:-2], 408, "request-timeout", LIMITS["head_seconds"]),
        (POST + b"Content-Length: 100\r\n\r\n", 408, "request-timeout", LIMITS["body_seconds"]),
        (GET[:-2] + b"a: " + b"x" * 3000, 431, "head-too-large", 0.0),
    ],
)
@pytest.mark.slow
def test_what_the_app_does_not_see_is_reported(connect, reports, data, status, problem, seconds):
    connection = connect(data)
    host = connection.getsockname()[0]
    found, fields, body = answer(connection)
    (report,) = [each for each in reports if each.request_id == fields["x-request-id"]]
    assert report[:3] == (problem, found, len(body)) == (problem, status, len(body))
    assert report.client == host
    assert seconds <= report.seconds < seconds + 5


def test_that_there_are_too_many_connections_is_reported(connect, reports):
    busy_connections(connect)
    _, fields, body = answer(connect(GET))
    (report,) = [each for each in reports if each.request_id == fields["x-request-id"]]
    assert report[:3] == ("overloaded", 503, len(body))


@pytest.mark.slow
def test_what_the_app_answers_is_not_reported(connect, reports):
    assert whole(connect())
    reports.clear()
    connection = connect(GET * 3)
    data = b""
    while data.count(b"HTTP/1.1 200") < 3:
        data += connection.recv(1000)
    assert connect().recv(100) == b""
    assert reports == []
