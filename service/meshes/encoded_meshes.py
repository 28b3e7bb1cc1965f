"""Encoded meshes: any level of a gamut in any format and coding, made once and kept in memory.

A level of a gamut in a format and a content coding is immutable content, named by its `MeshKey`.
Which level keeps a limit to the error is found, and remembered, by `service.meshes.level_search`.
Small ones are made on the spot, on the event loop; large ones, and those whose level is not
unpacked yet, in a thread.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, NamedTuple

from gamutcore.export import FORMATS, mesh_file
from gamutcore.history import MINIMUM_TRIANGLES
from gamutcore.metric.level_search import Bounds
from service.caching.byte_bounded_cache import ByteBoundedCache
from service.caching.single_flight import SingleFlight
from service.http.compression import IDENTITY, compressed
from service.http.conditional import IMMUTABLE, entity_tag, matches
from service.meshes.level_search import Choices
from service.telemetry.server_timing import timed

if TYPE_CHECKING:
    from service.meshes.library import Library, OpenGamut
    from service.storage.records import Record

__all__ = [
    "DEFAULT_TRIANGLES",
    "MEDIA_TYPES",
    "SUFFIXES",
    "EncodedMesh",
    "MeshKey",
    "Meshes",
    "Wanted",
]

DEFAULT_TRIANGLES = 1000
"""Triangles of a mesh when none are asked for: 23 kB as GLB, 32 kB with four inks; looks smooth."""

MEDIA_TYPES = {mesh_format.media_type: name for name, mesh_format in FORMATS.items()}
"""Names of the formats by media type, the preferred one first."""

SUFFIXES = {mesh_format.suffix.removeprefix("."): name for name, mesh_format in FORMATS.items()}
"""Names of the formats by suffix, without the dot."""

_INLINE_TRIANGLES = {"glb": 4000, "gltf": 1000, "ply": 4000, "stl": 4000}
"""Levels up to this are read and encoded in about a millisecond, which the event loop can spare."""

_ENTRY_BYTES = 1024
"""Rough cost of a mesh in the cache besides its content: key, header fields, bookkeeping."""


class Wanted(NamedTuple):
    """Which level is asked for: by its triangles or by limits to its error, else the default.

    Attributes
    ----------
    triangles : int or None
        The most triangles that it may have.
    max_error : float or None
        The largest distance from the full boundary that is accepted, in the space's unit.
    max_mismatch : float or None
        The largest mismatch that is accepted.
    """

    triangles: int | None = None
    max_error: float | None = None
    max_mismatch: float | None = None

    @property
    def limits(self) -> Bounds | None:
        """The limits to the error; None if there are none."""
        if self.max_error is None and self.max_mismatch is None:
            return None
        return Bounds(
            inf if self.max_error is None else self.max_error,
            inf if self.max_mismatch is None else self.max_mismatch,
        )


class MeshKey(NamedTuple):
    """What an encoded mesh is: a level of a gamut in a format, as it is or in a content coding."""

    gamut_id: str
    triangles: int
    format_name: str
    coding: str = IDENTITY


@dataclass(frozen=True)
class EncodedMesh:
    """A mesh as it is sent.

    Attributes
    ----------
    body : bytes
        The file.
    etag : str
        Strong entity tag: the digest of the body.
    headers : list of pairs of bytes
        The header fields of a 200 response.
    """

    body: bytes = field(repr=False)
    etag: str
    headers: list[tuple[bytes, bytes]] = field(repr=False)

    @classmethod
    def of(
        cls,
        body: bytes,
        media_type: str,
        triangles: int,
        vertices: int,
        bounds: Bounds | None = None,
    ) -> EncodedMesh:
        """Return the encoded mesh of a file with its counts, and what is promised of it, if so."""
        etag = entity_tag(body)
        fields = {
            "content-type": media_type,
            "content-length": str(len(body)),
            "gamut-triangles": str(triangles),
            "gamut-vertices": str(vertices),
            "etag": etag,
            "cache-control": IMMUTABLE,
            "vary": "Accept, Accept-Encoding",
        }
        headers = [(name.encode(), value.encode()) for name, value in fields.items()]
        mesh = cls(body, etag, headers)
        return mesh if bounds is None else mesh.promising(bounds)

    def promising(self, bounds: Bounds) -> EncodedMesh:
        """Return the mesh with other promises: the same content, so the same entity tag."""
        own = {
            b"gamut-max-error": b"%g" % bounds.distance,
            b"gamut-max-mismatch": b"%g" % bounds.mismatch,
        }
        headers = [item for item in self.headers if item[0] not in own]
        return EncodedMesh(self.body, self.etag, [*headers, *own.items()])

    def compressed(self, coding: str) -> EncodedMesh:
        """Return the mesh in a content coding: other bytes, so another entity tag."""
        body = compressed(self.body, coding)
        etag = entity_tag(body)
        own = {b"content-length": str(len(body)).encode(), b"etag": etag.encode()}
        headers = [(name, own.get(name, value)) for name, value in self.headers]
        return EncodedMesh(body, etag, [*headers, (b"content-encoding", coding.encode())])

    def response(self, if_none_match: str | None) -> tuple[int, list[tuple[bytes, bytes]], bytes]:
        """Return status, header fields and content: 304 if the client has it already."""
        if if_none_match is not None and matches(if_none_match, self.etag):
            kept = [item for item in self.headers if not item[0].startswith(b"content-")]
            return 304, kept, b""
        return 200, self.headers, self.body


class Meshes:
    """The encoded meshes of a library's gamuts.

    Parameters
    ----------
    library : Library
        Where the gamuts are.
    capacity : int
        Bytes of memory for encoded meshes.
    """

    def __init__(self, library: Library, capacity: int) -> None:
        self._library = library
        self._cache: ByteBoundedCache[MeshKey, EncodedMesh] = ByteBoundedCache(capacity)
        self._choices = Choices(library)
        self._encoding: SingleFlight[MeshKey, EncodedMesh] = SingleFlight()

    @property
    def cache(self) -> ByteBoundedCache[MeshKey, EncodedMesh]:
        """The meshes that are kept."""
        return self._cache

    @property
    def choices(self) -> Choices:
        """Which levels keep limits."""
        return self._choices

    def at_once(
        self, gamut_id: str, wanted: Wanted, format_name: str, coding: str = IDENTITY
    ) -> EncodedMesh | None:
        """Return a mesh if it is there, or can be there within a millisecond.

        Parameters
        ----------
        gamut_id : str
            The gamut.
        wanted : Wanted
            Without a count or a limit: `DEFAULT_TRIANGLES`, or all if there are fewer.
        format_name : str
            A key of `FORMATS`.
        coding : str
            One of `CODINGS`, or `IDENTITY`.

        Returns
        -------
        EncodedMesh or None
            None for all else: the gamut is not open, its level not unpacked or not found yet, the
            mesh is large, or there is no such mesh.
        """
        opened = self._library.opened(gamut_id)
        if wanted.limits is not None:
            level = self._choices.known(gamut_id, wanted.limits)
            if level is None:
                return None
            mesh = self._at_hand(opened, MeshKey(gamut_id, level.triangles, format_name, coding))
            return None if mesh is None else mesh.promising(level.bounds)
        if opened is None:
            # Whether an odd count is above the largest level only the gamut itself can tell.
            if wanted.triangles is None or wanted.triangles % 2:
                return None
            return self._cache.get(MeshKey(gamut_id, wanted.triangles, format_name, coding))
        count = _count(opened.gamut.history.triangles, wanted)
        if not MINIMUM_TRIANGLES <= count <= opened.gamut.history.triangles:
            return None
        return self._at_hand(opened, _key(gamut_id, count, format_name, coding))

    async def mesh(
        self, gamut_id: str, wanted: Wanted, format_name: str, coding: str = IDENTITY
    ) -> EncodedMesh:
        """Return a mesh; parameters as for `at_once`.

        Raises
        ------
        GamutNotStoredError
            There is no such gamut, or it is damaged.
        TriangleCountError
            The gamut has no such level.
        """
        mesh = self.at_once(gamut_id, wanted, format_name, coding)
        if mesh is not None:
            return mesh
        opened = await self._library.gamut(gamut_id)
        if wanted.limits is None:
            count = _count(opened.gamut.history.triangles, wanted)
            if not MINIMUM_TRIANGLES <= count <= opened.gamut.history.triangles:
                opened.gamut.history.level(count)  # raises, and knows best what to say
            return await self._encoded_once(opened, _key(gamut_id, count, format_name, coding))
        level = await self._choices.found(opened, wanted.limits)
        key = MeshKey(gamut_id, level.triangles, format_name, coding)
        mesh = self._at_hand(self._library.opened(gamut_id), key)
        if mesh is None:
            mesh = await self._encoded_once(opened, key)
        return mesh.promising(level.bounds)

    def most_triangles(self, record: Record, wanted: Wanted) -> int:
        """Return how many triangles a mesh of a gamut may have, told without making it.

        A count that is asked for is returned as it is, whether or not there is such a level.
        """
        if wanted.limits is not None:
            return self._choices.at_most(record, wanted.limits)
        return _count(record.description["counts"]["triangles"], wanted)

    def discard_gamut(self, gamut_id: str) -> None:
        """Forget all meshes of a gamut, and which of its levels keep limits."""
        self._cache.discard_where(lambda key: key.gamut_id == gamut_id)
        self._choices.discard(gamut_id)

    def _at_hand(self, opened: OpenGamut | None, key: MeshKey) -> EncodedMesh | None:
        """Return a mesh that is kept, or a small one of an open gamut whose level is unpacked."""
        mesh = self._cache.get(key)
        small = key.triangles <= _INLINE_TRIANGLES.get(key.format_name, 0)
        if mesh is not None or opened is None or not small:
            return mesh
        if not opened.gamut.history.is_unpacked(key.triangles):
            return None
        return self._encoded_and_kept(opened, key)

    def _encoded_and_kept(self, opened: OpenGamut, key: MeshKey) -> EncodedMesh:
        plain = key._replace(coding=IDENTITY)
        mesh = self._cache.get(plain)
        if mesh is None:
            with timed("encode"):
                mesh = _encoded(opened, plain)
            self._keep(plain, mesh)
        if key.coding != IDENTITY:
            with timed("compress"):
                mesh = mesh.compressed(key.coding)
            self._keep(key, mesh)
        return mesh

    async def _encoded_once(self, opened: OpenGamut, key: MeshKey) -> EncodedMesh:
        return await self._encoding.value(key, lambda: self._encode_and_keep(opened, key))

    async def _encode_and_keep(self, opened: OpenGamut, key: MeshKey) -> EncodedMesh:
        if key.coding == IDENTITY:
            await self._library.unpack(opened, key.triangles)
            with timed("encode"):
                mesh = await self._library.in_thread(_encoded, opened, key)
        else:
            # By way of the content as it is, which others are likely to ask for as well.
            mesh = await self.mesh(key.gamut_id, Wanted(key.triangles), key.format_name)
            with timed("compress"):
                mesh = await self._library.in_thread(mesh.compressed, key.coding)
        # A gamut that was deleted meanwhile leaves nothing behind in memory.
        if self._library.opened(key.gamut_id) is opened:
            self._keep(key, mesh)
        return mesh

    def _keep(self, key: MeshKey, mesh: EncodedMesh) -> None:
        self._cache.put(key, mesh, len(mesh.body) + _ENTRY_BYTES)


def _count(largest: int, wanted: Wanted) -> int:
    if wanted.triangles is not None:
        return wanted.triangles
    return min(DEFAULT_TRIANGLES, largest)


def _promised(opened: OpenGamut, triangles: int) -> Bounds | None:
    """Return what the error curve promises of a level; None of a level between its own."""
    for level in opened.gamut.description["levels"]:
        if level["triangles"] == triangles and {"distance_bound", "mismatch_bound"} <= set(level):
            return Bounds(level["distance_bound"], level["mismatch_bound"])
    return None


def _key(gamut_id: str, count: int, format_name: str, coding: str) -> MeshKey:
    # Closed meshes have an even count: an odd one names the same level as the even one below it.
    return MeshKey(gamut_id, count - count % 2, format_name, coding)


def _encoded(opened: OpenGamut, key: MeshKey) -> EncodedMesh:
    mesh = opened.gamut.level(key.triangles)
    body = mesh_file(mesh, key.format_name, opened.provenance, opened.space)
    media_type = FORMATS[key.format_name].media_type
    bounds = _promised(opened, len(mesh.faces))
    return EncodedMesh.of(body, media_type, len(mesh.faces), len(mesh.vertices), bounds)
