"""Questions to a gamut: each is declared once, beside the function that answers it.

A function takes a gamut, finds the level that answers, converts the colours, asks
`gamutcore.search`, and interpolates device values. The methods of `gamutcore.Gamut` call these
functions. `QUESTIONS` has the declarations, from which the service makes its routes and forms.
"""

from collections.abc import Mapping

from gamutcore.questions.black_rules import BLACK, DEFAULT_BLACK, black_rule
from gamutcore.questions.comparison import (
    COMPARISON,
    SECTORS,
    chromaticity,
    compare,
    compared_conditions,
)
from gamutcore.questions.conditions import (
    build_warnings,
    comparison_warnings,
    conditions_of,
    no_limit_warnings,
)
from gamutcore.questions.declarations import LEVEL_PARAMETERS, SPACE, Answer, Parameter, Question
from gamutcore.questions.levels import (
    DEFAULT_EDGE_WIDTH,
    DEFAULT_ERROR,
    INDEX_BYTES,
    GamutLike,
    IndexedLevels,
    check_space,
    colours_in,
    is_as_measured,
    lab_of,
    tolerance_of,
)
from gamutcore.questions.mapping import (
    COMPENSATION,
    MAP,
    MAPPING_ALIASES,
    MAPPING_METHODS,
    METHOD,
    PICTURE_SPACE,
    ROUNDING,
    SPATIAL,
    MappingRule,
    black_luminance,
    compensates_black,
    lab_conversion,
    map_colours,
    map_points,
    mapping_rule,
    mapping_warnings,
)
from gamutcore.questions.plotting import (
    MOST_DRAWN_TRIANGLES,
    PICTURE,
    PNG_KEYWORD,
    draw_rings,
    figure,
    notebook_html,
    picture,
    plot,
    plot_rings,
    plot_slice,
)
from gamutcore.questions.points import (
    CONTAINS,
    CROSSINGS,
    NEAREST,
    crossings,
    distance,
    nearest,
    positions,
)
from gamutcore.questions.recipes import COLOURS, RECIPES, device_colours, recipes
from gamutcore.questions.shape import (
    CUSPS,
    LEAVES,
    RINGS,
    SLICE,
    cusps,
    leaf,
    leaves,
    max_chroma,
    rings,
    section,
)

__all__ = [
    "BLACK",
    "COMPARISON",
    "COMPENSATION",
    "DEFAULT_BLACK",
    "DEFAULT_EDGE_WIDTH",
    "DEFAULT_ERROR",
    "INDEX_BYTES",
    "LEVEL_PARAMETERS",
    "MAP",
    "MAPPING_ALIASES",
    "MAPPING_METHODS",
    "METHOD",
    "MOST_DRAWN_TRIANGLES",
    "PICTURE",
    "PICTURE_SPACE",
    "PNG_KEYWORD",
    "QUESTIONS",
    "RECIPES",
    "RINGS",
    "ROUNDING",
    "SECTORS",
    "SPACE",
    "SPATIAL",
    "Answer",
    "GamutLike",
    "IndexedLevels",
    "MappingRule",
    "Parameter",
    "Question",
    "black_luminance",
    "black_rule",
    "build_warnings",
    "check_space",
    "chromaticity",
    "colours_in",
    "compare",
    "compared_conditions",
    "comparison_warnings",
    "compensates_black",
    "conditions_of",
    "crossings",
    "cusps",
    "device_colours",
    "distance",
    "draw_rings",
    "figure",
    "is_as_measured",
    "lab_conversion",
    "lab_of",
    "leaf",
    "leaves",
    "map_colours",
    "map_points",
    "mapping_rule",
    "mapping_warnings",
    "max_chroma",
    "nearest",
    "no_limit_warnings",
    "notebook_html",
    "picture",
    "plot",
    "plot_rings",
    "plot_slice",
    "positions",
    "recipes",
    "rings",
    "section",
    "tolerance_of",
]

QUESTIONS: Mapping[str, Question] = {
    each.name: each
    for each in (
        *(CONTAINS, NEAREST, MAP, CROSSINGS, RECIPES, COLOURS),
        *(CUSPS, LEAVES, SLICE, RINGS),
        *(COMPARISON, PICTURE),
    )
}
"""The declarations of all questions by name."""
