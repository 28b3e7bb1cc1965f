"""Links: tables from the values of one device to those of another, for other programs.

`link` computes a `Link`, which is written as a ``.cube`` file or an ICC device link.
"""

from gamutcore.links.table import SIZE, Link, LinkErrors, check_path, link

__all__ = ["SIZE", "Link", "LinkErrors", "check_path", "link"]
