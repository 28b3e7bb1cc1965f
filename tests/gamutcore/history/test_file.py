"""The history file: read back bit for bit, and never trusted."""

import json
import struct

import numpy as np
import pytest
import safetensors
import safetensors.numpy
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import HistoryFileError
from gamutcore.history import History, history_bytes, history_from_bytes, history_metadata

TETRAHEDRON = (
    b'{"__metadata__": {"format": "gamut-history", "version": "1", "vertices": "4"}, "centre": {'
)
NOTE = {"note": "größer\nals 🎨"}


@pytest.fixture(scope="module")
def file(small_history):
    """Return the bytes of a small history."""
    return history_bytes(small_history, NOTE)


def parts(data):
    """Header and arrays of a file by the layout that its module describes."""
    (size,) = struct.unpack("<Q", data[:8])
    return json.loads(data[8 : 8 + size]), data[8 + size :]


def assembled(header, body):
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + body


def assert_same_history(one, other):
    for array, expected in zip(one.splits, other.splits, strict=True):
        assert array.dtype == expected.dtype
        np.testing.assert_array_equal(array, expected)
    np.testing.assert_array_equal(one.centre, other.centre)


def assert_readable(history):
    """Read every level, and step through them: all indices are checked by the mesh."""
    for level in history.levels():
        assert np.isfinite(level.vertices).all()
    cursor = history.cursor(4)
    cursor.finer(history.vertices - 4)
    assert cursor.mesh == history.full()
    cursor.coarser(history.vertices - 4)


def tampered(data, metadata=None, **arrays):
    """Return a file with arrays or metadata replaced, written by the safetensors library."""
    header, _ = parts(data)
    replaced = safetensors.numpy.load(data) | {
        name.replace("__", "."): array for name, array in arrays.items()
    }
    return safetensors.numpy.save(replaced, header["__metadata__"] | (metadata or {}))


def with_array(data, name, change):
    arrays = safetensors.numpy.load(data)
    array = arrays[name].copy()
    change(array)
    return safetensors.numpy.save(arrays | {name: array}, parts(data)[0]["__metadata__"])


def first_levels(history, vertices):
    """Return a history up to a number of vertices."""
    splits, steps = history.splits, vertices - 4
    end = int(splits.moved_end[steps - 1]) if steps else 0
    cut = type(splits)(*splits[:2], *(array[:steps] for array in splits[2:8]), splits.moved[:end])
    return History(cut, history.centre, history.step)


class TestRoundTrip:
    def test_of_a_small_history(self, small_history, file):
        history, metadata = history_from_bytes(file)
        assert_same_history(history, small_history)
        assert metadata["note"] == NOTE["note"]
        assert metadata["format"] == "gamut-history"
        assert int(metadata["vertices"]) == small_history.vertices
        assert history_bytes(history, NOTE) == file

    def test_of_a_large_one(self, fogra39_gamut):
        history, _ = history_from_bytes(history_bytes(fogra39_gamut.history))
        assert_same_history(history, fogra39_gamut.history)
        for triangles in (4, 10, 1000, 10_001, history.triangles):
            assert history.level(triangles) == fogra39_gamut.history.level(triangles)

    @pytest.mark.parametrize("vertices", [4, 5, 7, 8, 9, 15, 16, 17])
    def test_of_every_way_that_groups_end(self, small_history, vertices):
        history, _ = history_from_bytes(history_bytes(first_levels(small_history, vertices)))
        assert history.triangles == 2 * vertices - 4
        for triangles in range(4, history.triangles + 1, 2):
            assert history.level(triangles) == small_history.level(triangles)

    def test_the_metadata_alone(self, file, tmp_path):
        path = tmp_path / "history"
        path.write_bytes(file)
        assert history_metadata(path) == history_from_bytes(file)[1]

    def test_own_metadata_cannot_displace_the_formats(self, small_history):
        _, metadata = history_from_bytes(history_bytes(small_history, {"vertices": "5"}))
        assert int(metadata["vertices"]) == small_history.vertices


class TestLayout:
    def test_the_safetensors_library_reads_it(self, file, tmp_path, small_history):
        path = tmp_path / "history.safetensors"
        path.write_bytes(file)
        with safetensors.safe_open(path, "numpy") as opened:
            assert opened.metadata()["note"] == NOTE["note"]
            np.testing.assert_array_equal(opened.get_tensor("centre"), small_history.centre)
            np.testing.assert_array_equal(
                opened.get_tensor("base.positions"), small_history.level(4).vertices
            )
            names = set(opened.keys())
        groups = {name.split(".")[1] for name in names if name.startswith("splits")}
        # 4 to 8 vertices, 8 to 16, ...
        assert len(groups) == int(np.ceil(np.log2(small_history.vertices / 4)))
        assert len(names) == 3 + 7 * len(groups)

    def test_arrays_are_aligned_and_follow_each_other(self, file):
        header, body = parts(file)
        del header["__metadata__"]
        end = 0
        for name, entry in header.items():
            start, stop = entry["data_offsets"]
            assert start == end, name
            assert stop - start == np.prod(entry["shape"]) * int(entry["dtype"][1:]) // 8
            assert start % 4 == 0
            end = stop
        assert end == len(body)

    @pytest.mark.parametrize("groups", [0, 1, 2, 3, 4])
    def test_a_prefix_that_ends_with_a_group_is_a_coarser_history(
        self, file, small_history, groups
    ):
        header, body = parts(file)
        metadata = header.pop("__metadata__")
        wanted = {f"{number:02d}" for number in range(groups)}
        kept = {
            name: entry
            for name, entry in header.items()
            if not name.startswith("splits.") or name.split(".")[1] in wanted
        }
        end = max(entry["data_offsets"][1] for entry in kept.values())
        metadata["vertices"] = str(4 * 2**groups)
        coarse, _ = history_from_bytes(assembled({"__metadata__": metadata, **kept}, body[:end]))
        assert coarse.vertices == 4 * 2**groups
        for triangles in range(4, coarse.triangles + 1, 2):
            assert coarse.level(triangles) == small_history.level(triangles)

    def test_no_pickle(self, file):
        assert b"pickle" not in file
        assert not file.startswith(b"\x80")


class TestDamage:
    @settings(max_examples=100)
    @given(part=st.floats(0, 1, exclude_max=True))
    def test_any_truncation_is_refused(self, file, part):
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(file[: int(part * len(file))])
        assert caught.value.remedy

    @settings(max_examples=300)
    @given(place=st.floats(0, 1, exclude_max=True), flip=st.integers(1, 255))
    def test_a_changed_byte_of_the_header_is_refused_or_changes_no_geometry(
        self, file, small_history, place, flip
    ):
        size = 8 + struct.unpack("<Q", file[:8])[0]
        data = bytearray(file)
        data[int(place * size)] ^= flip
        self.assert_refused_or(data, lambda read: assert_same_history(read, small_history))

    @settings(max_examples=150)
    @given(place=st.floats(0, 1, exclude_max=True), flip=st.integers(1, 255))
    def test_a_changed_byte_of_the_arrays_is_refused_or_leaves_all_readable(
        self, file, place, flip
    ):
        size = 8 + struct.unpack("<Q", file[:8])[0]
        data = bytearray(file)
        data[size + int(place * (len(file) - size))] ^= flip
        self.assert_refused_or(data, assert_readable)

    @settings(max_examples=100)
    @given(cuts=st.lists(st.tuples(st.floats(0, 1), st.binary(max_size=8)), min_size=1, max_size=3))
    def test_overwritten_and_inserted_bytes(self, file, cuts):
        data = bytearray(file)
        for place, content in cuts:
            start = int(place * len(data))
            data[start : start + 4] = content
        self.assert_refused_or(data, assert_readable)

    @settings(max_examples=100)
    @given(data=st.binary(max_size=300))
    def test_other_bytes_are_refused(self, data):
        with pytest.raises(HistoryFileError):
            history_from_bytes(data)

    @staticmethod
    def assert_refused_or(data, check):
        try:
            history, _ = history_from_bytes(bytes(data))
        except HistoryFileError:
            return
        check(history)

    def test_some_changed_positions_pass(self, file):
        """The two properties above are not empty: a moved vertex is a readable history."""
        read, _ = history_from_bytes(with_array(file, "base.positions", lambda a: a.fill(7.0)))
        assert_readable(read)


class TestRefusals:
    @pytest.mark.parametrize(
        ("metadata", "field"),
        [
            ({"format": "gamut"}, "format"),
            ({"version": "2"}, "version"),
            ({"version": ""}, "version"),
            ({"vertices": "3"}, "vertices"),
            ({"vertices": "-5"}, "vertices"),
            ({"vertices": "many"}, "vertices"),
            ({"vertices": "٩٩"}, "vertices"),
            ({"vertices": "1e2"}, "vertices"),
            ({"vertices": str(2**28 + 1)}, "vertices"),
            ({"vertices": "9" * 400}, "vertices"),
        ],
    )
    def test_of_metadata(self, file, metadata, field):
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(tampered(file, metadata))
        assert caught.value.where == {"field": field}

    @pytest.mark.parametrize("vertices", [4, 5, 96, 98, 1000, 2**20, 2**28])
    def test_of_a_claimed_count_that_the_arrays_do_not_have(self, file, small_history, vertices):
        assert vertices != small_history.vertices
        data = tampered(file, {"vertices": str(vertices)})
        if vertices in {4, 5}:  # the first group has four rows, not none or one
            vertices = 5
            data = tampered(file, {"vertices": "5"})
        with pytest.raises(HistoryFileError, match="splits"):
            history_from_bytes(data)

    @pytest.mark.parametrize(
        "name", ["centre", "base.faces", "splits.00.parent", "splits.01.moved"]
    )
    def test_of_a_missing_array(self, file, name):
        arrays = safetensors.numpy.load(file)
        del arrays[name]
        data = safetensors.numpy.save(arrays, parts(file)[0]["__metadata__"])
        with pytest.raises(HistoryFileError, match="missing") as caught:
            history_from_bytes(data)
        assert caught.value.where == {"field": name}

    @pytest.mark.parametrize(
        ("name", "array"),
        [
            ("centre", np.zeros(2)),
            ("centre", np.zeros(3, np.float32)),
            ("base__faces", np.zeros((4, 3), np.float32)),
            ("base__faces", np.zeros((3, 3), np.int32)),
            ("base__positions", np.zeros((4, 2), np.float32)),
            ("splits__00__parent", np.zeros((4, 1), np.int32)),
            ("splits__00__parent", np.zeros(4, np.int64)),
            ("splits__01__faces", np.zeros((8, 3, 2), np.int32)),
            ("splits__01__moved", np.zeros((3, 3), np.int32)),
        ],
    )
    def test_of_an_array_of_another_type_or_shape(self, file, name, array):
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(tampered(file, **{name: array}))
        assert caught.value.where == {"field": name.replace("__", ".")}

    @pytest.mark.parametrize("value", [-1, 4, 2**31 - 1, -(2**31)])
    @pytest.mark.parametrize(
        ("name", "row"),
        [
            ("base.faces", (2, 1)),
            ("splits.00.parent", (0,)),
            ("splits.00.faces", (0, 1, 2)),
            ("splits.00.moved", (0,)),
        ],
    )
    def test_of_an_index(self, file, name, row, value):
        """4 is the slot that the first split adds: nobody's parent yet, and no corner to move."""

        def change(array):
            array[row] = value

        if (name, value) == ("splits.00.faces", 4):
            value = 5
        if (name, value) == ("splits.00.moved", 4):
            value = 12
        with pytest.raises(HistoryFileError):
            history_from_bytes(with_array(file, name, change))

    @pytest.mark.parametrize("value", [-1, 2**31 - 1, 0])
    def test_of_ends_that_do_not_divide_the_moved_corners(self, file, value):
        with pytest.raises(HistoryFileError, match="moved_end"):
            history_from_bytes(with_array(file, "splits.02.moved_end", lambda a: a.fill(value)))

    @pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
    @pytest.mark.parametrize(
        "name",
        ["centre", "base.positions", "splits.00.coarse", "splits.01.fine", "splits.02.added"],
    )
    def test_of_numbers_that_are_not_finite(self, file, name, value):
        def change(array):
            array.flat[1] = value

        with pytest.raises(HistoryFileError, match="finite"):
            history_from_bytes(with_array(file, name, change))

    @pytest.mark.parametrize("vertices", [4, 9])
    def test_of_a_surface_that_is_not_closed(self, small_history, vertices):
        def swap(array):
            array[-1, ..., :] = array[-1, ..., ::-1]

        name = "base.faces" if vertices == 4 else "splits.01.faces"
        data = history_bytes(first_levels(small_history, vertices))
        assert_readable(history_from_bytes(data)[0])
        with pytest.raises(HistoryFileError, match="not closed"):
            history_from_bytes(with_array(data, name, swap))

    @pytest.mark.parametrize("depth", [10, 1000, 100_000, 1_000_000])
    def test_of_deeply_nested_json(self, depth):
        text = b'{"__metadata__":' + b"[" * depth + b"]" * depth + b"}"
        with pytest.raises(HistoryFileError):
            history_from_bytes(struct.pack("<Q", len(text)) + text)

    @pytest.mark.parametrize("size", [0, 1, 2**24 + 1, 2**62, 2**64 - 1])
    def test_of_a_header_length(self, file, size):
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(struct.pack("<Q", size) + file[8:])
        assert caught.value.where == {"byte": 0}

    @pytest.mark.parametrize(
        "text",
        [
            b"{}",
            b"[]",
            b"null",
            b'{"__metadata__": null}',
            b'{"__metadata__": {}}',
            b'{"__metadata__": {"format": "gamut-history"}}',
            b'{"__metadata__": []}',
            b"\xff\xfe",
            b'{"__metadata__": {"format": "gamut-history", "version": "1", "other": 5}}',
            b'{"__metadata__": {"format": "gamut-history", "version": "1", "vertices": "4"}}',
            TETRAHEDRON + b'"dtype": "F64", "shape": [3], "data_offsets": [0, 999999999999]}}',
            TETRAHEDRON
            + b'"dtype": "F64", "shape": [4611686018427387904], "data_offsets": [0, 0]}}',
        ],
    )
    def test_of_a_header(self, text):
        data = struct.pack("<Q", len(text)) + text
        with pytest.raises(HistoryFileError):
            history_from_bytes(data)

    def test_of_bytes_behind_the_arrays(self, file):
        with pytest.raises(HistoryFileError):
            history_from_bytes(file + b"\0")

    @pytest.mark.parametrize("content", [b"", b"PK\3\4", b"glTF" + bytes(100), b"\x93NUMPY\1\0"])
    def test_of_the_metadata_of_another_file(self, tmp_path, content):
        path = tmp_path / "file"
        path.write_bytes(content)
        with pytest.raises(HistoryFileError):
            history_metadata(path)

    def test_a_file_that_is_not_there_is_an_os_error(self, tmp_path):
        with pytest.raises(FileNotFoundError):
            history_metadata(tmp_path / "nothing")
