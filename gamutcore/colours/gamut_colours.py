"""The colours at the surface of a device's gamut, from its characterisation.

This is the only way from characterisation data to points in the colour space. Measured samples get
a device model, and the surface of the cube of device values is sampled densely. A profile is such a
model already. Bare colours are passed on. Every choice and assumption is in the provenance.
"""

from __future__ import annotations

import contextlib
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation import IccProfile, Picture
from gamutcore.characterisation.samples import JSON
from gamutcore.colours.colorimetry import (
    ICC_D50,
    adaptation_matrix,
    lab_to_xyz,
    white_point,
    xyz_to_lab,
)
from gamutcore.colours.device_model import device_model
from gamutcore.colours.formulas import Cielab
from gamutcore.colours.ink_limits import InkLimits, LimitedCube, limited_cube, surface_corners
from gamutcore.colours.measured import MeasuredColours, measured_colours
from gamutcore.colours.picture import picture_colours
from gamutcore.colours.plausibility import (
    extrapolation_warnings,
    impossible_colour_warnings,
    range_warnings,
)
from gamutcore.colours.profile import (
    ProfileColours,
    absolute_colours,
    declared_white,
    profile_colours,
)
from gamutcore.colours.reference import (
    encode_rgb,
    largest_code,
    reference_lab,
    reference_provenance,
    reference_white,
    rgb_xyz,
    surface_xyz,
)
from gamutcore.colours.sampling import (
    MAX_PATCHES,
    SURFACE_SAMPLES,
    AbsoluteColours,
    DeviceColours,
    DeviceSurface,
    SurfaceColours,
    SurfaceFaces,
    device_surface,
    outward_faces,
    values_between,
)
from gamutcore.colours.spaces import ColourConversion
from gamutcore.errors import InvalidPointsError, MalformedProfileError, OptionError
from gamutcore.geometry import TriangleMesh
from gamutcore.option_types import Choice, check_option
from gamutcore.references import Reference

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.arrays import FloatArray, IndexArray
    from gamutcore.characterisation import Samples
    from gamutcore.colours.spaces import ColourSpace

__all__ = [
    "INTENTS",
    "SurfaceColours",
    "colours_in_space",
    "described_volumes",
    "display_primaries",
    "medium_white_lab",
    "own_tristimulus",
    "srgb_volume",
    "surface_colours",
]

INTENTS = ("relative", "absolute", "perceptual", "saturation")

_POOR_FIT = 5.0
"""Mean leave-one-out ΔE*ab above which a model is called unreliable; real devices reach 0.1 to
1.5."""

_LINEAR_NODES = np.linspace(0.0, 1.0, 17) ** 2
"""Linear values that divide the edges of an RGB space, denser in the dark as lightness is."""

_FIT_REMEDY = (
    "Leave it out to use the samples' own colours. Or send at least two distinct device values "
    "more than there are varying channels, and not all of them in one plane."
)

_LIGHTS = frozenset({"display", "colour space"})
"""Classes of profiles whose colours are lights, which the optimal colour solid does not limit."""

_KINDS = {
    "mft1": "lut8",
    "mft2": "lut16",
    "mAB ": "lutAToB",
    "mpet": "multi-process elements",
}
"""Names of the types of a profile's transforms (ICC.1:2022, clause 10)."""


def surface_colours(
    characterisation: Samples | IccProfile | Picture | Reference,
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

    Parameters that do not apply to the kind of data are ignored; `Options.check_data` refuses them.

    Parameters
    ----------
    characterisation : Samples, IccProfile, Picture or Reference
        As read by `gamutcore.characterisation.characterisation`.
    intent : str
        ``"relative"`` or ``"absolute"``; for profiles also ``"perceptual"`` or ``"saturation"``.
    surface_samples : int
        Largest number of points at which a device model is evaluated. Bare colours are all used.
    limits : InkLimits, optional
        Largest amounts of ink, for a device with inks.
    observer : int, optional
        2 or 10 degrees, for spectra.
    illuminant : str, optional
        Illuminant of reflectance spectra, one of `gamutcore.colours.ILLUMINANTS`.
    adaptation : str
        Adaptation of measured colours, and of pictures without a profile, to D50; one of
        `gamutcore.colours.colorimetry.ADAPTATIONS`.
    popularity : float, optional
        Share of a picture's pixels that is left out, those of the least frequent colours.
    model : str, optional
        Device model of measured samples, one of `gamutcore.colours.DEVICE_MODELS`.

    Raises
    ------
    OptionError
        The intent or the number of samples is not accepted, or the data does not have the intent;
        there are ink limits for a device without inks, an observer or illuminant for data without
        spectra, or a device model that the samples cannot have.
    CharacterisationError, InvalidPointsError
        The data is broken.
    """
    intent = str(check_option("intent", intent, Choice(INTENTS)))
    check_option("surface_samples", surface_samples, SURFACE_SAMPLES)
    if isinstance(characterisation, Picture):
        return picture_colours(characterisation, intent, popularity, adaptation=adaptation)
    if isinstance(characterisation, IccProfile):
        return _profile_surface(characterisation, intent, surface_samples, limits or InkLimits())
    if isinstance(characterisation, Reference):
        return _reference_surface(characterisation, intent, surface_samples, adaptation)
    medium = measured_colours(
        characterisation, intent, observer=observer, illuminant=illuminant, adaptation=adaptation
    )
    surface = _sample_surface(
        characterisation, medium, surface_samples, limits or InkLimits(), model
    )
    return replace(surface, as_measured=medium.as_measured, absolute=medium.absolute)


def colours_in_space(colours: SurfaceColours, space: ColourSpace) -> SurfaceColours:
    """Return the colours of a device in a space, with the space in their provenance.

    Parameters
    ----------
    colours : SurfaceColours
        In ICC's CIELAB.
    space : ColourSpace

    Returns
    -------
    SurfaceColours
        Its points are coordinates of the space.

    Raises
    ------
    InvalidPointsError
        As `ColourSpace.coordinates`.
    """
    points, moved = _coordinates(colours.points, colours, space)
    own = colours.own
    if own is not None:
        lab = own.points
        own = own._replace(points=lambda values: _coordinates(lab(values), colours, space)[0])
    described = space.description()
    if space.is_icc_cielab:
        described["adaptation"] = "none: the colours are relative to D50"
    elif _own_values(colours) is not None:
        described["adaptation"] = "none: the display's own colours, from before adaptation to D50"
    elif colours.as_measured:
        described["adaptation"] = "none: the colours are as measured"
    given = colours.provenance.get("warnings")
    warnings = list(given) if isinstance(given, list) else []
    if moved:
        warnings.append(
            f"{moved} of {len(points)} colours are outside of the domain of {space.name} (negative "
            "tristimulus values, for example) and were moved to the nearest colours in it."
        )
    provenance = {
        **colours.provenance,
        "colour_space": described,
        "axes": " ".join(space.axes),
        "warnings": warnings,
    }
    faces = None if colours.faces is None else outward_faces(points, colours.faces)
    return replace(colours, points=points, provenance=provenance, faces=faces, own=own)


def _coordinates(
    lab: FloatArray, colours: SurfaceColours, space: ColourSpace
) -> tuple[FloatArray, int]:
    own = _own_values(colours)
    if own is not None and not space.is_icc_cielab:
        icc = Cielab(white_point("D50"))
        lab, _ = icc.coordinates(icc.xyz(lab) @ own.T)
    return space.coordinates(lab, as_measured=colours.as_measured)


def _own_values(colours: SurfaceColours) -> FloatArray | None:
    """Return the matrix from absolute colours, which ICC scales by the white, to own ones."""
    if not colours.as_measured or colours.absolute is None:
        return None
    return colours.absolute.own_from("absolute")


def _profile_surface(
    profile: IccProfile, intent: str, surface_samples: int, limits: InkLimits
) -> SurfaceColours:
    channels = len(profile.channels)
    limited = limited_cube(
        profile.channels, np.zeros(channels), np.ones(channels), limits, inks=profile.inks
    )
    nodes = profile.transform(intent)[0].nodes

    def lab(values: FloatArray) -> FloatArray:
        return profile_colours(profile, values, intent).lab

    surface = _surface_values(limited, lab, surface_samples, nodes)
    density = surface.density
    colours = profile_colours(profile, surface.device, intent)
    points = colours.lab
    white, white_warnings = declared_white(profile)
    provenance: dict[str, JSON] = {
        **profile.provenance,
        "intent": intent,
        "white": white,
        "illuminant": "D50",
        "observer": "2°",
        "adaptation": colours.adaptation,
        **_declared_luminance(profile),
        **_limits_provenance(limited),
        "model": {"name": "ICC profile", "tag": colours.tag, "kind": _kind(colours)},
        "surface": {"points": len(points), "density": density},
        # each warning once
        "warnings": list[JSON](
            dict.fromkeys(
                [
                    *profile.warnings,
                    *colours.warnings,
                    *white_warnings,
                    *_count_warnings(len(points), surface_samples, density),
                    *impossible_colour_warnings(points, lights=profile.device_class in _LIGHTS),
                ]
            )
        ),
    }
    absolute = absolute_colours(profile)
    return SurfaceColours(
        points,
        surface.device,
        provenance,
        intent == "absolute" and absolute is not None and absolute.as_measured,
        profile.channels,
        surface.faces,
        _device_colours(limited, surface, lab),
        absolute,
    )


def _reference_surface(
    reference: Reference, intent: str, surface_samples: int, adaptation: str
) -> SurfaceColours:
    model: dict[str, JSON] = {"name": "none: the colours themselves"}
    faces: SurfaceFaces | None
    surface: DeviceSurface | None = None
    own: DeviceColours | None = None
    channels: tuple[str, ...] = ()
    if reference.kind == "rgb":
        channels, white = ("R", "G", "B"), reference_white(reference)
        curve, top = reference.definition["curve"], largest_code(reference)
        # PQ and HLG are nearly uniform, so their faces are divided evenly
        nodes = None if reference.peak else np.tile(encode_rgb(_LINEAR_NODES, curve), (3, 1))
        limited = limited_cube(channels, np.zeros(3), np.full(3, top), InkLimits(), inks=False)

        def rgb_lab(values: FloatArray) -> FloatArray:
            return reference_lab(rgb_xyz(reference, values), white, intent, adaptation)[0]

        surface = _surface_values(limited, rgb_lab, surface_samples, nodes)
        own = _device_colours(limited, surface, rgb_lab)
        xyz, faces = rgb_xyz(reference, surface.device), surface.faces
        encoding = curve if isinstance(curve, str) else f"γ {curve:g}"
        model = {"name": "primaries and white", "encoding": encoding}
    else:
        xyz, white, corners = surface_xyz(reference, surface_samples)
        faces = SurfaceFaces(corners, np.zeros(len(corners), np.int32), closed=True)
    lab, adapted = reference_lab(xyz, white, intent, adaptation)
    points: dict[str, JSON] = {"points": len(lab)}
    provenance: dict[str, JSON] = {
        **reference_provenance(reference, white),
        "channels": list(channels),
        "intent": intent,
        "adaptation": adapted,
        "model": model,
        "surface": points | ({} if surface is None else {"density": surface.density}),
        "warnings": [],
    }
    return SurfaceColours(
        lab,
        None if surface is None else surface.device,
        provenance,
        intent == "absolute",
        channels,
        faces=faces,
        own=own,
        absolute=AbsoluteColours(adaptation_matrix(ICC_D50, white, adaptation), as_measured=True),
    )


def _kind(colours: ProfileColours) -> str:
    return _KINDS.get(colours.kind, "matrix and curves")


def _surface_values(
    limited: LimitedCube,
    colours: Callable[[FloatArray], FloatArray],
    surface_samples: int,
    nodes: FloatArray | None = None,
) -> DeviceSurface:
    """Device values at the surface of the printable part of a device's cube."""
    cube = limited.cube
    if not len(cube.lowest):
        return DeviceSurface(limited.base[np.newaxis], "corners")
    whole = limited.free.all() and (cube.lowest == 0).all() and (cube.highest == 1).all()
    surface = device_surface(
        cube,
        lambda values: colours(limited.device(values)),
        surface_samples,
        nodes if whole else None,
    )
    return replace(surface, device=limited.device(surface.device))


def _device_colours(
    limited: LimitedCube,
    surface: DeviceSurface,
    lab: Callable[[FloatArray], FloatArray],
    samples: FloatArray | None = None,
) -> DeviceColours:
    """All colours of a device; `samples` are further device values, (m, n), to be tried."""
    tried = values_between(surface)
    if samples is not None:
        tried = np.concatenate([tried, samples])
    return DeviceColours(
        limited.cube, lambda values: lab(limited.device(values)), tried[:, limited.free]
    )


def _limits_provenance(limited: LimitedCube) -> dict[str, JSON]:
    return {} if limited.provenance is None else {"ink_limits": limited.provenance}


def _declared_luminance(profile: IccProfile) -> dict[str, JSON]:
    """Luminance of a display's white in the tag `lumi`; empty if it is missing or broken."""
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
        warnings += impossible_colour_warnings(medium.lab, lights=medium.lights)
        provenance["warnings"] = list[JSON](warnings)
        return SurfaceColours(medium.lab, None, provenance)

    device, lab = _mean_colours(samples.device, medium.lab)
    averaged, distinct = len(samples.device) - len(device), len(device)
    model = device_model(device, lab, kind)
    device, lab = model.device, model.lab
    if len(device) < distinct:
        warnings.append(f"The device model uses {len(device)} of {distinct} distinct samples.")
    provenance["patches"] = _patches(
        samples, len(device), averaged=averaged, thinned=distinct - len(device)
    )
    lowest, highest = device.min(axis=0), device.max(axis=0)
    limited = limited_cube(samples.channels, lowest, highest, limits, inks=samples.inks)
    provenance["model"] = model.provenance
    if model.colours is None:
        why = f"no device model can be fitted ({model.degenerate})"
        if limits:
            raise limits.refusal(f"{why}.")
        if kind is not None:
            raise OptionError.not_applicable("device_model", kind, why, _FIT_REMEDY)
        warnings.append(f"{why[:1].upper()}{why[1:]}; the samples' colours are used.")
        warnings += impossible_colour_warnings(lab, lights=medium.lights)
        provenance["warnings"] = list[JSON](warnings)
        return SurfaceColours(lab, device, provenance, channels=samples.channels)

    warnings += model.warnings
    warnings += range_warnings(samples, device, limited)
    if model.mean_error is not None and model.mean_error > _POOR_FIT:
        warnings.append(f"Left-out samples have a mean error of {model.mean_error:.1f} ΔE*ab.")
    fitted = model.colours

    def own_lab(values: FloatArray) -> FloatArray:
        lab = fitted(values)
        lab[:, 0] = np.maximum(lab[:, 0], 0.0)
        return lab

    surface = _surface_values(limited, fitted, surface_samples, model.nodes)
    density, points = surface.density, fitted(surface.device)
    dark = points[:, 0] < 0
    if dark.any():
        warnings.append(f"{int(dark.sum())} colours below L* 0 were raised to 0.")
        points[dark, 0] = 0.0
    corners = limited.device(surface_corners(limited.cube))
    warnings += extrapolation_warnings(corners, device, points, lab)
    warnings += impossible_colour_warnings(points, lights=medium.lights)
    warnings += _count_warnings(len(points), surface_samples, density)
    provenance["surface"] = {"points": len(points), "density": density}
    provenance.update(_limits_provenance(limited))
    provenance["warnings"] = list[JSON](warnings)
    printable = device[limited.contains(device)]
    return SurfaceColours(
        points,
        surface.device,
        provenance,
        channels=samples.channels,
        faces=surface.faces,
        own=_device_colours(limited, surface, own_lab, printable),
    )


def _patches(samples: Samples, used: int, *, averaged: int = 0, thinned: int = 0) -> JSON:
    """Numbers of patches that were read, dropped (in reading or here), averaged and used."""
    read, dropped = len(samples), 0
    counts = samples.provenance.get("patches")
    if isinstance(counts, dict):
        kept, lost = counts.get("read"), counts.get("dropped")
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
        return ["No channel of the device varies: its gamut is one colour."]
    why = (
        f"points on its faces as well would be more than surface_samples, {surface_samples}"
        if surface_samples < MAX_PATCHES
        else "its faces are too many"
    )
    return [f"Only the {points} corners of the device cube were sampled; {why}."]


def _mean_colours(device: FloatArray, lab: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distinct device values with the mean of their colours."""
    order = np.lexsort(device.T[::-1])
    ranked = device[order]
    first = np.ones(len(ranked), dtype=bool)
    first[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    starts = np.flatnonzero(first)
    counts = np.diff(np.append(starts, len(ranked)))
    sums = np.add.reduceat(lab[order], starts, axis=0)
    return ranked[starts], sums / counts[:, np.newaxis]


_SAME = 1e-6
"""Largest difference of device values that count as equal; files have at most six decimals."""


def own_tristimulus(colours: SurfaceColours) -> tuple[FloatArray, FloatArray]:
    """Return tristimulus values without adaptation, and luminances relative to the white.

    Parameters
    ----------
    colours : SurfaceColours
        In ICC's CIELAB.

    Returns
    -------
    xyz : (n, 3) float
        In an arbitrary common scale, which chromaticities do not depend on.
    luminance : (n,) float
    """
    xyz = lab_to_xyz(np.asarray(colours.points, np.float64))
    absolute = colours.absolute
    own = None if absolute is None else absolute.own_from(colours.provenance.get("intent"))
    return (xyz if own is None else xyz @ own.T), xyz[:, 1]


def display_primaries(colours: SurfaceColours) -> FloatArray | None:
    """Return tristimulus values of full red, green and blue, (3, 3), of a display or an RGB space.

    None for other devices and for pictures, and if one of the three is not among the colours.
    """
    facts = colours.provenance
    lights = (
        facts.get("format") == "reference"
        or str(facts.get("medium", "")).startswith("display")
        or facts.get("device_class") in {"display", "colour space"}
    )
    if colours.channels != ("R", "G", "B") or colours.device is None or not lights:
        return None
    low, high = colours.device.min(axis=0), colours.device.max(axis=0)
    wanted = np.where(np.eye(3, dtype=bool), high, low)
    near = np.abs(colours.device[np.newaxis] - wanted[:, np.newaxis]).max(axis=2) < _SAME
    matches = [np.flatnonzero(rows) for rows in near]
    if not all(len(each) for each in matches):
        return None
    xyz, _ = own_tristimulus(colours)
    return np.stack([xyz[each].mean(axis=0) for each in matches])


CELLS = 64
"""Cells along an edge of sRGB's cube. The volume is extrapolated from this number and half of it;
the error is below 0.001 % of the volume in all spaces (tests compare with 512 cells)."""


def described_volumes(
    mesh: TriangleMesh, space: ColourSpace, intent: object, absolute: AbsoluteColours | None
) -> dict[str, JSON]:
    """Return the volumes of a boundary for its description.

    Parameters
    ----------
    mesh : TriangleMesh
        The boundary, in the space.
    space : ColourSpace
    intent : str
        Of its colours.
    absolute : AbsoluteColours or None
        The way between both intents, if there is one.

    Returns
    -------
    dict
        ``srgb``: the volume of sRGB in the space, relative to its white. ``relative`` and
        ``absolute``: mappings of ``volume`` and ``times_srgb``; ``own`` instead of both for colours
        without such intents. An intent whose colours have no coordinates in the space is left out.
    """
    srgb = srgb_volume(space)
    volumes = {"own": mesh.volume}
    if absolute is not None and intent in {"relative", "absolute"}:
        volumes = {"relative": mesh.volume, "absolute": mesh.volume}
        other = "absolute" if intent == "relative" else "relative"
        converted = _converted_volume(mesh, space, absolute, other)
        if converted is None:
            del volumes[other]
        else:
            volumes[other] = converted
    return {
        "srgb": srgb,
        **{
            name: {"volume": volume, "times_srgb": round(volume / srgb, 6)}
            for name, volume in volumes.items()
        },
    }


def medium_white_lab(absolute: AbsoluteColours) -> list[JSON]:
    """Return L*, a*, b* of the medium's white with the intent absolute, relative to D50."""
    return [round(float(value), 3) + 0.0 for value in xyz_to_lab(absolute.matrix @ ICC_D50)]


@lru_cache(maxsize=64)
def srgb_volume(space: ColourSpace) -> float:
    """Return the volume of sRGB in a space, media-relative: its white is the white of the space.

    Examples
    --------
    >>> from gamutcore.colours.spaces import ColourSpace
    >>> round(srgb_volume(ColourSpace("CIELAB")), -3)
    833000.0
    """
    fine, coarse = (_cube_volume(space, cells) for cells in (CELLS, CELLS // 2))
    return (4.0 * fine - coarse) / 3.0  # the error falls with the square of the size of a cell


def _cube_volume(space: ColourSpace, cells: int) -> float:
    """Return the volume within triangles between the colours of a grid on the cube's faces."""
    steps = np.linspace(0.0, 1.0, cells + 1) ** 2  # dense near black, where PQ is steep
    one, two = (each.ravel() for each in np.meshgrid(steps, steps, indexing="ij"))
    corner = (np.arange(cells)[:, np.newaxis] * (cells + 1) + np.arange(cells)).ravel()
    down, right, across = corner + cells + 1, corner + 1, corner + cells + 2
    patch = np.concatenate(
        [np.stack([corner, down, across], axis=1), np.stack([corner, across, right], axis=1)]
    )
    points: list[FloatArray] = []
    faces: list[IndexArray] = []
    for axis in range(3):
        for end in (0.0, 1.0):
            values = np.empty((len(one), 3))
            values[:, axis], values[:, axis - 2], values[:, axis - 1] = end, one, two
            faces.append((patch if end else patch[:, ::-1]) + len(points) * len(one))
            points.append(values)
    colours = ColourConversion("sRGB", space).to_gamut(np.concatenate(points))
    return abs(TriangleMesh(colours, np.concatenate(faces)).volume)


def _converted_volume(
    mesh: TriangleMesh, space: ColourSpace, absolute: AbsoluteColours, intent: str
) -> float | None:
    """Return the volume of a boundary of the other intent; None without coordinates for it."""
    matrix, as_measured = absolute.matrix, absolute.as_measured
    if absolute.own is not None and as_measured and not space.is_icc_cielab:
        matrix = absolute.own
    if intent == "relative":
        matrix = np.linalg.inv(matrix).astype(np.float64)
    to_absolute = intent == "absolute"
    xyz = space.tristimulus(mesh.vertices, as_measured=as_measured and not to_absolute)
    try:
        points, _ = space.from_tristimulus(xyz @ matrix.T, as_measured=as_measured and to_absolute)
    except InvalidPointsError:
        return None
    volume = TriangleMesh(points, mesh.faces).volume
    return volume if np.isfinite(volume) else None
