"""Pictures over HTTP: posted, mapped and returned; hostile ones are refused."""

import asyncio
import io
import json
import struct
import sys
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from PIL import Image

from gamutcore import Gamut
from service.admission import Admission, Work
from service.problems.problem import ProblemError
from service.questions import pictures
from service.settings import Settings

ROOT = Path(__file__).parents[3]
PRESS = ROOT / "examples" / "FOGRA39L.ti3"
DISPLAY = ROOT / "tests" / "data" / "DisplayP3-v4.icc"
OPTIONS = {"surface_samples": 4000, "ink_limit": 300}
PIXELS = np.random.default_rng(5).integers(0, 256, (30, 40, 3), np.uint8)

pytestmark = pytest.mark.slow


def built(server, path, options):
    answer = server.client.post(
        "/v1/gamuts",
        files={"file": path.read_bytes()},
        data={"options": json.dumps(options)},
    )
    assert answer.status_code in {200, 201}, answer.text
    return answer.json()["links"]["self"]


@pytest.fixture(scope="module")
def press(server):
    return built(server, PRESS, OPTIONS)


@pytest.fixture(scope="module")
def here():
    return Gamut(PRESS, **OPTIONS)


def file_of(pixels, kind="png", **options):
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, kind, **options)
    return file.getvalue()


def post(server, address, content, kind="image/png", accept="*/*", **parameters):
    return server.client.post(
        f"{address}/map",
        params=parameters,
        content=content,
        headers={"Content-Type": kind, "Accept": accept},
        timeout=600,
    )


def opened(answer):
    assert answer.status_code == 200, answer.text
    return Image.open(io.BytesIO(answer.content))


def test_a_picture_is_mapped_as_by_the_package(server, press, here, tmp_path):
    given = file_of(PIXELS)
    done = here.map_picture(given, tmp_path / "here.png", "clip-chroma", max_error=0.5)
    answer = post(server, press, given, method="clip-chroma", max_error=0.5)
    np.testing.assert_array_equal(opened(answer), Image.open(tmp_path / "here.png"))
    assert answer.headers["content-type"] == "image/png"
    told = dict(each.split("=") for each in answer.headers["gamut-mapped"].split(", "))
    assert int(told["outside"]) == done.outside
    assert float(told["delta-e"]) == pytest.approx(done.delta_e, abs=1e-4)
    assert "sRGB is assumed" in answer.headers["gamut-warning"]
    report = post(server, press, given, method="clip-chroma", max_error=0.5, result="report").json()
    assert (report["pixels"], report["colours"]) == (done.pixels, done.colours)
    heat = opened(post(server, press, given, result="heat-map"))
    assert (heat.mode, heat.size) == ("L", (40, 30))


@pytest.mark.parametrize(
    ("accept", "kind"), [("image/tiff", "TIFF"), ("image/jpeg", "JPEG"), ("image/png", "PNG")]
)
def test_accept_decides_the_format(server, press, accept, kind):
    answer = post(server, press, file_of(PIXELS), accept=accept, to="display-p3")
    found = opened(answer)
    assert (found.format, answer.headers["content-type"]) == (kind, accept)
    assert found.info["icc_profile"]


@pytest.mark.parametrize("kind", ["JPEG", "WEBP", "GIF"])
def test_the_largest_picture_is_mapped_whatever_its_format(server, press, kind):
    """Pillow decodes some formats at once; only a header is read to learn the size."""
    side = np.array(Image.fromarray(PIXELS).quantize(16).convert("RGB"))
    given = file_of(side.repeat(200, axis=0).repeat(100, axis=1), kind)  # 24 megapixels
    answer = post(server, press, given, f"image/{kind.lower()}", result="report", max_error=0.5)
    assert answer.status_code == 200, answer.text
    assert answer.json()["pixels"] == 6000 * 4000


def test_device_values_are_cmyk(server, press, here, tmp_path):
    given = file_of(PIXELS[:8], "jpeg")
    here.map_picture(given, tmp_path / "here.tif", to="device", black=0.5)
    answer = post(server, press, given, "image/jpeg", to="device", black=0.5)
    found = opened(answer)
    assert (found.mode, answer.headers["content-type"]) == ("CMYK", "image/tiff")
    with Image.open(tmp_path / "here.tif") as expected:
        np.testing.assert_array_equal(found, expected)


def test_the_profile_of_the_input_is_embedded(server):
    display = built(server, DISPLAY, {"surface_samples": 1000})
    found = opened(post(server, display, file_of(PIXELS), to="device"))
    assert (found.mode, found.info["icc_profile"]) == ("RGB", DISPLAY.read_bytes())


def test_openexr_stays_openexr(server, press, tmp_path):
    path = tmp_path / "given.exr"
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), oiio.ImageSpec(8, 6, 3, "half"))
    assert output.write_image(np.full((6, 8, 3), 0.5, np.float32))
    output.close()
    answer = post(server, press, path.read_bytes(), "image/x-exr")
    assert answer.status_code == 200, answer.text
    assert answer.content.startswith(b"v/1\x01")


@pytest.mark.parametrize(
    ("parameters", "field"),
    [
        ({"to": "nonsense"}, "to"),
        ({"to": "device", "black": "much"}, "black"),
        ({"to": "srgb", "black": "none"}, "black"),
        ({"colour": "red"}, "colour"),
        ({"table": "3"}, "table"),
        ({"method": "spatial", "iterations": "-1"}, "iterations"),
        ({"method": "sgck"}, "source"),
        ({"result": "sound"}, "result"),
        ({"space": "sRGB"}, "space"),
    ],
)
def test_parameters_that_do_not_fit_are_refused(server, press, assert_problem, parameters, field):
    answer = post(server, press, file_of(PIXELS), **parameters)
    problem = assert_problem(answer, 422, "invalid-parameter")
    assert problem["where"]["field"] == field


def png_of_size(width, height):
    def chunk(kind, body):
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    head = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    pixels = chunk(b"IDAT", zlib.compress(bytes(100)))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + pixels + chunk(b"IEND", b"")


def test_what_is_no_picture_or_too_large_is_refused(server, press, assert_problem):
    assert_problem(post(server, press, b"L,a,b\n"), 422, "malformed-file")
    assert_problem(post(server, press, b""), 422, "malformed-file")
    assert_problem(post(server, press, file_of(PIXELS)[:-600]), 422, "malformed-file")
    assert_problem(post(server, press, png_of_size(60_000, 50_000)), 422, "picture-too-large")
    width = pictures.MOST_PIXELS // 4000 + 1
    large = assert_problem(post(server, press, png_of_size(width, 4000)), 422, "picture-too-large")
    assert "gamut map" in large["remedy"]


def test_damaged_pictures_are_never_defects(server, press):
    """Pictures with flipped bytes, and files that are no pictures, give answers or problems."""
    rng = np.random.default_rng(1)
    for kind in ("png", "jpeg", "tiff", "webp", "gif"):
        given = bytearray(file_of(PIXELS, kind))
        for place in rng.integers(0, len(given), 12):
            given[place] ^= 0xFF
        answer = post(server, press, bytes(given), f"image/{kind}")
        assert answer.status_code in {200, 422}, answer.text
    for name in ("sRGB-v4.icc", "DisplayP3-v4.icc"):
        answer = post(server, press, (ROOT / "tests" / "data" / name).read_bytes(), "image/tiff")
        assert answer.status_code == 422, answer.text
    assert opened(post(server, press, file_of(PIXELS))).size == (40, 30)


@pytest.mark.parametrize(
    ("request_seen", "seconds", "code"),
    [
        ("os.kill(os.getpid(), 11)", 60.0, "malformed-file"),
        ("time.sleep(60)", 1.0, "picture-too-complex"),
        ("bytearray(1 << 30).count(1)", 1.0, "picture-too-complex"),
    ],
)
def test_a_process_that_fails_is_a_problem_of_the_picture(tmp_path, request_seen, seconds, code):
    """A decoder that crashes, hangs or takes all memory ends its process alone."""
    script = f"""
import os, sys, time
print('{{"event": "ready"}}', flush=True)
sys.stdin.readline()
{request_seen}
{request_seen}
time.sleep(60)
"""
    settings = Settings(build_timeout=seconds, store=str(tmp_path))
    admission = Admission(1 << 30, most_waiting=9)
    asked = pictures.MappingRequest(tmp_path / "a", tmp_path / "b.png", tmp_path / "c")

    async def ask():
        mapping = pictures.Pictures(settings, (sys.executable, "-c", script))
        try:
            place = await admission.place(Work.HEAVY, "", int)
            with place, pytest.raises(ProblemError) as caught:
                await mapping.mapped(asked, place)
        finally:
            await mapping.close()
        return caught.value.problem

    assert asyncio.run(ask()).code == code
    assert admission.total == 0


def test_gamuts_of_colours_have_no_device(server, gamut, assert_problem):
    answer = post(server, gamut["links"]["self"], file_of(PIXELS), to="device")
    assert_problem(answer, 422, "no-device-model")


def test_nothing_is_left_of_pictures(server, press):
    post(server, press, file_of(PIXELS))
    assert not list(server.data.rglob("picture-*"))
    assert not list(server.data.rglob(".picture-*"))
