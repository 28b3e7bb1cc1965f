"""Run what the Dockerfile says, without a container engine: build, start, health check, one gamut.

In a mount namespace of its own, the directories that the image's steps write to are empty memory
file systems; the COPY and RUN lines of the first stage are carried out there as they stand. Then
the root is made read-only, and the last stage's CMD is started as its USER with its ENV, until
its HEALTHCHECK succeeds and the smoke test of the wheel has passed against it. The machine's own
/usr/bin/python3 stands in for the base image's. Linux, as root; nothing is left on the machine.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

__all__: list[str] = []

CHECKOUT = Path(__file__).resolve().parent.parent
SYSTEM_PATH = "/usr/local/bin:/usr/local/sbin:/usr/sbin:/usr/bin:/sbin:/bin"
SCRATCH = ("/build", "/data", "/opt/gamut")
"""Where the Dockerfile's steps write: its WORKDIR, VOLUME and INSTALL_ROOT."""
START_SECONDS = 60
"""When a server that is not healthy is given up; the time it took is printed."""


@dataclass
class Stage:
    """One stage of a Dockerfile: its variables and its instructions in order."""

    environment: dict[str, str] = field(default_factory=dict)
    instructions: list[tuple[str, str]] = field(default_factory=list)

    def last(self, keyword: str) -> str:
        """Return the arguments of the last instruction of that name; ``KeyError`` without one."""
        return dict(self.instructions)[keyword]


def stages(dockerfile: str) -> list[Stage]:
    """Return the stages of a Dockerfile without ARG and here-documents, such as this project's."""
    lines = [line for line in dockerfile.splitlines() if not line.lstrip().startswith("#")]
    found: list[Stage] = []
    for line in re.sub(r"\\\n", " ", "\n".join(lines)).splitlines():
        if not line.strip():
            continue
        keyword, arguments = line.split(maxsplit=1)
        if keyword == "FROM":
            found.append(Stage())
        elif keyword == "ENV":
            found[-1].environment |= dict(pair.split("=", 1) for pair in shlex.split(arguments))
        else:
            found[-1].instructions.append((keyword, arguments))
    return found


def copied(arguments: str, context: Path, workdir: Path) -> None:
    """Carry out a COPY of files and directories of the context, without flags."""
    *sources, target = arguments.split()
    ignored = shutil.ignore_patterns("__pycache__", "*.py[cod]", "*.nb[ci]")  # as .dockerignore
    for source in sources:
        origin = context / source
        destination = workdir / target
        if origin.is_dir():
            shutil.copytree(origin, destination, ignore=ignored, dirs_exist_ok=True)
        else:
            if target.endswith("/"):
                destination /= origin.name
            destination.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(origin, destination)


def build(stage: Stage) -> None:
    """Carry out a stage's COPY and RUN lines."""
    workdir = Path("/")
    environment = {**os.environ, "PATH": SYSTEM_PATH, **stage.environment}
    for keyword, arguments in stage.instructions:
        print(f"# {keyword} {arguments}", flush=True)
        if keyword == "WORKDIR":
            workdir = Path(arguments)
        elif keyword == "COPY":
            copied(arguments, CHECKOUT, workdir)
        elif keyword == "RUN":
            quiet = {"PIP_QUIET": "1"}
            command = ["/bin/sh", "-c", arguments]
            subprocess.run(command, check=True, cwd=workdir, env={**environment, **quiet})
        else:
            message = f"{keyword} in the build stage: the rehearsal does not know it"
            raise SystemExit(message)


def mounted(kind: str, target: str, *options: str) -> None:
    """Mount, in this namespace only."""
    subprocess.run(["mount", *options, *(["-t", kind, kind] if kind else []), target], check=True)


def as_user(stage: Stage, command: list[str]) -> list[str]:
    """Return the command under the stage's user and variables, with no capability left."""
    user, group = stage.last("USER").split(":")
    variables = [f"{name}={value}" for name, value in stage.environment.items()]
    drop = ["--clear-groups", "--no-new-privs", "--bounding-set=-all", "--inh-caps=-all"]
    return ["setpriv", "--reuid", user, "--regid", group, *drop, "env", "-i", *variables, *command]


def seconds_until(stage: Stage, check: list[str], server: subprocess.Popen[bytes]) -> float:
    """Return how long it takes until a command of the image first succeeds."""
    started = time.monotonic()
    while time.monotonic() < started + START_SECONDS and server.poll() is None:
        answer = subprocess.run(as_user(stage, check), check=False, capture_output=True)
        if answer.returncode == 0:
            return time.monotonic() - started
        time.sleep(0.05)
    message = f"{check} never succeeded (server's exit code: {server.poll()})"
    raise SystemExit(message)


def run(stage: Stage) -> None:
    """Start the container's command on a read-only root and use it.

    Two variables differ from the image's: nothing on this machine may be reached from outside, and
    its port 8000 may be taken.
    """
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    stage.environment |= {"GAMUT_HOST": "127.0.0.1", "GAMUT_PORT": port}
    workdir = stage.last("WORKDIR")

    checks = Path("/build/checks")  # the user of the image need not be able to read the checkout
    checks.mkdir()
    for name in ("docker/other_cpu.py", ".ci/smoke.py", "examples/FOGRA39L.ti3"):
        shutil.copy2(CHECKOUT / name, checks)
    for folder in ("/opt/gamut", "/build"):
        mounted("", folder, "-o", "remount,ro")
    mounted("tmpfs", "/tmp", "-o", "mode=1777")
    mounted("", "/", "-o", "remount,bind,ro")
    writable = "for f in / /etc /opt/gamut /build; do ! touch $f/x 2>/dev/null || exit 1; done"
    subprocess.run(as_user(stage, ["sh", "-c", writable]), check=True)

    other_cpu = ["python", str(checks / "other_cpu.py")]
    subprocess.run(as_user(stage, other_cpu), check=True, cwd=workdir)

    server = subprocess.Popen(as_user(stage, json.loads(stage.last("CMD"))), cwd=workdir)
    try:
        check = json.loads(stage.last("HEALTHCHECK").split(" CMD ", 1)[1])
        healthy = seconds_until(stage, check, server)
        ready_check = [word.replace("/livez", "/readyz") for word in check]
        ready = healthy + seconds_until(stage, ready_check, server)
        print(f"healthy after {healthy:.1f} s, ready after {ready:.1f} s", flush=True)
        smoke = ["python", str(checks / "smoke.py"), str(checks / "FOGRA39L.ti3")]
        address = f"http://127.0.0.1:{port}"
        subprocess.run(as_user(stage, [*smoke, address]), check=True, cwd=workdir)
    finally:
        server.send_signal(signal.SIGTERM)
        code = server.wait(timeout=30)
    if code not in {0, -signal.SIGTERM}:  # uvicorn stops in order, then ends by the same signal
        message = f"the server ended with {code} on SIGTERM"
        raise SystemExit(message)


def main() -> None:
    """Enter a mount namespace, then build and run there."""
    if os.geteuid() != 0:
        raise SystemExit("The rehearsal mounts file systems: run it as root, on Linux.")
    if sys.argv[1:] != ["--inside"]:
        made = [folder for folder in SCRATCH if not Path(folder).exists()]
        for folder in made:
            Path(folder).mkdir(parents=True)
        try:
            inside = ["unshare", "--mount", "--propagation", "private", sys.executable, __file__]
            raise SystemExit(subprocess.run([*inside, "--inside"], check=False).returncode)
        finally:
            for folder in made:
                Path(folder).rmdir()
    for folder in SCRATCH:
        mounted("tmpfs", folder, "-o", "mode=0755")
    first, *_, last = stages((CHECKOUT / "Dockerfile").read_text())
    build(first)
    run(last)


if __name__ == "__main__":
    main()
