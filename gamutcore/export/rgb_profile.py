"""ICC profiles of RGB spaces, for pictures: a matrix and parametric curves, in version 4."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gamutcore.colours import (
    ICC_D50,
    RGB_CURVES,
    adaptation_matrix,
    primary_matrix,
    reference_white,
)
from gamutcore.export.icc_file import (
    COPYRIGHT,
    description_element,
    fixed_element,
    icc_file,
    parametric_element,
    xyz_element,
)

if TYPE_CHECKING:
    from gamutcore.references import Reference

__all__ = ["rgb_profile"]


def rgb_profile(reference: Reference) -> bytes:
    """Return the profile of an RGB space that is relative to its white, without a peak luminance.

    Colours are adapted to D50 by Bradford, as the profile states (ICC.1:2022, E.2).
    """
    adaptation = adaptation_matrix(reference_white(reference), ICC_D50, "Bradford")
    columns = (adaptation @ primary_matrix(reference)).T
    curve = reference.definition["curve"]
    parameters = RGB_CURVES[curve] if isinstance(curve, str) else (float(curve),)
    tags = {
        "desc": description_element(reference.name, 4),
        "cprt": description_element(COPYRIGHT, 4),
        "wtpt": xyz_element(ICC_D50),
        "chad": fixed_element(adaptation),
        **{f"{name}XYZ": xyz_element(xyz) for name, xyz in zip("rgb", columns, strict=True)},
        **dict.fromkeys(("rTRC", "gTRC", "bTRC"), parametric_element(parameters)),
    }
    return icc_file(4, "mntr", ("RGB ", "XYZ "), tags, "perceptual")
