"""The fuzz targets, for a bounded number of cases: `make fuzz` runs them for longer."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
CASES = {"cgats": 2000, "cxf": 2000, "jpeg": 2000, "png": 2000, "tiff": 2000}
"""Mutated files that the project promises to stand; the others get fewer."""


TARGETS = sorted(path.stem for path in (HERE / "targets").glob("[a-z]*.py") if path.stem != "icc")
"""All but profiles, which `test_icc` breaks."""


@pytest.mark.parametrize("cases", sorted({1000, *CASES.values()}))
def test_mutated_files_give_a_named_error_or_a_finite_result(cases):
    """Each within two seconds and 512 MB, which the program that runs them sees to.

    One process feeds all targets with as many cases: to start takes longer than most targets.
    """
    names = [name for name in TARGETS if CASES.get(name, 1000) == cases]
    assert names
    ended = subprocess.run(
        [sys.executable, HERE / "fuzz.py", "--cases", str(cases), *names],
        check=False,
        capture_output=True,
        text=True,
        cwd=HERE.parents[1],
    )
    assert ended.returncode == 0, ended.stderr[-3000:]
    assert [line.partition(":")[0] for line in ended.stdout.splitlines()] == names
