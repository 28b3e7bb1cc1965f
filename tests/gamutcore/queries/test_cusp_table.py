"""The table of cusps: its edges and its sectors. `test_cusps` compares the answers."""

import numpy as np

from gamutcore.queries import build_index
from gamutcore.queries.cusp_table import hue_sector


def test_only_edges_of_the_silhouette_are_listed(rough):
    table = build_index(*rough(4, 3000, 0.0)).cusps
    assert 20 < len(table.corners) < 200


def test_sectors_are_in_the_order_of_hues():
    angle = np.linspace(-np.pi / 2, 1.5 * np.pi, 1000, endpoint=False)
    sectors = [hue_sector(np.cos(each), np.sin(each), 12) for each in angle]
    assert sectors == sorted(sectors)
    assert np.bincount(sectors).min() > 60
