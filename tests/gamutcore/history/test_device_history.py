"""Device values of all levels, and their section of the history file."""

import numpy as np
import pytest
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
from gamutcore.history import device as device_module
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


class TestFile:
    def test_device_values_are_read_back(self, inked, file, layout):
        history, description = history_from_bytes(file)
        device = layout.parts(file)[0]["device"]
        assert device["channels"] == list(CHANNELS)
        assert device["steps"] == FULL_SCALE
        for triangles in range(4, history.triangles + 1, 2):
            assert history.device_values(triangles) == inked[0].device_values(triangles)
        assert history_bytes(history, description) == file

    def test_a_prefix_has_the_values_of_its_levels(self, inked, file, layout):
        prefix = file[: layout.group_end(file, 2)]
        history, _ = history_from_bytes(prefix, partial=True)
        assert history.vertices == 32
        for triangles in (4, 30, 60):
            assert history.device_values(triangles) == inked[0].device_values(triangles)

    def test_values_beyond_8192_vertices(self, shifting_history, monkeypatch):
        """Neighbours that move in a fine level keep their values."""
        monkeypatch.setattr(device_module, "CORRECTED", 40)
        slots = np.arange(shifting_history.vertices, dtype=np.int32)
        values = DeviceValues(TRACES, traced(shifting_history.full().vertices))
        splits = shifting_history.splits
        device = build_device_history(values, slots, splits)
        built = History(splits, shifting_history.centre, shifting_history.step, device)
        read, _ = history_from_bytes(history_bytes(built))
        begin = int(splits.shifted_end[35])
        moves = device.splits
        assert (moves.shifted_fine[begin:] == moves.shifted_coarse[begin:]).all()
        assert (moves.shifted_fine[:begin] != moves.shifted_coarse[:begin]).any()
        for triangles in range(4, built.triangles + 1, 2):
            assert read.device_values(triangles) == built.device_values(triangles)


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
        "device",
        [
            "",
            [],
            None,
            5,
            {"channels": ["C", "M"]},
            {"channels": ["C", "M"], "steps": 5100},
            *({"channels": ["C", "M"], "steps": n} for n in (0, 32768, True, "5100")),
            *({"channels": names, "steps": 5100} for names in ([], "CM", ["C", 5], ["C"])),
            {"channels": ["C"] * 65, "steps": 5100},
            {"channels": ["C", "M" * 1001], "steps": 5100},
        ],
    )
    def test_wrong_channels(self, file, layout, device):
        if isinstance(device, dict) and device.get("steps"):
            width = len(device["channels"])
            device = {"base": np.zeros((4, width), int).tolist()} | device
            if device["channels"] == ["C", "M"] and device["steps"] == 5100:
                del device["base"]
        data = layout.with_header(file, device=device)
        if device is None:  # the columns are those of a file with device values
            with pytest.raises(HistoryFileError, match="columns"):
                history_from_bytes(data)
            return
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(data)
        assert caught.value.where["field"] in ("device", "columns")

    @pytest.mark.parametrize(
        "base",
        [
            None,
            [[0, 0, 0]] * 4,
            [[0, 0.5]] * 4,
            [[-1, 0]] * 4,
            [[5101, 0]] * 4,
            [[2**70, 0]] * 4,
            [[0, 0], [0]] * 2,
        ],
    )
    def test_wrong_coarsest_level(self, file, layout, base):
        device = layout.parts(file)[0]["device"] | {"base": base}
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(layout.with_header(file, device=device))
        assert caught.value.where == {"field": "device"}

    @settings(max_examples=80)
    @given(data=st.data())
    def test_any_columns_of_values(self, file, inked, layout, data):
        """Any columns give an error, or values within full scale; the geometry does not change."""
        arrays = layout.columns(file, 2)
        for _ in range(data.draw(st.integers(1, 3))):
            array = arrays[data.draw(st.sampled_from(["device_middle", "device_edge"]))]
            row, channel = data.draw(st.integers(0, len(array) - 1)), data.draw(st.integers(0, 1))
            array[row, channel] = data.draw(st.integers(0, 2**16 - 1))
        history, _ = history_from_bytes(layout.with_columns(file, 2, arrays))
        refusal = None
        try:
            history.unpack(60)
        except HistoryFileError as error:
            refusal = error
        if refusal is not None:
            assert refusal.where == {"field": "groups.02"}
            return
        assert history.level(60) == inked[0].level(60)
        for triangles in (4, 30, 60):
            values = history.device_values(triangles).values
            assert (values >= 0).all()
            assert (values <= 1).all()
