import hashlib
import io
import json
import resource
import subprocess
import sys

import numpy as np
import pytest

from gamutcore import Gamut, Options
from gamutcore.building import gamut_id
from service.building import worker
from service.building.process import private_bytes


@pytest.fixture
def result(tmp_path):
    """Build from these bytes and options, and return all events."""

    def run(data, options, output="history", memory=0, job=None):
        (tmp_path / "input").write_bytes(data)
        stream = io.BytesIO()
        request = {
            "id": job or expected_id(data, options),
            "input": str(tmp_path / "input"),
            "output": str(tmp_path / output),
            "options": options,
            "memory": memory,
        }
        worker.build(request, worker.Events(stream))
        return [json.loads(line) for line in stream.getvalue().splitlines()]

    return run


def expected_id(data, options):
    known = Options.from_mapping(options if "unknown" not in options else {})
    return gamut_id(known, hashlib.sha256(data).hexdigest())


def document(samples):
    return json.dumps({"samples": samples}).encode()


def test_the_history_file_is_written_and_described(result, sphere, tmp_path):
    options = Options.from_mapping({"gamma": 0.5})
    *progress, built = result(document(sphere()), options.to_mapping())
    content = (tmp_path / "history").read_bytes()
    assert built["event"] == "built"
    assert built["sha256"] == hashlib.sha256(content).hexdigest()
    assert built["nbytes"] == len(content)
    assert built["description"] == json.loads(json.dumps(Gamut.from_bytes(content).description))
    assert built["description"]["options"] == options.to_mapping()
    assert progress
    for event in progress:
        assert event["event"] == "progress"
        assert event["stage"]
        assert 0 <= event["fraction"] <= 1


def test_an_error_of_gamutcore_is_passed_on_whole(result):
    (*_, refused) = result(b"LAB_L,LAB_A,LAB_X\n1,2,3\n", {})
    assert refused["event"] == "refused"
    assert refused["code"] == "missing-column"
    assert refused["message"]


def test_a_job_of_another_version_is_not_published_under_its_id(result, sphere, tmp_path):
    *_, outdated = result(document(sphere()), {}, job="0" * 64)
    assert outdated["event"] == "outdated"
    assert not (tmp_path / "history").exists()


def test_an_option_of_another_version_is_refused(result, sphere):
    (refused,) = result(document(sphere()), {"unknown": 1})
    assert refused["seconds"] == {}
    assert (refused["code"], refused["where"]) == ("invalid-option", {"field": "unknown"})


def test_a_disk_error_has_its_number(result, sphere):
    *_, failed = result(document(sphere()), {}, output="no/such/folder/history")
    assert failed.items() >= {"event": "failed", "errno": 2}.items()


def test_a_defect_costs_one_build(result, monkeypatch):
    def defect(*_arguments, **_options):
        raise ZeroDivisionError

    monkeypatch.setattr(worker, "Gamut", defect)
    assert result(b"", {}) == [{"event": "failed", "errno": None, "seconds": {}}]


def test_the_seconds_of_all_stages_are_told(result, sphere):
    *_, built = result(document(sphere()), {})
    assert {"characterisation", "boundary", "decimation", "metric"} <= set(built["seconds"])
    assert all(seconds >= 0 for seconds in built["seconds"].values())
    assert sum(built["seconds"].values()) > 0


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits what was mapped")
def test_an_allocation_beyond_the_memory_fails_and_the_next_build_works(
    result, sphere, monkeypatch
):
    def greedy(*_arguments, **_options):
        return np.ones(100_000_000)

    limits = resource.getrlimit(resource.RLIMIT_DATA)
    usual = worker.Gamut
    in_use = private_bytes("self")
    monkeypatch.setattr(worker, "Gamut", greedy)
    (exhausted,) = result(document(sphere()), {}, memory=in_use + 400_000_000)
    assert exhausted["event"] == "exhausted"
    assert resource.getrlimit(resource.RLIMIT_DATA) == limits
    monkeypatch.setattr(worker, "Gamut", usual)
    *_, built = result(document(sphere()), {}, memory=in_use + 2_000_000_000)
    assert built["event"] == "built"


@pytest.mark.slow
def test_the_process_is_ready_once_and_ends_with_its_input():
    command = [sys.executable, "-m", "service.building.worker"]
    answer = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, timeout=120, check=False
    )
    assert answer.returncode == 0
    assert answer.stdout in {b"", b'{"event": "ready"}\n'}
