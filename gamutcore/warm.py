"""Compile or load all kernels, by using each of them once on something small.

An image calls this when it is built, a service before it says that it is ready: the first client is
not the one who waits for the compiler. ``python -m gamutcore.warm`` does the same from a shell.
"""

from __future__ import annotations

import numpy as np

from gamutcore.export import FORMATS, encoded_mesh
from gamutcore.gamut import Gamut, Options, build_gamut
from gamutcore.metric import mismatch

__all__ = ["compile_kernels"]


def compile_kernels() -> None:
    """Build a small gamut from samples of a made-up device and use all that can be done with it."""
    steps = np.linspace(0.0, 1.0, 5)
    device = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    rows = "\n".join(
        ",".join(f"{value:.6g}" for value in (*row, 100 * row.mean(), *(80 * (row[:2] - row[2]))))
        for row in device
    )
    table = f"RGB_R,RGB_G,RGB_B,LAB_L,LAB_A,LAB_B\n{rows}\n"
    gamut = build_gamut(table.encode(), Options(surface_samples=1000))
    opened = Gamut.from_bytes(gamut.to_bytes())
    level = opened.history.level(100)
    for name in FORMATS:
        encoded_mesh(level, name)
    cursor = opened.history.cursor(100)
    cursor.finer()
    cursor.coarser()
    mismatch(level, opened.history.level(50))


if __name__ == "__main__":
    compile_kernels()
