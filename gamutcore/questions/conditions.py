"""Conditions of a gamut: what its colours are relative to, as every answer states it.

Also warnings of the builds, which answers pass on, and for answers that are right for another
question: colours as measured that meet a gamut
relative to its paper, and comparisons of gamuts with different conditions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.colours import INTENTS, xyz_to_lab
from gamutcore.number_text import number_text
from gamutcore.results import AS_GIVEN, Conditions

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.colours import DeviceModel
    from gamutcore.options import Options

__all__ = [
    "build_warnings",
    "colour_warnings",
    "comparison_warnings",
    "condition_lines",
    "conditions_of",
    "no_limit_warnings",
    "size_warnings",
    "table_warnings",
]

VIEWING = ("luminance", "adapting_luminance", "background", "surround")
"""Parameters of a space that describe how its colours are seen."""

WHITE_LAB = (100.0, 0.0, 0.0)

MEASUREMENT = {
    "illuminant": "illuminant",
    "observer": "observer",
    "measurement_condition": "measurement condition",
}
"""What measurements state, and how it is called."""

MOST_NAMES = 3
"""Most names of gamuts in a list that stands for a condition."""

SAME_WHITE = 0.5
"""ΔE*ab up to which two whites count as one: below the spread of measurements of one paper."""


def conditions_of(description: Mapping[str, Any]) -> Conditions:
    """Return the conditions that the description of a gamut states."""
    provenance, options = description.get("provenance", {}), description["options"]
    space, limits = provenance.get("colour_space", {}), provenance.get("ink_limits", {})
    intent, white = provenance.get("intent"), provenance.get("white_lab")
    return Conditions(
        intent=intent if intent in INTENTS else AS_GIVEN,
        ink_limit=limits.get("total"),
        black_limit=options.get("black_limit"),
        white=str(space.get("reference_white", AS_GIVEN)),
        white_xyz=tuple(space.get("reference_white_xyz", ())),
        space=str(options.get("space", "CIELAB")),
        viewing_conditions={name: space[name] for name in VIEWING if name in space},
        medium_white=None if white is None else tuple(white),
        illuminant=_stated(provenance.get("illuminant")),
        observer=_stated(provenance.get("observer")),
        measurement_condition=_stated(provenance.get("measurement_condition")),
        is_print=provenance.get("medium") == "reflective"
        or provenance.get("device_class") == "output",
        inks="ink_limits" in provenance,
        build_warnings=tuple(map(str, provenance.get("warnings", ()))),
        size_warnings=_few_patches(provenance),
    )


FEW_PATCHES = {3: 60, 4: 100}
"""Numbers of patches by channels below which the interval of the volume exceeds 3 %
(``docs/uncertainty.md``). Four channels are measured. Three are an estimate, as are more than four:
half as many again for each."""


def _few_patches(provenance: Mapping[str, Any]) -> tuple[str, ...]:
    """Return a warning about the volume of a device with few patches."""
    channels = len(provenance.get("channels") or ())
    used = provenance.get("patches", {}).get("used")
    model = str(provenance.get("model", {}).get("name", "none"))
    if used is None or channels < 3 or model.startswith("none"):
        return ()
    fewest = FEW_PATCHES.get(channels, round(FEW_PATCHES[4] * 1.5 ** (channels - 4)))
    if used >= fewest:
        return ()
    warning = (
        f"The volume rests on {used} patches of {channels} channels, and is uncertain by more than "
        f"3 %. Fewer than {fewest} patches are too few; --interval, or Gamut.uncertainty, gives "
        "the interval."
    )
    return (warning,)


def size_warnings(*gamuts: Conditions, names: tuple[str, ...] = ("A", "B")) -> tuple[str, ...]:
    """Return the warnings about the volumes of a gamut, or of two with their names."""
    if len(gamuts) == 1:
        return gamuts[0].size_warnings
    return tuple(
        f"{name}: {warning}"
        for name, gamut in zip(names, gamuts, strict=True)
        for warning in gamut.size_warnings
    )


def build_warnings(*gamuts: Conditions, names: tuple[str, ...] = ("A", "B")) -> tuple[str, ...]:
    """Return the warnings of the builds of one gamut, or of several with their names."""
    if len(gamuts) == 1:
        return gamuts[0].build_warnings
    return tuple(
        f"{name[:1].upper()}{name[1:]}: {warning}"
        for name, gamut in zip(names, gamuts, strict=True)
        for warning in gamut.build_warnings
    )


PRINTABLE = 300.0
"""Sum of inks in per cent that coated paper takes, and most presses."""


def no_limit_warnings(options: Options, model: DeviceModel) -> tuple[str, ...]:
    """Return a warning about a separation for a press whose sum of inks nothing limits."""
    if not model.inks or options.ink_limit is not None:
        return ()
    limited = model.limited
    if limited.cube.total is not None:
        return ()
    most = 100.0 * float(limited.cube.largest_sum + limited.base[~limited.free].sum())
    if most <= PRINTABLE + 0.5:
        return ()
    warning = (
        f"The data states no ink limit, and none is given: black has up to {most:.0f} % of ink. "
        f"Give that of the press, such as --ink-limit {PRINTABLE:.0f} for coated paper or 240 for "
        "newsprint; none is all inks in full, without this warning."
    )
    return (warning,)


def _paper_counts_as_white(conditions: Conditions) -> bool:
    """Whether a print is relative to a paper that differs from the white of the space."""
    return (
        conditions.is_print
        and conditions.intent == "relative"
        and conditions.medium_white is not None
        and _distance(conditions.medium_white, WHITE_LAB) > SAME_WHITE
    )


def _white_of_screens_is_outside(conditions: Conditions) -> bool:
    """Whether the white of sRGB colours, that of the space, is not the white of the medium.

    Only absolute colours keep another white. Those of lights are not adapted in other spaces than
    CIELAB with D50, so that their white is compared with that of the space.
    """
    if conditions.intent != "absolute" or conditions.medium_white is None:
        return False
    whites = [np.array(WHITE_LAB)]
    is_icc = conditions.space == "CIELAB" and conditions.white == "D50"
    if not (conditions.is_print or is_icc) and conditions.white_xyz:
        whites.append(xyz_to_lab(np.array(conditions.white_xyz)))
    return min(_distance(conditions.medium_white, tuple(white)) for white in whites) > SAME_WHITE


def colour_warnings(conditions: Conditions, space: str) -> tuple[str, ...]:
    """Return warnings about colours of no declared medium that meet a gamut.

    Parameters
    ----------
    conditions : Conditions
        Of the gamut.
    space : str
        Of the colours. Colours of sRGB are relative to the white of a screen. They fit a gamut
        relative to the white of its medium, as others fit an absolute one.
    """
    if space == "sRGB":
        if not _white_of_screens_is_outside(conditions):
            return ()
        assert conditions.medium_white is not None  # noqa: S101  # checked by the property
        medium = "paper" if conditions.is_print else "white"
        warning = (
            f"The gamut is absolute: its {medium} has L*a*b* {_lab(conditions.medium_white)}. "
            "White and light colours of sRGB (hex) are relative to the white of a screen, L*a*b* "
            "100 0 0, and count as outside: for such colours, build the gamut with the intent "
            'relative (--intent relative, or "intent": "relative").'
        )
        return (warning,)
    if not _paper_counts_as_white(conditions):
        return ()
    assert conditions.medium_white is not None  # noqa: S101  # checked by the property
    warning = (
        f"The gamut is relative to its paper, whose L*a*b* {_lab(conditions.medium_white)} counts "
        "as white: for colours as measured, build it with the intent absolute "
        '(--intent absolute, or "intent": "absolute").'
    )
    return (warning,)


def comparison_warnings(
    one: Conditions, two: Conditions, names: tuple[str, str] = ("A", "B")
) -> tuple[str, ...]:
    """Return reasons why figures about two gamuts, by their names, may mislead."""
    warnings = []
    a, b = names
    if AS_GIVEN in {one.intent, two.intent}:
        if _paper_counts_as_white(one) or _paper_counts_as_white(two):
            first, other = (a, b) if one.intent == AS_GIVEN else (b, a)
            warnings.append(
                f"The colours of {first} are as given, and {other} is relative to its paper. Build "
                f"{other} with the intent absolute if the colours of {first} are as measured."
            )
    elif one.intent != two.intent:
        warnings.append(
            f"The intents differ: {a} has the intent {one.intent}, {b} has {two.intent}. Their "
            "whites are not treated alike. Build both with the same intent."
        )
    elif one.intent == "absolute" and not (one.is_print and two.is_print):
        # papers are compared by this intent; lights keep a white that is not adapted
        whites = one.medium_white, two.medium_white
        if whites[0] and whites[1] and _distance(whites[0], whites[1]) > SAME_WHITE:
            warnings.append(
                f"The whites differ: L*a*b* {_lab(whites[0])} of {a}, {_lab(whites[1])} of {b}, "
                "relative to D50. Absolute colours are not adapted from one to the other; the "
                "intent relative compares each with its own white."
            )
    if one.is_print and two.is_print:
        for name, words in MEASUREMENT.items():
            first, second = getattr(one, name), getattr(two, name)
            if first and second and first != second:
                warnings.append(
                    f"The colours of {a} are for the {words} {first}, those of {b} for {second}."
                )
    return tuple(warnings)


def table_warnings(gamuts: Mapping[str, Conditions], space: str | None = None) -> tuple[str, ...]:
    """Return reasons why a table of many gamuts may mislead, each once for the whole table.

    `space` is that of the colours that meet the gamuts; None if there are none.
    """
    warnings = [
        f"{_names(names)}: {warning}"
        for warning, names in _groups(gamuts, "build_warnings").items()
    ]
    papers = [name for name, each in gamuts.items() if _paper_counts_as_white(each)]
    if space == "sRGB":
        absolute = [name for name, each in gamuts.items() if _white_of_screens_is_outside(each)]
        if absolute:
            warnings.append(
                f"The whites of absolute gamuts are their own ({_names(absolute)}). White and "
                "light colours of sRGB (hex) count as outside: for such colours, build gamuts with "
                "the intent relative."
            )
    elif space is not None and papers:
        warnings.append(
            f"The paper counts as white in gamuts with the intent relative ({_names(papers)}): for "
            "colours as measured, build them with the intent absolute."
        )
    relative = [
        name for name, each in gamuts.items() if each.is_print and each.intent == "relative"
    ]
    if space is None and len(relative) > 1:
        warnings.append(
            f"Gamuts are media-relative, so each paper counts as white ({_names(relative)}). Build "
            "them with the intent absolute to compare the papers as well."
        )
    return (*warnings, *_differences(gamuts, papers))


def _differences(gamuts: Mapping[str, Conditions], papers: Sequence[str]) -> list[str]:
    """Return a sentence for each condition in which gamuts differ."""
    warnings = []
    intents = _groups(gamuts, "intent")
    if AS_GIVEN in intents and not papers:
        del intents[AS_GIVEN]
    if len(intents) > 1:
        warnings.append(
            f"The intents differ: {_listed(intents)}. Whites are not treated alike. Build all with "
            "the same intent."
        )
    absolute = {name: each for name, each in gamuts.items() if each.intent == "absolute"}
    whites = {
        name: each.medium_white for name, each in absolute.items() if each.medium_white is not None
    }
    lights = [name for name in whites if not absolute[name].is_print]
    apart = [
        name
        for name, white in whites.items()
        if any(_distance(white, whites[light]) > SAME_WHITE for light in lights)
    ]
    if apart:
        shown = ", ".join(f"{_lab(whites[name])} of {name}" for name in apart[:MOST_NAMES])
        more = f" and {len(apart) - MOST_NAMES} more" if len(apart) > MOST_NAMES else ""
        warnings.append(
            f"The whites differ: L*a*b* {shown}{more}, relative to D50. Absolute colours are not "
            "adapted; the intent relative compares each with its own white."
        )
    prints = {name: each for name, each in gamuts.items() if each.is_print}
    for attribute, words in MEASUREMENT.items():
        stated = _groups(prints, attribute)
        if len(stated) > 1:
            warnings.append(f"The prints are for different {words}s: {_listed(stated)}.")
    return warnings


def condition_lines(gamuts: Mapping[str, Conditions]) -> dict[str, str]:
    """Return the conditions of many gamuts, each once, with the names that it holds for."""
    lines = {
        "Intent": _groups(gamuts, "intent"),
        "White": _groups(gamuts, "white"),
        "Ink limit": _groups(gamuts, "ink_limit"),
        "Illuminant": _groups(gamuts, "illuminant"),
        "Observer": _groups(gamuts, "observer"),
        "Measurement": _groups(gamuts, "measurement_condition"),
        "Space": _groups(gamuts, "space"),
    }
    return {
        title: next(iter(groups))
        if len(groups) == 1 and len(next(iter(groups.values()))) == len(gamuts)
        else _listed(groups)
        for title, groups in lines.items()
        if groups
    }


def _groups(gamuts: Mapping[str, Conditions], attribute: str) -> dict[str, list[str]]:
    """Return the names of the gamuts by the values that they state, in the order of the gamuts."""
    groups: dict[str, list[str]] = {}
    for name, conditions in gamuts.items():
        stated = getattr(conditions, attribute)
        for value in stated if isinstance(stated, tuple) else (stated,):
            if value not in {"", None}:
                text = f"{value:g} %" if isinstance(value, float) else str(value)
                groups.setdefault(text, []).append(name)
    return groups


def _listed(groups: Mapping[str, Sequence[str]]) -> str:
    return "; ".join(f"{value} ({_names(names)})" for value, names in groups.items())


def _names(names: Sequence[str]) -> str:
    if len(names) <= MOST_NAMES + 1:
        return ", ".join(names)
    return f"{', '.join(names[:MOST_NAMES])} and {len(names) - MOST_NAMES} more"


def _stated(text: object) -> str:
    """Return an illuminant or observer without notes such as "(assumed, not stated)"."""
    words = str(text or "")
    return "" if words.startswith(("none", "as stated")) else words.partition(" (")[0]


def _distance(one: tuple[float, ...], two: tuple[float, ...]) -> float:
    return float(np.linalg.norm(np.subtract(one, two)))


def _lab(white: tuple[float, ...]) -> str:
    return " ".join(number_text(value, 4) for value in white)
