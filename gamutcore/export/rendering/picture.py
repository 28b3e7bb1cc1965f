"""The picture of a mesh as PNG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gamutcore.arguments import finite_number
from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.errors import OptionError
from gamutcore.export.png import png
from gamutcore.export.rendering.raster import rasterise
from gamutcore.export.rendering.scene import VIEWS, camera, scene_triangles
from gamutcore.geometry import TriangleMesh

__all__ = [
    "BACKGROUNDS",
    "DEFAULT_SIZE",
    "LARGEST_PICTURE",
    "PICTURE_TRIANGLES",
    "SMALLEST_PICTURE",
    "mesh_picture",
]

SMALLEST_PICTURE, LARGEST_PICTURE = 16, 2048
"""Width and height in pixels."""

SAMPLES = 3
"""Samples of a pixel in each direction; one less above `SMOOTH_SIZE`."""

SMOOTH_SIZE = 1024

DEFAULT_SIZE = 800

PICTURE_TRIANGLES = 20_000
"""Triangles of a picture: no pixel shows an edge of them."""

BACKGROUNDS = ("white", "transparent")

SPEED = 3
"""Level of the compression: half the time of level 6, for pictures that are 5 % larger."""


def mesh_picture(
    mesh: TriangleMesh,
    space: ColourSpace = CIELAB,
    *,
    size: int = DEFAULT_SIZE,
    view: str | Sequence[float] = "standard",
    background: str = "white",
    axes: bool = True,
    texts: Mapping[str, str] | None = None,
) -> bytes:
    """Return a picture of a mesh as PNG.

    Parameters
    ----------
    mesh : TriangleMesh
        Closed.
    space : ColourSpace, optional
        Of its vertices.
    size : int, optional
        Width and height in pixels, 16 to 2048.
    view : str or (float, float), optional
        A key of `VIEWS`, or the hue and the elevation of the camera in degrees.
    background : {'white', 'transparent'}, optional
    axes : bool, optional
        Whether there are axes with labels.
    texts : mapping, optional
        Textual data of the file, as for `gamutcore.export.png.png`.

    Returns
    -------
    bytes
        The colours are those of the surface, as sRGB shows them; faces seen from the side are a
        little darker. The same mesh gives the same bytes on one platform.

    Raises
    ------
    OptionError
        An option is not accepted.
    """
    if not (isinstance(size, int) and SMALLEST_PICTURE <= size <= LARGEST_PICTURE):
        accepted = f"a whole number from {SMALLEST_PICTURE} to {LARGEST_PICTURE}"
        raise OptionError.refusal("size", size, accepted)
    if background not in BACKGROUNDS:
        raise OptionError.refusal("background", background, " or ".join(BACKGROUNDS))
    triangles = scene_triangles(mesh, space, camera(*_angles(view)), size, axes=axes)
    samples = SAMPLES if size <= SMOOTH_SIZE else SAMPLES - 1
    light = rasterise(triangles.corners, triangles.colours, size, samples)
    coverage = light[..., 3:]
    if background == "white":
        return png(_encoded(light[..., :3] + (1.0 - coverage)), SPEED, texts)
    colours = _encoded(light[..., :3] / np.where(coverage > 0.0, coverage, 1.0))
    alpha = np.rint(255.0 * coverage).astype(np.uint8)
    return png(np.concatenate([colours, alpha], axis=2), SPEED, texts)


def _angles(view: object) -> tuple[float, float]:
    """Return the hue and the elevation of the camera."""
    if isinstance(view, str) and view in VIEWS:
        return VIEWS[view]
    if isinstance(view, tuple | list) and len(view) == 2:
        azimuth, elevation = map(finite_number, view)
        if azimuth is not None and elevation is not None and abs(elevation) <= 90.0:
            return azimuth % 360.0, elevation
    accepted = f"{', '.join(VIEWS)}, or a hue and an elevation from -90 to 90 degrees"
    raise OptionError.refusal("view", view, accepted)


def _encoded(linear: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Return 8-bit sRGB (IEC 61966-2-1) of linear light."""
    steps = np.rint(np.clip(linear, 0.0, 1.0) * (len(_ENCODED) - 1)).astype(np.uint16)
    encoded: NDArray[np.uint8] = _ENCODED[steps]
    return encoded


def _table() -> NDArray[np.uint8]:
    linear = np.linspace(0.0, 1.0, 2**16)
    encoded = np.where(
        linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1.0 / 2.4) - 0.055
    )
    return np.rint(255.0 * encoded).astype(np.uint8)


_ENCODED = _table()
