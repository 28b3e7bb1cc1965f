from __future__ import annotations

import struct

import numpy as np
import pytest

from gamutcore.characterisation.icc.curves import curve_at
from gamutcore.characterisation.icc.element import Element
from gamutcore.characterisation.icc.segments import MAX_SEGMENTS, segmented_curve_at
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError

X = np.linspace(0.05, 1, 20)


def formula(function, *parameters):
    return struct.pack(f">4sIHH{len(parameters)}f", b"parf", 0, function, 0, *parameters)


def sampled(*samples):
    return struct.pack(f">4sII{len(samples)}f", b"samf", 0, len(samples), *samples)


def curve(breaks, *segments):
    head = struct.pack(f">4sIHH{len(breaks)}f", b"curf", 0, len(segments), 0, *breaks)
    return head + b"".join(segments)


def values(data, x=X):
    found, length = segmented_curve_at(Element("D2B1", data))
    assert length == len(data)
    return found.values(np.asarray(x, dtype=np.float64))


@pytest.mark.parametrize(
    ("segment", "expected"),
    [
        # ICC.1:2022, table 60.
        (formula(0, 2.0, 0.5, 0.25, 0.125), (0.5 * X + 0.25) ** 2 + 0.125),
        (formula(1, 2.0, 0.5, 3.0, 1.0, 0.25), 0.5 * np.log10(3 * X**2 + 1) + 0.25),
        (formula(2, 0.5, 2.0, 3.0, 1.0, 0.25), 0.5 * 2 ** (3 * X + 1) + 0.25),
        # ICC.2:2023, table 111.
        (formula(3, 2.0, 4.0, 0.5, 0.25, 0.125), 4 * (0.5 * X + 0.25) ** 2 + 0.125),
        (formula(4, 2.0, 0.5, -1.0, 0.25, 3.0), 0.5 * np.log(3 * X**2 + 1) + 0.25),
        (formula(5, 2.0, 0.5, 0.25, 1.0, 3.0, 2.0), 2 * np.exp((3 * X**2 - 1) / 0.5) + 0.25),
        (
            formula(6, 3.0, 2.0, 0.25, 2.0, 0.5, 4.0, 1.5),
            4 * (np.maximum(1.5 * X**2 - 0.25, 0) / (2 - 0.5 * X**2)) ** 3,
        ),
        (
            formula(7, 3.0, 2.0, 0.25, 2.0, 0.5, 4.0),
            4 * ((0.25 + 2 * X**2) / (1 + 0.5 * X**2)) ** 3,
        ),
    ],
)
def test_formulas_are_those_of_the_specifications(segment, expected):
    np.testing.assert_allclose(values(curve([], segment)), expected, rtol=1e-12)


def test_the_perceptual_quantizer_is_a_formula_of_type_6():
    # SMPTE ST 2084:2014, equation 4.1: 10,000 cd/m² is 1, and 100 cd/m² is 0.508078.
    m1, m2 = 2610 / 16384, 2523 / 4096 * 128
    c1, c2, c3 = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32
    data = curve([], formula(6, 1 / m1, 1 / m2, c1, c2, c3, 1.0, 1.0))
    np.testing.assert_allclose(values(data, [1.0, 0.508078]), [1.0, 0.01], rtol=2e-5)


def test_a_break_point_belongs_to_the_segment_that_ends_there():
    data = curve([0.5], formula(0, 1.0, 1.0, 0.0, 0.0), formula(0, 1.0, 1.0, 10.0, 0.0))
    np.testing.assert_allclose(values(data, [0.25, 0.5, 0.75]), [0.25, 0.5, 10.75])


def test_samples_begin_with_the_end_of_the_segment_before():
    # The first sample, at the break point, is not in the file (ICC.1:2022, 10.18.3.4).
    line = formula(0, 1.0, 1.0, 0.0, 0.0)
    data = curve([0.0, 1.0], line, sampled(1.0, 0.5), line)
    x = [-1.0, 0.0, 0.25, 0.5, 0.75, 1.0, 2.0]
    np.testing.assert_allclose(values(data, x), [-1, 0, 0.5, 1, 0.75, 0.5, 2])


def test_a_negative_base_has_whole_powers_only():
    data = curve([], formula(0, 2.0, 1.0, -1.0, 0.0))
    np.testing.assert_allclose(values(data, [0.0, 0.5]), [1, 0.25])
    data = curve([], formula(0, 0.5, 1.0, -1.0, 0.0))
    np.testing.assert_allclose(values(data, [0.0, 0.5]), [0, 0])


def test_they_may_stand_wherever_a_curve_stands():
    found, _ = curve_at(Element("rTRC", curve([], formula(0, 2.0, 1.0, 0.0, 0.0))))
    np.testing.assert_allclose(found.values(X), X**2)


@pytest.mark.parametrize(
    "data",
    [
        curve([], formula(0, 1.0, 1.0, 0.0, 0.0))[:-1],
        curve([])[:12],
        curve([0.5, 0.5], *[formula(0, 1.0, 1.0, 0.0, 0.0)] * 3),
        curve([float("nan")], *[formula(0, 1.0, 1.0, 0.0, 0.0)] * 2),
        curve([0.5], sampled(0.0, 1.0), formula(0, 1.0, 1.0, 0.0, 0.0)),
        curve([0.5], formula(0, 1.0, 1.0, 0.0, 0.0), sampled(0.0, 1.0)),
        curve([0.0, 1.0], formula(0, 1.0, 1, 0, 0), sampled(), formula(0, 1.0, 1, 0, 0)),
        curve([0.0, 1.0], formula(0, 1.0, 1, 0, 0), b"samf" + bytes(4) + b"\xff" * 4, b""),
    ],
)
def test_broken_curves_are_refused(data):
    with pytest.raises(MalformedProfileError) as caught:
        segmented_curve_at(Element("D2B1", data))
    assert caught.value.where == {"tag": "D2B1"}


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (b"sngf" + bytes(40), "sngf"),
        (curve([], formula(8, 1.0)), "8"),
        (curve([], b"xxxx" + bytes(20)), "xxxx"),
        (curve([0.0] * MAX_SEGMENTS, *[formula(0, 1, 1, 0, 0)] * (MAX_SEGMENTS + 1)), "257"),
    ],
)
def test_other_kinds_are_named(data, named):
    with pytest.raises(UnsupportedProfileError, match=named) as caught:
        segmented_curve_at(Element("D2B1", data))
    assert caught.value.where == {"tag": "D2B1"}
