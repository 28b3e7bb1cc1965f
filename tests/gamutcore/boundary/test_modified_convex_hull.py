"""The modified convex hull: published volumes, its definition, and arbitrary input."""

import itertools
import sys

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gamutcore import Gamut
from gamutcore.boundary import Boundary, modified_convex_hull
from gamutcore.boundary.radial_hull import radial_hull
from gamutcore.errors import (
    BoundaryError,
    CentreError,
    FlatPointsError,
    GamutError,
    InvalidPointsError,
    OptionError,
    TooFewPointsError,
)
from gamutcore.geometry import grid_step, nearest_grid_points

D50 = np.array([0.96422, 1.0, 0.82521])
WHITES = {"D65": (0.95047, 1.0, 1.08883), "C": (0.98074, 1.0, 1.18232), "D50": D50}
BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
WORKING_SPACES = {
    # Bruce Lindbloom's table of RGB working spaces: primaries' x y, white, gamma, CIELAB volume
    "sRGB": ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), "D65", 2.2, 832_870),
    "Adobe RGB": ((0.64, 0.33), (0.21, 0.71), (0.15, 0.06), "D65", 2.2, 1_208_631),
    "Apple RGB": ((0.625, 0.34), (0.28, 0.595), (0.155, 0.07), "D65", 1.8, 798_403),
    "Beta RGB": ((0.6888, 0.3112), (0.1986, 0.7551), (0.1265, 0.0352), "D50", 2.2, 1_717_450),
    "ColorMatch": ((0.63, 0.34), (0.295, 0.605), (0.15, 0.075), "D50", 1.8, 836_975),
    "NTSC": ((0.67, 0.33), (0.21, 0.71), (0.14, 0.08), "C", 2.2, 1_300_252),
    "ProPhoto": ((0.7347, 0.2653), (0.1596, 0.8404), (0.0366, 0.0001), "D50", 1.8, 2_879_568),
    "Wide Gamut": ((0.735, 0.265), (0.115, 0.826), (0.157, 0.018), "D50", 2.2, 2_164_221),
}
STEPS = 129


def cube_faces(steps):
    """Return device values on the faces of the RGB cube and triangles between them."""
    axis = np.linspace(0.0, 1.0, steps)
    one, two = np.meshgrid(axis, axis, indexing="ij")
    index = np.arange(steps * steps).reshape(steps, steps)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    quads = quads.reshape(-1, 4)
    faces = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    points, triangles = [], []
    for channel, side in itertools.product(range(3), (0.0, 1.0)):
        face = np.empty((steps * steps, 3))
        face[:, channel] = side
        face[:, (channel + 1) % 3], face[:, (channel + 2) % 3] = one.ravel(), two.ravel()
        triangles.append((faces if side else faces[:, ::-1]) + steps * steps * len(points))
        points.append(face)
    return np.vstack(points), np.vstack(triangles)


@pytest.fixture(scope="module")
def working_space():
    """Return a function from a name to CIELAB of the cube's faces and the volume between them."""
    device, triangles = cube_faces(STEPS)

    def lab_and_volume(name):
        *xy, white, gamma, _ = WORKING_SPACES[name]
        primaries = np.array([[x, y, 1 - x - y] for x, y in xy]).T
        matrix = primaries * np.linalg.solve(primaries, WHITES[white])
        gains = (BRADFORD @ D50) / (BRADFORD @ WHITES[white])
        adapted = np.linalg.inv(BRADFORD) @ np.diag(gains) @ BRADFORD @ matrix
        ratio = device**gamma @ adapted.T / D50
        f = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
        lab = np.stack(
            [116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1
        )
        corners = lab[triangles] - (50.0, 0.0, 0.0)
        return lab, np.linalg.det(corners).sum() / 6

    return lab_and_volume


class TestPublishedVolumes:
    @pytest.mark.parametrize("name", WORKING_SPACES)
    @pytest.mark.slow
    def test_of_rgb_working_spaces(self, working_space, name):
        boundary = modified_convex_hull(working_space(name)[0], gamma=0.05)
        assert boundary.mesh.volume == pytest.approx(WORKING_SPACES[name][-1], rel=0.0015)

    @pytest.mark.parametrize(
        ("name", "fifth", "convex"),
        [("sRGB", 0.09, 8.8), ("Adobe RGB", 0.10, 6.1), ("ProPhoto", 0.96, 7.4)],
    )
    def test_overshoot_with_gamma_a_fifth_and_of_the_convex_hull(
        self, working_space, name, fifth, convex
    ):
        lab, volume = working_space(name)
        for gamma, overshoot, tolerance in ((0.2, fifth, 0.03), (1.0, convex, 0.1)):
            boundary = modified_convex_hull(lab, gamma, (50.0, 0.0, 0.0))
            found = 100 * (boundary.mesh.volume / volume - 1)
            assert found == pytest.approx(overshoot, abs=tolerance)


def fibonacci_sphere(count):
    """Return nearly evenly spread points on the unit sphere."""
    index = np.arange(count) + 0.5
    turn, height = index * np.pi * (1 + np.sqrt(5)), 1 - 2 * index / count
    chord = np.sqrt(1 - height**2)
    return np.stack([chord * np.cos(turn), chord * np.sin(turn), height], axis=1)


def grid(steps):
    """Return the points of a full grid in the cube from 0 to 1: coplanar and co-spherical."""
    axis = np.linspace(0, 1, steps)
    return np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)


def cube_surface(steps):
    points = grid(steps)
    return points[((points == 0) | (points == 1)).any(axis=1)]


class TestDefinition:
    @pytest.mark.parametrize("gamma", [0.05, 0.2, 0.5, 1.0])
    def test_radii_to_power_no_point_is_outside_of_any_face(self, random_cloud, gamma):
        points = random_cloud(3, 500)
        centre = np.array([48.0, 1.0, -2.0])
        boundary = modified_convex_hull(points, gamma, centre)

        def raised(positions):
            relative = np.asarray(positions, np.float64) - centre
            radii = np.linalg.norm(relative, axis=1)[:, np.newaxis] / 60
            return relative / 60 * radii ** (gamma - 1)

        one, two, three = (
            raised(boundary.mesh.vertices)[boundary.mesh.faces[:, i]] for i in range(3)
        )
        normals = np.cross(two - one, three - one)
        normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
        rounded = nearest_grid_points(points, grid_step(points))
        heights = raised(rounded) @ normals.T - np.einsum("ij,ij->i", normals, one)
        assert heights.max() < 1e-12

    def test_vertices_are_given_points_and_say_which(self, random_cloud):
        points = random_cloud(4)
        boundary = modified_convex_hull(points)
        rounded = nearest_grid_points(points, grid_step(points))
        np.testing.assert_array_equal(boundary.mesh.vertices, rounded[boundary.sources])
        assert len(np.unique(boundary.sources)) == len(boundary.sources)

    def test_a_small_gamma_puts_all_points_on_the_surface(self, random_cloud):
        points = random_cloud(5)
        assert len(modified_convex_hull(points, 0.01).mesh.vertices) == len(points)

    def test_a_larger_gamma_keeps_no_point_that_a_smaller_one_drops(self, random_cloud):
        # what a plane bounds with radii to the power γ is, with a smaller power, a convex set that
        # touches the same points
        points = random_cloud(6, 400)
        kept = [
            set(modified_convex_hull(points, gamma, (50, 0, 0)).sources.tolist())
            for gamma in (0.05, 0.1, 0.2, 0.5, 1.0)
        ]
        for more, fewer in itertools.pairwise(kept):
            assert fewer < more


class TestKnownBodies:
    def test_a_sphere(self, assert_every_invariant):
        boundary = modified_convex_hull(fibonacci_sphere(4000), centre=(0, 0, 0))
        assert_every_invariant(boundary.mesh, boundary.centre, 2 * 4000 - 4)
        # n points of a convex body: relative deficit of the order of 1/n
        assert boundary.mesh.volume == pytest.approx(4 / 3 * np.pi, rel=0.003)
        assert boundary.mesh.area == pytest.approx(4 * np.pi, rel=0.003)

    @pytest.mark.parametrize("gamma", [0.2, 1.0])
    @pytest.mark.parametrize("steps", [2, 3, 7, 12])
    def test_a_cube_of_coplanar_points(self, assert_every_invariant, steps, gamma):
        boundary = modified_convex_hull(cube_surface(steps), gamma)
        assert_every_invariant(boundary.mesh, boundary.centre, boundary.mesh.triangles)
        assert boundary.mesh.volume == pytest.approx(1.0, rel=1e-6)
        assert boundary.mesh.area == pytest.approx(6.0, rel=1e-6)

    def test_a_dent_is_followed(self):
        # a cube with one face's middle pushed half way in: 1 − ⅙ of its volume
        shell = np.vstack([grid(2), [[0.5, 0.5, 0.75]]])
        mesh = modified_convex_hull(shell, 0.05, (0.5, 0.5, 0.4)).mesh
        assert mesh.volume == pytest.approx(1 - 0.25 / 3, rel=1e-6)


class TestInvariance:
    @settings(max_examples=20)
    @given(seed=st.integers(0, 10**6))
    def test_rotation_permutation_and_scale_leave_the_relative_volume(self, random_cloud, seed):
        points, centre = random_cloud(seed) - (50.0, 0.0, 0.0), np.zeros(3)
        volume = modified_convex_hull(points, 0.2, centre).mesh.volume
        random = np.random.default_rng(seed)
        # where four points lie in one plane after the power, a rounding decides which diagonal
        # their quadrilateral has, and the two enclose different volumes
        for _ in range(5):
            nudged = points * (1 + 1e-6 * random.uniform(-1, 1, points.shape))
            other = modified_convex_hull(nudged, 0.2, centre).mesh.volume
            assume(other == pytest.approx(volume, rel=1e-5))
        rotation = np.linalg.qr(random.normal(size=(3, 3)))[0]
        assert modified_convex_hull(points @ rotation, 0.2, centre).mesh.volume == pytest.approx(
            volume, rel=1e-5
        )
        shuffled = random.permutation(points)
        assert modified_convex_hull(shuffled, 0.2, centre).mesh.volume == pytest.approx(
            volume, rel=1e-5
        )
        scaled = modified_convex_hull(0.37 * points, 0.2, centre).mesh
        assert scaled.volume == pytest.approx(0.37**3 * volume, rel=1e-5)


def boundary_or_error(points, gamma, centre):
    try:
        return modified_convex_hull(points, gamma, centre)
    except GamutError as error:
        return error


def assert_valid_or_named(points, gamma, centre, assert_every_invariant):
    """Check for a boundary with all invariants, or an error with a remedy."""
    outcome = boundary_or_error(points, gamma, centre)
    if isinstance(outcome, GamutError):
        assert outcome.message
        assert outcome.remedy
    else:
        assert_every_invariant(outcome.mesh, outcome.centre, outcome.mesh.triangles)


NASTY = st.sampled_from(
    [0.0, -0.0, 1.0, -1.0, 0.5, 2.0, 3.0, 1e-7, 1e-30, 1 + 1e-7, 100.0, 1e6, 1e11, -1e11]
)


class TestAnything:
    @settings(max_examples=150)
    @given(
        points=arrays(np.float64, st.tuples(st.integers(0, 30), st.just(3)), elements=NASTY),
        gamma=st.sampled_from([0.01, 0.2, 1.0]),
        centre=st.one_of(st.just("auto"), st.tuples(NASTY, NASTY, NASTY)),
    )
    @pytest.mark.slow
    def test_of_awkward_numbers(self, assert_every_invariant, points, gamma, centre):
        assert_valid_or_named(points, gamma, centre, assert_every_invariant)

    @settings(max_examples=100)
    @given(
        points=arrays(
            np.float64,
            st.tuples(st.integers(4, 40), st.just(3)),
            elements=st.integers(-3, 3).map(float),
        ),
        scale=st.sampled_from([1e-30, 1e-3, 1.0, 1e5]),
        shift=st.sampled_from([0.0, 1.0, 1e3, 1e7]),
        gamma=st.sampled_from([0.05, 0.2, 1.0]),
    )
    @pytest.mark.slow
    def test_of_lattices(self, assert_every_invariant, points, scale, shift, gamma):
        assert_valid_or_named(points * scale + shift, gamma, "auto", assert_every_invariant)

    @settings(max_examples=100)
    @given(
        points=arrays(
            np.float64,
            st.tuples(st.integers(0, 20), st.just(3)),
            elements=st.floats(allow_nan=True, allow_infinity=True),
        )
    )
    def test_of_any_floats(self, assert_every_invariant, points):
        assert_valid_or_named(points, 0.2, "auto", assert_every_invariant)


class TestRefusals:
    @pytest.mark.parametrize(
        ("points", "kind"),
        [
            ([], InvalidPointsError),
            ([1.0, 2.0, 3.0], InvalidPointsError),
            (np.zeros((5, 2)), InvalidPointsError),
            (np.zeros((2, 5, 3)), InvalidPointsError),
            ("points", InvalidPointsError),
            ([["a", "b", "c"]] * 4, InvalidPointsError),
            ([[1, 2, 3], [4, 5]], InvalidPointsError),
            (None, InvalidPointsError),
            (np.eye(4, 3) * 1j, InvalidPointsError),
            ({}, InvalidPointsError),
            (np.eye(3), TooFewPointsError),
            (np.empty((0, 3)), TooFewPointsError),
            (np.repeat(np.eye(3), 10, axis=0), TooFewPointsError),
            (np.ones((50, 3)), TooFewPointsError),
            (np.ones((5000, 3)), FlatPointsError),
            (np.arange(30.0)[:, np.newaxis] * np.ones(3), FlatPointsError),
            (np.random.default_rng(0).random((50, 3)) * (1, 1, 0), FlatPointsError),
            (np.random.default_rng(0).random((50, 3)) @ [[1, 1, 2], [0, 1, 1], [1, 2, 3]],
             FlatPointsError),
            (np.random.default_rng(0).random((50, 3)) * (1, 1, 1e-7), FlatPointsError),
        ],
    )  # fmt: skip
    def test_of_points_without_a_volume(self, points, kind):
        with pytest.raises(InvalidPointsError) as caught:
            modified_convex_hull(points)
        assert type(caught.value) is kind
        assert caught.value.remedy

    @pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e12, -1e300])
    def test_of_a_number_out_of_range_names_its_row(self, value):
        points = cube_surface(3)
        points[7, 1] = value
        with pytest.raises(InvalidPointsError) as caught:
            modified_convex_hull(points)
        assert caught.value.where == {"row": 7}

    @pytest.mark.parametrize(
        "centre",
        [(2, 0, 0), (0, 0, 0), (1, 1, 1), (0.5, 0.5, 0), (0.5, 0.5, 1 + 1e-5), (-1e6, 0.5, 0.5)],
    )
    def test_of_a_centre_that_is_not_inside(self, centre):
        with pytest.raises(CentreError) as caught:
            modified_convex_hull(cube_surface(4), 0.2, centre)
        assert caught.value.where["field"] == "centre"

    def test_of_a_centre_inside_the_bounds_but_outside_the_hull(self):
        with pytest.raises(CentreError):
            modified_convex_hull(np.vstack([np.zeros(3), np.eye(3)]), 0.2, (0.9, 0.9, 0.9))

    @pytest.mark.parametrize(
        "centre", ["middle", (1, 2), (1, 2, 3, 4), None, (np.nan, 0, 0), (0, np.inf, 0), 5, "012"]
    )
    def test_of_a_centre_that_is_not_three_numbers(self, centre):
        with pytest.raises(OptionError) as caught:
            modified_convex_hull(cube_surface(4), 0.2, centre)
        assert caught.value.where["field"] == "centre"

    @pytest.mark.parametrize("gamma", [0, -0.2, 1.0001, np.nan, np.inf, "0.2", [0.2], True])
    def test_of_a_gamma_out_of_range(self, gamma):
        with pytest.raises(OptionError) as caught:
            Gamut(cube_surface(4), gamma=gamma)
        assert caught.value.where["field"] == "gamma"


def test_plates_as_thin_as_their_grid_are_wrapped_or_flat(assert_every_invariant):
    outcomes = set()
    for seed in range(60):
        random = np.random.default_rng(seed)
        rotation = np.linalg.qr(random.normal(size=(3, 3)))[0]
        plate = random.random((20, 3)) * (1, 1, 3e-6) @ rotation
        outcome = boundary_or_error(plate, 0.2, "auto")
        if not isinstance(outcome, GamutError):
            assert_every_invariant(outcome.mesh, outcome.centre, outcome.mesh.triangles)
        outcomes.add((type(outcome), "no centre on their grid" in str(outcome)))
    assert outcomes == {(Boundary, False), (FlatPointsError, False), (FlatPointsError, True)}


def test_a_hull_that_does_not_see_the_centre_would_not_get_through(monkeypatch):
    defined_in = sys.modules[modified_convex_hull.__module__]
    monkeypatch.setattr(
        defined_in, "radial_hull", lambda points: radial_hull(points)[:, ::-1].copy()
    )
    with pytest.raises(BoundaryError):
        modified_convex_hull(cube_surface(3))
