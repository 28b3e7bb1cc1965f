"""Clients that three generators make of ``openapi/openapi.json`` compile, and one is run."""

import json
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from gamutcore.options import Options
from tests.conftest import missing

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[3]
DOCUMENT = ROOT / "openapi" / "openapi.json"
CLIENTS = ROOT / "tests" / "clients"


CONTENT_TYPES = """\
content_type_overrides:
  application/x-npy: application/octet-stream
  text/csv: application/octet-stream
  image/*: application/octet-stream
"""
"""Settings of openapi-python-client, as `docs/http-api.md` has them."""


def run(*arguments, folder):
    ended = subprocess.run(
        list(map(str, arguments)), cwd=folder, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    """A folder with the package ``gamut_client`` and the module ``gamut_models``."""
    folder = tmp_path_factory.mktemp("clients")
    # hooks need a formatter on the path
    (folder / "settings.yaml").write_text(f"post_hooks: []\n{CONTENT_TYPES}")
    generators = (
        (
            *("openapi_python_client", "generate", "--path", DOCUMENT),
            *("--config", "settings.yaml", "--meta", "none", "--output-path", "gamut_client"),
            "--fail-on-warning",
        ),
        (
            *("datamodel_code_generator", "--input", DOCUMENT),
            *("--input-file-type", "openapi", "--output-model-type", "pydantic_v2.BaseModel"),
            *("--use-annotated", "--enum-field-as-literal", "all", "--formatters", "builtin"),
            *("--output", "gamut_models.py"),
        ),
    )
    with ThreadPoolExecutor() as threads:
        list(threads.map(lambda each: run(sys.executable, "-m", *each, folder=folder), generators))
    shutil.copy(CLIENTS / "usage.py", folder)
    return folder


def test_python_clients_and_their_use_are_well_typed(generated):
    run(sys.executable, "-m", "mypy", "--strict", "--config-file=", ".", folder=generated)


def test_a_python_client_reads_everything_of_a_gamut(server, generated):
    press = ROOT / "examples" / "FOGRA39L.ti3"
    found = json.loads(run(sys.executable, "usage.py", server.url, press, folder=generated))
    given = {"space": "Oklab", "surface_samples": 2000, "gamma": 0.5, "centre": [0.5, 0, 0]}
    assert found["options"] == Options.from_mapping(given).to_mapping()
    levels = server.client.get(f"/v1/gamuts/{found['id']}/levels?side=inside").json()["levels"]
    assert found["levels"] == [level["triangles"] for level in levels]
    assert found["signatures"][:2] == ["glTF", "ply\n"]
    assert len(set(found["history_bytes"])) == 1
    assert found["problem"] == "gamut-not-found"
    assert found["luminance"] == 100


def test_a_typescript_client_is_well_typed(tmp_path):
    modules = CLIENTS / "node_modules"
    if shutil.which("node") is None or not modules.is_dir():
        missing("openapi-typescript is not installed: run `make test`, or npm ci in tests/clients")
    (tmp_path / "node_modules").symlink_to(modules)
    (tmp_path / "package.json").write_text('{"type": "module"}')
    shutil.copy(CLIENTS / "usage.ts", tmp_path)
    run(
        *("node", "node_modules/openapi-typescript/bin/cli.js", DOCUMENT, "--output", "api.ts"),
        "--default-non-nullable=false",
        folder=tmp_path,
    )
    run(
        *("node", "node_modules/typescript/bin/tsc", "--noEmit", "--strict", "--target", "es2022"),
        *("--module", "nodenext", "--lib", "es2022,dom", "usage.ts"),
        folder=tmp_path,
    )
