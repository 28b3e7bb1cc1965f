"""Fixtures that several folders of tests share, and the mark of slow tests."""

from __future__ import annotations

import functools
import importlib.util
import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
import typer
from hypothesis import settings

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

VALIDATOR = Path(__file__).parent / "gltf"
WEB = Path(__file__).parents[1] / "web"

# The same examples in every run, so that a failure in CI repeats at a desk. Tests are not timed.
settings.register_profile("repository", max_examples=50, derandomize=True, deadline=None)
settings.load_profile("repository")
# Other examples in every run, and more of them: `make test-long`.
settings.register_profile("long", max_examples=1000, deadline=None, print_blob=True)


# The command line keeps no reference gamuts in the user's cache, and finds none there.
os.environ["GAMUTCORE_CACHE_DIR"] = ""

# --- The three groups of tests: `make test`, `make test-all` and `make test-long` -----------------
# The marks are `slow` for the second group and `long` for the third. They stand at tests and files.
# What a test uses marks it as well:

SLOW_FIXTURES = {
    *("browser", "cluster", "gltf_report", "javascript_levels"),
    *("observed_server", "proxy", "s3", "server", "services", "small_server", "start_server"),
    *("typescript_program", "viewgam"),
    *("fogra39_gamut", "fogra39_boundary", "fogra39_finest", "fogra39_quadric"),
}
"""Fixtures that start a server, a broker or a browser, need an npm package, or take seconds."""

LONG_FIXTURES = {"azure", "gcs"}
"""Fixtures of emulators that only `make test-long` needs."""

LONG_FOLDERS = {"faults", "fuzz"}

NEEDED_PACKAGES = {
    "celery": ["service/broker"],
    "jsonschema_rs": ["service/openapi/test_openapi.py"],
    "matplotlib": ["gamutcore/questions/test_drawing.py", "test_concepts.py", "test_recipes.py"],
    "pygltflib": ["gamutcore/export/test_gltf.py"],
}
"""Packages of the extra ``test-all`` that whole files import. `make test` leaves the files out."""


def is_installed(package: str) -> bool:
    """Return whether a package, or a module of one, can be imported."""
    try:
        return importlib.util.find_spec(package) is not None
    except ModuleNotFoundError:
        return False


collect_ignore = [
    file
    for package, files in NEEDED_PACKAGES.items()
    if not is_installed(package)
    for file in files
]

FIRST_FILES = (
    "service/viewer/test_solids.py",
    "service/viewer/test_answers.py",
    "service/broker/test_celery_worker.py",
    "service/building/test_builds.py",
    "service/routes/test_failures.py",
    "service/routes/test_jobs.py",
    "service/test_load.py",
    "gamutcore/cli/test_documented_commands.py",
    "gamutcore/decimation/test_decimation.py",
    "gamutcore/test_warm.py",
    "service/test_end_to_end.py",
)
"""The longest files begin first, so that no process has one of them left at the end."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests by what they use, and let long files begin."""
    for item in items:
        parameters = getattr(getattr(item, "callspec", None), "params", {}).values()
        names = (value for value in parameters if isinstance(value, str))
        fixtures = {*getattr(item, "fixturenames", ()), *names}
        if fixtures & LONG_FIXTURES or item.path.parent.name in LONG_FOLDERS:
            item.add_marker(pytest.mark.long)
        elif fixtures & SLOW_FIXTURES:
            item.add_marker(pytest.mark.slow)
    place = {Path(__file__).parent / name: number for number, name in enumerate(FIRST_FILES)}
    items.sort(key=lambda item: place.get(item.path, len(place)))


@pytest.fixture(scope="session", autouse=True)
def _commands_once() -> Iterator[None]:
    """Put a command line together once, which takes 40 ms, and not in every call of a test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", functools.cache(typer.main.get_command))
        yield


def one_slow_rest_long(first: object, *others: object) -> list[Any]:
    """Mark the first case for `make test-all`, and the others for `make test-long`."""
    return [
        pytest.param(*case if isinstance(case, tuple) else (case,), marks=marks)
        for marks, cases in ((pytest.mark.slow, [first]), (pytest.mark.long, others))
        for case in cases
    ]


def missing(what: str) -> None:
    """Skip a test that lacks something; fail in CI, where everything must be installed."""
    if os.environ.get("CI") == "true":
        pytest.fail(what)
    pytest.skip(what)


@pytest.fixture(scope="session")
def typescript_program(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path], list[str]]:
    """Return a function from a program in TypeScript below ``web/`` to the command that runs it."""
    node, esbuild = shutil.which("node"), WEB / "node_modules" / ".bin" / "esbuild"
    if node is None:
        missing("Programs in TypeScript need Node.js, which is not installed")
    if not esbuild.exists():
        missing("The packages of web/ are not installed: run `make test-all`, or npm ci in web")

    def command(source: Path) -> list[str]:
        bundle = tmp_path_factory.mktemp("typescript") / f"{source.stem}.mjs"
        options = ["--bundle", "--platform=node", "--format=esm", "--log-level=warning"]
        subprocess.run([str(esbuild), str(source), *options, f"--outfile={bundle}"], check=True)
        return [str(node), str(bundle)]

    return command


@pytest.fixture(scope="session")
def gltf_report(
    tmp_path_factory: pytest.TempPathFactory,
) -> Callable[[bytes | Path], dict[str, Any]]:
    """Return a function from GLB or glTF bytes, or a path, to the report of Khronos' validator.

    ``report["issues"]`` has ``numErrors``, ``numWarnings``, ``numInfos``, ``numHints`` and
    ``messages``. ``report["info"]`` has counts.
    """
    node = shutil.which("node")
    if node is None:
        missing("Khronos' glTF validator needs Node.js, which is not installed")
    if not (VALIDATOR / "node_modules" / "gltf-validator").is_dir():
        missing(
            "Khronos' glTF validator is not installed: run `make test-all`, or npm ci in tests/gltf"
        )

    def report(asset: bytes | Path) -> dict[str, Any]:
        if isinstance(asset, bytes):
            suffix = "glb" if asset.startswith(b"glTF") else "gltf"
            path = tmp_path_factory.mktemp("gltf") / f"asset.{suffix}"
            path.write_bytes(asset)
        else:
            path = asset
        ended = subprocess.run(
            [str(node), str(VALIDATOR / "validate.mjs"), str(path)],
            check=False,
            capture_output=True,
            text=True,
        )
        assert ended.returncode in {0, 1}, ended.stderr
        assert ended.stdout, ended.stderr
        (only,) = json.loads(ended.stdout)
        assert (ended.returncode == 1) == (only["issues"]["numErrors"] > 0)
        return dict(only)

    return report


@pytest.fixture(scope="session")
def javascript_levels(
    tmp_path_factory: pytest.TempPathFactory,
    typescript_program: Callable[[Path], list[str]],
) -> Callable[..., list[tuple[np.ndarray, ...]]]:
    """Return a function from a history file, or a prefix, to its levels as JavaScript reads them.

    The levels are those of `counts`, or all. Each is (positions, faces), with the values of
    `channels` device channels if there are any.
    """
    program = typescript_program(WEB / "boundary" / "tests" / "levels.ts")

    def levels(
        data: bytes, counts: list[int] | None = None, channels: int = 0
    ) -> list[tuple[np.ndarray, ...]]:
        path = tmp_path_factory.mktemp("javascript") / "history"
        path.write_bytes(data)
        asked = ["all"] if counts is None else [str(count) for count in counts]
        ended = subprocess.run(
            [
                *program,
                *(["--device"] if channels else []),
                str(path),
                *asked,
            ],
            check=False,
            capture_output=True,
        )
        assert ended.returncode == 0, ended.stderr.decode()
        found: list[tuple[np.ndarray, ...]] = []
        offset = 0
        while offset < len(ended.stdout):
            triangles = 4 + 2 * len(found) if counts is None else counts[len(found)]
            width = 6 * triangles + 24
            positions = np.frombuffer(ended.stdout, "<f4", width // 4, offset)
            faces = np.frombuffer(ended.stdout, "<i4", 3 * triangles, offset + width)
            offset += width + faces.nbytes
            if not channels:
                found.append((positions, faces))
                continue
            values = np.frombuffer(ended.stdout, "<f4", channels * width // 12, offset)
            found.append((positions, faces, values.reshape(-1, channels)))
            offset += values.nbytes
        return found

    return levels
