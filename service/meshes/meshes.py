"""Meshes of a library's gamuts: level, encoding and cache.

`Meshes.find_ready` answers without waiting. `Meshes.mesh` calls it first. Then it opens the gamut,
finds the level, encodes it, and keeps the mesh. Small levels that are unpacked are encoded on the
event loop in about a millisecond. All others are encoded in a thread.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from gamutcore.errors import TriangleCountError
from gamutcore.export.rendering import PICTURE_TRIANGLES
from service.caching.byte_bounded_cache import ByteBoundedCache
from service.caching.single_flight import SingleFlight
from service.http.representations import IDENTITY
from service.library import Charge, Cost
from service.meshes.encoding import (
    EncodedMesh,
    MeshKey,
    PictureOptions,
    encode_mesh,
    encode_picture,
)
from service.meshes.requested_levels import RequestedLevels

if TYPE_CHECKING:
    from gamutcore.levels import LevelRequest
    from service.library import Library, OpenGamut

__all__ = ["Meshes"]

_INLINE_TRIANGLES = {"glb": 4000, "gltf": 1000, "ply": 4000, "stl": 4000}
"""Largest levels that are read and encoded in about a millisecond, which the event loop can
spare. Formats that are not listed are always encoded in a thread."""

_ENTRY_BYTES = 1024
"""Approximate memory of a cache entry besides the content: key, header fields, bookkeeping."""


class Meshes:
    """The encoded meshes of a library's gamuts, in a cache of `capacity` bytes.

    `levels` finds the levels of requests.
    """

    def __init__(self, library: Library, capacity: int) -> None:
        self._library = library
        self.cache: ByteBoundedCache[MeshKey, EncodedMesh] = ByteBoundedCache(capacity)
        library.memory.add(self.cache)
        self.levels = RequestedLevels(library)
        self._encoding: SingleFlight[MeshKey, EncodedMesh] = SingleFlight()

    def find_ready(
        self, gamut_id: str, request: LevelRequest, format_name: str, coding: str = IDENTITY
    ) -> EncodedMesh | None:
        """Return a mesh that is cached or takes at most about a millisecond to encode; else None.

        The level must exist, and be found and unpacked already. `coding` is one of `CODINGS`, or
        `IDENTITY`.
        """
        opened = self._library.find_open(gamut_id)
        level = self.levels.find_known(gamut_id, request)
        if level is None:
            return None
        triangles = level.triangles
        key = MeshKey(gamut_id, triangles, format_name, coding, request.side)
        mesh = self.cache.get(key)
        if mesh is None:
            if request.side != "both":
                return None
            small = triangles <= _INLINE_TRIANGLES.get(format_name, 0)
            if opened is None or not small or not opened.gamut.history.is_unpacked(triangles):
                return None
            made = encode_mesh(opened, key, self.cache.get(key._replace(coding=IDENTITY)))
            mesh = self._keep(made)[key]
        return mesh if request.limits is None else mesh.with_bounds(level.bounds)

    async def mesh(
        self, gamut_id: str, request: LevelRequest, format_name: str, coding: str = IDENTITY
    ) -> EncodedMesh:
        """Return a mesh; parameters as for `find_ready`.

        Raise `GamutNotStoredError` if the gamut is missing or damaged, and `TriangleCountError` if
        it has no such level.
        """
        ready = self.find_ready(gamut_id, request, format_name, coding)
        if ready is not None:
            return ready
        record = await self._library.record(gamut_id)
        full: int = record.description["counts"]["triangles"]

        def need() -> int:
            if self.find_ready(gamut_id, request, format_name, coding) is not None:
                return 0
            triangles = min(full, self.levels.largest_count(record, request))
            encoding = Cost.FORMAT.get(format_name, Cost.OTHER_FORMAT) + Cost.CODING
            side = 0 if request.side == "both" else Cost.SIDE * full
            return self.levels.finding_cost(record, request) + encoding * triangles + side

        with await self._library.memory.charge("work", need) as charge:
            opened = await self._library.gamut(gamut_id, charge)
            triangles, bounds = await self.levels.find(opened, request)
            key = MeshKey(gamut_id, triangles, format_name, coding, request.side)
            mesh = self.cache.get(key)
            if mesh is None:
                mesh = await self._encoding.value(key, lambda: self._encode(opened, key, charge))
            self._library.settle(opened, charge)
        return mesh if request.limits is None else mesh.with_bounds(bounds)

    async def picture(
        self, gamut_id: str, request: LevelRequest, options: PictureOptions, most: int
    ) -> EncodedMesh:
        """Return a picture of a level of at most `most` triangles; raises as `mesh` does."""
        record = await self._library.record(gamut_id)
        full = record.description["counts"]["triangles"]
        request = request.or_default(min(PICTURE_TRIANGLES, full))
        pixels = Cost.PIXEL * options.size**2

        def need() -> int:
            triangles = min(most, self.levels.largest_count(record, request))
            if self.cache.get(options.key(gamut_id, triangles)) is not None:
                return 0
            return self.levels.finding_cost(record, request) + Cost.PICTURE * triangles + pixels

        with await self._library.memory.charge("work", need) as charge:
            opened = await self._library.gamut(gamut_id, charge)
            count, _ = await self.levels.find(opened, request)
            if count > most:
                raise TriangleCountError(
                    f"This error limit needs {count} triangles. A picture has at most {most}.",
                    where={"field": "max_error"},
                    remedy=f"Give a larger limit, or up to {most} triangles.",
                )
            key = options.key(gamut_id, count)
            picture = self.cache.get(key) or await self._encoding.value(
                key, lambda: self._draw(opened, key, options, charge)
            )
            self._library.settle(opened, charge)
        return picture

    async def _draw(
        self, opened: OpenGamut, key: MeshKey, options: PictureOptions, charge: Charge
    ) -> EncodedMesh:
        await self._library.unpack(opened, key.triangles)
        picture = await self._library.in_thread(encode_picture, opened, key, options)
        return self._keep({key: picture}, opened, charge)[key]

    async def rename(self, gamut_id: str) -> None:
        """Give the files of a gamut its new name from now on."""
        await self._library.rename(gamut_id)
        self.cache.discard_where(lambda key: key.gamut_id == gamut_id)

    def discard_gamut(self, gamut_id: str) -> None:
        """Forget all meshes of a gamut."""
        self.cache.discard_where(lambda key: key.gamut_id == gamut_id)

    async def _encode(self, opened: OpenGamut, key: MeshKey, charge: Charge) -> EncodedMesh:
        plain = self.cache.get(key._replace(coding=IDENTITY))
        if plain is not None and key.coding == IDENTITY:
            return plain  # `find_ready` has encoded it since the last look
        # a level on one side is compared with the full boundary
        needed = key.triangles if key.side == "both" else opened.gamut.history.triangles
        await self._library.unpack(opened, needed)
        made = await self._library.in_thread(encode_mesh, opened, key, plain)
        return self._keep(made, opened, charge)[key]

    def _keep(
        self,
        made: dict[MeshKey, EncodedMesh],
        opened: OpenGamut | None = None,
        charge: Charge | None = None,
    ) -> dict[MeshKey, EncodedMesh]:
        """Charge and keep meshes, unless the gamut was deleted meanwhile."""
        memory, kept = self._library.memory, {}
        for key, mesh in made.items():
            nbytes = len(mesh.body) + _ENTRY_BYTES
            own = Charge(memory, "meshes", 0)
            has_room = memory.raise_to(own, nbytes, charge)
            kept[key] = replace(mesh, charge=own)
            if has_room and (opened is None or self._library.find_open(key.gamut_id) is opened):
                self.cache.put(key, kept[key], nbytes)
        return kept
