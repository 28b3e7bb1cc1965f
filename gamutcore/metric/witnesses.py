"""Evidence that levels are further from the full boundary than a limit.

A vertex of the full boundary that is too far from every face of a level rejects the level. It also
rejects the next finer level if it is too far from the faces that the split between them changes. A
face of a level with a point too far from the full boundary rejects all levels with this face. Most
levels are therefore rejected in about a microsecond, and only few are compared as a whole.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.history import apply_splits, fine_columns
from gamutcore.kernels import kernel
from gamutcore.metric.cones import INDEX, Locations
from gamutcore.metric.distance_bound import Surface, nearest_face, squared_distance

if TYPE_CHECKING:
    from gamutcore.history import History

__all__ = ["Evidence", "LevelWalk", "find_evidence"]


class Evidence(NamedTuple):
    """Evidence that rejects a level and some finer ones.

    Attributes
    ----------
    points : (k, 3) float64
        Points of the full boundary, relative to the centre. Each rejects the levels without a face
        within the limit.
    faces : (m,) int32
        Faces of the level. Each rejects the levels that have the face.
    """

    points: FloatArray
    faces: IndexArray


def find_evidence(
    full: Surface, level: Surface, locations: Locations, limit: float
) -> Evidence | None:
    """Return evidence from the vertices of the full boundary, located in the cones of the level.

    Evidence has up to one point for each face of the level, and all faces with a point farther than
    `limit` from the full boundary. None if no vertex is evidence.
    """
    points, faces = _find_evidence(full, level, locations, limit)
    if len(points) == len(faces) == 0:
        return None
    return Evidence(full.position[points], faces)


class LevelWalk:
    """A walk through levels from coarse to fine, past those that evidence rejects.

    `counts` (n,) are the ascending triangle counts of the levels.
    """

    def __init__(self, history: History, counts: IndexArray) -> None:
        level = history.level(int(counts[0]))
        vertices = int(counts[-1]) // 2 + 2
        self._counts = counts
        self._centre = np.asarray(history.centre, np.float64)
        self._columns = fine_columns(history.splits)
        self._positions = np.zeros((vertices, 3), np.float32)
        self._positions[: len(level.vertices)] = level.vertices
        corner = np.empty(6 * vertices - 12, np.int32)
        corner[: 3 * level.triangles] = level.faces.ravel()
        none = np.empty(0, np.int32)
        self._surface = Surface(self._positions - self._centre, corner, none, none, np.empty(0))
        self.index = 0

    def skip(self, evidence: Evidence, limit: float) -> None:
        """Go to the first level, from the present one on, that evidence does not reject.

        `index` becomes its index in `counts`, or their number if all are rejected. The evidence has
        faces of the present level, and `limit` is the largest accepted distance.
        """
        self._walk(evidence, limit, stop=False)

    def advance(self) -> None:
        """Go to the next level."""
        self._walk(Evidence(np.empty((0, 3)), np.empty(0, np.int32)), 0.0, stop=True)

    def _walk(self, evidence: Evidence, limit: float, *, stop: bool) -> None:
        self.index = _walk(
            self._counts, self.index, self._positions, self._surface, self._centre,
            *evidence, limit, stop, *self._columns,
        )  # fmt: skip


@kernel
def _find_evidence(
    full: Surface, level: Surface, locations: Locations, limit: float
) -> tuple[IndexArray, IndexArray]:
    """Return vertices of the full boundary and faces of the level, as for `find_evidence`.

    Each face examines only its furthest vertex along the ray.
    """
    faces = len(level.corner) // 3
    furthest = np.full(faces, -1, np.int32)
    for vertex in range(len(full.position)):
        face = locations.face[INDEX(vertex)]
        before = furthest[INDEX(face)]
        if before < 0 or locations.along[INDEX(vertex)] > locations.along[INDEX(before)]:
            furthest[INDEX(face)] = vertex
    is_far, is_beyond = np.zeros(faces, np.uint8), np.zeros(faces, np.uint8)
    for face in range(faces):
        vertex = furthest[face]
        if vertex < 0 or locations.along[vertex] <= limit:
            continue
        x, y, z = full.position[vertex, 0], full.position[vertex, 1], full.position[vertex, 2]
        _, squared = nearest_face(x, y, z, level, face)
        is_far[face] = np.sqrt(squared) > limit
        if not is_far[face]:
            t = 1.0 / (1.0 + locations.beyond[vertex])
            start = full.fan[INDEX(full.fan_end[vertex] - 1)]
            _, squared = nearest_face(t * x, t * y, t * z, full, start)
            is_beyond[face] = np.sqrt(squared) > limit
    return furthest[is_far != 0], np.nonzero(is_beyond)[0].astype(np.int32)


@kernel
def _walk(  # noqa: C901, PLR0912  # one pass, so that nothing is copied
    counts: IndexArray,
    index: int,
    positions: Float32Array,
    level: Surface,
    centre: FloatArray,
    points: FloatArray,
    faces: IndexArray,
    limit: float,
    stop: bool,
    parent: IndexArray,
    fine: Float32Array,
    added: Float32Array,
    split_faces: IndexArray,
    moved_end: IndexArray,
    moved: IndexArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_fine: Float32Array,
) -> int:
    """Return the index of the first level that is not rejected; `level` becomes that level.

    With `stop`, return the index of the next level.
    """
    position, corner = level.position, level.corner
    kept = np.zeros(len(corner) // 3, np.uint8)
    for face in faces:
        kept[face] = 1
    left = len(faces)
    changed = np.zeros(len(position), np.uint8)
    # the next point, and whether it is known to be too far from the present level
    point, is_far = 0, False
    while True:
        present = counts[index]
        if left == 0 and not stop:
            while not is_far and point < len(points):
                is_far = _is_far(points[point], level, present, limit)
                point += 0 if is_far else 1
            if not is_far:
                return index
        index += 1
        if index == len(counts):
            return index
        start, end = present // 2 + 2, counts[index] // 2 + 2
        apply_splits(
            positions, corner, start, end, parent, fine, added, split_faces,
            moved_end, moved, shifted_end, shifted, shifted_fine,
        )  # fmt: skip
        for split in range(start - 4, end - 4):
            changed[parent[split]], changed[split + 4] = 1, 1
            for entry in range(shifted_end[split - 1] if split > 0 else 0, shifted_end[split]):
                changed[shifted[entry]] = 1
        for vertex in range(end):
            if changed[INDEX(vertex)] != 0:
                for axis in range(3):
                    position[vertex, axis] = np.float64(positions[vertex, axis]) - centre[axis]
        for face in range(counts[index]):
            at = INDEX(3 * face)
            one, two, three = corner[at], corner[at + INDEX(1)], corner[at + INDEX(2)]
            if changed[INDEX(one)] | changed[INDEX(two)] | changed[INDEX(three)]:
                left -= kept[face]
                kept[face] = 0
                if is_far:
                    x, y, z = points[point, 0], points[point, 1], points[point, 2]
                    is_far = np.sqrt(squared_distance(x, y, z, level, face)) > limit
        changed[:end] = 0
        if stop:
            return index


@kernel
def _is_far(point: FloatArray, level: Surface, faces: int, limit: float) -> bool:
    """Whether a point is further than the limit from all of the first `faces` faces."""
    for face in range(faces):
        if np.sqrt(squared_distance(point[0], point[1], point[2], level, face)) <= limit:
            return False
    return True
