"""Optimal colours: symmetry, convexity, published luminous limits."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull, KDTree

from gamutcore.colours.optimal_colours import (
    optimal_colours,
    optimal_faces,
    spectral_weights,
)
from gamutcore.colours.spaces.cielab import white_of
from gamutcore.mesh import TriangleMesh

CASES = [(light, observer) for light in ("D50", "D65", "A") for observer in (2, 10)]


@pytest.mark.parametrize(("light", "observer"), CASES)
def test_all_light_together_is_the_white(light, observer):
    weights = spectral_weights(light, observer)
    np.testing.assert_allclose(weights.sum(axis=0), white_of(light, str(observer)), atol=4e-4)


@pytest.mark.parametrize(("light", "observer"), CASES)
def test_the_complement_of_an_optimal_colour_is_optimal(light, observer):
    """The solid is a zonoid: point-symmetric about half of the white."""
    colours = optimal_colours(light, observer, 3000)
    white = colours[-1]
    distance, _ = KDTree(colours).query(white - colours)
    assert distance.max() < 1e-9


@pytest.mark.parametrize("count", [300, 5000, 60_000, 10**6])
def test_there_are_at_most_as_many_colours_as_asked_for(count):
    colours = optimal_colours("D65", 2, count)
    assert len(colours) <= count
    np.testing.assert_array_equal(colours[0], 0)
    assert colours[-1][1] == pytest.approx(1)


@pytest.mark.slow
def test_all_optimal_colours_are_on_their_convex_hull():
    colours = optimal_colours("D50", 2, 4000)
    planes = ConvexHull(colours).equations
    distances = -(colours @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    assert distances.max() < 1e-4


@pytest.mark.parametrize(("light", "observer"), CASES)
def test_the_faces_are_those_of_the_convex_hull(light, observer):
    colours = optimal_colours(light, observer, 4000)
    mesh = TriangleMesh(colours, optimal_faces(len(colours)))
    assert mesh.triangles == 2 * len(colours) - 4
    assert mesh.validity().is_sphere
    # the spectrum locus is concave by a little at its ends
    assert abs(mesh.volume) == pytest.approx(ConvexHull(colours).volume, rel=1e-5)


@pytest.mark.slow
def test_fewer_colours_enclose_less_and_never_more():
    volumes = [ConvexHull(optimal_colours("D50", 2, n)).volume for n in (16254, 60_000, 180_000)]
    assert volumes == sorted(volumes)
    assert volumes[0] > 0.999 * volumes[-1]
