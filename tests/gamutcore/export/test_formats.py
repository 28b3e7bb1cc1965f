"""STL and OBJ, and the table of all formats."""

import io
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from gamutcore.colours.spaces import ColourSpace, srgb
from gamutcore.errors import OptionError
from gamutcore.export import FORMATS, format_of_suffix, mesh_file

FOUR_CHANNELS = [name for name in FORMATS if name != "cge"]
"""Formats of meshes with the device values of a press."""


class TestStl:
    def test_is_the_triangles_bit_for_bit(self, level):
        """80 bytes of anything, a count, then normal, three corners and two bytes per triangle."""
        data = mesh_file(level, "stl")
        triangle = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
        assert int.from_bytes(data[80:84], "little") == level.triangles
        assert len(data) == 84 + level.triangles * triangle.itemsize
        read = np.frombuffer(data, triangle, level.triangles, 84)
        np.testing.assert_array_equal(read["corners"], level.vertices[level.faces])

    def test_normals_point_outwards(self, level):
        read = trimesh.load(io.BytesIO(mesh_file(level, "stl")), "stl", process=False)
        assert read.volume == pytest.approx(level.volume, rel=1e-5)


class TestObj:
    def test_trimesh_reads_it_back(self, level, provenance):
        read = trimesh.load(
            io.BytesIO(mesh_file(level, "obj", provenance)),
            "obj",
            process=False,
            maintain_order=True,
        )
        np.testing.assert_array_equal(read.vertices.astype(np.float32), level.vertices)
        np.testing.assert_array_equal(read.faces, level.faces)

    def test_colours_are_polypaint_before_the_faces(self, level):
        """``#MRGB``: up to 64 times mask, red, green and blue in hex (Bourke 2020)."""
        lines = mesh_file(level, "obj").decode("ascii").splitlines()
        words = [line.split()[1] for line in lines if line.startswith("#MRGB ")]
        assert max(map(len, words)) <= 64 * 8
        colours = np.frombuffer(bytes.fromhex("".join(words)), np.uint8).reshape(-1, 4)
        np.testing.assert_array_equal(colours[:, 0], 255)
        np.testing.assert_allclose(
            colours[:, 1:] / 255, srgb(level.vertices), atol=0.5 / 255 + 1e-6
        )
        kinds = [line.split()[0] for line in lines if line and not line.startswith("# ")]
        assert kinds == sorted(kinds, key=["v", "#MRGB", "f"].index)


class TestFormats:
    @pytest.mark.parametrize("name", FOUR_CHANNELS)
    def test_reruns_are_bit_identical(self, level, name, provenance):
        assert mesh_file(level, name, provenance) == mesh_file(level, name, provenance)


class TestRefusals:
    @pytest.mark.parametrize("name", ["", "GLB", "usdz", ".ply", "../glb"])
    def test_of_other_formats(self, level, name):
        with pytest.raises(OptionError, match="no mesh format") as caught:
            mesh_file(level, name)
        assert caught.value.where == {"field": "format"}
        assert "glb" in caught.value.remedy

    @pytest.mark.parametrize("suffix", ["", ".", "glb", ".stp"])
    def test_of_other_suffixes(self, suffix):
        assert format_of_suffix(".GLB").name == "glb"
        with pytest.raises(OptionError, match="no mesh format") as caught:
            format_of_suffix(suffix)
        assert ".glb" in caught.value.remedy

    @pytest.mark.parametrize(
        "space", [ColourSpace("Oklab"), ColourSpace("CIEXYZ"), ColourSpace("CIELAB", "D65")]
    )
    @pytest.mark.parametrize("name", ["gam", "icc", "cge"])
    def test_of_other_spaces_where_a_format_has_cielab_alone(self, level, space, name):
        with pytest.raises(OptionError, match="D50") as caught:
            mesh_file(level, name, {}, space)
        assert caught.value.where == {"field": "format"}
        assert "CIELAB" in caught.value.remedy


AT_ONCE = """
import threading
import numpy as np
from gamutcore.export import mesh_file
from gamutcore.geometry import TriangleMesh

corners = np.vstack([np.zeros(3), np.eye(3)]).astype(np.float32)
mesh = TriangleMesh(corners, np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]))
start = threading.Barrier(3)

def write(name):
    start.wait()
    mesh_file(mesh, name)

threads = [threading.Thread(target=write, args=(name,)) for name in ("ply", "stl", "obj")]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
"""


@pytest.mark.slow
def test_the_first_files_may_be_written_by_several_threads():
    """The modules of trimesh import one another, and are imported on first use."""
    command = [sys.executable, "-c", AT_ONCE]
    ended = subprocess.run(command, check=True, capture_output=True, text=True)
    assert ended.stderr == ""
