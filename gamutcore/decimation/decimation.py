"""Decimation of a full boundary: checks of the mesh, scaling to the grid, and the record."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.corner_table import opposite_corners
from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.progress import report_progress
from gamutcore.decimation.record import Record
from gamutcore.decimation.stage import Grid, new_stage
from gamutcore.decimation.stages import join_records
from gamutcore.decimation.star import DEFICIT_LARGEST
from gamutcore.decimation.trials import progress_of, run_schedule
from gamutcore.errors import DecimationError, MeshError
from gamutcore.grid import mesh_grid_step, nearest_grid_points
from gamutcore.star_shape import faces_not_seeing_centre

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from gamutcore.arrays import Float32Array, FloatArray, IndexArray
    from gamutcore.mesh import TriangleMesh

__all__ = ["Decimation", "decimate"]

UNIT_STEPS = 18
"""Binary logarithm of the number of grid steps in the internal unit of length. By the choice of the
grid the unit is about the thickness of the mesh."""


class Decimation(NamedTuple):
    """A boundary's decimation to four triangles.

    Attributes
    ----------
    record : Record
        Every collapse, in order.
    vertex : (3 F,) int32
        Vertices at the corners of the boundary's faces after the last collapse.
    positions : (V, 3) float32
        Positions after the last collapse.
    centre : (3,) float64
        The centre that every level is star-shaped about.
    step : float
        Step of the grid that the positions of all levels lie on.
    volume_error : float or None
        Largest difference of the volume of a level from the volume of the full boundary; None if
        the cost does not preserve the volume.
    """

    record: Record
    vertex: IndexArray
    positions: Float32Array
    centre: FloatArray
    step: float
    volume_error: float | None


def decimate(
    mesh: TriangleMesh,
    centre: ArrayLike,
    cost: str = "volume",
    *,
    progress: Callable[[float], None] | None = None,
) -> Decimation:
    """Decimate a boundary to four triangles and return the record of all collapses.

    Parameters
    ----------
    mesh : TriangleMesh
        A closed, oriented mesh of genus 0. With its positions rounded to the grid of
        `gamutcore.grid`, it is star-shaped about the centre.
    centre : (3,) array_like
    cost : str, optional
        The error of a collapse; one of `gamutcore.decimation.COSTS`.
    progress : callable, optional
        Called with the approximate fraction of the work that is done, ten times a second, from
        another thread.

    Returns
    -------
    Decimation
        Every level is a closed, oriented mesh of genus 0, star-shaped about the centre.

    Raises
    ------
    OptionError
        If there is no such cost.
    MeshError
        If the mesh is not closed, oriented, of genus 0 and star-shaped. The message says which.
    DecimationError
        If no edge can be collapsed validly although more than four triangles are left.

    Examples
    --------
    >>> from gamutcore.boundary import modified_convex_hull
    >>> boundary = modified_convex_hull(np.random.default_rng(0).normal(size=(50, 3)))
    >>> decimation = decimate(boundary.mesh, boundary.centre)
    >>> len(decimation.record.kept) == len(boundary.mesh.vertices) - 4
    True
    """
    chosen = cost_named(cost)
    origin = np.asarray(centre, np.float64)
    _check_numbers(mesh, origin)
    step = mesh_grid_step(mesh.vertices)
    # a unit near the size of the mesh: products of nine coordinates must not vanish or overflow
    unit = step * 2.0**UNIT_STEPS
    on_grid = np.ascontiguousarray(nearest_grid_points(mesh.vertices, step) / unit, np.float32)
    positions = on_grid.astype(np.float64) - origin / unit
    faces = np.ascontiguousarray(mesh.faces, np.int32)
    opposite = opposite_corners(faces, len(positions))
    _check(mesh, faces, opposite, positions)
    work = progress_of(chosen, len(positions))
    with report_progress(work.fraction, progress):
        # the stage has no name here, so that its state can be freed before the last level
        results = run_schedule(
            new_stage(
                chosen.parameters,
                positions,
                faces,
                opposite,
                Grid(on_grid, origin / unit, float(step / unit)),
            ),
            chosen,
            work,
        )
    record, vertex, final = join_records(results)
    if results[-1].left > 4:
        raise DecimationError(
            f"no edge could be collapsed validly with {2 * results[-1].left - 4} triangles left",
            remedy="Give a boundary whose faces are less degenerate, or another centre.",
        )
    for places in (record.position, record.shift, final):
        # the unit is a power of two, so nothing is rounded
        np.multiply(places, np.float32(unit), out=places)
    volume_error = None
    if chosen.parameters.preserves_volume:
        deficit = results[-1].stage.surface.deficit[DEFICIT_LARGEST]
        volume_error = float(deficit) / 6.0 * unit**3
    return Decimation(record, vertex, final, origin, step, volume_error)


def _check_numbers(mesh: TriangleMesh, centre: FloatArray) -> None:
    if not (mesh.triangles and np.isfinite(mesh.vertices).all() and np.isfinite(centre).all()):
        raise MeshError(
            "the mesh has no faces, or coordinates that are not finite numbers",
            remedy="Give finite numbers.",
        )


def _check(
    mesh: TriangleMesh, faces: IndexArray, opposite: IndexArray, positions: FloatArray
) -> None:
    """Raise `MeshError` unless the mesh is a valid boundary."""
    vertices, triangles = len(mesh.vertices), mesh.triangles
    if (opposite < 0).any():
        face = int(np.flatnonzero(opposite < 0)[0]) // 3
        raise MeshError(
            f"the mesh is not closed and consistently oriented: face {face} has an edge without"
            " exactly one neighbour",
            where={"face": face},
            remedy="Give a closed mesh whose faces are all oriented outwards.",
        )
    if triangles != 2 * vertices - 4 or triangles < 4:
        raise MeshError(
            f"{triangles} faces over {vertices} vertices are not a surface of genus 0",
            remedy=f"Give {2 * vertices - 4} faces: one closed piece without handles or unused "
            "vertices.",
        )
    spoilt = faces_not_seeing_centre(positions, faces)
    if spoilt.size:
        raise MeshError(
            f"the mesh is not star-shaped about the centre: {spoilt.size} faces do not see it from"
            f" inside, the first of them face {spoilt[0]}",
            where={"face": int(spoilt[0])},
            remedy="Give a centre that all faces see from inside.",
        )
