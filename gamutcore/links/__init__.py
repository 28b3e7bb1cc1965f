"""Links and profiles: what a gamut tells, as files that other programs apply.

`link` computes a `Link`, a table from the values of one device to those of another, which is
written as a ``.cube`` file or an ICC device link. `profile` makes the `Profile` of a device.
"""

from gamutcore.links.device_profile import PROFILE_SUFFIXES, Differences, Profile, profile
from gamutcore.links.table import PARAMETERS, Link, LinkErrors, check_path, link, table_size

__all__ = [
    "PARAMETERS",
    "PROFILE_SUFFIXES",
    "Differences",
    "Link",
    "LinkErrors",
    "Profile",
    "check_path",
    "link",
    "profile",
    "table_size",
]
