"""Charts in SVG: what is in them, at which place, in which colour."""

import base64
import io
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.export import leaf_axes, lightness_axes, plane_axes, rings_svg, section_svg
from gamutcore.export.charts import Chart, plain_text

SVG = "{http://www.w3.org/2000/svg}"


def tree(data):
    return ET.fromstring(data)  # noqa: S314  # our own


def texts(data):
    return ["".join(each.itertext()) for each in tree(data).iter(f"{SVG}text")]


def test_characters_that_xml_does_not_allow_are_left_out():
    name = "Pa\x00p\x1be\ud800r\uffff 1\u202f000"
    assert plain_text(name) == "Paper 1\u202f000"
    chart = Chart((0.0, 0.0), (1.0, 1.0), ("x", "y"), name, name)
    assert "Paper 1\u202f000" in texts(chart.svg())


SQUARE = np.array([(50, -40, -40), (50, 40, -40), (50, 40, 40), (50, -40, 40)], np.float64)


def image(data):
    found = tree(data).find(f"{SVG}image").get("href")
    prefix, _, body = found.partition(",")
    assert prefix == "data:image/png;base64"
    with Image.open(io.BytesIO(base64.b64decode(body))) as picture:
        return np.asarray(picture).astype(int)


class TestSectionSvg:
    def test_a_slice_shows_its_colours(self):
        pixels = image(section_svg([SQUARE], lightness_axes(50)))
        rows, columns, _ = pixels.shape
        assert rows == columns
        # L* 50 without chroma is sRGB 119, 119, 119
        assert abs(pixels[rows // 2, columns // 2] - 119).max() <= 2
        right, left = pixels[rows // 2, -1], pixels[rows // 2, 0]
        assert right[0] > right[1] + 50  # +a* is red
        assert left[1] > left[0] + 50  # −a* is green
        assert pixels[0, columns // 2][2] < pixels[-1, columns // 2][2] - 50  # −b* is blue

    def test_names_and_axes(self):
        found = texts(section_svg([SQUARE], lightness_axes(50), name="Paper <A> & B"))
        assert {"L* = 50", "Paper <A> & B · CIELAB", "a*", "b*"} <= set(found)
        leaf = np.array([(20, 0, 0), (50, 0, 60), (90, 0, 0)], np.float64)
        assert {"Hue 90°", "C*", "L*"} <= set(texts(section_svg([leaf], leaf_axes(90))))
        oklab = ColourSpace("Oklab")
        assert {"Chroma", "L"} <= set(texts(section_svg([leaf / 100], leaf_axes(90, oklab), oklab)))

    def test_holes_are_not_filled(self):
        data = section_svg([SQUARE, SQUARE * (1, 0.5, 0.5)], lightness_axes(50))
        clip = tree(data).find(f"{SVG}defs/{SVG}clipPath/{SVG}path")
        assert clip.get("clip-rule") == "evenodd"
        assert clip.get("d").count("M") == 2

    @pytest.mark.parametrize("normal", [(1, 0, 0), (-2, 0, 0), (0, 1, 0), (1, 1, 1), (0.5, 0, -3)])
    def test_axes_of_a_plane_are_in_it_and_seen_from_its_tip(self, normal):
        normal = np.array(normal, np.float64)
        axes = plane_axes(normal, 12.0)
        assert normal @ axes.origin == pytest.approx(12)
        frame = np.array([axes.right, axes.up, normal / np.linalg.norm(normal)])
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1)
        data = section_svg([], axes, name="Paper")
        assert "Paper · CIELAB · empty" in texts(data)
        assert tree(data).find(f"{SVG}image") is None


class TestRingsSvg:
    def rings(self, **more):
        lightness, hues = np.arange(10.0, 101, 10), np.arange(360) + 0.5
        radius = np.sqrt(lightness)[:, np.newaxis] * np.full(360, 40.0)
        return rings_svg(lightness, hues, radius, **more)

    def test_has_rings_labels_and_a_volume(self):
        data = self.rings(names=("Paper", "sRGB"), volume=502_654.8)
        found = texts(data)
        assert {"Gamut rings", "L* 10", "L* 50", "L* 100", "a*RSS", "b*RSS"} <= set(found)
        assert any(re.fullmatch(r"Paper · volume 502.655", each) for each in found)
        outlines = [
            each for each in tree(data).findall(f"{SVG}path") if each.get("stroke") == "#222"
        ]
        assert len(outlines) == 10

    def test_bands_have_the_colours_of_their_hues(self):
        group = tree(self.rings()).find(f"{SVG}g")
        fills = [each.get("fill") for each in group]
        assert len(fills) == 10 * 72
        colours = np.array([[int(fill[at : at + 2], 16) for at in (1, 3, 5)] for fill in fills])
        bands = colours.reshape(10, 72, 3)
        assert bands[4, 5, 0] > bands[4, 5, 1] + 40  # red at about 30°
        assert (np.diff(bands.mean(axis=(1, 2))) > 0).all()  # lighter outwards

    def test_bands_of_another_space_have_the_colours_of_its_hues(self):
        """Red is at about 113° in ICtCp, where CIELAB has a yellowish green."""
        for space, is_red in ((ColourSpace("ICtCp"), True), (CIELAB, False)):
            group = tree(self.rings(space=space)).find(f"{SVG}g")
            fill = group[4 * 72 + 113 // 5].get("fill")
            red, green, blue = (int(fill[at : at + 2], 16) for at in (1, 3, 5))
            assert (red > green + 40 and red > blue + 40) == is_red

    @pytest.mark.parametrize("sectors", [1, 2, 4, 100, 720])
    def test_one_ring_of_few_or_many_sectors_is_round(self, sectors):
        hues = (np.arange(sectors) + 0.5) * 360 / sectors
        data = rings_svg(np.array([100.0]), hues, np.full((1, sectors), 9.0))
        assert "L* 100" in texts(data)
        (outline,) = [
            each for each in tree(data).findall(f"{SVG}path") if each.get("stroke") == "#222"
        ]
        corners = np.array(
            [each.split(",") for each in outline.get("d")[1:-1].split(" ")], np.float64
        )
        radii = np.linalg.norm(corners - corners.mean(axis=0), axis=1)
        np.testing.assert_allclose(radii, radii[0], rtol=1e-3)
