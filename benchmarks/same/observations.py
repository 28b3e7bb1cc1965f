"""Observations of a revision in a folder, and the differences between two such folders."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

__all__ = ["Difference", "Observations", "differences"]

RELATIVE = 1e-12
"""Largest relative difference of numbers in float64 that counts as one of the last bits."""

ULPS = 2
"""Largest difference of numbers in float32, in units of the last place, that counts as such."""

LEAST = 1e-14
"""Differences smaller than this share of the largest number of an array are of the last bits, too:
the small number may be what is left of large ones."""

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+(?:e[-+]?\d+)?|e[-+]?\d+)(?![\w.])")

SHOWN = 110


class Difference(NamedTuple):
    """A named observation that differs, how, and whether in the last bits of numbers only."""

    area: str
    name: str
    text: str
    is_last_bits: bool


class Observations:
    """What is seen of a revision in one area, by name.

    Parameters
    ----------
    folder : Path
    area : str
    """

    def __init__(self, folder: Path, area: str) -> None:
        self.folder, self.area = folder, area
        self.documents: dict[str, Any] = {}
        self.arrays: dict[str, np.ndarray[Any, Any]] = {}

    def record(self, name: str, value: object) -> None:
        """Keep bytes, an array, a JSON value, or a data class with such fields."""
        if isinstance(value, bytes):
            self.arrays[name] = np.frombuffer(value, np.uint8)
        elif isinstance(value, np.ndarray):
            self.arrays[name] = value
        elif dataclasses.is_dataclass(value) and not isinstance(value, type):
            for field in dataclasses.fields(value):
                self.record(f"{name} .{field.name}", getattr(value, field.name))
        elif isinstance(value, np.generic):
            self.record(name, np.asarray(value))
        else:
            text = json.dumps(value, default=str)
            self.documents[name] = json.loads(re.sub(r" at 0x[0-9a-f]+", "", text))

    def attempt(
        self,
        name: str,
        function: Callable[..., object],
        /,
        *args: Any,  # noqa: ANN401
        **named: Any,  # noqa: ANN401
    ) -> None:
        """Keep what a function returns, or its error with the fields that users see."""
        try:
            self.record(name, function(*args, **named))
        except Exception as error:  # noqa: BLE001  # an observation as well
            fields = {key: getattr(error, key, None) for key in ("code", "where", "remedy")}
            self.record(name, {"error": type(error).__name__, "text": str(error), **fields})

    def save(self) -> None:
        """Write the files that `load` reads."""
        (self.folder / f"{self.area}.json").write_text(json.dumps(self.documents))
        np.savez(self.folder / f"{self.area}.npz", **self.arrays)  # type: ignore[arg-type]

    @staticmethod
    def load(folder: Path, area: str) -> dict[str, Any]:
        """Return the observations of an area by name; none if it was not observed."""
        if not (folder / f"{area}.json").exists():
            return {}
        found: dict[str, Any] = json.loads((folder / f"{area}.json").read_text())
        with np.load(folder / f"{area}.npz") as arrays:
            return {**found, **arrays}


def differences(area: str, before: dict[str, Any], now: dict[str, Any]) -> Iterator[Difference]:
    """Yield the observations of an area that differ, each with its first difference.

    Parameters
    ----------
    area : str
    before, now : dict
        As `Observations.load` returns them.

    Yields
    ------
    Difference
    """
    for name in dict.fromkeys([*before, *now]):
        if name not in now or name not in before:
            yield Difference(area, name, "only before" if name in before else "only now", False)
            continue
        found = list(_of_values(before[name], now[name], ""))
        serious = [text for text, is_last_bits in found if not is_last_bits]
        if found:
            text = (serious or [text for text, _ in found])[0]
            more = f" (and {len(found) - 1} more places)" if len(found) > 1 else ""
            yield Difference(area, name, text + more, not serious)


def _of_values(before: Any, now: Any, place: str) -> Iterator[tuple[str, bool]]:  # noqa: ANN401, PLR0912
    """Yield each difference of two values as text, and whether it is one of last bits."""
    if type(before) is not type(now):
        yield _text(place, before, now), False
    elif isinstance(before, np.ndarray):
        yield from _of_arrays(before, now, place)
    elif isinstance(before, dict):
        if list(before) != list(now):
            lost = [f"−{key}" for key in before if key not in now]
            new = [f"+{key}" for key in now if key not in before]
            yield f"{place}: keys {', '.join(lost + new) or 'in another order'}"[:200], False
        for key in before:
            if key in now:
                yield from _of_values(before[key], now[key], f"{place}.{key}")
    elif isinstance(before, list):
        if len(before) != len(now):
            yield f"{place}: {len(before)} → {len(now)} entries", False
        for number, pair in enumerate(zip(before, now, strict=False)):
            yield from _of_values(*pair, f"{place}[{number}]")
    elif isinstance(before, float) and before != now:
        if not (np.isnan(before) and np.isnan(now)):
            is_close = abs(before - now) <= RELATIVE * max(abs(before), abs(now))
            yield _text(place, before, now), is_close
    elif isinstance(before, str):
        yield from _of_texts(before, now, place)
    elif before != now:
        yield _text(place, before, now), False


def _of_arrays(
    before: np.ndarray[Any, Any], now: np.ndarray[Any, Any], place: str
) -> Iterator[tuple[str, bool]]:
    if before.dtype != now.dtype or (before.shape != now.shape and before.dtype != np.uint8):
        shapes = (f"{each.dtype} {each.shape}" for each in (before, now))
        yield f"{place}: {' → '.join(shapes)}"[:200], False
    elif before.dtype.names:
        for name in before.dtype.names:
            yield from _of_arrays(before[name], now[name], f"{place}.{name}")
    elif before.dtype == np.uint8 and before.ndim == 1:
        yield from _of_bytes(before.tobytes(), now.tobytes(), place)
    else:
        is_other = before != now
        if before.dtype.kind == "f":
            is_other &= ~(np.isnan(before) & np.isnan(now))
        if not is_other.any():
            return
        is_close = False
        if before.dtype.kind == "f":
            a, b = before[is_other], now[is_other]
            size = np.maximum(np.abs(a), np.abs(b))
            limit = RELATIVE * size + LEAST * np.nanmax(np.abs(before))
            if before.dtype == np.float32:
                limit = ULPS * np.spacing(size)
            is_close = bool((np.abs(a - b) <= limit).all())
        first = tuple(int(index) for index in np.argwhere(is_other)[0])
        count = f"{is_other.sum()} of {before.size} differ, first "
        yield _text(f"{place}{list(first)}: {count}", before[first], now[first]), is_close


def _of_bytes(before: bytes, now: bytes, place: str) -> Iterator[tuple[str, bool]]:
    if before == now:
        return
    try:
        texts = before.decode(), now.decode()
    except UnicodeDecodeError:
        pairs = enumerate(zip(before, now, strict=False))
        first = next((i for i, (a, b) in pairs if a != b), min(len(before), len(now)))
        sizes = f"{len(before)} → {len(now)} bytes"
        parts = before[first : first + 8].hex(), now[first : first + 8].hex()
        yield f"{place}: {sizes}, first at {first}: {parts[0]} → {parts[1]}", False
    else:
        yield from _of_texts(*texts, place)


def _of_texts(before: str, now: str, place: str) -> Iterator[tuple[str, bool]]:
    """Compare texts by lines. Numbers with a point or an exponent may differ in their last bits."""
    if before == now:
        return
    is_close = NUMBER.sub("#", before) == NUMBER.sub("#", now) and all(
        abs(float(a) - float(b)) <= RELATIVE * max(abs(float(a)), abs(float(b)))
        for a, b in zip(NUMBER.findall(before), NUMBER.findall(now), strict=True)
    )
    lines: Iterable[tuple[str, str]] = zip(
        [*before.split("\n"), "(end)"], [*now.split("\n"), "(end)"], strict=False
    )
    number, a, b = next((i, a, b) for i, (a, b) in enumerate(lines, 1) if a != b)
    start = max(0, next((i for i, (c, d) in enumerate(zip(a, b, strict=False)) if c != d), 0) - 40)
    yield _text(f"{place} line {number}", a[start:], b[start:]), is_close


def _text(place: str, before: object, now: object) -> str:
    shown = [repr(value)[:SHOWN] for value in (before, now)]
    return f"{place}: {shown[0]} → {shown[1]}"
