"""Kinds of problems with the content of a request: the errors of `gamutcore`.

A part of the table in `service.problems.kinds`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from gamutcore import errors
from gamutcore.characterisation.recognition import format_summary

__all__ = ["CONTENT_KINDS", "Kind"]


@dataclass(frozen=True)
class Kind:
    """A row of the table: the common part of all problems with one code, which is public.

    A single problem may have a more specific remedy. `detail` and `where` are an example, for the
    documentation.
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


_READ = f"Send {format_summary()}."

CONTENT_KINDS = (
    _core(
        errors.OptionError,
        "An option is not valid",
        "Use an option and a value from the documentation of POST /v1/gamuts.",
        "gamma is 1.5, which is not accepted.",
        field="gamma",
    ),
    _core(
        errors.UnrecognisedFormatError,
        "The file's format is not recognised",
        _READ,
        "The content has none of the supported formats.",
    ),
    _core(
        errors.MalformedFileError,
        "The file is malformed",
        "Correct the file at the given place.",
        "BEGIN_DATA is not followed by END_DATA.",
        line=18,
    ),
    _core(
        errors.MissingColumnError,
        "There are no columns with a colour",
        "Name columns LAB_L, LAB_A, LAB_B or XYZ_X, XYZ_Y, XYZ_Z, or the bands of a spectrum.",
        "There is no column LAB_B.",
        field="LAB_B",
    ),
    _core(
        errors.ConditionError,
        "The measurement condition is ambiguous or missing",
        "Select one with the option `condition`.",
        "The data has several measurement conditions: M0, M1, M2.",
        field="condition",
    ),
    _core(
        errors.SampleLimitError,
        "Too many samples, columns or channels",
        "Send fewer, for example only samples on the surface of the gamut.",
        "The file has more samples than the limit.",
    ),
    _core(
        errors.MalformedProfileError,
        "The ICC profile is malformed",
        "Send a profile that conforms to ICC.1 (ISO 15076-1).",
        "The tag A2B1 ends outside the profile.",
        tag="A2B1",
    ),
    _core(
        errors.UnsupportedProfileError,
        "The ICC profile is not supported",
        "Send an input, display, output or colour space profile with a device-to-PCS transform.",
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
        errors.PictureWorkError,
        "Decoding the picture takes too long",
        "Save the picture again, as PNG, TIFF or baseline JPEG.",
        "The JPEG has 20000 scans.",
        field="scans",
    ),
    _core(
        errors.UnsupportedPictureError,
        "The picture is not supported",
        "Send gray, RGB, CMYK or CIELAB pixels of 8 or 16 bits, or floats; CMYK with its profile "
        "embedded.",
        "The picture is CMYK without an embedded profile, so its colours are unknown.",
        field="profile",
    ),
    _core(
        errors.ReferenceNameError,
        "There is no such reference gamut",
        "Give a slug from GET /v1/references.",
        "There is no reference gamut 'srbg'.",
        field="reference",
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
        "Send at least four colours that do not lie in one plane.",
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
        "Give a centre inside the colours, or omit the option.",
        "The centre (50, 200, 0) is outside the convex hull of the colours.",
        field="centre",
    ),
    _core(
        errors.InvalidPointsError,
        "The colours cannot be used",
        "Send three finite numbers for every colour.",
        "Row 7 contains a value that is not finite.",
        row=7,
    ),
    _core(
        errors.TriangleCountError,
        "The gamut has no level with this triangle count",
        "Request a count from 4 to the largest count in the gamut's description.",
        "3 triangles were requested; a closed surface has at least 4.",
        field="triangles",
    ),
    _core(
        errors.BoundaryError,
        "No closed surface around the colours was found",
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
