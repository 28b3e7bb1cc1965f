import json
import struct

import numpy as np
import pytest

from gamutcore.characterisation import Picture, read_characterisation
from gamutcore.colours import surface_colours
from gamutcore.errors import GamutError, MalformedProfileError, OptionError


def document(columns, rows, **members):
    return json.dumps({"columns": columns.split(), "samples": rows, **members}).encode()


def rgb_cube(steps, function):
    values = np.linspace(0, 1, steps)
    device = np.stack(np.meshgrid(values, values, values), axis=-1).reshape(-1, 3)
    return np.column_stack([device, function(device)])


def lab(device):
    return np.column_stack([100 * device.mean(axis=1), 100 * (device[:, :2] - device[:, 1:])])


def test_the_surface_of_a_press(fogra39):
    surface = surface_colours(read_characterisation(fogra39), surface_samples=5000)
    assert 4500 < len(surface.points) <= 5000
    assert surface.device.shape == (len(surface.points), 4)
    white = surface.points[(surface.device == 0).all(axis=1)]
    np.testing.assert_allclose(white, [[100, 0, 0]], atol=0.1)
    provenance = surface.provenance
    assert provenance["patches"] == {"read": 1617, "averaged": 29, "dropped": 0, "used": 1588}
    assert provenance["model"]["leave_out_error"]["mean"] == pytest.approx(0.13, abs=0.01)
    assert provenance["model"]["leave_out_error"]["percentile_95"] < 0.5
    assert provenance["warnings"] == []
    json.dumps(provenance, allow_nan=False)


@pytest.mark.slow
def test_the_model_agrees_with_the_profile_of_the_same_press(shared_data, fogra39):
    profile = read_characterisation(
        (shared_data / "press" / "ISOcoated_v2_300_bas.icc").read_bytes()
    )
    surface = surface_colours(
        read_characterisation(fogra39), intent="absolute", surface_samples=10_000
    )
    # Up to the profile's ink limit of 300 %.
    printed = surface.device.sum(axis=1) <= 3
    ones = np.ones(printed.sum(), np.int64)
    picture = Picture("tiff", "CMYK", surface.device[printed], ones, profile)
    expected = surface_colours(picture, intent="absolute").points
    errors = np.linalg.norm(surface.points[printed] - expected, axis=1)
    assert errors.mean() < 0.5


def test_the_surface_of_a_profile(small_profile):
    profile = read_characterisation(small_profile("DisplayP3-v4.icc"))
    surface = surface_colours(profile)
    assert 99_000 < len(surface.points) <= 100_000
    assert surface.provenance["surface"]["density"] == "by curvature"
    assert surface.points[:, 0].min() == pytest.approx(0, abs=1e-6)
    provenance = surface.provenance
    assert provenance["device_class"] == "display"
    assert provenance["intent"] == "relative"
    assert provenance["model"]["name"] == "ICC profile"
    assert provenance["model"]["kind"] == "matrix and curves"
    # P3's D65 was adapted to D50.
    white = provenance["chromatic_adaptation"]["white"]
    np.testing.assert_allclose(white, [0.9505, 1, 1.0891], atol=2e-3)
    assert "ink_limits" not in provenance
    json.dumps(provenance, allow_nan=False)


def test_a_broken_white_matters_to_absolute_colours_only(small_profile):
    data = small_profile("sRGB-v2-magic.icc")
    offset = data.index(b"XYZ ", 132)
    profile = read_characterisation(data[: offset + 8] + bytes(12) + data[offset + 20 :])
    surface = surface_colours(profile, surface_samples=1000)
    assert surface.provenance["white"] is None
    assert any("white" in said for said in surface.provenance["warnings"])
    with pytest.raises(MalformedProfileError):
        surface_colours(profile, intent="absolute", surface_samples=1000)


def test_a_linear_device_is_sampled_exactly():
    data = document("R G B L a b", rgb_cube(4, lab).tolist())
    surface = surface_colours(read_characterisation(data), intent="absolute", surface_samples=1000)
    np.testing.assert_allclose(surface.points, lab(surface.device), atol=1e-6)


def test_many_samples_are_thinned_with_a_warning(monkeypatch):
    monkeypatch.setattr("gamutcore.colours.device_model.MAX_MODEL_SAMPLES", 100)
    beside = np.array([[0.5, 0.5, 0.55]])
    rows = [*rgb_cube(7, lab), *np.column_stack([beside, lab(beside)])]
    data = document("R G B L a b", [row.tolist() for row in rows])
    surface = surface_colours(read_characterisation(data), intent="absolute", surface_samples=1000)
    assert surface.provenance["patches"]["used"] == 100
    assert surface.provenance["patches"]["dropped"] == 244
    assert any("100 of 344" in said for said in surface.provenance["warnings"])
    np.testing.assert_allclose(surface.points, lab(surface.device), atol=1e-6)


def test_a_channel_that_is_never_used_is_left_out():
    rows = np.insert(rgb_cube(4, lab), 3, 0, axis=1)
    data = document("CMYK_C CMYK_M CMYK_Y CMYK_K L a b", rows.tolist())
    surface = surface_colours(read_characterisation(data), intent="absolute", surface_samples=1000)
    assert set(surface.device[:, 3]) == {0.0}
    assert any("K was measured" in said for said in surface.provenance["warnings"])


def test_the_measured_range_is_not_left():
    rows = rgb_cube(4, lab)
    rows[:, :3] *= 80
    data = document("C M Y L a b", rows.tolist())
    surface = surface_colours(read_characterisation(data), intent="absolute", surface_samples=1000)
    assert surface.device.max() == pytest.approx(0.8)
    assert any("80 %" in said for said in surface.provenance["warnings"])


def test_ink_sums_beyond_the_measured_are_warned_of():
    rows = rgb_cube(4, lab)
    limited = rows[rows[:, :3].sum(axis=1) < 2.5]
    data = document("C M Y L a b", limited.tolist())
    surface = surface_colours(read_characterisation(data), intent="absolute", surface_samples=1000)
    assert any("extrapolated" in said for said in surface.provenance["warnings"])


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        ([[0, 0, 0, 10, 0, 0]], "one distinct device value"),
        ([[i, i, i, i / 3, 0, 0] for i in range(256)], "lie in a plane"),
        ([[0, 0, 0, 10, 0, 0]] * 10, "one distinct device value"),
        (
            [[0, 0, 0, 0, 0, 0], [9, 0, 1, 40, 8, 9], [255] * 3 + [99, 9, 0]],
            "3 samples for 3 channels",
        ),
    ],
)
def test_samples_without_a_model_are_used_themselves(rows, why):
    samples = read_characterisation(document("R G B L a b", rows))
    surface = surface_colours(samples, intent="absolute")
    assert len(surface.points) == len({tuple(row) for row in rows})
    assert any("No device model" in said for said in surface.provenance["warnings"])
    with pytest.raises(OptionError, match=r"'fit' does not apply: no device model") as caught:
        surface_colours(samples, intent="absolute", model="fit")
    assert why in caught.value.message
    assert caught.value.where == {"field": "device_model"}
    assert "distinct device values" in caught.value.remedy


def test_the_device_model_of_a_grid_can_be_chosen():
    samples = read_characterisation(document("R G B L a b", rgb_cube(5, lab).tolist()))
    named = {
        kind: surface_colours(samples, intent="absolute", model=kind).provenance["model"]["name"]
        for kind in (None, "interpolation", "fit")
    }
    assert named[None] == named["interpolation"] == "n-linear interpolation of a complete grid"
    assert named["fit"] == "radial basis functions"


def test_fifteen_inks_have_their_corners(made_profile):
    import struct

    head = struct.pack(">4sIBBBB", b"mft1", 0, 15, 3, 2, 0) + bytes(36)
    lut = head + bytes(range(256)) * 15 + bytes(3 * 2**15) + bytes(range(256)) * 3
    profile = read_characterisation(made_profile({"A2B0": lut}, space="FCLR"))
    surface = surface_colours(profile, surface_samples=1000)
    assert len(surface.points) == 2**15
    assert any("corners" in said for said in surface.provenance["warnings"])


@pytest.mark.parametrize("intent", ["", "best", "absolute colorimetric"])
def test_unknown_intents_are_refused(fogra39, intent):
    with pytest.raises(OptionError) as caught:
        surface_colours(read_characterisation(fogra39), intent=intent)
    assert caught.value.where == {"field": "intent"}


def test_every_malformed_profile_is_refused_or_read(shared_data):
    for file in sorted((shared_data / "malformed").iterdir()):
        try:
            surface = surface_colours(
                read_characterisation(file.read_bytes()), surface_samples=1000
            )
        except GamutError:
            continue
        assert np.isfinite(surface.points).all(), file.name


@pytest.mark.parametrize(
    ("stated", "expected"),
    [(struct.pack(">3i", 0, 250 << 16, 0), 250.0), (b"", None), (bytes(12), None)],
)
def test_the_luminance_that_a_profile_states(small_profile, stated, expected):
    """The tag `lumi`, ICC.1:2022, 9.2.33: Y in cd/m²; a broken tag is ignored."""
    data = bytearray(small_profile("sRGB-v4.icc"))
    entry = data.index(b"cprt", 128)
    data[entry : entry + 12] = struct.pack(">4sII", b"lumi", len(data), 8 + len(stated))
    data += b"XYZ \0\0\0\0" + stated
    data[:4] = struct.pack(">I", len(data))
    surface = surface_colours(read_characterisation(bytes(data)), surface_samples=100)
    assert surface.provenance.get("white_luminance") == expected


@pytest.mark.parametrize("names", ["R G B", "CMY_C CMY_M CMY_Y"])
def test_too_few_samples_for_the_faces_are_told_as_such(names):
    data = document(f"{names} L a b", rgb_cube(4, lab).tolist())
    surface = surface_colours(read_characterisation(data), intent="absolute", surface_samples=8)
    assert len(surface.points) == 8
    (said,) = (text for text in surface.provenance["warnings"] if "corners" in text)
    assert said.endswith(
        "sampled; points on its faces as well would be more than surface_samples, 8."
    )


@pytest.mark.slow
def test_too_many_faces_are_told_as_such():
    """14 inks have C(14, 2)·2^12 = 372,736 two-dimensional faces."""
    inks = (np.arange(1 << 14)[:, np.newaxis] >> np.arange(14)) & 1
    names = " ".join(f"14CLR_{ink}" for ink in range(1, 15))
    rows = np.column_stack([inks, 100 - 5 * inks.sum(axis=1), inks[:, :2] * 20])
    samples = read_characterisation(document(f"{names} L a b", rows.tolist()))
    surface = surface_colours(samples, intent="absolute", surface_samples=250_000)
    assert len(surface.points) == 1 << 14
    assert surface.provenance["patches"]["dropped"] == 0
    said = surface.provenance["warnings"][-1]
    assert said == "Only the 16384 corners of the device cube were sampled; its faces are too many."
