"""Profiles: files read by Argyll, lcms, iccDEV and this package, against the device model."""

import re
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageCms

import gamutcore
from gamutcore import Gamut, profile
from gamutcore.characterisation import read_characterisation
from gamutcore.characterisation.icc.transforms import largest_output_sum
from gamutcore.cli.app import app, run
from gamutcore.errors import DeviceModelError, GamutError, OptionError
from gamutcore.search import delta_e_2000

DATA = Path(__file__).parents[2] / "data"
PRESS = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"
COARSE = {"surface_samples": 2000, "ink_limit": 300}
TO_XYZ = np.array([(0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505)])


@pytest.fixture(scope="module")
def press():
    return Gamut(PRESS, space="CAM16-UCS", **COARSE)


@pytest.fixture(scope="module")
def srgb():
    return gamutcore.reference("srgb", space="CAM16-UCS", surface_samples=2000)


@pytest.fixture(scope="module")
def made(srgb):
    return profile(PRESS, size=17, source_gamut=srgb, **COARSE)


@pytest.fixture(scope="module")
def fourth(press, srgb):
    return profile(press, size=17, version=4, source_gamut=srgb)


@pytest.fixture(scope="module")
def fifth(srgb):
    options = {"version": 5, "gamut_boundary": True, "triangles": 500, "source_gamut": srgb}
    return profile(PRESS, size=9, **options, **COARSE)


@pytest.fixture(scope="module")
def path(made, tmp_path_factory):
    path = tmp_path_factory.mktemp("profiles") / "press.icc"
    made.save(path)
    return path


def colours_of(press, device):
    return press.to_colour(device, space="CIELAB")


def printable(count, seed=1):
    values = np.random.default_rng(seed).random((4 * count, 4))
    return values[values.sum(axis=1) <= 3.0][:count]


def xicclu(path, way, rows, *options):
    """Return what Argyll's xicclu gives for rows, with the relative intent unless asked."""
    if shutil.which("xicclu") is None:
        pytest.skip("Argyll CMS is not installed")
    command = ["xicclu", "-v0", way, "-pl", *(options or ("-ir",)), path]
    asked = "\n".join(" ".join(map(repr, row)) for row in np.asarray(rows, float).tolist())
    answer = subprocess.run(command, input=asked, text=True, capture_output=True, check=True)
    lines = [line.split() for line in answer.stdout.splitlines() if line.strip()]
    return np.array([[float(part) for part in line if part != "(clip)"] for line in lines])


def display(light, label="DISPLAY"):
    """Return measurements of a display as text: tristimulus values of linear red, green, blue."""
    steps = np.linspace(0.0, 1.0, 8)
    rgb = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    rows = np.hstack([100.0 * rgb, 100.0 * light(rgb**2.2) @ TO_XYZ.T])
    table = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in rows)
    return (
        f'CTI3\n\nDEVICE_CLASS "{label}"\nNUMBER_OF_FIELDS 6\nBEGIN_DATA_FORMAT\n'
        "RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z\nEND_DATA_FORMAT\n"
        f"NUMBER_OF_SETS {len(rows)}\nBEGIN_DATA\n{table}\nEND_DATA\n"
    ).encode()


@pytest.mark.slow
def test_argyll_gives_the_colours_of_the_model_and_recipes_for_them(path, press, made):
    device = printable(2000)
    lab = colours_of(press, device)
    forward = delta_e_2000(xicclu(path, "-ff", device), lab)
    # Argyll interpolates in simplices, and the figures are of multilinear interpolation
    assert forward.mean() < 2.0 * made.forward.mean
    assert forward.max() < 2.0 * made.forward.worst
    found = xicclu(path, "-fb", lab)
    back = delta_e_2000(xicclu(path, "-ff", found), lab)
    assert back.mean() < 1.2 * made.round_trip.mean
    assert (back > made.round_trip.percentile_95).mean() < 0.07
    assert delta_e_2000(colours_of(press, np.clip(found, 0, 1)), lab).mean() < back.mean() + 0.05


@pytest.mark.slow
def test_measured_patches_have_their_colours(path):
    if shutil.which("profcheck") is None:
        pytest.skip("Argyll CMS is not installed")
    asked = ["profcheck", "-k", PRESS, path]
    answer = subprocess.run(asked, capture_output=True, text=True, check=True).stdout
    worst, mean = (float(each) for each in re.findall(r"(?:max|avg)\. = ([0-9.]+)", answer))
    # a profile of colprof -qh has 0.035 and 0.334
    assert mean < 0.02
    assert worst < 0.3


@pytest.mark.slow
def test_white_and_solid_inks_survive(path, press):
    np.testing.assert_allclose(xicclu(path, "-fb", [(100, 0, 0)]), np.zeros((1, 4)), atol=5e-4)
    np.testing.assert_allclose(xicclu(path, "-ff", np.zeros((1, 4))), [(100, 0, 0)], atol=2e-3)
    np.testing.assert_allclose(
        xicclu(path, "-ff", np.zeros((1, 4)), "-ia"), [(95.0, 0.0, -2.0)], atol=0.01
    )
    solids = np.concatenate([np.eye(4), [(1, 1, 0, 0), (1, 0, 1, 0), (0, 1, 1, 0)]])
    lab = colours_of(press, solids)
    assert delta_e_2000(xicclu(path, "-ff", solids), lab).max() < 0.1
    found = np.clip(xicclu(path, "-fb", lab), 0, 1)
    assert delta_e_2000(colours_of(press, found), lab).max() < 1.5  # corners between 17 nodes


@pytest.mark.slow
def test_colours_out_of_gamut_are_clipped_to_near_ones(path, press):
    colours = np.random.default_rng(3).random((1000, 3)) * (100, 200, 200) - (0, 100, 100)
    colours = colours[~press.contains(colours, space="CIELAB")]
    found = np.clip(xicclu(path, "-fb", colours), 0, 1)
    missed = delta_e_2000(colours_of(press, found), colours)
    nearest = delta_e_2000(press.nearest(colours, space="CIELAB").points, colours)
    assert missed.mean() < 1.02 * nearest.mean()
    assert found.sum(axis=1).max() <= 3.0 + 1e-4


@pytest.mark.parametrize("version", [2, 4])
@pytest.mark.slow
def test_every_table_keeps_the_ink_limit(made, fourth, version):
    made = made if version == 2 else fourth
    read = read_characterisation(made.to_bytes())
    assert read.version[0] == version
    for tag in ("B2A0", "B2A1", "B2A2"):
        assert largest_output_sum(read.element(tag), 4) <= 3.0 + 1e-4
    assert {"A2B0", "A2B1", "A2B2", "gamt", "wtpt", "desc", "cprt"} <= set(read.tags)
    assert ("bkpt" in read.tags) == (version == 2)


@pytest.mark.slow
def test_the_measurements_are_kept(path, press):
    kept = Gamut(path, source="measurements", space="CAM16-UCS", **COARSE)
    assert kept.volume == pytest.approx(press.volume, rel=1e-9)


@pytest.mark.parametrize("version", [2, 4])
@pytest.mark.slow
def test_lcms_converts_pictures(made, fourth, press, version, tmp_path):
    path, made = tmp_path / "press.icc", made if version == 2 else fourth
    made.save(path)
    opened = ImageCms.getOpenProfile(str(path))
    assert opened.profile.device_class == "prtr"
    assert f"worst {made.round_trip.worst:.2f} dE00" in opened.profile.profile_description
    # inside of the gamut of the press, so the relative intent keeps the colour
    rgb = np.random.default_rng(4).integers(90, 170, (1, 200, 3), np.uint8)
    srgb = ImageCms.createProfile("sRGB")
    intent = ImageCms.Intent.RELATIVE_COLORIMETRIC
    to_press = ImageCms.buildTransform(srgb, opened, "RGB", "CMYK", intent)
    inks = np.asarray(ImageCms.applyTransform(Image.fromarray(rgb), to_press))[0] / 255.0
    lab = gamutcore.reference("srgb", surface_samples=1000).convert(rgb[0] / 255.0, "sRGB")
    inside = press.contains(lab, space="CIELAB")
    assert inside.sum() > 100
    assert delta_e_2000(colours_of(press, inks), lab)[inside].mean() < 0.6  # 8 bits


@pytest.mark.slow
def test_the_perceptual_intent_of_version_4_has_the_black_of_the_reference_medium(press, fourth):
    read = read_characterisation(fourth.to_bytes())
    black = press.to_device((0, 0, 0), space="CIELAB").device[np.newaxis]
    lightness = read.transform("perceptual")[0].pcs_values(black)[0, 0]
    assert lightness == pytest.approx(3.1373, abs=1.0)  # ICC.1:2010, 6.3.4.3; the black is brownish
    assert read.transform("relative")[0].pcs_values(black)[0, 0] > 8.0


@pytest.mark.slow
def test_version_5_has_the_same_tables_and_a_boundary_with_device_values(fifth, made, press):
    one, two = (read_characterisation(each.to_bytes()) for each in (made, fifth))
    device = printable(500)
    for intent in ("relative", "saturation"):
        colours = [each.transform(intent)[0].pcs_values(device) for each in (one, two)]
        np.testing.assert_allclose(*colours, atol=4e-3)  # half a step of 16 bits each
    for tag in ("B2A0", "B2A1", "B2A2"):
        assert largest_output_sum(two.element(tag), 4) <= 3.0 + 1e-4
    cielab = Gamut(PRESS, **COARSE)
    level = Gamut(fifth.to_bytes(), source="boundary")
    assert level.volume == pytest.approx(cielab.mesh(500).volume, rel=1e-6)
    element = two.element("gbd1")
    count, faces = element.unsigned(12, 4), element.unsigned(16, 4)
    numbers = element.floats(20 + 12 * faces, 7 * count)
    lab, inks = numbers[: 3 * count].reshape(-1, 3), numbers[3 * count :].reshape(-1, 4)
    assert inks.sum(axis=1).max() <= 3.0 + 1e-4
    # vertices are rounded and merged, and samples of the surface are not exact elsewhere
    assert np.median(delta_e_2000(colours_of(press, inks), lab)) < 0.1


@pytest.mark.slow
def test_a_boundary_needs_version_5_and_measurements(press):
    for choices, field in (
        ({"gamut_boundary": True}, "gamut_boundary"),
        ({"gamut_boundary": True, "version": 4}, "gamut_boundary"),
        ({"version": 5, "triangles": 500}, "triangles"),
        ({"version": 5, "gamut_boundary": True}, "gamut_boundary"),  # not in CIELAB
    ):
        with pytest.raises(OptionError) as refused:
            profile(press, **choices)
        assert refused.value.where["field"] == field
        assert refused.value.remedy != "Leave it out."


@pytest.mark.slow
def test_gamt_has_the_size_of_the_other_tables(made):
    read = read_characterisation(made.to_bytes())
    element = read.element("gamt")
    assert element.data[:4] == b"mft2"
    assert tuple(element.data[8:11]) == (3, 1, 17)


@pytest.mark.skipif(shutil.which("transicc") is None, reason="liblcms2-utils is not installed")
@pytest.mark.slow
def test_transicc_gives_colours_and_recipes(made, fourth, fifth, press, tmp_path):
    def transicc(rows, *options):
        asked = "\n".join(" ".join(map(repr, row)) for row in rows.tolist())
        command = ["transicc", "-n", "-t1", *options]
        answer = subprocess.run(command, input=asked, text=True, capture_output=True, check=True)
        return np.array([line.split() for line in answer.stdout.splitlines()], float)

    path, device = tmp_path / "press.icc", printable(500)
    lab = colours_of(press, device)
    for each in (made, fourth, fifth):
        each.save(path)
        forward = delta_e_2000(transicc(100.0 * device, f"-i{path}", "-o*Lab4"), lab)
        assert forward.mean() < 2.0 * each.forward.mean
        assert forward.max() < 2.0 * each.forward.worst
        found = np.clip(transicc(lab, "-i*Lab4", f"-o{path}") / 100.0, 0.0, 1.0)
        back = delta_e_2000(colours_of(press, found), lab)
        assert back.mean() < 1.2 * each.round_trip.mean + 0.05


@pytest.mark.skipif(find_spec("iccdev") is None, reason="iccdev is not installed")
@pytest.mark.slow
def test_the_reference_implementation_finds_no_fault(made, fourth, fifth):
    iccdev = pytest.importorskip("iccdev")
    for each in (made, fourth, fifth):
        status, report = iccdev.validate_profile(each.to_bytes())
        assert (status, report) == (iccdev.ValidationStatus(0), "")


@pytest.mark.slow
def test_an_additive_display_has_a_matrix_and_another_one_tables(srgb, tmp_path):
    choices = {"surface_samples": 2000, "device_model": "fit", "size": 9, "source_gamut": srgb}
    additive = profile(display(lambda light: 0.002 + 0.998 * light), **choices)
    assert (additive.device_class, additive.form, additive.round_trip) == ("mntr", "matrix", None)
    assert additive.forward.percentile_95 < 0.5
    other = profile(
        display(lambda light: 0.8 * light + 0.2 * light.min(axis=1, keepdims=True)), **choices
    )
    assert (other.device_class, other.form) == ("mntr", "tables")
    path = tmp_path / "display.icc"
    additive.save(path)
    opened = ImageCms.getOpenProfile(str(path))
    assert opened.profile.device_class == "mntr"
    # the tag chad has the way from the white of sRGB's primaries
    adaptation = read_characterisation(additive.to_bytes()).adaptation_to_d50()
    white = np.linalg.solve(adaptation, (0.9642, 1.0, 0.8249))
    np.testing.assert_allclose(white / white[1], TO_XYZ.sum(axis=1), atol=2e-3)
    printer = profile(display(lambda light: light, "OUTPUT"), **choices)
    assert printer.device_class == "prtr"


@pytest.mark.slow
def test_equal_inputs_give_equal_bytes(press, srgb):
    one, two = (profile(press, size=9, source_gamut=srgb).to_bytes() for _ in range(2))
    assert one == two
    assert "targ" not in read_characterisation(one).tags  # a gamut keeps no measurements


@pytest.mark.parametrize(
    ("data", "choices", "field"),
    [
        (None, {"version": 3}, "version"),
        (None, {"size": 8}, "size"),
        (None, {"black": 1.5}, "black"),
        (None, {"intent": "absolute"}, "intent"),
        (None, {"source_gamut": "rec2021"}, "source_gamut"),
        (None, {"nonsense": 1}, "nonsense"),
        (DATA / "sGrey-v4.icc", {}, "channels"),
    ],
)
def test_refusals_name_the_argument(few_patches, data, choices, field):
    with pytest.raises(GamutError) as refused:
        profile(data or few_patches, **{"surface_samples": 500, **choices})
    assert refused.value.where["field"] == field
    assert refused.value.remedy


def test_data_without_a_device_model_is_refused(screen):
    with pytest.raises(DeviceModelError, match="colours only"):
        profile(100.0 * np.random.default_rng(0).random((50, 3)))
    with pytest.raises(OptionError, match="built already"):
        profile(screen("srgb"), ink_limit=280)


@pytest.mark.slow
def test_command(tmp_path, capsys):
    path = tmp_path / "press.icc"
    asked = ["profile", str(PRESS), "-o", str(path), "--size", "9", "--ink-limit", "300"]
    assert run(app, [*asked, "--surface-samples", "2000", "--name", "Coated"]) == 0
    printed = capsys.readouterr().out
    assert "Output profile of Coated, version 2, tables. Error: mean" in printed
    assert "Coated: error of A2B mean" in read_characterisation(path.read_bytes()).description
    assert list(tmp_path.iterdir()) == [path]
    asked[3] = str(tmp_path / "press.cube")
    assert run(app, asked) == 2
    assert "ends in .icc or .icm" in capsys.readouterr().err
