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


def test_imports_of_all_forms_are_found(architecture, tmp_path):
    for name, text in {
        "gamutcore/a/__init__.py": "from gamutcore.a.inner import x",
        "gamutcore/a/inner.py": "import gamutcore.b",
        "gamutcore/b.py": "import numpy",
        "service/c.py": "def f():\n    from gamutcore import a, b",
        "service/d/__init__.py": "from service.c import f",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    assert architecture.find_imports(tmp_path) == {
        "gamutcore.a": {"gamutcore.b"},
        "gamutcore.b": set(),
        "service.c": {"gamutcore.a", "gamutcore.b"},
        "service.d": {"service.c"},
    }


@pytest.mark.slow
def test_only_imports_that_follow_from_others_are_left_out(architecture):
    imports = {"a": {"b", "c"}, "b": {"c"}, "c": set()}
    assert architecture.reduce_transitively(imports) == {"a": {"b"}, "b": {"c"}, "c": set()}
