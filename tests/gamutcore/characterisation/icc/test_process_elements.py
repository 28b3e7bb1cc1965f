from __future__ import annotations

import struct

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from gamutcore.characterisation.icc import icc_profile
from gamutcore.characterisation.icc.element import Element
from gamutcore.characterisation.icc.process_elements import (
    MAX_CHANNELS,
    MAX_ELEMENTS,
    process_elements_transform,
)
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError

POINTS = np.random.default_rng(0).random((50, 3))


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


def tag(inputs, outputs, *elements):
    head = struct.pack(">4sIHHI", b"mpet", 0, inputs, outputs, len(elements))
    start = len(head) + 8 * len(elements)
    table, body = b"", b""
    for one in elements:
        table += struct.pack(">II", start + len(body), len(one))
        body += one + bytes(-len(one) % 4)
    return head + table + body


def colours(data, channels=3, points=POINTS, pcs="XYZ"):
    return process_elements_transform(Element("D2B1", data), channels, pcs).pcs_values(points)


MATRIX = [[0.4, 0.3, 0.2], [0.2, 0.7, 0.1], [0.0, 0.1, 0.9]]


def test_curves_and_a_matrix():
    data = tag(
        3, 3, curve_set(3, *[gamma_curve(g) for g in (1.8, 2.0, 2.2)]), matrix(MATRIX, [0.1] * 3)
    )
    expected = (POINTS ** [1.8, 2.0, 2.2]) @ np.transpose(MATRIX) + 0.1
    np.testing.assert_allclose(colours(data), expected, atol=1e-6)


@pytest.mark.parametrize(("inputs", "outputs"), [(4, 3), (3, 5), (7, 3), (2, 1)])
def test_lookup_tables_are_interpolated_linearly(inputs, outputs):
    table = np.random.default_rng(1).random((*[3] * inputs, outputs)).astype(np.float32)
    last = np.random.default_rng(2).random((3, outputs))
    points = np.random.default_rng(3).random((40, inputs))
    found = colours(tag(inputs, 3, clut(table), matrix(last, [0, 0, 0])), inputs, points)
    axes = [np.linspace(0, 1, 3)] * inputs
    expected = RegularGridInterpolator(axes, table)(points) @ last.T
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_results_are_colours_without_an_encoding():
    # ICC.1:2022, 6.3.4.2: connection space values of D2Bx are L*, a*, b* themselves.
    data = tag(3, 3, matrix(np.zeros((3, 3)), [50.0, -20.0, 30.0]))
    np.testing.assert_allclose(colours(data, pcs="Lab"), np.tile([50, -20, 30], (50, 1)))


def test_markers_are_passed_through():
    plain = tag(3, 3, matrix(MATRIX, [0, 0, 0]))
    marked = tag(
        3, 3, element(b"bACS", 3, 3, bytes(4)), matrix(MATRIX, [0, 0, 0]),
        element(b"eACS", 3, 3, bytes(4)),
    )  # fmt: skip
    np.testing.assert_array_equal(colours(marked), colours(plain))


def test_channels_may_share_a_curve():
    curve = gamma_curve(2.0)
    shared = element(b"cvst", 3, 3, struct.pack(">6I", *[36, len(curve)] * 3) + curve)
    np.testing.assert_allclose(colours(tag(3, 3, shared)), POINTS**2, atol=1e-9)


@pytest.mark.parametrize(
    ("data", "channels"),
    [
        (tag(3, 3), 3),
        (tag(3, 3, matrix(MATRIX, [0, 0, 0])), 4),
        (tag(3, 1, matrix(np.zeros((1, 3)), [0])), 3),
        (tag(3, 3, matrix(np.zeros((4, 3)), [0] * 4)), 3),
        (tag(3, 3, matrix(np.zeros((4, 3)), [0] * 4), matrix(MATRIX, [0, 0, 0])), 3),
        (tag(3, 3, matrix(MATRIX, [0, 0, 0]))[:-8], 3),
        (tag(3, 3, matrix(MATRIX, [float("nan"), 0, 0])), 3),
        (tag(3, 3, clut(np.zeros((2, 2, 2, 3))))[:-12], 3),
        (tag(3, 3, clut(np.zeros((2, 1, 2, 3)))), 3),
        (tag(3, 3, element(b"clut", 3, 3, b"\xff" * 16 + bytes(64))), 3),
        (tag(3, 3, element(b"cvst", 3, 3, b"\xff" * 24)), 3),
        (b"text" + bytes(20), 3),
        (b"mpet", 3),
    ],
)
def test_broken_tags_are_refused(data, channels):
    with pytest.raises(MalformedProfileError) as caught:
        colours(data, channels, np.zeros((1, channels)))
    assert caught.value.where == {"tag": "D2B1"}


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (tag(3, 3, element(b"calc", 3, 3, bytes(40))), "calc"),
        (tag(3, 3, element(b"JtoX", 3, 3, bytes(40))), "JtoX"),
        (tag(3, 3, element(b"bACS", 3, 4, bytes(4))), "bACS"),
        (tag(3, 3, *[matrix(MATRIX, [0, 0, 0])] * (MAX_ELEMENTS + 1)), str(MAX_ELEMENTS + 1)),
        (tag(3, 3, matrix(np.zeros((MAX_CHANNELS + 1, 3)), [0] * (MAX_CHANNELS + 1))), "17"),
        (tag(3, 3, *[clut(np.zeros((2, 2, 2, 3)))] * 3), "lookup tables"),
    ],
)
def test_what_is_not_evaluated_is_named(data, named):
    with pytest.raises(UnsupportedProfileError, match=named) as caught:
        colours(data)
    assert caught.value.where == {"tag": "D2B1"}


def lab_tag(level):
    return tag(3, 3, matrix(np.zeros((3, 3)), [level, 0, 0]))


CALCULATOR = tag(3, 3, element(b"calc", 3, 3, bytes(40)))
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
    transform, warnings = icc_profile(made_profile(tags)).transform(intent)
    assert (transform.tag, transform.kind, warnings) == (used, "mpet", [])
    np.testing.assert_allclose(transform.pcs_values(np.zeros((1, 3))), [[level, 0, 0]])


def test_absolute_colours_have_a_tag_of_their_own(made_profile):
    profile = icc_profile(made_profile({"D2B1": lab_tag(20), "D2B3": lab_tag(40)}))
    transform, _ = profile.transform("absolute")
    assert (transform.tag, transform.absolute) == ("D2B3", True)
    transform, _ = icc_profile(made_profile({"D2B1": lab_tag(20)})).transform("absolute")
    assert (transform.tag, transform.absolute) == ("D2B1", False)


def test_a_lookup_table_stands_in_for_elements_that_are_not_evaluated(made_profile):
    profile = icc_profile(made_profile({"D2B1": CALCULATOR, "A2B1": LUT}))
    transform, warnings = profile.transform("relative")
    assert transform.tag == "A2B1"
    assert "calc" in warnings[0]
    assert "A2B1" in warnings[1]


def test_without_a_stand_in_the_element_is_named(made_profile):
    with pytest.raises(UnsupportedProfileError, match="calc"):
        icc_profile(made_profile({"D2B1": CALCULATOR})).transform("relative")


def test_another_intents_elements_stand_in_last(made_profile):
    transform, warnings = icc_profile(made_profile({"D2B0": lab_tag(10)})).transform("relative")
    assert transform.tag == "D2B0"
    assert "D2B0" in warnings[0]


@pytest.mark.parametrize("space", ["RGB ", "3CLR", "nc\0\3"])
def test_iccmax_profiles_have_them_in_a2b_tags(made_profile, space):
    data = bytearray(
        made_profile({"A2B1": lab_tag(20), "A2B3": lab_tag(40)}, version=5, space=space)
    )
    profile = icc_profile(bytes(data))
    assert len(profile.channels) == 3
    assert profile.inks == (space != "RGB ")
    assert profile.transform("relative")[0].tag == "A2B1"
    assert profile.transform("absolute")[0].absolute
    data[68:80] = struct.pack(">3i", *[round(v * 65536) for v in (0.9642, 1, 0.8249)])
    assert icc_profile(bytes(data)).transform("relative")[0].tag == "A2B1"


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
            icc_profile(data)
