"""One client with much work does not keep another one waiting.

Bounds are parts of the time of the whole attack, so they hold on any machine, and while other
programs use it. An answer that waits for all requests of the attacker exceeds them.
"""

import contextlib
import io
import json
import re
import socket
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image

pytestmark = pytest.mark.slow

PRESS = Path(__file__).parents[2] / "examples" / "FOGRA39L.ti3"
ATTACKER, OTHER = "192.0.2.1", "198.51.100.1"
COLOURS = {"colours": [[50, 0, 0]]}
HANG = 600


@pytest.fixture(scope="module")
def loaded(start_server):
    """A server behind a proxy, with two gamuts of a press."""
    server = start_server(trusted_proxies="127.0.0.1")
    server.wait_ready()
    server.gamuts = []
    for limit in (280, 300):
        answer = server.client.post(
            "/v1/gamuts",
            files={"file": PRESS.read_bytes()},
            data={"options": json.dumps({"surface_samples": 6000, "ink_limit": limit})},
        )
        assert answer.status_code == 201, answer.text
        server.gamuts.append(answer.json()["links"]["self"])
    return server


@pytest.fixture
def attack(loaded):
    """Send many requests of one client at once, and meanwhile ask questions of another one.

    Return the seconds of the attack, and of the slowest answer by question.
    """

    def send(client, method, path, **arguments):
        start = time.perf_counter()
        fields = {"X-Forwarded-For": client, **arguments.pop("headers", {})}
        answer = httpx.request(method, loaded.url + path, headers=fields, timeout=HANG, **arguments)
        assert answer.status_code == 200, answer.text
        return time.perf_counter() - start

    def run(count, request, questions):
        for question in questions:
            send(OTHER, *question[0], **question[1])
        send(ATTACKER, *request[0], **request[1])
        alone = send(ATTACKER, *request[0], **request[1])
        start = time.perf_counter()
        slowest = [0.0] * len(questions)
        with ThreadPoolExecutor(count) as threads:
            attacks = [
                threads.submit(send, ATTACKER, *request[0], **request[1]) for _ in range(count)
            ]
            time.sleep(alone / 2)  # all have arrived, and most of them wait
            while not all(each.done() for each in attacks):
                for number, question in enumerate(questions):
                    seconds = send(OTHER, *question[0], **question[1])
                    slowest[number] = max(slowest[number], seconds)
            assert [each.result() for each in attacks]
        return time.perf_counter() - start, slowest

    return run


def png(width, height):
    file = io.BytesIO()
    pixels = np.random.default_rng(1).integers(0, 256, (height, width, 3), np.uint8)
    Image.fromarray(pixels).save(file, "png")
    return {"content": file.getvalue(), "headers": {"Content-Type": "image/png"}}


def test_comparisons_of_full_boundaries_leave_turns_for_small_questions(loaded, attack):
    one, other = (address.rpartition("/")[2] for address in loaded.gamuts)
    comparison = ("GET", f"/v1/comparisons?a={one}&b={other}&max_error=0"), {}
    colours = ("POST", f"{loaded.gamuts[0]}/contains"), {"json": COLOURS}
    section = ("GET", f"{loaded.gamuts[0]}/slice?lightness=50"), {}
    whole, (single, sliced) = attack(20, comparison, [colours, section])
    assert single <= whole / 3
    assert sliced <= whole / 2


def test_a_small_picture_waits_for_one_large_one_at_most(loaded, attack):
    address = f"{loaded.gamuts[0]}/map?method=spatial&iterations=60"
    large, small = (("POST", address), png(400, 300)), (("POST", address), png(40, 40))
    whole, (waited,) = attack(6, large, [small])
    assert waited <= whole / 2


def test_tables_of_recipes_leave_turns_for_single_colours(loaded, attack):
    file = io.BytesIO()
    colours = np.random.default_rng(2).uniform((20, -40, -40), (90, 40, 40), (30_000, 3))
    np.save(file, colours.astype(np.float32))
    body = {"content": file.getvalue(), "headers": {"Content-Type": "application/x-npy"}}
    table = ("POST", f"{loaded.gamuts[0]}/recipes"), body
    whole, (single,) = attack(
        6, table, [(("POST", f"{loaded.gamuts[1]}/contains"), {"json": COLOURS})]
    )
    assert single <= whole / 3


@pytest.fixture(scope="module")
def small_server(start_server, sphere):
    """A server with the smallest default of the budget, and the address of a gamut."""
    server = start_server(trusted_proxies="127.0.0.1", memory_bytes=448 * 2**20)
    server.wait_ready()
    created = server.client.post("/v1/gamuts", json={"samples": sphere(seed=79)}).json()
    server.gamut = created["links"]["self"]
    return server


@pytest.fixture
def unread(small_server):
    """Post tables whose answers a client does not read until the test ends."""
    with contextlib.ExitStack() as connections:

        def post(rows):
            address = small_server.url.removeprefix("http://").split(":")
            connection = connections.enter_context(socket.socket())
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            connection.connect((address[0], int(address[1])))
            body = b"L,a,b\n" + b"50.5,1.25,-3.75\n" * rows
            head = (
                f"POST {small_server.gamut}/nearest HTTP/1.1\r\nHost: localhost\r\n"
                f"X-Forwarded-For: {ATTACKER}\r\nContent-Type: text/csv\r\n"
                f"Content-Length: {len(body)}\r\n\r\n"
            )
            connection.sendall(head.encode() + body)

        yield post
    small_server.wait_for(lambda: unsent(small_server) == 0)


def unsent(server):
    """Bytes of answers that are not sent."""
    text = server.client.get("/metrics").text
    counted = re.search(r'(?m)^gamut_memory_charged_bytes\{kind="answers"\} (\S+)', text)
    return float(counted[1]) if counted else 0.0


def test_answers_that_one_client_does_not_read_stop_no_other_client(small_server, unread):
    """An answer in pieces takes half of the budget; the second of the client has to wait."""
    for _ in range(4):
        unread(200_000)
    small_server.wait_for(lambda: unsent(small_server) > 50e6)
    for lightness in range(40, 50):
        fields = {"X-Forwarded-For": OTHER}
        address = f"{small_server.url}{small_server.gamut}/slice?lightness={lightness}"
        assert httpx.get(address, headers=fields, timeout=HANG).status_code == 200


def test_a_complete_answer_counts_until_it_is_read(small_server, unread):
    unread(60_000)  # more than the buffers of the system take
    small_server.wait_for(lambda: unsent(small_server) > 5e6)
