"""From a full boundary to the record of its decimation: checks the mesh and runs the kernel."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.corner_table import opposite_corners
from gamutcore.decimation.costs import cost_module
from gamutcore.decimation.record import Record, empty_record
from gamutcore.decimation.stages import Stage, joined
from gamutcore.decimation.star import surface_of
from gamutcore.decimation.watching import watched
from gamutcore.decimation.ways import course_of, way_down
from gamutcore.errors import DecimationError, MeshError
from gamutcore.grid import mesh_grid_step, nearest_grid_points
from gamutcore.star_shape import faces_not_seeing_centre

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from gamutcore.arrays import Float32Array, FloatArray, IndexArray
    from gamutcore.mesh import TriangleMesh

__all__ = ["Decimation", "decimated"]

UNIT_STEPS = 18
"""Binary logarithm of the grid's steps in the unit that decimation computes in: about the thickness
of the mesh, by how the grid is chosen."""


class Decimation(NamedTuple):
    """A boundary's way down to four triangles.

    Attributes
    ----------
    record : Record
        Every collapse, in the order in which it happened.
    vertex : (3 F,) int32
        Vertices at the corners of the boundary's faces after the last collapse.
    positions : (V, 3) float32
        Positions after the last collapse.
    centre : (3,) float64
        What every level is star-shaped about.
    step : float
        Of the grid that the positions of all levels lie on.
    volume_error : float or None
        How much the volume of any level differs from the full boundary's at most; None if the cost
        does not preserve it.
    """

    record: Record
    vertex: IndexArray
    positions: Float32Array
    centre: FloatArray
    step: float
    volume_error: float | None


def decimated(
    mesh: TriangleMesh,
    centre: ArrayLike,
    cost: str = "volume",
    *,
    progress: Callable[[float], None] | None = None,
) -> Decimation:
    """Decimate a boundary to four triangles and return the record of it.

    Parameters
    ----------
    mesh : TriangleMesh
        A closed, oriented mesh of genus 0, star-shaped about the centre when its positions
        are rounded to the grid of `gamutcore.grid`.
    centre : (3,) array_like
    cost : str, optional
        What makes a collapse cheap; one of `gamutcore.decimation.costs.COSTS`.
    progress : callable, optional
        Called with the part of the work that has been done, about, ten times a second, from another
        thread.

    Returns
    -------
    Decimation
        Every level on the way is a closed, oriented mesh of genus 0, star-shaped about the centre.

    Raises
    ------
    OptionError
        If there is no such cost.
    MeshError
        If the mesh is not closed, oriented, of genus 0 and star-shaped; says which.
    DecimationError
        If no edge can be collapsed validly although more than four triangles are left.
    """
    module = cost_module(cost)
    middle = np.asarray(centre, np.float64)
    _check_numbers(mesh, middle)
    step = mesh_grid_step(mesh.vertices)
    # a unit near the size of the mesh: products of nine coordinates must not vanish or overflow
    unit = step * 2.0**UNIT_STEPS
    delivered = np.ascontiguousarray(nearest_grid_points(mesh.vertices, step) / unit, np.float32)
    origin = middle / unit
    positions = delivered.astype(np.float64) - origin
    faces = np.ascontiguousarray(mesh.faces, np.int32)
    opposite = opposite_corners(faces, len(positions))
    _check(mesh, faces, opposite, positions)
    steps = len(positions) - 4
    record, course = empty_record(len(positions)), course_of(module.PLAN, len(positions))
    with watched(course.done, progress):
        # no name for the stage: its state is let go of when it is not needed any more
        passages = way_down(
            Stage(
                module.state(positions, faces),
                surface_of(positions, faces, opposite),
                delivered,
                origin,
                step / unit,
                np.arange(len(positions), dtype=np.int32),
                np.arange(len(faces), dtype=np.int32),
            ),
            module.PLAN,
            record,
            course,
        )
    record, vertex, delivered = joined(record, passages)
    if len(record.kept) < steps:
        raise DecimationError(
            "no edge could be collapsed validly with"
            f" {2 * (steps - len(record.kept)) + 4} triangles left",
            remedy="a boundary whose faces are less degenerate, or another centre",
        )
    for places in (record.position, record.shift, delivered):
        # by a power of two: nothing is rounded
        np.multiply(places, np.float32(unit), out=places)
    volume_error = None
    if module.PRESERVES_VOLUME:
        volume_error = float(passages[-1].stage.surface.deficit[1]) / 6.0 * unit**3
    return Decimation(record, vertex, delivered, middle, step, volume_error)


def _check_numbers(mesh: TriangleMesh, centre: FloatArray) -> None:
    if not (mesh.triangles and np.isfinite(mesh.vertices).all() and np.isfinite(centre).all()):
        raise MeshError(
            "the mesh has no faces, or coordinates that are not finite numbers",
            remedy="finite numbers",
        )


def _check(
    mesh: TriangleMesh, faces: IndexArray, opposite: IndexArray, positions: FloatArray
) -> None:
    """Refuse what is not a valid boundary, and say why."""
    vertices, triangles = len(mesh.vertices), mesh.triangles
    if (opposite < 0).any():
        face = int(np.flatnonzero(opposite < 0)[0]) // 3
        raise MeshError(
            f"the mesh is not closed and consistently oriented: face {face} has an edge without"
            " exactly one neighbour",
            where={"face": face},
            remedy="a closed mesh whose faces are all oriented outwards",
        )
    if triangles != 2 * vertices - 4 or triangles < 4:
        raise MeshError(
            f"{triangles} faces over {vertices} vertices are not a surface of genus 0",
            remedy=f"{2 * vertices - 4} faces: one closed piece without handles or unused vertices",
        )
    spoilt = faces_not_seeing_centre(positions, faces)
    if spoilt.size:
        raise MeshError(
            f"the mesh is not star-shaped about the centre: {spoilt.size} faces do not see it from"
            f" inside, the first of them face {spoilt[0]}",
            where={"face": int(spoilt[0])},
            remedy="a centre that all faces see from inside",
        )
