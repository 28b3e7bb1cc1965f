"""Links: tables from the values of one device to those of another, for other programs.

`link` computes a `Link`, which is written as a ``.cube`` file or an ICC device link.
"""

from gamutcore.links.table import PARAMETERS, Link, LinkErrors, check_path, link, table_size

__all__ = ["PARAMETERS", "Link", "LinkErrors", "check_path", "link", "table_size"]
