"""A short run of ``api_properties.py``."""

import subprocess
import sys
from pathlib import Path

PROGRAM = Path(__file__).parent / "api_properties.py"


def test_the_service_answers_as_its_document_says():
    arguments = ["--seconds", "7", "--seed", "1", "--phases", "examples,coverage,stateful"]
    ended = subprocess.run(
        [sys.executable, PROGRAM, *arguments], check=False, capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stdout[-10_000:] + ended.stderr[-5000:]
    assert "API Links:" in ended.stdout
