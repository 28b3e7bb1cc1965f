"""The file formats that are read, and their recognition by content, never by file name.

`FORMATS` is the one list for messages, documents and the HTTP interface. Binary formats have
signatures. Text is decoded once. JSON has a bracket first, the CGATS family has a data section, and
other text is a table if its first line has column names.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from gamutcore.characterisation.cgats import cgats_samples, looks_like_cgats
from gamutcore.characterisation.cxf import cxf_samples, looks_like_cxf, looks_like_xml
from gamutcore.characterisation.icc import IccProfile, icc_profile, looks_like_icc
from gamutcore.characterisation.meshes.gltf import gltf_mesh, looks_like_glb, looks_like_gltf
from gamutcore.characterisation.meshes.mesh import GamutMesh, argyll_mesh, looks_like_argyll
from gamutcore.characterisation.meshes.triangle_files import (
    looks_like_obj,
    looks_like_ply,
    looks_like_stl,
    looks_like_threemf,
    obj_mesh,
    ply_mesh,
    stl_mesh,
    threemf_mesh,
)
from gamutcore.characterisation.pictures import Picture, picture_format, read_picture
from gamutcore.characterisation.samples import NPY_MAGIC, Samples, json_samples, npy_samples
from gamutcore.characterisation.text import DelimitedText, delimited_samples, text_encoding
from gamutcore.errors import OptionError, UnrecognisedFormatError
from gamutcore.references import Reference, parse_definition

__all__ = ["FORMATS", "Characterisation", "Format", "format_summary", "read_characterisation"]


@dataclass(frozen=True)
class Format:
    """A file format.

    Attributes
    ----------
    name, title : str
        Name in the provenance of a gamut, ``format``, and name for people.
    kind : str
        Content: ``"profile"``, ``"measurements"``, ``"picture"``, ``"mesh"`` or ``"reference"``.
    extensions : tuple of str
        Usual extensions.
    media_types : tuple of str
        Registered media types, the usual one first; empty if there is none.
    """

    name: str
    title: str
    kind: str
    extensions: tuple[str, ...]
    media_types: tuple[str, ...]


FORMATS = (
    Format(
        "icc",
        "ICC profile, version 2, 4 or 5 (iccMAX)",
        "profile",
        (".icc", ".icm"),
        ("application/vnd.iccprofile",),
    ),
    Format(
        "cgats",
        "CGATS text: CGATS.17, IT8.7/x, Argyll .ti3, ISO 28178, IDMS envelopes",
        "measurements",
        (".txt", ".ti3", ".cgats", ".it8"),
        ("text/plain",),
    ),
    Format(
        "cxf",
        "CxF3",
        "measurements",
        (".cxf", ".mxf", ".txf"),
        ("application/xml",),
    ),
    Format(
        "csv",
        "CSV, TSV, semicolon or space separated text",
        "measurements",
        (".csv", ".tsv", ".txt"),
        ("text/csv", "text/tab-separated-values"),
    ),
    Format(
        "json",
        "JSON samples",
        "measurements",
        (".json",),
        ("application/json",),
    ),
    Format("npy", "NumPy array", "measurements", (".npy",), ()),
    Format("png", "PNG", "picture", (".png",), ("image/png",)),
    Format("jpeg", "JPEG", "picture", (".jpg", ".jpeg"), ("image/jpeg",)),
    Format("tiff", "TIFF and BigTIFF", "picture", (".tif", ".tiff"), ("image/tiff",)),
    Format("exr", "OpenEXR", "picture", (".exr",), ("image/x-exr",)),
    Format(
        "hdr",
        "Radiance HDR",
        "picture",
        (".hdr",),
        ("image/vnd.radiance",),
    ),
    Format("jpeg-xl", "JPEG XL", "picture", (".jxl",), ("image/jxl",)),
    Format("jpeg-2000", "JPEG 2000", "picture", (".jp2", ".j2k"), ("image/jp2",)),
    Format("webp", "WebP", "picture", (".webp",), ("image/webp",)),
    Format("gif", "GIF", "picture", (".gif",), ("image/gif",)),
    Format(
        "bmp",
        "BMP",
        "picture",
        (".bmp",),
        ("image/bmp",),
    ),
    Format("dpx", "DPX", "picture", (".dpx",), ("image/dpx",)),
    Format("ply", "PLY", "mesh", (".ply",), ("model/ply",)),
    Format("glb", "glTF 2.0, binary", "mesh", (".glb",), ("model/gltf-binary",)),
    Format(
        "gltf",
        "glTF 2.0, JSON",
        "mesh",
        (".gltf",),
        ("model/gltf+json",),
    ),
    Format(
        "argyll-gam",
        "Argyll gamut surface",
        "mesh",
        (".gam",),
        (),
    ),
    Format(
        "stl",
        "STL, binary or text",
        "mesh",
        (".stl",),
        ("model/stl",),
    ),
    Format("3mf", "3MF", "mesh", (".3mf",), ("model/3mf",)),
    Format("obj", "Wavefront OBJ", "mesh", (".obj",), ("model/obj",)),
    Format(
        "reference",
        "JSON definition",
        "reference",
        (".json",),
        ("application/json",),
    ),
)
"""All formats, in the order of the documents."""


def format_summary() -> str:
    """Return the formats by kind, as a part of a sentence.

    Examples
    --------
    >>> format_summary().startswith("a profile (ICC profile")
    True
    """
    kinds = {"profile": "a profile", "measurements": "measurements", "picture": "a picture"}
    kinds |= {"mesh": "a gamut mesh", "reference": "a reference gamut"}
    parts = []
    for kind, article in kinds.items():
        titles = [entry.title.partition(":")[0] for entry in FORMATS if entry.kind == kind]
        parts.append(f"{article} ({'; '.join(titles)})")
    return ", ".join(parts[:-1]) + f" or {parts[-1]}"


Characterisation: TypeAlias = Samples | IccProfile | Picture | GamutMesh | Reference
"""What a file says of a device: the result of `read_characterisation`."""

_MESHES_IN_BYTES: tuple[tuple[Callable[[bytes], bool], Callable[[bytes], GamutMesh]], ...] = (
    (looks_like_ply, ply_mesh),
    (looks_like_glb, gltf_mesh),
    (looks_like_threemf, threemf_mesh),
    (looks_like_stl, stl_mesh),
)
_MESHES_IN_TEXT: tuple[tuple[Callable[[str], bool], Callable[[str], GamutMesh]], ...] = (
    (looks_like_gltf, lambda text: gltf_mesh(text.encode())),
    (looks_like_argyll, argyll_mesh),
    (looks_like_obj, obj_mesh),
)
"""Readers of meshes in the order of trial, each with the function that recognises its format."""


def read_characterisation(
    data: bytes,
    *,
    condition: str | None = None,
    layer: str | None = None,
    estimates: bool = False,
) -> Characterisation:
    """Return the characterisation data in the bytes of a file or message.

    Parameters
    ----------
    data : bytes
        A file in one of `gamutcore.characterisation.FORMATS`.
    condition : str, optional
        The measurement condition to read, such as ``"M1"``, if the data has several.
    layer : str, optional
        The layer of an OpenEXR picture.
    estimates : bool, optional
        Whether to read charts, whose colours are estimates (Argyll's .ti1 and .ti2). The provenance
        of their samples has ``chart``.

    Raises
    ------
    UnrecognisedFormatError
        The content has no known format, or is a chart.
    OptionError
        A condition is requested of a profile, a picture, a mesh or a reference gamut, or a layer of
        something else than OpenEXR.
    CharacterisationError, InvalidPointsError, MeshError
        The format is known, but the content is malformed. ``where`` has the location.
    """
    picture = picture_format(data)
    if layer is not None and picture is None:
        raise OptionError.not_applicable("layer", layer, "the data is not a picture")
    if picture is not None or looks_like_icc(data):
        _refuse_condition(condition, "profiles and pictures")
        return icc_profile(data) if picture is None else read_picture(data, picture, layer)
    mesh = next((read(data) for fits, read in _MESHES_IN_BYTES if fits(data)), None)
    if mesh is not None:
        _refuse_condition(condition, "meshes and reference gamuts")
        return mesh
    if data.startswith(NPY_MAGIC):
        return npy_samples(data, condition=condition)
    if looks_like_xml(data):
        if not looks_like_cxf(data):
            raise _unrecognised("The content is XML or HTML, but not CxF3.")
        return cxf_samples(data, condition=condition)
    encoding = text_encoding(data)
    if encoding is None:
        raise _unrecognised("The content is binary, and its format is unknown.")
    return _read_text(data, encoding, condition, estimates=estimates)


def _read_text(
    data: bytes, encoding: str, condition: str | None, *, estimates: bool
) -> Characterisation:
    """Return the characterisation data in a text: a mesh, JSON, CGATS or a table."""
    text = data.decode(encoding)
    if not text.strip("\0 \t\r\n"):
        raise _unrecognised("The content is empty.")
    mesh = next((read(text) for fits, read in _MESHES_IN_TEXT if fits(text)), None)
    if mesh is not None:
        _refuse_condition(condition, "meshes and reference gamuts")
        return mesh
    if text[:1000].lstrip().startswith(("{", "[")):
        reference = parse_definition(text)
        if reference is None:
            return json_samples(text, condition=condition)
        _refuse_condition(condition, "meshes and reference gamuts")
        return reference
    if looks_like_cgats(text):
        return cgats_samples(text, condition=condition, estimates=estimates)
    return delimited_samples(DelimitedText(data, encoding), condition=condition)


def _refuse_condition(condition: str | None, what: str) -> None:
    if condition is not None:
        raise OptionError.not_applicable(
            "condition", condition, f"{what} have no measurement condition"
        )


def _unrecognised(message: str) -> UnrecognisedFormatError:
    return UnrecognisedFormatError(message, remedy=f"Send {format_summary()}.")
