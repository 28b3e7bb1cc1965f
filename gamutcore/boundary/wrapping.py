"""The boundary of a device's gamut, with the choices that depend on the device's surface.

Most boundary methods only know points. Here, the faces of the device cube between these points
determine the centre, γ, and the volume within the device's own surface.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from gamutcore.boundary.centre import Centre, centre_of_points
from gamutcore.boundary.device_surface import device_centre, enclosed_centre
from gamutcore.boundary.methods import compute_boundary, resolve_method
from gamutcore.boundary.modified_convex_hull import has_fallen, surface_gammas
from gamutcore.boundary.radial_envelope import FINE, radial_volume
from gamutcore.errors import BoundaryError, CentreError
from gamutcore.number_text import number_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import ArrayLike

    from gamutcore.arrays import FloatArray
    from gamutcore.boundary.modified_convex_hull import Boundary
    from gamutcore.characterisation.samples import JSON
    from gamutcore.colours import SurfaceFaces

__all__ = ["Wrapping", "raise_wrapping", "wrap_colours"]

NOTICEABLE = 0.005
"""Relative difference between the volumes of the boundary and of the device's surface, from which a
warning is given."""


class Wrapping(NamedTuple):
    """A boundary, with its choices and warnings.

    Attributes
    ----------
    boundary : Boundary
    choices : dict
        Method, centre and γ for the provenance, JSON-able.
    device_volume : float or None
        Volume that the sampled surface of the device encloses; None without a device model.
    warnings : list of str
    """

    boundary: Boundary
    choices: dict[str, JSON]
    device_volume: float | None
    warnings: list[str]


def wrap_colours(
    points: FloatArray,
    faces: SurfaceFaces | None,
    method: str,
    centre: ArrayLike | Literal["auto"],
    parameters: Mapping[str, Any],
) -> Wrapping:
    """Return the boundary that a method wraps around the colours of a device.

    Parameters
    ----------
    points : (n, 3) float64
    faces : SurfaceFaces or None
        Triangles of the points over the surface of the device's cube. None for scattered points.
    method : str
        A key of `BOUNDARIES`. ``auto`` takes the modified convex hull, with a warning, if the
        device's surface cannot be the boundary.
    centre : (3,) array_like or "auto"
    parameters : mapping of str to object
        Options of the method. The γ "auto" is explained at
        `gamutcore.boundary.modified_convex_hull`.

    Returns
    -------
    Wrapping

    Raises
    ------
    OptionError, InvalidPointsError, BoundaryError
        As of `compute_boundary`.
    """
    taken, options = resolve_method(method, faces, parameters)
    warnings = []
    try:
        chosen, boundary, volume = _wrap_about(points, faces, taken, centre, options)
    except (BoundaryError, CentreError) as error:
        if method != "auto" or taken != "device-surface":
            raise
        taken, options = resolve_method(method, None, {"gamma": "auto", **parameters})
        chosen, boundary, volume = _wrap_about(points, faces, taken, centre, options)
        warnings.append(
            "The boundary is the modified convex hull, because the device's surface cannot be the"
            f" boundary: {error.message}"
        )
    described: dict[str, JSON] = {"from": chosen.origin}
    if chosen.depth is not None:
        described["depth"] = round(chosen.depth, 4)
    if faces is not None and faces.closed:
        described["hidden_area"] = round(chosen.hidden, 6)
    choices: dict[str, JSON] = {"method": taken, "centre": described}
    if "gamma" in options:
        choices["gamma"] = boundary.gamma
    return Wrapping(
        boundary, choices, volume, warnings + _volume_warnings(boundary.mesh.volume, volume)
    )


def raise_wrapping(wrapping: Wrapping, points: FloatArray, faces: SurfaceFaces) -> Wrapping:
    """Return the device surface about the same centre with folds among its triangles.

    Raises
    ------
    BoundaryError
        The folds pass through each other too often.
    """
    middle = wrapping.boundary.centre
    boundary = compute_boundary(points, "device-surface", middle, faces)
    volume = radial_volume(points, faces.corners, middle, FINE).volume
    warnings = _volume_warnings(boundary.mesh.volume, volume)
    return Wrapping(boundary, wrapping.choices, volume, warnings)


def _wrap_about(
    points: FloatArray,
    faces: SurfaceFaces | None,
    method: str,
    centre: ArrayLike | Literal["auto"],
    parameters: Mapping[str, Any],
) -> tuple[Centre, Boundary, float | None]:
    """Return the centre that a method is given, and the result of `_wrap` about it."""
    chosen = _centre(points, faces, centre)
    try:
        return chosen, *_wrap(points, faces, method, chosen, parameters)
    except CentreError:
        if not isinstance(centre, str):
            raise
        # a folded surface may hide the least from a point outside of the hull
        chosen = _enclosed(points, faces)
        return chosen, *_wrap(points, faces, method, chosen, parameters)


def _wrap(
    points: FloatArray,
    faces: SurfaceFaces | None,
    method: str,
    centre: Centre,
    parameters: Mapping[str, Any],
) -> tuple[Boundary, float | None]:
    """Return the boundary about a centre, and the volume within the device's surface."""
    if faces is None:
        boundary = compute_boundary(points, method, centre.point, None, **parameters)
        return boundary, None
    volume = _device_volume(points, faces, centre)
    gammas: Iterable[object] = [parameters.get("gamma")]
    if gammas == ["auto"]:
        gammas = surface_gammas(len(points), closed=faces.closed)
    for gamma in gammas:
        changed = {**parameters, "gamma": gamma} if "gamma" in parameters else parameters
        boundary = compute_boundary(points, method, centre.point, faces, **changed)
        if not has_fallen(boundary.mesh.volume, volume, len(points)):
            break
    return boundary, volume


def _centre(
    points: FloatArray, faces: SurfaceFaces | None, centre: ArrayLike | Literal["auto"]
) -> Centre:
    """The given centre, or the best one that the faces or the points allow."""
    is_given = not isinstance(centre, str)
    if faces is not None and faces.closed:
        position = np.asarray(centre, np.float64) if is_given else None
        device_middle = device_centre(points, faces.corners, position)
        if device_middle is not None:
            return device_middle
    if is_given:
        return Centre(np.asarray(centre, np.float64), "the option centre")
    return _enclosed(points, faces)


def _enclosed(points: FloatArray, faces: SurfaceFaces | None) -> Centre:
    """The automatic centre of points, or a deeper one if the faces do not surround it."""
    automatic = centre_of_points(points)
    return automatic if faces is None else enclosed_centre(points, faces.corners, automatic)


def _device_volume(points: FloatArray, faces: SurfaceFaces, centre: Centre) -> float:
    """Volume within the faces: exact if all see the centre, else by rays from the centre."""
    if not faces.closed or centre.hidden > 0:
        return radial_volume(points, faces.corners, centre.point, FINE).volume
    first, second, third = (points[faces.corners[:, corner]] - centre.point for corner in range(3))
    return float(np.einsum("ij,ij->", first, np.cross(second, third))) / 6


def _volume_warnings(enclosed: float, volume: float | None) -> list[str]:
    difference = enclosed / volume - 1 if volume else 0.0
    if abs(difference) <= NOTICEABLE:
        return []
    part, more = abs(difference), "larger" if difference > 0 else "smaller"
    percent = number_text(100 * part, 2)
    return [f"The gamut is {percent} % {more} than the device's sampled surface encloses."]
