"""Colours of device values by an ICC profile, for each rendering intent.

The steps after the profile's own transform follow the ICC's reference implementation. Absolute
colorimetry scales XYZ by the media white, in all versions and classes. The perceptual intent of
profiles without the reference medium's black point of version 4 gets it by scaling. Black-point
compensation is never applied. See ``docs/decisions/icc-evaluator.md``.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from gamutcore.characterisation.icc import CurveSet, Matrix, icc_profile, reduced_profile
from gamutcore.characterisation.samples import JSON
from gamutcore.colours.colorimetry import ICC_D50, adaptation_matrix, lab_to_xyz, xyz_to_lab
from gamutcore.colours.device_model import impossible_colour_warnings
from gamutcore.colours.ink_limits import InkLimits, limited_cube
from gamutcore.colours.models import Arrays, DeviceFunction, DeviceModel, device_function
from gamutcore.colours.sampling import (
    AbsoluteColours,
    SurfaceColours,
    count_warnings,
    device_colours,
    surface_values,
)
from gamutcore.errors import MalformedProfileError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.icc import IccProfile

PERCEPTUAL_BLACK = np.array([0.00336, 0.0034731, 0.00287])
"""XYZ of the perceptual reference medium's black point (ICC.1:2022, 6.3.3, table 3)."""

_SAME_WHITE = 0.001
"""Largest difference in X, Y and Z of a white that counts as D50; profilers round differently."""


_LIGHTS = frozenset({"display", "colour space"})
"""Classes of profiles whose colours are lights, which the optimal colour solid does not limit."""

_KINDS = {
    "mft1": "lut8",
    "mft2": "lut16",
    "mAB ": "lutAToB",
    "mpet": "multi-process elements",
}
"""Names of the types of a profile's transforms (ICC.1:2022, clause 10)."""


@dataclass(frozen=True, eq=False)
class ProfileColours:
    """Colours (m, 3) by a profile in CIELAB relative to D50, and what of it produced them.

    `tag` has the tag or tags of the transform, and `kind` their type, which is empty for curves.
    `adaptation` tells how the colours relate to D50.
    """

    lab: FloatArray
    tag: str
    kind: str
    adaptation: str
    warnings: tuple[str, ...]


def profile_colours(profile: IccProfile, device: FloatArray, intent: str) -> ProfileColours:
    """Return CIELAB colours of device values (m, n), 0 to 1, for any rendering intent.

    ICC.1:2022, 6.3.2.2 for absolute colorimetry, and 6.3.3 for the perceptual reference medium.
    """
    transform, warnings = profile.transform(intent)
    colours = transform.pcs_values(device)
    scale, offset = np.ones(3), np.zeros(3)
    adaptation = "as in the profile: media-relative to D50"
    if intent == "absolute":
        adaptation = "none: as in the profile"
    elif intent == "perceptual":
        adaptation = "as in the profile, with the perceptual reference medium's black point"
    if intent == "absolute" and not transform.absolute:
        white, white_warnings = profile.media_white()
        warnings += white_warnings
        scale = white / ICC_D50
        adaptation = "none: media-relative colours scaled by the media white"
    elif intent == "perceptual" and (profile.version[0] < 4 or "TRC" in transform.tag):
        scale, offset = 1 - PERCEPTUAL_BLACK / ICC_D50, PERCEPTUAL_BLACK
    else:
        lab = colours if transform.pcs == "Lab" else xyz_to_lab(colours)
        return ProfileColours(lab, transform.tag, transform.kind, adaptation, tuple(warnings))
    # As in the reference implementation, negative tristimulus values are clipped before and after
    # this adjustment only. CIELAB colours near black can have them.
    if transform.pcs == "Lab":
        colours = np.maximum(lab_to_xyz(colours), 0.0)
    lab = xyz_to_lab(np.maximum(colours * scale + offset, 0.0))
    return ProfileColours(lab, transform.tag, transform.kind, adaptation, tuple(warnings))


@device_function
@dataclass(frozen=True, eq=False)
class ProfileTransform(DeviceFunction):
    """The transform of an ICC profile for an intent."""

    kind: ClassVar[str] = "profile"
    profile: IccProfile
    intent: str

    def lab(self, device: FloatArray) -> FloatArray:
        """Return colours as `profile_colours`."""
        return profile_colours(self.profile, device, self.intent).lab

    def closed_values(self, lab: FloatArray) -> FloatArray | None:
        """Return device values as `values_by_curves`, for colours that an intent does not scale."""
        if self.intent not in {"relative", "saturation"}:
            return None
        return values_by_curves(self.profile, lab, self.intent)

    def parts(self) -> tuple[Arrays, dict[str, Any]]:
        """Return the profile with the tags that the transform needs."""
        data = reduced_profile(self.profile, self.intent)
        return {"profile": np.frombuffer(data, np.uint8)}, {"intent": self.intent}

    @classmethod
    def of(cls, arrays: Arrays, facts: Mapping[str, Any]) -> Self:
        """Return the function of its parts."""
        return cls(icc_profile(arrays["profile"].tobytes()), str(facts["intent"]))


_CURVE_SAMPLES = 4097
"""Samples of a profile's curve for its inverse, whose error is below a step of 12 bits."""


def values_by_curves(
    profile: IccProfile, lab: FloatArray, intent: str = "relative"
) -> FloatArray | None:
    """Return device values (n, k) of relative colours by the inverses of curves and a matrix.

    They are close, and may be outside of 0 to 1. None for other profiles.
    """
    transform, _ = profile.transform(intent)
    match transform.stages:
        case (CurveSet() as curves, Matrix() as linear) if transform.pcs == "XYZ":
            light = (lab_to_xyz(lab) - linear.offset) @ np.linalg.pinv(linear.matrix).T
        case _:
            return None
    ramp = np.linspace(0.0, 1.0, _CURVE_SAMPLES)
    samples = curves.values(np.repeat(ramp[:, np.newaxis], len(curves.curves), axis=1))
    if not (np.diff(samples, axis=0) >= 0.0).all():
        return None
    return np.column_stack(
        [np.interp(light[:, each], samples[:, each], ramp) for each in range(light.shape[1])]
    )


def declared_white(profile: IccProfile) -> tuple[JSON, list[str]]:
    """Return X, Y, Z of the media white for the provenance, and warnings; None if it is broken.

    Only absolute colorimetry needs the white, and refuses a broken one.
    """
    try:
        white, warnings = profile.media_white()
    except MalformedProfileError as error:
        return None, [error.message]
    return [round(float(value), 6) for value in white], warnings


def absolute_colours(profile: IccProfile) -> AbsoluteColours | None:
    """Return what media-relative colours of a profile are as absolute and as the device's own ones.

    None if the media white is broken. Prints are scaled by the media white (ICC.1:2022, 6.3.2.2).
    The colours of displays and of RGB spaces are adapted to D50, by the tag chad or, without it, by
    the linear Bradford transform. Scaling by the white does not undo this adaptation. The media
    white of a display profile is the display's own in version 2, and D50 in later versions, whose
    absolute colours stay adapted (9.2.36).
    """
    try:
        white, _ = profile.media_white()
        scaled = not profile.transform("absolute")[0].absolute
    except MalformedProfileError:
        return None
    scaling = np.diag(white / ICC_D50)
    if profile.device_class == "output":
        return AbsoluteColours(scaling)
    is_own = profile.device_class == "display" and np.abs(white - ICC_D50).max() > _SAME_WHITE
    adapting = profile.adaptation_to_d50()
    if adapting is None:
        unadapted = adaptation_matrix(ICC_D50, white, "Bradford") * white[1]
    else:
        unadapted = np.asarray(np.linalg.inv(adapting), np.float64)
    return AbsoluteColours(scaling, is_own and scaled, unadapted)


def profile_surface(
    profile: IccProfile, intent: str, surface_samples: int, limits: InkLimits
) -> SurfaceColours:
    """Return the colours at the surface of a profile's device within its ink limits."""
    channels = len(profile.channels)
    limited = limited_cube(
        profile.channels, np.zeros(channels), np.ones(channels), limits, inks=profile.inks
    )
    nodes = profile.transform(intent)[0].nodes
    function = ProfileTransform(profile, intent)
    surface = surface_values(limited, function.lab, surface_samples, nodes)
    density = surface.density
    colours = profile_colours(profile, surface.device, intent)
    points = colours.lab
    white, white_warnings = declared_white(profile)
    warnings = [
        *profile.warnings,
        *colours.warnings,
        *white_warnings,
        *count_warnings(len(points), surface_samples, density),
        *impossible_colour_warnings(points, lights=profile.device_class in _LIGHTS),
    ]
    provenance: dict[str, JSON] = {
        **profile.provenance,
        "intent": intent,
        "white": white,
        "illuminant": "D50",
        "observer": "2°",
        "adaptation": colours.adaptation,
        **_declared_luminance(profile),
        **limited.provenance,
        "model": {
            "name": "ICC profile",
            "tag": colours.tag,
            "kind": _KINDS.get(colours.kind, "matrix and curves"),
        },
        "surface": {"points": len(points), "density": density},
        "warnings": list[JSON](dict.fromkeys(warnings)),  # each once
    }
    absolute = absolute_colours(profile)
    return SurfaceColours(
        points,
        surface.device,
        provenance,
        intent == "absolute" and absolute is not None and absolute.as_measured,
        profile.channels,
        surface.faces,
        device_colours(DeviceModel(profile.channels, profile.inks, limited, function), surface),
        absolute,
    )


def _declared_luminance(profile: IccProfile) -> dict[str, JSON]:
    """Luminance of a display's white in the tag `lumi`; empty if it is missing or broken."""
    with contextlib.suppress(MalformedProfileError):
        luminance = float(profile.xyz("lumi")[1]) if "lumi" in profile.tags else 0.0
        if luminance > 0:
            return {"white_luminance": round(luminance, 4)}
    return {}
