"""The errors of the compute package: a small hierarchy with stable codes.

Every error has a message (what is wrong), `where` (field, line, column, tag, row, ...) and a remedy
(what is accepted). The codes are part of the public interface: clients and the service's problem
types refer to them, so a released code never changes its meaning.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import ClassVar

__all__ = [
    "BoundaryError",
    "CentreError",
    "CharacterisationError",
    "ConditionError",
    "DecimationError",
    "DeviceModelError",
    "FlatPointsError",
    "GamutError",
    "HistoryFileError",
    "InvalidPointsError",
    "MalformedFileError",
    "MalformedProfileError",
    "MeshError",
    "MissingColumnError",
    "NeighbourLimitError",
    "OptionError",
    "PictureSizeError",
    "PictureWorkError",
    "ReferenceNameError",
    "SampleLimitError",
    "TooFewPointsError",
    "TriangleCountError",
    "UnrecognisedFormatError",
    "UnsupportedPictureError",
    "UnsupportedProfileError",
]

LONGEST_SHOWN = 60
"""Longest part of a rejected value that a message repeats, in characters."""

Where = dict[str, str | int | float | list[str]]


class GamutError(Exception):
    """Base of all errors that `gamutcore` raises on purpose. ``str(error)`` has the remedy as well.

    Parameters
    ----------
    message : str
        What is wrong, in one sentence, with the rejected values.
    where : dict, optional
        Location of the fault: JSON-able values under keys such as ``field``, ``line``, ``column``,
        ``tag``, ``row``.
    remedy : str
        What is accepted instead, as a sentence.
    """

    code: ClassVar[str] = "gamut-error"

    def __init_subclass__(cls, code: str) -> None:
        cls.code = code

    def __init__(self, message: str, *, where: Where | None = None, remedy: str) -> None:
        super().__init__(message)
        self.message = message
        self.where: Where = dict(where or {})
        self.remedy = remedy

    def __str__(self) -> str:
        stop = "" if self.message.endswith((".", "?", "!")) else "."
        return f"{self.message}{stop} {self.remedy}".rstrip()

    def __reduce__(self) -> tuple[object, ...]:
        # a build runs in a worker process, and its parent reports the error: errors are pickled
        return partial(type(self), where=self.where, remedy=self.remedy), (self.message,)


class OptionError(GamutError, code="invalid-option"):
    """An option has a value that is not accepted; ``where["field"]`` names it."""

    @classmethod
    def refusal(cls, name: str, value: object, accepted: str) -> OptionError:
        """Return the error for a value that an option does not accept.

        `accepted` has the accepted values, as an object of "Give".

        Examples
        --------
        >>> OptionError.refusal("gamma", 2, "a number above 0, at most 1").message
        'gamma is 2, which is not accepted.'
        """
        message = f"{name} is {_text_of(value)}, which is not accepted."
        return cls(message, where={"field": name}, remedy=f"Give {accepted}.")

    @classmethod
    def not_applicable(
        cls, name: str, value: object, why: str, remedy: str = "Leave it out."
    ) -> OptionError:
        """Return the error for an option that does not apply to the data or to another option.

        `why` is the reason, without a full stop.
        """
        message = f"{name} {_text_of(value)} does not apply: {why}."
        return cls(message, where={"field": name}, remedy=remedy)

    @classmethod
    def check_intent(cls, intent: str, data: str) -> None:
        """Refuse intents that only ICC profiles have, for data of another kind."""
        if intent not in {"relative", "absolute"}:
            message = f"The intent {intent} exists in ICC profiles only; {data}."
            raise cls(message, where={"field": "intent"}, remedy="Give relative or absolute.")


def _text_of(value: object) -> str:
    """Return a rejected value as JSON shows it, cut to `LONGEST_SHOWN` characters."""
    shown = "null" if value is None else repr(value)
    return shown if len(shown) <= LONGEST_SHOWN else f"{shown[:LONGEST_SHOWN]}…"


class CharacterisationError(GamutError, code="invalid-characterisation"):
    """Base of the errors in characterisation data."""


class UnrecognisedFormatError(CharacterisationError, code="unrecognised-format"):
    """The content is in none of the supported formats."""


class MalformedFileError(CharacterisationError, code="malformed-file"):
    """A text, JSON or NumPy file breaks its format; ``where`` has line and column if known."""


class MissingColumnError(CharacterisationError, code="missing-column"):
    """The columns have no complete colour, or an unknown name."""


class ConditionError(CharacterisationError, code="measurement-condition"):
    """The data has several measurement conditions, or not the requested one.

    ``where["field"]`` is the option ``condition``; ``where["conditions"]`` lists the conditions.
    """


class SampleLimitError(CharacterisationError, code="too-many-samples"):
    """The data has more samples, columns or channels than are accepted."""


class MalformedProfileError(CharacterisationError, code="malformed-profile"):
    """An ICC profile breaks the specification; ``where["tag"]`` names the tag."""


class UnsupportedProfileError(CharacterisationError, code="unsupported-profile"):
    """An ICC profile is well formed but of an unsupported kind."""


class PictureSizeError(CharacterisationError, code="picture-too-large"):
    """A picture has more pixels than are accepted."""


class PictureWorkError(CharacterisationError, code="picture-too-complex"):
    """A picture takes more time to decode than its number of pixels allows."""


class UnsupportedPictureError(CharacterisationError, code="unsupported-picture"):
    """A picture is well formed but of an unsupported kind, or its colours are unknown."""


class ReferenceNameError(CharacterisationError, code="unknown-reference"):
    """There is no reference gamut of this name; the remedy names a near match."""


class InvalidPointsError(GamutError, code="invalid-points"):
    """Points have the wrong shape, or coordinates that are not finite."""


class TooFewPointsError(InvalidPointsError, code="too-few-points"):
    """Fewer than four distinct points enclose no volume."""


class FlatPointsError(InvalidPointsError, code="flat-points"):
    """All points lie nearly in one plane or on one line."""


class CentreError(InvalidPointsError, code="centre-outside"):
    """The centre is not strictly inside the points' convex hull."""


class BoundaryError(GamutError, code="boundary-failed"):
    """No closed surface that is star-shaped about the centre exists for the points."""


class MeshError(GamutError, code="invalid-mesh"):
    """A triangle mesh lacks a required property (closed, oriented, genus 0, star-shaped)."""


class DecimationError(GamutError, code="decimation-stalled"):
    """No edge can be collapsed validly although more than four triangles are left."""


class NeighbourLimitError(GamutError, code="too-many-neighbours"):
    """Vertices have so many neighbours that the history would be slow to read."""


class TriangleCountError(GamutError, code="triangle-count"):
    """The history has no level with the requested number of triangles."""


class HistoryFileError(GamutError, code="malformed-history"):
    """A history file is damaged, has another version, or is not a history."""


class DeviceModelError(GamutError, code="no-device-model"):
    """The gamut has no device model: it is of colours only, or its file does not have the model."""


@contextmanager
def errors_in(source: object) -> Iterator[None]:
    """Name the file in errors of its content, as ``where["file"]``, if `source` is a path.

    Errors of levels and of names of references are left alone: they are not about the file.
    """
    try:
        yield
    except GamutError as error:
        if isinstance(source, str | os.PathLike) and not isinstance(
            error, ReferenceNameError | TriangleCountError
        ):
            error.where = {"file": os.fspath(source), **error.where}
        raise
