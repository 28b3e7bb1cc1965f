"""Pictures as characterisation data: the colours of their pixels, from PNG, TIFF and JPEG files.

`picture` tells the format by its first bytes, and returns a `Picture`: distinct values of its
pixels with their numbers, and what they mean (a profile, or an `Encoding` that is stated or
assumed). Sizes are checked against what a file can hold before anything is decoded.
"""

from gamutcore.characterisation.pictures.encoding import Encoding
from gamutcore.characterisation.pictures.formats import looks_like_picture, picture
from gamutcore.characterisation.pictures.raster import Picture

__all__ = ["Encoding", "Picture", "looks_like_picture", "picture"]
