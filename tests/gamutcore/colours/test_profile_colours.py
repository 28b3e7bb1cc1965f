import io

import numpy as np
import pytest
from PIL import Image, ImageCms
from scipy.spatial import ConvexHull

from gamutcore.characterisation import Picture, embedded_measurements, read_characterisation
from gamutcore.colours import colours_in_space, surface_colours, xyz_to_lab
from gamutcore.colours.spaces import ColourSpace

SRGB_TO_XYZ = np.array(  # IEC 61966-2-1, 5.2
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
INTENTS = ("perceptual", "relative", "saturation", "absolute")
ORACLE = (
    "Ref-ECG-CMYKOGV_FOGRA55_TAC300",
    "SWOP2013C3_CRPC5",
    "sGrey-v4",
    "sRGB2014",
    "sRGB_v4_ICC_preference",
)


def profile_colours(profile, device, intent):
    """Colours of device values by a profile: those of a picture with the profile."""
    picture = Picture("tiff", "CMYK", device, np.ones(len(device), np.int64), profile)
    return surface_colours(picture, intent=intent)


@pytest.mark.parametrize("name", ORACLE)
@pytest.mark.parametrize("intent", INTENTS)
def test_the_reference_implementations_results(shared_data, name, intent):
    folder = shared_data / "oracle"
    profile = read_characterisation((folder / f"{name}.icc").read_bytes())
    table = (folder / f"{name}_ToPcs_ICC-{INTENTS.index(intent)}.csv").read_text()
    values = np.array(
        [row.replace("-->,", "").split(",") for row in table.split()], dtype=np.float64
    )
    device, expected = values[:, :-3], values[:, -3:]
    # The reference extends parametric curves beyond 0 to 1, where ICC.1:2022, 10.18, clips them.
    inside = ((device >= 0) & (device <= 1)).all(axis=1)
    device, expected = device[inside], expected[inside]
    if profile.pcs == "XYZ":
        expected = xyz_to_lab(expected)
    colours = profile_colours(profile, device, intent)
    errors = np.linalg.norm(colours.points - expected, axis=1)
    # The reference writes XYZ with six decimals, which are up to 0.002 in L*, a*, b*.
    assert errors.mean() < 0.0005
    assert errors.max() < 0.003


@pytest.mark.parametrize("name", ["sRGB-v4.icc", "sRGB-v2-magic.icc", "DisplayP3-v4.icc"])
def test_values_outside_the_device_range_are_clipped_as_by_littlecms(small_profile, name):
    """LittleCMS takes integers, so that its inputs are clipped before the transform."""
    data = small_profile(name)
    device = np.random.default_rng(0).uniform(-0.5, 1.5, (200, 3))
    device = np.where((device < 0) | (device > 1), device, np.rint(device * 255) / 255)
    lab = profile_colours(read_characterisation(data), device, "relative").points
    clipped = np.rint(np.clip(device, 0, 1) * 255).astype(np.uint8)
    transform = ImageCms.buildTransform(
        ImageCms.ImageCmsProfile(io.BytesIO(data)), ImageCms.createProfile("LAB"), "RGB", "LAB", 1
    )
    picture = ImageCms.applyTransform(Image.fromarray(clipped[np.newaxis]), transform)
    expected = np.asarray(picture)[0].astype(float)
    expected[:, 1:] = expected[:, 1:].astype(np.uint8).view(np.int8).astype(float)
    expected[:, 0] *= 100 / 255
    # 8 bits: a*, b* end at -128 and 127, and are rounded to 1; L* to 0.4.
    assert np.abs(np.clip(lab, [0, -128, -128], [100, 127, 127]) - expected).max() < 1.2


@pytest.mark.parametrize("name", ["sRGB-v4.icc", "sRGB-v2-magic.icc"])
def test_srgb_is_srgb(small_profile, name):
    profile = read_characterisation(small_profile(name))
    lab = profile_colours(profile, np.eye(3), "relative").points
    # The primaries in CIELAB D50 as Lindbloom's calculator gives them.
    expected = [[54.29, 80.81, 69.89], [87.82, -79.27, 80.99], [29.57, 68.30, -112.03]]
    np.testing.assert_allclose(lab, expected, atol=0.06)
    gray = profile_colours(profile, np.full((1, 3), 0.5), "relative").points
    np.testing.assert_allclose(gray, [[53.39, 0, 0]], atol=0.03)


@pytest.mark.parametrize("name", ["sRGB-v2-magic.icc", "sRGB-v4.icc"])
@pytest.mark.parametrize("space", ["CIEXYZ", "Oklab"])
def test_in_a_space_of_its_white_absolute_colours_of_srgb_are_srgb(small_profile, name, space):
    """Version 2 declares unadapted colours, version 4 adapted ones; the result is the same."""
    found = surface_colours(
        read_characterisation(small_profile(name)), intent="absolute", surface_samples=8
    )
    light = found.device @ SRGB_TO_XYZ.T
    in_d65 = ColourSpace(space, "D65")
    wanted, _ = in_d65.from_tristimulus(light, as_measured=True)
    points = colours_in_space(found, in_d65).points
    np.testing.assert_allclose(points, wanted, atol=2e-3)
    assert found.as_measured == ("v2" in name)


def test_absolute_colours_of_prints_stay_relative_to_d50(shared_data):
    profile = read_characterisation(
        (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()
    )
    found = surface_colours(profile, intent="absolute", surface_samples=100)
    assert not found.as_measured


@pytest.mark.slow
def test_a_display_and_its_own_measurements_are_of_one_size_in_absolute_colours(shared_data):
    """Compared with relative colours, which do not depend on the treatment of the white."""
    profile = read_characterisation((shared_data / "display" / "Acer_XB271HU.icc").read_bytes())

    def ratio(intent):
        sizes = [
            ConvexHull(
                colours_in_space(
                    surface_colours(data, intent=intent, surface_samples=2000), ColourSpace("Oklab")
                ).points
            ).volume
            for data in (profile, embedded_measurements(profile))
        ]
        return sizes[0] / sizes[1]

    assert ratio("absolute") == pytest.approx(ratio("relative"), abs=0.005)


def test_a_profile_agrees_with_its_own_measurements(shared_data, fogra39):
    # reference/figures.md: ISOcoated_v2_300 against FOGRA39L, absolute, is 0.03 ΔE76 on average.
    profile = read_characterisation(
        (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()
    )
    samples = read_characterisation(fogra39)
    colours = profile_colours(profile, samples.device, "absolute")
    errors = np.linalg.norm(colours.points - samples.lab, axis=1)
    assert errors.mean() == pytest.approx(0.03, abs=0.01)
    assert errors.max() < 0.5
