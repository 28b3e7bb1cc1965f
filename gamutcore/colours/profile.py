"""Colours of device values by an ICC profile, for each rendering intent.

The steps after the profile's own transform follow the ICC's reference implementation, except for
absolute colours of displays that state their own white: the adaptation to D50 is undone, as their
measurements show, where the reference scales XYZ by the white. The perceptual intent of
profiles without the reference medium's black point of version 4 gets it by scaling. Black-point
compensation is never applied. See ``docs/decisions/icc-evaluator.md``.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from gamutcore.characterisation.icc import (
    CurveSet,
    Matrix,
    icc_profile,
    near_d50,
    reduced_profile,
)
from gamutcore.characterisation.samples import JSON
from gamutcore.colours.colorimetry import ICC_D50, adaptation_matrix, lab_to_xyz, xyz_to_lab
from gamutcore.colours.device_model import impossible_colour_warnings
from gamutcore.colours.ink_limits import InkLimits, limited_cube
from gamutcore.colours.models import (
    Arrays,
    DeviceFunction,
    DeviceModel,
    check_shapes,
    device_function,
)
from gamutcore.colours.sampling import (
    AbsoluteColours,
    SurfaceColours,
    count_warnings,
    device_colours,
    surface_values,
)
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.icc import IccProfile

PERCEPTUAL_BLACK = np.array([0.00336, 0.0034731, 0.00287])
"""XYZ of the perceptual reference medium's black point (ICC.1:2022, 6.3.3, table 3)."""

_SAME_CHROMATICITY = 0.005
"""Largest difference in x and y of two statements of one white. Profilers' D65 differ by 0.001."""

_NEUTRAL = 3.0
"""Largest ΔE*ab from L* 100 of the white of media-relative colours. Tables of 8 bits round to 0.5;
a D65 white that is not adapted is 19 away, the paper of a press 4 or more."""

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


def profile_colours(
    profile: IccProfile, device: FloatArray, intent: str, absolute: FloatArray | None = None
) -> ProfileColours:
    """Return CIELAB colours of device values (m, n), 0 to 1, for any rendering intent.

    ICC.1:2022, 6.3.2.2 for absolute colorimetry, and 6.3.3 for the perceptual reference medium.
    `absolute` (3, 3) leads from media-relative to absolute tristimulus values; by default, it is
    that of `absolute_colours`.
    """
    transform, warnings = profile.transform(intent)
    colours = transform.pcs_values(device)
    scale, offset = np.eye(3), np.zeros(3)
    adaptation = "as in the profile: media-relative to D50"
    if intent == "absolute":
        adaptation = "none: as in the profile"
    elif intent == "perceptual":
        adaptation = "as in the profile, with the perceptual reference medium's black point"
    if intent == "absolute" and not transform.absolute:
        declared = _absolute_colours(profile)
        scale = declared.matrix if absolute is None else absolute
        adaptation = "none: media-relative colours scaled by the media white"
        if declared.as_measured:
            adaptation = "none: the adaptation of the display's own colours to D50 is undone"
    elif intent == "perceptual" and (profile.version[0] < 4 or "TRC" in transform.tag):
        scale, offset = np.diag(1 - PERCEPTUAL_BLACK / ICC_D50), PERCEPTUAL_BLACK
    else:
        lab = colours if transform.pcs == "Lab" else xyz_to_lab(colours)
        return ProfileColours(lab, transform.tag, transform.kind, adaptation, tuple(warnings))
    # As in the reference implementation, negative tristimulus values are clipped before and after
    # this adjustment only. CIELAB colours near black can have them.
    if transform.pcs == "Lab":
        colours = np.maximum(lab_to_xyz(colours), 0.0)
    lab = xyz_to_lab(np.maximum(colours @ scale.T + offset, 0.0))
    return ProfileColours(lab, transform.tag, transform.kind, adaptation, tuple(warnings))


def printed_values(profile: IccProfile, device: FloatArray, intent: str) -> FloatArray:
    """Return the device values that a profile's B2A prints for the colours of device values.

    They make the *usable* gamut of ISO/TS 18621-11: device values to colours by A2B, and back by
    B2A of the intent. Profiles of matrix and curves give the same device values.
    """
    intent = "relative" if intent == "absolute" else intent
    separation, transform = profile.separation(intent), profile.transform(intent)[0]
    if separation is None:
        return device
    colours = transform.pcs_values(device)
    return separation.device_values(colours)


@device_function
@dataclass(frozen=True, eq=False)
class ProfileTransform(DeviceFunction):
    """The transform of an ICC profile for an intent.

    `absolute` (3, 3) leads from media-relative to absolute tristimulus values, for this intent.
    """

    kind: ClassVar[str] = "profile"
    profile: IccProfile
    intent: str
    absolute: FloatArray | None = None

    def lab(self, device: FloatArray) -> FloatArray:
        """Return colours as `profile_colours`."""
        return profile_colours(self.profile, device, self.intent, self.absolute).lab

    def closed_values(self, lab: FloatArray) -> FloatArray | None:
        """Return device values as `values_by_curves`, for colours that an intent does not scale."""
        if self.intent not in {"relative", "saturation"}:
            return None
        return values_by_curves(self.profile, lab, self.intent)

    def parts(self) -> tuple[Arrays, dict[str, Any]]:
        """Return the profile with the tags that the transform needs."""
        data = reduced_profile(self.profile, self.intent)
        arrays = {"profile": np.frombuffer(data, np.uint8)}
        return arrays | ({} if self.absolute is None else {"absolute": self.absolute}), {
            "intent": self.intent
        }

    @classmethod
    def of(cls, arrays: Arrays, facts: Mapping[str, Any]) -> Self:
        """Return the function of its parts."""
        profile, intent = icc_profile(arrays["profile"].tobytes()), str(facts["intent"])
        absolute = arrays.get("absolute")
        if absolute is not None:
            check_shapes((absolute,), ((3, 3),), np.float64)
        elif intent == "absolute":  # a file of a version that scaled the colours of displays too
            absolute = np.diag(profile.media_white()[0] / ICC_D50)
        return cls(profile, intent, absolute)


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
        [
            np.interp(light[:, channel], samples[:, channel], ramp)
            for channel in range(light.shape[1])
        ]
    )


def declared_white(profile: IccProfile) -> tuple[JSON, list[str]]:
    """Return X, Y, Z of the media white for the provenance, and warnings; None if it is broken.

    Only absolute colorimetry needs the white, and refuses a broken one. A warning says if the white
    of media-relative colours is not that of D50.
    """
    relative = _relative_white(profile)
    strange = []
    if relative is not None and np.linalg.norm(relative - _WHITE) > _NEUTRAL:
        strange = [_strange_white(profile, relative)]
    try:
        white, warnings = profile.media_white()
    except MalformedProfileError as error:
        return None, [error.message, *strange]
    return [round(float(value), 6) for value in white], [*warnings, *strange]


_WHITE = np.array([100.0, 0.0, 0.0])


def _strange_white(profile: IccProfile, lab: FloatArray) -> str:
    values = " ".join(f"{value + 0.0:.3g}" for value in lab.round(1))
    if not profile.lights:
        return (
            f"The paper has L*a*b* {values} in the media-relative table, where it is 100 0 0. The "
            "table is not relative to the paper."
        )
    return (
        f"The white has L*a*b* {values} in the media-relative colours, where it is 100 0 0. The "
        "colorants are not adapted to D50 (ICC.1:2022, 9.2.15); relative colours keep this cast."
    )


def _relative_white(profile: IccProfile) -> FloatArray | None:
    """Return CIELAB (3,) of the medium's white by the media-relative transform.

    None for input profiles, whose device values have no white, and for a broken transform.
    """
    if profile.device_class == "input":
        return None
    device = np.full((1, len(profile.channels)), 0.0 if profile.inks else 1.0)
    try:
        transform, _ = profile.transform("relative")
        colours = transform.pcs_values(device)[0]
    except (MalformedProfileError, UnsupportedProfileError):
        return None
    return colours if transform.pcs == "Lab" else xyz_to_lab(colours)


def absolute_colours(profile: IccProfile) -> AbsoluteColours | None:
    """Return `_absolute_colours`; None if the media white or the transform is broken."""
    try:
        return _absolute_colours(profile)
    except MalformedProfileError:
        return None


def _absolute_colours(profile: IccProfile) -> AbsoluteColours:
    """Return what media-relative colours of a profile are as absolute and as the device's own ones.

    Prints are scaled by the media white (ICC.1:2022, 6.3.2.2). The colours of displays and of RGB
    spaces are adapted to D50. A display that states its own white (version 2) has absolute colours
    without this adaptation, as its measurements have. The media white of later versions is D50, and
    their absolute colours stay adapted (9.2.36).
    """
    white, _ = profile.media_white()
    scaling = np.diag(white / ICC_D50)
    if not profile.lights:
        own = None if profile.device_class == "output" else _unadapted(profile, white)
        return AbsoluteColours(scaling, own=own)
    own = _unadapted(profile, white)
    if near_d50(white) or profile.transform("absolute")[0].absolute:
        return AbsoluteColours(scaling, own=own)
    return AbsoluteColours(own, as_measured=True)


def _unadapted(profile: IccProfile, white: FloatArray) -> FloatArray:
    """Return the matrix (3, 3) from the connection space to the device's own tristimulus values.

    The adaptation is that of the tag chad, or linear Bradford without one that leads to the stated
    white. Colours that were never adapted stay.
    """
    relative = _relative_white(profile)
    if relative is not None and profile.lights:
        media_white = lab_to_xyz(relative)
        if not _same_chromaticity(media_white, ICC_D50) and _same_chromaticity(media_white, white):
            return np.eye(3)
    adapting = profile.adaptation_to_d50()
    if adapting is not None:
        unadapting = np.asarray(np.linalg.inv(adapting), np.float64)
        if near_d50(white) or _same_chromaticity(unadapting @ ICC_D50, white):
            return unadapting
    matrix: FloatArray = adaptation_matrix(ICC_D50, white, "Bradford") * white[1]
    return matrix


def _same_chromaticity(one: FloatArray, two: FloatArray) -> bool:
    return bool(np.abs(one / one.sum() - two / two.sum()).max() < _SAME_CHROMATICITY)


def profile_surface(
    profile: IccProfile,
    intent: str,
    surface_samples: int,
    limits: InkLimits,
    *,
    usable: bool = False,
) -> SurfaceColours:
    """Return the colours at the surface of a profile's device within its ink limits.

    `usable` is for `printed_values` of the whole device in their place; then the limits hold for
    recipes, and the B2A tables have their own.
    """
    channels = len(profile.channels)
    limited = limited_cube(
        profile.channels, np.zeros(channels), np.ones(channels), limits, inks=profile.inks
    )
    nodes = profile.transform(intent)[0].nodes
    function = ProfileTransform(profile, intent)
    printed = partial(printed_values, profile, intent=intent) if usable else None
    sampled = limited
    if usable:
        whole = np.zeros(channels), np.ones(channels)
        sampled = limited_cube(profile.channels, *whole, InkLimits(), inks=profile.inks)
    surface = surface_values(sampled, function.lab, surface_samples, nodes)
    density = surface.density
    device = surface.device if printed is None else printed(surface.device)
    colours = profile_colours(profile, device, intent)
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
            **({"separation": _separation_tag(profile, intent)} if usable else {}),
            "kind": _KINDS.get(colours.kind, "matrix and curves"),
        },
        "surface": {"points": len(points), "density": density},
        "warnings": list[JSON](dict.fromkeys(warnings)),  # each once
    }
    absolute = absolute_colours(profile)
    if intent == "absolute" and absolute is not None:
        function = replace(function, absolute=absolute.matrix)
    model = DeviceModel(profile.channels, profile.inks, limited, function)
    own = device_colours(replace(model, limited=sampled), surface)
    if printed is not None:
        own = own._replace(
            points=lambda values: function.lab(printed(sampled.device(values))),
            model=model,
            printed=printed,
        )
    return SurfaceColours(
        points,
        surface.device,
        provenance,
        intent == "absolute" and absolute is not None and absolute.as_measured,
        profile.channels,
        surface.faces,
        own,
        absolute,
    )


def _separation_tag(profile: IccProfile, intent: str) -> str:
    separation = profile.separation(intent)
    return "none: matrix and curves" if separation is None else separation.tag


def _declared_luminance(profile: IccProfile) -> dict[str, JSON]:
    """Luminance of a display's white in the tag `lumi`; empty if it is missing or broken."""
    with contextlib.suppress(MalformedProfileError):
        luminance = float(profile.xyz("lumi")[1]) if "lumi" in profile.tags else 0.0
        if luminance > 0:
            return {"white_luminance": round(luminance, 4)}
    return {}
