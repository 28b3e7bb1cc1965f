"""What decimation asks of a cost: four functions, overloaded for each cost's state.

The functions here are only names. A cost's module registers its compiled implementations with
`implement` for its own NamedTuple of arrays, and the decimation kernel is compiled
once for every such type: the choice costs nothing at run time, and the machine code can be cached.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from numba import types
from numba.extending import overload

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.decimation.star import Surface

__all__ = ["depends_on_ring", "error", "implement", "merge", "optimum"]


def optimum(cost: Any, surface: Surface, kept: int, dead: int, place: FloatArray) -> float:  # noqa: ANN401
    """Write the best position of the vertex that replaces an edge, and return its error.

    Parameters
    ----------
    cost : NamedTuple of arrays
    surface : Surface
    kept, dead : int
        The edge's ends.
    place : (3,) float64
        Receives the position, relative to the centre.

    Returns
    -------
    float
        As `error` gives it for that position.
    """
    raise TypeError(f"no implementation for {type(cost)}; compiled code calls its overloads")


def error(cost: Any, surface: Surface, kept: int, dead: int, place: FloatArray) -> float:  # noqa: ANN401
    """Cost of replacing an edge by a vertex at a position: the priority, smaller is better."""
    raise TypeError(f"no implementation for {type(cost)}; compiled code calls its overloads")


def merge(cost: Any, surface: Surface, kept: int, dead: int, place: FloatArray) -> None:  # noqa: ANN401
    """Bring the state up to date for a collapse; both ends are still where they were."""
    raise TypeError(f"no implementation for {type(cost)}; compiled code calls its overloads")


def depends_on_ring(cost: Any) -> bool:  # noqa: ANN401
    """Whether an edge's error changes when faces around it change, not only when its ends do."""
    raise TypeError(f"no implementation for {type(cost)}; compiled code calls its overloads")


def implement(
    state: type,
    *,
    optimum: Callable[..., float],
    error: Callable[..., float],
    merge: Callable[..., None],
    depends_on_ring: bool,
) -> None:
    """Register a cost's kernels as the implementation of this interface.

    Parameters
    ----------
    state : type
        The NamedTuple that the kernels take as their first argument.
    optimum, error, merge : callable
        Kernels with the signatures of the functions of this module.
    depends_on_ring : bool
        What the function of that name returns for this cost.
    """
    functions = globals()
    for name, implementation in (("optimum", optimum), ("error", error), ("merge", merge)):
        overload(functions[name])(_implementation_for(state, implementation))
    overload(functions["depends_on_ring"])(_constant_for(state, value=depends_on_ring))


def _is_state(cost: object, state: type) -> bool:
    return isinstance(cost, types.BaseNamedTuple) and getattr(cost, "instance_class", None) is state


def _implementation_for(state: type, implementation: Callable[..., Any]) -> Callable[..., Any]:
    # numba wants both functions to have the same parameters, annotations included
    def called(cost: Any, surface: Any, kept: Any, dead: Any, place: Any) -> Any:  # noqa: ANN401
        return implementation(cost, surface, kept, dead, place)

    def chosen(cost: Any, surface: Any, kept: Any, dead: Any, place: Any) -> Any:  # noqa: ANN401
        return called if _is_state(cost, state) else None

    return chosen


def _constant_for(state: type, *, value: bool) -> Callable[..., Any]:
    # a constant, so that the compiler drops what is not needed for the cost at hand
    def holds(cost: Any) -> bool:  # noqa: ANN401
        return True

    def fails(cost: Any) -> bool:  # noqa: ANN401
        return False

    def chosen(cost: Any) -> Any:  # noqa: ANN401
        return (holds if value else fails) if _is_state(cost, state) else None

    return chosen
