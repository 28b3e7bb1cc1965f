"""Pictures as characterisation data: the colours of their pixels.

`picture_format` recognises a picture by its first bytes, and `read_picture` returns a `Picture`:
the distinct values of its pixels, their counts, and a profile or `Encoding`. OpenImageIO
and Pillow decode.
"""

from gamutcore.characterisation.pictures.encoding import Encoding
from gamutcore.characterisation.pictures.picture import Picture, read_picture
from gamutcore.characterisation.pictures.raster import picture_format

__all__ = ["Encoding", "Picture", "picture_format", "read_picture"]
