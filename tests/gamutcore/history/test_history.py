"""Levels: their invariants, round trips through files, and reading in proportion to their size."""

import itertools

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimate
from gamutcore.errors import TriangleCountError
from gamutcore.export import mesh_file
from gamutcore.geometry import TriangleMesh
from gamutcore.history import MINIMUM_TRIANGLES, History, build_history

UNUSED_BY_LEVELS = ("fine", "added", "faces", "moved_end", "moved", "shifted_fine")
READERS = [("glb", "trimesh"), ("glb", "pygltflib"), ("ply", "trimesh"), ("ply", "meshio")]


@pytest.fixture(scope="module")
def spread_counts(fogra39_gamut):
    """Return 200 triangle counts across FOGRA39L, each a fixed part larger than the one before."""
    maximum = fogra39_gamut.history.triangles
    steps = np.geomspace(4, maximum, 260)
    counts = sorted({min(int(n) // 2 * 2, maximum) for n in steps})
    assert len(counts) >= 200
    assert (counts[0], counts[-1]) == (4, maximum)
    return counts


class TestEveryLevelOfASmallGamut:
    def test_small_levels_keep_every_invariant(self, small_gamut, assert_every_level):
        history = small_gamut.history
        counts = list(range(4, history.triangles + 1, 2))
        assert len(counts) > 100
        assert assert_every_level(history.levels(), history.centre) == counts
        for count, level in zip(counts, history.levels(), strict=True):
            assert level == history.level(count)


class TestLevelsAcrossALargeGamut:
    @pytest.mark.slow
    def test_levels_keep_every_invariant(self, fogra39_gamut, spread_counts, assert_every_level):
        history = fogra39_gamut.history
        levels = (history.level(count) for count in spread_counts)
        assert assert_every_level(levels, history.centre) == spread_counts

    @pytest.mark.slow
    def test_levels_of_the_published_cost(
        self, fogra39_quadric, spread_counts, assert_every_invariant
    ):
        for count in spread_counts[::4]:
            if count > fogra39_quadric.triangles:
                break
            level = fogra39_quadric.level(count)
            assert_every_invariant(level, fogra39_quadric.centre, count)

    @pytest.mark.parametrize("reader", READERS, ids="-".join)
    @pytest.mark.slow
    def test_levels_from_files_keep_every_invariant(
        self, fogra39_gamut, mesh_readers, spread_counts, reader
    ):
        history = fogra39_gamut.history
        for count in spread_counts[::8]:
            level = history.level(count)
            read = mesh_readers[reader](mesh_file(level, reader[0]))
            # equal bit for bit, so every invariant of the test above holds as well
            assert read == level

    def test_levels_keep_the_volume(self, fogra39_gamut, spread_counts):
        volume = fogra39_gamut.description["volume"]
        for count in spread_counts:
            assert fogra39_gamut.history.level(count).volume == pytest.approx(volume, rel=1e-5)


class TestCounts:
    def test_an_odd_count_gives_the_level_below(self, small_history):
        for count in range(4, small_history.triangles, 2):
            assert small_history.level(count + 1) == small_history.level(count)

    @pytest.mark.parametrize("count", [3, 2, 0, -4])
    def test_fewer_than_four_triangles_are_refused(self, small_history, count):
        with pytest.raises(TriangleCountError) as caught:
            small_history.level(count)
        assert caught.value.where == {"field": "triangles"}
        assert str(small_history.triangles) in caught.value.remedy

    def test_more_triangles_than_the_full_boundary_are_refused(self, small_history):
        for count in (small_history.triangles + 1, 10**9, 2**70):
            with pytest.raises(TriangleCountError, match=str(count)):
                small_history.level(count)
            with pytest.raises(TriangleCountError):
                small_history.cursor(count)

    def test_coarsest_level_and_full_boundary(self, small_history):
        assert small_history.level(4).triangles == MINIMUM_TRIANGLES == 4
        full = small_history.full()
        assert full.triangles == small_history.triangles == 2 * small_history.vertices - 4
        assert full == small_history.level(small_history.triangles)


class TestArrays:
    def test_arrays_belong_to_the_level(self, small_history):
        for count in (4, 12, 100, small_history.triangles):
            level, expected = small_history.level(count), small_history.level(count)
            level.vertices[:] = np.nan
            level.faces[:] = -1
            assert small_history.level(count) == expected
        assert small_history.full().validity(small_history.centre).is_gamut

    def test_vertex_i_of_a_level_is_slot_i(self, small_history):
        """A split moves one vertex and adds one. All others keep their position and number."""
        levels = list(small_history.levels())
        for slot, (coarse, fine) in enumerate(itertools.pairwise(levels), start=4):
            parent = int(small_history.splits.parent[slot - 4])
            differs = (coarse.vertices != fine.vertices[:slot]).any(axis=1)
            assert set(np.flatnonzero(differs).tolist()) <= {parent}
            changed = (coarse.faces != fine.faces[: coarse.triangles]).any(axis=1)
            # a face keeps its corners, or one corner passes from the parent to the new slot
            assert (fine.faces[: coarse.triangles][changed] == slot).sum() == changed.sum()
            assert slot in fine.faces[-1]
            assert slot in fine.faces[-2]

    @pytest.mark.slow
    def test_reruns_are_bit_identical(self, fogra39_boundary, fogra39_quadric):
        boundary = fogra39_boundary
        again = build_history(decimate(boundary.mesh, boundary.centre, "quadric"))
        for one, other in zip(again.splits, fogra39_quadric.splits, strict=True):
            assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("cost", COSTS)
def test_levels_are_the_collapses_played_forward(random_cloud, cost):
    """Collapse the full boundary by renaming vertices in plain lists, without slots."""
    boundary = modified_convex_hull(random_cloud(40, 80))
    decimation = decimate(boundary.mesh, boundary.centre, cost)
    history = build_history(decimation)
    positions, faces = boundary.mesh.vertices.copy(), boundary.mesh.faces.tolist()

    def triangles(positions, faces):
        corners = positions[np.asarray(faces)].tolist()
        return sorted(min(c[i:] + c[:i] for i in range(3)) for c in corners)

    record = decimation.record
    for step in range(len(record.kept) + 1):
        level = history.level(len(faces))
        assert triangles(level.vertices, level.faces) == triangles(positions, faces)
        if step < len(record.kept):
            kept, dead = int(record.kept[step]), int(record.dead[step])
            faces = [[kept if v == dead else v for v in f] for f in faces]
            faces = [face for face in faces if len(set(face)) == 3]
            positions[kept] = record.position[step, 2]
            shifts = slice(record.shifted_end[step - 1] if step else 0, record.shifted_end[step])
            positions[record.shifted[shifts]] = record.shift[shifts, 1]


@pytest.mark.slow
def test_vertices_of_large_boundaries_move_in_coarse_levels_only(fogra39_finest):
    """At most 1500 vertices."""
    ends = fogra39_finest.splits.shifted_end
    assert fogra39_finest.vertices > 20_000
    assert ends[1200 - 4] < ends[1500 - 4] == ends[-1]


class TestWorkFollowsTheLevel:
    @pytest.mark.parametrize("vertices", [4, 5, 8, 9, 16, 40, 64, 65, 97])
    def test_nothing_beyond_twice_its_vertices_is_read(self, small_history, vertices):
        """Data that a level must not read are replaced by values that would show in the level."""
        count = 2 * vertices - 4
        expected = small_history.level(count)
        splits = small_history.splits
        history = History(splits, small_history.centre, small_history.step)
        parent, coarse = splits.parent.copy(), splits.coarse.copy()
        parent[2 * vertices - 4 :], coarse[2 * vertices - 4 :] = 0, np.nan
        others = {name: np.zeros_like(getattr(splits, name)) for name in UNUSED_BY_LEVELS}
        history._splits = splits._replace(parent=parent, coarse=coarse, **others)
        used = next(each for each in history._snapshots if len(each.vertices) >= vertices)
        assert len(used.vertices) < 2 * vertices
        nothing = TriangleMesh(np.full((4, 3), np.nan), np.zeros((4, 3), np.int32))
        history._snapshots = [each if each is used else nothing for each in history._snapshots]
        assert history.level(count) == expected

    def test_memory_is_less_than_four_times_the_full_mesh_and_its_splits(self, fogra39_gamut):
        history = fogra39_gamut.history
        full = history.full()
        mesh = full.vertices.nbytes + full.faces.nbytes
        splits = sum(array.nbytes for array in history.splits)
        geometry = History(history.splits, history.centre, history.step)
        assert splits + mesh < geometry.nbytes < splits + 3 * mesh
        # device values: three per split, and snapshots below three times the full mesh
        values = history.device_values(history.triangles).values.astype(np.int16).nbytes
        edges = 9 * history.vertices
        assert 3 * values < history.nbytes - geometry.nbytes < 6 * values + edges


def test_a_history_of_a_tetrahedron_has_one_level(assert_every_invariant):
    boundary = modified_convex_hull(np.vstack([np.zeros(3), np.eye(3)]))
    history = build_history(decimate(boundary.mesh, boundary.centre))
    (level,) = history.levels()
    assert_every_invariant(level, history.centre, 4)
    assert history.level(4) == history.full() == level
    with pytest.raises(TriangleCountError):
        history.level(5)
