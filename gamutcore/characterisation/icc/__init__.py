"""ICC profiles of versions 2, 4 and 5, and their transforms from device values to colours.

`icc_profile` reads the header and the tag table. `IccProfile.transform` reads the transform of a
rendering intent on request. Damage in other tags therefore does not matter.
"""

from gamutcore.characterisation.icc.profile import (
    IccProfile,
    icc_profile,
    looks_like_icc,
    near_d50,
    reduced_profile,
)
from gamutcore.characterisation.icc.transforms import CurveSet, Matrix, largest_output_sum

__all__ = [
    "CurveSet",
    "IccProfile",
    "Matrix",
    "icc_profile",
    "largest_output_sum",
    "looks_like_icc",
    "near_d50",
    "reduced_profile",
]
