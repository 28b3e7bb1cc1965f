"""The class `Gamut`: its file, its arguments, its levels and its answers."""

import io
import json

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes
from PIL import ImageCms

import gamutcore
from gamutcore import Gamut, Options
from gamutcore.errors import (
    GamutError,
    HistoryFileError,
    InvalidPointsError,
    OptionError,
    TriangleCountError,
)
from gamutcore.gamut import read_description
from gamutcore.history import history_bytes


def bare(rows):
    text = "\n".join(",".join(map(repr, row)) for row in np.asarray(rows, float).tolist())
    return f"LAB_L,LAB_A,LAB_B\n{text}\n".encode()


OCTAHEDRON = [(90, 0, 0), (10, 0, 0), (50, 40, 0), (50, -40, 0), (50, 0, 40), (50, 0, -40)]


class Table:
    """The two methods of a pandas DataFrame that are used.

    pandas itself takes 60 MB and a second to import, for two methods that are stable since 1.0.
    """

    def __init__(self, names, rows):
        self.names, self.rows = names, np.asarray(rows, float)

    def to_numpy(self):
        return self.rows.astype(object)

    def to_csv(self, *, index):
        assert not index
        lines = [self.names, *self.rows.tolist()]
        return "".join(",".join(map(str, line)) + "\n" for line in lines)


def attempt(action):
    try:
        return action()
    except GamutError as error:
        return error


class TestFile:
    def test_round_trip(self, fogra39_gamut):
        read = Gamut.from_bytes(fogra39_gamut.to_bytes())
        assert read.description == fogra39_gamut.description
        assert (read.id, read.options) == (fogra39_gamut.id, fogra39_gamut.options)
        for triangles in (4, 100, 5001, read.history.triangles):
            assert read.history.level(triangles) == fogra39_gamut.history.level(triangles)
        assert read.to_bytes() == fogra39_gamut.to_bytes()

    @pytest.mark.parametrize(
        "description",
        [
            None,
            "",
            [],
            {},
            {"id": 5, "options": {}},
            {"id": "00"},
            *({"id": "00", "options": options} for options in (None, [], {"gamma": 7}, {"5": 7})),
            {"id": "00", "options": {}},
            *(
                {"id": "00", "options": {}, "levels": levels}
                for levels in (
                    [],
                    [{}],
                    [5],
                    [{"triangles": "many"}],
                    [{"triangles": 4, "distance_bound": []}, {"triangles": 6}],
                )
            ),
        ],
    )
    def test_a_history_that_describes_no_gamut_is_refused(
        self, small_history, description, tmp_path
    ):
        data = history_bytes(small_history, description)
        with pytest.raises(HistoryFileError):
            Gamut.from_bytes(data)
        path = tmp_path / "gamut"
        path.write_bytes(data)
        with pytest.raises(HistoryFileError):
            read_description(path)

    @settings(max_examples=150)
    @given(place=st.floats(0, 1, exclude_max=True), flip=st.integers(1, 255))
    @pytest.mark.slow
    def test_a_changed_byte_of_the_header_is_refused(self, small_gamut, place, flip):
        data = bytearray(small_gamut.to_bytes())
        data[int(place * (8 + int.from_bytes(data[:4], "little")))] ^= flip
        assert isinstance(attempt(lambda: Gamut.from_bytes(bytes(data))), HistoryFileError)

    def test_save_and_load(self, small_gamut, tmp_path):
        small_gamut.save(tmp_path / "small.gamut")
        read = Gamut.load(tmp_path / "small.gamut")
        assert read.to_bytes() == small_gamut.to_bytes()
        assert json.dumps(read.description) == json.dumps(small_gamut.description)


class TestArguments:
    def test_a_path_and_no_options(self, tmp_path):
        file = tmp_path / "colours.csv"
        file.write_bytes(bare(OCTAHEDRON))
        expected = Gamut(bare(OCTAHEDRON))
        for data in (file, str(file), bytearray(bare(OCTAHEDRON))):
            assert Gamut(data).to_bytes() == expected.to_bytes()
        for gamut in (Gamut(file, {"Cost": "Quadric"}), Gamut(file, cost="Quadric")):
            assert gamut.options.cost == "quadric"
        assert Gamut(file, Options(gamma=0.3), cost="finest").options.gamma == 0.3

    @pytest.mark.parametrize(
        ("arguments", "remedy"),
        [
            ((np.zeros((8, 2)),), "n, 3"),
            ((np.array(["L"]),), "n, 3"),
            ((object(),), "mesh"),
            (("L,a,b\n1,2,3\n",), "encode"),
            ((None,), "path"),
            ((b"", "finest"), "Options"),
            ((b"", [("cost", "finest")]), "Options"),
        ],
    )
    def test_arguments_of_other_types_are_explained(self, arguments, remedy):
        with pytest.raises(TypeError, match=remedy):
            Gamut(*arguments)

    def test_every_form_of_the_same_colours(self):
        """An array is the file that numpy.save writes, and a table that of its columns."""
        file = io.BytesIO()
        np.save(file, np.array(OCTAHEDRON, float))
        for data in (np.array(OCTAHEDRON), OCTAHEDRON, np.reshape(OCTAHEDRON, (2, 3, 3))):
            assert Gamut(data).id == Gamut(file.getvalue()).id
        named = np.array([(*row,) for row in OCTAHEDRON], [(f"LAB_{axis}", "f8") for axis in "LAB"])
        assert Gamut(named).history.full() == Gamut(OCTAHEDRON).history.full()
        table = Gamut(Table(["LAB_L", "LAB_A", "LAB_B"], OCTAHEDRON))
        assert table.history.full() == Gamut(OCTAHEDRON).history.full()

    def test_a_mesh_of_any_kind(self, small_gamut):
        """A level is a gamut again, with the surface and the device values that it had."""
        level = small_gamut.level(30)
        for mesh in (level, trimesh.Trimesh(level.vertices, level.faces, process=False)):
            again = Gamut(mesh)
            assert again.volume == pytest.approx(level.volume, rel=1e-6)
            assert again.history.triangles == 30

    @pytest.mark.slow
    def test_a_profile_of_pillow(self, small_profile):
        data = small_profile("sRGB-v4.icc")
        opened = ImageCms.ImageCmsProfile(io.BytesIO(data))
        assert Gamut(opened, surface_samples=500).volume == pytest.approx(
            Gamut(data, surface_samples=500).volume, rel=0.01
        )


class TestMesh:
    def test_by_count_and_by_limit(self, small_gamut):
        assert small_gamut.mesh(31).triangles == 30
        whole = small_gamut.history.triangles
        assert small_gamut.mesh().triangles == min(1000, whole)
        assert small_gamut.mesh(max_error=0).triangles == whole
        limited = small_gamut.mesh(max_error=2.0)
        assert limited.max_error <= 2.0
        assert limited == small_gamut.level(limited.triangles)

    def test_on_one_side(self, small_gamut):
        inside, outside = (small_gamut.mesh(60, side=side) for side in ("inside", "outside"))
        assert inside.volume < small_gamut.volume < outside.volume

    def test_errors(self, small_gamut):
        with pytest.raises(OptionError, match="triangles"):
            small_gamut.mesh(40, max_error=1.0)
        with pytest.raises(OptionError, match="max_error"):
            small_gamut.mesh(max_error=-1.0)
        with pytest.raises(OptionError, match="side"):
            small_gamut.mesh(40, side="left")
        with pytest.raises(TriangleCountError):
            small_gamut.mesh(3)


class TestContains:
    def test_of_a_body_whose_inside_is_known(self):
        gamut = Gamut(OCTAHEDRON)
        colours = np.random.default_rng(5).uniform(-60, 110, (500, 3))
        expected = np.abs(colours - (50, 0, 0)).sum(axis=1) <= 40
        assert (gamut.contains(colours) == expected).all()
        assert gamut.contains(colours.reshape(5, 100, 3)).shape == (5, 100)
        assert gamut.contains((50, 0, 0)).shape == ()
        assert gamut.contains(Table("Lab", colours)).tolist() == expected.tolist()

    @given(array_shapes(min_dims=1, max_dims=4, max_side=4), st.sampled_from(["f4", "i2", ">f8"]))
    def test_answers_have_the_shape_of_the_colours(self, small_gamut, shape, kind):
        inside = np.arange(np.prod(shape)).reshape(shape) % 2 == 0
        colours = np.where(inside[..., np.newaxis], (50, 0, 0), (50, 300, 0)).astype(kind)
        np.testing.assert_array_equal(small_gamut.contains(colours), inside)

    def test_in_other_spaces(self):
        gamut = Gamut(OCTAHEDRON)
        assert gamut.contains([(50, 39, 0), (50, 39, 45)], space="lchab").tolist() == [True, False]
        assert gamut.contains([(0.5, 0.5, 0.5), (1, 0, 0)], space="sRGB").tolist() == [True, False]
        lab = np.array([(50, 10, 10), (50, 30, 30)], float)
        for space in ("Oklab", "CAM16-UCS", "CIE XYZ"):
            other = Gamut(OCTAHEDRON, space=space, gamma=1.0)
            assert other.contains(lab, space="CIE Lab").tolist() == [True, False]
            assert other.contains(other.colour_space.coordinates(lab)[0]).tolist() == [True, False]

    @pytest.mark.parametrize(
        ("colours", "row"),
        [
            ([(50, 0, 0), (50, np.nan, 0)], 1),
            (np.full((2, 2, 3), np.inf), 0),
            ([(1, 2)], None),
            ("abc", None),
            ([(1, 2, 3), (1, 2)], None),
        ],
    )
    def test_colours_that_are_none(self, small_gamut, colours, row):
        with pytest.raises(InvalidPointsError) as caught:
            small_gamut.contains(colours)
        assert caught.value.where.get("row") == row
        assert caught.value.remedy


def test_indexes_count_and_are_bounded(small_gamut):
    gamut = Gamut.from_bytes(small_gamut.to_bytes())
    gamut.contains((50, 0, 0), max_error=0)
    assert gamut.nbytes == gamut.history.nbytes + gamut.levels.nbytes
    one = gamut.levels.nbytes
    assert one > 0
    gamut.levels.capacity = one + 1
    for triangles in range(10, 40, 2):
        gamut.contains((50, 0, 0), triangles=triangles)
        assert 0 < gamut.levels.nbytes <= gamut.levels.capacity


def test_repr_is_one_line(small_gamut):
    text = repr(small_gamut)
    assert "\n" not in text
    assert "CIELAB" in text
    assert small_gamut.id[:12] in text


def test_public_names_are_imported_on_first_use():
    assert {"Gamut", "Options", "reference"} <= set(dir(gamutcore))
    with pytest.raises(AttributeError, match="gamuts"):
        _ = gamutcore.gamuts
