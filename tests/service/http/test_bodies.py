"""Bodies while they arrive: their limits, what they take, and what is said about it."""

import asyncio
import contextlib
import json
import re
import socket
import tempfile
import time
from pathlib import Path

import httpx
import pytest

from service.application import create_app
from service.http import bodies
from service.settings import Settings
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs

HANG = 600
MEBIBYTE = 2**20
JSON, CSV = "application/json", "text/csv"
FORM = "multipart/form-data; boundary=x"
PROXY = "127.0.0.1"
LARGE = b"[" + b" " * 100_000


@pytest.fixture(scope="module")
def tight_server(start_server):
    """A server for four large bodies, two for each client."""
    started = start_server(
        trusted_proxies=PROXY,
        large_bodies=4,
    )
    started.wait_ready()
    return started


class Post:
    """A post whose body is sent piece by piece, from an address behind the proxy."""

    def __init__(self, server, path, media_type, length, client="192.0.2.1"):
        host, port = server.url.removeprefix("http://").split(":")
        self.connection = socket.create_connection((host, int(port)), timeout=HANG)
        head = (
            f"POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: {media_type}\r\n"
            f"X-Forwarded-For: {client}\r\nPrefer: respond-async\r\n"
            f"Content-Length: {length}\r\n\r\n"
        )
        self.connection.sendall(head.encode())

    def send(self, data):
        self.connection.sendall(data)

    def answer(self):
        """Return the status, the header fields and the document of the answer."""
        file = self.connection.makefile("rb")
        status = int(file.readline().split()[1])
        fields = dict(
            line.decode().lower().strip().split(": ") for line in iter(file.readline, b"\r\n")
        )
        return status, fields, json.loads(file.read(int(fields["content-length"])))

    def close(self):
        self.connection.close()


@pytest.fixture
def post():
    """Begin a post; at the end, it is closed, and its server must hold nothing of it."""
    servers = set()
    with contextlib.ExitStack() as stack:

        def begin(server, *arguments):
            servers.add(server)
            begun = Post(server, *arguments)
            stack.callback(begun.close)
            return begun

        yield begin
    for server in servers:
        wait_for_bodies(server, 0)
        server.wait_for(lambda server=server: not unnamed_files(server))
        assert list((server.data / "temporary").iterdir()) == []


def wait_for_bodies(server, count):
    """Wait for a number of large bodies."""
    server.wait_for(lambda: large_bodies(server) == count)


def large_bodies(server):
    return float(re.search(r"(?m)^gamut_large_bodies (\S+)", server.client.get("/metrics").text)[1])


def unnamed_files(server):
    """Sizes of the unnamed files that the server has in the store's folder for scratch files."""
    sizes = []
    for path in Path(f"/proc/{server.process.pid}/fd").iterdir():
        with contextlib.suppress(OSError):
            name = str(path.readlink())
            if name.startswith(str(server.data / "temporary")) and name.endswith("(deleted)"):
                sizes.append(path.stat().st_size)
    return sizes


def contains(server, sphere):
    created = server.client.post("/v1/gamuts", json={"samples": sphere(seed=79)}).json()
    return f"{created['links']['self']}/contains"


def test_slow_bodies_that_declare_much_stop_no_queries(tight_server, sphere, post):
    """Four of the large bodies have all places, and four wait for one."""
    path = contains(tight_server, sphere)
    for _ in range(20):
        post(tight_server, path, CSV, 160_000_000).send(b"L,a,b\n" + b"50,0,0\n" * 700)
    for number in range(8):
        begun = post(tight_server, path, CSV, 160_000_000, f"192.0.2.{number // 2}")
        begun.send(b"L,a,b\n" + b"50,0,0\n" * 20_000)
    wait_for_bodies(tight_server, 8)
    for media_type, body in ((JSON, b'{"colours": [[50, 0, 0]]}'), (CSV, b"L,a,b\n50,0,0\n")):
        fields = {"Content-Type": media_type}
        answer = tight_server.client.post(path, content=body, headers=fields)
        assert answer.status_code == 200, answer.text


def part(name, content, file=False):
    file = '; filename="f"' if file else ""
    head = f'--x\r\nContent-Disposition: form-data; name="{name}"{file}\r\n\r\n'
    return head.encode() + content + b"\r\n"


BODIES = {
    "JSON": (JSON, b'{"samples": [' + b"[50.25, 0, 0], " * 65_000),
    "a form of fields": (FORM, b"".join(part("gamma", bytes(60_000)) for _ in range(40))),
    "a form with a file": (FORM, part("file", bytes(1_000_000), file=True)),
}


@pytest.mark.parametrize("kind", BODIES)
def test_the_memory_of_arriving_bodies_is_bounded(tight_server, post, kind):
    """Hundreds of bodies of about a megabyte, none of them complete."""
    media_type, body = BODIES[kind]
    count = 150_000_000 // len(body)
    before = resident(tight_server)
    unsent = {}
    for number in range(count):
        begun = post(tight_server, "/v1/gamuts", media_type, len(body) + 10, f"192.0.2.{number}")
        begun.connection.setblocking(False)
        unsent[begun.connection] = body
    deadline = time.monotonic() + HANG
    while large_bodies(tight_server) < count:
        assert time.monotonic() < deadline, large_bodies(tight_server)
        for connection, rest in unsent.items():
            with contextlib.suppress(BlockingIOError):
                unsent[connection] = rest[connection.send(rest) :]
    # 64 KiB of each body, and as much in the buffer of its connection
    assert resident(tight_server) - before < 2 * count * bodies.IN_MEMORY + 64 * MEBIBYTE


def resident(server):
    status = Path(f"/proc/{server.process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) * 1024


def test_a_client_has_a_part_of_the_places(tight_server, post):
    for number in range(2):
        post(tight_server, "/v1/gamuts", JSON, 200_000).send(LARGE)
        wait_for_bodies(tight_server, number + 1)
    refused = post(tight_server, "/v1/gamuts", JSON, 200_000)
    refused.send(LARGE)
    status, fields, document = refused.answer()
    assert (status, document["code"]) == (429, "queries-busy")
    assert int(fields["retry-after"]) > 0
    small = post(tight_server, "/v1/gamuts", JSON, 2)
    other = post(tight_server, "/v1/gamuts", JSON, len(LARGE) + 1, "192.0.2.2")
    small.send(b"[]")
    other.send(LARGE + b"]")
    for each in (small, other):
        assert each.answer()[2]["code"] == "invalid-body"


def test_a_large_body_waits_for_the_place_of_another(tight_server, post):
    posts = []
    for number in range(5):
        posts.append(post(tight_server, "/v1/gamuts", JSON, len(LARGE) + 1, f"192.0.2.{number}"))
        posts[-1].send(LARGE)
        wait_for_bodies(tight_server, number + 1)
    # The fifth has not arrived as far as its place would let it.
    tight_server.wait_for(lambda: len(unnamed_files(tight_server)) == 4)
    posts[4].send(b"]")
    posts[0].send(b"]")
    for each in (posts[0], posts[4]):
        assert each.answer()[2]["code"] == "invalid-body"


def test_large_files_are_in_the_folder_of_the_store(tight_server, post):
    begun = post(tight_server, "/v1/gamuts", FORM, MEBIBYTE)
    begun.send(part("file", bytes(500_000), file=True)[:-2])
    tight_server.wait_for(lambda: sum(unnamed_files(tight_server)) > 400_000)
    begun.close()  # the fixture waits for the end of the file


# --- without a server ---------------------------------------------------------------------------


@pytest.fixture
def app(tmp_path):
    """Return a function that makes an app with settings."""
    store = GamutStore(LocalBlobs(tmp_path))
    store.open()
    store.close()

    def make(**settings):
        return create_app(Settings(store=str(tmp_path), **settings))

    return make


async def send(app, *pieces, media_type=JSON, client="192.0.2.1"):
    """Post pieces of a body, which may be bytes or events that the client waits for."""

    async def body():
        for piece in pieces:
            if isinstance(piece, asyncio.Event):
                await piece.wait()
            else:
                yield piece

    transport = httpx.ASGITransport(app, client=(client, 1))
    async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as browser:
        fields = {"Content-Type": media_type, "Prefer": "respond-async"}
        return await browser.post("/v1/gamuts", content=body(), headers=fields)


@pytest.mark.parametrize(
    ("media_type", "pieces"),
    [
        (JSON, [b"["]),
        (JSON, [LARGE]),
        (FORM, [part("file", b"x", file=True)]),
        (FORM, [part("file", bytes(200_000), file=True)]),
    ],
)
def test_a_body_has_a_time_to_arrive(app, assert_problem, media_type, pieces):
    made = app(body_timeout=0.2)

    async def scenario():
        return await send(made, *pieces, asyncio.Event(), media_type=media_type)

    answer = asyncio.run(asyncio.wait_for(scenario(), HANG))
    document = assert_problem(answer, 408, "request-timeout")
    assert f"{sum(map(len, pieces))} bytes" in document["detail"]
    assert answer.headers["connection"] == "close"
    assert made.state.service.bodies.large == 0


def test_a_body_that_finds_no_place_in_time_may_come_again(app, assert_problem):
    made = app(body_timeout=1.0, large_bodies=1)

    async def scenario():
        slow = asyncio.create_task(send(made, LARGE, asyncio.Event()))
        await asyncio.sleep(0.7)
        other = await send(made, LARGE, b"]", client="192.0.2.2")
        return await slow, other

    slow, waiting = asyncio.run(asyncio.wait_for(scenario(), HANG))
    assert_problem(slow, 408, "request-timeout")
    # It got the place of the slow one, in the time that remained.
    assert_problem(waiting, 422, "invalid-body")


def test_a_body_that_never_finds_a_place_is_told_so(app, assert_problem):
    made = app(body_timeout=0.2, large_bodies=1)

    async def scenario():
        async with made.state.service.bodies.places:
            return await send(made, LARGE, b"]")

    answer = asyncio.run(asyncio.wait_for(scenario(), HANG))
    assert_problem(answer, 503, "overloaded")
    assert int(answer.headers["retry-after"]) > 0
    assert made.state.service.bodies.large == 0
    assert_problem(asyncio.run(send(made, LARGE, b"]")), 422, "invalid-body")


@pytest.mark.parametrize("media_type", [JSON, FORM])
def test_what_is_larger_than_the_limit_is_refused_as_it_arrives(app, assert_problem, media_type):
    made = app(max_body_bytes=100_000)
    pieces = [part("file", b"", file=True)[:-2], *[bytes(20_000)] * 6, asyncio.Event()]

    async def scenario():
        return await send(made, *pieces, media_type=media_type)

    answer = asyncio.run(asyncio.wait_for(scenario(), HANG))
    document = assert_problem(answer, 413, "body-too-large")
    assert document["where"] == {"limit": 100_000}


@pytest.mark.parametrize("body", [{"json": [0] * 100_000}, {"files": {"file": bytes(100_000)}}])
def test_a_full_scratch_folder_is_called_that(app, request_app, monkeypatch, assert_problem, body):
    made = app()
    full = lambda **_: Path("/dev/full").open("w+b")  # noqa: E731, SIM115
    monkeypatch.setattr(tempfile, "TemporaryFile", full)
    document = assert_problem(request_app(made, "POST", "/v1/gamuts", **body), 507, "scratch-full")
    assert "scratch" in document["title"]
    few = request_app(made, "POST", "/v1/gamuts", json=[])
    assert few.status_code == 422


END = b"--x--\r\n"
GAMMA = part("gamma", b"0.5")
FILE = part("file", b"0,0,0", file=True)


@pytest.mark.parametrize(
    "content",
    [FILE + GAMMA, GAMMA + FILE, part("file", b"0,0,0") + GAMMA, GAMMA + FILE + GAMMA],
)
def test_parts_come_in_any_order_and_alike_ones_again(app, content):
    answer = asyncio.run(send(app(), content + END, media_type=FORM))
    assert answer.status_code == 202, answer.text


def test_a_file_without_a_file_name_keeps_its_bytes(app):
    """A text that is no UTF-8 must not be decoded and encoded again."""
    content = "L,a,b,name\n50,0,0,grün\n".encode("latin-1") + bytes(range(256))
    ids = set()
    for named in (True, False):
        body = part("file", content, file=named) + END
        for media_type in (FORM, f"{FORM}; charset=latin-1"):
            ids.add(asyncio.run(send(app(), body, media_type=media_type)).json()["id"])
    assert len(ids) == 1


@pytest.mark.parametrize(
    ("content", "field"),
    [
        (FILE + part("other", b"", file=True), "other"),
        (FILE + part("other", b""), "other"),
        (FILE + FILE, "file"),
        (FILE + part("gamma", b"0.5", file=True), "gamma"),
        (FILE + GAMMA + part("gamma", b"0.6"), "gamma"),
        (GAMMA, "file"),
        (END, "file"),
    ],
)
def test_parts_that_nobody_wants_are_refused(app, assert_problem, content, field):
    answer = asyncio.run(send(app(), content + END, media_type=FORM))
    assert assert_problem(answer, 422, "invalid-body")["where"] == {"field": field}


@pytest.mark.parametrize(
    ("content", "limit"),
    [
        (FILE + part("gamma", b"0" * 70_000), bodies.FIELD_BYTES),
        (FILE + GAMMA * 1000, 40),
        (FILE * 9, 3),
    ],
)
def test_forms_have_limits(app, assert_problem, content, limit):
    answer = asyncio.run(send(app(), content + END, media_type=FORM))
    assert assert_problem(answer, 413, "body-too-large")["where"] == {"limit": limit}


@pytest.mark.parametrize(
    ("media_type", "content"),
    [
        ("multipart/form-data", FILE),
        ("multipart/form-data; boundary=", FILE),
        ("multipart/form-data; boundary=" + "x" * 300, FILE),
        ('multipart/form-data; boundary="x', FILE),
        ("multipart/form-data; boundary*=utf-8''x", FILE),
        (FORM, b""),
        (FORM, FILE),  # without an end; Starlette's parser leaves the file to the collector
        (FORM, b"--y\r\n\r\n"),
        (FORM, b"--x\r\n\r\nx\r\n" + END),
        (FORM, b'--x\r\nContent-Disposition: form-data; name="file\r\n\r\nx\r\n--x'),
        (FORM, b"--x\r\nContent-Disposition: form-data\r\n\r\nx\r\n" + END),
        (FORM, b"--x\r\n" + b"A: b\r\n" * 10_000 + b"\r\n" + END),
        (FORM, b"--x\r\nA: " + b"b" * 100_000 + b"\r\n\r\n" + END),
        (FORM, b"--x\r\n\xff: b\r\n\r\n" + END),
        (FORM, b"--x\r\nContent Disposition: b\r\n\r\n" + END),
        (
            FORM,
            part('\xff"; filename="\udcff'.encode("utf-8", "surrogatepass").decode("latin-1"), b"")
            + END,
        ),
        (JSON, b""),
        (JSON, b"\xff"),
        (JSON, b"[" * 100_000),
        (JSON, b"[1" + b"0" * 5000 + b"]"),
        (JSON, b'{"samples": [[NaN, 0, 0]]}'),
        (JSON, b'{"samples": "\\ud800"}'),
        ("application/x-www-form-urlencoded", b"file=%ff&&;=&"),
    ],
)
@pytest.mark.filterwarnings("ignore:Unclosed file:ResourceWarning")
def test_what_no_parser_can_read_is_an_error_of_the_client(
    app, assert_problem, media_type, content
):
    answer = asyncio.run(send(app(), content, media_type=media_type))
    assert 400 <= answer.status_code < 500, answer.text
    assert_problem(answer, answer.status_code, answer.json()["code"])


@pytest.mark.parametrize(
    "query", ["%", "a=%ff", "&&=", "a" * 9000, "triangles=%00", "triangles=" + "9" * 5000, "=%zz;"]
)
def test_queries_that_no_parser_can_read_are_errors_of_the_client(app, request_app, query):
    for path in ("/v1/gamuts", f"/v1/gamuts/{'0' * 64}/mesh", "/v1/gamuts/srgb"):
        assert 400 <= request_app(app(), "GET", f"{path}?{query}").status_code < 500
