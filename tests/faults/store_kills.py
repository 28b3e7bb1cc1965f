"""Kill a process at the system calls that write to a store, and check what is left.

A child process stores inputs, creates and replaces job documents, publishes and deletes gamuts in a
local store, and prints each acknowledged step. ``strace`` sends it SIGKILL when it enters the n-th
``write``, ``fsync``, ``link``, ``rename``, ``unlink`` or ``mkdir``, with a different n each time.
After each kill the directory is opened again, as by a restarted service. Everything acknowledged
must be there byte for byte, and nothing incomplete may be visible.

``store_kills.py --kills 500`` prints one line of JSON with the figures and exits with 1 after any
loss or damage. It needs strace and the permission to trace.
"""

import argparse
import contextlib
import hashlib
import json
import os
import random
import re
import secrets
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from itertools import cycle, islice
from pathlib import Path

from service.storage.blobs import BlobNotFoundError, seal, unseal
from service.storage.gamut_store import GamutNotStoredError, GamutStore
from service.storage.local import LocalBlobs
from service.storage.published import PublishedGamut, id_of

CALLS = "write,fsync,link,linkat,rename,renameat,renameat2,unlink,unlinkat,mkdir,mkdirat"
"""All calls that change a file system, under all names that a C library may use."""

ROUNDS = 2
"""Rounds of a child. The first round creates the folders."""

START = b"start\n"


def content(gamut_id):
    """Return the content of an id, long enough for several writes."""
    seed = hashlib.sha256(gamut_id.encode()).digest()
    return (seed * 1000)[: 20_000 + seed[0]]


def say(word, *values):
    os.write(1, (" ".join([word, *map(str, values)]) + "\n").encode())


def work(directory):
    """Use a store as the service does, and acknowledge each step."""
    store = GamutStore(LocalBlobs(directory))
    os.write(1, START)
    store.open()
    previous = None
    for _ in range(ROUNDS):
        gamut_id = secrets.token_hex(32)
        data = content(gamut_id)
        store.keep_input(gamut_id, data, {"gamma": 0.2})
        say("kept", gamut_id)
        job = f"jobs/{gamut_id[:2]}/{gamut_id}.job"
        version = store.blobs.create(job, seal(b"0"))
        say("job", gamut_id, 0)
        for number in (1, 2):
            version = store.blobs.replace(job, seal(b"%d" % number), version)
            say("job", gamut_id, number)
        output = store.scratch(".gamut")
        output.write_bytes(data)
        digest = hashlib.sha256(data).hexdigest()
        store.publish(PublishedGamut(gamut_id, digest, len(data), "", {}), output)
        say("published", gamut_id)
        if previous is not None:
            say("deleting", previous)
            store.delete(previous)
            say("deleted", previous)
        previous = gamut_id
    store.close()
    say("done")


class Expected:
    """What has been acknowledged so far, by the names of `work`."""

    def __init__(self):
        self.jobs = {}
        self.kept, self.published, self.deleting, self.deleted = set(), set(), set(), set()

    def learn(self, output):
        """Read the output of a child; return whether the child reached its end."""
        for line in output.splitlines():
            word, *values = line.split()
            if word == "job":
                self.jobs[values[0]] = int(values[1])
            elif word in {"kept", "published", "deleting", "deleted"}:
                getattr(self, word).add(values[0])
        return output.endswith("done\n")


def losses(directory, expected):
    """Open the store again and return what is lost, damaged, incomplete or left over."""
    found = []
    blobs = LocalBlobs(directory)
    store = GamutStore(blobs)
    store.open()
    with contextlib.closing(store):
        store._sweeping.join()
        found += [f"left over: {path.name}" for path in store.scratch("").parent.iterdir()]
        visible = list(store.ids())
        for gamut_id in visible:
            try:
                if store.content(gamut_id)[1] != content(gamut_id):
                    found.append(f"other content: {gamut_id}")
            except GamutNotStoredError:
                found.append(f"damaged: {gamut_id}")
        lost = expected.published - expected.deleting - {*visible}
        found += [f"lost: {gamut_id}" for gamut_id in lost]
        found += [f"came back: {gamut_id}" for gamut_id in expected.deleted & {*visible}]
        histories = [id_of(key) for key in blobs.keys("published/") if key.endswith(".gamut")]
        if Counter(histories) != Counter(visible):
            found.append("histories without records")
        for gamut_id in expected.kept - expected.deleting:
            try:
                path = store.input_path(gamut_id)
                if path.read_bytes() != content(gamut_id):
                    found.append(f"other input: {gamut_id}")
                path.unlink()
            except BlobNotFoundError:
                found.append(f"lost input: {gamut_id}")
        for gamut_id, number in expected.jobs.items():
            data = unseal(blobs.read(f"jobs/{gamut_id[:2]}/{gamut_id}.job").data)
            if int(data) not in {number, number + 1}:
                found.append(f"job {gamut_id} fell back from {number} to {int(data)}")
        found += [f"quarantined: {key}" for key in blobs.keys("quarantine/")]
    return found


def child(directory, *options):
    """Run `work` under strace."""
    return subprocess.run(
        [
            *("strace", "-f", "-qq", "-e", f"trace={CALLS}", *options),
            *(sys.executable, __file__, "--work", directory),
        ],
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )


def kill_points(directory):
    """Return name and number of every call of a child that changes the file system."""
    log = directory / "trace"
    ended = child(directory / "points", "-o", str(log))
    if not ended.stdout.endswith(b"done\n"):
        raise RuntimeError(ended.stderr.decode()[-500:])
    counts = Counter()
    points, started, main = [], False, ""
    for line in log.read_text().splitlines():
        match = re.match(r"(\d+)\s+(\w+)\((.*)", line)
        if match is None:
            continue
        thread, call, arguments = match.groups()
        main = main or thread
        if thread != main:
            continue  # strace counts the calls of each thread separately
        counts[call] += 1
        if started:
            points.append((call, counts[call]))
        started = started or arguments.startswith('1, "start\\n"')
    return points


def survived(directory, kills, seed=0):
    """Kill a child that many times and return the figures.

    Every point of a child comes up before one comes up again. ``calls`` are kills by call,
    ``acknowledged`` counts what was by kind, and ``losses`` says what was wrong after a kill.
    """
    points = kill_points(directory)
    order = random.Random(seed).sample(points, len(points))  # noqa: S311  # not used for security
    expected, found, calls = Expected(), [], Counter()
    store = directory / "store"
    for call, number in islice(cycle(order), 2 * kills):
        if calls.total() == kills:
            break
        ended = child(store, "-o", os.devnull, "-e", f"inject={call}:signal=KILL:when={number}")
        # Existing folders are not created again, so the call may not occur and no kill happens.
        if not expected.learn(ended.stdout.decode()):
            calls[re.sub(r"at2?$", "", call)] += 1
        found += [f"after {call} {number}: {loss}" for loss in losses(store, expected)]
    return {
        "kills": calls.total(),
        "points": len(points),
        "calls": dict(sorted(calls.items())),
        "acknowledged": {
            "inputs": len(expected.kept),
            "jobs": len(expected.jobs),
            "gamuts": len(expected.published),
            "deletions": len(expected.deleted),
        },
        "losses": found,
    }


def main():
    """Run as a program; the exit status is 1 if anything was lost or damaged."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--work", type=Path, help=argparse.SUPPRESS)
    parsed = parser.parse_args()
    if parsed.work:
        work(parsed.work)
        return 0
    if shutil.which("strace") is None:
        sys.exit("strace is not installed")
    with tempfile.TemporaryDirectory() as folder:
        figures = survived(Path(folder), parsed.kills, parsed.seed)
    sys.stdout.write(json.dumps(figures) + "\n")
    return 1 if figures["losses"] else 0


if __name__ == "__main__":
    sys.exit(main())
