"""The device model of measured samples: its kind, and its estimated error.

Complete grids are interpolated linearly between their nodes, and scattered samples are fitted. A
fit can be more accurate for coarse grids of smooth devices. The provenance then says so, and the
option ``device_model`` chooses. Measurements: ``docs/decisions/device-model.md``.
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
"""Kinds of models: multilinear interpolation of complete grids, or a fit to the samples."""

_COMPARED = 1000
"""Largest grid whose fit is estimated as well; the fit of so many nodes takes 0.1 s."""

_STEPS_DOUBLED = 4.0
"""Ratio of the errors of linear interpolation when the step is doubled, for colours of constant
curvature. The estimate of a grid's error is too large by at most this factor."""

_NOTICEABLE = 1.0
"""Mean ΔE*ab of a grid's estimate below which the choice of the model does not matter. The errors
themselves are a half to a quarter of the estimate."""


@dataclass(frozen=True, eq=False)
class DeviceModel:
    """Device value to colour, from measured samples.

    Attributes
    ----------
    device, lab : (n, k) and (n, 3) float
        Device values and colours of the samples used.
    colours : callable or None
        (m, k) device values to (m, 3) colours; None if no model can be fitted.
    mean_error : float or None
        Mean ΔE*ab of left-out samples; None if none can be left out.
    nodes : (k, l) float or None
        Levels of each channel between which the model is smooth, if all channels have equally many.
    degenerate : str
        Why no model can be fitted.
    warnings : tuple of str
        Warnings about the accuracy of the model.
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
    """Return the device model of samples with distinct device values (n, k), 0 to 1.

    Without a `kind` of `DEVICE_MODELS`, complete grids are interpolated and other samples are
    fitted. A fit uses at most `MAX_MODEL_SAMPLES` samples. Interpolation without a complete grid is
    refused.
    """
    grid = None if kind == "fit" else grid_model(device, lab)
    if grid is not None:
        return _interpolation(grid, device, lab)
    if kind == "interpolation":
        raise _incomplete_grid(device)
    device, lab = _sample_subset(device, lab)
    fitted = _fit(device, lab)
    if isinstance(fitted, DegenerateSamplesError):
        none: dict[str, JSON] = {"name": "none: the samples' own colours"}
        why = str(fitted) if len(device) > 1 else "there is only one distinct device value"
        return DeviceModel(device, lab, None, none, degenerate=why)
    return _fit_model(fitted, device, lab)


def _incomplete_grid(device: FloatArray) -> OptionError:
    levels = [len(np.unique(values)) for values in device.T]
    if len(device) > 1:
        why = (
            f"the {len(device)} distinct device values are not a complete grid; a grid of "
            f"{' · '.join(map(str, levels))} levels has {math.prod(levels):.6g}"
        )
        remedy = "Give 'fit', or send exactly all combinations of some levels of each channel."
    else:
        why = "there is only one distinct device value"
        remedy = "Send all combinations of two or more levels of each channel."
    return OptionError.not_applicable("device_model", "interpolation", why, remedy)


def _fit(device: FloatArray, lab: FloatArray) -> ScatteredModel | DegenerateSamplesError:
    """Fit over the channels that vary, or the reason why there is none."""
    try:
        return scattered_model(device[:, _varying_channels(device)], lab)
    except DegenerateSamplesError as error:
        return error


def _varying_channels(device: FloatArray) -> npt.NDArray[np.bool_]:
    varied: npt.NDArray[np.bool_] = np.ptp(device, axis=0) > 1e-6
    return varied


def _interpolation(grid: GridModel, device: FloatArray, lab: FloatArray) -> DeviceModel:
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
        fitted = _fit(device, lab) if len(device) <= _COMPARED else None
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
            "The error of the device model is unknown: a grid of two levels per channel has no "
            "level that could be left out."
        )
    nodes = np.stack(grid.levels) if len(set(grid.shape)) == 1 else None
    return DeviceModel(device, lab, grid.colours, provenance, mean, nodes, warnings=tuple(warnings))


def _fit_model(model: ScatteredModel, device: FloatArray, lab: FloatArray) -> DeviceModel:
    mean, high = _figures(model.leave_out_errors)
    provenance: dict[str, JSON] = {
        "name": "radial basis functions",
        "kernel": "cubic",
        "smoothing": SMOOTHING,
        "samples": len(device),
        "leave_out_error": {"unit": "ΔE*ab", "mean": mean, "percentile_95": high},
    }
    varied = _varying_channels(device)
    return DeviceModel(
        device, lab, lambda values: model.colours(values[:, varied]), provenance, mean
    )


def _figures(errors: FloatArray) -> tuple[float, float]:
    """Mean and 95th percentile of errors."""
    return round(float(errors.mean()), 4), round(float(np.percentile(errors, 95)), 4)


def _sample_subset(device: FloatArray, lab: FloatArray) -> tuple[FloatArray, FloatArray]:
    """At most `MAX_MODEL_SAMPLES` samples: the cube's corners and a fixed random choice."""
    if len(device) <= MAX_MODEL_SAMPLES:
        return device, lab
    corners = ((device == 0) | (device == 1)).all(axis=1)
    # a fixed seed: the same file must give the same gamut
    rank = np.random.default_rng(0).permutation(len(device)) + len(device) * ~corners
    kept = np.sort(np.argsort(rank, kind="stable")[:MAX_MODEL_SAMPLES])
    return device[kept], lab[kept]
