"""Formats whose coordinates are CIELAB relative to D50 by definition."""

from __future__ import annotations

from gamutcore.colours.spaces import ColourSpace
from gamutcore.errors import OptionError

__all__ = ["check_icc_cielab"]


def check_icc_cielab(space: ColourSpace, format_name: str) -> None:
    """Refuse a format for meshes in other spaces than CIELAB relative to D50.

    Straight edges would be curves after a conversion, so the mesh is not converted.
    """
    if not space.is_icc_cielab:
        own = space.name if space.name != "CIELAB" else "CIELAB with another white or scale"
        raise OptionError.not_applicable(
            "format",
            format_name,
            f"the format is for CIELAB relative to D50, and the gamut is in {own}",
            "Build the gamut in the space CIELAB with default parameters, or choose ply or glb.",
        )
