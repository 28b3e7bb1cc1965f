"""The XML of a CxF3 file (ISO 17972-1) as the objects of colour-cxf, within bounds.

colour-cxf has the schema as data classes, and xsdata fills them. This module is what stands between
them and a hostile file: it drives Expat itself, refuses document type declarations (and with them
every kind of entity), deep nesting, and long attributes and texts before anything is built of
them, keeps the vendor's own sections away, and knows the line of every object.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, NoReturn
from xml.parsers import expat

from gamutcore.errors import MalformedFileError, SampleLimitError, UnrecognisedFormatError

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["CXF_NAMESPACE", "CxfDocument", "cxf_document", "looks_like_cxf", "looks_like_xml"]

CXF_NAMESPACE = "http://colorexchangeformat.com/CxF3-core"

MAX_ELEMENTS = 400_000
"""Elements at most, those that are passed over included."""

MAX_BOUND_ELEMENTS = 110_000
"""Elements that objects are made of at most: 6,000 patches under one condition, or 3,000 under
three. Each takes up to 16 µs, and no file may take two seconds."""

MAX_DEPTH = 32
"""Nesting at most; the schema's deepest element, outside vendors' sections, is the ninth."""

MAX_ATTRIBUTES = 32
"""Attributes at most of an element that objects are made of; the schema has 5 of one at most."""

MAX_SKIPPED_ATTRIBUTES = 1000
"""Attributes at most of an element that is passed over. Nothing is made of them, and their bytes
are bounded with the file's; X-Rite's i1Profiler keeps its settings in one element of 54."""

MAX_ATTRIBUTE_LENGTH = 10_000
MAX_TEXT_LENGTH = 100_000
MAX_TEXT_TOTAL = 16_000_000

_SKIPPED = frozenset(
    {
        "ColorDifferenceValues",
        "ColorSRGB",
        "ColorAdobeRGB",
        "ColorDensity",
        "ColorHTML",
        "CreationDate",
        "CustomResources",
        "CustomSpectrum",
        "CustomColorSpace",
        "GeometryChoice",
        "PhysicalAttributes",
        "PrivateColorValues",
        "PrivateSpectrum",
        "ProfileCollection",
    }
)
"""Elements of which nothing is used: left out with all that they hold."""

_SPECTRA = frozenset({"ReflectanceSpectrum", "TransmittanceSpectrum", "EmissiveSpectrum"})

_START = re.compile(rb"(?:\xef\xbb\xbf)?\s*<")
_ROOT = re.compile(r"<(?:[\w.-]+:)?CxF[\s>/]")
_OBJECT = f"{{{CXF_NAMESPACE}}}Object"


@dataclass(frozen=True)
class CxfDocument:
    """A CxF3 file.

    Parameters
    ----------
    root : colour_cxf.cxf3.CxF
        The content. Texts that are no numbers where numbers belong are left as they are. The value
        of a spectrum is one number, its place in `spectra`.
    spectra : tuple of str
        The texts of the spectra, in their order: to xsdata, each number would be an object.
    lines : tuple of int
        The line that each ``Object`` starts in, in their order.
    """

    root: Any
    spectra: tuple[str, ...]
    lines: tuple[int, ...]


def looks_like_xml(data: bytes) -> bool:
    """Return whether some bytes begin as an XML (or HTML) document does.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    bool
    """
    if data.startswith((b"\xff\xfe<\0", b"\xfe\xff\0<")):
        return True
    return _START.match(data[:1000]) is not None


def looks_like_cxf(data: bytes) -> bool:
    """Return whether an XML document's first elements are those of a CxF3 file.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    bool
    """
    start = data[:100_000]
    utf16 = start.startswith((b"\xff\xfe", b"\xfe\xff"))
    text = start.decode("utf-16" if utf16 else "latin-1", "replace")
    return _ROOT.search(text) is not None


def cxf_document(data: bytes) -> CxfDocument:
    """Return the content of a CxF3 file.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    CxfDocument

    Raises
    ------
    UnrecognisedFormatError
        The root is of another version or schema.
    MalformedFileError
        No well-formed XML, or with a document type declaration, deep nesting, or longer texts and
        attributes than a CxF file has: with line and column.
    SampleLimitError
        More elements than are accepted.
    """
    handler, parser_type, context, config, model = _binding()
    binder = parser_type(context=context, handler=handler, config=config)
    reading = _Reading(binder, model)
    with warnings.catch_warnings():
        # What cannot be converted stays text, and is looked at when it is used.
        warnings.simplefilter("ignore")
        root = reading.root(data)
    return CxfDocument(root, tuple(reading.spectra), tuple(reading.lines))


@cache
def _binding() -> tuple[Any, ...]:
    """Import colour-cxf on first use: it takes 0.2 s."""
    try:
        from colour_cxf import cxf3  # noqa: PLC0415
        from xsdata.formats.dataclass.context import XmlContext  # noqa: PLC0415
        from xsdata.formats.dataclass.parsers.bases import NodeParser  # noqa: PLC0415
        from xsdata.formats.dataclass.parsers.config import ParserConfig  # noqa: PLC0415
        from xsdata.formats.dataclass.parsers.mixins import XmlHandler  # noqa: PLC0415
    except ImportError:  # colour-cxf does not admit every version of Python
        raise UnrecognisedFormatError(
            "CxF files cannot be read here: the package colour-cxf is not installed.",
            remedy="Send the measurements as CGATS text or CSV.",
        ) from None
    config = ParserConfig(fail_on_unknown_properties=False, fail_on_unknown_attributes=False)
    return XmlHandler, NodeParser, XmlContext(), config, cxf3.CxF


class _Reading:
    """One pass of Expat over a document, handing what is used to xsdata."""

    def __init__(self, binder: Any, model: type) -> None:  # noqa: ANN401 (xsdata's NodeParser)
        self.binder = binder
        self.model = model
        self.queue: list[Any] = []
        self.objects: list[tuple[str | None, Any]] = []
        self.spectra: list[str] = []
        self.lines: list[int] = []
        self.depth = 0
        self.skipped_from = 0
        self.elements = 0
        self.bound = 0
        self.length = 0
        self.total = 0
        self.text: list[str] = []
        self.expat = expat.ParserCreate(namespace_separator="}")
        self.expat.buffer_text = True
        self.expat.StartDoctypeDeclHandler = self._refuse_declaration
        self.expat.EntityDeclHandler = self._refuse_declaration
        self.expat.StartElementHandler = self._start
        self.expat.EndElementHandler = self._end
        self.expat.CharacterDataHandler = self._characters

    def root(self, data: bytes) -> Any:  # noqa: ANN401 (colour_cxf.cxf3.CxF, which is optional)
        try:
            self.expat.Parse(data, True)
        except expat.ExpatError as error:
            raise MalformedFileError(
                f"The XML is broken: {expat.ErrorString(error.code)}.",
                where={"line": error.lineno, "column": error.offset + 1},
                remedy="Send the file as the measuring software wrote it.",
            ) from None
        except (LookupError, ValueError) as error:
            raise MalformedFileError(
                f"The XML has an encoding that is not known: {str(error)[:80]}.",
                where={"line": 1},
                remedy="Write the file in UTF-8.",
            ) from None
        return self.objects[-1][1]

    def _place(self) -> dict[str, str | int | float | list[str]]:
        return {
            "line": self.expat.CurrentLineNumber,
            "column": self.expat.CurrentColumnNumber + 1,
        }

    def _refuse(self, message: str) -> NoReturn:
        raise MalformedFileError(
            message,
            where=self._place(),
            remedy="A CxF3 file has plain elements, without declarations, and short texts.",
        )

    def _refuse_declaration(self, *_: object) -> NoReturn:
        self._refuse("The XML has a document type declaration.")

    def _start(self, name: str, attributes: Mapping[str, str]) -> None:
        self.depth += 1
        self.elements += 1
        if self.depth > MAX_DEPTH:
            self._refuse(f"The XML is nested more than {MAX_DEPTH} deep.")
        if any(len(value) > MAX_ATTRIBUTE_LENGTH for value in attributes.values()):
            self._refuse(
                f"An element has attributes of more than {MAX_ATTRIBUTE_LENGTH} characters."
            )
        namespace, _, local = name.rpartition("}")
        if self.depth == 1 and (local != "CxF" or namespace != CXF_NAMESPACE):
            raise UnrecognisedFormatError(
                f"The XML is no CxF3 file: its root is {local[:40]} of {namespace[:80] or 'no'} "
                "namespace.",
                where=self._place(),
                remedy=f"The root of a CxF3 file is CxF, of {CXF_NAMESPACE}.",
            )
        if not self.skipped_from and (local in _SKIPPED or namespace != CXF_NAMESPACE):
            self.skipped_from = self.depth
        most = MAX_SKIPPED_ATTRIBUTES if self.skipped_from else MAX_ATTRIBUTES
        if len(attributes) > most:
            self._refuse(f"An element has {len(attributes)} attributes, more than {most}.")
        self.bound += not self.skipped_from
        if self.elements > MAX_ELEMENTS or self.bound > MAX_BOUND_ELEMENTS:
            raise SampleLimitError(
                f"The file has more than {MAX_BOUND_ELEMENTS} elements of samples.",
                where=self._place(),
                remedy="Send fewer patches, or the measurements of one condition, or CGATS text.",
            )
        if self.skipped_from:
            return
        qualified = f"{{{name}"
        if qualified == _OBJECT and self.depth == 4:
            self.lines.append(self.expat.CurrentLineNumber)
        # Attributes of other namespaces (xsi:type, xsi:nil) could name other classes.
        plain = {key: value for key, value in attributes.items() if "}" not in key}
        self.text, self.length = [], 0
        self.binder.start(self.model, self.queue, self.objects, qualified, plain, {})

    def _characters(self, text: str) -> None:
        if self.skipped_from:
            return
        self.length += len(text)
        self.total += len(text)
        if self.length > MAX_TEXT_LENGTH or self.total > MAX_TEXT_TOTAL:
            self._refuse(f"An element's text is longer than {MAX_TEXT_LENGTH} characters.")
        self.text.append(text)

    def _end(self, name: str) -> None:
        self.depth -= 1
        if self.skipped_from:
            if self.depth < self.skipped_from:
                self.skipped_from = 0
            return
        text = "".join(self.text)
        self.text, self.length = [], 0
        if name.rpartition("}")[2] in _SPECTRA:
            self.spectra.append(text)
            text = str(len(self.spectra) - 1)
        self.binder.end(self.queue, self.objects, f"{{{name}", text, None)
