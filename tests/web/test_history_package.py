"""The npm package ``web/history``: its tests read a file that `gamutcore` writes."""

import os
import subprocess
from pathlib import Path

import pytest

from gamutcore import Gamut

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_reader(typescript_program, tmp_path):
    gamut = Gamut(ROOT / "examples" / "FOGRA39L.ti3", surface_samples=2000)
    path = tmp_path / "history"
    path.write_bytes(gamut.to_bytes())
    ended = subprocess.run(
        typescript_program(ROOT / "web" / "history" / "tests" / "reader.test.ts"),
        env={**os.environ, "HISTORY": str(path)},
        check=False,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "# fail 0" in ended.stdout
