"""Recognition of characterisation data by content, never by file name.

Binary formats have signatures. Text is decoded once. JSON has a bracket first, the CGATS family has
a data section, and other text is a table if its first line has column names.
"""

from __future__ import annotations

from typing import TypeAlias

from gamutcore.characterisation.cgats import cgats_samples, looks_like_cgats
from gamutcore.characterisation.cxf import cxf_samples, looks_like_cxf, looks_like_xml
from gamutcore.characterisation.delimited import delimited_samples
from gamutcore.characterisation.formats import format_summary
from gamutcore.characterisation.icc import IccProfile, icc_profile, looks_like_icc
from gamutcore.characterisation.json_samples import json_samples
from gamutcore.characterisation.meshes import GamutMesh, binary_mesh, text_mesh
from gamutcore.characterisation.npy_samples import NPY_MAGIC, npy_samples
from gamutcore.characterisation.pictures import Picture, picture_format, read_picture
from gamutcore.characterisation.samples import Samples
from gamutcore.characterisation.text import DelimitedText, text_and_encoding
from gamutcore.errors import OptionError, UnrecognisedFormatError
from gamutcore.references import Reference, parse_definition

__all__ = ["Characterisation", "characterisation"]

Characterisation: TypeAlias = Samples | IccProfile | Picture | GamutMesh | Reference


def characterisation(  # noqa: PLR0911 (one return for each kind)
    data: bytes, *, condition: str | None = None
) -> Characterisation:
    """Return the characterisation data in the bytes of a file or message.

    Parameters
    ----------
    data : bytes
        A file in one of `gamutcore.characterisation.FORMATS`.
    condition : str, optional
        The measurement condition to read, such as ``"M1"``, if the data has several.

    Raises
    ------
    UnrecognisedFormatError
        The content has no known format.
    OptionError
        A condition is requested of a profile, a picture, a mesh or a reference gamut.
    CharacterisationError, InvalidPointsError, MeshError
        The format is known, but the content is malformed. ``where`` has the location.
    """
    picture = picture_format(data)
    if looks_like_icc(data) or picture is not None:
        if condition is not None:
            raise OptionError.not_applicable(
                "condition",
                condition,
                "profiles and pictures have no measurement condition",
            )
        return icc_profile(data) if picture is None else read_picture(data, picture)
    if data.startswith(NPY_MAGIC):
        return npy_samples(data, condition=condition)
    mesh = binary_mesh(data)
    if mesh is not None:
        return _without_condition(mesh, condition)
    if looks_like_xml(data):
        if not looks_like_cxf(data):
            raise _unrecognised("The content is XML or HTML, but not CxF3.")
        return cxf_samples(data, condition=condition)
    found = text_and_encoding(data)
    if found is None:
        raise _unrecognised("The content is binary, and its format is unknown.")
    text, encoding = found
    if not text.strip("\0 \t\r\n"):
        raise _unrecognised("The content is empty.")
    mesh = text_mesh(text)
    if mesh is not None:
        return _without_condition(mesh, condition)
    start = text[:1000].lstrip()
    if start.startswith(("{", "[")):
        reference = parse_definition(text)
        if reference is not None:
            return _without_condition(reference, condition)
        return json_samples(text, condition=condition)
    if looks_like_cgats(text):
        return cgats_samples(text, condition=condition)
    return delimited_samples(DelimitedText(data, encoding), condition=condition)


def _without_condition(
    device: GamutMesh | Reference, condition: str | None
) -> GamutMesh | Reference:
    if condition is not None:
        raise OptionError.not_applicable(
            "condition", condition, "meshes and reference gamuts have no measurement condition"
        )
    return device


def _unrecognised(message: str) -> UnrecognisedFormatError:
    return UnrecognisedFormatError(
        message,
        remedy=f"Send {format_summary()}.",
    )
