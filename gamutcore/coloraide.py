"""Measured gamuts in coloraide, by plug-ins: the extra ``coloraide``.

After ``register(Color, "press", gamut)``, ``Color("blue").in_gamut("press")`` and
``Color("blue").fit("press")`` answer for the gamut.

Source: https://facelessuser.github.io/coloraide/plugins/gamut/ and the same address with ``fit``.
"""

from __future__ import annotations

from typing import Any

import coloraide.gamut
from coloraide import Color
from coloraide.util import DEF_FIT_TOLERANCE

from gamutcore.gamut import Gamut as MeasuredGamut

__all__ = ["Fit", "Gamut", "register"]

LAB = "lab"
"""CIELAB of coloraide, relative to D50: what gamutcore calls CIELAB."""


def register(
    color: type[Color], name: str, gamut: MeasuredGamut, *, method: str = "clip-hue"
) -> None:
    """Make a gamut known to a class of colours, as a gamut and as a method of `fit`.

    Parameters
    ----------
    color : type
        coloraide's ``Color``, or a class derived from it.
    name : str
        A name that no colour space of the class has. A gamut registered before is replaced.
    gamut : gamutcore.Gamut
        In any space. A print gamut relative to its medium has the white of the class as its paper.
    method : str, optional
        Default mapping of ``color.fit(name)``, as for `gamutcore.Gamut.map`.

    Raises
    ------
    ValueError
        A colour space has the name.
    """
    color.register([Gamut(name, gamut, method), Fit(name, gamut, method)], overwrite=True)


class Gamut(coloraide.gamut.Gamut):
    """Gamut plug-in: ``color.in_gamut(name)`` and ``color.fit(name)``."""

    def __init__(self, name: str, gamut: MeasuredGamut, method: str = "clip-hue") -> None:
        self.NAME = name
        self.gamut = gamut
        self.method = method

    def in_gamut(self, color: Color, tolerance: float, **options: Any) -> bool:  # noqa: ANN401
        """Whether a colour is in gamut, or within a tolerance in units of the gamut's space.

        coloraide's default tolerance is for channels of 0 to 1. Where it is passed, the accuracy of
        the gamut applies (`gamutcore.Gamut.tolerance`), so that no colour of the device is outside.
        `options` choose the level: ``triangles`` or ``max_error``.
        """
        limit = None if tolerance == DEF_FIT_TOLERANCE else tolerance
        inside = self.gamut.contains(_lab(color), space="CIELAB", tolerance=limit, **options)
        return bool(inside.item())

    def fit(self, color: Color, *, method: str | None = None, **options: Any) -> None:  # noqa: ANN401
        """Map a colour into the gamut in place.

        `method` and `options` are those of `gamutcore.Gamut.map`. The default method of the colour
        class, which is for RGB spaces, stands for that of the plug-in.
        """
        chosen = self.method if method in {None, color.FIT} else method
        _map(color, self.gamut, str(chosen), options)


class Fit(coloraide.gamut.Fit):
    """Fit plug-in: ``color.fit("srgb", method=name)`` maps by the gamut, then clips channels.

    With a gamut of the same RGB space in another one, such as
    ``gamutcore.reference("sRGB", space="Oklab")``, it is an exact nearest-point mapping there.
    """

    def __init__(self, name: str, gamut: MeasuredGamut, method: str = "clip-hue") -> None:
        self.NAME = name
        self.gamut = gamut
        self.method = method

    def fit(self, color: Color, space: str, **options: Any) -> None:  # noqa: ANN401
        """Map a colour into the gamut in place; it is then within the channels of `space`."""
        _map(color, self.gamut, self.method, options)
        color.clip(space)


def _lab(color: Color) -> list[float]:
    coordinates: list[float] = color.convert(LAB).coords(nans=False)
    return coordinates


def _map(color: Color, gamut: MeasuredGamut, method: str, options: dict[str, Any]) -> None:
    """Map a colour by a gamut. A colour that stays keeps its coordinates, undefined ones too."""
    lab = _lab(color)
    mapped = gamut.map(lab, method, space="CIELAB", **options).points.ravel().tolist()
    if mapped != lab:
        color.update(LAB, mapped, color[-1])
