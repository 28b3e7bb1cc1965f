"""Bodies while they arrive: what they take, who gives way, and what is said about it."""

import asyncio
import contextlib
import json
import re
import socket
import threading
from pathlib import Path

import httpx
import pytest

from service.application import create_app
from service.http import bodies
from service.settings import Settings
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs

HANG = 120
MEBIBYTE = 2**20
JSON, CSV = "application/json", "text/csv"
FORM = "multipart/form-data; boundary=x"
PROXY = "127.0.0.1"


@pytest.fixture(scope="module")
def default_server(start_server):
    """A server with the limits that a new installation has."""
    started = start_server(trusted_proxies=PROXY)
    started.wait_ready()
    return started


@pytest.fixture(scope="module")
def tight_server(start_server):
    """A server for eight arriving bodies, two for each client if others compete, and 1 MB."""
    started = start_server(
        trusted_proxies=PROXY,
        arriving_bodies=8,
        spool_bytes=1_000_000,
        max_body_bytes=1_000_000,
        max_inline_bytes=1_000_000,
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
        server.wait_for(lambda server=server: gauge(server, "gamut_spool_bytes") == 0)


def gauge(server, name):
    return float(re.search(rf"(?m)^{name} (\S+)", server.client.get("/metrics").text)[1])


def wait_for_bodies(server, count):
    server.wait_for(lambda: gauge(server, "gamut_http_bodies_arriving") == count)


def wait_for_bytes(server, count):
    server.wait_for(lambda: gauge(server, "gamut_spool_bytes") >= count)


def contains(server, sphere):
    created = server.client.post("/v1/gamuts", json={"samples": sphere(seed=79)}).json()
    return f"{created['links']['self']}/contains"


def test_slow_bodies_that_declare_much_stop_no_queries(default_server, sphere, post):
    path = contains(default_server, sphere)
    for _ in range(2):
        post(default_server, path, CSV, 160_000_000).send(b"L,a,b\n" + b"50,0,0\n" * 700)
    wait_for_bodies(default_server, 2)
    for media_type, body in ((JSON, b'{"colours": [[50, 0, 0]]}'), (CSV, b"L,a,b\n50,0,0\n")):
        fields = {"Content-Type": media_type}
        answer = default_server.client.post(path, content=body, headers=fields)
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
def test_the_memory_of_arriving_bodies_is_bounded(default_server, post, kind):
    """Today's attacks: hundreds of bodies of about a megabyte, none of them complete."""
    media_type, body = BODIES[kind]
    count = 150_000_000 // len(body)
    before = resident(default_server)
    for number in range(count):
        begun = post(default_server, "/v1/gamuts", media_type, len(body) + 10, f"192.0.2.{number}")
        begun.send(body)
    wait_for_bytes(default_server, count * (len(body) - 10_000))
    # 64 KiB of each body, and as much in the buffer of its connection
    assert resident(default_server) - before < 2 * count * bodies.IN_MEMORY + 64 * MEBIBYTE


def resident(server):
    status = Path(f"/proc/{server.process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) * 1024


@pytest.mark.parametrize(
    ("parts", "field"),
    [
        (part("other", b"", file=True), "other"),
        (part("file", b"x", file=True) + part("file", b"", file=True), "file"),
    ],
)
def test_parts_that_nobody_wants_are_refused_as_they_arrive(tight_server, post, parts, field):
    begun = post(tight_server, "/v1/gamuts", FORM, 900_000)
    begun.send(parts)
    status, _, document = begun.answer()
    assert (status, document["code"]) == (422, "invalid-body")
    assert document["where"] == {"field": field}


def test_the_slowest_body_gives_way_when_too_many_arrive(tight_server, post):
    slow = post(tight_server, "/v1/gamuts", JSON, 900_000, "192.0.2.0")
    wait_for_bodies(tight_server, 1)
    others = []
    for number in range(7):
        others.append(post(tight_server, "/v1/gamuts", JSON, 100_000, f"192.0.2.{number}"))
        others[-1].send(b"[" + b" " * 80_000)
        wait_for_bytes(tight_server, (number + 1) * 80_000)
    newcomer = post(tight_server, "/v1/gamuts", JSON, 2, "192.0.2.8")
    status, fields, document = slow.answer()
    assert (status, document["code"]) == (408, "request-timeout")
    assert int(fields["retry-after"]) > 0
    newcomer.send(b"[]")
    assert newcomer.answer()[0] == 422
    for other in others:
        other.send(b" " * 19_998 + b"]")
        assert other.answer()[2]["code"] == "invalid-body"


def test_one_client_leaves_a_share_of_the_places_to_others(tight_server, post):
    for number in range(6):
        post(tight_server, "/v1/gamuts", JSON, 2, "192.0.2.1")
        wait_for_bodies(tight_server, number + 1)
    status, fields, document = post(tight_server, "/v1/gamuts", JSON, 2, "192.0.2.1").answer()
    assert (status, document["code"]) == (429, "share-exceeded")
    assert int(fields["retry-after"]) > 0
    other = post(tight_server, "/v1/gamuts", JSON, 2, "192.0.2.2")
    wait_for_bodies(tight_server, 7)
    other.send(b"[]")
    assert other.answer()[0] == 422


def test_the_slowest_body_gives_way_to_the_bytes_of_others(tight_server, post):
    begun = []
    for number in range(4):
        begun.append(post(tight_server, "/v1/gamuts", JSON, 250_000, f"192.0.2.{number}"))
        begun[-1].send(b"[" + b" " * 239_999)
        wait_for_bytes(tight_server, (number + 1) * 240_000)
    greedy = post(tight_server, "/v1/gamuts", JSON, 250_000, "192.0.2.3")
    greedy.send(b"[" + b" " * 100_000)
    status, fields, document = greedy.answer()
    assert (status, document["code"]) == (429, "share-exceeded")
    assert int(fields["retry-after"]) > 0
    newcomer = post(tight_server, "/v1/gamuts", JSON, 100_000, "192.0.2.9")
    newcomer.send(b"[" + b" " * 99_998 + b"]")
    assert newcomer.answer()[2]["code"] == "invalid-body"
    status, _, document = begun[0].answer()  # all have the same size, so the oldest is the slowest
    assert (status, document["code"]) == (408, "request-timeout")


def test_bodies_that_wait_for_memory_are_bounded_in_bytes(tmp_path, monkeypatch, assert_problem):
    """The store keeps no file until the end: two files are in memory, two more fill the spool."""
    gate, entered, keep = threading.Event(), threading.Semaphore(0), GamutStore.keep_input

    def keep_behind_the_gate(*arguments):
        entered.release()
        assert gate.wait(HANG)
        return keep(*arguments)

    monkeypatch.setattr(GamutStore, "keep_input", keep_behind_the_gate)
    store = GamutStore(LocalBlobs(tmp_path))
    store.open()
    store.close()
    monkeypatch.setattr(bodies, "SHARE", 0.5)
    app = create_app(Settings(store=str(tmp_path), max_body_bytes=2_100_000, spool_bytes=4_200_000))

    async def post(number, size):
        transport = httpx.ASGITransport(app, client=(f"192.0.2.{number}", 1))
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            fields = {"Prefer": "respond-async"}
            return await client.post("/v1/gamuts", files={"file": bytes(size)}, headers=fields)

    async def scenario():
        posts = []
        for number in range(2):
            posts.append(asyncio.create_task(post(number, 2_000_000 + number)))
            assert await asyncio.to_thread(entered.acquire, timeout=HANG)
        posts += [asyncio.create_task(post(number, 2_000_000 + number)) for number in (2, 3)]
        spooled = app.state.service.spool
        while spooled.nbytes < 4_000_000 or spooled.arriving:  # noqa: ASYNC110 - no event says so
            await asyncio.sleep(0.01)
        refused = await post(9, 1_000_000)
        gate.set()
        return refused, await asyncio.gather(*posts)

    refused, others = asyncio.run(asyncio.wait_for(scenario(), HANG))
    assert_problem(refused, 503, "spool-full")
    assert int(refused.headers["retry-after"]) > 0
    assert {answer.status_code for answer in others} == {202}


def test_a_full_scratch_folder_is_called_that(request_app, tmp_path, monkeypatch, assert_problem):
    app = create_app(Settings(store=str(tmp_path)))
    monkeypatch.setattr(
        bodies.tempfile,
        "TemporaryFile",
        lambda **_: Path("/dev/full").open("w+b"),  # noqa: SIM115
    )
    answer = request_app(app, "POST", "/v1/gamuts", files={"file": bytes(100_000)})
    document = assert_problem(answer, 507, "scratch-full")
    assert "scratch" in document["title"]
    few = request_app(app, "POST", "/v1/gamuts", json=[])
    assert few.status_code == 422
