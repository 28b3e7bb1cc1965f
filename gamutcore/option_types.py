"""Types of option values and declarations of options, as plain data.

An algorithm declares the type of its parameter next to its code, such as ``SUBDIVISIONS =
WholeNumber(0, 7)``, and checks an argument with `check_option`. `gamutcore.options` uses the same
types in its declarations, so each bound is written once. Request models and tables can be generated
from a declaration.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeAlias

from gamutcore.errors import OptionError
from gamutcore.names import folded, ranked

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = [
    "DATA_KINDS",
    "Choice",
    "Number",
    "Option",
    "OptionType",
    "Text",
    "Vector",
    "WholeNumber",
    "WholeNumbers",
    "accepted_values",
    "check_option",
    "finite_number",
    "near_match",
    "option_table",
]


def finite_number(value: object) -> float | None:
    """Return a number as a finite float, never -0.0.

    None stands for anything else, including booleans and text.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number + 0.0 if math.isfinite(number) else None


def near_match(name: str, names: Iterable[str]) -> str | None:
    """Return the name that a misspelled one most resembles; None if no name is similar."""
    return next(iter(ranked(name[:60], ((each, (each,)) for each in names))), None)


@dataclass(frozen=True)
class Choice:
    """One of some names, or of some whole numbers.

    Names are matched without regard to letter case, spaces and punctuation. `aliases` maps further
    spellings, in lower-case letters and digits, to values.
    """

    values: tuple[str, ...] | tuple[int, ...]
    aliases: Mapping[str, str] = field(default_factory=dict, hash=False)

    @property
    def accepted(self) -> str:
        """Accepted values in words, to follow "Give" in a message."""
        shown = [repr(value) if len(self.values) == 1 else str(value) for value in self.values]
        return shown[0] if len(shown) == 1 else f"one of {', '.join(shown)}"

    def canonical(self, value: object) -> str | int | None:
        """Return the value that is meant, or None."""
        if isinstance(value, str):
            folds = {folded(each): each for each in self.values if isinstance(each, str)}
            return {**self.aliases, **folds}.get(folded(value))
        number = finite_number(value)
        return next((each for each in self.values if each == number), None)


@dataclass(frozen=True)
class Number:
    """A finite number within bounds, which `above_least` and `below_most` exclude.

    Messages and tables state the unit; it is empty for a pure number.
    """

    least: float
    most: float
    above_least: bool = False
    below_most: bool = False
    unit: str = ""

    @property
    def accepted(self) -> str:
        """Accepted values in words, to follow "Give" in a message."""
        least, most = (f"{bound:.10g}" for bound in (self.least, self.most))
        if self.above_least:
            bounds = (
                f"above {least} and below {most}"
                if self.below_most
                else (f"above {least}, at most {most}")
            )
        else:
            bounds = f"from {least} to {most}"
        return f"a number {bounds}" + (f", in {self.unit}" if self.unit else "")

    def canonical(self, value: object) -> float | None:
        """Return the number as a float, or None."""
        number = finite_number(value)
        if number is None or not self.least <= number <= self.most:
            return None
        excluded = (self.above_least and number == self.least) or (
            self.below_most and number == self.most
        )
        return None if excluded else number


@dataclass(frozen=True)
class WholeNumber:
    """A whole number from `least` to `most`. Booleans and floats are refused."""

    least: int
    most: int

    @property
    def accepted(self) -> str:
        """Accepted values in words, to follow "Give" in a message."""
        return f"a whole number from {self.least} to {self.most}"

    def canonical(self, value: object) -> int | None:
        """Return the number, or None."""
        if isinstance(value, bool) or not isinstance(value, int):
            return None
        return value if self.least <= value <= self.most else None


@dataclass(frozen=True)
class WholeNumbers:
    """A fixed number of whole numbers, each with its own bounds.

    `meaning` names the numbers, such as ``"polar and azimuth segments"``.
    """

    parts: tuple[WholeNumber, ...]
    meaning: str

    @property
    def accepted(self) -> str:
        """Accepted values in words, to follow "Give" in a message."""
        least, most = ([getattr(part, end) for part in self.parts] for end in ("least", "most"))
        return f"{len(self.parts)} whole numbers ({self.meaning}), from {least} to {most}"

    def canonical(self, value: object) -> tuple[int, ...] | None:
        """Return the numbers as a tuple, or None."""
        if not isinstance(value, list | tuple) or len(value) != len(self.parts):
            return None
        numbers = [part.canonical(each) for part, each in zip(self.parts, value, strict=True)]
        found = tuple(number for number in numbers if number is not None)
        return found if len(found) == len(self.parts) else None


@dataclass(frozen=True)
class Vector:
    """Three finite numbers.

    `accepted` follows "Give" in a message. `normalise` maps the numbers to their canonical form, or
    to None if they are not accepted.
    """

    accepted: str = "three finite numbers"
    normalise: Callable[[float, float, float], tuple[float, float, float] | None] | None = None

    def canonical(self, value: object) -> tuple[float, float, float] | None:
        """Return the numbers as a tuple of floats, or None."""
        if not isinstance(value, list | tuple) or len(value) != 3:
            return None
        first, second, third = (finite_number(part) for part in value)
        if first is None or second is None or third is None:
            return None
        return self.normalise(first, second, third) if self.normalise else (first, second, third)


@dataclass(frozen=True)
class Text:
    """Printable text of 1 to `longest` characters.

    `accepted` follows "Give" in a message. `normalise` maps the text to its canonical form.
    """

    longest: int
    accepted: str
    normalise: Callable[[str], str]

    def canonical(self, value: object) -> str | None:
        """Return the canonical form of the text, or None."""
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            return None
        return self.normalise(value) if len(value) <= self.longest else None


OptionType: TypeAlias = Choice | Number | WholeNumber | WholeNumbers | Vector | Text
"""Any of the types above. An option may accept several of them."""


def accepted_values(types: Iterable[OptionType]) -> str:
    """Describe the values that some types accept, such as "'auto' or three finite numbers"."""
    return " or ".join(each.accepted for each in types)


DATA_KINDS: Mapping[str, str] = MappingProxyType(
    {
        "profile": "the data is an ICC profile",
        "measurements": "the data is measured device values",
        "colours": "the data is colours without device values",
        "picture": "the data is a picture",
        "mesh": "the data is a boundary already, and nothing is wrapped",
        "reference": "the data is a reference gamut",
    }
)
"""Kinds of characterisation data, each with the reason why an option may not apply."""


@dataclass(frozen=True)
class Option:
    """The declaration of one option.

    Attributes
    ----------
    types : tuple of OptionType
        A value must be of one of them.
    default : object
        None if the option has no default, or if the default depends on `selector`.
    description : str
        In plain sentences, for people.
    data : tuple of str
        The keys of `DATA_KINDS` that the option applies to.
    selector : str
        ``"boundary"`` or ``"space"`` if only some boundaries or spaces have the option; else empty.
    defaults : mapping of str to object
        The defaults for the values of `selector` that have the option.
    unless_given : str
        What happens without a value, for an option without a default.
    is_universal : bool
        Whether all values of `selector` have the option.
    common : bool
        Whether a newcomer needs to know the option.
    """

    name: str
    types: tuple[OptionType, ...]
    default: object
    description: str
    data: tuple[str, ...] = tuple(DATA_KINDS)
    selector: str = ""
    defaults: Mapping[str, object] = field(default_factory=dict)
    unless_given: str = ""
    is_universal: bool = True
    common: bool = False

    @property
    def accepted(self) -> str:
        """The accepted values in words."""
        return accepted_values(self.types)

    @property
    def default_text(self) -> str:
        """The default in words, in Markdown: ``"0.2 for `modified-convex-hull`, 0.05 for `usv`"``.

        Empty for an option without a default; `unless_given` describes that case.
        """
        if not self.selector:
            return "" if self.default is None else _text_of(self.default)
        users: dict[str, list[str]] = {}
        for user, default in self.defaults.items():
            users.setdefault(_text_of(default), []).append(f"`{user}`")
        if len(users) == 1 and self.is_universal:
            return next(iter(users))
        return "; ".join(f"{default} for {', '.join(names)}" for default, names in users.items())

    @property
    def documentation(self) -> str:
        """The description with the default and the data that the option applies to."""
        parts = [self.description]
        if self.selector and self.default_text:
            parts.append(f"Default: {self.default_text}.")
        if self.unless_given:
            parts.append(self.unless_given)
        if len(self.data) < len(DATA_KINDS):
            parts.append(f"Applies to: {', '.join(self.data)}.")
        return " ".join(parts)


def _text_of(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, tuple):
        return str(list(value))
    return f"`{value}`" if isinstance(value, str) else str(value)


def check_option(name: str, value: object, *types: OptionType) -> object:
    """Return the canonical form of an option's value, of the first type that accepts it.

    Without such a type, OptionError is raised; ``where["field"]`` is `name`.
    """
    for each in types:
        canonical = each.canonical(value)
        if canonical is not None:
            return canonical
    names = [str(choice) for each in types if isinstance(each, Choice) for choice in each.values]
    meant = near_match(value, names) if isinstance(value, str) else None
    error = OptionError.refusal(name, value, accepted_values(types))
    if meant is not None:
        error.remedy += f" Did you mean {meant!r}?"
    raise error


def option_table(options: Iterable[Option]) -> str:
    """Return a Markdown table of options: name, accepted values, default, description."""
    lines = ["| option | values | default | meaning |", "|---|---|---|---|"]
    for option in options:
        default = option.default_text or option.unless_given.removeprefix("Unless given: ")
        cells = (f"`{option.name}`", option.accepted, default.rstrip("."), option.description)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"
