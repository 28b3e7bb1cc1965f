"""The colours at the surface of a device's gamut, from its characterisation.

This is the only way from characterisation data to points in the colour space. Measured samples get
a device model, and the surface of the cube of device values is sampled densely. A profile is such a
model already. Bare colours are passed on. Every choice and assumption is in the provenance.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation import IccProfile, Picture
from gamutcore.characterisation.samples import JSON
from gamutcore.colours.colorimetry import ICC_D50, lab_to_xyz, xyz_to_lab
from gamutcore.colours.ink_limits import InkLimits
from gamutcore.colours.measured import measured_colours, sample_surface
from gamutcore.colours.picture import picture_colours
from gamutcore.colours.profile import profile_surface
from gamutcore.colours.reference import reference_surface
from gamutcore.colours.repeats import consistent_samples
from gamutcore.colours.sampling import (
    AbsoluteColours,
    SurfaceColours,
    outward_faces,
)
from gamutcore.colours.spaces import ColourConversion
from gamutcore.errors import InvalidPointsError
from gamutcore.geometry import TriangleMesh
from gamutcore.references import Reference

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, IndexArray
    from gamutcore.characterisation import Samples
    from gamutcore.colours.spaces import ColourSpace

INTENTS = ("relative", "absolute", "perceptual", "saturation")


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
    usable: bool = False,
) -> SurfaceColours:
    """Return colours at the surface of a device's gamut.

    Parameters that do not apply to the kind of data are ignored; `Options.check_data` refuses them.

    Parameters
    ----------
    characterisation : Samples, IccProfile, Picture or Reference
        As read by `gamutcore.characterisation.read_characterisation`.
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
    usable : bool
        Whether only the colours that a profile's B2A tables reach count.

    Raises
    ------
    OptionError
        The data does not have the intent; there are ink limits for a device without inks, an
        observer or illuminant for data without spectra, or a device model that the samples cannot
        have.
    CharacterisationError, InvalidPointsError
        The data is broken.
    """
    if isinstance(characterisation, Picture):
        return picture_colours(characterisation, intent, popularity, adaptation=adaptation)
    if isinstance(characterisation, IccProfile):
        limits = limits or InkLimits()
        return profile_surface(characterisation, intent, surface_samples, limits, usable=usable)
    if isinstance(characterisation, Reference):
        return reference_surface(characterisation, intent, surface_samples, adaptation)
    samples = consistent_samples(characterisation)
    medium = measured_colours(
        samples, intent, observer=observer, illuminant=illuminant, adaptation=adaptation
    )
    surface = sample_surface(samples, medium, surface_samples, limits or InkLimits(), model)
    return replace(surface, as_measured=medium.as_measured, absolute=medium.absolute)


def colours_in_space(colours: SurfaceColours, space: ColourSpace) -> SurfaceColours:
    """Return colours in ICC's CIELAB as coordinates of a space, which is in their provenance.

    Raises
    ------
    InvalidPointsError
        As `ColourSpace.coordinates`.
    """
    as_measured = colours.as_measured
    points, moved = space.coordinates(colours.points, as_measured=as_measured)
    device = colours.device_colours
    if device is not None:
        lab = device.points
        device = device._replace(
            points=lambda values: space.coordinates(lab(values), as_measured=as_measured)[0],
            measured=space.coordinates(device.measured, as_measured=as_measured)[0],
        )
    described = space.description()
    if space.is_icc_cielab:
        described["adaptation"] = "none: the colours are relative to D50"
    elif colours.as_measured:
        described["adaptation"] = "none: the colours are as measured"
    data_warnings = colours.provenance.get("warnings")
    warnings = list(data_warnings) if isinstance(data_warnings, list) else []
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
    return replace(
        colours, points=points, provenance=provenance, faces=faces, device_colours=device
    )


_SAME = 1e-6
"""Largest difference of device values that count as equal; files have at most six decimals."""


def own_tristimulus(colours: SurfaceColours) -> tuple[FloatArray, FloatArray]:
    """Return tristimulus values (n, 3) without adaptation, and luminances (n,), white 1.

    The colours are in ICC's CIELAB. The values have an arbitrary common scale, which chromaticities
    do not depend on.
    """
    xyz = lab_to_xyz(np.asarray(colours.points, np.float64))
    absolute = colours.absolute
    to_own = None if absolute is None else absolute.own_from(colours.provenance.get("intent"))
    return (xyz if to_own is None else xyz @ to_own.T), xyz[:, 1]


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
    if not all(len(rows) for rows in matches):
        return None
    xyz, _ = own_tristimulus(colours)
    return np.stack([xyz[rows].mean(axis=0) for rows in matches])


CELLS = 64
"""Cells along an edge of sRGB's cube. The volume is extrapolated from this number and half of it;
the error is below 0.001 % of the volume in all spaces (tests compare with 512 cells)."""


def volume_description(
    mesh: TriangleMesh,
    space: ColourSpace,
    intent: object,
    absolute: AbsoluteColours | None,
    device_volume: float | None,
) -> dict[str, JSON]:
    """Return the volumes of a boundary for its description.

    In ``volumes``, ``srgb`` is the volume of sRGB in the space, relative to its white. ``relative``
    and ``absolute`` have ``volume`` and ``times_srgb``; ``own`` instead of both for colours without
    such intents. The volume of the other intent than `intent` is that of the boundary with its
    vertices converted; it is left out if they have no coordinates in the space. `device_volume` is
    the volume within the device's own surface, if that is known.
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
    description: dict[str, JSON] = {
        "volume": mesh.volume,
        "volumes": {
            "srgb": srgb,
            **{
                name: {"volume": volume, "times_srgb": round(volume / srgb, 6)}
                for name, volume in volumes.items()
            },
        },
    }
    if device_volume is not None:
        description["device_surface_volume"] = device_volume
    if space.name in JUST_NOTICEABLE:
        volume = mesh.volume if device_volume is None else device_volume
        units = JUST_NOTICEABLE[space.name]
        description["distinguishable_colours"] = volume * units
    return description


JUST_NOTICEABLE = {"ITP": 1.0, "ICtCp": 720.0**3 / 2.0}
"""Distinguishable colours per unit of volume, in spaces with a distance in ΔE_ITP.

A ΔE_ITP of 1 is a just noticeable difference: 720³ · ∫ dI dT dP with T = Ct / 2 (ITU-R BT.2124-0,
annex 1). The measure is that of Pytlarz and Atkins, Measuring the Distinguishable Colors of HDR and
WCG Displays, Dolby Laboratories 2018.
"""


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
    one, two = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
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
