"""How much characterisation data is accepted, where the caller wants less than the readers could.

Every reader has bounds of its own, beyond which no real data goes. Whoever reads the data of
strangers may lower the two that decide about time and memory, for the length of a call:
`apply_limits` holds for whatever reads inside it, in the same thread or task.
"""

from __future__ import annotations

import contextlib
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["MAX_PIXELS", "MAX_SAMPLES", "Limits", "apply_limits", "current_limits"]

MAX_SAMPLES = 5_000_000
"""Samples that are accepted at most: a 24-bit picture's worth of distinct colours takes 120 MB."""

MAX_PIXELS = 120_000_000
"""Pixels of a picture at most: the largest cameras in use have 102 to 151 million, phones up to 50
(200 by interpolation)."""


@dataclass(frozen=True)
class Limits:
    """How much is accepted at most.

    Attributes
    ----------
    samples : int
        Samples (patches) of characterisation data.
    pixels : int
        Pixels of a picture.
    """

    samples: int = MAX_SAMPLES
    pixels: int = MAX_PIXELS


_current: ContextVar[Limits] = ContextVar("limits", default=Limits())  # noqa: B039 - frozen


def current_limits() -> Limits:
    """Return the limits that hold here."""
    return _current.get()


@contextlib.contextmanager
def apply_limits(limits: Limits) -> Iterator[None]:
    """Let limits hold inside."""
    token = _current.set(limits)
    try:
        yield
    finally:
        _current.reset(token)
