"""Picture files: written some rows at a time by OpenImageIO, in the encoding of another picture."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from gamutcore.characterisation.pictures.encoding import SRGB, Encoding
from gamutcore.characterisation.pictures.picture import picture_meaning
from gamutcore.characterisation.pictures.raster import EXTENSIONS, open_raster, openimageio
from gamutcore.errors import OptionError, UnsupportedPictureError

if TYPE_CHECKING:
    import numpy.typing as npt

    from gamutcore.characterisation.pictures.raster import Raster

__all__ = ["DEPTHS", "WRITTEN", "Depth", "picture_writer", "with_depth"]

Depth = Literal["8", "16", "half", "float"]

WRITTEN = {".png": "png", ".tif": "tiff", ".tiff": "tiff", ".exr": "exr", ".jpg": "jpeg"}
"""Formats that are written, by the suffix of the file."""

DEPTHS: dict[str, tuple[str, type[np.generic]]] = {
    "8": ("uint8", np.uint8),
    "16": ("uint16", np.uint16),
    "half": ("half", np.float32),
    "float": ("float", np.float32),
}
"""Depths by name: OpenImageIO's type of the samples in the file, and the type in memory."""

_COLOUR = ("CICP", "chromaticities", "oiio:ColorSpace", "colorInteropID", "Exif:ColorSpace")
_KEPT = (
    *_COLOUR,
    *("Orientation", "XResolution", "YResolution", "ResolutionUnit", "PixelAspectRatio"),
)
"""Attributes of the header that are written as they were read."""


def with_depth(like: Raster, depth: Depth | None, path: Path) -> Raster:
    """Return how a picture is written: a raster with another type of samples, without its bands.

    Without a depth, that of the picture is kept; half floats become floats in TIFF, which has no
    half floats. Integers have straight alpha. Integers of a picture in linear light are sRGB.
    """
    if depth is None and like.stored == "half" and WRITTEN.get(path.suffix.lower()) == "tiff":
        depth = "float"
    if depth is None:
        return like
    if depth not in DEPTHS:
        raise OptionError(
            f"There is no depth {depth!r}.",
            where={"field": "depth"},
            remedy=f"Give one of {', '.join(DEPTHS)}.",
        )
    stored, dtype = DEPTHS[depth]
    made = replace(like, stored=stored, dtype=np.dtype(dtype), bands=iter(()))
    if made.dtype.kind == "f":
        return made
    made.premultiplied = False
    meaning, _ = picture_meaning(like)
    if isinstance(meaning, Encoding) and meaning.transfer == "linear":
        made.encoding = SRGB
        made.header = openimageio().ImageSpec(like.header)
        for name in _COLOUR:
            made.header.erase_attribute(name)
        made.header.attribute("oiio:ColorSpace", "srgb_rec709_scene")
    return made


@contextmanager
def picture_writer(
    path: Path, like: Raster
) -> Iterator[Callable[[int, int, npt.NDArray[Any]], None]]:
    """Open a picture of red, green and blue for writing, and put it in its place at the end.

    Parameters
    ----------
    path : Path
        Its suffix chooses the format.
    like : Raster
        Gives size, type of the samples, alpha and encoding; see `with_depth`.

    Yields
    ------
    callable
        Writes rows: the first row, the row after the last, and samples (pixels, channels).

    Raises
    ------
    UnsupportedPictureError
        The format is not written, or it cannot store the depth, alpha or encoding.
    OSError
        The file cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix not in WRITTEN:
        raise _refusal(f"Pictures are not written as {suffix or 'files without a suffix'}.")
    oiio = openimageio()
    names = ["R", "G", "B", *("A" if like.has_alpha else "")]
    spec = oiio.ImageSpec(like.width, like.height, len(names), like.stored)
    spec.channelnames = names
    spec.alpha_channel = 3 if like.has_alpha else -1
    for each in like.header.extra_attribs:
        if each.name in _KEPT:
            spec.attribute(each.name, each.type, each.value)
    if like.profile:
        spec.attribute("ICCProfile", f"uint8[{len(like.profile)}]", _array(like.profile))
    if like.has_alpha and not like.premultiplied:
        spec.attribute("oiio:UnassociatedAlpha", 1)
    if WRITTEN[suffix] == "jpeg":
        spec.attribute("Compression", "jpeg:95")
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".picture-") as folder:
        # the reader knows a format by its usual extension
        draft = Path(folder) / f"picture{EXTENSIONS[WRITTEN[suffix]]}"
        output = oiio.ImageOutput.create(str(draft))
        if output is None or not output.open(str(draft), spec):
            raise _refusal(f"The picture cannot be written: {(output or oiio).geterror()}")
        stored = output.spec()
        if str(stored.format) != like.stored or stored.nchannels != len(names):
            output.close()
            raise _refusal(
                f"A {WRITTEN[suffix]} file cannot store {like.stored} samples"
                f"{' with alpha' if like.has_alpha else ''}.",
                "Give the depth 8 or 16, or write OpenEXR or TIFF."
                if like.dtype.kind == "f"
                else _REMEDY,
            )

        def write(first: int, end: int, samples: npt.NDArray[Any]) -> None:
            rows = samples.reshape(end - first, like.width, len(names))
            if not output.write_scanlines(first, end, 0, rows):
                raise OSError(f"The picture cannot be written: {output.geterror()}")

        try:
            yield write
        finally:
            closed = output.close()
        if not closed:
            raise OSError(f"The picture cannot be written: {output.geterror()}")
        _check(draft, WRITTEN[suffix], like)
        os.replace(draft, path)  # noqa: PTH105  # Path.replace resolves nothing more


def _check(draft: Path, file_format: str, like: Raster) -> None:
    """Refuse a file whose values mean something else than those of the picture."""
    with open_raster(draft.read_bytes(), file_format) as found:
        meanings = [picture_meaning(each)[0] for each in (found, like)]
        if found.profile != like.profile or (not like.profile and meanings[0] != meanings[1]):
            raise _refusal(f"A {file_format} file cannot state the encoding of the picture.")
        if found.has_alpha != like.has_alpha or found.premultiplied != like.premultiplied:
            raise _refusal(f"A {file_format} file cannot store the alpha of the picture.")


def _array(data: bytes) -> Any:  # noqa: ANN401  # as OpenImageIO takes it
    return np.frombuffer(data, np.uint8)


_REMEDY = "Write the format of the picture itself, or PNG or TIFF."


def _refusal(message: str, remedy: str = _REMEDY) -> UnsupportedPictureError:
    return UnsupportedPictureError(message, where={"field": "output"}, remedy=remedy)
