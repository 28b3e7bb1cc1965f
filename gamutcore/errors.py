"""The errors of the compute package: a small hierarchy with stable codes.

Every error says what was wrong (the message), where (`where`: a field, line, column, tag, row, ...)
and what would be right (`remedy`). The codes are part of the public interface: clients and the
service's table of HTTP problems refer to them, so a code, once released, never changes its meaning.
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
    "SampleLimitError",
    "TooFewPointsError",
    "TriangleCountError",
    "UnrecognisedFormatError",
    "UnsupportedPictureError",
    "UnsupportedProfileError",
]

LONGEST_SHOWN = 60
"""Characters of a wrong value that a message repeats."""

Where = dict[str, str | int | float | list[str]]


class GamutError(Exception):
    """Base of all errors that `gamutcore` raises on purpose.

    Parameters
    ----------
    message : str
        What was wrong, in one sentence, with the values at fault.
    where : dict, optional
        Where it was wrong: JSON-able values under keys such as ``field``, ``line``, ``column``,
        ``tag``, ``row``.
    remedy : str, optional
        What would be right.
    """

    code: ClassVar[str] = "gamut-error"

    def __init__(self, message: str, *, where: Where | None = None, remedy: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.where: Where = dict(where or {})
        self.remedy = remedy

    def __reduce__(self) -> tuple[object, ...]:
        # errors cross process borders: a build runs in a worker, its parent reports the error
        return (_rebuilt, (type(self), self.message, self.where, self.remedy))


def _rebuilt(kind: type[GamutError], message: str, where: Where, remedy: str) -> GamutError:
    return kind(message, where=where, remedy=remedy)


class OptionError(GamutError):
    """An option has a value that is not accepted; ``where["field"]`` names it."""

    code = "invalid-option"

    @classmethod
    def refusal(cls, name: str, value: object, accepted: str) -> OptionError:
        """Return the error for an option's value, which is shown if it is short.

        Parameters
        ----------
        name : str
        value : object
        accepted : str
            What would be right, as what "Give" is followed by.

        Returns
        -------
        OptionError
        """
        message = f"{name} is {_shown(value)}, which is not accepted."
        return cls(message, where={"field": name}, remedy=f"Give {accepted}.")

    @classmethod
    def not_applicable(
        cls, name: str, value: object, why: str, remedy: str = "Leave it out."
    ) -> OptionError:
        """Return the error for an option that the data, or another option, leaves no place for.

        Parameters
        ----------
        name : str
        value : object
        why : str
            What keeps it from applying, without a full stop.
        remedy : str, optional
            What would be right.

        Returns
        -------
        OptionError
        """
        message = f"{name} {_shown(value)} does not apply: {why}."
        return cls(message, where={"field": name}, remedy=remedy)


def _shown(value: object) -> str:
    shown = "null" if value is None else repr(value)  # as it was written in JSON
    return shown if len(shown) <= LONGEST_SHOWN else f"{shown[:LONGEST_SHOWN]}…"


class CharacterisationError(GamutError):
    """Base of what can be wrong with characterisation data."""

    code = "invalid-characterisation"


class UnrecognisedFormatError(CharacterisationError):
    """The content is of none of the formats that are read."""

    code = "unrecognised-format"


class MalformedFileError(CharacterisationError):
    """A text, JSON or NumPy file breaks its format; ``where`` has line and column where known."""

    code = "malformed-file"


class MissingColumnError(CharacterisationError):
    """The columns do not hold a colour, or name something unknown."""

    code = "missing-column"


class ConditionError(CharacterisationError):
    """The data was measured under several conditions, or not under the one that is asked for.

    ``where["field"]`` is the option ``condition``, ``where["conditions"]`` what the data has.
    """

    code = "measurement-condition"


class SampleLimitError(CharacterisationError):
    """More samples, columns or channels than are accepted."""

    code = "too-many-samples"


class MalformedProfileError(CharacterisationError):
    """An ICC profile breaks the specification; ``where["tag"]`` names the tag."""

    code = "malformed-profile"


class UnsupportedProfileError(CharacterisationError):
    """An ICC profile is well formed but of a kind that is not evaluated."""

    code = "unsupported-profile"


class PictureSizeError(CharacterisationError):
    """A picture has more pixels than are decoded."""

    code = "picture-too-large"


class UnsupportedPictureError(CharacterisationError):
    """A picture is well formed but of a kind that is not read, or its colours are not known."""

    code = "unsupported-picture"


class InvalidPointsError(GamutError):
    """Points of the wrong shape, or with values that are not finite numbers."""

    code = "invalid-points"


class TooFewPointsError(InvalidPointsError):
    """Fewer than four distinct points: no volume can be wrapped around them."""

    code = "too-few-points"


class FlatPointsError(InvalidPointsError):
    """All points lie (nearly) in one plane or on one line."""

    code = "flat-points"


class CentreError(InvalidPointsError):
    """The centre is not strictly inside the points' convex hull."""

    code = "centre-outside"


class BoundaryError(GamutError):
    """No closed surface that is star-shaped about the centre could be wrapped around the points."""

    code = "boundary-failed"


class MeshError(GamutError):
    """A triangle mesh is not what the operation needs (closed, oriented, genus 0, star-shaped)."""

    code = "invalid-mesh"


class DecimationError(GamutError):
    """No edge of the mesh can be collapsed validly although more than four triangles are left."""

    code = "decimation-stalled"


class NeighbourLimitError(GamutError):
    """Vertices of a mesh have so many neighbours that its history would take too long to read."""

    code = "too-many-neighbours"


class TriangleCountError(GamutError):
    """A level was asked for that the history does not have."""

    code = "triangle-count"


class HistoryFileError(GamutError):
    """A history file is damaged, of another version, or not a history at all."""

    code = "malformed-history"
