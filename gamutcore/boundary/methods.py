"""The boundary methods by name: the function that wraps the colours, and its options.

This table is the only list of the methods, their options and defaults. A new method is
a new entry.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from gamutcore.boundary.device_surface import device_surface_boundary
from gamutcore.boundary.modified_convex_hull import GAMMA, Boundary, modified_convex_hull
from gamutcore.boundary.segment_maxima import SEGMENTS, segment_maxima
from gamutcore.boundary.usv import usv
from gamutcore.errors import OptionError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike

    from gamutcore.colours.device.surface import SurfaceFaces

__all__ = ["BOUNDARIES", "GAMMA", "Method", "compute_boundary", "resolve_method"]


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
    "convex-hull": Method(modified_convex_hull, {"gamma": 1.0}),
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
        Options of the method; the others have their defaults.

    Returns
    -------
    Boundary
        A vertex that is not one of the points has the source −1. γ is 0 for a method without it.

    Raises
    ------
    OptionError
        A parameter is not accepted, or the method needs faces and none are given.
    InvalidPointsError, BoundaryError
        No valid surface can be wrapped around the points.

    Examples
    --------
    >>> cube = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    >>> compute_boundary(cube, "convex-hull").mesh.triangles
    12
    """
    method, parameters = resolve_method(method, faces, parameters)
    chosen = BOUNDARIES[method]
    given: dict[str, Any] = {**chosen.defaults, **parameters}
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
        given["faces"] = faces
    return chosen.wrap(points, centre=centre, **given)
