"""Colours as other programs write them: style sheets (#e4002b, lab(), oklch()), and palettes.

The grammar of texts is that of CSS Color 4 (W3C, 2025), sections 5 to 10: #e4002b, rgb(), hsl(),
lab(), lch(), oklab(), oklch(). Alpha is read and not used. Names such as ``red`` and relative
colours are not read.

The format of palettes is Adobe Swatch Exchange (.ase), as the exports of Adobe's applications have
it: big-endian blocks, of which 0x0001 is a colour and 0xC001 and 0xC002 begin and end a group.
"""

from __future__ import annotations

import colorsys
import math
import re
import struct
from typing import TYPE_CHECKING, NamedTuple

from gamutcore.errors import MalformedFileError

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["PALETTE_MAGIC", "Swatch", "css_colour", "swatches"]

_HEX = re.compile(r"#?([0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})", re.IGNORECASE)
_FUNCTION = re.compile(
    r"(rgb|rgba|hsl|hsla|lab|lch|oklab|oklch|color)\(\s*([^()]{1,200})\)", re.IGNORECASE
)
_VALUE = re.compile(
    r"([+-]?(?:\d{1,20}\.?\d{0,20}|\.\d{1,20})(?:e[+-]?\d{1,2})?)(%|deg|grad|rad|turn)?"
)
_ANGLES = {"deg": 1.0, "grad": 0.9, "rad": 180.0 / math.pi, "turn": 360.0}

_FULL = {
    "rgb": (255.0, 255.0, 255.0),
    "hsl": (None, 1.0, 1.0),
    "lab": (100.0, 125.0, 125.0),
    "lch": (100.0, 150.0, None),
    "oklab": (1.0, 0.4, 0.4),
    "oklch": (1.0, 0.4, None),
    "color": (1.0, 1.0, 1.0),
}
"""What 100 % is (CSS Color 4, 6.1, 9.3 and 9.4); None for a hue."""


def css_colour(  # noqa: C901, PLR0911, PLR0912  # one branch for each function
    text: str, *, bare_hex: bool = False
) -> tuple[str, tuple[float, float, float]] | None:
    """Return the space and the coordinates of a colour; None if the text is none.

    Parameters
    ----------
    text : str
    bare_hex : bool, optional
        Whether ``e4002b`` is a colour as well.

    Examples
    --------
    >>> css_colour("#ff0000")
    ('sRGB', (1.0, 0.0, 0.0))
    >>> css_colour("lab(50% 40 59.5)")
    ('CIELAB', (50.0, 40.0, 59.5))
    """
    text = text.strip()
    match = _HEX.fullmatch(text)
    if match:
        if not (bare_hex or text.startswith("#")):
            return None
        digits = match[1] if len(match[1]) > 4 else "".join(2 * each for each in match[1])
        return "sRGB", _three(int(digits[at : at + 2], 16) / 255.0 for at in (0, 2, 4))
    called = _FUNCTION.fullmatch(text)
    if not called:
        return None
    name = called[1].lower().removesuffix("a") if called[1].lower() != "color" else "color"
    words = called[2].partition("/")[0].replace(",", " ").lower().split()
    if name == "color":
        if not words or words.pop(0) != "srgb":
            return None
    elif len(words) == 4 and name in {"rgb", "hsl"}:
        words.pop()  # alpha after a comma
    if len(words) != 3:
        return None
    values = [_value(word, full) for word, full in zip(words, _FULL[name], strict=True)]
    if any(value is None for value in values):
        return None
    one, two, three = _three(value or 0.0 for value in values)
    if name == "rgb":
        return "sRGB", (one / 255.0, two / 255.0, three / 255.0)
    if name == "color":
        return "sRGB", (one, two, three)
    if name == "hsl":
        if "%" not in words[1]:
            two, three = two / 100.0, three / 100.0
        return "sRGB", colorsys.hls_to_rgb(one / 360.0 % 1.0, three, two)
    if name in {"lch", "oklch"}:
        if name == "lch":
            return "LCHab", (one, two, three % 360.0)
        angle = math.radians(three)
        return "Oklab", (one, two * math.cos(angle), two * math.sin(angle))
    return ("CIELAB" if name == "lab" else "Oklab"), (one, two, three)


def _three(values: Iterable[float]) -> tuple[float, float, float]:
    one, two, three = values
    return one, two, three


def _value(word: str, full: float | None) -> float | None:
    """Return the number of a component; None if it is none."""
    if word == "none":
        return 0.0
    match = _VALUE.fullmatch(word)
    if not match:
        return None
    number, unit = float(match[1]), match[2]
    if full is None:
        return None if unit == "%" else number * _ANGLES[unit or "deg"]
    if unit in _ANGLES:
        return None
    return number * full / 100.0 if unit else number


PALETTE_MAGIC = b"ASEF"
_COLOUR, _GROUP, _GROUP_END = 0x0001, 0xC001, 0xC002
_COMPONENTS = {"RGB": 3, "LAB": 3, "CMYK": 4, "Gray": 1}


class Swatch(NamedTuple):
    """A colour: its name, its group, its model, and the components as in the file."""

    name: str
    group: str
    model: str
    values: tuple[float, ...]


def swatches(data: bytes) -> list[Swatch]:
    """Return the colours of a palette; errors have the number of the block, from 1."""
    found: list[Swatch] = []
    group, place, block = "", 12, 0
    try:
        (count,) = struct.unpack_from(">I", data, 8)
        for block in range(1, count + 1):  # noqa: B007  # named in the error
            kind, size = struct.unpack_from(">HI", data, place)
            content = data[place + 6 : place + 6 + size]
            if len(content) != size:
                raise struct.error("the file ends within a block")  # noqa: TRY301
            place += 6 + size
            if kind == _GROUP:
                group, _ = _block_text(content)
            elif kind == _GROUP_END:
                group = ""
            elif kind == _COLOUR:
                name, end = _block_text(content)
                model = content[end : end + 4].decode("ascii").strip()
                if model not in _COMPONENTS:
                    raise struct.error(f"the colour model is {model!r}")  # noqa: TRY301
                values = struct.unpack_from(f">{_COMPONENTS[model]}f", content, end + 4)
                found.append(Swatch(name, group, model, values))
    except (struct.error, UnicodeDecodeError) as error:
        raise MalformedFileError(
            f"The palette is damaged: {error}.",
            where={"block": block},
            remedy="Export the swatches again as Adobe Swatch Exchange (.ase).",
        ) from None
    return found


def _block_text(content: bytes) -> tuple[str, int]:
    """Return the text at the start of a block, and where it ends."""
    (length,) = struct.unpack_from(">H", content)
    end = 2 + 2 * length
    if end > len(content):
        raise struct.error("a name is longer than its block")
    return content[2:end].decode("utf-16-be").rstrip("\0"), end
