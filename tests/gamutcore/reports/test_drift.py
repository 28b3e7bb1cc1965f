"""Drift: a second reading with known changes, in which exactly these are found."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

import gamutcore
from gamutcore.cli.app import app, run
from gamutcore.errors import CharacterisationError, MissingColumnError, UnrecognisedFormatError

DATA = Path(__file__).parents[2] / "data" / "reports"
FOGRA39L = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"
HEAD = "CTI3\n{keywords}BEGIN_DATA_FORMAT\nSAMPLE_ID {device} {colour}\nEND_DATA_FORMAT\n"
CMYK = "CMYK_C CMYK_M CMYK_Y CMYK_K"
LAB = "LAB_L LAB_A LAB_B"


def published():
    """Return names, device values and CIELAB of the first 260 patches, and of the overprints."""
    data = FOGRA39L.read_text().split("BEGIN_DATA\n")[1].split("END_DATA")[0]
    rows = [row.split() for row in data.strip().splitlines()]
    solid = [set(row[1:5]) <= {"0", "100"} for row in rows]
    rows = [row for at, row in enumerate(rows) if at < 260 or solid[at]]
    values = np.array([row[1:] for row in rows], dtype=float)
    return [row[0] for row in rows], values[:, :4], values[:, 7:10]


def reading(names, device, colours, *, keywords="", channels=CMYK, colour=LAB):
    head = HEAD.format(keywords=keywords, device=channels, colour=colour)
    rows = (
        " ".join([name, *(f"{value:.6g}" for value in (*values, *lab))])
        for name, values, lab in zip(names, device, colours, strict=True)
    )
    return (head + "BEGIN_DATA\n" + "\n".join(rows) + "\nEND_DATA\n").encode()


def pair(*arguments, **options):
    return gamutcore.drift(*arguments, surface_samples=200, **options).data["pairs"][0]


@pytest.fixture(scope="module")
def patches():
    return published()


@pytest.fixture(scope="module")
def noisy(patches):
    """Return a function of a seed: CIELAB with noise of 0.3 ΔE*ab, root mean square."""
    lab = patches[2]
    return lambda seed: lab + np.random.default_rng(seed).normal(0, 0.3 / np.sqrt(3), lab.shape)


@pytest.mark.slow
def test_known_changes_of_paper_and_cyan_are_found_in_shuffled_noisy_patches(patches, noisy):
    names, device, _ = patches
    first, second = noisy(1), noisy(2)
    paper, cyan = (device == 0).all(axis=1), (device == [100, 0, 0, 0]).all(axis=1)
    second[paper, 2] += 0.5
    second[cyan, 0] -= 2.0
    order = np.random.default_rng(3).permutation(len(names))
    shuffled = [[names[at] for at in order], device[order], second[order]]
    report = gamutcore.drift(
        reading(names, device, first), reading(*shuffled), noise=0.3, surface_samples=200
    )
    figures, solids = report.data["pairs"][0], report.tables[1]
    distinct = np.unique(device, axis=0)
    assert figures["matched"] == len(distinct)
    marked = figures["patches"]["device"][
        [name in figures["beyond_noise"] for name in figures["patches"]["name"]]
    ]
    assert [100, 0, 0, 0] in marked.round(6).tolist()
    assert len(marked) == 1
    assert figures["larger_than_noise"]
    rows = {
        row[0]: dict(zip([c.name for c in solids.columns], row, strict=True)) for row in solids.rows
    }
    expected = (second[paper].mean(axis=0) - first[paper].mean(axis=0))[2]
    assert rows["white"]["Δb*"] == pytest.approx(expected, abs=1e-4)
    assert rows["C"]["ΔL*"] == pytest.approx((second[cyan] - first[cyan]).mean(axis=0)[0], abs=1e-4)
    assert {"M", "Y", "K", "C+M", "C+Y", "M+Y", "C+M+Y"} <= rows.keys()
    assert figures["delta_e_2000"]["mean"] < 0.5


@pytest.mark.slow
def test_noise_alone_is_within_the_noise_that_is_given_or_found(patches, noisy):
    names, device, _ = patches
    first = reading(names, device, noisy(4))
    twice = [*names, *names], np.vstack([device, device]), np.vstack([noisy(5), noisy(6)])
    given = pair(first, reading(names, device, noisy(5)), noise=0.3)
    assert given["larger_than_noise"] is False
    change = given["volume"]["interval"]["change"]  # nothing but noise changed
    assert change["low"] < 0.0 < change["high"]
    assert given["volume"]["interval"]["smallest_difference"] < 0.1
    found = pair(first, reading(*twice))
    assert found["noise"]["delta_e_ab"] == pytest.approx(0.3, rel=0.06)
    assert found["larger_than_noise"] is False
    assert pair(reading(names, device, noisy(4) + np.array([0.4, 0, 0])), reading(*twice))[
        "larger_than_noise"
    ]


def test_without_repeats_the_noise_is_not_known(patches):
    names, device, lab = patches
    one = np.unique(device, axis=0, return_index=True)[1]
    alone = reading([names[at] for at in one], device[one], lab[one])
    report = gamutcore.drift(alone, alone, surface_samples=200)
    assert report.data["pairs"][0]["larger_than_noise"] is None
    assert "no patch changed" in report.sentences[0]
    assert not any("mean nothing" in sentence for sentence in report.sentences)
    assert any("noise is not known" in warning for warning in report.warnings)
    assert report.data["pairs"][0]["volume"]["change"] == 0.0
    assert report.data["pairs"][0]["volume"]["second_covers"] == pytest.approx(1.0, abs=1e-3)


def test_direction_and_differences_have_the_sign_of_second_minus_first():
    device = [[0, 0, 0, 0], [100, 0, 0, 0], [0, 100, 0, 0]]
    first = [[95, 0, 0], [55, -30, -40], [48, 40, 30]]
    second = [[94, 0, 0], [55, -33, -44], [48, 30, 40]]
    figures = pair(reading("abc", device, first), reading("abc", device, second))
    # C* grows from 50 to 55; the hue of red turns from 36.87° to 53.13°: 2 · 50 · sin 8.13° = 14.14
    assert figures["direction"]["L"] == pytest.approx(-1 / 3)
    assert figures["direction"]["C"] == pytest.approx(5 / 3)
    assert figures["direction"]["H"] == pytest.approx(np.sqrt(200) / 3)
    assert figures["volume"] is None


def test_patches_match_in_8_bits_and_per_cent_and_others_are_named():
    per_cent = [[0, 0, 0, 0], [25, 0, 0, 0], [50, 0, 0, 0], [100, 0, 0, 0]]
    eight_bits = [[255, 0, 0, 0], [0, 0, 0, 0], [64, 0, 0, 0], [200, 0, 0, 0]]
    lab = [[95, 0, 0], [80, -10, -10], [70, -20, -25], [55, -35, -50]]
    report = gamutcore.drift(
        reading("abcd", per_cent, lab),
        reading("wxyz", eight_bits, [lab[3], lab[0], lab[1], lab[2]]),
    )
    figures = report.data["pairs"][0]
    assert figures["patches"]["name"] == ["a", "b", "d"]
    assert figures["delta_e_2000"]["largest"] == 0.0
    assert figures["only_in"]["first"] == {"count": 1, "patches": ["c"]}
    assert figures["only_in"]["second"] == {"count": 1, "patches": ["z"]}
    assert "1 patch is in reading 1 only, and not compared: c." in str(report)


def test_each_later_reading_has_a_row_and_conditions_are_warned_of_once(tmp_path, capsys):
    device = [[0, 0, 0, 0], [100, 0, 0, 0]]
    lab = [[95, 0, 0], [55, -30, -40]]
    for name, condition in (("one", "M0"), ("two", "M1"), ("three", "M1")):
        keywords = f'MEASUREMENT_CONDITION "{condition}"\nSAMPLE_BACKING "white"\n'
        (tmp_path / f"{name}.ti3").write_bytes(reading("ab", device, lab, keywords=keywords))
    files = [str(tmp_path / f"{name}.ti3") for name in ("one", "two", "three")]
    assert run(app, ["drift", *files, "--noise", "0.3"]) == 0
    out, _ = capsys.readouterr()
    assert out.count("measurement condition:") == 1
    assert "differ in their backing" not in out
    assert max(map(len, out.splitlines())) <= 80
    assert run(app, ["drift", *files, "--csv"]) == 0
    out, _ = capsys.readouterr()
    assert [line.split(",")[0] for line in out.splitlines()] == ["reading", "two.ti3", "three.ti3"]
    for suffix in ("json", "html", "txt"):
        assert run(app, ["drift", *files, "-o", str(tmp_path / f"drift.{suffix}")]) == 0
    document = json.loads((tmp_path / "drift.json").read_text())
    assert [each["second"] for each in document["pairs"]] == ["two.ti3", "three.ti3"]


@pytest.mark.slow
def test_displays_keep_a_change_of_luminance_and_of_white():
    channels, colour = "RGB_R RGB_G RGB_B", "XYZ_X XYZ_Y XYZ_Z"
    device = np.array(list(np.ndindex(2, 2, 2)), dtype=float) * 100
    light = device / 100 @ [[41, 21, 2], [36, 72, 12], [18, 7, 95]] + 0.05
    names = "abcdefgh"
    keywords = 'DEVICE_CLASS "DISPLAY"\n'

    def display(factor, luminance):
        white = f'LUMINANCE_XYZ_CDM2 "{luminance} {luminance} {luminance}"\n' if luminance else ""
        return reading(
            names,
            device,
            light * factor,
            keywords=keywords + white,
            channels=channels,
            colour=colour,
        )

    figures = pair(display(1, 100), display(1, 90))
    # 90 % of the luminance is L* 116 · 0.9^(1/3) − 16 = 95.997
    white = figures["patches"]["difference"][figures["patches"]["name"].index("h")]
    assert white == pytest.approx([95.997 - 100, 0, 0], abs=0.01)
    report = gamutcore.drift(display(1, None), display(1, None), surface_samples=200)
    assert any("does not state the luminance" in warning for warning in report.warnings)
    figures = pair(display(1.3, None), display(1.3 * 0.9, None))  # in cd/m²
    white = figures["patches"]["difference"][figures["patches"]["name"].index("h")]
    assert white == pytest.approx([95.997 - 100, 0, 0], abs=0.01)


@pytest.mark.parametrize(
    ("second", "kind", "told"),
    [
        ("display-reference.ti3", CharacterisationError, "different devices"),
        ("sRGB-v4.icc", UnrecognisedFormatError, "no reading"),
        ("chart-cmyk.ti1", UnrecognisedFormatError, "estimates"),
        (b"L,a,b\n50,0,0\n60,0,0\n70,0,9\n80,9,0\n", MissingColumnError, "no device values"),
        (b"C,M,Y,K,L,a,b\n10,0,0,0,90,0,0\n100,9,9,9,50,0,0\n", CharacterisationError, "in common"),
    ],
)
def test_what_cannot_be_compared_is_refused_with_a_remedy(second, kind, told):
    first = b"C,M,Y,K,L,a,b\n0,0,0,0,95,0,-2\n100,0,0,0,55,-37,-50\n"
    if isinstance(second, str):
        second = DATA / second if (DATA / second).exists() else DATA.parent / second
    with pytest.raises(kind, match=told) as caught:
        gamutcore.drift(first, second)
    assert caught.value.remedy
    if isinstance(second, os.PathLike):
        assert Path(caught.value.where["file"]).name == second.name
