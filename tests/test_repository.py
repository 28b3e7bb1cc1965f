"""What the repository's own files promise: pins, layout, no package host."""

import hashlib
import importlib.metadata
import json
import re
import subprocess
import tomllib
from itertools import chain
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())

PACKAGE_HOSTS = {
    "08d54e49cb09e297",
    "3378f2e28cc4630e",
    "4ff05e3c263b36b1",
    "954ad027ab968ca3",
    "a4aa2ac280bb8d1a",
    "f01c5863bec35117",
}
"""Registries of packages for Python, JavaScript and Debian: the first sixteen digits of the SHA-256
of two labels each, so that this file does not name them either."""

TWO_LABELS = re.compile(r"(?<![a-z0-9-])(?=([a-z0-9-]+\.[a-z0-9-]+))")

SETTINGS = re.compile(r"index-url|\"resolved\":|^\s*registry\s*=\s*[\"']?https?:", re.MULTILINE)
"""What tells a tool or a lock file where packages come from."""


def hosts_in(text, digests):
    """Return the pairs of labels in a text whose digests are among some."""
    pairs = set(TWO_LABELS.findall(text.lower()))
    return {pair for pair in pairs if hashlib.sha256(pair.encode()).hexdigest()[:16] in digests}


def pins():
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    return dict(line.split("==") for line in lines if not line.startswith("#"))


def tracked():
    """Return the text files that git tracks, or skip where this is not a checkout."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    paths = [ROOT / name for name in listed.stdout.split("\0") if name]
    return [path for path in paths if path.is_file() and b"\0" not in path.read_bytes()[:8192]]


class TestPins:
    def test_every_line_is_a_name_and_an_exact_version(self):
        lines = (ROOT / "constraints.txt").read_text().splitlines()
        wrong = [
            line
            for line in lines
            if not line.startswith("#")
            and not re.fullmatch(r"[A-Za-z0-9._-]+==[0-9][A-Za-z0-9.!+_-]*", line)
        ]
        assert wrong == []

    def test_what_the_project_asks_for_is_pinned_with_all_that_it_needs(self):
        """Walk the requirements of the installed packages from pyproject.toml's."""
        pinned = {canonicalize_name(name) for name in pins()}
        extras = PROJECT["project"]["optional-dependencies"]
        waiting = [
            Requirement(text)
            for text in [
                *PROJECT["project"]["dependencies"],
                *extras["service"],
                *extras["test"],
                *extras["lint"],
                *extras["docs"],
            ]
        ]
        seen = set()
        while waiting:
            requirement = waiting.pop()
            key = (canonicalize_name(requirement.name), frozenset(requirement.extras))
            if key in seen:
                continue
            seen.add(key)
            assert key[0] in pinned, f"{requirement} is not in constraints.txt"
            try:
                needed = importlib.metadata.requires(requirement.name) or []
            except importlib.metadata.PackageNotFoundError:
                continue  # of `lint` and `docs`, where only the tests' packages are installed
            for text in needed:
                further = Requirement(text)
                environments = [
                    {**default_environment(), "extra": extra} for extra in ("", *requirement.extras)
                ]
                if further.marker is None or any(map(further.marker.evaluate, environments)):
                    waiting.append(further)
        assert len(seen) > len(extras["test"])

    def test_the_ranges_admit_the_pins(self):
        pinned = {canonicalize_name(name): version for name, version in pins().items()}
        requirements = [
            *PROJECT["project"]["dependencies"],
            *PROJECT["build-system"]["requires"],
            *chain(*PROJECT["project"]["optional-dependencies"].values()),
        ]
        for requirement in map(Requirement, requirements):
            version = pinned[canonicalize_name(requirement.name)]
            assert requirement.specifier.contains(version), requirement

    def test_the_installed_versions_are_the_pinned_ones(self):
        installed = {
            name: importlib.metadata.version(name)
            for name in pins()
            if any(importlib.metadata.distributions(name=name))
        }
        assert installed
        assert installed == {name: pins()[name] for name in installed}

    @pytest.mark.parametrize("folder", ["tests/gltf", "tests/azurite", "web"])
    def test_the_npm_locks_have_digests_and_no_addresses(self, folder):
        lock = json.loads((ROOT / folder / "package-lock.json").read_text())
        packages = {name: entry for name, entry in lock["packages"].items() if name}
        assert packages
        for name, entry in packages.items():
            assert entry["integrity"].startswith("sha512-"), name
            assert "resolved" not in entry, name


def test_hosts_are_found_by_their_digests():
    digests = {hashlib.sha256(b"example.org").hexdigest()[:16]}
    for text in ("https://example.org/a", "x.Example.ORG.", '"a@example.org"', "example.org"):
        assert hosts_in(text, digests) == {"example.org"}
    for text in ("example.or", "anexample.org", "example-org", "example.organic"):
        assert hosts_in(text, digests) == set()


def test_no_file_names_a_package_host():
    # The bundle is as it was published, and says "resolved" of schemas.
    bundle = ROOT / "service" / "static" / "swagger-ui" / "swagger-ui-bundle.js"
    named = []
    for path in tracked():
        text = path.read_text("utf-8", "replace")
        told = path not in {Path(__file__), bundle} and SETTINGS.search(text)
        if told or hosts_in(text, PACKAGE_HOSTS):
            named.append(path)
    assert named == []


HEADING = re.compile(r"^#+ +(.*?) *$", re.MULTILINE)
LINK = re.compile(r"\]\(([^()\s]*(?:\([^()]*\))?[^()\s]*)\)")


def anchors(document):
    """Return the anchors that GitHub makes of the headings of a document."""
    titles = (re.sub(r"[`*]|\[|\]\([^)]*\)", "", title) for title in HEADING.findall(document))
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def test_links_in_documents_lead_to_files_and_headings():
    broken = []
    for path in tracked():
        if path.suffix != ".md":
            continue
        for link in LINK.findall(re.sub(r"```.*?```", "", path.read_text(), flags=re.DOTALL)):
            target, _, anchor = link.partition("#")
            if re.match(r"[a-z]+:", target):
                continue
            file = path.parent / target if target else path
            if not file.exists() or (anchor and anchor not in anchors(file.read_text())):
                broken.append(f"{path.relative_to(ROOT)}: {link}")
    assert broken == []


def test_the_index_lists_every_decision_record():
    folder = ROOT / "docs" / "decisions"
    records = sorted(path.name for path in folder.glob("*.md") if path.name != "README.md")
    index = (folder / "README.md").read_text()
    entries = re.findall(r"^- \[(.*?)\]\(([\w-]+\.md)\)$", index, re.MULTILINE)
    assert sorted(name for _, name in entries) == records
    for title, name in entries:
        head = rf"# {re.escape(title)}\n\nStatus: accepted, \d{{4}}-\d\d-\d\d\."
        assert re.match(head, (folder / name).read_text()), name


def test_the_examples_are_the_files_that_their_notices_speak_of():
    sections = (ROOT / "examples/README.md").read_text().split("\n## ")[1:]
    files = {section.splitlines()[0]: section for section in sections}
    listed = {path.name for path in (ROOT / "examples").iterdir() if path.name != "README.md"}
    assert listed <= files.keys()
    stated = {name: re.findall(r"`([0-9a-f]{64})`", files[name]) for name in listed}
    assert "FOGRA39L.ti3" in stated
    for name, digests in stated.items():
        if digests:  # a file of others
            content = (ROOT / "examples" / name).read_bytes()
            assert [hashlib.sha256(content).hexdigest()] == digests, name


def test_the_client_has_links_to_the_core():
    """An edit in place makes a copy of a link, which falls behind."""
    for name in ("number_text.py", "results.py"):
        link = ROOT / "client" / "gamutclient" / name
        assert link.is_symlink()
        assert link.resolve() == ROOT / "gamutcore" / name
