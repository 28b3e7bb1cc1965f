"""Characterisation data: what is known of a device, read from the files people hold.

`characterisation` tells the format by content and returns `Samples` (measured colours, with or
without device values), an `IccProfile`, a `Picture` or a `GamutMesh`; `measurements_of` and
`described_boundary` return what else a profile carries. Reading checks everything that a file
claims; colour is computed in `gamutcore.colours`.
"""

from gamutcore.characterisation.embedded import measurements_of
from gamutcore.characterisation.gamut_mesh import GamutMesh
from gamutcore.characterisation.icc import IccProfile
from gamutcore.characterisation.meshes import described_boundary
from gamutcore.characterisation.pictures import Picture
from gamutcore.characterisation.recognition import Characterisation, characterisation
from gamutcore.characterisation.samples import Samples

__all__ = [
    "Characterisation",
    "GamutMesh",
    "IccProfile",
    "Picture",
    "Samples",
    "characterisation",
    "described_boundary",
    "measurements_of",
]
