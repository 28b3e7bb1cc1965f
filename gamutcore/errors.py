"""The errors of the compute package: a small hierarchy with stable codes.

Every error has a message (what is wrong), `where` (field, line, column, tag, row, ...) and a remedy
(what is accepted). The codes are part of the public interface: clients and the service's problem
types refer to them, so a released code never changes its meaning.
"""

from __future__ import annotations

from typing import ClassVar

__all__ = [
    "BoundaryError",
    "CentreError",
    "CharacterisationError",
    "ConditionError",
    "DecimationError",
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
    """Base of all errors that `gamutcore` raises on purpose.

    Parameters
    ----------
    message : str
        What is wrong, in one sentence, with the rejected values.
    where : dict, optional
        Location of the fault: JSON-able values under keys such as ``field``, ``line``, ``column``,
        ``tag``, ``row``.
    remedy : str
        What is accepted instead, as a sentence.

    Notes
    -----
    ``str(error)`` is the message and the remedy; the attributes have each alone.
    """

    code: ClassVar[str] = "gamut-error"

    def __init__(self, message: str, *, where: Where | None = None, remedy: str) -> None:
        super().__init__(message)
        self.message = message
        self.where: Where = dict(where or {})
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{_ended(self.message)} {self.remedy}".rstrip()

    def __reduce__(self) -> tuple[object, ...]:
        # a build runs in a worker process, and its parent reports the error: errors are pickled
        return (_error_of, (type(self), self.message, self.where, self.remedy))


def _ended(text: str) -> str:
    """Return a text with a full stop, unless it already ends a sentence."""
    return text if text.endswith((".", "?", "!")) else f"{text}."


def _error_of(kind: type[GamutError], message: str, where: Where, remedy: str) -> GamutError:
    return kind(message, where=where, remedy=remedy)


class OptionError(GamutError):
    """An option has a value that is not accepted; ``where["field"]`` names it."""

    code = "invalid-option"

    @classmethod
    def refusal(cls, name: str, value: object, accepted: str) -> OptionError:
        """Return the error for a value that an option does not accept.

        Parameters
        ----------
        name : str
        value : object
            Shown in the message up to `LONGEST_SHOWN` characters.
        accepted : str
            The accepted values, as an object of "Give".

        Returns
        -------
        OptionError

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

        Parameters
        ----------
        name : str
        value : object
        why : str
            The reason, without a full stop.
        remedy : str, optional

        Returns
        -------
        OptionError
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
    shown = "null" if value is None else repr(value)  # as in JSON
    return shown if len(shown) <= LONGEST_SHOWN else f"{shown[:LONGEST_SHOWN]}…"


class CharacterisationError(GamutError):
    """Base of the errors in characterisation data."""

    code = "invalid-characterisation"


class UnrecognisedFormatError(CharacterisationError):
    """The content is in none of the supported formats."""

    code = "unrecognised-format"


class MalformedFileError(CharacterisationError):
    """A text, JSON or NumPy file breaks its format; ``where`` has line and column if known."""

    code = "malformed-file"


class MissingColumnError(CharacterisationError):
    """The columns have no complete colour, or an unknown name."""

    code = "missing-column"


class ConditionError(CharacterisationError):
    """The data has several measurement conditions, or not the requested one.

    ``where["field"]`` is the option ``condition``; ``where["conditions"]`` lists the conditions.
    """

    code = "measurement-condition"


class SampleLimitError(CharacterisationError):
    """The data has more samples, columns or channels than are accepted."""

    code = "too-many-samples"


class MalformedProfileError(CharacterisationError):
    """An ICC profile breaks the specification; ``where["tag"]`` names the tag."""

    code = "malformed-profile"


class UnsupportedProfileError(CharacterisationError):
    """An ICC profile is well formed but of an unsupported kind."""

    code = "unsupported-profile"


class PictureSizeError(CharacterisationError):
    """A picture has more pixels than are accepted."""

    code = "picture-too-large"


class PictureWorkError(CharacterisationError):
    """A picture takes more time to decode than its number of pixels allows."""

    code = "picture-too-complex"


class UnsupportedPictureError(CharacterisationError):
    """A picture is well formed but of an unsupported kind, or its colours are unknown."""

    code = "unsupported-picture"


class ReferenceNameError(CharacterisationError):
    """There is no reference gamut of this name; the remedy names a near match."""

    code = "unknown-reference"


class InvalidPointsError(GamutError):
    """Points have the wrong shape, or coordinates that are not finite."""

    code = "invalid-points"


class TooFewPointsError(InvalidPointsError):
    """Fewer than four distinct points enclose no volume."""

    code = "too-few-points"


class FlatPointsError(InvalidPointsError):
    """All points lie nearly in one plane or on one line."""

    code = "flat-points"


class CentreError(InvalidPointsError):
    """The centre is not strictly inside the points' convex hull."""

    code = "centre-outside"


class BoundaryError(GamutError):
    """No closed surface that is star-shaped about the centre exists for the points."""

    code = "boundary-failed"


class MeshError(GamutError):
    """A triangle mesh lacks a required property (closed, oriented, genus 0, star-shaped)."""

    code = "invalid-mesh"


class DecimationError(GamutError):
    """No edge can be collapsed validly although more than four triangles are left."""

    code = "decimation-stalled"


class NeighbourLimitError(GamutError):
    """Vertices have so many neighbours that the history would be slow to read."""

    code = "too-many-neighbours"


class TriangleCountError(GamutError):
    """The history has no level with the requested number of triangles."""

    code = "triangle-count"


class HistoryFileError(GamutError):
    """A history file is damaged, has another version, or is not a history."""

    code = "malformed-history"
