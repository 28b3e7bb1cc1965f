"""The device model of measured samples: which one they get, and how far it can be trusted.

Complete grids are interpolated linearly between their nodes; scattered samples are fitted. Coarse
grids of smooth devices can be fitted better than they are interpolated: the provenance says so
where it is the case, and who builds a gamut can choose. What was measured:
docs/decisions/device-model.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gamutcore.characterisation.samples import JSON
from gamutcore.colours.device.grid_model import GridModel, grid_model
from gamutcore.colours.device.scattered_model import (
    MAX_MODEL_SAMPLES,
    SMOOTHING,
    DegenerateSamplesError,
    ScatteredModel,
    scattered_model,
)
from gamutcore.errors import OptionError

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.arrays import FloatArray

__all__ = ["DEVICE_MODELS", "DeviceModel", "device_model"]

DEVICE_MODELS = ("interpolation", "fit")
"""What can be asked for: n-linear interpolation, of complete grids, or a fit to the samples."""

_COMPARED = 1000
"""Nodes of a grid up to which the error of a fit is estimated as well: that takes 0.1 s at most."""

_STEPS_DOUBLED = 4.0
"""How many times as large errors of linear interpolation are over steps of twice the length, where
colours bend evenly: the most by which the estimate of a grid's error is too large."""

_NOTICEABLE = 1.0
"""Mean ΔE*ab of a grid's estimate below which it does not matter which model is used: the errors
themselves are then a half to a quarter of that."""


@dataclass(frozen=True, eq=False)
class DeviceModel:
    """Device value to colour, as it follows from measured samples.

    Parameters
    ----------
    device : (n, k) float
        Device values of the samples that are used.
    lab : (n, 3) float
        Their colours.
    colours : callable or None
        (m, k) device values to (m, 3) colours; None if no model can be fitted.
    provenance : dict
        Kind of the model and its error, JSON-able.
    mean_error : float or None
        Mean ΔE*ab of samples that are left out; None if none can be.
    nodes : (k, l) float or None
        Levels of each channel between which the model has no kinks, if all have equally many.
    degenerate : str
        Why no model can be fitted.
    warnings : tuple of str
        What is to be known of the model.
    """

    device: FloatArray
    lab: FloatArray
    colours: Callable[[FloatArray], FloatArray] | None
    provenance: dict[str, JSON]
    mean_error: float | None = None
    nodes: FloatArray | None = None
    degenerate: str = ""
    warnings: tuple[str, ...] = ()


def device_model(device: FloatArray, lab: FloatArray, kind: str | None = None) -> DeviceModel:
    """Return the model that samples get.

    Parameters
    ----------
    device : (n, k) float
        Distinct device values, 0 to 1.
    lab : (n, 3) float
        Their colours.
    kind : str, optional
        One of `DEVICE_MODELS`; unless given, interpolation of complete grids, and a fit to other
        samples.

    Returns
    -------
    DeviceModel
        Of all the samples of a grid that is interpolated, else of `MAX_MODEL_SAMPLES` at most.

    Raises
    ------
    OptionError
        Interpolation is asked for of samples that are no complete grid.
    """
    grid = None if kind == "fit" else grid_model(device, lab)
    if grid is not None:
        return _of_grid(grid, device, lab)
    if kind == "interpolation":
        raise _no_grid(device)
    device, lab = _thinned(device, lab)
    fitted = _fitted(device, lab)
    if isinstance(fitted, DegenerateSamplesError):
        none: dict[str, JSON] = {"name": "none: the samples' own colours"}
        why = str(fitted) if len(device) > 1 else "there is one distinct device value only"
        return DeviceModel(device, lab, None, none, degenerate=why)
    return _of_scattered(fitted, device, lab)


def _no_grid(device: FloatArray) -> OptionError:
    levels = [len(np.unique(values)) for values in device.T]
    if len(device) > 1:
        why = (
            f"the {len(device)} distinct device values are no complete grid; one of "
            f"{' · '.join(map(str, levels))} levels has {math.prod(levels):.6g}"
        )
        remedy = (
            "Ask for 'fit', or send all combinations of some levels of each channel, and nothing "
            "beside them."
        )
    else:
        why = "there is one distinct device value only, and nothing to interpolate between"
        remedy = "Send all combinations of two or more levels of each channel."
    return OptionError.not_applicable("device_model", "interpolation", why, remedy)


def _fitted(device: FloatArray, lab: FloatArray) -> ScatteredModel | DegenerateSamplesError:
    """Return the fit over the channels that vary, or why there is none."""
    try:
        return scattered_model(device[:, _varied(device)], lab)
    except DegenerateSamplesError as error:
        return error


def _varied(device: FloatArray) -> npt.NDArray[np.bool_]:
    varied: npt.NDArray[np.bool_] = np.ptp(device, axis=0) > 1e-6
    return varied


def _of_grid(grid: GridModel, device: FloatArray, lab: FloatArray) -> DeviceModel:
    errors = grid.leave_out_errors()
    provenance: dict[str, JSON] = {
        "name": "n-linear interpolation of a complete grid",
        "levels": list[JSON](grid.shape),
        "samples": len(device),
        "leave_out_error": None,
    }
    warnings: list[str] = []
    mean = None
    if len(errors):
        mean, high = _figures(errors)
        provenance["leave_out_error"] = {
            "unit": "ΔE*ab",
            "mean": mean,
            "percentile_95": high,
            "of": "every second level, interpolated between the others; the whole grid's errors "
            "are about two to four times smaller",
        }
        fitted = _fitted(device, lab) if len(device) <= _COMPARED else None
        if isinstance(fitted, ScatteredModel):
            other, other_high = _figures(fitted.leave_out_errors)
            provenance["fit"] = {
                "leave_out_error": {"unit": "ΔE*ab", "mean": other, "percentile_95": other_high}
            }
            if mean > _NOTICEABLE and other * _STEPS_DOUBLED < mean:
                warnings.append(
                    f"The grid of {len(device)} patches is coarse for this device: a fit is likely "
                    f"to be more accurate (patches left out are missed by {other:.2f} ΔE*ab on "
                    f"average, by interpolation over every second level by {mean:.2f}). The option "
                    "device_model 'fit' asks for it."
                )
    else:
        warnings.append(
            "The error of the device model is not known: a grid of two levels per channel has none "
            "that could be left out."
        )
    nodes = np.stack(grid.levels) if len(set(grid.shape)) == 1 else None
    return DeviceModel(device, lab, grid.colours, provenance, mean, nodes, warnings=tuple(warnings))


def _of_scattered(model: ScatteredModel, device: FloatArray, lab: FloatArray) -> DeviceModel:
    mean, high = _figures(model.leave_out_errors)
    provenance: dict[str, JSON] = {
        "name": "radial basis functions",
        "kernel": "cubic",
        "smoothing": SMOOTHING,
        "samples": len(device),
        "leave_out_error": {"unit": "ΔE*ab", "mean": mean, "percentile_95": high},
    }
    varied = _varied(device)
    return DeviceModel(
        device, lab, lambda values: model.colours(values[:, varied]), provenance, mean
    )


def _figures(errors: FloatArray) -> tuple[float, float]:
    """Return the mean and the 95th percentile of errors."""
    return round(float(errors.mean()), 4), round(float(np.percentile(errors, 95)), 4)


def _thinned(device: FloatArray, lab: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return at most `MAX_MODEL_SAMPLES` samples: the cube's corners and a fixed random choice."""
    if len(device) <= MAX_MODEL_SAMPLES:
        return device, lab
    corners = ((device == 0) | (device == 1)).all(axis=1)
    # A fixed seed: the same file must give the same gamut.
    rank = np.random.default_rng(0).permutation(len(device)) + len(device) * ~corners
    kept = np.sort(np.argsort(rank, kind="stable")[:MAX_MODEL_SAMPLES])
    return device[kept], lab[kept]
