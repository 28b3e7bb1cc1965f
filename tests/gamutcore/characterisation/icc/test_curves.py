from __future__ import annotations

import struct

import numpy as np
import pytest

from gamutcore.characterisation.icc.curves import PARAMETER_COUNTS, curve_at
from gamutcore.characterisation.icc.element import Element
from gamutcore.errors import MalformedProfileError

X = np.linspace(0, 1, 101)


def curv(*samples):
    return Element("rTRC", struct.pack(f">4sII{len(samples)}H", b"curv", 0, len(samples), *samples))


def para(function, *parameters):
    fixed = [round(value * 65536) for value in parameters]
    data = struct.pack(f">4sIHH{len(fixed)}i", b"para", 0, function, 0, *fixed)
    return Element("rTRC", data)


def values(element, x=X):
    curve, length = curve_at(element)
    assert length == len(element.data)
    return curve.values(x)


def test_no_samples_are_the_identity():
    np.testing.assert_array_equal(values(curv()), X)


def test_one_sample_is_an_exponent():
    # u8Fixed8Number: 0233h is 2.19921875, the exponent of Adobe RGB (1998).
    np.testing.assert_allclose(values(curv(0x0233)), X**2.19921875)


def test_samples_are_joined_by_lines_and_end_at_their_ends():
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
def test_parametric_functions_are_those_of_the_specification(element, formula):
    np.testing.assert_allclose(values(element), [min(formula(x), 1) for x in X], atol=1e-12)


@pytest.mark.parametrize(
    "element",
    [curv(), curv(0x0233), curv(0, 9, 65535), para(0, 0.5), para(4, 2, 2, -1, 3, 0.5, 0.1, -0.2)],
)
def test_curves_have_the_domain_and_range_0_to_1(element):
    # ICC.1:2022, 10.6 and 10.18: values outside are clipped.
    x = np.array([-1e9, -0.1, 0, 1, 1.1, 1e9])
    y = values(element, x)
    np.testing.assert_array_equal(y, values(element, np.clip(x, 0, 1)))
    assert ((y >= 0) & (y <= 1)).all()


def test_srgb_as_a_parametric_curve():
    # IEC 61966-2-1: 0.5 decodes to 0.21404.
    element = para(3, 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)
    np.testing.assert_allclose(
        values(element, np.array([0.5, 0.02])), [0.21404, 0.001548], atol=2e-5
    )


@pytest.mark.parametrize("function", range(5))
def test_hostile_parameters_do_not_fail(function):
    count = PARAMETER_COUNTS[function]
    for value in (-32768, 32767.99, 0):
        with np.errstate(all="ignore"):
            assert curve_at(para(function, *[value] * count))[0].values(X).shape == X.shape


@pytest.mark.parametrize(
    "element",
    [
        para(5, 1),
        para(3, 1, 1),
        Element("rTRC", b"curv" + bytes(4) + b"\xff\xff\xff\xff" + bytes(8)),
        Element("rTRC", b"curv" + bytes(4) + b"\0\0\0\x03" + bytes(4)),
        Element("rTRC", b"text" + bytes(40)),
        Element("rTRC", b"cu"),
    ],
)
def test_broken_curves_are_refused(element):
    with pytest.raises(MalformedProfileError) as caught:
        curve_at(element)
    assert caught.value.where == {"tag": "rTRC"}
