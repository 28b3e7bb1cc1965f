"""Transforms of multi-process elements: the tags `D2Bx`, and `A2Bx` of iccMAX profiles.

A chain of elements over floating-point numbers gives colours in the connection space, without an
encoding. Curve sets, matrices and lookup tables are evaluated; markers for future expansion are
skipped; other kinds are refused by name. The work per colour is limited when a tag is read.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.icc.element import Element
from gamutcore.characterisation.icc.grid import checked_positions, multilinear
from gamutcore.characterisation.icc.lut import (
    MAX_GRID_NODES,
    CurveSet,
    Matrix,
    Stage,
    Transform,
)
from gamutcore.characterisation.icc.segments import segmented_curve_at
from gamutcore.errors import UnsupportedProfileError

if TYPE_CHECKING:
    import numpy.typing as npt

    from gamutcore.arrays import FloatArray

__all__ = ["FloatGrid", "process_elements_transform"]

MAX_ELEMENTS = 32
"""Maximum number of elements in a tag. Real tags have two to six."""
MAX_CHANNELS = 16
"""Maximum number of channels between elements. 100,000 colours with 16 channels take 13 MB."""
MAX_GRIDS = 2
"""Maximum number of lookup tables in a tag, because each can be as slow as another profile."""
MAX_GRID_INPUTS = 16
"""Maximum number of inputs of a lookup table (ICC.1:2022, table 66)."""

_PASSED_THROUGH = (b"bACS", b"eACS")
"""Markers without a calculation (ICC.1:2022, 10.18.1)."""


@dataclass(frozen=True, eq=False)
class FloatGrid:
    """A lookup table (CLUT) of floating-point numbers with any number of outputs.

    Attributes
    ----------
    nodes : tuple of int
        Nodes along each dimension, each at least 2.
    tables : tuple of (product of nodes, 3) float32
        Three outputs each, the last dimension varying fastest. Zeros fill the last table.
    """

    nodes: tuple[int, ...]
    tables: tuple[npt.NDArray[np.float32], ...]
    outputs: int

    def values(self, x: FloatArray) -> FloatArray:
        """Return the interpolated outputs (m, outputs) at inputs (m, n) clipped to 0 to 1."""
        positions, steps, strides = checked_positions(x, self.nodes)
        out = np.empty((len(x), 3 * len(self.tables)))
        part = np.empty((len(x), 3))
        for number, table in enumerate(self.tables):
            multilinear(positions, steps, strides, table, part)
            out[:, 3 * number : 3 * number + 3] = part
        return out[:, : self.outputs]


def process_elements_transform(element: Element, channels: int, pcs: str) -> Transform:
    """Return the transform of a D2B or A2B tag of the type `mpet`.

    Sources are ICC.1:2022, 10.18 (multiProcessElementsType), and ICC.2:2023, 10.2.17. Unsupported
    elements and exceeded limits raise `UnsupportedProfileError`.
    """
    if element.kind != "mpet":
        raise element.malformed(f"has the type {element.kind!r}, not mpet")
    inputs, outputs = element.unsigned(8, 2), element.unsigned(10, 2)
    if inputs != channels or outputs != 3:
        raise element.malformed(f"maps {inputs} to {outputs} channels; {channels} to 3 are needed")
    count = element.unsigned(12, 4)
    if count < 1:
        raise element.malformed("has no elements")
    if count > MAX_ELEMENTS:
        raise _unsupported(element, f"has {count} elements", f"At most {MAX_ELEMENTS}")
    stages: list[Stage] = []
    width = channels
    for number in range(count):
        offset, size = (element.unsigned(16 + 8 * number + part, 4) for part in (0, 4))
        step = Element(element.tag, element.raw(offset, size))
        before, after = step.unsigned(8, 2), step.unsigned(10, 2)
        if before != width:
            raise element.malformed(
                f"has {width} channels before its element {number + 1}, which needs {before}"
            )
        if not 1 <= after <= MAX_CHANNELS:
            raise _unsupported(
                element, f"has {after} channels after an element", f"1 to {MAX_CHANNELS}"
            )
        stage = _stage(step, before, after)
        if stage is not None:
            stages.append(stage)
        width = after
    if width != 3:
        raise element.malformed(f"ends with {width} channels; 3 are needed")
    if sum(isinstance(stage, FloatGrid) for stage in stages) > MAX_GRIDS:
        raise _unsupported(element, "has many lookup tables", f"At most {MAX_GRIDS}")
    return Transform(element.tag, tuple(stages), pcs, kind="mpet")


def _stage(step: Element, before: int, after: int) -> Stage | None:
    kind = step.raw(0, 4)
    if kind == b"cvst":
        return _curve_set(step, before, after)
    if kind == b"matf":
        numbers = _finite(step, 12, after * (before + 1))
        return Matrix(numbers[: after * before].reshape(after, before), numbers[after * before :])
    if kind == b"clut":
        return _float_grid(step, before, after)
    if kind in _PASSED_THROUGH and before == after:
        return None
    raise _unsupported(
        step,
        f"has a multi-process element of the type {kind.decode('latin-1')!r}",
        "Curve sets (cvst), matrices (matf) and lookup tables (clut)",
    )


def _curve_set(step: Element, before: int, after: int) -> CurveSet:
    if before != after:
        raise step.malformed(f"has a curve set from {before} to {after} channels")
    places = [tuple(step.unsigned(12 + 8 * i + part, 4) for part in (0, 4)) for i in range(before)]
    known = {
        place: segmented_curve_at(Element(step.tag, step.raw(*place)))[0] for place in set(places)
    }
    return CurveSet(tuple(known[place] for place in places))


def _float_grid(step: Element, before: int, after: int) -> FloatGrid:
    if before > MAX_GRID_INPUTS:
        raise step.malformed(f"has a lookup table of {before} inputs")
    nodes = tuple(step.raw(12, 16)[:before])
    if min(nodes) < 2:
        raise step.malformed(f"has a grid of {nodes} nodes; at least 2 are needed")
    count = math.prod(nodes)
    if count > MAX_GRID_NODES:
        raise step.malformed(f"has a grid of {count} nodes")
    values = _finite(step, 28, count * after).astype(np.float32).reshape(count, after)
    filled = -(-after // 3) * 3
    if filled > after:
        values = np.column_stack([values, np.zeros((count, filled - after), dtype=np.float32)])
    tables = tuple(
        np.ascontiguousarray(values[:, first : first + 3]) for first in range(0, filled, 3)
    )
    return FloatGrid(nodes, tables, after)


def _finite(step: Element, offset: int, count: int) -> FloatArray:
    numbers = step.floats(offset, count)
    if not np.isfinite(numbers).all():
        raise step.malformed("has an element with numbers that are not finite")
    return numbers


def _unsupported(element: Element, what: str, evaluated: str) -> UnsupportedProfileError:
    return UnsupportedProfileError(
        f"The tag {element.tag} {what}.",
        where={"tag": element.tag},
        remedy=f"{evaluated} are supported.",
    )
