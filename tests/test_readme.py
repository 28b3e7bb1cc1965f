"""The commands of the README, run as printed except for the port."""

import json
import os
import re
import signal
import socket
import subprocess
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest
import trimesh

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
ADDRESS = "http://127.0.0.1:8000"
START_SECONDS = 300
"""Enough for `make serve` to install everything. The start-up benchmark measures the time."""


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)


def commands(block):
    """Return the commands of a shell block without comments and blank lines."""
    lines = [re.sub(r"\s+#.*", "", line) for line in block.replace("\\\n", " ").splitlines()]
    return [line.strip() for line in lines if line.strip() and not line.startswith("#")]


FIRST, _, _, CURL = blocks("sh")


@pytest.fixture
def folder(tmp_path):
    """A folder with the examples and nothing that a command could overwrite."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    return tmp_path


@pytest.fixture
def address(tmp_path_factory):
    """Address of the service that `make serve` starts, on a free port with a new data directory."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))
    }
    environment["GAMUT_STORE"] = str(tmp_path_factory.mktemp("data"))
    environment["GAMUT_PORT"] = str(port)
    # Beside other tests the build may take longer than the 30 s after which POST answers 202.
    environment["GAMUT_CLIENT_WAIT"] = str(START_SECONDS)
    output = (tmp_path_factory.mktemp("log") / "serve.txt").open("w+b")
    command = commands(FIRST)[0]
    server = subprocess.Popen(
        ["bash", "-c", command],
        cwd=ROOT,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=output,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )
    address = f"http://127.0.0.1:{port}"
    try:
        deadline = time.monotonic() + START_SECONDS
        while True:
            try:
                urllib.request.urlopen(f"{address}/readyz", timeout=5).close()
                break
            except (urllib.error.URLError, ConnectionError, TimeoutError):
                if server.poll() is not None or time.monotonic() > deadline:
                    output.seek(0)
                    pytest.fail(f"{command} does not serve:\n{output.read().decode()}")
                time.sleep(0.2)
        yield address
    finally:
        if server.poll() is None:
            os.killpg(server.pid, signal.SIGINT)  # as Ctrl-C does
            server.wait(timeout=START_SECONDS)
        output.close()


def test_it_is_short_and_starts_with_the_two_commands():
    assert len(README.splitlines()) < 120
    assert commands(FIRST) == ["make serve", "make test"]
    assert README.index("```") < README.index("\n## ")


def test_ci_runs_the_test_command_that_it_prints():
    """Run only the function of .ci/run that reads the command."""
    script = (ROOT / ".ci/run").read_text()
    function = re.search(r"^test_command\(\) \{\n.*?^\}\n", script, re.MULTILINE | re.DOTALL)
    read = subprocess.run(
        ["bash", "-c", f"{function[0]}test_command"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert read.stdout.splitlines() == [commands(FIRST)[1]]


@pytest.mark.slow
def test_the_curl_commands_download_the_gamut_of_a_press_with_1000_triangles(folder, address):
    assert all(ADDRESS in command for command in commands(CURL))
    post, download = (command.replace(ADDRESS, address) for command in commands(CURL))
    (gamut,) = re.findall(r"/v1/gamuts/([0-9a-f]{64})/mesh", download)
    posted = subprocess.run(
        ["bash", "-c", post], cwd=folder, capture_output=True, text=True, check=True
    )
    described = json.loads(posted.stdout)
    assert described["id"] == gamut
    assert described["counts"]["triangles"] > 1000
    subprocess.run(["bash", "-c", download], cwd=folder, check=True)

    (file,) = folder.glob("*.glb")
    mesh = trimesh.load(file, force="mesh", process=False)
    assert len(mesh.faces) == 1000
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0


@pytest.mark.slow
def test_the_python_example_writes_a_closed_mesh(folder, monkeypatch):
    """With fewer samples. The command of the README runs with those of the other documents."""
    (example,) = blocks("python")
    for call in ("ink_limit=300)", 'gc.reference("sRGB")'):
        assert example.count(call) == 1
        example = example.replace(call, f"{call[:-1]}, surface_samples=4000)")
    monkeypatch.chdir(folder)
    exec(compile(example, "README.md", "exec"), {})  # noqa: S102
    (file,) = folder.glob("*.ply")
    mesh = trimesh.load(file, process=False)
    assert len(mesh.faces) == 1000
    assert mesh.is_watertight
