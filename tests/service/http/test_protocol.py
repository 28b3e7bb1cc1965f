"""Limits of connections. The server's clock stands still until a test moves it."""

import asyncio
import contextlib
import json
import re
import socket
import threading

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
SLACK = 0.75
"""Limits of time are checked every half of a second; the clock moves in steps of an eighth."""

HANG = 120
"""Seconds after which a test gives up; it never waits as long."""


left = []
"""Paths of the requests that learnt that their client is gone."""


async def app(scope, receive, send):
    """Answers with the length of the body; at /early before the body, at /large with 64 MiB.

    At /wait, it waits until the client is gone.
    """
    if scope["type"] != "http":
        return
    while scope["path"] == "/wait":
        if (await receive())["type"] == "http.disconnect":
            left.append(scope["path"])
            return
    length, more = 0, scope["path"] != "/early"
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            return
        length += len(message["body"])
        more = message["more_body"]
    content = bytes(64 << 20) if scope["path"] == "/large" else b"%d" % length
    fields = [(b"content-length", b"%d" % len(content))]
    await send({"type": "http.response.start", "status": 200, "headers": fields})
    await send({"type": "http.response.body", "body": content})


class Clock(asyncio.SelectorEventLoop):
    """An event loop whose time is what the test says."""

    now = 0.0

    def time(self):
        return self.now

    def settle(self, turns=8):
        """Let the loop do what it can do now: accepting and reading take a turn each."""
        for _ in range(turns):
            done = threading.Event()
            self.call_soon_threadsafe(done.set)
            assert done.wait(HANG)

    def jump(self, seconds):
        """Move the clock at once, as if the process had not run meanwhile."""
        self.settle()
        self.call_soon_threadsafe(setattr, self, "now", self.now + seconds)
        self.settle()

    def advance(self, seconds):
        """Move the clock in small steps, and let the loop run at each."""
        self.settle()
        for _ in range(int(seconds / 0.125)):
            self.call_soon_threadsafe(setattr, self, "now", self.now + 0.125)
            self.settle(3)


@pytest.fixture(scope="module")
def clock():
    return Clock()


@pytest.fixture(scope="module")
def reports():
    """What the server says that it has answered without the app."""
    return []


@pytest.fixture(scope="module")
def address(reports, clock):
    """A server in this process, whose limits are small."""
    config = uvicorn.Config(
        app,
        port=0,
        http=limited_protocol(ConnectionLimits(**LIMITS), reports.append),
        ws="none",
        lifespan="off",
        log_config=None,
        timeout_keep_alive=5,
    )
    server = uvicorn.Server(config)
    ready = threading.Event()

    async def serve():
        startup = server.startup

        async def started(sockets=None):
            await startup(sockets)
            ready.set()

        server.startup = started
        await server.serve()

    def run():
        with asyncio.Runner(loop_factory=lambda: clock) as runner:
            runner.run(serve())

    thread = threading.Thread(target=run)
    thread.start()
    assert ready.wait(HANG)
    yield server.servers[0].sockets[0].getsockname()
    server.should_exit = True
    while thread.is_alive():
        with contextlib.suppress(RuntimeError):  # the loop is closed
            clock.call_soon_threadsafe(setattr, clock, "now", clock.now + 0.125)
        thread.join(0.01)


@pytest.fixture
def connect(address):
    """Open connections that are closed at the end."""
    with contextlib.ExitStack() as stack:

        def connection(data=b""):
            made = stack.enter_context(socket.create_connection(address, timeout=HANG))
            made.sendall(data)
            return made

        yield connection


def answer(connection):
    """Status, fields and body of all that a connection still has to say."""
    data = b""
    while part := connection.recv(65536):
        data += part
    head, _, body = data.partition(b"\r\n\r\n")
    status, *lines = head.decode().split("\r\n")
    fields = dict(line.lower().split(": ", 1) for line in lines)
    return int(status.split()[1]), fields, body


def assert_problem(connection, status, code, reports):
    """Read a problem document, and check that it was reported; return it and the report."""
    found, fields, body = answer(connection)
    document = json.loads(body)
    assert (found, document["code"]) == (status, code)
    assert document["status"] == status
    assert fields["content-type"] == "application/problem+json"
    assert fields["cache-control"] == "no-store"
    assert fields["connection"] == "close"
    assert re.fullmatch("[0-9a-f]{32}", fields["x-request-id"])
    (report,) = [each for each in reports if each.request_id == fields["x-request-id"]]
    assert report[:3] == (code, status, len(body))
    assert report.client == connection.getsockname()[0]
    return document, report


def one_answer(connection):
    """Read one answer from a connection that stays open; return its content."""
    data = b""
    while True:
        head, end, body = data.partition(b"\r\n\r\n")
        if end and len(body) >= int(re.search(rb"content-length: (\d+)", head)[1]):
            assert head.startswith(b"HTTP/1.1 200")
            return body
        part = connection.recv(1000)
        assert part, data
        data += part


def whole(connection):
    """Whether a good request on this connection is answered."""
    connection.sendall(GET)
    return one_answer(connection) == b"0"


def is_open(connection):
    """Whether the server has neither answered nor ended this connection."""
    connection.setblocking(False)
    try:
        connection.recv(1, socket.MSG_PEEK)
    except BlockingIOError:
        return True
    except ConnectionResetError:
        pass
    finally:
        connection.settimeout(HANG)
    return False


def seconds_of_drops(clock, connection, data, meanwhile=lambda: True):
    """Send byte for byte until the other side ends the connection."""
    start = clock.now
    for number in data:
        if not is_open(connection):
            return clock.now - start
        connection.sendall(bytes([number]))
        clock.advance(0.125)
        assert meanwhile()
    return pytest.fail("the connection is still open")


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
def test_what_is_not_http_is_a_problem(connect, reports, data):
    _, report = assert_problem(connect(data), 400, "bad-request", reports)
    assert report.seconds == 0


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
def test_a_large_head_is_refused(connect, reports, data):
    document, _ = assert_problem(connect(data), 431, "head-too-large", reports)
    assert document["where"] == {"limit": 2000}


def test_many_fields_in_one_packet_are_refused_once(connect, clock, reports, caplog):
    """The parser's error and the size of the packet are one refusal."""
    before = len(reports)
    data = b"GET / HTTP/1.1\r\nHost: test\r\n" + b"X: 0123456789\r\n" * 400 + b"\r\n"
    assert_problem(connect(data), 431, "head-too-large", reports)
    clock.settle()
    assert len(reports) == before + 1
    assert not [record for record in caplog.records if record.exc_info]


def test_a_head_that_comes_in_drops_is_refused_while_others_are_served(connect, clock):
    slow, good = connect(GET[:10]), connect()
    seconds = seconds_of_drops(clock, slow, GET[10:-1] * 100, lambda: whole(good))
    assert LIMITS["head_seconds"] <= seconds <= LIMITS["head_seconds"] + SLACK


def test_half_a_head_is_refused_in_time(connect, clock, reports):
    connection = connect(GET[:-2])
    clock.advance(1)
    assert is_open(connection)
    clock.advance(1.5)
    _, report = assert_problem(connection, 408, "request-timeout", reports)
    assert LIMITS["head_seconds"] <= report.seconds <= LIMITS["head_seconds"] + SLACK


def test_who_says_nothing_is_left_without_a_word_unless_a_request_was_answered(connect, clock):
    silent, connection = connect(), connect()
    assert whole(connection)
    clock.advance(2.25)
    assert silent.recv(100) == b""
    assert whole(connection)


def test_a_second_head_has_its_own_time(connect, clock):
    connection = connect()
    assert whole(connection)
    clock.advance(1)
    connection.sendall(GET[:20])
    clock.advance(1)
    connection.sendall(GET[20:])
    assert one_answer(connection) == b"0"


def test_a_body_that_stops_is_refused(connect, clock, reports):
    connection = connect(POST + b"Content-Length: 100\r\n\r\n" + bytes(10))
    clock.advance(1.5)
    document, report = assert_problem(connection, 408, "request-timeout", reports)
    assert document["detail"].startswith("10 bytes")
    assert LIMITS["body_seconds"] <= report.seconds <= LIMITS["body_seconds"] + SLACK


def test_a_body_that_comes_in_drops_is_refused(connect, clock):
    connection = connect(POST + b"Content-Length: 1000\r\n\r\n")
    # a byte in an eighth of a second is a twelfth of the rate
    assert seconds_of_drops(clock, connection, bytes(1000)) <= 1.1 * LIMITS["body_seconds"] + SLACK


def test_a_body_that_is_slow_but_fast_enough_is_taken(connect, clock):
    connection = connect(POST + b"Content-Length: 400\r\n\r\n")
    for _ in range(10):
        connection.sendall(bytes(40))
        clock.advance(0.25)
    assert one_answer(connection) == b"400"


def test_clients_are_not_blamed_when_the_server_stalls(connect, clock):
    begun = connect(POST + b"Content-Length: 6\r\n\r\nabc")
    half = connect(GET[:10])
    clock.jump(100)
    begun.sendall(b"def")
    assert one_answer(begun) == b"6"
    half.sendall(GET[10:])
    assert one_answer(half) == b"0"


def test_whoever_does_not_read_the_answer_is_disconnected(connect, clock):
    connection = connect(b"GET /large HTTP/1.1\r\nHost: test\r\n\r\n")
    clock.advance(3)
    received = 0
    with contextlib.suppress(ConnectionResetError):
        while part := connection.recv(1 << 20):
            received += len(part)
    assert received < 64 << 20


def test_idle_connections_give_way_to_new_ones(connect, clock):
    idle = [connect() for _ in range(LIMITS["connections"] * 3)]
    clock.settle()
    assert whole(connect())
    # the one just served and the newest of the idle ones are left
    assert whole(idle[-1])
    clock.settle()
    assert not any(is_open(older) for older in idle[: -LIMITS["connections"] + 1])


def test_busy_connections_do_not(connect, clock, reports):
    body = POST + b"Content-Length: 2\r\n\r\nx"
    busy = [connect(body) for _ in range(LIMITS["connections"])]
    clock.settle()
    assert_problem(connect(GET), 503, "overloaded", reports)
    for connection in busy:
        connection.sendall(b"x")
        assert one_answer(connection) == b"2"
    assert whole(connect())


def test_an_answer_before_the_body_is_read_by_clients_that_send_first(connect, clock):
    head = b"POST /early HTTP/1.1\r\nHost: test\r\nContent-Length: 1000000\r\n\r\n"
    connection = connect(head)
    connection.sendall(bytes(1_000_000))
    assert one_answer(connection) == b"0"
    assert whole(connection)
    # the rest of a body is not waited for without end
    never = connect(head + bytes(10))
    assert one_answer(never) == b"0"
    clock.advance(6)
    assert not is_open(never)


def test_requests_behind_one_another_are_answered_in_order_and_not_reported(connect, reports):
    reports.clear()
    connection = connect(GET * 3)
    data = b""
    while data.count(b"HTTP/1.1 200") < 3 or not data.endswith(b"\r\n\r\n0"):
        part = connection.recv(1000)
        assert part, data
        data += part
    assert whole(connection)
    assert reports == []


def test_a_connection_with_thousands_of_requests_ahead_is_ended(connect):
    connection, good = connect(GET * 5000), connect()
    with contextlib.suppress(ConnectionResetError):
        assert connection.recv(1 << 20).count(b"HTTP/1.1 200") < 100
        assert connection.recv(1 << 20) == b""
    assert whole(good)


def test_a_wish_for_another_protocol_is_ignored(connect, caplog):
    fields = b"Connection: Upgrade, HTTP2-Settings\r\nUpgrade: h2c\r\nHTTP2-Settings: \r\n\r\n"
    connection = connect(GET[:-2] + fields)
    assert one_answer(connection) == b"0"
    assert not caplog.records


def test_the_request_that_is_answered_learns_that_its_client_is_gone(connect, clock):
    """uvicorn itself tells only the newest request of a connection."""
    left.clear()
    connection = connect(GET + GET.replace(b"/", b"/wait", 1) + GET)
    assert one_answer(connection) == b"0"
    clock.settle()
    connection.close()
    clock.settle()
    assert left == ["/wait"]
