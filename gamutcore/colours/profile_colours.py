"""Colours of device values by an ICC profile, for each rendering intent.

What is done after the profile's own transform follows the ICC's reference implementation: absolute
colorimetry scales XYZ by the media white, in all versions and classes; the perceptual intent of
profiles that do not have the version 4 reference medium's black point gets it by scaling.
Black-point compensation is never applied. See docs/decisions/icc-evaluator.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.cielab import ICC_D50, lab_to_xyz, xyz_to_lab

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.icc import IccProfile

__all__ = ["ProfileColours", "profile_colours"]

PERCEPTUAL_BLACK = np.array([0.00336, 0.0034731, 0.00287])
"""XYZ of the perceptual reference medium's black point (ICC.1:2022, 6.3.3, table 3)."""


@dataclass(frozen=True, eq=False)
class ProfileColours:
    """Colours by a profile, and what in it made them.

    Parameters
    ----------
    lab : (m, 3) float
        L*, a*, b*, relative to D50.
    tag : str
        The tag or tags of the transform.
    kind : str
        The type of the tag (``"mft1"``, ``"mft2"``, ``"mAB "``, ``"mpet"``); empty for curves.
    absolute : bool
        Whether the profile itself has colours as measured, so that nothing was scaled.
    warnings : tuple of str
        What stood in for something that is missing.
    """

    lab: FloatArray
    tag: str
    kind: str
    absolute: bool
    warnings: tuple[str, ...]


def profile_colours(profile: IccProfile, device: FloatArray, intent: str) -> ProfileColours:
    """Return CIELAB colours of device values.

    Parameters
    ----------
    profile : IccProfile
        The profile.
    device : (m, n) float
        Device values, 0 to 1, of the profile's n channels.
    intent : str
        ``"perceptual"``, ``"relative"``, ``"saturation"`` or ``"absolute"``.

    Returns
    -------
    ProfileColours

    Raises
    ------
    MalformedProfileError
        A tag that is needed is missing or broken, or makes no finite colours.
    UnsupportedProfileError
        The profile has only transforms of another kind, or such that would take too long.

    Notes
    -----
    ICC.1:2022, 6.3.2.2 for absolute colorimetry, and 6.3.3 for the perceptual reference medium.
    """
    transform, warnings = profile.transform(intent)
    colours = transform.pcs_values(device)
    scale, offset = np.ones(3), np.zeros(3)
    if intent == "absolute" and not transform.absolute:
        white, white_warnings = profile.media_white()
        warnings += white_warnings
        scale = white / ICC_D50
    elif intent == "perceptual" and (profile.version[0] < 4 or "TRC" in transform.tag):
        scale, offset = 1 - PERCEPTUAL_BLACK / ICC_D50, PERCEPTUAL_BLACK
    else:
        lab = colours if transform.pcs == "Lab" else xyz_to_lab(colours)
        return ProfileColours(
            lab, transform.tag, transform.kind, transform.absolute, tuple(warnings)
        )
    # Negative tristimulus values are cut off around these adjustments, and only there, as the
    # reference implementation does; CIELAB colours near black can have them.
    if transform.pcs == "Lab":
        colours = np.maximum(lab_to_xyz(colours), 0.0)
    lab = xyz_to_lab(np.maximum(colours * scale + offset, 0.0))
    return ProfileColours(lab, transform.tag, transform.kind, transform.absolute, tuple(warnings))
