"""Queries: what a level answers about colours.

Every query takes a level as its vertices, faces and centre, or as an index that `build_index` has
computed once.
"""

from gamutcore.queries.chromaticity import (
    AreaOverlap,
    ChromaticityComparison,
    ChromaticityGamut,
    chromaticity_gamut,
)
from gamutcore.queries.colour_difference import delta_e_2000
from gamutcore.queries.comparison import Comparison, Overlap, compare
from gamutcore.queries.crossings import Crossings, crossings
from gamutcore.queries.cusps import Cusps, cusp_points
from gamutcore.queries.index import Level, LevelIndex, as_index, build_index
from gamutcore.queries.leaves import Leaves, leaves
from gamutcore.queries.mapping import Mapped, map_colours
from gamutcore.queries.nearest import SurfacePoints, contains, nearest, signed_distance
from gamutcore.queries.nearest_ciede2000 import nearest_ciede2000
from gamutcore.queries.rings import Rings, gamut_rings
from gamutcore.queries.sections import Section, hue_leaf, slice_polygons

__all__ = [
    "AreaOverlap",
    "ChromaticityComparison",
    "ChromaticityGamut",
    "Comparison",
    "Crossings",
    "Cusps",
    "Leaves",
    "Level",
    "LevelIndex",
    "Mapped",
    "Overlap",
    "Rings",
    "Section",
    "SurfacePoints",
    "as_index",
    "build_index",
    "chromaticity_gamut",
    "compare",
    "contains",
    "crossings",
    "cusp_points",
    "delta_e_2000",
    "gamut_rings",
    "hue_leaf",
    "leaves",
    "map_colours",
    "nearest",
    "nearest_ciede2000",
    "signed_distance",
    "slice_polygons",
]
