"""Lookup-table transforms from device values to the profile connection space.

Versions 2 and 4 have three tag types: lut8 (`mft1`), lut16 (`mft2`) and lutAToB (`mAB `). Each
becomes a chain of curve sets, grid and matrix, and an encoding of the result. Sizes are checked
against the length of the tag.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from gamutcore.characterisation.icc.curves import Curve, SampledCurve, curve_at
from gamutcore.characterisation.icc.grid import Grid
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.icc.element import Element

__all__ = [
    "CurveSet",
    "Encoding",
    "Matrix",
    "Stage",
    "Transform",
    "largest_output_sum",
    "lut_transform",
]

MAX_GRID_NODES = 64_000_000
"""Maximum number of nodes of a grid. The largest profiles have some millions."""

MAX_SEPARATION_VALUES = 8_000_000
"""Maximum number of values of a table from colours to device values that is searched: 64 MB. Tables
of four inks with 33 nodes have 144,000."""

_CURVE_STEPS = 4097
"""Number of samples for the inversion of a curve."""


class Stage(Protocol):
    """One step of a transform."""

    def values(self, x: FloatArray) -> FloatArray:
        """Return (m, outputs) for (m, inputs)."""


@dataclass(frozen=True, eq=False)
class CurveSet:
    """A curve for each channel."""

    curves: tuple[Curve, ...]

    def values(self, x: FloatArray) -> FloatArray:
        """Return (m, n) for (m, n): the curve of each channel."""
        return np.column_stack([c.values(x[:, i]) for i, c in enumerate(self.curves)])


@dataclass(frozen=True, eq=False)
class Matrix:
    """A linear map (k, n) with an offset (k,)."""

    matrix: FloatArray
    offset: FloatArray

    def values(self, x: FloatArray) -> FloatArray:
        """Return matrix·x + offset, (m, k) for (m, n)."""
        mapped: FloatArray = x @ self.matrix.T + self.offset
        return mapped


@dataclass(frozen=True, eq=False)
class Encoding:
    """Encoding of colours as numbers from 0 to 1: colour = value · scale + offset, each (3,)."""

    scale: FloatArray
    offset: FloatArray


_XYZ = Encoding(np.full(3, 1 + 32767 / 32768), np.zeros(3))
"""PCSXYZ, 16 bits: 1.0 is 8000h (ICC.1:2022, table 12)."""
_LAB = Encoding(np.array([100.0, 255.0, 255.0]), np.array([0.0, -128.0, -128.0]))
"""PCSLAB: L* 100 and a*, b* 127 are full scale (ICC.1:2022, table 13)."""
_LEGACY_LAB = Encoding(_LAB.scale * 65535 / 65280, _LAB.offset)
"""lut16's PCSLAB in versions 2 and 4: L* 100 is FF00h (ICC.1:2022, 10.12, tables 42 and 43)."""


@dataclass(frozen=True, eq=False)
class Transform:
    """Device values to the profile connection space.

    Attributes
    ----------
    tag, kind : str
        The tag or tags of the transform, and their type, such as ``"mft2"``.
    stages : tuple of Stage
        In order.
    pcs : str
        ``"XYZ"`` (Y = 1 for the white) or ``"Lab"``.
    encoding : Encoding or None
        Encoding of the last stage; None if its results are colours.
    absolute : bool
        Whether colours are absolute rather than media-relative.
    """

    tag: str
    stages: tuple[Stage, ...]
    pcs: str
    encoding: Encoding | None = None
    kind: str = ""
    absolute: bool = False

    @property
    def nodes(self) -> FloatArray | None:
        """Device values (n, k) of the nodes of the first lookup table, for each channel.

        The nodes are mapped back through the curves before the table, and include 0 and 1. None if
        there is no table, if channels mix before it, if a curve does not rise, or if channels have
        different numbers of nodes.
        """
        curves: CurveSet | None = None
        for stage in self.stages:
            counts = getattr(stage, "nodes", None)
            if counts is not None:
                return _nodes_before(curves, counts)
            if curves is not None or not isinstance(stage, CurveSet):
                break
            curves = stage
        return None

    def pcs_values(self, device: FloatArray) -> FloatArray:
        """Return the colours (m, 3) of device values (m, n), 0 to 1, in the connection space.

        Colours are X, Y, Z or L*, a*, b*, according to `pcs`, relative to D50. A result that is not
        finite raises `MalformedProfileError`.
        """
        colours = device
        with np.errstate(all="ignore"):
            for stage in self.stages:
                colours = stage.values(colours)
            if self.encoding is not None:
                colours = colours * self.encoding.scale + self.encoding.offset
        if not (np.abs(colours) < 1e9).all():  # also where it is not a number
            raise MalformedProfileError(
                f"The tag {self.tag} gives colours that are not finite.",
                where={"tag": self.tag},
                remedy="Make the profile again, or repair the tag.",
            )
        return colours


def _nodes_before(curves: CurveSet | None, counts: tuple[int, ...]) -> FloatArray | None:
    if len(set(counts)) > 1:
        return None
    nodes = np.tile(np.linspace(0.0, 1.0, counts[0]), (len(counts), 1))
    if curves is None:
        return nodes
    x = np.linspace(0.0, 1.0, _CURVE_STEPS)
    with np.errstate(all="ignore"):
        y = curves.values(np.tile(x[:, np.newaxis], (1, len(counts))))
    if not (np.isfinite(y).all() and (np.diff(y, axis=0) >= 0).all()):
        return None
    nodes = np.stack([np.interp(row, y[:, i], x) for i, row in enumerate(nodes)])
    nodes[:, 0], nodes[:, -1] = 0.0, 1.0
    return nodes


def lut_transform(element: Element, channels: int, pcs: str) -> Transform:
    """Return the transform of an A2B tag with a lookup table: lut8, lut16 or lutAToB."""
    kind = element.kind
    if kind not in {"mft1", "mft2", "mAB "}:
        raise UnsupportedProfileError(
            f"The tag {element.tag} has the type {kind!r}.",
            where={"tag": element.tag},
            remedy="Lookup tables of the types mft1, mft2 and mAB are supported.",
        )
    inputs, outputs = element.unsigned(8, 1), element.unsigned(9, 1)
    if inputs != channels or outputs != 3:
        raise element.malformed(f"maps {inputs} to {outputs} channels; {channels} to 3 are needed")
    if kind == "mAB ":
        encoding = _XYZ if pcs == "XYZ" else _LAB
        return Transform(element.tag, _lut_a_to_b_stages(element, inputs), pcs, encoding, kind)
    lab = _LEGACY_LAB if kind == "mft2" else _LAB
    encoding = _XYZ if pcs == "XYZ" else lab
    return Transform(element.tag, _lut_stages(element, inputs), pcs, encoding, kind)


def largest_output_sum(element: Element, channels: int) -> float | None:
    """Return the largest sum of device values at the nodes of a table from colours to devices.

    Parameters
    ----------
    element : Element
        A B2A tag.
    channels : int
        Channels of the profile's device colour space.

    Returns
    -------
    float or None
        1 is one full channel. None for tags of other types or without a table. Between nodes, sums
        are the same or smaller, except by the curves after the table.

    Raises
    ------
    MalformedProfileError
        The tag is malformed.
    """
    kind = element.kind
    if kind not in {"mft1", "mft2", "mBA "}:
        return None
    inputs, outputs = element.unsigned(8, 1), element.unsigned(9, 1)
    if inputs != 3 or outputs != channels:
        raise element.malformed(f"maps {inputs} to {outputs} channels; 3 to {channels} are needed")
    if kind == "mBA ":
        clut, curves = element.unsigned(24, 4), element.unsigned(28, 4)
        if not clut:
            return None
        count, size = math.prod(element.raw(clut, 3)), element.unsigned(clut + 16, 1)
        start = clut + 20
        after = _curves(element, curves, channels) if curves else None
    else:
        size, start = (2, 52) if kind == "mft2" else (1, 48)
        entries = [element.unsigned(offset, 2) if size == 2 else 256 for offset in (48, 50)]
        if entries[1] < 2:
            raise element.malformed("has tables of fewer than 2 entries")
        start += inputs * entries[0] * size
        count = element.unsigned(10, 1) ** inputs
        after = _tables(element, start + count * channels * size, channels, entries[1], size)
    if size not in {1, 2} or count == 0:
        raise element.malformed(f"has a grid of {count} nodes of {size} bytes per value")
    if count * channels > MAX_SEPARATION_VALUES:
        return None
    values = element.integers(start, count * channels, size).reshape(-1, channels) / 65535.0
    with np.errstate(all="ignore"):
        sums = (values if after is None else after.values(values)).sum(axis=1)
    return float(sums.max()) if np.isfinite(sums).all() else None


def _grid(element: Element, offset: int, nodes: tuple[int, ...], size: int) -> Grid:
    if min(nodes) < 2:
        raise element.malformed(f"has a grid of {nodes} nodes; at least 2 are needed")
    count = math.prod(nodes)
    if count > MAX_GRID_NODES:
        raise element.malformed(f"has a grid of {count} nodes")
    return Grid(nodes, element.integers(offset, 3 * count, size).reshape(-1, 3))


def _lut_stages(element: Element, inputs: int) -> tuple[Stage, ...]:
    """Return the stages of lut8 and lut16 (ICC.1:2022, 10.11 and 10.12).

    The matrix at the start applies only to PCSXYZ inputs, which device profiles do not have. With
    device values, errors would be up to 35 ΔE*ab.
    """
    grid_points = element.unsigned(10, 1)
    if element.kind == "mft2":
        size, offset = 2, 52
        input_entries, output_entries = element.unsigned(48, 2), element.unsigned(50, 2)
    else:
        size, offset = 1, 48
        input_entries = output_entries = 256
    if min(input_entries, output_entries) < 2:
        raise element.malformed("has tables of fewer than 2 entries")
    before = _tables(element, offset, inputs, input_entries, size)
    offset += inputs * input_entries * size
    grid = _grid(element, offset, (grid_points,) * inputs, size)
    offset += grid.table.size * size
    return before, grid, _tables(element, offset, 3, output_entries, size)


def _tables(element: Element, offset: int, channels: int, entries: int, size: int) -> CurveSet:
    samples = element.integers(offset, channels * entries, size).reshape(channels, -1) / 65535.0
    return CurveSet(tuple(SampledCurve(row) for row in samples))


def _lut_a_to_b_stages(element: Element, inputs: int) -> tuple[Stage, ...]:
    """Return the stages of lutAToB, A curves to B curves (ICC.1:2022, 10.13)."""
    b, matrix, m, clut, a = (element.unsigned(offset, 4) for offset in range(12, 32, 4))
    if not b:
        raise element.malformed("has no B curves")
    if not clut and inputs != 3:
        raise element.malformed(f"has no grid for its {inputs} channels")
    stages: list[Stage] = []
    if a:
        stages.append(_curves(element, a, inputs))
    if clut:
        nodes = tuple(element.raw(clut, 16)[:inputs])
        size = element.unsigned(clut + 16, 1)
        if size not in {1, 2}:
            raise element.malformed(f"has a grid of {size} bytes per value")
        stages.append(_grid(element, clut + 20, nodes, size))
    if m:
        stages.append(_curves(element, m, 3))
    if matrix:
        numbers = element.fixed(matrix, 12)
        stages.append(Matrix(numbers[:9].reshape(3, 3), numbers[9:]))
    return (*stages, _curves(element, b, 3))


def _curves(element: Element, offset: int, channels: int) -> CurveSet:
    curves = []
    for _ in range(channels):
        curve, length = curve_at(element, offset)
        curves.append(curve)
        offset += length + -length % 4  # curves start at multiples of four bytes
    return CurveSet(tuple(curves))
