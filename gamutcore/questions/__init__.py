"""Questions to a gamut: each is declared once, beside the function that answers it.

A function takes a gamut, finds the level that answers, converts the colours, asks
`gamutcore.search`, and interpolates device values. The methods of `gamutcore.Gamut` call these
functions. `QUESTIONS` has the declarations, from which the service makes its routes and forms.
"""

from collections.abc import Mapping

from gamutcore.questions.black_rules import black_rule
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
from gamutcore.questions.declarations import SPACE, Answer, Parameter, Question
from gamutcore.questions.levels import (
    DEFAULT_EDGE_WIDTH,
    DEFAULT_ERROR,
    INDEX_BYTES,
    IndexedLevels,
    check_space,
    colours_in,
    is_as_measured,
    tolerance_of,
)
from gamutcore.questions.mapping import (
    COMPENSATION,
    MAP,
    METHOD,
    PICTURE_PARAMETERS,
    SPATIAL,
    black_luminance,
    compensates_black,
    map_colours,
    map_picture_file,
    map_points,
)
from gamutcore.questions.picture_mapping import (
    PICTURE_SPACE,
    MappedPicture,
    TableError,
    no_picture,
)
from gamutcore.questions.picture_targets import DECODE
from gamutcore.questions.picture_targets import DEVICE as DEVICE_VALUES
from gamutcore.questions.plotting import (
    MOST_DRAWN_TRIANGLES,
    PICTURE,
    PNG_KEYWORD,
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
    draw_rings,
    draw_section,
    leaf,
    leaves,
    max_chroma,
    rings,
    section,
)

__all__ = [
    "COMPARISON",
    "COMPENSATION",
    "DECODE",
    "DEFAULT_EDGE_WIDTH",
    "DEFAULT_ERROR",
    "DEVICE_VALUES",
    "INDEX_BYTES",
    "MAP",
    "METHOD",
    "MOST_DRAWN_TRIANGLES",
    "PICTURE",
    "PICTURE_PARAMETERS",
    "PICTURE_SPACE",
    "PNG_KEYWORD",
    "QUESTIONS",
    "RECIPES",
    "RINGS",
    "SECTORS",
    "SPACE",
    "SPATIAL",
    "Answer",
    "IndexedLevels",
    "MappedPicture",
    "Parameter",
    "Question",
    "TableError",
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
    "draw_section",
    "figure",
    "is_as_measured",
    "leaf",
    "leaves",
    "map_colours",
    "map_picture_file",
    "map_points",
    "max_chroma",
    "nearest",
    "no_limit_warnings",
    "no_picture",
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
