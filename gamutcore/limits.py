"""Limits on the amount of characterisation data.

Every reader has its own bounds, beyond the size of any real data. A service that reads data of
strangers may lower the two bounds that determine time and memory. `apply_limits` sets them for all
readers called inside it, in the same thread or task. Native decoders cannot be interrupted, so
their time limit ends the process (`Limits.overtime`).
"""

from __future__ import annotations

import contextlib
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from gamutcore.errors import GamutError

__all__ = ["MAX_PIXELS", "MAX_SAMPLES", "Limits", "apply_limits", "current_limits"]

MAX_SAMPLES = 5_000_000
"""Largest number of samples. The distinct colours of a 24-bit picture take 120 MB."""

MAX_PIXELS = 120_000_000
"""Largest number of pixels of a picture. Large cameras have 102 to 151 million, phones up to 50
million (200 by interpolation)."""


@dataclass(frozen=True)
class Limits:
    """Largest accepted numbers of samples and of pixels of a picture.

    `overtime` ends the process. It is called in another thread, with the error to report, when a
    decoder of pictures takes too long. Without it, decoders have no time limit.
    """

    samples: int = MAX_SAMPLES
    pixels: int = MAX_PIXELS
    overtime: Callable[[GamutError], None] | None = field(default=None, compare=False)


_current: ContextVar[Limits] = ContextVar("limits", default=Limits())  # noqa: B039 - frozen


def current_limits() -> Limits:
    """Return the limits of the current thread or task."""
    return _current.get()


@contextlib.contextmanager
def apply_limits(limits: Limits) -> Iterator[None]:
    """Set the limits for the body of a ``with`` statement.

    Examples
    --------
    >>> with apply_limits(Limits(samples=10)):
    ...     current_limits().samples
    10
    """
    token = _current.set(limits)
    try:
        yield
    finally:
        _current.reset(token)
