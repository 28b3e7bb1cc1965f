"""One suite for gamuts here and on the service: the client has the methods of `gamutcore.Gamut`."""

import asyncio
import inspect

import gamutclient
import numpy as np
import pytest
import trimesh

import gamutcore

COLOURS = np.random.default_rng(7).uniform((0, -90, -90), (100, 90, 90), (4, 60, 3))
LEVEL = {"triangles": 500}


def hue(points):
    return np.arctan2(points[..., 2], points[..., 1])


@pytest.mark.slow
class TestBoth:
    def test_shapes_follow_the_colours(self, press):
        assert press.contains((50, 0, 0)).shape == ()
        assert bool(press.contains((50, 0, 0)))
        assert press.contains(COLOURS).shape == (4, 60)
        assert press.nearest(COLOURS).points.shape == (4, 60, 3)
        assert press.contains(np.empty((0, 3))).shape == (0,)

    def test_the_distance_is_negative_inside(self, press):
        inside, distance = press.contains(COLOURS, **LEVEL), press.distance(COLOURS, **LEVEL)
        assert (inside == (distance <= 0)).all()
        assert inside.any()
        assert not inside.all()

    def test_classes_follow_the_distance(self, press):
        found = press.classify(COLOURS, tolerance=5, **LEVEL)
        distance = press.distance(COLOURS, **LEVEL)
        assert ((found == "edge") == (np.abs(distance) <= 5)).all()
        assert ((found == "outside") == (distance > 5)).all()

    @pytest.mark.parametrize("metric", ["CIE 1976", "CIE 2000"])
    def test_nearest_colours_are_on_the_surface(self, press, metric):
        found = press.nearest(COLOURS[0], metric=metric, **LEVEL)
        assert np.abs(press.distance(found.points, **LEVEL)).max() < 1e-6
        moved = np.linalg.norm(found.points - COLOURS[0], axis=1)
        np.testing.assert_allclose(found.distance, moved, atol=1e-9)
        assert found.channels == ("C", "M", "Y", "K")
        assert found.device.shape == (60, 4)
        assert found.triangles == 500
        assert found.max_error is None or found.max_error > 0  # only the service always knows it

    def test_colours_of_another_space(self, press):
        polar = np.stack(
            [
                COLOURS[0, :, 0],
                np.hypot(*COLOURS[0, :, 1:].T),
                np.degrees(hue(COLOURS[0])) % 360,
            ],
            axis=1,
        )
        direct = press.distance(COLOURS[0], **LEVEL)
        np.testing.assert_allclose(press.distance(polar, space="LCHab", **LEVEL), direct, atol=1e-6)

    def test_clipping_keeps_the_hue(self, press):
        found = press.map(COLOURS, "clip-hue", **LEVEL)
        turned = np.angle(np.exp(1j * (hue(found.points) - hue(COLOURS))))
        chroma = np.hypot(found.points[..., 1], found.points[..., 2])
        assert np.abs(turned * chroma).max() < 1e-6
        assert (found.moved == ~press.contains(COLOURS, **LEVEL)).all()
        assert press.distance(found.points, **LEVEL).max() < 1e-6

    def test_mapping_from_a_source_or_to_a_focus(self, press, srgb):
        compressed = press.map(COLOURS, "sgck", source=srgb, **LEVEL)
        assert press.distance(compressed.points, **LEVEL).max() < 1e-6
        focal = press.map(COLOURS, "clip-focal", focus=(50, 0, 0), **LEVEL)
        ahead = np.einsum("...i,...i", focal.points - (50, 0, 0), COLOURS - (50, 0, 0))
        assert (ahead > 0).all()

    def test_crossings_alternate(self, press):
        found = press.crossings(COLOURS[0], (50, 0, 0), kind="line", **LEVEL)
        assert len(found.offsets) == 61
        assert found.offsets[-1] == len(found.t)
        for start, end in zip(found.offsets[:-1], found.offsets[1:], strict=True):
            assert (np.diff(found.t[start:end]) > 0).all()
            assert found.entering[start:end].tolist() == [True, False] * ((end - start) // 2)

    def test_cusps_have_the_largest_chroma(self, press):
        found = press.cusps(12, **LEVEL)
        assert found.hue.tolist() == list(range(0, 360, 30))
        chroma = press.max_chroma(found.lightness, found.hue, **LEVEL)
        np.testing.assert_allclose(chroma, found.chroma, atol=1e-6)
        assert np.isnan(press.max_chroma(200, 0))

    def test_sections_are_on_the_surface(self, press):
        for section in (press.slice(50, **LEVEL), press.slice(plane=(1, 0, 0, 50), **LEVEL)):
            (polygon,) = section.polygons
            np.testing.assert_allclose(polygon[:, 0], 50, atol=1e-9)
            assert np.abs(press.distance(polygon, **LEVEL)).max() < 1e-6
        leaf = press.leaf(40, **LEVEL)
        np.testing.assert_allclose(
            leaf.points, press.slice(hue=40, **LEVEL).points, rtol=0, atol=1e-9
        )
        assert press.slice(500, **LEVEL).polygons == []

    def test_leaves_are_the_largest_chroma(self, press):
        found = press.leaves(4, 11, **LEVEL)
        chroma = press.max_chroma(found.lightness, found.hue[:, np.newaxis], **LEVEL)
        np.testing.assert_allclose(found.largest, chroma, atol=1e-6)

    def test_rings_enclose_the_volume(self, press, srgb):
        found = press.rings(srgb, sectors=90, **LEVEL)
        area = np.pi * (found.radius[-1] ** 2).mean()
        assert area == pytest.approx(found.volume, rel=1e-6)
        assert found.reference_radius.shape == found.radius.shape == (len(found.lightness), 90)
        assert press.rings().reference_radius is None

    def test_comparison(self, press, srgb):
        found = press.compare(srgb, sectors=12, **LEVEL)
        assert found.a_covers_b == pytest.approx(found.intersection / found.volume_b)
        assert found.union == pytest.approx(found.volume_a + found.volume_b - found.intersection)
        assert found.sectors.intersection.sum() == pytest.approx(found.intersection)
        assert found.hues.tolist() == list(range(0, 361, 30))
        assert found.triangles == (500, 500)
        assert press.coverage_of(srgb) == pytest.approx((press & srgb).of_second)
        assert 0.3 < press.coverage_of(srgb) < 0.6

    def test_pictures(self, press, srgb):
        assert b"<svg" in press.slice_svg(50)
        assert b"<svg" in press.rings_svg(srgb)
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

    def test_no_lines_have_no_crossings(self, press):
        found = press.crossings(np.empty((0, 3)), (50, 0, 0))
        assert found.offsets.tolist() == [0]
        assert found.points.shape == (0, 3)

    def test_pages_are_saved_by_their_suffix(self, press, tmp_path):
        press.save(tmp_path / "press.html")
        assert (tmp_path / "press.html").read_bytes().startswith(b"<!doctype html>")


QUESTIONS = {
    "contains": lambda gamut, _: gamut.contains(COLOURS),
    "distance": lambda gamut, _: gamut.distance(COLOURS),
    "nearest": lambda gamut, _: gamut.nearest(COLOURS),
    "map": lambda gamut, _: gamut.map(COLOURS),
    "crossings": lambda gamut, _: gamut.crossings(COLOURS, (50, 0, 0)),
    "cusps": lambda gamut, _: gamut.cusps(90),
    "slice": lambda gamut, _: gamut.slice(50),
    "leaves": lambda gamut, _: gamut.leaves(12, 11),
    "rings": lambda gamut, other: gamut.rings(other),
    "compare": lambda gamut, other: gamut.compare(other),
    "mesh": lambda gamut, _: gamut.mesh(300),
}


def assert_equal(here, there):
    """The same arrays and numbers; JSON has all digits, and error bounds have six in headers."""
    if isinstance(here, np.ndarray):
        np.testing.assert_allclose(there, here, rtol=0, atol=1e-9, equal_nan=True)
    elif isinstance(here, float):
        assert there == pytest.approx(here, rel=1e-5)
    else:
        assert there == here


@pytest.mark.parametrize("name", QUESTIONS)
def test_answers_are_those_of_gamutcore(local, remote, name):
    here, there = QUESTIONS[name](*local), QUESTIONS[name](*remote)
    if isinstance(here, np.ndarray):
        assert_equal(here, there)
        return
    compared = {
        field
        for field in vars(there)
        if hasattr(here, field) and field not in {"sectors", "device", "load"}
    }
    assert len(compared) >= 3
    for field in compared:
        assert_equal(getattr(here, field), getattr(there, field))


def test_both_kinds_have_the_same_methods(remote):
    methods = {
        name
        for name, _ in inspect.getmembers(gamutcore.Gamut, inspect.isfunction)
        if not name.startswith(("_", "plot"))
    } - {"convert", "level", "map_picture", "to_html"}  # docs/client.md
    assert methods <= set(dir(remote[0]))
    assert methods <= set(dir(gamutclient.AsyncGamut))


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
            )

    inside, nearest, coverage, mesh, file, chroma = asyncio.run(ask())
    press, srgb = local
    assert (inside == press.contains(COLOURS)).all()
    np.testing.assert_allclose(nearest.points, press.nearest(COLOURS).points, atol=1e-9)
    assert coverage == pytest.approx(press.coverage_of(srgb))
    np.testing.assert_array_equal(mesh.vertices, press.mesh(100).vertices)
    assert file.startswith(b"glTF")
    assert (tmp_path / "press.HTML").read_bytes().startswith(b"<!doctype html>")
    np.testing.assert_allclose(chroma, press.max_chroma(50, [0, 90]))
    with pytest.raises(TypeError, match="mesh_file"):
        mesh.to_bytes("glb")
