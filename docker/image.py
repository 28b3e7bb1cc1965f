"""Build the container image with buildah, and use the image as a deployment does.

``docker/image.py`` needs Debian, root, buildah, debootstrap and python3-venv. It needs no container
engine, no privileges beyond root, and no image registry: the base image is made by debootstrap. The
build itself has no network. Its packages come from a directory of wheels, which this machine's pip
fills first. Everything lies in a temporary directory, which is removed at the end.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.request import urlopen

from gamutcore.version import __version__

__all__: list[str] = []

CHECKOUT = Path(__file__).resolve().parent.parent
BASE = "localhost/debian-python"
LOCKS = ("requirements.txt", "requirements-build.txt")
SBOM = "/opt/gamut/sbom.cdx.json"
READY_SECONDS = 3.0
"""Goal for the time from start to ready, printed beside the figure."""
GIVE_UP_SECONDS = 300.0

STORAGE = '[storage]\ndriver = "vfs"\nrunroot = "{0}/run"\ngraphroot = "{0}/graph"\n'

LOAD_KERNELS = """
import llvmlite.binding
llvmlite.binding.get_host_cpu_name = lambda: 'nocona'
llvmlite.binding.get_host_cpu_features = llvmlite.binding.FeatureMap
from numba.core import event
from gamutcore.kernels import GROUPS
from gamutcore.warm import use_kernels
with event.install_recorder('numba:compile') as compilations:
    for group in GROUPS:
        use_kernels(group)
print(len(compilations.buffer), 'kernels compiled')
raise SystemExit(len(compilations.buffer) > 0)
"""
"""Fails where a kernel is compiled instead of loaded, on a CPU unlike the build machine's."""

UNWRITABLE = (
    "! find /bin /etc /lib /opt /sbin /usr -writable ! -type l -print -quit 2>/dev/null | grep ."
)
"""Fails where the user may write to a file of the image."""


PARTS = "du -sm /usr /opt/gamut/lib/python3*/site-packages/* | sort -rn | head -15"
"""What the image holds: Debian with Python, and the packages."""


def run(*command: str | Path) -> str:
    """Run a command in the checkout and return its output, which is printed where it fails."""
    ended = subprocess.run(command, check=False, capture_output=True, text=True, cwd=CHECKOUT)
    if ended.returncode != 0:
        line = " ".join(map(str, command))
        raise SystemExit(f"{ended.stdout}{ended.stderr}\n{line} failed ({ended.returncode})")
    return ended.stdout


def expect(condition: bool, expected: str) -> None:
    """End the program with what was expected where the condition does not hold."""
    if not condition:
        raise SystemExit(f"docker/image.py: expected {expected}")


def run_step(title: str, step: Callable[..., None], *arguments: Path | str) -> None:
    """Call a function and print how long it took."""
    started = time.monotonic()
    step(*arguments)
    print(f"{title}: {time.monotonic() - started:.0f} s", flush=True)


def build_base(folder: Path) -> None:
    """Commit a minimal Debian of this machine's release, with Python, as the base image."""
    release = run("sh", "-c", ". /etc/os-release && echo $VERSION_CODENAME").strip()
    root = folder / "base"
    packages = "--include=python3,python3-venv"
    run("debootstrap", "--variant=minbase", packages, release, root)
    for packages_cache in ("var/cache/apt/archives", "var/lib/apt/lists"):
        shutil.rmtree(root / packages_cache)
    container = run("buildah", "from", "scratch").strip()
    run("buildah", "copy", "--quiet", container, root, "/")
    run("buildah", "commit", "--quiet", "--rm", container, BASE)
    shutil.rmtree(root)


def download_packages(folder: Path) -> None:
    """Download what the Dockerfile installs, with the build backend, and configure pip to use it.

    The system's Python is the Python of the base image, therefore the wheels fit.
    """
    environment = folder / "venv"
    run("/usr/bin/python3", "-m", "venv", environment)
    download = ["download", "--quiet", "--require-hashes", f"--dest={folder / 'wheels'}"]
    for lock in LOCKS:
        run(environment / "bin" / "python", "-m", "pip", *download, "-r", f"docker/{lock}")
    (folder / "pip.conf").write_text("[global]\nno-index = true\nfind-links = /wheels\n")


def build_image(folder: Path, name: str) -> None:
    """Build the Dockerfile on the base image, without network."""
    volumes = {folder / "wheels": "/wheels", folder / "pip.conf": "/etc/pip.conf"}
    mounts = [f"--volume={source}:{target}:ro" for source, target in volumes.items()]
    # Only Docker's format has a health check.
    options = ["--quiet", "--pull-never", "--network=none", "--format=docker"]
    values = {"BASE": BASE, "VERSION": __version__, "REVISION": revision()}
    arguments = [f"--build-arg={key}={value}" for key, value in values.items()]
    run("buildah", "build", *options, *mounts, *arguments, f"--tag={name}", CHECKOUT)


@cache
def revision() -> str:
    """Return the commit that is checked out when the image is built."""
    return run("git", "rev-parse", "HEAD").strip()


class Service:
    """The image's command in a new container, on a data directory and a free port of loopback."""

    def __init__(self, container: str, data: Path, command: list[str]) -> None:
        self.log = data.with_name(f"{data.name}.log")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.address = f"http://127.0.0.1:{port}"
        settings = ["--env=GAMUT_HOST=127.0.0.1", f"--env=GAMUT_PORT={port}"]
        self.inside = ["buildah", "run", f"--volume={data}:/data", *settings, container, "--"]
        self.started = time.monotonic()
        with self.log.open("w") as log:
            arguments = [*self.inside, *command]
            self.process = subprocess.Popen(arguments, stdout=log, stderr=subprocess.STDOUT)

    def run(self, *command: str) -> None:
        """Run a command in the same container, as the image's user."""
        print(run(*self.inside, *command), end="", flush=True)

    def check_health(self, check: dict[str, Any]) -> None:
        """Run the image's health check as Docker does: an unhealthy service fails several times."""
        failures = 0
        while subprocess.run([*self.inside, *check["Test"][1:]], check=False).returncode != 0:
            failures += 1
            expect(failures < check["Retries"], "a healthy service")

    def wait_until_ready(self) -> float:
        """Return the seconds from start to ready."""
        while time.monotonic() < self.started + GIVE_UP_SECONDS and self.process.poll() is None:
            with suppress(OSError), urlopen(f"{self.address}/readyz", timeout=5):
                return time.monotonic() - self.started
            time.sleep(0.02)
        message = f"the service is not ready (exit code: {self.process.poll()})"
        raise SystemExit(f"{self.log.read_text()}\ndocker/image.py: {message}")

    def post_example(self) -> tuple[int, str]:
        """Post the README's example; return the status and the gamut's id.

        A build that takes longer than the service waits, as beside other work, is a job. Its page
        is asked until it has the gamut.
        """
        form = ["--form", f"file=@{CHECKOUT / 'examples' / 'FOGRA39L.ti3'}"]
        status = ["--write-out", "\n%{http_code}"]
        answer = run("curl", "-sS", "--fail", *form, *status, f"{self.address}/v1/gamuts")
        document, _, code = answer.rpartition("\n")
        posted = json.loads(document)
        if int(code) != HTTPStatus.ACCEPTED:
            return int(code), posted["id"]
        deadline = time.monotonic() + GIVE_UP_SECONDS
        while time.monotonic() < deadline:
            job = self.read_document(posted["links"]["self"])
            expect(job["state"] in ("queued", "running", "succeeded"), f"a job that ends: {job}")
            if job["state"] == "succeeded":
                return HTTPStatus.CREATED, job["links"]["gamut"].rpartition("/")[2]
            time.sleep(1)
        raise SystemExit(
            f"docker/image.py: the example's build has no end:\n{self.log.read_text()}"
        )

    def read_document(self, path: str) -> dict[str, Any]:
        """Return a JSON document of the service."""
        with urlopen(f"{self.address}{path}") as answer:
            document: dict[str, Any] = json.load(answer)
        return document

    def check_level(self, gamut: str) -> None:
        """Download a level; compare the triangles of its file with those that were asked for."""
        with urlopen(f"{self.address}/v1/gamuts/{gamut}/mesh?triangles=100") as answer:
            glb = answer.read()
        # glTF 2.0, section 4.4: 12 bytes of header, then the JSON chunk with its length and type.
        document = json.loads(glb[20 : 20 + int.from_bytes(glb[12:16], "little")])
        indices = document["meshes"][0]["primitives"][0]["indices"]
        expect(document["accessors"][indices]["count"] == 300, "a GLB of 100 triangles")

    def check_pages(self) -> None:
        """Load the documentation page and the files it refers to."""
        with urlopen(f"{self.address}/docs") as answer:
            files = re.findall(r'(?:src|href)="(/[^"]+)"', answer.read().decode())
        expect(bool(files), "files that the documentation page refers to")
        for file in files:
            urlopen(f"{self.address}{file}").close()

    def find_process(self) -> int:
        """Return the id of the service's process, below the processes of buildah."""
        process = self.process.pid
        while Path(f"/proc/{process}/cmdline").read_text().startswith("buildah"):
            threads = Path(f"/proc/{process}/task").glob("*/children")
            children = [child for thread in threads for child in thread.read_text().split()]
            if not children:
                break
            process = int(children[0])
        return process

    def memory(self) -> float:
        """Return the memory of the service and its workers, in MiB; shared pages count once."""
        server = self.find_process()
        children = Path(f"/proc/{server}/task").glob("*/children")
        processes = [
            server,
            *(int(child) for file in children for child in file.read_text().split()),
        ]
        rollups = (Path(f"/proc/{each}/smaps_rollup").read_text() for each in processes)
        return (
            sum(int(re.findall(r"^Pss: +(\d+)", text, re.MULTILINE)[0]) for text in rollups) / 1024
        )

    def stop(self) -> None:
        """Send SIGTERM to the service itself, because buildah kills its child on a signal."""
        os.kill(self.find_process(), signal.SIGTERM)
        self.process.wait(timeout=GIVE_UP_SECONDS)
        log = self.log.read_text()
        expect("Application shutdown complete" in log, f"a graceful shutdown in the log:\n{log}")
        expect("compiling" not in log, f"a service that compiles no kernel:\n{log}")


@contextmanager
def service(image: str, data: Path, command: list[str]) -> Iterator[Service]:
    """Yield a service that has just been started in a new container."""
    container = run("buildah", "from", "--pull-never", image).strip()
    # Otherwise buildah's own volume for /data hides the directory that is mounted there.
    run("buildah", "config", "--volume=/data-", container)
    running = Service(container, data, command)
    try:
        yield running
        running.stop()
    finally:
        if running.process.poll() is None:
            os.kill(running.find_process(), signal.SIGKILL)
            running.process.wait()
        run("buildah", "rm", container)


def check_image(folder: Path, image: str) -> None:
    """Start the image twice on one data directory; the second start has the gamut of the first."""
    config = json.loads(run("buildah", "inspect", "--type=image", image))["Docker"]["config"]
    user, group = map(int, config["User"].split(":"))
    labels = {name.rpartition(".")[2]: value for name, value in config["Labels"].items()}
    expect(labels["version"] == __version__, f"the label version {__version__}")
    expect(labels["revision"] == revision(), f"the label revision {revision()}")
    data = folder / "data"
    data.mkdir()
    os.chown(data, user, group)
    seconds = []
    for expected in (HTTPStatus.CREATED, HTTPStatus.OK):
        with service(image, data, config["Cmd"]) as running:
            seconds.append(running.wait_until_ready())
            idle = running.memory()
            running.check_health(config["Healthcheck"])
            status, gamut = running.post_example()
            expect(status == expected, f"status {expected}, not {status}, for the example")
            running.check_level(gamut)
            running.check_pages()
            running.run("sh", "-c", UNWRITABLE)
            running.run("python", "-c", LOAD_KERNELS)
            if expected == HTTPStatus.CREATED:
                keep_sbom(run(*running.inside, "cat", SBOM))
                running.run("sh", "-c", PARTS)
    # A figure and not a check: a machine that does other work delays the start.
    print(
        f"ready after {seconds[0]:.1f} s, after the restart in {seconds[1]:.1f} s"
        f" (goal: {READY_SECONDS:g} s), {idle:.0f} MiB idle",
        flush=True,
    )


def keep_sbom(text: str) -> None:
    """Check that the bill of materials has every locked package, and store it beside the image."""
    components = json.loads(text)["components"]
    listed = {(each["name"], each["version"]) for each in components}
    locked = re.findall(
        r"^(\S+)==(\S+)", (CHECKOUT / "docker" / LOCKS[0]).read_text(), re.MULTILINE
    )
    missing = {(re.sub(r"[-_.]+", "-", name).lower(), version) for name, version in locked} - listed
    expect(not missing, f"a bill of materials with {missing}")
    path = CHECKOUT / "build" / f"gamut-boundary-service-{__version__}.cdx.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    print(f"{path.relative_to(CHECKOUT)}: {len(components)} components", flush=True)


def main() -> None:
    """Build and check; name the step that takes the time."""
    missing = [tool for tool in ("buildah", "debootstrap", "curl") if shutil.which(tool) is None]
    expect(not missing, f"these commands: {', '.join(missing)} (.ci/run installs them)")
    expect(os.geteuid() == 0, "to be run as root, which debootstrap needs")
    image = f"gamut-boundary-service:{__version__}"
    with tempfile.TemporaryDirectory(prefix="gamut-image-") as name:
        folder = Path(name)
        (folder / "storage.conf").write_text(STORAGE.format(folder))
        os.environ["CONTAINERS_STORAGE_CONF"] = str(folder / "storage.conf")
        os.environ["BUILDAH_ISOLATION"] = "chroot"
        run_step("base image", build_base, folder)
        run_step("packages", download_packages, folder)
        run_step("image", build_image, folder, image)
        run_step("checks", check_image, folder, image)


if __name__ == "__main__":
    main()
