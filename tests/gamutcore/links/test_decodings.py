"""How code values become light: BT.1886 for video, or what is asked."""

import struct
import zlib

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from gamutcore import Gamut, link
from gamutcore.errors import OptionError

FEW = {"surface_samples": 2000}
GREYS = (0.25, 0.5, 0.75)


@pytest.fixture(scope="module")
def cinema(screen):
    return screen("p3-d65", space="IPT")


def greys(made, codes=GREYS):
    """Return what a link makes of equal values, and check that it is grey."""
    values = made.table.values(np.repeat(np.array(codes)[:, np.newaxis], 3, axis=1))
    assert np.ptp(values, axis=1).max() < 2e-5
    return values.mean(axis=1)


@pytest.mark.parametrize("source", ["bt709", "bt2020"])
def test_displays_decode_video_by_bt1886(cinema, source):
    """Figures of issue 46: V^(2.4 / 2.6) by ITU-R BT.1886, annex 1, with a black of 0."""
    made = link(source, cinema, size=5, **FEW)
    np.testing.assert_allclose(greys(made), [0.278, 0.527, 0.767], atol=5e-4)
    np.testing.assert_allclose(greys(made), np.array(GREYS) ** (2.4 / 2.6), atol=1e-5)
    text = made.to_bytes("cube").decode()
    assert f'TITLE "{source} (BT.1886) to p3-d65, clip-hue' in text
    assert "# Code values of the source are light by: ITU-R BT.1886, exponent 2.4, black 0." in text
    assert f"{source} (BT.1886) to ".encode() in made.to_bytes("icc")


def pq(code):
    """Luminance of a code, cd/m² (SMPTE ST 2084; ITU-R BT.2100-2, table 4)."""
    m1, m2, c1, c2, c3 = 2610 / 16384, 2523 / 32, 3424 / 4096, 2413 / 128, 2392 / 128
    root = code ** (1 / m2)
    return 10_000 * (max(root - c1, 0) / (c2 - c3 * root)) ** (1 / m1)


@pytest.mark.parametrize(
    ("decode", "light"),
    [
        ("bt1886", lambda code: code**2.4),
        ("oetf", lambda code: ((code + 0.099) / 1.099) ** (1 / 0.45)),  # ITU-R BT.709-6, 1.2
        ("srgb", lambda code: ((code + 0.055) / 1.055) ** 2.4),  # IEC 61966-2-1
        ("pq", lambda code: min(pq(code) / 203, 1)),  # 203 cd/m² is white: ITU-R BT.2408-7, 2.2
    ],
)
@pytest.mark.parametrize("source", ["bt709", "srgb"])
def test_the_decoding_that_is_asked(cinema, source, decode, light):
    made = link(source, cinema, decode=decode, size=5, **FEW)
    expected = [light(code) ** (1 / 2.6) for code in GREYS]
    np.testing.assert_allclose(greys(made), expected, atol=2e-5)


def test_a_destination_is_encoded_for_its_display(cinema):
    made = link(cinema, "bt709", size=5, **FEW)
    np.testing.assert_allclose(greys(made), np.array(GREYS) ** (2.6 / 2.4), atol=1e-5)
    assert made.decodings == ("gamma 2.6", "BT.1886")


@pytest.mark.parametrize("space", ["bt709", "bt2020", "ntsc-1953", "bt470-525"])
def test_device_values_of_a_gamut_are_for_displays(screen, space):
    exponent = 2.4 if space.startswith(("bt7", "bt2")) else 2.2
    gamut = screen(space)
    y = np.array(GREYS) ** exponent
    colours = gamut.to_colour(np.repeat(np.array(GREYS)[:, np.newaxis], 3, axis=1))
    np.testing.assert_allclose(colours[:, 0], 116 * np.cbrt(y) - 16, atol=1e-9)
    codes = np.random.default_rng(1).random((50, 3))
    np.testing.assert_allclose(gamut.to_device(gamut.to_colour(codes)).device, codes, atol=1e-6)
    again = Gamut.from_bytes(gamut.to_bytes())
    assert again.volume == gamut.volume


@pytest.mark.parametrize("space", ["bt2020", "ntsc-1953", "prophoto-rgb"])
def test_values_of_the_surface_have_its_colours(screen, space):
    """Stored values are rounded; those of another curve would miss by 5 or more."""
    gamut = screen(space)
    mesh = gamut.mesh(max_error=0.0)
    found = gamut.to_colour(mesh.device.values)
    np.testing.assert_allclose(found, mesh.vertices, atol=0.1)


def png(code, *, declared=None):
    """Return a picture of one grey with 16 bits, with the code points of a chunk cICP."""
    rows = b"\0" + struct.pack(">HHH", code, code, code)
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 16, 2, 0, 0, 0))]
    chunks += [] if declared is None else [(b"cICP", bytes((*declared, 0, 1)))]
    chunks += [(b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )


def grey_of(path):
    return oiio.ImageInput.open(str(path)).read_image("uint16").ravel()[0] / 65535


@pytest.mark.parametrize(
    ("declared", "decode", "exponent"),
    [
        ((1, 1), None, 2.4),
        ((9, 14), None, 2.4),
        ((6, 6), None, 2.4),
        ((9, 14), "bt1886", 2.4),
        (None, "bt1886", 2.4),
    ],
)
def test_pictures_of_video_are_decoded_by_bt1886(cinema, tmp_path, declared, decode, exponent):
    """Half of the largest code, as the device's own value and in two spaces."""
    data, code = png(32768, declared=declared), 32768 / 65535
    for to, other in (("device", 2.6), ("p3-d65", 2.6), ("bt2020", 2.4)):
        path = tmp_path / "grey.tif"
        cinema.map_picture(data, path, to=to, decode=decode)
        assert grey_of(path) == pytest.approx(code ** (exponent / other), abs=3e-5)


def test_another_decoding_of_a_picture(cinema, tmp_path):
    data, code = png(32768, declared=(1, 1)), 32768 / 65535
    light = ((code + 0.099) / 1.099) ** (1 / 0.45)  # ITU-R BT.709-6, 1.2
    done = cinema.map_picture(data, tmp_path / "p3.tif", to="p3-d65", decode="oetf")
    assert grey_of(tmp_path / "p3.tif") == pytest.approx(light ** (1 / 2.6), abs=3e-5)
    assert any("decoded by oetf" in warning for warning in done.warnings)
    own = cinema.map_picture(data, tmp_path / "own.png", decode="oetf")
    assert own.moved == 0
    assert (tmp_path / "own.png").stat().st_size


def test_pictures_that_state_their_light_are_refused(cinema, tmp_path):
    cinema.map_picture(png(32768), tmp_path / "p3.tif", to="display-p3")
    cinema.map_picture(png(32768), tmp_path / "p3.exr", to="display-p3", depth="float")
    for name, word in (("p3.tif", "profile"), ("p3.exr", "linear")):
        with pytest.raises(OptionError, match=word) as refused:
            cinema.map_picture(tmp_path / name, tmp_path / "again.tif", decode="bt1886")
        assert refused.value.where["field"] == "decode"


@pytest.mark.parametrize(
    ("source", "choices"),
    [
        ("tests/data/DisplayP3-v4.icc", {"decode": "bt1886"}),
        ("bt709", {"decode": "gamma"}),
        ("bt2020", {"decode": "pq", "method": "sgck"}),
    ],
)
def test_refusals(cinema, source, choices):
    with pytest.raises(OptionError) as refused:
        link(source, cinema, size=5, **choices, **FEW)
    assert refused.value.where["field"] == "decode"
    assert refused.value.remedy
