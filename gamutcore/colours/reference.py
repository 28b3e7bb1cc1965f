"""Colours of reference gamuts: RGB spaces, Pointer's gamut, the PRMG and the optimal colours.

The primaries and the white of an RGB space give the matrix of its linear values. Pointer's colours
and those of the PRMG are published tables, closed by the neutral colours in the middle of their
first and last ring. An optimal colour reflects all light of one band of wavelengths and none of the
rest, or the reverse.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isqrt
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from gamutcore.characterisation.samples import JSON
from gamutcore.colours.colorimetry import (
    ICC_D50,
    adaptation_matrix,
    adaptation_text,
    adaptation_to_d50,
    chromaticity_xyz,
    colour_science,
    lab_to_xyz,
    xyz_to_lab,
)
from gamutcore.colours.formulas import hlg_luminance, pq_luminance, pq_signal
from gamutcore.colours.ink_limits import InkLimits, limited_cube
from gamutcore.colours.measured import illuminated_functions
from gamutcore.colours.models import Arrays, DeviceFunction, DeviceModel, device_function
from gamutcore.colours.sampling import (
    AbsoluteColours,
    SurfaceColours,
    SurfaceFaces,
    device_colours,
    surface_values,
)
from gamutcore.colours.spaces import DEFAULT_LUMINANCE
from gamutcore.errors import OptionError
from gamutcore.references import (
    PRMG_CHROMA,
    PRMG_LIGHTNESS,
    REFERENCES,
    Reference,
    parse_definition,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.arrays import FloatArray, IndexArray, LongArray

RGB_CURVES: dict[str, tuple[float, float, float, float, float]] = {
    "sRGB": (2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045),  # IEC 61966-2-1
    "ROMM": (1.8, 1.0, 0.0, 1 / 16, 0.03125),  # ISO 22028-2
    "BT709": (1 / 0.45, 1 / 1.099, 0.099 / 1.099, 1 / 4.5, 0.081),  # ITU-R BT.709-6, 1.2
    "SMPTE240M": (1 / 0.45, 1 / 1.1115, 0.1115 / 1.1115, 1 / 4, 0.0913),  # SMPTE 240M, 7
    "L*": (3.0, 1 / 1.16, 0.16 / 1.16, 2700 / 24389, 0.08),  # eciRGB v2; CIE 15:2018, 8.2.1
}
"""Transfer curves with a linear part: g, a, b, c and d of Y = (aX + b)^g from d on, cX below
(ICC.1:2022, table 68, function 3)."""

_LINEAR_NODES = np.linspace(0.0, 1.0, 17) ** 2
"""Linear values that divide the edges of an RGB space, denser in the dark as lightness is."""

_FEWEST_BANDS = 16


def decode_rgb(values: FloatArray, curve: str | float) -> FloatArray:
    """Return linear values of encoded ones, 0 to 1, by a key of `RGB_CURVES` or an exponent.

    Scene-referred spaces have the exponent 1: their curves reach beyond the diffuse white.
    """
    if not isinstance(curve, str):
        return values**curve
    g, a, b, c, d = RGB_CURVES[curve]
    decoded: FloatArray = np.where(values >= d, np.maximum(a * values + b, 0) ** g, c * values)
    return decoded


def encode_rgb(linear: FloatArray, curve: str | float) -> FloatArray:
    """Return encoded values of linear ones; the inverse of `decode_rgb`."""
    if not isinstance(curve, str):
        return linear ** (1 / curve)
    g, a, b, c, d = RGB_CURVES[curve]
    encoded: FloatArray = np.where(linear >= c * d, (linear ** (1 / g) - b) / a, linear / c)
    return encoded


def primary_matrix(reference: Reference) -> FloatArray:
    """Return the matrix (3, 3) from linear RGB to XYZ with Y = 1 for the white: ``matrix @ rgb``.

    SMPTE RP 177: Derivation of basic television color equations.
    """
    chromaticities = np.array([(x, y, 1 - x - y) for x, y in reference.primaries]).T
    amounts = np.linalg.solve(chromaticities, reference_white(reference))
    matrix: FloatArray = chromaticities * amounts
    return matrix


def reference_white(reference: Reference) -> FloatArray:
    """Return XYZ of a reference's white, with Y = 1."""
    return chromaticity_xyz(*reference.white)


def rgb_xyz(reference: Reference, values: FloatArray) -> FloatArray:
    """Return XYZ (n, 3) of an RGB space's encoded values (n, 3) from 0 to 1.

    Y is 1 for the white, or for 203 cd/m² with a peak luminance (ITU-R BT.2408-7, 2.2).
    """
    matrix, curve, peak = primary_matrix(reference), reference.definition["curve"], reference.peak
    if peak is None:
        return decode_rgb(values, curve) @ matrix.T
    if curve == "HLG":
        light = hlg_luminance(values, matrix[1])
    else:
        light = np.minimum(pq_luminance(values), peak)
    return light @ matrix.T / DEFAULT_LUMINANCE


def largest_code(reference: Reference) -> float:
    """Return the code of the peak luminance; larger codes have the same light."""
    if reference.definition["curve"] != "PQ":
        return 1.0
    return float(pq_signal(np.array(float(reference.peak or 0.0))))


def _pointer_xyz(white: FloatArray) -> tuple[FloatArray, IndexArray]:
    """The colours of Pointer's gamut, with Y = 1 for the perfect diffuser, and their triangles."""
    colour_science()
    from colour.models.datasets import pointer_gamut  # noqa: PLC0415  # takes a second

    lightness, chroma, hue = np.asarray(pointer_gamut.DATA_POINTER_GAMUT_VOLUME, np.float64).T
    angle = np.radians(hue)
    lab = np.stack([lightness, chroma * np.cos(angle), chroma * np.sin(angle)], axis=1)
    caps = [[lightness.min(), 0.0, 0.0], [lightness.max(), 0.0, 0.0]]
    return lab_to_xyz(np.concatenate([lab, caps]), white), _ring_faces(16, 36)


def _prmg_xyz(white: FloatArray) -> tuple[FloatArray, IndexArray]:
    """The colours of the PRMG, with Y = 1 for the white of its medium, and their triangles."""
    chroma = np.asarray(PRMG_CHROMA, np.float64).T[1:-1]  # the first and the last are neutral
    rings, hues = chroma.shape
    angle = np.radians(np.arange(hues) * 360.0 / hues)
    height = np.broadcast_to(np.array(PRMG_LIGHTNESS)[1:-1, np.newaxis], chroma.shape)
    lab = np.stack([height, chroma * np.cos(angle), chroma * np.sin(angle)], axis=-1)
    caps = [[PRMG_LIGHTNESS[0], 0.0, 0.0], [PRMG_LIGHTNESS[-1], 0.0, 0.0]]
    xyz = lab_to_xyz(np.concatenate([lab.reshape(-1, 3), caps]), white)
    return xyz, _ring_faces(rings, hues)


def _ring_faces(rings: int, points: int) -> IndexArray:
    """Triangles between rings of points, closed by a point in the middle of either end."""
    here = np.arange(points)
    after = (here + 1) % points
    bottom, top = np.full(points, rings * points), np.full(points, rings * points + 1)
    faces = [np.stack([bottom, after, here], axis=1)]
    for start in range(0, (rings - 1) * points, points):
        above = start + points
        faces.append(np.stack([start + here, start + after, above + after], axis=1))
        faces.append(np.stack([start + here, above + after, above + here], axis=1))
    last = (rings - 1) * points
    faces.append(np.stack([last + here, last + after, top], axis=1))
    return np.concatenate(faces).astype(np.int32)


def reference_lab(
    xyz: FloatArray, white: FloatArray, intent: str, adaptation: str
) -> tuple[FloatArray, str]:
    """Return the colours of a reference in ICC's CIELAB, (n, 3), and the adaptation in words.

    ``"relative"`` adapts the white to D50; ``"absolute"`` adapts nothing. Y is 1 for the white.
    """
    if intent == "absolute":
        return xyz_to_lab(xyz), "none"
    OptionError.check_intent(intent, "the data is a reference gamut")
    lab = xyz_to_lab(adaptation_to_d50(xyz, white, adaptation))
    return lab, adaptation_text(adaptation, "the white")


@device_function
@dataclass(frozen=True, eq=False)
class RgbSpace(DeviceFunction):
    """The primaries, white and curve of an RGB space.

    `reference` has the curve that decodes the values, by default that of displays.
    """

    kind: ClassVar[str] = "rgb"
    reference: Reference
    intent: str
    adaptation: str

    @property
    def is_for_displays(self) -> bool:
        """Whether displays decode the values by another curve than that of the definition."""
        return REFERENCES[self.reference.slug].display is not None

    def with_decoding(self, decode: str) -> Self:
        """Return the space whose values are decoded by one of `DECODINGS`."""
        reference = REFERENCES[self.reference.slug].with_decoding(decode)
        return replace(self, reference=reference)

    def lab(self, device: FloatArray) -> FloatArray:
        """Return colours as `reference_lab`."""
        white = reference_white(self.reference)
        xyz = rgb_xyz(self.reference, device)
        return reference_lab(xyz, white, self.intent, self.adaptation)[0]

    def closed_values(self, lab: FloatArray) -> FloatArray | None:
        """Return the encoded values of colours, clipped to 0 to 1; None with a peak luminance."""
        if self.reference.peak is not None:
            return None
        matrix = primary_matrix(self.reference)
        if self.intent != "absolute":
            white = reference_white(self.reference)
            matrix = adaptation_matrix(white, ICC_D50, self.adaptation) @ matrix
        linear = lab_to_xyz(lab) @ np.linalg.inv(matrix).T
        return encode_rgb(np.clip(linear, 0.0, 1.0), self.reference.definition["curve"])

    def parts(self) -> tuple[Arrays, dict[str, Any]]:
        """Return the definition of the space."""
        facts = {"intent": self.intent, "adaptation": self.adaptation}
        definition = REFERENCES[self.reference.slug].data
        return {"definition": np.frombuffer(definition, np.uint8)}, facts

    @classmethod
    def of(cls, arrays: Arrays, facts: Mapping[str, Any]) -> Self:
        """Return the function of its parts."""
        reference = parse_definition(arrays["definition"].tobytes().decode())
        if reference is None:
            raise ValueError("no definition")
        return cls(reference.with_decoding(), str(facts["intent"]), str(facts["adaptation"]))


def optimal_colours(illuminant: str, observer: int, count: int) -> FloatArray:
    """Return the tristimulus values of optimal colours (n, 3), at most `count` (MacAdam 1935).

    They are black, white, and the b·(b − 1) bands between b wavelengths, with Y = 1 for the white.
    The wavelengths are dense where the bands that end there change fast in CIELAB.
    """
    weights = illuminated_functions(illuminant, observer)
    weights = weights / weights[:, 1].sum()  # the sum is the white, with Y = 1
    bands = max(_FEWEST_BANDS, (1 + isqrt(max(4 * count - 7, 1))) // 2)
    if bands < len(weights):
        weights = _merged_weights(weights, bands)
    bands = len(weights)
    sums = np.zeros((2 * bands + 1, 3))
    np.cumsum(np.concatenate([weights, weights]), axis=0, out=sums[1:])
    start, width = np.meshgrid(np.arange(bands), np.arange(1, bands), indexing="ij")
    parts = (sums[start + width] - sums[start]).reshape(-1, 3)
    return np.concatenate([np.zeros((1, 3)), parts, sums[bands : bands + 1]])


def optimal_faces(count: int) -> IndexArray:
    """Return triangles (2·(count − 2), 3) between `count` optimal colours: the zonoid's faces.

    Each is a parallelogram: a band, with a wavelength more at its end, less at its start, and both.
    """
    bands = (1 + isqrt(4 * count - 7)) // 2
    start, width = (
        grid.astype(np.int64).ravel()
        for grid in np.meshgrid(np.arange(bands), np.arange(1, bands), indexing="ij")
    )

    def index(start: LongArray, width: LongArray) -> LongArray:
        band = 1 + start % bands * (bands - 1) + width - 1
        colour_numbers: LongArray = np.where(
            width == 0, 0, np.where(width == bands, count - 1, band)
        )
        return colour_numbers

    band, longer = index(start, width), index(start, width + 1)
    shorter, moved = index(start + 1, width - 1), index(start + 1, width)
    # the other diagonal would fold 4 % of the area in CIELAB, this one 0.02 %
    faces = np.concatenate(
        [np.stack([band, longer, moved], axis=1), np.stack([band, moved, shorter], axis=1)]
    )
    return faces.astype(np.int32)


def _merged_weights(weights: FloatArray, bands: int) -> FloatArray:
    """Weights of fewer, wider bands, which add up to the same white."""
    sums = np.zeros((len(weights) + 1, 3))
    np.cumsum(weights, axis=0, out=sums[1:])
    white = sums[-1]
    change = sum(
        np.linalg.norm(
            np.diff(xyz_to_lab(adaptation_to_d50(ends, white, "Bradford")), axis=0), axis=1
        )
        for ends in (sums, white - sums)
    )
    places = np.concatenate([[0.0], np.cumsum(change)])
    chosen = np.interp(np.linspace(0, places[-1], bands + 1), places, np.arange(len(places)))
    ends = np.stack([np.interp(chosen, np.arange(len(sums)), column) for column in sums.T], axis=1)
    return np.diff(ends, axis=0)


def _for_displays(values: FloatArray, reference: Reference) -> FloatArray:
    """Return values by the curve of displays that have the light of values of the definition."""
    linear = decode_rgb(values, reference.definition["curve"])
    encoded = encode_rgb(linear, reference.with_decoding().definition["curve"])
    ends = (values == 0.0) | (values == 1.0)
    display_values: FloatArray = np.where(ends, values, np.clip(encoded, 0.0, 1.0))
    return display_values


def reference_surface(
    reference: Reference, intent: str, surface_samples: int, adaptation: str
) -> SurfaceColours:
    """Return the colours at the surface of a reference gamut."""
    white = reference_white(reference)
    model: dict[str, JSON] = {"name": "none: the colours themselves"}
    density: dict[str, JSON] = {}
    luminances: dict[str, JSON] = {}
    if reference.peak is not None:
        luminances = {"peak_luminance": reference.peak, "white_luminance": DEFAULT_LUMINANCE}
    own, device = None, None
    channels: tuple[str, ...] = ()
    faces: SurfaceFaces | None
    if reference.kind == "rgb":
        channels = ("R", "G", "B")
        curve, top = reference.definition["curve"], largest_code(reference)
        # PQ and HLG are nearly uniform, so their faces are divided evenly
        nodes = None if reference.peak else np.tile(encode_rgb(_LINEAR_NODES, curve), (3, 1))
        limited = limited_cube(channels, np.zeros(3), np.full(3, top), InkLimits(), inks=False)
        function = RgbSpace(reference, intent, adaptation)
        surface = surface_values(limited, function.lab, surface_samples, nodes)
        model_for_displays = DeviceModel(
            channels, False, limited, replace(function, reference=reference.with_decoding())
        )
        own = device_colours(DeviceModel(channels, False, limited, function), surface)
        own = own._replace(model=model_for_displays)
        device, density, faces = surface.device, {"density": surface.density}, surface.faces
        xyz = rgb_xyz(reference, device)
        encoding = curve if isinstance(curve, str) else f"γ {curve:g}"
        if reference.display is not None:  # samples lie by the definition, values are for displays
            device = _for_displays(device, reference)
            encoding = reference.with_decoding().decoding
        model = {"name": "primaries and white", "encoding": encoding}
    else:
        if reference.kind == "optimal":
            xyz = optimal_colours(reference.illuminant, reference.observer, surface_samples)
            white, corners = xyz[-1], optimal_faces(len(xyz))
        else:
            tables = {"Pointer 1980": _pointer_xyz, "PRMG": _prmg_xyz}
            xyz, corners = tables[reference.definition["colours"]](white)
        faces = SurfaceFaces(corners, np.zeros(len(corners), np.int32), closed=True)
    # media-relative colours of a print are scaled by its white (ICC.1:2022, 6.3.2.2)
    paper = float(reference.definition.get("white_reflectance", 1.0))
    if intent == "absolute":
        xyz = xyz * paper
    lab, adapted = reference_lab(xyz, white, intent, adaptation)
    absolute = paper * adaptation_matrix(ICC_D50, white, adaptation)
    provenance: dict[str, JSON] = {
        "format": "reference",
        "reference": reference.slug,
        "source": reference.source,
        "white": [round(float(value), 6) for value in white],
        "illuminant": reference.illuminant,
        "observer": f"{reference.observer}°",
        **luminances,
        "channels": list(channels),
        "intent": intent,
        "adaptation": adapted,
        "model": model,
        "surface": {"points": len(lab), **density},
        "warnings": [],
    }
    return SurfaceColours(
        lab,
        device,
        provenance,
        intent == "absolute",
        channels,
        faces=faces,
        device_colours=own,
        absolute=AbsoluteColours(absolute, as_measured=True),
    )
