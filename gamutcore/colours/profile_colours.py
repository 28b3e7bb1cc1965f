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

from gamutcore.characterisation.samples import JSON
from gamutcore.colours.spaces.cielab import ICC_D50, lab_to_xyz, xyz_to_lab
from gamutcore.colours.spaces.white_points import adaptation_matrix
from gamutcore.errors import MalformedProfileError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.icc import IccProfile

__all__ = ["ProfileColours", "profile_colours", "stated_white"]

PERCEPTUAL_BLACK = np.array([0.00336, 0.0034731, 0.00287])
"""XYZ of the perceptual reference medium's black point (ICC.1:2022, 6.3.3, table 3)."""

_SAME_WHITE = 0.001
"""Largest difference of X, Y and Z to a white that is D50; profilers round it in several ways."""


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
    own_values : (3, 3) float, optional
        What takes the tristimulus values of absolute colours, which ICC defines as scaled by the
        white, to those that a display has itself. None if they are to be taken as adapted to D50.
    """

    lab: FloatArray
    tag: str
    kind: str
    absolute: bool
    warnings: tuple[str, ...]
    own_values: FloatArray | None = None


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
    own_values = None
    if intent == "absolute" and not transform.absolute:
        white, white_warnings = profile.media_white()
        warnings += white_warnings
        scale = white / ICC_D50
        own_values = _own_values(profile, white)
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
    return ProfileColours(
        lab, transform.tag, transform.kind, transform.absolute, tuple(warnings), own_values
    )


def stated_white(profile: IccProfile) -> tuple[JSON, list[str]]:
    """Return a profile's media white for the provenance.

    Parameters
    ----------
    profile : IccProfile

    Returns
    -------
    white : list of float, or None
        X, Y, Z; None if it is broken. Only absolute colorimetry needs it, and refuses that.
    warnings : list of str
    """
    try:
        white, warnings = profile.media_white()
    except MalformedProfileError as error:
        return None, [error.message]
    return [round(float(value), 6) for value in white], warnings


def _own_values(profile: IccProfile, white: FloatArray) -> FloatArray | None:
    """Return the matrix from absolute colours to a display's own tristimulus values.

    The media white of displays is their own in profiles of version 2, and D50 in later ones, whose
    absolute colours stay adapted (ICC.1:2022, 9.2.36). The colours themselves are adapted either
    way, by the tag chad or, as is usual without it, by the linear Bradford transform. Scaling XYZ
    by the white, as absolute colorimetry is defined, does not undo that.
    """
    if profile.device_class != "display" or np.abs(white - ICC_D50).max() <= _SAME_WHITE:
        return None
    adapting = profile.adaptation_to_d50()
    unadapting = (
        adaptation_matrix(ICC_D50, white, "Bradford") * white[1]
        if adapting is None
        else np.linalg.inv(adapting)
    )
    return unadapting * (ICC_D50 / white)
