"""Transforms of ICC profiles: lookup tables and multi-process elements."""

import struct
from functools import partial
from itertools import product

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from gamutcore.characterisation import read_characterisation
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError

POINTS = np.random.default_rng(0).random((50, 3))
TURN = struct.pack(">9i", *[round(v * 65536) for v in (0, 1, 0, 0, 0, 1, 1, 0, 0)])
MATRIX = [[0.4, 0.3, 0.2], [0.2, 0.7, 0.1], [0.0, 0.1, 0.9]]


@pytest.fixture
def colours(made_profile):
    """Return a function from a transform's tag to the colours of device values."""

    def evaluate(data, channels=3, points=POINTS, pcs="Lab", tag="A2B1"):
        space = {1: "GRAY", 3: "RGB ", 4: "CMYK"}.get(channels, f"{channels:X}CLR")
        profile = read_characterisation(made_profile({tag: data}, space=space, pcs=f"{pcs:<4}"))
        return profile.transform("relative")[0].pcs_values(points)

    return evaluate


IDENTITY = b"curv" + bytes(8)


def lut16(inputs=3, *, grid=2, nodes=None, tables=(0, 65535), matrix=TURN):
    """A lut16 whose grid is the identity in the first three channels."""
    if nodes is None:
        nodes = [corner[:3] for corner in product((0, 65535), repeat=inputs)]
    flat = [int(v) for node in nodes for v in node]
    head = struct.pack(">4sIBBBB", b"mft2", 0, inputs, 3, grid, 0) + matrix
    head += struct.pack(">HH", len(tables), len(tables))
    curves = struct.pack(f">{len(tables)}H", *tables)
    return head + curves * inputs + struct.pack(f">{len(flat)}H", *flat) + curves * 3


def lut8():
    flat = bytes(255 * v for corner in product((0, 1), repeat=3) for v in corner)
    head = struct.pack(">4sIBBBB", b"mft1", 0, 3, 3, 2, 0) + TURN
    return head + bytes(range(256)) * 3 + flat + bytes(range(256)) * 3


def lut_a_to_b(*, grid=True, m=True, size=2, nodes=(2, 2, 2)):
    """A lutAToB with identity curves, an identity grid, and a matrix that turns the channels."""
    body, offsets = b"", {}

    def put(name, data):
        nonlocal body
        offsets[name] = 32 + len(body)
        body += data

    put("b", IDENTITY * 3)
    if m:
        put("matrix", TURN + struct.pack(">3i", 0, 0, 6554))
        put("m", IDENTITY * 3)
    if grid:
        put("a", IDENTITY * len(nodes))
        full = 255 if size == 1 else 65535
        flat = [int(full * v) for corner in product((0, 1), repeat=len(nodes)) for v in corner[:3]]
        clut = bytes(nodes) + bytes(16 - len(nodes)) + bytes([size, 0, 0, 0])
        put("clut", clut + struct.pack(f">{len(flat)}{'BH'[size - 1]}", *flat))
    order = [offsets.get(name, 0) for name in ("b", "matrix", "m", "clut", "a")]
    return struct.pack(">4sIBBH5I", b"mAB ", 0, len(nodes), 3, 0, *order) + body


def test_lut16_has_the_legacy_encoding_of_lab(colours):
    # ICC.1:2022, table 43: FF00h is L* 100; 8000h is a* 0, FF00h is a* 127.
    white = colours(lut16(nodes=[(0xFF00, 0x8000, 0x8000)] * 8))
    np.testing.assert_allclose(white, np.tile([100, 0, 0], (50, 1)), atol=1e-9)
    most = colours(lut16(nodes=[(0xFF00, 0xFF00, 0)] * 8))
    np.testing.assert_allclose(most, np.tile([100, 127, -128], (50, 1)), atol=1e-9)


def test_lut8_and_lut_a_to_b_have_lab_at_full_scale(colours):
    expected = POINTS * [100, 255, 255] - [0, 128, 128]
    np.testing.assert_allclose(colours(lut8()), expected, atol=1e-9)
    np.testing.assert_allclose(colours(lut_a_to_b(m=False)), expected, atol=1e-9)
    np.testing.assert_allclose(colours(lut_a_to_b(m=False, size=1)), expected, atol=1e-9)


def test_xyz_has_1_at_half_scale(colours):
    # ICC.1:2022, table 12: 8000h is 1.0.
    half = colours(lut16(nodes=[(0x8000,) * 3] * 8), pcs="XYZ")
    np.testing.assert_allclose(half, 1, atol=1e-9)


def test_the_matrix_of_lut16_is_not_applied_to_device_values(colours):
    identity = struct.pack(">9i", *[65536 * v for v in (1, 0, 0, 0, 1, 0, 0, 0, 1)])
    np.testing.assert_array_equal(colours(lut16()), colours(lut16(matrix=identity)))


def test_the_matrix_of_lut_a_to_b_is_applied(colours):
    turned = np.minimum(POINTS[:, [1, 2, 0]] + [0, 0, 6554 / 65536], 1)
    expected = turned * [100, 255, 255] - [0, 128, 128]
    np.testing.assert_allclose(colours(lut_a_to_b()), expected, atol=1e-9)
    np.testing.assert_allclose(colours(lut_a_to_b(grid=False)), expected, atol=1e-9)


def test_tables_come_before_and_after_the_grid(colours):
    squared = [round(65535 * (i / 255) ** 2) for i in range(256)]
    points = np.round(POINTS * 255) / 255
    plain = colours(lut16(tables=(0, 65535)), pcs="XYZ", points=points)
    curved = colours(lut16(tables=squared), pcs="XYZ", points=points)
    scale = 1 + 32767 / 32768
    np.testing.assert_allclose(curved / scale, (plain / scale) ** 4, atol=2e-3)


@pytest.mark.parametrize(("channels", "grid"), [(1, 5), (2, 4), (4, 3), (7, 2)])
def test_grids_are_interpolated_linearly(colours, channels, grid):
    chance = np.random.default_rng(1)
    table = chance.integers(0, 65536, (grid**channels, 3))
    points = chance.random((200, channels))
    points[:50] = points[:50].round()
    found = colours(lut16(channels, grid=grid, nodes=table), channels, points, pcs="XYZ")
    axes = [np.linspace(0, 1, grid)] * channels
    interpolator = RegularGridInterpolator(axes, table.reshape(*[grid] * channels, 3) / 32768)
    np.testing.assert_allclose(found, interpolator(points), atol=1e-9)


def test_a_grid_of_many_channels_is_refused_only_between_its_nodes(colours):
    lut = lut16(15, nodes=[(0, 0, 0)] * 2**15)
    corners = np.random.default_rng(2).integers(0, 2, (50_000, 15)).astype(float)
    assert colours(lut, 15, corners).shape == (50_000, 3)
    with pytest.raises(UnsupportedProfileError):
        colours(lut, 15, np.full((50_000, 15), 0.5))


@pytest.mark.parametrize(
    ("data", "channels"),
    [
        (lut16(), 4),
        (lut16()[:-1], 3),
        (lut16(grid=200), 3),
        (lut16(grid=1), 3),
        (lut16(tables=(0,)), 3),
        (lut8()[:700], 3),
        (b"mft2", 3),
        (lut16(15, grid=255, nodes=[(0, 0, 0)]), 15),
        (lut_a_to_b()[:60], 3),
        (
            lut_a_to_b(size=1).replace(
                b"\2\2\2" + bytes(13) + b"\1", b"\2\2\2" + bytes(13) + b"\3"
            ),
            3,
        ),
        (lut_a_to_b(nodes=(2, 2, 2)).replace(b"\2\2\2" + bytes(13), b"\2\1\2" + bytes(13)), 3),
        (lut_a_to_b(nodes=(2, 2, 2, 2)).replace(b"\2\2\2\2", b"\xff\xff\xff\xff"), 4),
        (b"mAB " + bytes(4) + b"\3\3" + bytes(40), 3),
        (
            b"mAB "
            + bytes(4)
            + b"\4\3"
            + bytes(2)
            + struct.pack(">5I", 32, 0, 0, 0, 0)
            + IDENTITY * 3,
            4,
        ),
        (b"mAB " + bytes(4) + b"\3\3" + bytes(2) + struct.pack(">5I", 0xFFFFFFFF, 0, 0, 0, 0), 3),
    ],
)
def test_broken_tables_are_refused(colours, data, channels):
    with pytest.raises(MalformedProfileError) as caught:
        colours(data, channels, np.zeros((1, channels)))
    assert caught.value.where == {"tag": "A2B1"}


def test_colours_that_are_not_finite_are_refused(colours):
    infinite = b"para" + bytes(4) + struct.pack(">HHi", 0, 0, -65536)
    data = lut_a_to_b(grid=False, m=False)[:32] + infinite * 3
    with pytest.raises(MalformedProfileError, match="finite"):
        colours(data, points=np.zeros((1, 3)))


@pytest.fixture
def elements(colours):
    """Return a function from multi-process elements to the colours of device values."""
    return partial(colours, pcs="XYZ", tag="D2B1")


def element(kind, before, after, body):
    return struct.pack(">4sIHH", kind, 0, before, after) + body


def gamma_curve(exponent):
    segment = struct.pack(">4sIHH4f", b"parf", 0, 0, 0, exponent, 1.0, 0.0, 0.0)
    return struct.pack(">4sIHH", b"curf", 0, 1, 0) + segment


def curve_set(channels, *curves):
    table, body, start = b"", b"", 12 + 8 * channels
    for curve in curves:
        table += struct.pack(">II", start + len(body), len(curve))
        body += curve
    return element(b"cvst", channels, channels, table + body)


def matrix(rows, offset):
    rows = np.asarray(rows, dtype=">f4")
    return element(
        b"matf", rows.shape[1], rows.shape[0], rows.tobytes() + np.asarray(offset, ">f4").tobytes()
    )


def clut(table):
    """A lookup table from an array (nodes..., outputs)."""
    nodes = bytes(table.shape[:-1])
    body = nodes + bytes(16 - len(nodes)) + table.astype(">f4").tobytes()
    return element(b"clut", table.ndim - 1, table.shape[-1], body)


def mpet(inputs, outputs, *elements):
    head = struct.pack(">4sIHHI", b"mpet", 0, inputs, outputs, len(elements))
    start = len(head) + 8 * len(elements)
    table, body = b"", b""
    for one in elements:
        table += struct.pack(">II", start + len(body), len(one))
        body += one + bytes(-len(one) % 4)
    return head + table + body


def test_curves_and_a_matrix(elements):
    data = mpet(
        3, 3, curve_set(3, *[gamma_curve(g) for g in (1.8, 2.0, 2.2)]), matrix(MATRIX, [0.1] * 3)
    )
    expected = (POINTS ** [1.8, 2.0, 2.2]) @ np.transpose(MATRIX) + 0.1
    np.testing.assert_allclose(elements(data), expected, atol=1e-6)


@pytest.mark.parametrize(("inputs", "outputs"), [(4, 3), (3, 5), (7, 3), (2, 1)])
def test_lookup_tables_are_interpolated_linearly(elements, inputs, outputs):
    table = np.random.default_rng(1).random((*[3] * inputs, outputs)).astype(np.float32)
    last = np.random.default_rng(2).random((3, outputs))
    points = np.random.default_rng(3).random((40, inputs))
    found = elements(mpet(inputs, 3, clut(table), matrix(last, [0, 0, 0])), inputs, points)
    axes = [np.linspace(0, 1, 3)] * inputs
    expected = RegularGridInterpolator(axes, table)(points) @ last.T
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_results_are_colours_without_an_encoding(elements):
    # ICC.1:2022, 6.3.4.2: connection space values of D2Bx are L*, a*, b* themselves.
    data = mpet(3, 3, matrix(np.zeros((3, 3)), [50.0, -20.0, 30.0]))
    np.testing.assert_allclose(elements(data, pcs="Lab"), np.tile([50, -20, 30], (50, 1)))


def test_markers_are_passed_through(elements):
    plain = mpet(3, 3, matrix(MATRIX, [0, 0, 0]))
    marked = mpet(
        3, 3, element(b"bACS", 3, 3, bytes(4)), matrix(MATRIX, [0, 0, 0]),
        element(b"eACS", 3, 3, bytes(4)),
    )  # fmt: skip
    np.testing.assert_array_equal(elements(marked), elements(plain))


def test_channels_may_share_a_curve(elements):
    curve = gamma_curve(2.0)
    shared = element(b"cvst", 3, 3, struct.pack(">6I", *[36, len(curve)] * 3) + curve)
    np.testing.assert_allclose(elements(mpet(3, 3, shared)), POINTS**2, atol=1e-9)


@pytest.mark.parametrize(
    ("data", "channels"),
    [
        (mpet(3, 3), 3),
        (mpet(3, 3, matrix(MATRIX, [0, 0, 0])), 4),
        (mpet(3, 1, matrix(np.zeros((1, 3)), [0])), 3),
        (mpet(3, 3, matrix(np.zeros((4, 3)), [0] * 4)), 3),
        (mpet(3, 3, matrix(np.zeros((4, 3)), [0] * 4), matrix(MATRIX, [0, 0, 0])), 3),
        (mpet(3, 3, matrix(MATRIX, [0, 0, 0]))[:-8], 3),
        (mpet(3, 3, matrix(MATRIX, [float("nan"), 0, 0])), 3),
        (mpet(3, 3, clut(np.zeros((2, 2, 2, 3))))[:-12], 3),
        (mpet(3, 3, clut(np.zeros((2, 1, 2, 3)))), 3),
        (mpet(3, 3, element(b"clut", 3, 3, b"\xff" * 16 + bytes(64))), 3),
        (mpet(3, 3, element(b"cvst", 3, 3, b"\xff" * 24)), 3),
        (b"text" + bytes(20), 3),
        (b"mpet", 3),
    ],
)
def test_broken_tags_are_refused(elements, data, channels):
    with pytest.raises(MalformedProfileError) as caught:
        elements(data, channels, np.zeros((1, channels)))
    assert caught.value.where == {"tag": "D2B1"}


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (mpet(3, 3, element(b"calc", 3, 3, bytes(40))), "calc"),
        (mpet(3, 3, curve_set(3, *[b"sngf" + bytes(40)] * 3)), "sngf"),
        (mpet(3, 3, element(b"JtoX", 3, 3, bytes(40))), "JtoX"),
        (mpet(3, 3, element(b"bACS", 3, 4, bytes(4))), "bACS"),
        (mpet(3, 3, *[matrix(MATRIX, [0, 0, 0])] * 33), "33"),
        (mpet(3, 3, matrix(np.zeros((17, 3)), [0] * 17)), "17"),
        (mpet(3, 3, *[clut(np.zeros((2, 2, 2, 3)))] * 3), "lookup tables"),
    ],
)
def test_what_is_not_evaluated_is_named(elements, data, named):
    with pytest.raises(UnsupportedProfileError, match=named) as caught:
        elements(data)
    assert caught.value.where == {"tag": "D2B1"}


def lab_tag(level):
    return mpet(3, 3, matrix(np.zeros((3, 3)), [level, 0, 0]))


CALCULATOR = mpet(3, 3, element(b"calc", 3, 3, bytes(40)))
LUT = (
    struct.pack(">4sIBBBB", b"mft1", 0, 3, 3, 2, 0)
    + bytes(36)
    + bytes(range(256)) * 3
    + bytes(24)
    + bytes(range(256)) * 3
)


@pytest.mark.parametrize(
    ("intent", "level", "used"),
    [("perceptual", 10, "D2B0"), ("relative", 20, "D2B1"), ("saturation", 30, "D2B2")],
)
def test_process_elements_go_before_lookup_tables(made_profile, intent, level, used):
    tags = {"D2B0": lab_tag(10), "D2B1": lab_tag(20), "D2B2": lab_tag(30), "A2B0": LUT, "A2B1": LUT}
    transform, warnings = read_characterisation(made_profile(tags)).transform(intent)
    assert (transform.tag, transform.kind, warnings) == (used, "mpet", [])
    np.testing.assert_allclose(transform.pcs_values(np.zeros((1, 3))), [[level, 0, 0]])


def test_a_lookup_table_stands_in_for_elements_that_are_not_evaluated(made_profile):
    profile = read_characterisation(made_profile({"D2B1": CALCULATOR, "A2B1": LUT}))
    transform, warnings = profile.transform("relative")
    assert transform.tag == "A2B1"
    assert "calc" in warnings[0]
    assert "A2B1" in warnings[1]


def test_without_a_stand_in_the_element_is_named(made_profile):
    with pytest.raises(UnsupportedProfileError, match="calc"):
        read_characterisation(made_profile({"D2B1": CALCULATOR})).transform("relative")


def test_another_intents_elements_stand_in_last(made_profile):
    transform, warnings = read_characterisation(made_profile({"D2B0": lab_tag(10)})).transform(
        "relative"
    )
    assert transform.tag == "D2B0"
    assert "D2B0" in warnings[0]


@pytest.mark.parametrize("space", ["RGB ", "3CLR", "nc\0\3"])
def test_iccmax_profiles_have_them_in_a2b_tags(made_profile, space):
    data = bytearray(
        made_profile({"A2B1": lab_tag(20), "A2B3": lab_tag(40)}, version=5, space=space)
    )
    profile = read_characterisation(bytes(data))
    assert len(profile.channels) == 3
    assert profile.inks == (space != "RGB ")
    assert profile.transform("relative")[0].tag == "A2B1"
    assert profile.transform("absolute")[0].absolute
    data[68:80] = struct.pack(">3i", *[round(v * 65536) for v in (0.9642, 1, 0.8249)])
    assert read_characterisation(bytes(data)).transform("relative")[0].tag == "A2B1"


def test_iccmax_profiles_of_other_conditions_are_named(made_profile):
    plain = made_profile({"A2B1": lab_tag(20)}, version=5)
    d65 = bytearray(plain)
    d65[68:80] = struct.pack(">3i", *[round(v * 65536) for v in (0.9505, 1, 1.0890)])
    spectral = plain[:20] + bytes(4) + plain[24:]
    ten_degrees = made_profile(
        {"A2B1": lab_tag(20), "svcn": b"svcn" + struct.pack(">II", 0, 2) + bytes(40)}, version=5
    )
    for data, named in (
        (bytes(d65), "illuminant"),
        (spectral, "spectra"),
        (ten_degrees, "observer"),
    ):
        with pytest.raises(UnsupportedProfileError, match=named):
            read_characterisation(data)
