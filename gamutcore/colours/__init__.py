"""From characterisation data to colours: colorimetry, spaces, device models, surface samples.

`surface_colours` is the entry point, and `colours_in_space` gives its result in a `ColourSpace`. A
device's *cube* is the set of all its device values, 0 to 1 in each channel. Ink limits cut it. The
colours at the surface of the cut cube are those that a boundary is wrapped around.
"""

from gamutcore.colours.colorimetry import (
    ICC_D50,
    adaptation_matrix,
    compensate_black,
    decode_srgb,
    encode_srgb,
    lab_to_xyz,
    luminance_of_black,
    white_point,
    xyz_to_lab,
)
from gamutcore.colours.device_model import DEVICE_MODELS, check_dimensions
from gamutcore.colours.folds import fold_sheets
from gamutcore.colours.gamut_colours import (
    INTENTS,
    colours_in_space,
    display_primaries,
    medium_white_lab,
    own_tristimulus,
    surface_colours,
    volume_description,
)
from gamutcore.colours.ink_limits import (
    BLACK_NAMES,
    InkLimits,
    lacks_black,
    spread_values,
    values_beside,
)
from gamutcore.colours.lookup import LookupTable, cube_nodes
from gamutcore.colours.measured import ILLUMINANTS, OBSERVERS, measured_colours
from gamutcore.colours.models import DeviceModel, naming_remedy
from gamutcore.colours.picture import (
    closed_form_values,
    find_values,
    picture_colours,
    profile_warnings,
)
from gamutcore.colours.reference import RGB_CURVES, RgbSpace, primary_matrix, reference_white
from gamutcore.colours.repeats import consistent_samples, device_groups
from gamutcore.colours.sampling import (
    SURFACE_SAMPLES,
    AbsoluteColours,
    DeviceColours,
    SurfaceColours,
    SurfaceFaces,
)
from gamutcore.colours.spaces import (
    CIELAB,
    DEFAULT_LUMINANCE,
    GIVEN_SPACE,
    MEASURED,
    OTHER_AXES,
    SPACE,
    SPACE_PARAMETERS,
    SPACES,
    ColourConversion,
    ColourSpace,
    check_mesh_space,
    declared_space,
    linear_srgb,
    measured_luminance,
    parameter_defaults,
    space_parameters,
    srgb,
)

__all__ = [
    "BLACK_NAMES",
    "CIELAB",
    "DEFAULT_LUMINANCE",
    "DEVICE_MODELS",
    "GIVEN_SPACE",
    "ICC_D50",
    "ILLUMINANTS",
    "INTENTS",
    "MEASURED",
    "OBSERVERS",
    "OTHER_AXES",
    "RGB_CURVES",
    "SPACE",
    "SPACES",
    "SPACE_PARAMETERS",
    "SURFACE_SAMPLES",
    "AbsoluteColours",
    "ColourConversion",
    "ColourSpace",
    "DeviceColours",
    "DeviceModel",
    "InkLimits",
    "LookupTable",
    "RgbSpace",
    "SurfaceColours",
    "SurfaceFaces",
    "adaptation_matrix",
    "check_dimensions",
    "check_mesh_space",
    "closed_form_values",
    "colours_in_space",
    "compensate_black",
    "consistent_samples",
    "cube_nodes",
    "declared_space",
    "decode_srgb",
    "device_groups",
    "display_primaries",
    "encode_srgb",
    "find_values",
    "fold_sheets",
    "lab_to_xyz",
    "lacks_black",
    "linear_srgb",
    "luminance_of_black",
    "measured_colours",
    "measured_luminance",
    "medium_white_lab",
    "naming_remedy",
    "own_tristimulus",
    "parameter_defaults",
    "picture_colours",
    "primary_matrix",
    "profile_warnings",
    "reference_white",
    "space_parameters",
    "spread_values",
    "srgb",
    "surface_colours",
    "values_beside",
    "volume_description",
    "white_point",
    "xyz_to_lab",
]
