"""The device model of measured samples: which one they get, and how far it can be trusted.

Complete grids of more samples than can be fitted, and those of many levels, are interpolated
linearly between their nodes; other samples are fitted, but for grids that linear interpolation is
known to follow better. Why, and what was measured: docs/decisions/device-model.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.samples import JSON
from gamutcore.colours.grid_model import GridModel, grid_model
from gamutcore.colours.scattered_model import (
    MAX_MODEL_SAMPLES,
    SMOOTHING,
    DegenerateSamplesError,
    ScatteredModel,
    scattered_model,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.arrays import FloatArray

__all__ = ["DeviceModel", "device_model"]


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
    """

    device: FloatArray
    lab: FloatArray
    colours: Callable[[FloatArray], FloatArray] | None
    provenance: dict[str, JSON]
    mean_error: float | None = None
    nodes: FloatArray | None = None
    degenerate: str = ""


def device_model(device: FloatArray, lab: FloatArray) -> DeviceModel:
    """Return the model that samples get.

    Parameters
    ----------
    device : (n, k) float
        Distinct device values, 0 to 1.
    lab : (n, 3) float
        Their colours.

    Returns
    -------
    DeviceModel
        Of all the samples if they form a complete grid, else of `MAX_MODEL_SAMPLES` at most.
    """
    grid = grid_model(device, lab)
    if grid is not None and (grid.fine or len(device) > MAX_MODEL_SAMPLES):
        return _of_grid(grid, device, lab)
    device, lab = _thinned(device, lab)
    varied = np.ptp(device, axis=0) > 1e-6
    try:
        fitted = scattered_model(device[:, varied], lab)
    except DegenerateSamplesError as error:
        none: dict[str, JSON] = {"name": "none: the samples' own colours"}
        return DeviceModel(device, lab, None, none, degenerate=str(error))
    model = _of_scattered(fitted, device, lab)
    if grid is not None:
        interpolated = _of_grid(grid, device, lab)
        # The grid's estimate is the worse one of the two for the same accuracy: what wins by it
        # follows kinks at its nodes that smooth functions cannot.
        if interpolated.mean_error is not None and model.mean_error is not None:
            return model if model.mean_error <= interpolated.mean_error else interpolated
    return model


def _of_grid(grid: GridModel, device: FloatArray, lab: FloatArray) -> DeviceModel:
    errors = grid.leave_out_errors()
    # None of a grid of two levels per channel can be left out.
    figures = _figures(errors) if len(errors) else None
    provenance: dict[str, JSON] = {
        "name": "n-linear interpolation of a complete grid",
        "levels": list[JSON](grid.shape),
        "samples": len(device),
        "leave_out_error": None,
    }
    if figures is not None:
        provenance["leave_out_error"] = {
            "unit": "ΔE*ab",
            "mean": figures[0],
            "percentile_95": figures[1],
            "of": "every second level, interpolated between the others; the whole grid's errors "
            "are about two to four times smaller",
        }
    nodes = np.stack(grid.levels) if len(set(grid.shape)) == 1 else None
    mean = None if figures is None else figures[0]
    return DeviceModel(device, lab, grid.colours, provenance, mean, nodes)


def _of_scattered(model: ScatteredModel, device: FloatArray, lab: FloatArray) -> DeviceModel:
    mean, high = _figures(model.leave_out_errors)
    provenance: dict[str, JSON] = {
        "name": "radial basis functions",
        "kernel": "cubic",
        "smoothing": SMOOTHING,
        "samples": len(device),
        "leave_out_error": {"unit": "ΔE*ab", "mean": mean, "percentile_95": high},
    }
    varied = np.ptp(device, axis=0) > 1e-6
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
