"""How a build that a thread is busy with is told to end, from another thread."""

from __future__ import annotations

from typing import Literal

__all__ = ["Interrupted", "Interruption"]


class Interrupted(Exception):  # noqa: N818 - not an error
    """A build was told to end.

    Attributes
    ----------
    reason : str
        ``cancel``: nobody wants it any more. ``release``: somebody else is to build it.
    """

    def __init__(self, reason: Literal["cancel", "release"]) -> None:
        super().__init__(reason)
        self.reason = reason


class Interruption:
    """A word from outside that a build looks for all the time."""

    def __init__(self) -> None:
        self._reason: Literal["cancel", "release"] | None = None

    def cancel(self) -> None:
        """Let the build end because nobody wants it any more."""
        self._reason = "cancel"

    def release(self) -> None:
        """Let the build end, to be begun again by somebody else; a cancelled one stays so."""
        self._reason = self._reason or "release"

    def check(self) -> None:
        """Raise `Interrupted` if the build is to end."""
        if self._reason is not None:
            raise Interrupted(self._reason)
