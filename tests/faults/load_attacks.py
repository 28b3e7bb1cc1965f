"""Attack a server with much work of one client, and measure what another client waits.

The clients have two addresses behind a proxy. The gamuts are FOGRA39L with different ink limits, of
140,000 triangles each. Every attack is sent at once. Meanwhile the other client asks one question
after the other, until the attack ends or `--seconds` are over. The program prints a line for each
attack, and exits with 1 if a goal is missed. Goals in seconds are those of a quiet machine of two
cores.
"""

import argparse
import asyncio
import contextlib
import io
import json
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from memory_attacks import Watch, built
from PIL import Image
from serving import PATIENCE, Serving

ATTACKER, OTHER = "192.0.2.1", "198.51.100.1"
COLOURS = json.dumps({"colours": [[50, 0, 0]]}).encode()
JSON, NPY, PNG = "application/json", "application/x-npy", "image/png"
SPATIAL = "map?method=spatial&iterations=100"


@dataclass
class Request:
    """A request, and who sends it."""

    path: str
    body: bytes | None = None
    media_type: str = JSON
    client: str = OTHER

    async def send(self, port):
        """Send it; return the status and the seconds until all of the answer has arrived."""
        body, start = self.body or b"", time.perf_counter()
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        try:
            head = (
                f"{'GET' if self.body is None else 'POST'} {self.path} HTTP/1.1\r\n"
                f"Host: localhost\r\nX-Forwarded-For: {self.client}\r\nConnection: close\r\n"
                f"Content-Type: {self.media_type}\r\nContent-Length: {len(body)}\r\n\r\n"
            )
            writer.write(head.encode() + body)
            status = int((await reader.readline()).split()[1])
            while await reader.read(1 << 20):
                pass
        finally:
            writer.close()
        return status, time.perf_counter() - start


@dataclass
class Attack:
    """Requests at once, and questions of another client, with their goals.

    Each list of requests is sent one after the other.
    """

    requests: list[list[Request]]
    questions: dict[str, tuple[Request, float]]
    """Questions by name, with the largest 99th percentile in seconds."""

    async def run(self, port, seconds):
        """Return the figures of an attack."""
        tasks = [asyncio.create_task(self.send_all(port, each)) for each in self.requests]
        await asyncio.sleep(0.5)  # the attack has arrived
        asked = await asyncio.gather(
            *(self.ask(port, tasks, *question) for question in self.questions.values()),
            asyncio.wait(tasks, timeout=seconds),
        )
        for task in tasks:
            task.cancel()
        ended = [task.result() for task in tasks if task.done() and not task.cancelled()]
        answers = Counter(str(status) for statuses in ended for status in statuses)
        return {
            "attack": dict(answers),
            "unfinished": len(tasks) - len(ended),
            **dict(zip(self.questions, asked, strict=False)),
        }

    async def send_all(self, port, requests):
        """Send requests one after the other; return their statuses."""
        return [(await each.send(port))[0] for each in requests]

    async def ask(self, port, tasks, request, goal):
        """Ask one question again and again; return its figures."""
        found = []
        while True:
            found.append(await asyncio.wait_for(request.send(port), PATIENCE))
            if all(task.done() for task in tasks) or len(found) >= 500:
                break
            await asyncio.sleep(0.05)
        p99 = float(np.percentile([seconds for _, seconds in found], 99))
        statuses = Counter(str(status) for status, _ in found)
        good = p99 <= goal and set(statuses) == {"200"}
        return {"statuses": dict(statuses), "p99": round(p99, 2), "goal": goal, "met": good}


def comparisons(ids, count):
    """Full boundaries are compared, while another client asks small questions."""
    *many, own = ids
    pairs = [(many[n % len(many)], many[(7 * n + 1) % len(many)]) for n in range(count)]
    attack = [
        [Request(f"/v1/comparisons?a={one}&b={other}&max_error=0", client=ATTACKER)]
        for one, other in pairs
    ]
    address = f"/v1/gamuts/{own}"
    return Attack(
        attack,
        {
            "single colours": (Request(f"{address}/contains", COLOURS), 1.0),
            "cusps": (Request(f"{address}/cusps"), 3.0),
            "slice": (Request(f"{address}/slice?lightness=50"), 3.0),
        },
    )


def picture(width, height):
    """Return a picture of distinct colours as PNG."""
    pixels = np.random.default_rng(1).integers(0, 256, (height, width, 3), np.uint8)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "png", compress_level=1)
    return file.getvalue()


def pictures(ids, port, count, megapixels):
    """Large pictures are mapped, while another client sends a small one."""
    large = picture(2000, int(500 * megapixels))
    address = f"/v1/gamuts/{ids[0]}/{SPATIAL}"
    one = asyncio.run(Request(address, large, PNG).send(port))
    attack = [[Request(address, large, PNG, ATTACKER)] for _ in range(count)]
    small = Request(f"/v1/gamuts/{ids[1]}/{SPATIAL}", picture(40, 40), PNG)
    return Attack(attack, {"40 × 40 picture": (small, round(1.2 * one[1], 2))})


def recipes(ids, count, rows):
    """Recipes are computed, while another client asks single colours."""
    file = io.BytesIO()
    colours = np.random.default_rng(2).uniform((20, -40, -40), (90, 40, 40), (rows, 3))
    np.save(file, colours.astype(np.float32))
    attack = [
        [Request(f"/v1/gamuts/{ids[0]}/recipes", file.getvalue(), NPY, ATTACKER)]
        for _ in range(count)
    ]
    question = Request(f"/v1/gamuts/{ids[-1]}/contains", COLOURS)
    return Attack(attack, {"single colours": (question, 1.0)})


def mixed(ids, count):
    """Many clients ask all kinds of questions."""
    kinds = [
        ("contains", COLOURS),
        ("mesh?triangles=1000", None),
        ("cusps?hues=36", None),
        ("picture.png?size=200", None),
        ("nearest", COLOURS),
        ("slice?lightness=50", None),
    ]
    attack = [
        [
            Request(f"/v1/gamuts/{ids[n % len(ids)]}/{path}", body, client=f"203.0.113.{n % 200}")
            for path, body in (kinds[(n + turn) % len(kinds)] for turn in range(12))
        ]
        for n in range(count)
    ]
    question = Request(f"/v1/gamuts/{ids[-1]}/contains", COLOURS)
    return Attack(attack, {"single colours": (question, 1.0)})


@contextlib.contextmanager
def serving(store, **settings):
    """Start a server that takes the address of the client from the proxy."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        server = Serving(store, log, trusted_proxies="127.0.0.1", **settings)
        try:
            server.wait_ready()
            yield server
            assert "Traceback" not in server.log(), server.log()[-5000:]
        finally:
            server.end()


def warm(server, ids):
    """Load kernels and libraries, which take seconds at first use; open the last gamut."""
    for path in ("cusps", "slice?lightness=50", "picture.png?size=64", "mesh?triangles=1000"):
        server.client.get(f"/v1/gamuts/{ids[-1]}/{path}").raise_for_status()
    for name in ("contains", "nearest", "recipes"):
        body = {"colours": [[50, 0, 0]]}
        server.client.post(f"/v1/gamuts/{ids[-1]}/{name}", json=body).raise_for_status()


def summary(name, figures):
    """Describe what another client waited, and what became of the attack."""
    waits = [
        f"{question} {wait['p99']:.2f} s" + ("" if wait["met"] else f" (goal {wait['goal']:g} s)")
        for question, wait in figures.items()
        if isinstance(wait, dict) and "p99" in wait
    ]
    statuses = ", ".join(f"{count} × {status}" for status, count in figures["attack"].items())
    return (
        f"{name}: p99 of {', '.join(waits)}; attack {statuses}; "
        f"`/livez` p99 {figures['livez_p99_ms']:.0f} ms; peak {figures['peak_mb']} MB"
    )


def main():
    """Run all attacks and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gamuts", type=int, default=8)
    parser.add_argument("--scale", type=float, default=1.0, help="part of the requests")
    parser.add_argument("--seconds", type=float, default=300, help="longest attack")
    parser.add_argument("--store", type=Path, help="directory that keeps the gamuts")
    parser.add_argument("--only", help="names of attacks, separated by commas")
    arguments = parser.parse_args()

    def scaled(count):
        return max(2, round(arguments.scale * count))

    def pictures_at(ids, server):
        return pictures(ids, server.port, scaled(6), 4)

    attacks = {
        "comparisons": (800e6, lambda ids, _: comparisons(ids, scaled(100))),
        "comparisons of 1.93 GB": (1.93e9, lambda ids, _: comparisons(ids, scaled(200))),
        "pictures": (2.5e9, pictures_at),
        "recipes": (800e6, lambda ids, _: recipes(ids, scaled(6), 100_000)),
        "mixed": (800e6, lambda ids, _: mixed(ids, scaled(200))),
    }
    figures = {}
    with tempfile.TemporaryDirectory() as folder:
        store = arguments.store or Path(folder) / "store"
        ids = built(store, arguments.gamuts)[:-1]
        for name, (budget, attack) in attacks.items():
            if arguments.only and name not in arguments.only.split(","):
                continue
            with serving(store, memory_bytes=int(budget)) as server:
                warm(server, ids)
                made = attack(ids, server)
                server.reset_peak()
                with Watch(server) as watch:
                    figures[name] = asyncio.run(made.run(server.port, arguments.seconds))
                figures[name] |= {
                    "livez_p99_ms": round(1e3 * float(np.percentile(watch.latencies, 99)), 1),
                    "peak_mb": round(server.peak() / 1e6),
                    "budget_mb": round(budget / 1e6),
                }
            print(summary(name, figures[name]), flush=True)
    parts = [part for each in figures.values() for part in each.values() if isinstance(part, dict)]
    met = all(part.get("met", True) for part in parts)
    return (
        0 if met and all(each["peak_mb"] <= each["budget_mb"] for each in figures.values()) else 1
    )


if __name__ == "__main__":
    sys.exit(main())
