"""Geometry of triangles and star-shaped meshes: vectors, meshes, the grid and the star test.

Other folders import from here, and this folder imports none of them.
"""

from gamutcore.geometry.corner_table import (
    following,
    opposite_corners,
    preceding,
    swing,
    vertex_fans,
)
from gamutcore.geometry.grid import grid_step, mesh_grid_step, nearest_grid_points
from gamutcore.geometry.mesh import (
    DeviceValues,
    TriangleMesh,
    Validity,
    connected_components,
    imported_trimesh,
)
from gamutcore.geometry.star_shape import MINIMUM_DETERMINANT, faces_not_seeing_centre, sees_centre
from gamutcore.geometry.vectors import (
    Symmetric,
    Vector,
    add_outer,
    adjugate,
    cross,
    dot,
    linear_combination,
    minus,
    plus,
    product,
    quadratic_form,
    row,
    scaled,
    symmetric_row,
    triple,
    write_row,
    write_symmetric_row,
)

__all__ = [
    "MINIMUM_DETERMINANT",
    "DeviceValues",
    "Symmetric",
    "TriangleMesh",
    "Validity",
    "Vector",
    "add_outer",
    "adjugate",
    "connected_components",
    "cross",
    "dot",
    "faces_not_seeing_centre",
    "following",
    "grid_step",
    "imported_trimesh",
    "linear_combination",
    "mesh_grid_step",
    "minus",
    "nearest_grid_points",
    "opposite_corners",
    "plus",
    "preceding",
    "product",
    "quadratic_form",
    "row",
    "scaled",
    "sees_centre",
    "swing",
    "symmetric_row",
    "triple",
    "vertex_fans",
    "write_row",
    "write_symmetric_row",
]
