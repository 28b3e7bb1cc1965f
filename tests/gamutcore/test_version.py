"""The versions of the distribution and of the algorithm."""

import importlib.metadata
import re

import pytest
from packaging.version import Version

from gamutcore.version import __version__


def test_it_is_a_version_in_its_canonical_form():
    assert str(Version(__version__)) == __version__
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", __version__)


def test_the_installed_distribution_has_it():
    try:
        installed = importlib.metadata.version("gamut-boundary-service")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("the package is run from its checkout, not installed")
    assert installed == __version__
