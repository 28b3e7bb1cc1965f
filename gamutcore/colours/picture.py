"""The colours of a picture in CIELAB, and the channel values of a picture for colours.

The colours come from the embedded profile if there is one, else from the primaries and the transfer
function that the file declares or that are assumed. Pictures in CIELAB have their colours already.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.characterisation import IccProfile
from gamutcore.characterisation.pictures import MODELS, Encoding, Picture
from gamutcore.characterisation.samples import JSON, IntArray
from gamutcore.colours.colorimetry import (
    ICC_D50,
    adaptation_matrix,
    adaptation_text,
    adaptation_to_d50,
    chromaticity_xyz,
    decode_srgb,
    encode_srgb,
    lab_to_xyz,
    rgb_to_xyz,
    xyz_to_lab,
)
from gamutcore.colours.formulas import hlg_luminance, pq_luminance, pq_signal
from gamutcore.colours.profile import (
    absolute_colours,
    declared_white,
    profile_colours,
    values_by_curves,
)
from gamutcore.colours.reference import decode_rgb, encode_rgb
from gamutcore.colours.sampling import AbsoluteColours, SurfaceColours
from gamutcore.colours.spaces import DEFAULT_LUMINANCE
from gamutcore.errors import OptionError

POPULARITY_CELL = 2.0
"""Edge length in CIELAB of the cells in which pixels are counted for the popularity cut. Colours
within a cell are hardly distinguishable (a just noticeable difference is 2.3 ΔE*ab; Mahy et al.
1994)."""

_AT_A_TIME = 2**18


def picture_colours(
    picture: Picture,
    intent: str,
    popularity: float | None = None,
    *,
    adaptation: str = "Bradford",
) -> SurfaceColours:
    """Return the colours of a picture.

    `popularity` is the share of pixels, 0 to 1, that is left out: those of the least frequent
    colours. Profiles have all rendering intents. Without a profile, ``"relative"`` maps the
    encoding's white to D50, and ``"absolute"`` keeps its chromaticity. Adaptation is not used for
    profiles and CIELAB.
    """
    provenance: dict[str, JSON] = {**picture.provenance, "intent": intent}
    warnings = list(picture.warnings)
    absolute = None
    if isinstance(picture.meaning, IccProfile):
        absolute = absolute_colours(picture.meaning)
        lab, how, profile_warnings = _by_profile(picture, picture.meaning, intent)
        warnings += profile_warnings
    else:
        OptionError.check_intent(intent, "the picture has no profile")
        if isinstance(picture.meaning, Encoding):
            lab, how = _by_encoding(picture, picture.meaning, intent, adaptation)
            white = chromaticity_xyz(*picture.meaning.white)
            own = adaptation_matrix(ICC_D50, white, adaptation)
            absolute = AbsoluteColours(own, as_measured=True)
        else:
            if intent != "relative":
                raise OptionError.not_applicable(
                    "intent",
                    intent,
                    "the colours of a picture in CIELAB are used unchanged",
                    "Give relative, or leave it out.",
                )
            lab = picture.values
            how = {"white": None, "adaptation": "none: CIELAB as in the file"}
    provenance |= {**how, "illuminant": "D50", "observer": "2°"}
    values = picture.values
    is_device = picture.model not in {"Lab", "XYZ"} and values.min() >= 0 and values.max() <= 1
    if popularity is not None:
        rows, cells = popular(lab, picture.counts, popularity)
        pixels = int(picture.counts.sum())
        provenance["popularity"] = {
            "asked": popularity,
            "left_out": round(1 - int(picture.counts[rows].sum()) / pixels, 6),
            "cell": POPULARITY_CELL,
            "cells": cells,
        }
        lab, values = lab[rows], values[rows]
    provenance |= {
        "model": {"name": "none: the colours of the picture"},
        "surface": {"points": len(lab)},
        "warnings": list[JSON](dict.fromkeys(warnings)),
    }
    return SurfaceColours(
        lab,
        values if is_device else None,
        provenance,
        intent == "absolute" and absolute is not None and absolute.as_measured,
        MODELS[picture.model] if is_device else (),
        absolute=absolute,
    )


def popular(lab: FloatArray, counts: IntArray, share: float) -> tuple[IntArray, dict[str, JSON]]:
    """Return the indices, in order, of the colours that remain without the least frequent ones.

    Cells are left out by ascending number of pixels, up to `share` of all pixels. Cells with equal
    numbers stay or go together, so the result does not depend on their order.
    """
    # clip the extreme colours of broken profiles, whose cells need not be distinguished
    indices = np.floor(np.clip(lab / POPULARITY_CELL, -1e4, 1e4)).astype(np.int64)
    indices -= indices.min(axis=0)
    extent = indices.max(axis=0) + 1
    _, cell = np.unique(np.ravel_multi_index(tuple(indices.T), tuple(extent)), return_inverse=True)
    pixels = np.bincount(cell, counts).astype(np.int64)
    _, group = np.unique(pixels, return_inverse=True)
    taken = np.cumsum(np.bincount(group, pixels))
    lost = taken[group] <= share * pixels.sum()
    return np.flatnonzero(~lost[cell]), {"used": len(pixels), "left_out": int(lost.sum())}


def _by_profile(
    picture: Picture, profile: IccProfile, intent: str
) -> tuple[FloatArray, dict[str, JSON], tuple[str, ...]]:
    channels = len(profile.channels)
    lab = np.empty((len(picture), 3))
    colours = None
    for start in range(0, len(picture), _AT_A_TIME):
        values = picture.values[start : start + _AT_A_TIME]
        device = np.broadcast_to(values, (len(values), channels))  # gray is equal R, G and B
        colours = profile_colours(profile, np.ascontiguousarray(device), intent)
        lab[start : start + len(values)] = colours.lab
    assert colours is not None  # noqa: S101 (a picture has at least one colour)
    warnings = profile_warnings(profile, intent)
    outside = ((picture.values < 0) | (picture.values > 1)).any(axis=1)
    if outside.any() and colours.kind != "mpet":
        warnings.append(
            f"{int(outside.sum())} of {len(picture)} colours have values outside 0 to 1. The "
            "profile's transform clips them."
        )
    white, _ = declared_white(profile)
    how: dict[str, JSON] = {
        "white": white,
        "adaptation": colours.adaptation,
        "transform": colours.tag,
    }
    return lab, how, tuple(warnings)


def profile_warnings(profile: IccProfile, intent: str) -> list[str]:
    """Return what is wrong with the transform of a picture's profile, and with its white."""
    return [*profile.transform(intent)[1], *declared_white(profile)[1]]


def _by_encoding(
    picture: Picture, encoding: Encoding, intent: str, adaptation: str
) -> tuple[FloatArray, dict[str, JSON]]:
    white = chromaticity_xyz(*encoding.white)
    matrix = rgb_to_xyz(encoding.primaries, white)
    lab = np.empty((len(picture), 3))
    for start in range(0, len(picture), _AT_A_TIME):
        values = picture.values[start : start + _AT_A_TIME]
        light = _light(np.broadcast_to(values, (len(values), 3)), encoding, matrix[1])
        xyz = light @ matrix.T
        if intent == "relative":
            xyz = adaptation_to_d50(xyz, white, adaptation)
        lab[start : start + len(values)] = xyz_to_lab(xyz)
    text = "none"
    if intent == "relative":
        text = adaptation_text(adaptation, "the encoding's white")
    return lab, {"white": [round(float(value), 6) for value in white], "adaptation": text}


def _light(values: FloatArray, encoding: Encoding, luminance: FloatArray) -> FloatArray:
    """Linear RGB, 1 for white."""
    if encoding.transfer == "linear":
        return values
    if encoding.transfer == "power":
        light: FloatArray = values**encoding.gamma
        return light
    if encoding.transfer == "PQ":
        return pq_luminance(values) / DEFAULT_LUMINANCE
    if encoding.transfer == "HLG":
        return hlg_luminance(values, luminance) / DEFAULT_LUMINANCE
    if encoding.transfer == "sRGB":
        return decode_srgb(values)
    return decode_rgb(values, encoding.transfer)


def closed_form_values(lab: FloatArray, meaning: IccProfile | Encoding) -> FloatArray | None:
    """Return the channel values (n, 3), also beyond 0 to 1, of colours by an inverse formula.

    They are exact for encodings, and close for profiles of curves and a matrix. None for HLG and
    for other profiles.
    """
    if isinstance(meaning, IccProfile):
        return values_by_curves(meaning, lab)
    if meaning.transfer == "HLG":
        return None
    white = chromaticity_xyz(*meaning.white)
    matrix = adaptation_matrix(white, ICC_D50, "Bradford") @ rgb_to_xyz(meaning.primaries, white)
    light = lab_to_xyz(lab) @ np.linalg.inv(matrix).T
    if meaning.transfer == "linear":
        return light
    light = np.maximum(light, 0.0)
    if meaning.transfer == "power":
        values: FloatArray = light ** (1.0 / meaning.gamma)
        return values
    if meaning.transfer == "PQ":
        return pq_signal(light * DEFAULT_LUMINANCE)
    return encode_srgb(light) if meaning.transfer == "sRGB" else encode_rgb(light, "BT709")


ACCURACY = 1e-4
"""Distance in CIELAB at which a search ends: a fifteenth of a step of 16 bits."""

STEP = 1.0 / 1024.0
"""Difference of values for slopes. It has a slope at black also where the curve is a power."""

MOST_STEPS = 40


def find_values(
    lab: FloatArray,
    start: FloatArray,
    colours: Callable[[FloatArray], FloatArray],
    lowest: float = 0.0,
    highest: float = 1.0,
) -> tuple[FloatArray, FloatArray]:
    """Return values (n, 3) in the range whose colours are nearest to `lab`, and the distances (n,).

    Profiles have no inverse transform that is exact to 16 bits. The search by Levenberg (1944) and
    Marquardt (1963) begins at `start`, and ends at the nearest colour that it finds in the range.
    `colours` maps values (m, 3) to CIELAB. Distances are Euclidean.
    """
    values = np.clip(start, lowest, highest)
    if len(values) == 0:
        return values, np.empty(0)
    residual = lab - colours(values)
    distance = np.linalg.norm(residual, axis=1)
    damping = np.full(len(lab), 1e-3)
    for _ in range(MOST_STEPS):
        active = np.flatnonzero((distance > ACCURACY) & (damping < 1e6))
        if len(active) == 0:
            break
        at, wanted, left = values[active], lab[active], residual[active]
        slopes = _slopes(at, wanted - left, colours, highest)
        pull = np.einsum("nij,ni->nj", slopes, left)
        held = ((at <= lowest) & (pull < 0.0)) | ((at >= highest) & (pull > 0.0))
        slopes[np.broadcast_to(held[:, np.newaxis, :], slopes.shape)] = 0.0
        pull[held] = 0.0
        normal = np.einsum("nij,nik->njk", slopes, slopes)
        size = np.maximum(np.einsum("nii->n", normal) / 3.0, 1e-12)
        normal += (damping[active] * size)[:, np.newaxis, np.newaxis] * np.eye(3)
        step = np.linalg.solve(normal, pull[:, :, np.newaxis])[:, :, 0]
        tried = np.clip(at + step, lowest, highest)
        rest = wanted - colours(tried)
        length = np.linalg.norm(rest, axis=1)
        better = length < distance[active]
        rows = active[better]
        values[rows], residual[rows], distance[rows] = tried[better], rest[better], length[better]
        damping[active] *= np.where(better, 0.1, 10.0)
    return values, distance


def _slopes(
    values: FloatArray,
    lab: FloatArray,
    colours: Callable[[FloatArray], FloatArray],
    highest: float,
) -> FloatArray:
    """Return the derivatives (n, 3 of the colour, 3 of the values) by differences."""
    slopes = np.empty((len(values), 3, 3))
    for channel in range(3):
        step = np.where(values[:, channel] + STEP > highest, -STEP, STEP)
        moved = values.copy()
        moved[:, channel] += step
        slopes[:, :, channel] = (colours(moved) - lab) / step[:, np.newaxis]
    return slopes
