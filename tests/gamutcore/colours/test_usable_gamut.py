"""The usable gamut of a profile: what its B2A tables reach."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.characterisation.icc import icc_profile
from gamutcore.colours.profile import printed_values
from gamutcore.errors import OptionError
from gamutcore.reports.standards import _press_chart, tetrahedra_volume

ROOT = Path(__file__).parents[3]
PRESS = ROOT.parent / "shared" / "data" / "press" / "ISOcoated_v2_300_bas.icc"
SRGB = ROOT / "tests" / "data" / "sRGB-v4.icc"

needs_press = pytest.mark.skipif(not PRESS.exists(), reason="needs ../shared/data")


def transicc(rows, *arguments):
    """Rows of numbers through little CMS."""
    text = "\n".join("\n".join(f"{value:.6f}" for value in row) for row in rows) + "\n"
    command = ["transicc", "-n", *arguments]
    output = subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout
    return np.array([line.split() for line in output.splitlines() if line.strip()], float)


@pytest.mark.slow
@needs_press
@pytest.mark.skipif(shutil.which("transicc") is None, reason="needs transicc of little CMS")
def test_the_volumes_of_a_press_are_those_by_another_engine():
    device, faces = _press_chart(("C", "M", "Y", "K"), inks=True)
    profile = icc_profile(PRESS.read_bytes())
    colours = transicc(100 * device, "-t1", "-i", str(PRESS), "-o", "*Lab")
    printed = transicc(colours, "-t1", "-i", "*Lab", "-o", str(PRESS))
    ours = 100 * printed_values(profile, device, "relative")
    assert np.abs(ours - printed).max() < 0.2
    usable = transicc(printed, "-t1", "-i", str(PRESS), "-o", "*Lab")
    assert tetrahedra_volume(colours, faces) == pytest.approx(452_403, rel=2e-3)
    assert tetrahedra_volume(usable, faces) == pytest.approx(376_245, rel=2e-3)


def test_tetrahedra_of_a_cube_have_its_volume():
    device, faces = _press_chart(("R", "G", "B"), inks=False)
    assert tetrahedra_volume(20 * device, faces) == pytest.approx(8000)


def test_a_profile_of_curves_reaches_everything():
    data = SRGB.read_bytes()
    usable = Gamut(data, source="usable", surface_samples=300)
    assert usable.volume == pytest.approx(Gamut(data, surface_samples=300).volume)
    assert usable.id != Gamut(data, surface_samples=300).id


def test_data_without_tables_and_limits_of_ink_are_refused():
    with pytest.raises(OptionError, match="not an ICC profile"):
        Gamut([(0, 0, 0), (50, 40, 0), (50, -40, 0), (50, 0, 40), (100, 0, 0)], source="usable")
    with pytest.raises(OptionError, match="ink_limit"):
        Gamut(SRGB.read_bytes(), source="usable", ink_limit=300)
