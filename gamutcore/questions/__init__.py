"""Questions to a gamut: each is declared once, beside the function that answers it.

A function takes a gamut, finds the level that answers, converts the colours, asks
`gamutcore.search`, and interpolates device values. Methods of `gamutcore.Gamut` are these
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
    colour_warnings,
    comparison_warnings,
    condition_lines,
    conditions_of,
    no_limit_warnings,
    table_warnings,
)
from gamutcore.questions.declarations import LEVEL_PARAMETERS, SPACE, Answer, Parameter, Question
from gamutcore.questions.intervals import UNCERTAINTY, compare_with_interval, uncertainty
from gamutcore.questions.levels import (
    DEFAULT_EDGE_WIDTH,
    DEFAULT_ERROR,
    INDEX_BYTES,
    GamutLike,
    IndexedLevels,
    OtherGamut,
    check_space,
    colours_in,
    is_as_measured,
    lab_of,
    other_gamut,
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
    plot_text,
)
from gamutcore.questions.points import (
    CONTAINS,
    CROSSINGS,
    NEAREST,
    classify,
    contains,
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
    "UNCERTAINTY",
    "Answer",
    "GamutLike",
    "IndexedLevels",
    "MappingRule",
    "OtherGamut",
    "Parameter",
    "Question",
    "black_luminance",
    "black_rule",
    "build_warnings",
    "check_space",
    "chromaticity",
    "classify",
    "colour_warnings",
    "colours_in",
    "compare",
    "compare_with_interval",
    "compared_conditions",
    "comparison_warnings",
    "compensates_black",
    "condition_lines",
    "conditions_of",
    "contains",
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
    "other_gamut",
    "picture",
    "plot",
    "plot_rings",
    "plot_slice",
    "plot_text",
    "positions",
    "recipes",
    "rings",
    "section",
    "table_warnings",
    "tolerance_of",
    "uncertainty",
]

QUESTIONS: Mapping[str, Question] = {
    question.name: question
    for question in (
        *(CONTAINS, NEAREST, MAP, CROSSINGS, RECIPES, COLOURS),
        *(CUSPS, LEAVES, SLICE, RINGS, UNCERTAINTY),
        *(COMPARISON, PICTURE),
    )
}
"""The declarations of all questions by name."""
