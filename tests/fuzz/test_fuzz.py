"""The fuzz targets, for a bounded number of cases: `make fuzz` runs them for longer."""

import subprocess
import sys
from pathlib import Path

import pytest

from gamutcore.characterisation import read_characterisation
from gamutcore.colours import surface_colours

HERE = Path(__file__).parent
MALFORMED = HERE.parents[2] / "shared" / "data" / "malformed"
CASES = 1500


@pytest.fixture(scope="module")
def targets():
    with pytest.MonkeyPatch.context() as path:
        path.syspath_prepend(str(HERE))
        from targets import TARGETS

        yield TARGETS


@pytest.mark.parametrize("first", [0, 1], ids=["one half", "other half"])
def test_mutated_files_give_a_named_error_or_a_finite_result(targets, first):
    """Each within two seconds and 512 MB, which the program that runs them sees to.

    One process feeds half of the targets: to start takes longer than most targets.
    """
    names = [*targets][first::2]
    ended = subprocess.run(
        [sys.executable, HERE / "fuzz.py", "--cases", str(CASES), *names],
        check=False,
        capture_output=True,
        text=True,
        cwd=HERE.parents[1],
    )
    assert ended.returncode == 0, ended.stderr[-3000:]
    assert [line.partition(":")[0] for line in ended.stdout.splitlines()] == names


def test_the_seeds_of_profiles_are_evaluated(targets):
    kinds = set()
    for data in targets["icc"].seeds:
        profile = read_characterisation(data)
        if "CIED" not in profile.tags:
            kinds.add(profile.transform("relative")[0].kind)
            surface_colours(profile, surface_samples=500)
    assert kinds == {"", "mft1", "mft2", "mAB ", "mpet"}


@pytest.mark.skipif(not MALFORMED.is_dir(), reason="the shared data folder is not beside this")
def test_profiles_that_broke_other_software(targets):
    files = sorted(MALFORMED.iterdir())
    assert files
    for path in files:
        targets["icc"].check(path.read_bytes())
