"""Use the installed packages as a newcomer would: a gamut built with gamutcore, one over HTTP.

``smoke.py FILE [ADDRESS]`` takes characterisation data and the address of a running service.
Without an address, it starts the installed console script on a free port with its own data folder.
``smoke.py --core FILE`` uses gamutcore alone and checks that no web package is imported. The script
is meant for a clean environment outside the checkout, where only the wheel can be imported.
"""

from __future__ import annotations

import http.client
import importlib.metadata
import json
import os
import re
import socket
import struct
import subprocess
import sys
import sysconfig
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__: list[str] = []

TRIANGLES = 100
WEB_PACKAGES = {"fastapi", "pydantic", "service", "starlette", "uvicorn"}
START_SECONDS = 600


def expect(condition: bool, what: str) -> None:
    """End with what was expected where it does not hold; unlike assert, under -O too."""
    if not condition:
        message = f"smoke test: expected {what}"
        raise SystemExit(message)


def glb_triangles(glb: bytes) -> int:
    """Return the triangle count that a GLB's JSON chunk states (glTF 2.0, section 4.4)."""
    magic, version, length, json_length, json_kind = struct.unpack_from("<4sIIII", glb)
    expect((magic, version, length) == (b"glTF", 2, len(glb)), "a GLB header that fits its length")
    expect(json_kind == 0x4E4F534A, "the JSON chunk first")
    document = json.loads(glb[20 : 20 + json_length])
    primitive = document["meshes"][0]["primitives"][0]
    return int(document["accessors"][primitive["indices"]]["count"]) // 3


def check_core(data: bytes) -> str:
    """Build a gamut with gamutcore alone, look at a level, and return the gamut's id."""
    import gamutcore
    from gamutcore.export import mesh_file
    from gamutcore.gamut import Options, build_gamut

    site = Path(sysconfig.get_path("purelib")).resolve()
    package = Path(gamutcore.__file__).resolve()
    expect(site in package.parents, f"gamutcore from {site}, not {package}")
    version = importlib.metadata.version("gamut-boundary-service")

    gamut = build_gamut(data, Options(surface_samples=2000))
    mesh = gamut.history.level(TRIANGLES)
    expect(glb_triangles(mesh_file(mesh, "glb", {})) == TRIANGLES, f"{TRIANGLES} triangles")
    print(f"gamutcore {version}: {gamut.history.triangles} triangles, levels down to 4")
    return str(gamut.id)


def check_service(address: str, data: bytes, name: str) -> None:
    """Post the data, read the description and download a level."""
    boundary = "smoke-test-boundary"
    head = f'--{boundary}\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n\r\n'
    body = head.encode() + data + f"\r\n--{boundary}--\r\n".encode()
    form = {"Content-Type": f"multipart/form-data; boundary={boundary}"}
    with urlopen(Request(f"{address}/v1/gamuts", body, form), timeout=60) as answer:
        gamut = json.load(answer)
        expect(answer.status in {200, 201}, f"200 or 201, not {answer.status}")
    expect(re.fullmatch("[0-9a-f]{64}", gamut["id"]) is not None, "an id of 64 hexadecimal digits")
    with urlopen(f"{address}/v1/gamuts/{gamut['id']}/mesh?triangles={TRIANGLES}") as answer:
        glb = answer.read()
        expect(answer.headers["Content-Type"] == "model/gltf-binary", "model/gltf-binary")
    expect(glb_triangles(glb) == TRIANGLES, f"{TRIANGLES} triangles from the service")
    with urlopen(f"{address}/docs") as answer:
        page = answer.read().decode()
    for file in re.findall(r'(?:src|href)="(/[^"]+)"', page):
        with urlopen(f"{address}{file}") as answer:
            expect(len(answer.read()) > 100_000, f"{file}, which the documentation is made of")
    print(f"service: gamut {gamut['id'][:12]} built, {TRIANGLES} triangles in {len(glb)} bytes")


@contextmanager
def served() -> Iterator[str]:
    """Yield the address of a service started for this test."""
    with tempfile.TemporaryDirectory() as folder:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        environment = {**os.environ, "GAMUT_STORE": folder, "GAMUT_PORT": str(port)}
        script = str(Path(sys.executable).parent / "gamut")
        server = subprocess.Popen([script, "serve"], env=environment)
        try:
            address = f"http://127.0.0.1:{port}"
            wait_until_ready(address, server)
            yield address
        finally:
            server.terminate()
            server.wait(timeout=30)


def wait_until_ready(address: str, server: subprocess.Popen[bytes]) -> None:
    """Return once the service answers that it is ready."""
    deadline = time.monotonic() + START_SECONDS
    while server.poll() is None and time.monotonic() < deadline:
        connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=5)
        try:
            connection.request("GET", "/readyz")
            if connection.getresponse().status == http.HTTPStatus.OK:
                return
        except OSError:
            pass
        finally:
            connection.close()
        time.sleep(0.1)
    message = f"smoke test: the service is not ready (exit code {server.poll()})"
    raise SystemExit(message)


def main() -> None:
    """Check the packages, then the service."""
    core_only = sys.argv[1] == "--core"
    file, *addresses = sys.argv[2:] if core_only else sys.argv[1:]
    data = Path(file).read_bytes()
    check_core(data)
    if core_only:
        web = sorted(WEB_PACKAGES & sys.modules.keys())
        expect(not web, f"no web package in gamutcore, not {', '.join(web)}")
    elif addresses:
        check_service(addresses[0], data, Path(file).name)
    else:
        with served() as address:
            check_service(address, data, Path(file).name)


if __name__ == "__main__":
    main()
