"""Recipes: device values that give a colour, for presses, profiles and displays."""

from __future__ import annotations

import json
import shutil
import subprocess
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from safetensors.numpy import load
from safetensors.numpy import save as save_tensors
from scipy.optimize import least_squares

from gamutcore import Gamut, reference
from gamutcore.colours import DeviceModel
from gamutcore.errors import (
    DeviceModelError,
    GamutError,
    HistoryFileError,
    InvalidPointsError,
    OptionError,
)
from gamutcore.questions import black_rule
from gamutcore.search import delta_e_2000

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.arrays import FloatArray

ROOT = Path(__file__).parents[3]
SHARED = ROOT.parent / "shared" / "data"
LIMIT = 3.0
SAMPLES: dict[str, Any] = {"surface_samples": 4000}


@lru_cache(maxsize=4)
def press(name: str = "FOGRA39L.ti3", **options: Any) -> Gamut:
    return Gamut(ROOT / "examples" / name, ink_limit=100 * LIMIT, **SAMPLES, **options)


def shared(name: str) -> Path:
    path = SHARED / name
    if not path.is_file():
        pytest.skip(f"needs {name} of the shared data")
    return path


def printable(count: int, channels: int, limit: float = LIMIT) -> FloatArray:
    values = np.random.default_rng(5).random((count, channels))
    return values[values.sum(axis=1) <= limit]


@pytest.mark.slow
@pytest.mark.parametrize("black", ["light", "medium", "heavy", "max", "none", "least-ink", 0.3])
def test_recipes_of_printable_colours_give_them(black: str | float) -> None:
    gamut = press()
    colours = gamut.to_colour(printable(250, 4))
    found = gamut.to_device(colours, black=black)
    errors = delta_e_2000(colours, gamut.to_colour(found.device))
    assert np.median(errors) <= 0.01
    assert np.percentile(errors, 99.9) <= 0.1
    assert found.device.min() >= 0.0
    assert found.device.max() <= 1.0
    assert found.device.sum(axis=1).max() <= LIMIT + 1e-5
    np.testing.assert_allclose(found.points, gamut.to_colour(found.device), atol=1e-9)
    # where the boundary is exact, no printable colour is outside of it
    np.testing.assert_allclose(found.delta_e[found.inside], errors[found.inside], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "black",
    ["medium", *(pytest.param(each, marks=pytest.mark.slow) for each in ("max", "least-ink"))],
)
def test_colours_that_nothing_prints_keep_the_limits(black: str) -> None:
    """The inverse model is asked directly, as for nodes of tables: nothing is mapped before."""
    gamut, rule = press(), black_rule(black)
    lab = np.random.default_rng(0).uniform((0, -100, -100), (100, 100, 100), (1000, 3))
    device = gamut.inverse_model.recipes(lab, rule).device
    assert device.min() >= 0.0
    assert device.max() <= 1.0
    assert device.sum(axis=1).max() <= LIMIT + 1e-5


@pytest.mark.slow
def test_the_range_of_black_contains_what_made_the_colour() -> None:
    gamut, device = press(), printable(250, 4)
    found = gamut.to_device(gamut.to_colour(device))
    assert found.black_least is not None
    assert found.black_most is not None
    black = device[:, 3]
    within = (black >= found.black_least - 0.005) & (black <= found.black_most + 0.005)
    assert within.mean() >= 0.999


@pytest.mark.slow
@pytest.mark.parametrize("colour", [(60, 0, 0), (40, 20, 10), (55, -20, 25), (30, 5, -15)])
def test_no_recipe_exists_outside_of_the_range_of_black(colour: tuple[float, ...]) -> None:
    """A solver of its own looks for C, M and Y at amounts of black in and out of the range."""
    gamut = press()
    found = gamut.to_device(colour)
    assert found.black_least is not None
    assert found.black_most is not None
    least, most = found.black_least.item(), found.black_most.item()

    def missed(black: float) -> float:
        def rest(inks: FloatArray) -> FloatArray:
            over = max(0.0, inks.sum() + black - LIMIT)
            colour_of = gamut.to_colour((*np.clip(inks, 0, 1), black))
            return np.append(colour_of - colour, 100 * over)

        starts = ((0.2, 0.2, 0.2), (0.6, 0.6, 0.6), (0.1, 0.5, 0.5))
        return min(
            float(np.abs(least_squares(rest, start, bounds=(0, 1)).fun).max()) for start in starts
        )

    assert missed(0.5 * (least + most)) < 0.02
    assert missed(least + 0.002) < 0.1
    assert missed(most - 0.002) < 0.1
    assert least == 0.0 or missed(least - 0.03) > 0.1
    assert most == 1.0 or missed(most + 0.03) > 0.1


@pytest.mark.slow
def test_rules_of_black_are_kept() -> None:
    gamut = press()
    colours = gamut.to_colour(printable(250, 4))
    rules: dict[str, Any] = {
        "none": "none", "half": 0.5, "maximum": "max", "least": "least-ink",
        "curve": [(0, 0.9), (40, 0.2), (100, 0.0)],
    }  # fmt: skip
    found = {name: gamut.to_device(colours, black=rule) for name, rule in rules.items()}
    black = {name: each.device[:, 3] for name, each in found.items()}
    least, most = found["half"].black_least, found["half"].black_most
    assert least is not None
    assert most is not None
    np.testing.assert_allclose(black["none"], least, atol=0.02)
    np.testing.assert_allclose(black["half"], 0.5 * (least + most), atol=0.02)
    np.testing.assert_allclose(black["maximum"], most, atol=0.02)
    wanted = np.interp(colours[:, 0], [0, 40, 100], [0.9, 0.2, 0.0])
    np.testing.assert_allclose(black["curve"], np.clip(wanted, least, most), atol=0.02)
    ink = {name: each.device.sum(axis=1) for name, each in found.items()}
    for name in ("none", "half", "maximum"):
        assert (ink["least"] <= ink[name] + 0.02).all()


MAKERS_BLACK = {
    30: (59.2, (50.5, 55.5, 60.8, 64.7, 62.2, 58.5, 53.9, 49.4, 42.0, 36.3, 36.1, 41.2),
         (36.4, 45.7, 52.0, 58.0, 53.8, 50.4, 45.1, 36.2, 21.7, 9.2, 7.9, 18.6)),
    50: (26.3, (20.2, 23.8, 28.0, 30.9, 28.0, 24.2, 21.0, 19.0, 15.5, 11.8, 11.1, 14.2),
         (11.3, 16.3, 24.0, 31.8, 24.6, 17.0, 11.8, 9.5, 4.8, 0.0, 0.0, 1.3)),
    70: (6.4, (3.4, 4.3, 6.8, 8.8, 6.6, 3.8, 2.1, 2.2, 2.0, 0.4, 0.0, 1.0),
         (0.0, 0.0, 3.4, 9.9, 3.6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
}  # fmt: skip
"""Per cent of black by L*, of C* 0, and of C* 20 and 40 at hues of 0 to 330 degrees: the table B2A1
of ISOcoated_v2_300_bas.icc by ``xicclu -fb -ir``. It was made from the data of FOGRA39L."""


@pytest.mark.slow
def test_medium_replacement_has_the_black_of_makers_tables() -> None:
    colours, expected = [], []
    for lightness, (gray, *circles) in MAKERS_BLACK.items():
        colours.append((lightness, 0.0, 0.0))
        expected.append(gray)
        for chroma, circle in zip((20.0, 40.0), circles, strict=True):
            hues = np.radians(np.arange(0, 360, 30))
            colours += [(lightness, chroma * np.cos(h), chroma * np.sin(h)) for h in hues]
            expected += circle
    difference = 100.0 * press().to_device(colours).device[:, 3] - expected
    assert np.abs(difference).mean() <= 8.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("colour", "black"), [((50, 0, 0), 26), ((68, 0, 0), 7), ((80, 0, 0), 2), ((72, 16, 20), 3)]
)
def test_greys_and_skin_have_the_black_of_eci(colour: tuple[float, ...], black: float) -> None:
    """PSOcoated_v3, B2A1: 26, 7, 2, and skin 9/34/43/3."""
    assert 100.0 * press().to_device(colour).device[3] == pytest.approx(black, abs=3)


@pytest.mark.slow
def test_presets_are_ordered_by_their_black() -> None:
    colours = press().to_colour(printable(250, 4))
    black = [
        press().to_device(colours, black=preset).device[:, 3]
        for preset in ("none", "light", "medium", "heavy", "max")
    ]
    assert (np.diff(black, axis=0) >= -0.01).all()
    assert (np.diff(np.mean(black, axis=1)) > 0.01).all()


@pytest.mark.slow
def test_inks_change_smoothly_along_the_neutral_axis() -> None:
    neutral = np.zeros((150, 3))
    neutral[:, 0] = np.linspace(20.0, 94.5, 150)  # steps of 0.5
    found = press().to_device(neutral)
    assert found.inside.all()
    assert np.abs(np.diff(found.device, axis=0)).max() <= 0.02


@pytest.mark.slow
def test_colours_out_of_gamut_get_the_recipe_of_the_mapped_colour() -> None:
    gamut, colours = press(), np.array([(50, 90, 0), (95, 0, 80), (5, 0, 0), (60, -90, 60)])
    found = gamut.to_device(colours, method="clip-hue")
    mapped = gamut.map(colours, "clip-hue")
    assert not found.inside.any()
    assert delta_e_2000(mapped.points, found.points).max() < 0.5
    np.testing.assert_allclose(found.delta_e, delta_e_2000(colours, found.points), atol=1e-9)


def test_recipes_of_a_display_are_its_codes(screen: Callable[..., Gamut]) -> None:
    codes = np.random.default_rng(2).random((300, 3))
    found = screen("srgb").to_device(codes, space="sRGB")
    np.testing.assert_allclose(found.device, codes, atol=1e-3)
    assert found.black_least is None


@pytest.mark.parametrize("space", ["IPT", "CIEXYZ", "CAM16-UCS"])
@pytest.mark.slow
def test_recipes_do_not_depend_on_the_space_of_the_gamut(space: str) -> None:
    colours = press().to_colour(printable(200, 4))
    other = press(space=space)
    found = other.to_device(colours, space="CIELAB", black="none")
    assert delta_e_2000(colours, other.to_colour(found.device, space="CIELAB")).max() < 0.05


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("xicclu") is None, reason="needs xicclu of Argyll")
@pytest.mark.parametrize(
    "name",
    ["press/ISOcoated_v2_300_bas.icc", "display/Acer_XB271HU.icc", "display/Panasonic-TV_2014.icc"],
)
def test_another_evaluator_gets_the_colours_from_recipes_of_profiles(name: str) -> None:
    path = shared(name)
    gamut = Gamut(path, **SAMPLES)
    colours = gamut.to_colour(printable(300, len(gamut.device_model.channels), 4.0))
    found = gamut.to_device(colours)
    lines = "\n".join(" ".join(f"{value:.7f}" for value in row) for row in found.device)
    command = ["xicclu", "-ff", "-ir", "-pl", "-s1", str(path)]
    answer = subprocess.run(
        command, input=lines, capture_output=True, text=True, check=True, timeout=600
    ).stdout
    evaluated = np.array(
        [line.split("->")[-1].split()[:3] for line in answer.splitlines() if "->" in line], float
    )
    # it interpolates in simplices, which differ from cells by some tenths at most
    errors = delta_e_2000(colours, evaluated)
    assert np.median(errors) < 0.1
    assert errors.max() < 1.0


@pytest.mark.slow
def test_presses_of_seven_inks_mix_three_and_black() -> None:
    gamut = Gamut(shared("oracle/Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc"), ink_limit=300, **SAMPLES)
    channels = np.array(gamut.device_model.channels)
    device = np.zeros((600, 7))
    random = np.random.default_rng(4)
    for number, inks in enumerate(("CMY", "MOY", "CMV", "CGY")):
        columns = [np.flatnonzero(np.char.startswith(channels, ink))[0] for ink in (*inks, "B")]
        device[number::4, columns] = random.random((150, 4)) * (1, 1, 1, 0.5)
    colours = gamut.to_colour(device[device.sum(axis=1) <= LIMIT])
    found = gamut.to_device(colours)
    errors = delta_e_2000(colours, found.points)
    assert np.median(errors) <= 0.01
    assert np.percentile(errors, 99) <= 0.1
    assert found.device.sum(axis=1).max() <= LIMIT + 1e-5
    # light neutral colours need no other inks than cyan, magenta, yellow and black
    neutral = gamut.to_device([(50, 0, 0), (70, 3, 3), (85, 0, 0)]).device
    extra = np.isin(channels, ["Orange", "Green", "Violet"])
    assert neutral[:, extra].max() < 1e-9


@pytest.mark.slow
def test_inks_of_seven_change_gradually() -> None:
    """Steps of 0.5 through dark and chromatic colours, where sets of inks take turns."""
    gamut = Gamut(shared("oracle/Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc"), ink_limit=300, **SAMPLES)
    share = np.linspace(0.0, 1.0, 130)[:, np.newaxis]
    for start, end in (((30, 0, 40), (60, 40, -20)), ((24, 4, -22), (40, -30, 30))):
        colours = (1.0 - share) * start + share * np.array(end)
        found = gamut.to_device(colours)
        made = found.delta_e < 0.1
        assert made.sum() > 60
        changes = np.abs(np.diff(found.device, axis=0)).max(axis=1)
        assert changes[made[1:] & made[:-1]].max() <= 0.12


@pytest.mark.slow
def test_a_saved_gamut_keeps_its_recipes(tmp_path: Path) -> None:
    gamut, colours = press(), [(50, 30, 20), (40, 0, 0)]
    path = tmp_path / "press.gamut"
    gamut.save(path)
    loaded = Gamut.load(path)
    np.testing.assert_array_equal(loaded.to_device(colours).device, gamut.to_device(colours).device)
    # the history, which the service delivers, has no model and is what it was
    assert loaded.to_bytes() == gamut.to_bytes()
    assert not Gamut.from_bytes(gamut.to_bytes()).has_device_model
    with pytest.raises(DeviceModelError, match="does not have the device model"):
        Gamut.from_bytes(gamut.to_bytes()).to_device(colours)


@pytest.mark.long  # of default size: a smaller gamut has the same model
def test_the_model_is_a_small_part_of_a_saved_press() -> None:
    gamut = Gamut(ROOT / "examples" / "FOGRA39L.ti3")
    assert len(gamut.to_bytes()) >= 0.7 * len(gamut.to_bytes(device_model=True))


@pytest.mark.slow
def test_another_reader_evaluates_a_saved_model_by_its_specification(tmp_path: Path) -> None:
    """Only docs/device-model-format.md, safetensors and numpy: the kind `fit`."""
    path = tmp_path / "press.gamut"
    press().save(path)
    data = path.read_bytes()
    header = json.loads(data[8 : 8 + int.from_bytes(data[:4], "little")])
    (section,) = header["sections"]
    assert section["name"] == "device_model"
    model = load(data[-section["bytes"] :])
    device = printable(300, 4)
    distances = np.linalg.norm(device[:, None] - model["centres"], axis=2)
    colours = model["linear"][0] + device @ model["linear"][1:] + distances**3 @ model["weights"]
    colours[:, 0] = np.maximum(colours[:, 0], 0.0)
    np.testing.assert_allclose(press().to_colour(device), colours, atol=1e-6)


@pytest.mark.slow
def test_damage_to_the_model_is_refused_as_such() -> None:
    whole = press().to_bytes(device_model=True)
    start = len(whole) - len(press().device_model.to_bytes())
    random = np.random.default_rng(1)
    refused = 0
    for place in [*range(start, start + 400, 21), *random.integers(start, len(whole), 12)]:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << random.integers(8)
        try:
            Gamut.from_bytes(bytes(damaged)).to_device((50, 0, 0))
        except GamutError:
            refused += 1
    assert refused > 6


@pytest.mark.parametrize("name", ["weights", "linear", "centres", "lowest", "base"])
def test_models_whose_arrays_do_not_fit_together_are_refused(name: str) -> None:
    """Kernels do not check indices, so a short array must not reach them."""
    data = press().device_model.to_bytes()
    arrays = load(data)
    arrays[name] = arrays[name][:-1]
    header = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    with pytest.raises(HistoryFileError):
        DeviceModel.from_bytes(save_tensors(arrays, header["__metadata__"]))


def test_what_has_no_device_is_refused() -> None:
    for data in ([(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)],):
        with pytest.raises(DeviceModelError, match="colours only"):
            Gamut(data).to_device((50, 0, 0))
    with pytest.raises(DeviceModelError, match="colours only"):
        reference("pointer", surface_samples=500).to_device((50, 0, 0))


@pytest.mark.parametrize(
    "black", ["some", -0.1, 1.5, [(10, 0.5)], [(10, 0.5), (5, 0.1)], [(0, 102), (100, 0)], [["a"]]]
)
def test_impossible_rules_of_black_are_refused(black: Any) -> None:
    with pytest.raises(OptionError) as caught:
        press().to_device((50, 0, 0), black=black)
    assert caught.value.where["field"] == "black"


@pytest.mark.parametrize("device", [(0, 0, 0), (0, 0, 0, 1.5), (0, 0, np.nan, 0)])
def test_impossible_device_values_are_refused(device: tuple[float, ...]) -> None:
    with pytest.raises(InvalidPointsError) as caught:
        press().to_colour(device)
    assert caught.value.where["field"] == "device"


def test_sgck_is_no_mapping_of_recipes() -> None:
    with pytest.raises(OptionError, match="another gamut"):
        press().to_device((50, 200, 0), method="sgck")
