"""The picture of the architecture agrees with the imports."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PROGRAM = ROOT / "docs" / "pictures" / "architecture.py"


@pytest.fixture(scope="module")
def architecture():
    spec = importlib.util.spec_from_file_location("architecture", PROGRAM)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_the_picture_is_current(architecture):
    current = PROGRAM.with_suffix(".svg").read_text() == architecture.draw_architecture()
    assert current, "docs/pictures/architecture.svg is out of date: run `make architecture`"
