"""Soft proofs: pictures of CMYK as light, by their embedded profile.

The light is unbounded, so that no colour is lost before it is mapped.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.characterisation.embedded_data import stated_ink_limit
from gamutcore.characterisation.pictures import LINEAR, divided_by_alpha
from gamutcore.colours import closed_form_values, lab_to_xyz, luminance_of_black
from gamutcore.colours.profile import profile_colours

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation import IccProfile
    from gamutcore.characterisation.pictures import Raster

__all__ = ["PROOF_SPACE", "PROOF_SPACE_CHOSEN", "black_of_press", "light_raster"]

PROOF_SPACE = "srgb"
"""Encoding of a soft proof for which none is asked."""

PROOF_SPACE_CHOSEN = "The picture is CMYK: the result has sRGB. `to` names another encoding."

_STEPS = 17
"""Levels of cyan, magenta and yellow among which the black is sought."""

_NEUTRAL = 1.0
"""Largest chroma in CIELAB of a black."""


def light_raster(raster: Raster, profile: IccProfile) -> Raster:
    """Return a raster of CMYK as linear light of `LINEAR`, with straight alpha."""

    def bands() -> Iterator[tuple[int, NDArray[Any], NDArray[Any] | None]]:
        for row, samples, alpha in raster.bands:
            inks = samples
            if alpha is not None and raster.premultiplied:
                opaque = alpha > 0
                inks = samples.copy()
                inks[opaque] = divided_by_alpha(samples[opaque], alpha[opaque])
            share = None if alpha is None else _fractions(alpha).astype(np.float32)
            yield row, _light(inks, profile), share

    return replace(
        raster,
        model="RGB",
        dtype=np.dtype(np.float32),
        bands=bands(),
        premultiplied=False,
        profile=b"",
        encoding=LINEAR,
    )


def _light(inks: NDArray[Any], profile: IccProfile) -> NDArray[np.float32]:
    """Return linear light (n, 3) of samples; equal ones are calculated once."""
    place: Any = slice(None)
    if inks.dtype.kind != "f":
        key = np.ascontiguousarray(inks).view(f"u{4 * inks.dtype.itemsize}").ravel()
        _, first, place = np.unique(key, return_index=True, return_inverse=True)
        inks = inks[first]
    lab = profile_colours(profile, _fractions(inks), "relative").lab
    light = closed_form_values(lab, LINEAR)
    assert light is not None  # noqa: S101  # linear light has a formula
    samples: NDArray[np.float32] = light.astype(np.float32)[place]
    return samples


def _fractions(samples: NDArray[Any]) -> FloatArray:
    full = 1.0 if samples.dtype.kind == "f" else float(np.iinfo(samples.dtype).max)
    return samples.astype(np.float64) / full


def black_of_press(profile: IccProfile) -> float:
    """Return the luminance of the darkest neutral of CMYK within the ink limit of the profile."""
    limit = stated_ink_limit(profile)
    total = 4.0 if limit is None else limit.total / 100.0
    levels = np.linspace(0.0, 1.0, _STEPS)
    inks = np.stack(np.meshgrid(levels, levels, levels, [1.0], indexing="ij"), -1).reshape(-1, 4)
    inks = inks[inks.sum(axis=1) <= total + 1e-9]
    if len(inks) == 0:  # less than full black
        inks = np.array([(0.0, 0.0, 0.0, total)])
    lab = profile_colours(profile, inks, "relative").lab
    neutral = lab[np.hypot(lab[:, 1], lab[:, 2]) <= _NEUTRAL]
    darkest = min(neutral if len(neutral) else lab, key=lambda each: float(each[0]))
    return luminance_of_black(lab_to_xyz(np.array([(darkest[0], 0.0, 0.0)]))[0])
