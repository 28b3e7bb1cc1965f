"""Decimation of the same boundaries by other mesh libraries.

The libraries come with the optional group ``peers``. Each is called through its Python package with
the settings that served it best. Times are processor times of the decimation alone, on one core.
PyMeshLab is GPL and MeshLib non-commercial, so neither `gamutcore` nor `service` imports them
(docs/decisions/peers.md).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from importlib.metadata import distributions
from typing import Any

import numpy as np

from benchmarks.common import FloatArray, Rows
from benchmarks.devices import Device
from gamutcore.geometry import TriangleMesh

COUNTS = (10_000, 1000, 500, 100, 50, 20, 10)
"""Triangle counts that are compared."""

IndexArray = np.ndarray[Any, np.dtype[np.int64]]

Peer = Callable[[FloatArray, IndexArray, int], Any]
"""From a boundary and a count to two functions: decimate, and read positions and triangles."""


def peer_rows(device: Device, names: Iterable[str]) -> Rows:
    """Measure what libraries make of a device's boundary.

    A library that misses a count is not asked for smaller ones.
    """
    mesh = device.boundary.mesh
    vertices = np.ascontiguousarray(mesh.vertices, np.float64)
    faces = np.ascontiguousarray(mesh.faces, np.int64)
    rows = []
    for name in names:
        for count in COUNTS:
            decimate, read = PEERS[name][1](vertices, faces, count)
            start = time.process_time()
            result = decimate()
            seconds = time.process_time() - start
            positions, triangles = read(result)
            # Some libraries keep the vertices that no face uses.
            used, renumbered = np.unique(triangles, return_inverse=True)
            level = TriangleMesh(
                np.asarray(positions, np.float64)[used], renumbered.reshape(-1, 3).astype(np.int64)
            )
            rows.append({**device.level_row(name, count, level), "seconds": seconds})
            if not rows[-1]["reached"]:
                break
    return rows


def installed() -> list[str]:
    """Return the names of the libraries that are installed."""
    return [name for name, (package, _) in PEERS.items() if any(distributions(name=package))]


def _vtk(vertices: FloatArray, faces: IndexArray, count: int) -> Any:  # noqa: ANN401  # untyped
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkQuadricDecimation

    points, cells, surface = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(numpy_to_vtk(vertices, deep=True))
    cells.SetData(3, numpy_to_vtkIdTypeArray(faces.ravel(), deep=True))
    surface.SetPoints(points)
    surface.SetPolys(cells)
    decimation = vtkQuadricDecimation()
    decimation.SetInputData(surface)
    decimation.SetTargetReduction(1 - count / len(faces))

    def read(_: object) -> tuple[FloatArray, IndexArray]:
        result = decimation.GetOutput()
        return (
            vtk_to_numpy(result.GetPoints().GetData()),
            vtk_to_numpy(result.GetPolys().GetConnectivityArray()),
        )

    return decimation.Update, read


def _pymeshlab(vertices: FloatArray, faces: IndexArray, count: int) -> Any:  # noqa: ANN401
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))

    def decimate() -> Any:  # noqa: ANN401
        meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=count, preservetopology=True)
        return meshes.current_mesh()

    return decimate, lambda mesh: (mesh.vertex_matrix(), mesh.face_matrix())


def _meshlib(vertices: FloatArray, faces: IndexArray, count: int) -> Any:  # noqa: ANN401
    from meshlib import mrmeshnumpy, mrmeshpy

    mesh = mrmeshnumpy.meshFromFacesVerts(faces.astype(np.int32), vertices)
    settings = mrmeshpy.DecimateSettings()
    settings.maxDeletedFaces = len(faces) - count
    settings.packMesh = True
    settings.maxTriangleAspectRatio = 1e30
    settings.stabilizer = 1e-6
    return lambda: mrmeshpy.decimateMesh(mesh, settings), lambda _: (
        mrmeshnumpy.getNumpyVerts(mesh),
        mrmeshnumpy.getNumpyFaces(mesh.topology),
    )


def _fast_simplification(vertices: FloatArray, faces: IndexArray, count: int) -> Any:  # noqa: ANN401
    import fast_simplification

    return (
        lambda: fast_simplification.simplify(vertices, faces, target_count=count),
        lambda result: result,
    )


def _meshoptimizer(vertices: FloatArray, faces: IndexArray, count: int) -> Any:  # noqa: ANN401
    import meshoptimizer

    positions = np.ascontiguousarray(vertices, np.float32)
    indices = np.ascontiguousarray(faces.ravel(), np.uint32)
    found = np.empty_like(indices)
    # The error limit counts in sizes of the mesh, so only the count ends the simplification.
    return lambda: meshoptimizer.simplify(
        found, indices, positions, target_index_count=3 * count, target_error=1e9
    ), lambda size: (vertices, found[:size])


def _manifold(vertices: FloatArray, faces: IndexArray, count: int) -> Any:  # noqa: ANN401
    """Simplify with the smallest tolerance that reaches the count.

    It is found by bisection, and the time is that of one simplification with it.
    """
    import manifold3d

    solid = manifold3d.Manifold(manifold3d.Mesh64(vertices, faces.astype(np.uint64)))
    extent = float(np.ptp(vertices, axis=0).max())
    coarse = 1e-5 * extent
    # Counts are not monotonic in the tolerance, so the first that reaches the count is taken.
    while solid.simplify(coarse).num_tri() > count and coarse < extent / 8:
        coarse *= 2
    fine = coarse / 2
    for _ in range(6):
        middle = (fine + coarse) / 2
        if solid.simplify(middle).num_tri() <= count:
            coarse = middle
        else:
            fine = middle

    def read(mesh: Any) -> tuple[FloatArray, IndexArray]:  # noqa: ANN401
        return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)

    return lambda: solid.simplify(coarse).to_mesh64(), read


PEERS: dict[str, tuple[str, Peer]] = {
    "VTK": ("vtk", _vtk),
    "PyMeshLab": ("pymeshlab", _pymeshlab),
    "MeshLib": ("meshlib", _meshlib),
    "fast-simplification": ("fast-simplification", _fast_simplification),
    "meshoptimizer": ("meshoptimizer", _meshoptimizer),
    "Manifold": ("manifold3d", _manifold),
}
"""Package and function by the name in tables."""
