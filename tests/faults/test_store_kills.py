"""A short run of ``store_kills.py``."""

import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parent / "store_kills.py"

specification = importlib.util.spec_from_file_location("store_kills", PROGRAM)
store_kills = importlib.util.module_from_spec(specification)
sys.modules["store_kills"] = store_kills
specification.loader.exec_module(store_kills)


def no_tracing():
    """Return why processes cannot be traced here; empty if they can."""
    if shutil.which("strace") is None:
        return "strace is not installed"
    probe = subprocess.run(["strace", "-qq", "-o", "/dev/null", "true"], check=False)
    return "" if probe.returncode == 0 else "tracing is not permitted here"


@pytest.mark.skipif(bool(no_tracing()), reason=no_tracing())
def test_no_kill_loses_or_damages_anything(tmp_path):
    figures = store_kills.survived(tmp_path, 20)
    assert figures["losses"] == []
    assert figures["kills"] == 20
    assert figures["points"] > 50
    assert {"write", "fsync", "link", "rename", "unlink"} & set(figures["calls"])


def test_losses_are_found(tmp_path):
    """A loss that the check must find, or the test above would prove nothing."""
    expected = store_kills.Expected()
    output = subprocess.run(
        [sys.executable, PROGRAM, "--work", tmp_path / "store"],
        capture_output=True,
        text=True,
        check=True,
        env={"PYTHONPATH": str(PROGRAM.parents[2])},
    ).stdout
    assert expected.learn(output)
    assert store_kills.losses(tmp_path / "store", expected) == []
    for suffix in ("gamut", "input", "job"):
        for path in (tmp_path / "store").rglob(f"*.{suffix}"):
            path.write_bytes(path.read_bytes()[:-1] if suffix != "job" else store_kills.seal(b"0"))
    found = " ".join(store_kills.losses(tmp_path / "store", expected))
    for word in ("damaged", "lost input", "fell back", "quarantined"):
        assert word in found
