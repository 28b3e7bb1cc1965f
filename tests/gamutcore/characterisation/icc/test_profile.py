"""Profiles: header, intents and their stand-ins, white, names, and files that break the format."""

import random
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.characterisation import read_characterisation
from gamutcore.colours import surface_colours
from gamutcore.errors import GamutError, MalformedProfileError, UnsupportedProfileError


def xyz(*values):
    return b"XYZ " + bytes(4) + struct.pack(">3i", *[round(v * 65536) for v in values])


GAMMA = b"curv" + bytes(4) + struct.pack(">IH", 1, 0x0200)
MATRIX = {
    **{tag: xyz(0.3, 0.3, 0.3) for tag in ("rXYZ", "gXYZ", "bXYZ")},
    **dict.fromkeys(("rTRC", "gTRC", "bTRC"), GAMMA),
    "wtpt": xyz(0.95, 1, 1.09),
}


def test_the_header_of_a_real_profile(small_profile):
    profile = read_characterisation(small_profile("sRGB-v2-magic.icc"))
    assert profile.version == (2, 1, 0)
    assert profile.device_class == "display"
    assert profile.channels == ("R", "G", "B")
    assert profile.pcs == "XYZ"
    # sRGB's own white, D65: x 0.3127, y 0.3290.
    white, warnings = profile.media_white()
    np.testing.assert_allclose(white, [0.9505, 1, 1.0891], atol=3e-4)
    assert warnings == []


def test_the_gray_axis_of_the_connection_space(small_profile):
    transform, _ = read_characterisation(small_profile("sGrey-v4.icc")).transform("relative")
    np.testing.assert_allclose(transform.pcs_values(np.ones((1, 1))), [[0.9642, 1, 0.8249]])


def test_a_gray_profile_over_lab(made_profile):
    profile = read_characterisation(made_profile({"kTRC": GAMMA}, space="GRAY"))
    transform, _ = profile.transform("relative")
    np.testing.assert_allclose(transform.pcs_values(np.array([[0.5]])), [[25, 0, 0]])
    assert profile.media_white()[1]


@pytest.mark.parametrize(
    ("tags", "intent", "used", "warned"),
    [
        (("A2B0", "A2B1", "A2B2"), "perceptual", "A2B0", False),
        (("A2B0", "A2B1", "A2B2"), "relative", "A2B1", False),
        (("A2B0", "A2B1", "A2B2"), "absolute", "A2B1", False),
        (("A2B0", "A2B1", "A2B2"), "saturation", "A2B2", False),
        (("A2B0",), "relative", "A2B0", True),
        (("A2B0",), "saturation", "A2B0", True),
        (("A2B1",), "perceptual", "A2B1", True),
    ],
)
def test_each_intent_has_its_tag_and_stand_ins(made_profile, tags, intent, used, warned):
    lut = b"mAB " + bytes(4) + b"\3\3" + bytes(2) + struct.pack(">5I", 32, 0, 0, 0, 0)
    lut += (b"curv" + bytes(8)) * 3
    profile = read_characterisation(made_profile({**dict.fromkeys(tags, lut), **MATRIX}))
    transform, warnings = profile.transform(intent)
    assert transform.tag == used
    assert bool(warnings) == warned


def test_damage_in_other_tags_does_no_harm(made_profile):
    data = bytearray(made_profile({"A2B9": b"x" * 8, **MATRIX}, pcs="XYZ ", kind="mntr"))
    data[136:144] = b"\xff" * 8
    transform, _ = read_characterisation(bytes(data)).transform("relative")
    np.testing.assert_allclose(transform.pcs_values(np.ones((1, 3))), [[0.9, 0.9, 0.9]], atol=1e-4)


def test_input_profiles_are_warned_of(made_profile):
    assert (
        "encoding"
        in read_characterisation(made_profile(MATRIX, kind="scnr", pcs="XYZ ")).warnings[0]
    )


def colorants(*names):
    entries = b"".join(name.ljust(32, b"\0") + bytes(6) for name in names)
    return {"clrt": b"clrt" + bytes(4) + struct.pack(">I", len(names)) + entries}


@pytest.mark.parametrize(
    ("tags", "channels"),
    [
        (colorants(b"Cyan", b"Orange"), ("Cyan", "Orange")),
        ({}, ("1", "2")),
        (colorants(b"Cyan"), ("1", "2")),
        (colorants(b"Cyan", b"Cyan"), ("1", "2")),
        (colorants(b"Cyan", b""), ("1", "2")),
        ({"clrt": colorants(b"Cyan", b"Orange")["clrt"][:50]}, ("1", "2")),
    ],
)
def test_ink_names_come_from_the_colorant_table(made_profile, tags, channels):
    assert read_characterisation(made_profile(tags, space="2CLR")).channels == channels


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"version": 6}, "version"),
        ({"version": 1}, "version"),
        ({"kind": "link"}, "device_class"),
        ({"kind": "nmcl"}, "device_class"),
        ({"space": "Lab "}, "device_colour_space"),
        ({"space": "HSV "}, "device_colour_space"),
    ],
)
def test_other_kinds_of_profiles_are_unsupported(made_profile, options, field):
    with pytest.raises(UnsupportedProfileError) as caught:
        read_characterisation(made_profile(MATRIX, **options))
    assert caught.value.where == {"field": field}


def test_version_3_is_read_as_version_2_with_a_warning(made_profile):
    """No version 3 exists, but displays with this byte do."""
    odd, even = (read_characterisation(made_profile(MATRIX, version=v, pcs="XYZ ")) for v in (3, 2))
    assert any("version 3" in said for said in odd.warnings)
    assert not any("version" in said for said in even.warnings)
    for intent in ("perceptual", "relative", "absolute"):
        points = [
            surface_colours(each, intent=intent, surface_samples=100).points for each in (odd, even)
        ]
        np.testing.assert_array_equal(*points)


def test_the_white_that_colours_were_adapted_from(made_profile):
    # ICC.1:2022, annex E.3: the linear Bradford matrix from D65 to D50.
    bradford = (1.0478, 0.0229, -0.0501, 0.0295, 0.9905, -0.0171, -0.0092, 0.0150, 0.7517)
    chad = b"sf32" + bytes(4) + struct.pack(">9i", *[round(v * 65536) for v in bradford])
    profile = read_characterisation(made_profile({**MATRIX, "chad": chad}, pcs="XYZ ", kind="mntr"))
    white, warnings = profile.native_white()
    np.testing.assert_allclose(white, [0.9505, 1, 1.0891], atol=1e-3)
    assert warnings == []
    assert profile.provenance["chromatic_adaptation"]["tag"] == "chad"
    assert read_characterisation(made_profile(MATRIX)).native_white() == (None, [])


@pytest.mark.parametrize("chad", [b"sf32" + bytes(40), b"sf32" + bytes(10), b"text" + bytes(40)])
def test_a_broken_adaptation_is_warned_of(made_profile, chad):
    profile = read_characterisation(made_profile({**MATRIX, "chad": chad}, pcs="XYZ ", kind="mntr"))
    assert "chad" in profile.warnings[0]
    assert profile.transform("relative")[0].tag.startswith("rXYZ")


def test_channels_are_inks_or_not(made_profile):
    kinds = {"RGB ": False, "GRAY": False, "CMYK": True, "CMY ": True, "7CLR": True}
    assert {
        space: read_characterisation(made_profile({}, space=space)).inks for space in kinds
    } == kinds


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda d: d[:131], {"field": "size"}),
        (lambda d: d[:128] + b"\xff\xff\xff\xff" + d[132:], {"field": "tag_count"}),
        (lambda d: d[:200], {"field": "tag_count"}),
        (lambda d: d[:20] + b"Luv " + d[24:], {"field": "pcs"}),
    ],
)
def test_broken_headers_are_refused(made_profile, change, where):
    with pytest.raises(MalformedProfileError) as caught:
        read_characterisation(change(made_profile(MATRIX, pcs="XYZ ")))
    assert caught.value.where == where


@pytest.mark.parametrize(
    ("tags", "tag"),
    [
        ({}, "A2B1"),
        ({**MATRIX, "gTRC": b"text" + bytes(8)}, "gTRC"),
        ({k: v for k, v in MATRIX.items() if k != "bXYZ"}, "bXYZ"),
        ({**MATRIX, "rXYZ": b"XYZ " + bytes(8)}, "rXYZ"),
        ({**MATRIX, "rXYZ": b"sf32" + bytes(16)}, "rXYZ"),
        ({**MATRIX, "A2B0": b""}, "A2B0"),
    ],
)
def test_broken_transforms_name_their_tag(made_profile, tags, tag):
    profile = read_characterisation(made_profile(tags, pcs="XYZ ", kind="mntr"))
    with pytest.raises(MalformedProfileError) as caught:
        profile.transform("relative")
    assert caught.value.where == {"tag": tag}


@pytest.mark.parametrize("white", [xyz(0, 1, 1), xyz(-1, 1, 1), xyz(30000, 1, 1), b"XYZ "])
def test_a_white_that_is_none_is_refused(made_profile, white):
    profile = read_characterisation(made_profile({"wtpt": white}))
    with pytest.raises(MalformedProfileError) as caught:
        profile.media_white()
    assert caught.value.where == {"tag": "wtpt"}


def test_files_that_crashed_other_software(shared_data):
    files = sorted((shared_data / "malformed").glob("*.icc"))
    assert files
    for file in files:
        data = file.read_bytes()
        try:
            transform, _ = read_characterisation(data).transform("relative")
            assert np.isfinite(transform.pcs_values(np.eye(3))).all()
        except GamutError as error:
            assert error.where, file.name  # noqa: PT017 (some of the files are read)


@settings(max_examples=300)
@given(seed=st.integers(0, 2**32))
def test_mutated_profiles_are_read_or_refused(seed, small_profile, made_profile):
    chance = random.Random(seed)  # noqa: S311
    lut = (
        struct.pack(">4sIBBBB", b"mft2", 0, 3, 3, 2, 0)
        + bytes(36)
        + b"\0\2\0\2"
        + b"\0\0\xff\xff" * 18
    )
    base = chance.choice(
        [
            small_profile("sRGB-v4.icc"),
            small_profile("sRGB-v2-magic.icc"),
            small_profile("sGrey-v4.icc"),
            made_profile({"A2B0": lut, "wtpt": xyz(0.9, 1, 0.8)}),
        ]
    )
    data = bytearray(base)
    for _ in range(chance.randint(1, 10)):
        place = chance.choice([chance.randrange(len(data)), chance.randrange(128, 300)])
        data[place % len(data)] = chance.choice([0, 1, 127, 255, chance.randrange(256)])
    if chance.random() < 0.2:
        del data[chance.randrange(len(data)) :]
    try:
        profile = read_characterisation(bytes(data))
        for intent in ("relative", "perceptual"):
            transform, _ = profile.transform(intent)
            points = np.random.default_rng(0).random((20, len(profile.channels)))
            assert np.isfinite(transform.pcs_values(points)).all()
        assert np.isfinite(profile.media_white()[0]).all()
    except GamutError:
        return


def test_descriptions_of_both_versions(made_profile):
    old = b"desc" + bytes(4) + struct.pack(">I", 6) + b"Press\0"
    text = "Drück".encode("utf-16-be")
    new = b"mluc" + bytes(4) + struct.pack(">II2s2sII", 1, 12, b"de", b"DE", len(text), 28) + text
    for data, name in ((old, "Press"), (new, "Drück"), (b"desc", ""), (b"text" + bytes(8), "")):
        profile = read_characterisation(made_profile({"desc": data}))
        assert profile.provenance["description"] == name
    assert read_characterisation(made_profile({})).provenance["description"] == ""
