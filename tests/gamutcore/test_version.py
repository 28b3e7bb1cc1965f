"""The versions of the distribution and of the algorithm."""

import importlib.metadata
import re
from pathlib import Path

import pytest
from packaging.version import Version

from gamutcore.version import __version__

ROOT = Path(__file__).parents[2]


def test_it_is_a_version_in_its_canonical_form():
    assert str(Version(__version__)) == __version__
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", __version__)


@pytest.mark.parametrize(
    "path",
    [
        "CITATION.cff",
        "Dockerfile",
        "client/pyproject.toml",
        "deploy/compose.yaml",
        "deploy/helm/gamut/Chart.yaml",
        "web/boundary/package.json",
    ],
)
def test_the_files_that_a_release_changes_have_it(path):
    assert f"`{path}`" in (ROOT / "RELEASING.md").read_text()
    versions = re.findall(r"(?i)version\W+([\d.]+)|service:([\d.]+)", (ROOT / path).read_text())
    assert __version__ in {one or other for one, other in versions}


def test_the_installed_distribution_has_it():
    try:
        installed = importlib.metadata.version("gamut-boundary-service")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("the package is run from its checkout, not installed")
    assert installed == __version__
