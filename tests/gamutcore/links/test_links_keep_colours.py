"""Nothing that both gamuts contain moves by more than the table's own error."""

import functools
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import gamutcore
from gamutcore import Gamut, link
from gamutcore.colours import cube_nodes
from gamutcore.errors import OptionError
from gamutcore.questions import PICTURE_SPACE
from gamutcore.search import delta_e_2000

EXAMPLES = Path(__file__).parents[3] / "examples"
COARSE = {"surface_samples": 2000}
SCREENS = ("srgb", "display-p3", "adobe-rgb-1998", "bt2020", "prophoto-rgb")
FILES = {"coated": "FOGRA39L.ti3", "uncoated": "FOGRA29L.ti3", "television": "Panasonic-TV.icc"}


@functools.cache
def device(name):
    """Return a device, built when it is first asked for."""
    if name in FILES:
        return Gamut(EXAMPLES / FILES[name], space=PICTURE_SPACE, **COARSE)
    return gamutcore.reference(name, space=PICTURE_SPACE, **COARSE)


def scaled_black(lab, source, destination):
    """Return colours with the luminance of black scaled relative to D50 (ISO 18619).

    Those that are darker than black are no colours then: NaN.
    """
    white = np.array((0.9642, 1.0, 0.8249))
    f = np.stack([lab[:, 0] / 116 + 16 / 116] * 3, axis=1)
    f += np.stack([lab[:, 1] / 500, np.zeros(len(lab)), -lab[:, 2] / 200], axis=1)
    xyz = white * np.where(f > 6 / 29, f**3, 3 * (6 / 29) ** 2 * (f - 4 / 29))
    scale = (1 - destination) / (1 - source)
    ratio = (scale * xyz + (1 - scale) * white) / white
    ratio[(ratio < 0).any(axis=1)] = np.nan
    g = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack(
        [116 * g[:, 1] - 16, 500 * (g[:, 0] - g[:, 1]), 200 * (g[:, 1] - g[:, 2])], axis=1
    )


def black_of(gamut):
    """Return the luminance of the darkest neutral colour, by trial."""
    lightness = np.linspace(0, 40, 4001)
    colours = lightness[:, np.newaxis] * (1, 0, 0)
    darkest = lightness[gamut.contains(colours, space="CIELAB", max_error=0, tolerance=0)][0]
    return ((darkest + 16) / 116) ** 3 if darkest > 8 else darkest / 903.3


def moved(made, source, destination, codes):
    """Return how far a link moves colours that both devices have, after their blacks are equal."""
    before = source.to_colour(codes, space="CIELAB")
    if made.black_point_compensation:
        before = scaled_black(before, black_of(source), black_of(destination))
        codes, before = (rows[np.isfinite(before).all(axis=1)] for rows in (codes, before))
    common = destination.contains(before, space="CIELAB", max_error=0, tolerance=0)
    if len(destination.channels) == 3:  # the triangles near black leave the cube by 0.2 ΔE00
        common &= destination.to_device(before, space="CIELAB").delta_e < 0.01
    assert common.sum() > 20
    after = destination.to_colour(made.table.values(codes), space="CIELAB")
    return delta_e_2000(before, after)[common]


PAIRS = [("srgb", "srgb"), ("srgb", "display-p3"), ("bt2020", "display-p3")]
MORE_PAIRS = [
    ("srgb", "coated"),
    *(("srgb", screen) for screen in SCREENS[2:]),
    *((screen, screen) for screen in SCREENS[1:]),
    ("display-p3", "bt2020"),
    ("adobe-rgb-1998", "srgb"),
    ("television", "television"),
    ("srgb", "television"),
    ("coated", "coated"),
    ("coated", "srgb"),
    ("uncoated", "coated"),
    ("coated", "uncoated"),
]


@pytest.mark.parametrize(
    ("source", "destination"),
    [*PAIRS, *(pytest.param(*pair, marks=pytest.mark.slow) for pair in MORE_PAIRS)],
)
def test_what_both_have_stays(source, destination):
    one, two = device(source), device(destination)
    channels = len(one.channels)
    made = link(one, two, size=9 if channels == 3 else 5)
    nodes = cube_nodes(made.table.size, channels)
    assert moved(made, one, two, nodes).max() < 0.05  # a table is exact at its nodes
    # the mean of a screen is that of few dark colours, which 500 codes may have once or never
    codes = np.random.default_rng(3).random((4000 if channels == 3 else 500, channels))
    assert moved(made, one, two, codes).mean() <= 1.5 * made.errors.mean + 1e-6


@pytest.mark.parametrize("method", ["clip-hue", "clip-nearest", "sgck"])
def test_a_space_to_itself_is_the_identity(method):
    """Near black, the boundary in CAM16-UCS misses colours of sRGB by up to 1.8."""
    srgb = device("srgb")
    assert srgb.description["boundary_error"] > 1.0
    made = link(srgb, srgb, method=method, size=17)
    np.testing.assert_allclose(made.table.nodes.reshape(-1, 3), cube_nodes(17), atol=1e-6)
    dark = cube_nodes(7) * 6 / 255
    np.testing.assert_allclose(made.table.values(dark), dark, atol=1e-6)
    assert made.errors.worst < 0.001


def test_greys_of_a_wider_space_stay():
    """BT.2020 to P3: L* 11.9, 19.7, 33.6 and 79.8 became 5.5, 12.6, 27.5 and 82.4."""
    one, two = device("bt2020"), device("display-p3")
    grey = np.array([11.9, 19.7, 33.6, 79.8])[:, np.newaxis] * (1, 0, 0)
    codes = one.to_device(grey, space="CIELAB").device
    after = two.to_colour(link(one, two).table.values(codes), space="CIELAB")
    assert delta_e_2000(grey, after).max() < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("space", ["CIELAB", "Oklab", "IPT", "Jzazbz"])
@pytest.mark.parametrize("destination", ["display-p3", "coated"])
def test_what_both_have_stays_in_any_space(space, destination):
    options = {"luminance": 100.0} if space == "Jzazbz" else {}
    one = gamutcore.reference("srgb", space=space, **COARSE, **options)
    file = EXAMPLES / FILES.get(destination, "")
    two = (
        Gamut(file, space=space, **COARSE, **options)
        if file.is_file()
        else gamutcore.reference(destination, space=space, **COARSE, **options)
    )
    assert moved(link(one, two, size=5), one, two, cube_nodes(5)).max() < 0.05


def test_sgck_changes_nothing_where_the_destination_has_all():
    """The curve of lightness began at that of L*min 5, and moved greys by up to 4.9 ΔE00."""
    one, two = device("srgb"), device("display-p3")
    made = link(one, two, method="sgck", size=9)
    assert not made.black_point_compensation
    assert moved(made, one, two, cube_nodes(9)).max() < 0.05


def test_sgck_keeps_greys_between_equal_blacks_and_whites():
    """BT.2020 to P3: L* 11.9, 19.7, 33.6 and 79.8 became 5.5, 12.6, 27.5 and 82.4."""
    grey = np.array([11.9, 19.7, 33.6, 79.8])[:, np.newaxis] * (1, 0, 0)
    found = device("display-p3").map(grey, "sgck", source=device("bt2020"), space="CIELAB")
    np.testing.assert_allclose(found.points, grey, atol=0.02)


@pytest.mark.slow
def test_the_stated_error_is_against_the_wanted_colours():
    """Compression moves greys that a press has, which the table holds faithfully."""
    one, two = device("srgb"), device("coated")
    clipped, compressed = (link(one, two, method=each, size=9) for each in ("clip-hue", "sgck"))
    codes = np.random.default_rng(8).random((2000, 3))
    before = one.to_colour(codes, space="CIELAB")
    common = two.contains(before, space="CIELAB", max_error=0, tolerance=0)
    after = two.to_colour(compressed.table.values(codes), space="CIELAB")
    change = delta_e_2000(before, after)[common]
    assert change.mean() > 1.0
    assert compressed.errors.mean > 0.9 * common.mean() * change.mean()
    assert compressed.errors.mean > compressed.table_errors.mean
    assert clipped.errors.mean == pytest.approx(clipped.table_errors.mean, rel=0.1)


@pytest.mark.slow
def test_black_point_compensation_can_be_switched_off():
    one, two = device("srgb"), device("coated")
    made = link(one, two, size=5, black_point_compensation=False)
    assert not made.black_point_compensation
    assert moved(made, one, two, cube_nodes(5)).max() < 0.05


def test_absolute_colours_have_no_compensation():
    made = link("srgb", "display-p3", size=2, intent="absolute", surface_samples=500)
    assert not made.black_point_compensation


PATCHES = {
    "grey": [(value,) * 3 for value in (0, 1, 13, 26, 77, 128, 191, 254, 255)],
    "skin": [(115, 82, 68), (194, 150, 130)],  # those and the sky of the ColorChecker
    "sky": [(98, 122, 157), (135, 206, 235)],
    "primaries": [(255, 0, 0), (0, 255, 0), (0, 0, 255), (0, 255, 255), (255, 0, 255)],
}
"""Codes of 8 bits."""


def cube_of(path):
    """Return the nodes (n, n, n, 3) of a .cube file by red, green and blue."""
    lines = [line for line in path.read_text("ascii").splitlines() if line[0].isdigit()]
    nodes = np.array([line.split() for line in lines], float)
    size = round(len(nodes) ** (1 / 3))
    return nodes.reshape(size, size, size, 3).transpose(2, 1, 0, 3)  # red is fastest


def trilinear(nodes, rgb):
    """Interpolate between the eight corners of a cell."""
    last = len(nodes) - 1
    first = np.minimum((rgb * last).astype(int), last - 1)
    share = rgb * last - first
    result = np.zeros_like(rgb)
    for corner in np.ndindex(2, 2, 2):
        weight = np.where(corner, share, 1 - share).prod(axis=1, keepdims=True)
        result += weight * nodes[tuple((first + corner).T)]
    return result


def tetrahedral(nodes, rgb):
    """Interpolate along the path that adds one channel after another, largest share first."""
    last = len(nodes) - 1
    first = np.minimum((rgb * last).astype(int), last - 1)
    share = rgb * last - first
    result = np.empty_like(rgb)
    for row, part in enumerate(share):
        corner = first[row]
        result[row] = nodes[tuple(corner)]
        for axis in np.argsort(-part, kind="stable"):
            after = corner + np.eye(3, dtype=int)[axis]
            result[row] += part[axis] * (nodes[tuple(after)] - nodes[tuple(corner)])
            corner = after
    return result


def transicc(path, rgb):
    """Apply a device link by lcms, with codes of 8 bits."""
    asked = "\n".join(" ".join(map(repr, row)) for row in (255 * rgb).tolist())
    command = ["transicc", "-n", "-c0", "-l", path]
    answer = subprocess.run(command, input=asked, text=True, capture_output=True, check=True)
    return np.array([line.split() for line in answer.stdout.splitlines() if line], float) / 255


@pytest.mark.slow
@pytest.mark.parametrize("source", ["srgb", "display-p3"])
def test_grey_skin_sky_and_primaries_in_other_programs(tmp_path, source):
    made = link(device(source), device("srgb"))
    rgb = np.concatenate(list(PATCHES.values())) / 255
    made.save(tmp_path / "link.cube")
    made.save(tmp_path / "link.icc")
    nodes = cube_of(tmp_path / "link.cube")
    results = [trilinear(nodes, rgb), tetrahedral(nodes, rgb)]
    if shutil.which("transicc") is not None:
        results.append(transicc(tmp_path / "link.icc", rgb))
    greys = len(PATCHES["grey"])
    for result in results:
        # half a code of 8 bits: trilinear interpolation takes corners out of gamut into account
        np.testing.assert_allclose(result[:greys], rgb[:greys], atol=0.5 / 255)
        if source == "srgb":
            np.testing.assert_allclose(result, rgb, atol=1e-4)
            continue
        before, after = (
            device(name).to_colour(np.clip(values, 0, 1), space="CIELAB")
            for name, values in ((source, rgb), ("srgb", result))
        )
        common = slice(greys + len(PATCHES["skin"] + PATCHES["sky"]))
        assert delta_e_2000(before[common], after[common]).max() < 0.2  # between nodes
        red, green, blue = (255 * result)[-5:-2]
        assert red[0] > 254  # P3's red is no orange, and its blue neither purple nor cyan
        assert red[1:].max() < 40
        assert green[1] > 254
        assert blue[2] > 254
        assert blue[:2].max() < 40


INKS = np.array(
    [*np.eye(4), (0, 0, 0, 0), (0, 0, 0, 0.5), (0, 0, 0, 0.03), (0.5, 0, 0, 0), (0, 0.97, 0, 0)]
)


@pytest.mark.slow
@pytest.mark.parametrize("preserve", ["black", "primaries"])
def test_a_press_to_itself_keeps_pure_inks(tmp_path, preserve):
    press, path = device("coated"), tmp_path / "press.icc"
    made = link(press, press, size=5, preserve=preserve)
    kept = INKS if preserve == "primaries" else INKS[(INKS[:, :3] == 0).all(axis=1)]
    np.testing.assert_allclose(made.table.values(kept), kept, atol=1e-6)
    if shutil.which("icclu") is not None:
        made.save(path)
        asked = "\n".join(" ".join(map(str, row)) for row in kept)
        answer = subprocess.run(
            ["icclu", "-v0", path], input=asked, text=True, capture_output=True, check=True
        )
        applied = np.array([line.split() for line in answer.stdout.splitlines()], float)
        np.testing.assert_allclose(applied, kept, atol=2e-5)


@pytest.mark.slow
def test_pure_inks_of_another_press_stay_pure_and_keep_their_order():
    one, two = device("coated"), device("uncoated")
    made = link(one, two, size=5, preserve="primaries")
    nodes = np.linspace(0, 1, 5)
    for ink in range(4):
        values = made.table.values(nodes[:, np.newaxis] * np.eye(4)[ink])
        assert (np.delete(values, ink, axis=1) == 0).all()
        assert values[[0, -1], ink] == pytest.approx([0, 1], abs=1e-6)
        assert (np.diff(values[:, ink]) > 0).all()
    # greys of black alone are as light, relative to paper and solid, as in the source
    black = nodes[:, np.newaxis] * (0, 0, 0, 1)
    lightness = [
        press.to_colour(each, space="CIELAB")[:, 0]
        for press, each in ((one, black), (two, made.table.values(black)))
    ]
    shares = [(100 - each) / (100 - each[-1]) for each in lightness]
    np.testing.assert_allclose(*shares, atol=0.02)


@pytest.mark.parametrize(
    ("source", "destination", "preserve"),
    [("srgb", "press", "black"), ("press", "srgb", "primaries"), ("press", "press", "inks")],
)
def test_pure_inks_that_do_not_apply(few_patches, source, destination, preserve):
    gamuts = {"srgb": device("srgb"), "press": Gamut(few_patches, space=PICTURE_SPACE, **COARSE)}
    with pytest.raises(OptionError) as refused:
        link(gamuts[source], gamuts[destination], preserve=preserve, size=3)
    assert refused.value.where["field"] == "preserve"
    assert refused.value.remedy
