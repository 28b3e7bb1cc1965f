"""The device surface: the image of the faces of a device's cube, as a star-shaped boundary.

The surface of a device of three channels is the boundary itself if all of its triangles see the
centre. In all other cases the boundary is the radial envelope: folded surfaces, devices of more
channels, whose faces cross, and centres that do not see everything.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.centre import automatic_centre, bounds, centre_on_grid, points_on_grid
from gamutcore.boundary.device_centre import device_centre, enclosed_centre
from gamutcore.boundary.envelope import radial_envelope
from gamutcore.boundary.insertion_order import curve_positions
from gamutcore.boundary.modified_convex_hull import Boundary, Cuts, coherent_order
from gamutcore.errors import BoundaryError, CentreError
from gamutcore.grid import nearest_grid_points
from gamutcore.mesh import TriangleMesh
from gamutcore.star_shape import faces_not_seeing_centre

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.colours.device.surface import SurfaceFaces

__all__ = ["device_surface_boundary"]


def device_surface_boundary(
    points: ArrayLike, faces: SurfaceFaces, centre: ArrayLike | Literal["auto"] = "auto"
) -> Boundary:
    """Return the outermost surface of the faces of a device's cube.

    Parameters
    ----------
    points : (n, 3) array_like
        Colours at the surface of the device's cube. They are first rounded to their grid.
    faces : SurfaceFaces
        Triangles between them; closed ones turned outwards.
    centre : (3,) array_like or "auto", optional
        Point that radii are taken from, rounded to the same grid. "auto" takes the centre of
        `device_centre` or `enclosed_centre`.

    Returns
    -------
    Boundary
        Vertices at which triangles cross have the source −1. γ is 0, because no power is used.

    Raises
    ------
    OptionError
        The centre is neither "auto" nor three numbers.
    InvalidPointsError
        The points are not an (n, 3) array of finite numbers below 10¹².
    TooFewPointsError, FlatPointsError, CentreError
        The faces enclose no volume, or the centre is not inside.
    BoundaryError
        The surface is not valid, which is a fault of the program.
    """
    rounded, step = points_on_grid(points)
    middle = centre_on_grid(centre, rounded, step)
    if middle is not None:
        found = _boundary_about(middle, rounded, faces, step)
    else:
        deepest = device_centre(rounded, faces.corners) if faces.closed else None
        found = deepest and _boundary_about(
            nearest_grid_points(deepest.point, step), rounded, faces, step
        )
        if found is None:
            preferred = automatic_centre(rounded, step)  # raises the error if they are flat
            enclosed = enclosed_centre(rounded, faces.corners, preferred)
            middle = nearest_grid_points(enclosed.point, step)
            found = _boundary_about(middle, rounded, faces, step)
    if found is not None:
        return found
    automatic_centre(rounded, step)  # raises the better error if the points are flat
    lowest, highest = bounds(rounded)
    raise CentreError(
        f"The centre {np.asarray(middle).tolist()} is not inside the faces of the device's cube,"
        f" which extend from {lowest.tolist()} to {highest.tolist()}.",
        where={"field": "centre"},
        remedy="Give a point inside the gamut, or another boundary.",
    )


def _boundary_about(
    middle: FloatArray, points: FloatArray, faces: SurfaceFaces, step: float
) -> Boundary | None:
    """Boundary about a centre on the grid; None if the faces do not surround it."""
    relative = np.ascontiguousarray(points - middle)
    if faces.closed and not faces_not_seeing_centre(relative, faces.corners).size:
        own = np.arange(len(points), dtype=np.int32)
        ends = np.column_stack([own, own])
        return _boundary(relative, middle, faces.corners, ends, np.zeros(len(own)))
    envelope = radial_envelope(relative, faces.corners, step)
    if not len(envelope.faces):
        return None
    if faces_not_seeing_centre(envelope.position, envelope.faces).size:
        raise BoundaryError(
            "The envelope of the device's faces is not star-shaped about the centre.",
            remedy="Give a centre well inside the gamut, or another boundary.",
        )
    return _boundary(envelope.position, middle, envelope.faces, envelope.ends, envelope.share)


def _boundary(
    relative: FloatArray,
    middle: FloatArray,
    faces: IndexArray,
    ends: IndexArray,
    share: FloatArray,
) -> Boundary:
    """Return a boundary in coherent order, given the points between which the vertices are."""
    corners, packed = coherent_order(faces, curve_positions(relative))
    vertices = (relative[corners] + middle).astype(np.float32)
    cuts = Cuts(ends[corners].astype(np.int64), share[corners])
    sources: LongArray = np.where(cuts.ends[:, 0] == cuts.ends[:, 1], cuts.ends[:, 0], -1)
    return Boundary(TriangleMesh(vertices, packed), middle, sources, 0.0, cuts)
