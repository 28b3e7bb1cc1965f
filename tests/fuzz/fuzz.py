"""Feed mutated files to the parsers: each must give a finite result or an error of gamutcore.

`targets` says what the parsers are. A case may take two seconds of processor time and 512 MB.
What fails is written to `build/fuzz`, with the number that repeats it by `--first`.

    python tests/fuzz/fuzz.py --seconds 600             all targets, for ten minutes
    python tests/fuzz/fuzz.py --cases 2000 cgats cxf    2000 files each, the same in every run
"""

import argparse
import random
import resource
import signal
import sys
import time
import traceback
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from targets import TARGETS  # noqa: E402 - beside this program

ROOT = HERE.parents[1]
FAILURES = ROOT / "build" / "fuzz"

CASE_SECONDS = 2.0
CASE_BYTES = 512 * 2**20
MAX_MUTATIONS = 12
LONGEST = 4_000_000

NUMBERS = [
    b"0", b"-1", b"1e308", b"-1e-320", b"1e999", b"nan", b"inf", b"255", b"100,5", b"1_0",
    b"99999999999999999999", b"0x10", b"3.4.5", b"\xc3\xa9", b"\0", b"\xff\xfe", b"",
]  # fmt: skip


class Hang(Exception):  # noqa: N818 - not an error of the parser, but a verdict on it
    """A case took more than its processor time."""


def mutated(target, chance):
    """Return a file with a few random changes: most of them of words and lines, some of bytes."""
    if target.mutated:
        return target.mutated(chance)
    changed = bytearray(chance.choice(target.seeds))
    for _ in range(min(int(chance.paretovariate(1.0)), MAX_MUTATIONS)):
        change = chance.choice((other_word, other_word, other_line, other_bytes))
        change(changed, target, chance)
    return bytes(changed[:LONGEST])


def other_word(changed, target, chance):
    """Put another word, from the same file, another one, or the lists, in the place of one."""
    # A search from a random place: a list of all words of a picture takes longer than its reading.
    match = target.word.search(changed, chance.randrange(len(changed) + 1))
    if match is None:
        return
    source = chance.choice((changed, chance.choice(target.seeds)))
    found = target.word.search(source, chance.randrange(len(source) + 1))
    pool = chance.choice((target.tokens, NUMBERS, NUMBERS if found is None else [bytes(found[0])]))
    changed[match.start() : match.end()] = chance.choice(pool)


def other_line(changed, target, chance):
    """Drop, double, move or empty a line, or take one of another file."""
    lines = bytes(changed).splitlines(keepends=True)
    if not lines:
        return
    place = chance.randrange(len(lines))
    kind = chance.randrange(5)
    if kind == 0:
        del lines[place]
    elif kind == 1:
        lines.insert(chance.randrange(len(lines)), lines[place])
    elif kind == 2:
        lines.insert(chance.randrange(len(lines)), lines.pop(place))
    elif kind == 3:
        lines[place] = chance.choice(target.tokens) + b"\n"
    else:
        lines.insert(place, chance.choice(chance.choice(target.seeds).splitlines(keepends=True)))
    changed[:] = b"".join(lines)


def other_bytes(changed, target, chance):
    """Change, drop, repeat or cut off bytes anywhere."""
    place = chance.randrange(len(changed) + 1)
    length = min(int(chance.paretovariate(0.7)), 2000)
    kind = chance.randrange(6)
    if kind == 0 and place < len(changed):
        changed[place] = chance.randrange(256)
    elif kind == 1:
        del changed[place : place + length]
    elif kind == 2:
        changed[place:place] = chance.choice(target.tokens)
    elif kind == 3:
        changed[place:place] = changed[place : place + length] * chance.randint(1, 50)
    elif kind == 4:
        other = chance.choice(target.seeds)
        start = chance.randrange(len(other) + 1)
        changed[place : place + length] = other[start : start + length]
    elif chance.random() < 0.2:
        del changed[place:]


def interrupted(_number, _frame):
    """End a case that takes too long."""
    raise Hang(f"more than {CASE_SECONDS:g} s")


def checked(name, seed):
    """Return whether one case is handled as it should be; report and keep it if it is not."""
    target = TARGETS[name]
    data = mutated(target, random.Random(f"{name} {seed}"))  # noqa: S311 - the same in every run
    signal.setitimer(signal.ITIMER_VIRTUAL, CASE_SECONDS)
    try:
        target.check(data)
    except BaseException:  # noqa: BLE001 - whatever it is, it should not be
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        FAILURES.mkdir(parents=True, exist_ok=True)
        path = FAILURES / f"{name}-{seed}"
        path.write_bytes(data)
        traceback.print_exc()
        print(f"{name}: case {seed}, {path.relative_to(ROOT)}", file=sys.stderr)  # noqa: T201
        return False
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    return True


def bound_memory():
    """Let a case take no more than its share beside what is loaded by now."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + CASE_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))


def main():
    """Run the targets that are asked for, and return how many cases failed, at most 1."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("targets", nargs="*", metavar="target", help=", ".join(TARGETS))
    parser.add_argument("--seconds", type=float, default=0.0, help="of all targets together")
    parser.add_argument("--cases", type=int, default=500, help="of each target, without --seconds")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    given = parser.parse_args()
    names = given.targets or [*TARGETS]
    for name in names:
        for seed in TARGETS[name].seeds:  # imports what is imported on first use
            TARGETS[name].check(seed)
    signal.signal(signal.SIGVTALRM, interrupted)
    if Path("/proc/self/statm").exists():
        bound_memory()
    failures = 0
    for name in names:
        begun, number = time.monotonic(), given.first
        while (
            time.monotonic() - begun < given.seconds / len(names)
            if given.seconds
            else number < given.first + given.cases
        ):
            failures += not checked(name, number)
            number += 1
        seconds = time.monotonic() - begun
        print(f"{name}: {number - given.first} cases in {seconds:.1f} s")  # noqa: T201
    return min(failures, 1)


if __name__ == "__main__":
    sys.exit(main())
