"""The nearest point by ΔE00, compared with dense samples of the surface."""

import numpy as np
import pytest

from gamutcore.errors import InvalidPointsError
from gamutcore.queries import build_index, contains, nearest
from gamutcore.queries.colour_difference import delta_e_2000
from gamutcore.queries.nearest_ciede2000 import nearest_ciede2000


def surface(level, count):
    """Return points of all faces, so dense that `count` are on an edge."""
    vertices, faces, _ = level
    steps = [(i, j, count - i - j) for i in range(count + 1) for j in range(count + 1 - i)]
    weights = np.array(steps) / count
    return np.einsum("sc,fcx->fsx", weights, np.asarray(vertices, float)[faces]).reshape(-1, 3)


def smallest(point, samples):
    """Return the smallest ΔE00 between a colour and samples."""
    return delta_e_2000(np.repeat([point], len(samples), axis=0), samples).min()


class TestNearestCiede2000:
    @pytest.mark.parametrize(("count", "samples"), [(8, 60), (40, 30), (300, 12)])
    def test_is_not_above_any_point_of_the_surface(self, rough, count, samples):
        level = rough(31, count, 0.2)
        points = surface(level, samples)
        random = np.random.default_rng(0)
        colours = random.uniform((0, -110, -110), (110, 110, 110), (40, 3))
        colours[:10, 1:] *= 0.05
        found = nearest_ciede2000(colours, level)
        # where hues are opposite, the formula is not continuous
        along = (found.points[:, 1:] * colours[:, 1:]).sum(axis=1)
        tolerance = np.where(along > 0, 1e-6, 0.1)
        assert (along > 0).sum() > 25
        for row, colour in enumerate(colours):
            assert found.distance[row] <= smallest(colour, points) + tolerance[row]

    def test_fields_describe_one_point_of_the_surface(self, rough):
        vertices, faces, _ = level = rough(32, 200, 0.2)
        colours = np.random.default_rng(1).uniform((0, -110, -110), (110, 110, 110), (60, 3))
        found = nearest_ciede2000(colours, level)
        np.testing.assert_allclose(delta_e_2000(colours, found.points), found.distance, atol=1e-9)
        assert (found.weights >= 0).all()
        corners = vertices.astype(float)[faces[found.faces]]
        at = np.einsum("nc,ncx->nx", found.weights, corners)
        np.testing.assert_allclose(found.points, at, atol=1e-10)
        euclidean = nearest(colours, level)
        assert (found.distance <= delta_e_2000(colours, euclidean.points) + 1e-9).all()

    def test_no_point_nearby_is_better(self, rough):
        """The minimum in its face is exact to 1e-6."""
        vertices, faces, _ = level = rough(33, 60, 0.2)
        random = np.random.default_rng(2)
        colours = random.uniform((0, -110, -110), (110, 110, 110), (30, 3))
        found = nearest_ciede2000(colours, level)
        corners = vertices.astype(float)[faces[found.faces]]
        for size in (1e-1, 1e-2, 1e-3):
            for _ in range(50):
                other = found.weights + size * random.normal(size=found.weights.shape)
                other = np.maximum(other, 0)
                other /= other.sum(axis=1, keepdims=True)
                near = np.einsum("nc,ncx->nx", other, corners)
                assert (delta_e_2000(colours, near) >= found.distance - 1e-6).all()

    def test_of_points_of_the_surface_is_zero(self, rough):
        level = rough(34, 100, 0.2)
        points = surface(level, 3)[::40]
        assert nearest_ciede2000(points, level).distance.max() < 1e-5

    def test_does_not_depend_on_other_rows(self, rough):
        index = build_index(*rough(35, 100, 0.2))
        colours = np.random.default_rng(3).uniform((0, -110, -110), (110, 110, 110), (20, 3))
        together = nearest_ciede2000(colours, index)
        for row in range(0, 20, 5):
            alone = nearest_ciede2000(colours[row : row + 1], index)
            assert abs(alone.distance[0] - together.distance[row]) < 1e-6

    @pytest.mark.slow
    def test_neutral_colours_and_opposite_hues(self, rough):
        """The white and the black end are the nearest of many colours."""
        level = rough(36, 120, 0.1)
        points = surface(level, 25)
        random = np.random.default_rng(4)
        colours = random.uniform((-40, -150, -150), (140, 150, 150), (30, 3))
        colours[:10, 1:] = 0
        colours[10:20, 1:] *= 0.01
        found = nearest_ciede2000(colours, level)
        along = (found.points[:, 1:] * colours[:, 1:]).sum(axis=1)
        tolerance = np.where(along >= 0, 1e-6, 0.1)
        for row, colour in enumerate(colours):
            assert found.distance[row] <= smallest(colour, points) + tolerance[row]

    def test_order_of_the_rows_does_not_matter(self, rough):
        index = build_index(*rough(37, 200, 0.2))
        colours = np.random.default_rng(6).uniform((-40, -150, -150), (140, 150, 150), (200, 3))
        turned = nearest_ciede2000(colours[::-1], index).distance[::-1]
        distance = nearest_ciede2000(colours, index).distance
        alone = [nearest_ciede2000(each[None], index).distance[0] for each in colours[:50]]
        assert (np.abs(distance - turned) < 1e-6).mean() > 0.95  # others have the opposite hue
        assert np.abs(distance - turned).max() < 0.1
        assert np.abs(distance[:50] - alone).max() < 0.1

    def test_of_colours_far_away_is_found_soon(self, rough):
        """The formula is nearly constant there."""
        level = rough(38, 100, 0.2)
        colours = np.random.default_rng(7).uniform((0, -80, -80), (100, 80, 80), (30, 3))
        for size in (1e3, 1e6, 1e40):
            found = nearest_ciede2000(size * colours, level)
            smallest_of = [smallest(size * colour, surface(level, 6)) for colour in colours]
            assert (found.distance <= 1.001 * np.array(smallest_of)).all()

    def test_gamuts_far_larger_than_those_of_colours(self, rough):
        """No face is left out when the number of divisions is used up."""
        vertices, faces, centre = rough(39, 300, 0.2)
        level = 1e6 * vertices.astype(float), faces, 1e6 * centre
        samples = surface(level, 12)
        colours = np.random.default_rng(8).uniform((-40, -90, -90), (140, 90, 90), (12, 3))
        colours = np.concatenate([1e6 * colours, colours])
        found = nearest_ciede2000(colours, level)
        smallest_of = np.array([smallest(colour, samples) for colour in colours])
        assert (found.distance <= 1.01 * smallest_of).all()

    def test_no_point_is_no_answer_and_bad_rows_are_named(self, cube):
        assert [len(field) for field in nearest_ciede2000(np.zeros((0, 3)), cube)] == [0, 0, 0, 0]
        with pytest.raises(InvalidPointsError, match="Row 1"):
            nearest_ciede2000([(0, 0, 0), (0, np.inf, 0)], cube)

    @pytest.mark.slow
    def test_beside_a_press_it_is_well_below_the_euclidean_one(self, fogra39_gamut):
        """For colours 3 to 20 ΔE outside, the medians are about 6.9 and 5.1."""
        level = fogra39_gamut.level(1000)
        index = build_index(level.vertices, level.faces, fogra39_gamut.history.centre)
        colours = np.random.default_rng(4).uniform((0, -100, -100), (100, 100, 100), (6000, 3))
        colours = colours[~contains(colours, index)]
        plain = nearest(colours, index)
        kept = (plain.distance >= 3) & (plain.distance <= 20)
        euclidean = delta_e_2000(colours, plain.points)[kept]
        found = nearest_ciede2000(colours[kept], index)
        assert (found.distance <= euclidean + 1e-9).all()
        assert abs(np.median(euclidean) - 6.9) < 0.2
        assert abs(np.median(found.distance) - 5.1) < 0.2
        # no point of a dense sample is better
        points = surface(index[:3], 12)
        rows = np.random.default_rng(5).choice(len(found.distance), 40, replace=False)
        for row in rows:
            assert found.distance[row] <= smallest(colours[kept][row], points) + 1e-6
