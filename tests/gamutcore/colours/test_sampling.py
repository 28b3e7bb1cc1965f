"""Points and faces on the surface of a device, and the ink limits that cut it."""

import json
from dataclasses import replace
from itertools import product
from math import comb, factorial, isqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.boundary import compute_boundary
from gamutcore.characterisation import Picture, read_characterisation
from gamutcore.colours import InkLimits, colours_in_space, surface_colours
from gamutcore.colours.sampling import distinct_rows
from gamutcore.colours.spaces import CIELAB
from gamutcore.errors import OptionError
from gamutcore.geometry import TriangleMesh
from gamutcore.levels import radial_difference


def bent(device):
    """Colours with the largest curvature at low values of the first channel."""
    a, b, c = (device[:, i % device.shape[1]] for i in range(3))
    return np.column_stack(
        [50 + 40 * a**0.3, 60 * (a**0.3 - b), 60 * (b - c) + 10 * device.sum(axis=1)]
    )


def inks(count, colours=bent, levels=(0.0, 1.0), lowest=None):
    """Measured samples of all combinations of levels of the first inks of seven or more."""
    device = np.array(list(product(levels, repeat=count)))
    rest = max(7 - count, 0)
    names = [f"{count + rest}CLR_{ink}" for ink in range(1, count + rest + 1)]
    others = np.full((len(device), rest), 0.0 if lowest is None else lowest)
    document = {
        "columns": [*names, "LAB_L", "LAB_A", "LAB_B"],
        "samples": np.hstack([100 * device, 100 * others, colours(device)]).tolist(),
    }
    return read_characterisation(json.dumps(document).encode())


def surface_of(count, wanted, total=None, **options):
    """Surface of a device of inks, with the values of the inks that vary only."""
    limits = None if total is None else InkLimits(100 * total)
    kind = options.pop("model", None)
    data = inks(count, **options)
    found = surface_colours(
        data, intent="absolute", surface_samples=wanted, limits=limits, model=kind
    )
    return replace(found, device=found.device[:, :count])


def corners_of(count, total):
    """Where all inks are 0 or 1, or all but one and the sum is the limit."""
    corners = {corner for corner in product((0.0, 1.0), repeat=count) if sum(corner) <= total}
    for corner in list(corners):
        rest = total - sum(corner)
        if 0 < rest < 1:
            ends = np.flatnonzero(np.array(corner) == 0)
            corners |= {tuple(np.where(np.arange(count) == end, rest, corner)) for end in ends}
    return {tuple(np.round(corner, 6).tolist()) for corner in corners}


def area_of_all_faces(count, total):
    """Sum of the areas of the two-dimensional faces of a cut cube."""
    area = 0.0
    # The cube's faces: what is left of the unit square at each corner of the other channels.
    for ones in range(count - 1):
        rest = total - ones
        below = [max(rest - k, 0) ** 2 / 2 for k in range(3)]
        square = below[0] - 2 * below[1] + below[2]
        area += comb(count, 2) * comb(count - 2, ones) * square
    # The cut's: a plane section of the unit cube at each corner of the others; its area is √3
    # times that of its projection, the part of the square where the third is within 0 and 1.
    for ones in range(count - 2):
        rest = total - ones
        below = [max(rest - k, 0) ** 2 / 2 for k in range(4)]
        section = below[0] - 3 * below[1] + 3 * below[2] - below[3]
        area += comb(count, 3) * comb(count - 3, ones) * np.sqrt(3) * section
    return area


def volume_below(count, total):
    """Volume of the unit cube up to a sum (Irwin-Hall distribution)."""
    return sum(
        (-1) ** k * comb(count, k) * max(total - k, 0) ** count for k in range(count + 1)
    ) / factorial(count)


def areas(corners):
    """Areas of triangles in any number of dimensions."""
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    gram = (one**2).sum(1) * (two**2).sum(1) - (one * two).sum(1) ** 2
    return np.sqrt(np.maximum(gram, 0)) / 2


@given(st.integers(1, 6), st.integers(8, 4000), st.one_of(st.none(), st.floats(0.1, 6)))
@pytest.mark.slow
def test_points_are_on_the_surface_and_no_more_than_asked_for(count, wanted, total):
    device = surface_of(count, wanted, total).device
    limit = count if total is None else min(total, count)
    corners = corners_of(count, limit)
    assert device.min() >= -1e-9
    assert device.max() <= 1 + 1e-9
    assert len(device) <= max(wanted, len(corners))
    assert device.sum(axis=1).max() <= limit + 1e-6
    ends = ((device < 1e-6) | (device > 1 - 1e-6)).sum(axis=1)
    if count > 1:
        ends += (np.abs(device.sum(axis=1) - limit) < 1e-6) & (ends < count)
    assert (ends >= count - 2).all()


@pytest.mark.parametrize(("count", "total"), [(3, 1.5), (4, 3.0), (4, 2.4), (7, 3.5), (7, None)])
def test_every_corner_is_a_point(count, total):
    device = surface_of(count, 5000, total).device
    found = {tuple(row) for row in device.round(6).tolist()}
    assert corners_of(count, total or count) <= found


@given(st.integers(20, 3000), st.one_of(st.none(), st.floats(0.1, 3)), st.floats(0.05, 0.9))
@pytest.mark.slow
def test_three_channels_have_a_closed_surface(wanted, total, power):
    """Closed, oriented outwards, and with the area and volume of the cut cube."""
    found = surface_of(3, wanted, total, colours=lambda device: bent(device**power))
    faces, limit = found.faces, 3 if total is None else total
    assert faces.closed
    assert faces.labels.shape == (len(faces.corners),)
    mesh = TriangleMesh(found.device, faces.corners)
    assert mesh.validity().is_sphere
    assert abs(mesh.volume) == pytest.approx(volume_below(3, limit), rel=1e-6)
    assert areas(found.device[faces.corners]).sum() == pytest.approx(area_of_all_faces(3, limit))


@settings(max_examples=40)
@given(st.integers(4, 6), st.integers(3000, 6000), st.one_of(st.none(), st.floats(0.3, 5)))
@pytest.mark.slow
def test_faces_of_more_channels_cover_every_face_once_and_meet_edge_to_edge(count, wanted, total):
    found = surface_of(count, wanted, total)
    faces, limit = found.faces, count if total is None else min(total, count)
    assert not faces.closed
    covered = areas(found.device[faces.corners]).sum()
    assert covered == pytest.approx(area_of_all_faces(count, limit), rel=1e-6)
    # every edge of the cube is an edge of n - 1 faces; of the limit's plane, of two or more
    edges = np.sort(np.concatenate([faces.corners[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]))
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert uses.min() >= 2


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_faces_are_turned_outwards_in_colours(sign):
    found = surface_of(3, 500, colours=lambda device: 100 * device * [1.0, 1.0, sign])
    found = colours_in_space(found, CIELAB)
    assert TriangleMesh(found.points, found.faces.corners).volume == pytest.approx(1e6)


@pytest.mark.parametrize("count", [1, pytest.param(2, marks=pytest.mark.slow), 13])
def test_there_are_no_faces_where_nothing_is_enclosed_or_points_are_few(count):
    assert surface_of(count, 50).faces is None


@pytest.mark.parametrize(("count", "total"), [(3, None), (4, None), (4, 2.5), (5, None)])
def test_nearly_as_many_as_asked_for_each_once(count, total):
    found = surface_of(count, 20_000, total, levels=(0.0, 0.2, 1.0), model="fit")
    assert found.provenance["surface"]["density"] == "by curvature"
    assert 0.95 * 20_000 <= len(found.device) <= 20_000
    if total is None:
        assert len(np.unique(found.device.round(12), axis=0)) == len(found.device)


def test_flat_colours_are_sampled_evenly():
    def flat(device):
        return device @ np.array([[40.0, 10, 0], [30, -50, 20], [20, 30, -60]])

    for values in surface_of(3, 20_000, colours=flat).device.T:
        counts, _ = np.histogram(values, bins=4, range=(0.01, 0.99))
        assert counts.max() < 1.25 * counts.min()


def test_nodes_of_the_model_are_among_the_points():
    device = np.array(list(product((0.0, 0.13, 0.4, 1.0), repeat=3)))
    rows = np.hstack([100 * device, bent(device)]).tolist()
    document = {"columns": ["CMY_C", "CMY_M", "CMY_Y", "L", "a", "b"], "samples": rows}
    data = read_characterisation(json.dumps(document).encode())
    for values in surface_colours(data, intent="absolute", surface_samples=20_000).device.T:
        assert {0.13, 0.4} <= set(values.round(9))


def test_few_points_for_many_inks_are_uniform():
    assert surface_of(7, 2000).provenance["surface"]["density"] == "uniform"


@pytest.mark.slow
def test_the_cut_of_many_inks_is_sampled_at_its_corners_and_on_its_faces():
    """Hundreds of thousands of corners of trapezoids that share vertices and edges."""
    found = surface_of(11, 100_000, 5.5)
    device = found.device
    assert found.provenance["surface"]["density"] == "uniform"
    assert len(device) <= 100_000
    assert device.sum(axis=1).max() <= 5.5 + 1e-9
    # Two-dimensional faces: of the cube's, or of the plane's, where three channels may vary.
    inner = ((device > 1e-9) & (device < 1 - 1e-9)).sum(axis=1)
    on_plane = np.abs(device.sum(axis=1) - 5.5) < 1e-9
    assert (inner <= np.where(on_plane, 3, 2)).all()
    assert corners_of(11, 5.5) <= {tuple(row) for row in device.round(6).tolist()}


@pytest.mark.parametrize(
    ("file", "points", "gain"),
    [
        # docs/decisions/surface-sampling.md: 0.62, 0.42, 0.97 and 0.72 of the mismatch of uniform
        # points, against a denser reference than this one.
        ("oracle/SWOP2013C3_CRPC5.icc", 8_000, 0.85),
        ("oracle/Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc", 20_000, 0.7),
        ("display/Acer_XB271HU.icc", 8_000, 1.0),
        ("spaces/sRGB-v4.icc", 8_000, 0.85),
    ],
)
@pytest.mark.slow
def test_more_accurate_than_as_many_uniform_points(
    shared_data, uniform_surface, file, points, gain
):
    profile = read_characterisation((shared_data / file).read_bytes())
    channels = len(profile.channels)

    def uniform(count):
        device = uniform_surface(channels, isqrt(count // (comb(channels, 2) << (channels - 2))))
        picture = Picture("tiff", "CMYK", device, np.ones(len(device), np.int64), profile)
        return surface_colours(picture).points

    def boundary(colours, centre="auto"):
        return compute_boundary(colours, "modified-convex-hull", centre, gamma=0.2)

    reference = boundary(uniform(20 * points))
    centre = tuple(reference.centre)
    shared_out = surface_colours(profile, surface_samples=points).points
    assert len(shared_out) <= points
    errors = [
        radial_difference(reference.mesh, boundary(colours, centre).mesh, centre).difference
        for colours in (uniform(points), shared_out)
    ]
    assert errors[1] < gain * errors[0]


@given(
    st.integers(1, 15).flatmap(
        lambda columns: st.lists(
            st.lists(
                st.sampled_from([0.0, 0.1, 0.25, 0.5, 1.0]), min_size=columns, max_size=columns
            ),
            min_size=1,
            max_size=60,
        )
    )
)
@pytest.mark.slow
def test_distinct_rows_are_those_of_numpy(rows):
    distinct, places = distinct_rows(np.array(rows))
    expected, inverse = np.unique(np.array(rows), axis=0, return_inverse=True)
    np.testing.assert_array_equal(distinct, expected)
    np.testing.assert_array_equal(places, inverse.reshape(-1))


def test_rows_that_are_not_told_apart_at_once_are_distinct(monkeypatch):
    """With factors for the first column only, rows with equal first columns collide."""

    class Chance:
        def integers(self, *_limits, size, dtype):
            return np.full(size, 2**63, dtype)  # doubled, that is nothing: all factors are 1

    rows = np.array([[0.5, 1.0], [1.0, 0.5], [0.5, 1.0], [0.25, 0.25]])  # two of equal sums
    monkeypatch.setattr(np.random, "default_rng", lambda _seed: Chance())
    distinct, places = distinct_rows(rows)
    np.testing.assert_array_equal(distinct, [[0.25, 0.25], [0.5, 1.0], [1.0, 0.5]])
    np.testing.assert_array_equal(places, [1, 2, 1, 0])


@pytest.mark.parametrize("name", ["K", "Black", " black ", "Schwarz"])
def test_a_black_limit_shortens_black(name):
    data = inks(7)
    named = replace(data, channels=(*data.channels[:2], name, *data.channels[3:]))
    found = surface_colours(named, surface_samples=200, limits=InkLimits(black=40))
    np.testing.assert_allclose(found.device.max(axis=0), [1, 1, 0.4, 1, 1, 1, 1])


def test_inks_that_never_vary_count_towards_the_limit():
    found = surface_colours(
        inks(3, lowest=0.1), surface_samples=500, limits=InkLimits(200), intent="absolute"
    )
    assert found.device[:, :3].sum(axis=1).max() == pytest.approx(1.6)
    assert found.device.sum(axis=1).max() == pytest.approx(2.0)


def test_a_limit_below_one_ink_shortens_all():
    np.testing.assert_allclose(surface_of(3, 500, 0.5).device.max(axis=0), 0.5)


@pytest.mark.parametrize(
    ("limits", "lowest", "field"),
    [
        (InkLimits(black=90), 0.0, "black_limit"),  # which channel is black is not known
        (InkLimits(30), 0.1, "ink_limit"),  # four inks are never below 10 %
        (InkLimits(300, 0), 0.0, "black_limit"),
    ],
)
def test_limits_that_leave_nothing_are_refused(limits, lowest, field):
    with pytest.raises(OptionError) as caught:
        surface_colours(
            inks(3, lowest=lowest), intent="absolute", surface_samples=50, limits=limits
        )
    assert caught.value.where == {"field": field}


def press(lowest=0.0):
    levels = 100 * np.linspace(lowest, 1, 4)
    device = np.stack(np.meshgrid(*[levels] * 4), axis=-1).reshape(-1, 4)
    lab = np.column_stack(
        [100 - device @ [0.2, 0.25, 0.1, 0.4], device[:, :2] @ [-0.3, 0.6], device[:, 2] * 0.8]
    )
    columns = ["CMYK_C", "CMYK_M", "CMYK_Y", "CMYK_K", "LAB_L", "LAB_A", "LAB_B"]
    document = {"columns": columns, "samples": np.column_stack([device, lab]).tolist()}
    return read_characterisation(json.dumps(document).encode())


def test_a_black_limit_below_all_black_is_refused():
    with pytest.raises(OptionError) as caught:
        surface_colours(press(0.1), limits=InkLimits(black=5))
    assert caught.value.where == {"field": "black_limit"}
    assert "10 %" in caught.value.message


@pytest.mark.parametrize("samples", [50, 500, 5000])
@pytest.mark.parametrize(("total", "black"), [(300, None), (240, 80), (None, 50), (150, 0)])
def test_a_press_keeps_to_its_limits(samples, total, black):
    surface = surface_colours(press(), surface_samples=samples, limits=InkLimits(total, black))
    device = surface.device
    assert device.sum(axis=1).max() <= (total or 400) / 100 + 1e-9
    assert device[:, 3].max() <= (black if black is not None else 100) / 100 + 1e-9
    assert surface.provenance["ink_limits"] == {"total": total, "black": black}
    if total is not None:
        # The cut's own faces, where three or more inks share the limit, are sampled as well.
        on_cut = np.abs(device.sum(axis=1) - total / 100) < 1e-6
        assert on_cut.sum() >= 6
        if samples == 5000:
            between = ((device > 1e-6) & (device < 1 - 1e-6)).sum(axis=1)
            assert (between[on_cut] >= 3).any()


@pytest.mark.parametrize(
    ("columns", "rows"),
    [
        ("R G B L a b", [[0, 0, 0, 0, 0, 0], [1, 1, 1, 90, 0, 0]]),
        ("CMYK_C CMYK_M CMYK_Y CMYK_K L a b", [[0, 0, 0, 0, 90, 0, 0]]),
    ],
)
def test_limits_are_refused_where_there_is_no_model_of_inks(columns, rows):
    document = {"columns": columns.split(), "samples": rows}
    data = read_characterisation(json.dumps(document).encode())
    with pytest.raises(OptionError) as caught:
        surface_colours(data, limits=InkLimits(300))
    assert caught.value.where == {"field": "ink_limit"}


def test_profiles_of_lights_refuse_limits(small_profile):
    profile = read_characterisation(small_profile("sRGB-v4.icc"))
    with pytest.raises(OptionError):
        surface_colours(profile, limits=InkLimits(300))
