"""Pictures in notebooks, and drawings with matplotlib."""

import io
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from gamutcore import Gamut, reference
from gamutcore.colours.spaces import ColourSpace
from gamutcore.questions.plotting import face_colours, figure, plane_axes, svg_picture

CUBE = 20 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) + (50, 0, 0)
FEW = {"surface_samples": 1000}


def test_html_has_a_picture_and_the_key_figures(small_gamut):
    html = small_gamut._repr_html_()
    assert "<svg" in html
    for text in ("CIELAB", small_gamut.id[:12], f"{small_gamut.volume:.6g}"):
        assert text in html


def test_plot_shows_the_whole_gamut():
    axes = figure().add_subplot(projection="3d")
    assert Gamut(CUBE, gamma=1).plot(axes, alpha=0.5) is axes
    assert axes.get_zlabel() == "L*"
    low, high = axes.get_zlim()
    assert low <= 30
    assert high >= 70
    Gamut(CUBE + np.array([20, 0, 0]), gamma=1).plot(axes, triangles=8)
    assert axes.get_zlim()[1] >= 90


def test_without_matplotlib_the_extra_is_named(small_gamut, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(ModuleNotFoundError, match=r"\[plot\]"):
        small_gamut.plot()


def test_slices_and_rings():
    gamut, other = Gamut(CUBE, gamma=1), Gamut(CUBE / 2 + np.array([25, 0, 0]), gamma=1)
    axes = gamut.plot_slice(50, figure().add_subplot())
    other.plot_slice(50, axes)
    corners = [patch.get_xy() for patch in axes.patches]
    assert [np.abs(each).max() for each in corners] == pytest.approx([20, 10], abs=1e-3)
    assert axes.get_xlabel() == "a*"
    leaf = gamut.plot_slice(ax=figure().add_subplot(), hue=0)
    assert leaf.patches[0].get_xy().max(axis=0).tolist() == pytest.approx([20, 70], abs=1e-3)
    rings = gamut.plot_rings(other, figure().add_subplot(), sectors=12)
    legend = [text.get_text() for text in rings.get_legend().texts]
    assert legend == ["reference", "intersection"]
    radii = [np.hypot(*line.get_data()).max() for line in rings.lines]
    assert max(radii) == pytest.approx(gamut.rings(sectors=12).radius.max())


def test_plots_have_names_colours_and_dashes():
    """The section is filled with the colours that it shows; the second is dashed."""
    gamut, other = Gamut(CUBE, gamma=1), Gamut(CUBE / 2 + np.array([25, 0, 0]), gamma=1)
    gamut.name, other.name = "Large $1", "Small $2"
    axes = gamut.plot_slice(50, figure().add_subplot())
    (image,) = axes.images
    middle = image.get_array()[image.get_array().shape[0] // 2, image.get_array().shape[1] // 2]
    assert middle.tolist() == pytest.approx([119, 119, 119], abs=2)  # L* 50 in sRGB
    assert axes.get_title("left") == "L* = 50"
    assert axes.get_legend() is None
    other.plot_slice(50, axes)
    assert len(axes.images) == 1
    solid, dashed = axes.get_legend().get_lines()
    assert (solid.is_dashed(), dashed.is_dashed()) == (False, True)
    axes.figure.draw_without_rendering()  # a name is no formula
    assert axes.texts[0].get_text() == r"Large \$1, Small \$2 · CIELAB"
    assert axes.patches[1].get_linestyle() != axes.patches[0].get_linestyle()


def test_cleared_axes_begin_anew():
    gamut, other = Gamut(CUBE, gamma=1), Gamut(CUBE / 2 + np.array([25, 0, 0]), gamma=1)
    gamut.name, other.name = "Large", "Small"
    axes = gamut.plot_slice(50, figure().add_subplot())
    axes.clear()
    other.plot_slice(50, axes)
    assert axes.texts[0].get_text() == "Small · CIELAB"
    assert len(axes.images) == 1
    assert axes.get_legend() is None


def test_plots_in_a_part_of_a_figure():
    part, _ = figure().subfigures(1, 2)
    assert Gamut(CUBE, gamma=1).plot_slice(50, part.add_subplot()).patches


def test_conditions_of_several_rings_have_names():
    gamut, other = Gamut(CUBE, gamma=1), reference("srgb", surface_samples=1000)
    axes = gamut.plot_rings(ax=figure().add_subplot(), sectors=12)
    other.plot_rings(ax=axes, sectors=12)
    unnamed, named = axes.texts[-1].get_text().replace("\n", " ").split("sRGB: ")
    assert not unnamed.startswith(":")
    assert named


def test_a_gamut_has_the_name_of_its_file_or_reference(small_gamut, tmp_path):
    assert small_gamut.name == ""
    small_gamut.save(tmp_path / "Coated.gamut")
    assert Gamut.load(tmp_path / "Coated.gamut").name == "Coated"
    assert reference("display-p3", surface_samples=1000).name == "Display P3"
    assert Gamut("examples/FOGRA39L.ti3", surface_samples=1000).name == "FOGRA39L"


@pytest.mark.parametrize("normal", [(1, 0, 0), (-2, 0, 0), (0, 1, 0), (1, 1, 1), (0.5, 0, -3)])
def test_axes_of_a_plane_are_in_it_and_seen_from_its_tip(normal):
    normal = np.array(normal, np.float64)
    axes = plane_axes(normal, 12.0, ColourSpace("CIELAB"))
    assert normal @ axes.origin == pytest.approx(12)
    frame = np.array([axes.right, axes.up, normal / np.linalg.norm(normal)])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1)


def test_a_plane_has_its_equation_and_its_shape():
    """Across a* = 10, the cube of 40 is a square of 40 that is as high as it is wide."""
    axes = Gamut(CUBE, gamma=1).plot_slice(ax=figure().add_subplot(), plane=(0, 1, 0, 10))
    assert axes.get_title("left") == "a* = 10"
    assert np.ptp(axes.patches[0].get_xy(), axis=0) == pytest.approx([40, 40], abs=1e-3)
    beside = Gamut(CUBE, gamma=1).plot_slice(ax=figure().add_subplot(), plane=(0, 1, 0, 50))
    assert beside.texts[0].get_text().endswith("CIELAB · empty")
    assert not beside.images
    assert not beside.patches


def test_a_slice_has_the_colours_of_its_hues():
    axes = Gamut(CUBE, gamma=1).plot_slice(50, figure().add_subplot())
    pixels = axes.images[0].get_array().astype(int)
    rows, columns, _ = pixels.shape
    right, left = pixels[rows // 2, -1], pixels[rows // 2, 0]
    assert right[0] > right[1] + 30  # +a* is red
    assert left[1] > left[0] + 30  # −a* is green
    assert pixels[0, columns // 2][2] < pixels[-1, columns // 2][2] - 30  # −b* is blue


class TestRings:
    def bands(self, space="CIELAB"):
        """Return the colours of bands by ring and sector of 5°."""
        gamut = Gamut(CUBE, gamma=1) if space == "CIELAB" else reference("srgb", **FEW, space=space)
        (bands,) = gamut.plot_rings(ax=figure().add_subplot(), sectors=72).collections
        return bands.get_facecolors()[:, :3].reshape(10, 72, 3)

    def test_bands_have_the_colours_of_their_hues(self):
        bands = self.bands()
        assert bands[4, 5, 0] > bands[4, 5, 1] + 0.15  # red at about 30°
        assert (np.diff(bands.mean(axis=(1, 2))) > 0).all()  # lighter outwards

    def test_bands_of_another_space_have_the_colours_of_its_hues(self):
        """Red is at about 113° in ICtCp, where CIELAB has a yellowish green."""
        for space, is_red in (("ICtCp", True), ("CIELAB", False)):
            red, green, blue = self.bands(space)[4, 113 // 5]
            assert (red > green + 0.15 and red > blue + 0.15) == is_red

    @pytest.mark.parametrize("sectors", [1, 4, 100])
    def test_rings_of_few_or_many_sectors_are_arcs(self, sectors):
        gamut = Gamut(CUBE, gamma=1)
        found = gamut.rings(sectors=sectors)
        axes = gamut.plot_rings(ax=figure().add_subplot(), sectors=sectors)
        outer = max(axes.lines, key=lambda line: np.ptp(line.get_xdata()))
        radii = np.hypot(*outer.get_data())
        assert len(radii) > 72
        shown = np.unique(radii.round(6))
        np.testing.assert_allclose(shown, np.unique(found.radius[-1].round(6)), rtol=1e-5)


def test_a_name_of_any_characters_gives_a_file_that_opens():
    """XML has no control characters, and matplotlib writes each text as a comment."""
    gamut = Gamut(CUBE, gamma=1)
    gamut.name = "Pa\x00p\x1be\ud800r <A> & -- $1"
    file = io.BytesIO()
    gamut.plot_slice(50, figure().add_subplot()).figure.savefig(file, format="svg")
    assert ET.fromstring(file.getvalue()).tag.endswith("svg")  # noqa: S314  # our own


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
