"""Runs of the programs of this folder; `make faults` runs them for an hour."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent

sys.path.insert(0, str(HERE))
import store_kills  # noqa: E402 - a program beside this one


def run(program, *arguments):
    """Run a program of this folder, and return its end."""
    command = [sys.executable, HERE / program, *arguments]
    environment = {**os.environ, "PYTHONPATH": str(HERE.parents[1])}
    return subprocess.run(command, check=False, capture_output=True, text=True, env=environment)


def test_the_service_answers_as_its_document_says():
    arguments = ["--seconds", "60", "--seed", "1", "--phases", "examples,coverage"]
    ended = run("api_properties.py", *arguments, "--stateful-examples", "6")
    assert ended.returncode == 0, ended.stdout[-10_000:] + ended.stderr[-5000:]
    assert "API Links:" in ended.stdout


def test_hostile_clients_do_not_affect_others():
    ended = run("hostile_clients.py")
    assert ended.stdout, ended.stderr[-5000:]
    figures = json.loads(ended.stdout)
    assert [row for row in figures["attacks"] if not row["as_deserved"]] == []
    assert figures["growth_mb"] * 1e6 <= 64 << 20
    assert figures["good_failures"] == []
    assert figures["good_requests"] > 100
    assert figures["tracebacks"] == 0
    assert ended.returncode == 0


def test_one_client_does_not_keep_others_waiting():
    ended = run("load_attacks.py", "--gamuts", "4", "--scale", "0.4")
    assert ended.stdout.count("p99") == 10, ended.stderr[-5000:]  # five attacks, and `/livez`
    assert ended.returncode == 0, ended.stdout


def no_tracing():
    """Return why processes cannot be traced here; empty if they can."""
    if shutil.which("strace") is None:
        return "strace is not installed"
    probe = subprocess.run(["strace", "-qq", "-o", "/dev/null", "true"], check=False)
    return "" if probe.returncode == 0 else "tracing is not permitted here"


@pytest.mark.skipif(bool(no_tracing()), reason=no_tracing())
def test_no_kill_loses_or_damages_anything(tmp_path):
    kills = 100
    figures = store_kills.survived(tmp_path, kills)
    assert figures["losses"] == []
    assert figures["kills"] == kills
    assert figures["points"] > 50
    assert {"write", "fsync", "link", "rename", "unlink"} & set(figures["calls"])


def test_losses_are_found(tmp_path):
    """A loss that the check must find, or the test above would prove nothing."""
    expected = store_kills.Expected()
    assert expected.learn(run("store_kills.py", "--work", tmp_path / "store").stdout)
    assert store_kills.losses(tmp_path / "store", expected) == []
    for suffix in ("gamut", "input", "job"):
        for path in (tmp_path / "store").rglob(f"*.{suffix}"):
            path.write_bytes(path.read_bytes()[:-1] if suffix != "job" else store_kills.seal(b"0"))
    found = " ".join(store_kills.losses(tmp_path / "store", expected))
    for word in ("damaged", "lost input", "fell back", "quarantined"):
        assert word in found
