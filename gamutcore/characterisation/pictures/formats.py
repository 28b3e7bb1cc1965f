"""Which format a picture is of, by its first bytes, and the picture itself."""

from __future__ import annotations

from gamutcore.characterisation.pictures.jpeg import JPEG_SIGNATURE, jpeg_raster
from gamutcore.characterisation.pictures.png import PNG_SIGNATURE, png_raster
from gamutcore.characterisation.pictures.raster import Picture, picture_of_raster
from gamutcore.characterisation.pictures.tiff import TIFF_SIGNATURES, tiff_raster

__all__ = ["looks_like_picture", "picture"]


def looks_like_picture(data: bytes) -> bool:
    """Return whether bytes begin as PNG, JPEG or TIFF files do.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    bool
    """
    return data.startswith((PNG_SIGNATURE, JPEG_SIGNATURE, *TIFF_SIGNATURES))


def picture(data: bytes) -> Picture:
    """Return the colours of a picture.

    Parameters
    ----------
    data : bytes
        A file that `looks_like_picture`.

    Returns
    -------
    Picture

    Raises
    ------
    MalformedFileError
        The file breaks its format, or ends early.
    PictureSizeError
        It has more pixels than are decoded.
    UnsupportedPictureError
        It is of a kind that is not read.
    MalformedProfileError, UnsupportedProfileError
        Its embedded profile is broken, or not evaluated.
    InvalidPointsError
        A value is not a finite number, or every pixel is transparent.
    """
    if data.startswith(PNG_SIGNATURE):
        return picture_of_raster(png_raster(data))
    if data.startswith(JPEG_SIGNATURE):
        return picture_of_raster(jpeg_raster(data))
    return picture_of_raster(tiff_raster(data))
