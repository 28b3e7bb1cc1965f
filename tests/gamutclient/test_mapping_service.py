"""The example of a gamut-mapping microservice, between a real client and a real gamut service."""

import asyncio
import io
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import httpx
import numpy as np
import pytest

import gamutcore

ROOT = Path(__file__).parents[2]
RUNNING = re.compile(r"Uvicorn running on (http://127\.0\.0\.1:\d+)")
REQUESTS, ROWS = 100, 500

SAMPLES = 4000
PATIENT_AND_COARSE = f"""
import functools, httpx, uvicorn
from gamutclient import clients
clients.TIMEOUT = httpx.Timeout(600.0)
clients.AsyncClient.build = functools.partialmethod(
    clients.AsyncClient.build, surface_samples={SAMPLES}
)
uvicorn.main()
"""


@pytest.fixture(scope="module")
def mapping_service(server, tmp_path_factory):
    log = tmp_path_factory.mktemp("mapping") / "log"
    with log.open("wb") as output:
        process = subprocess.Popen(
            [
                *(sys.executable, "-c", PATIENT_AND_COARSE, "--app-dir", ROOT / "examples"),
                *("mapping_service:app", "--port", "0"),
            ],
            env={
                **os.environ,
                "GAMUT_SERVICE": server.url,
                "PYTHONPATH": str(ROOT / "client"),
                "PYTHONDONTWRITEBYTECODE": "1",  # examples/ has only what its README lists
            },
            stdout=output,
            stderr=subprocess.STDOUT,
        )
    try:
        deadline = time.monotonic() + 600
        while not (found := RUNNING.search(log.read_text())):
            assert process.poll() is None, log.read_text()
            assert time.monotonic() < deadline, log.read_text()
            time.sleep(0.05)
        yield found[1]
    finally:
        process.terminate()
        process.wait(600)


def npy(colours):
    file = io.BytesIO()
    np.save(file, colours)
    return file.getvalue()


@pytest.mark.slow
def test_a_hundred_requests_in_flight(mapping_service):
    """All are answered, each as gamutcore answers."""
    random = np.random.default_rng(5)
    batches = random.uniform((0, -80, -80), (100, 80, 80), (REQUESTS, ROWS, 3))

    async def ask():
        limits = httpx.Limits(max_connections=REQUESTS)
        address = f"{mapping_service}/map"
        async with httpx.AsyncClient(timeout=600, limits=limits) as client:
            posted = [client.post(address, content=npy(batch)) for batch in batches]
            return await asyncio.gather(*posted)

    answers = asyncio.run(ask())
    assert {answer.status_code for answer in answers} == {200}
    path = ROOT / "examples" / "FOGRA39L.ti3"
    press = gamutcore.Gamut(path, ink_limit=300, surface_samples=SAMPLES)
    for number in (0, 57, 99):
        mapped = np.load(io.BytesIO(answers[number].content))
        expected = press.map(batches[number], max_error=0.5).points
        np.testing.assert_allclose(mapped, expected, rtol=0, atol=1e-9)


def test_errors_pass_through(mapping_service):
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 3)}\n"
    huge = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
    faulty = [
        b"",
        b"no array",
        b"PK\x03\x04",
        huge,
        npy(np.zeros((5, 4))),
        npy(np.array(["a"] * 3)),
    ]
    for content in faulty:
        assert httpx.post(f"{mapping_service}/map", content=content, timeout=600).status_code == 422
    answer = httpx.post(
        f"{mapping_service}/map?method=clip-hoe", content=npy(np.zeros((1, 3))), timeout=600
    )
    assert answer.status_code == 422
    assert answer.json()["detail"]["code"] == "invalid-parameter"
