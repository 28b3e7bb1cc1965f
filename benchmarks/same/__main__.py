"""Compare what users see of the working tree and of an earlier revision: ``make same BEFORE=...``.

The earlier revision is cloned and installed, with the compiled kernels of the working tree where
they fit. Both read the same files and answer the same requests. What differs is printed, and
nothing where nothing does. Exit status: 0 nothing differs, 1 something does, 3 only last bits.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import groupby
from pathlib import Path
from statistics import median

from benchmarks.common import ROOT
from benchmarks.same.inputs import write_inputs
from benchmarks.same.observations import Difference, Observations, differences
from benchmarks.same.probe import AREAS
from benchmarks.same.ratios import OPERATIONS
from benchmarks.same.service_probe import AREAS as SERVICE_AREAS

__all__ = ["main"]

OTHER, LAST_BITS = 1, 3
"""Exit statuses."""

SHOWN = 12
"""Differences of an area that are printed, unless all are asked for."""


def main() -> int:
    """Compare both revisions and return the exit status."""
    every = [*AREAS, *SERVICE_AREAS]
    parser = argparse.ArgumentParser(prog="python -m benchmarks.same", description=__doc__)
    parser.add_argument("revision", help="the earlier revision, such as HEAD~3")
    parser.add_argument("--clone", type=Path, help="an installed clone of it, which is not changed")
    parser.add_argument("--data", type=Path, help="a folder of further files to read")
    parser.add_argument("--only", action="append", choices=every, metavar="AREA", help=f"{every}")
    parser.add_argument("--all", action="store_true", help="print every difference")
    parser.add_argument("--counts", action="store_true", help="print the numbers of observations")
    parser.add_argument("--keep", type=Path, help="a new folder for inputs and observations")
    parser.add_argument("--ratios", action="store_true", help="measure time and memory as well")
    parser.add_argument("--rounds", type=int, default=3, help="of each measurement (3)")
    arguments = parser.parse_args()
    areas = arguments.only or every
    with _folder(arguments.keep) as folder:
        (folder / "inputs").mkdir()
        write_inputs(folder / "inputs", ROOT, arguments.data)
        before = arguments.clone or _install(arguments.revision, folder / "clone")
        sides = {
            name: _Side(tree.resolve(), folder, folder / name, is_given=tree == arguments.clone)
            for name, tree in (("before", before), ("now", ROOT))
        }
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(lambda side: side.observe(areas), sides.values()))
        found = []
        for area in areas:
            one, other = (Observations.load(side.results, area) for side in sides.values())
            if arguments.counts:
                print(f"{area}: {len(other)} observations")
            found += list(differences(area, one, other))
        _report(found, SHOWN if not arguments.all else len(found))
        if arguments.ratios:
            _print_ratios(list(sides.values()), arguments.rounds)
    if any(not each.is_last_bits for each in found):
        return OTHER
    return LAST_BITS if found else 0


@contextlib.contextmanager
def _folder(given: Path | None) -> Iterator[Path]:
    if given is not None:
        given.mkdir(parents=True)
        yield given.resolve()
        return
    with tempfile.TemporaryDirectory(prefix="same-") as folder:
        yield Path(folder)


def _install(revision: str, clone: Path) -> Path:
    """Clone a revision and install it, with the compiled kernels of the working tree."""
    commit = subprocess.check_output(["git", "rev-parse", revision], cwd=ROOT, text=True).strip()
    subprocess.run(["git", "clone", "-q", "--shared", str(ROOT), str(clone)], check=True)
    subprocess.run(["git", "checkout", "-q", "--detach", commit], cwd=clone, check=True)
    for path in (ROOT / "gamutcore").rglob(
        "*.nb?"
    ):  # stamped by their source, so old ones are lost
        copy = clone / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, copy)
    subprocess.run(["make", "install"], cwd=clone, check=True, stdout=sys.stderr)
    return clone


class _Side:
    """A revision that is observed: its tree, and the folder of what is seen of it."""

    def __init__(self, tree: Path, folder: Path, results: Path, *, is_given: bool) -> None:
        self.inputs, self.results = folder / "inputs", results
        results.mkdir()
        # the same programs for both revisions: their own package `benchmarks` is not found
        (results / "programs" / "benchmarks").mkdir(parents=True)
        (results / "programs" / "benchmarks" / "__init__.py").touch()
        shutil.copytree(Path(__file__).parent, results / "programs" / "benchmarks" / "same")
        self.python = str(tree / ".venv/bin/python")
        paths = (results / "programs", tree, tree / "client")
        self.environment = {
            **{k: v for k, v in os.environ.items() if not k.startswith(("GAMUT", "PYTHON"))},
            "PYTHONPATH": os.pathsep.join(map(str, paths)),
            "PYTHONDONTWRITEBYTECODE": "1" if is_given else "",
            "OPENBLAS_NUM_THREADS": "1",
            "GAMUTCORE_CACHE_DIR": str(results / "cache"),
            "COLUMNS": "100",
            "TERM": "dumb",
            "SAME_TREE": str(tree),
            "SAME_GAMUT": str(tree / ".venv/bin/gamut"),
            "SAME_PACKAGES": sysconfig.get_path("purelib"),
        }

    def run(self, module: str, *words: str) -> tuple[float, int]:
        """Run a program and return the number that it prints last, and the peak memory in KiB."""
        command = [self.python, "-P", "-m", f"benchmarks.same.{module}", str(self.inputs), *words]
        with (self.results / f"{module}.log").open("w+b") as log:
            process = subprocess.Popen(
                command, cwd=self.results, env=self.environment, stdout=log, stderr=log
            )
            _, status, usage = os.wait4(process.pid, 0)
            log.seek(0)
            text = log.read().decode(errors="replace")
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise RuntimeError(f"Exit status {process.returncode}: {command}\n{text[-3000:]}")
        return float((text.split() or ["0"])[-1]) if module == "ratios" else 0.0, usage.ru_maxrss

    def observe(self, areas: list[str]) -> None:
        """Observe areas of this revision."""
        for module, known in (("probe", [*AREAS]), ("service_probe", [*SERVICE_AREAS])):
            wanted = [area for area in known if area in areas]
            if wanted:
                start = time.monotonic()
                self.run(module, str(self.results), *wanted)
                print(f"{module}: {time.monotonic() - start:.0f} s", file=sys.stderr)


def _report(found: list[Difference], most: int) -> None:
    """Print differences by area, similar ones once, those in last bits under their own heading."""
    for heading, is_last_bits in (("differs", False), ("differs in last bits only", True)):
        chosen = [each for each in found if each.is_last_bits == is_last_bits]
        for area, group in groupby(chosen, key=lambda each: each.area):
            entries = list(group)
            print(f"{area} {heading}: {len(entries)}")
            kinds: dict[str, list[Difference]] = {}
            for each in entries:
                like = re.sub(r"(?<=')[^' ]*(?=')|[-\d.]+", "", each.text)
                kinds.setdefault(like if most < len(found) else each.name, []).append(each)
            for first, *others in list(kinds.values())[:most]:
                more = f" (and {len(others)} like it)" if others else ""
                print(f"  {first.name}{more}\n    {first.text}")
            if len(kinds) > most:
                print(f"  … {len(kinds) - most} more kinds; --all prints them")


def _print_ratios(sides: list[_Side], rounds: int) -> None:
    """Measure both revisions in turn and print medians, and the medians of their ratios."""
    print(
        f"{'':8}{'before':>10}{'now':>10}{'ratio':>8}   peak MiB{'before':>8}{'now':>8}{'ratio':>8}"
    )
    for operation in OPERATIONS:
        measured = [[side.run("ratios", operation) for side in sides] for _ in range(rounds)]
        line = f"{operation:8}"
        for part, scale in ((0, 1.0), (1, 1 / 1024)):
            one, other = ([turn[side][part] * scale for turn in measured] for side in (0, 1))
            ratio = median(b / a for a, b in zip(one, other, strict=True))
            digits, width = (4, 10) if part == 0 else (0, 8)
            line += f"{median(one):{width}.{digits}f}{median(other):{width}.{digits}f}{ratio:8.2f}"
            line += "" if part else " " * 11
        print(line)


if __name__ == "__main__":
    sys.exit(main())
