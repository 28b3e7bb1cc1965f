"""In what stages a cost's decimation goes down, and from where on several ways are tried."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

if TYPE_CHECKING:
    from gamutcore.arrays import IndexArray

__all__ = ["Fork", "Plan"]


class Fork(NamedTuple):
    """Where several ways down are tried, and by what the one to take is chosen.

    Attributes
    ----------
    vertices : int
        The level they begin at; boundaries with fewer vertices begin at once.
    ways : int
        How many there are. On the first, edges have the errors that they have; on the others these
        are disturbed.
    compared : tuple of int
        Levels, finest first, whose deviations are compared; the last one is where the ways end.
    """

    vertices: int
    ways: int
    compared: tuple[int, ...]


def _in_one_stage(*_: object) -> NoReturn:
    raise TypeError("the plan has no stages")


class Plan(NamedTuple):
    """The stages of a cost; without any, it goes down in one.

    Attributes
    ----------
    compacted : tuple of int
        Levels, by their vertices, from which on what is left lies side by side in memory.
    forks : tuple of Fork
    state_on : callable
        From the cost's state and the numbers of the vertices, (v,) int32, and faces, (f,) int32,
        that are left to its state on a surface of these; needed for stages.
    deviation : callable
        From the cost's state to the deviation of the present level; needed for forks.
    """

    compacted: tuple[int, ...] = ()
    forks: tuple[Fork, ...] = ()
    state_on: Callable[[Any, IndexArray, IndexArray], Any] = _in_one_stage
    deviation: Callable[[Any], float] = _in_one_stage
