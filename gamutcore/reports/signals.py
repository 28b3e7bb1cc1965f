"""Test signals of displays: the colours on the surface of the RGB cube that standards measure.

With m levels a channel, 6m² − 12m + 8 of the m³ colours have a channel at either end (IDMS 1.3,
5.32; IEC 62977-3-5). The levels are rounded down, as in the published sets of 8 bits: 0, 25, 51,
76, …, 255.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Annotated

import numpy as np

from gamutcore.arguments import Choice, WholeNumber, check_option
from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.errors import OptionError

__all__ = [
    "SIGNAL_COUNTS",
    "cube_faces",
    "signal_codes",
    "signal_levels",
    "write_signals",
]

SIGNAL_COUNTS = {98: 5, 218: 7, 386: 9, 602: 11}
"""Numbers of test signals, with the levels of each channel."""


def signal_levels(count: int = 602, bits: int = 8) -> FloatArray:
    """Return the levels of each channel as codes, in increasing order.

    Raises
    ------
    OptionError
        The count is none of `SIGNAL_COUNTS`, the bits are not from 1 to 16, or they are too few for
        distinct levels.
    """
    check_option("count", count, Annotated[int, Choice(tuple(SIGNAL_COUNTS))])
    check_option("bits", bits, Annotated[int, WholeNumber(1, 16)])
    steps = SIGNAL_COUNTS[count] - 1
    codes = np.arange(steps + 1) * (2**bits - 1) // steps
    if len(np.unique(codes)) <= steps:
        least = next(b for b in range(bits, 17) if 2**b - 1 >= steps)
        raise OptionError(
            f"With {bits} bits, the {steps + 1} levels of {count} signals are not distinct.",
            where={"field": "bits"},
            remedy=f"Give {least} bits or more, or fewer signals.",
        )
    return np.asarray(codes, np.float64)


def cube_faces(levels: FloatArray) -> tuple[FloatArray, IndexArray]:
    """Return the points (n, 3) of a lattice on the surface of a cube, and triangles between them.

    The triangles are counter-clockwise seen from outside. The diagonal of a square is the one that
    joins the points of one larger coordinate each, as in the tools of the standard's authors; in
    CIELAB the other one gives 0.1 % more for sRGB.
    """
    count = len(levels)
    one, two = (grid.ravel() for grid in np.meshgrid(*2 * [np.arange(count)], indexing="ij"))
    corner = (np.arange(count - 1)[:, np.newaxis] * count + np.arange(count - 1)).ravel()
    along, across = corner + count, corner + 1
    squares = [(corner, along, across), (along, along + 1, across)]
    triangles = np.concatenate([np.stack(square, axis=1) for square in squares])
    places: list[LongArray] = []
    faces: list[LongArray] = []
    for axis in range(3):
        for end in (0, count - 1):
            place = np.empty((len(one), 3), np.int64)
            place[:, axis], place[:, axis - 2], place[:, axis - 1] = end, one, two
            outward = triangles if end else triangles[:, ::-1]
            faces.append(outward + len(places) * len(one))
            places.append(place)
    distinct, rows = np.unique(np.concatenate(places), axis=0, return_inverse=True)
    return levels[distinct], rows.reshape(-1)[np.concatenate(faces)].astype(np.int32)


def signal_codes(count: int = 602, bits: int = 8) -> FloatArray:
    """Return the codes (count, 3) of R, G, B, in increasing order.

    Examples
    --------
    >>> signal_codes(98)[:3].tolist()
    [[0.0, 0.0, 0.0], [0.0, 0.0, 63.0], [0.0, 0.0, 127.0]]
    """
    return cube_faces(signal_levels(count, bits))[0]


def write_signals(path: str | Path, count: int = 602, bits: int = 8) -> None:
    """Write test signals as CSV with the columns SAMPLE_ID, RGB_R, RGB_G and RGB_B.

    Readings go into further columns, XYZ_X, XYZ_Y and XYZ_Z.
    """
    path = Path(path)
    if path.suffix.lower() != ".csv":
        raise OptionError.refusal("output", path.name, "a name that ends in .csv")
    signals = signal_codes(count, bits).astype(int).tolist()
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["SAMPLE_ID", "RGB_R", "RGB_G", "RGB_B"])
        writer.writerows([number, *signal] for number, signal in enumerate(signals, 1))
