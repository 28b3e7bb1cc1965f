"""Compile the kernels by using each of them once on small data.

The build of an image does so, a service before it reports that it is ready
(`gamutcore.kernels.ensure_compiled`), and ``python -m gamutcore.warm`` from a shell.
"""

from __future__ import annotations

import argparse
import gc
import multiprocessing
import os
import tempfile
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from gamutcore.boundary import (
    BOUNDARIES,
    compute_boundary,
    device_surface_boundary,
    radial_map,
    voxel_mismatch,
)
from gamutcore.boundary.centre import face_planes
from gamutcore.boundary.device_surface import hidden_area
from gamutcore.boundary.radial_envelope import COARSE, radial_volume
from gamutcore.characterisation import Samples, read_characterisation
from gamutcore.characterisation.icc.transforms import Grid
from gamutcore.colours import LookupTable, SurfaceFaces, surface_colours
from gamutcore.decimation import COSTS, decimate
from gamutcore.export import FORMATS, mesh_file
from gamutcore.export.picture_file import png
from gamutcore.export.rendering import mesh_picture
from gamutcore.gamut import Gamut
from gamutcore.geometry import DeviceValues, TriangleMesh
from gamutcore.history import (
    History,
    Splits,
    build_device_history,
    build_history,
    history_bytes,
    history_from_bytes,
)
from gamutcore.kernels import GROUPS, compilation_lock, is_compiled, mark_compiled, watchers
from gamutcore.levels import (
    LevelRequest,
    LevelSearch,
    curve_counts,
    error_curve,
    radial_difference,
)
from gamutcore.search import (
    LevelIndex,
    build_index,
    contains,
    nearest,
    nearest_ciede2000,
    signed_distance,
)

__all__ = ["compile_kernels", "use_kernels"]

COLLECTION = (100_000, 20, 100)
"""Thresholds of the garbage collector while kernels compile. The compiler keeps most of its
objects: with Python's own thresholds, collections take a tenth of the time and free little."""


def compile_kernels(groups: tuple[str, ...] = GROUPS) -> None:
    """Compile groups of kernels, those with two steps in two processes, and mark them."""
    for group in groups:
        with compilation_lock(group):
            if is_compiled(group):
                continue
            first, *rest = STEPS[group]
            spawn = multiprocessing.get_context("spawn")
            others = [
                spawn.Process(target=_use_beside, args=(step, bool(watchers)), daemon=True)
                for step in rest[:1]
            ]
            for other in others:
                other.start()
            first()
            for other in others:
                other.join()
            for step in rest[1:]:
                step()
            mark_compiled(group)


def use_kernels(group: str) -> None:
    """Call every kernel of a group in this process, to compile it or load it from the cache."""
    for step in STEPS[group]:
        step()


def _use_beside(step: Callable[[], None], printing: bool) -> None:
    """Take a step in a process that ends with the one that started it."""
    parent = multiprocessing.parent_process()
    assert parent is not None  # noqa: S101  # `compile_kernels` starts this process
    _exit_after(parent.join)
    gc.set_threshold(*COLLECTION)
    if printing:
        watchers.append(_print_name)
    step()


def _print_name(name: str) -> None:
    print(name, flush=True)  # noqa: T201  # for the process that started this one


def _exit_after(wait: Callable[[], None]) -> None:
    """End this process when a function returns."""

    def end() -> None:
        wait()
        os._exit(1)

    threading.Thread(target=end, daemon=True).start()


def _use_surface() -> None:
    """Decimate, and wrap surfaces around colours and of devices."""
    _decimate_cube("volume")
    compute_boundary(_device(), "modified-convex-hull")
    _use_device_surface()


def _use_index() -> None:
    """Search an index.

    Signed distances are not needed at first, but in this process their parts are compiled: they
    take 2 s instead of 10 s.
    """
    index = _tetrahedron_index()
    nearest(index.vertices, index)
    contains(index.vertices, index)
    signed_distance(index.vertices, index)


def _tetrahedron_index() -> LevelIndex:
    points = np.array([(50, 0, 40), (50, 40, -20), (50, -40, -20), (90, 0, 0)], np.float64)
    return build_index(points, _TETRAHEDRON, np.array([60.0, 0.0, 0.0]))


def _use_device_surface() -> None:
    """Wrap surfaces of devices, with what only folded ones and more channels use."""
    corners = np.vstack([np.eye(3), np.zeros((1, 3))])
    hidden_area(face_planes(corners, _TETRAHEDRON), np.zeros(3))
    radial_volume(corners, _TETRAHEDRON, np.full(3, 0.1), COARSE)
    # two tetrahedra that cross
    cube = np.array(list(np.ndindex(2, 2, 2)), np.float64)
    corners = cube[[0, 3, 5, 6, 7, 4, 2, 1]]
    both = np.concatenate([_TETRAHEDRON[:, ::-1], _TETRAHEDRON + np.int32(4)])
    labels = np.arange(len(both), dtype=np.int32)
    device_surface_boundary(corners, SurfaceFaces(both, labels, closed=False))


def _decimate_cube(cost: str) -> None:
    # small: errors by samples, of which there are as many however few the faces, take a while
    vertices = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [corners for a, b, c, d in quads for corners in ((a, b, c), (a, c, d))]
    decimate(TriangleMesh(vertices, np.array(faces, np.int32)), np.zeros(3), cost)


def _use_levels_and_models() -> None:
    """Read, search and write levels of a saved gamut, and evaluate models of devices."""
    _use_index()
    corners = np.array([(50, 0, 40), (50, 40, -20), (50, -40, -20), (90, 0, 0)], np.float32)
    # a tetrahedron whose first vertex is split into itself and slot 4
    splits = Splits(
        base_positions=corners,
        base_faces=_TETRAHEDRON,
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
    ramp = DeviceValues(("R", "G", "B"), np.linspace((0.0,) * 3, (1.0,) * 3, 5))
    device = build_device_history(ramp, np.arange(5, dtype=np.int32), splits)
    history = History(splits, np.array([60.0, 0.0, 0.0]), 2.0**-11, device)
    history, _ = history_from_bytes(history_bytes(history))
    counts = curve_counts(history.triangles)
    curve = [level.to_mapping() for level in error_curve(history, counts)]
    search = LevelSearch(curve)
    search.find(history, LevelRequest(max_error=1e-6))
    search.find(history, LevelRequest(max_error=1e-6, side="inside"))
    mesh = replace(history.level(6), device=history.device_values(6))
    for name in FORMATS:
        mesh_file(mesh, name)
    Grid((2, 2, 2), (np.zeros((8, 3), np.uint16),)).values(np.full((1, 3), 0.5))
    samples = read_characterisation(_table())
    assert isinstance(samples, Samples)  # noqa: S101  # what a table holds
    for model in (None, "fit"):
        surface_colours(samples, surface_samples=200, model=model)


def _device() -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return a grid of device values, (125, 3)."""
    steps = np.linspace(0.0, 1.0, 5)
    return np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)


def _table() -> bytes:
    """Return samples of a made-up device as a table."""
    rows = "\n".join(
        ",".join(f"{value:.6g}" for value in (*row, 100 * row.mean(), *(80 * (row[:2] - row[2]))))
        for row in _device()
    )
    return f"RGB_R,RGB_G,RGB_B,LAB_L,LAB_A,LAB_B\n{rows}\n".encode()


def _use_build() -> None:
    """Build gamuts with the default options, of a complete grid and of scattered samples."""
    # few samples, because every process that builds waits for this; more vertices than the trials
    built = Gamut(_table(), surface_samples=200)
    Gamut(_table(), surface_samples=200, device_model="fit")
    Gamut.from_bytes(built.to_bytes()).level(50)


def _use_options() -> None:
    """Use the costs and boundaries other than the default, pictures and comparisons."""
    Grid((2, 2, 2), (np.zeros((8, 3), np.float32),)).values(np.full((1, 3), 0.5))
    for cost in COSTS:
        _decimate_cube(cost)
    for method, entry in BOUNDARIES.items():
        if not entry.needs_faces:
            boundary = compute_boundary(_device(), method)
    history = build_history(decimate(boundary.mesh, boundary.centre, "quadric"))
    LookupTable.sample(np.asarray, 2).values(np.full((1, 3), 0.5))
    cursor = history.cursor(100)
    cursor.finer()
    cursor.coarser()
    voxel_mismatch(history.full(), history.level(50))
    radial_difference(history.full(), history.level(50), history.centre)
    mesh_picture(history.level(50), size=16)
    gamut = Gamut(_table(), surface_samples=200)
    gamut.nearest(_COLOURS)
    gamut.compare(gamut)
    gamut.coverage_of(gamut)


def _use_queries() -> None:
    """Ask for sections, crossings, mapping and recipes."""
    gamut = Gamut(_table(), surface_samples=200)
    radial_map(np.vstack([np.eye(3), np.zeros((1, 3))]), _TETRAHEDRON, np.full(3, 0.1), COARSE)
    gamut.rings()
    gamut.leaf(0.0)
    gamut.leaves([0.0], [50.0])
    gamut.max_chroma(50.0, 0.0)
    gamut.slice(50.0)
    gamut.cusps(4)
    gamut.crossings(_COLOURS, _COLOURS[::-1])
    gamut.map(_COLOURS, "clip-nearest")
    gamut.map(_COLOURS, "sgck", source=gamut)
    gamut.to_device(_COLOURS)
    with tempfile.TemporaryDirectory() as folder:
        picture = png(np.zeros((1, 1, 3), np.uint8))
        gamut.map_picture(picture, Path(folder) / "mapped.png", table=5)
        gamut.map_picture(picture, Path(folder) / "mapped.png", "spatial", iterations=1)


def _use_ciede2000() -> None:
    """Search by CIEDE2000."""
    index = _tetrahedron_index()
    nearest_ciede2000(index.vertices, index)


_TETRAHEDRON = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)], np.int32)

_COLOURS = np.array([(50.0, 0.0, 0.0), (50.0, 90.0, 0.0)])

STEPS = {
    "default": (_use_levels_and_models, _use_surface, _use_build),
    "optional": (_use_options, _use_queries),
    "ciede2000": (_use_ciede2000,),
}
"""What uses the kernels of each group. The first two steps take about as long, have few kernels in
common, and run at the same time. A third one uses the kernels of both."""


def _wait_for_end_of_stdin() -> None:
    # not sys.stdin: at exit the interpreter wants its lock, which this thread would hold
    while os.read(0, 4096):
        pass


def main() -> None:
    """Compile the groups that the command line names, or all."""
    parser = argparse.ArgumentParser(prog="python -m gamutcore.warm", description=__doc__)
    parser.add_argument("group", nargs="*", choices=[*GROUPS, []])
    parser.add_argument(
        "--while-stdin-is-open", action="store_true", help="exit when standard input ends"
    )
    parser.add_argument(
        "--print", action="store_true", help="print the name of each kernel that is usable"
    )
    parser.add_argument("--nice", action="store_true", help="run at the lowest priority")
    arguments = parser.parse_args()
    gc.set_threshold(*COLLECTION)
    if arguments.print:
        watchers.append(_print_name)
    if arguments.nice:
        os.nice(19)
    if arguments.while_stdin_is_open:
        _exit_after(_wait_for_end_of_stdin)
    compile_kernels(tuple(arguments.group) or GROUPS)


if __name__ == "__main__":
    main()
