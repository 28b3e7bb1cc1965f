import asyncio
import hashlib
import json

import pytest

from gamutcore.export import encoded_mesh
from gamutcore.gamut import Options, build_gamut
from service.library import Library, mesh_provenance
from service.store import GamutNotStoredError, Record


def run(library, scenario):
    try:
        asyncio.run(scenario)
    finally:
        library.close()


def test_a_gamut_is_opened_once_for_all_who_ask(filled_store, built, monkeypatch):
    library, reads, content = Library(filled_store, 10**9), [], filled_store.content
    monkeypatch.setattr(filled_store, "content", lambda name: reads.append(name) or content(name))

    async def scenario():
        identity = built[0].id
        assert library.opened(identity) is None
        opened = await asyncio.gather(*(library.gamut(identity) for _ in range(20)))
        assert len({id(one) for one in opened}) == 1
        assert library.opened(identity) is opened[0]
        assert reads == [identity]

    run(library, scenario())


def test_no_more_is_kept_than_fits(filled_store, built):
    library = Library(filled_store, max(gamut.nbytes for gamut in built))

    async def scenario():
        for gamut in built:
            await library.gamut(gamut.id)
        assert [library.opened(gamut.id) is None for gamut in built] == [True, False]

    run(library, scenario())


def test_what_is_deleted_while_it_is_being_opened_is_not_kept(filled_store, built):
    library = Library(filled_store, 10**9)

    async def scenario():
        opening = asyncio.create_task(library.gamut(built[0].id))
        await asyncio.sleep(0)
        library.discard(built[0].id)
        await opening
        assert library.opened(built[0].id) is None

    run(library, scenario())


def test_a_file_that_is_no_history_is_set_aside(filled_store):
    content = b"intact, but of another kind"
    record = Record("a" * 64, hashlib.sha256(content).hexdigest(), len(content), "", {})
    filled_store.publish(record, filled_store.write_temporary(".gamut", content))
    library = Library(filled_store, 10**9)

    async def scenario():
        with pytest.raises(GamutNotStoredError):
            await library.gamut(record.id)
        assert list(filled_store.quarantine.iterdir())

    run(library, scenario())


def test_a_mesh_says_where_it_comes_from(filled_store, built):
    library = Library(filled_store, 10**9)

    async def scenario():
        provenance = (await library.gamut(built[0].id)).provenance
        assert provenance["gamut"] == built[0].id
        assert provenance["space"] == "CIELAB"
        description = built[0].description
        centre = [float(number) for number in provenance["centre"].split()]
        assert centre == description["centre"]
        stated = description["provenance"]
        assert provenance["input_sha256"] == stated["input"]["sha256"]
        assert provenance["algorithm_version"] == str(stated["algorithm"]["version"])
        assert all(isinstance(value, str) for value in provenance.values())

    run(library, scenario())


def test_glb_and_ply_carry_centre_white_input_and_algorithm(sphere):
    white = [95.047, 100.0, 108.883]
    source = json.dumps({"samples": sphere(21), "white": white}).encode()
    gamut = build_gamut(source, Options())
    provenance = mesh_provenance(gamut.id, gamut.description)
    stated = gamut.description["provenance"]
    expected = {
        "centre": " ".join(map(repr, gamut.description["centre"])),
        "white": " ".join(map(repr, stated["white"])),
        "input_sha256": hashlib.sha256(source).hexdigest(),
        "algorithm_version": str(stated["algorithm"]["version"]),
    }
    level = gamut.history.level(10)
    glb = encoded_mesh(level, "glb", provenance)
    length = int.from_bytes(glb[12:16], "little")
    assert expected.items() <= json.loads(glb[20 : 20 + length])["asset"]["extras"].items()
    header = encoded_mesh(level, "ply", provenance).partition(b"end_header")[0].decode()
    for name, value in expected.items():
        assert any(
            line.startswith("comment") and name in line and value in line
            for line in header.splitlines()
        ), name
