"""Transforms of ICC profiles from device values to the profile connection space.

`TagData` gives checked access to the bytes of one tag. A transform is a chain of stages: curve
sets, matrices and lookup tables. Versions 2 and 4 have three types of tag: lut8 (`mft1`), lut16
(`mft2`) and lutAToB (`mAB `). The tags `D2Bx`, and `A2Bx` of iccMAX profiles, have multi-process
elements (`mpet`), which work on floating-point numbers without an encoding. The work per colour is
limited when a tag is read. Sizes are checked against the length of the tag.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from gamutcore.arrays import FloatArray
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError
from gamutcore.kernels import kernel

__all__ = [
    "CurveSet",
    "Grid",
    "Matrix",
    "Separation",
    "Stage",
    "TagData",
    "Transform",
    "checked_positions",
    "curve_at",
    "largest_output_sum",
    "lut_transform",
    "multilinear",
    "process_elements_transform",
    "separation",
]


MAX_GRID_NODES = 64_000_000
"""Maximum number of nodes of a grid. The largest profiles have some millions."""


@dataclass(frozen=True)
class TagData:
    """The data of one tag, starting with its type signature. Errors name the tag."""

    tag: str
    data: bytes

    def malformed(self, problem: str, remedy: str = "") -> MalformedProfileError:
        """Return the error for a fault in this tag.

        The problem is a predicate with the tag as its subject.
        """
        return MalformedProfileError(
            f"The tag {self.tag} {problem}.",
            where={"tag": self.tag},
            remedy=remedy or "Make the profile again, or repair the tag.",
        )

    def unsupported(self, problem: str, remedy: str) -> UnsupportedProfileError:
        """Return the error for content of this tag that is not read."""
        return UnsupportedProfileError(
            f"The tag {self.tag} {problem}.", where={"tag": self.tag}, remedy=remedy
        )

    def refuse_other_channels(self, needed_inputs: int, needed_outputs: int, size: int = 1) -> None:
        """Refuse a table with other numbers of inputs and outputs, which are at offset 8."""
        inputs, outputs = self.unsigned(8, size), self.unsigned(8 + size, size)
        if (inputs, outputs) != (needed_inputs, needed_outputs):
            raise self.malformed(
                f"maps {inputs} to {outputs} channels; {needed_inputs} to {needed_outputs} are "
                "needed"
            )

    def node_count(self, nodes: tuple[int, ...]) -> int:
        """Return the number of nodes of a grid, at least 2 along each dimension."""
        if min(nodes) < 2:
            raise self.malformed(f"has a grid of {nodes} nodes; at least 2 are needed")
        count = math.prod(nodes)
        if count > MAX_GRID_NODES:
            raise self.malformed(f"has a grid of {count} nodes")
        return count

    def raw(self, offset: int, size: int) -> bytes:
        """Return `size` bytes from `offset`.

        This method and those below raise `MalformedProfileError` if the bytes exceed the tag.
        """
        if offset < 0 or size < 0 or offset + size > len(self.data):
            raise self.malformed(
                f"needs {size} bytes at offset {offset} and has {len(self.data)} bytes in all"
            )
        return self.data[offset : offset + size]

    @property
    def kind(self) -> str:
        """The type signature, such as ``"mft2"``."""
        return self.raw(0, 4).decode("latin-1")

    def unsigned(self, offset: int, size: int) -> int:
        """Return the unsigned integer of `size` bytes at `offset`."""
        return int.from_bytes(self.raw(offset, size), "big")

    def integers(self, offset: int, count: int, size: int) -> np.ndarray:
        """Return unsigned integers of 1 or 2 bytes as (count,) uint16.

        Single bytes are multiplied by 257, which maps full scale exactly.
        """
        raw = self.raw(offset, count * size)
        if size == 1:
            return np.frombuffer(raw, dtype=np.uint8) * np.uint16(257)
        return np.frombuffer(raw, dtype=">u2").astype(np.uint16)

    def fixed(self, offset: int, count: int) -> FloatArray:
        """Return (count,) numbers of the type s15Fixed16Number."""
        return np.frombuffer(self.raw(offset, 4 * count), dtype=">i4") / 65536.0

    def floats(self, offset: int, count: int) -> FloatArray:
        """Return (count,) numbers of the type float32Number, which may be infinite or NaN."""
        raw = np.frombuffer(self.raw(offset, 4 * count), dtype=">f4")
        with np.errstate(invalid="ignore"):  # a signalling NaN becomes a quiet one
            return raw.astype(np.float64)


MAX_SEGMENTS = 256
"""Maximum number of segments. Each needs a pass over the colours. Real curves have 1 to 5."""

Curve: TypeAlias = Callable[[FloatArray], FloatArray]
"""The values of a curve, or of a segment of one. Hostile parameters give infinite values or NaN."""


def _real_power(base: FloatArray | float, exponent: FloatArray | float) -> FloatArray:
    # A negative base has a real power only for whole exponents. For other exponents the base is 0,
    # as in parametric curves.
    values, powers = np.broadcast_arrays(
        np.asarray(base, dtype=np.float64), np.asarray(exponent, dtype=np.float64)
    )
    whole = powers == np.floor(powers)
    result: FloatArray = np.where(whole, values, np.maximum(values, 0.0)) ** powers
    return result


def _sixth(x: FloatArray, p: Sequence[float]) -> FloatArray:
    inner = _real_power(x, p[1])
    ratio = np.maximum(p[6] * inner - p[2], 0.0) / (p[3] - p[4] * inner)
    return p[5] * _real_power(ratio, p[0])


def _seventh(x: FloatArray, p: Sequence[float]) -> FloatArray:
    inner = _real_power(x, p[1])
    return p[5] * _real_power((p[2] + p[3] * inner) / (1.0 + p[4] * inner), p[0])


_FORMULAS: tuple[tuple[int, Callable[[FloatArray, Sequence[float]], FloatArray]], ...] = (
    (4, lambda x, p: _real_power(p[1] * x + p[2], p[0]) + p[3]),
    (5, lambda x, p: p[1] * np.log10(p[2] * _real_power(x, p[0]) + p[3]) + p[4]),
    (5, lambda x, p: p[0] * _real_power(p[1], p[2] * x + p[3]) + p[4]),
    (5, lambda x, p: p[1] * _real_power(np.maximum(p[2] * x + p[3], 0.0), p[0]) + p[4]),
    (5, lambda x, p: p[1] * np.log(p[4] * _real_power(x, p[0]) - p[2]) + p[3]),
    (6, lambda x, p: p[5] * np.exp((p[4] * _real_power(x, p[0]) - p[3]) / np.float64(p[1])) + p[2]),
    (7, _sixth),
    (6, _seventh),
)
"""Number of parameters and formula of the function types 0 to 2 (ICC.1:2022, table 60), and 3 to 7
(ICC.2:2023, table 111), with parameters in the specification's order."""


def _formula(function: int, parameters: FloatArray) -> Curve:
    """Return a segment of a function type of `_FORMULAS`."""
    formula, numbers = _FORMULAS[function][1], parameters.tolist()

    def values(x: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            return np.asarray(formula(x, numbers), dtype=np.float64)

    return values


def _through(positions: FloatArray, samples: FloatArray) -> Curve:
    """Return the segment through samples (n,) at rising positions (n,)."""
    return lambda x: np.interp(x, positions, samples)


def _segmented(breaks: FloatArray, segments: Sequence[Curve]) -> Curve:
    """Return a curve of n segments with n - 1 rising break points between them.

    A break point belongs to the segment before it. The first segment starts at minus infinity, and
    the last ends at infinity.
    """

    def values(x: FloatArray) -> FloatArray:
        places = np.searchsorted(breaks, x, side="left")
        y = np.empty_like(x)
        for number, segment in enumerate(segments):
            here = places == number
            if here.any():
                y[here] = segment(x[here])
        return y

    return segments[0] if len(segments) == 1 else values


def _segmented_curve_at(element: TagData, offset: int = 0) -> tuple[Curve, int]:
    """Return the segmented curve (`curf`) at an offset of a tag, and its length in bytes.

    The offset is that of the type signature. The source is ICC.1:2022, 10.18.3, tables 58 to 61.
    """
    kind = element.raw(offset, 4).decode("latin-1")
    if kind != "curf":
        raise element.unsupported(
            f"has a curve of the type {kind!r}", "Supported: segmented curves (curf)."
        )
    count = element.unsigned(offset + 8, 2)
    if count < 1:
        raise element.malformed("has a curve without segments")
    if count > MAX_SEGMENTS:
        raise element.unsupported(
            f"has a curve of {count} segments", f"Supported: at most {MAX_SEGMENTS}."
        )
    breaks = element.floats(offset + 12, count - 1)
    if not (np.isfinite(breaks).all() and (np.diff(breaks) > 0).all()):
        raise element.malformed("has a curve whose break points do not rise")
    start, place = offset, offset + 12 + 4 * (count - 1)
    segments: list[Curve] = []
    for number in range(count):
        sampled = element.raw(place, 4)
        if sampled == b"parf":
            function = element.unsigned(place + 8, 2)
            if function >= len(_FORMULAS):
                raise element.unsupported(
                    f"has the formula type {function}", "Supported: types 0 to 7."
                )
            size = _FORMULAS[function][0]
            segments.append(_formula(function, element.floats(place + 12, size)))
        elif sampled == b"samf":
            size = element.unsigned(place + 8, 4)
            if number in {0, count - 1} or size < 1:
                raise element.malformed("has a sampled segment that lacks an end or samples")
            low, high = breaks[number - 1], breaks[number]
            # The segment before gives the value at the start (ICC.1:2022, 10.18.3.4).
            first = segments[-1](breaks[number - 1 : number])
            samples = np.concatenate([first, element.floats(place + 12, size)])
            positions = np.linspace(float(low), float(high), size + 1)
            segments.append(_through(positions, samples))
        else:
            kind = sampled.decode("latin-1")
            raise element.unsupported(
                f"has a curve segment of the type {kind!r}",
                "Supported: formulas (parf), samples (samf).",
            )
        place += 12 + 4 * size
    return _segmented(breaks, segments), place - start


PARAMETER_COUNTS = (1, 3, 4, 5, 7)
"""Parameters of the function types 0 to 4 (ICC.1:2022, table 68)."""


def _sampled(samples: FloatArray) -> Curve:
    """Return the curve through n ≥ 2 equally spaced samples, for inputs from 0 to 1."""
    last = len(samples) - 1
    curve = _through(np.arange(last + 1.0), samples)
    return lambda x: curve(x * last)


def _parametric(function: int, parameters: FloatArray) -> Curve:
    """Return a curve of function type 0 to 4. Parameters are the first of g, a, b, c, d, e, f.

    Domain and range are 0 to 1, and values outside are clipped (ICC.1:2022, 10.18, table 68).
    """
    g, a, b, c, d, e, f = np.append(parameters, np.zeros(7 - len(parameters))).tolist()

    def values(x: FloatArray) -> FloatArray:
        x = np.clip(x, 0.0, 1.0)
        base = x if function == 0 else a * x + b
        with np.errstate(all="ignore"):
            y = np.maximum(base, 0.0) ** g
        # Types 1 and 2 start at x = -b/a, where the base becomes positive. Type 1 is type 2 with
        # c = 0; type 3 is type 4 with e = f = 0.
        if function in {1, 2}:
            y = np.where(base >= 0, y, 0.0) + c
        elif function > 2:
            y = np.where(x >= d, y + e, c * x + f)
        return np.where(np.isfinite(y), np.clip(y, 0.0, 1.0), y)

    return values


def curve_at(element: TagData, offset: int = 0) -> tuple[Curve, int]:
    """Return the curve (`curv`, `para` or `curf`) at an offset of a tag, and its length.

    The offset is that of the curve's type signature. The length is in bytes, without padding.
    """
    kind = element.raw(offset, 4)
    if kind == b"curv":
        count = element.unsigned(offset + 8, 4)
        if count == 0:
            return _parametric(0, np.ones(1)), 12
        if count == 1:
            # One value is an exponent of the type u8Fixed8Number (ICC.1:2022, 10.6).
            return _parametric(0, np.array([element.unsigned(offset + 12, 2) / 256.0])), 14
        return _sampled(element.integers(offset + 12, count, 2) / 65535.0), 12 + 2 * count
    if kind == b"para":
        function = element.unsigned(offset + 8, 2)
        if function >= len(PARAMETER_COUNTS):
            raise element.malformed(
                f"has a parametric curve of the unknown function type {function}"
            )
        count = PARAMETER_COUNTS[function]
        return _parametric(function, element.fixed(offset + 12, count)), 12 + 4 * count
    if kind == b"curf":
        return _segmented_curve_at(element, offset)
    raise element.malformed(
        f"has {kind.decode('latin-1')!r} in place of a curve",
        "Curves are of the type curv or para, or curf in iccMAX profiles.",
    )


MAX_CORNERS = 300_000_000
"""Maximum number of table reads in one evaluation, about 3 s: 100,000 points in 11 dimensions."""


@kernel
def multilinear(
    positions: FloatArray,
    steps: npt.NDArray[np.int64],
    strides: npt.NDArray[np.int64],
    table: npt.NDArray[np.uint16] | npt.NDArray[np.float32],
    out: FloatArray,
) -> None:
    """Interpolate linearly in every dimension, between rows of `table` (nodes, 3).

    `positions` (m, n) are from 0 to 1. `steps` (n,) has the nodes of each dimension, less one, and
    `strides` (n,) the rows from one node to the next. `out` (m, 3) is on the table's scale.
    """
    dimensions = positions.shape[1]
    fractions = np.empty(dimensions)
    offsets = np.empty(dimensions, dtype=np.int64)
    for i in range(positions.shape[0]):
        base = 0
        between = 0
        for d in range(dimensions):
            position = min(max(positions[i, d], 0.0), 1.0) * steps[d]
            node = int(position)
            base += node * strides[d]
            # A dimension in which the point is a node needs no neighbour.
            if position > node:
                fractions[between] = position - node
                offsets[between] = strides[d]
                between += 1
        first = second = third = 0.0
        for corner in range(1 << between):
            weight = 1.0
            row = base
            for d in range(between):
                if corner >> d & 1:
                    weight *= fractions[d]
                    row += offsets[d]
                else:
                    weight *= 1.0 - fractions[d]
            first += weight * table[row, 0]
            second += weight * table[row, 1]
            third += weight * table[row, 2]
        out[i, 0] = first
        out[i, 1] = second
        out[i, 2] = third


def checked_positions(
    positions: FloatArray, nodes: tuple[int, ...]
) -> tuple[FloatArray, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the arguments of `multilinear`: positions (m, n) clipped to 0 to 1, steps, strides.

    An evaluation with more than `MAX_CORNERS` table reads is refused.
    """
    steps = np.array(nodes, dtype=np.int64) - 1
    strides = np.cumprod(np.array([1, *nodes[:0:-1]], dtype=np.int64))[::-1].copy()
    # The kernel does not check positions, so none may be NaN.
    clipped = np.ascontiguousarray(np.clip(np.nan_to_num(positions, nan=0.0), 0.0, 1.0))
    between = np.count_nonzero(clipped * steps % 1.0, axis=1)
    corners = int((1 << between).sum())
    if corners > MAX_CORNERS:
        raise UnsupportedProfileError(
            f"Interpolating {len(positions)} points over {len(nodes)} channels takes "
            f"{corners} table entries.",
            where={"field": "surface_samples"},
            remedy="Ask for fewer surface_samples.",
        )
    return clipped, steps, strides


@dataclass(frozen=True, eq=False)
class Grid:
    """A lookup table (CLUT) with any number of outputs.

    `nodes` has the nodes along each dimension, each at least 2. Each of the `tables` (product of
    nodes, 3) has three outputs, of which `full` is 1; zeros fill the last one. The last dimension
    varies fastest.
    """

    nodes: tuple[int, ...]
    tables: tuple[npt.NDArray[np.uint16] | npt.NDArray[np.float32], ...]
    outputs: int = 3
    full: float = 1.0

    def values(self, x: FloatArray) -> FloatArray:
        """Return the interpolated outputs (m, outputs) at inputs (m, n) clipped to 0 to 1."""
        positions, steps, strides = checked_positions(x, self.nodes)
        out = np.empty((len(x), 3 * len(self.tables)))
        part = np.empty((len(x), 3))
        for number, table in enumerate(self.tables):
            multilinear(positions, steps, strides, table, part)
            out[:, 3 * number : 3 * number + 3] = part
        return out[:, : self.outputs] / self.full


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
        return np.column_stack([c(x[:, i]) for i, c in enumerate(self.curves)])


@dataclass(frozen=True, eq=False)
class Matrix:
    """A linear map (k, n) with an offset (k,)."""

    matrix: FloatArray
    offset: FloatArray

    def values(self, x: FloatArray) -> FloatArray:
        """Return matrix·x + offset, (m, k) for (m, n)."""
        mapped: FloatArray = x @ self.matrix.T + self.offset
        return mapped


def _encoding(scale: FloatArray, offset: FloatArray) -> Matrix:
    """Return the stage from numbers from 0 to 1 to the colours that they encode."""
    return Matrix(np.diag(scale), offset)


_LAB_SCALE, _LAB_OFFSET = np.array([100.0, 255.0, 255.0]), np.array([0.0, -128.0, -128.0])
_XYZ_ENCODING = _encoding(np.full(3, 1 + 32767 / 32768), np.zeros(3))
"""PCSXYZ, 16 bits: 1.0 is 8000h (ICC.1:2022, table 12)."""
_LAB_ENCODING = _encoding(_LAB_SCALE, _LAB_OFFSET)
"""PCSLAB: L* 100 and a*, b* 127 are full scale (ICC.1:2022, table 13)."""
_LEGACY_LAB_ENCODING = _encoding(_LAB_SCALE * 65535 / 65280, _LAB_OFFSET)
"""lut16's PCSLAB in versions 2 and 4: L* 100 is FF00h (ICC.1:2022, 10.12, tables 42 and 43)."""


@dataclass(frozen=True, eq=False)
class Transform:
    """Device values to the profile connection space.

    `tag` and `kind` are the tag or tags, and their type. `pcs` is ``"XYZ"`` (Y = 1 for the white)
    or ``"Lab"``. `absolute`
    colours are not media-relative.
    """

    tag: str
    stages: tuple[Stage, ...]
    pcs: str
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


def lut_transform(element: TagData, channels: int, pcs: str) -> Transform:
    """Return the transform of an A2B tag with a lookup table: lut8, lut16 or lutAToB."""
    kind = element.kind
    if kind not in {"mft1", "mft2", "mAB "}:
        raise element.unsupported(
            f"has the type {kind!r}", "Lookup tables of the types mft1, mft2 and mAB are supported."
        )
    element.refuse_other_channels(channels, 3)
    lab = _LEGACY_LAB_ENCODING if kind == "mft2" else _LAB_ENCODING
    encoding = _XYZ_ENCODING if pcs == "XYZ" else lab
    stages = (_lut_a_to_b_stages if kind == "mAB " else _lut_stages)(element, channels)
    return Transform(element.tag, (*stages, encoding), pcs, kind)


def largest_output_sum(element: TagData, channels: int) -> float | None:
    """Return the largest sum of device values at the nodes of a B2A tag.

    1 is one full channel. None for tags of other types or without a table. Between nodes, sums are
    the same or smaller, except by the curves after the table.
    """
    kind = element.kind
    if kind not in {"mft1", "mft2", "mBA "}:
        return None
    element.refuse_other_channels(3, channels)
    if kind == "mBA ":
        clut, curves = element.unsigned(24, 4), element.unsigned(28, 4)
        if not clut:
            return None
        count, size = math.prod(element.raw(clut, 3)), element.unsigned(clut + 16, 1)
        start = clut + 20
        after = _curves(element, curves, channels) if curves else None
    else:
        size, start, before, entries = _lut_layout(element)
        if entries < 2:
            raise element.malformed("has tables of fewer than 2 entries")
        start += 3 * before * size
        count = element.unsigned(10, 1) ** 3
        after = _tables(element, start + count * channels * size, channels, entries, size)
    if size not in {1, 2} or count == 0:
        raise element.malformed(f"has a grid of {count} nodes of {size} bytes per value")
    if count * channels > MAX_SEPARATION_VALUES:
        return None
    values = element.integers(start, count * channels, size).reshape(-1, channels) / 65535.0
    with np.errstate(all="ignore"):
        sums = (values if after is None else after.values(values)).sum(axis=1)
    return float(sums.max()) if np.isfinite(sums).all() else None


@dataclass(frozen=True, eq=False)
class Separation:
    """Colours of the connection space to device values: a B2A tag.

    `pcs` is as that of `Transform`.
    """

    tag: str
    stages: tuple[Stage, ...]
    pcs: str

    def device_values(self, colours: FloatArray) -> FloatArray:
        """Return device values (m, n), 0 to 1, of colours (m, 3) in the connection space."""
        values = colours
        for stage in self.stages:
            values = np.clip(stage.values(values), 0.0, 1.0)
        return values


def separation(element: TagData, channels: int, pcs: str) -> Separation:
    """Return the separation of a B2A tag with a lookup table: lut8, lut16 or lutBToA."""
    kind = element.kind
    if kind not in {"mft1", "mft2", "mBA "}:
        raise element.unsupported(
            f"has the type {kind!r}", "Lookup tables of the types mft1, mft2 and mBA are supported."
        )
    element.refuse_other_channels(3, channels)
    lab = _LEGACY_LAB_ENCODING if kind == "mft2" else _LAB_ENCODING
    encoding = _XYZ_ENCODING if pcs == "XYZ" else lab
    scale = np.diag(encoding.matrix)
    first: tuple[Stage, ...] = (Matrix(np.diag(1.0 / scale), -encoding.offset / scale),)
    if kind == "mBA ":
        stages = _lut_b_to_a_stages(element, channels)
    else:
        if pcs == "XYZ":
            first += (Matrix(element.fixed(12, 9).reshape(3, 3), np.zeros(3)),)
        stages = _lut_stages(element, 3, channels)
    return Separation(element.tag, (*first, *stages), pcs)


def _lut_b_to_a_stages(element: TagData, outputs: int) -> tuple[Stage, ...]:
    """Return the stages of lutBToA, B curves to A curves (ICC.1:2022, 10.14)."""
    b, matrix, m, clut, a = (element.unsigned(offset, 4) for offset in range(12, 32, 4))
    if not b:
        raise element.malformed("has no B curves")
    if not clut and outputs != 3:
        raise element.malformed(f"has no grid for its {outputs} channels")
    stages: list[Stage] = [_curves(element, b, 3)]
    if matrix:
        numbers = element.fixed(matrix, 12)
        stages.append(Matrix(numbers[:9].reshape(3, 3), numbers[9:]))
    if m:
        stages.append(_curves(element, m, 3))
    if clut:
        stages.append(_element_grid(element, clut, 3, outputs))
    if a:
        stages.append(_curves(element, a, outputs))
    return tuple(stages)


def _grid(
    element: TagData, offset: int, nodes: tuple[int, ...], size: int, outputs: int = 3
) -> Grid:
    values = element.integers(offset, outputs * element.node_count(nodes), size)
    values = values.reshape(-1, outputs)
    if outputs % 3:
        values = np.pad(values, ((0, 0), (0, -outputs % 3)))
    tables = tuple(
        np.ascontiguousarray(values[:, at : at + 3]) for at in range(0, values.shape[1], 3)
    )
    return Grid(nodes, tables, outputs, full=65535.0)


def _element_grid(element: TagData, offset: int, inputs: int, outputs: int) -> Grid:
    """Return the grid of lutAToB or lutBToA."""
    size = element.unsigned(offset + 16, 1)
    if size not in {1, 2}:
        raise element.malformed(f"has a grid of {size} bytes per value")
    nodes = tuple(element.raw(offset, 16)[:inputs])
    return _grid(element, offset + 20, nodes, size, outputs)


def _lut_layout(element: TagData) -> tuple[int, int, int, int]:
    """Return bytes per value, offset, and entries of the input and output tables of lut8, lut16."""
    if element.kind == "mft1":
        return 1, 48, 256, 256
    return 2, 52, element.unsigned(48, 2), element.unsigned(50, 2)


def _lut_stages(element: TagData, inputs: int, outputs: int = 3) -> tuple[Stage, ...]:
    """Return the stages of lut8 and lut16 (ICC.1:2022, 10.11 and 10.12).

    The matrix at the start applies only to PCSXYZ inputs, and is not among them. With device
    values, errors would be up to 35 ΔE*ab.
    """
    grid_points = element.unsigned(10, 1)
    size, offset, input_entries, output_entries = _lut_layout(element)
    if min(input_entries, output_entries) < 2:
        raise element.malformed("has tables of fewer than 2 entries")
    before = _tables(element, offset, inputs, input_entries, size)
    offset += inputs * input_entries * size
    grid = _grid(element, offset, (grid_points,) * inputs, size, outputs)
    offset += len(grid.tables[0]) * outputs * size
    return before, grid, _tables(element, offset, outputs, output_entries, size)


def _tables(element: TagData, offset: int, channels: int, entries: int, size: int) -> CurveSet:
    samples = element.integers(offset, channels * entries, size).reshape(channels, -1) / 65535.0
    return CurveSet(tuple(map(_sampled, samples)))


def _lut_a_to_b_stages(element: TagData, inputs: int) -> tuple[Stage, ...]:
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
        stages.append(_element_grid(element, clut, inputs, 3))
    if m:
        stages.append(_curves(element, m, 3))
    if matrix:
        numbers = element.fixed(matrix, 12)
        stages.append(Matrix(numbers[:9].reshape(3, 3), numbers[9:]))
    return (*stages, _curves(element, b, 3))


def _curves(element: TagData, offset: int, channels: int) -> CurveSet:
    curves = []
    for _ in range(channels):
        curve, length = curve_at(element, offset)
        curves.append(curve)
        offset += length + -length % 4  # curves start at multiples of four bytes
    return CurveSet(tuple(curves))


MAX_ELEMENTS = 32
"""Maximum number of elements in a tag. Real tags have two to six."""
MAX_STAGE_CHANNELS = 16
"""Maximum number of channels between elements. 100,000 colours with 16 channels take 13 MB."""
MAX_GRIDS = 2
"""Maximum number of lookup tables in a tag, because each can be as slow as another profile."""
MAX_GRID_INPUTS = 16
"""Maximum number of inputs of a lookup table (ICC.1:2022, table 66)."""

_PASSED_THROUGH = (b"bACS", b"eACS")
"""Markers without a calculation (ICC.1:2022, 10.18.1)."""


def process_elements_transform(element: TagData, channels: int, pcs: str) -> Transform:
    """Return the transform of a D2B or A2B tag of the type `mpet`.

    Sources are ICC.1:2022, 10.18 (multiProcessElementsType), and ICC.2:2023, 10.2.17. Unsupported
    elements and exceeded limits raise `UnsupportedProfileError`.
    """
    if element.kind != "mpet":
        raise element.malformed(f"has the type {element.kind!r}, not mpet")
    element.refuse_other_channels(channels, 3, size=2)
    count = element.unsigned(12, 4)
    if count < 1:
        raise element.malformed("has no elements")
    if count > MAX_ELEMENTS:
        raise element.unsupported(f"has {count} elements", f"At most {MAX_ELEMENTS} are supported.")
    stages: list[Stage] = []
    width = channels
    for number in range(count):
        offset, size = (element.unsigned(16 + 8 * number + part, 4) for part in (0, 4))
        step = TagData(element.tag, element.raw(offset, size))
        before, after = step.unsigned(8, 2), step.unsigned(10, 2)
        if before != width:
            raise element.malformed(
                f"has {width} channels before its element {number + 1}, which needs {before}"
            )
        if not 1 <= after <= MAX_STAGE_CHANNELS:
            raise element.unsupported(
                f"has {after} channels after an element",
                f"1 to {MAX_STAGE_CHANNELS} are supported.",
            )
        stage = _stage(step, before, after)
        if stage is not None:
            stages.append(stage)
        width = after
    if width != 3:
        raise element.malformed(f"ends with {width} channels; 3 are needed")
    if sum(isinstance(stage, Grid) for stage in stages) > MAX_GRIDS:
        raise element.unsupported("has many lookup tables", f"At most {MAX_GRIDS} are supported.")
    return Transform(element.tag, tuple(stages), pcs, kind="mpet")


def _stage(step: TagData, before: int, after: int) -> Stage | None:
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
    raise step.unsupported(
        f"has a multi-process element of the type {kind.decode('latin-1')!r}",
        "Curve sets (cvst), matrices (matf) and lookup tables (clut) are supported.",
    )


def _curve_set(step: TagData, before: int, after: int) -> CurveSet:
    if before != after:
        raise step.malformed(f"has a curve set from {before} to {after} channels")
    places = [tuple(step.unsigned(12 + 8 * i + part, 4) for part in (0, 4)) for i in range(before)]
    known = {
        place: _segmented_curve_at(TagData(step.tag, step.raw(*place)))[0] for place in set(places)
    }
    return CurveSet(tuple(known[place] for place in places))


def _float_grid(step: TagData, before: int, after: int) -> Grid:
    if before > MAX_GRID_INPUTS:
        raise step.malformed(f"has a lookup table of {before} inputs")
    nodes = tuple(step.raw(12, 16)[:before])
    count = step.node_count(nodes)
    values = _finite(step, 28, count * after).astype(np.float32).reshape(count, after)
    filled = -(-after // 3) * 3
    if filled > after:
        values = np.column_stack([values, np.zeros((count, filled - after), dtype=np.float32)])
    tables = tuple(
        np.ascontiguousarray(values[:, first : first + 3]) for first in range(0, filled, 3)
    )
    return Grid(nodes, tables, after)


def _finite(step: TagData, offset: int, count: int) -> FloatArray:
    numbers = step.floats(offset, count)
    if not np.isfinite(numbers).all():
        raise step.malformed("has an element with numbers that are not finite")
    return numbers
