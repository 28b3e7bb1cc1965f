"""Colours of pictures, and values for colours, against profiles, published figures and a search."""

from pathlib import Path

import numpy as np
import pytest

from gamutcore.characterisation import Picture, read_characterisation
from gamutcore.characterisation.pictures.encoding import (
    ADOBE_RGB,
    LINEAR,
    SRGB,
    code_point_encoding,
)
from gamutcore.colours import colours_in_space, find_values, surface_colours
from gamutcore.colours.picture import ACCURACY
from gamutcore.colours.spaces import ColourSpace
from gamutcore.errors import OptionError

DATA = Path(__file__).parents[2] / "data"


def picture(values, meaning, model="RGB", counts=None):
    values = np.asarray(values, float)
    counts = np.ones(len(values), np.int64) if counts is None else np.asarray(counts)
    return Picture("png", model, values, counts, meaning, {"format": "png"})


def profile(name):
    return read_characterisation((DATA / f"{name}.icc").read_bytes())


def test_values_that_a_profile_clips_are_told():
    values = np.array([[0.5, 0.5, 0.5], [-0.1, 0.5, 0.5], [0.5, 1.1, 0.5]])
    found = surface_colours(picture(values, profile("DisplayP3-v4")))
    assert any(
        "2 of 3 colours have values outside 0 to 1" in said for said in found.provenance["warnings"]
    )
    clipped = surface_colours(picture(values.clip(0, 1), profile("DisplayP3-v4")))
    np.testing.assert_array_equal(found.points, clipped.points)
    assert clipped.provenance["warnings"] == []


@pytest.mark.parametrize(
    ("encoding", "name", "folder"),
    [
        (SRGB, "sRGB-v4", None),
        (code_point_encoding(12, 13), "DisplayP3-v4", None),
        (ADOBE_RGB, "AdobeCompat-v2", "spaces"),
    ],
)
def test_encodings_agree_with_the_profiles_of_their_names(encoding, name, folder, request):
    """Compact ICC profiles have rounded numbers and curves; the darkest colours are excluded."""
    if folder is None:
        reference = profile(name)
    else:
        shared = request.getfixturevalue("shared_data")
        reference = read_characterisation((shared / folder / f"{name}.icc").read_bytes())
    values = np.random.default_rng(0).random((500, 3)) * 0.9 + 0.1
    found = surface_colours(picture(values, encoding)).points
    wanted = surface_colours(picture(values, reference)).points
    assert np.linalg.norm(found - wanted, axis=1).max() < 0.3


def test_white_is_white_and_gray_is_neutral():
    for encoding in (SRGB, LINEAR, ADOBE_RGB, code_point_encoding(11, 17)):
        lab = surface_colours(picture([[1.0], [0.5]], encoding, "gray")).points
        np.testing.assert_allclose(lab[0], [100, 0, 0], atol=0.01)
        np.testing.assert_allclose(lab[1, 1:], 0, atol=0.01)


def test_srgb_mid_gray():
    """IEC 61966-2-1: 0.5 is the light 0.2140; CIE 15: L* 116 · 0.2140^(1/3) − 16 = 53.39."""
    lab = surface_colours(picture([[0.5]], SRGB, "gray")).points
    np.testing.assert_allclose(lab[0, 0], 53.39, atol=0.01)


CORNERS = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
SRGB_TO_XYZ = np.array(  # IEC 61966-2-1, 5.2
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)


@pytest.mark.parametrize(
    "adaptation", ["Bradford", "CAT02", "CAT16", "von-Kries", "XYZ-scaling", "none"]
)
def test_in_a_space_of_its_white_a_picture_has_its_own_tristimulus_values(adaptation):
    """The adaptation to D50 is undone by the same adaptation."""
    space = ColourSpace("CIEXYZ", "D65", adaptation)
    found = surface_colours(picture(CORNERS, SRGB), adaptation=adaptation)
    np.testing.assert_allclose(
        colours_in_space(found, space).points, CORNERS @ SRGB_TO_XYZ.T, atol=2e-4
    )


def test_absolute_colours_are_the_encodings_own():
    found = surface_colours(picture(CORNERS, SRGB), intent="absolute")
    xyz = colours_in_space(found, ColourSpace("CIEXYZ", "D65"))
    np.testing.assert_allclose(xyz.points, CORNERS @ SRGB_TO_XYZ.T, atol=2e-4)
    assert xyz.provenance["colour_space"]["adaptation"].startswith("none")
    white = colours_in_space(found, ColourSpace("Oklab")).points[-1]
    np.testing.assert_allclose(white, [1, 0, 0], atol=2e-4)


def test_the_adaptation_is_in_the_provenance():
    def said(adaptation):
        found = surface_colours(picture(CORNERS, SRGB), adaptation=adaptation)
        return found.provenance["adaptation"]

    assert said("CAT16") == "CAT16 from the encoding's white to D50"
    assert said("none") == "none, as asked"


def test_pq_and_hlg_put_white_at_203_cd_per_m2():
    """ITU-R BT.2408, table 1: 58 % of PQ and 75 % of HLG are 203 cd/m²."""
    for transfer, signal in ((16, 0.5807), (18, 0.75)):
        encoding = code_point_encoding(9, transfer)
        lab = surface_colours(picture([[signal]], encoding, "gray")).points
        np.testing.assert_allclose(lab[0], [100, 0, 0], atol=0.3)


def test_pq_reaches_ten_thousand():
    """SMPTE ST 2084: full scale is 10 000 cd/m², L* 116 · (10000/203)^(1/3) − 16."""
    lab = surface_colours(picture([[1.0]], code_point_encoding(9, 16), "gray")).points
    np.testing.assert_allclose(lab[0, 0], 116 * (10_000 / 203) ** (1 / 3) - 16, rtol=1e-6)


def test_gray_with_an_rgb_profile_is_equal_values():
    reference = profile("sRGB-v4")
    found = surface_colours(picture([[0.2], [0.7]], reference, "gray")).points
    wanted = surface_colours(picture([[0.2] * 3, [0.7] * 3], reference)).points
    np.testing.assert_array_equal(found, wanted)


@pytest.mark.parametrize("meaning", [SRGB, None])
@pytest.mark.parametrize("intent", ["perceptual", "saturation"])
def test_intents_of_profiles_need_one(meaning, intent):
    model = "RGB" if meaning else "Lab"
    with pytest.raises(OptionError) as caught:
        surface_colours(picture([[0.5, 0.5, 0.5]], meaning, model), intent=intent)
    assert caught.value.where == {"field": "intent"}


def test_cielab_has_no_absolute_colours_beside_itself():
    with pytest.raises(OptionError) as caught:
        surface_colours(picture([[50.0, 10, -20]], None, "Lab"), intent="absolute")
    assert caught.value.where == {"field": "intent"}


CELL = 2.0
"""Cells of colours that are counted together, in L*, a* and b*."""


@pytest.mark.parametrize(
    ("share", "left"),
    [
        (0.004, [1, 9, 10, 30, 50, 100]),
        (0.005, [9, 10, 30, 50, 100]),  # 1 pixel of 200
        (0.05, [10, 30, 50, 100]),  # 1 + 9
        (0.0999, [10, 30, 50, 100]),
        (0.1, [30, 50, 100]),  # 1 + 9 + 10
        (0.3, [50, 100]),
        (0.99, [100]),
    ],
)
def test_the_least_used_colours_go_first(share, left):
    counts = np.array([30, 9, 100, 1, 50, 10])
    lab = np.array([[50.0 + CELL * (n + 0.5), 0.5, 0.5] for n in range(len(counts))])
    found = surface_colours(picture(lab, None, "Lab", counts), popularity=share)
    np.testing.assert_array_equal(found.points, lab[np.isin(counts, left)])
    assert found.provenance["popularity"] == {
        "asked": share,
        "left_out": round(1 - sum(left) / 200, 6),
        "cell": CELL,
        "cells": {"used": 6, "left_out": 6 - len(left)},
    }


@pytest.mark.parametrize(
    ("model", "values", "channels"),
    [
        ("RGB", np.eye(3), ("R", "G", "B")),
        ("gray", [[0.0], [0.5]], ("gray",)),
        ("RGB", [[0, 0, 1.5]], ()),  # floats have what no device is told
        ("Lab", [[0.5, 0.5, 0.5]], ()),
    ],
)
def test_values_of_pixels_are_device_values(model, values, channels):
    found = surface_colours(picture(values, None if model == "Lab" else SRGB, model))
    assert found.channels == channels
    if channels:
        np.testing.assert_array_equal(found.device, values)
    else:
        assert found.device is None


def test_device_values_are_of_the_colours_that_are_left():
    found = surface_colours(picture(np.eye(3), SRGB, counts=[90, 100, 1]), popularity=0.05)
    np.testing.assert_array_equal(found.device, np.eye(3)[:2])


def forward(encoding):
    def colours(values):
        once = np.ones(len(values), np.int64)
        return surface_colours(Picture("png", "RGB", values, once, encoding)).points

    return colours


@pytest.mark.parametrize("codes", [(1, 13), (12, 13), (9, 16), (9, 18), (1, 4), (1, 8)])
def test_the_values_of_colours_are_found_from_other_values(codes):
    """sRGB, Display P3, PQ, HLG, a power and linear light."""
    colours = forward(code_point_encoding(*codes))
    random = np.random.default_rng(1)
    values = random.uniform(0.02, 1, (500, 3))
    start = np.clip(values + random.uniform(-0.2, 0.2, values.shape), 0, 1)
    found, distance = find_values(colours(values), start, colours)
    assert distance.max() <= ACCURACY
    # dark values of one channel hardly matter beside bright ones of the others
    np.testing.assert_allclose(found, values, atol=5e-4)


def test_colours_outside_get_the_nearest_of_the_range():
    colours = forward(SRGB)
    wanted = np.array([[60.0, 110, 0], [90, -120, 40], [40, 40, -130], [105, 0, 0]])
    found, distance = find_values(wanted, np.full((4, 3), 0.5), colours)
    assert found.min() >= 0
    assert found.max() <= 1
    grid = colours(np.array(list(np.ndindex(41, 41, 41))) / 40)
    nearest = np.linalg.norm(grid[:, np.newaxis] - wanted, axis=2).min(axis=0)
    assert (distance <= nearest + 1e-6).all()


def test_no_colours():
    found, distance = find_values(np.empty((0, 3)), np.empty((0, 3)), forward(SRGB))
    assert len(found) == len(distance) == 0
