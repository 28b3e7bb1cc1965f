"""The camera, the axes and what is in the picture."""

import numpy as np
import pytest

from gamutcore.colours.spaces import CIELAB, SPACES, ColourSpace
from gamutcore.export.rendering.scene import VIEWS, camera, scene_triangles
from gamutcore.export.rendering.strokes import GLYPHS
from gamutcore.mesh import TriangleMesh


@pytest.mark.parametrize("view", [*VIEWS.values(), (12.5, -70.0)])
def test_directions_are_right_handed(view):
    directions = camera(*view)
    np.testing.assert_allclose(directions @ directions.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(directions) == pytest.approx(1)


def test_views_are_what_their_names_say():
    a, b, lightness = np.eye(3)
    for name, right, up in (
        ("front", a, lightness),
        ("right", b, lightness),
        ("back", -a, lightness),
        ("left", -b, lightness),
        ("top", a, b),
        ("bottom", a, -b),
    ):
        np.testing.assert_allclose(camera(*VIEWS[name])[:2], [right, up], atol=1e-12)
    assert camera(*VIEWS["standard"])[1, 2] > 0.9  # lightness upwards


def octahedron(space, size):
    """Around a grey of the space, elongated along the axis of lightness."""
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    steps = np.concatenate([[side * row for side in (1, -1)] for row in np.eye(3)])
    steps[:, space.definition.lightness] *= 1.5
    centre = np.zeros(3)
    centre[space.definition.lightness] = 2 * size
    return TriangleMesh(centre + size * steps, np.array(faces))


@pytest.mark.parametrize("axes", [True, False])
@pytest.mark.parametrize("view", [*VIEWS, "other"])
@pytest.mark.parametrize("name", SPACES)
def test_everything_is_in_the_picture(name, view, axes):
    space = ColourSpace(name)
    mesh = octahedron(space, 0.1)
    directions = camera(*VIEWS.get(view, (33.0, 44.0)))
    corners, colours = scene_triangles(mesh, space, directions, 200, axes=axes)
    assert len(corners) == len(colours)
    assert (len(corners) > len(mesh.faces)) == axes
    assert corners[..., :2].min() >= 0
    assert corners[..., :2].max() <= 200
    assert colours.min() >= 0
    assert colours.max() <= 1


def test_directions_of_axes_in_the_picture():
    mesh = octahedron(CIELAB, 20.0)
    seen = scene_triangles(mesh, CIELAB, camera(*VIEWS["front"]), 100, axes=False).corners
    by_vertex = dict(zip(mesh.faces.ravel().tolist(), seen.reshape(-1, 3), strict=True))
    assert by_vertex[2][0] > by_vertex[3][0]  # +a* is to the right of −a*
    assert by_vertex[0][1] < by_vertex[1][1]  # lighter is higher up
    assert by_vertex[5][2] > by_vertex[4][2]  # −b* is nearer


def test_all_names_of_axes_and_numbers_have_glyphs():
    names = "".join("".join(definition.axes) for definition in SPACES.values())
    assert set(names) | set("0123456789.-+") <= set(GLYPHS)
