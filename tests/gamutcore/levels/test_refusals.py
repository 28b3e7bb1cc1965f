"""What comparisons of levels refuse: meshes that are no body, and edges of voxels."""

import numpy as np
import pytest
import trimesh

from gamutcore.boundary import voxel_mismatch
from gamutcore.errors import MeshError, OptionError
from gamutcore.geometry import TriangleMesh
from gamutcore.levels import radial_difference

SPHERE = trimesh.creation.icosphere(1)
CORNERS, FACES = np.asarray(SPHERE.vertices), np.asarray(SPHERE.faces)
FLIPPED = np.vstack([FACES[:1, ::-1], FACES[1:]])
MOVED = {value: np.vstack([[(value, 0, 0)], CORNERS[1:]]) for value in (np.nan, np.inf)}

BAD = {
    "open": (CORNERS, FACES[1:]),
    "a turned face": (CORNERS, FLIPPED),
    "nothing": (np.empty((0, 3)), np.empty((0, 3), int)),
    "not a number": (MOVED[np.nan], FACES),
    "infinite": (MOVED[np.inf], FACES),
    "a point": (np.ones((42, 3)), FACES),
}


def radial(one, other):
    return radial_difference(one, other, np.zeros(3))


@pytest.mark.parametrize("metric", [voxel_mismatch, radial])
@pytest.mark.parametrize("bad", BAD)
def test_what_is_no_body_is_refused_on_either_side(metric, bad):
    body = TriangleMesh(CORNERS, FACES)
    wrong = TriangleMesh(*BAD[bad])
    for pair in ((wrong, body), (body, wrong)):
        if pair == (body, wrong) and bad == "a point" and metric is not radial:
            continue  # a body without a volume differs from the reference by all of it
        with pytest.raises((MeshError, OptionError)) as caught:
            metric(*pair)
        assert caught.value.remedy


def test_a_centre_that_does_not_see_all_faces_is_refused(icosphere):
    with pytest.raises(MeshError, match="do not see the centre") as caught:
        radial_difference(icosphere(1), icosphere(2), (150.0, 0.0, 0.0))
    assert caught.value.remedy


def test_vertices_that_are_not_used_are_refused(icosphere):
    more = TriangleMesh(np.vstack([CORNERS, [(0, 0, 0)]]), FACES)
    with pytest.raises(MeshError):
        radial_difference(icosphere(1), more, np.zeros(3))


def test_a_reference_without_a_voxel_is_refused(icosphere):
    with pytest.raises(MeshError) as caught:
        voxel_mismatch(icosphere(1, 0.1), icosphere(1), 0.5)
    assert "smaller" in caught.value.remedy


@pytest.mark.parametrize("edge", [0, -1.0, np.nan, np.inf, 1e-5, 1e-300])
def test_an_edge_that_gives_no_or_too_many_voxels_is_refused(icosphere, edge):
    with pytest.raises(OptionError) as caught:
        voxel_mismatch(icosphere(1), icosphere(2), edge)
    assert caught.value.where == {"field": "edge"}
    assert "2048" in caught.value.remedy
