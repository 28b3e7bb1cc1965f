"""Colours of reference gamuts: matrices, curves, adaptation."""

import numpy as np
import pytest

from gamutcore.colours.reference_colours import (
    RGB_CURVES,
    decode_rgb,
    encode_rgb,
    primary_matrix,
    reference_lab,
    reference_white,
    rgb_xyz,
    surface_xyz,
)
from gamutcore.errors import OptionError
from gamutcore.references import REFERENCES

RGB = [each for each in REFERENCES.values() if each.kind == "rgb"]


@pytest.mark.parametrize("curve", [*RGB_CURVES, 1.0, 2.2, 563 / 256])
def test_encoding_inverts_decoding(curve):
    values = np.linspace(0, 1, 1001)
    # the published constants of the linear parts are rounded, so the parts do not quite meet
    np.testing.assert_allclose(encode_rgb(decode_rgb(values, curve), curve), values, atol=3e-4)
    assert (np.diff(decode_rgb(values, curve)) > -1e-5).all()


@pytest.mark.parametrize(("slug", "volume"), [("srgb", 0.207094138), ("display-p3", 0.288173460)])
def test_the_parallelepiped_in_xyz_has_the_exact_volume(slug, volume):
    """The determinant, as published (see the figures of the design)."""
    assert np.linalg.det(primary_matrix(REFERENCES[slug])) == pytest.approx(volume, abs=2e-9)


@pytest.mark.parametrize("reference", RGB, ids=lambda each: each.slug)
def test_full_scale_is_the_white_and_zero_is_black(reference):
    white = reference_white(reference)
    xyz = rgb_xyz(reference, np.array([[1.0, 1, 1], [0, 0, 0]]))
    np.testing.assert_allclose(xyz, [white, [0, 0, 0]], atol=1e-9)
    lab, _ = reference_lab(xyz, white, "relative", "Bradford")
    np.testing.assert_allclose(lab, [[100, 0, 0], [0, 0, 0]], atol=1e-6)


def test_srgb_red_has_the_cielab_of_its_profile():
    """L* 54.29, a* 80.80, b* 69.89: sRGB red in D50, Bradford (B. Lindbloom's calculator)."""
    srgb = REFERENCES["srgb"]
    xyz = rgb_xyz(srgb, np.array([[1.0, 0, 0]]))
    lab, text = reference_lab(xyz, reference_white(srgb), "relative", "Bradford")
    np.testing.assert_allclose(lab[0], [54.29, 80.80, 69.89], atol=0.02)
    assert "Bradford" in text


@pytest.mark.parametrize("intent", ["perceptual", "saturation"])
def test_intents_of_profiles_are_refused(intent):
    with pytest.raises(OptionError, match=intent):
        reference_lab(np.ones((1, 3)), np.ones(3), intent, "Bradford")


def test_the_faces_of_pointers_gamut_are_a_closed_oriented_sphere():
    xyz, white, faces = surface_xyz(REFERENCES["pointer"], 1000)
    assert set(faces.ravel()) == set(range(len(xyz)))
    assert len(faces) == 2 * len(xyz) - 4
    edges = {
        edge for face in faces.tolist() for edge in zip(face, face[1:] + face[:1], strict=True)
    }
    assert len(edges) == 3 * len(faces)
    assert all((b, a) in edges for a, b in edges)
    corners = reference_lab(xyz, white, "relative", "Bradford")[0][faces]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume > 5e5


def test_pointers_colours_have_the_lightness_and_hue_of_his_table():
    xyz, white, _ = surface_xyz(REFERENCES["pointer"], 1000)
    from gamutcore.colours.spaces.cielab import xyz_to_lab

    lab = xyz_to_lab(xyz, white)
    assert len(lab) == 16 * 36 + 2
    np.testing.assert_allclose(np.unique(np.round(lab[:, 0], 6)), np.arange(15, 91, 5), atol=1e-6)
    # Pointer's most saturated colours: a yellow of L* 85 with C*ab 115 or more
    assert np.hypot(lab[:, 1], lab[:, 2]).max() > 110
