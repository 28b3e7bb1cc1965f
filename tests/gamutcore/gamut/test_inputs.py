"""Gamuts of every kind of input: profiles, measurements, pictures and meshes."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.booleans import mismatch
from gamutcore import Gamut, Options
from gamutcore.characterisation import read_characterisation
from gamutcore.errors import CentreError, OptionError
from gamutcore.export import FORMATS, mesh_file
from gamutcore.levels import radial_difference

COLORD = Path("/usr/share/color/icc/colord")
ARGYLL = Path("/usr/share/color/argyll/ref")

# Bruce Lindbloom's table of RGB working spaces: Lab D50, 2°, Bradford (reference/figures.md).
WORKING_SPACES = {
    COLORD / "sRGB.icc": 832_870,
    COLORD / "AdobeRGB1998.icc": 1_208_631,
    COLORD / "AppleRGB.icc": 798_403,
    COLORD / "BetaRGB.icc": 1_717_450,
    COLORD / "ColorMatchRGB.icc": 836_975,
    COLORD / "NTSC-RGB.icc": 1_300_252,
    COLORD / "ProPhotoRGB.icc": 2_879_568,
    COLORD / "WideGamutRGB.icc": 2_164_221,
    ARGYLL / "sRGB.icm": 832_870,
    ARGYLL / "ClayRGB1998.icm": 1_208_631,
    ARGYLL / "ProPhoto.icm": 2_879_568,
}


def off(reference, other):
    """Mismatch of two full boundaries, both of which see the centre of the first."""
    centre = reference.history.centre
    return radial_difference(reference.history.full(), other.history.full(), centre).mismatch


def working_space(path):
    if not path.is_file():
        pytest.skip(f"{path.name} is not there: Debian's packages colord-data and argyll have it")
    return path.read_bytes()


@pytest.mark.parametrize("path", WORKING_SPACES, ids=lambda path: path.name)
@pytest.mark.long
def test_the_gamut_of_an_rgb_working_space_has_its_volume(path):
    gamut = Gamut(working_space(path))
    assert gamut.description["volume"] == pytest.approx(WORKING_SPACES[path], rel=0.0008)


@pytest.mark.slow
def test_a_press_profile_and_its_measurements_have_one_gamut(shared_data, fogra39):
    # The profile is made of FOGRA39L, for an ink limit of 300 % (data/README.md).
    profile = (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()
    options = Options(intent="absolute", ink_limit=300, surface_samples=20_000)
    measured, characterised = Gamut(fogra39, options), Gamut(profile, options)
    assert off(measured, characterised) <= 0.01


def cube_surface(step):
    """Return all colours of the six faces of the cube of 8-bit RGB, in steps, as rows of pixels."""
    levels = np.arange(0, 256, step, dtype=np.uint8)
    face = np.stack(np.meshgrid(levels, levels, indexing="ij"), axis=-1).reshape(-1, 2)
    faces = [np.insert(face, axis, end, axis=1) for axis in range(3) for end in (0, 255)]
    return np.concatenate(faces)


@pytest.mark.parametrize(
    ("name", "file_format"), [("DisplayP3-v4", "PNG"), ("AdobeCompat-v2", "TIFF")]
)
@pytest.mark.slow
def test_a_picture_of_all_colours_has_the_gamut_of_its_profile(shared_data, name, file_format):
    profile = (shared_data / "spaces" / f"{name}.icc").read_bytes()
    pixels = cube_surface(5)
    file = io.BytesIO()
    Image.frombytes("RGB", (52, 312), pixels.tobytes()).save(file, file_format, icc_profile=profile)
    found = Gamut(file.getvalue(), gamma=0.05)
    characterised = Gamut(profile, surface_samples=20_000)
    assert mismatch(characterised.history.full(), found.history.full()) <= 0.001
    provenance = found.description["provenance"]
    assert provenance["size"] == [52, 312]
    assert provenance["profile"]["description"]


def test_vertices_of_a_picture_have_the_values_of_its_pixels():
    corners = np.array(np.meshgrid([0, 255], [0, 255], [0, 255]), np.uint8).reshape(3, -1).T
    file = io.BytesIO()
    Image.fromarray(corners[np.newaxis]).save(file, "PNG")
    mesh = Gamut(file.getvalue()).history
    device = mesh.device_values(mesh.triangles)
    assert device.channels == ("R", "G", "B")
    lightest = mesh.level(mesh.triangles).vertices[:, 0].argmax()
    np.testing.assert_allclose(device.values[lightest], 1, atol=1e-3)
    blue = np.linalg.norm(device.values - (0, 0, 1), axis=1).argmin()
    np.testing.assert_allclose(device.values[blue], (0, 0, 1), atol=1e-3)
    # sRGB's blue, Lindbloom's calculator
    np.testing.assert_allclose(mesh.full().vertices[blue], (29.57, 68.30, -112.03), atol=0.06)


def test_the_least_used_colours_of_a_picture_can_be_left_out():
    dull = np.array([(r, g, b) for r in (60, 180) for g in (60, 180) for b in (60, 180)], np.uint8)
    speck = np.array([[255, 0, 0], [0, 0, 255]], np.uint8)
    pixels = np.concatenate([np.repeat(dull, 100, axis=0), speck])  # 2 pixels of 802
    file = io.BytesIO()
    Image.frombytes("RGB", (401, 2), pixels.tobytes()).save(file, "PNG")
    every, popular = (Gamut(file.getvalue(), **share) for share in ({}, {"popularity": 0.01}))
    plain = io.BytesIO()
    Image.frombytes("RGB", (400, 2), pixels[:800].tobytes()).save(plain, "PNG")
    without = Gamut(plain.getvalue())
    assert popular.description["volume"] == without.description["volume"]
    assert every.description["volume"] > 1.5 * without.description["volume"]
    assert every.id != popular.id
    with pytest.raises(OptionError):
        Gamut(b"L,a,b\n90,0,0\n10,0,0\n50,40,9\n50,-40,9\n50,0,-40\n", Options(popularity=0.01))


@pytest.mark.parametrize(
    ("file", "tag"),
    [("press/ISOcoated_v2_300_bas.icc", "targ"), ("oracle/SWOP2013C3_CRPC5.icc", "CxF")],
)
@pytest.mark.slow
def test_the_measurements_within_a_profile_have_its_gamut(shared_data, file, tag):
    profile = (shared_data / file).read_bytes()
    gamuts = [
        Gamut(profile, intent="absolute", surface_samples=5000, **options)
        for options in ({}, {"source": "measurements"})
    ]
    assert off(*gamuts) <= 0.01
    provenance = gamuts[1].description["provenance"]
    assert provenance["embedded"]["tag"] == tag
    assert provenance["model"]["leave_out_error"]["percentile_95"] < 0.5


@pytest.mark.slow
def test_an_ink_limit_takes_a_part_of_the_gamut_away(few_patches):
    volumes = [
        Gamut(few_patches, surface_samples=4000, **options).description["volume"]
        for options in ({"ink_limit": 150}, {"ink_limit": 240}, {"ink_limit": 320}, {})
    ]
    assert volumes == sorted(volumes)
    assert volumes[0] < 0.9 * volumes[3]
    # K = 0 alone loses 20 % of the volume (reference/characterisation.md, what users expect).
    without_black = Gamut(few_patches, surface_samples=4000, black_limit=0)
    assert 0.75 < without_black.description["volume"] / volumes[3] < 0.85


@pytest.mark.slow
def test_provenance_of_a_profile_says_all_that_went_in(shared_data):
    data = (shared_data / "oracle" / "Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc").read_bytes()
    gamut = Gamut(
        data, Options(ink_limit=300, black_limit=95, surface_samples=4000, intent="absolute")
    )
    provenance = gamut.description["provenance"]
    assert provenance["device_class"] == "output"
    assert provenance["channels"][3:5] == ["Black", "Orange"]
    assert provenance["ink_limits"] == {"total": 300, "black": 95}
    assert provenance["model"] == {"name": "ICC profile", "tag": "A2B1", "kind": "lut16"}
    assert provenance["intent"] == "absolute"
    assert provenance["white"] == pytest.approx([0.8528, 0.8762, 0.7929], abs=1e-4)
    assert provenance["illuminant"] == "D50"
    assert provenance["adaptation"]
    (warning,) = provenance["warnings"]  # seven inks fold
    assert "outside of the full boundary" in warning
    assert len(provenance["input"]["sha256"]) == 64
    assert read_characterisation(data).inks


class TestMesh:
    """A posted mesh is the boundary itself."""

    @pytest.mark.parametrize("name", [name for name in FORMATS if name != "cge"])  # no triangles
    @pytest.mark.parametrize("triangles", [4, 10, 1000])
    @pytest.mark.slow
    def test_an_exported_level_is_the_full_boundary(self, fogra39_gamut, name, triangles):
        level = fogra39_gamut.history.level(triangles)
        centre = fogra39_gamut.description["centre"]
        provenance = {"centre": " ".join(map(repr, centre)), "space": "CIELAB"}
        source = {"source": "boundary"} if name == "icc" else {}
        gamut = Gamut(mesh_file(level, name, provenance), **source)
        full = gamut.history.full()
        assert gamut.description["counts"]["triangles"] == triangles
        # sums in another order
        assert gamut.description["volume"] == pytest.approx(level.volume, rel=1e-12)
        # the same triangles, whatever their order
        assert triangle_set(full) == triangle_set(level)
        if name not in {"stl", "icc"}:  # these have no place for a centre
            assert gamut.description["centre"] == centre
        assert full.validity(gamut.description["centre"]).is_gamut

    def test_the_centre_may_be_chosen(self, fogra39_gamut):
        data = mesh_file(fogra39_gamut.history.level(100), "stl")
        centre = fogra39_gamut.description["centre"]
        gamut = Gamut(data, centre=tuple(centre))
        assert gamut.description["centre"] == centre
        with pytest.raises(CentreError):
            Gamut(data, centre=(500, 0, 0))


def triangle_set(mesh):
    """Each triangle as the positions of its corners, starting with the smallest."""
    corners = mesh.vertices[mesh.faces].tolist()
    turned = (face[face.index(min(face)) :] + face[: face.index(min(face))] for face in corners)
    return sorted(turned)
