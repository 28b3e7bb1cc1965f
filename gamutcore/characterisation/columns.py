"""What the columns of a table of samples are, told from their names.

Device values are named as CGATS.17 has it, by the set of inks or lights and the one that is meant
(`CMYK_C`, `RGB_R`, `7CLR_3`, `CMYKOGV_O`); colours as `LAB_L LAB_A LAB_B` and `XYZ_X XYZ_Y XYZ_Z`.
Plain letters in their usual order (`R G B`, `L a b`, `L* a* b*`) are understood too, because that
is what spreadsheets and scripts write.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gamutcore.errors import MissingColumnError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.errors import Where

__all__ = ["MAX_CHANNELS", "MAX_COLUMNS", "ColumnRoles", "column_roles"]

MAX_CHANNELS = 15
"""Channels of a device at most, as in ICC profiles (ICC.1:2022, 7.2.8: up to ``FCLR``)."""

MAX_COLUMNS = 2000
"""Columns of a table at most; a spectrum in steps of 1 nm takes 401."""

_LETTERS = re.compile(r"i?([CMYKORGBVWNcmykorgbvwn]{1,15})_([A-Za-z])")
_NUMBERED = re.compile(r"(\d{1,2})CLR_(\d{1,2})|PC(\d{1,2})_(\d{1,2})", re.IGNORECASE)
_GRAY = re.compile(r"GR[AE]Y(?:_\w+)?", re.IGNORECASE)
_SPECTRAL = re.compile(r"(?:SPEC|SPECTRAL|NM|SPECTRAL_NM|R)_?\d{3}", re.IGNORECASE)
_PLAIN = {
    ("C", "M", "Y", "K"): "CMYK",
    ("C", "M", "Y"): "CMY",
    ("R", "G", "B"): "RGB",
    ("X", "Y", "Z"): "XYZ",
    ("L", "A", "B"): "LAB",
    ("L*", "A*", "B*"): "LAB",
}


@dataclass(frozen=True)
class ColumnRoles:
    """Which columns hold device values and colours.

    Parameters
    ----------
    names : tuple of str
        All column names as found.
    channels : tuple of str
        Channel names of the device, empty for bare colours.
    device : tuple of int
        Columns of the device values, in the order of `channels`.
    lab, xyz : tuple of three int or None
        Columns of the colours.
    ignored : tuple of str
        Further sets of device columns, which are not used.
    """

    names: tuple[str, ...]
    channels: tuple[str, ...]
    device: tuple[int, ...]
    lab: tuple[int, ...] | None
    xyz: tuple[int, ...] | None
    ignored: tuple[str, ...] = ()

    @property
    def selected(self) -> tuple[int, ...]:
        """Columns to read: device values, then L* a* b*, then X Y Z."""
        return (*self.device, *(self.lab or ()), *(self.xyz or ()))

    @property
    def selected_names(self) -> tuple[str, ...]:
        """Names of the columns to read."""
        return tuple(self.names[column] for column in self.selected)

    @property
    def kinds(self) -> tuple[str, ...]:
        """``"device"``, ``"lab"`` or ``"xyz"`` for each column to read."""
        return (
            *(["device"] * len(self.device)),
            *(["lab"] * len(self.lab or ())),
            *(["xyz"] * len(self.xyz or ())),
        )


def column_roles(names: Sequence[str], *, where: Where | None = None) -> ColumnRoles:
    """Return which columns hold device values and colours.

    Parameters
    ----------
    names : sequence of str
        Column names, in order.
    where : dict, optional
        Where the names stand, for errors.

    Returns
    -------
    ColumnRoles

    Raises
    ------
    MissingColumnError
        There is no complete Lab or XYZ colour, a device channel is missing, or a column that is
        needed appears twice.
    SampleLimitError
        More than `MAX_COLUMNS` columns or `MAX_CHANNELS` channels.
    """
    place: Where = dict(where or {})
    if len(names) > MAX_COLUMNS:
        raise SampleLimitError(
            f"{len(names)} columns are more than the {MAX_COLUMNS} that are accepted.", where=place
        )
    cleaned = _spelt_out(tuple(name.strip() for name in names))
    lab = _colour_columns(cleaned, ("LAB_L", "LAB_A", "LAB_B"), place)
    xyz = _colour_columns(cleaned, ("XYZ_X", "XYZ_Y", "XYZ_Z"), place)
    if lab is None and xyz is None:
        raise _no_colour(cleaned, place)
    groups = _device_groups(cleaned)
    if not groups:
        return ColumnRoles(tuple(names), (), (), lab, xyz)
    prefix, members = next(iter(groups.items()))
    channels, device = _channels(prefix, members, place)
    return ColumnRoles(tuple(names), channels, device, lab, xyz, tuple(groups)[1:])


def _spelt_out(names: tuple[str, ...]) -> tuple[str, ...]:
    upper = tuple(name.upper() for name in names)
    spelt, index = list(names), 0
    while index < len(names):
        for letters, prefix in _PLAIN.items():
            if upper[index : index + len(letters)] == letters:
                for offset, letter in enumerate(letters):
                    spelt[index + offset] = f"{prefix}_{letter.rstrip('*')}"
                index += len(letters) - 1
                break
        index += 1
    return tuple(spelt)


def _colour_columns(
    names: tuple[str, ...], wanted: tuple[str, ...], where: Where
) -> tuple[int, ...] | None:
    found: dict[str, int] = {}
    for index, name in enumerate(names):
        upper = name.upper()
        if upper not in wanted:
            continue
        if upper in found:
            raise MissingColumnError(
                f"The column {name} appears twice.",
                where={**where, "column": name},
                remedy="Keep one set of colours, of one measurement condition.",
            )
        found[upper] = index
    if not found:
        return None
    missing = [name for name in wanted if name not in found]
    if missing:
        raise MissingColumnError(
            f"The column {missing[0]} is missing beside {', '.join(found)}.",
            where={**where, "column": missing[0], "columns": list(names)[:50]},
            remedy=f"Give all of {', '.join(wanted)}.",
        )
    return tuple(found[name] for name in wanted)


def _no_colour(names: tuple[str, ...], where: Where) -> MissingColumnError:
    remedy = "Give the columns LAB_L, LAB_A, LAB_B or XYZ_X, XYZ_Y, XYZ_Z."
    message = "No column holds a CIELAB or XYZ colour"
    if any(_SPECTRAL.fullmatch(name) for name in names):
        message += "; the spectra in the table are not read"
    return MissingColumnError(
        f"{message}. The columns are: {', '.join(names)[:300] or 'none'}.",
        where={**where, "columns": list(names)[:50]},
        remedy=remedy,
    )


def _device_groups(names: tuple[str, ...]) -> dict[str, dict[str, list[int]]]:
    groups: dict[str, dict[str, list[int]]] = {}
    for index, name in enumerate(names):
        numbered, letters = _NUMBERED.fullmatch(name), _LETTERS.fullmatch(name)
        if numbered:
            count, ink = numbered[1] or numbered[3], numbered[2] or numbered[4]
            prefix, channel = f"{int(count)}CLR", str(int(ink))
        elif letters and (channel := _letter_of(letters[1], letters[2])):
            prefix = letters[1].upper() if letters[1].islower() else letters[1]
        elif _GRAY.fullmatch(name):
            prefix, channel = "GRAY", "K" if name.upper().endswith("_K") else "W"
        else:
            continue
        groups.setdefault(prefix, {}).setdefault(channel, []).append(index)
    return groups


def _letter_of(letters: str, letter: str) -> str:
    # Light inks are told from full ones by case (CMYKcm_c); otherwise case means nothing.
    if letter in letters and not letters.islower():
        return letter
    return letter.upper() if letter.upper() in letters.upper() else ""


def _channels(
    prefix: str, members: dict[str, list[int]], where: Where
) -> tuple[tuple[str, ...], tuple[int, ...]]:
    if prefix.endswith("CLR"):
        count = int(prefix[:-3])
        if count > MAX_CHANNELS:
            raise SampleLimitError(
                f"{prefix} has more than {MAX_CHANNELS} channels.",
                where={**where, "column": prefix},
            )
        wanted = [str(ink) for ink in range(1, count + 1)]
    else:
        wanted = list(members) if prefix == "GRAY" else list(prefix)
        if not set(wanted) & set(members):
            wanted = [letter.upper() for letter in wanted]
    for channel in [*wanted, *members]:
        found = members.get(channel, [])
        if len(found) != 1 or channel not in wanted:
            problem = "is missing" if not found else "appears twice or is none of its channels"
            raise MissingColumnError(
                f"The device column {prefix}_{channel} {problem}.",
                where={**where, "column": f"{prefix}_{channel}"},
                remedy=f"Give each of {', '.join(f'{prefix}_{c}' for c in wanted)} once.",
            )
    return tuple(wanted), tuple(members[channel][0] for channel in wanted)
