"""What decimation asks of a cost: functions that are overloaded for each cost's state.

The functions here are only names. A cost's module registers its compiled implementations with
`implement` for its own NamedTuple of arrays, and the decimation kernel is compiled
once for every such type: the choice costs nothing at run time, and the machine code can be cached.
Costs only propose positions: that they are valid is tested by the kernel.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from numba import types
from numba.extending import overload

from gamutcore.kernels import leaf_kernel

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.decimation.star import Surface

__all__ = [
    "depends_on_ring",
    "eager_collapses",
    "error",
    "implement",
    "improve",
    "merge",
    "moves_vertices",
    "optimum",
    "preserves_volume",
    "reach",
    "settle",
]

# numba's annotations do not know all of its options
PART_OF_THE_CALLER: Any = {"forceinline": True, "_nrt": False}
"""How overloads are compiled, which do nothing but call a cost's kernel."""

UNKNOWN = "no implementation for {}; compiled code calls its overloads"


def optimum(cost: Any, surface: Surface, at: int, place: FloatArray) -> float:  # noqa: ANN401
    """Write the best position of the vertex that replaces an edge, and return its error.

    Parameters
    ----------
    cost : NamedTuple of arrays
    surface : Surface
    at : int
        One of the two corners that face the edge.
    place : (3,) float64
        Receives the position, relative to the centre.

    Returns
    -------
    float
        As `error` gives it for that position.
    """
    raise TypeError(UNKNOWN.format(type(cost)))


def error(cost: Any, surface: Surface, at: int, place: FloatArray) -> float:  # noqa: ANN401
    """Cost of replacing the edge that a corner faces by a vertex at a place: smaller is better."""
    raise TypeError(UNKNOWN.format(type(cost)))


def merge(
    cost: Any,  # noqa: ANN401
    surface: Surface,
    at: int,
    kept: int,
    dead: int,
    place: FloatArray,
) -> None:
    """Bring the state up to date for a collapse that is about to happen."""
    raise TypeError(UNKNOWN.format(type(cost)))


def settle(cost: Any, surface: Surface, at: int) -> None:  # noqa: ANN401
    """Bring the state up to date after a collapse to the vertex `at`, or a move of it."""
    raise TypeError(UNKNOWN.format(type(cost)))


def reach(cost: Any, surface: Surface, at: int) -> bool:  # noqa: ANN401
    """Prepare for levels with `at` vertices and fewer; whether all errors have changed by that."""
    raise TypeError(UNKNOWN.format(type(cost)))


def improve(cost: Any, surface: Surface, at: int, place: FloatArray) -> bool:  # noqa: ANN401
    """Write a better position for the vertex `at` than it has; whether there is one."""
    raise TypeError(UNKNOWN.format(type(cost)))


def depends_on_ring(cost: Any) -> bool:  # noqa: ANN401
    """Whether an edge's error changes when faces around it change, not only when its ends do."""
    raise TypeError(UNKNOWN.format(type(cost)))


def preserves_volume(cost: Any) -> bool:  # noqa: ANN401
    """Whether positions are rounded and placed so that the volume stays what it was."""
    raise TypeError(UNKNOWN.format(type(cost)))


def moves_vertices(cost: Any) -> bool:  # noqa: ANN401
    """Whether vertices around a collapse are moved after it, to what `improve` proposes."""
    raise TypeError(UNKNOWN.format(type(cost)))


def eager_collapses(cost: Any) -> int:  # noqa: ANN401
    """How many collapses before the end errors that may have changed are evaluated at once.

    Before that they are when their edge comes to the front: errors mostly grow as faces do, so an
    old one is seldom too large, and two thirds of the evaluations are saved.
    """
    raise TypeError(UNKNOWN.format(type(cost)))


def implement(
    state: type,
    *,
    optimum: Callable[..., float],
    error: Callable[..., float],
    merge: Callable[..., None],
    settle: Callable[..., None] | None = None,
    reach: Callable[..., bool] | None = None,
    improve: Callable[..., bool] | None = None,
    depends_on_ring: bool = False,
    preserves_volume: bool = False,
    eager_collapses: int = 0,
) -> None:
    """Register a cost's kernels as the implementation of this interface.

    Parameters
    ----------
    state : type
        The NamedTuple that the kernels take as their first argument.
    optimum, error, merge : callable
        Kernels with the signatures of the functions of this module.
    settle, reach, improve : callable, optional
        The same; without them nothing happens, nothing changes and no vertex is moved.
    depends_on_ring, preserves_volume : bool, optional
    eager_collapses : int, optional
        What the functions of these names return for this cost.
    """
    functions = globals()
    for name, kernel, adapted in (
        ("optimum", optimum, _adapted_to_place),
        ("error", error, _adapted_to_place),
        ("merge", merge, _adapted_to_edge),
        ("settle", settle or _nothing, _adapted),
        ("reach", reach or _no, _adapted),
        ("improve", improve or _no_place, _adapted_to_place),
    ):
        overload(functions[name], jit_options=PART_OF_THE_CALLER)(adapted(state, kernel))
    for name, value in (
        ("depends_on_ring", depends_on_ring),
        ("preserves_volume", preserves_volume),
        ("moves_vertices", improve is not None),
    ):
        overload(functions[name], jit_options=PART_OF_THE_CALLER)(_flag_for(state, value=value))
    overload(functions["eager_collapses"], jit_options=PART_OF_THE_CALLER)(
        _number_for(state, eager_collapses)
    )


@leaf_kernel
def _nothing(cost: Any, surface: Surface, at: int) -> None:  # noqa: ANN401
    pass


@leaf_kernel
def _no(cost: Any, surface: Surface, at: int) -> bool:  # noqa: ANN401
    return False


@leaf_kernel
def _no_place(cost: Any, surface: Surface, at: int, place: FloatArray) -> bool:  # noqa: ANN401
    return False


def _is_state(cost: object, state: type) -> bool:
    return isinstance(cost, types.BaseNamedTuple) and getattr(cost, "instance_class", None) is state


# numba wants an overload to have the parameters of what it overloads, names and annotations too


def _adapted(state: type, kernel: Callable[..., Any]) -> Callable[..., Any]:
    def called(cost: Any, surface: Any, at: Any) -> Any:  # noqa: ANN401
        return kernel(cost, surface, at)

    def chosen(cost: Any, surface: Any, at: Any) -> Any:  # noqa: ANN401
        return called if _is_state(cost, state) else None

    return chosen


def _adapted_to_place(state: type, kernel: Callable[..., Any]) -> Callable[..., Any]:
    def called(cost: Any, surface: Any, at: Any, place: Any) -> Any:  # noqa: ANN401
        return kernel(cost, surface, at, place)

    def chosen(cost: Any, surface: Any, at: Any, place: Any) -> Any:  # noqa: ANN401
        return called if _is_state(cost, state) else None

    return chosen


def _adapted_to_edge(state: type, kernel: Callable[..., Any]) -> Callable[..., Any]:
    def called(cost: Any, surface: Any, at: Any, kept: Any, dead: Any, place: Any) -> Any:  # noqa: ANN401
        return kernel(cost, surface, at, kept, dead, place)

    def chosen(cost: Any, surface: Any, at: Any, kept: Any, dead: Any, place: Any) -> Any:  # noqa: ANN401
        return called if _is_state(cost, state) else None

    return chosen


def _flag_for(state: type, *, value: bool) -> Callable[..., Any]:
    # a constant, so that the compiler drops what is not needed for the cost at hand
    def holds(cost: Any) -> bool:  # noqa: ANN401
        return True

    def fails(cost: Any) -> bool:  # noqa: ANN401
        return False

    def chosen(cost: Any) -> Any:  # noqa: ANN401
        return (holds if value else fails) if _is_state(cost, state) else None

    return chosen


def _number_for(state: type, number: int) -> Callable[..., Any]:
    def value(cost: Any) -> int:  # noqa: ANN401
        return number

    def chosen(cost: Any) -> Any:  # noqa: ANN401
        return value if _is_state(cost, state) else None

    return chosen
