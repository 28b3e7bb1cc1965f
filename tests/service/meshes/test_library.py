import asyncio
import hashlib
import json
from dataclasses import replace

import numpy as np
import pytest

from gamutcore.colours.spaces import SPACES
from gamutcore.errors import OptionError
from gamutcore.export import mesh_file
from gamutcore.gamut import Options, build_gamut
from gamutcore.history import packed_splits
from service.meshes.library import Library, mesh_provenance
from service.storage.gamuts import GamutDamagedError, GamutNotStoredError
from service.storage.records import Record

NAME = "a" * 64


def run(library, scenario):
    try:
        asyncio.run(scenario)
    finally:
        library.close()


def published(store, content, description=None):
    """The record of some bytes, which are in the store from now on."""
    digest = hashlib.sha256(content).hexdigest()
    path = store.scratch(".gamut")
    path.write_bytes(content)
    return store.publish(Record(NAME, digest, len(content), "", description or {}), path)


def of_a_damaged_stream(gamut):
    """The bytes of a gamut, except for the last of its finest levels."""
    content = bytearray(gamut.to_bytes())
    content[-1] ^= 255
    return bytes(content)


def test_a_gamut_is_opened_once_for_all_who_ask(filled_store, built, monkeypatch):
    library, reads, content = Library(filled_store, 10**9), [], filled_store.content
    monkeypatch.setattr(filled_store, "content", lambda name: reads.append(name) or content(name))

    async def scenario():
        identity = built[0].id
        assert library.find_open(identity) is None
        opened = await asyncio.gather(*(library.gamut(identity) for _ in range(20)))
        assert len({id(one) for one in opened}) == 1
        assert library.find_open(identity) is opened[0]
        assert reads == [identity]

    run(library, scenario())


def test_no_more_is_kept_than_fits(filled_store, built):
    library = Library(filled_store, max(gamut.nbytes for gamut in built))

    async def scenario():
        opened = [await library.gamut(gamut.id) for gamut in built]
        assert [library.find_open(gamut.id) for gamut in built] == opened
        await library.unpack(opened[0], built[0].history.triangles)
        assert [library.find_open(gamut.id) is None for gamut in built] == [False, True]
        await library.gamut(built[1].id)
        assert [library.find_open(gamut.id) is None for gamut in built] == [True, False]
        # what is no longer kept can still be read by whoever holds it
        await library.unpack(opened[0], 4)
        assert opened[0].gamut.history.full() == built[0].history.full()
        assert library.find_open(built[0].id) is None

    run(library, scenario())


def test_what_is_deleted_while_it_is_being_opened_is_not_kept(filled_store, built):
    library = Library(filled_store, 10**9)

    async def scenario():
        opening = asyncio.create_task(library.gamut(built[0].id))
        await asyncio.sleep(0)
        library.discard(built[0].id)
        await opening
        assert library.find_open(built[0].id) is None

    run(library, scenario())


def test_a_file_that_is_no_history_is_set_aside(filled_store):
    record = published(filled_store, b"intact, but of another kind")
    library = Library(filled_store, 10**9)

    async def scenario():
        with pytest.raises(GamutNotStoredError):
            await library.gamut(record.id)
        assert list(filled_store.blobs.keys("quarantine/"))

    run(library, scenario())


def test_a_file_with_a_damaged_stream_is_set_aside_when_that_is_asked_for(filled_store, built):
    """Its digest is right: it was written like that."""
    record = published(filled_store, of_a_damaged_stream(built[0]), built[0].description)
    library = Library(filled_store, 10**9)
    triangles = built[0].history.triangles

    async def scenario():
        opened = await library.gamut(record.id)
        await library.unpack(opened, 10)
        assert opened.gamut.level(10) == built[0].level(10)
        wanted = (library.unpack(opened, triangles) for _ in range(3))
        errors = await asyncio.gather(*wanted, return_exceptions=True)
        assert all(isinstance(error, GamutDamagedError) for error in errors)
        assert library.find_open(record.id) is None
        assert list(filled_store.blobs.keys("quarantine/"))
        with pytest.raises(GamutNotStoredError):
            await library.gamut(record.id)

    run(library, scenario())


def test_a_reader_of_a_damaged_gamut_leaves_the_one_that_replaced_it(filled_store, built):
    """Two requests hold it; by the time of the second it has been set aside, mended and opened."""
    published(filled_store, of_a_damaged_stream(built[0]))
    library = Library(filled_store, 10**9)
    triangles = built[0].history.triangles

    async def scenario():
        damaged = await library.gamut(NAME)
        with pytest.raises(GamutDamagedError):
            await library.unpack(damaged, triangles)
        record = published(filled_store, built[0].to_bytes())
        mended = await library.gamut(NAME)
        with pytest.raises(GamutDamagedError):
            await library.unpack(damaged, triangles)
        assert library.find_open(NAME) is mended
        assert filled_store.record(NAME) == record
        assert filled_store.corruptions == 1
        await library.unpack(mended, triangles)
        assert mended.gamut.history.full() == built[0].history.full()

    run(library, scenario())


def test_what_replaced_a_file_that_is_no_history_while_it_was_read_stays(
    filled_store, built, monkeypatch
):
    published(filled_store, b"intact, but of another kind")
    library, content, mended = Library(filled_store, 10**9), filled_store.content, []

    def replaced_when_read(gamut_id):
        found = content(gamut_id)
        filled_store.delete(gamut_id)
        mended.append(published(filled_store, built[0].to_bytes()))
        return found

    async def scenario():
        with monkeypatch.context() as patch:
            patch.setattr(filled_store, "content", replaced_when_read)
            with pytest.raises(GamutDamagedError):
                await library.gamut(NAME)
        assert [filled_store.record(NAME)] == mended
        assert filled_store.corruptions == 0
        assert (await library.gamut(NAME)).record == mended[0]

    run(library, scenario())


def test_a_gamut_that_could_not_be_unpacked_is_opened_anew(filled_store, built, monkeypatch):
    library = Library(filled_store, 10**9)
    triangles = built[0].history.triangles

    def no_memory(*_):
        raise MemoryError

    async def scenario():
        opened = await library.gamut(built[0].id)
        monkeypatch.setattr(packed_splits, "read_group", no_memory)
        with pytest.raises(MemoryError):
            await library.unpack(opened, triangles)
        monkeypatch.undo()
        again = await library.gamut(built[0].id)
        await library.unpack(again, triangles)
        assert again.gamut.history.full() == built[0].history.full()
        assert not list(filled_store.blobs.keys("quarantine/"))

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
    glb = mesh_file(level, "glb", provenance)
    length = int.from_bytes(glb[12:16], "little")
    assert expected.items() <= json.loads(glb[20 : 20 + length])["asset"]["extras"].items()
    header = mesh_file(level, "ply", provenance).partition(b"end_header")[0].decode()
    for name, value in expected.items():
        assert any(
            line.startswith("comment") and name in line and value in line
            for line in header.splitlines()
        ), name


DEVICE = b"RGB_R,RGB_G,RGB_B,LAB_L,LAB_A,LAB_B\n" + b"\n".join(
    b"%d,%d,%d,%d,%d,%d" % (r * 255, g * 255, b * 255, *lab)
    for (r, g, b), lab in zip(
        np.ndindex(2, 2, 2),
        [
            (9, 0, 0),
            (32, 68, -90),
            (87, -70, 70),
            (90, -50, -15),
            (54, 70, 60),
            (60, 90, -55),
            (97, -15, 85),
            (100, 0, 0),
        ],
        strict=True,
    )
)

SPACE_OPTIONS = [
    *({"space": space} for space in SPACES),
    {"reference_white": "D65"},
    {"reference_white": [0.95, 1, 1.1], "adaptation": "CAT16"},
    {"scale": 0.01},
    {"scale": 1000},
    {"adaptation": "none"},
    {"space": "CIEXYZ", "scale": 100, "reference_white": "D65"},
    {"space": "ITP", "luminance": 100.5},
    {"space": "CAM16-UCS", "surround": "dim", "background": 18.4, "adapting_luminance": 1 / 3},
]


def posted_back(options, format_name, asked):
    gamut = build_gamut(DEVICE, Options.from_mapping({"surface_samples": 2000, **options}))
    level = gamut.level(60)
    provenance = mesh_provenance(gamut.id, gamut.description)
    data = mesh_file(level, format_name, provenance, gamut.colour_space)
    return gamut, level, build_gamut(data, Options.from_mapping(asked))


def recipes(mesh):
    """Each vertex with its device values, as files have them."""
    rows = zip(mesh.vertices.tolist(), mesh.device.values.astype(np.float32).tolist(), strict=True)
    return mesh.device.channels, sorted(rows)


@pytest.mark.parametrize("options", SPACE_OPTIONS, ids=str)
@pytest.mark.parametrize("format_name", ["ply", "glb"])
@pytest.mark.slow
def test_a_level_is_read_back_in_its_own_space(options, format_name):
    gamut, level, again = posted_back(options, format_name, options)
    assert again.history.full().volume == pytest.approx(level.volume, rel=1e-12)
    assert again.description["centre"] == gamut.description["centre"]
    assert again.colour_space == gamut.colour_space
    before, after = gamut.description["provenance"], again.description["provenance"]
    assert after["colour_space"].pop("from") == "the file"
    before["colour_space"]["adaptation"] = after["colour_space"]["adaptation"]
    assert after["colour_space"] == before["colour_space"]
    for name in ("axes", "space", "white", "illuminant", "observer", "channels"):
        assert after[name] == before[name]
    assert recipes(again.level(60)) == recipes(level)


@pytest.mark.parametrize(
    ("options", "asked", "field"),
    [
        ({"space": "Oklab"}, {}, "space"),
        ({}, {"space": "Oklab"}, "space"),
        ({"reference_white": "D65"}, {}, "reference_white"),
        ({"reference_white": [0.95, 1.0, 1.1]}, {"reference_white": "D65"}, "reference_white"),
        ({"scale": 0.01}, {}, "scale"),
        ({}, {"scale": 0.01}, "scale"),
        (
            {"reference_white": "D65", "adaptation": "none"},
            {"reference_white": "D65"},
            "adaptation",
        ),
        ({"space": "ICtCp"}, {"space": "ICtCp", "luminance": 100}, "luminance"),
        ({"space": "CAM16-UCS", "surround": "dark"}, {"space": "CAM16-UCS"}, "surround"),
    ],
    ids=str,
)
@pytest.mark.slow
def test_a_level_in_another_space_than_is_asked_for_is_refused(options, asked, field):
    with pytest.raises(OptionError) as caught:
        posted_back(options, "ply", asked)
    assert caught.value.where == {"field": field}
    stated = options.get(field)
    assert str(stated) in caught.value.remedy or field in {"space", "scale", "luminance"}


@pytest.mark.parametrize("space", ["CIELAB", "Oklab", "CIEXYZ"])
@pytest.mark.slow
def test_a_mesh_that_states_nothing_is_taken_to_be_in_the_space_that_is_asked_for(space):
    _, level, again = posted_back({"space": space}, "stl", {"space": space})
    assert again.history.full().volume == pytest.approx(level.volume, rel=1e-12)
    described = again.description["provenance"]["colour_space"]
    assert described["name"] == space
    assert "assumed" in described["from"]
    assert again.description["provenance"]["warnings"] == []


def test_a_mesh_that_states_nothing_and_is_too_small_for_cielab_has_a_warning():
    _, _, again = posted_back({"space": "Oklab"}, "stl", {})
    (warning,) = again.description["provenance"]["warnings"]
    assert "option space" in warning


@pytest.mark.parametrize("format_name", ["ply", "glb", "gltf"])
@pytest.mark.slow
def test_inks_of_any_name_are_read_back(format_name):
    mesh = build_gamut(DEVICE, Options(surface_samples=2000)).level(60)
    channels = ("Größe", "end of header", "黒")
    named = replace(mesh, device=replace(mesh.device, channels=channels))
    again = build_gamut(mesh_file(named, format_name, {"observer": "2°"}), Options())
    assert recipes(again.level(60)) == recipes(named)
    provenance = again.description["provenance"]
    assert provenance["observer"] == "2°"
    assert provenance["channels"] == list(channels)
    assert not [name for name in provenance["stated"] if name.lower().startswith("device")]
