"""Volumes of both intents, and of sRGB in every space."""

import numpy as np
import pytest

from gamutcore import Gamut, reference
from gamutcore.colours.gamut_colours import srgb_volume
from gamutcore.colours.spaces import ColourSpace

SRGB_IN_LAB = 832870
"""Cubic ΔE*ab: Lindbloom, RGB Working Space Information, brucelindbloom.com."""


def test_srgb_in_cielab_is_the_published_volume():
    assert srgb_volume(ColourSpace("CIELAB")) == pytest.approx(SRGB_IN_LAB, rel=5e-4)


def test_srgb_in_ciexyz_is_the_determinant_of_its_primaries():
    space = ColourSpace("CIEXYZ", reference_white="D65")
    xyz = [(0.64, 0.33, 0.2126), (0.30, 0.60, 0.7152), (0.15, 0.06, 0.0722)]  # IEC 61966-2-1
    columns = [(x / y * Y, Y, (1 - x - y) / y * Y) for x, y, Y in xyz]
    assert srgb_volume(space) == pytest.approx(abs(np.linalg.det(columns)), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("space", ["CIELAB", "Oklab", "CAM16-UCS", "ITP"])
def test_a_reference_is_once_srgb(space):
    volumes = reference("srgb", space=space, surface_samples=50_000).description["volumes"]
    assert volumes["relative"]["times_srgb"] == pytest.approx(1, abs=1.5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("space", ["CIELAB", "CAM16-UCS"])
def test_the_other_intent_has_the_volume_of_its_own_build(fogra39, space):
    relative, absolute = (
        Gamut(fogra39, surface_samples=5000, space=space, intent=intent)
        for intent in ("relative", "absolute")
    )
    for intent, built in (("relative", relative), ("absolute", absolute)):
        for gamut in (relative, absolute):
            found = gamut.description["volumes"][intent]
            assert found["volume"] == pytest.approx(built.volume, rel=1e-3)
            ratio = found["volume"] / gamut.description["volumes"]["srgb"]
            assert found["times_srgb"] == pytest.approx(ratio, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("source", "space"), [("profile", "CIELAB"), ("reference", "Oklab")])
def test_the_own_white_of_a_display(small_profile, source, space):
    """The surface of the cube is used, because hulls differ from one space to another."""
    data = small_profile("sRGB-v2-magic.icc")
    options = {"space": space, "boundary": "device-surface", "surface_samples": 20_000}
    relative, absolute = (
        Gamut(data, intent=intent, **options)
        if source == "profile"
        else reference("srgb", intent=intent, **options)
        for intent in ("relative", "absolute")
    )
    for intent, built in (("relative", relative), ("absolute", absolute)):
        for gamut in (relative, absolute):
            found = gamut.description["volumes"][intent]["volume"]
            assert found == pytest.approx(built.volume, rel=1e-4)


def test_bare_colours_have_one_volume():
    cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]  # noqa: E741
    volumes = Gamut(cube).description["volumes"]
    assert set(volumes) == {"srgb", "own"}
    assert volumes["own"]["times_srgb"] == pytest.approx(8000 / SRGB_IN_LAB, rel=1e-3)
