import asyncio

import pytest

from gamutcore.errors import TriangleCountError
from gamutcore.export import FORMATS
from service.library import Library
from service.meshes import MEDIA_TYPES, SUFFIXES, EncodedMesh, Meshes
from service.store import GamutNotStoredError


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


def test_every_format_has_a_media_type_and_a_suffix_of_its_own():
    assert sorted(MEDIA_TYPES.values()) == sorted(SUFFIXES.values()) == sorted(FORMATS)
    assert next(iter(MEDIA_TYPES)) == "model/gltf-binary"


def test_a_mesh_is_at_hand_once_its_gamut_is_open(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        assert meshes.at_once(name, 100, "glb") is None
        await library.gamut(name)
        mesh = meshes.at_once(name, 101, "glb")
        assert mesh is meshes.at_once(name, 100, "glb")
        assert mesh is await meshes.mesh(name, 100, "glb")

    run(scenario)


def test_a_mesh_outlives_its_closed_gamut_but_not_its_deleted_one(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        mesh = await meshes.mesh(name, 100, "glb")
        library.discard(name)
        assert meshes.at_once(name, 100, "glb") is mesh
        assert meshes.at_once(name, 101, "glb") is None
        assert meshes.at_once(name, None, "glb") is None
        meshes.discard_gamut(name)
        assert meshes.at_once(name, 100, "glb") is None

    run(scenario)


def test_levels_that_are_not_there_are_never_answered(run, built):
    async def scenario(_library, meshes):
        gamut = built[0]
        largest = gamut.history.triangles
        await meshes.mesh(gamut.id, largest, "glb")
        for count in (3, 0, -1, largest + 1):
            assert meshes.at_once(gamut.id, count, "glb") is None
            with pytest.raises(TriangleCountError):
                await meshes.mesh(gamut.id, count, "glb")
        with pytest.raises(GamutNotStoredError):
            await meshes.mesh("0" * 64, 100, "glb")

    run(scenario)


def test_a_slow_format_is_left_to_a_thread_and_made_once(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        await library.gamut(name)
        assert meshes.at_once(name, 100, "obj") is None
        both = await asyncio.gather(*(meshes.mesh(name, 100, "obj") for _ in range(5)))
        assert len({id(mesh) for mesh in both}) == 1
        assert meshes.at_once(name, 100, "obj") is both[0]

    run(scenario)


def test_what_is_deleted_while_it_is_encoded_is_not_kept(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        await library.gamut(name)
        encoding = asyncio.create_task(meshes.mesh(name, 100, "obj"))
        await asyncio.sleep(0)
        library.discard(name)
        meshes.discard_gamut(name)
        await encoding
        assert meshes.at_once(name, 100, "obj") is None

    run(scenario)


def test_a_cache_without_room_keeps_nothing_and_hinders_nobody(run, built):
    async def scenario(library, meshes):
        name = built[0].id
        first = await meshes.mesh(name, 100, "ply")
        assert meshes.at_once(name, 100, "ply") == first
        library.discard(name)
        assert meshes.at_once(name, 100, "ply") is None

    run(scenario, capacity=0)


def test_a_304_has_the_fields_that_a_cache_needs_and_no_content():
    mesh = EncodedMesh.of(b"body", "model/stl", 4, 4)
    status, headers, body = mesh.response(mesh.etag)
    names = {name for name, _ in headers}
    assert (status, body) == (304, b"")
    assert {b"etag", b"cache-control", b"vary"} <= names
    assert names.isdisjoint({b"content-type", b"content-length"})
