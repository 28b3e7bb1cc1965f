"""Decimation of the same boundaries by other mesh libraries.

The libraries come with the optional group ``peers``. Each is called through its Python package with
the settings that served it best. Times are processor times of the decimation alone, on one core.
PyMeshLab is GPL and MeshLib non-commercial, so neither `gamutcore` nor `service` imports them
(docs/decisions/peers.md).
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from benchmarks.common import FloatArray, Rows
from benchmarks.devices import Device, exact_mismatch, faults
from gamutcore.mesh import TriangleMesh

__all__ = ["COUNTS", "PEERS", "installed", "level_row", "peer_rows"]

COUNTS = (10_000, 1000, 500, 100, 50, 20, 10)
"""Triangle counts that are compared."""

IndexArray = np.ndarray[Any, np.dtype[np.int64]]
PeerResult = tuple[FloatArray, IndexArray, float]
"""Vertices, faces, and seconds."""

Peer = Callable[[FloatArray, IndexArray, int], PeerResult]


def peer_rows(device: Device, names: Iterable[str]) -> Rows:
    """Measure what installed libraries make of a device's boundary.

    Rows are those of `level_row`. A library that misses a count is not asked for smaller ones.
    """
    mesh = device.boundary.mesh
    vertices = np.ascontiguousarray(mesh.vertices, np.float64)
    faces = np.ascontiguousarray(mesh.faces, np.int64)
    rows = []
    for name in names:
        for count in COUNTS:
            positions, triangles, seconds = PEERS[name][1](vertices, faces, count)
            level = _compact(positions, triangles)
            rows.append({**level_row(device, name, count, level), "seconds": seconds})
            if not rows[-1]["reached"]:
                break
    return rows


def installed() -> list[str]:
    """Return the names of the libraries that are installed."""
    return [name for name, (package, _) in PEERS.items() if importlib.util.find_spec(package)]


def level_row(device: Device, method: str, asked: int, mesh: TriangleMesh) -> dict[str, Any]:
    """Return the mismatch and the faults of a level by a method."""
    return {
        "device": device.name,
        "method": method,
        "asked": asked,
        "triangles": mesh.triangles,
        "reached": 4 <= mesh.triangles <= asked,
        "mismatch": exact_mismatch(device.boundary.mesh, mesh, device.boundary.centre),
        "faults": faults(mesh, device.boundary.centre),
    }


def _compact(vertices: FloatArray, faces: IndexArray) -> TriangleMesh:
    """Remove the vertices that no face uses, which some libraries keep."""
    used, renumbered = np.unique(faces, return_inverse=True)
    return TriangleMesh(
        np.asarray(vertices, np.float64)[used], renumbered.reshape(-1, 3).astype(np.int64)
    )


# --- one function for each library ----------------------------------------------------------------


def _vtk_run(
    decimation: Any,  # noqa: ANN401  # VTK has no static types
    vertices: FloatArray,
    faces: IndexArray,
    count: int,
) -> PeerResult:
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    points, cells, surface = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(numpy_to_vtk(vertices, deep=True))
    cells.SetData(3, numpy_to_vtkIdTypeArray(faces.ravel(), deep=True))
    surface.SetPoints(points)
    surface.SetPolys(cells)
    decimation.SetInputData(surface)
    decimation.SetTargetReduction(1 - count / len(faces))
    start = time.process_time()
    decimation.Update()
    seconds = time.process_time() - start
    result = decimation.GetOutput()
    return (
        vtk_to_numpy(result.GetPoints().GetData()).astype(np.float64),
        vtk_to_numpy(result.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64),
        seconds,
    )


def _vtk_quadric(vertices: FloatArray, faces: IndexArray, count: int) -> PeerResult:
    from vtkmodules.vtkFiltersCore import vtkQuadricDecimation

    return _vtk_run(vtkQuadricDecimation(), vertices, faces, count)


def _vtk_pro(vertices: FloatArray, faces: IndexArray, count: int) -> PeerResult:
    from vtkmodules.vtkFiltersCore import vtkDecimatePro

    decimation = vtkDecimatePro()
    decimation.PreserveTopologyOn()
    return _vtk_run(decimation, vertices, faces, count)


def _pymeshlab(*, topology: bool) -> Peer:
    def run(vertices: FloatArray, faces: IndexArray, count: int) -> PeerResult:
        import pymeshlab

        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
        start = time.process_time()
        meshes.meshing_decimation_quadric_edge_collapse(
            targetfacenum=count, preservetopology=topology
        )
        seconds = time.process_time() - start
        result = meshes.current_mesh()
        return result.vertex_matrix(), result.face_matrix().astype(np.int64), seconds

    return run


def _fast_simplification(vertices: FloatArray, faces: IndexArray, count: int) -> PeerResult:
    import fast_simplification

    start = time.process_time()
    positions, triangles = fast_simplification.simplify(vertices, faces, target_count=count)
    return positions, triangles, time.process_time() - start


def _meshlib(*, tuned: bool) -> Peer:
    def run(vertices: FloatArray, faces: IndexArray, count: int) -> PeerResult:
        from meshlib import mrmeshnumpy, mrmeshpy

        mesh = mrmeshnumpy.meshFromFacesVerts(faces.astype(np.int32), vertices)
        settings = mrmeshpy.DecimateSettings()
        settings.maxDeletedFaces = len(faces) - count
        settings.packMesh = True
        if tuned:
            settings.maxTriangleAspectRatio = 1e30
            settings.stabilizer = 1e-6
        start = time.process_time()
        mrmeshpy.decimateMesh(mesh, settings)
        seconds = time.process_time() - start
        return (
            mrmeshnumpy.getNumpyVerts(mesh),
            mrmeshnumpy.getNumpyFaces(mesh.topology).astype(np.int64),
            seconds,
        )

    return run


def _manifold(vertices: FloatArray, faces: IndexArray, count: int) -> PeerResult:
    """Simplify with the smallest tolerance that reaches the count, found by bisection.

    The time is that of the last simplification, as if the tolerance had been known.
    """
    import manifold3d

    solid = manifold3d.Manifold(manifold3d.Mesh64(vertices, faces.astype(np.uint64)))

    def simplified(tolerance: float) -> tuple[Any, float]:
        start = time.process_time()
        simple = solid.simplify(tolerance)
        simple.num_tri()  # forces the evaluation
        return simple, time.process_time() - start

    extent = float(np.ptp(vertices, axis=0).max())
    coarse = 1e-5 * extent
    best, seconds = simplified(coarse)
    # Counts are not monotonic in the tolerance, so the first that reaches the count is taken.
    while best.num_tri() > count and coarse < extent / 8:
        coarse *= 2
        best, seconds = simplified(coarse)
    fine = coarse / 2
    for _ in range(6 if best.num_tri() <= count else 0):
        middle = (fine + coarse) / 2
        simple, taken = simplified(middle)
        if simple.num_tri() <= count:
            coarse, best, seconds = middle, simple, taken
        else:
            fine = middle
    mesh = best.to_mesh64()
    positions = np.asarray(mesh.vert_properties)[:, :3]
    return positions, np.asarray(mesh.tri_verts).astype(np.int64), seconds


def _meshoptimizer(vertices: FloatArray, faces: IndexArray, count: int) -> PeerResult:
    import meshoptimizer

    positions = np.ascontiguousarray(vertices, np.float32)
    indices = np.ascontiguousarray(faces.ravel(), np.uint32)
    found = np.empty_like(indices)
    start = time.process_time()
    # The error limit counts in sizes of the mesh, so only the count ends the simplification.
    size = meshoptimizer.simplify(
        found, indices, positions, target_index_count=3 * count, target_error=1e9
    )
    seconds = time.process_time() - start
    return vertices, found[:size].reshape(-1, 3).astype(np.int64), seconds


PEERS: dict[str, tuple[str, Peer]] = {
    "VTK": ("vtkmodules", _vtk_quadric),
    "VTK DecimatePro": ("vtkmodules", _vtk_pro),
    "PyMeshLab": ("pymeshlab", _pymeshlab(topology=False)),
    "PyMeshLab, topology kept": ("pymeshlab", _pymeshlab(topology=True)),
    "MeshLib": ("meshlib", _meshlib(tuned=False)),
    "MeshLib, tuned": ("meshlib", _meshlib(tuned=True)),
    "fast-simplification": ("fast_simplification", _fast_simplification),
    "meshoptimizer": ("meshoptimizer", _meshoptimizer),
    "Manifold": ("manifold3d", _manifold),
}
"""Package and function by the name in tables."""
