"""Build the wheels that a release publishes, into a folder that is emptied first.

    python .ci/wheels.py FOLDER [PYTHON...]

These are the pure wheel, the client's, and for each Python a wheel with machine code for every
processor of this architecture, and with the references that people ask for first. Such a wheel has
the platform tag of Numba's own wheel, which its code needs anyway. Each Python gets an environment
with the versions of ``constraints.txt``.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
SCRATCH = ROOT / "build" / "wheels"

# pip splits values at spaces, so the paths are relative
PINS = {"PIP_CONSTRAINT": "constraints.txt", "PIP_BUILD_CONSTRAINT": "constraints.txt"}

# a processor that every one of the architecture can stand in for, as in the Dockerfile
GENERIC = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}

# a build takes 2 s, and a file 1.7 MB
REFERENCES = ("srgb", "display-p3", "bt2020", "adobe-rgb-1998")

FACTS = """
import importlib.metadata, json, re, sysconfig
wheel = importlib.metadata.distribution("numba").read_text("WHEEL")
print(json.dumps([re.search(r"Tag: (\\S+)", wheel).group(1), sysconfig.get_path("purelib")]))
"""


def run(*command: str | Path, **environment: str) -> str:
    """Run a command in the checkout, and return what it prints."""
    names = {**os.environ, **PINS, **environment}
    return subprocess.run(
        command, check=True, cwd=ROOT, env=names, stdout=subprocess.PIPE, text=True
    ).stdout


def build_wheel(target: Path, *projects: str, **environment: str) -> None:
    """Build wheels into a folder."""
    pip = (sys.executable, "-m", "pip", "wheel", "-q", "--no-deps")
    run(*pip, "--wheel-dir", target, *projects, **environment)


def build_compiled_wheel(target: Path, python: str, pure: Path) -> None:
    """Build the wheel with machine code for a Python."""
    shutil.rmtree(SCRATCH, ignore_errors=True)
    run(python, "-m", "venv", SCRATCH / "venv")
    inside = SCRATCH / "venv" / "bin" / "python"
    run(inside, "-m", "pip", "install", "-q", "--upgrade", "pip>=26")
    run(inside, "-m", "pip", "install", "-q", pure)
    tag, packages = json.loads(run(inside, "-I", "-c", FACTS))
    # kernels that lie beside the sources are kept where they fit: the same processor and Python
    for path in (ROOT / "gamutcore").rglob("*.nbc"):
        copy = Path(packages) / path.relative_to(ROOT)
        if copy.parents[1].is_dir():
            copy.parent.mkdir(exist_ok=True)
            shutil.copy(path, copy)
    names = set(run(inside, "-I", "-m", "gamutcore.warm", "--print", **GENERIC).split())
    folder = SCRATCH / "added"
    code = folder / "kernels" / "compiled"
    code.mkdir(parents=True)
    for path in (Path(packages) / "gamutcore").rglob("__pycache__/*.*"):
        if path.suffix == ".stamp" or (path.suffix == ".nbc" and path.stem in names):
            shutil.copy(path, code)
    for slug in REFERENCES:
        cache = {"GAMUTCORE_CACHE_DIR": str(SCRATCH / "cache")}
        run(inside, "-I", "-m", "gamutcore", "info", slug, **GENERIC, **cache)
    (versions,) = (SCRATCH / "cache").iterdir()
    (folder / "references").mkdir()
    versions.rename(folder / "references" / "built")
    build_wheel(target, ".", GAMUT_WHEEL_FOLDER=str(folder), GAMUT_WHEEL_TAG=tag)


def main() -> None:
    """Build all wheels, and print their sizes."""
    target = ROOT / sys.argv[1]
    shutil.rmtree(target, ignore_errors=True)
    build_wheel(target, ".", "./client")
    (pure,) = target.glob("gamut_boundary_service-*-none-any.whl")
    for python in sys.argv[2:]:
        build_compiled_wheel(target, python, pure)
    shutil.rmtree(SCRATCH, ignore_errors=True)
    for path in sorted(target.iterdir()):
        print(f"{path.stat().st_size / 1e6:6.1f} MB  {path.name}")


if __name__ == "__main__":
    main()
