"""Damage every file of a store: the service must detect it, never serve it, and build it again."""

import random
import re

_FOUND = re.compile(r"^gamut_store_corruptions_total (\d+)", re.MULTILINE)

ROUNDS = (("gamut", "flip"), ("gamut", "truncate"), ("record", "flip"), ("record", "truncate"))
"""The file of each gamut that is damaged, and the kind of damage."""


def damage(content, how, chance):
    """Return content with one flipped bit, or truncated."""
    position = chance.randrange(len(content))
    if how == "truncate":
        return content[:position]
    changed = bytearray(content)
    changed[position] ^= 1 << chance.randrange(8)
    return bytes(changed)


def every_damage_is_noticed(start_server, bodies, *, seed=0):
    """Damage the files of all gamuts in several rounds; return the number of damaged files.

    After a restart, each request for a damaged gamut must start a build, the gamut must then have
    its former bytes, and the service must have counted the damage.
    """
    chance = random.Random(seed)  # noqa: S311  # reproducible
    server = start_server()
    gamuts = [server.client.post("/v1/gamuts", json=body).json() for body in bodies]
    meshes = [server.client.get(gamut["links"]["mesh"]).content for gamut in gamuts]
    histories = [server.client.get(gamut["links"]["history"]).content for gamut in gamuts]
    for suffix, how in ROUNDS:
        server.stop()
        for gamut in gamuts:
            (path,) = server.data.rglob(f"published/*/{gamut['id']}*.{suffix}")
            path.write_bytes(damage(path.read_bytes(), how, chance))
        server = start_server(data=server.data)
        for gamut, mesh, history in zip(gamuts, meshes, histories, strict=True):
            answer = server.client.get(gamut["links"]["mesh"])
            assert answer.status_code == 503, (suffix, how, answer.status_code)
            problem = answer.json()
            assert problem["code"] == "gamut-rebuilding"
            assert server.finished_job(problem["where"]["job"])["state"] == "succeeded"
            assert server.client.get(gamut["links"]["mesh"]).content == mesh
            assert server.client.get(gamut["links"]["history"]).content == history
        (found,) = _FOUND.findall(server.client.get("/metrics").text)
        assert int(found) == len(gamuts), (suffix, how)
    server.stop()
    return len(ROUNDS) * len(gamuts)
