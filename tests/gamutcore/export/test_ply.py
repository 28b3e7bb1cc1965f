"""PLY: exact positions, 8-bit sRGB, provenance in comments."""

import io
import re
from dataclasses import replace

import meshio
import numpy as np
import pytest
import trimesh

from gamutcore.export import mesh_file
from gamutcore.geometry import DeviceValues


def header_lines(data):
    return data[: data.index(b"end_header\n")].decode("ascii").splitlines()


@pytest.fixture
def written(level, provenance):
    return mesh_file(level, "ply", provenance)


def test_the_arrays_are_where_the_header_puts_them(level, written):
    """A minimal reader: fixed records of vertices, then of faces."""
    body = written[written.index(b"end_header\n") + len("end_header\n") :]
    vertex = np.dtype([("position", "<f4", 3), ("colour", "u1", 3)])
    face = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    assert len(body) == len(level.vertices) * vertex.itemsize + level.triangles * face.itemsize
    vertices = np.frombuffer(body, vertex, len(level.vertices))
    faces = np.frombuffer(body, face, level.triangles, len(level.vertices) * vertex.itemsize)
    np.testing.assert_array_equal(vertices["position"], level.vertices)
    np.testing.assert_array_equal(faces["corners"], level.faces)
    assert (faces["count"] == 3).all()


def test_colours_are_srgb_in_eight_bits(level, written, displayed):
    read = meshio.read(io.BytesIO(written), "ply")
    stored = np.stack([read.point_data[name] for name in ("red", "green", "blue")], axis=1)
    stored = stored.view(np.uint8)  # meshio takes uchar for signed
    expected = 255 * displayed(level.vertices, encoded=True)
    assert np.abs(stored - expected).max() <= 0.51
    loaded = trimesh.load(io.BytesIO(written), "ply", process=False)
    np.testing.assert_array_equal(loaded.visual.vertex_colors[:, :3], stored)


class TestComments:
    def test_have_every_entry_on_a_line_of_its_own(self, written, provenance):
        comments = [line for line in header_lines(written) if line.startswith("comment ")]
        assert len(comments) == len(provenance) + 1
        assert comments[0].startswith("comment generator: gamutcore ")
        assert "comment conditions: D50, 2\\xb0 M1" in comments

    def test_keep_other_scripts_readable_in_ascii(self, written, provenance):
        (line,) = [line for line in header_lines(written) if line.startswith("comment title")]
        text = line.removeprefix("comment title: ")
        assert text.encode("ascii").decode("unicode_escape") == provenance["title"]

    def test_cannot_end_the_header_or_add_to_it(self, mesh_readers, level, written):
        assert written.count(b"\nend_header\n") == 1
        assert len(re.findall(rb"^element ", written.split(b"end_header\n")[0], re.MULTILINE)) == 2
        assert mesh_readers["ply", "trimesh"](written) == level


class TestDeviceValues:
    """Each channel is a float property after the colours, with its name in a comment."""

    def test_are_properties(self, press_gamut, provenance):
        level = press_gamut.level(1000)
        written = mesh_file(level, "ply", provenance)
        lines = header_lines(written)
        names = [f"device_{ink}" for ink in "CMYK"]
        properties = [line.split()[1:] for line in lines if line.startswith("property")]
        assert properties[6:-1] == [["float", name] for name in names]
        assert [line for line in lines if line.startswith("comment device_")] == [
            f"comment {name}: {ink}" for name, ink in zip(names, "CMYK", strict=True)
        ]
        read = meshio.read(io.BytesIO(written), "ply")
        np.testing.assert_array_equal(read.points, level.vertices)
        for channel, name in enumerate(names):
            np.testing.assert_array_equal(read.point_data[name], level.device.values[:, channel])

    def test_channels_of_any_name_break_nothing(self, level):
        channels = (
            "end_header\nproperty",
            "Größe",
            "",
            "\ud800",
            "Gold!",
            "gold",
            "GOLD",
            "2",
            "2",
        )
        values = np.full((len(level.vertices), 9), 0.5, np.float32)
        written = mesh_file(replace(level, device=DeviceValues(channels, values)), "ply")
        read = meshio.read(io.BytesIO(written), "ply")
        np.testing.assert_array_equal(read.points, level.vertices)
        named = [name for name in read.point_data if name.startswith("device_")]
        assert len(named) == 9
        assert all((read.point_data[name] == 0.5).all() for name in named)
