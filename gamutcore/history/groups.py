"""The groups that a history file stores its splits in, each one stream of bits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from gamutcore.errors import HistoryFileError
from gamutcore.history.bit_codes import read_bits

if TYPE_CHECKING:
    from types import TracebackType

    from numpy.typing import NDArray

    from gamutcore.history.bit_codes import BitReader

__all__ = [
    "DAMAGED",
    "DEVICE",
    "SPLITS",
    "Unbroken",
    "group_name",
    "groups_leading_to",
    "groups_of",
    "lengthened",
    "refuse_bits_left",
]

Scalar = TypeVar("Scalar", bound="np.generic[Any]")

SPLITS, DEVICE = "splits", "device"
"""What a stream tells of its splits: their geometry, or the device values at them."""

DAMAGED = "the file as it was delivered, unchanged"
"""What would be right in place of a stream that is not as a writer leaves it."""


def groups_of(vertices: int) -> list[tuple[int, int]]:
    """Return the groups of a history, which double the number of vertices.

    Parameters
    ----------
    vertices : int
        Of the full boundary.

    Returns
    -------
    list of (int, int)
        Slots that each group adds, the first and the one behind the last: [4, 8), [8, 16), ..., the
        last one cut at the vertex count.
    """
    groups = []
    start = 4
    while start < vertices:
        groups.append((start, min(2 * start, vertices)))
        start *= 2
    return groups


def groups_leading_to(vertices: int) -> int:
    """Return how many groups have to be there for a level to be read.

    Parameters
    ----------
    vertices : int
        Of the level.

    Returns
    -------
    int
        The last of them ends at the level or behind it: they lead to the smallest snapshot of a
        history that is not coarser.
    """
    return (vertices - 1).bit_length() - 2


def group_name(number: int, kind: str = SPLITS) -> str:
    """Return the name of a group's array in the file."""
    return f"{kind}.{number:02d}"


def lengthened(array: NDArray[Scalar], rows: int) -> NDArray[Scalar]:
    """Return a copy of an array with room for so many rows, the new ones not filled.

    With groups that double, what is copied in all is as much as what is there in the end.
    """
    longer: NDArray[Scalar] = np.empty((rows, *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


def refuse_bits_left(reader: BitReader, name: str) -> None:
    """Check that a stream ends where its last split does.

    Parameters
    ----------
    reader : BitReader
        At the end of that split.
    name : str
        Of the array that holds the stream.

    Raises
    ------
    HistoryFileError
        If more is left than the zeros that fill its last byte.
    """
    left = reader.length - int(reader.place[0])
    if left >= 8 or read_bits(reader, left):
        raise HistoryFileError(
            f"the last split of a group leaves {left} bits over",
            where={"field": name},
            remedy="zeros up to the end of a byte",
        )


class Unbroken:
    """Surrounds steps each of which goes on from where the one before has ended.

    What fails stands somewhere within its step, and nothing may go on from there: after a first
    fault, of whatever kind, every further step begins and ends with that same fault.
    """

    def __init__(self) -> None:
        self._fault: BaseException | None = None

    def __enter__(self) -> None:
        if self._fault is not None:
            raise self._fault.with_traceback(None)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._fault = fault
