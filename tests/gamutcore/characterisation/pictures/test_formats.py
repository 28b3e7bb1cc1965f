import json
import os
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gamutcore.characterisation import Picture, characterisation
from gamutcore.characterisation.pictures import looks_like_picture
from gamutcore.characterisation.pictures.bounds import FREELY_EVALUATED
from gamutcore.errors import OptionError


@pytest.mark.parametrize(
    "data",
    [
        b"\x89PNG\r\n\x1a\n",
        b"\xff\xd8\xff\xe0",
        b"II*\0\x08\0\0\0",
        b"MM\0*\0\0\0\x08",
        b"II+\0\x08\0\0\0",
        b"MM\0+\0\x08\0\0",
    ],
)
def test_pictures_are_told_by_their_first_bytes(data):
    assert looks_like_picture(data)


@pytest.mark.parametrize("data", [b"", b"II", b"MM", b"II, MM\n1, 2\n", b"\xff\xd8", b"\x89PNG"])
def test_other_data_is_not(data):
    assert not looks_like_picture(data)


def test_a_picture_is_characterisation_data(png, tiff, tags):
    pixels = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    for data in (png(pixels, 8, 2), tiff([pixels.tobytes()], tags(4, 4, 8, 3, 2))):
        found = characterisation(data)
        assert isinstance(found, Picture)
        assert found.provenance["format"] == found.format
        with pytest.raises(OptionError) as caught:
            characterisation(data, condition="M1")
        assert caught.value.where == {"field": "condition"}


MOST_BYTES = 512 * 2**20
"""What a process may hold that reads files of few bytes, with the program itself."""

BUILD = """
import json, sys
from pathlib import Path
from gamutcore.errors import GamutError
from gamutcore.gamut import Options, build_gamut
from gamutcore.warm import compile_kernels

compile_kernels()
said = {}
for path in map(Path, sys.argv[1:]):
    try:
        said[path.name] = build_gamut(path.read_bytes(), Options()).description["provenance"]
    except GamutError as error:
        said[path.name] = error.code
peak = [line.split() for line in open("/proc/self/status") if line.startswith("VmHWM")]
print(json.dumps({"peak": int(peak[0][1]) * 1024, "said": said}))
"""


def packed(lines):
    packer = zlib.compressobj(9)
    return b"".join(map(packer.compress, lines)) + packer.flush()


def png_of_lines(png, lines, size, depth, colour):
    width, height = size
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    parts = [(b"IHDR", header), (b"IDAT", packed(lines)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(png.chunk(*part) for part in parts)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is told by Linux only")
def test_few_bytes_of_many_pixels_do_not_fill_the_memory(tmp_path, png, tiff, tags, noise):
    """44, 22 and 11 megapixels of 0.1 to 2 MB: one colour, and millions by a constant filter."""

    # The filter Up: every row is the one above and this one. 256 different rows come of one, and
    # as many again of each other one among them.
    one, other = (b"\2" + noise(6 * 4720, seed=seed).tobytes() for seed in (0, 1))
    flat = packed([bytes(6680 * 3)] * 6680)
    floats = packed([bytes(3300 * 12)] * 3300)
    files = {
        "flat.png": png_of_lines(png, [bytes(6680 * 3 + 1)] * 6680, (6680, 6680), 8, 2),
        "deep.png": png_of_lines(png, [bytes(4720 * 6 + 1)] * 4720, (4720, 4720), 16, 2),
        "many.png": png_of_lines(png, [one] * 4720, (4720, 4720), 16, 2),
        "most.png": png_of_lines(png, ([*[one] * 255, other] * 19)[:4720], (4720, 4720), 16, 2),
        "flat.tif": tiff([flat], tags(6680, 6680, 8, 3, 2, t259=8, t317=2)),
        "floats.tif": tiff([floats], tags(3300, 3300, 32, 3, 2, t259=8, t317=3, t339=3)),
        "packbits.tif": tiff([b"\x81\0" * 1_046_875], tags(6700, 6666, 8, 3, 2, t259=32773)),
    }
    for name, content in files.items():
        assert len(content) < 2_100_000
        (tmp_path / name).write_bytes(content)
    blank = Image.new("RGB", (6000, 4000), (120, 40, 200))
    blank.save(tmp_path / "flat.jpg", quality=90)
    blank.save(tmp_path / "progressive.jpg", quality=90, progressive=True, subsampling=0)
    del blank
    paths = sorted(map(str, tmp_path.iterdir()))
    environment = {**os.environ, "MALLOC_ARENA_MAX": "2"}
    done = subprocess.run(
        [sys.executable, "-c", BUILD, *paths],
        capture_output=True, text=True, check=True, env=environment,
    )  # fmt: skip
    found = json.loads(done.stdout)
    assert found["peak"] < MOST_BYTES
    one_colour = {"flat.png", "deep.png", "flat.tif", "floats.tif", "flat.jpg"}
    assert {found["said"][name] for name in one_colour} == {"too-few-points"}
    refused = {"packbits.tif", "progressive.jpg", "most.png"}
    assert {found["said"][name] for name in refused} == {"picture-too-large"}
    assert found["said"]["many.png"]["distinct_values"] > 10**6
    assert found["said"]["many.png"]["lattice"]["values"] <= FREELY_EVALUATED
