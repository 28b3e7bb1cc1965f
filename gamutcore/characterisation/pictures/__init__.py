"""Pictures as characterisation data: the colours of their pixels.

`picture_format` recognises a picture by its first bytes, and `read_picture` returns a `Picture`:
the distinct values of its pixels, their counts, and a profile or `Encoding`. `open_raster` gives
the pixels themselves, and `picture_meaning` what they mean. OpenImageIO and Pillow decode.
"""

from gamutcore.characterisation.pictures.encoding import (
    LINEAR,
    SRGB,
    Encoding,
    chromaticity_encoding,
)
from gamutcore.characterisation.pictures.picture import (
    LARGEST_LIGHT,
    Picture,
    divided_by_alpha,
    picture_meaning,
    read_picture,
    refuse_not_finite,
    refuse_too_bright,
)
from gamutcore.characterisation.pictures.raster import (
    EXTENSIONS,
    MODELS,
    Raster,
    open_raster,
    openimageio,
    picture_format,
)

__all__ = [
    "EXTENSIONS",
    "LARGEST_LIGHT",
    "LINEAR",
    "MODELS",
    "SRGB",
    "Encoding",
    "Picture",
    "Raster",
    "chromaticity_encoding",
    "divided_by_alpha",
    "open_raster",
    "openimageio",
    "picture_format",
    "picture_meaning",
    "read_picture",
    "refuse_not_finite",
    "refuse_too_bright",
]
