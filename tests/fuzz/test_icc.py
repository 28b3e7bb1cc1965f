"""Profiles that are broken in two thousand ways, and files that broke other software.

`python tests/fuzz/test_icc.py 600` goes on for ten minutes with new ones, and says which seed to
give to repeat what fails.
"""

from __future__ import annotations

import importlib.util
import random
import resource
import sys
import time
import warnings
from pathlib import Path
from types import ModuleType

import pytest

CASES = 2000
CASE_SECONDS = 2.0
MOST_BYTES = 512 * 2**20


def target() -> ModuleType:
    """Return the fuzz target of ICC profiles."""
    path = Path(__file__).parent / "targets" / "icc.py"
    spec = importlib.util.spec_from_file_location("fuzz_target_icc", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def peak_bytes() -> int:
    """Return the most memory that this process has held so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def checked(module: ModuleType, seed: int, seeds: list[bytes]) -> None:
    """Check one mutated profile; it may take two seconds of processor time and 512 MB."""
    data = module.mutated(random.Random(seed), seeds)  # noqa: S311 - the same in every run
    begun, held = time.process_time(), peak_bytes()
    module.check(data)
    assert time.process_time() - begun < CASE_SECONDS, seed
    assert peak_bytes() - held < MOST_BYTES, seed


@pytest.fixture(scope="module")
def profiles() -> ModuleType:
    module = target()
    for data in module.SEEDS:  # whatever is compiled or imported on first use
        module.check(data)
    return module


def test_the_seeds_are_evaluated(profiles):
    kinds = set()
    for data in profiles.SEEDS:
        profile = profiles.characterisation(data)
        if "CIED" not in profile.tags:
            kinds.add(profile.transform("relative")[0].kind)
            profiles.surface_colours(profile, surface_samples=500)
    assert kinds == {"", "mft1", "mft2", "mAB ", "mpet"}


def test_mutated_profiles_are_refused_by_name_or_finite(profiles):
    # Real profiles take part where they are there; their tables are too large to be copied often.
    real = sorted((profiles.SHARED / "display").glob("[CM]*.icc"))
    seeds = [*profiles.SEEDS, *(path.read_bytes() for path in real)]
    for seed in range(CASES):
        checked(profiles, seed, seeds)


def test_mutated_real_profiles_with_large_tables(profiles):
    names = ["press/ISOcoated_v2_300_bas.icc", "display/Acer_XB271HU.icc"]
    files = [profiles.SHARED / name for name in names]
    if not all(path.is_file() for path in files):
        pytest.skip("the shared data folder is not beside this checkout")
    seeds = [path.read_bytes() for path in files]
    for seed in range(50):
        checked(profiles, seed, seeds)


def test_files_that_broke_other_software(profiles):
    folder = profiles.SHARED / "malformed"
    if not folder.is_dir():
        pytest.skip("the shared data folder is not beside this checkout")
    files = sorted(folder.iterdir())
    assert files
    for path in files:
        begun, held = time.process_time(), peak_bytes()
        profiles.check(path.read_bytes())
        assert time.process_time() - begun < CASE_SECONDS, path.name
        assert peak_bytes() - held < MOST_BYTES, path.name


def main(seconds: float) -> None:
    """Check new mutations for so long."""
    warnings.simplefilter("error")  # as in the tests
    module = target()
    begun, seed = time.monotonic(), CASES
    while time.monotonic() - begun < seconds:
        try:
            checked(module, seed, module.SEEDS)
        except BaseException:
            print(f"seed {seed}", file=sys.stderr)  # noqa: T201
            raise
        seed += 1
    print(f"{seed - CASES} profiles")  # noqa: T201


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)
