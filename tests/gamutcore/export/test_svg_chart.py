"""Charts in SVG, read with an XML parser, and their images, read with Pillow."""

import io
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from gamutcore.export.png import png
from gamutcore.export.svg_chart import Chart, plain_text, rich_text

SVG = "{http://www.w3.org/2000/svg}"


def tree(data):
    return ET.fromstring(data)  # noqa: S314  # our own


def texts(chart):
    return ["".join(each.itertext()) for each in tree(chart.svg()).iter(f"{SVG}text")]


class TestChart:
    def test_has_a_title_axes_and_round_numbers(self):
        found = texts(Chart((-60.0, 0.0), (80.0, 100.0), ("a*", "b*"), "L* < 50", "a & b"))
        assert {"L* < 50", "a & b", "a*", "b*", "0", "−60", "80", "100"} <= set(found)

    def test_both_axes_have_the_same_scale_and_points_are_inside_the_frame(self):
        chart = Chart((-10.0, 5.0), (90.0, 25.0), ("x", "y"), "")
        points = chart.place(np.array([(0.0, 10.0), (10.0, 10.0), (0.0, 20.0)]))
        across, along = points[1] - points[0], points[2] - points[0]
        assert across[0] == pytest.approx(-along[1])
        assert across[1] == along[0] == 0
        frame = tree(chart.svg()).findall(f"{SVG}rect")[1]
        corner = np.array([float(frame.get("x")), float(frame.get("y"))])
        size = np.array([float(frame.get("width")), float(frame.get("height"))])
        for point in chart.place(np.array([(-10.0, 5.0), (90.0, 25.0)])):
            assert (point >= corner).all()
            assert (point <= corner + size).all()

    @pytest.mark.parametrize("size", [0.0, 1e-3, 0.7, 150.0, 1e6])
    def test_spans_of_any_size_have_a_few_numbers(self, size):
        numbers = texts(Chart((0.0, 0.0), (size, size), ("x", "y"), ""))
        assert 6 <= len(numbers) <= 30

    def test_a_path_closes_every_polygon(self):
        chart = Chart((0.0, 0.0), (1.0, 1.0), ("x", "y"), "")
        square = np.array([(0, 0), (1, 0), (1, 1)], np.float64)
        assert chart.path([square, square / 2]).count("Z") == 2
        chart.add_polygons([])
        chart.add_polygons([square], fill="none", stroke_width="2")
        assert b'stroke-width="2"' in chart.svg()


def test_a_png_has_its_pixels():
    pixels = np.random.default_rng(0).integers(0, 256, (5, 7, 3)).astype(np.uint8)
    with Image.open(io.BytesIO(png(pixels))) as image:
        np.testing.assert_array_equal(np.asarray(image), pixels)


def test_markup_is_escaped():
    assert rich_text("<b> & C*") == plain_text("<b> & C*") == "&lt;b&gt; &amp; C*"


def test_characters_that_xml_does_not_allow_are_left_out():
    name = "Pa\x00p\x1be\ud800r\uffff 1\u202f000"
    assert plain_text(name) == "Paper 1\u202f000"
    chart = Chart((0.0, 0.0), (1.0, 1.0), ("x", "y"), name, name)
    assert "Paper 1\u202f000" in texts(chart)
