"""Characterisation data: what is known of a device, read from files.

`read_characterisation` recognises a format by content. It returns `Samples` (measured colours, with
or without device values), an `IccProfile`, a `Picture`, a `GamutMesh` or a `Reference`.
`embedded_measurements` and `embedded_boundary` return further content of a profile. `FORMATS` lists
all formats. Readers check every size and value in a file; `gamutcore.colours` computes colours.
"""

from gamutcore.characterisation.embedded_data import embedded_measurements, stated_ink_limit
from gamutcore.characterisation.icc import IccProfile
from gamutcore.characterisation.meshes import GamutMesh, embedded_boundary
from gamutcore.characterisation.pictures import Picture
from gamutcore.characterisation.recognition import (
    FORMATS,
    Characterisation,
    Format,
    read_characterisation,
)
from gamutcore.characterisation.samples import Samples
from gamutcore.characterisation.text import (
    DelimitedText,
    mentions,
    text_encoding,
)

__all__ = [
    "FORMATS",
    "Characterisation",
    "DelimitedText",
    "Format",
    "GamutMesh",
    "IccProfile",
    "Picture",
    "Samples",
    "embedded_boundary",
    "embedded_measurements",
    "mentions",
    "read_characterisation",
    "stated_ink_limit",
    "text_encoding",
]
