"""Geometry of a level: containment, nearest points, crossings, sections, mapping, comparison.

Every function takes a level as its vertices, faces and centre, or as an index that `build_index`
has computed once. Without an index, the errors of `build_index` are raised as well. What users ask,
with parameters and columns, is declared in `gamutcore.questions`.
"""

from gamutcore.search.chromaticity import (
    CHROMATICITY_STANDARDS,
    chromaticity_description,
    chromaticity_gamut,
)
from gamutcore.search.ciede2000 import delta_e_2000
from gamutcore.search.comparison import (
    MOST_SECTORS,
    RING_LIGHTNESSES,
    compare,
    gamut_rings,
)
from gamutcore.search.containment import contains, signed_distance
from gamutcore.search.crossings import Crossings, crossings
from gamutcore.search.index import (
    LARGEST_COORDINATE,
    Level,
    LevelIndex,
    as_index,
    build_index,
    checked_points,
)
from gamutcore.search.mapping import Mapped, MappingMethod, map_colours
from gamutcore.search.nearest import SurfacePoints, nearest
from gamutcore.search.nearest_ciede2000 import nearest_ciede2000
from gamutcore.search.sections import (
    Cusps,
    Leaves,
    Section,
    cusp_points,
    hue_leaf,
    leaves,
    slice_polygons,
)
from gamutcore.search.spatial_mapping import Lines, find_lines, neutral_ends, relax_shifts

__all__ = [
    "CHROMATICITY_STANDARDS",
    "LARGEST_COORDINATE",
    "MOST_SECTORS",
    "RING_LIGHTNESSES",
    "Crossings",
    "Cusps",
    "Leaves",
    "Level",
    "LevelIndex",
    "Lines",
    "Mapped",
    "MappingMethod",
    "Section",
    "SurfacePoints",
    "as_index",
    "build_index",
    "checked_points",
    "chromaticity_description",
    "chromaticity_gamut",
    "compare",
    "contains",
    "crossings",
    "cusp_points",
    "delta_e_2000",
    "find_lines",
    "gamut_rings",
    "hue_leaf",
    "leaves",
    "map_colours",
    "nearest",
    "nearest_ciede2000",
    "neutral_ends",
    "relax_shifts",
    "signed_distance",
    "slice_polygons",
]
