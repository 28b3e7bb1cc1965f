"""The fuzz targets, for a bounded number of cases: `make fuzz` runs them for longer."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
TARGETS = sorted(path.stem for path in (HERE / "targets").glob("[a-z]*.py"))
CASES = 5000 if os.environ.get("GAMUT_TEST_LONG") == "1" else 1000


@pytest.mark.parametrize("first", [0, 1], ids=["one half", "other half"])
def test_mutated_files_give_a_named_error_or_a_finite_result(first):
    """Each within two seconds and 512 MB, which the program that runs them sees to.

    One process feeds half of the targets: to start takes longer than most targets.
    """
    names = TARGETS[first::2]
    ended = subprocess.run(
        [sys.executable, HERE / "fuzz.py", "--cases", str(CASES), *names],
        check=False,
        capture_output=True,
        text=True,
        cwd=HERE.parents[1],
    )
    assert ended.returncode == 0, ended.stderr[-3000:]
    assert [line.partition(":")[0] for line in ended.stdout.splitlines()] == names


@pytest.fixture(scope="module")
def profiles():
    spec = importlib.util.spec_from_file_location("fuzz", HERE / "fuzz.py")
    fuzz = importlib.util.module_from_spec(spec)
    sys.modules["fuzz"] = fuzz
    spec.loader.exec_module(fuzz)
    return fuzz.target("icc")


def test_the_seeds_of_profiles_are_evaluated(profiles):
    kinds = set()
    for data in profiles.SEEDS:
        profile = profiles.characterisation(data)
        if "CIED" not in profile.tags:
            kinds.add(profile.transform("relative")[0].kind)
            profiles.surface_colours(profile, surface_samples=500)
    assert kinds == {"", "mft1", "mft2", "mAB ", "mpet"}


def test_profiles_that_broke_other_software(profiles):
    folder = profiles.SHARED / "malformed"
    if not folder.is_dir():
        pytest.skip("the shared data folder is not beside this checkout")
    files = sorted(folder.iterdir())
    assert files
    for path in files:
        profiles.check(path.read_bytes())
