"""The errors of `gamutcore` as rows of the table of problems: what each means to a client.

The rest of the table, and what is made of it, is in `service.problems.problem`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from gamutcore import errors

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["CORE_KINDS", "Kind"]


@dataclass(frozen=True)
class Kind:
    """A row of the table: what all problems of one code have in common.

    Attributes
    ----------
    code : str
        Stable, part of the public interface.
    status : int
        HTTP status code.
    title : str
        What is wrong, the same for all problems of the kind.
    remedy : str
        What would be right, where the single problem does not know it better.
    detail, where
        An example of a single problem, for the documentation.
    """

    code: str
    status: int
    title: str
    remedy: str
    detail: str
    where: Mapping[str, Any] = field(default_factory=dict)


def _core(
    error: type[errors.GamutError], title: str, remedy: str, detail: str, **where: str | int
) -> Kind:
    """Return the row of an error of `gamutcore`: the client's content cannot be processed."""
    return Kind(error.code, 422, title, remedy, detail, where)


_READ = (
    "CGATS and IT8 text, CxF3, CSV, JSON, NumPy arrays (.npy), ICC profiles and pictures (PNG, "
    "TIFF, JPEG) are read."
)

CORE_KINDS = (
    _core(
        errors.OptionError,
        "An option is not accepted",
        "Use an option and a value from the documentation of POST /v1/gamuts.",
        "gamma is 1.5, which is not accepted.",
        field="gamma",
    ),
    _core(
        errors.UnrecognisedFormatError,
        "The file's format is not recognised",
        _READ,
        "The content is of none of the formats that are read.",
    ),
    _core(
        errors.MalformedFileError,
        "The file breaks its format",
        "Correct the place that is named.",
        "BEGIN_DATA is not followed by END_DATA.",
        line=18,
    ),
    _core(
        errors.MissingColumnError,
        "The columns do not hold a colour",
        "Name columns LAB_L, LAB_A, LAB_B or XYZ_X, XYZ_Y, XYZ_Z, or the bands of a spectrum.",
        "There is no column LAB_B.",
        field="LAB_B",
    ),
    _core(
        errors.ConditionError,
        "Several measurement conditions, or another one",
        "Choose one of them by the option `condition`.",
        "The data was measured under several conditions: M0, M1, M2.",
        field="condition",
    ),
    _core(
        errors.SampleLimitError,
        "Too many samples, columns or channels",
        "Send fewer, for instance only those on the surface of the gamut.",
        "The file has more samples than are accepted.",
    ),
    _core(
        errors.MalformedProfileError,
        "The ICC profile is malformed",
        "Send a profile that keeps to ICC.1 (ISO 15076-1).",
        "The tag A2B1 ends outside the profile.",
        tag="A2B1",
    ),
    _core(
        errors.UnsupportedProfileError,
        "The ICC profile is of an unsupported kind",
        "Send an input, display, output or colour space profile with a device to PCS side.",
        "Profiles of the class named colour have no gamut.",
    ),
    _core(
        errors.PictureSizeError,
        "The picture is too large",
        "Send a smaller copy of the picture.",
        "The picture has 60000 × 60000 pixels, 10800 MB unpacked.",
        field="size",
    ),
    _core(
        errors.UnsupportedPictureError,
        "The picture is of an unsupported kind",
        "Send PNG, baseline or progressive JPEG, or TIFF without compression, with LZW, deflate, "
        "PackBits or JPEG; CMYK with its profile embedded.",
        "The picture is CMYK and has no embedded profile, so its colours are not known.",
        field="profile",
    ),
    _core(
        errors.CharacterisationError,
        "The characterisation data cannot be used",
        _READ,
        "The characterisation data cannot be used.",
    ),
    _core(
        errors.TooFewPointsError,
        "Too few distinct colours",
        "Send at least four colours that are not in one plane.",
        "There are 3 distinct colours.",
    ),
    _core(
        errors.FlatPointsError,
        "The colours lie in one plane",
        "Send colours that span a volume.",
        "All colours lie in one plane.",
    ),
    _core(
        errors.CentreError,
        "The centre is not inside the gamut",
        "Give a centre that is surrounded by the colours, or leave it out.",
        "The centre (50, 200, 0) is outside the convex hull of the colours.",
        field="centre",
    ),
    _core(
        errors.InvalidPointsError,
        "The colours cannot be used",
        "Send three finite numbers for every colour.",
        "Row 7 holds a value that is not a finite number.",
        row=7,
    ),
    _core(
        errors.TriangleCountError,
        "The gamut has no level of this triangle count",
        "Ask for a count from 4 up to the gamut's largest, which its description tells.",
        "3 triangles were asked for; a closed surface has at least 4.",
        field="triangles",
    ),
    _core(
        errors.BoundaryError,
        "No closed surface could be wrapped around the colours",
        "Try a larger gamma, other segments, or another centre.",
        "No surface that is star-shaped about the centre was found.",
    ),
    _core(
        errors.MeshError,
        "The surface is not closed, oriented and star-shaped",
        "Try a larger gamma, or another centre.",
        "An edge belongs to three triangles.",
    ),
    _core(
        errors.DecimationError,
        "The surface could not be decimated to four triangles",
        "Try a larger gamma, or another centre.",
        "No edge can be collapsed although 12 triangles are left.",
    ),
    _core(
        errors.NeighbourLimitError,
        "Vertices have too many neighbours",
        "Divide the surface so that fewer triangles meet at a vertex.",
        "Up to 131072 triangles meet at a vertex, and levels would take too long to read.",
        neighbours=131072,
    ),
    _core(
        errors.HistoryFileError,
        "A history file is damaged",
        "Post the characterisation data again.",
        "The history file is damaged.",
    ),
    _core(
        errors.GamutError,
        "The gamut cannot be built",
        "Compare the request with the documentation.",
        "The gamut cannot be built.",
    ),
)
"""What gamutcore finds wrong with options and characterisation data."""
