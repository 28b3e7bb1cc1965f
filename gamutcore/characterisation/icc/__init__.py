"""ICC profiles of versions 2 and 4: their bytes checked and turned into device transforms.

`icc_profile` reads a header and tag table; `IccProfile.transform` reads the transform of a
rendering intent when it is asked for, so that damage in other tags does no harm.
"""

from gamutcore.characterisation.icc.profile import IccProfile, icc_profile, looks_like_icc

__all__ = ["IccProfile", "icc_profile", "looks_like_icc"]
