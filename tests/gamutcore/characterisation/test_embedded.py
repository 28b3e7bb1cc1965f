"""Measurements inside profiles."""

import struct
import zlib

import numpy as np
import pytest

from gamutcore.characterisation import embedded_data as module
from gamutcore.characterisation import embedded_measurements, read_characterisation
from gamutcore.errors import CharacterisationError, InvalidPointsError, OptionError


def text(content, kind=b"text"):
    return kind + bytes(4) + content.encode()


BOTH = """CTI3
BEGIN_DATA_FORMAT
SAMPLE_ID RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z
END_DATA_FORMAT
BEGIN_DATA
A1 100 100 100 95 100 109
A2 0 0 0 0.1 0.1 0.1
END_DATA
"""
COLOURS = """CGATS.17
ILLUMINANT "D50"
BEGIN_DATA_FORMAT
SAMPLE_ID LAB_L LAB_A LAB_B
END_DATA_FORMAT
BEGIN_DATA
A1 95 0 -2
"A 2" 50 10 20
END_DATA
"""
DEVICES = """CGATS.17
BEGIN_DATA_FORMAT
SAMPLE_ID CMYK_C CMYK_M CMYK_Y CMYK_K
END_DATA_FORMAT
BEGIN_DATA
"A 2" 10 20 30 40
A1 0 0 0 0
END_DATA
"""
UNNAMED = COLOURS.replace("SAMPLE_ID ", "").replace("A1 ", "").replace('"A 2" ', "")


def test_the_target_of_a_display_profile(made_profile):
    profile = read_characterisation(made_profile({"targ": text(BOTH)}, kind="mntr"))
    samples = embedded_measurements(profile)
    assert samples.channels == ("R", "G", "B")
    np.testing.assert_allclose(samples.xyz, [[95, 100, 109], [0.1, 0.1, 0.1]])
    assert samples.conditions["DEVICE_CLASS"] == "DISPLAY"
    assert samples.provenance["source"] == "measurements"
    assert samples.provenance["embedded"]["tag"] == "targ"


def test_what_a_text_states_is_kept(made_profile):
    stated = BOTH.replace("CTI3\n", 'CTI3\nDEVICE_CLASS "OUTPUT"\n')
    profile = read_characterisation(made_profile({"targ": text(stated)}, kind="mntr"))
    assert embedded_measurements(profile).conditions["DEVICE_CLASS"] == "OUTPUT"


def test_colours_and_device_values_in_two_tags_are_joined_by_name(made_profile):
    tags = {"CIED": text(COLOURS), "DevD": text(DEVICES)}
    samples = embedded_measurements(read_characterisation(made_profile(tags, space="CMYK")))
    assert samples.channels == ("C", "M", "Y", "K")
    np.testing.assert_allclose(samples.device, [[0, 0, 0, 0], [0.1, 0.2, 0.3, 0.4]])
    np.testing.assert_allclose(samples.lab, [[95, 0, -2], [50, 10, 20]])
    assert samples.conditions["ILLUMINANT"] == "D50"


def test_without_names_they_are_joined_by_order(made_profile):
    tags = {
        "CIED": text(UNNAMED),
        "DevD": text(DEVICES),
    }
    samples = embedded_measurements(read_characterisation(made_profile(tags, space="CMYK")))
    np.testing.assert_allclose(samples.device, [[0.1, 0.2, 0.3, 0.4], [0, 0, 0, 0]])


@pytest.mark.parametrize("devices", ["", BOTH])
def test_a_tag_with_all_columns_needs_no_other(made_profile, devices):
    tags = {"CIED": text(BOTH), "DevD": text(devices)}
    assert len(embedded_measurements(read_characterisation(made_profile(tags)))) == 2


@pytest.mark.parametrize("kind", [b"text", b"utf8", b"zut8", b"ZXML", b"data"])
def test_texts_of_every_kind(made_profile, kind):
    content = BOTH.encode()
    if kind in {b"zut8", b"ZXML"}:
        content = zlib.compress(content)
    if kind == b"data":
        content = bytes(4) + content
    profile = read_characterisation(made_profile({"targ": kind + bytes(4) + content}))
    assert len(embedded_measurements(profile)) == 2


@pytest.mark.parametrize("level", range(10))
def test_packed_xml_with_a_number_before_it(made_profile, level):
    # X-Rite's layout: type, reserved, 1, stream.
    packed = b"ZXML" + bytes(4) + struct.pack(">I", 1) + zlib.compress(BOTH.encode(), level)
    assert len(embedded_measurements(read_characterisation(made_profile({"targ": packed})))) == 2


@pytest.mark.parametrize("size", range(6))
def test_packed_xml_without_a_stream_is_refused(made_profile, size):
    with pytest.raises(CharacterisationError) as caught:
        embedded_measurements(
            read_characterisation(made_profile({"targ": b"ZXML" + bytes(4 + size)}))
        )
    assert caught.value.where["tag"] == "targ"


def test_bare_colours_are_colours(made_profile):
    profile = read_characterisation(made_profile({"CIED": text(COLOURS)}))
    assert embedded_measurements(profile).device is None


def test_numbered_inks_have_the_profiles_names(made_profile):
    entries = b"".join(name.ljust(32, b"\0") + bytes(6) for name in (b"Black", b"Orange"))
    clrt = b"clrt" + bytes(4) + struct.pack(">I", 2) + entries
    table = BOTH.replace("RGB_R RGB_G RGB_B", "2CLR_1 2CLR_2 OTHER")
    profile = read_characterisation(made_profile({"targ": text(table), "clrt": clrt}, space="2CLR"))
    samples = embedded_measurements(profile)
    assert samples.channels == ("Black", "Orange")
    assert samples.provenance["channels"] == ["Black", "Orange"]


@pytest.mark.parametrize("data", [b"L,a,b\n50,0,0\n60,1,2\n", None])
def test_data_without_measurements_inside_is_refused(made_profile, data):
    with pytest.raises(OptionError) as caught:
        embedded_measurements(read_characterisation(data or made_profile({})))
    assert caught.value.where == {"field": "source"}


def test_a_reference_to_registered_data_is_named(made_profile):
    reference = {"targ": text("ICCHDAT FOGRA39\0")}
    with pytest.raises(OptionError, match="only refers to the registered data set FOGRA39") as said:
        embedded_measurements(read_characterisation(made_profile(reference)))
    assert said.value.where == {"field": "source"}
    assert "registry" in said.value.remedy
    beside = {**reference, "CIED": text(COLOURS), "DevD": text(DEVICES)}
    samples = embedded_measurements(read_characterisation(made_profile(beside, space="CMYK")))
    assert samples.provenance["embedded"]["tag"] == "CIED"


@pytest.mark.parametrize(
    "tags",
    [
        {"targ": text("")},
        {"targ": text("hello")},
        {"targ": text(BOTH.replace("95", "x"))},
        {"targ": b"XYZ " + bytes(16)},
        {"targ": b"zut8" + bytes(20)},
        {"targ": b"text"},
        {"CIED": text(COLOURS), "DevD": text(DEVICES.replace("A1", "A9"))},
        {"CIED": text(COLOURS), "DevD": text(DEVICES.replace("40\n", "\n"))},
        {"CIED": text(UNNAMED), "DevD": text(DEVICES.replace("A1 0 0 0 0\n", ""))},
        {"CIED": text(COLOURS), "DevD": b"mluc" + bytes(30)},
    ],
)
def test_broken_measurements_name_their_tag(made_profile, tags):
    with pytest.raises((CharacterisationError, InvalidPointsError)) as caught:
        embedded_measurements(read_characterisation(made_profile(tags, space="CMYK")))
    assert caught.value.where["tag"] in tags


def test_a_profile_within_a_profile_is_refused(made_profile):
    inner = made_profile({"targ": text(BOTH)})
    with pytest.raises(CharacterisationError) as caught:
        embedded_measurements(
            read_characterisation(made_profile({"targ": b"data" + bytes(8) + inner}))
        )
    assert caught.value.where["tag"] == "targ"


def test_a_packed_text_without_end_is_refused(made_profile, monkeypatch):
    monkeypatch.setattr(module, "MAX_TEXT", 1000)
    packed = b"zut8" + bytes(4) + zlib.compress(b" " * 10_000_000)
    with pytest.raises(CharacterisationError, match="more than 1000 bytes"):
        embedded_measurements(read_characterisation(made_profile({"targ": packed})))


@pytest.mark.parametrize(
    ("file", "patches", "channels"),
    [
        ("press/ISOcoated_v2_300_bas.icc", 1617, 4),
        ("oracle/SWOP2013C3_CRPC5.icc", 1617, 4),  # CxF, by X-Rite's i1Profiler
        ("oracle/Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc", 4884, 7),
        ("display/Acer_XB271HU.icc", 2068, 3),  # data/README.md: 2068 measured patches
    ],
)
@pytest.mark.slow
def test_real_profiles(shared_data, file, patches, channels):
    profile = read_characterisation((shared_data / file).read_bytes())
    samples = embedded_measurements(profile)
    assert samples.device.shape == (patches, channels)
    assert samples.channels == profile.channels


def test_the_press_profiles_measurements_are_those_of_the_press(shared_data, fogra39):
    profile = read_characterisation((shared_data / "press/ISOcoated_v2_300_bas.icc").read_bytes())
    inside, own = embedded_measurements(profile), read_characterisation(fogra39)
    table = {tuple(d): lab for d, lab in zip(inside.device.round(4), inside.lab, strict=True)}
    errors = [
        np.linalg.norm(table[tuple(d)] - lab)
        for d, lab in zip(own.device.round(4), own.lab, strict=True)
        if tuple(d) in table
    ]
    assert len(errors) > 1500
    assert np.mean(errors) < 0.1
