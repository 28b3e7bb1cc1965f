"""The table of hues: every section of a face is in a rectangle of its sector, and in its span."""

import numpy as np
import pytest

from gamutcore.queries import build_index
from gamutcore.queries.cusp_table import hue_sector, hue_turn
from gamutcore.queries.face_tree import WIDTH
from gamutcore.queries.hue_table import hue_part


def sides_of(table, node):
    """Return smallest and largest lightness and chroma of the children, (2, 2, 8)."""
    return table.rectangles[node].reshape(2, 2, WIDTH).astype(float)


def leaves_of(table, node):
    """Return face, span and rectangle of all leaves below a node."""
    first, sides = table.first[node], sides_of(table, node)
    found = []
    for at in np.flatnonzero(np.isfinite(sides[0, 0])):
        if first < 0:
            place = ~first + at
            found.append((int(table.faces[place]), table.spans[place], sides[:, :, at]))
        else:
            below = leaves_of(table, first + at)
            assert all((sides[0, :, at] <= each[2][0]).all() for each in below)
            assert all((sides[1, :, at] >= each[2][1]).all() for each in below)
            found += below
    return found


def check(index, hue):
    """Check the leaves of a hue's sector with all segments of its half-plane."""
    table, scale = index.hues, index.tree.scale
    ca, cb = float(np.cos(hue)), float(np.sin(hue))
    sectors = len(table.roots)
    sector = hue_sector(ca, cb, sectors)
    part = hue_part(0.25 * sectors * hue_turn(ca, cb) - sector)
    root = table.roots[sector]
    found = {face: rest for face, *rest in leaves_of(table, root)} if root >= 0 else {}
    crossed = 0
    for face, corners in enumerate(index.vertices[index.faces]):
        heights = corners[:, 1:] @ (-cb, ca)
        for one, two in ((0, 1), (1, 2), (2, 0)):
            if heights[one] * heights[two] < 0:
                share = heights[one] / (heights[one] - heights[two])
                point = corners[one] + share * (corners[two] - corners[one])
                chroma = point[1:] @ (ca, cb)
                if chroma >= 0:
                    span, sides = found[face]
                    assert span[0] <= part <= span[1]
                    place = scale * np.array([point[0] - index.centre[0], chroma])
                    assert (sides[0] <= place).all()
                    assert (sides[1] >= place).all()
                    crossed += 1
    return crossed


class TestHueTable:
    @pytest.mark.parametrize("count", [8, 60, 400])
    @pytest.mark.parametrize("shift", [0.0, 60.0])
    def test_every_section_is_in_its_sector(self, rough, count, shift):
        """Also where the neutral axis is outside."""
        vertices, faces, centre = rough(count, count, 0.4)
        moved = np.array([0.0, shift, -shift])
        index = build_index(vertices + moved, faces, centre + moved)
        random = np.random.default_rng(count)
        hues = [*random.uniform(-np.pi, np.pi, 30), -np.pi / 4]
        assert sum(check(index, float(hue)) for hue in hues) > 4

    def test_corners_on_the_axis_and_edges_between_sectors(self, cube):
        vertices, faces, centre = cube
        for moved in ((0, 0, 0), (0, -1, -1), (0, 1, 0)):
            index = build_index(vertices + np.array(moved, np.float32), faces, centre + moved)
            for turn in np.linspace(0, 2 * np.pi, 25):
                for hue in (turn, np.nextafter(turn, 9), np.nextafter(turn, -9)):
                    check(index, float(hue))

    def test_memory_is_that_of_the_arrays(self, rough):
        index = build_index(*rough(3, 60))
        assert index.hues.nbytes == sum(array.nbytes for array in index.hues)
