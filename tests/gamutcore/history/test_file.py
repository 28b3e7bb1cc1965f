"""The history file: bit-exact round trips, and damage that is refused or harmless."""

import math
import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore import Gamut
from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import decimate
from gamutcore.errors import GamutError, HistoryFileError, NeighbourLimitError
from gamutcore.history import (
    History,
    build_history,
    columns,
    history_bytes,
    history_description,
    history_from_bytes,
    history_section,
)
from gamutcore.history import file as file_module

ROOT = Path(__file__).parents[3]


def assert_same_history(one, other):
    for array, expected in zip(one.splits, other.splits, strict=True):
        assert array.dtype == expected.dtype
        np.testing.assert_array_equal(array, expected)
    np.testing.assert_array_equal(one.centre, other.centre)


@pytest.fixture(scope="module")
def assert_readable(assert_every_level):
    """Return a check that every level of a history is valid and can be reached by steps."""

    def check(history):
        assert_every_level(history.levels(), history.centre)
        cursor = history.cursor(4)
        cursor.finer(history.vertices - 4)
        assert cursor.mesh == history.full()
        cursor.coarser(history.vertices - 4)

    return check


@pytest.fixture(scope="module", params=["volume", "finest"])
def large_history(request, fogra39_gamut, fogra39_finest):
    """Return the history of a press; with `finest`, neighbours move in its coarser splits."""
    return fogra39_gamut.history if request.param == "volume" else fogra39_finest


class TestRoundTrip:
    def test_small_history(self, small_history, file, note):
        history, description = history_from_bytes(file)
        assert_same_history(history, small_history)
        assert description == note
        assert history_bytes(history, note) == file

    def test_neighbours_that_move(self, shifting_history, assert_readable):
        assert len(shifting_history.splits.shifted) > 100
        history, _ = history_from_bytes(history_bytes(shifting_history))
        assert_same_history(history, shifting_history)
        assert_readable(history)

    @pytest.mark.parametrize("partial", [False, True])
    def test_other_facts_and_sections_are_ignored(self, small_history, file, layout, partial):
        sections = [{"name": "notes", "bytes": 3, "crc32": 0}]
        data = layout.with_header(file, notes={"any": [1]}, sections=sections) + b"abc"
        history, _ = history_from_bytes(data, partial=partial)
        assert_same_history(history, small_history)

    @settings(max_examples=40)
    @given(
        seed=st.integers(0, 2**32 - 1),
        count=st.integers(4, 60),
        scale=st.sampled_from([1e-30, 1e-3, 1.0, 1e5, 1e30]),
        offset=st.floats(-5, 5),
        spike=st.floats(1, 30),
    )
    @pytest.mark.slow
    def test_any_gamut(self, random_cloud, assert_readable, seed, count, scale, offset, spike):
        points = random_cloud(seed, count) - (50.0, 0.0, 0.0)
        points[0] *= spike
        try:
            boundary = modified_convex_hull((points + 50 * offset) * scale)
        except GamutError:  # four random points seldom surround a centre
            return
        history = build_history(decimate(boundary.mesh, boundary.centre))
        read, _ = history_from_bytes(history_bytes(history))
        assert_same_history(read, history)
        assert_readable(read)

    @pytest.mark.parametrize("count", [50, 1000])
    @pytest.mark.parametrize("cost", ["volume", "quadric"])
    def test_slots_with_many_neighbours(self, double_pyramid, count, cost):
        """Two poles are neighbours of all other vertices."""
        history = build_history(decimate(double_pyramid(count), np.zeros(3), cost))
        read, _ = history_from_bytes(history_bytes(history))
        assert_same_history(read, history)

    @pytest.mark.slow
    def test_large_history(self, large_history):
        history, _ = history_from_bytes(history_bytes(large_history))
        assert_same_history(history, large_history)
        for triangles in (4, 10, 1000, 10_001, history.triangles):
            assert history.level(triangles) == large_history.level(triangles)

    @pytest.mark.parametrize("cost", ["volume", "finest"])
    @pytest.mark.long  # of default size
    def test_one_of_default_size_is_compact(self, fogra39, cost):
        """Issue 48 accepts 1.7 MB for FOGRA39L; 1.46 MB and 1.54 MB (`finest`) were measured."""
        history = Gamut(fogra39, cost=cost).history
        assert len(history_bytes(history)) < 1_700_000

    @pytest.mark.parametrize("vertices", [4, 5, 7, 8, 9, 15, 16, 17])
    def test_last_group_of_any_length(self, small_history, first_levels, vertices):
        history, _ = history_from_bytes(history_bytes(first_levels(small_history, vertices)))
        assert history.triangles == 2 * vertices - 4
        for triangles in range(4, history.triangles + 1, 2):
            assert history.level(triangles) == small_history.level(triangles)

    def test_the_description_is_read_without_groups(self, file, note, tmp_path):
        path = tmp_path / "history"
        path.write_bytes(file)
        assert history_description(path) == note

    def test_sections_are_read_by_name(self, small_history):
        sections = {"one": b"1", "other": bytes(1000)}
        data = history_bytes(small_history, None, sections)
        for name, content in sections.items():
            assert history_section(data, name) == content
        assert history_section(data, "third") is None
        assert_same_history(history_from_bytes(data)[0], small_history)


@pytest.fixture(scope="module")
def read_level():
    """Return the reader that docs/history-format.md prints."""
    text = (ROOT / "docs" / "history-format.md").read_text()
    names = {}
    exec(text.split("```python\n")[1].split("```")[0], names)  # noqa: S102  # of this repository
    return names["read_level"]


class TestReaderOfTheDocument:
    @pytest.mark.slow
    def test_it_reads_the_levels_of_a_press(self, read_level):
        gamut = Gamut(ROOT / "examples" / "FOGRA39L.ti3", surface_samples=2000, cost="finest")
        history, data = gamut.history, gamut.to_bytes()
        assert len(history.splits.shifted)
        for count in (4, 5, 8, 50, 500, history.vertices):
            positions, faces, device = read_level(data, count)
            mesh = history.level(2 * count - 4)
            np.testing.assert_array_equal(positions.astype(np.float32), mesh.vertices)
            np.testing.assert_array_equal(faces, mesh.faces)
            values = history.device_values(2 * count - 4).values
            np.testing.assert_array_equal(device.astype(np.float32), values)

    def test_it_reads_neighbours_that_move(self, read_level, shifting_history):
        data = history_bytes(shifting_history)
        for count in (4, 50, shifting_history.vertices):
            positions, faces, device = read_level(data, count)
            mesh = shifting_history.level(2 * count - 4)
            np.testing.assert_array_equal(positions.astype(np.float32), mesh.vertices)
            np.testing.assert_array_equal(faces, mesh.faces)
            assert device.size == 0


class TestPrefix:
    @settings(max_examples=50)
    @given(part=st.floats(0, 1))
    def test_any_prefix_holds_the_coarser_levels(self, file, layout, small_history, part):
        end = int(part * len(file))
        groups = 0
        while 4 * 2**groups < small_history.vertices and layout.group_end(file, groups) <= end:
            groups += 1
        if end < len(file) - sum(map(len, layout.parts(file)[1])):
            with pytest.raises(HistoryFileError):
                history_from_bytes(file[:end], partial=True)
            return
        coarse, _ = history_from_bytes(file[:end], partial=True)
        assert coarse.vertices == min(4 * 2**groups, small_history.vertices)
        for triangles in range(4, coarse.triangles + 1, 2):
            assert coarse.level(triangles) == small_history.level(triangles)


class TestWriting:
    def test_positions_off_the_grid_are_refused(self, small_history):
        history = History(small_history.splits, small_history.centre, 4 * small_history.step)
        with pytest.raises(HistoryFileError, match="grid"):
            history_bytes(history)

    def test_a_step_too_fine_for_float32_is_refused(self, small_history):
        history = History(small_history.splits, small_history.centre, small_history.step / 2**10)
        with pytest.raises(HistoryFileError, match="grid"):
            history_bytes(history)


class TestDamage:
    @settings(max_examples=60)
    @given(part=st.floats(0, 1, exclude_max=True))
    def test_truncation_names_the_group(self, file, layout, part):
        end = int(part * len(file))
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(file[:end])
        assert caught.value.remedy
        header, groups = layout.parts(file)
        if end < len(file) - sum(map(len, groups)):
            assert caught.value.where in ({"byte": 0}, {"field": "header"})
            return
        group = sum(layout.group_end(file, n) <= end for n in range(len(header["groups"])))
        assert caught.value.where == {"field": f"groups.{group:02d}"}

    @settings(max_examples=150)
    @given(place=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
    def test_any_flipped_bit_is_named(self, file, layout, small_history, place, bit):
        """Defect of version 2: a flipped bit gave other vertices silently."""
        at = int(place * len(file))
        data = bytearray(file)
        data[at] ^= 1 << bit
        number = sum(layout.group_end(file, n) <= at for n in range(len(layout.parts(file)[1])))
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(bytes(data))[0].unpack()
        where = caught.value.where
        if at < len(file) - sum(map(len, layout.parts(file)[1])):
            assert where in ({"byte": 0}, {"field": "header"})
            return
        assert where == {"field": f"groups.{number:02d}"}
        assert f"group {number} " in caught.value.message
        coarse, _ = history_from_bytes(bytes(data))
        assert coarse.level(2 * 4 * 2**number - 4) == small_history.level(2 * 4 * 2**number - 4)

    @settings(max_examples=60)
    @given(cuts=st.lists(st.tuples(st.floats(0, 1), st.binary(max_size=8)), min_size=1, max_size=3))
    def test_overwritten_and_inserted_bytes(self, file, cuts):
        data = bytearray(file)
        for place, content in cuts:
            start = int(place * len(data))
            data[start : start + 4] = content
        if bytes(data) != file:
            with pytest.raises(HistoryFileError):
                history_from_bytes(bytes(data))[0].unpack()

    @settings(max_examples=100)
    @given(data=st.binary(max_size=300))
    def test_other_bytes_are_refused(self, data):
        with pytest.raises(HistoryFileError):
            history_from_bytes(data)

    @pytest.mark.parametrize("content", [b"", b"PK\3\4", b"glTF" + bytes(100), b"\x93NUMPY\1\0"])
    def test_description_of_another_file(self, tmp_path, content):
        path = tmp_path / "file"
        path.write_bytes(content)
        with pytest.raises(HistoryFileError):
            history_description(path)

    def test_a_file_that_is_not_there_is_an_os_error(self, tmp_path):
        with pytest.raises(FileNotFoundError):
            history_description(tmp_path / "nothing")

    def test_the_version_before_is_refused(self):
        """Version 2 was a safetensors file."""
        text = b'{"__metadata__":{"format":"gamut-history","version":"2","vertices":"4"}}'
        with pytest.raises(HistoryFileError, match="has version 2"):
            history_from_bytes(struct.pack("<Q", len(text)) + text)

    def test_a_damaged_section(self, small_history):
        data = history_bytes(small_history, None, {"model": b"content"})
        with pytest.raises(HistoryFileError) as caught:
            history_section(data[:-1] + b"!", "model")
        assert caught.value.where == {"field": "model"}


class TestHeader:
    """Wrong statements of a header with the right checksum."""

    @pytest.mark.parametrize(
        ("name", "values"),
        [
            ("format", ("gamut", None, 5)),
            ("version", (2, 4, "3", None)),
            ("vertices", (3, -5, "many", 1e2, True, 2**25 + 1, 10**400, None)),
            ("centre", ([0, 0], [0, 0, math.nan], [0, 0, math.inf], "abc", [[0], 0, 0], None)),
            ("step", (0.0, -0.5, 3.0, 0.1, math.nan, 2.0**-150, 2.0**104, 5e-324, [1], None)),
            ("columns", ([], None, [5])),
            ("groups", ([], None, {})),
            ("sections", (5, [5], [{}], [{"name": "n", "bytes": -1, "crc32": 0}])),
        ],
    )
    def test_wrong_facts(self, file, layout, name, values):
        for value in values:
            with pytest.raises(HistoryFileError) as caught:
                history_from_bytes(layout.with_header(file, **{name: value}))
            where = (
                {"byte": 8} if value is None and name in ("format", "version") else {"field": name}
            )
            assert caught.value.where == where

    @pytest.mark.parametrize("vertices", [250, 1000, 2**25])
    def test_count_beyond_the_groups(self, file, layout, small_history, vertices):
        assert vertices > small_history.vertices
        with pytest.raises(HistoryFileError, match="group"):
            history_from_bytes(layout.with_header(file, vertices=vertices))

    @pytest.mark.parametrize(
        "line",
        [
            {"vertices": 9},
            {"moved": -1},
            {"moved": 10**6},
            {"moved": "4"},
            {"shifted": 10**6},
            {"bytes": -1},
            {"bytes": 2**63},
            {"crc32": 2**32},
            {"crc32": None},
        ],
    )
    def test_wrong_line_of_a_group(self, file, layout, line):
        groups = layout.parts(file)[0]["groups"]
        groups[1] |= line
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(layout.with_header(file, groups=groups))
        assert caught.value.where == {"field": "groups.01"}

    @pytest.mark.parametrize(
        ("base", "field"),
        [
            ({"faces": [[-1, 0, 1], [0, 1, 2], [0, 2, 3], [1, 3, 2]]}, "base.faces"),
            ({"faces": [[0, 0, 1], [0, 0, 1], [0, 2, 3], [1, 3, 2]]}, "base.faces"),
            ({"faces": [[0, 2, 1], [0, 2, 1], [0, 2, 3], [1, 3, 2]]}, "base.faces"),
            ({"faces": [[0, 1, 2.5]] * 4}, "base.faces"),
            ({"faces": 5}, "base.faces"),
            ({"positions": [[2**24 + 1, 0, 0]] * 4}, "base.positions"),
            ({"positions": [[7, 7, 7]] * 4}, "base.positions"),
            ({"positions": [[10**30, 0, 0]] * 4}, "base.positions"),
            ({"positions": [[1, 2]] * 4}, "base.positions"),
        ],
    )
    def test_wrong_coarsest_level(self, file, layout, base, field):
        changed = layout.parts(file)[0]["base"] | base
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(layout.with_header(file, base=changed))
        assert caught.value.where == {"field": field}

    def test_a_centre_outside(self, file, layout):
        with pytest.raises(HistoryFileError, match="see the centre"):
            history_from_bytes(layout.with_header(file, centre=[1e6, 0, 0]))

    @pytest.mark.parametrize("depth", [10, 1000, 100_000])
    def test_deeply_nested_json(self, depth):
        text = b'{"format":' + b"[" * depth + b"]" * depth + b"}"
        with pytest.raises(HistoryFileError):
            history_from_bytes(struct.pack("<II", len(text), zlib.crc32(text)) + text)

    @pytest.mark.parametrize("text", [b"{}", b"[]", b"null", b"5", b"\xff\xfe", b'{"format"'])
    def test_wrong_header(self, text):
        with pytest.raises(HistoryFileError):
            history_from_bytes(struct.pack("<II", len(text), zlib.crc32(text)) + text)

    def test_bytes_behind_the_file(self, file):
        with pytest.raises(HistoryFileError):
            history_from_bytes(file + b"\0")


class TestColumns:
    """Wrong columns with the right checksums."""

    @staticmethod
    def refusal(data):
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(data)[0].unpack()
        return caught.value

    @pytest.mark.parametrize(
        "content", [b"", b"abc", zlib.compress(b""), zlib.compress(bytes(9**6))]
    )
    def test_bytes_that_are_no_columns(self, file, layout, content):
        error = self.refusal(layout.with_group(file, 2, content))
        assert error.where == {"field": "groups.02"}

    def test_bytes_behind_the_columns(self, file, layout):
        _, groups = layout.parts(file)
        error = self.refusal(layout.with_group(file, 2, groups[2] + b"\0"))
        assert error.where == {"field": "groups.02"}

    @pytest.mark.parametrize(
        ("name", "value", "message"),
        [
            ("parent", 16 + 5, "does not exist"),
            ("parent", -1, "does not exist"),
            ("parent", 2**31 - 1, "does not exist"),
            ("moved_count", 0, "counts"),
            ("moved_count", -(2**31), "counts"),
            ("shifted_count", 1, "counts"),
            ("middle", 2**32 - 1, "2\\^24"),
            ("edge", 0, "see the centre"),
            ("edge", 2**32 - 2, "2\\^24"),
        ],
    )
    def test_wrong_number_in_a_split(self, file, layout, name, value, message):
        arrays = layout.columns(file, 2)
        arrays[name][5] = value
        error = self.refusal(layout.with_columns(file, 2, arrays))
        assert error.where["field"] == "groups.02"
        assert error.where.get("slot", 21) == 21
        assert re.search(message, error.message)

    @pytest.mark.parametrize("value", [-1, 3 * (2 * 16 - 4), 2**31 - 1, -(2**31)])
    def test_a_corner_that_does_not_exist(self, file, layout, value):
        arrays = layout.columns(file, 2)
        arrays["moved"][0] = value
        error = self.refusal(layout.with_columns(file, 2, arrays))
        assert error.where == {"field": "groups.02", "slot": 16}

    def test_corners_in_another_order(self, file, layout):
        arrays = layout.columns(file, 3)
        counts = arrays["moved_count"][:, 0]
        split = int(np.flatnonzero(counts >= 2)[0])
        end = int(counts[: split + 1].sum())
        arrays["moved"][end - 2 : end] = arrays["moved"][end - 2 : end][::-1].copy()
        error = self.refusal(layout.with_columns(file, 3, arrays))
        assert error.where == {"field": "groups.03", "slot": 32 + split}
        assert "fan" in error.message

    def test_one_corner_twice(self, file, layout):
        arrays = layout.columns(file, 3)
        arrays["moved_count"][4] += 1
        begin = int(arrays["moved_count"][:4].sum())
        arrays["moved"] = np.insert(arrays["moved"], begin, arrays["moved"][begin], axis=0)
        error = self.refusal(layout.with_columns(file, 3, arrays))
        assert error.where == {"field": "groups.03", "slot": 36}

    def test_all_corners_of_a_slot(self, small_history, layout):
        """A parent that keeps no face would leave a mesh that is not closed."""
        data = history_bytes(small_history)
        history, _ = history_from_bytes(data)
        arrays = layout.columns(data, 0)
        parent = int(arrays["parent"][0, 0])
        faces = history.level(4).faces
        # counter-clockwise around the parent: each face begins where the one before ended
        ring = [
            3 * int(f) + int(np.flatnonzero(faces[f] == parent)[0])
            for f in range(4)
            if parent in faces[f]
        ]
        sides = {c: (faces[c // 3][(c + 1) % 3], faces[c // 3][(c + 2) % 3]) for c in ring}
        fan = [ring[0]]
        while len(fan) < 3:
            fan.append(next(c for c in ring if sides[c][0] == sides[fan[-1]][1]))
        count = int(arrays["moved_count"][0, 0])
        arrays["moved"] = np.vstack([np.array(fan, np.int32)[:, None], arrays["moved"][count:]])
        arrays["moved_count"][0] = 3
        error = self.refusal(layout.with_columns(data, 0, arrays))
        assert error.where == {"field": "groups.00", "slot": 4}
        assert "fan" in error.message

    def test_neighbours_that_move_twice_or_are_the_parent(self, shifting_history, layout):
        data = history_bytes(shifting_history)
        arrays = layout.columns(data, 3)
        counts = arrays["shifted_count"][:, 0]
        split = int(np.flatnonzero(counts >= 2)[0])
        begin = int(counts[:split].sum())
        for value in (arrays["shifted"][begin + 1, 0], arrays["parent"][split, 0], 32 + split, -1):
            changed = {name: array.copy() for name, array in arrays.items()}
            changed["shifted"][begin] = value
            error = self.refusal(layout.with_columns(data, 3, changed))
            assert error.where == {"field": "groups.03", "slot": 32 + split}

    def test_too_many_elements_or_too_much_work(self, file, small_history, monkeypatch):
        monkeypatch.setattr(columns, "LARGEST_WORK", 2000)
        assert "triangles meet" in self.refusal(file).message
        monkeypatch.undo()
        monkeypatch.setattr(file_module, "LARGEST_WORK", 2000)
        with pytest.raises(NeighbourLimitError, match="triangles meet"):
            history_bytes(small_history)
        monkeypatch.undo()
        monkeypatch.setattr(file_module, "CORNERS_PER_VERTEX", 1)
        with pytest.raises(NeighbourLimitError):
            history_bytes(small_history)

    @pytest.mark.parametrize("moving", [False, True])
    @settings(max_examples=250, deadline=None)
    @given(data=st.data())
    @pytest.mark.slow
    def test_any_columns_are_refused_or_valid(
        self, file, shifting_history, layout, assert_readable, moving, data
    ):
        """The guarantee: whatever the bytes are, a level is valid or the file is refused."""
        content = history_bytes(shifting_history) if moving else file
        group = data.draw(st.integers(0, 4))
        arrays = layout.columns(content, group)
        names = [name for name, array in arrays.items() if array.size]
        for _ in range(data.draw(st.integers(1, 3))):
            array = arrays[data.draw(st.sampled_from(names))]
            row = data.draw(st.integers(0, len(array) - 1))
            near = st.integers(-9, 9).map(lambda n, old=int(array[row, 0]): old + n)
            other = st.integers(0, len(array) - 1).map(lambda at, a=array: int(a[at, 0]))
            value = data.draw(st.one_of(near, other, st.integers(-(2**31), 2**32 - 1)))
            array[row, data.draw(st.integers(0, array.shape[1] - 1))] = np.array(value).astype(
                array.dtype
            )
        history, _ = history_from_bytes(layout.with_columns(content, group, arrays))
        refusal = None
        try:
            history.unpack()
        except HistoryFileError as error:
            refusal = error
        if refusal is not None:
            assert str(refusal.where["field"]).startswith("groups.")
            coarse = 8 * 2**group - 4
            assert history.level(coarse).triangles == coarse
            return
        assert_readable(history)


class TestReaderInJavaScript:
    """A JavaScript reader, written from docs/history-format.md, returns the same levels."""

    @pytest.mark.slow
    def test_every_level_of_small_histories(
        self, javascript_levels, small_history, shifting_history, first_levels, note
    ):
        for history in (small_history, shifting_history, first_levels(small_history, 4)):
            levels = javascript_levels(history_bytes(history, note))
            assert len(levels) == history.vertices - 3
            assert_same_levels(levels, history.levels())

    @pytest.mark.slow
    def test_levels_of_a_large_one(self, javascript_levels, large_history):
        full = large_history.triangles
        counts = [*range(4, 400, 2), *range(400, 8000, 500), 20_000, 40_000, full]
        levels = javascript_levels(history_bytes(large_history), counts)
        assert_same_levels(levels, map(large_history.level, counts))

    def test_vertices_with_thousands_of_neighbours(self, javascript_levels, double_pyramid):
        history = build_history(decimate(double_pyramid(2000), np.zeros(3)))
        counts = [4, 100, 500, 600, 2000, history.triangles]
        levels = javascript_levels(history_bytes(history), counts)
        assert_same_levels(levels, map(history.level, counts))

    @pytest.mark.slow
    def test_levels_of_a_prefix(self, javascript_levels, fogra39_gamut, layout):
        """Read up to the end of a group, as a client does with ranges, and a few bytes more."""
        history = fogra39_gamut.history
        data = history_bytes(history)
        end = layout.group_end(data, 6)
        assert end < len(data) // 10
        for length in (end, end + 1, layout.group_end(data, 7) - 1):
            levels = javascript_levels(data[:length])
            assert len(levels) == 4 * 2**7 - 3
            assert_same_levels(levels, (history.level(4 + 2 * i) for i in range(len(levels))))


def assert_same_levels(levels, expected):
    for (positions, faces), mesh in zip(levels, expected, strict=True):
        assert positions.tobytes() == mesh.vertices.tobytes()
        assert faces.tobytes() == mesh.faces.tobytes()
