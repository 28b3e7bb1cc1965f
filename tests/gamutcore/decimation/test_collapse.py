"""All collapses of a boundary: their order, the volume deficit, and the record."""

import numpy as np
import pytest

from gamutcore.decimation.costs import COSTS, cost_named
from gamutcore.decimation.stage import Grid
from gamutcore.decimation.stages import run_stage
from gamutcore.decimation.star import DEFICIT_NOW, keeps_star_shape
from gamutcore.grid import grid_step, nearest_grid_points


@pytest.fixture(scope="module")
def run(bumpy_mesh, stage_of):
    """Return a function that makes all collapses of a bumpy surface with a cost."""

    def make(cost, seed, count=80):
        rough, faces = bumpy_mesh(seed, count)
        step = grid_step(rough)
        positions = nearest_grid_points(rough, step)
        grid = Grid(positions.astype(np.float32), np.zeros(3), step)
        stage = stage_of(cost_named(cost).parameters, positions, faces, grid)
        counter = np.zeros(1, np.int64)
        record = run_stage(stage, 4, counter).record
        collapses = len(record.kept)
        assert counter[0] == collapses
        return positions, faces, stage.surface, grid.position, collapses, record

    return make


@pytest.mark.parametrize("cost", COSTS)
@pytest.mark.parametrize("seed", range(3))
def test_four_faces_are_left(run, faces_left, cost, seed):
    positions, _, surface, delivered, collapses, record = run(cost, seed)
    assert collapses == len(positions) - 4 == len(record.dead)
    _, faces = faces_left(surface)
    assert len(faces) == len(np.unique(faces)) == 4
    assert np.linalg.det(surface.position[faces]).min() > 0
    vertices = np.unique(faces)
    np.testing.assert_array_equal(surface.position[vertices], delivered[vertices])
    assert set(record.dead.tolist()) == set(range(len(positions))) - set(vertices.tolist())


@pytest.mark.parametrize("cost", COSTS)
def test_the_record_has_no_unused_entries(run, cost):
    *_, record = run(cost, 1)
    assert len(record.moved) == record.moved_end[-1]
    assert len(record.shifted) == len(record.shift) == record.shifted_end[-1]
    assert (np.diff(record.shifted_end) >= 0).all()
    assert (len(record.shifted) > 0) == (cost == "finest")


@pytest.mark.parametrize("seed", range(3))
def test_the_deficit_is_the_missing_volume(run, faces_left, seed):
    """To a few roundings of the deficit itself."""
    positions, faces, surface, *_ = run("volume", seed)
    before = np.linalg.det(positions[faces]).sum()
    _, left = faces_left(surface)
    missing = before - np.linalg.det(surface.position[left]).sum()
    assert surface.deficit[DEFICIT_NOW] == pytest.approx(missing, abs=1e-9 * before)
    assert abs(missing) <= 1e-5 * before


def planes_of(positions, faces):
    corners = positions[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
    return normals, -np.sum(normals * corners[:, 0], axis=1)


@pytest.mark.parametrize("seed", range(5))
def test_the_cheapest_edge_goes_first(run, ends_of, surface_from, seed):
    """By the formula of Garland and Heckbert, with explicit sums over planes."""
    positions, faces, _, _, _, record = run("quadric", seed)
    surface = surface_from(positions, faces)
    normals, offsets = planes_of(positions, faces)
    errors, edges = [], []
    for corner in surface.corner_facing.tolist():
        one, two = ends_of(surface, corner)
        rows = np.concatenate([np.flatnonzero((faces == end).any(axis=1)) for end in (one, two)])
        best, *_ = np.linalg.lstsq(normals[rows], -offsets[rows])
        common = [
            set(faces[(faces == end).any(axis=1)].ravel().tolist()) - {one, two}
            for end in (one, two)
        ]
        ring = [
            pair
            for end in (one, two)
            for face in faces[(faces == end).any(axis=1)].tolist()
            for pair in [[v for v in np.roll(face, -face.index(end)).tolist() if v != end]]
            if not set(pair) & {one, two}
        ]
        if len(common[0] & common[1]) == 2 and keeps_star_shape(
            positions, np.array(ring, np.int32), len(ring), *best
        ):
            errors.append(((normals[rows] @ best + offsets[rows]) ** 2).sum())
            edges.append({one, two})
    first = edges.index({int(record.kept[0]), int(record.dead[0])})
    # up to the pull towards the midpoint: 1e-5 of the trace times the squared distance
    length = max(np.linalg.norm(positions[one] - positions[two]) for one, two in edges)
    assert errors[first] <= min(errors) + 1e-5 * 20 * length**2
    assert errors[first] <= np.quantile(errors, 0.05)
