"""A small run of ``hostile_clients.py``."""

import json
import subprocess
import sys
from pathlib import Path

PROGRAM = Path(__file__).parent / "hostile_clients.py"


def test_hostile_clients_do_not_affect_others():
    ended = subprocess.run([sys.executable, PROGRAM], check=False, capture_output=True, text=True)
    assert ended.stdout, ended.stderr[-5000:]
    figures = json.loads(ended.stdout)
    assert [row for row in figures["attacks"] if not row["as_deserved"]] == []
    assert figures["growth_mb"] * 1e6 <= 64 << 20
    assert figures["good_failures"] == []
    assert figures["good_requests"] > 100
    assert figures["tracebacks"] == 0
    assert ended.returncode == 0
