"""One client with much work does not keep another one waiting.

Bounds are multiples of the time of one request of the attack, so they hold on any machine. The
attacker's requests one after the other would exceed them.
"""

import io
import json
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
            data={"options": json.dumps({"surface_samples": 15_000, "ink_limit": limit})},
        )
        assert answer.status_code == 201, answer.text
        server.gamuts.append(answer.json()["links"]["self"])
    return server


@pytest.fixture
def attack(loaded):
    """Send many requests of one client at once, and meanwhile ask questions of another one.

    Return the seconds of one request of the attack alone, and of the slowest answer by question.
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
        return alone, slowest

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
    alone, (single, sliced) = attack(40, comparison, [colours, section])
    assert single <= 4 * alone + 0.2
    assert sliced <= 8 * alone + 0.2


def test_a_small_picture_waits_for_one_large_one_at_most(loaded, attack):
    address = f"{loaded.gamuts[0]}/map?method=spatial&iterations=100"
    large, small = (("POST", address), png(400, 300)), (("POST", address), png(40, 40))
    alone, (waited,) = attack(4, large, [small])
    assert waited <= 2 * alone


def test_tables_of_recipes_leave_turns_for_single_colours(loaded, attack):
    file = io.BytesIO()
    colours = np.random.default_rng(2).uniform((20, -40, -40), (90, 40, 40), (30_000, 3))
    np.save(file, colours.astype(np.float32))
    body = {"content": file.getvalue(), "headers": {"Content-Type": "application/x-npy"}}
    table = ("POST", f"{loaded.gamuts[0]}/recipes"), body
    alone, (single,) = attack(
        6, table, [(("POST", f"{loaded.gamuts[1]}/contains"), {"json": COLOURS})]
    )
    assert single <= alone
