"""Pictures written by hand, so that the readers are not tested by the libraries they use."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

_LETTERS = {1: "B", 3: "H", 4: "I", 7: "B"}


def png_chunk(name: bytes, content: bytes) -> bytes:
    """Return a chunk with its length and check sum."""
    return (
        struct.pack(">I", len(content))
        + name
        + content
        + struct.pack(">I", zlib.crc32(name + content))
    )


class Png:
    """Writes PNG files (W3C PNG, third edition) without filters, or with the filter of Paeth."""

    chunk = staticmethod(png_chunk)

    def __call__(self, pixels, depth, colour, *chunks, filtered=0, interlaced=0):
        height, width = pixels.shape[:2]
        header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, interlaced)
        data = zlib.compress(b"".join(self.rows(pixels, depth, filtered, interlaced)))
        return (
            b"\x89PNG\r\n\x1a\n"
            + png_chunk(b"IHDR", header)
            + b"".join(chunks)
            + png_chunk(b"IDAT", data)
            + png_chunk(b"IEND", b"")
        )

    def rows(self, pixels, depth, filtered, interlaced):
        if interlaced:  # first column and row, and their steps, of each pass (clause 8.2)
            for left, top, right, down in [
                (0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2),
                (0, 1, 1, 2),
            ]:  # fmt: skip
                part = pixels[top::down, left::right]
                if part.size:
                    yield from self.rows(part, depth, filtered, 0)
            return
        before = None
        step = max(1, depth * (pixels.shape[2] if pixels.ndim == 3 else 1) // 8)
        for row in pixels:
            line = self.packed(row.reshape(-1), depth)
            above = np.zeros_like(line) if before is None else before
            yield (b"\4" + self.paeth(line, above, step)) if filtered else b"\0" + line.tobytes()
            before = line

    @staticmethod
    def packed(values, depth):
        if depth == 16:
            return np.frombuffer(values.astype(">u2").tobytes(), np.uint8)
        bits = np.unpackbits(values.astype(np.uint8)[:, np.newaxis], axis=1)[:, 8 - depth :]
        return np.packbits(bits)

    @staticmethod
    def paeth(line, above, step):
        """Return a row as differences from the predictor of clause 9.4."""
        found = bytearray()
        for place in range(len(line)):
            left = int(line[place - step]) if place >= step else 0
            corner = int(above[place - step]) if place >= step else 0
            up = int(above[place])
            estimate = left + up - corner
            nearest = min((left, up, corner), key=lambda value: abs(estimate - value))
            found.append((int(line[place]) - nearest) % 256)
        return bytes(found)


def tiff_file(parts, tags, *, order="<", tiled=False, big=False):
    """Return a TIFF (or BigTIFF) file of strips or tiles and tags: tag to type and values."""
    body = bytearray(16)
    starts = []
    for part in parts:
        starts.append(len(body))
        body += part + bytes(-len(part) % 2)
    tags = {
        **tags,
        (324 if tiled else 273): (4, starts),
        (325 if tiled else 279): (4, [len(part) for part in parts]),
    }
    word, room = ("Q", 8) if big else ("I", 4)
    table = struct.pack(order + ("Q" if big else "H"), len(tags))
    for tag, (kind, values) in sorted(tags.items()):
        content = (
            values
            if isinstance(values, bytes)
            else struct.pack(f"{order}{len(values)}{_LETTERS[kind]}", *values)
        )
        place = content.ljust(room, b"\0")
        if len(content) > room:
            place = struct.pack(order + word, len(body))
            body += content + bytes(-len(content) % 2)
        table += struct.pack(order + "HH" + word, tag, kind, len(values)) + place
    mark = b"II" if order == "<" else b"MM"
    version = struct.pack(order + "HHH", 43, 8, 0) if big else struct.pack(order + "H", 42)
    header = mark + version + struct.pack(order + word, len(body))
    body[: len(header)] = header
    return bytes(body) + table + bytes(8)


def tiff_tags(width, height, bits, samples, photometric, **more):
    """Return the tags of a picture; `more` are further ones by number, as ``t259``."""
    tags = {
        256: (4, [width]),
        257: (4, [height]),
        258: (3, [bits] * samples),
        262: (3, [photometric]),
        277: (3, [samples]),
    }
    return tags | {int(name[1:]): (3, [value]) for name, value in more.items()}


@pytest.fixture(params=["whole", "a row at a time"])
def bands(request, monkeypatch):
    """Decode small pictures at once, and one row at a time."""
    if request.param != "whole":
        monkeypatch.setattr("gamutcore.characterisation.pictures.raster.BAND_BYTES", 1)
    return request.param


@pytest.fixture
def png():
    return Png()


@pytest.fixture
def tiff():
    return tiff_file


@pytest.fixture
def tags():
    return tiff_tags


@pytest.fixture
def noise():
    """Return a function from a shape and a number of bits to fixed noise."""

    def made(*shape, bits=8, seed=0):
        kind = np.uint8 if bits <= 8 else np.uint16
        return np.random.default_rng(seed).integers(0, 2**bits, shape, dtype=np.int64).astype(kind)

    return made


@pytest.fixture
def pixel_counts():
    """Return a function from whole numbers, a row per pixel, to a dictionary of their counts."""

    def counted(pixels):
        rows, counts = np.unique(pixels.reshape(-1, pixels.shape[-1]), axis=0, return_counts=True)
        return {tuple(map(int, row)): int(n) for row, n in zip(rows, counts, strict=True)}

    return counted


@pytest.fixture
def counts_of():
    """Return a function from a picture and its full scale to the same dictionary."""

    def counted(picture, full):
        whole = np.round(picture.values * full).astype(np.int64)
        assert np.abs(picture.values * full - whole).max() < 1e-6
        return {tuple(map(int, row)): int(n) for row, n in zip(whole, picture.counts, strict=True)}

    return counted


FIELDS = np.array(
    [[0.9, 0.1, 0.1], [0.1, 0.8, 0.2], [0.1, 0.1, 0.9], [0.5, 0.5, 0.5], [1, 1, 1], [0, 0, 0]]
)


@pytest.fixture
def written(tmp_path):
    """Return a function that writes fields of 16 × 16 pixels, which lossy formats hardly change."""

    def write(extension, sample_type, colours=FIELDS, **attributes):
        pixels = np.repeat(np.repeat(colours[np.newaxis], 16, axis=0), 16, axis=1)
        spec = oiio.ImageSpec(pixels.shape[1], 16, pixels.shape[2], sample_type)
        for name, value in attributes.items():
            kinds = {"chromaticities": "float[8]", "CICP": "int[4]"}
            if name in kinds:
                spec.attribute(name, oiio.TypeDesc(kinds[name]), value)
            else:
                spec.attribute(name.replace("__", ":"), value)
        path = tmp_path / f"picture{extension}"
        output = oiio.ImageOutput.create(str(path))
        assert output.open(str(path), spec)
        assert output.write_image(np.ascontiguousarray(pixels, np.float32))
        assert output.close()
        return path.read_bytes()

    return write
