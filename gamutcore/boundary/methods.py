"""The boundary methods by name: what wraps the colours, and which options it takes.

One table that everything else reads: which names there are, which options apply to which method,
their defaults, and what is accepted. A further method is a further entry.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from gamutcore.boundary.modified_convex_hull import Boundary, modified_convex_hull
from gamutcore.boundary.segment_maxima import SEGMENTS, checked_segments, segment_maxima
from gamutcore.boundary.usv import checked_basis, checked_subdivisions, usv
from gamutcore.errors import OptionError
from gamutcore.numbers import finite_number

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike

__all__ = ["BOUNDARIES", "Method", "Parameter", "compute_boundary"]


class Parameter(NamedTuple):
    """An option of a boundary method.

    Attributes
    ----------
    default : object
    checked : callable
        From a value to its canonical form; raises an `OptionError` where it is not accepted.
    """

    default: object
    checked: Callable[[object], object]


class Method(NamedTuple):
    """A boundary method.

    Attributes
    ----------
    wrap : callable
        From points, ``centre`` and the method's parameters, as keywords, to a `Boundary`.
    parameters : dict
        The options that apply, by name.
    """

    wrap: Callable[..., Boundary]
    parameters: Mapping[str, Parameter]


def _checked_gamma(gamma: object) -> float:
    number = finite_number(gamma)
    if number is None or not 0 < number <= 1:
        raise OptionError.refusal("gamma", gamma, "a number above 0, at most 1")
    return number


def _gamma_of_the_convex_hull(gamma: object) -> float:
    if finite_number(gamma) != 1.0:
        raise OptionError.not_applicable(
            "gamma", gamma, "the convex hull is the modified one with a gamma of 1"
        )
    return 1.0


BOUNDARIES: dict[str, Method] = {
    "modified-convex-hull": Method(modified_convex_hull, {"gamma": Parameter(0.2, _checked_gamma)}),
    "convex-hull": Method(
        modified_convex_hull, {"gamma": Parameter(1.0, _gamma_of_the_convex_hull)}
    ),
    "segment-maxima": Method(segment_maxima, {"segments": Parameter(SEGMENTS, checked_segments)}),
    "usv": Method(
        usv,
        {
            "gamma": Parameter(0.05, _checked_gamma),
            "basis": Parameter("icosahedron", checked_basis),
            "subdivisions": Parameter(4, checked_subdivisions),
        },
    ),
}
"""Ways to wrap colours, by the name that the option ``boundary`` has for them."""


def compute_boundary(
    points: ArrayLike,
    method: str,
    centre: ArrayLike | Literal["auto"] = "auto",
    **parameters: Any,  # noqa: ANN401  # the method knows
) -> Boundary:
    """Wrap points in a closed surface by the method of a name.

    Parameters
    ----------
    points : (n, 3) array_like
    method : str
        One of `BOUNDARIES`.
    centre : (3,) array_like or "auto", optional
    **parameters
        Of the method; the rest have their defaults.

    Returns
    -------
    Boundary
        A vertex that is none of the points, as segment maxima have them, has the source −1. Where
        no power decides what is on the surface, γ is 0, its limit.

    Raises
    ------
    OptionError
        If a parameter is not accepted.
    InvalidPointsError, BoundaryError
        If no valid surface can be wrapped around the points.
    """
    chosen = BOUNDARIES[method]
    defaults = {name: parameter.default for name, parameter in chosen.parameters.items()}
    return chosen.wrap(points, centre=centre, **{**defaults, **parameters})
