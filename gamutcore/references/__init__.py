"""Reference gamuts: RGB spaces, Pointer's gamut and the optimal colours, by slug.

`REFERENCES` is the catalogue. A reference is built from its definition, a small JSON document, as
any gamut is built from its data. `gamutcore.reference` builds one by name. The colours are computed
in `gamutcore.colours.reference`. See ``docs/decisions/references.md``.

The primaries, whites and transfer curves of the RGB spaces are in ``rgb_spaces.json``, taken from
colour-science. They are copied because a definition is a part of a gamut's id, and because the
service lists them without importing colour-science.

The curves of BT.709, BT.2020 and NTSC there are no curves of displays. The member ``display`` has
the exponent of the display (ITU-R BT.1886, annex 1, with a black of 0; BT.470-6, table 1, as
ITU-T H.273, table 3, transfer 4). All device values are for displays. The samples of a gamut lie by
the curve of the definition, so that its shape does not depend on the display.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.resources import files
from types import MappingProxyType
from typing import Any, Literal

from gamutcore.errors import MalformedFileError, ReferenceNameError
from gamutcore.names import EXACT, folded, print_condition, ranked, similarity

__all__ = [
    "DECODINGS",
    "NOT_OFFERED",
    "REFERENCES",
    "USUAL",
    "Reference",
    "find_reference",
    "parse_definition",
    "search_references",
    "stated_name",
]

_LONGEST = 4096
"""Largest number of characters of a definition; the catalogue's have a few hundred."""

_RGB_SOURCE = "colour-science 0.4.7, colour.RGB_COLOURSPACES[{!r}]"
_OPTIMAL_SOURCE = (
    "CIE 15:2018, tables of the illuminant and the observer, 360 to 780 nm by 1 nm; optimal "
    "colours after D. L. MacAdam, JOSA 25 (1935)"
)
_BT2100_SOURCE = "ITU-R BT.2100-2, tables 2, 4 and 5; white level of ITU-R BT.2408-7, 2.2"

DECODINGS: Mapping[str, str | float] = MappingProxyType(
    {
        "bt1886": 2.4,  # ITU-R BT.1886, annex 1: L = Lw V^2.4 for a black of 0
        "oetf": "BT709",  # the inverse of the curve of cameras: ITU-R BT.709-6, 1.2
        "pq": "PQ",
        "hlg": "HLG",
        "srgb": "sRGB",
    }
)
"""Curves from code values to light by name: keys of `gamutcore.colours.RGB_CURVES`, exponents, or
``"PQ"`` and ``"HLG"`` (ITU-R BT.2100)."""

_CAMERA_CURVES = frozenset({"BT709", "SMPTE240M"})
_PEAKS = {"PQ": 10_000.0, "HLG": 1000.0}
_CURVE_NAMES = {
    2.4: "BT.1886",
    1.0: "linear light",
    "BT709": "inverse OETF",
    "SMPTE240M": "SMPTE 240M",  # its reference reproducer has the inverse of the curve of cameras
    "ROMM": "ROMM RGB",
}

_OPTIMAL_WHITES: dict[tuple[str, Literal[2, 10]], tuple[float, float]] = {
    ("D50", 2): (0.34567, 0.35851),
    ("D50", 10): (0.34773, 0.35952),
    ("D65", 2): (0.31272, 0.32903),
    ("D65", 10): (0.31382, 0.33100),
    ("A", 2): (0.44758, 0.40745),
    ("A", 10): (0.45117, 0.40594),
}
"""Chromaticities of the perfect diffuser (CIE 15:2018, table T.3)."""


@dataclass(frozen=True, eq=False)
class Reference:
    """A reference gamut.

    Attributes
    ----------
    slug, name : str
        Name in addresses (lower-case letters, digits and hyphens), and name for people.
    kind : str
        ``"rgb"``, ``"optimal"`` or ``"surface"``.
    definition : dict
        Definition of the colours; JSON-able.
    white : tuple of two float
        Chromaticity x, y of the white, which `illuminant` names.
    observer : int
        Field of view of the standard observer, in degrees.
    source : str
        Source of the numbers.
    primaries : tuple of three pairs of float
        Chromaticities x, y of red, green and blue; empty for other kinds.
    aliases : tuple of str
        Further names.
    display : float, optional
        Exponent by which displays decode values if the curve of `definition` is another.
    """

    slug: str
    name: str
    kind: Literal["rgb", "surface", "optimal"]
    definition: Mapping[str, Any]
    white: tuple[float, float]
    illuminant: str
    observer: Literal[2, 10]
    source: str
    primaries: tuple[tuple[float, float], ...] = ()
    aliases: tuple[str, ...] = ()
    display: float | None = None

    @property
    def decoding(self) -> str:
        """Name of the curve from values to light."""
        curve = self.definition["curve"]
        return _CURVE_NAMES.get(curve, curve if isinstance(curve, str) else f"gamma {curve:g}")

    def with_decoding(self, decode: str | None = None) -> Reference:
        """Return this RGB space with a curve of `DECODINGS`, by default with that of displays.

        The name states the curve if it is not that of the definition.
        """
        own_curve = self.definition["curve"]
        if decode is None:
            curve = own_curve if self.display is None else self.display
        elif decode == "oetf" and own_curve in _CAMERA_CURVES:
            curve = own_curve
        else:
            curve = DECODINGS[decode]
        if curve == own_curve and decode is None:
            return self
        peak = _PEAKS.get(str(curve))
        if self.peak is not None and curve == own_curve:
            peak = self.peak
        definition = {key: self.definition[key] for key in self.definition if key != "peak"}
        definition |= {"curve": curve} | ({} if peak is None else {"peak": peak})
        reference = replace(self, definition=definition, display=None)
        return (
            reference
            if curve == own_curve
            else replace(reference, name=f"{self.name}, {reference.decoding}")
        )

    @property
    def peak(self) -> float | None:
        """Peak luminance in cd/m²; None for gamuts relative to their white."""
        return self.definition.get("peak")

    @cached_property
    def data(self) -> bytes:
        """The definition as input of `gamutcore.Gamut`: canonical JSON."""
        return json.dumps(
            {"reference": self.slug, **self.definition}, sort_keys=True, separators=(",", ":")
        ).encode()

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of `data`, hexadecimal: the digest in the gamut's id."""
        return hashlib.sha256(self.data).hexdigest()


_RGB_ROWS: list[dict[str, Any]] = json.loads(
    files("gamutcore.references").joinpath("rgb_spaces.json").read_text("utf-8")
)

NOT_OFFERED: Mapping[str, str] = MappingProxyType(
    {row["name"]: row["not_offered"] for row in _RGB_ROWS if "not_offered" in row}
)
"""RGB spaces of colour-science that have no gamut in CIELAB, with the reason."""


def _rgb_space(row: dict[str, Any], source: str) -> Reference:
    members = ("primaries", "white", "curve", "peak")
    return Reference(
        slug=row["slug"],
        name=row["name"],
        kind="rgb",
        definition={name: row[name] for name in members if name in row},
        white=tuple(row["white"]),
        illuminant=row["illuminant"],
        observer=2,
        source=source,
        primaries=tuple(map(tuple, row["primaries"])),
        aliases=tuple(row.get("aliases", ())),
        display=row.get("display"),
    )


def _bt2100(curve: str, peak: int) -> Reference:
    own = {
        "slug": f"bt2100-{curve.lower()}-{peak}",
        "name": f"ITU-R BT.2100 {curve}, {peak:,} cd/m²",
        "curve": curve,
        "peak": float(peak),
        "aliases": (f"BT.2100 {curve}", f"Rec.2100 {curve} {peak}"),
    }
    bt2020 = next(row for row in _RGB_ROWS if row["slug"] == "bt2020")
    return _rgb_space(bt2020 | own | {"display": None}, _BT2100_SOURCE)


def _optimal_colours(illuminant: str, observer: Literal[2, 10]) -> Reference:
    return Reference(
        slug=f"optimal-colours-{illuminant.lower()}-{observer}",
        name=f"Optimal colours, {illuminant}, {observer}°",
        kind="optimal",
        definition={"illuminant": illuminant, "observer": observer, "wavelengths": [360, 780, 1]},
        white=_OPTIMAL_WHITES[illuminant, observer],
        illuminant=illuminant,
        observer=observer,
        source=_OPTIMAL_SOURCE,
    )


_POINTER = Reference(
    slug="pointer",
    name="Pointer's gamut",
    kind="surface",
    definition={"illuminant": "C", "observer": 2, "colours": "Pointer 1980"},
    white=(0.31006, 0.31616),  # CIE 15:2018, table T.3
    illuminant="C",
    observer=2,
    source=(
        "M. R. Pointer, The gamut of real surface colours, Color Research & Application 5 (1980), "
        "table II; colour-science, DATA_POINTER_GAMUT_VOLUME"
    ),
    aliases=("Pointer gamut", "real surface colours"),
)

REFERENCES: Mapping[str, Reference] = MappingProxyType(
    {
        each.slug: each
        for each in (
            *(
                _rgb_space(row, _RGB_SOURCE.format(row["name"]))
                for row in _RGB_ROWS
                if row["name"] not in NOT_OFFERED
            ),
            *(_bt2100("PQ", peak) for peak in (1000, 4000, 10_000)),
            _bt2100("HLG", 1000),
            _POINTER,
            *(_optimal_colours(*key) for key in _OPTIMAL_WHITES),
        )
    }
)
"""All reference gamuts by slug."""


USUAL = ("srgb", "display-p3", "bt2020", "adobe-rgb-1998", "prophoto-rgb", "bt709", "dci-p3")
"""References that people usually mean; they come first among equally likely ones."""

_NAMES = [
    (reference, (reference.slug, reference.name, *reference.aliases))
    for reference in (*(REFERENCES[slug] for slug in USUAL), *REFERENCES.values())
]

_BY_NAME = {folded(name): reference for reference, names in _NAMES for name in names[:2]}
"""References by slug and name, which are unique."""

_SUGGESTED = 4
"""Most candidates in an error."""


def search_references(name: str) -> list[Reference]:
    """Return the reference gamuts that a name may mean, the most likely first.

    The name is an everyday one, such as ``"Rec. 709"`` or ``"adobe"``, or a part of a name.

    Examples
    --------
    >>> [reference.slug for reference in search_references("P3")][:2]
    ['display-p3', 'dci-p3']
    """
    return list(dict.fromkeys(ranked(name, _NAMES)))


def find_reference(name: str) -> Reference:
    """Return the reference gamut of a slug or name.

    An alias counts if only one reference has it. Letter case, spaces and punctuation do not matter,
    and "Rec." and "BT." are the same.

    Raises
    ------
    ReferenceNameError
        There is no such reference, or several have the name; the remedy names the candidates.

    Examples
    --------
    >>> find_reference("Rec2020").slug
    'bt2020'
    """
    reference = _BY_NAME.get(folded(name))
    if reference is not None:
        return reference
    called = {
        candidate.slug: candidate
        for candidate, names in _NAMES
        if any(similarity(name, other) == EXACT for other in names)
    }
    if len(called) == 1:
        return next(iter(called.values()))
    for space, reason in NOT_OFFERED.items():
        if folded(space) == folded(name):
            raise ReferenceNameError(
                f"{space} has no gamut. {reason}",
                where={"field": "reference"},
                remedy="Give another RGB space.",
            )
    raise ReferenceNameError(
        f"{len(called)} reference gamuts are called {name[:40]!r}."
        if called
        else f"There is no reference gamut {name[:40]!r}.",
        where={"field": "reference"},
        remedy=_remedy(name),
    )


def _remedy(name: str) -> str:
    """Return what to give instead of an unknown or ambiguous name, as a sentence."""
    condition = print_condition(name)
    if condition:
        return (
            f"{' or '.join(condition)} is a print condition; build its gamut from its "
            "characterisation data or its profile."
        )
    slugs = [reference.slug for reference in search_references(name)[:_SUGGESTED]]
    if not slugs:
        return "Give a slug such as srgb or display-p3."
    *others, last = slugs
    return f"Did you mean {', '.join(others)} or {last}?" if others else f"Did you mean {last}?"


def parse_definition(text: str) -> Reference | None:
    """Return the reference gamut that a JSON document defines; None if it defines none.

    The text is an object with the member ``reference``, a slug or name. It may have the definition
    of that reference as further members, as in `Reference.data`.

    Raises
    ------
    ReferenceNameError
        No reference has this name.
    MalformedFileError
        The definition differs from that of the reference.
    """
    if len(text) > _LONGEST or '"reference"' not in text:
        return None
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(document, dict) or "samples" in document:
        return None
    name = document.pop("reference", None)
    if not isinstance(name, str):
        return None
    reference = find_reference(name)
    if document and document != reference.definition:
        raise MalformedFileError(
            f"The definition is not that of {reference.slug}.",
            where={"field": "reference"},
            remedy=f'Send {{"reference": "{reference.slug}"}} alone.',
        )
    return reference


DESCRIPTORS = ("DESCRIPTOR", "DESCRIPTION", "FILE_DESCRIPTOR")
"""Keywords of characterisation data that describe it, in order."""


def stated_name(description: Mapping[str, Any]) -> str:
    """Return the name that the description of a gamut states, for people; empty if it has none."""
    provenance = description.get("provenance", {})
    if provenance.get("format") == "reference":
        reference = REFERENCES.get(provenance["reference"])
        return str(provenance["reference"]) if reference is None else reference.name
    conditions = provenance.get("conditions", {})
    texts = [*(conditions.get(keyword) for keyword in DESCRIPTORS), provenance.get("description")]
    return next((" ".join(text.split()) for text in texts if isinstance(text, str) and text), "")
