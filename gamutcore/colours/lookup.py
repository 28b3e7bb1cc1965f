"""Lookup tables over the unit cube of three or more inputs, interpolated in tetrahedra.

Each cell is cut into the six tetrahedra that share its diagonal from the smallest corner to the
largest (Kasson, Nin, Plouffe and Hafner 1995). Neutral values of an RGB device lie on these
diagonals. Programs that apply ``.cube`` files and device links interpolate in the same way. More
inputs than three are interpolated linearly between tables of the last three, as by Little CMS.

Layout of the kernel: nodes are rows of one array, and the last input varies fastest. A point walks
from the smallest corner of its cell to the largest, one input at a time, by descending fraction.
`starts` has the first row of each point's table, and `weights` the weight with which it counts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.kernels import kernel

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray

__all__ = ["LookupTable", "cube_nodes"]


@dataclass(frozen=True, eq=False)
class LookupTable:
    """Values at equally spaced nodes of the unit cube, with tetrahedral interpolation.

    Parameters
    ----------
    nodes : (n, …, n, k) float64
        The values at the nodes, by first to last of three or more inputs. n is at least 2.

    Notes
    -----
    Source: J. M. Kasson, S. I. Nin, W. Plouffe and J. L. Hafner, "Performing color space
    conversions with three-dimensional linear interpolation", Journal of Electronic Imaging 4
    (1995).

    Examples
    --------
    >>> table = LookupTable.sample(lambda points: points**2, 3)
    >>> table.values([(0.5, 0.25, 1.0)]).tolist()
    [[0.25, 0.125, 1.0]]
    """

    nodes: FloatArray

    def __post_init__(self) -> None:
        nodes = np.ascontiguousarray(self.nodes, np.float64)
        if nodes.ndim < 4 or len(set(nodes.shape[:-1])) != 1 or len(nodes) < 2:
            raise ValueError(f"Nodes have the shape {nodes.shape}. Give (n, n, n, k), n ≥ 2.")
        object.__setattr__(self, "nodes", nodes)

    @classmethod
    def sample(
        cls, function: Callable[[FloatArray], FloatArray], size: int, inputs: int = 3
    ) -> LookupTable:
        """Return the table of a function from points (m, inputs), 0 to 1, to values (m, k).

        `size` is the number of nodes along each input. The function gets all nodes in one call.
        """
        values = np.asarray(function(cube_nodes(size, inputs)), np.float64)
        return cls(values.reshape(*[size] * inputs, -1))

    @property
    def size(self) -> int:
        """Number of nodes along each input."""
        return len(self.nodes)

    @property
    def inputs(self) -> int:
        """Number of inputs."""
        return self.nodes.ndim - 1

    def values(self, points: FloatArray) -> FloatArray:
        """Return the interpolated values (m, k) at points (m, inputs), which are clipped to 0 to 1.

        A coordinate that is not a number counts as 0. The kernel releases the interpreter's lock.
        """
        coordinates = np.ascontiguousarray(points, np.float64)
        rows = self.nodes.reshape(-1, self.nodes.shape[-1])
        out = np.zeros((len(coordinates), rows.shape[1]))
        first = self.inputs - 3
        places = np.clip(np.nan_to_num(coordinates[:, :first]), 0.0, 1.0) * (self.size - 1)
        low = np.minimum(places.astype(np.int64), self.size - 2)
        fractions = places - low
        steps = self.size ** np.arange(self.inputs - 1, 2, -1)
        last = np.ascontiguousarray(coordinates[:, first:])
        for bits in product((0, 1), repeat=first):
            corner = np.array(bits, np.int64)
            weights = np.where(corner, fractions, 1.0 - fractions).prod(axis=1)
            starts: LongArray = (low + corner) @ steps
            _interpolate(last, rows, self.size, starts, weights, out)
        return out


def cube_nodes(size: int, inputs: int = 3) -> FloatArray:
    """Return the nodes of the unit cube (sizeⁱⁿᵖᵘᵗˢ, inputs); the last coordinate is fastest.

    Examples
    --------
    >>> cube_nodes(2)[:3].tolist()
    [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]
    """
    steps = np.linspace(0.0, 1.0, size)
    return np.stack(np.meshgrid(*[steps] * inputs, indexing="ij"), axis=-1).reshape(-1, inputs)


@kernel
def _interpolate(
    points: FloatArray,
    nodes: FloatArray,
    size: int,
    starts: LongArray,
    weights: FloatArray,
    out: FloatArray,
) -> None:
    last, outputs = size - 1, nodes.shape[1]
    for i in range(len(points)):
        x = max(0.0, min(points[i, 0], 1.0)) * last
        y = max(0.0, min(points[i, 1], 1.0)) * last
        z = max(0.0, min(points[i, 2], 1.0)) * last
        at_x, at_y, at_z = min(int(x), last - 1), min(int(y), last - 1), min(int(z), last - 1)
        x, y, z = x - at_x, y - at_y, z - at_z
        base = starts[i] + (at_x * size + at_y) * size + at_z
        # the inputs by descending fraction: their fractions, and the rows that a step takes
        high, middle, low = x, y, z
        first, second, third = size * size, size, 1
        if high < middle:
            high, middle, first, second = middle, high, second, first
        if middle < low:
            middle, low, second, third = low, middle, third, second
        if high < middle:
            high, middle, first, second = middle, high, second, first
        one = base + first
        two, end = one + second, one + second + third
        for each in range(outputs):
            out[i, each] += weights[i] * (
                (1.0 - high) * nodes[base, each]
                + (high - middle) * nodes[one, each]
                + (middle - low) * nodes[two, each]
                + low * nodes[end, each]
            )
