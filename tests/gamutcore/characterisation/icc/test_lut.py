from __future__ import annotations

import struct
from itertools import product

import numpy as np
import pytest

from gamutcore.characterisation.icc.element import Element
from gamutcore.characterisation.icc.lut import lut_transform
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError

MATRIX = struct.pack(">9i", *[round(v * 65536) for v in (0, 1, 0, 0, 0, 1, 1, 0, 0)])
IDENTITY = b"curv" + bytes(8)
POINTS = np.random.default_rng(0).random((50, 3))


def lut16(inputs=3, *, grid=2, nodes=None, tables=(0, 65535), matrix=MATRIX):
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
    head = struct.pack(">4sIBBBB", b"mft1", 0, 3, 3, 2, 0) + MATRIX
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
        put("matrix", MATRIX + struct.pack(">3i", 0, 0, 6554))
        put("m", IDENTITY * 3)
    if grid:
        put("a", IDENTITY * len(nodes))
        full = 255 if size == 1 else 65535
        flat = [int(full * v) for corner in product((0, 1), repeat=len(nodes)) for v in corner[:3]]
        clut = bytes(nodes) + bytes(16 - len(nodes)) + bytes([size, 0, 0, 0])
        put("clut", clut + struct.pack(f">{len(flat)}{'BH'[size - 1]}", *flat))
    order = [offsets.get(name, 0) for name in ("b", "matrix", "m", "clut", "a")]
    return struct.pack(">4sIBBH5I", b"mAB ", 0, len(nodes), 3, 0, *order) + body


def colours(data, *, channels=3, pcs="Lab", points=POINTS):
    return lut_transform(Element("A2B1", data), channels, pcs).pcs_values(points)


def test_lut16_has_the_legacy_encoding_of_lab():
    # ICC.1:2022, table 43: FF00h is L* 100; 8000h is a* 0, FF00h is a* 127.
    white = colours(lut16(nodes=[(0xFF00, 0x8000, 0x8000)] * 8))
    np.testing.assert_allclose(white, np.tile([100, 0, 0], (50, 1)), atol=1e-9)
    most = colours(lut16(nodes=[(0xFF00, 0xFF00, 0)] * 8))
    np.testing.assert_allclose(most, np.tile([100, 127, -128], (50, 1)), atol=1e-9)


def test_lut8_and_lut_a_to_b_have_lab_at_full_scale():
    expected = POINTS * [100, 255, 255] - [0, 128, 128]
    np.testing.assert_allclose(colours(lut8()), expected, atol=1e-9)
    np.testing.assert_allclose(colours(lut_a_to_b(m=False)), expected, atol=1e-9)
    np.testing.assert_allclose(colours(lut_a_to_b(m=False, size=1)), expected, atol=1e-9)


def test_xyz_has_1_at_half_scale():
    # ICC.1:2022, table 12: 8000h is 1.0.
    half = colours(lut16(nodes=[(0x8000,) * 3] * 8), pcs="XYZ")
    np.testing.assert_allclose(half, 1, atol=1e-9)


def test_the_matrix_of_lut16_is_not_applied_to_device_values():
    identity = struct.pack(">9i", *[65536 * v for v in (1, 0, 0, 0, 1, 0, 0, 0, 1)])
    np.testing.assert_array_equal(colours(lut16()), colours(lut16(matrix=identity)))


def test_the_matrix_of_lut_a_to_b_is_applied():
    turned = np.minimum(POINTS[:, [1, 2, 0]] + [0, 0, 6554 / 65536], 1)
    expected = turned * [100, 255, 255] - [0, 128, 128]
    np.testing.assert_allclose(colours(lut_a_to_b()), expected, atol=1e-9)
    np.testing.assert_allclose(colours(lut_a_to_b(grid=False)), expected, atol=1e-9)


def test_tables_come_before_and_after_the_grid():
    squared = [round(65535 * (i / 255) ** 2) for i in range(256)]
    points = np.round(POINTS * 255) / 255
    plain = colours(lut16(tables=(0, 65535)), pcs="XYZ", points=points)
    curved = colours(lut16(tables=squared), pcs="XYZ", points=points)
    scale = 1 + 32767 / 32768
    np.testing.assert_allclose(curved / scale, (plain / scale) ** 4, atol=2e-3)


@pytest.mark.parametrize("channels", [1, 2, 4, 7])
def test_other_numbers_of_channels(channels):
    nodes = [(sum(c), 0, 0) for c in product((0, 65535 // channels), repeat=channels)]
    points = np.random.default_rng(1).random((20, channels))
    lab = colours(lut16(channels, nodes=nodes), channels=channels, points=points)
    expected = points.mean(axis=1) * (65535 // channels * channels) / 65280 * 100
    np.testing.assert_allclose(lab[:, 0], expected, atol=1e-9)


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
def test_broken_tables_are_refused(data, channels):
    with pytest.raises(MalformedProfileError) as caught:
        lut_transform(Element("A2B0", data), channels, "Lab")
    assert caught.value.where == {"tag": "A2B0"}


def test_multi_process_elements_are_named_as_unsupported():
    with pytest.raises(UnsupportedProfileError, match="mpet"):
        lut_transform(Element("A2B0", b"mpet" + bytes(40)), 3, "Lab")


def test_colours_that_are_not_finite_are_refused():
    infinite = b"para" + bytes(4) + struct.pack(">HHi", 0, 0, -65536)
    data = lut_a_to_b(grid=False, m=False)[:32] + infinite * 3
    with pytest.raises(MalformedProfileError, match="finite"):
        colours(data, points=np.zeros((1, 3)))
