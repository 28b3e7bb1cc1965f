"""The XML of a CxF3 file (ISO 17972-1) as an element tree, parsed within limits.

Expat is driven directly, because only its own handlers report line numbers and can stop a hostile
file. Document type declarations are refused, and with them every entity. Depth, elements,
attributes and text are limited before the tree grows. Sections of vendors are skipped.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NoReturn
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from gamutcore.errors import MalformedFileError, SampleLimitError, UnrecognisedFormatError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.errors import Where

__all__ = ["CXF_NAMESPACE", "cxf_root", "element_line", "looks_like_cxf", "looks_like_xml"]

CXF_NAMESPACE = "http://colorexchangeformat.com/CxF3-core"

MAX_ELEMENTS = 400_000
"""Maximum number of elements, skipped ones included: 22,000 patches under one condition. This many
take 1.5 s; a fuzz test allows 2 s."""

MAX_DEPTH = 32
"""Maximum depth. Outside vendors' sections, the schema has at most nine levels."""

MAX_ATTRIBUTES = 1000
"""Maximum number of attributes of an element. The schema has at most 5, but vendors add elements of
their own: X-Rite's i1Profiler writes one with 54."""

MAX_ATTRIBUTE_LENGTH = 10_000
MAX_TEXT_LENGTH = 100_000
MAX_TEXT_TOTAL = 16_000_000

_SKIPPED = frozenset({"CustomResources", "ProfileCollection"})
"""Elements that are skipped with their content, as all elements of other namespaces are."""

_LINE = ":line"
"""Key of the line number among the attributes. No attribute of a file can have this name."""

_START = re.compile(rb"(?:\xef\xbb\xbf)?\s*<")
_ROOT = re.compile(r"<(?:[\w.-]+:)?CxF[\s>/]")


def looks_like_xml(data: bytes) -> bool:
    r"""Return whether bytes begin as an XML or HTML document does.

    Examples
    --------
    >>> looks_like_xml(b"\n<a/>"), looks_like_xml(b"1 < 2")
    (True, False)
    """
    if data.startswith((b"\xff\xfe<\0", b"\xfe\xff\0<")):
        return True
    return _START.match(data[:1000]) is not None


def looks_like_cxf(data: bytes) -> bool:
    """Return whether an XML document contains a ``CxF`` element near its start."""
    start = data[:100_000]
    utf16 = start.startswith((b"\xff\xfe", b"\xfe\xff"))
    text = start.decode("utf-16" if utf16 else "latin-1", "replace")
    return _ROOT.search(text) is not None


def element_line(element: Element) -> int:
    """Return the line number of an ``Object`` element of `cxf_root`, from 1."""
    return int(element.get(_LINE, "1"))


def cxf_root(data: bytes) -> Element:
    """Return the root element ``CxF`` of a CxF3 file, with names of elements without namespace.

    A fault of the XML or an exceeded limit raises an error with line and column in ``where``.
    """
    return _Reader().read(data)


class _Reader:
    """Expat handlers that build an element tree and enforce the limits."""

    def __init__(self) -> None:
        self.builder = TreeBuilder()
        self.depth = 0
        self.skipped_from = 0
        self.elements = 0
        self.text_length = 0
        self.text_total = 0
        self.expat = expat.ParserCreate(namespace_separator="}")
        self.expat.buffer_text = True
        self.expat.StartDoctypeDeclHandler = self._refuse_declaration
        self.expat.EntityDeclHandler = self._refuse_declaration
        self.expat.StartElementHandler = self._start
        self.expat.EndElementHandler = self._end
        self.expat.CharacterDataHandler = self._add_text

    def read(self, data: bytes) -> Element:
        try:
            self.expat.Parse(data, True)
        except expat.ExpatError as error:
            raise MalformedFileError(
                f"The XML is not well formed: {expat.ErrorString(error.code)}.",
                where={"line": error.lineno, "column": error.offset + 1},
                remedy="Send the file as the measuring software wrote it.",
            ) from None
        except (LookupError, ValueError) as error:
            raise MalformedFileError(
                f"The XML declares an unknown encoding: {str(error)[:80]}.",
                where={"line": 1},
                remedy="Write the file in UTF-8.",
            ) from None
        root: Element = self.builder.close()
        return root

    def _place(self) -> Where:
        return {
            "line": self.expat.CurrentLineNumber,
            "column": self.expat.CurrentColumnNumber + 1,
        }

    def _refuse(self, message: str) -> NoReturn:
        raise MalformedFileError(
            message,
            where=self._place(),
            remedy="Send plain elements with short texts and without a document type declaration.",
        )

    def _refuse_declaration(self, *_: object) -> NoReturn:
        self._refuse("The XML has a document type declaration.")

    def _start(self, name: str, attributes: Mapping[str, str]) -> None:
        self.depth += 1
        self.elements += 1
        if self.depth > MAX_DEPTH:
            self._refuse(f"The XML is nested more than {MAX_DEPTH} levels deep.")
        if self.elements > MAX_ELEMENTS:
            raise SampleLimitError(
                f"The file has more than {MAX_ELEMENTS} elements.",
                where=self._place(),
                remedy="Send fewer patches, or send the measurements as CGATS text.",
            )
        namespace, _, local = name.rpartition("}")
        if self.depth == 1 and (local != "CxF" or namespace != CXF_NAMESPACE):
            raise UnrecognisedFormatError(
                f"The XML is not a CxF3 file: its root is {local[:40]} of {namespace[:80] or 'no'} "
                "namespace.",
                where=self._place(),
                remedy=f"The root of a CxF3 file is CxF, of {CXF_NAMESPACE}.",
            )
        if not self.skipped_from and (local in _SKIPPED or namespace != CXF_NAMESPACE):
            self.skipped_from = self.depth
        if attributes:
            self._check_attributes(attributes)
        if not self.skipped_from:
            self.text_length = 0
            kept = dict(attributes)
            if local == "Object":
                kept[_LINE] = str(self.expat.CurrentLineNumber)
            self.builder.start(local, kept)

    def _check_attributes(self, attributes: Mapping[str, str]) -> None:
        if len(attributes) > MAX_ATTRIBUTES:
            self._refuse(
                f"An element has {len(attributes)} attributes, more than {MAX_ATTRIBUTES}."
            )
        if max(map(len, attributes.values())) > MAX_ATTRIBUTE_LENGTH:
            self._refuse(f"One of the attributes has more than {MAX_ATTRIBUTE_LENGTH} characters.")

    def _add_text(self, text: str) -> None:
        if self.skipped_from:
            return
        self.text_length += len(text)
        self.text_total += len(text)
        if self.text_length > MAX_TEXT_LENGTH or self.text_total > MAX_TEXT_TOTAL:
            self._refuse(
                f"An element has a text of more than {MAX_TEXT_LENGTH} characters, or all texts "
                f"together have more than {MAX_TEXT_TOTAL}."
            )
        self.builder.data(text)

    def _end(self, name: str) -> None:
        if not self.skipped_from:
            self.text_length = 0
            self.builder.end(name.rpartition("}")[2])
        elif self.depth == self.skipped_from:
            self.skipped_from = 0
        self.depth -= 1
