"""The costs of a collapse: one module each, all with the interface of `costs.interface`.

A cost is a module of this folder with a public ``state(positions, faces)`` that returns a
NamedTuple of arrays, the constants ``PRESERVES_VOLUME`` and ``PLAN``, and numba overloads of the
interface's functions for that NamedTuple. Modules are found by their names, so a further cost is a
further file and nothing else.
"""

from __future__ import annotations

import importlib
import pkgutil
from typing import TYPE_CHECKING, Protocol, cast

from gamutcore.errors import OptionError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, IndexArray
    from gamutcore.decimation.plan import Plan

__all__ = ["COSTS", "CostModule", "cost_module"]


class CostModule(Protocol):
    """What a cost's module offers besides its overloads.

    Attributes
    ----------
    PRESERVES_VOLUME : bool
        Whether all levels have the volume of the full boundary.
    PLAN : Plan
        In what stages it goes down.
    """

    PRESERVES_VOLUME: bool
    PLAN: Plan

    def state(self, positions: FloatArray, faces: IndexArray) -> tuple[FloatArray, ...]:
        """Return the cost's arrays for a full boundary (a NamedTuple)."""


COSTS: tuple[str, ...] = tuple(
    sorted(module.name for module in pkgutil.iter_modules(__path__) if module.name != "interface")
)
"""Names of all costs."""


def cost_module(name: str) -> CostModule:
    """Return the module of a cost.

    Parameters
    ----------
    name : str
        One of `COSTS`.

    Raises
    ------
    OptionError
        If there is no such cost.
    """
    if name not in COSTS:
        raise OptionError(
            f"there is no cost {name!r}",
            where={"field": "cost"},
            remedy=f"one of {', '.join(COSTS)}",
        )
    return cast("CostModule", importlib.import_module(f"{__name__}.{name}"))
