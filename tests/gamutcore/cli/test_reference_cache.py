"""The cache of reference gamuts: what is kept, and what happens where it cannot be."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gamutcore.building import gamut_id
from gamutcore.cli import reference_cache
from gamutcore.cli.reference_cache import CACHE_VARIABLE, cache_directory, cached_reference
from gamutcore.options import Options
from gamutcore.references import find_reference
from gamutcore.version import __version__

SRGB = find_reference("sRGB")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache" / __version__


class Builder:
    """Counts builds of a gamut that is there already."""

    def __init__(self, gamut):
        self.gamut, self.builds = gamut, 0

    def __call__(self):
        self.builds += 1
        return self.gamut


@pytest.fixture
def builder(small_gamut, monkeypatch):
    monkeypatch.setattr("gamutcore.building.gamut_id", lambda *_: small_gamut.id)
    return Builder(small_gamut)


def test_a_second_use_reads_the_file(cache, builder):
    first = cached_reference(SRGB, Options(), builder)
    second = cached_reference(SRGB, Options(), builder)
    assert builder.builds == 1
    assert first.to_bytes() == second.to_bytes()
    (path,) = cache.iterdir()
    assert path.name == f"{builder.gamut.id}.gamut"


@pytest.mark.parametrize("damage", [b"", b"rubbish", None])
def test_a_damaged_file_is_replaced(cache, builder, damage):
    cached_reference(SRGB, Options(), builder)
    (path,) = cache.iterdir()
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 2 // 3] if damage is None else damage)
    cached_reference(SRGB, Options(), builder)
    assert builder.builds == 2
    assert path.read_bytes() == whole


def test_nothing_is_kept_if_switched_off(tmp_path, monkeypatch, builder):
    monkeypatch.setenv(CACHE_VARIABLE, "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_directory() is None
    for _ in range(2):
        cached_reference(SRGB, Options(), builder)
    assert builder.builds == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="XDG is of Linux")
def test_the_directory_is_that_of_xdg(tmp_path, monkeypatch):
    monkeypatch.delenv(CACHE_VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_directory() == tmp_path / "gamut-boundary-service" / __version__


def test_a_directory_that_cannot_be_made_is_not_used(tmp_path, monkeypatch, builder):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "file" / "cache"))
    assert cached_reference(SRGB, Options(), builder) is builder.gamut


def test_the_files_used_last_are_kept(cache, builder, monkeypatch):
    monkeypatch.setattr(reference_cache, "MOST_FILES", 3)
    cache.mkdir(parents=True)
    for age in range(5):
        path = cache / f"{age}.gamut"
        path.write_bytes(b"")
        os.utime(path, (1000 - age, 1000 - age))
    cached_reference(SRGB, Options(), builder)
    kept = {path.name for path in cache.iterdir()}
    assert kept == {f"{builder.gamut.id}.gamut", "0.gamut", "1.gamut"}


@pytest.mark.slow
def test_processes_share_the_cache(tmp_path):
    environment = {**os.environ, CACHE_VARIABLE: str(tmp_path)}
    command = [sys.executable, "-m", "gamutcore", "info", "srgb", "--surface-samples", "500"]
    started = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE) for _ in range(2)]
    answers = {process.communicate()[0] for process in started}
    assert len(answers) == 1
    assert all(process.returncode == 0 for process in started)
    wanted = gamut_id(Options(surface_samples=500), SRGB.sha256)
    folder = tmp_path / __version__
    assert [path.name for path in Path(folder).iterdir()] == [f"{wanted}.gamut"]
