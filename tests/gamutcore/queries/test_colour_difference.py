"""CIEDE2000, compared with the published pairs and with colour-science."""

import numpy as np
import pytest

from gamutcore.colours.spaces.cielab import colour_science
from gamutcore.errors import InvalidPointsError
from gamutcore.queries.colour_difference import delta_e_2000

# Sharma, Wu & Dalal (2005), table I
PAIRS = """
50.0000 2.6772 -79.7751 50.0000 0.0000 -82.7485 2.0425
50.0000 3.1571 -77.2803 50.0000 0.0000 -82.7485 2.8615
50.0000 2.8361 -74.0200 50.0000 0.0000 -82.7485 3.4412
50.0000 -1.3802 -84.2814 50.0000 0.0000 -82.7485 1.0000
50.0000 -1.1848 -84.8006 50.0000 0.0000 -82.7485 1.0000
50.0000 -0.9009 -85.5211 50.0000 0.0000 -82.7485 1.0000
50.0000 0.0000 0.0000 50.0000 -1.0000 2.0000 2.3669
50.0000 -1.0000 2.0000 50.0000 0.0000 0.0000 2.3669
50.0000 2.4900 -0.0010 50.0000 -2.4900 0.0009 7.1792
50.0000 2.4900 -0.0010 50.0000 -2.4900 0.0010 7.1792
50.0000 2.4900 -0.0010 50.0000 -2.4900 0.0011 7.2195
50.0000 2.4900 -0.0010 50.0000 -2.4900 0.0012 7.2195
50.0000 -0.0010 2.4900 50.0000 0.0009 -2.4900 4.8045
50.0000 -0.0010 2.4900 50.0000 0.0010 -2.4900 4.8045
50.0000 -0.0010 2.4900 50.0000 0.0011 -2.4900 4.7461
50.0000 2.5000 0.0000 50.0000 0.0000 -2.5000 4.3065
50.0000 2.5000 0.0000 73.0000 25.0000 -18.0000 27.1492
50.0000 2.5000 0.0000 61.0000 -5.0000 29.0000 22.8977
50.0000 2.5000 0.0000 56.0000 -27.0000 -3.0000 31.9030
50.0000 2.5000 0.0000 58.0000 24.0000 15.0000 19.4535
50.0000 2.5000 0.0000 50.0000 3.1736 0.5854 1.0000
50.0000 2.5000 0.0000 50.0000 3.2972 0.0000 1.0000
50.0000 2.5000 0.0000 50.0000 1.8634 0.5757 1.0000
50.0000 2.5000 0.0000 50.0000 3.2592 0.3350 1.0000
60.2574 -34.0099 36.2677 60.4626 -34.1751 39.4387 1.2644
63.0109 -31.0961 -5.8663 62.8187 -29.7946 -4.0864 1.2630
61.2901 3.7196 -5.3901 61.4292 2.2480 -4.9620 1.8731
35.0831 -44.1164 3.7933 35.0232 -40.0716 1.5901 1.8645
22.7233 20.0904 -46.6940 23.0331 14.9730 -42.5619 2.0373
36.4612 47.8580 18.3852 36.2715 50.5065 21.2231 1.4146
90.8027 -2.0831 1.4410 91.1528 -1.6435 0.0447 1.4441
90.9257 -0.5406 -0.9208 88.6381 -0.8985 -0.7239 1.5381
6.7747 -0.2908 -2.4247 5.8714 -0.0985 -2.2286 0.6377
2.0776 0.0795 -1.1350 0.9033 -0.0636 -0.5514 0.9082
"""


class TestDeltaE2000:
    def test_of_the_published_pairs(self):
        pairs = np.array([line.split() for line in PAIRS.split("\n") if line], float)
        assert len(pairs) == 34
        for one, two in ((pairs[:, :3], pairs[:, 3:6]), (pairs[:, 3:6], pairs[:, :3])):
            np.testing.assert_array_equal(delta_e_2000(one, two).round(4), pairs[:, 6])

    def test_is_that_of_colour_science(self):
        random = np.random.default_rng(0)
        one = random.uniform((0, -120, -120), (100, 120, 120), (20_000, 3))
        two = one + random.normal(0, 1, one.shape) * random.choice([0.1, 5, 60], (20_000, 1))
        expected = colour_science().delta_E(one, two, method="CIE 2000")
        np.testing.assert_allclose(delta_e_2000(one, two), expected, atol=1e-10)

    def test_of_neutral_colours_and_far_ones(self):
        one = np.array([(50, 0, 0), (0, 0, 0), (50, 30, 0), (0, 1e60, -1e60)], float)
        two = np.array([(50, 0, 0), (100, 0, 0), (50, 0, 0), (1e60, 0, 0)], float)
        found = delta_e_2000(one, two)
        assert found[0] == 0
        assert abs(found[1] - 100) < 1e-12
        assert np.isfinite(found).all()

    def test_names_rows_that_do_not_fit(self):
        with pytest.raises(InvalidPointsError, match="1 rows"):
            delta_e_2000(np.zeros((1, 3)), np.zeros((2, 3)))
        with pytest.raises(InvalidPointsError, match="Row 0 of two"):
            delta_e_2000([(0, 0, 0)], [(0, np.nan, 0)])
