"""Device values of the vertices of a boundary, from the points that the vertices come from."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.mesh import DeviceValues

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.boundary.modified_convex_hull import Boundary

__all__ = ["vertex_device_values"]


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
    given = np.asarray(device, np.float64)
    if boundary.cuts is not None:
        start, end = given[boundary.cuts.ends[:, 0]], given[boundary.cuts.ends[:, 1]]
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
    values = np.clip(given[sources], 0.0, 1.0)
    return DeviceValues(tuple(channels), values)
