"""Wrong statements in a history file are refused with place and reason."""

import json
import struct
import tracemalloc

import numpy as np
import pytest
import safetensors.numpy

from gamutcore.errors import HistoryFileError
from gamutcore.history import history_bytes, history_from_bytes, history_metadata

TETRAHEDRON = (
    b'{"__metadata__": {"format": "gamut-history", "version": "2", "vertices": "4"}, "centre": {'
)


def metadata_of(data):
    """Return the metadata of a file, by the documented layout."""
    (size,) = struct.unpack("<Q", data[:8])
    return json.loads(data[8 : 8 + size])["__metadata__"]


def tampered(data, metadata=None, **arrays):
    """Return a file with arrays or metadata replaced, written by the safetensors library."""
    replaced = safetensors.numpy.load(data) | {
        name.replace("__", "."): array for name, array in arrays.items()
    }
    return safetensors.numpy.save(replaced, metadata_of(data) | (metadata or {}))


def unpacked(data):
    history, _ = history_from_bytes(data)
    history.unpack()
    return history


class TestRefusals:
    @pytest.mark.parametrize(
        ("metadata", "field"),
        [
            ({"format": "gamut"}, "format"),
            ({"version": "1"}, "version"),
            ({"version": "3"}, "version"),
            ({"version": ""}, "version"),
            ({"vertices": "3"}, "vertices"),
            ({"vertices": "-5"}, "vertices"),
            ({"vertices": "many"}, "vertices"),
            ({"vertices": "٩٩"}, "vertices"),
            ({"vertices": "1e2"}, "vertices"),
            ({"vertices": str(2**25 + 1)}, "vertices"),
            ({"vertices": "9" * 400}, "vertices"),
        ],
    )
    def test_wrong_metadata(self, file, metadata, field):
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(tampered(file, metadata))
        assert caught.value.where == {"field": field}

    @pytest.mark.parametrize("vertices", [250, 1000, 2**20, 2**25])
    def test_count_beyond_the_arrays(self, file, small_history, vertices):
        assert vertices > small_history.vertices
        with pytest.raises(HistoryFileError, match="splits"):
            history_from_bytes(tampered(file, {"vertices": str(vertices)}))

    def test_count_below_that_of_the_stream(self, file, small_history):
        with pytest.raises(HistoryFileError, match="bits over"):
            unpacked(tampered(file, {"vertices": str(small_history.vertices - 1)}))

    def test_a_claimed_count_allocates_nothing(self, file):
        """A file of a few hundred bytes claims millions of splits."""
        claimed = {"vertices": str(2**25)}
        streams = {f"splits__{number:02d}": np.zeros(4, np.uint8) for number in range(23)}
        data = tampered(file, claimed, **streams)
        tracemalloc.start()
        with pytest.raises(HistoryFileError, match="too few"):
            history_from_bytes(data)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 2**20

    @pytest.mark.parametrize(
        "name", ["centre", "step", "base.faces", "base.positions", "splits.00", "splits.04"]
    )
    def test_missing_array(self, file, name):
        arrays = safetensors.numpy.load(file)
        del arrays[name]
        data = safetensors.numpy.save(arrays, metadata_of(file))
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
            ("base__positions", np.zeros((4, 2), np.int32)),
            ("base__positions", np.zeros((4, 3), np.float32)),
            ("step", np.zeros(3)),
            ("splits__00", np.zeros((4, 1), np.uint8)),
            ("splits__00", np.zeros(40, np.int32)),
        ],
    )
    def test_array_of_another_type_or_shape(self, file, name, array):
        with pytest.raises(HistoryFileError) as caught:
            history_from_bytes(tampered(file, **{name: array}))
        assert caught.value.where == {"field": name.replace("__", ".")}

    def test_unknown_array_with_wrong_offsets(self, file):
        """Unknown arrays are ignored, but the file must be valid safetensors."""
        size = struct.unpack("<Q", file[:8])[0]
        header = json.loads(file[8 : 8 + size])
        end = len(file) - 8 - size
        for begin, size_of in ((end, 4), (end - 4, 4), (end + 4, 8)):
            offsets = [begin, begin + size_of]
            header["notes"] = {"dtype": "F32", "shape": [1], "data_offsets": offsets}
            text = json.dumps(header).encode()
            body = file[8 + size :] + b"\0" * (0 if begin == end else 4)
            with pytest.raises(HistoryFileError, match="damaged"):
                history_from_bytes(struct.pack("<Q", len(text)) + text + body)

    @pytest.mark.parametrize(
        ("name", "place", "values"),
        [
            # slots that the coarsest level does not have
            ("base.faces", (2, 1), (-1, 4, 2**31 - 1, -(2**31))),
            # coordinates that float32 may not hold
            ("base.positions", (1, 1), (2**24 + 1, -(2**24) - 1, -(2**31))),
            ("centre", 1, (np.nan, np.inf, -np.inf)),
            # no powers of two, or too small or too large ones
            ("step", ..., (0.0, -0.5, 3.0, 0.1, np.nan, np.inf, 2.0**-150, 2.0**104, 5e-324)),
        ],
    )
    def test_value_out_of_range(self, file, name, place, values):
        for value in values:
            array = safetensors.numpy.load(file)[name].copy()
            array[place] = value
            with pytest.raises(HistoryFileError) as caught:
                history_from_bytes(tampered(file, **{name: array}))
            assert caught.value.where == {"field": name}

    @pytest.mark.parametrize("face", [(0, 0, 1), (1, 1, 1), (0, 2, 1), (0, 1, 2)])
    def test_coarsest_level_that_is_not_closed(self, file, face):
        faces = np.array([face, face, (0, 2, 3), (1, 3, 2)], np.int32)
        with pytest.raises(HistoryFileError, match="not closed"):
            history_from_bytes(tampered(file, base__faces=faces))

    def test_coarsest_level_beside_the_centre(self, file):
        for change in (
            {"base.positions": np.full((4, 3), 7, np.int32)},
            {"centre": np.full(3, 1e6)},
        ):
            with pytest.raises(HistoryFileError, match="see the centre"):
                history_from_bytes(tampered(file, **change))

    def test_stream_that_is_too_short_or_too_long(self, file):
        stream = safetensors.numpy.load(file)["splits.03"]
        with pytest.raises(HistoryFileError, match="ends within") as caught:
            unpacked(tampered(file, splits__03=stream[:-1]))
        assert caught.value.where["field"] == "splits.03"
        assert 32 <= caught.value.where["slot"] < 64
        with pytest.raises(HistoryFileError, match="bits over") as caught:
            unpacked(tampered(file, splits__03=np.append(stream, np.uint8(0))))
        assert caught.value.where == {"field": "splits.03"}

    def test_last_byte_that_does_not_end_with_zeros(self, small_history, first_levels):
        """Cut histories at different counts, so that some end within a byte."""
        refused = 0
        for vertices in range(10, 16):
            data = bytearray(history_bytes(first_levels(small_history, vertices)))
            data[-1] ^= 1
            try:
                unpacked(bytes(data))
            except HistoryFileError as error:
                refused += "bits over" in error.message
        assert refused > 1

    @pytest.mark.parametrize("depth", [10, 1000, 100_000, 1_000_000])
    def test_deeply_nested_json(self, depth):
        text = b'{"__metadata__":' + b"[" * depth + b"]" * depth + b"}"
        with pytest.raises(HistoryFileError):
            history_from_bytes(struct.pack("<Q", len(text)) + text)

    @pytest.mark.parametrize("size", [0, 1, 2**24 + 1, 2**62, 2**64 - 1])
    def test_wrong_header_length(self, file, size):
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
            b'{"__metadata__": {"format": "gamut-history", "version": "2", "other": 5}}',
            b'{"__metadata__": {"format": "gamut-history", "version": "2", "vertices": "4"}}',
            TETRAHEDRON + b'"dtype": "F64", "shape": [3], "data_offsets": [0, 999999999999]}}',
            TETRAHEDRON
            + b'"dtype": "F64", "shape": [4611686018427387904], "data_offsets": [0, 0]}}',
        ],
    )
    def test_wrong_header(self, text):
        data = struct.pack("<Q", len(text)) + text
        with pytest.raises(HistoryFileError):
            history_from_bytes(data)

    def test_bytes_behind_the_arrays(self, file):
        with pytest.raises(HistoryFileError):
            history_from_bytes(file + b"\0")

    @pytest.mark.parametrize("content", [b"", b"PK\3\4", b"glTF" + bytes(100), b"\x93NUMPY\1\0"])
    def test_metadata_of_another_file(self, tmp_path, content):
        path = tmp_path / "file"
        path.write_bytes(content)
        with pytest.raises(HistoryFileError):
            history_metadata(path)

    def test_a_file_that_is_not_there_is_an_os_error(self, tmp_path):
        with pytest.raises(FileNotFoundError):
            history_metadata(tmp_path / "nothing")
