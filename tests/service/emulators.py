"""Emulators of object stores, as processes on loopback: moto's server for S3, Azurite for Azure."""

import base64
import contextlib
import hashlib
import hmac
import re
import shutil
import subprocess
import sys
import time
from email.utils import formatdate
from pathlib import Path

import httpx

START_SECONDS = 600

AMAZON = Path(__file__).with_name("amazon_storage.py")

AZURITE = Path(__file__).parents[1] / "azurite" / "node_modules" / ".bin" / "azurite-blob"

AZURE_ACCOUNT = "devstoreaccount1"
AZURE_KEY = (  # the well-known one of the emulator, in its documentation
    "Eby8vdM02xNOcqFlqUwJPLlmEtlCDXJ1OUzFT50uSRZ6IFsuFq2UVErCz4I6tq/K1SZFPTOtr/KBHBeksoGMGw=="
)


@contextlib.contextmanager
def running(command, log, pattern):
    """Start a process and yield the first group of a pattern in its output; end it at the end."""
    with log.open("wb") as output:
        process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
    try:
        deadline = time.monotonic() + START_SECONDS
        while not (found := re.search(pattern, log.read_text())):
            assert process.poll() is None, log.read_text()
            assert time.monotonic() < deadline, log.read_text()
            time.sleep(0.05)
        yield found[1]
    finally:
        process.terminate()
        process.wait(START_SECONDS)


@contextlib.contextmanager
def s3_server(folder):
    """Moto's server on a free port; yields the environment that obstore finds it with."""
    command = [sys.executable, "-W", "ignore", str(AMAZON), "-H", "127.0.0.1", "-p", "0"]
    with running(command, folder / "log", r"Running on (http://127\.0\.0\.1:\d+)") as url:
        httpx.put(f"{url}/bucket", timeout=START_SECONDS).raise_for_status()
        yield {
            "AWS_ENDPOINT": url,
            "AWS_ALLOW_HTTP": "true",
            "AWS_REGION": "us-east-1",
            "AWS_ACCESS_KEY_ID": "any",
            "AWS_SECRET_ACCESS_KEY": "unchecked-by-moto",
        }


def azurite_missing():
    """Why Azurite cannot be started here; empty if it can."""
    if AZURITE.exists() and shutil.which("node"):
        return ""
    return "Azurite is not installed: run `make test`, or npm ci in tests/azurite"


@contextlib.contextmanager
def azure_server(folder):
    """Azurite on a free port; yields the environment that obstore finds it with."""
    command = [AZURITE, "--blobHost", "127.0.0.1", "--blobPort", "0", "--inMemoryPersistence"]
    command += ["--disableTelemetry", "--skipApiVersionCheck", "--silent"]
    with running(command, folder / "log", r"listens on (http://127\.0\.0\.1:\d+)") as url:
        create_container(f"{url}/{AZURE_ACCOUNT}", "bucket")
        yield {
            "AZURE_ENDPOINT": f"{url}/{AZURE_ACCOUNT}",
            "AZURE_ALLOW_HTTP": "true",
            "AZURE_STORAGE_ACCOUNT_NAME": AZURE_ACCOUNT,
            "AZURE_STORAGE_ACCOUNT_KEY": AZURE_KEY,
        }


def create_container(endpoint, name):
    """Create a container: a request signed with the shared key, which obstore does not have."""
    headers = {"x-ms-date": formatdate(usegmt=True), "x-ms-version": "2021-08-06"}
    signed = "PUT" + "\n" * 12 + "".join(f"{key}:{value}\n" for key, value in headers.items())
    signed += f"/{AZURE_ACCOUNT}/{AZURE_ACCOUNT}/{name}\nrestype:container"
    digest = hmac.new(base64.b64decode(AZURE_KEY), signed.encode(), hashlib.sha256).digest()
    headers["Authorization"] = f"SharedKey {AZURE_ACCOUNT}:{base64.b64encode(digest).decode()}"
    headers["Content-Length"] = "0"
    httpx.put(
        f"{endpoint}/{name}?restype=container", headers=headers, timeout=START_SECONDS
    ).raise_for_status()
