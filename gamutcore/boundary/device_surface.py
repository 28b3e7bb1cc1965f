"""The device surface: the image of the faces of a device's cube, as a star-shaped boundary.

The surface of a device of three channels is the boundary itself if all of its triangles see the
centre. In all other cases the boundary is the radial envelope: folded surfaces, devices of more
channels, whose faces cross, and centres that do not see everything.

The best centre is the deepest point of the star-kernel of the device's surface: all faces see it
from inside, so every ray from it meets the surface once. The star-kernel of folded surfaces is
empty. The centre is then the point from which the least area is hidden. A face is hidden if it
turns its back to the point. Of several such points, the deepest inside of the other faces is taken.

The faces of more than three channels cross. From the automatic centre of the points, nothing of
their outside is hidden (``docs/decisions/centre.md`` has the figures). But a tight ink limit can
leave that centre outside of the faces, or close to them. A deep point then replaces it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.boundary.centre import (
    Centre,
    Planes,
    automatic_centre,
    bounds,
    centre_on_grid,
    face_planes,
    points_on_grid,
    star_kernel_point,
)
from gamutcore.boundary.modified_convex_hull import Boundary, Cuts, coherent_order
from gamutcore.boundary.radial_envelope import COARSE, radial_envelope, radial_volume
from gamutcore.errors import BoundaryError, CentreError
from gamutcore.geometry import (
    TriangleMesh,
    curve_positions,
    faces_not_seeing_centre,
    nearest_grid_points,
)
from gamutcore.kernels import kernel

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from gamutcore.colours import SurfaceFaces

FLATNESS = 1e-6
"""A surface is flat if it encloses less than this share of the cube of its extent."""

SEARCH = 2.0**-4
"""First step of searches along the axes, in extents of the surface."""

HALVINGS = 8
"""Number of times that the step of these searches is halved."""

SHALLOW = 0.5
"""Share of its depth in the convex hull that a centre must have within the faces. Presses without a
tight ink limit have 0.95 to 0.99."""


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
        boundary = _boundary_about(middle, rounded, faces, step)
    else:
        deepest = device_centre(rounded, faces.corners) if faces.closed else None
        boundary = deepest and _boundary_about(
            nearest_grid_points(deepest.point, step), rounded, faces, step
        )
        if boundary is None:
            preferred = automatic_centre(rounded, step)  # raises the error if they are flat
            enclosed = enclosed_centre(rounded, faces.corners, preferred)
            middle = nearest_grid_points(enclosed.point, step)
            boundary = _boundary_about(middle, rounded, faces, step)
    if boundary is not None:
        return boundary
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


def device_centre(
    points: FloatArray, faces: IndexArray, position: FloatArray | None = None
) -> Centre | None:
    """Return the centre of the gamut of a device with three channels.

    The faces form a closed surface, oriented outwards. With `given`, that centre is examined
    instead of a search for the best one. The result is None if the faces enclose almost no volume.
    """
    lowest, highest = points.min(axis=0), points.max(axis=0)
    middle, extent = (lowest + highest) / 2, float((highest - lowest).max())
    planes = face_planes(np.ascontiguousarray(points - middle), faces)
    bounded = np.isfinite(planes.offsets)
    volume = float((planes.offsets[bounded] * planes.areas[bounded]).sum()) / 3
    if not extent > 0 or not volume > FLATNESS * extent**3:
        return None
    if position is None:
        kernel_point = star_kernel_point(planes, extent)
        if kernel_point.margin > 0:
            return Centre(kernel_point.point + middle, "star-kernel", kernel_point.margin)
        starts = (kernel_point.point, np.zeros(3))
        point = _pattern_search(lambda at: (hidden_area(planes, at),), starts, extent)
    else:
        point = position - middle
    seen = planes.offsets - planes.normals @ point > 0
    visible = Planes(
        np.ascontiguousarray(planes.normals[seen]), planes.offsets[seen], planes.areas[seen]
    )
    hidden = max(0.0, 1.0 - float(visible.areas.sum() / planes.areas.sum()))
    if position is None:
        kernel_point = star_kernel_point(visible, extent)
        return Centre(kernel_point.point + middle, "least hidden area", kernel_point.margin, hidden)
    depth = float((visible.offsets - visible.normals @ point).min(initial=np.inf))
    return Centre(position, "the option centre", depth, hidden)


def enclosed_centre(points: FloatArray, faces: IndexArray, start: Centre) -> Centre:
    """Return a centre well inside of faces that may cross and have any orientation.

    The result is `start` if the faces surround it and it is deep enough. Otherwise it is the point
    with the largest distance to the outermost faces that a search along the axes finds.
    """
    faces = np.ascontiguousarray(faces)
    depth = radial_volume(points, faces, start.point, COARSE).depth
    if depth >= SHALLOW * (start.depth or 0.0) and depth > 0.0:
        return start

    def shallowness(point: FloatArray) -> tuple[float, float]:
        volume = radial_volume(points, faces, point, COARSE)
        return volume.uncovered, -volume.depth

    extent = float((points.max(axis=0) - points.min(axis=0)).max())
    point = _pattern_search(shallowness, (start.point, points.mean(axis=0)), extent)
    return Centre(point, "deep point within the faces", -shallowness(point)[1])


def _pattern_search(
    measure: Callable[[FloatArray], tuple[float, ...]],
    starts: tuple[FloatArray, ...],
    extent: float,
) -> FloatArray:
    """Search for the point of least measure along the axes, with ever smaller steps.

    Hooke and Jeeves, "Direct search" solution of numerical and statistical problems, JACM 8 (1961).
    """
    measures = [measure(start) for start in starts]
    least = min(measures)
    point = starts[measures.index(least)]
    step = SEARCH * extent
    for _ in range(HALVINGS):
        improved = True
        while improved:
            improved = False
            for move in np.vstack([np.eye(3), -np.eye(3)]) * step:
                trial_measure = measure(point + move)
                if trial_measure < least:
                    point, least, improved = point + move, trial_measure, True
        step /= 2
    return point


@kernel
def hidden_area(planes: Planes, point: FloatArray) -> float:
    """Return the area of the faces that a point is not inside of."""
    normals, offsets, hidden = planes.normals, planes.offsets, 0.0
    for face in range(len(offsets)):
        room = offsets[face] - (
            normals[face, 0] * point[0] + normals[face, 1] * point[1] + normals[face, 2] * point[2]
        )
        if room <= 0.0:
            hidden += planes.areas[face]
    return hidden
