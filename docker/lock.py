"""Write the lock files of the image: versions with the SHA-256 of their wheels, for pip to verify.

``python docker/lock.py`` needs Python 3.11, the version in the image, and a package index. The
versions are those of constraints.txt. The hashes are those of the wheels that pip selects for Linux
on x86-64 and on ARM. ``requirements.txt`` is installed into the image, ``requirements-build.txt``
builds the wheel of the project.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import tomllib
from collections import defaultdict
from pathlib import Path

__all__: list[str] = []

CHECKOUT = Path(__file__).resolve().parent.parent
EXTRAS = ("service", "celery", "cloud")
MACHINES = ("x86_64", "aarch64")
OLD_PYTHON = ["async-timeout>=4.0.3"]
"""What redis needs before Python 3.11.3. Debian 12 has 3.11.2, and CI builds on it."""

GLIBC_MINORS = range(17, 37)
"""Minor versions of glibc 2 up to that of the base image, Debian 12 (PEP 600)."""

HEADER = """\
# Written by `make constraints`. pip refuses packages with other hashes (--require-hashes).
"""


def wheels(requirements: list[str], machine: str) -> dict[tuple[str, str], str]:
    """Return the SHA-256 of the wheels that pip selects, by name and version."""
    tags = [f"manylinux2014_{machine}", *(f"manylinux_2_{n}_{machine}" for n in GLIBC_MINORS)]
    platforms = [f"--platform={tag}" for tag in tags]
    with tempfile.TemporaryDirectory() as folder:
        options = ["--dry-run", "--ignore-installed", "--quiet", "--only-binary=:all:"]
        report = [f"--target={folder}", f"--report={folder}/report.json", "-c", "constraints.txt"]
        subprocess.run(
            [sys.executable, "-m", "pip", "install", *options, *report, *platforms, *requirements],
            check=True,
            cwd=CHECKOUT,
        )
        found = json.loads((Path(folder) / "report.json").read_text())
    return {
        (item["metadata"]["name"], item["metadata"]["version"]): (
            item["download_info"]["archive_info"]["hashes"]["sha256"]
        )
        for item in found["install"]
    }


def write_lock(name: str, requirements: list[str]) -> None:
    """Write one lock file, in the form that pip reads."""
    hashes: dict[tuple[str, str], set[str]] = defaultdict(set)
    for machine in MACHINES:
        for package, digest in wheels(requirements, machine).items():
            hashes[package].add(digest)
    lines = [HEADER]
    for (package, version), digests in sorted(hashes.items(), key=lambda item: item[0][0].lower()):
        pinned = [f"{package}=={version}", *(f"--hash=sha256:{each}" for each in sorted(digests))]
        lines.append(" \\\n    ".join(pinned) + "\n")
    (CHECKOUT / "docker" / name).write_text("".join(lines))


def main() -> None:
    """Write both lock files."""
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())
    extras = project["project"]["optional-dependencies"]
    needed = project["project"]["dependencies"] + [each for name in EXTRAS for each in extras[name]]
    write_lock("requirements.txt", needed + OLD_PYTHON)
    write_lock("requirements-build.txt", project["build-system"]["requires"])


if __name__ == "__main__":
    main()
