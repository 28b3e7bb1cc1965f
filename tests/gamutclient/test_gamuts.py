"""One suite for gamuts here and on the service: the client has the methods of `gamutcore.Gamut`."""

import asyncio
import inspect
import json
import re
from pathlib import Path

import gamutclient
import numpy as np
import pytest
import trimesh
from gamutclient.gamuts import SPACE_OPTIONS
from PIL import Image

import gamutcore
from gamutcore.colours import SPACE_PARAMETERS

EXAMPLE = Path(__file__).parents[2] / "examples" / "FOGRA39L.ti3"
COLOURS = np.random.default_rng(7).uniform((0, -90, -90), (100, 90, 90), (4, 60, 3))
LEVEL = {"triangles": 500}


@pytest.mark.slow
class TestBoth:
    def test_short_questions_are_forms_of_others(self, press, srgb):
        inside, distance = press.contains(COLOURS, **LEVEL), press.distance(COLOURS, **LEVEL)
        assert (inside == (distance <= 0)).all()
        found = press.classify(COLOURS, tolerance=5, **LEVEL)
        assert ((found == "edge") == (np.abs(distance) <= 5)).all()
        leaf, section = press.leaf(40, **LEVEL), press.slice(hue=40, **LEVEL)
        np.testing.assert_allclose(leaf.points, section.points, rtol=0, atol=1e-9)
        cusps = press.cusps(12, **LEVEL)
        chroma = press.max_chroma(cusps.lightness, cusps.hue, **LEVEL)
        np.testing.assert_allclose(chroma, cusps.chroma, atol=1e-6)
        assert 0.3 < press.coverage_of(srgb) < 0.6
        assert press.coverage_of(srgb) == pytest.approx((press & srgb).of_second)
        assert (press & "srgb").of_second == pytest.approx(press.coverage_of(srgb), abs=0.01)

    def test_answers_state_the_conditions(self, press, srgb):
        near, cusps = press.nearest((50, 90, 0)), press.cusps(4)
        for stated in (near.gamut, cusps.gamut, press.compare(srgb).gamuts[0]):
            assert (stated.intent, stated.ink_limit, stated.white) == ("relative", 300, "D50")
            assert (stated.space, stated.black_limit) == ("CIELAB", None)
        assert '(--intent absolute, or "intent": "absolute")' in near.warnings[0]
        assert press.nearest((1, 0, 0), space="sRGB").warnings == cusps.warnings == ()
        assert press.rings(srgb, sectors=4).reference_gamut.intent == "relative"

    def test_pictures(self, press):
        assert press.picture(64, (30, 20), axes=False).startswith(b"\x89PNG")

    def test_meshes(self, press, tmp_path):
        mesh = press.mesh(200)
        assert mesh.triangles == 200
        assert mesh.volume == pytest.approx(press.volume, rel=1e-3)
        assert press.mesh(max_error=1.0).max_error <= 1.0
        assert press.mesh(200, side="inside").volume < mesh.volume
        mesh.save(tmp_path / "press.glb")
        read = trimesh.load(tmp_path / "press.glb", force="mesh", process=False)
        assert len(read.faces) == 200
        assert mesh.to_trimesh().is_watertight

    def test_files_are_read_by_gamutcore(self, press, tmp_path):
        press.save(tmp_path / "press.gamut")
        assert gamutcore.Gamut.load(tmp_path / "press.gamut").id == press.id

    def test_errors_have_codes(self, press):
        with pytest.raises(Exception, match="method") as caught:
            press.map(COLOURS, "clip-hoe")
        assert caught.value.code in {"invalid-option", "invalid-parameter"}
        with pytest.raises(Exception, match="Row 1") as caught:
            press.contains([(50, 0, 0), (50, np.nan, 0)])
        assert caught.value.code == "invalid-points"
        assert caught.value.where["row"] == 1

    @pytest.mark.parametrize(
        "colours",
        [np.zeros((5, 4)), 3.0, "red", [["a", "b", "c"]], [], np.zeros((1, 3), complex)],
        ids=str,
    )
    def test_what_is_no_array_of_colours(self, press, colours):
        for ask in (press.contains, press.nearest, lambda rows: press.crossings(rows, (50, 0, 0))):
            with pytest.raises(Exception, match=r"\(\.\.\., 3\)|shape|rows") as caught:
                ask(colours)
            assert caught.value.code == "invalid-points"

    def test_pages_are_saved_by_their_suffix(self, press, tmp_path):
        press.save(tmp_path / "press.html")
        assert (tmp_path / "press.html").read_bytes().startswith(b"<!doctype html>")


class Frame(dict):
    """What is used of a data frame: its columns, a column by its name, and the rows."""

    columns = property(list)

    def __len__(self):
        return len(next(iter(self.values())))


@pytest.mark.slow
class TestTables:
    def test_the_names_of_the_columns_of_a_data_frame_count(self, press):
        """Columns in another order, others beside them, and codes from 0 to 255."""
        points = np.array([(50.0, 40.0, 30.0), (20.0, -90.0, 30.125), (60.0, 10.0, 200.0)])
        lightness, a, b = points.T
        names = ["Warm, grey", 'x;"y"', "z"]
        frame = Frame(name=names, B=b, L=lightness, A=a)
        assert press.contains(frame, **LEVEL).tolist() == press.contains(points, **LEVEL).tolist()
        near = press.nearest(frame, **LEVEL)
        np.testing.assert_allclose(near.points, press.nearest(points, **LEVEL).points, atol=1e-9)
        np.testing.assert_allclose(press.distance(frame), press.distance(points), atol=1e-9)
        assert press.classify(frame).shape == (3,)
        codes = Frame(G=[0, 255], B=[0, 255], R=[255, 0])
        mapped = press.map(codes, **LEVEL)
        expected = press.map([(1, 0, 0), (0, 1, 1)], space="sRGB", **LEVEL)
        np.testing.assert_allclose(mapped.points, expected.points, atol=1e-9)
        assert mapped.points.max() < 2

    def test_faulty_data_frames_are_refused(self, press):
        for frame, told in (
            (Frame(L=[50, 120], a=[0, 0], b=[0, 0]), "120"),
            (Frame(L=[50, np.nan], a=[0, 0], b=[0, 0]), "nan"),
            (Frame(L=["50", ""], a=["0", ""], b=["0", ""]), "rows|not numbers"),
            (Frame(C=[1], M=[2], Y=[3], K=[4]), "ink"),
        ):
            with pytest.raises(Exception, match=told) as caught:
                press.contains(frame)
            assert caught.value.code in {"invalid-points", "missing-column", "invalid-body"}

    def test_the_client_takes_files_of_colours(self, client, tmp_path):
        """A row without a colour has no answer."""
        press = client.build(EXAMPLE, surface_samples=1000, ink_limit=300)
        content = b"name;h;C;L\r\nRed;40,5;60;50\r\n;;;\r\nGrey;0;0;50\r\n"
        path = tmp_path / "spots.csv"
        path.write_bytes(content)
        for colours in (path, content):
            assert (
                press.contains(colours).tolist()
                == press.contains([(50, 60, 40.5), (50, 0, 0)], space="LCHab").tolist()
            )
        assert press.nearest(path).points.shape == (2, 3)


CENTRE = (50, 0, 0)
POLAR = [(60, 40, 30), (20, 90, 300)]

QUESTIONS = {
    "contains": lambda gamut, _: gamut.contains(COLOURS),
    "contains one colour": lambda gamut, _: gamut.contains(CENTRE),
    "contains of none": lambda gamut, _: gamut.contains(np.empty((0, 3))),
    "tolerance": lambda gamut, _: gamut.tolerance(**LEVEL),
    "warnings": lambda gamut, other: gamut.warnings_about(other),
    "distance": lambda gamut, _: gamut.distance(COLOURS, **LEVEL),
    "distance in another space": lambda gamut, _: gamut.distance(POLAR, space="LCHab", **LEVEL),
    "classify": lambda gamut, _: gamut.classify(COLOURS, tolerance=5, **LEVEL),
    "nearest": lambda gamut, _: gamut.nearest(COLOURS),
    "nearest by CIEDE2000": lambda gamut, _: gamut.nearest(COLOURS[0], metric="CIE 2000", **LEVEL),
    "map": lambda gamut, _: gamut.map(COLOURS),
    "map by clipping": lambda gamut, _: gamut.map(COLOURS, "clip-hue", **LEVEL),
    "map from a source": lambda gamut, other: gamut.map(COLOURS, "sgck", source=other, **LEVEL),
    "map to a focus": lambda gamut, _: gamut.map(COLOURS, "clip-focal", focus=CENTRE, **LEVEL),
    "map with black": lambda gamut, _: gamut.map(COLOURS, black_point_compensation=True, **LEVEL),
    "to_device": lambda gamut, _: gamut.to_device(COLOURS),
    "to_device by a rule": lambda gamut, _: gamut.to_device(CENTRE, black="maximum", **LEVEL),
    "crossings": lambda gamut, _: gamut.crossings(COLOURS, CENTRE),
    "crossings of lines": lambda gamut, _: gamut.crossings(COLOURS, CENTRE, kind="line", **LEVEL),
    "crossings of none": lambda gamut, _: gamut.crossings(np.empty((0, 3)), CENTRE),
    "cusps": lambda gamut, _: gamut.cusps(90),
    "max_chroma": lambda gamut, _: gamut.max_chroma([20, 50, 200], [0, 90, 0], **LEVEL),
    "slice": lambda gamut, _: gamut.slice(50),
    "slice by a plane": lambda gamut, _: gamut.slice(plane=(1, 0, 0, 50), **LEVEL),
    "slice by a hue": lambda gamut, _: gamut.slice(hue=40, **LEVEL),
    "slice of nothing": lambda gamut, _: gamut.slice(500, **LEVEL),
    "leaf": lambda gamut, _: gamut.leaf(40, **LEVEL),
    "leaves": lambda gamut, _: gamut.leaves(12, 11),
    "rings": lambda gamut, other: gamut.rings(other, sectors=90, **LEVEL),
    "rings alone": lambda gamut, _: gamut.rings(),
    "compare": lambda gamut, other: gamut.compare(other),
    "compare sectors": lambda gamut, other: gamut.compare(other, sectors=12, **LEVEL),
    "compare lost": lambda gamut, other: gamut.compare(other, sectors=12, lost=True),
    "and": lambda gamut, other: gamut & other,
    "coverage": lambda gamut, other: gamut.coverage_of(other),
    "mesh": lambda gamut, _: gamut.mesh(300),
}


NOT_SENT = {
    "load",
    # conditions beside those in header fields
    *("white_xyz", "viewing_conditions", "medium_white", "illuminant", "observer"),
    *("build_warnings", "is_print", "inks"),
}
"""Fields of results that the service does not send."""


def assert_equal(here, there):
    """The same arrays and numbers; JSON has all digits, and error bounds have six in headers."""
    if type(here).__name__ == "DeviceValues":
        assert_equal(here.values, there)
    elif isinstance(here, np.ndarray) and here.dtype.kind == "f":
        assert there.shape == here.shape
        np.testing.assert_allclose(there, here, rtol=0, atol=1e-9, equal_nan=True)
    elif isinstance(here, np.ndarray | np.generic):
        assert there.shape == here.shape
        assert (there == here).all()
    elif isinstance(here, float):
        assert there == pytest.approx(here, rel=1e-5, nan_ok=True)
    elif isinstance(here, list | tuple):
        for one, other in zip(here, there, strict=True):
            assert_equal(one, other)
    elif type(here).__module__.startswith("gamutcore"):
        compared = {field for field in vars(there) if hasattr(here, field)} - NOT_SENT
        assert len(compared) >= 3
        for field in compared:
            assert_equal(getattr(here, field), getattr(there, field))
    elif here is not None:  # only the service always knows an error
        assert there == here


@pytest.mark.parametrize("name", QUESTIONS)
def test_answers_are_those_of_gamutcore(local, remote, name):
    assert_equal(QUESTIONS[name](*local), QUESTIONS[name](*remote))


def test_chromaticities_are_those_of_gamutcore(local, remote):
    for here, there in zip(local, remote, strict=True):
        one, other = here.chromaticity(), there.chromaticity()
        assert one.basis == other.basis
        np.testing.assert_array_equal(one.xy, other.xy)
        np.testing.assert_allclose(one.uv, other.uv)
    found = remote[0].compare(remote[1]).chromaticity
    assert found.basis_a == "colours"
    assert found.uv.area_ratio == pytest.approx(found.uv.area_a / found.uv.area_b)


def test_pictures_are_mapped_as_by_gamutcore(local, remote, tmp_path):
    given, here, there = (tmp_path / f"{name}.png" for name in ("given", "here", "there"))
    pixels = np.random.default_rng(4).integers(0, 256, (12, 10, 3), np.uint8)
    Image.fromarray(pixels).save(given)
    options = {"to": "display-p3", "max_error": 0.5}
    done = local[0].map_picture(given, here, **options)
    told = remote[0].map_picture(given, there, **options)
    np.testing.assert_array_equal(Image.open(here), Image.open(there))
    assert told["outside"] == done.outside
    assert told["delta_e"] == pytest.approx(done.delta_e, abs=1e-4)
    assert {*tmp_path.iterdir()} == {given, here, there}


def test_both_kinds_have_the_same_methods(remote):
    methods = {
        name
        for name, _ in inspect.getmembers(gamutcore.Gamut, inspect.isfunction)
        if not name.startswith(("_", "plot"))
    } - {"convert", "level", "to_html", "to_colour", "compare_with_interval"}  # docs/client.md
    methods -= {"no_device_model", "use_device_model"}  # of the service
    assert methods <= set(dir(remote[0]))
    assert methods <= set(dir(gamutclient.AsyncGamut))


def test_the_viewer_shows_the_gamuts_of_the_service(remote):
    """The page is that of `gamutcore`, with the names that the service knows."""
    press, srgb = remote
    for others in ((), (srgb,), (srgb.id, "display-p3")):
        shown = press.show(*others, state="theme=dark", height=400)
        assert shown.height == 400
        held, state = (
            json.loads(re.search(f'id="{part}">(.*?)</script>', shown.html.decode())[1])
            for part in ("gamut-file", "page-state")
        )
        assert state == {"address": "theme=dark"}
        ids = [each["gamut"]["id"] for each in held["gamuts"]]
        assert len(ids) == 1 + len(others)
        assert ids[:2] == [press.id, srgb.id][: len(ids)]


def test_references_are_shown_in_the_space_of_the_gamut(server):
    with gamutclient.Client(server.url) as client:
        corners = np.random.default_rng(5).uniform((0.2, -0.1, -0.1), (0.8, 0.1, 0.1), (40, 3))
        gamut = client.build(corners, space="Oklab", reference_white="D50")
        page = gamut.show("srgb").html.decode()
        held = json.loads(re.search('id="gamut-file">(.*?)</script>', page)[1])["gamuts"]
        assert [each["gamut"]["options"]["space"] for each in held] == ["Oklab", "Oklab"]
        assert [each["gamut"]["options"]["reference_white"] for each in held] == ["D50"] * 2
        assert {*SPACE_OPTIONS} == {"space", *SPACE_PARAMETERS}


def test_coroutines_give_the_same(server, local, remote, tmp_path):
    async def ask():
        async with gamutclient.AsyncClient(server.url) as client:
            press, srgb = await asyncio.gather(
                client.gamut(remote[0].id), client.reference("sRGB", surface_samples=1000)
            )
            await press.save(tmp_path / "press.HTML")
            return await asyncio.gather(
                press.contains(COLOURS),
                press.nearest(COLOURS),
                press.coverage_of(srgb),
                press.mesh(100),
                press.mesh_file("glb", 100),
                press.max_chroma(50, [0, 90]),
                press.show(srgb),
            )

    inside, nearest, coverage, mesh, file, chroma, shown = asyncio.run(ask())
    press, srgb = local
    assert (inside == press.contains(COLOURS)).all()
    np.testing.assert_allclose(nearest.points, press.nearest(COLOURS).points, atol=1e-9)
    assert coverage == pytest.approx(press.coverage_of(srgb))
    np.testing.assert_array_equal(mesh.vertices, press.mesh(100).vertices)
    assert file.startswith(b"glTF")
    assert (tmp_path / "press.HTML").read_bytes().startswith(b"<!doctype html>")
    np.testing.assert_allclose(chroma, press.max_chroma(50, [0, 90]))
    assert shown.html == remote[0].show(remote[1]).html
    with pytest.raises(TypeError, match="mesh_file"):
        mesh.to_bytes("glb")
