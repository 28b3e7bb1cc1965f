"""Black-point compensation: light is scaled so that the black of one medium becomes another's.

ISO 18619:2015; Adobe Systems, "Adobe Systems' Implementation of Black Point Compensation" (2006).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces.cielab import ICC_D50

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["compensate_black", "luminance_of_black"]

LIGHTEST_BLACK = 0.184187
"""Luminance of L* 50, to which both publications limit blacks."""


def luminance_of_black(xyz: FloatArray) -> float:
    """Return the luminance of the neutral that stands for a black; xyz is (3,), and white has 1."""
    return float(np.clip(xyz[1], 0.0, LIGHTEST_BLACK))


def compensate_black(xyz: FloatArray, source: float, destination: float) -> FloatArray:
    """Return tristimulus values (n, 3) with another black; white is unchanged.

    Values are relative to D50, with Y = 1 for the white. `source` and `destination` are the
    luminances of the two blacks, which are neutral.
    """
    scale = (1.0 - destination) / (1.0 - source)
    return scale * xyz + (1.0 - scale) * ICC_D50
