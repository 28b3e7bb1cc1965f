"""Device values of all levels, and their section of the history file."""

import json
import struct

import numpy as np
import pytest
import safetensors.numpy
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore import Gamut
from gamutcore.boundary import modified_convex_hull
from gamutcore.characterisation import read_characterisation
from gamutcore.colours.profile import profile_colours
from gamutcore.decimation import decimate
from gamutcore.errors import HistoryFileError, MeshError
from gamutcore.geometry import DeviceValues
from gamutcore.history import (
    History,
    build_device_history,
    build_history,
    history_bytes,
    history_from_bytes,
)
from gamutcore.history.device import CORRECTED, FULL_SCALE

CHANNELS = ("Cyan", "Größe 🎨")


@pytest.fixture(scope="module")
def inked(random_cloud):
    """Return a small history of a device of two inks, and the values of its boundary by vertex."""
    boundary = modified_convex_hull(random_cloud(1))
    random = np.random.default_rng(2)
    values = random.choice([0.0, 1.0, 0.37, 0.123456], (len(boundary.mesh.vertices), 2))
    device = DeviceValues(CHANNELS, values)
    return build_history(decimate(boundary.mesh, boundary.centre), device), boundary, values


TRACES = ("x", "y", "z")


def traced(positions):
    """Return positions as device values: 0 to 1 within 100 units of L* = 50."""
    return (np.asarray(positions, np.float64) - (50.0, 0.0, 0.0)) / 200.0 + 0.5


@pytest.fixture(scope="module")
def tracing(icosphere):
    """Return the history of a sphere whose device values are its positions."""
    mesh = icosphere(3, 60.0, (50.0, 0.0, 0.0))
    boundary = modified_convex_hull(mesh.vertices)
    device = DeviceValues(TRACES, traced(boundary.mesh.vertices))
    return build_history(decimate(boundary.mesh, boundary.centre), device)


@pytest.fixture(scope="module")
def srgb(small_profile):
    return small_profile("sRGB-v4.icc")


@pytest.fixture(scope="module")
def srgb_gamut(srgb):
    return Gamut(srgb)


@pytest.fixture(scope="module")
def file(inked):
    return history_bytes(inked[0], {"note": "a note"})


@pytest.fixture(scope="module")
def limited_gamut(fogra39):
    """Return the gamut of a press with an ink limit of 250 %."""
    return Gamut(fogra39, ink_limit=250, surface_samples=20_000)


def header_of(data):
    (size,) = struct.unpack("<Q", data[:8])
    return json.loads(data[8 : 8 + size]), 8 + size


def tampered(data, metadata=None, **arrays):
    """Return a file with arrays or metadata replaced, or without those that are None."""
    header, _ = header_of(data)
    replaced = safetensors.numpy.load(data) | {
        name.replace("__", "."): array for name, array in arrays.items()
    }
    described = header["__metadata__"] | (metadata or {})
    return safetensors.numpy.save(
        {name: array for name, array in replaced.items() if array is not None},
        {name: text for name, text in described.items() if text is not None},
    )


class TestFullBoundary:
    def test_vertices_have_the_values_of_their_sources(self, inked):
        history, boundary, values = inked
        full, found = history.full(), history.device_values(history.triangles)
        assert found.channels == CHANNELS
        assert found.values.dtype == np.float32
        expected = {
            row.tobytes(): value for row, value in zip(boundary.mesh.vertices, values, strict=True)
        }
        for position, value in zip(full.vertices, found.values, strict=True):
            step = 0.5 / FULL_SCALE + 1e-7
            np.testing.assert_allclose(value, expected[position.tobytes()], rtol=0, atol=step)

    def test_one_row_for_each_vertex(self, random_cloud):
        boundary = modified_convex_hull(random_cloud(1))
        decimation = decimate(boundary.mesh, boundary.centre)
        with pytest.raises(MeshError):
            build_history(decimation, DeviceValues(CHANNELS, np.zeros((3, 2))))


class TestLevels:
    @pytest.mark.slow
    def test_coarse_levels_have_the_nearest_values_of_the_full_boundary(self, tracing):
        """Values that are positions, compared with trimesh's nearest points."""
        surface = tracing.full().to_trimesh()
        for triangles in [*range(4, 30, 2), *range(30, tracing.triangles, 200)]:
            vertices = tracing.level(triangles).vertices
            nearest, _, _ = trimesh.proximity.closest_point_naive(surface, vertices)
            found = tracing.device_values(triangles).values
            np.testing.assert_allclose(found, traced(nearest), rtol=0, atol=1.05 / FULL_SCALE)

    def test_moved_neighbours_have_nearest_values(self, shifting_history):
        slots = np.arange(shifting_history.vertices, dtype=np.int32)
        full = shifting_history.full()
        device = build_device_history(
            DeviceValues(TRACES, traced(full.vertices)), slots, shifting_history.splits
        )
        assert len(device.splits.shifted_fine) == len(shifting_history.splits.shifted) > 100
        moving = History(
            shifting_history.splits, shifting_history.centre, shifting_history.step, device
        )
        splits = moving.splits
        for split in (0, 17, 40, len(splits.parent) - 1):
            begin = splits.shifted_end[split - 1] if split else 0
            before = moving.device_values(2 * split + 4).values
            after = moving.device_values(2 * split + 6).values
            for index in range(begin, splits.shifted_end[split]):
                slot = splits.shifted[index]
                for values, rows in (
                    (before, device.splits.shifted_coarse),
                    (after, device.splits.shifted_fine),
                ):
                    expected = (rows[index] / FULL_SCALE).astype(np.float32)
                    np.testing.assert_array_equal(values[slot], expected)

    @pytest.mark.slow
    def test_fine_levels_are_interpolated_along_collapsed_edges(self, fogra39_gamut):
        """Collapse the full boundary step by step, by the definition in floating point."""
        history = fogra39_gamut.history
        splits = history.splits
        values = history.device_values(history.triangles).values.astype(np.float64)
        for slot in range(history.vertices - 1, CORRECTED - 1, -1):
            parent = splits.parent[slot - 4]
            coarse, fine, added = (
                array[slot - 4].astype(np.float64)
                for array in (splits.coarse, splits.fine, splits.added)
            )
            edge = added - fine
            place = np.clip((coarse - fine) @ edge / (edge @ edge), 0.0, 1.0)
            values[parent] += place * (values[slot] - values[parent])
            if slot % 10_000 == 0 or slot == CORRECTED:
                found = history.device_values(2 * slot - 4).values
                # each collapse rounds by half a step, and averages earlier rounding errors
                np.testing.assert_allclose(found, values[:slot], rtol=0, atol=4 / FULL_SCALE)

    @pytest.mark.parametrize("triangles", [1000, 4000, 16_000, 40_000])
    @pytest.mark.slow
    def test_the_device_makes_the_colours_from_the_values(self, srgb_gamut, srgb, triangles):
        """The device reproduces most colours within a hardly visible difference."""
        level = srgb_gamut.level(triangles)
        device = level.device.values.astype(np.float64)
        predicted = profile_colours(read_characterisation(srgb), device, "relative").lab
        error = np.linalg.norm(predicted - level.vertices, axis=1)
        assert error.mean() < 0.1
        assert np.percentile(error, 95) < 0.3

    @pytest.mark.parametrize("triangles", [4, 12, 100, 1000, 10_000])
    @pytest.mark.slow
    def test_levels_keep_the_ink_limit(self, limited_gamut, triangles):
        values = limited_gamut.level(triangles).device.values
        assert values.min() >= 0
        assert values.max() <= 1
        assert values.astype(np.float64).sum(axis=1).max() <= 2.5 + 4 / FULL_SCALE

    def test_bare_colours_have_none(self, small_gamut):
        assert small_gamut.history.device is None
        assert small_gamut.history.device_values(10) is None
        assert small_gamut.level(10).device is None
        assert "device" not in header_of(small_gamut.to_bytes())[0]["__metadata__"]


class TestFile:
    def test_device_values_are_read_back(self, inked, file):
        history, metadata = history_from_bytes(file)
        section = {"channels": list(CHANNELS), "steps": FULL_SCALE, "corrected": CORRECTED}
        assert json.loads(metadata["device"]) == section
        for triangles in range(4, history.triangles + 1, 2):
            assert history.device_values(triangles) == inked[0].device_values(triangles)
        assert history_bytes(history, metadata) == file

    def test_geometry_does_not_depend_on_device_values(self, inked, file):
        """A reader without support for device values finds the geometry unchanged."""
        history = inked[0]
        plain = history_bytes(History(history.splits, history.centre, history.step))
        (one, begin), (other, start) = header_of(plain), header_of(file)
        del one["__metadata__"], other["__metadata__"]
        added = {name for name in other if name not in one}
        assert added == {name for name in other if name.startswith("device.")}
        assert {name: other[name] for name in one} == one
        assert file[start:].startswith(plain[begin:])
        kinds = {other[name]["dtype"] for name in added}
        assert kinds <= {"I32", "U8"}  # types that readers of geometry alone accept

    def test_a_prefix_without_all_device_values_has_none(self, inked, file):
        header, begin = header_of(file)
        last = max(name for name in header if name.startswith("splits."))
        end = begin + header[last]["data_offsets"][1]
        for length in (end, len(file) - 1):
            history, _ = history_from_bytes(file[:length], partial=True)
            assert history.vertices == inked[0].vertices
            assert history.device is None
        history, _ = history_from_bytes(file, partial=True)
        assert history.device_values(30) == inked[0].device_values(30)

    @pytest.mark.long  # of default size: smaller ones take more bits
    def test_a_press_takes_less_than_24_bits_for_each_vertex(self, fogra39):
        gamut = Gamut(fogra39)
        header, _ = header_of(gamut.to_bytes())
        sizes = [
            entry["data_offsets"][1] - entry["data_offsets"][0]
            for name, entry in header.items()
            if name.startswith("device.")
        ]
        assert 8 * sum(sizes) < 24 * gamut.history.vertices


class TestReaderInJavaScript:
    def test_small_history(self, javascript_levels, inked, file):
        history = inked[0]
        levels = javascript_levels(file, channels=2)
        assert len(levels) == history.vertices - 3
        for (positions, faces, values), triangles in zip(
            levels, range(4, history.triangles + 1, 2), strict=True
        ):
            mesh = history.level(triangles)
            assert positions.tobytes() == mesh.vertices.tobytes()
            assert faces.tobytes() == mesh.faces.tobytes()
            np.testing.assert_array_equal(values, history.device_values(triangles).values)

    def test_neighbours_that_move(self, javascript_levels, shifting_history):
        slots = np.arange(shifting_history.vertices, dtype=np.int32)
        values = DeviceValues(TRACES, traced(shifting_history.full().vertices))
        splits = shifting_history.splits
        device = build_device_history(values, slots, splits)
        history = History(splits, shifting_history.centre, shifting_history.step, device)
        data = history_bytes(history)
        read, _ = history_from_bytes(data)
        for (_, _, found), triangles in zip(
            javascript_levels(data, channels=3), range(4, history.triangles + 1, 2), strict=True
        ):
            expected = history.device_values(triangles)
            np.testing.assert_array_equal(found, expected.values)
            assert read.device_values(triangles) == expected


class TestDamage:
    @pytest.mark.parametrize(
        "text",
        [
            "",
            "[]",
            "null",
            "[" * 100_000,
            '{"channels":["C","M"]}',
            '{"channels":["C","M"],"steps":5100}',
            '{"channels":["C","M"],"steps":5100,"corrected":-1}',
            '{"channels":["C","M"],"steps":5100,"corrected":1.5}',
            '{"channels":["C","M"],"steps":5100,"corrected":null}',
            '{"channels":["C","M"],"steps":0,"corrected":0}',
            '{"channels":["C","M"],"steps":32768,"corrected":0}',
            '{"channels":["C","M"],"steps":true,"corrected":0}',
            '{"channels":["C","M"],"steps":"5100","corrected":0}',
            '{"channels":[],"steps":5100,"corrected":0}',
            '{"channels":"CM","steps":5100,"corrected":0}',
            '{"channels":["C",5],"steps":5100,"corrected":0}',
            '{"channels":["C"],"steps":5100,"corrected":0}',
            json.dumps({"channels": ["C"] * 65, "steps": 5100, "corrected": 0}),
            json.dumps({"channels": ["C", "M" * 1001], "steps": 5100, "corrected": 0}),
        ],
    )
    def test_wrong_channels(self, file, text):
        with pytest.raises(HistoryFileError):
            history_from_bytes(tampered(file, {"device": text}))

    @pytest.mark.parametrize(
        "base",
        [
            None,
            np.zeros((4, 3), np.int32),
            np.zeros((4, 2), np.float64),
            np.full((4, 2), -1, np.int32),
            np.full((4, 2), 5101, np.int32),
            np.full((4, 2), 2**31 - 1, np.int32),
        ],
    )
    def test_wrong_coarsest_level(self, file, base):
        with pytest.raises(HistoryFileError, match=r"device"):
            history_from_bytes(tampered(file, device__base=base))

    @pytest.mark.parametrize(
        "stream", [None, np.zeros(0, np.uint8), np.zeros(8, np.int32), np.zeros((8, 1), np.uint8)]
    )
    def test_damaged_group(self, file, stream):
        with pytest.raises(HistoryFileError, match=r"device|bytes"):
            history_from_bytes(tampered(file, device__01=stream))

    def test_a_section_that_is_not_announced_is_ignored(self, file):
        history, _ = history_from_bytes(tampered(file, {"device": None}))
        assert history.device is None

    @pytest.mark.parametrize("longer", [1, 3])
    def test_bytes_that_are_left_over(self, file, longer):
        stream = safetensors.numpy.load(file)["device.02"]
        padded = np.concatenate([stream, np.zeros(longer, np.uint8)])
        history, _ = history_from_bytes(tampered(file, device__02=padded))
        with pytest.raises(HistoryFileError, match="bits over"):
            _ = history.device

    @pytest.mark.parametrize(("left", "message"), [(-2, "adds slot"), (10, "too few")])
    def test_a_stream_that_ends_early(self, file, left, message):
        stream = safetensors.numpy.load(file)["device.03"]
        history, _ = history_from_bytes(tampered(file, device__03=stream[:left]))
        with pytest.raises(HistoryFileError, match=message) as caught:
            _ = history.device
        assert caught.value.where["field"] == "device.03"

    @settings(max_examples=300)
    @given(data=st.data())
    @pytest.mark.slow
    def test_any_bytes_of_the_section(self, file, inked, data):
        """Any bytes give an error, or values within full scale; the geometry does not change."""
        header, begin = header_of(file)
        starts = [header[name]["data_offsets"][0] for name in header if name.startswith("device.")]
        mutated = bytearray(file)
        for _ in range(data.draw(st.integers(1, 4))):
            place = data.draw(st.integers(begin + min(starts), len(file) - 1))
            mutated[place] = data.draw(st.integers(0, 255))
        where = {"field": "device"}
        found = []
        try:
            history, _ = history_from_bytes(bytes(mutated))
            found = [history.device_values(count) for count in (4, 30, history.triangles)]
            assert history.full() == inked[0].full()
        except HistoryFileError as error:
            where = error.where
        assert str(where["field"]).startswith("device")
        for values in found:
            assert (values.values >= 0).all()
            assert (values.values <= 1).all()
