"""Links and profiles: what a gamut tells, as files that other programs apply.

`link` computes a `Link`, a table from the values of one device to those of another, which is
written as a ``.cube`` file or an ICC device link. `profile` makes the `Profile` of a device.
"""

from gamutcore.links.device_profile import PROFILE_SUFFIXES, Differences, Profile, profile
from gamutcore.links.rgb_link import SIZE, Link, LinkErrors, check_path, link

__all__ = [
    "PROFILE_SUFFIXES",
    "SIZE",
    "Differences",
    "Link",
    "LinkErrors",
    "Profile",
    "check_path",
    "link",
    "profile",
]
