"""The kernel cache under another CPU, which the image relies on, its packages and its name.

``make image-check`` builds and runs the image itself.
"""

import hashlib
import importlib.metadata
import json
import os
import platform
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import OpenImageIO as oiio  # noqa: N813
import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from PIL import features

from gamutcore.version import __version__

ROOT = Path(__file__).parent.parent
DOCKERFILE = (ROOT / "Dockerfile").read_text()
STAGES = DOCKERFILE.split("\nFROM ")[1:]
FIXED_CPU = dict(re.findall(r'(NUMBA_CPU_\w+)="?(\w*)', STAGES[-1]))

OLD_CPU = "nocona" if platform.machine() == "x86_64" else "cortex-a53"
"""A CPU that LLVM knows and that no current machine has."""

MAIN = f"""
import sys
import llvmlite.binding
if sys.argv[1] == "another":
    llvmlite.binding.get_host_cpu_name = lambda: "{OLD_CPU}"
    llvmlite.binding.get_host_cpu_features = llvmlite.binding.FeatureMap
from twice import twice
assert twice(21.0) == 42.0
print(sum(twice.stats.cache_hits.values()), sum(twice.stats.cache_misses.values()))
"""

KERNEL = """
from gamutcore.kernels import kernel

@kernel
def twice(value):
    return 2.0 * value
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "twice.py").write_text(KERNEL)
    (tmp_path / "main.py").write_text(MAIN)
    return tmp_path


def loads_and_compilations(folder, cpu, variables):
    """Call the kernel in a new process; count how often it was loaded and compiled."""
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith("NUMBA")
    }
    environment |= {**variables, "PYTHONPATH": str(ROOT)}
    output = subprocess.run(
        [sys.executable, "main.py", cpu],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    return tuple(map(int, output.split()))


@pytest.mark.slow
def test_kernels_for_a_fixed_cpu_load_on_another_and_after_a_copy(folder):
    assert loads_and_compilations(folder, "this", FIXED_CPU) == (0, 1)
    # Copying from one stage of the image to the next may round the times of files.
    os.utime(folder / "twice.py", (1_000_000_000, 1_000_000_000))
    assert loads_and_compilations(folder, "another", FIXED_CPU) == (1, 0)


@pytest.mark.slow
def test_kernels_for_the_host_do_not_load_on_another_cpu(folder):
    """The control of the test above."""
    assert loads_and_compilations(folder, "this", {}) == (0, 1)
    assert loads_and_compilations(folder, "this", {}) == (1, 0)
    assert loads_and_compilations(folder, "another", {}) == (0, 1)


def test_both_stages_have_one_base_and_one_cpu():
    assert re.search(r"^ARG BASE=python:3\.11\.\d+-slim-bookworm$", DOCKERFILE, re.MULTILINE)
    assert len(STAGES) == 2
    for stage in STAGES:
        assert stage.startswith("${BASE}")
        assert "NUMBA_CPU_NAME=generic" in stage
        assert 'NUMBA_CPU_FEATURES=""' in stage


def locked(name):
    """The versions and the numbers of hashes in a lock file, by package."""
    text = (ROOT / "docker" / name).read_text().replace("\\\n", " ")
    lines = [line.split() for line in text.splitlines() if not line.startswith("#")]
    pattern = re.compile(r"--hash=sha256:[0-9a-f]{64}")
    assert all(pattern.fullmatch(each) for _, *hashes in lines for each in hashes)
    pins = [(*pin.split("=="), len(hashes)) for pin, *hashes in lines]
    return {canonicalize_name(name): (version, hashes) for name, version, hashes in pins}


def test_the_image_is_installed_from_hashes_of_the_pinned_versions():
    constraints = (ROOT / "constraints.txt").read_text().splitlines()
    pins = dict(line.split("==") for line in constraints if not line.startswith("#"))
    pins = {canonicalize_name(name): version for name, version in pins.items()}
    packages = locked("requirements.txt")
    assert all(hashes >= 1 for _, hashes in packages.values())
    assert packages["numpy"][1] == packages["numba"][1] == 2  # x86-64 and ARM
    differing = {name for name, (version, _) in packages.items() if pins.get(name) != version}
    assert differing == {"async-timeout"}  # of an earlier Python than that of the pins
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    extras = project["project"]["optional-dependencies"]
    named = [each for name in ("service", "celery", "cloud") for each in extras[name]]
    wanted = {canonicalize_name(Requirement(each).name) for each in named}
    wanted |= {canonicalize_name(Requirement(e).name) for e in project["project"]["dependencies"]}
    assert wanted <= packages.keys()
    assert "hatchling" in locked("requirements-build.txt")
    installs = re.findall(r"pip install [^&]*", DOCKERFILE)
    assert all("--require-hashes" in each or "--no-index" in each for each in installs)


def test_the_image_says_its_version():
    assert f"\nARG VERSION={__version__}\n" in DOCKERFILE
    for name in ("version", "revision"):
        assert f'org.opencontainers.image.{name}="${{{name.upper()}}}"' in DOCKERFILE


@pytest.mark.slow
def test_the_bill_of_materials_lists_what_is_installed():
    """Of this environment; members and types as in the specification of CycloneDX 1.6."""
    program = [sys.executable, str(ROOT / "docker" / "sbom.py")]
    printed = subprocess.run(program, capture_output=True, text=True, check=True).stdout
    document = json.loads(printed)
    assert (document["bomFormat"], document["specVersion"]) == ("CycloneDX", "1.6")
    assert document["metadata"]["component"]["name"] == "gamut-boundary-service"
    parts = document["components"]
    assert len({part["bom-ref"] for part in parts}) == len(parts)
    assert {part["type"] for part in parts} == {"library", "platform"}
    for name in ("numpy", "fastapi"):
        version = importlib.metadata.version(name)
        (part,) = [part for part in parts if part["bom-ref"].startswith(f"pkg:pypi/{name}@")]
        assert (part["version"], part["purl"]) == (version, f"pkg:pypi/{name}@{version}")
        assert part["licenses"]


@pytest.fixture(scope="module")
def bill():
    program = [sys.executable, str(ROOT / "docker" / "sbom.py")]
    printed = subprocess.run(program, capture_output=True, text=True, check=True).stdout
    return json.loads(printed)


@pytest.mark.slow
def test_what_the_image_installs_has_a_licence_and_the_hashes_of_the_lock(bill):
    text = (ROOT / "docker" / "requirements.txt").read_text().replace("\\\n", " ")
    parts = {part["bom-ref"]: part for part in bill["components"]}
    for line in text.splitlines():
        if line.startswith("#"):
            continue
        pin, *hashes = line.split()
        name, version = pin.split("==")
        part = parts.get(f"pkg:pypi/{canonicalize_name(name)}@{version}")
        if part is not None:  # otherwise this environment has another version, or none
            assert part["licenses"], name
            assert {f"--hash=sha256:{each['content']}" for each in part["hashes"]} == set(hashes)


def test_decoders_inside_wheels_are_listed(bill):
    """With the versions that the libraries state themselves."""
    wheels = {part["name"]: part.get("components", []) for part in bill["components"]}
    named = {(part["name"].lower(), part.get("version")) for part in wheels["pillow"]}
    for feature, name in (("webp", "libwebp"), ("libtiff", "libtiff")):
        assert (name, features.version(feature)) in named, sorted(named)
    linked = {part["name"]: part["version"] for part in wheels["openimageio"] if "version" in part}
    states = oiio.get_string_attribute("library_list")
    for name, library in (("PNG", "libpng"), ("OpenJPEG", "OpenJpeg"), ("OpenEXR", "OpenEXR")):
        assert f"{library} {linked[name]}" in states
    for wheel, parts in wheels.items():
        for part in parts:
            if part["type"] == "file" and ".libs/" in part["name"]:
                path = importlib.metadata.distribution(wheel).locate_file(part["name"])
                digest = hashlib.sha256(path.read_bytes()).hexdigest()
                assert part["hashes"] == [{"alg": "SHA-256", "content": digest}]
    references = [part["bom-ref"] for part in bill["components"]]
    references += [part["bom-ref"] for parts in wheels.values() for part in parts]
    assert len(set(references)) == len(references)


def test_compose_and_the_chart_name_the_image_that_is_built():
    compose = (ROOT / "deploy" / "compose.yaml").read_text()
    assert f"${{GAMUT_IMAGE:-gamut-boundary-service:{__version__}}}" in compose
    chart = ROOT / "deploy" / "helm" / "gamut"
    values = yaml.safe_load((chart / "values.yaml").read_text())["image"]
    version = yaml.safe_load((chart / "Chart.yaml").read_text())["appVersion"]
    assert (values["repository"], values["tag"]) == ("gamut-boundary-service", "")
    assert version == __version__
    built = (ROOT / "docker" / "image.py").read_text()
    assert 'f"gamut-boundary-service:{__version__}"' in built
