"""The power γ of the modified convex hull, chosen by the data.

A large γ bridges concave regions. A small γ makes vertices of points inside the gamut: between two
neighbours at an angle θ, a point deeper by the share θ² ÷ 8 γ still sticks out of the raised hull.

- Scattered points get the paper's 0.2.
- The surface of a device with three channels gets the smallest value, because it has no inner
  points unless it is folded.
- Other device surfaces have inner points. Both errors together are least if γ is proportional to
  θ, that is to 1 ÷ √points.
- A boundary smaller than the device's surface has fallen into inner points. γ is then doubled
  until the boundary is large enough.

``docs/decisions/gamma.md`` has the figures.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["SCATTERED", "has_fallen", "surface_gammas"]

SCATTERED = 0.2
"""γ of scattered points (Balasubramanian & Dalal 1997; Bakke & Farup)."""

SMALLEST = 5e-5
"""γ of surfaces without inner points. Smaller values change volumes by less than 0.02 %. Larger
ones bridge the concave faces of film spaces."""

PER_ANGLE = 10.0
"""γ times √points for surfaces with inner points. Presses of four inks are exact to 0.01 % from 5
to 15, and the errors of seven inks balance at 11."""

LOST = 3e-4
"""Smallest relative loss of volume by which a boundary counts as fallen into inner points."""

LOST_PER_POINT = 10.0
"""The same, times the number of points: coarse surfaces lose some volume between their points."""


def surface_gammas(points: int, *, closed: bool) -> Iterator[float]:
    """Yield the values of γ to try for the surface of a device, ascending; the last is `SCATTERED`.

    A surface is `closed` with three channels.
    """
    if closed:
        yield SMALLEST
    gamma = round(PER_ANGLE / sqrt(points), 4)
    while gamma < SCATTERED:
        yield gamma
        gamma *= 2
    yield SCATTERED


def has_fallen(volume: float, surface_volume: float, points: int) -> bool:
    """Whether a boundary has lost so much volume that it has fallen into inner points."""
    return volume < surface_volume * (1 - max(LOST, LOST_PER_POINT / points))
