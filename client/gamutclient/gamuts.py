"""Gamuts on the service, with the methods of `gamutcore.Gamut`."""

from __future__ import annotations

import asyncio
import os
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from gamutclient.gamut_steps import GamutSteps, MeshLevel, RemoteGamut
from gamutclient.meshes import Mesh
from gamutclient.results import Intersection
from gamutclient.transport import awaiting, blocking, run, run_async

__all__ = ["AsyncGamut", "Gamut"]


class Gamut(RemoteGamut):
    """A gamut on the service. `Client` returns it.

    Attributes
    ----------
    description : dict
        What the service says about the gamut: id, options, provenance, counts, volume.

    Notes
    -----
    Colours in arguments are arrays (..., 3) in the space of the gamut, unless `space` names another
    one. Questions are answered on the level of `triangles`, the smallest within `max_error`, or by
    default one within 0.1 in CIELAB.
    """

    contains = blocking(GamutSteps.contains)
    tolerance = blocking(GamutSteps.tolerance)
    distance = blocking(GamutSteps.distance)
    classify = blocking(GamutSteps.classify)
    nearest = blocking(GamutSteps.nearest)
    map = blocking(GamutSteps.map)
    crossings = blocking(GamutSteps.crossings)
    cusps = blocking(GamutSteps.cusps)
    max_chroma = blocking(GamutSteps.max_chroma)
    slice = blocking(GamutSteps.slice)
    leaf = blocking(GamutSteps.leaf)
    leaves = blocking(GamutSteps.leaves)
    rings = blocking(GamutSteps.rings)
    slice_svg = blocking(GamutSteps.slice_svg)
    rings_svg = blocking(GamutSteps.rings_svg)
    picture = blocking(GamutSteps.picture)
    compare = blocking(GamutSteps.compare)
    coverage_of = blocking(GamutSteps.coverage_of)
    warnings_about = blocking(GamutSteps.warnings_about)
    intersection = blocking(GamutSteps.intersection)
    mesh_file = blocking(GamutSteps.mesh_file)
    to_bytes = blocking(GamutSteps.to_bytes)
    give_name = blocking(GamutSteps.give_name)
    delete = blocking(GamutSteps.delete)

    def mesh(self, triangles: int | None = None, **level: Unpack[MeshLevel]) -> Mesh:
        """Return a level as a mesh: of a triangle count, or within an error limit."""

        def load(format_name: str) -> bytes:
            return run(GamutSteps.mesh_file(self, format_name, triangles, **level), self.http)

        return replace(run(GamutSteps.mesh(self, triangles, **level), self.http), load=load)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the gamut to a file that `gamutcore.Gamut.load` reads, or to a page, ``.html``."""
        content = run(GamutSteps.file(self, Path(path).suffix), self.http)
        Path(path).write_bytes(content)

    def __and__(self, other: object) -> Intersection:
        """Return the intersection with another gamut: its volume, and its shares of both."""
        return self.intersection(other) if isinstance(other, RemoteGamut | str) else NotImplemented


class AsyncGamut(RemoteGamut):
    """A gamut on the service whose methods are coroutines. `AsyncClient` returns it.

    Attributes
    ----------
    description : dict
        As for `Gamut`.
    """

    contains = awaiting(GamutSteps.contains)
    tolerance = awaiting(GamutSteps.tolerance)
    distance = awaiting(GamutSteps.distance)
    classify = awaiting(GamutSteps.classify)
    nearest = awaiting(GamutSteps.nearest)
    map = awaiting(GamutSteps.map)
    crossings = awaiting(GamutSteps.crossings)
    cusps = awaiting(GamutSteps.cusps)
    max_chroma = awaiting(GamutSteps.max_chroma)
    slice = awaiting(GamutSteps.slice)
    leaf = awaiting(GamutSteps.leaf)
    leaves = awaiting(GamutSteps.leaves)
    rings = awaiting(GamutSteps.rings)
    slice_svg = awaiting(GamutSteps.slice_svg)
    rings_svg = awaiting(GamutSteps.rings_svg)
    picture = awaiting(GamutSteps.picture)
    compare = awaiting(GamutSteps.compare)
    coverage_of = awaiting(GamutSteps.coverage_of)
    warnings_about = awaiting(GamutSteps.warnings_about)
    intersection = awaiting(GamutSteps.intersection)
    mesh_file = awaiting(GamutSteps.mesh_file)
    mesh = awaiting(GamutSteps.mesh)
    to_bytes = awaiting(GamutSteps.to_bytes)
    give_name = awaiting(GamutSteps.give_name)
    delete = awaiting(GamutSteps.delete)

    async def save(self, path: str | os.PathLike[str]) -> None:
        """Write the gamut to a file that `gamutcore.Gamut.load` reads, or to a page, ``.html``."""
        content = await run_async(GamutSteps.file(self, Path(path).suffix), self.http)
        await asyncio.to_thread(Path(path).write_bytes, content)
