"""Quadratic approximations of the square of ΔE00, as lower bounds for searches of the nearest.

Around a colour c, with the residuals ΔL' ÷ S_L, u = ΔC' ÷ S_C and v = ΔH' ÷ S_H and their
derivatives J, the square of ΔE00 is nearly a quadratic polynomial m whose matrix M is that of J,
with R_T between u and v. There are three bounds:

- ΔE00(x) ≥ √m(x) − κ |x − c|², with κ of `curvature`;
- ΔE00(x) ≥ ΔE00(c) + g · (x − c) − κ |x − c|², with the gradient g and κ of `tangent_curvature`;
- with M at the colour p of the query itself, √((x − p) · M (x − p)) ≤ ΔE00 (1 + k ΔE00), with k of
  `metric_slack`.

The limits κ and k have no proof. They are above the largest values found on millions of random
pairs, and tests repeat the measurement on other pairs. The first two do not hold where the formula
has no derivative: at opposite hues, and at the neutral axis.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.kernels import leaf_kernel
from gamutcore.queries.ciede2000_slope import CHROMA, A, B
from gamutcore.queries.face_tree import ROUNDING, FaceTree

__all__ = [
    "BLUE",
    "curvature",
    "is_blue",
    "least_chroma",
    "meets_cliff",
    "metric_bound",
    "metric_slack",
    "set_metric",
    "set_metric_bounds",
    "tangent_curvature",
]

LEAST_CHROMA = 3.0
"""Below this chroma the first two bounds are not used."""

NEAR, FURTHER = 10.0, 20.0
"""Up to which ΔE00 the limits of the distance in the metric were measured, near hue 275° and for
small chromas, and elsewhere."""

BLUE = 0.35
"""k near hue 275°, where R_T changes."""


@leaf_kernel
def metric_slack(colour: FloatArray) -> tuple[float, float, float]:
    """Return k of the metric at a colour, its growth by ΔE00, and up to which ΔE00 they hold."""
    a, b, chroma = colour[A], colour[B], colour[CHROMA]
    if b < 0.0 and a > 0.7 * b and a < (-1.43 if chroma < 32.0 else -0.18) * b and chroma > 8.0:
        return BLUE, 0.0, NEAR
    if chroma < 32.0:
        return 0.042, 0.001, NEAR
    return 0.034, 0.0006, NEAR if is_blue(a, b) else FURTHER


@leaf_kernel
def metric_bound(away: float, slack: float, growth: float) -> float:
    """Return the lower bound of ΔE00 at a distance in the metric.

    It solves w (1 + k w) = `away`, first with `slack` as k, which is too small, so that w and k
    from it are too large, and then with this k.
    """
    bound = (np.sqrt(1.0 + 4.0 * slack * away) - 1.0) / (2.0 * slack)
    wider = slack + growth * bound
    return (np.sqrt(1.0 + 4.0 * wider * away) - 1.0) / (2.0 * wider)


@leaf_kernel
def is_blue(a: float, b: float) -> bool:
    """Whether a hue is between 215° and 330°, where R_T counts."""
    return b < 0.0 and a > 1.43 * b and a < -1.73 * b


@leaf_kernel
def set_metric(slope: FloatArray, x: float, y: float, z: float, metric: FloatArray) -> float:
    """Set the quadratic polynomial that approximates the square of ΔE00 around a colour.

    Sets the matrix (L*L*, a*a*, a*b*, b*b*) and the place of the minimum, and returns the minimum.
    """
    uy, uz, vy, vz, rotation = slope[4], slope[5], slope[6], slope[7], slope[8]
    ll = slope[3] * slope[3]
    aa = uy * uy + vy * vy + rotation * uy * vy
    ab = uy * uz + vy * vz + 0.5 * rotation * (uy * vz + uz * vy)
    bb = uz * uz + vz * vz + rotation * uz * vz
    flat = aa * bb - ab * ab
    dx = slope[0] / ll
    dy = (bb * slope[1] - ab * slope[2]) / flat
    dz = (aa * slope[2] - ab * slope[1]) / flat
    metric[0], metric[1], metric[2], metric[3] = ll, aa, ab, bb
    metric[4], metric[5], metric[6] = x - dx, y - dy, z - dz
    return slope[9] * slope[9] - slope[0] * dx - slope[1] * dy - slope[2] * dz


@leaf_kernel
def set_metric_bounds(
    metric: FloatArray, centre: FloatArray, tree: FaceTree, node: int, squares: FloatArray
) -> None:
    """Set lower bounds of the squared distances to the children of a node, in a metric.

    With the matrix M and the normal n of a disc, a difference d divides into one along M⁻¹ n and
    one in the plane, which are orthogonal in the metric. The first has the square
    (n · d)² ÷ n · M⁻¹ n. In the plane, lengths grow by no more than the larger eigenvalue of M
    there, whose trace is that of M without n · M n and whose determinant is det M × n · M⁻¹ n.
    """
    cylinders = tree.cylinders
    x = (metric[4] - centre[0]) * tree.scale
    y = (metric[5] - centre[1]) * tree.scale
    z = (metric[6] - centre[2]) * tree.scale
    ll, aa, ab, bb = metric[0], metric[1], metric[2], metric[3]
    flat = aa * bb - ab * ab
    inverse_l, inverse_aa, inverse_ab, inverse_bb = 1.0 / ll, bb / flat, -ab / flat, aa / flat
    whole_determinant, trace = ll * flat, ll + aa + bb
    row = np.uint64(node)
    # a loop whose length the compiler knows is unrolled first, and then not vectorised
    for each in range(cylinders.shape[1] // 8):
        at = np.uint64(each)
        u = cylinders[row, at] - x
        v = cylinders[row, at + np.uint64(8)] - y
        w = cylinders[row, at + np.uint64(16)] - z
        nx = float(cylinders[row, at + np.uint64(24)])
        ny = float(cylinders[row, at + np.uint64(32)])
        nz = float(cylinders[row, at + np.uint64(40)])
        wide = cylinders[row, at + np.uint64(48)]
        tall = cylinders[row, at + np.uint64(56)]
        square = ll * u * u + aa * v * v + 2.0 * ab * v * w + bb * w * w
        up = abs(nx * u + ny * v + nz * w)
        across = ll * nx * nx + aa * ny * ny + 2.0 * ab * ny * nz + bb * nz * nz
        inverse = (
            inverse_l * nx * nx
            + inverse_aa * ny * ny
            + 2.0 * inverse_ab * ny * nz
            + inverse_bb * nz * nz
        )
        inverse = max(inverse, 1e-300)
        half = 0.5 * (trace - across)
        larger = half + np.sqrt(max(half * half - whole_determinant * inverse, 0.0))
        side = np.sqrt(max(square * (1.0 - ROUNDING) - up * up / inverse, 0.0))
        tilt = np.sqrt(max(across * (1.0 + ROUNDING) - 1.0 / inverse, 0.0))
        side = max(side - wide * np.sqrt(larger) * (1.0 + ROUNDING) - tall * tilt, 0.0)
        above = max(up * (1.0 - ROUNDING) - tall, 0.0)
        squares[at] = side * side + above * above / inverse if wide >= 0.0 else np.inf


@leaf_kernel
def least_chroma(colour: FloatArray, y: float, z: float, radius: float) -> float:
    """Return the least chroma in a circle of the plane of a* and b*.

    It is 0 if it is small, or if the circle meets the hue opposite to that of the colour.
    """
    chroma = np.sqrt(y * y + z * z) - radius
    if chroma > LEAST_CHROMA and not meets_cliff(colour, y, z, radius):
        return chroma
    return 0.0


@leaf_kernel
def tangent_curvature(colour: FloatArray, value: float, chroma: float, y: float, z: float) -> float:
    """Return κ of the tangent for a ball around a colour with a value and a least chroma."""
    flat = 0.012 if is_blue(colour[A] + y, colour[B] + z) else 0.008
    return flat + 0.0014 * value + (2.5 + 0.55 * value) / (chroma * chroma)


@leaf_kernel
def curvature(colour: FloatArray, value: float, chroma: float, y: float, z: float) -> float:
    """Return κ for a ball around a colour with a value and a least chroma."""
    share = 1.0 / chroma
    if is_blue(colour[A] + y, colour[B] + z):
        return 0.003 + 0.0008 * value + share * (0.9 + share * (5.0 + 0.55 * value))
    return 0.0075 + 0.0008 * value + share * share * (8.0 + 0.43 * value)


@leaf_kernel
def meets_cliff(colour: FloatArray, y: float, z: float, radius: float) -> bool:
    """Whether a circle of the plane of a* and b* meets the hue opposite to a colour's."""
    a, b, away = colour[A], colour[B], radius * colour[CHROMA]
    return a * y + b * z <= away and abs(a * z - b * y) < away
