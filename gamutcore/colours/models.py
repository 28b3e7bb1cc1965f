"""Device models as data: device value to colour, with limits, saved and read without the input.

A `DeviceModel` has one of four functions: a fit or a grid of measured samples, the transform of an
ICC profile, or the formulas of an RGB space. It is saved as a safetensors file, which has only what
the function needs: 95 kB for a press of 1,617 patches, and the used tags for a profile.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
from safetensors import SafetensorError
from safetensors import deserialize as read_tensors
from safetensors.numpy import save as save_tensors

from gamutcore.colours.colorimetry import lab_to_xyz, xyz_to_lab
from gamutcore.colours.ink_limits import InkCube, LimitedCube
from gamutcore.errors import GamutError, HistoryFileError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import FloatArray

__all__ = [
    "Arrays",
    "DeviceFunction",
    "DeviceModel",
    "check_shapes",
    "device_function",
    "naming_remedy",
]

Arrays = dict[str, Any]

FORMAT = "gamut-device-model"
VERSION = 1


class DeviceFunction(Protocol):
    """A function from device values to CIELAB relative to D50."""

    kind: ClassVar[str]

    def lab(self, device: FloatArray) -> FloatArray:
        """Return the colours (m, 3) of device values (m, n), 0 to 1."""

    def closed_values(self, lab: FloatArray) -> FloatArray | None:  # noqa: ARG002
        """Return device values of colours by an inverse formula, about exact; None without one."""
        return None

    def parts(self) -> tuple[Arrays, dict[str, Any]]:
        """Return arrays and JSON-able facts, from which `of` makes the function again."""

    @classmethod
    def of(cls, arrays: Arrays, facts: Mapping[str, Any]) -> Self:
        """Return the function of its parts."""


SOLIDS = {
    "C": (55, -37, -50),
    "M": (48, 74, -3),
    "Y": (89, -5, 93),
    "K": (16, 0, 0),
    "O": (65, 58, 88),
    "G": (60, -75, 0),
    "V": (22, 47, -56),
}
"""CIELAB of solid inks: ISO 12647-2, coated paper, and the inks of FOGRA55."""


FUNCTIONS: dict[str, type[DeviceFunction]] = {}
"""The classes of functions by kind. Each is added where it is defined."""

Function = TypeVar("Function", bound="type[DeviceFunction]")


def device_function(function: Function) -> Function:
    """Add a class to `FUNCTIONS`."""
    FUNCTIONS[function.kind] = function
    return function


@dataclass(frozen=True, eq=False)
class DeviceModel:
    """A device: its channels, the device values that it can have, and their colours.

    Attributes
    ----------
    channels : tuple of str
        Names of the n channels.
    inks : bool
        Whether more of a channel is darker, rather than lighter.
    limited : LimitedCube
        The range of each channel and the limit of their sum.
    function : DeviceFunction
        Device values to colours.
    own : (3, 3) float, optional
        Matrix from the function's tristimulus values to those of the gamut's space. Only files of
        older versions have it, for profiles of displays whose colours are not adapted.
    """

    channels: tuple[str, ...]
    inks: bool
    limited: LimitedCube
    function: DeviceFunction
    own: FloatArray | None = None

    def lab(self, device: FloatArray) -> FloatArray:
        """Return CIELAB (m, 3) relative to D50 of device values (m, n), 0 to 1."""
        lab = self.function.lab(device)
        return lab if self.own is None else xyz_to_lab(lab_to_xyz(lab) @ self.own.T)

    def closed_values(self, lab: FloatArray) -> FloatArray | None:
        """Return device values of colours by the function's inverse formula; None without one."""
        if self.own is not None:
            lab = xyz_to_lab(lab_to_xyz(lab) @ np.linalg.inv(self.own).T)
        return self.function.closed_values(lab)

    def to_bytes(self) -> bytes:
        """Return the model as a safetensors file."""
        arrays, facts = self.function.parts()
        cube, limited = self.limited.cube, self.limited
        facts |= {
            "version": VERSION,
            "kind": self.function.kind,
            "channels": list(self.channels),
            "inks": self.inks,
            "free": limited.free.tolist(),
            "total": cube.total,
        }
        ranges = {"lowest": cube.lowest, "highest": cube.highest, "base": limited.base}
        own = {} if self.own is None else {"own": self.own}
        tensors = {
            name: np.ascontiguousarray(array) for name, array in {**arrays, **ranges, **own}.items()
        }
        # one text, because the library writes several in any order
        return save_tensors(tensors, {FORMAT: json.dumps(facts)})

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Return the model of a file that `to_bytes` wrote; others raise `HistoryFileError`."""
        try:
            length = int.from_bytes(data[:8], "little")
            facts = json.loads(json.loads(data[8 : 8 + length])["__metadata__"][FORMAT])
            arrays = {name: _array(array) for name, array in read_tensors(data)}
            cube = InkCube(arrays["lowest"], arrays["highest"], facts["total"])
            free, count = np.array(facts["free"], bool), len(facts["channels"])
            ranges = (arrays["lowest"], arrays["highest"], arrays["base"])
            varied = (int(free.sum()),)
            check_shapes((*ranges, free), (varied, varied, (count,), (count,)))
            limited = LimitedCube(cube, free, arrays["base"], {})
            function = FUNCTIONS[facts["kind"]].of(arrays, facts)
            model = cls(
                tuple(map(str, facts["channels"])),
                bool(facts["inks"]),
                limited,
                function,
                arrays.get("own"),
            )
            corners = np.stack([cube.lowest, cube.highest])
            damaged = facts["version"] != VERSION
            damaged |= not np.isfinite(model.lab(limited.device(corners))).all()
        except (
            SafetensorError,
            GamutError,
            LookupError,
            ValueError,
            TypeError,
            AttributeError,
            RecursionError,
        ) as cause:
            raise _damaged() from cause
        if damaged:
            raise _damaged()
        return model


def check_shapes(
    arrays: Sequence[np.ndarray],
    shapes: Sequence[tuple[int, ...]],
    dtype: Any = None,  # noqa: ANN401
) -> None:
    """Raise ValueError if arrays of a file do not have these shapes and this type."""
    for array, shape in zip(arrays, shapes, strict=True):
        if array.shape != shape or (dtype is not None and array.dtype != dtype):
            message = f"an array has the shape {array.shape}, not {shape}"
            raise ValueError(message)


def _damaged() -> HistoryFileError:
    return HistoryFileError(
        "The device model of the file is damaged, or of another version.",
        where={"field": "model"},
        remedy="Build the gamut again from its data.",
    )


_TYPES = {"F64": np.float64, "F32": np.float32, "U8": np.uint8}


def _array(tensor: Mapping[str, Any]) -> np.ndarray:
    values = np.frombuffer(tensor["data"], _TYPES[tensor["dtype"]])
    return values.reshape(tensor["shape"])


def naming_remedy(model: DeviceModel) -> str:
    """Return how to name the inks of a device, with a guess by the colours of the solid inks."""
    count = len(model.channels)
    solids = np.tile(model.limited.base, (count, 1))
    np.fill_diagonal(solids, 1.0)
    lab = model.lab(solids)
    distances = np.linalg.norm(lab[:, np.newaxis] - np.array(list(SOLIDS.values())), axis=2)
    names = [list(SOLIDS)[place] for place in distances.argmin(axis=1)]
    darkest = int(lab[:, 0].argmin())
    if len(set(names)) == count:
        guess = f"By their colours, they may be {','.join(names)}."
    else:
        guess = f"Ink {darkest + 1} is the darkest (L* {lab[darkest, 0]:.0f}): it may be black, K."
    return f"Give their names in order, such as --inks C,M,Y,K,O,G,V (the option inks). {guess}"
