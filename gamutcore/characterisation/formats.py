"""The file formats that are read: the one list for messages, documents and the HTTP interface.

Recognition looks at the content of a file. Extensions and media types inform users only.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["FORMATS", "Format", "format_summary"]


@dataclass(frozen=True)
class Format:
    """A file format.

    Parameters
    ----------
    name : str
        Name in the provenance of a gamut, ``format``.
    title : str
        Name for people.
    kind : str
        Content: ``"profile"``, ``"measurements"``, ``"picture"``, ``"mesh"`` or ``"reference"``.
    extensions : tuple of str
        Usual extensions.
    media_types : tuple of str
        Registered media types, the usual one first; empty if there is none.
    recognition : str
        How the format is recognised.
    """

    name: str
    title: str
    kind: str
    extensions: tuple[str, ...]
    media_types: tuple[str, ...]
    recognition: str


FORMATS = (
    Format(
        "icc",
        "ICC profile, version 2, 4 or 5 (iccMAX)",
        "profile",
        (".icc", ".icm"),
        ("application/vnd.iccprofile",),
        "`acsp` at byte 36",
    ),
    Format(
        "cgats",
        "CGATS text: CGATS.17, IT8.7/x, Argyll .ti3, ISO 28178, IDMS envelopes",
        "measurements",
        (".txt", ".ti3", ".ti1", ".cgats", ".it8"),
        ("text/plain",),
        "a `BEGIN_DATA` section",
    ),
    Format(
        "cxf",
        "CxF3",
        "measurements",
        (".cxf", ".mxf", ".txf"),
        ("application/xml",),
        "XML with the root `CxF`",
    ),
    Format(
        "csv",
        "CSV, TSV, semicolon or space separated text",
        "measurements",
        (".csv", ".tsv", ".txt"),
        ("text/csv", "text/tab-separated-values"),
        "a first line of column names",
    ),
    Format(
        "json",
        "JSON samples",
        "measurements",
        (".json",),
        ("application/json",),
        "a first character `{` or `[`",
    ),
    Format("npy", "NumPy array", "measurements", (".npy",), (), "the signature `\\x93NUMPY`"),
    Format("png", "PNG", "picture", (".png",), ("image/png",), "its signature"),
    Format("jpeg", "JPEG", "picture", (".jpg", ".jpeg"), ("image/jpeg",), "its signature"),
    Format(
        "tiff", "TIFF and BigTIFF", "picture", (".tif", ".tiff"), ("image/tiff",), "its signature"
    ),
    Format("exr", "OpenEXR", "picture", (".exr",), ("image/x-exr",), "its signature"),
    Format(
        "hdr",
        "Radiance HDR",
        "picture",
        (".hdr",),
        ("image/vnd.radiance",),
        "`#?RADIANCE`, `#?RGBE`",
    ),
    Format("jpeg-xl", "JPEG XL", "picture", (".jxl",), ("image/jxl",), "its signature"),
    Format(
        "jpeg-2000",
        "JPEG 2000",
        "picture",
        (".jp2", ".j2k"),
        ("image/jp2",),
        "its signature",
    ),
    Format("webp", "WebP", "picture", (".webp",), ("image/webp",), "`RIFF` and `WEBP`"),
    Format("gif", "GIF", "picture", (".gif",), ("image/gif",), "`GIF87a`, `GIF89a`"),
    Format(
        "bmp",
        "BMP",
        "picture",
        (".bmp",),
        ("image/bmp",),
        "`BM` and the size of a known header at byte 14",
    ),
    Format("dpx", "DPX", "picture", (".dpx",), ("image/dpx",), "`SDPX` or `XPDS`"),
    Format("ply", "PLY", "mesh", (".ply",), ("model/ply",), "a first line `ply`"),
    Format("glb", "glTF 2.0, binary", "mesh", (".glb",), ("model/gltf-binary",), "`glTF`"),
    Format(
        "gltf",
        "glTF 2.0, JSON",
        "mesh",
        (".gltf",),
        ("model/gltf+json",),
        "JSON with `asset`, `meshes` and `accessors`",
    ),
    Format(
        "argyll-gam",
        "Argyll gamut surface",
        "mesh",
        (".gam",),
        (),
        "CGATS text with the first word `GAMUT`",
    ),
    Format(
        "stl",
        "STL, binary or text",
        "mesh",
        (".stl",),
        ("model/stl",),
        "a length that fits its facets, or `solid` and `facet`",
    ),
    Format("3mf", "3MF", "mesh", (".3mf",), ("model/3mf",), "a ZIP archive with a `.model`"),
    Format("obj", "Wavefront OBJ", "mesh", (".obj",), ("model/obj",), "lines `v` and `f`"),
    Format(
        "reference",
        "JSON definition",
        "reference",
        (".json",),
        ("application/json",),
        "a JSON object with `reference`, without `samples`",
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
