"""Links: files read by OpenColorIO and Argyll, against mappings by `Gamut.map`, and refusals."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from PIL import ImageCms

from gamutcore import Gamut, link
from gamutcore.cli.app import app, run
from gamutcore.colours import cube_nodes
from gamutcore.errors import DeviceModelError, OptionError, ReferenceNameError
from gamutcore.links import table, table_size
from gamutcore.questions import PICTURE_SPACE
from gamutcore.search import delta_e_2000

DATA = Path(__file__).parents[2] / "data"
PRESS = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"
P3_TO_SRGB = np.array(  # CSS Color 4, section 17: by way of XYZ, both D65
    [
        (1.2249401762805598, -0.22494017628055996, 0.0),
        (-0.042056954709688163, 1.0420569547096881, 0.0),
        (-0.019637554590334432, -0.078636045550631889, 1.0982736001409663),
    ]
)
COARSE = {"surface_samples": 2000}
LINKED = {"space": PICTURE_SPACE, **COARSE}


@pytest.fixture(scope="module")
def srgb(screen):
    return screen("srgb", space=PICTURE_SPACE)


@pytest.fixture(scope="module")
def display_p3(screen):
    return screen("display-p3", space=PICTURE_SPACE)


@pytest.fixture(scope="module")
def cielab(screen):
    return screen("srgb")


@pytest.fixture(scope="module")
def p3_to_srgb(srgb, display_p3):
    return link(display_p3, srgb, method="clip-nearest", size=9)


def decode(values):
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def encode(linear):
    size = np.abs(linear)
    encoded = np.where(size <= 0.0031308, 12.92 * size, 1.055 * size ** (1 / 2.4) - 0.055)
    return np.copysign(encoded, linear)


def read(path):
    """Return the lines of a .cube file before the numbers, and the numbers, red fastest."""
    lines = path.read_text("ascii").splitlines()
    head = [line for line in lines if not line[0].isdigit()]
    return head, np.array([line.split() for line in lines[len(head) :]], float)


@pytest.mark.parametrize("method", ["sgck", "clip-hue"])
def test_nodes_have_the_mapped_colours(srgb, display_p3, cielab, tmp_path, method):
    path = tmp_path / "p3.cube"
    found = link(display_p3, srgb, method=method, size=5)
    found.save(path)
    head, numbers = read(path)
    assert head[-3:] == ["LUT_3D_SIZE 5", "DOMAIN_MIN 0.0 0.0 0.0", "DOMAIN_MAX 1.0 1.0 1.0"]
    assert head[0].startswith('TITLE "display-p3 to srgb')
    assert f"worst {found.errors.worst:.2f} dE00" in head[0]
    nodes = cube_nodes(5)[:, ::-1]  # red fastest
    given = encode(decode(nodes) @ P3_TO_SRGB.T)
    source = {"source": display_p3} if method == "sgck" else {}
    mapped = srgb.map(given, method, space="sRGB", max_error=0, **source)
    clipped = np.clip(mapped.points, 0.0, 1.0)
    within = (np.abs(clipped - mapped.points) < 1e-6).all(axis=1)
    np.testing.assert_allclose(numbers[within], clipped[within], atol=1e-6)  # rounded
    wanted, cut, got = (cielab.convert(rows, "sRGB") for rows in (mapped.points, clipped, numbers))
    # the boundary is a mesh, and leaves sRGB by a little: there, values are nearest by ΔE*ab
    further = np.linalg.norm(got - wanted, axis=1) - np.linalg.norm(cut - wanted, axis=1)
    assert further[~within].max() < 1e-3
    assert list(numbers[0]) == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(numbers[-1], 1.0, atol=1e-5)


def test_opencolorio_applies_the_file(p3_to_srgb, tmp_path):
    path = tmp_path / "p3.cube"
    p3_to_srgb.save(path)
    values = np.random.default_rng(1).random((64, 64, 3)).astype(np.float32)
    picture = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(64, 64, 3, "float"))
    picture.set_pixels(OpenImageIO.ROI(), values)
    applied = OpenImageIO.ImageBufAlgo.ociofiletransform(picture, str(path))
    assert not applied.has_error
    expected = p3_to_srgb.table.values(values.reshape(-1, 3).astype(float))
    np.testing.assert_allclose(
        applied.get_pixels(OpenImageIO.FLOAT).reshape(-1, 3), expected, rtol=0, atol=1e-6
    )


@pytest.mark.skipif(shutil.which("icclu") is None, reason="Argyll CMS is not installed")
def test_argyll_and_lcms_read_the_device_link(p3_to_srgb, tmp_path):
    path = tmp_path / "p3.icc"
    p3_to_srgb.save(path)
    values = np.random.default_rng(2).random((300, 3))
    asked = "\n".join(" ".join(map(repr, row)) for row in values.tolist())
    answer = subprocess.run(
        ["icclu", "-v0", path], input=asked, text=True, capture_output=True, check=True
    )
    applied = np.array([line.split() for line in answer.stdout.splitlines()], float)
    # 16 bits in the table, and six digits in the answer
    np.testing.assert_allclose(applied, p3_to_srgb.table.values(values), rtol=0, atol=2e-5)
    profile = ImageCms.getOpenProfile(str(path)).profile
    assert (profile.device_class, profile.xcolor_space.strip()) == ("link", "RGB")
    assert f"worst {p3_to_srgb.errors.worst:.2f} dE00" in profile.profile_description


@pytest.mark.skipif(shutil.which("transicc") is None, reason="liblcms2-utils is not installed")
@pytest.mark.slow
def test_transicc_applies_a_device_link_from_rgb_to_inks(srgb, tmp_path):
    path = tmp_path / "press.icc"
    found = link(srgb, PRESS, method="clip-nearest", size=9, ink_limit=300, **COARSE)
    found.save(path)
    values = np.random.default_rng(5).random((200, 3))
    asked = "\n".join(" ".join(map(repr, row)) for row in (255.0 * values).tolist())
    answer = subprocess.run(
        ["transicc", "-n", "-l", path], input=asked, text=True, capture_output=True, check=True
    )
    applied = np.array([line.split() for line in answer.stdout.splitlines()], float) / 100.0
    # 16 bits in the table and in the program, whose inputs have 16 bits as well
    np.testing.assert_allclose(applied, found.table.values(values), rtol=0, atol=1e-4)


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_ffmpeg_applies_the_cube(p3_to_srgb, tmp_path):
    path = tmp_path / "p3.cube"
    p3_to_srgb.save(path)
    values = np.random.default_rng(6).integers(0, 65536, (32, 32, 3)).astype("<u2")
    form = ["-f", "rawvideo", "-pixel_format", "rgb48le", "-video_size", "32x32"]
    command = ["ffmpeg", "-v", "error", *form, "-i", "-", "-vf"]
    command += [f"lut3d=file={path}:interp=tetrahedral", *form[:2], "-pix_fmt", "rgb48le", "-"]
    answer = subprocess.run(command, input=values.tobytes(), capture_output=True, check=True)
    applied = np.frombuffer(answer.stdout, "<u2").reshape(-1, 3) / 65535.0
    expected = p3_to_srgb.table.values(values.reshape(-1, 3) / 65535.0)
    np.testing.assert_allclose(applied, expected, rtol=0, atol=4e-5)  # 16 bits


def test_a_space_to_itself_is_the_identity(srgb):
    found = link(srgb, srgb, size=17)
    np.testing.assert_allclose(found.table.nodes.reshape(-1, 3), cube_nodes(17), atol=1e-6)
    assert found.errors.worst < 0.05  # of curves that are straight between nodes; exact there


def test_other_inputs_have_the_stated_errors(srgb, display_p3, cielab, monkeypatch):
    monkeypatch.setattr(table, "INPUTS", 5000)
    found = link(display_p3, srgb, method="clip-nearest", size=9)
    values = np.random.default_rng(99).random((4000, 3))
    wanted = srgb.map(
        encode(decode(values) @ P3_TO_SRGB.T), "clip-nearest", space="sRGB", max_error=0
    )
    colours = [cielab.convert(rows, "sRGB") for rows in (wanted.points, found.table.values(values))]
    difference = delta_e_2000(*colours)
    assert difference.mean() == pytest.approx(found.errors.mean, rel=0.1)
    assert 0.03 < (difference > found.errors.percentile_95).mean() < 0.07
    assert 0.005 < (difference > found.errors.percentile_99).mean() < 0.015
    assert found.errors.worst >= found.errors.percentile_99


def test_profiles_give_the_tables_of_their_spaces(srgb, display_p3):
    """The profiles of the two spaces, of which the destination's is inverted by search."""
    spaces = link(display_p3, srgb, method="clip-nearest", size=5)
    profiles = link(
        DATA / "DisplayP3-v4.icc",
        DATA / "sRGB-v4.icc",
        method="clip-nearest",
        size=5,
        **COARSE,
    )
    assert (profiles.source, profiles.destination) == ("DisplayP3-v4.icc", "sRGB-v4.icc")
    np.testing.assert_allclose(profiles.table.nodes, spaces.table.nodes, atol=1e-2)


@pytest.mark.slow
def test_black_of_the_source_becomes_that_of_the_destination(srgb):
    rgb = cube_nodes(3)
    light = 0.01 + 0.99 * decode(rgb)  # a display whose black has 1 % of its white
    to_xyz = np.array(
        [(0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505)]
    )
    rows = np.hstack([100 * rgb, 100 * light @ to_xyz.T])
    names = "RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z"
    lines = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in rows)
    display = (
        'CTI3\n\nDEVICE_CLASS "DISPLAY"\nNUMBER_OF_FIELDS 6\nBEGIN_DATA_FORMAT\n'
        f"{names}\nEND_DATA_FORMAT\nNUMBER_OF_SETS {len(rows)}\nBEGIN_DATA\n{lines}\nEND_DATA\n"
    ).encode()
    middle = [
        link(srgb, display, method="clip-chroma", size=5, black_point_compensation=each, **COARSE)
        .table.nodes[1, 1, 1]
        .mean()
        for each in (False, True)
    ]
    assert middle[0] + 0.01 < middle[1]  # dark grays are lighter in order to stay apart


@pytest.mark.slow
def test_a_press_gets_separations_within_its_ink_limit(cielab, tmp_path):
    path = tmp_path / "press.icc"
    press = Gamut(PRESS, ink_limit=280, **LINKED)
    found = link("srgb", press, method="clip-hue", black="maximum", size=17, **COARSE)
    assert (found.channels, found.destination_channels) == (("R", "G", "B"), ("C", "M", "Y", "K"))
    values = np.random.default_rng(4).random((500, 3))
    inks = found.table.values(values)
    assert inks.sum(axis=1).max() <= 2.8 + 1e-5
    wanted = press.map(values, "clip-hue", space="sRGB", max_error=0, black_point_compensation=True)
    difference = delta_e_2000(
        press.to_colour(inks, space="CIELAB"), cielab.convert(wanted.points, "sRGB")
    )
    assert np.percentile(difference, 99) <= found.errors.worst
    assert difference.mean() == pytest.approx(found.errors.mean, rel=0.2)
    found.save(path)
    header = path.read_bytes()[:128]
    assert (header[12:16], header[16:20], header[20:24]) == (b"link", b"RGB ", b"CMYK")
    with pytest.raises(OptionError, match=r"from R G B to C M Y K"):
        found.save(tmp_path / "press.cube")
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(shutil.which("icclu") is None, reason="Argyll CMS is not installed")
@pytest.mark.slow
def test_argyll_reads_a_link_from_a_press(srgb, tmp_path):
    path = tmp_path / "proof.icc"
    found = link(PRESS, srgb, method="clip-chroma", size=9, **COARSE)
    found.save(path)
    nodes = cube_nodes(9, 4)[::41]
    asked = "\n".join(" ".join(map(repr, row)) for row in nodes.tolist())
    answer = subprocess.run(
        ["icclu", "-v0", path], input=asked, text=True, capture_output=True, check=True
    )
    applied = np.array([line.split() for line in answer.stdout.splitlines()], float)
    np.testing.assert_allclose(applied, found.table.values(nodes), rtol=0, atol=2e-5)


@pytest.mark.parametrize(
    ("source", "destination", "choices", "field"),
    [
        ("acescg", "srgb", {}, "source"),
        ("srgb", "bt2100-pq-1000", {}, "destination"),
        ("srgb", "pointer", {}, "destination"),
        (PRESS, "srgb", {"method": "clip-hue", "size": 39}, "size"),
        ("srgb", PRESS, {"method": "clip-hue", "black": "much"}, "black"),
        ("srgb", DATA / "sGrey-v4.icc", {}, "destination"),
        ("srgb", "srgb", {"size": 1}, "size"),
        ("srgb", "srgb", {"size": 130}, "size"),
        ("srgb", "srgb", {"method": "clip"}, "method"),
        ("srgb", "srgb", {"intent": "perceptual"}, "intent"),
        ("srgb", "srgb", {"nonsense": 1}, "nonsense"),
    ],
)
def test_refusals_name_the_argument(source, destination, choices, field):
    with pytest.raises(OptionError) as refused:
        link(source, destination, **choices)
    assert refused.value.where["field"] == field
    assert refused.value.remedy


def test_colours_that_are_not_adapted_are_not_compressed_into_those_that_are(few_patches):
    choices = {"intent": "absolute", "method": "sgck", "surface_samples": 500}
    with pytest.raises(OptionError, match="adapted to D50") as refused:
        link("srgb", few_patches, **choices)
    assert refused.value.where["field"] == "intent"
    assert refused.value.remedy


@pytest.mark.parametrize("most", [65**3, 129**3])
def test_tables_of_any_number_of_channels_are_within_the_limit(most):
    """ICC profiles have up to 15 channels."""
    for channels in range(3, 16):
        size = table_size(None, channels, most)
        assert size >= 2
        assert size**channels <= most
    assert table_size(round(most ** (1 / 3)), 3, most) ** 3 == most


def test_unknown_names_and_gamuts_without_a_model(srgb, tmp_path):
    with pytest.raises(ReferenceNameError) as refused:
        link("srgb", "rec2021")
    assert refused.value.where["field"] == "destination"
    cube = Gamut(100.0 * cube_nodes(2))
    with pytest.raises(DeviceModelError, match="colours only") as refused:
        link(cube, srgb)
    assert refused.value.where["field"] == "source"
    with pytest.raises(OptionError, match=r"ends in \.cube"):
        link(srgb, srgb, method="clip-hue", size=2).save(tmp_path / "p3.3dl")


def test_nothing_is_left_of_a_file_that_cannot_be_written(srgb, tmp_path):
    taken = tmp_path / "taken.cube"
    taken.mkdir()
    with pytest.raises(OSError, match="taken"):
        link(srgb, srgb, method="clip-hue", size=2).save(taken)
    assert list(tmp_path.iterdir()) == [taken]


def test_command(tmp_path, capsys):
    path = tmp_path / "p3.cube"
    asked = ["link", "display-p3", "srgb", "-o", str(path), "--method", "clip-hue", "--size", "5"]
    assert run(app, [*asked, "--surface-samples", "500"]) == 0
    assert (
        "display-p3 to srgb, clip-hue in CAM16-UCS, 5 nodes a side. Error: mean"
        in capsys.readouterr().out
    )
    assert len(read(path)[1]) == 125
    asked[4] = str(tmp_path / "missing" / "p3.cube")
    assert run(app, asked) == 1
    assert "There is no such folder" in capsys.readouterr().err
