"""RGB devices both ways: colours of device values, and device values of colours.

RGB spaces have a closed inverse. Profiles and measured displays are inverted by search
(`gamutcore.colours.picture.find_values`), as for pictures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from gamutcore.colours.lookup import cube_nodes
from gamutcore.colours.picture import find_values
from gamutcore.colours.reference import rgb_values
from gamutcore.errors import OptionError
from gamutcore.references import Reference

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation import Characterisation
    from gamutcore.colours.sampling import SurfaceColours

__all__ = ["RgbDevice", "rgb_device"]

_STARTS = 17
"""Nodes a side among which a search begins; denser ones shorten it by less than they cost."""

_OTHER = "Give relative, which adapts the white."
_HELD = {"PQ": "high dynamic range", "HLG": "high dynamic range", 1.0: "linear light"}
"""Transfer curves whose values a table with equal steps from 0 to 1 cannot hold."""


@dataclass(frozen=True, eq=False)
class RgbDevice:
    """An RGB device or space.

    Attributes
    ----------
    colours : callable
        From device values (n, 3), encoded, 0 to 1, to L*, a*, b* relative to D50.
    as_measured : bool
        Whether the colours are the device's own, without adaptation to D50.
    inverse : callable, optional
        The closed inverse of `colours`, clipped to 0 to 1.
    """

    colours: Callable[[FloatArray], FloatArray]
    as_measured: bool
    inverse: Callable[[FloatArray], FloatArray] | None = None

    def values(self, lab: FloatArray) -> FloatArray:
        """Return the device values (n, 3), 0 to 1, of colours of the device.

        Those of colours outside the device's gamut are close to the nearest ones at best.
        """
        if self.inverse is not None:
            return self.inverse(lab)
        nodes, tree = self._starts
        return find_values(lab, nodes[tree.query(lab)[1]], self.colours)[0]

    @cached_property
    def _starts(self) -> tuple[FloatArray, cKDTree]:
        from scipy.spatial import cKDTree  # noqa: PLC0415  # spaces do not need it

        nodes = cube_nodes(_STARTS)
        return nodes, cKDTree(self.colours(nodes))


def rgb_device(
    characterisation: Characterisation, found: SurfaceColours, field: str, adaptation: str
) -> RgbDevice:
    """Return the RGB device of characterisation data and its colours in CIELAB.

    Parameters
    ----------
    characterisation : Reference, IccProfile or Samples
    found : SurfaceColours
        Colours with a device model, of any number of samples.
    field : str
        The argument that errors name.
    adaptation : str
        To D50, of the colours of RGB spaces.

    Raises
    ------
    OptionError
        The device is not RGB, its data has no device model, or its values are linear or of high
        dynamic range.
    """
    model = found.device_colours
    if found.channels != ("R", "G", "B") or model is None or len(model.cube.lowest) != 3:
        channels = " ".join(found.channels)
        why = f"the channels {channels}" if model is not None else "no model of a device"
        raise OptionError(
            f"The {field} has {why}; a table needs R G B.",
            where={"field": field},
            remedy="Give an RGB space such as display-p3, an RGB profile, or measurements of a "
            "display.",
        )
    intent = str(found.provenance["intent"])
    own, absolute = found.as_measured, found.absolute
    if own and absolute is not None and absolute.own_from(intent) is not None:
        raise OptionError.not_applicable(
            "intent", intent, f"the absolute colours of the {field} are scaled by its white", _OTHER
        )
    if not isinstance(characterisation, Reference):
        return RgbDevice(model.points, own)
    curve = characterisation.definition["curve"]
    if curve in _HELD:
        raise OptionError(
            f"The {field} {characterisation.slug} has values in {_HELD[curve]}, which a table with "
            "equal steps from 0 to 1 cannot hold.",
            where={"field": field},
            remedy="Give a space with a transfer curve for displays, such as bt2020.",
        )
    return RgbDevice(
        model.points, own, lambda lab: rgb_values(characterisation, lab, intent, adaptation)
    )
