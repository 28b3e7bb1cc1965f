"""The picture of a gamut: SVG that fits, with the colours of the faces, from the right side."""

import re
import xml.etree.ElementTree as ET

import numpy as np

from gamutcore import Gamut
from gamutcore.answers.picture import face_colours, svg_picture, upright

CUBE = 20 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) + (50, 0, 0)


def test_the_visible_faces_of_a_cube_are_three_squares():
    """Seen from above and outside: the lightest vertex is in the picture, the darkest is not."""
    gamut = Gamut(CUBE, gamma=1)
    mesh, space = gamut.level(12), gamut.colour_space
    picture = ET.fromstring(svg_picture(mesh, space, 100))  # noqa: S314  # our own
    shapes = [shape for shape in picture.iter() if shape.tag.endswith("polygon")]
    assert len(shapes) == 6
    numbers = [float(n) for shape in shapes for n in re.split("[ ,]", shape.get("points"))]
    assert min(numbers) >= 0
    assert max(numbers) <= 100
    fills = {shape.get("fill") for shape in shapes}
    colours = np.rint(255 * face_colours(mesh, space)).astype(int)
    light = colours[np.argmax(mesh.vertices[mesh.faces][:, :, 0].mean(axis=1))]
    assert "#{:02x}{:02x}{:02x}".format(*light) in fills


def test_lightness_is_upright(small_gamut):
    xyz = Gamut(CUBE, gamma=1, space="CIEXYZ").colour_space
    assert upright(np.array([[1, 2, 3]]), xyz).tolist() == [[1, 3, 2]]
    assert upright(np.array([[1, 2, 3]]), small_gamut.colour_space).tolist() == [[2, 3, 1]]
