"""A level as a mesh that is saved in the format of the suffix."""

import json

import pytest
import trimesh

from gamutcore.errors import OptionError


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".ply", ".stl", ".OBJ"])
def test_is_saved_in_the_format_of_the_suffix(small_gamut, tmp_path, suffix):
    path = tmp_path / f"level{suffix}"
    small_gamut.mesh(40).save(path)
    assert len(trimesh.load(path, force="mesh").faces) == 40


def test_a_file_has_the_provenance_of_the_gamut(small_gamut):
    extras = json.loads(small_gamut.mesh(40).to_bytes("gltf"))["asset"]["extras"]
    assert extras["gamut"] == small_gamut.id


def test_other_formats_are_refused(small_gamut, tmp_path):
    with pytest.raises(OptionError, match="suffix"):
        small_gamut.mesh(40).save(tmp_path / "level.txt")
    with pytest.raises(OptionError, match="format"):
        small_gamut.mesh(40).to_bytes("txt")
