"""The default cost: memoryless quadrics under exact preservation of volume.

Memoryless: the planes are those of the faces around the edge as it is now, weighted by their
area, not an accumulated history (Lindstrom & Turk, "Fast and Memory Efficient Polygonal
Simplification", 1998; Hoppe, "New Quadric Metric for Simplifying Meshes with Appearance
Attributes", 1999). Volume: the new vertex is the minimum of that quadric among the positions that
leave the enclosed volume as it is, which are a plane. On smooth sides that comes within a few per
cent of the best possible.

With y the position relative to the edge's midpoint, N the (doubled) area vector of a face around
the edge and d = N·(p − midpoint) for a vertex p of it, the error is Σ (N·y − d)² ÷ (2 |N|), and
the volume is preserved where g·y = Σ d with g the (doubled) area vector of the edge's link.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.corner_table import following, preceding, swung
from gamutcore.decimation.costs import interface
from gamutcore.decimation.star import Surface
from gamutcore.kernels import leaf_kernel

__all__ = ["VolumeState", "state"]

REGULARISATION = 1e-5
"""Weight of the midpoint in the solve, as a part of the quadric's trace; decides on flat sides."""


FLATNESS = 1e-10
"""Weight of the squared edge length in the error, as a part of the quadric's trace: on exactly flat
sides it makes shorter edges come first, elsewhere it weighs nothing (as in `quadric`)."""


class VolumeState(NamedTuple):
    """Scratch for the edge at hand; nothing is remembered between collapses.

    Attributes
    ----------
    sums : (15,) float64
        a00, a01, a02, a11, a12, a22, b0, b1, b2, c of the error yᵀA y − 2 bᵀy + c, then g0, g1,
        g2 and the volume's right-hand side, and what is added to the error for the edge's length.
    """

    sums: FloatArray


def state(positions: FloatArray, faces: IndexArray) -> VolumeState:  # noqa: ARG001
    """Return the scratch of a decimation; the parameters are those of every cost's `state`."""
    return VolumeState(np.zeros(15))


@leaf_kernel
def _gather(cost: VolumeState, surface: Surface, kept: int, dead: int) -> None:
    """Sum what the error and the volume are made of over the faces around an edge."""
    position, vertex, sums = surface.position, surface.vertex, cost.sums
    mx = 0.5 * (position[kept, 0] + position[dead, 0])
    my = 0.5 * (position[kept, 1] + position[dead, 1])
    mz = 0.5 * (position[kept, 2] + position[dead, 2])
    a00, a01, a02, a11, a12, a22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    b0, b1, b2, c = 0.0, 0.0, 0.0, 0.0
    g0, g1, g2, h = 0.0, 0.0, 0.0, 0.0
    for end in range(2):
        centre, other = (kept, dead) if end == 0 else (dead, kept)
        ex, ey, ez = position[centre, 0] - mx, position[centre, 1] - my, position[centre, 2] - mz
        first = surface.corner_at[centre]
        corner = first
        one = vertex[following(corner)]
        ux, uy, uz = position[one, 0] - mx, position[one, 1] - my, position[one, 2] - mz
        while True:
            two = vertex[preceding(corner)]
            vx, vy, vz = position[two, 0] - mx, position[two, 1] - my, position[two, 2] - mz
            shared = one == other or two == other
            if end == 0 or not shared:
                px, py, pz = ux - ex, uy - ey, uz - ez
                qx, qy, qz = vx - ex, vy - ey, vz - ez
                nx, ny, nz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
                weight = 0.5 / np.sqrt(nx * nx + ny * ny + nz * nz)
                d = nx * ex + ny * ey + nz * ez
                wx, wy, wz = weight * nx, weight * ny, weight * nz
                a00 += wx * nx
                a01 += wx * ny
                a02 += wx * nz
                a11 += wy * ny
                a12 += wy * nz
                a22 += wz * nz
                b0 += wx * d
                b1 += wy * d
                b2 += wz * d
                c += weight * d * d
                if not shared:
                    g0 += uy * vz - uz * vy
                    g1 += uz * vx - ux * vz
                    g2 += ux * vy - uy * vx
                    h += d
            # the face across the edge to `two` comes next, and there `two` is the following vertex
            one, ux, uy, uz = two, vx, vy, vz
            corner = swung(surface.opposite, corner)
            if corner == first:
                break
    sums[0], sums[1], sums[2], sums[3], sums[4], sums[5] = a00, a01, a02, a11, a12, a22
    sums[6], sums[7], sums[8], sums[9] = b0, b1, b2, c
    sums[10], sums[11], sums[12], sums[13] = g0, g1, g2, h
    dx, dy, dz = position[kept, 0] - mx, position[kept, 1] - my, position[kept, 2] - mz
    sums[14] = FLATNESS * (a00 + a11 + a22) * 4.0 * (dx * dx + dy * dy + dz * dz)


@leaf_kernel
def _value(sums: FloatArray, x: float, y: float, z: float) -> float:
    """Error at a position relative to the midpoint; rounding must not make it negative."""
    quadratic = (
        sums[0] * x * x
        + sums[3] * y * y
        + sums[5] * z * z
        + 2.0 * (sums[1] * x * y + sums[2] * x * z + sums[4] * y * z)
    )
    linear = sums[6] * x + sums[7] * y + sums[8] * z
    return max(quadratic - 2.0 * linear + sums[9], 0.0) + sums[14]


@leaf_kernel
def _optimum(cost: VolumeState, surface: Surface, kept: int, dead: int, place: FloatArray) -> float:
    _gather(cost, surface, kept, dead)
    sums, position = cost.sums, surface.position
    pull = REGULARISATION * (sums[0] + sums[3] + sums[5])
    a, b, c = sums[0] + pull, sums[1], sums[2]
    d, e, f = sums[3] + pull, sums[4], sums[5] + pull
    # inverse of a symmetric 3 × 3 matrix by its cofactors; the determinant cancels in the end
    i00, i01, i02 = d * f - e * e, c * e - b * f, b * e - c * d
    i11, i12, i22 = a * f - c * c, b * c - a * e, a * d - b * b
    determinant = a * i00 + b * i01 + c * i02
    bx, by, bz = sums[6], sums[7], sums[8]
    gx, gy, gz = sums[10], sums[11], sums[12]
    # A⁻¹ b, the free minimum, and A⁻¹ g, the way along which the volume changes most cheaply
    ux = i00 * bx + i01 * by + i02 * bz
    uy = i01 * bx + i11 * by + i12 * bz
    uz = i02 * bx + i12 * by + i22 * bz
    vx = i00 * gx + i01 * gy + i02 * gz
    vy = i01 * gx + i11 * gy + i12 * gz
    vz = i02 * gx + i12 * gy + i22 * gz
    along = gx * vx + gy * vy + gz * vz
    x, y, z = 0.0, 0.0, 0.0
    if determinant > 0.0 and along > 0.0:
        step = (sums[13] * determinant - (gx * ux + gy * uy + gz * uz)) / along
        x = (ux + step * vx) / determinant
        y = (uy + step * vy) / determinant
        z = (uz + step * vz) / determinant
    place[0] = 0.5 * (position[kept, 0] + position[dead, 0]) + x
    place[1] = 0.5 * (position[kept, 1] + position[dead, 1]) + y
    place[2] = 0.5 * (position[kept, 2] + position[dead, 2]) + z
    return _value(sums, x, y, z)


@leaf_kernel
def _error(cost: VolumeState, surface: Surface, kept: int, dead: int, place: FloatArray) -> float:
    _gather(cost, surface, kept, dead)
    position = surface.position
    return _value(
        cost.sums,
        place[0] - 0.5 * (position[kept, 0] + position[dead, 0]),
        place[1] - 0.5 * (position[kept, 1] + position[dead, 1]),
        place[2] - 0.5 * (position[kept, 2] + position[dead, 2]),
    )


@leaf_kernel
def _merge(cost: VolumeState, surface: Surface, kept: int, dead: int, place: FloatArray) -> None:
    """Nothing to bring up to date: memoryless."""


interface.implement(VolumeState, optimum=_optimum, error=_error, merge=_merge, depends_on_ring=True)
