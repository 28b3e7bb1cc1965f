"""Questions about two gamuts: cubes, whose intersections are cubes, and published figures."""

import numpy as np
import pytest

from gamutcore import Gamut, reference
from gamutcore.colours.colorimetry import colour_science
from gamutcore.errors import OptionError, ReferenceNameError

colour = colour_science()

UNIT = 2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1


def cube(half, middle=(50, 0, 0), **options):
    return Gamut(half * UNIT + middle, gamma=1, **options)


def test_cubes():
    one, two = cube(20), cube(10, (50, 20, 0))
    common = one & two
    assert common.volume == pytest.approx(10 * 20 * 20)
    assert common.of_first == pytest.approx(4000 / 40**3)
    assert common.of_second == pytest.approx(0.5)
    assert one.coverage_of(two) == pytest.approx(0.5)
    assert two.coverage_of(one) == pytest.approx(4000 / 40**3)
    found = one.compare(two, sectors=4)
    assert found.union == pytest.approx(40**3 + 4000)
    assert found.sectors.volume_a.tolist() == pytest.approx([40**3 / 4] * 4)
    assert found.white_a[0] == pytest.approx(70, abs=1e-3)
    assert found.black_b[0] == pytest.approx(40, abs=1e-3)
    assert {each[:3] for each in found.warnings} == {"A: ", "B: "}  # of the builds


def surface_of_cube(half, steps):
    """Return the middles of equal squares on the faces of a cube, (6 · steps², 3)."""
    middles = half * (2 * (np.arange(steps) + 0.5) / steps - 1)
    square = np.stack(np.meshgrid(middles, middles), axis=-1).reshape(-1, 2)
    sides = [np.insert(square, axis, end, axis=1) for axis in range(3) for end in (-half, half)]
    return np.concatenate(sides) + np.array((50, 0, 0))


@pytest.mark.slow
def test_colours_lost_are_those_of_a_search_of_all_pairs():
    one, two = cube(20), cube(10)
    found = one.compare(two, sectors=1, lost=True)
    given, others = surface_of_cube(20, 8), surface_of_cube(10, 20)
    pairs = colour.difference.delta_E_CIE2000(given[:, np.newaxis], others[np.newaxis])
    nearest = pairs.min(axis=1)
    assert found.lost_a.mean == pytest.approx(nearest.mean(), rel=0.02)
    assert found.lost_a.percentile_95 == pytest.approx(np.percentile(nearest, 95), rel=0.03)
    assert found.lost_a.share_outside == 1
    assert [*vars(found.lost_b).values()] == [0, 0, 0]
    assert found.sectors.lost_mean_a == pytest.approx([found.lost_a.mean])
    turned = two.compare(one, lost=True)
    assert vars(turned.lost_b) == vars(found.lost_a)
    # each quarter of the hues is the same but for ΔE00
    assert turned.sectors.lost_mean_b.mean() == pytest.approx(found.lost_a.mean, rel=0.1)


@pytest.mark.slow
def test_shares_outside_are_shares_of_area():
    """Of a cube of edge 40 that is moved by 10, one face and quarters of four are outside."""
    found = cube(20).compare(cube(20, (50, 10, 0)), lost=True)
    assert found.lost_a.share_outside == pytest.approx((1 + 4 / 4) / 6, abs=0.01)
    assert found.lost_b.share_outside == pytest.approx((1 + 4 / 4) / 6, abs=0.01)
    same = cube(20).compare(cube(20), lost=True)
    assert same.lost_a.share_outside == same.lost_b.mean == 0
    assert same.summary[0] == "A and B reach equally far at every hue."


@pytest.mark.parametrize("sectors", [1, 7, 36])
def test_the_largest_chroma_in_a_sector_of_a_cube(sectors):
    hues = np.linspace(0, 360, sectors * 1000 + 1)
    # the distance from an edge of the square is 20
    chroma = 20 / np.maximum(*np.abs([np.cos(np.radians(hues)), np.sin(np.radians(hues))]))
    expected = [chroma[at : at + 1001].max() for at in range(0, sectors * 1000, 1000)]
    found = cube(20).compare(cube(10), sectors=sectors).sectors
    assert found.max_chroma_a == pytest.approx(expected, rel=1e-4)
    assert found.max_chroma_b == pytest.approx(found.max_chroma_a / 2, rel=1e-4)
    assert found.lost_mean_a is None


SOLIDS = {
    "cyan": (-37, -50),
    "magenta": (74, -3),
    "yellow": (-5, 93),
    "red": (68, 48),
    "green": (-68, 25),
    "blue": (17, -46),
}
"""a* and b* of prints (ISO 12647-2:2004/Amd 1:2007, paper type 1)."""


@pytest.mark.parametrize("name", SOLIDS)
def test_the_summary_names_the_hue_of_a_peak(name):
    """Of primaries and secondaries, of prints and of sRGB."""
    rgb = {"red": "100", "yellow": "110", "green": "010", "cyan": "011", "blue": "001"}
    full = np.array([*rgb.get(name, "101")], float)
    d50 = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D50"]
    lab = colour.XYZ_to_Lab(colour.RGB_to_XYZ(full, "sRGB", d50), d50)
    for peak in (SOLIDS[name], lab[1:]):
        spiked = Gamut(np.vstack([10 * UNIT + (50, 0, 0), (50, *peak)]), gamma=1)
        words = spiked.compare(cube(10)).summary[0]
        assert words.startswith("A reaches further in ")
        assert f"{name} (hue " in words
        far = float(words.split("by up to ")[1].split()[0])
        assert far == pytest.approx(np.hypot(*peak), abs=15)
        assert words.split("chroma, ")[1].startswith((f"in {name} (hue", "at hue"))


def test_small_shares_and_the_end_of_the_hues_in_words():
    base = 10 * UNIT + (50, 0, 0)
    one, two = (Gamut(np.vstack([base, (50, 30, end)]), gamma=1) for end in (-10, 10))
    words = " ".join(one.compare(two).summary)
    assert "° to 360°)" in words
    assert "to 0°" not in words
    words = " ".join(cube(20).compare(cube(1.5)).summary)
    assert "B covers less than 0.1 % of the volume of A" in words


@pytest.mark.slow
def test_the_summary_has_the_figures_and_takes_names():
    one, two = cube(20), cube(10, (50, 20, 0))
    found = one.compare(two, lost=True)
    words = " ".join(found.summary)
    # B ends at an a* of 30, and A at 20
    assert "by up to 10 in chroma" in words
    assert "A covers 50.0 % of the volume of B, and B covers 6." in words
    white = colour.difference.delta_E_CIE2000(found.white_a, found.white_b)
    assert f"A has L* 70.0 and that of B 60.0 (ΔE00 {white:.1f})" in words
    assert f"ΔE00 is {found.lost_b.mean:.1f} on average" in words
    assert "(0 where it is inside A)" in words
    named = " ".join(found.summary_with("press A", "Bild"))
    assert named.replace("press A", "A").replace("Bild", "B") == words
    assert "press A covers 50.0 % of the volume of Bild" in named


@pytest.mark.slow
def test_other_spaces_have_hues_without_names_or_no_hue():
    oklab = cube(20, space="Oklab").compare(cube(10, space="Oklab"), lost=True)
    assert "at every hue" in oklab.summary[0]
    assert "at hue " in oklab.summary[0]
    # nearest by Oklab is no nearer by ΔE00
    assert oklab.lost_a.mean > 0.95 * cube(20).compare(cube(10), lost=True).lost_a.mean
    xyz = cube(20, space="CIEXYZ").compare(cube(10, space="CIEXYZ"))
    assert xyz.sectors.max_chroma_a is None
    assert xyz.summary[0].startswith("A covers")
    assert " Y 0." in xyz.summary[-1]


def test_spaces_must_be_the_same():
    with pytest.raises(OptionError, match="CIELAB and Oklab"):
        cube(20).compare(cube(20, space="Oklab"))
    with pytest.raises(OptionError, match="parameters"):
        _ = cube(20) & cube(20, reference_white="D65")
    with pytest.raises(OptionError, match="sectors"):
        cube(20).compare(cube(10), sectors=0)
    with pytest.raises(TypeError):
        _ = cube(20) & 5


@pytest.mark.slow
def test_another_gamut_is_a_gamut_a_file_or_the_name_of_a_reference(tmp_path):
    """By one rule for all methods; what is built has the space of the gamut that asks."""
    one, two = cube(20, space="CIELUV"), cube(10, space="CIELUV")
    saved, table = tmp_path / "two.gamut", tmp_path / "two.csv"
    two.save(saved)
    table.write_text("\n".join(["L,a,b", *(f"{x},{y},{z}" for x, y, z in 10 * UNIT + (50, 0, 0))]))
    exact = one.compare(two).intersection
    assert one.compare(saved).intersection == one.compare(str(saved)).intersection == exact
    built = Gamut(table, space="CIELUV")
    assert (one & table).volume == (one & built).volume
    assert (one & str(table)).volume == (one & built).volume
    pointer = reference("pointer", space="CIELUV")  # a small one
    assert one.coverage_of("Pointer") == one.coverage_of(pointer)
    colours = [(50, 30, 0)]
    for named, same in (("pointer", pointer), (saved, two)):
        mapped = [one.map(colours, "sgck", source=each).points for each in (named, same)]
        assert np.array_equal(*mapped)
        assert one.rings(named).reference_radius.tolist() == (
            one.rings(same).reference_radius.tolist()
        )


def test_what_names_no_gamut_is_refused(tmp_path):
    for name, kind in (("srbg", ReferenceNameError), ("srbg.icc", FileNotFoundError)):
        with pytest.raises(kind):
            cube(20).coverage_of(name)
    with pytest.raises(FileNotFoundError):
        cube(20).coverage_of(tmp_path / "srgb")
    with pytest.raises(TypeError):
        cube(20).coverage_of(5)


@pytest.mark.slow
def test_two_papers_that_both_count_as_white_have_a_warning(fogra39):
    relative, absolute = (
        Gamut(fogra39, surface_samples=500, intent=intent) for intent in ("relative", "absolute")
    )
    assert any("absolute" in each for each in relative.compare(relative).warnings)
    assert not any("intent" in each for each in absolute.compare(absolute).warnings)
