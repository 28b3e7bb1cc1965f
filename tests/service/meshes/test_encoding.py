import asyncio
import gzip
import hashlib

from gamutcore.export import FORMATS
from service.meshes.encoding import MEDIA_TYPES, SUFFIXES, MeshKey, encode_mesh
from service.meshes.library import Library


def test_every_format_has_a_media_type_and_a_suffix_of_its_own():
    # bytes of no stated type are GLB, for clients that know no other binary type
    assert MEDIA_TYPES["application/octet-stream"] == "glb"
    own = [name for kind, name in MEDIA_TYPES.items() if kind != "application/octet-stream"]
    assert sorted(own) == sorted(SUFFIXES.values()) == sorted(FORMATS)
    assert next(iter(MEDIA_TYPES)) == "model/gltf-binary"


def test_a_compressed_mesh_is_made_of_the_plain_one(filled_store, built):
    async def scenario():
        library = Library(filled_store, 10**9)
        opened = await library.gamut(built[0].id)
        await library.unpack(opened, 100)
        library.close()
        return opened

    opened = asyncio.run(scenario())
    key = MeshKey(built[0].id, 100, "ply", "gzip")
    made = encode_mesh(opened, key)
    plain = made[key._replace(coding="")]
    assert set(made) == {key, key._replace(coding="")}
    assert gzip.decompress(made[key].body) == plain.body
    for mesh in made.values():
        assert mesh.etag == f'"{hashlib.sha256(mesh.body).hexdigest()}"'
    assert encode_mesh(opened, key, plain) == {key: made[key]}
