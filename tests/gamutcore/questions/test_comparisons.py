"""Questions about two gamuts: cubes, whose intersections are cubes, and published figures."""

import numpy as np
import pytest

from gamutcore import Gamut, reference
from gamutcore.errors import OptionError, ReferenceNameError

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
    assert found.warnings == ()


def test_spaces_must_be_the_same():
    with pytest.raises(OptionError, match="CIELAB and Oklab"):
        cube(20).compare(cube(20, space="Oklab"))
    with pytest.raises(OptionError, match="parameters"):
        _ = cube(20) & cube(20, reference_white="D65")
    with pytest.raises(OptionError, match="sectors"):
        cube(20).compare(cube(10), sectors=0)
    with pytest.raises(TypeError):
        _ = cube(20) & 5


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
    srgb = reference("sRGB", space="CIELUV")
    assert one.coverage_of("srgb") == one.coverage_of(srgb)
    colours = [(50, 30, 0)]
    for named, same in (("srgb", srgb), (saved, two)):
        mapped = [one.map(colours, "sgck", source=each).points for each in (named, same)]
        assert np.array_equal(*mapped)
        assert one.rings(named).reference_radius.tolist() == (
            one.rings(same).reference_radius.tolist()
        )
        assert one.rings_svg(named) == one.rings_svg(same)


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
    assert "absolute" in relative.compare(relative).warnings[0]
    assert absolute.compare(absolute).warnings == ()
