"""The boundary methods by name: the function that wraps the colours, and its options.

This table is the only list of the methods, their options and defaults. A new method is
a new entry. The vertices of every boundary get their device values here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from gamutcore.boundary.device_surface import device_surface_boundary
from gamutcore.boundary.modified_convex_hull import Boundary, modified_convex_hull
from gamutcore.boundary.published import SEGMENTS, segment_maxima, usv
from gamutcore.errors import OptionError
from gamutcore.geometry import DeviceValues

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike

    from gamutcore.colours import SurfaceFaces


class Method(NamedTuple):
    """A boundary method.

    `wrap` maps points, ``centre`` and the method's options, as keywords, to a `Boundary`.
    `defaults` has these options. With `needs_faces`, `wrap` also takes the faces of the device's
    cube as ``faces``.
    """

    wrap: Callable[..., Boundary]
    defaults: Mapping[str, object]
    needs_faces: bool = False


BOUNDARIES: dict[str, Method] = {
    "auto": Method(modified_convex_hull, {"gamma": "auto"}),
    "modified-convex-hull": Method(modified_convex_hull, {"gamma": "auto"}),
    "segment-maxima": Method(segment_maxima, {"segments": SEGMENTS}),
    "device-surface": Method(device_surface_boundary, {}, needs_faces=True),
    "usv": Method(usv, {"gamma": 0.05, "basis": "icosahedron", "subdivisions": 4}),
}
"""Boundary methods by the value of the option ``boundary``. See `resolve_method` for ``auto``."""


def resolve_method(
    method: str, faces: SurfaceFaces | None, parameters: Mapping[str, Any]
) -> tuple[str, dict[str, Any]]:
    """Return the method that ``auto`` stands for, and its options; other methods as they are.

    The device's own surface is the boundary where it is known. A given γ asks for the modified
    convex hull, because the device's surface has no γ.
    """
    if method != "auto":
        return method, dict(parameters)
    if faces is not None and parameters.get("gamma", "auto") == "auto":
        return "device-surface", {}
    return "modified-convex-hull", dict(parameters)


def compute_boundary(
    points: ArrayLike,
    method: str,
    centre: ArrayLike | Literal["auto"] = "auto",
    faces: SurfaceFaces | None = None,
    **parameters: Any,  # noqa: ANN401  # the method knows
) -> Boundary:
    """Return the closed surface that a method wraps around points.

    Parameters
    ----------
    points : (n, 3) array_like
        Colours, in coordinates of the colour space.
    method : str
        A key of `BOUNDARIES`.
    centre : (3,) array_like or "auto", optional
        Origin of the radii.
    faces : SurfaceFaces, optional
        Triangles between the points that cover the surface of a device's cube.
    **parameters
        Options of the method, as `gamutcore.Options` has checked them; the others have their
        defaults.

    Returns
    -------
    Boundary
        A vertex that is not one of the points has the source −1. γ is 0 for a method without it.

    Raises
    ------
    OptionError
        The method needs faces and none are given, or the centre is not three numbers.
    InvalidPointsError, BoundaryError
        No valid surface can be wrapped around the points.

    Examples
    --------
    >>> cube = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    >>> compute_boundary(cube, "modified-convex-hull", gamma=1).mesh.triangles
    12
    """
    method, parameters = resolve_method(method, faces, parameters)
    chosen = BOUNDARIES[method]
    arguments: dict[str, Any] = {**chosen.defaults, **parameters}
    if chosen.needs_faces:
        if faces is None:
            raise OptionError.not_applicable(
                "boundary",
                method,
                "the data gives no device model of three or more channels whose faces can be"
                " sampled",
                "Send a profile, or samples with device values that a model can be fitted to; with"
                " many inks, also raise surface_samples. Or give another boundary.",
            )
        arguments["faces"] = faces
    return chosen.wrap(points, centre=centre, **arguments)


def vertex_device_values(
    boundary: Boundary, points: ArrayLike, device: ArrayLike, channels: tuple[str, ...]
) -> DeviceValues:
    """Return the device values of the vertices of a boundary.

    Parameters
    ----------
    boundary : Boundary
    points : (n, 3) array_like
        The colours that the boundary was wrapped around.
    device : (n, k) array_like
        Their device values, 0 to 1.
    channels : tuple of str
        Names of the k channels.

    Returns
    -------
    DeviceValues
        float64. A vertex that is one of the points has the point's values. A vertex on the line
        between two points of the device's surface has the values between theirs. Another
        constructed vertex (source −1) has the values of the nearest point: very different mixtures
        of inks can have nearly the same colour, so values are not interpolated there.
    """
    point_values = np.asarray(device, np.float64)
    if boundary.cuts is not None:
        start, end = (
            point_values[boundary.cuts.ends[:, 0]],
            point_values[boundary.cuts.ends[:, 1]],
        )
        between = start + boundary.cuts.share[:, np.newaxis] * (end - start)
        return DeviceValues(tuple(channels), np.clip(between, 0.0, 1.0))
    sources = boundary.sources.copy()
    constructed = sources < 0
    if constructed.any():
        from scipy.spatial import cKDTree  # noqa: PLC0415  # 0.15 s and 15 MB; few boundaries need it

        tree = cKDTree(np.asarray(points, np.float64))
        vertices = boundary.mesh.vertices[constructed].astype(np.float64)
        sources[constructed] = tree.query(vertices)[1]
    # values on a face of the device cube may be off it by rounding
    values = np.clip(point_values[sources], 0.0, 1.0)
    return DeviceValues(tuple(channels), values)
