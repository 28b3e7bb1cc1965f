"""The colours at the surface of a device's gamut, from its characterisation.

The one entrance from characterisation data to points in the colour space: measured samples get a
device model, from which the surface of the cube of device values is sampled densely; profiles are
such a model already; bare colours are passed on. Everything that was chosen or assumed on the way
is in the provenance of the result.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation import IccProfile, Picture
from gamutcore.characterisation.pictures.raster import CHANNELS
from gamutcore.characterisation.samples import JSON
from gamutcore.colours.device.cube_surface import SURFACE_SAMPLES
from gamutcore.colours.device.ink_limits import InkLimits, LimitedCube, limited_cube
from gamutcore.colours.device.model import device_model
from gamutcore.colours.device.surface import MAX_PATCHES, device_surface
from gamutcore.colours.measured_colours import MeasuredColours, measured_colours
from gamutcore.colours.picture_colours import picture_colours
from gamutcore.colours.profile_colours import ProfileColours, profile_colours, stated_white
from gamutcore.errors import MalformedProfileError, OptionError
from gamutcore.option_types import Choice, check_option

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation import Samples

__all__ = ["INTENTS", "SurfaceColours", "surface_colours"]

INTENTS = ("relative", "absolute", "perceptual", "saturation")

_POOR_FIT = 5.0
"""Mean leave-out ΔE*ab beyond which a model is called unreliable; real devices reach 0.1 to 1.5."""

_NEEDED_BY_FITS = (
    "Leave it out, and the samples' own colours are used; or send at least two distinct device "
    "values more than there are channels that vary, and not all of them in one plane."
)

_KINDS = {
    "mft1": "lut8",
    "mft2": "lut16",
    "mAB ": "lutAToB",
    "mpet": "multi-process elements",
}
"""Names of the types of profiles' transforms (ICC.1:2022, clause 10)."""


@dataclass(frozen=True, eq=False)
class SurfaceColours:
    """Points that the gamut's boundary is to be wrapped around.

    Parameters
    ----------
    points : (m, 3) float
        CIELAB L*, a*, b*, relative to ICC's D50.
    device : (m, k) float or None
        The device values that make them, or pixels' values, 0 to 1; None for bare colours.
    provenance : dict
        All that went in, JSON-able.
    as_measured : bool
        Whether the colours are a display's or an encoding's own tristimulus values, adapted to no
        white.
    channels : tuple of str
        Names of the k device channels; none of bare colours.
    own_values : (3, 3) float, optional
        What takes the tristimulus values of `points` to the display's own, if they are as measured
        and ICC's absolute colours differ from that, see `ProfileColours`.
    """

    points: FloatArray
    device: FloatArray | None
    provenance: dict[str, JSON]
    as_measured: bool = False
    channels: tuple[str, ...] = ()
    own_values: FloatArray | None = None


def surface_colours(
    characterisation: Samples | IccProfile | Picture,
    *,
    intent: str = "relative",
    surface_samples: int = 100_000,
    limits: InkLimits | None = None,
    observer: int | None = None,
    illuminant: str | None = None,
    adaptation: str = "Bradford",
    popularity: float | None = None,
    model: str | None = None,
) -> SurfaceColours:
    """Return colours at the surface of a device's gamut.

    Parameters
    ----------
    characterisation : Samples, IccProfile or Picture
        As read by `gamutcore.characterisation.characterisation`.
    intent : str
        ``"relative"`` or ``"absolute"``; for profiles also ``"perceptual"`` or ``"saturation"``.
    surface_samples : int
        Points to sample a device model at, at most. Bare colours are all passed on.
    limits : InkLimits, optional
        How much ink is used at most, of a device that has inks.
    observer : int, optional
        2 or 10 degrees, for spectra.
    illuminant : str, optional
        What reflectance spectra are seen under, one of `gamutcore.colours.spectral.ILLUMINANTS`.
    adaptation : str
        How measured colours, and those of pictures without a profile, are adapted to D50, one of
        `gamutcore.colours.spaces.white_points.ADAPTATIONS`;
        the colours of profiles are by definition.
    popularity : float, optional
        Which part of a picture's pixels, those of the least used colours, is left out.
    model : str, optional
        Which device model measured samples get, one of
        `gamutcore.colours.device.model.DEVICE_MODELS`.

    Returns
    -------
    SurfaceColours

    Raises
    ------
    OptionError
        An unknown intent, or one that the data does not have; a number of samples out of range;
        limits of ink for a device without inks; an observer or illuminant for data without spectra;
        a popularity cut of what is no picture; a device model that the data cannot have.
    CharacterisationError, InvalidPointsError
        The data turns out to be broken when it is evaluated.
    """
    intent = str(check_option("intent", intent, Choice(INTENTS)))
    check_option("surface_samples", surface_samples, SURFACE_SAMPLES)
    if isinstance(characterisation, Picture):
        return _picture_points(characterisation, intent, popularity, adaptation)
    if isinstance(characterisation, IccProfile):
        return _profile_surface(characterisation, intent, surface_samples, limits or InkLimits())
    medium = measured_colours(
        characterisation, intent, observer=observer, illuminant=illuminant, adaptation=adaptation
    )
    surface = _sample_surface(
        characterisation, medium, surface_samples, limits or InkLimits(), model
    )
    return replace(surface, as_measured=medium.as_measured)


def _picture_points(
    picture: Picture,
    intent: str,
    popularity: float | None,
    adaptation: str,
) -> SurfaceColours:
    colours = picture_colours(picture, intent, popularity, adaptation=adaptation)
    provenance: dict[str, JSON] = {
        **colours.provenance,
        "model": {"name": "none: the colours of the picture"},
        "surface": {"points": len(colours.lab)},
        "warnings": list[JSON](colours.warnings),
    }
    return SurfaceColours(
        colours.lab,
        colours.device,
        provenance,
        colours.as_measured,
        () if colours.device is None else CHANNELS[picture.model],
        colours.own_values,
    )


def _profile_surface(
    profile: IccProfile, intent: str, surface_samples: int, limits: InkLimits
) -> SurfaceColours:
    channels = len(profile.channels)
    limited = limited_cube(
        profile.channels, np.zeros(channels), np.ones(channels), limits, inks=profile.inks
    )
    nodes = profile.transform(intent)[0].nodes
    device, density = _surface_values(
        limited, lambda values: profile_colours(profile, values, intent).lab, surface_samples, nodes
    )
    colours = profile_colours(profile, device, intent)
    points = colours.lab
    white, white_warnings = stated_white(profile)
    adaptation = {
        "absolute": "none: as in the profile"
        if colours.absolute
        else "none: media-relative colours scaled by the media white",
        "perceptual": "as in the profile, with the perceptual reference medium's black point",
    }.get(intent, "as in the profile: media-relative to D50")
    provenance: dict[str, JSON] = {
        **profile.provenance,
        "intent": intent,
        "white": white,
        "illuminant": "D50",
        "observer": "2°",
        "adaptation": adaptation,
        **_declared_luminance(profile),
        **_limits_provenance(limited),
        "model": {"name": "ICC profile", "tag": colours.tag, "kind": _kind(colours)},
        "surface": {"points": len(points), "density": density},
        # What is missed twice is warned of once.
        "warnings": list[JSON](
            dict.fromkeys(
                [
                    *profile.warnings,
                    *colours.warnings,
                    *white_warnings,
                    *_count_warnings(len(points), surface_samples, density),
                ]
            )
        ),
    }
    own = colours.own_values
    return SurfaceColours(points, device, provenance, own is not None, profile.channels, own)


def _kind(colours: ProfileColours) -> str:
    return _KINDS.get(colours.kind, "matrix and curves")


def _surface_values(
    limited: LimitedCube,
    colours: Callable[[FloatArray], FloatArray],
    surface_samples: int,
    nodes: FloatArray | None = None,
) -> tuple[FloatArray, str]:
    """Return device values at the surface of what is used of a device's cube, and their density."""
    cube = limited.cube
    if not len(cube.lowest):
        return limited.base[np.newaxis], "corners"
    whole = limited.free.all() and (cube.lowest == 0).all() and (cube.highest == 1).all()
    surface = device_surface(
        cube,
        lambda values: colours(limited.device(values)),
        surface_samples,
        nodes if whole else None,
    )
    return limited.device(surface.device), surface.density


def _limits_provenance(limited: LimitedCube) -> dict[str, JSON]:
    return {} if limited.provenance is None else {"ink_limits": limited.provenance}


def _declared_luminance(profile: IccProfile) -> dict[str, JSON]:
    """Return the luminance of a display's white, which the tag `lumi` states; nothing if broken."""
    with contextlib.suppress(MalformedProfileError):
        luminance = float(profile.xyz("lumi")[1]) if "lumi" in profile.tags else 0.0
        if luminance > 0:
            return {"white_luminance": round(luminance, 4)}
    return {}


def _sample_surface(
    samples: Samples,
    medium: MeasuredColours,
    surface_samples: int,
    limits: InkLimits,
    kind: str | None,
) -> SurfaceColours:
    provenance: dict[str, JSON] = {**samples.provenance, **medium.provenance}
    warnings = [*samples.warnings, *medium.warnings]
    if samples.device is None:
        provenance["patches"] = _patches(samples, len(medium.lab))
        provenance["model"] = {"name": "none: the colours themselves"}
        provenance["warnings"] = list[JSON](warnings)
        return SurfaceColours(medium.lab, None, provenance)

    device, lab = _distinct(samples.device, medium.lab)
    averaged, distinct = len(samples.device) - len(device), len(device)
    model = device_model(device, lab, kind)
    device, lab = model.device, model.lab
    if len(device) < distinct:
        warnings.append(
            f"Of {distinct} distinct samples, {len(device)} were used for the device model."
        )
    provenance["patches"] = _patches(
        samples, len(device), averaged=averaged, thinned=distinct - len(device)
    )
    lowest, highest = device.min(axis=0), device.max(axis=0)
    limited = limited_cube(samples.channels, lowest, highest, limits, inks=samples.inks)
    provenance["model"] = model.provenance
    if model.colours is None:
        why = f"o device model can be fitted ({model.degenerate})"
        if limits:
            raise limits.refusal(f"n{why}.")
        if kind is not None:
            raise OptionError.not_applicable("device_model", kind, f"n{why}", _NEEDED_BY_FITS)
        warnings.append(f"N{why}; the samples' colours are used.")
        provenance["warnings"] = list[JSON](warnings)
        return SurfaceColours(lab, device, provenance, channels=samples.channels)

    warnings += model.warnings
    warnings += _range_warnings(samples, lowest, highest, device, limited)
    if model.mean_error is not None and model.mean_error > _POOR_FIT:
        warnings.append(
            f"The device model misses left-out samples by {model.mean_error:.1f} ΔE*ab on average."
        )
    values, density = _surface_values(limited, model.colours, surface_samples, model.nodes)
    points = model.colours(values)
    dark = points[:, 0] < 0
    if dark.any():
        warnings.append(f"{int(dark.sum())} colours below L* 0 were raised to it.")
        points[dark, 0] = 0.0
    warnings += _count_warnings(len(points), surface_samples, density)
    provenance["surface"] = {"points": len(points), "density": density}
    provenance.update(_limits_provenance(limited))
    provenance["warnings"] = list[JSON](warnings)
    return SurfaceColours(points, values, provenance, channels=samples.channels)


def _patches(samples: Samples, used: int, *, averaged: int = 0, thinned: int = 0) -> JSON:
    """Return how many patches were read, dropped (in reading or here), averaged and used."""
    read, dropped = len(samples), 0
    told = samples.provenance.get("patches")
    if isinstance(told, dict):
        kept, lost = told.get("read"), told.get("dropped")
        read = kept if isinstance(kept, int) else read
        dropped = lost if isinstance(lost, int) else 0
    return {"read": read, "averaged": averaged, "dropped": dropped + thinned, "used": used}


def _count_warnings(points: int, surface_samples: int, density: str) -> list[str]:
    if density != "corners":
        return []
    if points > surface_samples:
        return [
            f"The corners of the device cube alone are {points} points, more than surface_samples."
        ]
    if points == 1:
        return ["No channel varies within what is used of the device: its gamut is one colour."]
    why = (
        f"points on its faces as well would be more than surface_samples, {surface_samples}"
        if surface_samples < MAX_PATCHES
        else "its faces are too many"
    )
    return [f"Only the {points} corners of the device cube were sampled; {why}."]


def _distinct(device: FloatArray, lab: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distinct device values with the mean of their colours."""
    order = np.lexsort(device.T[::-1])
    ranked = device[order]
    first = np.ones(len(ranked), dtype=bool)
    first[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    starts = np.flatnonzero(first)
    counts = np.diff(np.append(starts, len(ranked)))
    sums = np.add.reduceat(lab[order], starts, axis=0)
    return ranked[starts], sums / counts[:, np.newaxis]


def _range_warnings(
    samples: Samples,
    lowest: FloatArray,
    highest: FloatArray,
    device: FloatArray,
    limited: LimitedCube,
) -> list[str]:
    warnings = [
        f"{channel} was measured from {100 * low:.3g} to {100 * high:.3g} % only; the gamut is of "
        "that range."
        for channel, low, high in zip(samples.channels, lowest, highest, strict=True)
        if low > 0.005 or high < 0.995
    ]
    full = float(limited.base[~limited.free].sum() + limited.cube.largest_sum)
    most = float(device.sum(axis=1).max())
    if not samples.additive and most < 0.99 * full:
        warnings.append(
            f"The most ink that was measured is {100 * most:.0f} %; colours of up to "
            f"{100 * full:.0f} % are extrapolated."
        )
    return warnings
