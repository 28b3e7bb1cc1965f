"""Compile or load all kernels, by using each of them once on something small.

An image calls this when it is built, a service before it says that it is ready: the first client is
not the one who waits for the compiler. ``python -m gamutcore.warm`` does the same from a shell.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gamutcore.boundary import BOUNDARIES, compute_boundary
from gamutcore.characterisation.icc.grid import Grid
from gamutcore.characterisation.icc.process_elements import FloatGrid
from gamutcore.decimation import COSTS, decimated
from gamutcore.device_values import DeviceValues
from gamutcore.export import FORMATS, mesh_file
from gamutcore.gamut import Gamut, Options, build_gamut
from gamutcore.history import History, Splits, build_history, history_bytes, history_from_bytes
from gamutcore.history.device_history import build_device_history
from gamutcore.metric import mismatch, radial_difference, voxel_mismatch
from gamutcore.metric.level_search import Bounds, LevelSearch

__all__ = ["compile_kernels", "compile_reading_kernels"]


def compile_kernels() -> None:
    """Use everything once: build a small gamut from samples of a made-up device, and read it."""
    steps = np.linspace(0.0, 1.0, 5)
    device = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    rows = "\n".join(
        ",".join(f"{value:.6g}" for value in (*row, 100 * row.mean(), *(80 * (row[:2] - row[2]))))
        for row in device
    )
    table = f"RGB_R,RGB_G,RGB_B,LAB_L,LAB_A,LAB_B\n{rows}\n"
    options = Options(surface_samples=1000, cost="quadric")
    built = build_gamut(table.encode(), options)
    build_gamut(table.encode(), replace(options, device_model="fit"))
    Gamut.from_bytes(built.to_bytes()).level(50)
    Grid((2, 2, 2), np.zeros((8, 3), np.uint16)).values(np.full((1, 3), 0.5))
    FloatGrid((2, 2, 2), (np.zeros((8, 3), np.float32),), 3).values(np.full((1, 3), 0.5))
    for method in BOUNDARIES:
        boundary = compute_boundary(device, method)
    # small: errors by samples, of which there are as many however few the faces, take a while
    cube = compute_boundary(device[(device % 1.0 == 0.0).all(axis=1)], "convex-hull")
    for cost in COSTS:
        decimated(cube.mesh, cube.centre, cost)
    history = build_history(decimated(boundary.mesh, boundary.centre, "quadric"))
    cursor = history.cursor(100)
    cursor.finer()
    cursor.coarser()
    for function in (mismatch, voxel_mismatch):
        function(history.full(), history.level(50))
    radial_difference(history.full(), history.level(50), history.centre)
    compile_reading_kernels()


def compile_reading_kernels() -> None:
    """Use once all that serving built gamuts takes: reading, choosing and writing their levels."""
    corners = np.array([(50, 0, 40), (50, 40, -20), (50, -40, -20), (90, 0, 0)], np.float32)
    # a tetrahedron whose first vertex is split into itself and slot 4
    splits = Splits(
        base_positions=corners,
        base_faces=np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)], np.int32),
        parent=np.zeros(1, np.int32),
        coarse=corners[:1],
        fine=corners[:1],
        added=corners[:1] - np.float32(1),
        faces=np.array([[(0, 4, 2), (4, 0, 1)]], np.int32),
        moved_end=np.ones(1, np.int32),
        moved=np.zeros(1, np.int32),
        shifted_end=np.zeros(1, np.int32),
        shifted=np.zeros(0, np.int32),
        shifted_coarse=np.zeros((0, 3), np.float32),
        shifted_fine=np.zeros((0, 3), np.float32),
    )
    ramp = DeviceValues(("K",), np.linspace(0.0, 1.0, 5)[:, np.newaxis])
    device = build_device_history(ramp, np.arange(5, dtype=np.int32), splits)
    history = History(splits, np.array([60.0, 0.0, 0.0]), 2.0**-11, device)
    history, _ = history_from_bytes(history_bytes(history))
    LevelSearch(history.triangles, []).find(history, Bounds(distance=1e-6))
    mesh = replace(history.level(6), device=history.device_values(6))
    for name in FORMATS:
        mesh_file(mesh, name)


if __name__ == "__main__":
    compile_kernels()
