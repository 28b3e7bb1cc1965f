"""Curves of ICC profiles, seen through a gray profile, whose Y is the curve itself."""

import struct

import numpy as np
import pytest

from gamutcore.characterisation import read_characterisation
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError


def curv(*samples):
    return struct.pack(f">4sII{len(samples)}H", b"curv", 0, len(samples), *samples)


def para(function, *parameters):
    fixed = [round(value * 65536) for value in parameters]
    return struct.pack(f">4sIHH{len(fixed)}i", b"para", 0, function, 0, *fixed)


@pytest.fixture
def values(made_profile):
    """Return a function that evaluates a curve."""

    def evaluate(data, x=X):
        profile = read_characterisation(made_profile({"kTRC": data}, space="GRAY", pcs="XYZ "))
        device = np.asarray(x, float)[:, np.newaxis]
        return profile.transform("relative")[0].pcs_values(device)[:, 1]

    return evaluate


X = np.linspace(0, 1, 101)


def test_one_sample_is_an_exponent(values):
    # u8Fixed8Number: 0233h is 2.19921875, the exponent of Adobe RGB (1998).
    np.testing.assert_allclose(values(curv(0x0233)), X**2.19921875)


def test_samples_are_joined_by_lines_and_end_at_their_ends(values):
    x = np.array([-1, 0, 0.25, 0.5, 0.75, 1, 2])
    np.testing.assert_allclose(
        values(curv(0, 32767, 65535), x) * 65535,
        [0, 0, 16383.5, 32767, 49151, 65535, 65535],
    )


@pytest.mark.parametrize(
    ("element", "formula"),
    [
        (para(0, 2.5), lambda x: x**2.5),
        (para(1, 2, 2, -0.5), lambda x: max(2 * x - 0.5, 0) ** 2),
        (para(2, 2, 2, -0.5, 0.25), lambda x: max(2 * x - 0.5, 0) ** 2 + 0.25),
        (para(3, 2, 1, 0, 0.5, 0.25), lambda x: x**2 if x >= 0.25 else 0.5 * x),
        (
            para(4, 2, 1, 0, 0.5, 0.25, 0.125, 0.0625),
            lambda x: x**2 + 0.125 if x >= 0.25 else 0.5 * x + 0.0625,
        ),
    ],
)
def test_parametric_functions_are_those_of_the_specification(values, element, formula):
    np.testing.assert_allclose(values(element), [min(formula(x), 1) for x in X], atol=1e-12)


@pytest.mark.parametrize(
    "element",
    [curv(), curv(0x0233), curv(0, 9, 65535), para(0, 0.5), para(4, 2, 2, -1, 3, 0.5, 0.1, -0.2)],
)
def test_curves_have_the_domain_and_range_0_to_1(values, element):
    # ICC.1:2022, 10.6 and 10.18: values outside are clipped.
    x = np.array([-1e9, -0.1, 0, 1, 1.1, 1e9])
    y = values(element, x)
    np.testing.assert_array_equal(y, values(element, np.clip(x, 0, 1)))
    assert ((y >= 0) & (y <= 1)).all()


LIGHTS = np.linspace(0.05, 1, 20)


def formula(function, *parameters):
    return struct.pack(f">4sIHH{len(parameters)}f", b"parf", 0, function, 0, *parameters)


def sampled(*samples):
    return struct.pack(f">4sII{len(samples)}f", b"samf", 0, len(samples), *samples)


def curve(breaks, *segments):
    head = struct.pack(f">4sIHH{len(breaks)}f", b"curf", 0, len(segments), 0, *breaks)
    return head + b"".join(segments)


@pytest.mark.parametrize(
    ("segment", "expected"),
    [
        # ICC.1:2022, table 60.
        (formula(0, 2.0, 0.5, 0.25, 0.125), (0.5 * LIGHTS + 0.25) ** 2 + 0.125),
        (formula(1, 2.0, 0.5, 3.0, 1.0, 0.25), 0.5 * np.log10(3 * LIGHTS**2 + 1) + 0.25),
        (formula(2, 0.5, 2.0, 3.0, 1.0, 0.25), 0.5 * 2 ** (3 * LIGHTS + 1) + 0.25),
        # ICC.2:2023, table 111.
        (formula(3, 2.0, 4.0, 0.5, 0.25, 0.125), 4 * (0.5 * LIGHTS + 0.25) ** 2 + 0.125),
        (formula(4, 2.0, 0.5, -1.0, 0.25, 3.0), 0.5 * np.log(3 * LIGHTS**2 + 1) + 0.25),
        (formula(5, 2.0, 0.5, 0.25, 1.0, 3.0, 2.0), 2 * np.exp((3 * LIGHTS**2 - 1) / 0.5) + 0.25),
        (
            formula(6, 3.0, 2.0, 0.25, 2.0, 0.5, 4.0, 1.5),
            4 * (np.maximum(1.5 * LIGHTS**2 - 0.25, 0) / (2 - 0.5 * LIGHTS**2)) ** 3,
        ),
        (
            formula(7, 3.0, 2.0, 0.25, 2.0, 0.5, 4.0),
            4 * ((0.25 + 2 * LIGHTS**2) / (1 + 0.5 * LIGHTS**2)) ** 3,
        ),
    ],
)
def test_formulas_are_those_of_the_specifications(values, segment, expected):
    np.testing.assert_allclose(values(curve([], segment), LIGHTS), expected, rtol=1e-12)


def test_the_perceptual_quantizer_is_a_formula_of_type_6(values):
    # SMPTE ST 2084:2014, equation 4.1: 10,000 cd/m² is 1, and 100 cd/m² is 0.508078.
    m1, m2 = 2610 / 16384, 2523 / 4096 * 128
    c1, c2, c3 = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32
    data = curve([], formula(6, 1 / m1, 1 / m2, c1, c2, c3, 1.0, 1.0))
    np.testing.assert_allclose(values(data, [1.0, 0.508078]), [1.0, 0.01], rtol=2e-5)


def test_a_break_point_belongs_to_the_segment_that_ends_there(values):
    data = curve([0.5], formula(0, 1.0, 1.0, 0.0, 0.0), formula(0, 1.0, 1.0, 10.0, 0.0))
    np.testing.assert_allclose(values(data, [0.25, 0.5, 0.75]), [0.25, 0.5, 10.75])


def test_samples_begin_with_the_end_of_the_segment_before(values):
    # The first sample, at the break point, is not in the file (ICC.1:2022, 10.18.3.4).
    line = formula(0, 1.0, 1.0, 0.0, 0.0)
    data = curve([0.0, 1.0], line, sampled(1.0, 0.5), line)
    x = [-1.0, 0.0, 0.25, 0.5, 0.75, 1.0, 2.0]
    np.testing.assert_allclose(values(data, x), [-1, 0, 0.5, 1, 0.75, 0.5, 2])


def test_a_negative_base_has_whole_powers_only(values):
    data = curve([], formula(0, 2.0, 1.0, -1.0, 0.0))
    np.testing.assert_allclose(values(data, [0.0, 0.5]), [1, 0.25])
    data = curve([], formula(0, 0.5, 1.0, -1.0, 0.0))
    np.testing.assert_allclose(values(data, [0.0, 0.5]), [0, 0])


LINE = formula(0, 1.0, 1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "data",
    [
        para(5, 1),
        para(3, 1, 1),
        b"curv" + bytes(4) + b"\xff\xff\xff\xff" + bytes(8),
        b"curv" + bytes(4) + b"\0\0\0\x03" + bytes(4),
        b"text" + bytes(40),
        b"cu",
        curve([], LINE)[:-1],
        curve([])[:12],
        curve([0.5, 0.5], LINE, LINE, LINE),
        curve([float("nan")], LINE, LINE),
        curve([0.5], sampled(0.0, 1.0), LINE),
        curve([0.5], LINE, sampled(0.0, 1.0)),
        curve([0.0, 1.0], LINE, sampled(), LINE),
        curve([0.0, 1.0], LINE, b"samf" + bytes(4) + b"\xff" * 4, b""),
    ],
)
def test_broken_curves_are_refused(values, data):
    with pytest.raises(MalformedProfileError) as caught:
        values(data)
    assert caught.value.where == {"tag": "kTRC"}


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (curve([], b"sngf" + bytes(40)), "sngf"),
        (curve([], formula(8, 1.0)), "8"),
        (curve([], b"xxxx" + bytes(20)), "xxxx"),
        (curve([0.0] * 256, *[LINE] * 257), "257"),
    ],
)
def test_other_kinds_of_segments_are_named(values, data, named):
    with pytest.raises(UnsupportedProfileError, match=named) as caught:
        values(data)
    assert caught.value.where == {"tag": "kTRC"}
