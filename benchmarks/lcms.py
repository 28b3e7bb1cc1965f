"""Little CMS by ctypes: colours of profiles, and its gamut boundary descriptor.

The evaluator and the descriptor are independent of `gamutcore`. The library is Debian's
``liblcms2-2``.
"""

from __future__ import annotations

import ctypes
import ctypes.util
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.common import FloatArray

_SPACES = {3: 4, 4: 6}
"""lcms2's number of the pixel space, PT_RGB and PT_CMYK, by channels."""

_LAB, _RELATIVE, _NO_OPTIMISATION = 10, 1, 0x0100


@cache
def _library() -> ctypes.CDLL:
    name = ctypes.util.find_library("lcms2")
    if name is None:
        raise ImportError("Little CMS is missing. Install liblcms2-2.")
    library = ctypes.CDLL(name)
    for function in ("OpenProfileFromFile", "CreateLab4Profile", "CreateTransform", "GBDAlloc"):
        getattr(library, f"cms{function}").restype = ctypes.c_void_p
    return library


def _pixels(space: int, channels: int) -> int:
    """Return the code of float64 pixels."""
    return 1 << 22 | space << 16 | channels << 3


def relative_lab(path: Path, device: FloatArray) -> FloatArray:
    """Return media-relative CIELAB colours of device values from 0 to 1, shape (n, channels)."""
    library, channels = _library(), device.shape[1]
    source = library.cmsOpenProfileFromFile(str(path).encode(), b"r")
    space = library.cmsCreateLab4Profile(None)
    transform = library.cmsCreateTransform(
        ctypes.c_void_p(source),
        ctypes.c_uint32(_pixels(_SPACES[channels], channels)),
        ctypes.c_void_p(space),
        ctypes.c_uint32(_pixels(_LAB, 3)),
        ctypes.c_uint32(_RELATIVE),
        ctypes.c_uint32(_NO_OPTIMISATION),
    )
    if not transform:
        raise ValueError(f"Little CMS cannot read the profile {path.name}.")
    # lcms2 counts ink in per cent
    rows = np.ascontiguousarray(device * (100.0 if channels == 4 else 1.0), np.float64)
    lab = np.empty((len(rows), 3))
    library.cmsDoTransform(
        ctypes.c_void_p(transform),
        ctypes.c_void_p(rows.ctypes.data),
        ctypes.c_void_p(lab.ctypes.data),
        ctypes.c_uint32(len(rows)),
    )
    return lab


def descriptor_volume(points: FloatArray, step: float = 3.0) -> float:
    """Return the volume that lcms2's gamut boundary descriptor of some colours contains.

    Counts the cells of a grid whose middle the descriptor contains.
    """
    library = _library()
    descriptor = ctypes.c_void_p(library.cmsGBDAlloc(None))
    for colour in points:
        library.cmsGDBAddPoint(descriptor, (ctypes.c_double * 3)(*colour))
    library.cmsGDBCompute(descriptor, ctypes.c_uint32(0))
    lowest, highest = points.min(axis=0), points.max(axis=0)
    axes = [np.arange(a + step / 2, b, step) for a, b in zip(lowest, highest, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = sum(
        library.cmsGDBCheckPoint(descriptor, (ctypes.c_double * 3)(*colour)) for colour in grid
    )
    library.cmsGBDFree(descriptor)
    return float(inside * step**3)
