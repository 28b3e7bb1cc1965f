"""Gamuts of devices of which something is known from elsewhere: another file, or another table."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from gamutcore.characterisation import characterisation
from gamutcore.gamut import Options, build_gamut
from gamutcore.metric import mismatch

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


@pytest.mark.parametrize("path", WORKING_SPACES, ids=lambda path: path.name)
def test_the_volume_of_an_rgb_working_space(path):
    if not path.is_file():
        pytest.skip(f"{path.name} is not there: Debian's packages colord-data and argyll have it")
    # The default of 0.2 bridges the concave places of wide spaces (ProPhoto: +0.7 %); 0.05 follows.
    gamut = build_gamut(path.read_bytes(), Options(gamma=0.05))
    assert gamut.description["volume"] == pytest.approx(WORKING_SPACES[path], rel=0.0015)


def test_a_press_profile_and_its_measurements_have_one_gamut(
    shared_data, fogra39, record_property, capsys
):
    # The profile is made of FOGRA39L, for an ink limit of 300 % (data/README.md).
    profile = (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()
    options = Options(intent="absolute", ink_limit=300)
    measured, characterised = build_gamut(fogra39, options), build_gamut(profile, options)
    found = mismatch(measured.history.full(), characterised.history.full())
    record_property("mismatch", found)
    with capsys.disabled():
        sys.stdout.write(f"ISOcoated_v2_300 against FOGRA39L, absolute: {100 * found:.3f} %\n")
    assert found <= 0.01


def test_the_measurements_within_a_profile_have_its_gamut(shared_data):
    profile = (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()
    gamuts = [
        build_gamut(profile, Options(intent="absolute", surface_samples=20_000, **options))
        for options in ({}, {"source": "measurements"})
    ]
    assert mismatch(*[gamut.history.full() for gamut in gamuts]) <= 0.01
    provenance = gamuts[1].description["provenance"]
    assert provenance["embedded"]["tag"] == "targ"
    assert provenance["model"]["leave_out_error"]["percentile_95"] < 0.5


def test_an_ink_limit_takes_a_part_of_the_gamut_away(fogra39):
    volumes = [
        build_gamut(fogra39, Options(surface_samples=20_000, **options)).description["volume"]
        for options in ({"ink_limit": 150}, {"ink_limit": 240}, {"ink_limit": 320}, {})
    ]
    assert volumes == sorted(volumes)
    assert volumes[0] < 0.9 * volumes[3]
    # K = 0 alone loses 20 % of the volume (reference/characterisation.md, what users expect).
    without_black = build_gamut(fogra39, Options(surface_samples=20_000, black_limit=0))
    assert 0.75 < without_black.description["volume"] / volumes[3] < 0.85


def test_provenance_of_a_profile_says_all_that_went_in(shared_data):
    data = (shared_data / "oracle" / "Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc").read_bytes()
    gamut = build_gamut(
        data, Options(ink_limit=300, black_limit=95, surface_samples=20_000, intent="absolute")
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
    assert provenance["warnings"] == []
    assert len(provenance["input"]["sha256"]) == 64
    assert characterisation(data).inks
