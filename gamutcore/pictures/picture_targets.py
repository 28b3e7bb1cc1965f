"""The encoding of a mapped picture: that of the picture, an RGB space, or a device.

The argument `to` names it. An RGB space is stated by an embedded profile, in OpenEXR by linear
light and its chromaticities. Device values come from the inverse device model.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from gamutcore.arguments import Choice, check_option
from gamutcore.characterisation import IccProfile
from gamutcore.characterisation.icc import icc_profile
from gamutcore.characterisation.pictures import Encoding, chromaticity_encoding
from gamutcore.errors import OptionError, ReferenceNameError
from gamutcore.export.picture_file import WRITTEN, in_encoding
from gamutcore.export.rgb_profile import rgb_profile
from gamutcore.questions import DEFAULT_BLACK, Parameter, black_rule, lab_of
from gamutcore.references import DECODINGS, REFERENCES, find_reference

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import ArrayLike, NDArray

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.pictures import Raster
    from gamutcore.colours import DeviceModel
    from gamutcore.colours.spaces import ColourConversion
    from gamutcore.export.picture_file import Depth
    from gamutcore.questions import GamutLike

__all__ = [
    "DECODE",
    "DEVICE",
    "OWN",
    "DeviceValues",
    "decoded_meaning",
    "device_raster",
    "device_target",
    "space_raster",
]

DECODE = Parameter(
    "decode",
    Annotated[str, Choice(tuple(DECODINGS))],
    "How the code values of the source become light. `bt1886`: as displays of video do, by an "
    "exponent of 2.4 and a black of 0 (ITU-R BT.1886). `oetf`: the inverse of the curve of cameras "
    "(BT.709, 1.2). `pq`, `hlg`: ITU-R BT.2100. `srgb`: IEC 61966-2-1. Default: as displays of the "
    "space or of the declared encoding do, which is `bt1886` for BT.709 and BT.2020.",
    example="bt1886",
)
"""The decoding of the source of links and pictures."""

OWN, DEVICE = "picture", "device"
"""Names of encodings beside RGB spaces."""

_NO_PROFILE = (
    "No profile is embedded: the gamut was not built here from an ICC profile. Assign the profile "
    "of the device to the picture."
)

_NO_ALPHA = (
    "Device values have no alpha: transparent pixels are blank, and others have their full colour."
)

_DISPLAYS = ("srgb", "display-p3", "adobe-rgb-1998", "bt2020", "prophoto-rgb")
"""Spaces that an error names; all others with the kind rgb are accepted too."""


@dataclass(frozen=True, eq=False)
class DeviceValues:
    """The device as the encoding of a picture.

    Attributes
    ----------
    model : DeviceModel
    recipes : callable
        From colours (n, 3) in CIELAB to device values (n, k), and their colours in CIELAB.
    tabulated : bool
        Whether recipes are so smooth that they may be interpolated unless exact ones are asked for.
    profile : bytes
        The ICC profile of the device; empty if none is known.
    """

    model: DeviceModel
    recipes: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    tabulated: bool
    profile: bytes

    @property
    def name(self) -> str:
        """The name of the encoding."""
        return f"device values {' '.join(self.model.channels)}"

    @property
    def blank(self) -> float:
        """The value of all channels where nothing is printed or light is full."""
        return 0.0 if self.model.inks else 1.0

    def codes(self, values: FloatArray, full: float) -> FloatArray:
        """Return device values (n, k) as whole codes, of which none exceeds the ink limits."""
        codes = values * full
        if not self.model.inks:
            return np.round(codes)
        limited = self.model.limited
        highest = limited.base.copy()
        highest[limited.free] = limited.cube.highest
        whole = np.minimum(np.round(codes), np.floor(full * highest + _ROUNDING))
        if limited.cube.total is not None:
            most = full * (limited.cube.total + limited.base[~limited.free].sum()) + _ROUNDING
            above = whole.sum(axis=1) > most
            whole[above] = np.floor(codes[above] + _ROUNDING)
        return whole


_ROUNDING = 1e-6
"""Rounding error of a code."""


def device_target(
    gamut: GamutLike,
    conversion: ColourConversion,
    black: str | float | ArrayLike | None,
) -> DeviceValues:
    """Return the device of a gamut as the encoding of pictures; `black` as for `recipes`."""
    model = gamut.device_model
    rule = black_rule(black, model)
    inverse = gamut.inverse_model

    def recipes(lab: FloatArray) -> tuple[FloatArray, FloatArray]:
        recipe = inverse.recipes(lab_of(gamut, conversion.to_gamut(lab)), rule)
        return recipe.device, recipe.lab

    recipes(np.array([(50.0, 0.0, 0.0)]))  # makes tables before threads need them
    is_smooth = rule is DEFAULT_BLACK and len(model.channels) <= _SMOOTH_CHANNELS
    return DeviceValues(model, recipes, is_smooth, gamut.profile or b"")


_SMOOTH_CHANNELS = 4
"""Recipes of more inks change their set of inks between nodes of a table."""


def device_raster(like: Raster, depth: Depth | None, device: DeviceValues) -> Raster:
    """Return how device values of a picture are written: with 8 or 16 bits, and without alpha."""
    if depth not in {None, "8", "16"}:
        raise OptionError.not_applicable(
            "depth", depth, "device values have 8 or 16 bits", "Give 8 or 16."
        )
    bits = depth or ("8" if like.dtype == np.uint8 else "16")
    made = replace(
        like,
        bands=iter(()),
        stored=f"uint{bits}",
        dtype=np.dtype(f"uint{bits}"),
        has_alpha=False,
        premultiplied=False,
        profile=device.profile,
        encoding=None,
        warnings=[],
    )
    if like.has_alpha:
        made.warnings.append(_NO_ALPHA)
    if not device.profile:
        made.warnings.append(_NO_PROFILE)
    return made


def decoded_meaning(
    meaning: IccProfile | Encoding, decode: str | None
) -> tuple[IccProfile | Encoding, tuple[str, ...]]:
    """Return what the values of a picture mean by a decoding of `DECODE`, and warnings."""
    if decode is None:
        return meaning, ()
    decode = str(check_option("decode", decode, DECODE.kind))
    if isinstance(meaning, IccProfile):
        why = "the embedded profile states how its values become light"
        raise OptionError.not_applicable("decode", decode, why)
    if meaning.transfer == "linear":
        raise OptionError.not_applicable("decode", decode, "the picture has linear light")
    curve = DECODINGS[decode]
    made = meaning.with_transfer(curve, decode)
    if (made.transfer, made.gamma) == (meaning.transfer, meaning.gamma):
        return meaning, ()
    return made, (f"The values are decoded by {decode}, as asked, and not as {meaning.name}.",)


def space_raster(
    like: Raster, own: IccProfile | Encoding, to: str, output: Path
) -> tuple[Raster, IccProfile | Encoding]:
    """Return how a picture is written in an RGB space, and what its values mean.

    `like` has the depth of the result, and `own` is what the values of the picture mean. The values
    of the result are for displays of the space.
    """
    try:
        reference = find_reference(to)
    except ReferenceNameError as error:
        raise _unknown(to, error.remedy) from None
    if reference.kind != "rgb" or reference.peak is not None:
        raise _unknown(to, "These are no RGB spaces relative to their white.")
    reference = reference.with_decoding()
    curve = reference.definition["curve"]
    primaries: Any = reference.primaries
    meaning: IccProfile | Encoding
    if WRITTEN.get(output.suffix.lower()) == "exr":
        corners = np.ravel((*primaries, reference.white)).astype(np.float32)
        stated = chromaticity_encoding(corners.tolist(), linear=True)
        assert stated is not None  # noqa: S101  # primaries of the catalogue
        return in_encoding(like, stated), replace(stated, name=reference.name)
    profile = rgb_profile(reference)
    if curve == "sRGB":
        meaning = Encoding(reference.name, primaries, reference.white)
    elif isinstance(curve, str):
        meaning = icc_profile(profile)
    else:
        transfer = "linear" if curve == 1.0 else "power"
        meaning = Encoding(reference.name, primaries, reference.white, transfer, float(curve))
    if (
        isinstance(meaning, Encoding)
        and isinstance(own, Encoding)
        and own == replace(meaning, name=own.name)
    ):
        meaning = own  # values of colours that stay are kept exactly
    return in_encoding(like, profile), meaning


def _unknown(to: str, why: str) -> OptionError:
    spaces = ", ".join(each for each in _DISPLAYS if each in REFERENCES)
    return OptionError(
        f"There is no encoding {to[:40]!r} of pictures.",
        where={"field": "to", "available": [OWN, DEVICE, *_DISPLAYS]},
        remedy=f"Give {OWN}, {DEVICE}, or an RGB space such as {spaces}. {why}",
    )


def full_scale(dtype: np.dtype[Any]) -> float:
    """Return the largest value of samples: 1 for floats."""
    return 1.0 if dtype.kind == "f" else float(np.iinfo(dtype).max)


def blank_samples(device: DeviceValues, count: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return samples (n, k) of blank pixels."""
    blank = device.blank * full_scale(dtype)
    return np.full((count, len(device.model.channels)), blank, dtype)
