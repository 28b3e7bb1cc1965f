import asyncio

import pytest

from gamutcore.errors import TriangleCountError
from gamutcore.metric import radial_difference
from service.http.compression import CODINGS
from service.meshes.encoding import EncodedMesh, MeshKey
from service.meshes.library import Library
from service.meshes.meshes import Meshes
from service.meshes.requested_levels import LevelRequest
from service.storage.gamuts import GamutNotStoredError


@pytest.fixture
def run(filled_store):
    """Run a coroutine function with the meshes of the filled store."""

    def run_scenario(scenario, capacity=10**8):
        library = Library(filled_store, 10**9)
        try:
            return asyncio.run(scenario(library, Meshes(library, capacity)))
        finally:
            library.close()

    return run_scenario


def test_a_mesh_is_at_hand_once_its_level_is_unpacked(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        assert meshes.find_ready(name, LevelRequest(100), "glb") is None
        opened = await library.gamut(name)
        assert meshes.find_ready(name, LevelRequest(100), "glb") is None
        await library.unpack(opened, 100)
        mesh = meshes.find_ready(name, LevelRequest(101), "glb")
        assert mesh is meshes.find_ready(name, LevelRequest(100), "glb")
        assert mesh is await meshes.mesh(name, LevelRequest(100), "glb")

    run(scenario)


def test_a_mesh_outlives_its_closed_gamut_but_not_its_deleted_one(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        mesh = await meshes.mesh(name, LevelRequest(100), "glb")
        library.discard(name)
        assert meshes.find_ready(name, LevelRequest(100), "glb") is mesh
        assert meshes.find_ready(name, LevelRequest(101), "glb") is None
        assert meshes.find_ready(name, LevelRequest(), "glb") is None
        meshes.discard_gamut(name)
        assert meshes.find_ready(name, LevelRequest(100), "glb") is None

    run(scenario)


def test_a_coarse_mesh_leaves_the_finer_levels_packed(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        assert triangles(await meshes.mesh(name, LevelRequest(10), "ply")) == 10
        opened = library.find_open(name)
        assert not opened.gamut.history.is_unpacked(built[0].history.triangles)
        before = library.cache.nbytes
        await meshes.mesh(name, LevelRequest(built[0].history.triangles), "ply")
        assert library.find_open(name) is opened
        assert opened.gamut.nbytes == library.cache.nbytes > before

    run(scenario)


class TestLimits:
    """The level is that of `service.meshes.requested_levels`; here is how it is sent."""

    def test_are_kept_by_what_the_headers_promise(self, run, built):
        async def scenario(_library, meshes):
            for name, limits in (("max_error", (20, 5, 0.7)), ("max_mismatch", (0.2, 0.01))):
                counts = []
                for limit in limits:
                    mesh = await meshes.mesh(built[0].id, LevelRequest(**{name: limit}), "glb")
                    assert promised(mesh)[name] <= limit
                    counts.append(triangles(mesh))
                assert counts == sorted(set(counts))

        run(scenario)

    def test_of_both_kinds_are_both_kept(self, run, built):
        levels = built[0].description["levels"]
        errors = [level["distance_bound"] for level in levels[2::3]]
        mismatches = [level["mismatch_bound"] for level in levels[2::3]]

        async def count(meshes, *limits):
            mesh = await meshes.mesh(built[0].id, LevelRequest(None, *limits), "glb")
            for found, limit in zip(promised(mesh).values(), limits, strict=True):
                assert limit is None or found <= limit
            return triangles(mesh)

        async def scenario(_library, meshes):
            for error in errors:
                for mismatch in mismatches:
                    alone = await count(meshes, error, None), await count(meshes, None, mismatch)
                    assert await count(meshes, error, mismatch) >= max(alone)

        run(scenario)

    def test_of_zero_only_the_full_boundary_keeps(self, run, built):
        async def scenario(_library, meshes):
            for wanted in (LevelRequest(max_error=0.0), LevelRequest(max_mismatch=0.0)):
                mesh = await meshes.mesh(built[0].id, wanted, "glb")
                assert triangles(mesh) == built[0].history.triangles
                assert promised(mesh) == {"max_error": 0, "max_mismatch": 0}

        run(scenario)

    def test_share_the_content_with_the_level_by_its_count(self, run, built):
        """Which promises nothing, if the curve does not have it."""

        async def scenario(_library, meshes):
            wanted = LevelRequest(max_error=0.7)
            limited = await meshes.mesh(built[0].id, wanted, "glb")
            plain = await meshes.mesh(built[0].id, LevelRequest(triangles(limited)), "glb")
            assert limited.body is plain.body
            assert limited.etag == plain.etag
            assert triangles(limited) not in {
                level["triangles"] for level in built[0].description["levels"]
            }
            assert promised(plain) == {}
            for coding in CODINGS:
                coded = await meshes.mesh(built[0].id, wanted, "glb", coding)
                assert promised(coded) == promised(limited)
                assert meshes.find_ready(built[0].id, wanted, "glb", coding) == coded
            assert len(meshes.cache) == 1 + len(CODINGS)

        run(scenario)

    def test_are_found_once_and_then_at_hand(self, run, built):
        async def scenario(library, meshes):
            wanted = LevelRequest(max_error=0.7, max_mismatch=0.02)
            assert meshes.find_ready(built[0].id, wanted, "glb") is None
            mesh = await meshes.mesh(built[0].id, wanted, "glb")
            assert meshes.find_ready(built[0].id, wanted, "glb") == mesh
            library.discard(built[0].id)
            assert meshes.find_ready(built[0].id, wanted, "glb") == mesh
            assert meshes.find_ready(built[0].id, wanted, "ply") is None
            meshes.discard_gamut(built[0].id)
            assert meshes.find_ready(built[0].id, wanted, "glb") is None

        run(scenario)

    def test_are_kept_without_a_curve_that_promises_anything(self, run, built):
        async def scenario(library, meshes):
            opened = await library.gamut(built[0].id)
            for level in opened.gamut.description["levels"]:
                del level["distance_bound"], level["mismatch_bound"]
            mesh = await meshes.mesh(built[0].id, LevelRequest(max_error=2.0), "ply")
            assert promised(mesh)["max_error"] <= 2
            full, level = opened.gamut.history.full(), opened.gamut.level(triangles(mesh))
            direct = radial_difference(full, level, opened.gamut.history.centre)
            assert promised(mesh)["max_mismatch"] == pytest.approx(direct.mismatch, rel=1e-5)
            assert promised(await meshes.mesh(built[0].id, LevelRequest(100), "ply")) == {}

        run(scenario)

    def test_are_in_the_headers_of_the_curve_s_levels_alone(self, run, built):
        levels = built[0].description["levels"]

        async def scenario(_library, meshes):
            for level in levels:
                headers = dict((await meshes.mesh(*question(level["triangles"]))).headers)
                assert float(headers[b"gamut-max-error"]) == level["distance_bound"]
                assert float(headers[b"gamut-max-mismatch"]) == level["mismatch_bound"]
            other = levels[-2]["triangles"] + 2
            headers = dict((await meshes.mesh(*question(other))).headers)
            assert {b"gamut-max-error", b"gamut-max-mismatch"}.isdisjoint(headers)

        def question(count):
            return built[0].id, LevelRequest(count), "glb"

        run(scenario)


def triangles(mesh):
    return int(dict(mesh.headers)[b"gamut-triangles"])


def promised(mesh):
    """What the header fields promise, by the names of the parameters."""
    headers = dict(mesh.headers)
    fields = {"max_error": b"gamut-max-error", "max_mismatch": b"gamut-max-mismatch"}
    return {name: float(headers[field]) for name, field in fields.items() if field in headers}


def test_levels_that_are_not_there_are_never_answered(run, built):
    async def scenario(_library, meshes):
        gamut = built[0]
        largest = gamut.history.triangles
        await meshes.mesh(gamut.id, LevelRequest(largest), "glb")
        for count in (3, 0, -1, largest + 1):
            assert meshes.find_ready(gamut.id, LevelRequest(count), "glb") is None
            with pytest.raises(TriangleCountError):
                await meshes.mesh(gamut.id, LevelRequest(count), "glb")
        with pytest.raises(GamutNotStoredError):
            await meshes.mesh("0" * 64, LevelRequest(100), "glb")

    run(scenario)


def test_a_slow_format_is_left_to_a_thread_and_made_once(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        await library.gamut(name)
        assert meshes.find_ready(name, LevelRequest(100), "obj") is None
        both = await asyncio.gather(
            *(meshes.mesh(name, LevelRequest(100), "obj") for _ in range(5))
        )
        assert len({id(mesh) for mesh in both}) == 1
        assert meshes.find_ready(name, LevelRequest(100), "obj") is both[0]

    run(scenario)


def test_what_is_deleted_while_it_is_encoded_is_not_kept(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        await library.gamut(name)
        encoding = asyncio.create_task(meshes.mesh(name, LevelRequest(100), "obj"))
        await asyncio.sleep(0)
        library.discard(name)
        meshes.discard_gamut(name)
        await encoding
        assert meshes.find_ready(name, LevelRequest(100), "obj") is None

    run(scenario)


def test_a_cache_without_room_keeps_nothing_and_hinders_nobody(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        first = await meshes.mesh(name, LevelRequest(100), "ply")
        assert meshes.find_ready(name, LevelRequest(100), "ply") == first
        library.discard(name)
        assert meshes.find_ready(name, LevelRequest(100), "ply") is None

    run(scenario, capacity=0)


def test_a_304_has_the_fields_that_a_cache_needs_and_no_content():
    mesh = EncodedMesh.of(b"body", "model/stl", ("a", "-4.stl"), 4, 4)
    status, headers, body = mesh.response(mesh.etag)
    names = {name for name, _ in headers}
    assert (status, body) == (304, b"")
    assert {b"etag", b"cache-control", b"vary"} <= names
    assert names.isdisjoint({b"content-type", b"content-length"})


def test_a_mesh_that_the_fast_path_makes_meanwhile_is_not_made_again(run, built):
    async def scenario(library, meshes):
        opened = await library.gamut(built[0].id)
        await library.unpack(opened, 100)
        ready = meshes.find_ready(built[0].id, LevelRequest(100), "glb")
        assert await meshes._encode(opened, MeshKey(built[0].id, 100, "glb")) is ready

    run(scenario)
