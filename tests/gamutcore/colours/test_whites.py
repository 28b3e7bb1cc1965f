"""Whites that a file states wrongly, does not state, or states as a display's own."""

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from gamutcore import Gamut
from gamutcore.characterisation import embedded_measurements, read_characterisation
from gamutcore.colours import (
    DeviceModel,
    colours_in_space,
    lab_to_xyz,
    measured_colours,
    surface_colours,
    xyz_to_lab,
)
from gamutcore.colours.spaces import ColourSpace
from gamutcore.errors import InvalidPointsError, MalformedProfileError
from gamutcore.search import delta_e_2000

REPORTS = Path(__file__).parents[2] / "data" / "reports"
D65 = np.array([0.9505, 1.0, 1.0891])
D50 = np.array([0.9642, 1.0, 0.8249])
SRGB = (  # IEC 61966-2-1 adapted to D50 by Bradford, as in every sRGB profile; and as it is
    np.array([[0.4361, 0.3851, 0.1431], [0.2225, 0.7169, 0.0606], [0.0139, 0.0971, 0.7141]]),
    np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]),
)
RGB = np.vstack([np.eye(3), 1 - np.eye(3), np.ones((1, 3)), np.full((1, 3), 0.5)])
GAMMA = b"curv" + bytes(4) + struct.pack(">IH", 1, 0x0200)


def fixed(*values, kind=b"XYZ "):
    return kind + bytes(4) + struct.pack(f">{len(values)}i", *[round(v * 65536) for v in values])


def matrix_tags(white, colorants=SRGB[0], **others):
    named = dict(
        zip(("rXYZ", "gXYZ", "bXYZ"), (fixed(*column) for column in colorants.T), strict=True)
    )
    curves = dict.fromkeys(("rTRC", "gTRC", "bTRC"), GAMMA)
    return {**named, **curves, "wtpt": fixed(*white), **others}


def report(name):
    return read_characterisation((REPORTS / f"{name}.icc").read_bytes())


def found(profile, intent, samples=300):
    return surface_colours(profile, intent=intent, surface_samples=samples)


def warned(surface, *words):
    return any(all(word in said for word in words) for said in surface.provenance["warnings"])


class TestOwnWhiteOfADisplay:
    def test_absolute_volume_of_srgb_is_that_of_its_own_tristimulus_values(self):
        """897,948 is the volume of sRGB with its own D65 white in CIELAB for D50."""
        gamut = Gamut(
            REPORTS / "display-profile-v2-with-its-own-white.icc",
            intent="absolute",
            surface_samples=3000,
        )
        assert gamut.description["device_surface_volume"] == pytest.approx(897_948, rel=1e-3)
        (relative,) = (gamut.description["volumes"]["relative"]["volume"],)
        assert relative == pytest.approx(833_135, rel=1e-3)  # reference/reports.md

    @pytest.mark.parametrize("kind", ["mntr", "spac"])
    @pytest.mark.parametrize("version", [2, 4])
    @pytest.mark.parametrize("chad", [None, "right", "identity", "singular"])
    def test_the_adaptation_is_undone_whatever_chad_says(self, made_profile, kind, version, chad):
        """Version 4 must state D50; a D65 white there is the display's, and is warned of."""
        matrices = {
            "right": SRGB[0] @ np.linalg.inv(SRGB[1]),
            "identity": np.eye(3),
            "singular": np.zeros((3, 3)),
        }
        others = {} if chad is None else {"chad": fixed(*matrices[chad].ravel(), kind=b"sf32")}
        data = made_profile(matrix_tags(D65, **others), pcs="XYZ ", kind=kind, version=version)
        surface = found(read_characterisation(data), "absolute")
        wanted = surface.device**2 @ SRGB[1].T
        np.testing.assert_allclose(lab_to_xyz(surface.points), wanted, atol=4e-4)
        assert warned(surface, "9.2.36") == (version == 4)

    @pytest.mark.parametrize("space", ["CIEXYZ", "Oklab", "CAM16-UCS"])
    def test_in_all_spaces(self, made_profile, space):
        data = made_profile(matrix_tags(D65), pcs="XYZ ", kind="mntr", version=2)
        surface = found(read_characterisation(data), "absolute")
        wanted, _ = ColourSpace(space).from_tristimulus(
            surface.device**2 @ SRGB[1].T, as_measured=True
        )
        points = colours_in_space(surface, ColourSpace(space)).points
        scale = np.ptp(wanted, axis=0).max()
        np.testing.assert_allclose(points, wanted, atol=2e-3 * scale)

    def test_version_4_with_d50_stays_adapted(self):
        one, two = (
            found(report("display-profile-v4-reference"), i) for i in ("relative", "absolute")
        )
        np.testing.assert_allclose(one.points, two.points, atol=0.01)
        assert one.provenance["warnings"] == two.provenance["warnings"] == []

    @pytest.mark.parametrize("name", ["Acer_XB271HU", "Panasonic-TV_2014"])
    def test_agrees_with_the_displays_own_measurements(self, shared_data, name):
        """Absolute colours miss the measurements by no more than relative ones; scaling by 3.3."""
        profile = read_characterisation((shared_data / "display" / f"{name}.icc").read_bytes())
        samples = embedded_measurements(profile)
        step = max(1, len(samples) // 300)
        some = replace(samples, device=samples.device[::step], xyz=samples.xyz[::step])
        some = replace(some, lab=None if some.lab is None else some.lab[::step])
        some = replace(some, white=samples.xyz[(samples.device == 1).all(axis=1)].mean(axis=0))
        transform = found(profile, "absolute").device_colours.model.function
        relative = found(profile, "relative").device_colours.model.function
        misses = [
            np.linalg.norm(function.lab(some.device) - measured_colours(some, intent).lab, axis=1)
            for function, intent in ((transform, "absolute"), (relative, "relative"))
        ]
        assert misses[0].mean() < 1.15 * misses[1].mean()
        assert misses[0].max() < 1.5 * misses[1].max()

    def test_a_table_precedes_an_exchanged_matrix(self, made_profile):
        """Profilers exchange the matrix to show which programs ignore the table."""
        nodes = np.stack(np.meshgrid(*[[0.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        table = np.rint(nodes @ SRGB[0].T * 32768).astype(">u2").tobytes()
        lut = b"mft2" + bytes(4) + b"\3\3\2\0" + fixed(*np.eye(3).ravel())[8:]
        ramp = struct.pack(">HH", 0, 65535) * 3
        lut += struct.pack(">HH", 2, 2) + ramp + table + ramp
        tags = matrix_tags(D65, SRGB[0][:, ::-1], A2B0=lut)
        data = made_profile(tags, pcs="XYZ ", kind="mntr", version=2)
        surface = found(read_characterisation(data), "absolute")
        wanted = surface.device @ SRGB[1].T
        np.testing.assert_allclose(lab_to_xyz(surface.points), wanted, atol=4e-4)

    def test_a_saved_model_keeps_the_absolute_colours(self):
        surface = found(report("display-profile-v2-with-its-own-white"), "absolute")
        model = DeviceModel.from_bytes(surface.device_colours.model.to_bytes())
        np.testing.assert_allclose(model.lab(surface.device), surface.points, atol=1e-9)


class TestStatedWhite:
    @pytest.mark.parametrize(
        "white",
        [(0.3127, 0.3290, 1.0), (0.3127, 0.3290, 0.0), (0.3127, 0.3290, 120.0),
         (0.3127, 0.3290, 0.3583), (95.05, 100.0, 108.91), (0.5 * D65)],
    )  # fmt: skip
    def test_a_display_gets_the_white_that_is_meant(self, made_profile, white):
        right, wrong = (
            found(read_characterisation(made_profile(tags, pcs="XYZ ", kind="mntr", version=2)), i)
            for tags, i in ((matrix_tags(D65), "absolute"), (matrix_tags(white), "absolute"))
        )
        np.testing.assert_allclose(wrong.points, right.points, atol=0.05)
        assert warned(wrong, "wtpt", "media white")
        assert not warned(right, "wtpt")

    def test_the_report_has_the_volume_of_the_right_tag(self):
        right, wrong = (
            found(report(f"display-profile-white-tag-{name}"), "absolute")
            for name in ("right", "is-x-y-1")
        )
        np.testing.assert_allclose(wrong.points, right.points, atol=0.02)
        assert warned(wrong, "0.312698 0.328995 1", "x, y")

    @pytest.mark.parametrize(
        ("kind", "white"),
        [("mntr", (0.1, 1.0, 0.1)), ("mntr", (0.0, 0.0, 0.0)), ("prtr", (0.0, 0.0, 0.0)),
         ("prtr", (0.0096, 0.01, 0.0083)), ("prtr", (1.5, 1.6, 1.3)),
         ("prtr", (0.3457, 0.3585, 1.0))],
    )  # fmt: skip
    def test_what_no_medium_has_is_refused_for_absolute_colours_only(
        self, made_profile, kind, white
    ):
        profile = read_characterisation(
            made_profile(matrix_tags(white), pcs="XYZ ", kind=kind, version=2)
        )
        assert warned(found(profile, "relative"), "wtpt")
        with pytest.raises(MalformedProfileError) as refused:
            found(profile, "absolute")
        assert refused.value.where == {"tag": "wtpt"}
        assert "relative" in refused.value.remedy

    def test_a_paper_in_per_cent_is_read(self, made_profile):
        paper = np.array([0.85, 0.88, 0.75])
        tags = matrix_tags(100 * paper)
        profile = read_characterisation(made_profile(tags, pcs="XYZ ", kind="prtr", version=2))
        surface = found(profile, "absolute")
        white = surface.points[surface.device.sum(axis=1).argmax()]
        np.testing.assert_allclose(white, xyz_to_lab(paper), atol=0.05)
        assert warned(surface, "scale to 100")

    def test_colorants_that_are_not_adapted_are_named_and_not_adapted_twice(self):
        profile = report("display-profile-colorants-not-adapted")
        relative, absolute = (found(profile, intent) for intent in ("relative", "absolute"))
        for surface in (relative, absolute):
            assert warned(surface, "100 -2.4 -19.4", "not adapted")
        np.testing.assert_allclose(absolute.points, relative.points, atol=1e-6)

    def test_a_table_that_is_not_relative_to_the_paper_is_named(self, made_profile):
        lut = struct.pack(">4sIBBBB", b"mft2", 0, 3, 3, 2, 0) + bytes(36) + struct.pack(">HH", 2, 2)
        lut += struct.pack(">HH", 0, 65535) * 3
        lut += struct.pack(">3H", 62000, 32768, 32300) * 8 + struct.pack(">HH", 0, 65535) * 3
        data = made_profile({"A2B0": lut, "wtpt": fixed(0.85, 0.88, 0.75)}, version=2)
        assert warned(found(read_characterisation(data), "relative"), "not relative to the paper")


def without_white(samples, far=1e-6):
    """Samples without those near white: no ink, or all channels at full scale."""
    away = np.abs(samples.device - (1.0 if samples.additive else 0.0)).max(axis=1)
    kept = {
        name: None if getattr(samples, name) is None else getattr(samples, name)[away > far]
        for name in ("device", "lab", "xyz")
    }
    return replace(samples, **kept)


class TestUnmeasuredWhite:
    @pytest.mark.parametrize("far", [1e-6, 0.025])
    def test_a_press_gets_the_paper_of_its_model(self, fogra39, far):
        samples = read_characterisation(fogra39)
        whole = measured_colours(samples, "relative")
        part = measured_colours(without_white(samples, far), "relative")
        papers = [xyz_to_lab(np.array([each.provenance["white"]])) for each in (whole, part)]
        assert delta_e_2000(*papers).item() < 0.3
        (warning,) = [said for said in part.warnings if "not measured" in said]
        assert "no ink" in warning

    @pytest.mark.slow
    def test_the_volume_of_a_press_without_paper(self, fogra39):
        samples = read_characterisation(fogra39)
        volumes = []
        for data in (samples, without_white(samples)):
            surface = surface_colours(data, surface_samples=5000)
            volumes.append(ConvexHull(surface.points).volume)
        assert volumes[1] == pytest.approx(volumes[0], rel=0.005)

    @pytest.mark.parametrize("intent", ["relative", "absolute"])
    def test_a_display_whose_lightest_patch_is_yellow(self, intent):
        """The lightest of the other 124 patches is a yellow of L* 98.9, b* 29.9."""
        samples = read_characterisation((REPORTS / "display-reference.ti3").read_bytes())
        whole, part = (
            surface_colours(each, intent=intent, surface_samples=2000)
            for each in (samples, without_white(samples))
        )
        np.testing.assert_allclose(
            part.points[part.device.sum(axis=1).argmax()],
            whole.points[whole.device.sum(axis=1).argmax()],
            atol=0.3,
        )
        # the grid is complete with the white, and interpolated as before
        assert part.provenance["model"]["name"] == whole.provenance["model"]["name"]

    def test_the_lightest_patch_is_an_overprint(self, fogra39):
        """Every patch has two inks of 20 % or more, the lightest of them a light orange."""
        samples = read_characterisation(fogra39)
        inks = (samples.device >= 0.2).sum(axis=1)
        data = replace(
            samples,
            device=samples.device[inks > 1],
            lab=samples.lab[inks > 1],
            xyz=None,
        )
        white = np.array(measured_colours(data, "relative").provenance["white"])
        lightest = data.lab[data.lab[:, 0].argmax()]
        paper, estimate = np.array([95.0, 0.0, -2.0]), xyz_to_lab(white)
        assert np.linalg.norm(estimate - paper) < 0.5 * np.linalg.norm(lightest - paper)

    def test_a_white_that_nothing_gives_is_refused(self):
        solids = [[1, 0, 0, 55, -36, -49], [0, 1, 0, 48, 74, -3], [0, 0, 1, 89, -5, 93],
                  [1, 1, 0, 24, 17, -46], [1, 0, 1, 50, -65, 27]]  # fmt: skip
        text = "CMY_C CMY_M CMY_Y LAB_L LAB_A LAB_B"
        rows = "\n".join(" ".join(map(str, [100 * v for v in r[:3]] + r[3:])) for r in solids)
        layout = f"CGATS.17\nBEGIN_DATA_FORMAT\n{text}\nEND_DATA_FORMAT\n"
        samples = read_characterisation(f"{layout}BEGIN_DATA\n{rows}\nEND_DATA\n".encode())
        with pytest.raises(InvalidPointsError) as refused:
            measured_colours(samples, "relative")
        assert refused.value.where == {"field": "white"}
        assert len(measured_colours(samples, "absolute").lab) == len(solids)
